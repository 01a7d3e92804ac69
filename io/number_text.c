/* Numbers as text that reads back exactly. SPDX-License-Identifier: Apache-2.0 */
#include "io/number_text.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

size_t thrum_number_text(double value, char text[THRUM_NUMBER_TEXT]) {
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, THRUM_NUMBER_TEXT, "%.*g", digits, value);
    if (strtod(text, NULL) == value)
      break;
  }

  // the mark that the locale puts between the digits becomes a point
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
