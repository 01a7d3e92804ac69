/* `thrum bench displacement`: options and output; the measurement is bench/displacement.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdio.h>

#include "bench/bench.h"
#include "cli/bench.h"
#include "cli/cli.h"
#include "precompute/build_info.h"

static void print_help(void) {
  fputs("usage: thrum bench displacement [OPTIONS]\n\n"
        "Times u = U q of a body of random numbers: the single-precision surface that the library\n"
        "offers for display against OpenBLAS' double-precision product with the same U, both on\n"
        "one thread and taking turns; and the normals.\n\n"
        "      --vertices N      shown vertices (default 19796)\n"
        "      --rank R          reduced coordinates (default 30)\n"
        "      --repetitions N   samples (default 200)\n"
        "      --json            print one JSON object instead of the table\n"
        "  -h, --help            this text\n\n"
        "examples:\n"
        "  thrum bench displacement\n"
        "  thrum bench displacement --vertices 5000 --rank 60 --json\n",
        stdout);
}

static int read_count(const char *name, const char *text, int64_t low, int64_t high,
                      int64_t *value) {
  int64_t read = 0;
  if (!cli_parse_integer(text, &read) || read < low || read > high)
    return cli_usage("bench displacement", "--%s is a whole number from %lld to %lld, not '%s'",
                     name, (long long)low, (long long)high, text);
  *value = read;
  return CLI_DONE;
}

static int read_options(int argc, char **argv, bench_displacement *bench, bool *json, bool *help) {
  static const struct option options[] = {{"vertices", required_argument, NULL, 'v'},
                                          {"rank", required_argument, NULL, 'r'},
                                          {"repetitions", required_argument, NULL, 'n'},
                                          {"json", no_argument, NULL, 'j'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
  opterr = 0;
  optind = 0;
  int option, code = CLI_DONE;
  while (code == CLI_DONE && (option = getopt_long(argc, argv, ":h", options, NULL)) != -1) {
    if (option == 'v')
      code = read_count("vertices", optarg, 3, 10000000, &bench->vertices);
    else if (option == 'r')
      code = read_count("rank", optarg, 1, THRUM_RANK_MAX, &bench->rank);
    else if (option == 'n')
      code = read_count("repetitions", optarg, 1, 1000000, &bench->repetitions);
    else if (option == 'j')
      *json = true;
    else if (option == 'h')
      *help = true;
    else
      return cli_usage_option("bench displacement", argv, options);
  }
  if (code == CLI_DONE && optind < argc)
    return cli_usage("bench displacement", "'%s' is not expected", argv[optind]);
  return code;
}

static void print_json(const bench_displacement *bench) {
  cJSON *object = cJSON_CreateObject();
  cli_json_string(object, "processor", bench_processor());
  cli_json_string(object, "compiler", thrum_build_compiler());
  cli_json_string(object, "blas_core", thrum_build_blas_core());
  cli_json_number(object, "vertices", (double)bench->vertices);
  cli_json_number(object, "rank", (double)bench->rank);
  cli_json_number(object, "repetitions", (double)bench->repetitions);
  cli_json_number(object, "dgemv_us", bench->dgemv.minimum);
  cli_json_number(object, "dgemv_us_median", bench->dgemv.median);
  cli_json_number(object, "dgemv_columns_us", bench->dgemv_columns.minimum);
  cli_json_number(object, "dgemv_columns_us_median", bench->dgemv_columns.median);
  cli_json_number(object, "double_us", bench->plain.minimum);
  cli_json_number(object, "double_us_median", bench->plain.median);
  cli_json_number(object, "surface_us", bench->surface.minimum);
  cli_json_number(object, "surface_us_median", bench->surface.median);
  cli_json_number(object, "normals_us", bench->normals.minimum);
  cli_json_number(object, "normals_us_median", bench->normals.median);
  cli_json_number(object, "ratio", bench->ratio);
  cli_json_number(object, "ratio_columns", bench->ratio_columns);
  cli_json_number(object, "ratio_median", bench->ratio_median);
  cli_json_number(object, "bytes_per_us", bench->bytes_surface / bench->surface.minimum);
  cli_json_number(object, "difference", bench->difference);
  cli_json_print(object);
}

static void print_table(const bench_displacement *bench) {
  printf("u = U q of %lld vertices at rank %lld, %lld repetitions, one thread\n",
         (long long)bench->vertices, (long long)bench->rank, (long long)bench->repetitions);
  printf("%s, %s, OpenBLAS core %s\n\n", bench_processor(), thrum_build_compiler(),
         thrum_build_blas_core());
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
  bench_displacement bench = {.vertices = 19796, .rank = 30, .repetitions = 200};
  bool json = false, help = false;
  const int code = read_options(argc, argv, &bench, &json, &help);
  if (code != CLI_DONE)
    return code;
  if (help) {
    print_help();
    return CLI_DONE;
  }
  thrum_error error = {THRUM_OK, ""};
  if (bench_displacement_run(&bench, &error) < 0)
    return cli_refuse(&error);
  if (json)
    print_json(&bench);
  else
    print_table(&bench);
  return CLI_DONE;
}
