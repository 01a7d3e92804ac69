/* Tests of texts for terminals: what directs a terminal or the direction of a text is not shown,
 * and all else stays. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "core/base/plain_text.h"
#include "thrum/status.h"

static void what_directs_a_terminal_is_not_shown(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"a\033[31mb", "a?[31mb"},
      {"line\nend\t\r\177", "line?end???"},
      {"\302\233"
       "31m and \302\205",
       "??31m and ??"}, // U+009B, U+0085
      {"\233"
       "31m",
       "?31m"},                              // a single byte of the same
      {"\342\200\256gpj.exe", "???gpj.exe"}, // U+202E
      {"\342\201\246x\342\201\251\342\200\216\330\234", "???x????????"}, // U+2066, 2069, 200E, 061C
      {"\342\200\250", "???"},                                           // U+2028

      // these are letters and signs, and bytes that are no UTF-8
      {"Gr\303\266\303\237e \342\202\254 \360\237\230\200",
       "Gr\303\266\303\237e \342\202\254 \360\237\230\200"},
      {"\303", "\303"},
      {"\342\200", "\342?"},
      {"\377x\376", "\377x\376"},
      {"", ""},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char text[64];
    strcpy(text, cases[n][0]);
    thrum_plain_text(text);
    assert_string_equal(text, cases[n][1]);
  }
}

static void a_message_is_one_plain_line(void **state) {
  (void)state;
  thrum_error error;
  thrum_error_set(&error, THRUM_IO, "%s: is missing",
                  "a\302\233"
                  "2J\342\200\256b\n");
  assert_string_equal(error.message, "a??2J???b?: is missing");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_directs_a_terminal_is_not_shown),
      cmocka_unit_test(a_message_is_one_plain_line),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
