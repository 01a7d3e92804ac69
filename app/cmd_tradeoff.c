/* `thrum tradeoff`: what speed costs in accuracy, and which setting to take. validation/tradeoff
 * measures; this file reads the request, prints the result and writes its files.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/cmd.h"
#include "app/results.h"
#include "app/tradeoff_commands.h"
#include "app/tradeoff_jobs.h"
#include "app/tradeoff_options.h"
#include "config/message.h"
#include "config/progress.h"
#include "core/base/pi.h"
#include "driver/make/named_model.h"
#include "driver/make/train_case.h"
#include "driver/model/model_cut.h"
#include "driver/model/model_meta.h"
#include "driver/spec/shared_options.h"
#include "io/folder.h"
#include "io/json.h"
#include "io/report.h"
#include "platform/allocate.h"
#include "platform/interrupt.h"

/* All of one call. */
typedef struct trade {
  const tradeoff_request *request;
  char *const *words;        /* of the command line, up to a NULL */
  const thrum_model *loaded; /* owned */
  const thrum_model *model;  /* the same, or its body of another law */
  thrum_model body;
  double *forces;
  thrum_load *courses;
  model_recipe recipe; /* of a model by name, with the texts of its tests */
  const char *test_texts[TRADEOFF_TESTS_MAX];
  char other[120]; /* a test of its own choosing */
  train_case test_cases[TRADEOFF_TESTS_MAX];
  full_motion_script tests[TRADEOFF_TESTS_MAX];
  int64_t mode_count; /* of the model's own basis; 0: not known */
  double mode_omega2[THRUM_RANK_MAX];
  tradeoff_problem problem;
  tradeoff_result result;
  int64_t chosen;
  tradeoff_commands commands;
  char wanted[160];
  config_progress progress;
  tradeoff_jobs jobs; /* that are collected; zeroed: none */
  cJSON *missing;     /* names of those that are not there; NULL: nothing is collected */
  load_spec own;      /* the default load of a model by name */
  char own_text[128];
} trade;

/* Says before it begins that a search may take long. */
static void announce(void *context, double seconds) {
  config_progress *progress = context;
  config_progress_end(progress, true);
  if (!progress->quiet)
    fprintf(stderr,
            "thrum: no setting so far does it; going on with bases trained on the load, of higher "
            "and higher rank, for up to about %.2g %s\n",
            seconds < 90 ? seconds : seconds / 60, seconds < 90 ? "s" : "minutes");
}

/* The recipe's load where none is given. */
static thrum_status default_load(trade *t, const load_spec **loads, int64_t *count,
                                 thrum_error *error) {
  const tradeoff_request *request = t->request;
  *loads = request->loads;
  *count = request->load_count;
  if (request->load_count > 0)
    return THRUM_OK;

  // a named model says in its recipe how to load it
  const model_recipe *recipe = &t->recipe;
  const double *d = recipe->load_direction, force = recipe->load_force;
  if (!recipe->found || !(force > 0))
    return thrum_error_set(error, THRUM_MISSING, "%.200s: name a load with --load",
                           request->model_path);

  snprintf(t->own_text, sizeof t->own_text, "square:%.6g,%.6g,%.6g@%.40s", force * d[0],
           force * d[1], force * d[2], recipe->load_group);
  *loads = &t->own;
  *count = 1;
  return load_spec_parse(t->own_text, &t->own, error);
}

static thrum_status fill_loads(trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  const load_spec *loads;
  int64_t count;
  THRUM_TRY(default_load(t, &loads, &count, error));
  if (t->model->tets == NULL || t->model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "%.200s: a model without a mesh and a basis has "
                           "no full order to be measured against",
                           t->request->model_path);

  const size_t components = 3 * (size_t)t->model->vertex_count;
  THRUM_TRY(thrum_reserve(&t->forces, count, components * sizeof *t->forces, "the loads", error));
  THRUM_TRY(thrum_reserve(&t->courses, count, sizeof *t->courses, "the loads", error));

  // reducing a load first gives an error that names --load and its target
  for (int64_t n = 0; n < count; n++) {
    double reduced[THRUM_RANK_MAX];
    THRUM_TRY(load_spec_reduce(t->model, &loads[n], reduced, error));
    THRUM_TRY(load_spec_fill(t->model, &loads[n], t->forces + (size_t)n * components, error));
    t->courses[n] = loads[n].course;
  }
  t->problem.script = (full_motion_script){.load_count = count,
                                           .courses = t->courses,
                                           .forces = t->forces,
                                           .damping_alpha = request->damping[0],
                                           .damping_beta = request->damping[1],
                                           .time = request->time};

  // they stand in the commands, too
  t->commands.loads = loads;
  t->commands.load_count = count;
  return THRUM_OK;
}

/* A load of another kind: weight aslant; where the load is a weight, the same from another side and
 * for a while. */
static void make_other(trade *t) {
  const load_spec *load = &t->commands.loads[0];
  if (t->commands.load_count > 0 && load->gravity)
    snprintf(t->other, sizeof t->other, "gravity:%.6g,%.6g,%.6g,until=%.6g", load->vector[2],
             load->vector[0], load->vector[1], t->request->time / 4);
  else
    snprintf(t->other, sizeof t->other, "gravity:5.66,5.66,-5.66");
}

/* The loads of the tests: those given, else those of the recipe, else one of another kind. */
static thrum_status fill_tests(trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  int64_t count = request->test_count;
  for (int64_t n = 0; n < count; n++)
    t->test_texts[n] = request->tests[n];
  // a recipe's tests go with its load, where there is time for them
  if (count == 0 && !request->no_tests && !request->quick && request->load_count == 0)
    for (; count < t->recipe.test_count; count++)
      t->test_texts[count] = t->recipe.tests[count];

  // a pick is worth less under what it was not chosen for, so it is always told how much
  if (count == 0 && !request->no_tests) {
    make_other(t);
    t->test_texts[count++] = t->other;
  }
  for (int64_t n = 0; n < count; n++) {
    train_case *c = &t->test_cases[n];
    THRUM_TRY(train_case_parse(t->test_texts[n], c, error));
    THRUM_TRY(train_case_fill(t->model, "test", c, error));
    t->tests[n] = train_case_script(c);
    t->tests[n].damping_alpha = request->damping[0];
    t->tests[n].damping_beta = request->damping[1];
    t->tests[n].time = request->time;
  }
  t->problem.tests = t->tests;
  t->problem.test_count = count;
  return THRUM_OK;
}

/* The linear modes that the model's own basis was made of, as its metadata has them. */
static void find_modes(trade *t) {
  cJSON *meta = model_meta_parse(t->model);
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, model_meta_find(meta, NULL, "frequencies_hz")) {
    if (!cJSON_IsNumber(item) || t->mode_count == THRUM_RANK_MAX)
      break;
    const double omega = THRUM_TWO_PI * item->valuedouble;
    t->mode_omega2[t->mode_count++] = omega * omega;
  }
  cJSON_Delete(meta);
  t->commands.own_modes = t->mode_count;

  // bases that are trained have as many, and half of the rank where that is not known
  t->problem.mode_count = t->mode_count;
  t->problem.mode_omega2 = t->mode_count > 0 ? t->mode_omega2 : NULL;
  t->problem.modes = t->mode_count > 0 ? t->mode_count : (t->model->rank + 1) / 2;
}

/* Adds a recipe that is not there yet. */
static void add_recipe(tradeoff_problem *p, const tradeoff_recipe *recipe) {
  for (int64_t n = 0; n < p->recipe_count; n++) {
    const tradeoff_recipe *other = &p->recipes[n];
    if (other->modes == recipe->modes && other->rank == recipe->rank &&
        other->single == recipe->single && other->cubature_error == recipe->cubature_error)
      return;
  }
  p->recipes[p->recipe_count++] = *recipe;
}

/* The bases of one rank: by polynomials in double and in single precision, and by points. Rank 0 is
 * the model's own basis as it is, or made anew with points where no polynomial is tried. */
static void add_rank(trade *t, int64_t rank) {
  tradeoff_problem *p = &t->problem;
  tradeoff_recipe basis = {.modes = (rank + 1) / 2, .rank = rank};
  const bool own = rank == 0, points = t->model->point_count > 0;
  if (own && t->model == t->loaded && (points || !p->points_alone)) {
    add_recipe(p, &basis);
    return;
  }

  // each polynomial by the precisions that were asked for
  for (int single = 0; single < 2 && !p->points_alone && !own; single++) {
    basis.single = single == 1;
    if (t->request->precisions[single])
      add_recipe(p, &basis);
  }

  // what the model's own basis was made of, or about so
  basis.single = false;
  if (own) {
    basis.modes = p->modes;
    basis.rank = t->model->rank;
  }
  tradeoff_recipe forms[TRADEOFF_POINTS_MAX];
  const int64_t count = tradeoff_points(p, &basis, forms);
  for (int64_t n = 0; n < count; n++)
    add_recipe(p, &forms[n]);
}

static void fill_problem(trade *t) {
  const tradeoff_request *request = t->request;
  tradeoff_problem *p = &t->problem;
  p->model = t->model;
  p->full_dt = request->full_dt;
  p->keep_runs = request->keep_runs;
  p->error = request->error;
  p->by_worse = request->by_worse;
  p->cost = request->budget * request->fps;
  p->rank_max = request->rank_max;
  p->condense = request->condense;

  // no polynomial holds another law
  p->points_alone =
      request->cubature == TRADEOFF_CUBATURE_ONLY || thrum_law_of_model(t->model) != THRUM_LAW_STVK;
  p->cubature_count = request->cubature_count;
  p->cubature_refine = request->cubature_refine;
  memcpy(p->cubature_errors, request->cubature_errors, sizeof p->cubature_errors);
  for (int64_t n = 0; n < request->rank_count; n++)
    add_rank(t, (int64_t)request->ranks[n]);

  p->dt_count = request->dt_count;
  memcpy(p->dts, request->dts, sizeof p->dts);
  p->tolerance_count = request->tolerance_count;
  memcpy(p->tolerances, request->tolerances, sizeof p->tolerances);
  memcpy(p->integrators, request->integrators, sizeof p->integrators);
  p->threads = (int)request->threads;
  p->progress = config_progress_show;
  p->search_begins = announce;
  p->progress_context = &t->progress;
}

/* The figures of the full order, which stand in the printed object and beside the table. */
static void add_full(cJSON *object, const trade *t) {
  json_number(object, "time_s", t->request->time);
  cJSON *full = cJSON_AddObjectToObject(object, "full");
  json_number(full, "components", (double)t->result.free_count);
  json_string(full, "law", thrum_law_name(thrum_law_of_model(t->model)));
  json_number(full, "dt", t->request->full_dt);
  json_number(full, "us_per_step", t->result.full_us_per_step);
  json_number(full, "cost_s_per_s", t->result.full_cost);
  json_number(full, "error", t->result.full_error);
  json_number(full, "mesh_error", t->result.mesh_error);
}

/* The object that begins with how it ended, and says which jobs it lacks. */
static cJSON *report(const trade *t) {
  const bool whole = cJSON_GetArraySize(t->missing) == 0;
  cJSON *object = json_report("tradeoff", !whole          ? "incomplete"
                                          : t->chosen < 0 ? "flagged"
                                                          : "done");
  if (!whole)
    cJSON_AddItemToObject(object, "missing_jobs", cJSON_Duplicate(t->missing, true));
  return object;
}

static thrum_status write_files(const trade *t, thrum_error *error) {
  const char *folder = t->request->output;
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(results_open(folder, "tradeoff.csv", &writer, error));
  tradeoff_csv(writer.stream, &t->result, t->problem.error, t->problem.cost);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  // the page also says what was wanted and which row of the table is recommended
  cJSON *about = report(t);
  results_add_machine(about);
  add_full(about, t);
  cJSON_AddStringToObject(about, "wanted", t->wanted);
  json_number(about, "recommended_row", t->chosen < 0 ? NAN : (double)t->chosen);

  // of what, under which loads, by which command
  json_string(about, "model", t->request->model_path);
  cJSON *loads = cJSON_AddArrayToObject(about, "loads");
  for (int64_t n = 0; n < t->commands.load_count; n++)
    cJSON_AddItemToArray(loads, cJSON_CreateString(t->commands.loads[n].text));
  cJSON *command = cJSON_AddArrayToObject(about, "command");
  cJSON_AddItemToArray(command, cJSON_CreateString(t->commands.program));
  for (int n = 0; t->words[n] != NULL; n++)
    cJSON_AddItemToArray(command, cJSON_CreateString(t->words[n]));
  THRUM_TRY(results_write_json(folder, "tradeoff.about.json", about, error));
  results_make_page(folder, "tradeoff", "tradeoff");
  if (t->chosen < 0)
    return THRUM_OK;

  return tradeoff_commands_write(&t->commands, folder, error);
}

static void add_errors(cJSON *object, const char *key, const tradeoff_errors *errors) {
  cJSON *item = cJSON_AddObjectToObject(object, key);
  json_number(item, "displacement", errors->displacement);
  json_number(item, "velocity", errors->velocity);
  json_number(item, "energy", errors->energy);
}

/* Cubature points in place of the polynomial; null: none. What an own basis was asked for is null.
 */
static void add_points(cJSON *object, const trade *t, const tradeoff_basis *basis) {
  if (basis->points == 0) {
    cJSON_AddNullToObject(object, "cubature");
    return;
  }
  const double wanted = basis->recipe.cubature_error;
  cJSON *item = cJSON_AddObjectToObject(object, "cubature");
  json_number(item, "points", (double)basis->points);
  json_number(item, "error_wanted", wanted > 0 ? wanted : NAN);
  json_number(item, "range", basis->cubature_range);
  json_number(item, "refine", wanted > 0 ? (double)t->request->cubature_refine : NAN);
  json_number(item, "force_error", basis->force_error);
}

static cJSON *run_json(const trade *t, const tradeoff_run *run) {
  const tradeoff_basis *basis = &t->result.bases[run->basis];
  cJSON *item = cJSON_CreateObject();
  const tradeoff_recipe *recipe = &basis->recipe;
  json_number(item, "modes", recipe->modes > 0 ? (double)recipe->modes : NAN);
  json_number(item, "rank", (double)basis->rank);
  cJSON_AddStringToObject(item, "precision", tradeoff_precision(basis));
  add_points(item, t, basis);
  cJSON_AddBoolToObject(item, "trained", recipe->trained);
  json_number(item, "masters", recipe->masters > 0 ? (double)recipe->masters : NAN);
  cJSON_AddStringToObject(item, "integrator", experiment_scheme_names[run->integrator]);
  json_number(item, "dt", run->dt);
  json_number(item, "tolerance", run->tolerance);
  cJSON_AddBoolToObject(item, "stable", run->stable);

  // the cost, then the errors: against the full order, of the basis alone, in time alone
  json_number(item, "us_per_step", run->us_per_step);
  json_number(item, "cost_s_per_s", run->cost);
  json_number(item, "times_faster_than_full", t->result.full_cost / run->cost);
  json_number(item, "error", run->error.displacement);
  add_errors(item, "errors", &run->error);
  add_errors(item, "basis_errors", &basis->error);
  json_number(item, "projection_error", basis->projection);
  cJSON_AddBoolToObject(item, "cancels", run->cancels);
  cJSON_AddBoolToObject(item, "disproved", run->disproved);
  json_string(item, "flag", tradeoff_flag(run));
  json_string(item, "barred", tradeoff_barred(&t->result, run, t->problem.error, t->problem.cost));
  json_number(item, "fallback_steps", (double)run->fallback_steps);
  add_errors(item, "time_errors", &run->time_error);
  json_number(item, "frequency_error", run->frequency_error);
  json_number(item, "frequency_mode", (double)run->frequency_mode + 1);
  json_number(item, "drift", run->drift);
  cJSON_AddBoolToObject(item, "front", run->front);
  return item;
}

/* The errors under the loads that nothing was trained on. */
static void add_tests(cJSON *object, const trade *t) {
  cJSON *tests = cJSON_AddArrayToObject(object, "tests");
  for (int64_t n = 0; n < t->problem.test_count; n++) {
    cJSON *item = json_add_row(tests);
    json_string(item, "load", t->test_texts[n]);
    json_string(item, "status",
                isfinite(t->result.test_error[n])          ? "done"
                : t->jobs.missed[t->jobs.recipe_count + n] ? "not run"
                                                           : "lost");
    json_number(item, "error", t->result.test_error[n]);
    json_number(item, "velocity_error", t->result.test_velocity[n]);
    json_number(item, "own_basis_error", t->result.test_own_error[n]);
    json_number(item, "own_basis_velocity_error", t->result.test_own_velocity[n]);
  }
}

static thrum_status print_json(const trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  thrum_status status = THRUM_OK;
  cJSON *object = report(t);
  json_string(object, "model", request->model_path);
  results_add_machine(object);
  json_string(object, "output", request->output);
  add_full(object, t);

  cJSON *runs = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < t->result.run_count; n++)
    cJSON_AddItemToArray(runs, run_json(t, &t->result.runs[n]));
  cJSON_AddStringToObject(object, "wanted", t->wanted);

  // null says that no setting does what was wanted
  if (t->chosen >= 0) {
    cJSON_AddItemToObject(object, "recommended", run_json(t, &t->result.runs[t->chosen]));
    add_tests(object, t);
    status = tradeoff_commands_add(&t->commands, object, error);
  } else {
    cJSON_AddNullToObject(object, "recommended");
  }
  if (status >= 0)
    json_print(object);
  else
    cJSON_Delete(object);
  return status;
}

/* What the table says behind a setting: that it is recommended, or why a cheaper one is not. */
static const char *note_of(const trade *t, const tradeoff_run *run) {
  const tradeoff_run *chosen = t->chosen < 0 ? NULL : &t->result.runs[t->chosen];
  const char *barred = tradeoff_barred(&t->result, run, t->problem.error, t->problem.cost);
  if (run == chosen)
    return "recommended";
  return barred != NULL && (chosen == NULL || run->cost < chosen->cost) ? barred : "";
}

/* The columns of a run, which are those of its JSON: the setting, its cost, its errors by their
 * sources. */
static const char run_head[] = "method        rank basis   coeff.      h [s]      tol.   us/step   "
                               "cost s/s   faster      error   "
                               "velocity   of basis    in time  frequency";
static const report_line run_lines[] = {
    REPORT_LINE("",
                "{integrator:-8s} {stepped:6s}{rank:3.0f} {basis:-7s} {energy:-8s} {dt:8.4g} "
                "{tolerance:9.0e} {us_per_step:9.2f|        -} {cost_s_per_s:10.2e|         -} "
                "{times_faster_than_full:8.0f|       -} {error:8.3g%|       - %} "
                "{errors.velocity:8.3g%|       - %} {basis_errors.displacement:8.3g%|       - %} "
                "{time_errors.displacement:8.3g%|       - %} "
                "{frequency_error:8.3g%|       - %}{note}"),
    {0},
};

static void print_run(const trade *t, const tradeoff_run *run, const char *note) {
  const tradeoff_basis *basis = &t->result.bases[run->basis];
  const tradeoff_recipe *recipe = &basis->recipe;
  cJSON *object = run_json(t, run), *more = cJSON_CreateObject();

  // a condensed basis steps some of its coordinates; points have no coefficients
  char text[80] = "";
  if (recipe->masters > 0)
    snprintf(text, sizeof text, "%d of ", (int)recipe->masters);
  json_string(more, "stepped", text);
  snprintf(text, sizeof text, "%s", recipe->single ? "single" : "double");
  if (basis->points > 0)
    snprintf(text, sizeof text, "%d pts", (int)basis->points);
  json_string(more, "energy", text);
  json_string(more, "basis", recipe->trained ? "trained" : recipe->modes == 0 ? "own" : "modes");
  snprintf(text, sizeof text, "%s%.70s", note[0] != 0 ? "  " : "", note);
  json_string(more, "note", text);
  report_end(object, more, 0, run_lines);
}

/* Prints the setting that comes nearest where none does what was asked for. */
static void print_nearest(const trade *t) {
  const tradeoff_run *nearest = NULL;
  for (int64_t n = 0; n < t->result.run_count; n++) {
    const tradeoff_run *run = &t->result.runs[n];
    if (run->stable && !run->disproved &&
        (nearest == NULL || tradeoff_judged(&run->error, t->problem.by_worse) <
                                tradeoff_judged(&nearest->error, t->problem.by_worse)))
      nearest = run;
  }

  // where no setting has come to its end there is no nearest one
  if (nearest == NULL) {
    puts("no setting that was tried came to its end");
    return;
  }
  printf("no setting that was tried; of least error is\n");
  print_run(t, nearest, "");
  if (t->problem.rank_max == 0)
    puts("bases trained on the load are tried without --ranks, or with --rank-max");
}

static const report_line test_lines[] = {
    REPORT_LINE("",
                "{load:-44s} {error:8.3g%|{status:10s}}[, velocity {velocity_error:.3g%}][, under "
                "a load that was "
                "in no training; own basis {own_basis_error:.3g%}, velocity "
                "{own_basis_velocity_error:.3g%}]",
                .each = "tests"),
    {0},
};
static const report_line full_lines[] = {
    REPORT_LINE(
        "full order",
        "{full.components:.0f} components of {full.law}, {ms:.3g} ms a step of {full.dt:g} "
        "s, {full.cost_s_per_s:.3g} s for a second; in time off by {full.error:.2g%|nan %}"),
    {0},
};

static void print_table(const trade *t) {
  cJSON *object = cJSON_CreateObject(), *more = cJSON_CreateObject();
  add_full(object, t);
  json_number(more, "ms", 1e-3 * t->result.full_us_per_step);
  report_end(object, more, REPORT_LABEL, full_lines);

  // a line for each run that no other beats in both cost and error, and for the one that is taken
  puts(run_head);
  for (int64_t n = 0; n < t->result.run_count; n++)
    if (t->result.runs[n].front || n == t->chosen)
      print_run(t, &t->result.runs[n], note_of(t, &t->result.runs[n]));

  // the setting that was picked among them
  printf("\nrecommended for %s:\n", t->wanted);
  if (t->chosen < 0) {
    print_nearest(t);
    return;
  }
  const tradeoff_run *chosen = &t->result.runs[t->chosen];
  const double basis = tradeoff_judged(&t->result.bases[chosen->basis].error, t->problem.by_worse);
  print_run(t, chosen, "");

  // two errors that cancel here need not do so elsewhere
  if (chosen->cancels)
    printf("its error is below that of its basis, %.3g %%: the errors of basis and time step "
           "cancel in part under this load, and need not under another\n",
           100 * basis);
  if (tradeoff_flag(chosen) != NULL)
    printf("thrum simulate flags its run as %s%s; no setting that does what was asked is not "
           "flagged\n",
           tradeoff_flag(chosen), chosen->grew ? "" : ": steps needed more than their own scheme");
  cJSON *tests = cJSON_CreateObject();
  add_tests(tests, t);
  report_end(tests, NULL, 0, test_lines);
  tradeoff_commands_print(&t->commands);
}

/* Warns where the chosen setting has a mode of the load's band at another pitch than was asked. */
static void warn_of_frequency(const trade *t) {
  if (t->chosen < 0 || isnan(t->request->error))
    return;
  const tradeoff_run *run = &t->result.runs[t->chosen];
  if (run->frequency_mode < 0 || !(run->frequency_error > t->request->error))
    return;
  config_warn("the load moves mode %d, which vibrates at %.4g Hz and is stepped at %.4g Hz, off by "
              "%.2g %%: a smaller time step has its pitch nearer (thrum info --dt)",
              (int)run->frequency_mode + 1, run->frequency, run->stepped_frequency,
              100 * run->frequency_error);
}

/* No error below that of the reference means anything, in time or of the mesh. */
static void warn_of_reference(const trade *t) {
  if (t->result.full_error > t->request->error)
    config_warn("the full order itself is off by about %.2g %% in time at steps of %g s, more than "
                "the error asked for: lower --full-dt",
                100 * t->result.full_error, t->request->full_dt);
  if (t->result.mesh_error > t->request->error)
    config_warn("the mesh itself is off by more than the error asked for: its linear tetrahedra "
                "have one of the first frequencies about %.2g %% too high, and errors here are "
                "against this mesh: make the model with --order 2",
                100 * t->result.mesh_error);
}

static void say_wanted(trade *t) {
  const tradeoff_request *request = t->request;
  char error[64] = "", budget[64] = "";
  if (!isnan(request->error))
    snprintf(error, sizeof error, "an error of %g %%%s", 100 * request->error,
             request->by_worse ? " in displacement and velocity" : "");
  if (!isnan(request->budget))
    snprintf(budget, sizeof budget, "%g ms a frame of %g a second", 1e3 * request->budget,
             request->fps);
  snprintf(t->wanted, sizeof t->wanted, "%s%s%s", error, error[0] && budget[0] ? " and " : "",
           budget);
}

/* The body is of the law that was asked for, whatever the model's own basis answers by. */
static thrum_status take_law(trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  const thrum_law own = thrum_law_of_model(t->loaded);
  const thrum_law law = law_of_run(request->law_given, request->law, t->loaded);
  t->model = t->loaded;
  if (law == THRUM_LAW_BY_REGION && thrum_law_has_yield(t->loaded))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s has a region that flows, and elastic bodies are compared: leave "
                           "its yield out, or take the whole body to one --law",
                           request->model_path);
  if (law != THRUM_LAW_STVK && request->cubature == TRADEOFF_CUBATURE_OFF)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%.200s is of %s material, which a polynomial cannot hold: leave out "
                           "--cubature off",
                           request->model_path,
                           law == THRUM_LAW_BY_REGION ? "several laws'" : thrum_law_name(law));
  if (law == own)
    return THRUM_OK;

  // a copy that borrows all arrays; its energy is not stepped
  t->body = model_of_law(t->loaded, law);
  t->model = &t->body;
  return THRUM_OK;
}

/* Sets up what is to be compared, from the request. */
static thrum_status prepare(trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  THRUM_TRY(folder_make_output(request->output, error));
  THRUM_TRY(mesh_model_load(request->model_path, &request->mesh_def, request->quiet, &t->loaded,
                            NULL, error));

  // bases are compared in all their coordinates
  THRUM_TRY(model_check_whole(t->loaded, request->model_path, "tradeoff",
                              "without --condense and --touch", error));
  THRUM_TRY(take_law(t, error));
  THRUM_TRY(model_recipe_find(request->model_path, &t->recipe, error));
  THRUM_TRY(fill_loads(t, error));
  THRUM_TRY(fill_tests(t, error));
  find_modes(t);
  fill_problem(t);
  say_wanted(t);
  t->progress = config_progress_make(request->quiet);
  return THRUM_OK;
}

/* The list of the jobs, or one of them. */
static thrum_status run_job(trade *t, char *const *argv, thrum_error *error) {
  const thrum_status status = tradeoff_jobs_run(t->request, &t->problem, argv, error);
  config_progress_end(&t->progress, status >= 0);
  return status;
}

static thrum_status run_trade(trade *t, thrum_error *error) {
  const tradeoff_request *request = t->request;
  if (request->jobs.collect)
    THRUM_TRY(tradeoff_jobs_open(request, &t->problem, &t->jobs, error));

  // minutes to hours, with the full order first
  const thrum_status status = tradeoff_solve(&t->problem, &t->result, error);
  config_progress_end(&t->progress, status >= 0);
  if (status < 0)
    return status;
  t->missing = tradeoff_jobs_missing(&t->jobs);
  if (t->result.dropped > 0)
    config_warn("%d of the ranks could not be made: %s", (int)t->result.dropped,
                t->result.dropped_reason.message);
  t->chosen = t->result.chosen;

  // how the setting is made and run again
  t->commands.request = request;
  t->commands.problem = &t->problem;
  t->commands.result = &t->result;

  // a checkout has ./run thrum
  const char *called = getenv("THRUM_COMMAND");
  t->commands.program = called != NULL && called[0] != 0 ? called : "thrum";
  warn_of_frequency(t);
  warn_of_reference(t);

  // the files first: what is printed is then the last word
  thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
  THRUM_TRY(write_files(t, error));
  if (request->json)
    return print_json(t, error);
  print_table(t);
  return THRUM_OK;
}

int cmd_tradeoff(int argc, char **argv) {
  tradeoff_request request = {0};
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);
  request.loads = thrum_scope_allocate(&scope, argc, sizeof *request.loads);
  request.tests = thrum_scope_allocate(&scope, argc, sizeof *request.tests);

  // flagged: it ran, but no setting does what was wanted
  int code = scope.status < 0 ? config_refuse(&error) : tradeoff_options_read(argc, argv, &request);
  if (code == COMMAND_DONE) {
    trade t = {.request = &request, .words = argv, .chosen = -1};
    if (request.keep_runs != NULL)
      thrum_interrupt_clean("\nthrum: stopped; nothing was written, and the same command goes on "
                            "with the runs that are kept\n");
    const bool one = request.jobs.list || request.jobs.number > 0;
    thrum_status status = prepare(&t, &error);
    THRUM_THEN(status, one ? run_job(&t, argv, &error) : run_trade(&t, &error));
    if (status < 0)
      folder_give_up(request.output);
    code = config_end(status, !one && (t.chosen < 0 || cJSON_GetArraySize(t.missing) > 0), &error);
    cJSON_Delete(t.missing);
    tradeoff_jobs_close(&t.jobs);
    tradeoff_free(&t.result);
    for (int64_t n = 0; n < TRADEOFF_TESTS_MAX; n++)
      train_case_free(&t.test_cases[n]);
    free(t.forces);
    free(t.courses);
    thrum_model_destroy(t.loaded);
  }

  thrum_scope_free(&scope);
  return code;
}
