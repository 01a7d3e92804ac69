/* The JSON reader that keeps line numbers: everything that RFC 8259 allows is read, and everything
 * else is refused with the line. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/json_read.h"

static thrum_status read_text(const char *text, json_document *document, thrum_error *error) {
  // a copy of exactly its size, so that a sanitizer sees any byte read beyond it
  const size_t length = strlen(text);
  char *bytes = malloc(length > 0 ? length : 1);
  assert_non_null(bytes);
  memcpy(bytes, text, length);
  const thrum_status status = json_read("t", bytes, length, document, error);
  free(bytes);
  return status;
}

static void valid_texts_are_read(void **state) {
  (void)state;

  // scalars, lists, objects, blanks, escapes and UTF-8
  static const char *const texts[] = {"0",
                                      "-0",
                                      "-1.5e+30",
                                      "1E400",
                                      "true",
                                      " null ",
                                      "\"\"",
                                      "[]",
                                      "{}",
                                      "[[[]],[{}]]",
                                      "{\"\":0}",
                                      "[1,\t2 ,\r\n3]",
                                      "\"\\\"\\\\\\/\\b\\f\\n\\r\\t\\u00e9\\ud83d\\ude00\"",
                                      "\"\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80\""};

  for (size_t n = 0; n < sizeof texts / sizeof *texts; n++) {
    json_document document = {0};
    thrum_error error = {0};
    if (read_text(texts[n], &document, &error) < 0)
      fail_msg("%s: %s", texts[n], error.message);
    json_free(&document);
  }
}

static void invalid_texts_are_refused(void **state) {
  (void)state;

  // truncated or stray structure, numbers, words, escapes, UTF-8, repeated keys and comments
  static const char *const texts[] = {"",
                                      "   ",
                                      "[",
                                      "{",
                                      "]",
                                      "[1",
                                      "[1,]",
                                      "[,1]",
                                      "{\"a\"}",
                                      "{\"a\":}",
                                      "{\"a\":1,}",
                                      "{a:1}",
                                      "{'a':1}",
                                      "01",
                                      "-",
                                      "+1",
                                      ".5",
                                      "1.",
                                      "1e",
                                      "1e+",
                                      "0x10",
                                      "NaN",
                                      "Infinity",
                                      "tru",
                                      "truee",
                                      "1 2",
                                      "[1 2]",
                                      "\"",
                                      "\"\\\"",
                                      "\"\\x\"",
                                      "\"\\u12\"",
                                      "\"\\u0000\"",
                                      "\"\\ud800\"",
                                      "\"\\udc00\"",
                                      "\"\\ud800\\u0041\"",
                                      "\"\\udc00\\udc00\"",
                                      "\"\\udbff\\udbff\"",
                                      "\"\\ud800\\ue000\"",
                                      "\"\t\"",
                                      "\"\n\"",
                                      "\"\x01\"",
                                      "\"\xff\"",
                                      "\"\xc0\x80\"",
                                      "\"\xed\xa0\x80\"",
                                      "\"\xf4\x90\x80\x80\"",
                                      "\"\xe2\x82\"",
                                      "\xff\xfe",
                                      "{\"a\":1 \"b\":2}",
                                      "{\"a\":1,\"a\":2}",
                                      "[1}",
                                      "/**/1",
                                      "#\n1"};

  // the message begins with the name of the text, and no node is left
  for (size_t n = 0; n < sizeof texts / sizeof *texts; n++) {
    json_document document = {0};
    thrum_error error = {0};
    if (read_text(texts[n], &document, &error) >= 0)
      fail_msg("read: %s", texts[n]);
    assert_int_equal(error.status, THRUM_BAD_FORMAT);
    assert_memory_equal(error.message, "t:", 2);
    assert_null(document.nodes);
  }
}

static void every_member_knows_its_line(void **state) {
  (void)state;

  // members on lines that end in LF and in CR LF
  json_document document = {0};
  thrum_error error = {0};
  assert_true(read_text("\n{ \"a\" : 1,\r\n\"b\":\n [ \"x\",\n\"\\u00e9\" ],\n\"c\":{\"d\":true}}",
                        &document, &error) >= 0);

  // the nodes in the order of the text
  const json_node *nodes = document.nodes;
  const json_node *a = &nodes[nodes[0].first], *b = &nodes[a->next], *c = &nodes[b->next];

  // keys, texts and lines of the members and of what they contain
  assert_int_equal(nodes[0].line, 2);
  assert_string_equal(a->key, "a");
  assert_string_equal(a->text, "1");
  assert_int_equal(a->line, 2);
  assert_int_equal(b->line, 3);
  assert_int_equal(nodes[b->first].line, 4);
  assert_int_equal(nodes[nodes[b->first].next].line, 5);
  assert_string_equal(nodes[nodes[b->first].next].text, "\xc3\xa9");
  assert_int_equal(c->line, 6);
  assert_string_equal(nodes[c->first].key, "d");
  assert_int_equal(nodes[c->first].type, JSON_TRUE);
  assert_int_equal(c->next, -1);

  json_free(&document);
}

static void nesting_has_an_end(void **state) {
  (void)state;
  char text[2 * JSON_DEPTH_MAX + 3];
  for (int deep = JSON_DEPTH_MAX; deep <= JSON_DEPTH_MAX + 1; deep++) {
    json_document document = {0};
    thrum_error error = {0};
    memset(text, '[', (size_t)deep);
    memset(text + deep, ']', (size_t)deep);
    text[2 * deep] = 0;
    const thrum_status status = read_text(text, &document, &error);
    assert_int_equal(status >= 0, deep == JSON_DEPTH_MAX);
    json_free(&document);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(valid_texts_are_read),
      cmocka_unit_test(invalid_texts_are_refused),
      cmocka_unit_test(every_member_knows_its_line),
      cmocka_unit_test(nesting_has_an_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
