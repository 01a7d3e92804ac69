/* The passes with AVX2: two registers of 4 lanes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/kernels/processor_kernel.h"

#ifdef THRUM_KERNEL_HAS_X86

#include <immintrin.h>

#define TARGET __attribute__((target("avx2")))
#define INLINE static inline __attribute__((always_inline, target("avx2")))
#define ROWS_MANY 4
#define ROWS_FEW 4
#define PASS static TARGET

typedef struct v8 {
  __m256d a, b; /* lanes 0 to 3, 4 to 7 */
} v8;

INLINE v8 v8_of(__m256d a, __m256d b) {
  const v8 v = {a, b};
  return v;
}

INLINE v8 v8_zero(void) {
  return v8_of(_mm256_setzero_pd(), _mm256_setzero_pd());
}

INLINE v8 v8_set1(double s) {
  return v8_of(_mm256_set1_pd(s), _mm256_set1_pd(s));
}

INLINE v8 v8_load(const double *p) {
  return v8_of(_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4));
}

INLINE v8 v8_load_single(const float *p) {
  return v8_of(_mm256_cvtps_pd(_mm_loadu_ps(p)), _mm256_cvtps_pd(_mm_loadu_ps(p + 4)));
}

#define V8_PREFETCH
INLINE void v8_prefetch(const void *p) {
  _mm_prefetch((const char *)p, _MM_HINT_T0);
}

INLINE void v8_store(double *p, v8 v) {
  _mm256_storeu_pd(p, v.a);
  _mm256_storeu_pd(p + 4, v.b);
}

INLINE v8 v8_mul(v8 v, v8 w) {
  return v8_of(_mm256_mul_pd(v.a, w.a), _mm256_mul_pd(v.b, w.b));
}

INLINE v8 v8_add(v8 v, v8 w) {
  return v8_of(_mm256_add_pd(v.a, w.a), _mm256_add_pd(v.b, w.b));
}

INLINE v8 v8_and(v8 v, v8 w) {
  return v8_of(_mm256_and_pd(v.a, w.a), _mm256_and_pd(v.b, w.b));
}

#define V8_MASKS
typedef struct v8_mask {
  __m256i a, b;
} v8_mask;

INLINE v8_mask v8_range(int64_t lo, int64_t hi) {
  const __m256i low = _mm256_set1_epi64x(lo - 1), high = _mm256_set1_epi64x(hi);
  const __m256i lanes = _mm256_setr_epi64x(0, 1, 2, 3), next = _mm256_setr_epi64x(4, 5, 6, 7);
  const v8_mask mask = {
      _mm256_and_si256(_mm256_cmpgt_epi64(lanes, low), _mm256_cmpgt_epi64(high, lanes)),
      _mm256_and_si256(_mm256_cmpgt_epi64(next, low), _mm256_cmpgt_epi64(high, next))};
  return mask;
}

INLINE v8 v8_load_mask(const double *p, v8_mask mask) {
  return v8_of(_mm256_maskload_pd(p, mask.a), _mm256_maskload_pd(p + 4, mask.b));
}

INLINE double v8_sum(v8 v) {
  const __m256d four = _mm256_add_pd(v.a, v.b);
  const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
  return _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two));
}

INLINE v8 v8_two(double s, double t) {
  return v8_of(_mm256_setr_pd(s, t, 0.0, 0.0), _mm256_setzero_pd());
}

/* (0+4)+(2+6) and (1+5)+(3+7) of each. */
INLINE __m256d v8_halves(v8 v, v8 w) {
  const __m256d a = _mm256_add_pd(v.a, v.b), b = _mm256_add_pd(w.a, w.b);
  return _mm256_add_pd(_mm256_permute2f128_pd(a, b, 0x20), _mm256_permute2f128_pd(a, b, 0x31));
}

INLINE __m256d v8_sums4(v8 a, v8 b, v8 c, v8 d) {
  return _mm256_hadd_pd(v8_halves(a, c), v8_halves(b, d));
}

INLINE v8 v8_sums(v8 a, v8 b, v8 c, v8 d, v8 e, v8 f, v8 g, v8 h) {
  return v8_of(v8_sums4(a, b, c, d), v8_sums4(e, f, g, h));
}

#include "core/polynomial/kernel_lanes.h"
// these need the lanes
#include "runtime/kernels/kernel_passes.inl"

static const thrum_kernel points_table = THRUM_POINTS_TABLE(THRUM_KERNEL_AVX2);
const thrum_kernel thrum_kernel_avx2 = THRUM_KERNEL_TABLE(THRUM_KERNEL_AVX2);

#else
typedef int thrum_kernel_avx2_is_elsewhere;
#endif
