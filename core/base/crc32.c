/* CRC-32 as zip files use it: the remainder of the message, as a polynomial over GF(2), modulo
 * x^32+x^26+x^23+x^22+x^16+x^12+x^11+x^10+x^8+x^7+x^5+x^4+x^2+x+1, bits reflected, with the first
 * 32 bits and the result inverted.
 * The remainder is linear, so eight bytes are divided at once by eight table look-ups whose results
 * are added: M. E. Kounavis and F. L. Berry, "Novel table lookup-based algorithms for
 * high-performance CRC generation", IEEE Trans. Computers 57 (2008), doi:10.1109/TC.2008.85.
 * Cost: about one cycle a byte; the tables take 4,000 operations.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/crc32.h"

#define POLYNOMIAL UINT32_C(0xEDB88320)

void thrum_crc32_prepare(thrum_crc32_table *table) {
  for (uint32_t b = 0; b < 256; b++) {
    uint32_t r = b;
    for (int bit = 0; bit < 8; bit++)
      r = (r >> 1) ^ ((r & 1u) != 0 ? POLYNOMIAL : 0u);
    table->row[0][b] = r;
  }
  // one zero byte more is one more step of the byte-wise division
  for (int k = 1; k < 8; k++)
    for (int b = 0; b < 256; b++) {
      uint32_t r = table->row[k - 1][b];
      table->row[k][b] = (r >> 8) ^ table->row[0][r & 0xFFu];
    }
}

uint32_t thrum_crc32(const thrum_crc32_table *table, uint32_t crc, const void *data, size_t size) {
  const unsigned char *p = data;
  uint32_t r = ~crc;
  for (; size >= 8; size -= 8, p += 8) {
    // bytes are taken one by one, so neither alignment nor byte order matters
    uint32_t low =
        r ^ ((uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24);
    r = table->row[7][low & 0xFFu] ^ table->row[6][(low >> 8) & 0xFFu] ^
        table->row[5][(low >> 16) & 0xFFu] ^ table->row[4][low >> 24] ^ table->row[3][p[4]] ^
        table->row[2][p[5]] ^ table->row[1][p[6]] ^ table->row[0][p[7]];
  }
  for (; size > 0; size--, p++)
    r = (r >> 8) ^ table->row[0][(r ^ *p) & 0xFFu];
  return ~r;
}
