/* The peak and the bandwidths of one core, with which measured times are compared.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MACHINE_H
#define THRUM_BENCH_MACHINE_H

/* Measured with the widest vectors of the machine. */
typedef struct bench_machine {
  double peak_gflops; /* fused multiply-adds in registers, 2 operations each [1e9/s] */
  double l2_gbs;      /* reading 256 kB again and again [1e9 byte/s] */
  double l3_gbs;      /* 8 MB */
  double dram_gbs;    /* 512 MB */
} bench_machine;

/* Takes about a second. */
void bench_machine_measure(bench_machine *machine);

/* Bandwidth of the level that holds so many bytes, and its name. */
double bench_machine_bandwidth(const bench_machine *machine, double bytes, const char **level);

/* Compiler, its flags; static storage. */
const char *bench_build(void);

#endif
