/* The scanner of lines, words and numbers. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <locale.h>
#include <math.h>

#include "io/number_text.h"
#include "io/text.h"

static uint64_t bits(double value) {
  uint64_t pattern;
  memcpy(&pattern, &value, sizeof pattern);
  return pattern;
}

static void check_number(const char *text) {
  double value = -7;
  assert_int_equal(thrum_text_scan_number(text, text + strlen(text), &value), strlen(text));
  double expected = strtod(text, NULL);
  if (bits(value) != bits(expected))
    fail_msg("%s gives %.17g, not %.17g", text, value, expected);
}

static uint64_t next_random(uint64_t *random) {
  *random ^= *random << 13;
  *random ^= *random >> 7;
  *random ^= *random << 17;
  return *random;
}

static void doubles_come_back_bit_for_bit(void **state) {
  (void)state;
  uint64_t random = 1234567891011u;
  for (int i = 0; i < 50000; i++) {
    uint64_t pattern = next_random(&random);
    double value;
    memcpy(&value, &pattern, sizeof value);
    if (!isfinite(value))
      continue;
    char text[64];
    snprintf(text, sizeof text, "%.17g", value);
    double read = 0;
    assert_int_equal(thrum_text_scan_number(text, text + strlen(text), &read), strlen(text));
    assert_true(bits(read) == bits(value));
  }
}

static void decimals_are_rounded_correctly(void **state) {
  (void)state;
  uint64_t random = 987654321u;
  for (int i = 0; i < 50000; i++) {
    char text[80];
    uint64_t digits = next_random(&random) >> next_random(&random) % 60;
    int point = (int)(next_random(&random) % 50) - 25;
    snprintf(text, sizeof text, "%s%llu%s%llue%d", i % 2 ? "-" : "", (unsigned long long)digits,
             i % 3 ? "." : "", (unsigned long long)next_random(&random) % 1000000, point);
    check_number(text);
  }
}

static void hard_decimals_are_rounded_correctly(void **state) {
  (void)state;

  // zeros, ties between two doubles, subnormal numbers, overflow and underflow
  static const char *const cases[] = {
      "0",
      "-0",
      "0.0e99999999999",
      "00012.50",
      ".5",
      "5.",
      "+1e+2",
      "1E-2",
      "9007199254740993",
      "9007199254740992.999999999999999999",
      "9007199254740993.0000000000000000000000000001",
      "2.2250738585072011e-308",
      "2.2250738585072014e-308",
      "4.9406564584124654e-324",
      "2.4703282292062327e-324",
      "2.4703282292062328e-324",
      "1.7976931348623157e308",
      "1.7976931348623158e308",
      "1e400",
      "-1e400",
      "1e-400",
      "1e22",
      "1e23",
      "123456789e-22",
      "0.1e-22",
      "12345678901234567890",
      "99999999999999999999e-20",
      "1e99999999999999999999",
      "1e-99999999999999999999",
      "0.000000000000000000000000000000000000000000000000000001e54"};

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    check_number(cases[i]);

  // midway between 1 and the next double, decided by a digit far behind
  char text[1200];
  for (int last = 0; last < 2; last++) {
    int used =
        snprintf(text, sizeof text, "1.00000000000000011102230246251565404236316680908203125");
    memset(text + used, '0', 1000);
    text[used + 1000] = last ? '1' : '0';
    text[used + 1001] = '\0';
    check_number(text);
    double value;
    thrum_text_scan_number(text, text + used + 1001, &value);
    assert_true(value == (last ? nextafter(1, 2) : 1));
  }
}

static void a_word_that_is_no_number_is_left_alone(void **state) {
  (void)state;

  // texts without a number use no characters and leave the value
  static const char *const none[] = {"", "-", "+", ".", "-.", "e5", "x", "--1", "+-1", ",5", "- 1"};
  double value = -7;
  for (size_t i = 0; i < sizeof none / sizeof *none; i++)
    assert_int_equal(thrum_text_scan_number(none[i], none[i] + strlen(none[i]), &value), 0);
  assert_true(value == -7);

  // only the beginning of these is a number
  static const struct {
    const char *text;
    size_t used;
    double value;
  } part[] = {{"1,5", 1, 1},  {"1.2.3", 3, 1.2}, {"1e", 1, 1}, {"1e+", 1, 1},
              {"0x10", 1, 0}, {"1 2", 1, 1},     {"7f", 1, 7}, {"2e3e4", 3, 2000}};
  for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
    const char *text = part[i].text;
    assert_int_equal(thrum_text_scan_number(text, text + strlen(text), &value), part[i].used);
    assert_true(value == part[i].value);
  }

  // the given end is respected, whatever follows in memory
  assert_int_equal(thrum_text_scan_number(part[1].text, part[1].text + 2, &value), 2);
  assert_true(value == 1);
}

static void non_finite_words_are_scanned_to_be_named(void **state) {
  (void)state;
  double value = 0;
  static const char *const words[] = {"inf", "INF", "infinity", "nan", "NaN"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
    assert_int_equal(thrum_text_scan_number(words[i], words[i] + strlen(words[i]), &value),
                     strlen(words[i]));
    assert_false(isfinite(value));
  }
}

static void integers_stop_at_their_range(void **state) {
  (void)state;

  // the range is that of 64 bits, without its lowest value
  static const struct {
    const char *text;
    size_t used;
    int64_t value;
  } cases[] = {{"0", 1, 0},
               {"-12", 3, -12},
               {"+7x", 2, 7},
               {"9223372036854775807", 19, INT64_MAX},
               {"-9223372036854775807", 20, -INT64_MAX},
               {"9223372036854775808", 0, 0},
               {"99999999999999999999", 0, 0},
               {"-", 0, 0},
               {"x", 0, 0},
               {"", 0, 0}};

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    int64_t value = 0;
    const char *text = cases[i].text;
    assert_int_equal(thrum_text_scan_integer(text, text + strlen(text), &value), cases[i].used);
    assert_true(value == cases[i].value);
  }
}

static void lines_end_in_three_ways_and_keep_their_numbers(void **state) {
  (void)state;

  // three kinds of line endings, comments, blank lines and a last line without an end
  const char *path = mesh_write_text("lines", "one\r\ntwo # x\n\n# y\n  \rthree\n\nfour  ");
  thrum_text text;
  assert_int_equal(thrum_text_open(path, '#', ',', &text, NULL), THRUM_OK);

  // the words with the lines that an editor would count
  static const struct {
    const char *word;
    int64_t line;
  } expected[] = {{"one", 1}, {"two", 2}, {"three", 6}, {"four", 8}};
  thrum_word word = {"", 0};
  for (int i = 0; i < 4; i++) {
    assert_true(thrum_text_next_line(&text));
    assert_int_equal(text.line, expected[i].line);
    assert_true(thrum_text_word(&text, &word));
    assert_true(thrum_text_equals(word, expected[i].word));
    assert_false(thrum_text_word(&text, &word));
  }

  // the end stays the end
  assert_false(thrum_text_next_line(&text));
  assert_false(thrum_text_next_line(&text));
  assert_false(thrum_text_more(&text));

  thrum_text_close(&text);
}

static void a_locale_with_decimal_commas_changes_nothing(void **state) {
  (void)state;
  // any of these that is installed; without one, the digits are as above
  static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE", "C"};
  size_t i = 0;
  while (!setlocale(LC_ALL, names[i]))
    i++;
  double value = 0;
  const char *text = "12345.6789012345678901234567890";
  assert_int_equal(thrum_text_scan_number(text, text + strlen(text), &value), strlen(text));
  assert_true(value == 12345.6789012345678901234567890);
  const char *comma = "1,5";
  assert_int_equal(thrum_text_scan_number(comma, comma + 3, &value), 1);
  setlocale(LC_ALL, "C");
}

static void a_number_within_a_width_keeps_the_digits_that_fit(void **state) {
  (void)state;
  char text[THRUM_NUMBER_TEXT];
  // whatever the number, it fits, and what is read back is as near as 12 digits are
  uint64_t random = 20;
  for (int i = 0; i < 50000; i++) {
    uint64_t pattern = next_random(&random);
    double value;
    memcpy(&value, &pattern, sizeof value);
    if (!isfinite(value))
      continue;
    const size_t length = thrum_number_text_within(value, 20, text);
    assert_int_equal(length, strlen(text));
    assert_true(length <= 20);
    const double back = strtod(text, NULL);
    if (fabs(back - value) > 1e-11 * fabs(value) && isnormal(value))
      fail_msg("%.17g became %s", value, text);
  }

  // zeros that say nothing go before digits do
  thrum_number_text_within(0.15, 20, text);
  assert_string_equal(text, "0.15");
  thrum_number_text_within(-0.025000000000000085, 20, text);
  assert_string_equal(text, "-.025000000000000085");
  thrum_number_text_within(-8.5001450322863552e-17, 20, text);
  assert_string_equal(text, "-8.5001450322864e-17");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(doubles_come_back_bit_for_bit),
      cmocka_unit_test(decimals_are_rounded_correctly),
      cmocka_unit_test(hard_decimals_are_rounded_correctly),
      cmocka_unit_test(a_word_that_is_no_number_is_left_alone),
      cmocka_unit_test(non_finite_words_are_scanned_to_be_named),
      cmocka_unit_test(integers_stop_at_their_range),
      cmocka_unit_test(lines_end_in_three_ways_and_keep_their_numbers),
      cmocka_unit_test(a_locale_with_decimal_commas_changes_nothing),
      cmocka_unit_test(a_number_within_a_width_keeps_the_digits_that_fit),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
