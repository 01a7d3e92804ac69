/* Texts that may be shown on a terminal. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_PLAIN_TEXT_H
#define THRUM_CORE_BASE_PLAIN_TEXT_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Is it one that directs a terminal or the direction of the text? */
static inline bool thrum_text_directs(uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code <= 0x9f) || code == 0x061c || code == 0x200e ||
         code == 0x200f || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

/* The character at `at` and its bytes; 1 byte of that value where it is no UTF-8. */
static inline uint32_t thrum_text_character(const unsigned char *at, int *bytes) {
  const unsigned char first = at[0];
  const int length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 1;
  uint32_t code = length > 1 ? first & (0x7fu >> length) : first;

  // a text that ends within it has a 0 there, which is no continuation
  for (int n = 1; n < length; n++) {
    if ((at[n] & 0xc0) != 0x80) {
      *bytes = 1;
      return first;
    }
    code = code << 6 | (at[n] & 0x3fu);
  }
  *bytes = length;
  return code;
}

/* Puts '?' in the place of what makes a terminal do something or show what is not there: control
 * characters of ASCII and of Unicode (U+0080 to U+009F, also as single bytes), line and paragraph
 * ends, and marks that turn the direction of the text. All else stays, also what is no UTF-8. */
static inline void thrum_plain_text(char *text) {
  for (unsigned char *at = (unsigned char *)text; *at != 0;) {
    int bytes = 1;
    if (thrum_text_directs(thrum_text_character(at, &bytes)))
      memset(at, '?', (size_t)bytes);
    at += bytes;
  }
}

#endif
