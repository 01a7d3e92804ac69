/* `thrum bench displacement`: options and output; the measurement is bench/measure_displacement.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdio.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "bench/measure.h"
#include "config/message.h"
#include "config/options.h"
#include "io/json.h"
#include "precompute/build_info.h"

typedef struct request {
  bench_displacement bench;
  bool json;
} request;

#define AT(member) CONFIG_AT(request, member)

static const config_option options[] = {
    OPTION_COUNT("vertices", "19796", "shown vertices", AT(bench.vertices), CONFIG_RANGE(3, 1e7)),
    OPTION_COUNT("rank", "30", "reduced coordinates", AT(bench.rank),
                 CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_COUNT("repetitions", "200", "samples", AT(bench.repetitions), CONFIG_RANGE(1, 1e6)),
    OPTION_JSON(request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_bench_displacement = {
    .name = "bench displacement",
    .summary = "u = U q of a mesh that is shown",
    .usage = "[OPTIONS]",
    .about =
        "Times u = U q of a body of random numbers: the single-precision surface that the library "
        "offers for display against OpenBLAS' double-precision product with the same U, both on "
        "one thread and taking turns; and the normals.",
    .options = options,
    .examples = "bench displacement\n"
                "bench displacement --vertices 5000 --rank 60 --json",
};

static void print_json(const bench_displacement *bench) {
  cJSON *object = cJSON_CreateObject();
  json_string(object, "processor", bench_processor());
  json_string(object, "compiler", thrum_build_compiler());
  json_string(object, "blas_core", thrum_build_blas_core());

  json_number(object, "vertices", (double)bench->vertices);
  json_number(object, "rank", (double)bench->rank);
  json_number(object, "repetitions", (double)bench->repetitions);

  // each way by its minimum and its median
  bench_row_time(object, "dgemv_us", &bench->dgemv);
  bench_row_time(object, "dgemv_columns_us", &bench->dgemv_columns);
  bench_row_time(object, "double_us", &bench->plain);
  bench_row_time(object, "surface_us", &bench->surface);
  bench_row_time(object, "normals_us", &bench->normals);

  json_number(object, "ratio", bench->ratio);
  json_number(object, "ratio_columns", bench->ratio_columns);
  json_number(object, "ratio_median", bench->ratio_median);
  json_number(object, "bytes_per_us", bench->bytes_surface / bench->surface.minimum);
  json_number(object, "difference", bench->difference);
  json_print(object);
}

static void print_table(const bench_displacement *bench) {
  printf("u = U q of %lld vertices at rank %lld, %lld repetitions, one thread\n",
         (long long)bench->vertices, (long long)bench->rank, (long long)bench->repetitions);
  printf("%s, %s, OpenBLAS core %s\n\n", bench_processor(), thrum_build_compiler(),
         thrum_build_blas_core());

  // one line for each way
  printf("                               minimum    median [us]\n");
  printf("  dgemv, double              %9.1f %9.1f\n", bench->dgemv.minimum, bench->dgemv.median);
  printf("  the same, U by columns     %9.1f %9.1f\n", bench->dgemv_columns.minimum,
         bench->dgemv_columns.median);
  printf("  thrum_displacement, double %9.1f %9.1f\n", bench->plain.minimum, bench->plain.median);
  printf("  surface, single            %9.1f %9.1f\n", bench->surface.minimum,
         bench->surface.median);
  printf("  its normals                %9.1f %9.1f\n\n", bench->normals.minimum,
         bench->normals.median);

  printf("  surface over dgemv         %9.3f %9.3f\n", bench->ratio, bench->ratio_median);
  printf("  over the one by columns    %9.3f\n", bench->ratio_columns);
  printf("  surface reads U at         %9.2f GB/s\n",
         bench->bytes_surface / bench->surface.minimum * 1e-3);
  printf("  largest difference         %9.1e of the largest displacement\n", bench->difference);
}

int bench_displacement_command(int argc, char **argv) {
  request asked = {.bench = {.vertices = 19796, .rank = 30, .repetitions = 200}};
  CONFIG_TRY(config_options_read(&command_bench_displacement, argc, argv, &asked));
  if (optind < argc)
    return config_usage("bench displacement", "'%s' is not expected", argv[optind]);
  thrum_error error = {.status = THRUM_OK};
  if (bench_displacement_run(&asked.bench, &error) < 0)
    return config_refuse(&error);
  (asked.json ? print_json : print_table)(&asked.bench);
  return COMMAND_DONE;
}
