/* The surface of a body as far as wind and contact need it: its vertices and their share of the
 * triangles' area. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static thrum_status check(const thrum_scene_body_def *def, thrum_error *error) {
  const thrum_model *model = def->model;

  // a body that nothing meets needs no basis
  if (def->triangle_count <= 0 && def->touch_count <= 0)
    return THRUM_OK;
  if ((def->triangle_count > 0 && !def->triangles) || (def->touch_count > 0 && !def->touch))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "triangles or touch is NULL, and its count is not 0");
  if (!model->vertices || !model->basis)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so it has no surface: precompute it from a "
                           "mesh");

  // indices are read without a test later
  for (int64_t n = 0; n < 3 * def->triangle_count; n++)
    if (def->triangles[n] < 0 || def->triangles[n] >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "a triangle names vertex %lld; the model has %lld",
                             (long long)def->triangles[n], (long long)model->vertex_count);
  for (int64_t n = 0; n < def->touch_count; n++)
    if (def->touch[n] < 0 || def->touch[n] >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "vertex %lld is to touch; the model has %lld",
                             (long long)def->touch[n], (long long)model->vertex_count);

  return THRUM_OK;
}

/* Half the outward normal, as long as the area, of a triangle at rest. */
static void area_of(const thrum_model *model, const int32_t *corner, double area[3]) {
  const double *a = model->vertices + 3 * (int64_t)corner[0];
  const double *b = model->vertices + 3 * (int64_t)corner[1];
  const double *c = model->vertices + 3 * (int64_t)corner[2];
  const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double f[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    area[axis] = 0.5 * (e[next] * f[last] - e[last] * f[next]);
  }
}

/* The area that each vertex of the model stands for: a third of its triangles; all is vertex_count
 * x 4, the area vector and the plain area. */
static void share_areas(const thrum_scene_body_def *def, double *all) {
  const double square = def->scale * def->scale;
  for (int64_t n = 0; n < def->triangle_count; n++) {
    const int32_t *corner = def->triangles + 3 * n;
    double area[3];
    area_of(def->model, corner, area);
    const double plain = sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    for (int k = 0; k < 3; k++) {
      double *share = all + 4 * (int64_t)corner[k];
      for (int axis = 0; axis < 3; axis++)
        share[axis] += square * area[axis] / 3;
      share[3] += square * plain / 3;
    }
  }
}

/* The vertices that have a share, ascending. */
static void pick(const thrum_model *model, const double *all, scene_body *body) {
  const int64_t r = model->rank;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *share = all + 4 * v;
    if (!(share[3] > 0))
      continue;
    const int64_t place = body->surface_count++;
    body->surface[place] = (int32_t)v;
    memcpy(body->areas + 3 * place, share, 3 * sizeof *share);
    double square = 0;
    for (int64_t i = 0; i < 3 * r; i++)
      square += model->basis[3 * v * r + i] * model->basis[3 * v * r + i];
    body->stretch[place] = body->k * body->k * square;
  }
}

/* The vertices that may touch; those of no area only where no triangles are known, and none that is
 * held, since nothing can push it. */
static void pick_touch(const thrum_scene_body_def *def, const double *all, scene_body *body) {
  for (int64_t n = 0; n < def->touch_count; n++) {
    const int32_t v = def->touch[n];
    const bool held = def->model->fixed && def->model->fixed[v] == 7;
    if (held || (def->triangle_count > 0 && !(all[4 * (int64_t)v + 3] > 0)))
      continue;
    body->touch_areas[body->touch_count] = all[4 * (int64_t)v + 3];
    body->touching[body->touch_count++] = v;
  }
}

thrum_status scene_surface_make(const thrum_scene_body_def *def, scene_body *body,
                                thrum_error *error) {
  // a body without a surface has nothing to show or to touch with
  const thrum_status status = check(def, error);
  if (status < 0 || (def->triangle_count <= 0 && def->touch_count <= 0))
    return status;

  // room for the surface that is shown and for the points that touch
  const size_t count = (size_t)def->model->vertex_count, touches = (size_t)def->touch_count;
  double *all = calloc(4 * count + 1, sizeof *all);
  const size_t shown = def->triangle_count > 0 ? count : 1;
  body->surface = malloc(shown * sizeof *body->surface);
  body->areas = malloc(3 * shown * sizeof *body->areas);
  body->stretch = malloc(shown * sizeof *body->stretch);
  body->touching = malloc((touches + 1) * sizeof *body->touching);
  body->touch_areas = malloc((touches + 1) * sizeof *body->touch_areas);
  if (!all || !body->surface || !body->areas || !body->stretch || !body->touching ||
      !body->touch_areas) {
    free(all);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface of a body");
  }

  // areas by vertex; from them what the wind and the contact need
  share_areas(def, all);
  pick(def->model, all, body);
  pick_touch(def, all, body);
  body->areas_known = def->triangle_count > 0;
  body->touch_stiffness = def->touch_stiffness;
  free(all);
  return THRUM_OK;
}
