/* The files of a scene's run: for each body those of a run of it alone, and the probes.
 * SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driver/run_placement.h"
#include "driver/scene_run.h"
#include "io/file.h"
#include "io/json.h"
#include "thrum/displacement.h"

static thrum_status write_failed(const scene_run *run, const char *name, thrum_error *error) {
  const int reason = errno != 0 ? errno : EIO;
  return thrum_error_set(error, THRUM_IO, "%.200s: %s could not be written (%s)%s",
                         run->folder.path, name, strerror(reason), thrum_file_hint(reason));
}

static double time_at(const scene_run *run, int64_t step) {
  return (double)step * run->dt;
}

/* --- opening -----------------------------------------------------------------------------------
 */

/* The model with the stiffness and density that the body has, for stresses. */
static bool scale_material(scene_body_run *body) {
  const thrum_model *model = body->model;
  const size_t count = (size_t)model->region_count;
  body->shown = *model;
  if (model->material == NULL)
    return true;
  body->material = malloc(3 * count * sizeof *body->material);
  if (body->material == NULL)
    return false;
  for (size_t n = 0; n < count; n++) {
    body->material[3 * n] = body->spec->stiffness * model->material[3 * n];
    body->material[3 * n + 1] = model->material[3 * n + 1];
    body->material[3 * n + 2] = body->spec->density * model->material[3 * n + 2];
  }
  body->shown.material = body->material;
  return true;
}

/* Its vertices where the body stands, for frames. */
static bool place_vertices(const scene_run *run, int32_t n) {
  scene_body_run *body = &run->bodies[n];
  const size_t count = (size_t)body->model->vertex_count;
  double matrix[16];
  body->vertices = malloc(3 * count * sizeof *body->vertices + 1);
  if (body->vertices == NULL)
    return false;
  thrum_scene_body_matrix(run->scene, n, matrix);
  for (size_t v = 0; v < count; v++)
    cli_run_place_point(matrix, body->model->vertices + 3 * v, body->vertices + 3 * v);
  body->shown.vertices = body->vertices;
  return true;
}

static thrum_status open_body(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  const scene_outputs_spec *outputs = &run->spec.outputs;
  const size_t rank = (size_t)body->model->rank;
  const bool frames = outputs->frames_rate > 0 || outputs->frames_every > 0;
  char path[CLI_PATH_MAX + 80];
  body->q = calloc(2 * rank, sizeof *body->q);
  if (body->q == NULL || !scale_material(body))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for body '%s'", body->spec->name);
  body->extents = body->q + rank;
  thrum_status status = THRUM_OK;
  if (body->model->basis != NULL)
    status = thrum_basis_extents(body->model, body->extents, error);
  if (status >= 0)
    status = simulate_measures_open(&body->request, &body->shown, &body->measures, error);
  if (status >= 0 && frames && body->model->vertices != NULL && !place_vertices(run, n))
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for frames of body '%s'",
                             body->spec->name);
  snprintf(path, sizeof path, "%.*s/%s", CLI_PATH_MAX, run->folder.work, body->spec->name);
  if (status >= 0)
    status = cli_run_output_open(path, &body->shown, frames, &body->output, error);
  if (status >= 0 && body->spec->free)
    status = cli_run_output_open_places(&body->output, error);
  body->figures.peak = body->model->basis != NULL ? 0 : NAN;
  body->figures.peak_vertex = -1;
  simulate_figures_begin(&body->figures);
  // what wind and contact give and take is no drift
  if (run->spec.obstacles.count > 0 || run->spec.wind.at.node != NULL)
    body->figures.windows = (simulate_drift){0};
  return status;
}

static thrum_status open_probes(scene_run *run, thrum_error *error) {
  char path[CLI_PATH_MAX + 80];
  if (thrum_scene_probe_count(run->scene) == 0)
    return THRUM_OK;
  snprintf(path, sizeof path, "%.*s/" CLI_SCENE_PROBES, CLI_PATH_MAX, run->folder.work);
  errno = 0;
  run->probes = fopen(path, "w");
  bool done = run->probes != NULL && fputs("step,time_s", run->probes) >= 0;
  for (int32_t n = 0; done && n < thrum_scene_probe_count(run->scene); n++) {
    const char *p = thrum_scene_probe_name(run->scene, n);
    done = fprintf(run->probes, ",%s.x_m,%s.y_m,%s.z_m,%s.vx_m_s,%s.vy_m_s,%s.vz_m_s", p, p, p, p,
                   p, p) > 0;
  }
  done = done && fputc('\n', run->probes) != EOF;
  return done ? THRUM_OK : write_failed(run, CLI_SCENE_PROBES, error);
}

thrum_status scene_run_open(scene_run *run, thrum_error *error) {
  thrum_status status = cli_scene_folder_open(run->request->output, &run->folder, error);
  for (int32_t n = 0; n < run->spec.bodies.count && status >= 0; n++)
    status = open_body(run, n, error);
  return status >= 0 ? open_probes(run, error) : status;
}

/* --- rows --------------------------------------------------------------------------------------
 */

static thrum_status write_probes(scene_run *run, int64_t step, thrum_error *error) {
  if (run->probes == NULL)
    return THRUM_OK;
  errno = 0;
  bool done = fprintf(run->probes, "%" PRId64 ",%.17g", step, time_at(run, step)) > 0;
  for (int32_t n = 0; n < thrum_scene_probe_count(run->scene); n++) {
    double x[3], v[3];
    const thrum_status status = thrum_scene_probe(run->scene, n, x, v, error);
    if (status < 0)
      return status;
    done = done && fprintf(run->probes, ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", x[0], x[1], x[2],
                           v[0], v[1], v[2]) > 0;
  }
  done = done && fputc('\n', run->probes) != EOF;
  return done ? THRUM_OK : write_failed(run, CLI_SCENE_PROBES, error);
}

/* Where a free body is. */
static thrum_status record_place(scene_run *run, int32_t n, thrum_error *error) {
  double matrix[16];
  thrum_scene_body_matrix(run->scene, n, matrix);
  return cli_run_output_place(&run->bodies[n].output, matrix, error);
}

/* What a body is at this step, into its figures; and into a row of its series. */
static thrum_status record_body(scene_run *run, int32_t n, int64_t step, bool row,
                                const thrum_scene_energies *now, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  simulate_figures *figures = &body->figures;
  const thrum_energies energies = {now->kinetic, now->potential, now->kinetic + now->potential,
                                   now->high};
  thrum_status status = thrum_scene_body_shape(run->scene, n, body->q, error);
  if (status >= 0 && body->model->basis != NULL)
    status = thrum_displacement_peak(body->model, body->extents, body->q, &figures->peak,
                                     &figures->peak_vertex, error);
  if (status >= 0)
    status = simulate_measures_look(&body->measures, body->q, time_at(run, step), error);
  if (status < 0)
    return status;
  simulate_figures_add(figures, row ? body->output.rows : -1, &energies);
  if (!row)
    return THRUM_OK;
  status =
      cli_run_output_record(&body->output, step, time_at(run, step), body->q, &energies, error);
  return status >= 0 && body->spec->free ? record_place(run, n, error) : status;
}

thrum_status scene_run_record(scene_run *run, int64_t step, bool row, thrum_error *error) {
  const int32_t count = (int32_t)run->spec.bodies.count;
  thrum_scene_energies *energies = calloc((size_t)count, sizeof *energies);
  thrum_status status = THRUM_OK;
  if (energies == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a row");
  // all are looked at first: a row is of all bodies or of none
  for (int32_t n = 0; n < count && status >= 0; n++)
    status = thrum_scene_body_energies(run->scene, n, &energies[n], error);
  if (status == THRUM_NOT_FINITE && step > 0) {
    // the states are finite, an energy is not any more: the run ends here, the rows before stand
    run->status = status;
    thrum_error_set(&run->stop, THRUM_OK, "%s", error->message);
    free(energies);
    return THRUM_OK;
  }
  for (int32_t n = 0; n < count && status >= 0; n++)
    status = record_body(run, n, step, row, &energies[n], error);
  free(energies);
  run->rows += row;
  return status >= 0 && row ? write_probes(run, step, error) : status;
}

/* --- frames ------------------------------------------------------------------------------------
 */

/* Displacements in the world, from where the body was placed. */
static thrum_status world_displacements(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  double matrix[16], *u = body->output.displacement;
  const int64_t count = body->model->vertex_count;
  const thrum_status status = thrum_displacement(body->model, body->q, 0, count, u, error);
  thrum_scene_body_matrix(run->scene, n, matrix);
  for (int64_t v = 0; status >= 0 && v < count; v++) {
    const double *rest = body->model->vertices + 3 * v;
    const double in[3] = {rest[0] + u[3 * v], rest[1] + u[3 * v + 1], rest[2] + u[3 * v + 2]};
    cli_run_place_point(matrix, in, u + 3 * v);
    for (int axis = 0; axis < 3; axis++)
      u[3 * v + axis] -= body->vertices[3 * v + axis];
  }
  return status;
}

thrum_status scene_run_frame(scene_run *run, int64_t step, thrum_error *error) {
  static const double still[3] = {0};
  const double time = time_at(run, step);
  thrum_status status = THRUM_OK;
  for (int32_t n = 0; n < run->spec.bodies.count && status >= 0; n++) {
    scene_body_run *body = &run->bodies[n];
    status = thrum_scene_body_shape(run->scene, n, body->q, error);
    if (status >= 0)
      status = simulate_measures_look(&body->measures, body->q, time, error);
    if (status >= 0)
      status = world_displacements(run, n, error);
    if (status >= 0)
      status = cli_run_output_frame_of(&body->output, time, still, body->measures.von_mises, error);
  }
  run->frames += status >= 0;
  return status;
}

/* --- the end -----------------------------------------------------------------------------------
 */

/* What the engine and the run know of a body, into the figures of its own run. */
static void finish_figures(scene_run *run, int32_t n) {
  simulate_figures *figures = &run->bodies[n].figures;
  thrum_scene_body_info info;
  thrum_scene_body(run->scene, n, &info, NULL);
  figures->report = info.report;
  figures->report.time = time_at(run, info.report.steps);
  figures->fallback_steps = info.fallback_steps;
  figures->work_load = info.work_load;
  figures->work_base = info.work_base;
  figures->dissipated = info.dissipated;
  figures->peak *= info.scale;
  figures->seconds_step = NAN; // bodies of one model are stepped side by side
  figures->seconds_read = figures->seconds_output = figures->seconds_plot = NAN;
  figures->seconds_total = NAN;
  if (run->status < 0) {
    figures->status = info.status < 0 ? info.status : run->status;
    figures->stop = run->stop;
  } else if (info.fallback_steps > 0) {
    figures->status = THRUM_FELL_BACK;
  }
  simulate_figures_end(figures);
}

/* Where the body stands in its scene, besides the figures of a run. */
static cJSON *placement_json(const scene_run *run, const scene_body_run *body) {
  const scene_body_spec *spec = body->spec;
  cJSON *object = cJSON_CreateObject();
  json_string(object, "scene", run->request->path);
  cJSON_AddStringToObject(object, "name", spec->name);
  json_numbers(object, "position_m", spec->position, 3);
  json_numbers(object, "rotation_wxyz", spec->rotation, 4);
  json_number(object, "scale", spec->scale);
  json_number(object, "stiffness", spec->stiffness);
  json_number(object, "density", spec->density);
  cJSON_AddBoolToObject(object, "free", spec->free);
  return object;
}

/* What contact did to a body; null where nothing can touch it. */
static void add_contact(const scene_run *run, const thrum_scene_body_info *info, cJSON *object) {
  const thrum_contact_report *contact = &info->contact;
  if (run->spec.obstacles.count == 0 || contact->steps == 0) {
    cJSON_AddNullToObject(object, "contact");
    return;
  }
  cJSON *report = cJSON_AddObjectToObject(object, "contact");
  json_number(report, "touching", contact->touching);
  json_number(report, "normal_n", contact->normal);
  json_number(report, "depth_m", contact->depth);
  json_number(report, "stored_j", contact->stored);
  json_number(report, "lost_j", contact->lost);
  json_number(report, "driven_j", contact->driven);
  json_number(report, "granted_j", contact->granted);
  json_number(report, "redone_steps", (double)contact->redone);
  json_number(report, "declined_steps", (double)contact->declined);
  json_number(report, "dropped_touches", (double)contact->dropped);
}

static thrum_status end_body(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  char title[256];
  double *p = body->extents; // no longer needed
  thrum_status status = thrum_scene_body_get(run->scene, n, body->q, p, error);
  const bool whole = status >= 0;
  if (whole || status == THRUM_NOT_FINITE)
    status = cli_run_output_end(&body->output, whole ? body->q : NULL, p, error);
  if (status < 0)
    return status;
  snprintf(title, sizeof title, "%.60s: %s, dt = %g s", body->spec->name,
           thrum_integrator_name(body->request.def.integrator), run->dt);
  if (run->spec.outputs.plots)
    cli_run_output_plot(&body->output, title);
  finish_figures(run, n);
  cJSON *object = simulate_report_json(&body->figures, &body->output, &body->measures);
  cJSON_AddItemToObject(object, "placement", placement_json(run, body));
  thrum_scene_body_info info;
  thrum_scene_body(run->scene, n, &info, NULL);
  add_contact(run, &info, object);
  status = cli_run_output_commit(&body->output, object, error);
  cJSON_Delete(object);
  return status;
}

thrum_status scene_run_end(scene_run *run, thrum_error *error) {
  thrum_status status = THRUM_OK;
  errno = 0;
  if (run->probes != NULL) {
    const bool done =
        fflush(run->probes) == 0 && ferror(run->probes) == 0 && fsync(fileno(run->probes)) == 0;
    if (fclose(run->probes) != 0 || !done)
      status = write_failed(run, CLI_SCENE_PROBES, error);
    run->probes = NULL;
  }
  for (int32_t n = 0; n < run->spec.bodies.count && status >= 0; n++)
    status = end_body(run, n, error);
  return status;
}
