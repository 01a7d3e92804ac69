/* The passes for several states at once with AVX2: four.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/batch/batch_kernel.h"

#ifdef THRUM_KERNEL_HAS_X86

#include <immintrin.h>

#define LANES 4
#define ROWS 4
#define ROWS_FEW 3
#define INLINE static inline __attribute__((always_inline, target("avx2")))
#define PASS static __attribute__((target("avx2")))

typedef __m256d vs;

INLINE vs vs_zero(void) {
  return _mm256_setzero_pd();
}

INLINE vs vs_set1(double s) {
  return _mm256_set1_pd(s);
}

INLINE vs vs_set1_single(const float *p) {
  return _mm256_cvtps_pd(_mm_set1_ps(*p));
}

INLINE vs vs_load(const double *p) {
  return _mm256_load_pd(p);
}

INLINE void vs_store(double *p, vs a) {
  _mm256_store_pd(p, a);
}

INLINE vs vs_mul(vs a, vs b) {
  return _mm256_mul_pd(a, b);
}

INLINE vs vs_div(vs a, vs b) {
  return _mm256_div_pd(a, b);
}

INLINE vs vs_add(vs a, vs b) {
  return _mm256_add_pd(a, b);
}

/* A number that all lanes take is a register's anyway. */
INLINE vs vs_keep(vs a) {
  return a;
}

INLINE const double *vs_again(const double *p) {
  return p;
}

#include "runtime/batch/batch_passes.inl"

const thrum_batch_kernel thrum_batch_kernel_avx2 = THRUM_BATCH_TABLE;

#else
typedef int thrum_batch_avx2_is_elsewhere;
#endif
