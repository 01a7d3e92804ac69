/* The results of `thrum precompute`: the table, the JSON line, and the JSON text that the model
 * keeps as meta.
 *
 * Meta holds no folders, and no times on request, so that the same mesh and options then give the
 * same file on any machine with the same build. SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "driver/make/model_coordinates.h"
#include "driver/make/precompute_report.h"
#include "driver/make/precompute_stages.h"
#include "driver/model/locking.h"
#include "driver/spec/elastic_report.h"
#include "io/json.h"
#include "io/paths.h"
#include "io/report.h"
#include "mesh/mesh_groups.h"
#include "mesh/model_quality.h"
#include "platform/clock.h"
#include "precompute/build_info.h"

static const char *mass_name(thrum_mass mass) {
  return mass == THRUM_MASS_LUMPED ? "lumped" : "consistent";
}

/* Adds frequencies [Hz] of squared angular frequencies. */
static void add_frequencies(cJSON *object, const char *key, const double *omega2, int64_t count) {
  cJSON *array = cJSON_AddArrayToObject(object, key);
  for (int64_t n = 0; n < count; n++) {
    double hertz;
    thrum_frequencies(omega2 + n, 1, &hertz);
    cJSON_AddItemToArray(array, json_number_item(hertz));
  }
}

static void add_hash(cJSON *object, const char *key, const thrum_mesh *mesh) {
  char text[17];
  snprintf(text, sizeof text, "%016" PRIx64, thrum_mesh_hash(mesh));
  cJSON_AddStringToObject(object, key, text);
}

static void add_units(cJSON *meta) {
  cJSON *units = cJSON_AddObjectToObject(meta, "units");
  cJSON_AddStringToObject(units, "length", "m");
  cJSON_AddStringToObject(units, "mass", "kg");
  cJSON_AddStringToObject(units, "time", "s");
}

static void add_materials(cJSON *meta, const thrum_mesh *mesh) {
  cJSON *materials = cJSON_AddArrayToObject(meta, "materials");
  for (int64_t m = 0; m < mesh->region_count; m++) {
    cJSON *material = json_add_row(materials);
    if (mesh->region_count > 1)
      json_string(material, "region", thrum_mesh_region_text(mesh, m).text);
    json_number(material, "young_pa", mesh->materials[m].young);
    json_number(material, "poisson", mesh->materials[m].poisson);
    json_number(material, "density_kg_m3", mesh->materials[m].density);
    elastic_json(material, mesh->elastic, mesh->elastic_count, m);
    if (mesh->laws)
      cJSON_AddStringToObject(material, "law", thrum_law_name(mesh->laws[m].law));
    if (mesh->laws && mesh->laws[m].yield > 0)
      json_number(material, "yield", mesh->laws[m].yield);
  }
}

static void add_options(cJSON *meta, const precompute_request *request,
                        const thrum_precomputed *result) {
  cJSON *options = cJSON_AddObjectToObject(meta, "options");

  // the counts are those of the result, which an import or the mesh may have lowered
  json_number(options, "modes", (double)result->mode_count);
  json_number(options, "rank", (double)result->model.rank);
  if (request->options.selection == THRUM_SELECTION_MASS)
    cJSON_AddStringToObject(options, "selection", "mass");
  cJSON_AddStringToObject(options, "mass", mass_name(request->options.mass));
  cJSON_AddStringToObject(options, "precision", request->options.single ? "single" : "double");
  if (result->quadrature_order > 0)
    json_number(options, "quadrature_order", result->quadrature_order);
  json_number(options, "scale", request->reading.scale);
  if (request->reading.unit)
    json_string(options, "unit", request->reading.unit);
  json_number(options, "threads", request->options.threads);

  // a predicate stays as it is, a file loses its folder
  cJSON *fixes = cJSON_AddArrayToObject(options, "fix");
  for (int64_t n = 0; n < request->fix_count; n++) {
    const char *spec = request->fixes[n];
    json_add_string(fixes, strpbrk(spec, "<>") != NULL ? spec : path_basename(spec));
  }
  if (request->spring_count > 0)
    json_strings(options, "spring", request->springs, request->spring_count);
  if (request->actuator_count > 0)
    json_strings(options, "actuator", request->actuators, request->actuator_count);
  json_strings(options, "handles", request->handles, request->handle_count);
}

static void add_residuals(cJSON *object, const thrum_precomputed *result) {
  cJSON *residuals = cJSON_AddObjectToObject(object, "residuals");
  json_numbers(residuals, "modes", result->mode_residual, result->mode_count);
  json_number(residuals, "orthonormality", result->basis_orthonormality);
  json_number(residuals, "diagonality", result->basis_diagonality);
  if (result->rigid_count > 0)
    json_number(residuals, "rigid", result->rigid_residual);
  if (result->single_error > 0)
    json_number(residuals, "single_precision", result->single_error);
}

/* Points in place of the polynomial, and what they leave out. */
static void add_cubature(cJSON *object, const precompute_request *request,
                         const thrum_precomputed *result) {
  const thrum_cubature_figures *figures = &result->cubature;
  if (!request->options.cubature)
    return;
  cJSON *cubature = cJSON_AddObjectToObject(object, "cubature");
  json_number(cubature, "points", (double)figures->points);
  json_number(cubature, "candidates", (double)figures->candidates);
  json_number(cubature, "states", (double)figures->states);
  json_number(cubature, "test_states", (double)figures->test_states);
  json_number(cubature, "range", request->options.cubature_range);
  json_number(cubature, "yield", request->options.cubature_yield);
  json_number(cubature, "error_wanted", request->options.cubature_error);
  json_number(cubature, "refine", (double)request->options.cubature_refine);
  if (request->options.cubature_refine > 0)
    json_number(cubature, "chosen_error", figures->chosen_error);
  json_number(cubature, "train_error", figures->train_error);
  json_number(cubature, "test_error", figures->test_error);
  json_number(cubature, "motion_error", figures->motion_error);
  json_number(cubature, "motion_error_beyond", figures->motion_error_beyond);
  if (request->options.law == THRUM_LAW_STVK)
    json_number(cubature, "force_cost", figures->force_cost);
  cJSON_AddStringToObject(cubature, "law", thrum_law_name(request->options.law));
}

/* Where the basis comes from, if not from modes of the body. */
static void add_import(cJSON *object, const precompute_request *request,
                       const thrum_precomputed *result) {
  if (!request->import_basis)
    return;
  const thrum_imported_figures *imported = &result->imported;
  const double missing = NAN;

  // meta names files without their folders
  cJSON *import = cJSON_AddObjectToObject(object, "import");
  json_string(import, "basis", path_basename(request->import_basis));
  if (request->import_cubic)
    json_string(import, "cubic", path_basename(request->import_cubic));
  cJSON_AddBoolToObject(import, "basis_changed", imported->changed);
  json_number(import, "orthonormality", imported->orthonormality);

  // the differences exist only where a polynomial came with the basis
  const bool cubic = request->import_cubic != NULL;
  json_number(import, "gradient_defect", cubic ? imported->defect : missing);
  json_number(import, "linear_difference", cubic ? imported->linear_difference : missing);
  json_number(import, "energy_difference", cubic ? imported->energy_difference : missing);
}

/* How it was made sure that no mode was missed, and what that showed. */
static void add_check(cJSON *object, const thrum_precomputed *result) {
  if (result->mode_count == 0)
    return;
  double next = 0, shift = 0;
  thrum_frequencies(&result->next_omega2, 1, &next);
  thrum_frequencies(&result->shift, 1, &shift);

  // below_shift is a count by inertia, which a search alone does not give
  cJSON *check = cJSON_AddObjectToObject(object, "mode_check");
  cJSON_AddStringToObject(check, "method", result->mode_counted ? "inertia" : "search");
  cJSON_AddBoolToObject(check, "complete", result->modes_complete);
  json_number(check, "recovered", (double)result->modes_recovered);
  json_number(check, "next_hz", next);
  json_number(check, "shift_hz", result->mode_counted ? shift : NAN);
  json_number(check, "below_shift", result->mode_counted ? (double)result->shift_count : NAN);
}

/* The errors under the loads of a training and of its test; nothing without one. */
static void add_training(cJSON *object, const train_outcome *training) {
  if (training->run_count == 0)
    return;
  cJSON *item = cJSON_AddObjectToObject(object, "training");
  json_number(item, "shapes", (double)training->field_count);
  json_number(item, "error", precompute_train_error(training, false));
  json_number(item, "test_error", precompute_train_error(training, true));
  cJSON *loads = cJSON_AddArrayToObject(item, "loads");
  for (int64_t n = 0; n < training->run_count; n++) {
    cJSON *load = json_add_row(loads);
    json_string(load, "load", training->runs[n].text);
    cJSON_AddBoolToObject(load, "test", training->runs[n].test);
    json_number(load, "error", training->runs[n].error);
  }
}

/* How pulls at the surface are followed, with touch modes and without; nothing where not judged. */
static void add_touch(cJSON *object, const touch_outcome *touch) {
  if (!touch->judged)
    return;
  cJSON *item = cJSON_AddObjectToObject(object, "touch");
  json_number(item, "modes", (double)touch->shapes);
  cJSON_AddBoolToObject(item, "follow", touch->followers.count > 0);
  touch_coverage_json(item, "before", &touch->before, NULL);
  touch_coverage_json(item, "after", &touch->after, touch->at);
}

char *precompute_meta(const precompute_outcome *outcome) {
  const precompute_request *request = outcome->request;
  const thrum_mesh *mesh = outcome->mesh;
  const thrum_precomputed *result = outcome->result;
  cJSON *meta = cJSON_CreateObject();

  // the program that made the model, because another build may round differently
  cJSON_AddStringToObject(meta, "tool", "thrum");
  cJSON_AddStringToObject(meta, "version", thrum_version());
  cJSON_AddStringToObject(meta, "compiler", thrum_build_compiler());
  cJSON_AddStringToObject(meta, "blas_core", thrum_build_blas_core());
  add_units(meta);

  // the mesh, known by its hash
  cJSON *about = cJSON_AddObjectToObject(meta, "mesh");
  json_string(about, "name", path_basename(request->mesh_name));
  add_hash(about, "hash", mesh);
  json_number(about, "vertices", (double)mesh->vertex_count);
  json_number(about, "tets", (double)mesh->tet_count);
  element_solids_json(about, mesh);
  element_order_json(about, &outcome->order, mesh);
  add_materials(meta, mesh);

  // the options and the figures of the result
  add_options(meta, request, result);
  json_number(meta, "mass_kg", result->mass);
  json_number(meta, "volume_m3", result->volume);
  add_frequencies(meta, "frequencies_hz", result->mode_omega2, result->mode_count);
  add_frequencies(meta, "basis_frequencies_hz", result->model.omega2, result->model.rank);
  model_coordinates_add(meta, outcome);
  json_number(meta, "rigid_modes", (double)result->rigid_count);

  // how far the result can be trusted
  add_residuals(meta, result);
  add_cubature(meta, request, result);
  add_check(meta, result);
  add_import(meta, request, result);
  add_training(meta, &outcome->training);
  add_touch(meta, &outcome->touch);
  if (!request->reproducible)
    precompute_add_stages(meta, result, request->options.cubature, &outcome->training);

  char *text = json_text(meta);
  cJSON_Delete(meta);
  return text;
}

/* Adds the solver that several processes used, and the memory that decided for it. */
static void add_solver(cJSON *object, const thrum_solver_use *use) {
  if (use->room == 0)
    return;
  cJSON *row = cJSON_AddObjectToObject(object, "solver");
  cJSON_AddStringToObject(row, "name", use->solver == THRUM_SOLVER_CG ? "cg" : "factor");
  if (use->factor_bytes > 0)
    json_number(row, "factor_mb", use->factor_bytes / 1048576);
  json_number(row, "cg_mb", use->cg_bytes / 1048576);
  json_number(row, "room_mb", use->room / 1048576);
  if (use->solves > 0) {
    json_number(row, "solves", use->solves);
    json_number(row, "steps", use->steps);
  }
}

static void add_seconds(cJSON *object, const precompute_outcome *outcome) {
  cJSON *seconds = cJSON_AddObjectToObject(object, "seconds");
  json_number(seconds, "mesh", outcome->seconds_mesh);
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    json_number(seconds, precompute_stage_label_of((thrum_stage)stage, false).name,
                outcome->result->seconds[stage]);
  if (outcome->touch.judged)
    json_number(seconds, "touch", outcome->touch.seconds);
  json_number(seconds, "write", outcome->seconds_write);
  json_number(seconds, "total", outcome->seconds_total);
}

/* Linear tetrahedra that bend are too stiff, and other elements that are large or distorted, or
 * hardly change their volume. */
static void warn_of_order(const precompute_outcome *outcome) {
  const element_order *order = &outcome->order;
  const char *name = path_basename(outcome->request->mesh_name);
  if (outcome->mesh->solid_count > 0)
    locking_warn_of_solids(name, order->finer_errors, order->finer_count);
  else if (outcome->mesh->midsides == NULL)
    locking_warn_of(name, order->errors, order->error_count, order->kept);
  else
    locking_warn_of_ten(name, order->cubic_errors, order->cubic_count);
}

#define LEARNED_STEPS 10000 /* of --cubature-refine, as a rule */
#define LEARNED_FROM 20000  /* points times rank: a force of some 25 us */
#define LEARNED_GAIN 1.5    /* points over those that would be learned */

/* Whether points of fewer numbers, which are learned, would make steps much cheaper. */
static bool would_learn(const precompute_outcome *outcome) {
  const thrum_cubature_figures *figures = &outcome->result->cubature;
  const double points = (double)figures->points, rank = (double)outcome->result->model.rank;
  const bool flows = !isinf(outcome->request->options.cubature_yield) ||
                     outcome->result->model.region_yield != NULL;
  return figures->few > 0 && !flows &&
         thrum_law_of_model(&outcome->result->model) == THRUM_LAW_STVK &&
         points * rank > LEARNED_FROM && points > LEARNED_GAIN * (double)figures->few;
}

/* Time of a step by these points, which goes with their number [s]. */
static double learned_step(const thrum_cubature_figures *figures) {
  return figures->step_seconds * (double)figures->few / (double)figures->points;
}

/* Adds what learned points would take; null where they would gain little. */
static void add_learned(cJSON *cubature, const precompute_outcome *outcome) {
  const thrum_cubature_figures *figures = &outcome->result->cubature;
  if (!would_learn(outcome)) {
    cJSON_AddNullToObject(cubature, "if_learned");
    return;
  }
  cJSON *learned = cJSON_AddObjectToObject(cubature, "if_learned");
  json_number(learned, "refine", LEARNED_STEPS);
  json_number(learned, "points", (double)figures->few);
  json_number(learned, "step_us", 1e6 * learned_step(figures));
  json_number(learned, "seconds",
              thrum_cubature_learning(figures->few, outcome->result->model.rank, LEARNED_STEPS));
}

static cJSON *make_report(const precompute_outcome *outcome) {
  const thrum_precomputed *result = outcome->result;
  const thrum_mesh *mesh = outcome->mesh;
  cJSON *object = cJSON_CreateObject();

  // the verdict and the model that was written
  cJSON_AddStringToObject(object, "status", outcome->flagged ? "flagged" : "done");
  json_string(object, "model", outcome->request->output);
  cJSON_AddStringToObject(object, "version", thrum_version());

  // the mesh as it was used
  add_hash(object, "mesh_hash", mesh);
  json_number(object, "vertices", (double)mesh->vertex_count);
  json_number(object, "tets", (double)mesh->tet_count);
  element_solids_json(object, mesh);
  element_order_json(object, &outcome->order, mesh);
  if (result->quadrature_order > 0)
    json_number(object, "quadrature_order", result->quadrature_order);
  json_number(object, "fixed", (double)outcome->fixed_count);
  json_number(object, "flipped_tets", (double)mesh->flipped_tets);
  json_number(object, "dropped_vertices", (double)mesh->dropped_vertices);

  // size of the eigenproblem and properties of the body
  json_number(object, "free_dofs", (double)result->free_dofs);
  json_number(object, "factor_nonzeros", (double)result->factor_nonzeros);
  add_solver(object, &result->solver);
  json_number(object, "mass_kg", result->mass);
  json_number(object, "volume_m3", result->volume);
  double least[3], most[3], size[3];
  thrum_box3(mesh->vertices, mesh->vertex_count, least, most);
  for (int axis = 0; axis < 3; axis++)
    size[axis] = most[axis] - least[axis];
  json_numbers(object, "size_m", size, 3);

  // the basis and its frequencies
  json_number(object, "rank", (double)result->model.rank);
  json_number(object, "modes", (double)result->mode_count);
  add_frequencies(object, "frequencies_hz", result->mode_omega2, result->mode_count);
  add_frequencies(object, "basis_frequencies_hz", result->model.omega2, result->model.rank);
  model_coordinates_add(object, outcome);

  // how imexv would split it at the default step
  json_number(object, "dt", outcome->dt);
  json_number(object, "explicit_modes", (double)outcome->split.explicit_modes);
  json_number(object, "implicit_modes", (double)outcome->split.implicit_modes);
  json_number(object, "rigid_modes", (double)result->rigid_count);

  // how far the result can be trusted
  add_residuals(object, result);
  add_cubature(object, outcome->request, result);
  if (outcome->request->options.cubature) {
    cJSON *cubature = cJSON_GetObjectItem(object, "cubature");
    json_number(cubature, "step_us", 1e6 * result->cubature.step_seconds);
    add_learned(cubature, outcome);
  }
  add_check(object, result);
  add_import(object, outcome->request, result);

  add_training(object, &outcome->training);
  add_touch(object, &outcome->touch);

  // the cost
  json_number(object, "threads", outcome->request->options.threads);
  cJSON_AddStringToObject(object, "blas_core", thrum_build_blas_core());
  add_seconds(object, outcome);
  precompute_add_stages(object, result, outcome->request->options.cubature, &outcome->training);
  json_number(object, "peak_mb", clock_peak_mb());
  return object;
}

static const report_line lines[] = {
    // the file, the mesh and the body
    REPORT_LINE("model", "{model}"),
    REPORT_LINE("mesh",
                "{vertices} vertices ({fixed} held), {solids?{solids}|{tets} tetrahedra{ten_nodes? "
                "of ten nodes{order_by=auto?, by --order auto}}}"),
    REPORT_LINE("body", "{mass_kg:.6g} kg, {volume_m3:.6g} m^3, {size_m.0:.4g} x {size_m.1:.4g} x "
                        "{size_m.2:.4g} m"),
    REPORT_LINE("solver",
                "factor, about {solver.factor_mb:.0f} MB more in a process; {solver.room_mb:.0f} "
                "MB were left "
                "for it",
                .when = "solver.name=factor"),
    REPORT_LINE(
        "solver",
        "conjugate gradients with multigrid, about {solver.cg_mb:.0f} MB more in a process[ (a "
        "factor: "
        "{solver.factor_mb:.0f} MB)]; {solver.room_mb:.0f} MB were left for it",
        .when = "solver.name=cg"),

    // where the basis comes from, and what it is worth where it was trained and elsewhere
    REPORT_LINE(
        "basis",
        "rank {rank}{modes? from {modes} linear modes}{handles? and {handles} handle{handles#|s}}"
        "{training.shapes?, {training.shapes} of it trained}"
        "[{touch.follow?, which is stepped; {touch.modes} touch modes follow|, {touch.modes} of it "
        "touch modes}]"),
    REPORT_LINE(
        "touch",
        "pulls are followed by {touch.after.worst:.0f%} at least (vertex {touch.after.vertex}, at "
        "{touch.after.at_m:.3g} m), {touch.after.mean:.0f%} in the mean of {touch.after.places} "
        "places; without "
        "touch modes by {touch.before.worst:.0f%} at least, {touch.before.mean:.0f%} in the mean; "
        "{seconds.touch:.2f} s"),
    REPORT_LINE("error in {test?a test|training}",
                "{error=null?the run was lost|{error:.3g%} of the displacement} under {load}",
                .each = "training.loads"),

    // a free body keeps its rigid modes apart, and an imported basis has no linear modes of its own
    REPORT_LINE("rigid modes",
                "{rigid_modes} kept apart, |K z| / (|K| |z|) at most {residuals.rigid:.1e}"),
    REPORT_LINE("linear modes", "{linear_hz} Hz"),
    REPORT_LINE(
        "none missed",
        "{mode_check.method=inertia?{mode_check.complete?yes|NO} by inertia: "
        "{mode_check.below_shift} "
        "modes "
        "below {mode_check.shift_hz:.5g} Hz|yes by search}, next {mode_check.next_hz:.5g} Hz"
        "{mode_check.recovered? ({mode_check.recovered} missed at first)}"),
    REPORT_LINE("imported",
                "|U^T M U - 1| was {import.orthonormality:.1e}, {import.basis_changed?its basis "
                "was changed|taken as it "
                "is}"),
    REPORT_LINE(
        "",
        "gradient to {import.gradient_defect:.1e}, linear part to {import.linear_difference:.1e}, "
        "energy to "
        "{import.energy_difference:.1e}"),

    // what the model is good for: its split and its residuals
    REPORT_LINE("basis", "{basis_hz} Hz"),
    REPORT_LINE("split",
                "{explicit_modes} explicit, {implicit_modes} implicit by imexv at dt = {dt:g} s"),
    REPORT_LINE("residuals",
                "modes {worst:.1e}, orthonormality {residuals.orthonormality:.1e}, diagonality "
                "{residuals.diagonality:.1e}"),
    REPORT_LINE(
        "precision",
        "single, force wrong by {residuals.single_precision:.1e} of itself at most, of 16 samples"),

    // points against the polynomial that they replace
    REPORT_LINE(
        "cubature",
        "{cubature.points} point{cubature.points#|s} of {cubature.candidates}, force wrong by "
        "{cubature.train_error:.2g%} in {cubature.states} states of training, "
        "{cubature.test_error:.2g%} in "
        "{cubature.test_states} others (rms)"),
    REPORT_LINE(
        "motion",
        "{cubature.motion_error=null?not measured: run it beside the mesh (simulate --full) or "
        "tradeoff|wrong by "
        "{cubature.motion_error:.2g%} in motions of {range_within:.2g} of the diagonal, "
        "{cubature.motion_error_beyond:.2g%} at {range_beyond:.2g} of it (rms over two periods); a "
        "step takes "
        "{cubature.step_us:.3g} us}",
        .when = "cubature"),
    REPORT_LINE(
        "cheaper",
        "--cubature-refine {cubature.if_learned.refine} would begin with "
        "{cubature.if_learned.points} "
        "points"
        "{cubature.step_us?, so that a step takes about {cubature.if_learned.step_us:.3g} us for "
        "{cubature.step_us:.3g}}, and learn for about {cubature.if_learned.seconds:.2g} s more; "
        "check "
        "its error "
        "of motion, which may be larger"),
    REPORT_LINE("gradients", "learned: points of the mesh alone would be wrong by "
                             "{cubature.chosen_error:.2g%} in these others"),
    REPORT_LINE("law", "{cubature.law}, by which the points alone answer",
                .when = "cubature.force_cost=null"),
    REPORT_LINE(
        "", "{recommended?recommended|not recommended, leave --cubature out}: a force takes about "
            "{cubature.force_cost:.2g} "
            "times as long as by the polynomial{recommended?|, and a step gains below a half}"),
    REPORT_LINE("took", "{seconds.total:.2f} s, peak {peak_mb:.0f} MB"),
    {0}};

/* Cost of a force by points over that by the polynomial, below which a step gains: a step of
 * energy has more than forces. Of a beam of rank 20 to 30 a step took 0.56, 0.80, 0.88, 1.12, 1.43
 * and 1.77 times as long with forces of 0.19, 0.35, 0.27, 0.56, 0.89 and 1.3. */
#define STEP_GAINS 0.5

#define FREQUENCIES_SHOWN 6

/* The first few frequencies of a list and the last one, as a text; nothing of an empty one. */
static void add_first(cJSON *more, const char *key, const cJSON *frequencies) {
  const int count = cJSON_GetArraySize(frequencies);
  cJSON *list = cJSON_CreateObject(), *shown = cJSON_AddArrayToObject(list, "first");
  char text[200];
  for (int n = 0; n < count && n < FREQUENCIES_SHOWN; n++)
    cJSON_AddItemToArray(shown, cJSON_Duplicate(cJSON_GetArrayItem(frequencies, n), true));
  if (count > FREQUENCIES_SHOWN)
    cJSON_AddItemToObject(list, "last",
                          cJSON_Duplicate(cJSON_GetArrayItem(frequencies, count - 1), true));
  if (count > 0 && report_text(list, NULL, "{first:.5g}[, ... {last:.5g}]", text, sizeof text))
    cJSON_AddStringToObject(more, key, text);
  cJSON_Delete(list);
}

/* What the table has beside the report. */
static cJSON *make_more(const precompute_outcome *outcome, const cJSON *report) {
  const thrum_precomputed *result = outcome->result;
  const double range = outcome->request->options.cubature_range;
  cJSON *more = cJSON_CreateObject();
  double worst = 0;

  // one number stands for the residuals of all modes
  for (int64_t n = 0; n < result->mode_count; n++)
    worst = result->mode_residual[n] > worst ? result->mode_residual[n] : worst;
  json_number(more, "worst", worst);
  add_first(more, "linear_hz", cJSON_GetObjectItemCaseSensitive(report, "frequencies_hz"));
  add_first(more, "basis_hz", cJSON_GetObjectItemCaseSensitive(report, "basis_frequencies_hz"));

  cJSON_AddBoolToObject(more, "ten_nodes", outcome->mesh->midsides != NULL);
  json_number(more, "handles", (double)outcome->request->handle_count);
  json_number(more, "range_within", 0.75 * range);
  json_number(more, "range_beyond", 1.5 * range);
  cJSON_AddBoolToObject(more, "recommended", result->cubature.force_cost < STEP_GAINS);
  return more;
}

void precompute_print_report(const precompute_outcome *outcome) {
  cJSON *report = make_report(outcome);
  warn_of_order(outcome);
  if (outcome->request->json) {
    json_print(report);
    return;
  }
  report_end(report, make_more(outcome, report), REPORT_LABEL_WIDE, lines);
  precompute_print_stages(outcome->result, outcome->request->options.cubature, &outcome->training);
}
