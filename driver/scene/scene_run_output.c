/* The files of a scene's run: for each body those of a run of it alone, and the probes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_output.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>

#include "driver/record/run_placement.h"
#include "driver/run/simulate_report.h"
#include "driver/scene/scene_run_account.h"
#include "driver/scene/scene_run_contact.h"
#include "driver/scene/scene_run_judge.h"
#include "driver/scene/scene_run_link.h"
#include "io/json.h"
#include "platform/stop_request.h"

/* --- opening ---------------------------------------------------------------------------------- */

/* The model with the stiffness and density that the body has, for stresses. */
static bool scale_material(scene_body_run *body) {
  const thrum_model *model = body->model;
  const size_t count = (size_t)model->region_count;
  body->shown = *model;
  if (model->material == NULL)
    return true;

  // Young's modulus and density are scaled, Poisson's ratio is not
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

/* Moves the vertices of a body to where the body stands, for frames. */
static bool place_vertices(const scene_run *run, int32_t n) {
  scene_body_run *body = &run->bodies[n];
  const size_t count = (size_t)body->model->vertex_count;
  double matrix[16];
  body->vertices = malloc(3 * count * sizeof *body->vertices + 1);
  if (body->vertices == NULL)
    return false;
  thrum_scene_body_matrix(run->scene, n, matrix);
  for (size_t v = 0; v < count; v++)
    run_placement_point(matrix, body->model->vertices + 3 * v, body->vertices + 3 * v);
  body->shown.vertices = body->vertices;
  return true;
}

/* Refuses an output that this body cannot have, by its key; what is no output, such as a file that
 * cannot be written, has its own words. */
static thrum_status refuse_outputs(const scene_run *run, const scene_body_run *body,
                                   thrum_status status, const thrum_error *detail,
                                   thrum_error *error) {
  if (detail->field != NULL)
    return config_record_refuse(&run->spec.file, &run->spec.outputs.at, detail->field + 2, status,
                                "body '%.64s': %s", body->spec->name, thrum_error_reason(detail));
  return thrum_error_set(error, status, "%s", detail->message);
}

/* Does more act on a body than its loads, or is it more than a model on a ground? */
static bool is_judged_together(const scene_run *run, int32_t n) {
  const scene_body_run *body = &run->bodies[n];
  const scene_body_spec *spec = body->spec;
  return spec->scale != 1 || spec->stiffness != 1 || spec->density != 1 || spec->free ||
         run->spec.wind.at.node != NULL || scene_run_is_met(run, n);
}

static thrum_status open_body(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  const scene_outputs_spec *outputs = &run->spec.outputs;
  const bool frames = outputs->frames_rate > 0 || outputs->frames_every > 0;
  char path[RUN_PATH_MAX + 80];
  if (!scale_material(body))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for body '%s'", body->spec->name);
  body->request.basis.together = is_judged_together(run, n);
  if (body->spec->detail.jump > 0)
    body->request.basis.unless = "the body steps fewer coordinates at times";
  else if (body->request.basis.together)
    body->request.basis.unless = scene_run_why_not_judged(run, n);
  if (body->request.actuate_count > 0)
    body->request.basis.unless = "the mesh that would be asked has no actuators";
  snprintf(path, sizeof path, "%.*s/%s", RUN_PATH_MAX, run->folder.work, body->spec->name);
  thrum_error detail = {0};
  const thrum_status opened = driver_run_open_body(&run->run, n, path, &body->shown, &detail);
  if (opened < 0)
    return refuse_outputs(run, body, opened, &detail, error);

  // a basis is judged as it is in the file, wherever the body stands
  run->run.bodies[n].measures.basis.model = body->model;

  // measures are of the body at rest in its own axes, frames of the body in place
  if (frames && body->model->vertices != NULL && !place_vertices(run, n))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for frames of body '%s'",
                           body->spec->name);

  // what wind, contact and links give and take is no drift, and not counted as work
  if (run->spec.wind.at.node != NULL || scene_run_is_met(run, n)) {
    run->run.bodies[n].figures.windows = (driver_drift){0};
    run->run.bodies[n].figures.uncounted = true;
  }

  // loads and gravity also work on the motion of a free body as a whole, and that work is not added
  // up
  if (body->spec->free)
    run->run.bodies[n].figures.uncounted = true;
  return THRUM_OK;
}

static thrum_status open_probes(scene_run *run, thrum_error *error) {
  if (thrum_scene_probe_count(run->scene) == 0)
    return THRUM_OK;

  // six columns for each probe
  errno = 0;
  run->probes = run_folder_create(&run->folder, SCENE_PROBES);
  bool done = run->probes != NULL && fputs("step,time_s", run->probes) >= 0;
  for (int32_t n = 0; done && n < thrum_scene_probe_count(run->scene); n++) {
    const char *p = thrum_scene_probe_name(run->scene, n);
    done = fprintf(run->probes, ",%s.x_m,%s.y_m,%s.z_m,%s.vx_m_s,%s.vy_m_s,%s.vz_m_s", p, p, p, p,
                   p, p) > 0;
  }

  done = done && fputc('\n', run->probes) != EOF;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_PROBES, error);
}

thrum_status scene_run_open(scene_run *run, thrum_error *error) {
  THRUM_TRY(run_folder_open(run->request->output, RUN_OF_SCENE, &run->folder, error));
  for (int32_t n = 0; n < run->spec.bodies.count; n++)
    THRUM_TRY(open_body(run, n, error));
  THRUM_TRY(scene_run_open_account(run, error));
  THRUM_TRY(scene_run_open_contact(run, error));
  THRUM_TRY(scene_run_open_links(run, error));
  return open_probes(run, error);
}

/* --- rows ------------------------------------------------------------------------------------- */

thrum_status scene_run_record_probes(scene_run *run, int64_t step, double time,
                                     thrum_error *error) {
  if (run->probes == NULL)
    return THRUM_OK;
  errno = 0;
  bool done = fprintf(run->probes, "%" PRId64 ",%.17g", step, time) > 0;

  // position and velocity of each probe
  for (int32_t n = 0; n < thrum_scene_probe_count(run->scene); n++) {
    double x[3], v[3];
    THRUM_TRY(thrum_scene_probe_get(run->scene, n, x, v, error));

    done = done && fprintf(run->probes, ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", x[0], x[1], x[2],
                           v[0], v[1], v[2]) > 0;
  }
  done = done && fputc('\n', run->probes) != EOF;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_PROBES, error);
}

/* --- the end ---------------------------------------------------------------------------------- */

/* Where the body stands in its scene, besides the figures of a run. */
static cJSON *placement_json(const scene_run *run, const scene_body_run *body) {
  const scene_body_spec *spec = body->spec;
  cJSON *object = cJSON_CreateObject();
  json_string(object, "scene", run->request->path);
  cJSON_AddStringToObject(object, "name", spec->name);

  // viewers place the body by these
  json_numbers(object, "position_m", spec->position, 3);
  json_numbers(object, "rotation_wxyz", spec->rotation, 4);
  json_number(object, "scale", spec->scale);
  const double colour[3] = {(double)spec->colour[0], (double)spec->colour[1],
                            (double)spec->colour[2]};
  json_numbers(object, "colour", colour, 3);

  // factors of its material, and whether it moves as a whole
  json_number(object, "stiffness", spec->stiffness);
  json_number(object, "density", spec->density);
  cJSON_AddBoolToObject(object, "free", spec->free);
  cJSON_AddBoolToObject(object, "coupled", body->def.coupled);
  cJSON_AddBoolToObject(object, "coupled_by_default", body->coupled_by_default);
  cJSON_AddBoolToObject(object, "self_contact", spec->self_contact);
  return object;
}

/* Forces and energies of the contact of a body; null where nothing can touch it. */
static void add_contact(const scene_run *run, const thrum_scene_body_info *info, cJSON *object) {
  const thrum_contact_report *contact = &info->contact;
  cJSON *report =
      json_section(object, "contact", run->spec.obstacles.count > 0 && contact->steps > 0);
  if (report == NULL)
    return;

  // forces and depth at the end, then the energy exchanged over the run
  scene_run_add_touches(report, contact);

  // steps that contact made difficult
  json_number(report, "redone_steps", (double)contact->redone);
  json_number(report, "declined_steps", (double)contact->declined);
  json_number(report, "dropped_touches", (double)contact->dropped);
}

/* The plot and run.json of a body, which say that its own run is whole. */
static thrum_status complete_body(scene_run *run, int32_t n, thrum_error *error) {
  const scene_body_run *body = &run->bodies[n];
  driver_body *record = &run->run.bodies[n];
  thrum_scene_body_info info;

  // the plot is drawn from energy.csv, which is closed by now
  char title[256];
  snprintf(title, sizeof title, "%.60s, stepped by %s, dt = %g s", body->spec->name,
           thrum_integrator_name(body->request.def.integrator), run->dt);
  if (run->spec.outputs.plots)
    run_output_plot(&record->output, title);

  // run.json comes last: it says that the body's run is whole
  cJSON *object = simulate_report_json(record);
  cJSON_AddItemToObject(object, "placement", placement_json(run, body));
  thrum_scene_body(run->scene, n, &info, NULL);
  add_contact(run, &info, object);

  const thrum_status status = run_output_commit(&record->output, object, error);
  cJSON_Delete(object);
  return status;
}

static thrum_status complete_bodies(scene_run *run, thrum_error *error) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++)
    THRUM_TRY(complete_body(run, n, error));
  return THRUM_OK;
}

thrum_status scene_run_end(scene_run *run, thrum_error *error) {
  errno = 0;
  if (!run_folder_close_file(&run->probes))
    return run_folder_write_failed(&run->folder, SCENE_PROBES, error);
  if (!run_folder_close_file(&run->account))
    return run_folder_write_failed(&run->folder, SCENE_ACCOUNT, error);
  if (!run_folder_close_file(&run->contact))
    return run_folder_write_failed(&run->folder, SCENE_CONTACT, error);
  THRUM_TRY(scene_run_end_links(run, error));
  THRUM_TRY(driver_run_end(&run->run, error));
  THRUM_TRY(scene_run_judge(run, error));
  thrum_stop_request_end_by(NULL, NULL);
  return complete_bodies(run, error);
}

thrum_status scene_run_end_unjudged(scene_run *run, thrum_error *error) {
  for (int32_t n = 0; n < run->run.body_count; n++) {
    run->run.bodies[n].measures.basis.estimate = basis_estimate_none("it was stopped");
    run->run.bodies[n].figures.basis_wrong = false;
  }
  return complete_bodies(run, error);
}
