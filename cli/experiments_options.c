/* Options of `thrum experiments`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/experiments.h"

#define THREADS_MAX 256
#define STEPS_MAX 1e10

enum {
  LONG = 256,
  SWEEP,
  MODELS,
  LOADS,
  INTEGRATORS,
  AMPLITUDES,
  TIME,
  DT,
  STEPS,
  THREADS,
  RESUME,
  JSON
};

static const struct option options[] = {
    {"output", required_argument, NULL, 'o'},
    {"long", no_argument, NULL, LONG},
    {"sweep", no_argument, NULL, SWEEP},
    {"models", required_argument, NULL, MODELS},
    {"loads", required_argument, NULL, LOADS},
    {"integrators", required_argument, NULL, INTEGRATORS},
    {"amplitudes", required_argument, NULL, AMPLITUDES},
    {"time", required_argument, NULL, TIME},
    {"dt", required_argument, NULL, DT},
    {"steps", required_argument, NULL, STEPS},
    {"threads", required_argument, NULL, THREADS},
    {"resume", no_argument, NULL, RESUME},
    {"json", no_argument, NULL, JSON},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

void experiments_help(void) {
  fputs(
      "usage: thrum experiments -o DIR [OPTIONS]\n\n"
      "Runs the experiments of the thesis and writes tables (CSV) and a report (HTML) to DIR:\n"
      "six models x impulse, 0.3 s square load, 1 Hz sine x damping 0 and 0.3 /s x imexv, "
      "newmark,\n"
      "energy, 30 s each at 0.003 s. The forces are found first: a sine bends the loaded part by "
      "a\n"
      "tenth of the body's length at least, the other loads by a twentieth.\n\n"
      "      --long            instead: 3 million undamped steps after an impulse, horse and "
      "beam,\n"
      "                        and what becomes of the mean energy over windows of 35 s\n"
      "      --sweep           instead: 30 s after an impulse, beam and horse, at time steps from\n"
      "                        0.0001 to 0.05 s\n"
      "  -o, --output DIR      the folder; made when it is not there\n"
      "      --models LIST     names or model files (default: the six; of the others, two)\n"
      "      --loads LIST      of impulse, square, sine\n"
      "      --integrators LIST  of imexv, newmark, energy\n"
      "      --amplitudes LIST --long: swings, as shares of the length (default 0.05,0.1,0.2);\n"
      "                        --sweep: one (default 0.05)\n"
      "      --time S          to simulate [s] (default 30)\n"
      "      --dt S            time step [s] (default 0.003)\n"
      "      --steps N         --long: number of steps (default 3000000)\n"
      "      --threads N       (default 1)\n"
      "      --json            print one JSON object instead of the table\n"
      "  -q, --quiet           no progress\n"
      "  -h, --help            this text\n\n"
      "examples:\n"
      "  thrum experiments -o results --threads 4\n"
      "  thrum experiments -o quick --models beam --loads sine --time 3 --json\n"
      "  thrum experiments --long -o long --models beam --steps 100000\n"
      "  thrum experiments --sweep -o sweep --integrators imexv,energy\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 ran, but a run ended before its time\n",
      stdout);
}

/* Cuts a list at its commas, in place; -1 when it holds an empty or too many names. */
static int64_t cut(char *list, const char **names, int64_t most) {
  int64_t count = 0;
  for (char *at = list; at != NULL; count++) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma = 0;
    if (at[0] == 0 || count == most)
      return -1;
    names[count] = at;
    at = comma != NULL ? comma + 1 : NULL;
  }
  return count;
}

/* Marks the names of a list in `flags`; the known ones are `known`. */
static int flags_option(const char *option, const char *text, const char *const *known, int count,
                        bool *flags) {
  const char *names[16];
  char *list = malloc(strlen(text) + 1);
  if (list == NULL)
    return cli_usage("experiments", "out of memory");
  memcpy(list, text, strlen(text) + 1);
  int code = CLI_DONE;
  const int64_t given = cut(list, names, 16);
  if (given < 0)
    code = cli_usage("experiments", "--%s wants names with commas between, not '%s'", option, text);
  memset(flags, 0, (size_t)count * sizeof *flags);
  for (int64_t n = 0; n < given && code == CLI_DONE; n++) {
    int index = 0;
    while (index < count && strcmp(names[n], known[index]) != 0)
      index++;
    if (index == count)
      code = cli_usage("experiments", "--%s: there is no '%s'", option, names[n]);
    else
      flags[index] = true;
  }
  free(list);
  return code;
}

static int models_option(const char *text, experiments_request *request) {
  free(request->list);
  request->list = malloc(strlen(text) + 1);
  if (request->list == NULL)
    return cli_usage("experiments", "out of memory");
  memcpy(request->list, text, strlen(text) + 1);
  request->model_count = cut(request->list, request->models, EXPERIMENTS_MODELS_MAX);
  if (request->model_count < 0)
    return cli_usage("experiments", "--models wants at most %d names with commas between, not '%s'",
                     EXPERIMENTS_MODELS_MAX, text);
  return CLI_DONE;
}

static int amplitudes_option(const char *text, experiments_request *request) {
  const char *names[EXPERIMENTS_AMPLITUDES_MAX];
  char list[512];
  snprintf(list, sizeof list, "%s", text);
  int64_t count = strlen(text) < sizeof list ? cut(list, names, EXPERIMENTS_AMPLITUDES_MAX) : -1;
  for (int64_t n = 0; n < count; n++) {
    double *amplitude = &request->amplitudes[n];
    if (!cli_parse_number(names[n], amplitude) || !(*amplitude > 0) || !(*amplitude <= 1))
      count = -1;
  }
  if (count < 0)
    return cli_usage("experiments", "--amplitudes wants shares of the length in (0, 1], not '%s'",
                     text);
  request->amplitude_count = count;
  return CLI_DONE;
}

static int number_option(const char *name, const char *text, double *value) {
  if (cli_parse_number(text, value) && *value > 0)
    return CLI_DONE;
  return cli_usage("experiments", "--%s wants seconds above 0, not '%s'", name, text);
}

static int count_option(const char *name, const char *text, int64_t most, int64_t *value) {
  if (cli_parse_integer(text, value) && *value >= 1 && *value <= most)
    return CLI_DONE;
  return cli_usage("experiments", "--%s wants a whole number from 1 to %lld, not '%s'", name,
                   (long long)most, text);
}

/* One option that getopt_long recognised. */
static int apply_option(int option, experiments_request *request) {
  switch (option) {
  case 'o':
    request->output = optarg;
    return CLI_DONE;
  case LONG:
    request->kind = EXPERIMENTS_LONG;
    return CLI_DONE;
  case SWEEP:
    request->kind = EXPERIMENTS_SWEEP;
    return CLI_DONE;
  case MODELS:
    return models_option(optarg, request);
  case LOADS:
    return flags_option("loads", optarg, study_load_names, STUDY_LOAD_COUNT, request->loads);
  case INTEGRATORS:
    return flags_option("integrators", optarg, study_integrator_names, STUDY_INTEGRATOR_COUNT,
                        request->integrators);
  case AMPLITUDES:
    return amplitudes_option(optarg, request);
  case TIME:
    return number_option("time", optarg, &request->time);
  case DT:
    return number_option("dt", optarg, &request->dt);
  case STEPS:
    return count_option("steps", optarg, (int64_t)STEPS_MAX, &request->steps);
  case THREADS:
    return count_option("threads", optarg, THREADS_MAX, &request->threads);
  case RESUME:
    request->resume = true;
    return CLI_DONE;
  case JSON:
    request->json = true;
    return CLI_DONE;
  case 'q':
    request->quiet = true;
    return CLI_DONE;
  default:
    request->help = true;
    return CLI_DONE;
  }
}

/* What depends on the kind of experiment, and what cannot be seen option by option. */
static int finish(int argc, char **argv, experiments_request *request) {
  static const char *const pair[] = {"horse", "beam"};
  static const double swings[] = {0.05, 0.1, 0.2};
  if (optind < argc)
    return cli_usage("experiments", "'%s' is too much; name models with --models", argv[optind]);
  if (request->output == NULL || request->output[0] == 0)
    return cli_usage("experiments", "where to? name a folder with -o DIR");
  if (request->model_count == 0 && request->kind == EXPERIMENTS_MATRIX) {
    for (int n = 0; n < CLI_MODEL_COUNT; n++)
      request->models[request->model_count++] = cli_model_names[n];
  } else if (request->model_count == 0) {
    for (int n = 0; n < 2; n++)
      request->models[request->model_count++] = pair[n];
  }
  if (request->amplitude_count == 0) {
    request->amplitude_count = request->kind == EXPERIMENTS_SWEEP ? 1 : 3;
    memcpy(request->amplitudes, swings, sizeof swings);
  }
  if (request->kind != EXPERIMENTS_LONG) {
    // a time within a millionth of a step is a whole number of them, any other is rounded up
    const double dt = request->kind == EXPERIMENTS_SWEEP ? EXPERIMENTS_SHORTEST : request->dt;
    const double steps = ceil(request->time / dt - 1e-6);
    if (!(steps <= STEPS_MAX))
      return cli_usage("experiments", "--time %g at a time step of %g is too many steps",
                       request->time, dt);
    request->steps = steps < 1 ? 1 : (int64_t)steps;
  }
  return CLI_DONE;
}

int experiments_options_read(int argc, char **argv, experiments_request *request) {
  request->time = 30;
  request->dt = thrum_default_state_def().dt;
  request->steps = 3000000;
  request->threads = 1;
  for (int n = 0; n < STUDY_LOAD_COUNT; n++)
    request->loads[n] = true;
  for (int n = 0; n < STUDY_INTEGRATOR_COUNT; n++)
    request->integrators[n] = true;
  opterr = 0;
  optind = 1;
  for (int option = getopt_long(argc, argv, ":o:qh", options, NULL); option != -1;
       option = getopt_long(argc, argv, ":o:qh", options, NULL)) {
    if (option == '?' || option == ':')
      return cli_usage_option("experiments", argv, options);
    const int code = apply_option(option, request);
    if (code != CLI_DONE || request->help)
      return code;
  }
  return finish(argc, argv, request);
}
