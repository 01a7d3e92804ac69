/* Numbers as text that reads back exactly. SPDX-License-Identifier: Apache-2.0 */
#include "io/number_text.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

/* The mark that the locale puts between the digits becomes a point; returns the length. */
static size_t put_point(char *text) {
  size_t kept = 0;
  bool foreign = false;
  for (const char *p = text; *p; p++) {
    const bool own = (*p >= '0' && *p <= '9') || *p == '-' || *p == '+' || *p == '.' || *p == 'e';
    if (own || !foreign)
      text[kept++] = own ? *p : '.';
    foreign = !own;
  }
  text[kept] = '\0';
  return kept;
}

size_t thrum_number_text(double value, char text[THRUM_NUMBER_TEXT]) {
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, THRUM_NUMBER_TEXT, "%.*g", digits, value);
    if (strtod(text, NULL) == value)
      break;
  }
  return put_point(text);
}

/* Removes the zero before a point, and the sign and the zeros that begin an exponent. */
static size_t squeeze(char *text) {
  size_t kept = 0, at = 0;
  if (text[0] == '-')
    text[kept++] = text[at++];
  if (text[at] == '0' && text[at + 1] == '.')
    at++;

  // the minus of an exponent stays
  bool begins = false;
  for (; text[at]; at++) {
    if (begins && (text[at] == '0' || text[at] == '+'))
      continue;
    begins = text[at] == 'e' || (begins && text[at] == '-');
    text[kept++] = text[at];
  }
  text[kept] = '\0';
  return kept;
}

size_t thrum_number_text_within(double value, size_t width, char text[THRUM_NUMBER_TEXT]) {
  size_t length = thrum_number_text(value, text);
  if (length > width)
    length = squeeze(text);
  for (int digits = 16; length > width && digits > 1; digits--) {
    snprintf(text, THRUM_NUMBER_TEXT, "%.*g", digits, value);
    put_point(text);
    length = squeeze(text);
  }
  return length;
}
