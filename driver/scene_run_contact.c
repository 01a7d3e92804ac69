/* The forces of contact, row by row in contact.csv: what each body felt of each obstacle and body
 * that it touched in the last step. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_run_contact.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "driver/run_entries.h"
#include "driver/scene_run_solid.h"
#include "driver/scene_run_world.h"

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

/* The name of what a body touched, by its number among bodies, solids and obstacles. */
static void name_of(const scene_run *run, int32_t from, char name[SCENE_OVERLAP_NAME]) {
  if (from < THRUM_SCENE_SOLID) {
    snprintf(name, SCENE_OVERLAP_NAME, "%.60s", scene_bodies(&run->spec)[from].name);
    return;
  }
  const bool solid = from < THRUM_SCENE_OBSTACLE;
  const int32_t number = from - (solid ? THRUM_SCENE_SOLID : THRUM_SCENE_OBSTACLE);
  const int32_t index = scene_run_obstacle_index(run, solid, number);
  if (scene_obstacles(&run->spec)[index].name != NULL)
    snprintf(name, SCENE_OVERLAP_NAME, "%.60s", scene_obstacles(&run->spec)[index].name);
  else
    snprintf(name, SCENE_OVERLAP_NAME, "obstacles[%d]", (int)index);
}

/* Writes what one acts with on a body, where it does. */
static bool write(const row_of_contact *row, int32_t body, int32_t from) {
  double f[3];
  char name[SCENE_OVERLAP_NAME];
  if (thrum_scene_contact_force(row->run->scene, body, from, f, NULL) < 0 ||
      (f[0] == 0 && f[1] == 0 && f[2] == 0))
    return true;
  name_of(row->run, from, name);
  return fprintf(row->run->contact, "%" PRId64 ",%.17g,%s,%s,%.17g,%.17g,%.17g\n", row->step,
                 row->time, scene_bodies(&row->run->spec)[body].name, name, f[0], f[1], f[2]) > 0;
}

/* Did a touch before this one have the same two? Those of two bodies mostly follow each other. */
static bool is_known(const scene_run *run, int64_t index, const int32_t bodies[2]) {
  thrum_pair_touch touch;
  for (int64_t n = index - 1; n >= 0; n--)
    if (thrum_scene_collision(run->scene, n, &touch, NULL) >= 0 && touch.bodies[0] == bodies[0] &&
        touch.bodies[1] == bodies[1])
      return true;
  return false;
}

/* Bodies and solids that touched each other, on both of them. */
static bool write_touches(const row_of_contact *row) {
  thrum_pair_touch touch;
  bool done = true;
  for (int64_t n = 0; done && thrum_scene_collision(row->run->scene, n, &touch, NULL) >= 0; n++) {
    if (touch.bodies[0] == touch.bodies[1] || is_known(row->run, n, touch.bodies))
      continue;
    for (int side = 0; side < 2; side++)
      if (touch.bodies[side] < THRUM_SCENE_SOLID)
        done = done && write(row, touch.bodies[side], touch.bodies[1 - side]);
  }
  return done;
}

thrum_status scene_run_record_contact(scene_run *run, int64_t step, double time,
                                      thrum_error *error) {
  const row_of_contact row = {run, step, time};
  if (run->contact == NULL)
    return THRUM_OK;
  errno = 0;
  bool done = true;
  for (int32_t body = 0; body < thrum_scene_body_count(run->scene); body++)
    for (int32_t n = 0; done && n < thrum_scene_obstacle_count(run->scene); n++)
      done = write(&row, body, THRUM_SCENE_OBSTACLE + n);
  done = done && write_touches(&row);
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_CONTACT, error);
}
