/* The report of a scene's run: a table for people, one JSON object for programs and scene.json.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_report.h"

#include <math.h>
#include <string.h>

#include "driver/model/locking.h"
#include "driver/model/step_cost.h"
#include "driver/run/simulate_report.h"
#include "driver/scene/scene_run_account.h"
#include "driver/scene/scene_run_contact.h"
#include "driver/scene/scene_run_couple.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"
#include "io/report.h"
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
    basis_estimate_json(&run->run.bodies[n].measures.basis.estimate,
                        (double)driver_run_step_count(&run->run) * run->dt, object);
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

static const report_line lines[] = {
    REPORT_LINE("scene", "{title}"),
    REPORT_LINE("steps",
                "{steps} ({simulated_s:g} s)[, {us_per_step:.2f} us a step of all bodies]"),

    // a line for each body
    REPORT_LINE("body", "steps by     rank      first J       last J       peak m status"),
    REPORT_LINE("{name:-12s} ",
                "{integrator:-8s} {condensed?{condensed.masters:2s} of {rank:2s}|{rank:8s}} "
                "{energy_first_j:12.6g|           -} {energy_last_j:12.6g|           -} "
                "{peak_displacement_m:12.6g|           -} {status}",
                .each = "bodies"),
    REPORT_LINE("detail",
                "{name?{name}: {condense} coordinates|fewer coordinates} in {share:.3g%} of the "
                "steps{name?| of bodies that may}, {changes} change{changes#|s}, largest jump "
                "{largest_jump_m:.2g} m[ (at most {jump_m:g} m)]",
                .each = "details"),
    REPORT_LINE("coupled",
                "{turning.names}: {turning.count#it begins|they begin} to turn at "
                "{turning.count#|{turning.least:.2g} to }{turning.most:.2g} of "
                "{turning.count#its lowest frequency|their lowest frequencies}, so "
                "{turning.count#its spin and shape|their spins and shapes} act on each other "
                "(\"coupled\": false leaves that out, for an eighth of the time)"),

    // the table names the integrators asked for, so bodies that switched are listed apart
    REPORT_LINE("switched", "{name}: {stepped_by}", .each = "switched"),
    {0}};

static const report_line behind[] = {
    // what bodies did to each other
    REPORT_LINE("collisions",
                "bodies touch each other or themselves in {collisions.touching} "
                "place{collisions.touching#|s} at the end, {collisions.lost_j:g} J lost, "
                "{collisions.deepest_of_thickness:.2g} of the thickness at most"),
    REPORT_LINE("obstacles",
                "bodies touch them in {touched.touching} place{touched.touching#|s} at the end, "
                "{touched.lost_j:g} J lost"),
    REPORT_LINE(
        "links",
        "{joints.hold} of {joints.count} hold at the end, joints open by {joints.drift:.2g} "
        "m at most, {joints.stored:g} J in springs, {joints.lost:g} J lost, "
        "{joints.driven:g} J driven"),

    // the end names the files, of which some are there only where the scene asks for them
    REPORT_LINE("status", "{status}"),
    REPORT_LINE("files", "{run}/" SCENE_JSON "{probes?, " SCENE_PROBES "}{account?, " SCENE_ACCOUNT
                         "}{contact?, " SCENE_CONTACT "}{links?, " SCENE_LINKS
                         "}, and a run in each of its folders"),
    {0}};

/* Adds "details": what the levels of detail did, of each body where they are few, else of all. */
static void add_details(cJSON *more, const cJSON *report) {
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(report, "bodies"), *body = NULL;
  const bool few = cJSON_GetArraySize(bodies) <= DETAIL_LINES;
  const double steps = json_number_of(report, "steps");
  double all = 0, reduced = 0, changes = 0, jump = 0;
  cJSON *list = cJSON_AddArrayToObject(more, "details");
  cJSON_ArrayForEach(body, bodies) {
    const cJSON *detail = cJSON_GetObjectItemCaseSensitive(body, "detail");
    if (detail == NULL)
      continue;
    all += steps;
    reduced += json_number_of(detail, "reduced_steps");
    changes += json_number_of(detail, "changes");
    jump = fmax(jump, json_number_of(detail, "largest_jump_m"));
    cJSON *own = few ? cJSON_Duplicate(detail, true) : NULL;
    if (own == NULL)
      continue;
    json_string(own, "name", json_text_of(body, "name"));
    json_number(own, "share", steps > 0 ? json_number_of(detail, "reduced_steps") / steps : 0);
    cJSON_AddItemToArray(list, own);
  }
  if (few || !(all > 0))
    return;
  cJSON *sum = json_add_row(list);
  json_number(sum, "share", reduced / all);
  json_number(sum, "changes", changes);
  json_number(sum, "largest_jump_m", jump);
}

/* Adds "errors", the bodies whose error by the basis is told: all where they are few, else the one
 * that is most wrong; and "switched", those that another integrator stepped for a while. */
static void add_bodies(cJSON *more, const cJSON *report) {
  cJSON *bodies = cJSON_GetObjectItemCaseSensitive(report, "bodies"), *body = NULL, *worst = NULL;
  cJSON *errors = cJSON_AddArrayToObject(more, "errors");
  cJSON *switched = cJSON_AddArrayToObject(more, "switched");
  const bool few = cJSON_GetArraySize(bodies) <= ERROR_LINES;
  double most = -INFINITY;
  cJSON_ArrayForEach(body, bodies) {
    const char *by = json_text_of(body, "stepped_by"), *asked = json_text_of(body, "integrator");
    if (by != NULL && asked != NULL && strcmp(by, asked) != 0)
      cJSON_AddItemReferenceToArray(switched, body);
    if (few)
      cJSON_AddItemReferenceToArray(errors, body);
    const double share =
        json_number_of(cJSON_GetObjectItemCaseSensitive(body, "error_estimate"), "share");
    if (share > most) {
      worst = body;
      most = share;
    }
  }
  if (!few && worst != NULL)
    cJSON_AddItemReferenceToArray(errors, worst);
}

/* Adds "joints", all links together. */
static void add_joints(cJSON *more, const cJSON *report) {
  const cJSON *links = cJSON_GetObjectItemCaseSensitive(report, "links"), *link = NULL;
  double hold = 0, drift = 0, stored = 0, lost = 0, driven = 0;
  cJSON_ArrayForEach(link, links) {
    hold += cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(link, "holds"));
    drift = fmax(drift, json_number_of(link, "largest_drift_m"));
    stored += json_number_of(link, "stored_j");
    lost += json_number_of(link, "lost_j");
    driven += json_number_of(link, "driven_j");
  }
  cJSON *joints = json_section(more, "joints", cJSON_GetArraySize(links) > 0);
  if (joints == NULL)
    return;
  json_number(joints, "hold", hold);
  json_number(joints, "count", cJSON_GetArraySize(links));
  json_number(joints, "drift", drift);
  json_number(joints, "stored", stored);
  json_number(joints, "lost", lost);
  json_number(joints, "driven", driven);
}

void scene_run_table(const scene_run *run, const cJSON *report) {
  cJSON *more = cJSON_CreateObject();
  add_details(more, report);
  add_bodies(more, report);
  add_joints(more, report);
  scene_run_coupled_json(run, more);
  const scene_run_losses losses = scene_run_losses_get(run);
  if (run->spec.obstacles.count > 0)
    scene_run_add_touches(cJSON_AddObjectToObject(more, "touched"), &losses.obstacles);
  cJSON_AddBoolToObject(more, "account", scene_run_has_account(run));
  cJSON_AddBoolToObject(more, "contact", scene_run_has_contact(run));

  // the lines of the errors are those of one run, for each body
  report_print(report, more, REPORT_LABEL, lines);
  report_print_each(report, more, "errors", REPORT_LABEL, basis_estimate_lines);
  report_print(report, more, REPORT_LABEL, behind);
  cJSON_Delete(more);
}
