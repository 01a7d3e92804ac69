/* Options of `thrum experiments`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/message.h"
#include "config/options.h"
#include "config/parse.h"
#include "validation/experiments/sweep.h"

#define THREADS_MAX 256
#define STEPS_MAX 1e10

static void print_help(void) {
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
      "      --extremes        instead: bodies, loads and steps far outside the usual, and one "
      "body "
      "in\n"
      "                        other units; 2000 steps each\n"
      "      --linear          instead: how far the six models may be bent, at rest and in "
      "motion,\n"
      "                        before linear modal analysis is wrong by 5 and by 20 %, and what\n"
      "                        the nonlinear terms cost\n"
      "  -o, --output DIR      the folder; made when it is not there\n"
      "      --models LIST     names or model files (default: the six; of the others, two)\n"
      "      --loads LIST      of impulse, square, sine\n"
      "      --integrators LIST  of imexv, newmark, energy\n"
      "      --amplitudes LIST --long: swings, as shares of the length (default 0.05,0.1,0.2);\n"
      "                        --sweep: one (default 0.05)\n"
      "      --subjects LIST   --extremes: of stiffness, poisson, size, density, load, snap, tet,\n"
      "                        square, rank, resonance, rate\n"
      "      --time S          to simulate [s] (default 30)\n"
      "      --dt S            time step [s] (default 0.003)\n"
      "      --steps N         --long, --extremes: number of steps (default 3000000, 2000)\n"
      "      --threads N       (default 1)\n"
      "      --json            print one JSON object instead of the table\n"
      "  -q, --quiet           no progress\n"
      "  -h, --help            this text\n\n"
      "examples:\n"
      "  thrum experiments -o results --threads 4\n"
      "  thrum experiments -o quick --models beam --loads sine --time 3 --json\n"
      "  thrum experiments --long -o long --models beam --steps 100000\n"
      "  thrum experiments --sweep -o sweep --integrators imexv,energy\n"
      "  thrum experiments --extremes -o extremes --subjects load,snap\n"
      "  thrum experiments --linear -o linear --models beam,horse\n\n"
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
static int take_names(const config_given *given, const char *const *known, int count, bool *flags) {
  const char *names[16];
  char *list = malloc(strlen(given->text) + 1);
  if (list == NULL)
    return config_given_refuse(given, "out of memory");
  memcpy(list, given->text, strlen(given->text) + 1);
  int code = COMMAND_DONE;
  const int64_t taken = cut(list, names, 16);
  if (taken < 0)
    code = config_given_wrong(given);
  memset(flags, 0, (size_t)count * sizeof *flags);
  for (int64_t n = 0; n < taken && code == COMMAND_DONE; n++) {
    int index = 0;
    while (index < count && strcmp(names[n], known[index]) != 0)
      index++;
    if (index == count)
      code = config_given_refuse(given, "--%s: there is no '%s'", given->option->name, names[n]);
    else
      flags[index] = true;
  }
  free(list);
  return code;
}

static int take_loads(const config_given *given, void *request) {
  return take_names(given, experiment_load_names, EXPERIMENT_LOAD_COUNT,
                    ((experiments_request *)request)->loads);
}

static int take_integrators(const config_given *given, void *request) {
  return take_names(given, experiment_integrator_names, EXPERIMENT_INTEGRATOR_COUNT,
                    ((experiments_request *)request)->integrators);
}

static int take_subjects(const config_given *given, void *request) {
  return take_names(given, experiment_subject_names, EXPERIMENT_SUBJECT_COUNT,
                    ((experiments_request *)request)->subjects);
}

static int take_models(const config_given *given, void *request) {
  experiments_request *r = request;
  free(r->list);
  r->list = malloc(strlen(given->text) + 1);
  if (r->list == NULL)
    return config_given_refuse(given, "out of memory");
  memcpy(r->list, given->text, strlen(given->text) + 1);
  r->model_count = cut(r->list, r->models, EXPERIMENTS_MODELS_MAX);
  if (r->model_count < 0)
    return config_given_refuse(given,
                               "--models wants at most %d names with commas between, not '%s'",
                               EXPERIMENTS_MODELS_MAX, given->text);
  return COMMAND_DONE;
}

static int take_amplitudes(const config_given *given, void *request) {
  experiments_request *r = request;
  const char *names[EXPERIMENTS_AMPLITUDES_MAX];
  char list[512];
  snprintf(list, sizeof list, "%s", given->text);
  int64_t count =
      strlen(given->text) < sizeof list ? cut(list, names, EXPERIMENTS_AMPLITUDES_MAX) : -1;
  for (int64_t n = 0; n < count; n++) {
    double *amplitude = &r->amplitudes[n];
    if (!config_parse_number(names[n], amplitude) || !(*amplitude > 0) || !(*amplitude <= 1))
      count = -1;
  }
  if (count < 0)
    return config_given_wrong(given);
  r->amplitude_count = count;
  return COMMAND_DONE;
}

static int take_long(const config_given *given, void *request) {
  (void)given;
  ((experiments_request *)request)->kind = EXPERIMENTS_LONG;
  return COMMAND_DONE;
}

static int take_sweep(const config_given *given, void *request) {
  (void)given;
  ((experiments_request *)request)->kind = EXPERIMENTS_SWEEP;
  return COMMAND_DONE;
}

static int take_extremes(const config_given *given, void *request) {
  (void)given;
  ((experiments_request *)request)->kind = EXPERIMENTS_EXTREMES;
  return COMMAND_DONE;
}

static int take_linear(const config_given *given, void *request) {
  (void)given;
  ((experiments_request *)request)->kind = EXPERIMENTS_LINEAR;
  return COMMAND_DONE;
}

#define FIELD(member) .field = offsetof(experiments_request, member)
#define LIST .kind = CONFIG_TEXT, .wants = "names with commas between"
#define SECONDS .kind = CONFIG_NUMBER, .most = INFINITY, .above = true, .wants = "seconds above 0"

static const config_option table[] = {
    {.name = "output", .letter = 'o', .kind = CONFIG_TEXT, FIELD(output)},
    {.name = "long", .kind = CONFIG_FLAG, .take = take_long},
    {.name = "sweep", .kind = CONFIG_FLAG, .take = take_sweep},
    {.name = "extremes", .kind = CONFIG_FLAG, .take = take_extremes},
    {.name = "linear", .kind = CONFIG_FLAG, .take = take_linear},
    {.name = "subjects", LIST, .take = take_subjects},
    {.name = "models", LIST, .take = take_models},
    {.name = "loads", LIST, .take = take_loads},
    {.name = "integrators", LIST, .take = take_integrators},
    {.name = "amplitudes",
     .kind = CONFIG_TEXT,
     .take = take_amplitudes,
     .wants = "shares of the length in (0, 1]"},
    {.name = "time", SECONDS, FIELD(time)},
    {.name = "dt", SECONDS, FIELD(dt)},
    {.name = "steps", .kind = CONFIG_COUNT, FIELD(steps), .least = 1, .most = STEPS_MAX},
    {.name = "threads", .kind = CONFIG_COUNT, FIELD(threads), .least = 1, .most = THREADS_MAX},
    {.name = "resume", .kind = CONFIG_FLAG, FIELD(resume)},
    CONFIG_OPTION_JSON(experiments_request),
    CONFIG_OPTION_QUIET(experiments_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

/* What depends on the kind of experiment, and what cannot be seen option by option. */
static int finish(int argc, char **argv, experiments_request *request) {
  static const char *const pair[] = {"horse", "beam"};
  static const double swings[] = {0.05, 0.1, 0.2};
  if (optind < argc)
    return config_usage("experiments", "'%s' is too much; name models with --models", argv[optind]);
  if (request->output == NULL || request->output[0] == 0)
    return config_usage("experiments", "where to? name a folder with -o DIR");
  if (request->model_count > 0 && request->kind == EXPERIMENTS_EXTREMES)
    return config_usage("experiments", "--extremes has bodies of its own; leave --models out");
  if (request->model_count == 0 &&
      (request->kind == EXPERIMENTS_MATRIX || request->kind == EXPERIMENTS_LINEAR)) {
    for (int n = 0; n < CLI_MODEL_COUNT; n++)
      request->models[request->model_count++] = cli_model_names[n];
  } else if (request->model_count == 0 && request->kind != EXPERIMENTS_EXTREMES) {
    for (int n = 0; n < 2; n++)
      request->models[request->model_count++] = pair[n];
  }
  if (request->amplitude_count == 0) {
    request->amplitude_count = request->kind == EXPERIMENTS_SWEEP ? 1 : 3;
    memcpy(request->amplitudes, swings, sizeof swings);
  }
  if (request->steps == 0)
    request->steps = request->kind == EXPERIMENTS_EXTREMES ? 2000 : 3000000;
  if (request->kind == EXPERIMENTS_MATRIX || request->kind == EXPERIMENTS_SWEEP) {
    const double dt = request->kind == EXPERIMENTS_SWEEP ? EXPERIMENT_SWEEP_SHORTEST : request->dt;
    const int64_t steps = thrum_step_count(request->time, dt);
    if (steps > (int64_t)STEPS_MAX)
      return config_usage("experiments", "--time %g at a time step of %g is too many steps",
                          request->time, dt);
    request->steps = steps < 1 ? 1 : steps;
  }
  return COMMAND_DONE;
}

int experiments_options_read(int argc, char **argv, experiments_request *request) {
  request->time = 30;
  request->dt = thrum_default_state_def().dt;
  request->threads = 1;
  for (int n = 0; n < EXPERIMENT_LOAD_COUNT; n++)
    request->loads[n] = true;
  for (int n = 0; n < EXPERIMENT_INTEGRATOR_COUNT; n++)
    request->integrators[n] = true;
  for (int n = 0; n < EXPERIMENT_SUBJECT_COUNT; n++)
    request->subjects[n] = true;
  const int code = config_options_read("experiments", table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  return finish(argc, argv, request);
}
