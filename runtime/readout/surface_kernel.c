/* The product of a block of 16 vertices with q (runtime/readout/surface_private.h): plain C, AVX2
 * and AVX-512. The accumulators stay in registers; each float of U is loaded once and used once, so
 * the product runs at the speed of the memory that holds U. Cost: 2 operations and 4 bytes an entry
 * of U.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/readout/surface_private.h"

void thrum_surface_kernel_reference(int64_t rank, const float *rows, const float *q,
                                    float *position) {
  for (int64_t i = 0; i < rank; i++) {
    const float *row = rows + i * THRUM_SURFACE_LANES;
    const float q_i = q[i];
    for (int s = 0; s < THRUM_SURFACE_LANES; s++)
      position[s] += row[s] * q_i;
  }
}

#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#include <immintrin.h>

/* Prefetch distance of rows, in floats: a hardware prefetcher stops at each page. */
#define AHEAD (32 * THRUM_SURFACE_LANES)

__attribute__((target("avx2"))) static void kernel_avx2(int64_t rank, const float *rows,
                                                        const float *q, float *position) {
  __m256 sum[6];
  for (int s = 0; s < 6; s++)
    sum[s] = _mm256_loadu_ps(position + 8 * s);
  for (int64_t i = 0; i < rank; i++) {
    const float *row = rows + i * THRUM_SURFACE_LANES;
    const __m256 q_i = _mm256_set1_ps(q[i]);
    for (int s = 0; s < 3; s++)
      _mm_prefetch((const char *)(row + AHEAD + 16 * s), _MM_HINT_T0);
    for (int s = 0; s < 6; s++)
      sum[s] = _mm256_add_ps(sum[s], _mm256_mul_ps(_mm256_load_ps(row + 8 * s), q_i));
  }
  for (int s = 0; s < 6; s++)
    _mm256_storeu_ps(position + 8 * s, sum[s]);
}

__attribute__((target("avx512f"))) static void kernel_avx512(int64_t rank, const float *rows,
                                                             const float *q, float *position) {
  __m512 sum[3];
  for (int s = 0; s < 3; s++)
    sum[s] = _mm512_loadu_ps(position + 16 * s);
  for (int64_t i = 0; i < rank; i++) {
    const float *row = rows + i * THRUM_SURFACE_LANES;
    const __m512 q_i = _mm512_set1_ps(q[i]);
    for (int s = 0; s < 3; s++)
      _mm_prefetch((const char *)(row + AHEAD + 16 * s), _MM_HINT_T0);
    for (int s = 0; s < 3; s++)
      sum[s] = _mm512_add_ps(sum[s], _mm512_mul_ps(_mm512_load_ps(row + 16 * s), q_i));
  }
  for (int s = 0; s < 3; s++)
    _mm512_storeu_ps(position + 16 * s, sum[s]);
}

thrum_surface_kernel *thrum_surface_kernel_best(void) {
  if (__builtin_cpu_supports("avx512f"))
    return kernel_avx512;
  return __builtin_cpu_supports("avx2") ? kernel_avx2 : thrum_surface_kernel_reference;
}
#else
thrum_surface_kernel *thrum_surface_kernel_best(void) {
  return thrum_surface_kernel_reference;
}
#endif
