/* Options of `thrum tradeoff`. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "app/tradeoff_options.h"
#include "config/message.h"
#include "driver/make/train_case.h"
#include "driver/spec/shared_options.h"
#include "mesh/formats/mesh_read.h"

#define FPS_DEFAULT 60
#define ERROR_DEFAULT 0.05
#define RANK_MAX_DEFAULT 200

static thrum_status take_load(const config_given *given, void *request) {
  tradeoff_request *r = request;
  return load_option_take(given, r->loads, &r->load_count);
}

static thrum_status take_test(const config_given *given, void *request) {
  tradeoff_request *r = request;
  if (strcmp(given->text, "none") == 0) {
    r->no_tests = true;
    return THRUM_OK;
  }

  if (r->test_count == TRADEOFF_TESTS_MAX)
    return config_given_refuse(given, "given more than %d times", TRADEOFF_TESTS_MAX);
  return train_case_option_take(given, r->tests, &r->test_count);
}

static thrum_status take_ranks(const config_given *given, void *request) {
  tradeoff_request *r = request;
  THRUM_TRY(config_given_numbers(given, 1, TRADEOFF_LIST_MAX, r->ranks, &r->rank_count));
  for (int64_t n = 0; n < r->rank_count; n++)
    if (r->ranks[n] != floor(r->ranks[n]) || r->ranks[n] == 1)
      return config_given_wrong(given);
  return THRUM_OK;
}

static const char *const judges[] = {"displacement", "worse", NULL};
static const char *const precisions[] = {"double", "single"};
static const char *const cubatures[] = {"auto", "off", "only", NULL}; /* tradeoff_cubature */

static thrum_status take_error(const config_given *given, void *request) {
  return error_option_take(given, &((tradeoff_request *)request)->error);
}

static thrum_status take_budget(const config_given *given, void *request) {
  static const char *const endings[] = {"s", "ms", "us", NULL};
  static const double scales[] = {1, 1e-3, 1e-6};
  return scaled_option_take(given, endings, scales, &((tradeoff_request *)request)->budget);
}

#define AT(member) CONFIG_AT(tradeoff_request, member)
#define COUNTED(member) .counted = offsetof(tradeoff_request, member)

static const config_option options[] = {
    OPTION_TEXT("output", "DIR", NULL, "the folder; made when it is not there", .letter = 'o',
                AT(output)),
    OPTION_LOAD(take_load, "of beam, basket, bridge, horse, tower and heart there is one",
                "as of thrum simulate"),
    OPTION_WORD("error", "P%", "5%",
                "pick the cheapest setting whose displacement error against the full order is at "
                "most P per cent",
                .take = take_error, .wants = "an error such as 1%"),
    OPTION_CHOICE("judge-by", judges, "displacement",
                  "what --error is of: the displacement, or the worse of displacement and velocity",
                  AT(by_worse)),
    OPTION_WORD("budget", "T", NULL,
                "pick the most accurate one that takes at most T of processor time for a frame, "
                "such as 2ms or 500us",
                .take = take_budget, .wants = "a time with its unit, such as 2ms or 500us"),

    // what is asked, and for how long a motion
    OPTION_NUMBER("fps", "1/s", "60", "frames a second of --budget", AT(fps), CONFIG_ABOVE(0)),
    OPTION_TIME(tradeoff_request, time, "1; with --quick 0.5"),
    OPTION_FLAG(
        "quick",
        "a coarse answer in under a minute on a model of some thousand tetrahedra: shorter, fewer "
        "settings, and one test; a small error that takes ranks of 60 and more "
        "takes minutes",
        AT(quick)),
    OPTION_LAW("that of the model",
               ": of the full order, and of the models, which are those of cubature points then",
               AT(law), .given = offsetof(tradeoff_request, law_given)),
    OPTION_GROUP(mesh_options, "of a MESH", AT(mesh_def)),

    OPTION_TEXT("test", "CASE",
                "those of the model by name; of others, and with --quick, a load of another kind",
                "what no basis is trained on, as --test of precompute: the error of the setting "
                "that was picked is measured in it too; none: no such case",
                .repeats = true, .take = take_test),

    OPTION_HEADING("what is tried"),
    OPTION_TEXT("ranks", "LIST", "0,6,10,20,30; with --quick 0,10",
                "ranks, each of half as many modes; 0 is the model's own basis; given, only these "
                "are tried, and without --rank-max neither condensed nor trained bases",
                .take = take_ranks, CONFIG_RANGE(0, THRUM_RANK_MAX),
                .wants = "0 or ranks from 2 with commas between"),
    OPTION_COUNT("rank-max", "200",
                 "where none of these does what is wanted, bases trained on the load are tried, up "
                 "to this rank, beyond 100 with cubature points alone; 0: none",
                 AT(rank_max), CONFIG_RANGE(0, 200)),
    OPTION_TEXT("dts", "LIST",
                "0.001,0.002,0.003,0.005,0.01,0.016667; with --quick 0.003,0.01,0.016667",
                "time steps [s]", AT(dts), COUNTED(dt_count), CONFIG_RANGE(1e-6, 1),
                .wants = "time steps from 1e-6 to 1 s with commas between"),
    OPTION_TEXT("tolerances", "LIST", "1e-10,1e-6,1e-3; with --quick 1e-6",
                "of the implicit solves", AT(tolerances), COUNTED(tolerance_count),
                CONFIG_RANGE(1e-15, 0.01), .wants = "numbers in (0, 0.01] with commas between"),
    OPTION_TEXT("integrators", "LIST", "imexv,newmark,energy",
                "names of schemes, as those of thrum experiments", AT(integrators),
                .names = experiment_scheme_names,
                .wants = "imexv, newmark, energy with commas between"),
    OPTION_TEXT("precisions", "LIST", "double,single; with --quick double",
                "of the coefficients of the bases that are made", AT(precisions),
                .names = precisions, .wants = "double, single or double,single"),
    OPTION_CHOICE("cubature", cubatures, "auto",
                  "energies of the bases that are made: summed over cubature points too where that "
                  "may be cheaper than the polynomial, from rank 29 on; off: polynomials alone; "
                  "only: points alone",
                  AT(cubature)),
    OPTION_TEXT("cubature-errors", "LIST", "0.01,0.003",
                "relative errors of the force at which there are enough points, as "
                "--cubature-error of precompute; their range is how far the load moves the body",
                AT(cubature_errors), COUNTED(cubature_count), CONFIG_RANGE(1e-6, 1),
                .wants = "up to 4 numbers from 1e-6 to 1 with commas between"),
    OPTION_COUNT("cubature-refine", "0",
                 "steps in which the gradients of these points are learned, as --cubature-refine "
                 "of precompute: fewer points have the same error, and each model takes longer to "
                 "make",
                 AT(cubature_refine), CONFIG_RANGE(0, 1000000)),
    OPTION_DAMPING(AT(damping)),
    OPTION_NUMBER("full-dt", "s", "0.001; with --quick 0.002", "time step of the full order",
                  AT(full_dt), CONFIG_ABOVE(0)),

    OPTION_HEADING("the work"),
    OPTION_TEXT("keep-runs", "DIR", "none",
                "keep full-order runs in this folder, and take those that are there already",
                .path = CONFIG_PATH_ALWAYS, AT(keep_runs)),
    OPTION_COUNT("threads", "1", "runs at a time", AT(threads), CONFIG_RANGE(1, 256)),
    OPTION_JSON(tradeoff_request),
    OPTION_QUIET(tradeoff_request),
    OPTION_HELP_TWICE,
    OPTION_GROUP(job_options, "in independent jobs", AT(jobs)),
    OPTION_END,
};

const config_command command_tradeoff = {
    .name = "tradeoff",
    .summary = "say what speed costs in accuracy, and pick a setting",
    .usage = "MODEL|MESH -o DIR --load LOAD [--error P%|--budget T] [OPTIONS]",
    .about =
        "Steps a load with the full-order body of the model's mesh and with reduced models over "
        "rank, precision, integrator, time step and tolerance, by polynomials and, at higher "
        "ranks, by cubature points; says what each costs and how far it is off; and picks a "
        "setting. Where none is accurate enough, it goes on with bases that are trained on the "
        "load. It prints the commands that make the model and run it. "
        "Writes to DIR: tradeoff.html, tradeoff.csv, commands.sh, and the setting as options "
        "files that thrum precompute and thrum simulate take.",
    .options = options,
    .often = "output load error budget time quick",
    .examples =
        "tradeoff beam -o trade --error 5% --quick\n"
        "tradeoff bridge -o trade --list-jobs\n"
        "tradeoff bridge -o trade --collect\n"
        "tradeoff beam.npz -o trade --load 'square:0,0,-40@tip' --budget 500us --threads 4\n"
        "tradeoff beam:12x3x3@1x0.1x0.1 -o trade --fix 'x<0.001' --load square:0,0,-9@tip\n"
        "tradeoff beam -o trade --law neo-hookean --quick\n"
        "simulate trade/model.npz -o swing --options trade/simulate.json --load "
        "square:0,0,-33@load",
    .exits = "0 done, 1 refused, 2 usage, 3 done, but no setting does what was asked, or jobs are "
             "missing",
};

static void default_list(const double *values, int64_t count, double *list, int64_t *list_count) {
  if (*list_count > 0)
    return;
  memcpy(list, values, (size_t)count * sizeof *values);
  *list_count = count;
}

/* Checks the options of cubature points, and fills in their errors. Returns COMMAND_DONE, or the
 * exit code of a refusal. */
static int read_cubature(tradeoff_request *r) {
  static const double errors[] = {0.01, 0.003};
  if (r->cubature == TRADEOFF_CUBATURE_OFF && (r->cubature_count > 0 || r->cubature_refine > 0))
    return config_usage("tradeoff", "%s is of cubature points, which --cubature off leaves out",
                        r->cubature_count > 0 ? "--cubature-errors" : "--cubature-refine");
  if (r->cubature == TRADEOFF_CUBATURE_OFF && r->law_given && r->law != THRUM_LAW_STVK)
    return config_usage("tradeoff",
                        "--law %s needs cubature points, as a polynomial cannot hold "
                        "it: leave out --cubature off",
                        law_names[r->law]);
  if (r->cubature == TRADEOFF_CUBATURE_OFF)
    return COMMAND_DONE;
  default_list(errors, 2, r->cubature_errors, &r->cubature_count);

  // the fewest points first
  for (int64_t n = 1; n < r->cubature_count; n++)
    for (int64_t i = n; i > 0 && r->cubature_errors[i] > r->cubature_errors[i - 1]; i--) {
      const double larger = r->cubature_errors[i];
      r->cubature_errors[i] = r->cubature_errors[i - 1];
      r->cubature_errors[i - 1] = larger;
    }
  return COMMAND_DONE;
}

int tradeoff_options_read(int argc, char **argv, tradeoff_request *r) {
  static const double ranks[] = {0, 6, 10, 20, 30}, quick_ranks[] = {0, 10};
  static const double dts[] = {0.001, 0.002, 0.003, 0.005, 0.01, 1. / 60};
  static const double quick_dts[] = {0.003, 0.01, 1. / 60};
  static const double tolerances[] = {1e-10, 1e-6, 1e-3}, quick_tolerances[] = {1e-6};

  // defaults that zero does not stand for
  r->mesh_def = mesh_model_def_default();
  r->error = r->budget = NAN;
  r->fps = FPS_DEFAULT;
  r->threads = 1;
  r->rank_max = -1;
  r->integrators[EXPERIMENT_SCHEME_IMEXV] = true;
  r->integrators[EXPERIMENT_SCHEME_NEWMARK] = true;
  r->integrators[EXPERIMENT_SCHEME_ENERGY] = true;

  // the first wrong option ends the command with its own exit code
  CONFIG_TRY(config_options_read_one(&command_tradeoff, "model", argc, argv, r, &r->model_path));
  CONFIG_TRY(mesh_model_def_check("tradeoff", &r->mesh_def, thrum_mesh_is_named(r->model_path),
                                  r->law_given));
  CONFIG_TRY(read_cubature(r));

  // what no default can stand for, and what two options decide together
  if (r->output == NULL || r->output[0] == 0)
    return config_usage("tradeoff", "where to? name a folder with -o DIR");
  if (isnan(r->error) && isnan(r->budget))
    r->error = ERROR_DEFAULT;
  // a coarse answer needs no more than one
  if (!r->precisions[0] && !r->precisions[1]) {
    r->precisions[0] = true;
    r->precisions[1] = !r->quick;
  }

  // ranks that were asked for are all that is tried
  r->condense = r->rank_count == 0 || r->rank_max > 0;
  if (r->rank_max < 0)
    r->rank_max = r->rank_count > 0 ? 0 : RANK_MAX_DEFAULT;

  // the rest depends on --quick
  r->time = r->time > 0 ? r->time : r->quick ? 0.5 : 1;
  r->full_dt = r->full_dt > 0 ? r->full_dt : r->quick ? 0.002 : 0.001;
  default_list(r->quick ? quick_ranks : ranks, r->quick ? 2 : 5, r->ranks, &r->rank_count);
  default_list(r->quick ? quick_dts : dts, r->quick ? 3 : 6, r->dts, &r->dt_count);
  default_list(r->quick ? quick_tolerances : tolerances, r->quick ? 1 : 3, r->tolerances,
               &r->tolerance_count);
  return job_request_check(&r->jobs, "tradeoff");
}
