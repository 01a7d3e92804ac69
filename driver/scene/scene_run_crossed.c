/* Do bodies of a scene pass through each other or through obstacles? The status surfaces_crossed
 * and the warnings that say who and how deep (docs/contact.md). SPDX-License-Identifier: Apache-2.0
 */
#include "driver/scene/scene_run_crossed.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "driver/scene/scene_run_sphere.h"
#include "driver/scene/scene_run_world.h"
#include "runtime/material/jacobi.h"

#define OBSTACLE_DEPTH 0.5 /* of a body's thickness: a vertex so deep went through an obstacle */
#define NEAR_SHARE 0.35    /* of the thickness, missing at the start: from there bodies tremble */
#define NAMES_MAX 4        /* bodies that a warning names */

/* Are there obstacles that vertices touch, none of which is as soft as the file asks? */
static bool has_hard_obstacles(const scene_run *run) {
  bool any = false;
  for (int64_t n = 0; n < run->spec.obstacles.count; n++) {
    const scene_obstacle_spec *spec = &scene_obstacles(&run->spec)[n];
    if (scene_obstacle_is_solid(spec))
      continue;
    if (spec->stiffness > 0)
      return false;
    any = true;
  }
  return any;
}

/* How far a body extends along the principal axes of its vertices, the least of them: a plate that
 * stands aslant in its mesh is as thin as one that does not. */
static double find_thickness(const thrum_model *model) {
  const int64_t count = model->vertex_count;
  double middle[3] = {0}, spread[9] = {0}, axes[9], thickness = INFINITY;
  for (int64_t c = 0; c < 3 * count; c++)
    middle[c % 3] += model->vertices[c] / (double)count;
  for (int64_t v = 0; v < count; v++)
    for (int n = 0; n < 9; n++)
      spread[n] += (model->vertices[3 * v + n / 3] - middle[n / 3]) *
                   (model->vertices[3 * v + n % 3] - middle[n % 3]);
  thrum_jacobi(3, spread, axes);

  for (int axis = 0; axis < 3; axis++) {
    double least = INFINITY, most = -INFINITY;
    for (int64_t v = 0; v < count; v++) {
      const double *x = model->vertices + 3 * v;
      const double at = axes[axis] * x[0] + axes[3 + axis] * x[1] + axes[6 + axis] * x[2];
      least = fmin(least, at);
      most = fmax(most, at);
    }
    thickness = fmin(thickness, most - least);
  }
  return thickness;
}

/* The box of a body at rest, and its diagonal and thickness as it is scaled. */
static void find_box(scene_body_run *body) {
  const thrum_model *model = body->model;
  double thickness = find_thickness(model);
  thrum_box3(model->vertices, model->vertex_count, body->least, body->most);
  for (int axis = 0; axis < 3; axis++)
    thickness = fmin(thickness, body->most[axis] - body->least[axis]);
  body->diagonal = body->spec->scale * thrum_box3_diagonal(model->vertices, model->vertex_count);
  body->thickness = body->spec->scale * thickness;
}

/* Where the middle of a body is, in the axes of another one. */
static void find_middle(const scene_run *run, int32_t n, int32_t in, double at[3]) {
  const scene_body_run *body = run->bodies + n;
  double matrix[16], place[3];
  thrum_scene_body_matrix(run->scene, n, matrix);
  for (int axis = 0; axis < 3; axis++) {
    place[axis] = matrix[12 + axis];
    for (int c = 0; c < 3; c++)
      place[axis] += matrix[4 * c + axis] * 0.5 * (body->least[c] + body->most[c]);
  }
  scene_run_in_mesh(run, in, place, at);
}

/* Would both touch, if they could? */
static bool would_touch(const scene_run *run, int32_t a, int32_t b) {
  return a != b && run->spec.collide && run->bodies[a].spec->collide &&
         run->bodies[b].spec->collide && run->bodies[b].model->vertices != NULL;
}

/* What passes a condensed body between two rows is seen by the way of its middle. */
static thrum_status open_ways(scene_run *run, thrum_error *error) {
  const int32_t count = (int32_t)run->spec.bodies.count;
  for (int32_t n = 0; n < count && run->has_passing; n++) {
    scene_body_run *body = run->bodies + n;
    if (!scene_run_is_condensed(run, n) || body->def.triangle_count == 0)
      continue;
    THRUM_TRY(
        thrum_reserve(&body->middle_at, 3 * count, sizeof *body->middle_at, "a scene", error));
    THRUM_TRY(thrum_reserve(&body->surface, 3 * body->model->vertex_count, sizeof *body->surface,
                            "a scene", error));
    for (int32_t other = 0; other < count; other++)
      find_middle(run, other, n, body->middle_at + 3 * (int64_t)other);
  }
  return THRUM_OK;
}

thrum_status scene_run_look_for_crossings(scene_run *run, thrum_error *error) {
  run->has_hard_obstacles = has_hard_obstacles(run);
  const bool boxes = run->has_hard_obstacles || run->has_passing;
  for (int64_t n = 0; n < run->spec.bodies.count && boxes; n++)
    if (run->bodies[n].model->vertices != NULL)
      find_box(run->bodies + n);
  THRUM_TRY(open_ways(run, error));
  return scene_run_open_spheres(run, error);
}

/* Finds whose the touch of the last step is that is nearest; returns its distance [m]. */
static double find_nearest(const scene_run *run, int32_t bodies[2]) {
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  double nearest = INFINITY;
  bodies[0] = bodies[1] = -1;
  for (int64_t n = 0; n < of.touching; n++) {
    thrum_pair_touch touch;
    if (thrum_scene_collision_get(run->scene, n, &touch, NULL) < 0 || touch.distance >= nearest)
      continue;
    nearest = touch.distance;
    memcpy(bodies, touch.bodies, sizeof touch.bodies);
  }
  return nearest;
}

/* Keeps who met first, and when: of the touches of the step that is deepest so far; and who began
 * nearer to each other than contact keeps them. */
static void note_meeting(scene_run *run) {
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  if (thrum_scene_steps(run->scene) == 1) {
    run->near_share = of.deepest_share;
    run->near_distance = find_nearest(run, run->near);
  }
  if (of.deepest_share < 1 || run->met_time > 0)
    return;
  run->met_time = (double)thrum_scene_steps(run->scene) * run->dt;
  find_nearest(run, run->met);
}

/* Follows the middle of each body on its way to this row; *found is the first that went through a
 * condensed one. */
static void follow_ways(const scene_run *run, thrum_scene_overlap *found) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    for (int32_t other = 0; body->middle_at != NULL && other < run->spec.bodies.count; other++) {
      double *before = body->middle_at + 3 * (int64_t)other, now[3];
      if (!would_touch(run, n, other))
        continue;
      find_middle(run, other, n, now);
      if (found->body < 0 && scene_run_goes_through(run, n, before, now))
        *found = (thrum_scene_overlap){.body = other, .other = n, .obstacle = -1, .solid = -1};
      memcpy(before, now, sizeof now);
    }
  }
}

thrum_status scene_run_look_through(scene_run *run, double time, thrum_error *error) {
  thrum_scene_overlap found;
  if (!run->has_passing || run->through_time > 0 || !(time > 0))
    return THRUM_OK;
  THRUM_TRY(thrum_scene_find_overlap(run->scene, &found, error));
  if (found.obstacle >= 0 ||
      (!scene_run_is_condensed(run, found.body) && !scene_run_is_condensed(run, found.other)))
    found.body = -1;
  follow_ways(run, &found);
  if (found.body < 0)
    return THRUM_OK;
  run->through = found;
  run->through_time = time;
  return THRUM_OK;
}

void scene_run_note_depths(scene_run *run) {
  if (run->account != NULL)
    note_meeting(run);
  for (int32_t n = 0; n < run->spec.bodies.count && run->has_hard_obstacles; n++) {
    scene_body_run *body = run->bodies + n;
    thrum_scene_body_info info;
    if (thrum_scene_body(run->scene, n, &info, NULL) >= 0)
      body->obstacle_depth = fmax(body->obstacle_depth, info.contact.depth);
  }
  scene_run_note_spheres(run);
}

/* Was a vertex of the body so deep in a plane, a sphere or a room that the body went through it? A
 * plate may be below a floor as a whole, and no deeper than it is thick. */
static bool went_through(const scene_body_run *body) {
  return body->diagonal > 0 && body->obstacle_depth > OBSTACLE_DEPTH * body->thickness;
}

/* Did a touch become as deep as the thickness, so that surfaces met? */
static bool have_met(const scene_run *run) {
  return thrum_scene_collisions(run->scene).deepest_share >= 1;
}

bool scene_run_have_crossed(const scene_run *run) {
  bool crossed = have_met(run) || run->through_time > 0;
  for (int64_t n = 0; n < run->spec.bodies.count; n++)
    crossed = crossed || went_through(run->bodies + n) || run->bodies[n].passed > 0;
  return crossed;
}

/* Adds a body's name to those that a warning has, the `count`-th of them. */
static void add_name(char *names, size_t size, int64_t count, const char *name) {
  const size_t length = strlen(names);
  if (count <= NAMES_MAX)
    snprintf(names + length, size - length, "%s\"%.60s\"", count > 1 ? ", " : "", name);
  else if (count == NAMES_MAX + 1)
    snprintf(names + length, size - length, " and others");
}

/* Steps that were made without contact, and whose bodies they were. */
static void warn_of_declined(const scene_run *run) {
  char names[NAMES_MAX * 80] = "";
  int64_t count = 0, most = 0;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    thrum_scene_body_info info;
    if (thrum_scene_body(run->scene, n, &info, NULL) < 0 || info.contact.declined == 0)
      continue;
    add_name(names, sizeof names, ++count, run->bodies[n].spec->name);
    most = info.contact.declined > most ? info.contact.declined : most;
  }
  if (count > 0)
    config_warn("contact was given up in %" PRId64 " step%s of %s, which no attempt could solve: "
                "they may have gone through what they touch; take a shorter dt, in which nothing "
                "moves further than a body is thick",
                most, most == 1 ? "" : "s", names);
}

bool scene_run_has_declined(const scene_run *run) {
  bool any = false;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    thrum_scene_body_info info;
    any = any || (thrum_scene_body(run->scene, n, &info, NULL) >= 0 && info.contact.declined > 0);
  }
  return any;
}

/* Something was in a condensed body, or went through it. */
static void warn_of_passed(const scene_run *run) {
  char in[SCENE_OVERLAP_NAME];
  scene_run_name_overlap(run, &run->through, in);
  config_warn(
      "body '%.60s' is in %s at %.4g s, or went through it, and one of them is condensed, so "
      "that they do not touch: do not trust it; precompute that one with --touch-stepped, or say "
      "\"collide\": false of it",
      run->bodies[run->through.body].spec->name, in, run->through_time);
}

/* How deep bodies really are in each other at the end: a touch knows places that are near alone. */
static void warn_of_overlap(const scene_run *run) {
  thrum_scene_overlap deepest;
  char in[SCENE_OVERLAP_NAME];
  if (thrum_scene_find_overlap(run->scene, &deepest, NULL) < 0 || deepest.body < 0)
    return;
  scene_run_name_overlap(run, &deepest, in);
  config_warn("body '%.60s' is %.2g m deep in %s at the end", run->bodies[deepest.body].spec->name,
              deepest.depth, in);
}

/* The name of a body or a solid that a touch is of. */
static void name_met(const scene_run *run, int32_t number, char name[SCENE_OVERLAP_NAME]) {
  const thrum_scene_thing met = thrum_scene_thing_of(number);
  const bool solid = met.kind == THRUM_SCENE_SOLID;
  thrum_scene_overlap of = {
      .other = solid ? -1 : met.number, .obstacle = -1, .solid = solid ? met.number : -1};
  scene_run_name_overlap(run, &of, name);
}

/* Says when surfaces met first, and whose they were where a touch knew of them. */
static void warn_of_meeting(const scene_run *run) {
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  char first[SCENE_OVERLAP_NAME], second[SCENE_OVERLAP_NAME],
      whose[2 * SCENE_OVERLAP_NAME + 20] = "";
  if (run->met[0] >= 0) {
    name_met(run, run->met[0], first);
    name_met(run, run->met[1], second);
    snprintf(whose, sizeof whose, ", of %s and %s at first,", first, second);
  }
  config_warn("surfaces went through each other%s in the step to %.4g s: their places came up to "
              "%.2g m deeper than the distance that they keep, %.2g times it: do not trust what "
              "touches; take a shorter dt, or bodies that differ less",
              whose, run->met_time, of.deepest, of.deepest_share);
}

/* Says who began within the thickness: there contact pushes them apart only as far as it has energy
 * for, and they do not come to rest. */
static void warn_of_start(const scene_run *run) {
  char first[SCENE_OVERLAP_NAME], second[SCENE_OVERLAP_NAME];
  if (!(run->near_share > NEAR_SHARE) || have_met(run) || run->near[0] == run->near[1])
    return;
  name_met(run, run->near[0], first);
  name_met(run, run->near[1], second);
  config_warn(
      "%s and %s start %.2g m apart, and contact keeps %.2g m between them: they stay that "
      "near and may tremble; move them apart, or give \"collisions\" a thickness below %.2g",
      first, second, run->near_distance, run->near_distance / (1 - run->near_share),
      run->near_distance);
}

void scene_run_warn_of_depth(const scene_run *run) {
  warn_of_start(run);
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  warn_of_declined(run);
  if (run->through_time > 0)
    warn_of_passed(run);
  if (have_met(run))
    warn_of_meeting(run);
  if (have_met(run))
    warn_of_overlap(run);

  // obstacles that vertices touch
  for (int64_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    if (went_through(body))
      config_warn("body '%.100s' was %.2g m deep in an obstacle, and is %.2g m thick: do not trust "
                  "it; take a shorter dt",
                  body->spec->name, body->obstacle_depth, body->thickness);
    else if (body->passed > 0)
      config_warn("body '%.100s' went over obstacles[%d], a sphere, between its vertices or within "
                  "a step: do not trust it; take a shorter dt, a finer mesh, or a capsule, whose "
                  "faces are touched",
                  body->spec->name, (int)body->passed - 1);
  }
  if (of.dropped > 0)
    config_warn("%lld touches of bodies found no room and were left out", (long long)of.dropped);
}
