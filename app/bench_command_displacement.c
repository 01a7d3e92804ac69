/* `thrum bench displacement`: options and output; the measurement is bench/measure_displacement.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "bench/measure.h"
#include "config/message.h"
#include "config/options.h"
#include "io/json.h"
#include "precompute/build_info.h"

#define WIDTH 29 /* of the name of a way */

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

static cJSON *report(const bench_displacement *bench) {
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
  json_number(object, "gb_per_s", 1e-3 * bench->bytes_surface / bench->surface.minimum);
  json_number(object, "difference", bench->difference);
  return object;
}

static const report_line head[] = {
    REPORT_LINE("", "u = U q of {vertices} vertices at rank {rank}, {repetitions} repetitions, one "
                    "thread"),
    REPORT_LINE("", "{processor}, {compiler}, OpenBLAS core {blas_core}"),
    REPORT_LINE("", ""),
    REPORT_LINE("", "                               minimum    median [[us]]"),
    {0},
};
static const report_line lines[] = {
// one line for each way
#define WAY(label, key) REPORT_LINE(label, "{" key ":9.1f} {" key "_median:9.1f}")
    WAY("  dgemv, double", "dgemv_us"),
    WAY("  the same, U by columns", "dgemv_columns_us"),
    WAY("  thrum_displacement, double", "double_us"),
    WAY("  surface, single", "surface_us"),
    WAY("  its normals", "normals_us"),
#undef WAY
    REPORT_LINE("  surface over dgemv", "{ratio:9.3f} {ratio_median:9.3f}"),
    REPORT_LINE("  over the one by columns", "{ratio_columns:9.3f}"),
    REPORT_LINE("  surface reads U at", "{gb_per_s:9.2f} GB/s"),
    REPORT_LINE("  largest difference", "{difference:9.1e} of the largest displacement"),
    {0},
};

int bench_displacement_command(int argc, char **argv) {
  request asked = {.bench = {.vertices = 19796, .rank = 30, .repetitions = 200}};
  CONFIG_TRY(config_options_read(&command_bench_displacement, argc, argv, &asked));
  if (optind < argc)
    return config_usage("bench displacement", "'%s' is not expected", argv[optind]);
  thrum_error error = {.status = THRUM_OK};
  if (bench_displacement_run(&asked.bench, &error) < 0)
    return config_refuse(&error);
  bench_report_end(report(&asked.bench), asked.json, head, WIDTH, lines);
  return COMMAND_DONE;
}
