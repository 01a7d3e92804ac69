/* The forces of contact, row by row in contact.csv: what each body felt of each obstacle and body
 * that it touched in the last step. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_contact.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>

#include "driver/record/run_entries.h"
#include "driver/scene/scene_run_solid.h"
#include "driver/scene/scene_run_world.h"
#include "platform/allocate.h"

bool scene_run_has_contact(const scene_run *run) {
  return scene_run_touches(run) || run->spec.obstacles.count > 0;
}

thrum_status scene_run_open_contact(scene_run *run, thrum_error *error) {
  if (!scene_run_has_contact(run))
    return THRUM_OK;
  errno = 0;
  run->contact = run_folder_create(&run->folder, SCENE_CONTACT);
  const bool done =
      run->contact != NULL && fputs("step,time_s,body,on,fx_n,fy_n,fz_n\n", run->contact) >= 0;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_CONTACT, error);
}

/* A row in the making. */
typedef struct row_of_contact {
  scene_run *run;
  int64_t step;
  double time;
} row_of_contact;

/* The name of what a body touched. */
static void name_of(const scene_run *run, thrum_scene_thing from, char name[SCENE_OVERLAP_NAME]) {
  if (from.kind == THRUM_SCENE_BODY) {
    snprintf(name, SCENE_OVERLAP_NAME, "%.60s", scene_bodies(&run->spec)[from.number].name);
    return;
  }
  const bool solid = from.kind == THRUM_SCENE_SOLID;
  const int32_t index = scene_run_obstacle_index(run, solid, from.number);
  if (scene_obstacles(&run->spec)[index].name != NULL)
    snprintf(name, SCENE_OVERLAP_NAME, "%.60s", scene_obstacles(&run->spec)[index].name);
  else
    snprintf(name, SCENE_OVERLAP_NAME, "obstacles[%d]", (int)index);
}

/* Writes what one acts with on a body, where it does. */
static bool write(const row_of_contact *row, int32_t body, thrum_scene_thing from,
                  const double f[3]) {
  char name[SCENE_OVERLAP_NAME];
  if (f[0] == 0 && f[1] == 0 && f[2] == 0)
    return true;
  name_of(row->run, from, name);
  return fprintf(row->run->contact, "%" PRId64 ",%.17g,%s,%s,%.17g,%.17g,%.17g\n", row->step,
                 row->time, scene_bodies(&row->run->spec)[body].name, name, f[0], f[1], f[2]) > 0;
}

/* Writes what planes, spheres and rooms act with on a body. */
static bool write_obstacles(const row_of_contact *row, int32_t body) {
  bool done = true;
  for (int32_t n = 0; done && n < thrum_scene_obstacle_count(row->run->scene); n++) {
    double f[3];
    const thrum_scene_thing from = {THRUM_SCENE_OBSTACLE, n};
    if (thrum_scene_contact_force(row->run->scene, body, from, f, NULL) >= 0)
      done = write(row, body, from, f);
  }
  return done;
}

/* Two that touch, and the force on the first of them. */
typedef struct met_pair {
  int32_t bodies[2];
  double force[3];
} met_pair;

/* Sums up the touches of bodies and solids, in one pass over them; returns how many pairs touch. */
static int64_t sum_up(const scene_run *run, met_pair *pairs) {
  thrum_pair_touch touch;
  int64_t count = 0;
  for (int64_t n = 0; thrum_scene_collision_get(run->scene, n, &touch, NULL) >= 0; n++) {
    if (touch.bodies[0] == touch.bodies[1])
      continue;

    // touches of the same two mostly follow each other
    int64_t at = count - 1;
    while (at >= 0 &&
           (pairs[at].bodies[0] != touch.bodies[0] || pairs[at].bodies[1] != touch.bodies[1]))
      at--;
    if (at < 0) {
      at = count++;
      pairs[at] = (met_pair){.bodies = {touch.bodies[0], touch.bodies[1]}};
    }
    for (int axis = 0; axis < 3; axis++)
      pairs[at].force[axis] += touch.force[axis] + touch.impulse[axis] / run->dt;
  }
  return count;
}

/* Writes what bodies and solids that touched act with on each other. */
static bool write_touches(const row_of_contact *row, met_pair *pairs) {
  const int64_t count = sum_up(row->run, pairs);
  bool done = true;
  for (int64_t n = 0; done && n < count; n++)
    for (int side = 0; side < 2; side++) {
      double f[3];
      for (int axis = 0; axis < 3; axis++)
        f[axis] = side == 0 ? pairs[n].force[axis] : 0.0 - pairs[n].force[axis];
      const thrum_scene_thing on = thrum_scene_thing_of(pairs[n].bodies[side]);
      if (on.kind == THRUM_SCENE_BODY)
        done = done && write(row, on.number, thrum_scene_thing_of(pairs[n].bodies[1 - side]), f);
    }
  return done;
}

thrum_status scene_run_record_contact(scene_run *run, int64_t step, double time,
                                      thrum_error *error) {
  const row_of_contact row = {run, step, time};
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  met_pair *pairs = NULL;
  if (run->contact == NULL)
    return THRUM_OK;
  THRUM_TRY(
      thrum_reserve(&pairs, of.touching + of.struck + 1, sizeof *pairs, "contact.csv", error));
  errno = 0;
  bool done = true;
  for (int32_t body = 0; body < thrum_scene_body_count(run->scene); body++)
    done = done && write_obstacles(&row, body);
  done = done && write_touches(&row, pairs);
  const int failure = errno;
  free(pairs);
  errno = failure;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_CONTACT, error);
}
