/* Snapshots: what steps change, one record after the other behind a head with a checksum
 * (core/base/seal.h). Nothing is restored before all of it has been checked.
 * SPDX-License-Identifier: Apache-2.0 */

#include "scene/scene_free_body.h"
#include "scene/scene_loads.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/seal.h"

/* Steps and counters beyond this could overflow when they are counted on. */
#define COUNT_MAX (INT64_C(1) << 62)

/* The version is that of the records below. */
static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 'c', 'n'}, 13};

typedef struct scene_record {
  uint64_t revision;
  int64_t steps, origin_step;
  double origin, eye[3];
} scene_record;

typedef struct body_record {
  int64_t status;
  double work_load, work_base;
  scene_counts before_state;
  thrum_translation way;
  thrum_rigid_frame rigid_frame;
} body_record;

/* The fields of a link that steps change. */
typedef struct link_record {
  int64_t released, steps;
  thrum_link_report report;
} link_record;

static size_t contact_bytes(const scene_body *body) {
  return body->touch != NULL ? thrum_contact_bytes(body->touch->contact) : 0;
}

/* Numbers of a condensed body alone: what its slaves answer to, loads and pulls. */
static size_t condensed_count(const scene_body *body) {
  return body->derived->condensed ? (size_t)(2 * body->model->rank) : 0;
}

/* A body with a level of detail keeps what updates have seen, and the coordinates at the last. */
static size_t detail_bytes(const scene_body *body) {
  return body->detail != NULL ? sizeof(scene_seen) + (size_t)body->model->rank * sizeof(double) : 0;
}

size_t thrum_scene_snapshot_size(const thrum_scene *scene) {
  size_t size = THRUM_SEAL_BYTES + sizeof(scene_record);
  for (int32_t n = 0; n < scene->body_count; n++) {
    const scene_body *body = scene->bodies[n];
    size += sizeof(body_record) + (size_t)body->derived->rank * sizeof(double) +
            thrum_state_kept_bytes(body->state) + contact_bytes(body) +
            condensed_count(body) * sizeof(double) + detail_bytes(body);
  }
  return size + (size_t)scene->obstacle_count * sizeof *scene->obstacles +
         thrum_contact_pairs_kept_bytes(scene->pairs.contact) +
         (size_t)scene->link_count * sizeof(link_record);
}

static void put(unsigned char **to, const void *from, size_t size) {
  memcpy(*to, from, size);
  *to += size;
}

static void take(const unsigned char **from, void *to, size_t size) {
  memcpy(to, *from, size);
  *from += size;
}

thrum_status thrum_scene_snapshot(const thrum_scene *scene, void *memory, size_t size,
                                  thrum_error *error) {
  const size_t needed = thrum_scene_snapshot_size(scene);
  if (memory == NULL || size < needed)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "a snapshot of this scene has %zu bytes, the memory %zu", needed, size);

  // the scene's own numbers
  unsigned char *at = (unsigned char *)memory + THRUM_SEAL_BYTES;
  const scene_record head = {scene->revision,
                             scene->steps,
                             scene->origin_step,
                             scene->origin,
                             {scene->eye[0], scene->eye[1], scene->eye[2]}};
  put(&at, &head, sizeof head);

  // each body with its state and contact
  for (int32_t n = 0; n < scene->body_count; n++) {
    const scene_body *body = scene->bodies[n];
    const body_record record = {body->status,       body->work_load, body->work_base,
                                body->before_state, body->way,       body->rigid_frame};
    put(&at, &record, sizeof record);
    put(&at, body->before, (size_t)body->derived->rank * sizeof *body->before);
    put(&at, body->state, thrum_state_kept_bytes(body->state));
    if (body->touch != NULL)
      put(&at, body->touch->contact, contact_bytes(body));
    if (body->derived->condensed) {
      put(&at, body->answered, (size_t)body->model->rank * sizeof *body->answered);
      put(&at, body->pulled, (size_t)body->model->rank * sizeof *body->pulled);
    }
    if (body->detail != NULL) {
      put(&at, &body->detail->seen, sizeof body->detail->seen);
      put(&at, body->detail->last, (size_t)body->model->rank * sizeof *body->detail->last);
    }
  }

  if (scene->obstacle_count > 0)
    put(&at, scene->obstacles, (size_t)scene->obstacle_count * sizeof *scene->obstacles);
  if (scene->pairs.contact != NULL)
    put(&at, scene->pairs.contact, thrum_contact_pairs_kept_bytes(scene->pairs.contact));
  for (int32_t n = 0; n < scene->link_count; n++) {
    const scene_link *link = scene->links + n;
    const link_record record = {link->released, link->tie.steps, link->tie.report};
    put(&at, &record, sizeof record);
  }
  thrum_seal_put(memory, needed, kind);
  return THRUM_OK;
}

/* --- restoring -------------------------------------------------------------------------------- */

static thrum_status refuse(const char *what, thrum_error *error) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "the snapshot's %s is out of its range", what);
}

static bool is_count(int64_t count) {
  return count >= 0 && count <= COUNT_MAX;
}

/* Only a coupled body's inertia and internal momentum change with its shape. */
static bool is_inertia_right(const scene_body *body, const thrum_rigid_frame *then) {
  const thrum_rigid_frame *now = &body->rigid_frame;
  if (body->inertia_work != NULL)
    return thrum_all_finite(then->inverse, 9) && thrum_all_finite(then->internal, 3);
  return memcmp(then->inverse, now->inverse, sizeof now->inverse) == 0 &&
         memcmp(then->internal, now->internal, sizeof now->internal) == 0;
}

/* Whether the parts of a body's motion that steps do not change are as now, and the rest finite. */
static bool is_motion_right(const scene_body *body, const body_record *record) {
  const thrum_rigid_frame *now = &body->rigid_frame, *then = &record->rigid_frame;
  const double sums[] = {record->work_load, record->work_base, record->before_state.dissipated,
                         record->before_state.plastic_work, record->before_state.work_actuators};
  return thrum_all_finite(sums, 5) && record->way.mass == body->way.mass &&
         thrum_all_finite(record->way.position, 3) && thrum_all_finite(record->way.velocity, 3) &&
         memcmp(then->centre, now->centre, sizeof now->centre) == 0 &&
         is_inertia_right(body, then) && thrum_all_finite(then->attitude, 9) &&
         thrum_all_finite(then->momentum, 3);
}

/* Checks what updates have seen of a body, in a scene of so many steps, at *at, which moves behind
 * it. */
static thrum_status check_seen(const scene_body *body, int64_t steps, const unsigned char **at,
                               thrum_error *error) {
  scene_seen seen;
  take(at, &seen, sizeof seen);
  const thrum_scene_detail_report *report = &seen.report;
  const double numbers[] = {seen.last_time, seen.quiet_since, report->largest_jump,
                            report->energy, report->distance, report->speed};
  bool right = thrum_all_finite(numbers, 6) && is_count(seen.last_steps) &&
               is_count(report->changes) && is_count(report->put_off) && seen.last_steps <= steps &&
               is_count(report->reduced_steps) && report->reduced_steps < COUNT_MAX &&
               report->set == 1 && report->reduced == body->detail->seen.report.reduced &&
               seen.far >= 0 && seen.far <= 1;
  for (int64_t i = 0; i < body->model->rank; i++) {
    double q;
    take(at, &q, sizeof q);
    right = right && thrum_all_finite(&q, 1);
  }
  return right ? THRUM_OK : refuse("level of detail of a body", error);
}

/* One body's part of the snapshot at *at, which moves behind it. */
static thrum_status check_body(const scene_body *body, int64_t steps, const unsigned char **at,
                               thrum_error *error) {
  body_record record;
  take(at, &record, sizeof record);
  if (record.status < INT_MIN || record.status > INT_MAX ||
      !is_count(record.before_state.fallback_steps) || !is_motion_right(body, &record))
    return refuse("motion of a body", error);

  // q as the scene shows it; the state has its own check
  for (int64_t i = 0; i < body->derived->rank; i++) {
    double q;
    take(at, &q, sizeof q);
    if (!thrum_all_finite(&q, 1))
      return refuse("shape of a body", error);
  }

  // the state, and the contact of a body that touches
  THRUM_TRY(thrum_state_copy_check(body->derived->model, body->state, *at, error));
  *at += thrum_state_kept_bytes(body->state);
  if (body->touch != NULL) {
    THRUM_TRY(thrum_contact_copy_check(body->touch->contact, *at, error));
    *at += contact_bytes(body);
  }

  for (size_t n = 0; n < condensed_count(body); n++) {
    double value;
    take(at, &value, sizeof value);
    if (!thrum_all_finite(&value, 1))
      return refuse("shape of a body", error);
  }
  return body->detail != NULL ? check_seen(body, steps, at, error) : THRUM_OK;
}

/* Everything behind the head. */
static thrum_status check_content(const thrum_scene *scene, const unsigned char *at,
                                  thrum_error *error) {
  scene_record head;
  take(&at, &head, sizeof head);
  if (head.revision != scene->revision)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is none of the scene as it is now: what it is made of has "
                           "changed since");
  if (!is_count(head.steps) || !is_count(head.origin_step) || head.origin_step > head.steps ||
      !thrum_all_finite(&head.origin, 1) || !thrum_all_finite(head.eye, 3))
    return refuse("number of steps", error);

  // bodies and obstacles in the order in which the snapshot was written
  for (int32_t n = 0; n < scene->body_count; n++)
    THRUM_TRY(check_body(scene->bodies[n], head.steps, &at, error));
  for (int32_t n = 0; n < scene->obstacle_count; n++) {
    thrum_obstacle obstacle;
    take(&at, &obstacle, sizeof obstacle);
    THRUM_TRY(thrum_obstacle_check(&obstacle, n, error));
  }
  if (scene->pairs.contact != NULL)
    THRUM_TRY(thrum_contact_pairs_copy_check(scene->pairs.contact, at, error));
  at += thrum_contact_pairs_kept_bytes(scene->pairs.contact);
  for (int32_t n = 0; n < scene->link_count; n++) {
    link_record record;
    take(&at, &record, sizeof record);
    if (record.released < 0 || record.released > 1 || !is_count(record.steps) ||
        !thrum_all_finite(record.report.force, sizeof record.report / sizeof(double)))
      return refuse("link", error);
  }
  return THRUM_OK;
}

/* A body's part, all of which has been checked. */
static void take_body(scene_body *body, const unsigned char **at) {
  body_record record;
  take(at, &record, sizeof record);
  take(at, body->before, (size_t)body->derived->rank * sizeof *body->before);
  take(at, body->state, thrum_state_kept_bytes(body->state));
  if (body->touch != NULL)
    take(at, body->touch->contact, contact_bytes(body));
  if (body->derived->condensed) {
    take(at, body->answered, (size_t)body->model->rank * sizeof *body->answered);
    take(at, body->pulled, (size_t)body->model->rank * sizeof *body->pulled);
  }
  if (body->detail != NULL) {
    take(at, &body->detail->seen, sizeof body->detail->seen);
    take(at, body->detail->last, (size_t)body->model->rank * sizeof *body->detail->last);
  }

  // where it is as a whole
  body->way = record.way;
  body->rigid_frame = record.rigid_frame;
  if (body->free)
    scene_free_place(body);

  // its counters; shape and velocity are read again when asked for
  body->status = (thrum_status)record.status;
  body->work_load = record.work_load;
  body->work_base = record.work_base;
  body->before_state = record.before_state;
  body->q_known = body->p_known = false;
}

thrum_status thrum_scene_restore(thrum_scene *scene, const void *memory, size_t size,
                                 thrum_error *error) {
  THRUM_TRY(thrum_seal_check(memory, size, kind, thrum_scene_snapshot_size(scene), error));
  const unsigned char *at = (const unsigned char *)memory + THRUM_SEAL_BYTES;
  THRUM_TRY(check_content(scene, at, error));

  // nothing can fail from here on
  scene_record head;
  take(&at, &head, sizeof head);
  for (int32_t n = 0; n < scene->body_count; n++)
    take_body(scene->bodies[n], &at);
  if (scene->obstacle_count > 0)
    take(&at, scene->obstacles, (size_t)scene->obstacle_count * sizeof *scene->obstacles);
  if (scene->pairs.contact != NULL)
    take(&at, scene->pairs.contact, thrum_contact_pairs_kept_bytes(scene->pairs.contact));
  for (int32_t n = 0; n < scene->link_count; n++) {
    link_record record;
    take(&at, &record, sizeof record);
    scene->links[n].released = record.released != 0;
    scene->links[n].tie.steps = record.steps;
    scene->links[n].tie.report = record.report;
  }
  scene->steps = head.steps;
  scene->origin_step = head.origin_step;
  scene->origin = head.origin;
  memcpy(scene->eye, head.eye, sizeof scene->eye);
  scene_loads_retime(scene);
  return THRUM_OK;
}
