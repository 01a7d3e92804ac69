/* Options of `thrum bench step`, `batch` and `kernels`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/bench_options.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/simulate_options.h"

/* They share a table, so that the help goes by the command. */
static int print_help(const config_given *given, void *request) {
  (void)request;
  const char *command = given->command;
  const bool batch = strcmp(command, "bench batch") == 0;
  const bool step = batch || strcmp(command, "bench step") == 0;
  printf("usage: thrum %s [MODEL] [OPTIONS]\n\n", command);
  fputs(
      batch
          ? "Microseconds of the processor for a step of one of many bodies that swing, one by one "
            "and\ntogether, on one core, both ways in turns.\n\n"
      : step ? "Microseconds of a step of a body that swings, on one core. Every batch of steps "
               "begins at\nthe same snapshot.\n\n"
             : "Microseconds of each pass over the coefficients, on one core:\n"
               "  V                the energy at q\n"
               "  R and V          the internal force and the energy\n"
               "  T                the tangent stiffness, rank x rank\n"
               "  T v              the tangent stiffness times a vector\n"
               "  V at held q_E    V with all but |I| modes held, a quartic in those\n"
               "  T_II             its tangent stiffness\n\n",
      stdout);
  printf("MODEL is a model file; without one the body is beam:20x3x3@1x0.15x0.15, held at one end, "
         "at\neach rank.\n\n"
         "      --rank R,R,...     ranks of the beam (default %s)\n"
         "      --kernel NAME      reference, avx2, avx512, neon, wasm or best (default)\n",
         batch ? "30" : "5,10,15,20,30,45,60");
  if (batch)
    fputs("      --bodies N         how many (default 300)\n", stdout);
  if (step) {
    fputs("      --integrator NAME  imexv (default), newmark, verlet, midpoint or energy\n"
          "      --dt S             time step [s] (default 0.003)\n"
          "      --implicit N       choose the time step so that exactly N modes are implicit for "
          "imexv\n"
          "                         (the others take the same step)\n"
          "      --swing METRES     amplitude of the first mode (default 0.4)\n"
          "      --steps N          steps of a batch (default: about 5 ms of them)\n",
          stdout);
  } else {
    fputs("      --implicit N       |I| of the last two passes (default 3)\n", stdout);
  }
  printf("      --batches N        batches (default %d)\n"
         "      --no-machine       do not measure the machine's own rates\n"
         "  -o, --output FOLDER    also write %s.csv and a plot into the folder\n"
         "      --json             print one JSON object instead of the table\n"
         "  -q, --quiet            no progress\n"
         "  -h, --help             this text\n\n"
         "examples:\n"
         "  thrum %s --rank 30%s\n"
         "  thrum %s --rank 15,30,60 --kernel avx2 --json\n\n"
         "exit codes: 0 done, 1 refused, 2 usage\n",
         batch ? 10 : 40, command + strlen("bench "), command, step ? " --implicit 3" : "",
         command);
  return COMMAND_HELPED;
}

static int take_ranks(const config_given *given, void *request) {
  bench_request *r = request;
  r->ranks_given = true;
  return config_given_counts(given, BENCH_RANKS_MAX, r->ranks, &r->rank_count);
}

static int take_kernel(const config_given *given, void *request) {
  for (int id = 0; thrum_kernel_name((thrum_kernel_id)id); id++) {
    if (strcmp(given->text, thrum_kernel_name((thrum_kernel_id)id)) != 0)
      continue;
    if (!thrum_kernel_usable((thrum_kernel_id)id))
      return config_given_refuse(given, "--kernel %s: this machine or build does not have it",
                                 given->text);
    ((bench_request *)request)->kernel = (thrum_kernel_id)id;
    return COMMAND_DONE;
  }
  return config_given_wrong(given);
}

static void choose_integrator(void *request, int index) {
  ((bench_request *)request)->step.def.integrator = (thrum_integrator)index;
}

static int take_implicit(const config_given *given, void *request) {
  int64_t count = 0;
  const int code = config_given_count(given, &count);
  if (code == COMMAND_DONE)
    ((bench_request *)request)->step.implicit_wanted = (int)count;
  return code;
}

static int take_no_machine(const config_given *given, void *request) {
  (void)given;
  ((bench_request *)request)->machine = false;
  return COMMAND_DONE;
}

#define FIELD(member) .field = offsetof(bench_request, member)
#define SOME .kind = CONFIG_COUNT, .least = 1, .most = 1e6
#define POSITIVE .kind = CONFIG_NUMBER, .most = INFINITY, .above = true

static const config_option table[] = {
    {.name = "rank",
     .kind = CONFIG_TEXT,
     .take = take_ranks,
     .least = 1,
     .most = THRUM_RANK_MAX,
     .wants = "ranks from 1 to 512, as in 15,30"},
    {.name = "integrator",
     .kind = CONFIG_CHOICE,
     .names = simulate_integrators,
     .choose = choose_integrator},
    {.name = "kernel",
     .kind = CONFIG_TEXT,
     .take = take_kernel,
     .wants = "reference, avx2, avx512, neon, wasm or best"},
    {.name = "implicit", .kind = CONFIG_COUNT, .take = take_implicit, .most = 1e6},
    {.name = "dt", POSITIVE, FIELD(step.def.dt)},
    {.name = "swing", POSITIVE, FIELD(step.swing)},
    {.name = "batches", SOME, FIELD(batches)},
    {.name = "steps", SOME, FIELD(step.steps)},
    {.name = "bodies", SOME, FIELD(bodies)},
    {.name = "no-machine", .kind = CONFIG_FLAG, .take = take_no_machine},
    {.name = "output", .letter = 'o', .kind = CONFIG_TEXT, FIELD(folder)},
    CONFIG_OPTION_JSON(bench_request),
    CONFIG_OPTION_QUIET(bench_request),
    {.name = "help", .letter = 'h', .kind = CONFIG_FLAG, .take = print_help},
    {.name = NULL},
};

int bench_options_read(const char *command, int argc, char **argv, bench_request *request) {
  static const int64_t usual[] = {5, 10, 15, 20, 30, 45, 60};
  *request = (bench_request){.command = command, .batches = 40, .machine = true};
  request->step.def = thrum_default_state_def();
  request->step.implicit_wanted = -1;
  request->step.swing = 0.4;
  request->bodies = 300;
  memcpy(request->ranks, usual, sizeof usual);
  request->rank_count = sizeof usual / sizeof usual[0];
  if (strcmp(command, "bench batch") == 0) {
    request->ranks[0] = 30;
    request->rank_count = 1;
    request->batches = 10;
  }
  const int code = config_options_read(command, table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  if (optind + 1 < argc)
    return config_usage(command, "one MODEL at most, not also '%s'", argv[optind + 1]);
  if (optind < argc)
    request->model_path = argv[optind];
  if (request->ranks_given && request->model_path)
    return config_usage(command, "--rank is of the beam; a model file has its own rank");
  if (request->step.implicit_wanted >= 0 && strcmp(command, "bench kernels") != 0 &&
      request->step.def.dt != thrum_default_state_def().dt)
    return config_usage(command, "--implicit chooses the time step; give it without --dt");
  return COMMAND_DONE;
}
