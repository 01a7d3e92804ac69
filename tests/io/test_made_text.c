/* Texts of streams in memory. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "io/made_text.h"

static void put_word(FILE *stream, const void *of) {
  fputs(of, stream);
}

/* What a stream has that loses a byte from the second time on, and says nothing. */
static void put_less(FILE *stream, const void *of) {
  static int times = 0;
  fputs((const char *)of + times++, stream);
}

static void a_text_is_whole(void **state) {
  (void)state;
  size_t size = 0;
  char *text = made_text(put_word, "two words", &size);
  assert_string_equal(text, "two words");
  assert_int_equal(size, 9);
  free(text);

  text = made_text(put_word, "", NULL);
  assert_string_equal(text, "");
  free(text);
}

static void a_text_that_lost_bytes_is_none(void **state) {
  (void)state;
  assert_null(made_text(put_less, "two words", NULL));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_text_is_whole),
      cmocka_unit_test(a_text_that_lost_bytes_is_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
