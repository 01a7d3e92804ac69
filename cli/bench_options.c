/* Options of `thrum bench step` and `thrum bench kernels`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "cli/bench_speed.h"

enum {
  RANK = 256,
  INTEGRATOR,
  KERNEL,
  IMPLICIT,
  DT,
  SWING,
  BATCHES,
  STEPS,
  BODIES,
  NO_MACHINE,
  JSON
};

static const struct option options[] = {
    {"rank", required_argument, NULL, RANK},
    {"integrator", required_argument, NULL, INTEGRATOR},
    {"kernel", required_argument, NULL, KERNEL},
    {"implicit", required_argument, NULL, IMPLICIT},
    {"dt", required_argument, NULL, DT},
    {"swing", required_argument, NULL, SWING},
    {"batches", required_argument, NULL, BATCHES},
    {"steps", required_argument, NULL, STEPS},
    {"bodies", required_argument, NULL, BODIES},
    {"no-machine", no_argument, NULL, NO_MACHINE},
    {"output", required_argument, NULL, 'o'},
    {"json", no_argument, NULL, JSON},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static void help(const char *command) {
  const bool batch = strcmp(command, "bench batch") == 0;
  const bool step = batch || strcmp(command, "bench step") == 0;
  printf("usage: thrum %s [MODEL] [OPTIONS]\n\n", command);
  fputs(
      batch
          ? "Microseconds of the processor for a step of one of many bodies that swing, one by one "
            "and\ntogether, on one core, both ways in turns.\n\n"
      : step ? "Microseconds of a step of a body that swings, on one core. Every batch of steps "
               "begins at\nthe same snapshot.\n\n"
             : "Microseconds of each pass over the coefficients, on one core.\n\n",
      stdout);
  fputs("MODEL is a model file; without one the body is beam:20x3x3@1x0.15x0.15, held at one end, "
        "at\neach rank.\n\n"
        "      --rank R,R,...     ranks of the beam (default 5,10,15,20,30,45,60)\n"
        "      --kernel NAME      reference, avx2, avx512, neon, wasm or best (default)\n",
        stdout);
  if (batch)
    fputs("      --bodies N         how many (default 300)\n", stdout);
  if (step) {
    fputs("      --integrator NAME  imexv (default), newmark, verlet, midpoint or energy\n"
          "      --dt S             time step [s] (default 0.003)\n"
          "      --implicit N       choose the time step so that exactly N modes are implicit\n"
          "      --swing METRES     amplitude of the first mode (default 0.4)\n"
          "      --steps N          steps of a batch (default: about 5 ms of them)\n",
          stdout);
  } else {
    fputs("      --implicit N       |I| of the passes over V at held q_E (default 3)\n", stdout);
  }
  printf("      --batches N        batches (default 40)\n"
         "      --no-machine       do not measure the machine's own rates\n"
         "  -o, --output FOLDER    also write %s.csv and a plot into the folder\n"
         "      --json             print one JSON object instead of the table\n"
         "  -q, --quiet            no progress\n"
         "  -h, --help             this text\n\n"
         "examples:\n"
         "  thrum %s --rank 30%s\n"
         "  thrum %s --rank 15,30,60 --kernel avx2 --json\n\n"
         "exit codes: 0 done, 1 refused, 2 usage\n",
         command + strlen("bench "), command, step ? " --implicit 3" : "", command);
}

static int wants(const bench_request *request, const char *option, const char *what,
                 const char *text) {
  return cli_usage(request->command, "--%s wants %s, not '%s'", option, what, text);
}

static int read_ranks(bench_request *request, const char *text) {
  static const char what[] = "ranks from 1 to 512, as in 15,30";
  char copy[256];
  if (strlen(text) >= sizeof copy)
    return wants(request, "rank", what, text);
  strcpy(copy, text);
  request->rank_count = 0;
  for (char *at = strtok(copy, ","); at; at = strtok(NULL, ",")) {
    int64_t rank;
    if (!cli_parse_integer(at, &rank) || rank < 1 || rank > THRUM_RANK_MAX ||
        request->rank_count == BENCH_RANKS_MAX)
      return wants(request, "rank", what, text);
    request->ranks[request->rank_count++] = rank;
  }
  return request->rank_count > 0 ? CLI_DONE : wants(request, "rank", what, text);
}

static int read_kernel(bench_request *request, const char *text) {
  for (int id = 0; thrum_kernel_name((thrum_kernel_id)id); id++) {
    if (strcmp(text, thrum_kernel_name((thrum_kernel_id)id)) != 0)
      continue;
    if (!thrum_kernel_usable((thrum_kernel_id)id))
      return cli_usage(request->command, "--kernel %s: this machine or build does not have it",
                       text);
    request->kernel = (thrum_kernel_id)id;
    return CLI_DONE;
  }
  return wants(request, "kernel", "reference, avx2, avx512, neon, wasm or best", text);
}

static int read_integrator(bench_request *request, const char *text) {
  static const char *const names[] = {"imexv", "newmark", "verlet", "midpoint", "energy"};
  for (int n = 0; n < 5; n++)
    if (strcmp(text, names[n]) == 0) {
      request->step.def.integrator = (thrum_integrator)n;
      return CLI_DONE;
    }
  return wants(request, "integrator", "imexv, newmark, verlet, midpoint or energy", text);
}

static int read_count(const bench_request *request, const char *option, const char *text,
                      int64_t least, int64_t *count) {
  int64_t value;
  if (!cli_parse_integer(text, &value) || value < least || value > 1000000)
    return wants(request, option, "a whole number", text);
  *count = value;
  return CLI_DONE;
}

static int read_number(const bench_request *request, const char *option, const char *text,
                       double *number) {
  double value;
  if (!cli_parse_number(text, &value) || !(value > 0))
    return wants(request, option, "a number above 0", text);
  *number = value;
  return CLI_DONE;
}

static int read_option(int option, const char *text, bench_request *request) {
  int64_t count = 0;
  int code = CLI_DONE;
  switch (option) {
  case RANK:
    return read_ranks(request, text);
  case INTEGRATOR:
    return read_integrator(request, text);
  case KERNEL:
    return read_kernel(request, text);
  case IMPLICIT:
    code = read_count(request, "implicit", text, 0, &count);
    request->step.implicit_wanted = (int)count;
    return code;
  case DT:
    return read_number(request, "dt", text, &request->step.def.dt);
  case SWING:
    return read_number(request, "swing", text, &request->step.swing);
  case BATCHES:
    return read_count(request, "batches", text, 1, &request->batches);
  case STEPS:
    return read_count(request, "steps", text, 1, &request->step.steps);
  case BODIES:
    return read_count(request, "bodies", text, 1, &request->bodies);
  case NO_MACHINE:
    request->machine = false;
    return code;
  case 'o':
    request->folder = text;
    return code;
  case JSON:
    request->json = true;
    return code;
  case 'q':
    request->quiet = true;
    return code;
  default:
    request->help = true;
    return code;
  }
}

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
  opterr = 0;
  optind = 1;
  bool ranks_given = false;
  for (int option; (option = getopt_long(argc, argv, ":o:qh", options, NULL)) != -1;) {
    if (option == '?' || option == ':')
      return cli_usage_option(command, argv, options);
    const int code = read_option(option, optarg, request);
    if (code != CLI_DONE)
      return code;
    ranks_given = ranks_given || option == RANK;
  }
  if (request->help) {
    help(command);
    return CLI_DONE;
  }
  if (optind + 1 < argc)
    return cli_usage(command, "one MODEL at most, not also '%s'", argv[optind + 1]);
  if (optind < argc)
    request->model_path = argv[optind];
  if (ranks_given && request->model_path)
    return cli_usage(command, "--rank is of the beam; a model file has its own rank");
  return CLI_DONE;
}
