/* Options of `thrum experiments`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/message.h"
#include "driver/spec/shared_options.h"
#include "validation/experiments/sweep.h"

#define THREADS_MAX 256
#define STEPS_MAX 1e10

/* The names stay in a copy of the text, which is cut at its commas. */
static thrum_status take_models(const config_given *given, void *request) {
  experiments_request *r = request;
  free(r->list);
  r->list = strdup(given->text);
  if (r->list == NULL)
    return thrum_error_set(given->error, THRUM_OUT_OF_MEMORY, "out of memory");
  r->model_count = 0;

  // names between commas, none of them empty
  for (char *at = r->list; at != NULL;) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma++ = 0;
    if (at[0] == 0 || r->model_count == EXPERIMENTS_MODELS_MAX)
      return config_given_wrong(given);
    r->models[r->model_count++] = at;
    at = comma;
  }
  return THRUM_OK;
}

#define AT(member) CONFIG_AT(experiments_request, member)
#define COUNTED(member) .counted = offsetof(experiments_request, member)
#define NAMES(known, member) .names = known, .wants = "names with commas between", AT(member)
#define NAMED(symbol, name, ...) " " name
#define KIND(value) AT(kind), .set = EXPERIMENTS_##value

static const config_option options[] = {
    OPTION_HEADING("in place of the matrix"),
    OPTION_FLAG("long",
                "3 million undamped steps after an impulse, horse and beam, and what becomes of "
                "the mean energy over windows of 35 s",
                KIND(LONG)),
    OPTION_FLAG("sweep",
                "30 s after an impulse, beam and horse, at time steps from 0.0001 to 0.05 s",
                KIND(SWEEP)),
    OPTION_FLAG("step-sizes",
                "the matrix of the beam under the square load at 0.001, 0.005 and 0.01 s, with the "
                "first second step by step",
                KIND(STEP_SIZES)),
    OPTION_FLAG("work-precision",
                "error against processor time: the first second after two starts, the six models, "
                "the time steps of --sweep",
                KIND(WORK_PRECISION)),
    OPTION_FLAG("variable",
                "as --sweep, with steps that are drawn anew each time between a third of the "
                "longest and the longest, beside constant ones of the mean",
                KIND(VARIABLE)),
    OPTION_FLAG("extremes",
                "bodies, loads and steps far outside the usual, and one body in other units; 2000 "
                "steps each",
                KIND(EXTREMES)),
    OPTION_FLAG("linear",
                "how far the six models may be bent, at rest and in motion, before linear modal "
                "analysis is wrong by 5 and by 20 %, and what the nonlinear terms cost",
                KIND(LINEAR)),

    OPTION_HEADING("options"),
    OPTION_TEXT("output", "DIR", NULL, "the folder; made when it is not there", .letter = 'o',
                AT(output)),
    OPTION_TEXT("models", "LIST", "the six, or fewer", "names or model files", .take = take_models,
                .wants = "at most 32 names with commas between"),
    OPTION_TEXT("loads", "LIST", "all; of --step-sizes square", "of impulse, square, sine",
                NAMES(experiment_load_names, loads)),
    OPTION_TEXT("schemes", "LIST", "all", "of" EXPERIMENT_SCHEME_LIST(NAMED),
                NAMES(experiment_scheme_names, schemes)),
    OPTION_TEXT(
        "amplitudes", "LIST", "0.05,0.1,0.2; of the others 0.05",
        "--long: swings, as shares of the length; --sweep, --work-precision, --variable: one",
        AT(amplitudes), COUNTED(amplitude_count), CONFIG_RANGE(0, 1), .above = true,
        .wants = "shares of the length in (0, 1]"),
    OPTION_TEXT("subjects", "LIST", "all",
                "--extremes: of stiffness, poisson, size, density, load, snap, tet, square, rank, "
                "resonance, rate",
                NAMES(experiment_subject_names, subjects)),

    // the length of runs, and how they are spread over the machine
    OPTION_TIME(experiments_request, time, "30; of --work-precision 10"),
    OPTION_DT(experiments_request, dt),
    OPTION_COUNT("steps", "3000000; of --extremes 2000", "--long, --extremes: number of steps",
                 AT(steps), CONFIG_RANGE(1, STEPS_MAX)),
    OPTION_COUNT("threads", "1", "runs at a time", AT(threads), CONFIG_RANGE(1, THREADS_MAX)),

    // what concerns the folder and the screen
    OPTION_FLAG("resume", "take over the runs that the folder has already", AT(resume)),
    OPTION_JSON(experiments_request),
    OPTION_QUIET(experiments_request),
    OPTION_HELP,
    OPTION_GROUP(job_options, "in independent jobs", AT(jobs)),
    OPTION_END,
};

const config_command command_experiments = {
    .name = "experiments",
    .summary = "run the experiments of the 2011 thesis and report them",
    .usage = "-o DIR [OPTIONS]",
    .about =
        "Runs the experiments of the 2011 thesis and writes tables (CSV) and a report (HTML) to "
        "DIR: "
        "six models x impulse, 0.3 s square load, 1 Hz sine x damping 0 and 0.3 /s x all "
        "schemes, 30 s each at 0.003 s. The forces are found first: a sine bends the "
        "loaded part by a tenth of the body's length at least, the other loads by a twentieth.",
    .options = options,
    .examples = "experiments -o results --threads 4\n"
                "experiments -o quick --models beam --loads sine --time 3 --json\n"
                "experiments --long -o long --models beam --steps 100000\n"
                "experiments --sweep -o sweep --schemes imexv,energy\n"
                "experiments -o results --list-jobs\n"
                "experiments -o results --job 3\n"
                "experiments -o results --collect\n"
                "experiments --extremes -o extremes --subjects load,snap\n"
                "experiments --linear -o linear --models beam,horse",
    .exits = "0 done, 1 refused, 2 usage, 3 imexv or energy lost a run, or jobs are missing",
};

/* Checks the options together, and fills in the defaults that depend on the kind of experiment. */
static int finish(int argc, char **argv, experiments_request *request) {
  static const char *const pair[] = {"horse", "beam"};
  static const double swings[] = {0.05, 0.1, 0.2};
  if (optind < argc)
    return config_usage("experiments", "'%s' is too much; name models with --models", argv[optind]);

  // rows need a folder to go to, and a job resumes by itself
  if (request->resume && request->jobs.number > 0)
    return config_usage("experiments",
                        "--resume is not needed: a job whose result is there is done");

  if (request->output == NULL || request->output[0] == 0)
    return config_usage("experiments", "where to? name a folder with -o DIR");

  // each kind of experiment has models of its own
  if (request->model_count > 0 && request->kind == EXPERIMENTS_EXTREMES)
    return config_usage("experiments", "--extremes has bodies of its own; leave --models out");
  if (request->model_count == 0 &&
      (request->kind == EXPERIMENTS_MATRIX || request->kind == EXPERIMENTS_LINEAR ||
       request->kind == EXPERIMENTS_WORK_PRECISION))
    for (int n = 0; n < MODEL_NAME_COUNT; n++)
      request->models[request->model_count++] = model_names[n];
  else if (request->model_count == 0 && request->kind == EXPERIMENTS_STEP_SIZES)
    request->models[request->model_count++] = "beam";
  else if (request->model_count == 0 && request->kind != EXPERIMENTS_EXTREMES)
    for (int n = 0; n < 2; n++)
      request->models[request->model_count++] = pair[n];

  // without --loads all of them are applied, but one alone where step sizes are compared
  bool any = false;
  for (int n = 0; n < EXPERIMENT_LOAD_COUNT; n++)
    any = any || request->loads[n];
  for (int n = 0; n < EXPERIMENT_LOAD_COUNT && !any; n++)
    request->loads[n] = request->kind != EXPERIMENTS_STEP_SIZES || n == EXPERIMENT_LOAD_square;

  // each kind has its own time, swings and number of steps
  if (!(request->time > 0))
    request->time = request->kind == EXPERIMENTS_WORK_PRECISION ? 10 : 30;
  if (request->amplitude_count == 0) {
    request->amplitude_count = request->kind == EXPERIMENTS_LONG ? 3 : 1;
    memcpy(request->amplitudes, swings, sizeof swings);
  }
  if (request->steps == 0)
    request->steps = request->kind == EXPERIMENTS_EXTREMES ? 2000 : 3000000;

  // the sweep and what is made of it have starts and time steps of their own
  const bool of_variable = request->kind == EXPERIMENTS_VARIABLE;
  request->starts[EXPERIMENT_START_impulse] = true;
  request->starts[EXPERIMENT_START_smooth] = request->kind == EXPERIMENTS_WORK_PRECISION;
  request->dts = of_variable ? experiment_variable_dts : experiment_sweep_dts;
  request->dt_count = of_variable ? experiment_variable_dt_count : experiment_sweep_dt_count;

  // runs of too many steps are refused
  const double dt = request->kind == EXPERIMENTS_MATRIX ? request->dt : EXPERIMENT_SWEEP_TICK;
  if (thrum_step_count(request->time, dt) > (int64_t)STEPS_MAX)
    return config_usage("experiments", "--time %g at a time step of %g is too many steps",
                        request->time, dt);
  return job_request_check(&request->jobs, "experiments");
}

int experiments_options_read(int argc, char **argv, experiments_request *request) {
  request->dt = thrum_default_state_def().dt;
  request->threads = 1;
  for (int n = 0; n < EXPERIMENT_SCHEME_COUNT; n++)
    request->schemes[n] = true;
  for (int n = 0; n < EXPERIMENT_SUBJECT_COUNT; n++)
    request->subjects[n] = true;
  CONFIG_TRY(config_options_read(&command_experiments, argc, argv, request));
  return finish(argc, argv, request);
}
