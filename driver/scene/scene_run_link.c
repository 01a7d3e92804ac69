/* Links of a scene file: what they tie, the paths of their ends, and what they did.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_link.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/scene/scene_run_refuse.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"
#include "platform/allocate.h"

#define OPEN_MOST 1e-8 /* of a joint [m]: beyond this it is told */

/* The data that a link's def points to while it is added. */
typedef struct link_parts {
  base_motion_spec motion;
  double *times, *places;
  int32_t *vertices[2]; /* of its sides */
} link_parts;

static void free_parts(link_parts *parts) {
  if (parts->motion.text != NULL)
    base_motion_close(&parts->motion);
  free(parts->times);
  free(parts->places);
  free(parts->vertices[0]);
  free(parts->vertices[1]);
}

/* A body and the vertices of it that a key names, if it does. All of them are listed too: no list
 * means those near a place. */
static thrum_status find_side(const scene_run *run, const scene_link_spec *spec, const char *key,
                              const char *name, const char *text, int32_t *number,
                              int32_t **vertices, int64_t *count) {
  load_target target;
  thrum_error detail = {0};
  *number = thrum_scene_find_body(run->scene, name);
  if (text == NULL)
    return THRUM_OK;
  thrum_status status = load_target_parse(text, key, &target, &detail);
  THRUM_THEN(status,
             load_target_list(run->bodies[*number].model, &target, vertices, count, &detail));
  return scene_run_pass(run, &spec->at, key, status, &detail);
}

/* The path of the file, or of the waypoints. */
static thrum_status read_path(const scene_run *run, const scene_link_spec *spec, link_parts *parts,
                              thrum_scene_link_def *def, thrum_error *error) {
  const scene_link_waypoint_spec *way = spec->way.items;
  thrum_error detail = {0};
  if (spec->path != NULL) {
    thrum_status status = base_motion_parse(spec->path, &parts->motion, &detail);
    THRUM_THEN(status, base_motion_read(&parts->motion, &detail));
    THRUM_TRY(scene_run_pass(run, &spec->at, "file", status, &detail));
    def->path_times = parts->motion.motion.times;
    def->path_places = parts->motion.motion.positions;
    def->path_count = parts->motion.motion.count;
    return THRUM_OK;
  }

  // waypoints as they are
  const int64_t count = spec->way.count;
  THRUM_TRY(thrum_reserve(&parts->times, count + 1, sizeof *parts->times, "the scene", error));
  THRUM_TRY(
      thrum_reserve(&parts->places, 3 * count + 1, sizeof *parts->places, "the scene", error));
  for (int64_t n = 0; n < count; n++) {
    parts->times[n] = way[n].time;
    memcpy(parts->places + 3 * n, way[n].place, sizeof way[n].place);
  }
  def->path_times = parts->times;
  def->path_places = parts->places;
  def->path_count = count;
  return THRUM_OK;
}

/* Refuses a body whose number of coordinates may change. */
static thrum_status check_whole(const scene_run *run, const scene_link_spec *spec, int32_t number) {
  const scene_body_spec *body = run->bodies[number].spec;
  if (body->error == 0 && body->budget == 0 && body->detail.at.node == NULL)
    return THRUM_OK;
  return config_record_refuse(&run->spec.file, &spec->at, NULL, THRUM_BAD_VALUE,
                              "body \"%.60s\" has \"error\", \"budget\" or \"detail\", and such "
                              "bodies cannot be linked",
                              body->name);
}

static thrum_status add_link(const scene_run *run, const scene_link_spec *spec, link_parts *parts,
                             thrum_error *error) {
  thrum_scene_link_def made = thrum_default_scene_link_def(), *def = &made;

  // what it ties
  THRUM_TRY(find_side(run, spec, "at", spec->body, spec->target, &def->body, &parts->vertices[0],
                      &def->count));
  THRUM_TRY(check_whole(run, spec, def->body));
  if (spec->other != NULL) {
    THRUM_TRY(find_side(run, spec, "other_at", spec->other, spec->other_target, &def->other,
                        &parts->vertices[1], &def->other_count));
    THRUM_TRY(check_whole(run, spec, def->other));
  }

  def->vertices = parts->vertices[0];
  def->other_vertices = parts->vertices[1];

  // how, where and for how long
  def->kind = (thrum_link_kind)spec->kind;
  THRUM_LINK_FIELDS(SCENE_COPY)
  THRUM_TRY(read_path(run, spec, parts, def, error));
  thrum_error detail = {0};
  const thrum_status status = thrum_scene_add_link(run->scene, def, NULL, &detail);
  return scene_run_pass(run, &spec->at, NULL, status, &detail);
}

thrum_status scene_run_links(scene_run *run, thrum_error *error) {
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < run->spec.links.count && status >= 0; n++) {
    link_parts parts = {.times = NULL};
    status = add_link(run, &scene_links(&run->spec)[n], &parts, error);
    free_parts(&parts);
  }
  return status;
}

thrum_status scene_run_open_links(scene_run *run, thrum_error *error) {
  const int32_t count = thrum_scene_link_count(run->scene);
  if (count == 0)
    return THRUM_OK;
  errno = 0;
  run->links = run_series_open(&run->folder, SCENE_LINKS, SCENE_LINK_COLUMNS * (int64_t)count);
  return run->links != NULL ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_LINKS, error);
}

thrum_status scene_run_record_links(scene_run *run, thrum_error *error) {
  const int32_t count = thrum_scene_link_count(run->scene);
  bool done = true;
  errno = 0;
  for (int32_t n = 0; n < count && run->links != NULL; n++) {
    thrum_scene_link link;
    THRUM_TRY(thrum_scene_link_get(run->scene, n, &link, error));

    // the columns that run_entries.h lists
    double row[SCENE_LINK_COLUMNS] = {link.holds, link.report.drift};
    memcpy(row + 2, link.places, sizeof link.places);
    done = done && fwrite(row, sizeof row, 1, run->links) == 1;
  }
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_LINKS, error);
}

thrum_status scene_run_end_links(scene_run *run, thrum_error *error) {
  const int64_t columns = SCENE_LINK_COLUMNS * (int64_t)thrum_scene_link_count(run->scene);
  errno = 0;
  return run->links == NULL || run_series_close(&run->links, run->run.rows, columns)
             ? THRUM_OK
             : run_folder_write_failed(&run->folder, SCENE_LINKS, error);
}

/* The link whose joint was open the widest, and by how much. */
static int32_t widest_joint(const scene_run *run, double *open) {
  int32_t widest = 0;
  *open = 0;
  for (int32_t n = 0; n < thrum_scene_link_count(run->scene); n++) {
    thrum_scene_link link;
    if (thrum_scene_link_get(run->scene, n, &link, NULL) < 0 ||
        !(link.report.largest_drift > *open))
      continue;
    *open = link.report.largest_drift;
    widest = n;
  }
  return widest;
}

bool scene_run_joints_opened(const scene_run *run) {
  double open;
  widest_joint(run, &open);
  return open > OPEN_MOST;
}

void scene_run_warn_of_joints(const scene_run *run) {
  double open;
  const int32_t widest = widest_joint(run, &open);
  if (!(open > OPEN_MOST))
    return;

  // by its name, or by its place in the file
  const char *name = scene_links(&run->spec)[widest].name;
  char text[32];
  snprintf(text, sizeof text, "links[%d]", (int)widest);
  config_warn("the joint of link '%.100s' was open by %.2g m: a joint keeps closed to %g m where "
              "bodies and the ends of links move little in a step; take a shorter dt, or a slower "
              "path",
              name != NULL ? name : text, open, OPEN_MOST);
}

bool scene_run_is_linked(const scene_run *run, int32_t number) {
  for (int32_t n = 0; n < thrum_scene_link_count(run->scene); n++) {
    thrum_scene_link link;
    if (thrum_scene_link_get(run->scene, n, &link, NULL) >= 0 &&
        (link.bodies[0] == number || link.bodies[1] == number))
      return true;
  }
  return false;
}

bool scene_run_is_met(const scene_run *run, int32_t number) {
  return run->spec.obstacles.count > 0 || scene_run_body_meets(run, run->bodies + number) ||
         scene_run_is_linked(run, number);
}

cJSON *scene_run_links_json(const scene_run *run) {
  cJSON *list = cJSON_CreateArray();
  for (int32_t n = 0; n < run->spec.links.count; n++) {
    const scene_link_spec *spec = &scene_links(&run->spec)[n];
    thrum_scene_link link;
    if (thrum_scene_link_get(run->scene, n, &link, NULL) < 0)
      continue;

    // what it ties, and where that is at the end
    cJSON *object = json_add_row(list);
    if (spec->name != NULL)
      json_string(object, "name", spec->name);
    cJSON_AddStringToObject(object, "kind", scene_link_names[spec->kind]);
    cJSON_AddStringToObject(object, "body", spec->body);
    if (spec->other != NULL)
      cJSON_AddStringToObject(object, "other", spec->other);
    cJSON_AddBoolToObject(object, "holds", link.holds);
    json_numbers(object, "place_m", link.places[0], 3);
    json_numbers(object, "other_place_m", link.places[1], 3);

    // forces of the last step, and energies of the run
    json_numbers(object, "force_n", link.report.force, 3);
    json_numbers(object, "torque_n_m", link.report.torque, 3);
    json_number(object, "drift_m", link.report.drift);
    json_number(object, "largest_drift_m", link.report.largest_drift);
    json_number(object, "stored_j", link.report.stored);
    json_number(object, "lost_j", link.report.lost);
    json_number(object, "driven_j", link.report.driven);
  }
  return list;
}
