/* The peak of one core: rate of fused multiply-adds and bandwidth of reading, with AVX-512 or AVX2
 * where there is, otherwise in plain C. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench/machine.h"
#include "platform/clock.h"

#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define X86 1
#include <immintrin.h>
#endif

#define L2_BYTES (1 << 20)  /* where the system does not say */
#define L3_BYTES (32 << 20) /* the same */
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
    const double began = clock_thread_seconds();
    for (int64_t n = 0; n < rounds; n++)
      sink = sink + read(a, count);
    const double rate = 1e-9 * (double)(bytes * rounds) / (clock_thread_seconds() - began);
    best = rate > best ? rate : best;
  }
  return best;
}

/* The size of the processor's data cache of this level; 0: the system does not say. */
static double cache_bytes(int level) {
  for (int index = 0; index < 8; index++) {
    char path[96], text[32] = "", unit = 0;
    static const char *const names[] = {"level", "type", "size"};
    double numbers[3] = {0};
    for (int n = 0; n < 3; n++) {
      snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/%s", index, names[n]);
      FILE *file = fopen(path, "r");
      if (file == NULL || fgets(text, sizeof text, file) == NULL)
        text[0] = 0;
      if (file != NULL)
        fclose(file);
      numbers[n] = n == 1 ? text[0] == 'I' : strtod(text, NULL);
      sscanf(text, "%*f%c", &unit);
    }

    // "1024K" of level 2, of data or of all
    if ((int)numbers[0] == level && numbers[1] == 0)
      return numbers[2] * (unit == 'M' ? 1 << 20 : unit == 'K' ? 1 << 10 : 1);
  }
  return 0;
}

void bench_machine_caches(bench_machine *machine) {
  machine->l2_bytes = cache_bytes(2);
  machine->l3_bytes = cache_bytes(3);
  if (!(machine->l2_bytes > 0))
    machine->l2_bytes = L2_BYTES;
  if (!(machine->l3_bytes > machine->l2_bytes))
    machine->l3_bytes = fmax(L3_BYTES, 4 * machine->l2_bytes);
}

/* A part of so many bytes, in whole rounds of the readers, that the memory for it has. */
static int64_t part_of(double bytes) {
  return (int64_t)(fmin(bytes, DRAM_BYTES) / 4096) * 4096;
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
  bench_machine_caches(machine);
  double sink = 0;
  for (int r = 0; r < REPETITIONS; r++) {
    const double began = clock_thread_seconds();
    const double operations = rate(&sink);
    const double found = 1e-9 * operations / (clock_thread_seconds() - began);
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
  const double third = fmax(0.25 * machine->l3_bytes, 2 * machine->l2_bytes);
  machine->l2_gbs = bandwidth(read, memory, part_of(0.25 * machine->l2_bytes), REPETITIONS);
  machine->l3_gbs = bandwidth(read, memory, part_of(third), REPETITIONS);
  machine->dram_gbs = bandwidth(read, memory, DRAM_BYTES, 3);
  free(memory);
}

double bench_machine_bandwidth(const bench_machine *machine, double bytes, const char **level) {
  const bool second = bytes <= machine->l2_bytes, third = bytes <= machine->l3_bytes;
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
