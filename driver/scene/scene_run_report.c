/* The report of a scene's run: a table for people, one JSON object for programs and scene.json.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_report.h"

#include <inttypes.h>
#include <math.h>

#include "driver/model/locking.h"
#include "driver/model/step_cost.h"
#include "driver/run/simulate_report.h"
#include "driver/scene/scene_run_account.h"
#include "driver/scene/scene_run_contact.h"
#include "driver/scene/scene_run_couple.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"
#include "platform/clock.h"
#include "runtime/material/material_law.h"

#define DETAIL_LINES 8 /* bodies that each have one */
#define ERROR_LINES 8

static double per_step(const scene_run *run, double value) {
  const int64_t steps = driver_run_step_count(&run->run);
  return steps > 0 ? value / (double)steps : NAN;
}

/* Adds what "error" and "budget" asked for, and what was found. */
static void add_finding(cJSON *object, const scene_body_run *body) {
  static const char *const by[] = {NULL, "trials", "another body", "an earlier run"};
  const scene_finding *finding = &body->finding;
  if (finding->by == SCENE_NOT_ASKED)
    return;

  // the error is that of the trial runs, also where a budget alone was given
  if (body->spec->error > 0)
    json_number(object, "error_asked", body->spec->error);
  json_number(object, "error_found", finding->error);
  cJSON_AddStringToObject(object, "found_by", by[finding->by]);
  if (!(body->spec->budget > 0))
    return;

  // masters of 0 step all coordinates
  const int64_t rank = body->model->rank, masters = finding->masters;
  json_number(object, "budget_s", body->spec->budget);
  json_number(object, "cost_s",
              step_cost(&body->request.def, masters > 0 ? masters : rank,
                        masters > 0 ? rank - masters : 0));
}

/* Adds what the level of detail did. */
static void add_detail(cJSON *object, const scene_run *run, int32_t n) {
  const scene_detail_spec *spec = &run->bodies[n].spec->detail;
  thrum_scene_detail_report report;
  if (thrum_scene_body_detail(run->scene, n, &report, NULL) < 0 || !report.set)
    return;
  cJSON *item = cJSON_AddObjectToObject(object, "detail");
  json_number(item, "condense", (double)spec->condense);
  json_number(item, "jump_m", spec->jump);
  json_number(item, "largest_jump_m", report.largest_jump);
  json_number(item, "changes", (double)report.changes);
  json_number(item, "put_off", (double)report.put_off);
  json_number(item, "reduced_steps", (double)report.reduced_steps);
  json_number(item, "energy_j", report.energy);
  json_number(item, "distance_m", report.distance);
  json_number(item, "speed_bound_m_s", report.speed);
}

/* A body's line in the scene's report; its own run.json says more. */
static cJSON *body_json(const scene_run *run, int32_t n) {
  const scene_body_run *body = &run->bodies[n];
  const simulate_figures *figures = &run->run.bodies[n].figures;
  char stepped_by[128];
  cJSON *object = cJSON_CreateObject();

  // which body, and what steps it
  cJSON_AddStringToObject(object, "name", body->spec->name);
  cJSON_AddStringToObject(object, "status", run_outcome_word(simulate_outcome(figures)));
  json_string(object, "model", body->spec->model);
  cJSON_AddStringToObject(object, "integrator",
                          thrum_integrator_name(body->request.def.integrator));
  simulate_figures_stepped_by(figures, stepped_by);
  cJSON_AddStringToObject(object, "stepped_by", stepped_by);
  cJSON_AddStringToObject(object, "law", thrum_law_name(thrum_law_of_model(body->model)));
  json_number(object, "rank", (double)body->model->rank);
  locking_json(object, body->model);
  simulate_report_condensed(object, figures);
  add_finding(object, body);
  add_detail(object, run, n);

  // its place and the factors of its material
  json_numbers(object, "position_m", body->spec->position, 3);
  json_numbers(object, "rotation_wxyz", body->spec->rotation, 4);
  json_number(object, "scale", body->spec->scale);
  json_number(object, "stiffness", body->spec->stiffness);
  json_number(object, "density", body->spec->density);
  cJSON_AddBoolToObject(object, "coupled", body->def.coupled);
  cJSON_AddBoolToObject(object, "coupled_by_default", body->coupled_by_default);

  // its energy and how well the run kept it
  json_number(object, "energy_first_j", figures->first.total);
  json_number(object, "energy_last_j", figures->last.total);
  json_number(object, "energy_max_j", figures->energy_max);
  json_number(object, "drift", figures->drift);
  json_number(object, "plastic_work_j", figures->plastic_work);
  json_number(object, "peak_displacement_m", figures->peak);
  if (run->run.bodies[n].measures.basis_asked)
    basis_estimate_json(&run->run.bodies[n].measures.basis.estimate, object);
  json_number(object, "fallback_steps", (double)figures->fallback_steps);
  json_number(object, "grown_steps", (double)figures->report.grown_steps);
  return object;
}

static cJSON *wind_json(const scene_wind_spec *wind) {
  if (wind->at.node == NULL)
    return cJSON_CreateNull();
  cJSON *object = cJSON_CreateObject();
  json_numbers(object, "velocity_m_s", wind->velocity, 3);
  json_number(object, "density_kg_m3", wind->density);
  json_number(object, "drag", wind->drag);
  return object;
}

static cJSON *obstacles_json(const scene_run *run) {
  cJSON *list = cJSON_CreateArray();
  for (int64_t n = 0; n < run->spec.obstacles.count; n++) {
    const scene_obstacle_spec *spec = &scene_obstacles(&run->spec)[n];

    // only the keys of its shape
    cJSON *object = json_add_row(list);
    if (spec->name != NULL)
      json_string(object, "name", spec->name);
    cJSON_AddStringToObject(object, "shape", scene_shape_names[spec->shape]);
    json_numbers(object, "centre_m", spec->centre, 3);
    if (spec->shape == SCENE_PLANE)
      json_numbers(object, "normal", spec->normal, 3);
    if (spec->radius > 0)
      json_number(object, "radius_m", spec->radius);
    if (spec->shape == SCENE_CYLINDER || spec->shape == SCENE_CAPSULE)
      json_number(object, "height_m", spec->height);
    if (spec->shape == SCENE_BOX)
      json_numbers(object, "size_m", spec->size, 3);
    if (spec->shape == SCENE_MESH)
      json_string(object, "file", spec->path);
    if (spec->shape >= SCENE_BOX)
      json_numbers(object, "rotation_wxyz", spec->rotation, 4);

    // motion and contact are of any shape
    cJSON_AddBoolToObject(object, "inside", spec->inside);
    json_numbers(object, "velocity_m_s", spec->velocity, 3);
    json_number(object, "friction", spec->friction);
    json_number(object, "restitution", spec->restitution);
  }
  return list;
}

static cJSON *probes_json(const scene_run *run) {
  cJSON *list = cJSON_CreateArray();
  for (int64_t n = 0; n < run->spec.probes.count; n++) {
    const scene_probe_spec *probe = &scene_probes(&run->spec)[n];
    cJSON *object = json_add_row(list);
    cJSON_AddStringToObject(object, "name", probe->name);
    cJSON_AddStringToObject(object, "body", probe->body);
    json_string(object, "at", probe->target);
  }
  return list;
}

cJSON *scene_run_json(const scene_run *run) {
  const scene_spec *spec = &run->spec;
  cJSON *object = simulate_report_begin(run_outcome_word(scene_run_outcome(run)), &run->run.stop);

  // the files
  json_string(object, "scene", run->request->path);
  if (spec->title != NULL)
    json_string(object, "title", spec->title);
  json_string(object, "run", run->request->output);

  // what acts on all bodies
  json_number(object, "dt_s", run->dt);
  json_numbers(object, "gravity_m_s2", spec->gravity, 3);
  cJSON_AddItemToObject(object, "wind", wind_json(&spec->wind));
  json_strings(object, "base_motion", spec->base_motion.texts, spec->base_motion.count);

  // how far the run came and at what cost
  json_number(object, "steps", (double)driver_run_step_count(&run->run));
  json_number(object, "simulated_s", (double)driver_run_step_count(&run->run) * run->dt);
  json_number(object, "us_per_step", per_step(run, 1e6 * run->run.seconds_step));
  json_number(object, "rows", (double)run->run.rows);
  json_number(object, "frames", (double)run->run.frames);

  // bodies, obstacles and probes in the order of the file
  cJSON *bodies = cJSON_AddArrayToObject(object, "bodies");
  for (int32_t n = 0; n < spec->bodies.count; n++)
    cJSON_AddItemToArray(bodies, body_json(run, n));
  cJSON_AddItemToObject(object, "obstacles", obstacles_json(run));
  cJSON_AddItemToObject(object, "collisions", scene_run_collisions_json(run));
  cJSON_AddItemToObject(object, "links", scene_run_links_json(run));
  cJSON_AddItemToObject(object, "probes", probes_json(run));

  // where the time went
  cJSON *seconds = cJSON_AddObjectToObject(object, "seconds");
  json_number(seconds, "read", run->seconds_read);
  json_number(seconds, "find", run->seconds_find);
  json_number(seconds, "step", run->run.seconds_step);
  json_number(seconds, "output", run->seconds_output);
  json_number(seconds, "total", run->seconds_total);
  json_number(object, "peak_mb", clock_peak_mb());
  return object;
}

/* "2 of 20" coordinates that are stepped near, or "20". */
static void name_stepped(const scene_body_run *body, const simulate_figures *figures, char *text,
                         size_t size) {
  if (figures->masters > 0)
    snprintf(text, size, "%d of %d", (int)figures->masters, (int)body->model->rank);
  else
    snprintf(text, size, "%d", (int)body->model->rank);
}

/* Prints what the levels of detail did: a line for each body where they are few, else one for all.
 */
static void print_details(const scene_run *run) {
  int64_t steps = 0, reduced = 0, changes = 0;
  double jump = 0;

  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_spec *spec = run->bodies[n].spec;
    thrum_scene_detail_report report;
    if (thrum_scene_body_detail(run->scene, n, &report, NULL) < 0 || !report.set)
      continue;

    // the sum over bodies
    const int64_t all = driver_run_step_count(&run->run);
    steps += all;
    reduced += report.reduced_steps;
    changes += report.changes;
    jump = fmax(jump, report.largest_jump);

    // and the body's own line
    if (run->spec.bodies.count <= DETAIL_LINES)
      printf("detail       %s: %" PRId64 " coordinates in %.3g %% of the steps, %" PRId64
             " change%s, largest jump %.2g m (at most %g m)\n",
             spec->name, spec->detail.condense,
             all > 0 ? 100 * (double)report.reduced_steps / (double)all : 0, report.changes,
             report.changes == 1 ? "" : "s", report.largest_jump, spec->detail.jump);
  }

  if (steps > 0 && run->spec.bodies.count > DETAIL_LINES)
    printf("detail       fewer coordinates in %.3g %% of the steps of bodies that may, %" PRId64
           " change%s, largest jump %.2g m\n",
           100 * (double)reduced / (double)steps, changes, changes == 1 ? "" : "s", jump);
}

/* Prints what is known of the error by the bases: a line for each body where they are few, else for
 * the one that is most wrong. */
static void print_errors(const scene_run *run) {
  const int64_t count = run->spec.bodies.count;
  const double end = (double)driver_run_step_count(&run->run) * run->dt;
  int64_t worst = -1;
  for (int64_t n = 0; n < count; n++) {
    const simulate_measures *of = &run->run.bodies[n].measures;
    if (!of->basis_asked)
      continue;
    if (count <= ERROR_LINES)
      simulate_measures_error(of, run->bodies[n].spec->name, end);
    else if (of->basis.estimate.why == NULL &&
             (worst < 0 ||
              of->basis.estimate.share > run->run.bodies[worst].measures.basis.estimate.share))
      worst = n;
  }
  if (worst >= 0)
    simulate_measures_error(&run->run.bodies[worst].measures, run->bodies[worst].spec->name, end);
}

void scene_run_table(const scene_run *run) {
  const int64_t steps = driver_run_step_count(&run->run);
  if (run->spec.title != NULL)
    printf("scene        %s\n", run->spec.title);

  // the length of the run and the cost of a step
  printf("steps        %" PRId64 " (%g s)", steps,
         (double)driver_run_step_count(&run->run) * run->dt);
  if (steps > 0)
    printf(", %.2f us a step of all bodies", per_step(run, 1e6 * run->run.seconds_step));
  puts("");

  // a line for each body
  printf("%-12s %-8s %8s %12s %12s %12s %s\n", "body", "steps by", "rank", "first J", "last J",
         "peak m", "status");
  for (int64_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = &run->bodies[n];
    const simulate_figures *figures = &run->run.bodies[n].figures;
    char stepped[32];
    name_stepped(body, figures, stepped, sizeof stepped);
    printf("%-12s %-8s %8s %12.6g %12.6g %12.6g %s\n", body->spec->name,
           thrum_integrator_name(body->request.def.integrator), stepped, figures->first.total,
           figures->last.total, figures->peak, run_outcome_word(simulate_outcome(figures)));
  }

  print_details(run);
  scene_run_print_coupled(run);

  // the table names the integrators asked for, so bodies that switched are listed apart
  for (int64_t n = 0; n < run->spec.bodies.count; n++) {
    const simulate_figures *figures = &run->run.bodies[n].figures;
    char stepped_by[128];
    simulate_figures_stepped_by(figures, stepped_by);
    if (figures->report.switched_steps > 0)
      printf("switched     %s: %s\n", run->bodies[n].spec->name, stepped_by);
  }

  print_errors(run);

  // what bodies did to each other
  if (scene_run_touches(run)) {
    const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
    printf("collisions   bodies touch each other or themselves in %" PRId64
           " place%s at the end, %g J lost, %.2g of the thickness at most\n",
           of.touching, of.touching == 1 ? "" : "s", of.lost, of.deepest_share);
  }
  if (run->spec.obstacles.count > 0) {
    const thrum_contact_report of = scene_run_losses_get(run).obstacles;
    printf("obstacles    bodies touch them in %d place%s at the end, %g J lost\n", (int)of.touching,
           of.touching == 1 ? "" : "s", of.lost);
  }
  scene_run_print_links(run);

  // the end names the files, of which some are there only where the scene asks for them
  printf("status       %s\n", run_outcome_word(scene_run_outcome(run)));
  printf("files        %s/" SCENE_JSON "%s%s%s%s, and a run in each of its folders\n",
         run->request->output, thrum_scene_probe_count(run->scene) > 0 ? ", " SCENE_PROBES : "",
         scene_run_has_account(run) ? ", " SCENE_ACCOUNT : "",
         scene_run_has_contact(run) ? ", " SCENE_CONTACT : "",
         thrum_scene_link_count(run->scene) > 0 ? ", " SCENE_LINKS : "");
}
