/* Snapshots: what steps change, one record after the other.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "scene/scene_free_body.h"
#include "scene/scene_loads.h"

#define SNAPSHOT_MAGIC UINT64_C(0x7468736e61700002)

typedef struct scene_record {
  uint64_t magic, revision, size;
  int64_t steps, origin_step;
  double origin;
} scene_record;

typedef struct body_record {
  int64_t status, fallback_steps;
  double work_load, work_base, dissipated;
  thrum_translation way;
  thrum_rigid_frame rigid_frame;
} body_record;

static size_t contact_bytes(const scene_body *body) {
  return body->touch != NULL ? thrum_contact_bytes(body->touch->contact) : 0;
}

size_t thrum_scene_snapshot_size(const thrum_scene *scene) {
  size_t size = sizeof(scene_record);
  for (int32_t n = 0; n < scene->body_count; n++) {
    const scene_body *body = scene->bodies[n];
    size += sizeof(body_record) + (size_t)body->derived->rank * sizeof(double) +
            thrum_state_kept_bytes(body->state) + contact_bytes(body);
  }
  return size + (size_t)scene->obstacle_count * sizeof *scene->obstacles;
}

static thrum_status check_size(const thrum_scene *scene, const void *memory, size_t size,
                               thrum_error *error) {
  const size_t needed = thrum_scene_snapshot_size(scene);
  if (memory != NULL && size >= needed)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                         "a snapshot of this scene has %zu bytes, the memory %zu", needed, size);
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
  const thrum_status status = check_size(scene, memory, size, error);
  if (status < 0)
    return status;
  unsigned char *at = memory;
  const scene_record head = {
      SNAPSHOT_MAGIC, scene->revision,    (uint64_t)thrum_scene_snapshot_size(scene),
      scene->steps,   scene->origin_step, scene->origin};
  put(&at, &head, sizeof head);
  for (int32_t n = 0; n < scene->body_count; n++) {
    const scene_body *body = scene->bodies[n];
    const body_record record = {body->status,     body->fallback_steps, body->work_load,
                                body->work_base,  body->dissipated,     body->way,
                                body->rigid_frame};
    put(&at, &record, sizeof record);
    put(&at, body->before, (size_t)body->derived->rank * sizeof *body->before);
    put(&at, body->state, thrum_state_kept_bytes(body->state));
    if (body->touch != NULL)
      put(&at, body->touch->contact, contact_bytes(body));
  }
  if (scene->obstacle_count > 0)
    put(&at, scene->obstacles, (size_t)scene->obstacle_count * sizeof *scene->obstacles);
  return THRUM_OK;
}

thrum_status thrum_scene_restore(thrum_scene *scene, const void *memory, size_t size,
                                 thrum_error *error) {
  const thrum_status status = check_size(scene, memory, size, error);
  if (status < 0)
    return status;
  const unsigned char *at = memory;
  scene_record head;
  take(&at, &head, sizeof head);
  if (head.magic != SNAPSHOT_MAGIC || head.revision != scene->revision ||
      head.size != thrum_scene_snapshot_size(scene))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is none of the scene as it is now: what it is made of has "
                           "changed since");
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    body_record record;
    take(&at, &record, sizeof record);
    take(&at, body->before, (size_t)body->derived->rank * sizeof *body->before);
    take(&at, body->state, thrum_state_kept_bytes(body->state));
    if (body->touch != NULL)
      take(&at, body->touch->contact, contact_bytes(body));
    body->way = record.way;
    body->rigid_frame = record.rigid_frame;
    if (body->free)
      scene_free_place(body);
    body->status = (thrum_status)record.status;
    body->fallback_steps = record.fallback_steps;
    body->work_load = record.work_load;
    body->work_base = record.work_base;
    body->dissipated = record.dissipated;
    body->q_known = body->p_known = false;
  }
  if (scene->obstacle_count > 0)
    take(&at, scene->obstacles, (size_t)scene->obstacle_count * sizeof *scene->obstacles);
  scene->steps = head.steps;
  scene->origin_step = head.origin_step;
  scene->origin = head.origin;
  scene_loads_retime(scene);
  return THRUM_OK;
}
