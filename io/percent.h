/* Shares as they are told: in per cent, with two digits and no exponent.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_PERCENT_H
#define THRUM_IO_PERCENT_H

#include <stdio.h>

enum { PERCENT_MAX = 32 };

/* A share in per cent, without the sign of it: "0.11", "93", "100", "4971"; beyond 1e9 with an
 * exponent after all, and "<0.0001" below that. Returns `text`. */
static inline const char *percent_text(double share, char text[PERCENT_MAX]) {
  const double value = 100 * share;
  if (value > 0 && value < 1e-4)
    return "<0.0001";
  snprintf(text, PERCENT_MAX, value >= 99.5 && value < 1e9 ? "%.0f" : "%.2g", value);
  return text;
}

#endif
