/* The passes for several states at once with AVX-512: eight.
 * SPDX-License-Identifier: Apache-2.0 */
#include "crowd.h"

#ifdef THRUM_KERNEL_HAS_X86

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <immintrin.h>

#define LANES 8
#define ROWS 3
#define INLINE static inline __attribute__((always_inline, target("avx512f")))
#define PASS static __attribute__((target("avx512f")))

typedef __m512d vs;

INLINE vs vs_zero(void) {
  return _mm512_setzero_pd();
}

INLINE vs vs_set1(double s) {
  return _mm512_set1_pd(s);
}

INLINE vs vs_load(const double *p) {
  return _mm512_load_pd(p);
}

INLINE void vs_store(double *p, vs a) {
  _mm512_store_pd(p, a);
}

INLINE vs vs_mul(vs a, vs b) {
  return _mm512_mul_pd(a, b);
}

INLINE vs vs_add(vs a, vs b) {
  return _mm512_add_pd(a, b);
}

#include "crowd_passes.h"

const thrum_crowd_kernel thrum_crowd_kernel_avx512 = THRUM_CROWD_TABLE;

#else
typedef int thrum_crowd_avx512_is_elsewhere;
#endif
