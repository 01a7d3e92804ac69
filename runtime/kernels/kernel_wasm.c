/* The passes with the 128-bit SIMD of WebAssembly: four registers of 2 lanes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/kernels/processor_kernel.h"
#include "runtime/points/kernel_points.h"

#ifdef THRUM_KERNEL_HAS_WASM

#include <wasm_simd128.h>

#define INLINE static inline __attribute__((always_inline))
#define ROWS_MANY 4
#define ROWS_FEW 4
#define PASS static

typedef struct v8 {
  v128_t a, b, c, d; /* lanes 0 and 1, 2 and 3, ... */
} v8;

INLINE v8 v8_set1(double s) {
  const v128_t t = wasm_f64x2_splat(s);
  const v8 v = {t, t, t, t};
  return v;
}

INLINE v8 v8_zero(void) {
  return v8_set1(0.0);
}

INLINE v8 v8_load(const double *p) {
  const v8 v = {wasm_v128_load(p), wasm_v128_load(p + 2), wasm_v128_load(p + 4),
                wasm_v128_load(p + 6)};
  return v;
}

INLINE v8 v8_load_single(const float *p) {
  const v8 v = {wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p)),
                wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p + 2)),
                wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p + 4)),
                wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p + 6))};
  return v;
}

INLINE void v8_store(double *p, v8 v) {
  wasm_v128_store(p, v.a);
  wasm_v128_store(p + 2, v.b);
  wasm_v128_store(p + 4, v.c);
  wasm_v128_store(p + 6, v.d);
}

INLINE v8 v8_mul(v8 v, v8 w) {
  const v8 product = {wasm_f64x2_mul(v.a, w.a), wasm_f64x2_mul(v.b, w.b), wasm_f64x2_mul(v.c, w.c),
                      wasm_f64x2_mul(v.d, w.d)};
  return product;
}

INLINE v8 v8_add(v8 v, v8 w) {
  const v8 sum = {wasm_f64x2_add(v.a, w.a), wasm_f64x2_add(v.b, w.b), wasm_f64x2_add(v.c, w.c),
                  wasm_f64x2_add(v.d, w.d)};
  return sum;
}

INLINE v8 v8_and(v8 v, v8 w) {
  const v8 both = {wasm_v128_and(v.a, w.a), wasm_v128_and(v.b, w.b), wasm_v128_and(v.c, w.c),
                   wasm_v128_and(v.d, w.d)};
  return both;
}

/* (0+4)+(2+6) and (1+5)+(3+7) */
INLINE v128_t v8_halves(v8 v) {
  return wasm_f64x2_add(wasm_f64x2_add(v.a, v.c), wasm_f64x2_add(v.b, v.d));
}

INLINE double v8_sum(v8 v) {
  const v128_t two = v8_halves(v);
  return wasm_f64x2_extract_lane(two, 0) + wasm_f64x2_extract_lane(two, 1);
}

INLINE v8 v8_two(double s, double t) {
  v8 v = v8_zero();
  v.a = wasm_f64x2_make(s, t);
  return v;
}

INLINE v128_t v8_sums2(v8 a, v8 b) {
  const v128_t x = v8_halves(a), y = v8_halves(b);
  return wasm_f64x2_add(wasm_i64x2_shuffle(x, y, 0, 2), wasm_i64x2_shuffle(x, y, 1, 3));
}

INLINE v8 v8_sums(v8 a, v8 b, v8 c, v8 d, v8 e, v8 f, v8 g, v8 h) {
  const v8 v = {v8_sums2(a, b), v8_sums2(c, d), v8_sums2(e, f), v8_sums2(g, h)};
  return v;
}

#include "core/polynomial/kernel_lanes.h"

/* Cubature points by the passes of the reference: with these instructions, clang 14 gave a tangent
 * with other bits, and other digits. */
#define THRUM_KERNEL_POINTS &thrum_points_reference

// these need the lanes
#include "runtime/kernels/kernel_passes.inl"

const thrum_kernel thrum_kernel_wasm = THRUM_KERNEL_TABLE(THRUM_KERNEL_WASM);

#else
typedef int thrum_kernel_wasm_is_elsewhere;
#endif
