/* `thrum bench precompute`: options and output; the measurement is bench/measure_pipeline.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/bench_command.h"
#include "bench/bench.h"
#include "bench/measure_pipeline.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/make/precompute_progress.h"
#include "io/json.h"
#include "precompute/build_info.h"

#define POINTS_MAX 16
#define SYRK_MB 3000 /* a larger panel is not made for comparison's sake */

typedef struct sweep {
  bool over_rank;
  int64_t modes, rank, tets, threads;
  int64_t sizes[POINTS_MAX]; /* as given */
  int64_t size_count;
  int64_t points[POINTS_MAX]; /* tets, or ranks */
  int64_t count;
  bench_pipeline runs[POINTS_MAX];
  bool json;
} sweep;

static const char *stage_name(int stage) {
  return precompute_stage_label_of((thrum_stage)stage, false).name;
}

static thrum_status take_tets(const config_given *given, void *request) {
  sweep *asked = request;
  return config_given_counts(given, POINTS_MAX, asked->sizes, &asked->size_count);
}

static thrum_status take_ranks(const config_given *given, void *request) {
  sweep *asked = request;
  asked->over_rank = true;
  return config_given_counts(given, POINTS_MAX, asked->points, &asked->count);
}

#define AT(member) CONFIG_AT(sweep, member)

static const config_option options[] = {
    OPTION_TEXT("tets", "LIST", "1000,3000,10000,30000,100000; with --ranks 10000", "sizes of mesh",
                .take = take_tets, CONFIG_RANGE(1, 1e7),
                .wants = "up to 16 whole numbers from 1 to 10000000"),
    OPTION_TEXT("ranks", "LIST", NULL, "ranks instead, at one size of mesh", .take = take_ranks,
                CONFIG_RANGE(1, THRUM_RANK_MAX), .wants = "up to 16 whole numbers from 1 to 512"),
    OPTION_COUNT("modes", "20", "linear modes", AT(modes), CONFIG_RANGE(1, 10000)),
    OPTION_COUNT("rank", "30", "rank of --tets", AT(rank), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_COUNT("threads", "1", "threads of the linear algebra", AT(threads),
                 CONFIG_RANGE(1, CONFIG_THREADS_MAX)),
    OPTION_JSON(sweep),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_bench_precompute = {
    .name = "bench precompute",
    .summary = "the pipeline against mesh size or rank",
    .usage = "[OPTIONS]",
    .about =
        "Times the pipeline of thrum precompute on clamped beams, stage by stage, against the size "
        "of the mesh or the rank, each run in a process of its own; and beside it one DSYRK of the "
        "size of its Gram product. Seconds are of the processor, which another program on the "
        "machine disturbs least; wall-clock seconds stand beside the totals.",
    .options = options,
    .examples = "bench precompute\n"
                "bench precompute --tets 100000 --modes 10\n"
                "bench precompute --tets 10000 --ranks 10,20,40,80,100 --json",
};

static int read_options(int argc, char **argv, sweep *asked) {
  static const int64_t usual[] = {1000, 3000, 10000, 30000, 100000};
  CONFIG_TRY(config_options_read(&command_bench_precompute, argc, argv, asked));
  if (optind < argc)
    return config_usage("bench precompute", "'%s' is not expected", argv[optind]);
  if (asked->over_rank && asked->size_count > 1)
    return config_usage("bench precompute", "--tets is one number when there are --ranks");

  // either the ranks or the sizes are the points of the sweep
  if (asked->over_rank && asked->size_count == 1)
    asked->tets = asked->sizes[0];
  if (!asked->over_rank) {
    const bool given = asked->size_count > 0;
    asked->count = given ? asked->size_count : (int64_t)(sizeof usual / sizeof *usual);
    memcpy(asked->points, given ? asked->sizes : usual, (size_t)asked->count * sizeof *usual);
  }
  return COMMAND_DONE;
}

static thrum_status run_all(sweep *asked, thrum_error *error) {
  for (int64_t n = 0; n < asked->count; n++) {
    bench_pipeline *run = &asked->runs[n];
    run->wanted = asked->over_rank ? asked->tets : asked->points[n];
    run->rank = asked->over_rank ? asked->points[n] : asked->rank;
    run->modes = asked->modes;
    run->threads = (int)asked->threads;

    // the DSYRK is timed where its panel fits into memory
    const double columns = (double)(run->rank + run->rank * (run->rank + 1) / 2);
    run->syrk = 48e-6 * columns * (double)run->wanted < SYRK_MB;
    THRUM_TRY(bench_pipeline_run(run, error));
    fprintf(stderr, "%lld tets, rank %lld: %.2f s of the processor, %.2f s in all\n",
            (long long)run->tets, (long long)run->rank, run->cpu_total, run->total);
  }
  return THRUM_OK;
}

/* The value of a run in one column of the table. */
static double value_of(const bench_pipeline *run, int column) {
  if (column < THRUM_STAGE_COUNT)
    return run->cpu_seconds[column];
  return column == THRUM_STAGE_COUNT ? run->cpu_total : run->peak_mb;
}

/* The exponent of a column over the runs from the `first` on. */
static double exponent_of(const sweep *asked, int column, int64_t first) {
  double x[POINTS_MAX], y[POINTS_MAX];
  for (int64_t n = first; n < asked->count; n++) {
    x[n - first] = (double)(asked->over_rank ? asked->runs[n].rank : asked->runs[n].tets);
    y[n - first] = value_of(&asked->runs[n], column);
  }
  return bench_exponent(x, y, asked->count - first);
}

/* The upper half of the points: what large ones cost. */
static int64_t upper_half(const sweep *asked) {
  return asked->count > 3 ? asked->count / 2 : 0;
}

static double syrk_ratio(const bench_pipeline *run) {
  return run->cpu_seconds[THRUM_STAGE_polynomial] / run->syrk_cpu_seconds;
}

static cJSON *run_json(const bench_pipeline *run) {
  cJSON *row = cJSON_CreateObject();
  json_number(row, "tets", (double)run->tets);
  json_number(row, "free_dofs", (double)run->free_dofs);
  json_number(row, "modes", (double)run->modes);
  json_number(row, "rank", (double)run->rank);
  json_number(row, "factor_nonzeros", (double)run->factor_nonzeros);

  // processor and wall time of each stage, and its rate where it counts operations
  cJSON *cpu = cJSON_AddObjectToObject(row, "cpu_seconds");
  cJSON *wall = cJSON_AddObjectToObject(row, "seconds");
  cJSON *rates = cJSON_AddObjectToObject(row, "gflops");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    json_number(cpu, stage_name(stage), run->cpu_seconds[stage]);
    json_number(wall, stage_name(stage), run->seconds[stage]);
    if (run->flops[stage] > 0)
      json_number(rates, stage_name(stage), 1e-9 * run->flops[stage] / run->cpu_seconds[stage]);
  }

  json_number(cpu, "total", run->cpu_total);
  json_number(wall, "total", run->total);
  json_number(row, "peak_mb", run->peak_mb);
  json_number(row, "syrk_cpu_seconds", run->syrk_cpu_seconds);
  json_number(row, "polynomial_over_syrk", syrk_ratio(run));
  return row;
}

static void print_json(const sweep *asked) {
  cJSON *object = cJSON_CreateObject();
  json_string(object, "processor", bench_processor());
  json_string(object, "compiler", thrum_build_compiler());
  json_string(object, "blas_core", thrum_build_blas_core());
  json_number(object, "threads", (double)asked->threads);

  cJSON *rows = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < asked->count; n++)
    cJSON_AddItemToArray(rows, run_json(&asked->runs[n]));

  // how each stage grows with the size
  cJSON *exponents = cJSON_AddObjectToObject(object, "exponents");
  for (int column = 0; column < THRUM_STAGE_COUNT + 2; column++)
    json_number(exponents,
                column < THRUM_STAGE_COUNT    ? stage_name(column)
                : column == THRUM_STAGE_COUNT ? "total"
                                              : "peak_mb",
                exponent_of(asked, column, upper_half(asked)));
  json_print(object);
}

static void print_table(const sweep *asked) {
  printf("thrum precompute, %lld modes, %lld thread%s, seconds of the processor\n",
         (long long)asked->modes, (long long)asked->threads, asked->threads > 1 ? "s" : "");
  printf("%s, %s, OpenBLAS core %s\n\n%8s %5s", bench_processor(), thrum_build_compiler(),
         thrum_build_blas_core(), "tets", "rank");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    printf(" %11s", stage_name(stage));
  printf(" %9s %9s %8s %8s\n", "total", "wall", "MB", "/DSYRK");

  // one line for each run
  for (int64_t n = 0; n < asked->count; n++) {
    const bench_pipeline *run = &asked->runs[n];
    printf("%8lld %5lld", (long long)run->tets, (long long)run->rank);
    for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
      printf(" %11.4f", run->cpu_seconds[stage]);
    printf(" %9.3f %9.3f %8.0f", run->cpu_total, run->total, run->peak_mb);
    if (isnan(run->syrk_seconds))
      printf(" %8s\n", "-");
    else
      printf(" %8.2f\n", syrk_ratio(run));
  }

  // exponents need two points
  if (asked->count < 2)
    return;
  printf("%-14s", "grows as ^");
  for (int column = 0; column <= THRUM_STAGE_COUNT; column++)
    printf(column < THRUM_STAGE_COUNT ? " %11.2f" : " %9.2f",
           exponent_of(asked, column, upper_half(asked)));
  printf(" %9s %8.2f\n", "", exponent_of(asked, THRUM_STAGE_COUNT + 1, upper_half(asked)));
  printf("\nExponents: least squares over the upper half of the runs. /DSYRK: the polynomial's\n"
         "seconds over those of one DSYRK of its size.\n");
}

int bench_precompute_command(int argc, char **argv) {
  sweep asked = {.modes = 20, .rank = 30, .tets = 10000, .threads = 1};
  CONFIG_TRY(read_options(argc, argv, &asked));
  thrum_error error = {.status = THRUM_OK};
  if (run_all(&asked, &error) < 0)
    return config_refuse(&error);
  (asked.json ? print_json : print_table)(&asked);
  return COMMAND_DONE;
}
