/* The peak of one core: rate of fused multiply-adds and bandwidth of reading, with AVX-512 or AVX2
 * where there is, otherwise in plain C. SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "bench/machine.h"
#include "platform/clock.h"

#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define X86 1
#include <immintrin.h>
#endif

#define L2_BYTES (256 << 10)
#define L3_BYTES (8 << 20)
#define DRAM_BYTES (512 << 20)
#define RATE_ROUNDS 200000
#define REPETITIONS 15

typedef double reader(const double *a, int64_t count); /* sums; count: of 64 */

#ifdef X86
__attribute__((target("avx512f"))) static double read_avx512(const double *a, int64_t count) {
  __m512d s[8] = {_mm512_setzero_pd()};
  for (int64_t i = 0; i < count; i += 64)
    for (int k = 0; k < 8; k++)
      s[k] = _mm512_add_pd(s[k], _mm512_loadu_pd(a + i + 8 * k));
  double sum = 0;
  for (int k = 0; k < 8; k++)
    sum += _mm512_reduce_add_pd(s[k]);
  return sum;
}

__attribute__((target("avx2"))) static double read_avx2(const double *a, int64_t count) {
  __m256d s[8] = {_mm256_setzero_pd()};
  for (int64_t i = 0; i < count; i += 32)
    for (int k = 0; k < 8; k++)
      s[k] = _mm256_add_pd(s[k], _mm256_loadu_pd(a + i + 4 * k));
  double lane[4], sum = 0;
  for (int k = 0; k < 8; k++) {
    _mm256_storeu_pd(lane, s[k]);
    sum += lane[0] + lane[1] + lane[2] + lane[3];
  }
  return sum;
}

/* Twelve independent chains keep two units of latency 4 or 5 busy. */
#define CHAINS(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)

__attribute__((target("avx512f"))) static double rate_avx512(double *sink) {
  const __m512d x = _mm512_set1_pd(0.999999), y = _mm512_set1_pd(1e-9);
#define X(n) __m512d s##n = _mm512_set1_pd(n);
  CHAINS(X)
#undef X
  for (int i = 0; i < RATE_ROUNDS; i++) {
#define X(n) s##n = _mm512_fmadd_pd(s##n, x, y);
    CHAINS(X)
#undef X
  }
#define X(n) *sink += _mm512_reduce_add_pd(s##n);
  CHAINS(X)
#undef X
  return 12.0 * 8.0 * 2.0 * RATE_ROUNDS;
}

__attribute__((target("avx2,fma"))) static double rate_avx2(double *sink) {
  const __m256d x = _mm256_set1_pd(0.999999), y = _mm256_set1_pd(1e-9);
#define X(n) __m256d s##n = _mm256_set1_pd(n);
  CHAINS(X)
#undef X
  for (int i = 0; i < RATE_ROUNDS; i++) {
#define X(n) s##n = _mm256_fmadd_pd(s##n, x, y);
    CHAINS(X)
#undef X
  }
#define X(n) *sink += _mm256_cvtsd_f64(s##n);
  CHAINS(X)
#undef X
  return 12.0 * 4.0 * 2.0 * RATE_ROUNDS;
}
#endif

static double read_plain(const double *a, int64_t count) {
  double s[8] = {0};
  for (int64_t i = 0; i < count; i += 8)
    for (int k = 0; k < 8; k++)
      s[k] += a[i + k];
  return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

/* Products and sums apart, as plain C has them. */
static double rate_plain(double *sink) {
  double s[24];
  for (int k = 0; k < 24; k++)
    s[k] = k;
  for (int i = 0; i < RATE_ROUNDS; i++)
    for (int k = 0; k < 24; k++)
      s[k] = s[k] * 0.999999 + 1e-9;
  for (int k = 0; k < 24; k++)
    *sink += s[k];
  return 24.0 * 2.0 * RATE_ROUNDS;
}

static double bandwidth(reader *read, const double *a, int64_t bytes, int repetitions) {
  const int64_t count = bytes / (int64_t)sizeof *a;
  const int64_t rounds = count < (1 << 20) ? (1 << 20) / count : 1;
  double best = 0;
  for (int r = 0; r < repetitions; r++) {
    volatile double sink = 0;
    const double began = clock_seconds();
    for (int64_t n = 0; n < rounds; n++)
      sink = sink + read(a, count);
    const double rate = 1e-9 * (double)(bytes * rounds) / (clock_seconds() - began);
    best = rate > best ? rate : best;
  }
  return best;
}

void bench_machine_measure(bench_machine *machine) {
  reader *read = read_plain;
  double (*rate)(double *) = rate_plain;
#ifdef X86
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    read = read_avx2;
    rate = rate_avx2;
  }
  if (__builtin_cpu_supports("avx512f")) {
    read = read_avx512;
    rate = rate_avx512;
  }
#endif

  // the best of the repetitions; the sum is kept so that the compiler keeps the loop
  *machine = (bench_machine){0};
  double sink = 0;
  for (int r = 0; r < REPETITIONS; r++) {
    const double began = clock_seconds();
    const double operations = rate(&sink);
    const double found = 1e-9 * operations / (clock_seconds() - began);
    machine->peak_gflops = found > machine->peak_gflops ? found : machine->peak_gflops;
  }
  volatile double kept = sink;
  (void)kept;

  // without the memory the bandwidths stay zero
  double *memory = aligned_alloc(64, DRAM_BYTES);
  if (!memory)
    return;
  for (int64_t i = 0; i < DRAM_BYTES / (int64_t)sizeof *memory; i++)
    memory[i] = 1e-3 * (double)(i % 7);
  machine->l2_gbs = bandwidth(read, memory, L2_BYTES, REPETITIONS);
  machine->l3_gbs = bandwidth(read, memory, L3_BYTES, REPETITIONS);
  machine->dram_gbs = bandwidth(read, memory, DRAM_BYTES, 3);
  free(memory);
}

double bench_machine_bandwidth(const bench_machine *machine, double bytes, const char **level) {
  // what a level is sure to hold beside other data
  const bool second = bytes <= 2.0 * (1 << 20), third = bytes <= 64.0 * (1 << 20);
  *level = second ? "L2" : third ? "L3" : "DRAM";
  return second ? machine->l2_gbs : third ? machine->l3_gbs : machine->dram_gbs;
}

const char *bench_build(void) {
#if defined(__clang__)
  return "clang " __clang_version__ ", " THRUM_BENCH_FLAGS;
#else
  return "gcc " __VERSION__ ", " THRUM_BENCH_FLAGS;
#endif
}
