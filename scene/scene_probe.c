/* Probes: the mean of some vertices, whose rows of U are averaged once.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_access.h"
#include "scene/scene_memory.h"
#include "scene/scene_shape.h"

#include <stdio.h>
#include <stdlib.h>

static thrum_status check(const scene_body *body, const int32_t *vertices, int64_t count,
                          thrum_error *error) {
  if (count < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a probe is given no vertices");
  for (int64_t n = 0; n < count; n++)
    THRUM_TRY(scene_vertex_check(body, vertices ? vertices[n] : n, error));
  return THRUM_OK;
}

/* Means of the rest positions and of the rows of U. */
static void average(const thrum_model *model, const int32_t *vertices, int64_t count,
                    scene_probe *probe) {
  const int64_t r = model->rank;
  for (int64_t n = 0; n < count; n++) {
    const int64_t v = vertices ? vertices[n] : n;
    for (int axis = 0; axis < 3; axis++)
      probe->rest[axis] += model->vertices[3 * v + axis] / (double)count;
    for (int64_t i = 0; i < 3 * r; i++)
      probe->rows[i] += model->basis[3 * v * r + i] / (double)count;
  }
}

thrum_status thrum_scene_add_probe(thrum_scene *scene, const char *name, int32_t number,
                                   const int32_t *vertices, int64_t count, thrum_error *error) {
  // the vertices are checked before anything changes
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  const int64_t all = vertices ? count : body->model->vertex_count;
  THRUM_TRY(check(body, vertices, all, error));

  scene_probe probe = {.body = number};
  probe.rows = calloc(3 * (size_t)body->model->rank, sizeof *probe.rows);
  if (!probe.rows || !scene_grow(&scene->probes, scene->probe_count + 1, sizeof *scene->probes)) {
    free(probe.rows);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a probe");
  }

  // a probe without a name is called by its number
  if (name != NULL)
    snprintf(probe.name, sizeof probe.name, "%.*s", THRUM_SCENE_NAME_MAX - 1, name);
  else
    snprintf(probe.name, sizeof probe.name, "probe%d", (int)scene->probe_count + 1);

  average(body->model, vertices, all, &probe);
  scene->probes[scene->probe_count++] = probe;
  return THRUM_OK;
}

int32_t thrum_scene_probe_count(const thrum_scene *scene) {
  return scene->probe_count;
}

static const scene_probe *probe_at(const thrum_scene *scene, int32_t probe) {
  return probe >= 0 && probe < scene->probe_count ? &scene->probes[probe] : NULL;
}

const char *thrum_scene_probe_name(const thrum_scene *scene, int32_t probe) {
  const scene_probe *found = probe_at(scene, probe);
  return found ? found->name : NULL;
}

int32_t thrum_scene_probe_body(const thrum_scene *scene, int32_t probe) {
  const scene_probe *found = probe_at(scene, probe);
  return found ? found->body : -1;
}

thrum_status thrum_scene_probe_get(thrum_scene *scene, int32_t number, double position[3],
                                   double velocity[3], thrum_error *error) {
  const scene_probe *probe = probe_at(scene, number);
  if (probe == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no probe %d: the scene has %d",
                           (int)number, (int)scene->probe_count);
  scene_body *body = scene->bodies[probe->body];
  THRUM_TRY(scene_body_read(body, velocity != NULL, error));
  scene_point(body, probe->rest, probe->rows, position, velocity);
  return THRUM_OK;
}
