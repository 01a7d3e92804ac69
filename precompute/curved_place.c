/* Where a point lies in a mesh of curved elements, see curved_place.h: Newton's method on
 * sum N_a(l) X_a = x, from the coordinates between the corners. SPDX-License-Identifier: Apache-2.0
 */
#include "precompute/curved_place.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "platform/allocate.h"

#define STEPS_MAX 30
#define CLOSE 1e-14  /* of the size of an element: x is reached */
#define INSIDE 1e-12 /* how negative l may be inside, which is rounding */
#define FAR 0.5      /* how negative l may be at all: beyond, a quadratic map runs away */

struct thrum_curved_places {
  thrum_scope memory; /* of itself and its arrays */
  const thrum_model *model;
  int64_t *begin; /* vertex_count + 1: where the tets around each vertex start in `around` */
  int32_t *around;
};

static void node_places(const thrum_model *model, int64_t t, double nodes[10][3]) {
  for (int a = 0; a < 10; a++) {
    const int32_t v = a < 4 ? model->tets[4 * t + a] : model->midsides[6 * t + a - 4];
    memcpy(nodes[a], model->vertices + 3 * (int64_t)v, sizeof nodes[a]);
  }
}

static bool is_curved(const thrum_model *model) {
  for (int64_t t = 0; t < model->tet_count && model->midsides; t++) {
    double nodes[10][3];
    node_places(model, t, nodes);
    if (thrum_quadratic_is_curved(nodes))
      return true;
  }
  return false;
}

thrum_status thrum_curved_places_make(const thrum_model *model, thrum_curved_places **places,
                                      thrum_error *error) {
  *places = NULL;
  if (!is_curved(model))
    return THRUM_OK;

  // the tets around each corner, by counting sort
  thrum_scope memory = thrum_scope_begin("the surface", error);
  thrum_curved_places *made = thrum_scope_allocate(&memory, 1, sizeof *made);
  int64_t *begin = thrum_scope_allocate(&memory, model->vertex_count + 2, sizeof *begin);
  int32_t *around = thrum_scope_allocate(&memory, 4 * model->tet_count, sizeof *around);
  if (memory.status < 0) {
    thrum_scope_free(&memory);
    return memory.status;
  }
  for (int64_t i = 0; i < 4 * model->tet_count; i++)
    begin[model->tets[i] + 2]++;
  for (int64_t v = 0; v < model->vertex_count; v++)
    begin[v + 2] += begin[v + 1];
  for (int64_t i = 0; i < 4 * model->tet_count; i++)
    around[begin[model->tets[i] + 1]++] = (int32_t)(i / 4);
  *made = (thrum_curved_places){memory, model, begin, around};
  *places = made;
  return THRUM_OK;
}

void thrum_curved_places_free(thrum_curved_places *places) {
  if (!places)
    return;
  thrum_scope memory = places->memory;
  thrum_scope_free(&memory);
}

// x(l), relative to node 0
static void map_point(double nodes[10][3], const double l[4], double x[3]) {
  double shape[10];
  thrum_quadratic_shape(l, shape);
  for (int axis = 0; axis < 3; axis++) {
    x[axis] = 0;
    for (int a = 1; a < 10; a++)
      x[axis] += shape[a] * (nodes[a][axis] - nodes[0][axis]);
  }
}

// l with x(l) = point, from the l of the corners; false where Newton's method does not get there
static bool invert(double nodes[10][3], const double point[3], double l[4]) {
  const double size = thrum_box3_longest(nodes[0], 10);
  double target[3], slopes[10][3], gradients[9];
  thrum_subtract3(point, nodes[0], target);

  // straight coordinates of the corners
  double edge[3][3], cross[3];
  for (int a = 0; a < 3; a++)
    thrum_subtract3(nodes[a + 1], nodes[0], edge[a]);
  const double volume = thrum_triple3(edge[0], edge[1], edge[2]);
  for (int a = 0; a < 3; a++) {
    thrum_cross3(edge[(a + 1) % 3], edge[(a + 2) % 3], cross);
    l[a + 1] = thrum_dot3(cross, target) / volume;
  }
  l[0] = 1 - l[1] - l[2] - l[3];

  // one step more than it takes to arrive costs nothing and gains the last digits
  for (int step = 0, arrived = 0; step < STEPS_MAX && isfinite(l[0]); step++) {
    double at[3], rest[3];
    map_point(nodes, l, at);
    thrum_subtract3(target, at, rest);
    if (arrived)
      return true;
    arrived = sqrt(thrum_dot3(rest, rest)) <= CLOSE * size;
    thrum_quadratic_slopes(l, slopes);
    if (!(thrum_quadratic_map(nodes, slopes, gradients) > 0))
      return false;
    for (int a = 0; a < 3; a++)
      l[a + 1] += thrum_dot3(gradients + 3 * a, rest);
    l[0] = 1 - l[1] - l[2] - l[3];
  }
  return false;
}

static double least(const double l[4]) {
  return fmin(fmin(l[0], l[1]), fmin(l[2], l[3]));
}

// tries one element; returns whether the point is inside
static bool try_element(const thrum_curved_places *places, const double point[3], int32_t t,
                        double *best, thrum_tet_place *place) {
  double nodes[10][3], l[4];
  node_places(places->model, t, nodes);
  if (!invert(nodes, point, l) || !(least(l) > *best))
    return false;
  *best = least(l);

  // the distance to the point whose negative coordinates are cut off
  place->tet = t;
  memcpy(place->weights, l, sizeof l);
  place->distance = 0;
  if (*best < -INSIDE) {
    double cut[4], sum = 0, near[3], apart[3];
    for (int a = 0; a < 4; a++)
      sum += cut[a] = fmax(l[a], 0);
    for (int a = 0; a < 4; a++)
      cut[a] /= sum;
    map_point(nodes, cut, near);
    for (int axis = 0; axis < 3; axis++)
      apart[axis] = point[axis] - nodes[0][axis] - near[axis];
    place->distance = sqrt(thrum_dot3(apart, apart));
  }
  return *best >= -INSIDE;
}

void thrum_curved_place(const thrum_curved_places *places, const double point[3],
                        thrum_tet_place *place) {
  const int32_t *corner = places->model->tets + 4 * (int64_t)place->tet;
  double best = -FAR;
  if (try_element(places, point, place->tet, &best, place))
    return;
  for (int c = 0; c < 4; c++)
    for (int64_t i = places->begin[corner[c]]; i < places->begin[corner[c] + 1]; i++)
      if (try_element(places, point, places->around[i], &best, place))
        return;
}
