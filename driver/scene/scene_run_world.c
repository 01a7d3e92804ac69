/* The parts of a scene file that all bodies share: base motions, wind, obstacles and probes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/scene/scene_run_refuse.h"
#include "driver/scene/scene_run_solid.h"

// room for touches between bodies, for each of the first ones and of those beyond, of which
// scenes of many bodies have fewer each; a touch takes 1.3 kB at rank 4 and 4 kB at rank 60
#define SCENE_TOUCHES 1024
#define SCENE_TOUCHES_FIRST 64
#define SCENE_TOUCHES_BEYOND 128
#define SCENE_OVERLAP 5e-3 /* of a body's diagonal: it may begin that deep in something */

thrum_status scene_run_add_base_motion(const base_motion_spec *base_motion, thrum_scene *scene,
                                       thrum_error *error) {
  return base_motion->sine ? thrum_scene_add_base_motion(scene, base_motion->amplitude,
                                                         &base_motion->course, error)
                           : thrum_scene_add_base_motion_record(scene, &base_motion->motion, error);
}

thrum_status scene_run_base_motions(scene_run *run, thrum_error *error) {
  const config_texts *texts = &run->spec.base_motion;
  run->base_motions = calloc((size_t)texts->count + 1, sizeof *run->base_motions);
  if (run->base_motions == NULL)
    return scene_run_no_memory(error);
  for (int64_t n = 0; n < texts->count; n++) {
    // a record is read from its file, a sine is complete as parsed
    base_motion_spec *base_motion = &run->base_motions[n];
    thrum_error detail = {0};
    thrum_status status = base_motion_parse(texts->texts[n], base_motion, &detail);
    THRUM_THEN(status, base_motion_read(base_motion, &detail));

    // counted as soon as it owns memory, so that closing frees it
    run->base_motion_count += status >= 0;

    THRUM_THEN(status, scene_run_add_base_motion(base_motion, run->scene, &detail));

    if (status < 0)
      return config_record_refuse_text(&run->spec.file, &run->spec.settings.at, "base_motion",
                                       texts, n, "%s", detail.message);
  }
  return THRUM_OK;
}

static void place_obstacle(const scene_obstacle_spec *spec, thrum_obstacle *def) {
  *def = thrum_default_obstacle();
  def->shape = (thrum_obstacle_shape)spec->shape;
  THRUM_OBSTACLE_FIELDS(SCENE_COPY)

  // boxes are given by their sides, the engine takes half of each; and the rotation as a matrix
  for (int axis = 0; axis < 3 && spec->shape == SCENE_BOX; axis++)
    def->half[axis] = 0.5 * spec->size[axis];
  thrum_scene_axes(spec->rotation, def->rotation, NULL);
}

thrum_status scene_run_obstacles(const scene_run *run, thrum_scene *scene) {
  for (int64_t n = 0; n < run->spec.obstacles.count; n++) {
    const scene_obstacle_spec *spec = &scene_obstacles(&run->spec)[n];
    thrum_obstacle obstacle;
    thrum_error detail = {0};
    if (scene_obstacle_is_solid(spec)) {
      THRUM_TRY(scene_run_add_solid(run, spec, scene));
      continue;
    }
    place_obstacle(spec, &obstacle);
    const thrum_status status = thrum_scene_add_obstacle(scene, &obstacle, NULL, &detail);
    THRUM_TRY(scene_run_pass(run, &spec->at, NULL, status, &detail));
  }
  return THRUM_OK;
}

bool scene_run_collides(const scene_run *run) {
  return run->spec.collide && run->spec.bodies.count > 1;
}

bool scene_run_body_meets(const scene_run *run, const scene_body_run *body) {
  return (scene_run_collides(run) && body->spec->collide) || body->spec->self_contact;
}

/* Does a body touch itself? */
static bool has_self_contact(const scene_run *run) {
  bool any = false;
  for (int64_t n = 0; n < run->spec.bodies.count && !any; n++)
    any = scene_bodies(&run->spec)[n].self_contact;
  return any;
}

bool scene_run_bodies_meet(const scene_run *run) {
  return scene_run_collides(run) || has_self_contact(run);
}

bool scene_run_has_solids(const scene_run *run) {
  return scene_run_obstacle_index(run, true, 0) >= 0;
}

bool scene_run_touches(const scene_run *run) {
  return scene_run_bodies_meet(run) || scene_run_has_solids(run);
}

thrum_contact_pairs_def scene_run_collisions_def(const scene_run *run) {
  const scene_collisions_spec *spec = &run->spec.collisions;
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.thickness = spec->thickness;
  def.friction = spec->friction;
  def.restitution = spec->restitution;

  // touches of all bodies share the room
  const int64_t count = run->spec.bodies.count;
  const int64_t first = count < SCENE_TOUCHES_FIRST ? count : SCENE_TOUCHES_FIRST;
  def.touch_max = SCENE_TOUCHES * first + SCENE_TOUCHES_BEYOND * (count - first);
  return def;
}

thrum_status scene_run_collisions(const scene_run *run) {
  if (!has_self_contact(run) && (!run->spec.collide || !scene_run_touches(run)))
    return THRUM_OK;
  const thrum_contact_pairs_def def = scene_run_collisions_def(run);
  thrum_error detail = {0};
  const thrum_status status = thrum_scene_set_collisions(run->scene, &def, &detail);
  return scene_run_pass(run, &run->spec.settings.at, "collide", status, &detail);
}

void scene_run_name_overlap(const scene_run *run, const thrum_scene_overlap *overlap,
                            char in[SCENE_OVERLAP_NAME]) {
  const bool solid = overlap->solid >= 0;
  const int32_t index =
      scene_run_obstacle_index(run, solid, solid ? overlap->solid : overlap->obstacle);
  if (overlap->other >= 0)
    snprintf(in, SCENE_OVERLAP_NAME, "body \"%.60s\"",
             scene_bodies(&run->spec)[overlap->other].name);
  else if (scene_obstacles(&run->spec)[index].name != NULL)
    snprintf(in, SCENE_OVERLAP_NAME, "obstacle \"%.60s\"", scene_obstacles(&run->spec)[index].name);
  else
    snprintf(in, SCENE_OVERLAP_NAME, "obstacles[%d]", (int)index);
}

bool scene_run_is_condensed(const scene_run *run, int32_t body) {
  thrum_scene_body_info info = {0};
  return body >= 0 && thrum_scene_body(run->scene, body, &info, NULL) >= 0 && info.condensed;
}

thrum_status scene_run_check_start(const scene_run *run, thrum_error *error) {
  thrum_scene_overlap deepest;
  THRUM_TRY(thrum_scene_find_overlap(run->scene, &deepest, error));
  if (deepest.body < 0 || deepest.depth <= SCENE_OVERLAP * deepest.diagonal)
    return THRUM_OK;

  // condensed bodies touch none, and may begin in each other
  if (deepest.obstacle < 0 &&
      (scene_run_is_condensed(run, deepest.body) || scene_run_is_condensed(run, deepest.other)))
    return THRUM_OK;

  const scene_body_spec *body = &scene_bodies(&run->spec)[deepest.body];
  char in[SCENE_OVERLAP_NAME];
  scene_run_name_overlap(run, &deepest, in);
  return config_record_refuse(&run->spec.file, &body->settings.at, "position", THRUM_BAD_VALUE,
                              "puts \"%.60s\" %.3g m deep into %s: move it out", body->name,
                              deepest.depth, in);
}

thrum_status scene_run_wind(const scene_run *run, thrum_scene *scene) {
  const scene_wind_spec *spec = &run->spec.wind;
  thrum_scene_wind_def wind = thrum_default_scene_wind_def(), *def = &wind;
  thrum_error detail = {0};
  if (spec->at.node == NULL)
    return THRUM_OK;
  THRUM_WIND_FIELDS(SCENE_COPY)
  memcpy(def->velocity, spec->velocity, sizeof def->velocity);
  const thrum_status status = thrum_scene_set_wind(scene, def, &detail);
  return scene_run_pass(run, &spec->at, NULL, status, &detail);
}

thrum_status scene_run_probes(scene_run *run) {
  for (int64_t n = 0; n < run->spec.probes.count; n++) {
    const scene_probe_spec *probe = &scene_probes(&run->spec)[n];
    const int32_t body = thrum_scene_find_body(run->scene, probe->body);

    // several vertices are followed by their mean
    load_vertices at = {0};
    load_target target;

    thrum_error detail = {0};
    thrum_status status = load_target_parse(probe->target, "at", &target, &detail);
    THRUM_THEN(status, load_target_find(run->bodies[body].model, &target, &at, &detail));
    THRUM_THEN(status,
               thrum_scene_add_probe(run->scene, probe->name, body, at.list, at.count, &detail));
    load_vertices_free(&at);
    THRUM_TRY(scene_run_pass(run, &probe->at, "at", status, &detail));
  }
  return THRUM_OK;
}
