/* `thrum bench precompute`: options and output; the measurement is bench/pipeline.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/pipeline.h"
#include "cli/bench.h"
#include "cli/cli.h"
#include "precompute/build_info.h"

#define POINTS_MAX 16
#define SYRK_MB 3000 /* a larger panel is not made for comparison's sake */

typedef struct sweep {
  bool over_rank;
  int64_t modes, rank, tets, threads;
  int64_t points[POINTS_MAX]; /* tets, or ranks */
  int64_t count;
  bench_pipeline runs[POINTS_MAX];
  bool json, help;
} sweep;

static const char *const stage_names[] = {
#define X(name, text) #name,
    THRUM_STAGE_LIST(X)
#undef X
};

static void print_help(void) {
  fputs("usage: thrum bench precompute [OPTIONS]\n\n"
        "Times the pipeline of thrum precompute on clamped beams, stage by stage, against the\n"
        "size of the mesh or the rank, each run in a process of its own; and beside it one DSYRK\n"
        "of the size of its Gram product. Seconds are of the processor, which another program on\n"
        "the machine disturbs least; wall-clock seconds stand beside the totals.\n\n"
        "      --tets LIST    sizes of mesh (default 1000,3000,10000,30000,100000)\n"
        "      --ranks LIST   ranks instead, at one size of mesh (default size 10000)\n"
        "      --modes K      linear modes (default 20)\n"
        "      --rank R       rank of --tets (default 30)\n"
        "      --threads N    threads of the linear algebra (default 1)\n"
        "      --json         print one JSON object instead of the table\n"
        "  -h, --help         this text\n\n"
        "examples:\n"
        "  thrum bench precompute\n"
        "  thrum bench precompute --tets 100000 --modes 10\n"
        "  thrum bench precompute --tets 10000 --ranks 10,20,40,80,100 --json\n",
        stdout);
}

/* Comma-separated whole numbers. */
static int read_list(const char *name, const char *text, int64_t high, sweep *asked) {
  char copy[256];
  asked->count = 0;
  if (strlen(text) >= sizeof copy)
    return cli_usage("bench precompute", "--%s is too long", name);
  strcpy(copy, text);
  char *rest = copy;
  while (rest != NULL) {
    char *comma = strchr(rest, ',');
    if (comma != NULL)
      *comma++ = 0;
    int64_t value = 0;
    if (asked->count == POINTS_MAX || !cli_parse_integer(rest, &value) || value < 1 || value > high)
      return cli_usage("bench precompute",
                       "--%s is up to %d whole numbers from 1 to %lld, not '%s'", name, POINTS_MAX,
                       (long long)high, text);
    asked->points[asked->count++] = value;
    rest = comma;
  }
  return CLI_DONE;
}

static int read_count(const char *name, const char *text, int64_t high, int64_t *value) {
  sweep one = {0};
  const int code = read_list(name, text, high, &one);
  if (code == CLI_DONE && one.count != 1)
    return cli_usage("bench precompute", "--%s is one number, not '%s'", name, text);
  if (code == CLI_DONE)
    *value = one.points[0];
  return code;
}

static int read_options(int argc, char **argv, sweep *asked) {
  static const struct option options[] = {
      {"tets", required_argument, NULL, 't'},    {"ranks", required_argument, NULL, 's'},
      {"modes", required_argument, NULL, 'k'},   {"rank", required_argument, NULL, 'r'},
      {"threads", required_argument, NULL, 'n'}, {"json", no_argument, NULL, 'j'},
      {"help", no_argument, NULL, 'h'},          {NULL, 0, NULL, 0}};
  const char *tets = NULL, *ranks = NULL;
  opterr = 0;
  optind = 0;
  int option, code = CLI_DONE;
  while (code == CLI_DONE && (option = getopt_long(argc, argv, ":h", options, NULL)) != -1) {
    if (option == 't')
      tets = optarg;
    else if (option == 's')
      ranks = optarg;
    else if (option == 'k')
      code = read_count("modes", optarg, 10000, &asked->modes);
    else if (option == 'r')
      code = read_count("rank", optarg, THRUM_RANK_MAX, &asked->rank);
    else if (option == 'n')
      code = read_count("threads", optarg, 1024, &asked->threads);
    else if (option == 'j')
      asked->json = true;
    else if (option == 'h')
      asked->help = true;
    else
      return cli_usage_option("bench precompute", argv, options);
  }
  if (code == CLI_DONE && optind < argc)
    return cli_usage("bench precompute", "'%s' is not expected", argv[optind]);
  asked->over_rank = ranks != NULL;
  if (code == CLI_DONE && asked->over_rank && tets != NULL)
    code = read_count("tets", tets, 10000000, &asked->tets);
  if (code == CLI_DONE && asked->over_rank)
    return read_list("ranks", ranks, THRUM_RANK_MAX, asked);
  return code != CLI_DONE
             ? code
             : read_list("tets", tets ? tets : "1000,3000,10000,30000,100000", 10000000, asked);
}

static thrum_status run_all(sweep *asked, thrum_error *error) {
  for (int64_t n = 0; n < asked->count; n++) {
    bench_pipeline *run = &asked->runs[n];
    run->wanted = asked->over_rank ? asked->tets : asked->points[n];
    run->rank = asked->over_rank ? asked->points[n] : asked->rank;
    run->modes = asked->modes;
    run->threads = (int)asked->threads;
    const double columns = (double)(run->rank + run->rank * (run->rank + 1) / 2);
    run->syrk = 48e-6 * columns * (double)run->wanted < SYRK_MB;
    const thrum_status status = bench_pipeline_run(run, error);
    if (status < 0)
      return status;
    fprintf(stderr, "%lld tets, rank %lld: %.2f s of the processor, %.2f s in all\n",
            (long long)run->tets, (long long)run->rank, run->cpu_total, run->total);
  }
  return THRUM_OK;
}

/* What is plotted against what: one column of the table. */
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
  cli_json_number(row, "tets", (double)run->tets);
  cli_json_number(row, "free_dofs", (double)run->free_dofs);
  cli_json_number(row, "modes", (double)run->modes);
  cli_json_number(row, "rank", (double)run->rank);
  cli_json_number(row, "factor_nonzeros", (double)run->factor_nonzeros);
  cJSON *cpu = cJSON_AddObjectToObject(row, "cpu_seconds");
  cJSON *wall = cJSON_AddObjectToObject(row, "seconds");
  cJSON *rates = cJSON_AddObjectToObject(row, "gflops");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    cli_json_number(cpu, stage_names[stage], run->cpu_seconds[stage]);
    cli_json_number(wall, stage_names[stage], run->seconds[stage]);
    if (run->flops[stage] > 0)
      cli_json_number(rates, stage_names[stage],
                      1e-9 * run->flops[stage] / run->cpu_seconds[stage]);
  }
  cli_json_number(cpu, "total", run->cpu_total);
  cli_json_number(wall, "total", run->total);
  cli_json_number(row, "peak_mb", run->peak_mb);
  cli_json_number(row, "syrk_cpu_seconds", run->syrk_cpu_seconds);
  cli_json_number(row, "polynomial_over_syrk", syrk_ratio(run));
  return row;
}

static void print_json(const sweep *asked) {
  cJSON *object = cJSON_CreateObject();
  cli_json_string(object, "processor", bench_processor());
  cli_json_string(object, "compiler", thrum_build_compiler());
  cli_json_string(object, "blas_core", thrum_build_blas_core());
  cli_json_number(object, "threads", (double)asked->threads);
  cJSON *rows = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < asked->count; n++)
    cJSON_AddItemToArray(rows, run_json(&asked->runs[n]));
  cJSON *exponents = cJSON_AddObjectToObject(object, "exponents");
  for (int column = 0; column < THRUM_STAGE_COUNT + 2; column++)
    cli_json_number(exponents,
                    column < THRUM_STAGE_COUNT    ? stage_names[column]
                    : column == THRUM_STAGE_COUNT ? "total"
                                                  : "peak_mb",
                    exponent_of(asked, column, upper_half(asked)));
  cli_json_print(object);
}

static void print_table(const sweep *asked) {
  printf("thrum precompute, %lld modes, %lld thread%s, seconds of the processor\n",
         (long long)asked->modes, (long long)asked->threads, asked->threads > 1 ? "s" : "");
  printf("%s, %s, OpenBLAS core %s\n\n%8s %5s", bench_processor(), thrum_build_compiler(),
         thrum_build_blas_core(), "tets", "rank");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    printf(" %11s", stage_names[stage]);
  printf(" %9s %9s %8s %8s\n", "total", "wall", "MB", "/DSYRK");
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

int bench_pipeline_command(int argc, char **argv) {
  sweep asked = {.modes = 20, .rank = 30, .tets = 10000, .threads = 1};
  const int code = read_options(argc, argv, &asked);
  if (code != CLI_DONE)
    return code;
  if (asked.help) {
    print_help();
    return CLI_DONE;
  }
  thrum_error error = {THRUM_OK, ""};
  if (run_all(&asked, &error) < 0)
    return cli_refuse(&error);
  (asked.json ? print_json : print_table)(&asked);
  return CLI_DONE;
}
