/* The passes with NEON of 64-bit ARM: four registers of 2 lanes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/kernels/processor_kernel.h"

#ifdef THRUM_KERNEL_HAS_ARM

#include <arm_neon.h>

#define INLINE static inline __attribute__((always_inline))
#define ROWS_MANY 4
#define ROWS_FEW 4
#define PASS static

typedef struct v8 {
  float64x2_t a, b, c, d; /* lanes 0 and 1, 2 and 3, ... */
} v8;

INLINE v8 v8_set1(double s) {
  const float64x2_t t = vdupq_n_f64(s);
  const v8 v = {t, t, t, t};
  return v;
}

INLINE v8 v8_zero(void) {
  return v8_set1(0.0);
}

INLINE v8 v8_load(const double *p) {
  const v8 v = {vld1q_f64(p), vld1q_f64(p + 2), vld1q_f64(p + 4), vld1q_f64(p + 6)};
  return v;
}

INLINE v8 v8_load_single(const float *p) {
  const float32x4_t low = vld1q_f32(p), high = vld1q_f32(p + 4);
  const v8 v = {vcvt_f64_f32(vget_low_f32(low)), vcvt_f64_f32(vget_high_f32(low)),
                vcvt_f64_f32(vget_low_f32(high)), vcvt_f64_f32(vget_high_f32(high))};
  return v;
}

INLINE void v8_store(double *p, v8 v) {
  vst1q_f64(p, v.a);
  vst1q_f64(p + 2, v.b);
  vst1q_f64(p + 4, v.c);
  vst1q_f64(p + 6, v.d);
}

INLINE v8 v8_mul(v8 v, v8 w) {
  const v8 product = {vmulq_f64(v.a, w.a), vmulq_f64(v.b, w.b), vmulq_f64(v.c, w.c),
                      vmulq_f64(v.d, w.d)};
  return product;
}

INLINE v8 v8_add(v8 v, v8 w) {
  const v8 sum = {vaddq_f64(v.a, w.a), vaddq_f64(v.b, w.b), vaddq_f64(v.c, w.c),
                  vaddq_f64(v.d, w.d)};
  return sum;
}

INLINE float64x2_t both_bits(float64x2_t a, float64x2_t b) {
  return vreinterpretq_f64_u64(vandq_u64(vreinterpretq_u64_f64(a), vreinterpretq_u64_f64(b)));
}

INLINE v8 v8_and(v8 v, v8 w) {
  const v8 both = {both_bits(v.a, w.a), both_bits(v.b, w.b), both_bits(v.c, w.c),
                   both_bits(v.d, w.d)};
  return both;
}

/* (0+4)+(2+6) and (1+5)+(3+7) */
INLINE float64x2_t v8_halves(v8 v) {
  return vaddq_f64(vaddq_f64(v.a, v.c), vaddq_f64(v.b, v.d));
}

INLINE double v8_sum(v8 v) {
  const float64x2_t two = v8_halves(v);
  return vgetq_lane_f64(two, 0) + vgetq_lane_f64(two, 1);
}

INLINE v8 v8_two(double s, double t) {
  v8 v = v8_zero();
  v.a = vsetq_lane_f64(t, vdupq_n_f64(s), 1);
  return v;
}

INLINE float64x2_t v8_sums2(v8 a, v8 b) {
  return vpaddq_f64(v8_halves(a), v8_halves(b));
}

INLINE v8 v8_sums(v8 a, v8 b, v8 c, v8 d, v8 e, v8 f, v8 g, v8 h) {
  const v8 v = {v8_sums2(a, b), v8_sums2(c, d), v8_sums2(e, f), v8_sums2(g, h)};
  return v;
}

#include "core/polynomial/kernel_lanes.h"
// these need the lanes
#include "runtime/kernels/kernel_passes.inl"

static const thrum_kernel points_table = THRUM_POINTS_TABLE(THRUM_KERNEL_NEON);
const thrum_kernel thrum_kernel_neon = THRUM_KERNEL_TABLE(THRUM_KERNEL_NEON);

#else
typedef int thrum_kernel_neon_is_elsewhere;
#endif
