/* Reads JSON (RFC 8259) and keeps the line of each value for messages. It takes one pass and
 * recurses once for each level of nesting. SPDX-License-Identifier: Apache-2.0 */
#include "io/json_read.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"

typedef struct reader {
  const char *name;
  const char *at, *end;
  int64_t line;
  int depth;
  json_document document;
  int64_t room;    /* capacity of document.nodes */
  char *text_next; /* next free byte of document.texts */
  thrum_error *error;
} reader;

__attribute__((format(printf, 2, 3))) static thrum_status fail(const reader *r, const char *format,
                                                               ...) {
  char line[320];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.150s:%lld: %s", r->name, (long long)r->line,
                         line);
}

/* Describes the next character for messages. */
static const char *found(const reader *r, char text[16]) {
  if (r->at == r->end)
    return "the end of the file";
  const unsigned char c = (unsigned char)*r->at;
  if (c > ' ' && c < 127)
    snprintf(text, 16, "'%c'", c);
  else
    snprintf(text, 16, "byte 0x%02x", c);
  return text;
}

static thrum_status expected(const reader *r, const char *what) {
  char text[16];
  return fail(r, "expected %s, not %s", what, found(r, text));
}

static void skip_blanks(reader *r) {
  for (; r->at < r->end; r->at++)
    if (*r->at == '\n')
      r->line++;
    else if (*r->at != ' ' && *r->at != '\t' && *r->at != '\r')
      return;
}

static char *put_utf8(char *to, uint32_t code) {
  if (code < 0x80) {
    *to++ = (char)code;
    return to;
  }

  // the first byte tells how many bytes follow; each of these holds six bits
  if (code < 0x800) {
    *to++ = (char)(0xc0 | code >> 6);
  } else {
    if (code < 0x10000) {
      *to++ = (char)(0xe0 | code >> 12);
    } else {
      *to++ = (char)(0xf0 | code >> 18);
      *to++ = (char)(0x80 | (code >> 12 & 63));
    }
    *to++ = (char)(0x80 | (code >> 6 & 63));
  }

  *to++ = (char)(0x80 | (code & 63));
  return to;
}

/* Reads four hexadecimal digits; returns -1 when they are none. */
static int32_t read_hex(reader *r) {
  int32_t value = 0;
  if (r->end - r->at < 4)
    return -1;

  // both cases of the letters are allowed
  for (int n = 0; n < 4; n++, r->at++) {
    const char c = *r->at;
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                             : -1;
    if (digit < 0)
      return -1;
    value = 16 * value + digit;
  }
  return value;
}

/* Reads \uXXXX from behind its u; a pair of surrogates is one character. */
static thrum_status read_unicode(reader *r) {
  int32_t code = read_hex(r);
  if (code >= 0xd800 && code < 0xdc00 && r->end - r->at >= 2 && r->at[0] == '\\' &&
      r->at[1] == 'u') {
    r->at += 2;
    const int32_t low = read_hex(r);
    code = low >= 0xdc00 && low < 0xe000 ? 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00) : -1;
  }

  // a character 0 would end the text, and half a pair is no character
  if (code <= 0 || (code >= 0xd800 && code < 0xe000))
    return fail(r, "\\u wants four hexadecimal digits of a character that is not 0");
  r->text_next = put_utf8(r->text_next, (uint32_t)code);
  return THRUM_OK;
}

static thrum_status read_escape(reader *r) {
  static const char letters[] = "\"\\/bfnrt", bytes[] = "\"\\/\b\f\n\r\t";
  const char *letter = r->at < r->end && *r->at != 0 ? strchr(letters, *r->at) : NULL;
  if (letter != NULL) {
    r->at++;
    *r->text_next++ = bytes[letter - letters];
    return THRUM_OK;
  }
  if (r->at < r->end && *r->at == 'u') {
    r->at++;
    return read_unicode(r);
  }
  return expected(r, "one of \"\\/bfnrtu after a backslash (two of them for one)");
}

/* Reads a string whose opening quote is next. */
static thrum_status read_string(reader *r, const char **text) {
  *text = r->text_next;
  for (r->at++; r->at < r->end && *r->at != '"';) {
    const int length = thrum_utf8_length(r->at, (size_t)(r->end - r->at));
    if (*r->at == '\n')
      return fail(r, "this line ends within a text: a '\"' is missing");
    if (length == 0 || (unsigned char)*r->at < ' ') {
      char byte[16];
      return fail(r, "%s does not belong in a text%s", found(r, byte),
                  length == 0 ? ": save the file as UTF-8" : "; write \\t for a tabulator");
    }

    // an escape never takes more bytes than it was written with
    if (*r->at == '\\') {
      r->at++;
      THRUM_TRY(read_escape(r));
      continue;
    }

    memcpy(r->text_next, r->at, (size_t)length);
    r->text_next += length;
    r->at += length;
  }

  // the closing quote ends the text
  if (r->at == r->end)
    return fail(r, "the file ends within a text: a '\"' is missing");
  r->at++;
  *r->text_next++ = 0;
  return THRUM_OK;
}

static bool skip_digits(reader *r) {
  const char *start = r->at;
  while (r->at < r->end && *r->at >= '0' && *r->at <= '9')
    r->at++;
  return r->at > start;
}

static bool skip_one(reader *r, const char *characters) {
  if (r->at == r->end || *r->at == 0 || strchr(characters, *r->at) == NULL)
    return false;
  r->at++;
  return true;
}

/* Reads [-] digits [. digits] [e [+-] digits]; a needless zero in front is refused. */
static thrum_status read_number(reader *r, const char **text) {
  const char *start = r->at;
  skip_one(r, "-");

  // a zero in front of other digits could mean an octal number
  const bool zero = r->at < r->end && *r->at == '0';
  const char *digits = r->at;
  bool good = skip_digits(r) && (!zero || r->at - digits == 1);
  if (good && skip_one(r, "."))
    good = skip_digits(r);
  if (good && skip_one(r, "eE")) {
    skip_one(r, "+-");
    good = skip_digits(r);
  }

  if (!good)
    return fail(r, "a number is written as 12, -0.5 or 1e-3: digits on both sides of the point, no "
                   "zero or plus in front");

  // the text is kept as written, so that its last digit is too
  *text = r->text_next;
  memcpy(r->text_next, start, (size_t)(r->at - start));
  r->text_next += r->at - start;
  *r->text_next++ = 0;
  return THRUM_OK;
}

/* Adds a node and returns its place, or -1 when there is no memory. */
static int64_t add_node(reader *r) {
  json_document *d = &r->document;
  if (d->count == r->room) {
    const int64_t room = 2 * r->room + 16;
    json_node *nodes = realloc(d->nodes, (size_t)room * sizeof *nodes);
    if (nodes == NULL)
      return -1;
    d->nodes = nodes;
    r->room = room;
  }
  d->nodes[d->count] = (json_node){.type = JSON_NULL, .line = r->line, .first = -1, .next = -1};
  return d->count++;
}

static thrum_status read_value(reader *r, int64_t *place);

static thrum_status read_key(reader *r, int64_t parent, const char **key) {
  if (r->at == r->end || *r->at != '"')
    return expected(r, "a key in double quotes");
  THRUM_TRY(read_string(r, key));

  // a key that is there twice would leave open which one holds
  int64_t keys = 0;
  for (int64_t n = r->document.nodes[parent].first; n >= 0; n = r->document.nodes[n].next) {
    if (strcmp(r->document.nodes[n].key, *key) == 0)
      return fail(r, "\"%s\" is there twice; first in line %lld",
                  thrum_text_excerpt(thrum_word_of(*key)).text,
                  (long long)r->document.nodes[n].line);
    if (++keys == JSON_KEYS_MAX)
      return fail(r, "more than %d keys", JSON_KEYS_MAX);
  }

  // the value stands behind a colon
  skip_blanks(r);
  if (r->at == r->end || *r->at != ':')
    return fail(r, "expected ':' after the key \"%s\"",
                thrum_text_excerpt(thrum_word_of(*key)).text);
  r->at++;
  return THRUM_OK;
}

/* Reads the members of an object or the items of an array, whose bracket is next. */
static thrum_status read_members(reader *r, int64_t parent, char close) {
  int64_t last = -1;
  if (++r->depth > JSON_DEPTH_MAX)
    return fail(r, "nested more than %d deep", JSON_DEPTH_MAX);
  r->at++;
  skip_blanks(r);

  // members follow each other until the bracket closes
  for (bool more = r->at == r->end || *r->at != close; more;) {
    const char *key = NULL;
    const int64_t line = r->line;
    thrum_status status = close == '}' ? read_key(r, parent, &key) : THRUM_OK;

    // reading a value may move the nodes, so their address is taken afterwards
    int64_t child = -1;
    THRUM_THEN(status, read_value(r, &child));
    if (status < 0)
      return status;

    json_node *nodes = r->document.nodes;
    nodes[child].key = key;
    if (key != NULL)
      nodes[child].line = line;

    // the members are linked in the order of the file
    *(last < 0 ? &nodes[parent].first : &nodes[last].next) = child;
    last = child;
    skip_blanks(r);

    // a comma behind the last member is a common mistake, so it has its own message
    more = r->at < r->end && *r->at == ',';
    if (more) {
      r->at++;
      skip_blanks(r);
      if (r->at < r->end && *r->at == close)
        return fail(r, "a comma stands before '%c': remove it", close);
    }
  }

  if (r->at == r->end || *r->at != close)
    return expected(r, close == '}' ? "',' or '}'" : "',' or ']'");
  r->at++;
  r->depth--;
  return THRUM_OK;
}

static thrum_status read_literal(reader *r, json_node *node) {
  static const struct {
    const char *word;
    json_type type;
  } words[] = {{"true", JSON_TRUE}, {"false", JSON_FALSE}, {"null", JSON_NULL}};
  for (int n = 0; n < 3; n++) {
    const size_t length = strlen(words[n].word);
    if ((size_t)(r->end - r->at) >= length && memcmp(r->at, words[n].word, length) == 0) {
      r->at += length;
      node->type = words[n].type;
      return THRUM_OK;
    }
  }

  // common mistakes are named
  if (thrum_utf8_length(r->at, (size_t)(r->end - r->at)) == 0)
    return fail(r, "no text: save the file as UTF-8");
  if (*r->at == '/' || *r->at == '#')
    return fail(r, "JSON has no comments: remove it");
  return expected(r, "a value (texts stand in double quotes)");
}

static thrum_status read_value(reader *r, int64_t *place) {
  skip_blanks(r);
  if (r->at == r->end)
    return expected(r, "a value");
  *place = add_node(r);
  if (*place < 0)
    return thrum_error_set(r->error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory", r->name);
  json_node *node = &r->document.nodes[*place];

  // the first character says what the value is
  const char c = *r->at;
  if (c == '{' || c == '[') {
    node->type = c == '{' ? JSON_OBJECT : JSON_ARRAY;
    return read_members(r, *place, c == '{' ? '}' : ']');
  }
  if (c == '"') {
    node->type = JSON_STRING;
    return read_string(r, &node->text);
  }
  if (c == '-' || c == '+' || c == '.' || (c >= '0' && c <= '9')) {
    node->type = JSON_NUMBER;
    return read_number(r, &node->text);
  }
  return read_literal(r, node);
}

thrum_status json_read(const char *name, const char *bytes, size_t length, json_document *document,
                       thrum_error *error) {
  if (length > JSON_BYTES_MAX)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%.150s: %lld bytes are too many: %d at most",
                           name, (long long)length, JSON_BYTES_MAX);

  reader r = {.name = name, .at = bytes, .end = bytes + length, .line = 1, .error = error};

  // without its quotes, a text is shorter than what it was; a number is followed by one byte
  r.document.texts = malloc(length + 2);
  r.text_next = r.document.texts;

  thrum_status status = THRUM_OK;
  int64_t root = -1;
  if (r.document.texts == NULL)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory", name);
  THRUM_THEN(status, read_value(&r, &root));

  // a second value or a stray bracket behind the first is an error
  skip_blanks(&r);
  if (status >= 0 && r.at != r.end)
    status = expected(&r, "nothing after the closing bracket");

  if (status < 0) {
    json_free(&r.document);
    return status;
  }
  *document = r.document;
  return THRUM_OK;
}

void json_free(json_document *document) {
  free(document->nodes);
  free(document->texts);
  *document = (json_document){0};
}
