/* Numbers drawn from an input, for fuzz targets whose input is a sequence of decisions. An input
 * that has ended gives zeros. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_DRAW_H
#define THRUM_TESTS_FUZZ_FUZZ_DRAW_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct fuzz_draw {
  const uint8_t *at;
  size_t left;
} fuzz_draw;

static inline unsigned draw_byte(fuzz_draw *draw) {
  if (draw->left == 0)
    return 0;
  draw->left--;
  return *draw->at++;
}

/* A whole number in [0, count), count up to 65536. */
static inline int64_t draw_index(fuzz_draw *draw, int64_t count) {
  const unsigned low = draw_byte(draw), high = count > 256 ? draw_byte(draw) : 0;
  return (int64_t)(low | high << 8) % count;
}

/* Any number, often one of those that break things. */
static inline double draw_any(fuzz_draw *draw) {
  static const double special[] = {0,     -0.0,   1,       -1,     0.5,      1e-300,
                                   1e300, 1e154,  DBL_MAX, -1e15,  INFINITY, -INFINITY,
                                   NAN,   5e-324, 2e9,     0x1p31, 0x1p63};
  const unsigned kind = draw_byte(draw);
  if (kind < 64)
    return special[kind % (sizeof special / sizeof *special)];
  if (kind < 128)
    return ((double)draw_byte(draw) - 128) / 64;

  // any bits at all
  uint8_t bytes[8];
  double number;
  for (int n = 0; n < 8; n++)
    bytes[n] = (uint8_t)draw_byte(draw);
  memcpy(&number, bytes, sizeof number);
  return number;
}

/* A number of about this size, in seven of eight cases. */
static inline double draw_about(fuzz_draw *draw, double size) {
  const unsigned kind = draw_byte(draw);
  return kind % 8 == 0 ? draw_any(draw) : size * ((double)draw_byte(draw) - 128) / 128;
}

/* The same above zero. */
static inline double draw_above(fuzz_draw *draw, double size) {
  const unsigned kind = draw_byte(draw);
  return kind % 8 == 0 ? draw_any(draw) : size * ((double)draw_byte(draw) + 1) / 64;
}

#endif
