/* Numbers from texts, for options and specs.
 *
 * They are read in the C locale, which the program never leaves, and must fill the whole text:
 * "5e6x", "nan" and "0x10" are no numbers here. SPDX-License-Identifier: Apache-2.0 */
#include "config/parse.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Reads one finite number at the start of `text`; *end is where it stops. */
static bool parse_leading(const char *text, double *value, char **end) {
  // strtod alone would also take white space, hexadecimals, infinities and nan
  const char *digits = text + (*text == '+' || *text == '-');
  if (!(*digits >= '0' && *digits <= '9') && *digits != '.')
    return false;
  if (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X'))
    return false;
  const double parsed = strtod(text, end);
  if (*end == text || !isfinite(parsed))
    return false;
  *value = parsed;
  return true;
}

bool config_parse_number(const char *text, double *value) {
  char *end = NULL;
  double parsed = 0;
  if (!parse_leading(text, &parsed, &end) || *end != 0)
    return false;
  *value = parsed;
  return true;
}

bool config_parse_integer(const char *text, int64_t *value) {
  const char *digits = text + (*text == '+' || *text == '-');
  if (!(*digits >= '0' && *digits <= '9'))
    return false;
  char *end = NULL;
  errno = 0;
  const long long parsed = strtoll(text, &end, 10);
  if (*end != 0 || errno != 0)
    return false;
  *value = parsed;
  return true;
}

bool config_parse_vector3(const char *text, double value[3]) {
  double parsed[3];
  for (int axis = 0; axis < 3; axis++) {
    char *end = NULL;
    if (!parse_leading(text, &parsed[axis], &end))
      return false;
    if (*end != (axis < 2 ? ',' : 0))
      return false;
    text = end + 1;
  }
  memcpy(value, parsed, sizeof parsed);
  return true;
}
