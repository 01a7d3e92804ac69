/* Everything that acts on the bodies of an archive over time: starts, loads, links, base motion,
 * wind. Loads, links and starts are read off the scene that `thrum simulate` would step, so that
 * the page has the same numbers. SPDX-License-Identifier: Apache-2.0 */
#include <cjson/cJSON.h>
#include <stdint.h>

#include "app/view/view_archive.h"
#include "io/json.h"
#include "thrum/thrum.h"

/* The course of a load, whose rows are those of loads that are keys. */
static void add_course(cJSON *object, const thrum_load *course) {
  static const char *const names[] = {"constant", "sine", "ramp"};
  thrum_scene_load_def load = thrum_default_scene_load_def();
  load.course = *course;
  cJSON_AddStringToObject(object, "shape", names[course->shape]);
  view_archive_add_fields(object, THRUM_SCENE_RECORD_LOAD, &load);
}

/* q and p are of the body's rank at most, and small beside its model. */
static void add_start(cJSON *body, const scene_run *run, int32_t n) {
  const int64_t rank = run->bodies[n].model->rank;
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  if (run->bodies[n].spec->start.count == 0 || thrum_scene_body_get(run->scene, n, q, p, NULL) < 0)
    return;
  json_numbers(body, "q", q, rank);
  json_numbers(body, "p", p, rank);
}

void view_archive_add_loads(cJSON *body, const scene_run *run, int32_t n) {
  const int64_t rank = run->bodies[n].model->rank;
  add_start(body, run, n);
  cJSON *loads = cJSON_AddArrayToObject(body, "loads");
  for (int64_t l = 0; l < thrum_scene_load_count(run->scene, n); l++) {
    thrum_scene_load_def load;
    cJSON *object = json_add_row(loads);
    if (thrum_scene_load_get(run->scene, n, l, &load, NULL) < 0)
      continue;
    add_course(object, &load.course);

    // a free body also moves as a whole
    json_numbers(object, "reduced", load.reduced, rank);
    if (load.parts == NULL)
      continue;
    json_numbers(object, "parts", load.parts, 9 * rank);
    json_numbers(object, "moments", load.moments, 9);
    json_numbers(object, "resultant", load.resultant, 3);
  }
}

/* A side of a link on a body: what its place and directions are at rest, and their rows. */
static void add_side(cJSON *object, const char *rest, const char *rows,
                     const thrum_scene_link_side *side) {
  json_numbers(object, rest, side->rest, 12);
  if (side->rows != NULL)
    json_numbers(object, rows, side->rows, 12 * side->rank);
}

static cJSON *link_of(const scene_link_spec *spec, const thrum_scene_link_def *made) {
  cJSON *object = cJSON_CreateObject();
  if (spec->name != NULL)
    json_string(object, "name", spec->name);
  cJSON_AddStringToObject(object, "kind", scene_link_names[made->kind]);
  json_number(object, "body", made->body);
  if (made->other >= 0)
    json_number(object, "other", made->other);
  view_archive_add_fields(object, THRUM_SCENE_RECORD_LINK, made);
  add_side(object, "rest", "rows", &made->sides[0]);
  add_side(object, "other_rest", "other_rows", &made->sides[1]);

  // most links have no path
  if (made->path_count == 0)
    return object;
  json_numbers(object, "times", made->path_times, made->path_count);
  json_numbers(object, "places", made->path_places, 3 * made->path_count);
  return object;
}

void view_archive_add_links(cJSON *scene, const scene_run *run) {
  cJSON *links = cJSON_AddArrayToObject(scene, "links");
  for (int32_t n = 0; n < thrum_scene_link_count(run->scene); n++) {
    thrum_scene_link_def made;
    if (thrum_scene_link_made(run->scene, n, &made, NULL) >= 0)
      cJSON_AddItemToArray(links, link_of(&scene_links(&run->spec)[n], &made));
  }
}

static cJSON *base_motion_of(const base_motion_spec *base_motion) {
  const thrum_base_motion *motion = &base_motion->motion;
  cJSON *object = cJSON_CreateObject();
  if (base_motion->sine) {
    json_numbers(object, "amplitude", base_motion->amplitude, 3);
    add_course(object, &base_motion->course);
    return object;
  }
  json_numbers(object, "times", motion->times, motion->count);
  json_numbers(object, "accelerations", motion->accelerations, 3 * motion->count);
  json_numbers(object, "velocities", motion->velocities, 3 * motion->count);
  json_numbers(object, "positions", motion->positions, 3 * motion->count);
  return object;
}

void view_archive_add_air_and_ground(cJSON *scene, const scene_run *run) {
  const scene_wind_spec *wind = &run->spec.wind;
  cJSON *base_motions = cJSON_AddArrayToObject(scene, "base_motion");
  for (int64_t n = 0; n < run->base_motion_count; n++)
    cJSON_AddItemToArray(base_motions, base_motion_of(&run->base_motions[n]));
  if (wind->at.node == NULL)
    return;
  cJSON *object = cJSON_AddObjectToObject(scene, "wind");
  json_numbers(object, "velocity", wind->velocity, 3);
  json_number(object, "density", wind->density);
  json_number(object, "drag", wind->drag);
}
