/* Writes bytes as base64 text. SPDX-License-Identifier: Apache-2.0 */
#include "io/base64.h"

#include <string.h>

#define PIECE 3072 /* bytes that are written as text at a time: a multiple of 3 */

/* Writes the four characters of a group of one to three bytes. */
static void group_text(const unsigned char *bytes, size_t count, char text[4]) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

  // bytes that are missing count as zeros, and their characters are '='
  const unsigned bits = (unsigned)bytes[0] << 16 | (count > 1 ? (unsigned)bytes[1] << 8 : 0) |
                        (count > 2 ? bytes[2] : 0);
  text[0] = digits[bits >> 18];
  text[1] = digits[bits >> 12 & 63];
  text[2] = count > 1 ? digits[bits >> 6 & 63] : '=';
  text[3] = count > 2 ? digits[bits & 63] : '=';
}

/* Writes whole groups. */
static void put_groups(FILE *stream, const unsigned char *bytes, size_t size) {
  char text[PIECE / 3 * 4];

  // a piece at a time, since a call for each group would cost more than its text
  for (size_t begin = 0; begin < size; begin += PIECE) {
    const size_t count = size - begin < PIECE ? size - begin : PIECE;
    for (size_t n = 0; n < count; n += 3)
      group_text(bytes + begin + n, 3, text + n / 3 * 4);
    fwrite(text, 1, count / 3 * 4, stream);
  }
}

void thrum_base64_put(thrum_base64 *text, const void *bytes, size_t size) {
  const unsigned char *at = bytes;

  // first what waits for its group to be full
  size_t waiting = text->waiting_count;
  while (waiting > 0 && waiting < 3 && size > 0) {
    text->waiting[waiting++] = *at++;
    size--;
  }
  if (waiting == 3) {
    put_groups(text->stream, text->waiting, 3);
    waiting = 0;
  }
  text->waiting_count = waiting;

  // then the whole groups; what is left waits
  const size_t whole = size / 3 * 3;
  put_groups(text->stream, at, whole);
  if (size > whole) { // nothing waits, or there would be no bytes left
    memcpy(text->waiting, at + whole, size - whole);
    text->waiting_count = size - whole;
  }
}

void thrum_base64_end(thrum_base64 *text) {
  char last[4];
  if (text->waiting_count > 0) {
    group_text(text->waiting, text->waiting_count, last);
    fwrite(last, 1, sizeof last, text->stream);
  }
  text->waiting_count = 0;
}
