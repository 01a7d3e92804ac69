/* What a page does with its one scene beside the calls of javascript/bridge_scene.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#define BODIES_MAX 256

static int32_t model_of_body[BODIES_MAX];

const page_model *page_body_model(const thrum_scene *scene, int32_t body) {
  if (body < 0 || body >= thrum_scene_body_count(scene))
    return NULL;
  return page_model_at(model_of_body[body]);
}

/* js_scene_add_body of a model of the page, with its surface. */
int32_t EXPORT(page_add_body)(thrum_scene *scene, int32_t model, int32_t integrator, double alpha,
                              const double *q, const double *p) {
  const page_model *of = page_model_at(model);
  if (of == NULL || thrum_scene_body_count(scene) == BODIES_MAX)
    return thrum_error_set(&js_failure, THRUM_INVALID_ARGUMENT,
                           "a body has no model, or there are more than %d bodies", BODIES_MAX);
  thrum_scene_body_def *def = js_def_made();
  def->triangles = of->triangles;
  def->triangle_count = of->triangle_count;
  def->touch = of->touch;
  def->touch_count = of->touch_count;

  // the scene makes a copy, so the page keeps which model it was
  const int32_t body = js_scene_add_body(scene, &of->model, integrator, alpha, 0, q, p);
  if (body >= 0)
    model_of_body[body] = model;
  return body;
}

/* q of the model's full rank, as floats for the GPU. */
int32_t EXPORT(page_shape)(thrum_scene *scene, int32_t body, float *out) {
  double q[THRUM_RANK_MAX];
  THRUM_TRY(thrum_scene_body_shape(scene, body, q, &js_failure));
  for (int64_t i = 0; i < page_body_model(scene, body)->model.rank; i++)
    out[i] = (float)q[i];
  return THRUM_OK;
}

/* omega^2 of the modes of a body, rank of them. */
const double *EXPORT(page_omega2)(const thrum_scene *scene, int32_t body) {
  thrum_scene_body_info info;
  if (thrum_scene_body(scene, body, &info, &js_failure) != THRUM_OK)
    return NULL;
  return info.stepped->omega2;
}

/* Frequencies of its modes as a step gives them [Hz], rank of them; NaN where a mode does not
 * vibrate. */
const double *EXPORT(page_stepped_frequencies)(const thrum_scene *scene, int32_t body) {
  static thrum_stepped_mode modes[THRUM_RANK_MAX];
  static double hertz[THRUM_RANK_MAX];
  thrum_scene_body_info info;
  if (thrum_scene_body(scene, body, &info, &js_failure) != THRUM_OK ||
      thrum_scene_body_stepped_modes(scene, body, modes, &js_failure) != THRUM_OK)
    return NULL;
  for (int64_t i = 0; i < info.rank; i++)
    hertz[i] = modes[i].stepped_hertz;
  return hertz;
}

/* Displacement per force at a vertex of the body as it is stepped, at rest, summed over the axes
 * [m/N]: tr(U_v diag(1/omega^2) U_v^T). */
static double compliance(const thrum_scene *scene, int32_t body, int32_t vertex,
                         const thrum_scene_body_info *info) {
  const thrum_model *model = &page_body_model(scene, body)->model;
  const double *rows = model->basis + 3 * (int64_t)vertex * model->rank;
  // U' = k U, k^2 = 1 / (density scale^3), has unit mass as U has
  const double k2 = 1.0 / (info->density * info->scale * info->scale * info->scale);
  double sum = 0.0;
  for (int64_t i = 0; i < info->rank; i++)
    for (int axis = 0; axis < 3; axis++) {
      double u = rows[axis * model->rank + i];
      sum += k2 * u * u / info->stepped->omega2[i];
    }

  // what follows gives way as well
  const double scale = info->stiffness / (info->density * info->scale * info->scale);
  for (int64_t i = info->rank; info->condensed && i < model->rank; i++)
    for (int axis = 0; axis < 3; axis++) {
      double u = rows[axis * model->rank + i];
      sum += k2 * u * u / (scale * model->omega2[i]);
    }
  return sum;
}

/* Begins to pull a vertex that is not held towards numbers 0..2 [m], with a spring of `strength`
 * times the stiffness that the body itself has there. Returns its number, or a status below 0. */
int32_t EXPORT(page_pull_start)(thrum_scene *scene, int32_t body, int32_t vertex, double strength) {
  thrum_scene_body_info info;
  THRUM_TRY(thrum_scene_body(scene, body, &info, &js_failure));

  // its compliance is read from the rows of the basis before the scene sees the vertex
  if (vertex < 0 || vertex >= page_body_model(scene, body)->model.vertex_count)
    return thrum_error_set(&js_failure, THRUM_INVALID_ARGUMENT,
                           "the body has no vertex %ld to pull at", (long)vertex);
  int32_t pull = 0;
  THRUM_TRY(thrum_scene_pull_start(scene, body, vertex, js_number,
                                   strength / compliance(scene, body, vertex, &info), -1.0, &pull,
                                   &js_failure));
  return pull;
}
