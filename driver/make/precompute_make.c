/* The pipeline behind `thrum precompute` and behind models that are asked for by name: from a
 * mesh's name to the written model file. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "core/base/pi.h"
#include "driver/make/about.h"
#include "driver/make/precompute_dry.h"
#include "driver/make/precompute_make.h"
#include "driver/make/precompute_progress.h"
#include "driver/make/precompute_report.h"
#include "driver/make/precompute_touch.h"
#include "driver/model/basis_estimate.h"
#include "driver/model/mesh_of_model.h"
#include "driver/model/mesh_warnings.h"
#include "driver/model/model_cut.h"
#include "driver/model/split_at.h"
#include "driver/spec/region_material.h"
#include "io/npz.h"
#include "io/paths.h"
#include "io/vtu.h"
#include "mesh/actuator.h"
#include "mesh/elastic.h"
#include "mesh/formats/file_suffix.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_beam.h"
#include "mesh/mesh_fix.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_springs.h"
#include "mesh/model_quality.h"
#include "mesh/vertex_places.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/basis/handles.h"
#include "precompute/estimate.h"
#include "precompute/options_check.h"
#include "precompute/vega_reduced.h"

/* Beyond these the model is written, but flagged (exit 3). */
#define RESIDUAL_FLAG 1e-8       /* |K psi - w^2 M psi| / (|K| |psi|) of any mode */
#define ROUNDING_FLAG 2e-3       /* of omega^2, of a mode and its coordinate */
#define ORTHONORMALITY_FLAG 1e-9 /* |U^T M U - 1| and the same of U^T K U */

/* Checks the paths of the model and of the modes: neither may take the place of the other, nor of
 * the mesh. */
static thrum_status check_outputs(const precompute_request *request, thrum_error *error) {
  const char *const paths[] = {request->output, request->export_modes};
  if (request->output[0] == 0)
    return thrum_error_set(error, THRUM_IO, "-o: the model file needs a name, such as beam.npz");

  // a file that is written must not be the mesh that is read
  for (int n = 0; n < 2 && paths[n]; n++) {
    THRUM_TRY(path_check_output(paths[n], error));
    if (path_same_file(paths[n], request->mesh_name))
      return thrum_error_set(error, THRUM_IO, "%s is the mesh: write to another file", paths[n]);
  }

  if (paths[1] && path_same_file(paths[0], paths[1]))
    return thrum_error_set(error, THRUM_IO, "-o and --export-modes name one file, %s", paths[0]);
  return THRUM_OK;
}

/* --condense with no coordinate that could follow is refused before any work is done. */
static thrum_status check_condensed(const precompute_request *request, thrum_error *error) {
  const thrum_precompute_options complete = thrum_options_complete(&request->options);
  if (!request->condense || complete.rank > complete.modes)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "--condense: at rank %lld nothing is left to follow %lld linear modes: "
                         "raise --rank above it, or lower --modes",
                         (long long)complete.rank, (long long)complete.modes);
}

/* Laws that regions were given need points as that of the whole body does. */
static thrum_status check_laws(const precompute_request *request, thrum_error *error) {
  const thrum_precompute_options *options = &request->options;
  if (options->law != THRUM_LAW_STVK && !options->cubature)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%.200s: laws of its regions other than stvk need --cubature: a "
                           "polynomial cannot hold them",
                           request->mesh_name);
  if (options->law == THRUM_LAW_STVK && !isinf(options->cubature_yield))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--yield needs --law corotational or neo-hookean, or a region of one, "
                           "whose points flow");
  return THRUM_OK;
}

/* The options' material replaces the mesh's own, in every region and then in those that are named.
 */
static thrum_status apply_material(precompute_request *request, thrum_mesh *mesh,
                                   thrum_error *error) {
  const thrum_material *wanted = &request->material;
  const bool whole = !isnan(wanted->young) && !isnan(wanted->poisson) && !isnan(wanted->density);

  // one material in place of the mesh's own, in every region
  if (!isnan(wanted->young) || !isnan(wanted->poisson))
    for (int64_t m = 0; m < mesh->region_count; m++)
      THRUM_TRY(thrum_mesh_set_elastic(mesh, m, NULL, 0, error));
  for (int64_t m = 0; m < mesh->region_count; m++) {
    if (!isnan(wanted->young))
      mesh->materials[m].young = wanted->young;
    if (!isnan(wanted->poisson))
      mesh->materials[m].poisson = wanted->poisson;
    if (!isnan(wanted->density))
      mesh->materials[m].density = wanted->density;
  }

  // a law that is asked for is that of all regions without one of their own, of a model's mesh too
  if (request->law_given) {
    free(mesh->laws);
    mesh->laws = NULL;
  }
  int64_t lacking = -1;
  THRUM_TRY(region_materials_apply(request->materials, request->material_count, mesh,
                                   &request->options.law, &lacking, error));
  THRUM_TRY(check_laws(request, error));

  if (!mesh->has_material && !whole && lacking >= 0) {
    if (request->material_count > 0)
      return thrum_error_set(error, THRUM_MISSING,
                             "%.150s does not say what region '%.80s' is made of: give --material "
                             "for it too, or --young, --poisson and --density",
                             request->mesh_name, thrum_mesh_region_text(mesh, lacking).text);
    return thrum_error_set(error, THRUM_MISSING,
                           "%s does not say what it is made of: give --young, --poisson and "
                           "--density",
                           request->mesh_name);
  }
  mesh->has_material = true;
  mesh_warn_materials(mesh, path_basename(request->mesh_name), request->reading.unit);
  mesh_warn_poisson(mesh, path_basename(request->mesh_name));
  if (strncmp(request->mesh_name, "beam:", 5) == 0)
    mesh_warn_weight(mesh, path_basename(request->mesh_name), &request->reading);
  return THRUM_OK;
}

/* Puts the place in an options file before what an error says, or the option where it was given
 * elsewhere. */
static thrum_status name_line(const precompute_request *request, const char *option,
                              const int64_t *lines, int64_t n, thrum_status status,
                              thrum_error *error) {
  if (request->lines_file == NULL || n >= CONFIG_FILE_ITEMS_MAX || lines[n] == 0)
    return config_error_of(error, status, option);
  return config_error_in(error, status, "%.100s:%lld: %s", request->lines_file, (long long)lines[n],
                         option + 2);
}

/* Marks what the --fix options name in `fixed`, beside what it marks already. */
static thrum_status fix_vertices(const precompute_request *request, const thrum_mesh *mesh,
                                 uint8_t *fixed, thrum_error *error) {
  // each SPEC adds to the vertices already held
  for (int64_t n = 0; n < request->fix_count; n++) {
    int64_t count = 0;
    const thrum_status status = thrum_mesh_fix(mesh, request->fixes[n], fixed, &count, error);
    if (status < 0)
      return name_line(request, "--fix", request->fix_lines, n, status, error);
    if (count == 0 && mesh->made_midsides == 0)
      config_warn("--fix %s: the list is empty and holds nothing", request->fixes[n]);
  }
  return THRUM_OK;
}

/* The same of a mesh that was read from a file, of which nothing is held yet. */
static thrum_status hold_vertices(const precompute_request *request, const thrum_mesh *mesh,
                                  uint8_t **fixed, thrum_error *error) {
  THRUM_TRY(thrum_reserve(fixed, mesh->vertex_count, 1, "what is held of the mesh", error));
  return fix_vertices(request, mesh, *fixed, error);
}

/* Adds the --spring options to the springs that the mesh has. */
static thrum_status add_springs(const precompute_request *request, thrum_mesh *mesh,
                                thrum_error *error) {
  for (int64_t n = 0; n < request->spring_count; n++)
    THRUM_TRY(config_error_of(error, thrum_mesh_add_springs(mesh, request->springs[n], error),
                              "--spring"));
  return THRUM_OK;
}

/* Shares them out again where middle nodes have come since, which are then of the same places. */
static thrum_status share_springs(const precompute_request *request, int64_t vertices,
                                  thrum_mesh *mesh, thrum_error *error) {
  if (mesh->vertex_count == vertices || request->spring_count == 0)
    return THRUM_OK;
  free(mesh->springs);
  mesh->springs = NULL;
  return add_springs(request, mesh, error);
}

/* Counts the vertices held. */
static int64_t count_held(const thrum_mesh *mesh, const uint8_t *fixed) {
  int64_t held = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    held += fixed[v] != 0;
  return held;
}

/* Says that a body is free where nobody asked for that. */
static void warn_free(const precompute_request *request, int64_t held) {
  if (held == 0 && !request->free)
    config_warn("nothing is fixed, so this is a free body: the model is its elastic part, the six "
                "rigid modes are kept apart (hold vertices with --fix, such as --fix 'x<0.001')");
}

/* The model with the condensed polynomial of its lowest coordinates in the place of its own;
 * *memory and *none hold that and are the caller's. */
static thrum_status condense(int64_t masters, thrum_model *model, void **memory, double **none,
                             thrum_error *error) {
  const thrum_model *stepped = NULL;
  THRUM_TRY(model_condense_to(model, masters, memory, &stepped, error));

  // of a coarse mesh all masters may stretch the body, and nothing follows them: its map is zero
  const int64_t pairs = masters * (masters + 1) / 2, slaves = model->rank - masters;
  if (stepped->follow == NULL)
    THRUM_TRY(thrum_reserve(none, slaves * pairs, sizeof **none, "the condensed model", error));
  model->c3 = model->c4 = NULL;
  model->c3_count = model->c4_count = 0;
  model->slave_map = stepped->follow != NULL ? stepped->follow : *none;
  model->slave_count = slaves;
  model->slave_pairs = pairs;
  model->condensed_c3 = stepped->c3;
  model->condensed_c3_count = stepped->c3_count;
  model->condensed_c4 = stepped->c4;
  model->condensed_c4_count = stepped->c4_count;
  return THRUM_OK;
}

static thrum_status save_model(const precompute_request *request, const precompute_outcome *outcome,
                               thrum_error *error) {
  const thrum_precomputed *result = outcome->result;
  char *meta = precompute_meta(outcome);
  if (meta == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory for meta");
  // a shallow copy, so that meta stays ours; with what follows, where touch modes do
  const thrum_touch_followers *followers = &outcome->touch.followers;
  thrum_model model = followers->count > 0 ? followers->model : result->model;
  model.meta = (const uint8_t *)meta;
  model.meta_bytes = (int64_t)strlen(meta);
  void *memory = NULL;
  double *none = NULL;
  thrum_status status = THRUM_OK;
  if (request->condense)
    status = condense(result->mode_count, &model, &memory, &none, error);
  THRUM_THEN(status, thrum_model_save(request->output, &model, error));
  free(memory);
  free(none);
  free(meta);
  return status;
}

#define MOTION_WARNED 0.1 /* error of motions by points within their range that is told */

/* Says that the points miss the error that was asked for, and what may mend that: more points only
 * where their number was bounded. */
static void warn_of_points(const precompute_request *request, const thrum_precomputed *result) {
  const thrum_precompute_options *options = &request->options;
  const bool bounded = result->cubature.points >= options->cubature_points;

  // points that flow cannot be learned
  const bool flows = !isinf(options->cubature_yield) || result->model.region_yield != NULL;
  const char *advice = "";
  if (options->cubature_refine > 0)
    advice = bounded ? "raise --cubature-refine or --cubature-points, or "
                     : "raise --cubature-refine, or ";
  else if (bounded)
    advice = "raise --cubature-points, or ";
  else if (!flows)
    advice = "learn the points' gradients by --cubature-refine, or ";
  config_warn("the force by %lld cubature point%s is wrong by %.2g (rms), not by %.2g as asked: "
              "%slower --cubature-range",
              (long long)result->cubature.points, result->cubature.points == 1 ? "" : "s",
              result->cubature.test_error, options->cubature_error, advice);
}

/* Says that a rank leaves linear modes out, or all that would let them bend far. */
static void warn_of_rank(const thrum_precomputed *result) {
  int64_t modes = 0, others = 0;
  if (result->coordinates == NULL)
    return;
  for (int64_t i = 0; i < result->model.rank; i++) {
    modes += result->coordinates[i].kind == THRUM_COORDINATE_MODE;
    others += result->coordinates[i].kind != THRUM_COORDINATE_MODE;
  }
  if (modes < result->mode_count)
    config_warn("the rank leaves room for the first %lld of %lld linear modes: give a larger "
                "--rank, or fewer --modes",
                (long long)modes, (long long)result->mode_count);
  if (modes > 0 && others == 0)
    config_warn("rank %lld holds linear modes and nothing that lets them bend far, so the model is "
                "for small motion alone: give a larger --rank, such as %lld, or fewer --modes",
                (long long)result->model.rank,
                (long long)thrum_options_usual_rank(result->mode_count));
}

/* A basis that has all modes has their frequencies, but for rounding. */
static bool warn_of_rounding(const thrum_precomputed *result) {
  int64_t modes = 0;
  for (int64_t n = 0; n < result->model.rank && result->coordinates != NULL; n++)
    modes += result->coordinates[n].kind == THRUM_COORDINATE_MODE;
  if (modes < result->mode_count || !result->modes_complete)
    return false;
  for (int64_t n = 0; n < modes; n++) {
    const double mode = result->mode_omega2[n], own = result->model.omega2[n];
    if (fabs(own - mode) <= ROUNDING_FLAG * mode)
      continue;
    config_warn(
        "mode %lld has %.6g Hz, and in the basis %.6g Hz: the stiffness is lost in rounding, "
        "which in thin parts grows as (length over thickness)^4",
        (long long)n + 1, sqrt(mode) / THRUM_TWO_PI, sqrt(own) / THRUM_TWO_PI);
    return true;
  }
  return false;
}

/* What stays on a body about a state of a file: also what held it there and holds it no more. */
static thrum_status say_loads(const char *about, const thrum_mesh *mesh, const uint8_t *fixed,
                              thrum_error *error) {
  double loads[3];
  if (!thrum_file_has_suffix(about, ".npy"))
    return THRUM_OK;
  THRUM_TRY(about_loads(mesh, fixed, loads, error));
  fprintf(stderr,
          "thrum: %.200s: the loads of this state stay on the body, (%.3g, %.3g, %.3g) N in all; a "
          "reaction of what is not held any more is one of them\n",
          about, loads[0], loads[1], loads[2]);
  return THRUM_OK;
}

static bool is_flagged(const precompute_request *request, const thrum_precomputed *result) {
  bool flagged = !(result->basis_orthonormality <= ORTHONORMALITY_FLAG) ||
                 !(result->basis_diagonality <= ORTHONORMALITY_FLAG);
  for (int64_t n = 0; n < result->mode_count; n++)
    flagged = flagged || !(result->mode_residual[n] <= RESIDUAL_FLAG);

  // an eigenvalue count that is larger than the list means missed modes
  if (!result->modes_complete)
    config_warn(
        "%lld modes lie below the %lld-th, more than were found: another --modes may find them",
        (long long)(result->shift_count - result->rigid_count), (long long)result->mode_count);

  warn_of_rank(result);
  flagged = warn_of_rounding(result) || flagged;

  // points that do not reach what was asked for
  const bool missed =
      request->options.cubature && result->cubature.test_error > request->options.cubature_error;
  if (missed)
    warn_of_points(request, result);
  if (request->options.cubature && result->cubature.motion_error > MOTION_WARNED)
    config_warn(
        "motions by these cubature points are wrong by %.2g %% (rms over two periods) within "
        "the range of training, though the force is by %.2g %%: a smaller --cubature-error "
        "mends that",
        100 * result->cubature.motion_error, 100 * result->cubature.test_error);

  if (flagged)
    config_warn("residuals are larger than they should be; see `thrum info`");
  return flagged || missed || !result->modes_complete;
}

/* Whether the model is not what its training wanted: lost under a load, or of a larger error. */
static bool is_lost(const precompute_request *request, const train_outcome *training) {
  if (training->missed)
    config_warn("the error of %g %% is not reached; raise --rank-max, train on more of the loads, "
                "or ask for less",
                100 * request->error);
  const double error = precompute_train_error(training, false);
  if (!training->missed && error > BASIS_ACCEPTED)
    config_warn("the trained basis is %.2g %% off in its own training, and the usual one may be "
                "nearer (thrum simulate says by how much): raise --rank, or leave --train out",
                100 * error);
  for (int64_t n = 0; n < training->run_count; n++)
    if (isnan(training->runs[n].error)) {
      config_warn("the model is lost under %.200s: lower the load, or train on a smaller one as "
                  "well",
                  training->runs[n].text);
      return true;
    }
  return training->missed;
}

/* Whether some visible place does not follow a pull as --touch wants. */
static bool is_not_followed(const precompute_request *request, const touch_outcome *touch) {
  if (touch->missed)
    config_warn("a pull at vertex %lld (%.3g, %.3g, %.3g m) is followed by %.0f %% at rank %lld, "
                "not by %.0f %%: raise --rank-max, or name the place that will be pulled by "
                "--handles",
                (long long)touch->after.vertex + 1, touch->at[0], touch->at[1], touch->at[2],
                100 * touch->after.worst, (long long)request->rank_max, 100 * TOUCH_FOLLOWS);
  return touch->missed;
}

static thrum_status read_imported_basis(const precompute_request *request,
                                        thrum_imported_basis *imported, thrum_error *error) {
  thrum_status status = THRUM_OK;
  if (request->import_basis)
    status = thrum_vega_basis_read(request->import_basis, imported, error);
  if (status >= 0 && request->import_cubic)
    status = thrum_vega_cubic_read(request->import_cubic, imported, error);
  return status;
}

static thrum_status save_modes(const precompute_request *request, const thrum_precomputed *result,
                               thrum_error *error) {
  if (!request->export_modes)
    return THRUM_OK;
  double *hertz = NULL;
  THRUM_TRY(thrum_reserve(&hertz, result->mode_count, sizeof *hertz, "the frequencies", error));
  thrum_frequencies(result->mode_omega2, result->mode_count, hertz);
  const thrum_status status =
      vtu_write_modes(request->export_modes, &result->model, result->mode_count, hertz,
                      result->mode_vectors, error);
  free(hertz);
  return status;
}

/* One run of a training, which is kept; no model is written. */
static thrum_status make_run(const precompute_task *task, thrum_error *error) {
  const thrum_status status = precompute_train_job(task, error);
  config_progress_end(&task->progress->bar, status >= 0);
  return status;
}

/* The errors of linear elements that the precompute has found. */
static void keep_order_errors(const thrum_precomputed *result, element_order *order) {
  order->error_count = result->order_error_count;
  memcpy(order->errors, result->order_error, sizeof order->errors);
}

/* Makes the model from the fixed mesh, writes its file and prints the result. */
static thrum_status make_model(precompute_task *task, precompute_show *show,
                               precompute_outcome *outcome, thrum_error *error) {
  const precompute_request *request = task->request;

  // an imported basis takes the place of modes and derivatives
  thrum_precomputed result = {0};
  thrum_imported_basis imported = {0};
  thrum_status status = read_imported_basis(request, &imported, error);
  task->options.imported = request->import_basis ? &imported : NULL;
  if (status >= 0 && request->train_count + request->test_count > 0)
    status = precompute_train(task, &outcome->training, &result, error);
  else if (status >= 0 && request->touch)
    status = precompute_touch(task, &outcome->touch, &result, error);
  else
    THRUM_THEN(status, thrum_precompute(task->mesh, task->fixed, &task->options, &result, error));
  thrum_imported_basis_free(&imported);

  config_progress_end(&task->progress->bar, status >= 0);
  if (status < 0) {
    precompute_train_free(&outcome->training);
    precompute_touch_free(&outcome->touch);
    thrum_precomputed_free(&result);
    return status;
  }

  // the split at the default step is shown with the other figures
  outcome->result = &result;
  if (!task->options.order_known)
    keep_order_errors(&result, &outcome->order);
  outcome->order.cubic_count = result.cubic_error_count;
  memcpy(outcome->order.cubic_errors, result.cubic_error, sizeof result.cubic_error);
  status = element_order_refine(request, task->mesh, task->fixed, result.mode_count,
                                result.mode_omega2, &outcome->order, error);
  outcome->dt = thrum_default_state_def().dt;
  THRUM_THEN(status, split_at(&result.model, outcome->dt, &outcome->split, error));

  // the model first: the modes are an extra
  const double writing = clock_seconds();
  THRUM_THEN(status, save_model(request, outcome, error));
  THRUM_THEN(status, save_modes(request, &result, error));

  // the caller shows the figures while the result is still there
  if (status >= 0) {
    const double now = clock_seconds();
    outcome->seconds_write = now - writing;
    outcome->seconds_total = now - outcome->began;
    outcome->flagged = is_flagged(request, &result) || is_lost(request, &outcome->training) ||
                       is_not_followed(request, &outcome->touch);
    if (show != NULL)
      show(outcome);
  }

  thrum_precomputed_free(&result);
  precompute_train_free(&outcome->training);
  precompute_touch_free(&outcome->touch);
  outcome->result = NULL;
  return status;
}

/* Makes a group of the mesh of what is at a place, of that name; other texts are passed over. */
static thrum_status add_place(thrum_mesh *mesh, const char *text, thrum_error *error) {
  int32_t *vertices = NULL;
  int64_t count = 0;
  if (!thrum_vertex_places_meant(text) || thrum_mesh_find_group(mesh, text) != NULL)
    return THRUM_OK;
  THRUM_TRY(
      thrum_vertex_places_list(mesh->vertices, mesh->vertex_count, text, &vertices, &count, error));
  const thrum_status status = thrum_mesh_add_group(mesh, text, vertices, count, error);
  free(vertices);
  return status;
}

/* Looks the --handles up in the mesh; places become groups of it. */
static thrum_status find_handles(const precompute_request *request, thrum_mesh *mesh,
                                 thrum_handle *handles, thrum_error *error) {
  for (int64_t n = 0; n < request->handle_count; n++) {
    thrum_status status = add_place(mesh, request->handles[n], error);
    THRUM_THEN(status, thrum_handle_find(mesh, request->handles[n], &handles[n], error));
    if (status < 0)
      return name_line(request, "--handles", request->handle_lines, n, status, error);
  }
  return THRUM_OK;
}

/* Makes a group of the place that an actuator's surface is at, where its SPEC names one. */
static thrum_status add_actuator_place(thrum_mesh *mesh, const char *text, thrum_error *error) {
  const char *spec = strchr(text, '='), *colon = spec ? strchr(spec, ':') : NULL;
  char place[THRUM_MESH_NAME_MAX + 1];
  const size_t length = colon ? strcspn(colon + 1, ",") : 0;
  if (!colon || strncmp(spec, "=tendon", 7) == 0 || length >= sizeof place)
    return THRUM_OK;
  memcpy(place, colon + 1, length);
  place[length] = 0;
  return add_place(mesh, place, error);
}

/* Reads the --actuator options; *actuators has room for them. */
static thrum_status find_actuators(const precompute_request *request, thrum_mesh *mesh,
                                   const uint8_t *fixed, thrum_actuator *actuators,
                                   thrum_error *error) {
  for (int64_t n = 0; n < request->actuator_count; n++) {
    const char *text = request->actuators[n];
    const size_t name = strcspn(text, "=") + 1;
    thrum_status status = add_actuator_place(mesh, text, error);
    for (int64_t m = 0; m < n && status >= 0; m++)
      if (strncmp(text, request->actuators[m], name) == 0)
        status =
            thrum_error_set(error, THRUM_INVALID_ARGUMENT, "'%.100s': the name is taken", text);
    THRUM_THEN(status, thrum_actuator_read(mesh, fixed, text, &actuators[n], error));
    if (status < 0)
      return config_error_of(error, status, "--actuator");
  }
  return THRUM_OK;
}

/* Shows the memory and the time that the model would take. */
static thrum_status estimate_model(precompute_request *request, const uint8_t *fixed,
                                   precompute_outcome *outcome, thrum_error *error) {
  thrum_imported_basis imported = {0};
  thrum_status status = read_imported_basis(request, &imported, error);
  request->options.imported = request->import_basis ? &imported : NULL;
  THRUM_THEN(status, precompute_dry_run(outcome, fixed, &outcome->flagged, error));
  thrum_imported_basis_free(&imported);
  return status;
}

/* Cells of a beam beyond which a dry run takes more than a minute or a gigabyte to order them. */
#define DRY_CELLS 1e6

/* A short name of a mesh may mean more than the memory holds: that is known before it is made. A
 * dry run tells the memory in full where that takes little. */
static thrum_status check_generated(const precompute_request *request, thrum_error *error) {
  int64_t cells[3];
  if (strncmp(request->mesh_name, "beam:", 5) != 0 || request->import_basis)
    return THRUM_OK;
  THRUM_TRY(thrum_mesh_beam_cells(request->mesh_name, cells, error));
  if (request->dry_run && (double)cells[0] * (double)cells[1] * (double)cells[2] <= DRY_CELLS)
    return THRUM_OK;
  return thrum_estimate_grid(cells, &request->options, error);
}

/* What of the request is of tetrahedra alone, as `tets_for` of the options of reading. */
static const char *tets_for(const precompute_request *request) {
  const thrum_precompute_options *options = &request->options;
  if (options->parameters)
    return "parameters take";
  if (options->cubature || options->law != THRUM_LAW_STVK ||
      region_materials_need_points(request->materials, request->material_count))
    return "cubature points take";
  return options->shared != NULL ? "several processes take" : request->reading.tets_for;
}

/* The elements of a model cannot be cut. */
static thrum_status check_solids_of_model(const precompute_request *request, thrum_error *error) {
  const char *why = tets_for(request);
  if (why == NULL)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "%.200s is a model of hexahedra or wedges, and %s tetrahedra alone: give "
                         "the mesh that it was made from",
                         request->mesh_name, why);
}

/* Only tetrahedra of ten nodes have points to choose. */
static thrum_status check_quadrature(const precompute_request *request, const thrum_mesh *mesh,
                                     thrum_error *error) {
  if (request->options.quadrature_order == 0 || mesh->midsides != NULL)
    return THRUM_OK;
  return thrum_error_set_field(error, "--quadrature-order", THRUM_INVALID_ARGUMENT,
                               " is of tetrahedra of ten nodes, and the mesh has none: leave it "
                               "out, or give --element tet --order 2");
}

/* The mesh, and what of it is held before any --fix: a model file says so, too. */
static thrum_status read_mesh(const precompute_request *request, thrum_mesh *mesh, uint8_t **fixed,
                              thrum_error *error) {
  if (mesh_of_model_is_named(request->mesh_name)) {
    const thrum_mesh_read_options *reading = &request->reading;
    if (reading->scale != 1 || reading->order > 0 || reading->unit || reading->regions ||
        reading->element != THRUM_ELEMENT_AUTO)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "%.200s is a model: --scale, --unit, --regions, --order and --element "
                             "are of its mesh's file",
                             request->mesh_name);
    THRUM_TRY(mesh_of_model_read(request->mesh_name, mesh, fixed, error));
    return mesh->solid_count > 0 ? check_solids_of_model(request, error) : THRUM_OK;
  }

  // what tetrahedra alone have cuts other elements, unless these were asked for
  thrum_mesh_read_options reading = request->reading;
  reading.tets_for = tets_for(request);
  THRUM_TRY(thrum_mesh_read_with(request->mesh_name, &reading, mesh, error));
  THRUM_TRY(thrum_mesh_check_kept(request->mesh_name, &reading, mesh, error));
  return thrum_reserve(fixed, mesh->vertex_count, 1, "what is held of the mesh", error);
}

/* Tetrahedra of ten nodes get a mean dilatation. */
static thrum_status take_mean_dilatation(const precompute_request *request, thrum_mesh *mesh,
                                         thrum_error *error) {
  if (!mesh->midsides)
    return thrum_error_set_field(error, "--mean-dilatation", THRUM_INVALID_ARGUMENT,
                                 ": %.150s has no tetrahedra of ten nodes: give --element tet "
                                 "--order 2, or leave it out, as hexahedra do not lock",
                                 request->mesh_name);
  THRUM_TRY(thrum_mesh_make_solids(mesh, error));
  memset(mesh->solid_form, THRUM_FORM_MEAN10, (size_t)mesh->solid_count);
  return THRUM_OK;
}

thrum_status precompute_make(const precompute_request *request, precompute_show *show,
                             bool *flagged, thrum_error *error) {
  const double began = clock_seconds();
  thrum_mesh mesh = {0};
  uint8_t *fixed = NULL;

  // a dry run and a job write no model, so they need no name
  const bool writes = !request->dry_run && request->jobs.number == 0;
  thrum_status status = writes ? check_outputs(request, error) : THRUM_OK;
  THRUM_THEN(status, check_condensed(request, error));
  THRUM_THEN(status, check_generated(request, error));
  THRUM_THEN(status, read_mesh(request, &mesh, &fixed, error));
  if (status < 0) {
    thrum_mesh_free(&mesh);
    free(fixed);
    return status;
  }

  // the request is completed in a copy, the caller's stays as it was given
  const bool metres =
      mesh_of_model_is_named(request->mesh_name) || strncmp(request->mesh_name, "beam:", 5) == 0;
  mesh_warnings_print(&mesh, path_basename(request->mesh_name), metres ? NULL : &request->reading);
  thrum_handle *handles = NULL;
  status = thrum_reserve(&handles, request->handle_count, sizeof *handles, "the handles", error);
  precompute_request found = *request;
  found.options.handles = handles;
  found.options.handle_count = request->handle_count;

  thrum_actuator *actuators = NULL;
  THRUM_THEN(status, thrum_reserve(&actuators, request->actuator_count, sizeof *actuators,
                                   "the actuators", error));
  found.options.actuators = actuators;
  found.options.actuator_count = request->actuator_count;

  // handles and actuators come beside the rank that was asked for
  if (found.options.rank > 0)
    found.options.rank += 2 * thrum_options_responses(&found.options);
  found.options.keep_modes = request->export_modes != NULL;
  found.options.condensed = request->condense;
  precompute_outcome outcome = {.request = &found, .mesh = &mesh, .began = began};

  // what the options say about the mesh: material, fixed vertices, handles
  THRUM_THEN(status, apply_material(&found, &mesh, error));
  THRUM_THEN(status, fix_vertices(request, &mesh, fixed, error));
  THRUM_THEN(status, add_springs(request, &mesh, error));
  if (status >= 0 && mesh.springs == NULL)
    warn_free(request, count_held(&mesh, fixed));

  // linear elements that lock may get their middle nodes, in which handles share too
  const bool read = !mesh_of_model_is_named(request->mesh_name);
  const int64_t vertices = mesh.vertex_count;
  precompute_progress progress = {.bar = config_progress_make(request->quiet),
                                  .basis = "",
                                  .cubature = request->options.cubature};
  THRUM_THEN(status, element_order_choose(&found, read, hold_vertices, &progress.bar, &mesh, &fixed,
                                          &outcome.order, error));
  config_progress_end(&progress.bar, status >= 0);
  THRUM_THEN(status, share_springs(request, vertices, &mesh, error));
  THRUM_THEN(status, check_quadrature(request, &mesh, error));
  if (status >= 0) {
    if (!request->quiet)
      element_order_say(&outcome.order, &mesh, path_basename(request->mesh_name));
    found.options.order_known = outcome.order.error_count > 0;
  }

  // so is a mean dilatation, and directions of a material are those of solids
  if (request->mean_dilatation)
    THRUM_THEN(status, take_mean_dilatation(request, &mesh, error));
  if (mesh.elastic_count > 0)
    THRUM_THEN(status, thrum_mesh_make_solids(&mesh, error));
  if (request->about)
    THRUM_THEN(status, about_find(request->about, fixed, &mesh, error));
  if (request->about && !request->quiet)
    THRUM_THEN(status, say_loads(request->about, &mesh, fixed, error));
  if (status >= 0)
    outcome.fixed_count = count_held(&mesh, fixed); // middle nodes, too
  THRUM_THEN(status, find_handles(request, &mesh, handles, error));
  THRUM_THEN(status, find_actuators(request, &mesh, fixed, actuators, error));

  // a dry run stops at the estimate
  outcome.seconds_mesh = clock_seconds() - began;
  precompute_task task = {&found, &mesh, fixed, found.options, &progress};
  task.options.progress = precompute_progress_show;
  task.options.progress_context = &progress;
  if (status >= 0 && request->dry_run)
    status = estimate_model(&found, fixed, &outcome, error);
  else if (status >= 0 && request->jobs.number > 0)
    status = make_run(&task, error);
  else if (status >= 0)
    status = make_model(&task, show, &outcome, error);

  free(fixed);
  free(handles);
  for (int64_t n = 0; actuators && n < request->actuator_count; n++)
    thrum_actuator_free(&actuators[n]);
  free(actuators);
  thrum_mesh_free(&mesh);
  *flagged = outcome.flagged;
  return status;
}
