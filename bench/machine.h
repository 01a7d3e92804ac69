/* The peak and the bandwidths of one core, with which measured times are compared.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MACHINE_H
#define THRUM_BENCH_MACHINE_H

/* Measured with the widest vectors of the machine. */
typedef struct bench_machine {
  double peak_gflops; /* fused multiply-adds in registers, 2 operations each [1e9/s] */
  double l2_bytes;    /* sizes of the caches of the first processor, as its system has them; else */
  double l3_bytes;    /* 1 and 32 MiB */
  double l2_gbs;      /* reading a quarter of the second level again and again [1e9 byte/s], */
  double l3_gbs;      /* a quarter of the third level, or twice the second if that is more, */
  double dram_gbs;    /* and 512 MiB */
} bench_machine;

/* The sizes alone, and all of it, in processor time; takes about a second. */
void bench_machine_caches(bench_machine *machine);
void bench_machine_measure(bench_machine *machine);

/* Bandwidth of the level that holds so many bytes, and its name. */
double bench_machine_bandwidth(const bench_machine *machine, double bytes, const char **level);

/* Compiler, its flags; static storage. */
const char *bench_build(void);

#endif
