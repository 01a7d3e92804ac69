/* How near places of one surface are to each other at rest, for bodies that touch themselves.
 *
 * Two places that share no vertex and are a gap apart at rest touch only after they have moved
 * against each other by that gap. Each node of the tree has the least gap of its places to any
 * other, so a part of the surface that is hardly deformed is left out of the search at once
 * (contact_pairs_search.c). Cost: some 20 pairs of leaves a leaf.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <stdbool.h>

#include "contact/contact_distance.h"
#include "contact/contact_skin.h"
#include "core/base/vec3.h"

#define STACK 64 /* nodes that wait: twice the depth of the tree is enough */

/* The distance at rest between a vertex and a triangle, or between two edges [m]. */
static double distance_of(const thrum_skin_view *view, thrum_quad_kind kind,
                          const int32_t vertices[4]) {
  static const double still[3] = {0.0, 0.0, 0.0};
  thrum_quad quad;
  for (int n = 0; n < 4; n++) {
    quad.x[n] = view->rest + 3 * (int64_t)vertices[n];
    quad.d[n] = still;
  }
  return thrum_quad_nearest(kind, &quad, 0.0).distance;
}

static bool has(const int32_t *vertices, int count, int32_t vertex) {
  bool any = false;
  for (int n = 0; n < count; n++)
    any = any || vertices[n] == vertex;
  return any;
}

/* A bound from below of the distance between two triangles, by their boxes [m]. */
static double boxes_apart(const thrum_skin_view *view, const int32_t *a, const int32_t *b) {
  double most = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    double least[2] = {INFINITY, INFINITY}, largest[2] = {-INFINITY, -INFINITY};
    for (int n = 0; n < 3; n++)
      for (int side = 0; side < 2; side++) {
        const double x = view->rest[3 * (int64_t)(side == 0 ? a : b)[n] + axis];
        least[side] = fmin(least[side], x);
        largest[side] = fmax(largest[side], x);
      }
    most = fmax(most, fmax(least[0] - largest[1], least[1] - largest[0]));
  }
  return most;
}

/* The least gap between the vertices and edges of two triangles, or `gap` where that is less. */
static double gap_of(const thrum_skin_view *view, const int32_t *a, const int32_t *b, double gap) {
  if (boxes_apart(view, a, b) >= gap)
    return gap;

  // vertices of either against the other
  for (int n = 0; n < 3; n++) {
    const int32_t first[4] = {a[n], b[0], b[1], b[2]}, second[4] = {b[n], a[0], a[1], a[2]};
    if (!has(b, 3, a[n]))
      gap = fmin(gap, distance_of(view, THRUM_VERTEX_TRIANGLE, first));
    if (!has(a, 3, b[n]))
      gap = fmin(gap, distance_of(view, THRUM_VERTEX_TRIANGLE, second));
  }

  // edges
  for (int n = 0; n < 3; n++)
    for (int m = 0; m < 3; m++) {
      const int32_t ends[4] = {a[n], a[(n + 1) % 3], b[m], b[(m + 1) % 3]};
      if (!has(ends + 2, 2, ends[0]) && !has(ends + 2, 2, ends[1]))
        gap = fmin(gap, distance_of(view, THRUM_EDGE_EDGE, ends));
    }
  return gap;
}

static double gap_of_leaves(const thrum_skin_view *view, const thrum_skin_node *a,
                            const thrum_skin_node *b, double gap) {
  for (int32_t n = a->first; n < a->first + a->count; n++)
    for (int32_t m = b->first; m < b->first + b->count; m++)
      gap = gap_of(view, view->triangles[n].corners, view->triangles[m].corners, gap);
  return gap;
}

/* The least gap of a leaf to itself and to all others. */
static double gap_of_leaf(const thrum_skin_view *view, const thrum_skin_node *leaf) {
  double gap = gap_of_leaves(view, leaf, leaf, INFINITY);
  int32_t stack[STACK];
  int count = 0;
  stack[count++] = 0;

  // a ball that is no nearer than the gap so far holds nothing nearer
  while (count > 0) {
    const thrum_skin_node *node = view->nodes + stack[--count];
    double apart[3];
    thrum_subtract3(node->middle, leaf->middle, apart);
    if (node == leaf || sqrt(thrum_dot3(apart, apart)) - node->radius - leaf->radius >= gap)
      continue;
    if (node->left < 0) {
      gap = gap_of_leaves(view, leaf, node, gap);
      continue;
    }
    stack[count++] = node->left;
    stack[count++] = node->right;
  }
  return gap;
}

void thrum_skin_prepare_own(thrum_skin *skin) {
  if (skin == NULL || skin->own_known)
    return;

  // nodes follow their parents, so children are known first
  const thrum_skin_view view = thrum_skin_view_of(skin);
  for (int64_t n = skin->node_count - 1; n >= 0; n--) {
    const thrum_skin_node *node = view.nodes + n;
    view.own_gaps[n] = node->left < 0 ? gap_of_leaf(&view, node)
                                      : fmin(view.own_gaps[node->left], view.own_gaps[node->right]);
  }
  skin->own_known = 1;
}
