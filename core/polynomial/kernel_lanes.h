/* Helpers that all kernels build on their primitives, for a file that has defined
 *
 *   v8          8 doubles, in as many registers as that takes
 *   INLINE      `static inline`, forced, for the instructions in use; PASS the same without inline
 *   v8_zero, v8_set1(s), v8_load(p), v8_store(p, a), v8_mul(a, b), v8_add(a, b)
 *   v8_and(a, b)               bitwise and
 *   v8_load_single(p)          8 floats as doubles
 *   v8_sum(a)                  ((0+4)+(2+6))+((1+5)+(3+7))
 *   v8_sums(a, ..., h)         the v8_sum of each of eight
 *   v8_two(s, t)               s and t in the first lanes, zeros in the others
 *   ROWS_MANY, ROWS_FEW        rows taken at once, 1 to 8: at one point, and at two
 *
 * and, to replace the defaults below,
 *   V8_MASKS    v8_mask, v8_range(lo, hi)  the lanes lo <= s < hi; lo and hi may be any number
 *               v8_load_mask(p, mask)      these lanes of p, zero in the others, which are not read
 *   V8_KEEP     v8_keep(a)     a, in a register from here on
 *   V8_STORE_FIRST  v8_store_first(p, a, count)  the first lanes, 1 or more
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdint.h>

#define EACH_8(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

/* Eight vectors, passed as one value. */
typedef struct v8x8 {
  v8 r[8];
} v8x8;

#ifndef V8_MASKS
typedef struct v8_mask {
  int64_t lo, hi;
} v8_mask;

INLINE v8_mask v8_range(int64_t lo, int64_t hi) {
  const v8_mask mask = {lo < 0 ? 0 : lo, hi > 8 ? 8 : hi};
  return mask;
}

INLINE v8 v8_load_mask(const double *p, v8_mask mask) {
  if (mask.lo == 0 && mask.hi == 8)
    return v8_load(p);
  double lanes[8] = {0};
  for (int64_t s = mask.lo; s < mask.hi; s++)
    lanes[s] = p[s];
  return v8_load(lanes);
}
#endif

#ifndef V8_STORE_FIRST
/* The lanes s < count, 1 or more. */
INLINE void v8_store_first(double *p, v8 a, int64_t count) {
  if (count >= 8) {
    v8_store(p, a);
    return;
  }
  double lanes[8];
  v8_store(lanes, a);
  for (int64_t s = 0; s < count; s++)
    p[s] = lanes[s];
}
#endif

#ifndef V8_KEEP
INLINE v8 v8_keep(v8 a) {
  return a;
}
#endif

INLINE v8 v8_load_range(const double *p, int64_t lo, int64_t hi) {
  return v8_load_mask(p, v8_range(lo, hi));
}

#ifndef V8_PREFETCH
INLINE void v8_prefetch(const void *p) {
  (void)p;
}
#endif

/* The sums of the first `rows` vectors, and zeros for the others, which are zero. */
INLINE v8 v8_sums_of(int rows, const v8x8 *a) {
  if (rows > 2)
    return v8_sums(a->r[0], a->r[1], a->r[2], a->r[3], a->r[4], a->r[5], a->r[6], a->r[7]);
  return v8_two(v8_sum(a->r[0]), rows > 1 ? v8_sum(a->r[1]) : 0.0);
}

/* Writes them to to[0..7]. It takes one store, because a load of the result would wait for
 * several. */
INLINE void v8_store_sums(int rows, double *to, const v8x8 *a) {
  v8_store(to, v8_sums_of(rows, a));
}
