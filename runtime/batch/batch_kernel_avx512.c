/* The passes for several states at once with AVX-512: eight.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/batch/batch_kernel.h"

#ifdef THRUM_KERNEL_HAS_X86

#include <immintrin.h>

#define LANES 8
#define ROWS 8
#define ROWS_FEW 4
#define INLINE static inline __attribute__((always_inline, target("avx512f")))
#define PASS static __attribute__((target("avx512f")))

typedef __m512d vs;

INLINE vs vs_zero(void) {
  return _mm512_setzero_pd();
}

INLINE vs vs_set1(double s) {
  return _mm512_set1_pd(s);
}

INLINE vs vs_set1_single(const float *p) {
  return _mm512_cvtps_pd(_mm256_set1_ps(*p));
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

INLINE vs vs_div(vs a, vs b) {
  return _mm512_div_pd(a, b);
}

INLINE vs vs_add(vs a, vs b) {
  return _mm512_add_pd(a, b);
}

/* One number in memory serves as an operand for all lanes, where the other one is in a register. */
INLINE vs vs_keep(vs a) {
  __asm__("" : "+v"(a));
  return a;
}

INLINE const double *vs_again(const double *p) {
  __asm__("" : "+r"(p));
  return p;
}

#include "runtime/batch/batch_passes.inl"

const thrum_batch_kernel thrum_batch_kernel_avx512 = THRUM_BATCH_TABLE;

#else
typedef int thrum_batch_avx512_is_elsewhere;
#endif
