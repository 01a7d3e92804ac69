/* The scene of an archive: of models alone, or of a scene file. SPDX-License-Identifier: Apache-2.0
 */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/view/view_archive.h"
#include "driver/scene/scene_run_solid.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"
#include "thrum/thrum.h"

#define COLOUR "#4a86c5"

/* A scene has these where no file says otherwise: the default step and integrator, no gravity. */
static cJSON *empty_scene(void) {
  static const double none[3] = {0};
  const thrum_state_def def = thrum_default_state_def();
  cJSON *scene = cJSON_CreateObject();
  json_number(scene, "dt", def.dt);
  cJSON_AddStringToObject(scene, "integrator", thrum_integrator_name(def.integrator));
  json_numbers(scene, "gravity", none, 3);
  json_number(scene, "damping", 0);
  return scene;
}

/* A body at a place, of its model's own material. */
static cJSON *body_at(const char *name, int64_t number, int64_t rank, const run_placement *place) {
  static const double none[3] = {0}, unturned[4] = {1, 0, 0, 0};
  cJSON *body = cJSON_CreateObject();
  json_string(body, "name", name);
  json_number(body, "model", (double)number);
  json_numbers(body, "position", place->placed ? place->position : none, 3);
  json_numbers(body, "rotation", place->placed ? place->rotation : unturned, 4);
  json_number(body, "scale", place->placed ? place->scale : 1);
  json_number(body, "stiffness", 1);
  json_number(body, "density", 1);
  json_number(body, "rank", (double)rank);
  return body;
}

cJSON *view_archive_scene_of_models(const view_archive_model *models) {
  const run_placement nowhere = {.placed = false};
  cJSON *scene = empty_scene();
  cJSON_AddArrayToObject(scene, "obstacles");

  // one body, which the page exchanges for another model
  const int64_t masters = thrum_model_masters(models[0].model);
  cJSON *body = body_at(models[0].name, 0, masters > 0 ? masters : models[0].model->rank, &nowhere);
  cJSON_AddStringToObject(body, "colour", COLOUR);
  cJSON_AddBoolToObject(body, "free", false);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(scene, "bodies"), body);
  return scene;
}

static void add_colour(cJSON *object, const float colour[3]) {
  char text[8];
  unsigned parts[3];
  for (int n = 0; n < 3; n++)
    parts[n] = (unsigned)lround(255 * fmin(fmax((double)colour[n], 0), 1));
  snprintf(text, sizeof text, "#%02x%02x%02x", parts[0] & 255, parts[1] & 255, parts[2] & 255);
  cJSON_AddStringToObject(object, "colour", text);
}

/* A rotation of length 1 of one of any length. */
static void add_rotation(cJSON *object, const double rotation[4]) {
  double length = 0, turned[4];
  for (int n = 0; n < 4; n++)
    length = hypot(length, rotation[n]);
  for (int n = 0; n < 4; n++)
    turned[n] = rotation[n] / length;
  json_numbers(object, "rotation", turned, 4);
}

static cJSON *body_of_run(const scene_run *run, int32_t n, int64_t place) {
  const scene_body_spec *spec = run->bodies[n].spec;
  const thrum_state_def *def = &spec->settings.def;
  cJSON *body = cJSON_CreateObject();
  json_string(body, "name", spec->name);
  json_number(body, "model", (double)place);

  // as it is stepped: "error" and "budget" have found the number
  const int64_t asked = run->bodies[n].request.condense;
  const int64_t masters = asked > 0 ? asked : thrum_model_masters(run->bodies[n].model);
  json_number(body, "rank", (double)(masters > 0 ? masters : run->bodies[n].model->rank));
  json_number(body, "condense", (double)masters);
  add_rotation(body, spec->rotation);
  add_colour(body, spec->colour);
  view_archive_add_fields(body, THRUM_SCENE_RECORD_BODY, &run->bodies[n].def);
  cJSON_AddStringToObject(body, "integrator", thrum_integrator_name(def->integrator));
  json_number(body, "damping", def->damping_alpha);
  view_archive_add_loads(body, run, n);
  return body;
}

static cJSON *obstacle_of_spec(const scene_obstacle_spec *spec) {
  cJSON *obstacle = cJSON_CreateObject();
  cJSON_AddStringToObject(obstacle, "kind", scene_shape_names[spec->shape]);
  json_numbers(obstacle, "centre", spec->centre, 3);

  // only what the kind has
  if (spec->shape == SCENE_PLANE)
    json_numbers(obstacle, "normal", spec->normal, 3);
  if (spec->shape == SCENE_SPHERE)
    json_number(obstacle, "radius", spec->radius);
  if (spec->shape == SCENE_BOX) {
    json_numbers(obstacle, "size", spec->size, 3);
    add_rotation(obstacle, spec->rotation);
  }

  cJSON_AddBoolToObject(obstacle, "inside", spec->inside);
  json_numbers(obstacle, "velocity", spec->velocity, 3);
  json_number(obstacle, "friction", spec->friction);
  json_number(obstacle, "restitution", spec->restitution);
  json_number(obstacle, "stiffness", spec->stiffness);
  json_number(obstacle, "damping", spec->damping);
  add_colour(obstacle, spec->colour);
  return obstacle;
}

/* An obstacle that is touched by its faces: its surface as the scene made it, and its way. */
static cJSON *solid_of_run(const scene_run *run, const scene_obstacle_spec *spec, int32_t number) {
  thrum_scene_solid solid;
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "kind", "solid");
  json_numbers(object, "centre", spec->centre, 3);
  add_rotation(object, spec->rotation);
  json_numbers(object, "velocity", spec->velocity, 3);
  json_number(object, "friction", spec->friction);
  json_number(object, "restitution", spec->restitution);
  add_colour(object, spec->colour);

  // vertices, then triangles by their corners
  if (thrum_scene_solid_get(run->scene, number, &solid, NULL) < 0)
    return object;
  json_numbers(object, "vertices", solid.vertices, 3 * solid.vertex_count);
  cJSON *triangles = cJSON_AddArrayToObject(object, "triangles");
  for (int64_t n = 0; n < 3 * solid.triangle_count; n++)
    cJSON_AddItemToArray(triangles, cJSON_CreateNumber(solid.triangles[n]));

  // its way was made before, when the obstacle was added to the scene
  double *times = NULL, *places = NULL;
  int64_t count = 0;
  if (spec->way.count > 0)
    scene_run_way(run, spec, &times, &places, &count, NULL);
  json_numbers(object, "times", times, count);
  json_numbers(object, "places", places, 7 * count);
  free(times);
  free(places);
  return object;
}

static cJSON *collisions_of_run(const scene_run *run) {
  const thrum_contact_pairs_def def = scene_run_collisions_def(run);
  cJSON *collisions = cJSON_CreateObject();
  view_archive_add_fields(collisions, THRUM_SCENE_RECORD_PAIRS, &def);
  json_number(collisions, "touches", (double)def.touch_max);
  return collisions;
}

/* Adds the obstacles of a scene file, as they stand in its scene; run: NULL for none. */
static void add_obstacles(cJSON *scene, const scene_run *run) {
  cJSON *obstacles = cJSON_AddArrayToObject(scene, "obstacles");
  int32_t solids = 0;
  for (int64_t n = 0; run != NULL && n < run->spec.obstacles.count; n++) {
    const scene_obstacle_spec *of = &scene_obstacles(&run->spec)[n];
    cJSON_AddItemToArray(obstacles, scene_obstacle_is_solid(of) ? solid_of_run(run, of, solids++)
                                                                : obstacle_of_spec(of));
  }
}

cJSON *view_archive_scene_of_run(const scene_run *run, const int64_t *of_body) {
  const scene_spec *spec = &run->spec;
  const thrum_state_def *def = &spec->settings.def;
  cJSON *scene = cJSON_CreateObject();
  if (spec->title != NULL)
    json_string(scene, "title", spec->title);

  json_number(scene, "dt", def->dt);
  cJSON_AddBoolToObject(scene, "own_dt", true);
  cJSON_AddStringToObject(scene, "integrator", thrum_integrator_name(def->integrator));
  json_numbers(scene, "gravity", spec->gravity, 3);
  json_number(scene, "damping", def->damping_alpha);

  // bodies refer to the models of the archive by their places
  add_obstacles(scene, run);
  cJSON *bodies = cJSON_AddArrayToObject(scene, "bodies");
  for (int32_t n = 0; n < spec->bodies.count; n++)
    cJSON_AddItemToArray(bodies, body_of_run(run, n, of_body[n]));
  view_archive_add_links(scene, run);
  view_archive_add_air_and_ground(scene, run);
  if (scene_run_bodies_meet(run))
    cJSON_AddItemToObject(scene, "collisions", collisions_of_run(run));
  return scene;
}

/* A body as its run placed it; it is not stepped, so it has no integrator of its own. */
static cJSON *body_of_motion(const recorded_run *run, const char *name, int64_t model) {
  const run_placement *place = &run->place;
  cJSON *body = body_at(name, model, run->model->rank, place);
  cJSON_AddBoolToObject(body, "free", run->places != NULL);

  // a run of one model has no colour of its own
  const float colour[3] = {(float)place->colour[0], (float)place->colour[1],
                           (float)place->colour[2]};
  if (place->placed)
    add_colour(body, colour);
  else
    cJSON_AddStringToObject(body, "colour", COLOUR);
  if (run->error[0] != 0)
    json_string(body, "error", run->error);
  return body;
}

cJSON *view_archive_scene_of_motion(view_archive_motion motion, const char *const *names,
                                    const int64_t *of_body, const scene_run *obstacles) {
  cJSON *scene = empty_scene();
  add_obstacles(scene, obstacles);
  cJSON *bodies = cJSON_AddArrayToObject(scene, "bodies");
  for (int64_t n = 0; n < motion.count; n++)
    cJSON_AddItemToArray(bodies, body_of_motion(&motion.runs[n], names[n], of_body[n]));
  return scene;
}
