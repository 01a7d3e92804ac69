/* The passes with AVX-512: one register of 8 lanes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/kernels/processor_kernel.h"

#ifdef THRUM_KERNEL_HAS_X86

#include <immintrin.h>

#define TARGET __attribute__((target("avx512f")))
#define INLINE static inline __attribute__((always_inline, target("avx512f")))
#define ROWS_MANY 8
#define ROWS_FEW 4
#define POINT_SUMS 9
#define POINT_COLUMNS 8
#define PASS static TARGET

typedef __m512d v8;

INLINE v8 v8_zero(void) {
  return _mm512_setzero_pd();
}

INLINE v8 v8_set1(double s) {
  return _mm512_set1_pd(s);
}

INLINE v8 v8_load(const double *p) {
  return _mm512_loadu_pd(p);
}

INLINE v8 v8_load_single(const float *p) {
  return _mm512_cvtps_pd(_mm256_loadu_ps(p));
}

#define V8_PREFETCH
INLINE void v8_prefetch(const void *p) {
  _mm_prefetch((const char *)p, _MM_HINT_T0);
}

/* A coefficient with two products is loaded once: with a memory operand in each, a force at r = 30
 * took 1.14 of the time. */
#define V8_KEEP
INLINE v8 v8_keep(v8 a) {
  __asm__("" : "+v"(a));
  return a;
}

INLINE void v8_store(double *p, v8 a) {
  _mm512_storeu_pd(p, a);
}

INLINE v8 v8_mul(v8 a, v8 b) {
  return _mm512_mul_pd(a, b);
}

INLINE v8 v8_add(v8 a, v8 b) {
  return _mm512_add_pd(a, b);
}

INLINE v8 v8_and(v8 a, v8 b) {
  return _mm512_castsi512_pd(_mm512_and_si512(_mm512_castpd_si512(a), _mm512_castpd_si512(b)));
}

#define V8_MASKS
typedef __mmask8 v8_mask;

INLINE v8_mask v8_range(int64_t lo, int64_t hi) {
  const unsigned from = lo < 0 ? 0 : lo > 8 ? 8 : (unsigned)lo;
  const unsigned to = hi < 0 ? 0 : hi > 8 ? 8 : (unsigned)hi;
  return (__mmask8)((0xffU << from) & (0xffU >> (8 - to)));
}

INLINE v8 v8_load_mask(const double *p, v8_mask mask) {
  return _mm512_maskz_loadu_pd(mask, p);
}

#define V8_STORE_FIRST
INLINE void v8_store_first(double *p, v8 a, int64_t count) {
  _mm512_mask_storeu_pd(p, v8_range(0, count), a);
}

INLINE double v8_sum(v8 a) {
  const __m256d four = _mm256_add_pd(_mm512_castpd512_pd256(a), _mm512_extractf64x4_pd(a, 1));
  const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
  return _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two));
}

INLINE v8 v8_two(double s, double t) {
  return _mm512_setr_pd(s, t, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
}

/* Each step adds two halves of all, and leaves them half as wide. */
INLINE v8 v8_fold(v8 a, v8 b) {
  return _mm512_add_pd(_mm512_shuffle_f64x2(a, b, 0x44), _mm512_shuffle_f64x2(a, b, 0xee));
}

INLINE v8 v8_fold_again(v8 a, v8 b) {
  return _mm512_add_pd(_mm512_shuffle_f64x2(a, b, 0x88), _mm512_shuffle_f64x2(a, b, 0xdd));
}

INLINE v8 v8_sums(v8 a, v8 b, v8 c, v8 d, v8 e, v8 f, v8 g, v8 h) {
  const v8 low = v8_fold_again(v8_fold(a, b), v8_fold(c, d));
  const v8 high = v8_fold_again(v8_fold(e, f), v8_fold(g, h));
  const v8 sums = _mm512_add_pd(_mm512_unpacklo_pd(low, high), _mm512_unpackhi_pd(low, high));
  // a, e, b, f, ... into order
  return _mm512_permutexvar_pd(_mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7), sums);
}

#include "core/polynomial/kernel_lanes.h"
// these need the lanes
#include "runtime/kernels/kernel_passes.inl"

static const thrum_kernel points_table = THRUM_POINTS_TABLE(THRUM_KERNEL_AVX512);
const thrum_kernel thrum_kernel_avx512 = THRUM_KERNEL_TABLE(THRUM_KERNEL_AVX512);

#else
typedef int thrum_kernel_avx512_is_elsewhere;
#endif
