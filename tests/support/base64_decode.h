/* Base64 as a test reads it. Header only; needs cmocka. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_BASE64_DECODE_H
#define THRUM_TESTS_SUPPORT_BASE64_DECODE_H

#include <stdbool.h>
#include <string.h>

/* Decodes base64 of whole groups (RFC 4648) and returns the number of bytes. */
static inline uint64_t base64_decode(const char *text, uint64_t length, unsigned char *bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  uint64_t count = 0;
  assert_int_equal(length % 4, 0);
  for (uint64_t n = 0; n < length; n += 4) {
    uint32_t bits = 0;
    int missing = 0;
    for (int k = 0; k < 4; k++) {
      const char *digit = strchr(digits, text[n + (uint64_t)k]);
      const bool pad = text[n + (uint64_t)k] == '=';
      assert_true(pad ? n + 4 == length && k >= 2 : digit != NULL && missing == 0);
      bits = bits << 6 | (pad ? 0 : (uint32_t)(digit - digits));
      missing += pad;
    }

    // three bytes, less those that the padding stands for
    for (int k = 0; k < 3 - missing; k++)
      bytes[count++] = (unsigned char)(bits >> (16 - 8 * k));
  }
  return count;
}

#endif
