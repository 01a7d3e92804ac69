/* Point location in a tetrahedral mesh: boxes halved at the median along their longest side; a
 * query goes into the nearer box first and leaves out what is farther than the best so far.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/tet_tree.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "mesh/tet_distance.h"
#include "platform/allocate.h"

enum { LEAF = 4, DEPTH_MAX = 64 };

/* Distances that differ by less are one: the same place, reached through neighbours. */
#define SAME 1e-9

typedef struct tree_node {
  double low[3], high[3];
  int32_t first; /* of a leaf's tetrahedra in `order`; of an inner node's two children */
  int32_t count; /* of tetrahedra; 0: inner */
} tree_node;

struct thrum_tet_tree {
  thrum_scope memory; /* of itself and its arrays */
  const double *vertices;
  const int32_t *tets;
  int32_t *order; /* tetrahedra, leaf by leaf */
  tree_node *nodes;
  int64_t node_count;
};

void thrum_tet_tree_free(thrum_tet_tree *tree) {
  if (tree == NULL)
    return;
  thrum_scope memory = tree->memory;
  thrum_scope_free(&memory);
}

static const double *corner(const thrum_tet_tree *tree, int32_t tet, int c) {
  return tree->vertices + 3 * (int64_t)tree->tets[4 * (int64_t)tet + c];
}

/* Four times the centre of each tetrahedron (x 3). */
static void find_centres(const thrum_tet_tree *tree, int64_t count, double *centres) {
  for (int64_t n = 0; n < 3 * count; n++) {
    const int32_t tet = (int32_t)(n / 3);
    const int axis = (int)(n % 3);
    centres[n] = corner(tree, tet, 0)[axis] + corner(tree, tet, 1)[axis] +
                 corner(tree, tet, 2)[axis] + corner(tree, tet, 3)[axis];
  }
}

static void empty_box(tree_node *node) {
  for (int axis = 0; axis < 3; axis++) {
    node->low[axis] = INFINITY;
    node->high[axis] = -INFINITY;
  }
}

static void grow_box(tree_node *node, const double low[3], const double high[3]) {
  for (int axis = 0; axis < 3; axis++) {
    node->low[axis] = low[axis] < node->low[axis] ? low[axis] : node->low[axis];
    node->high[axis] = high[axis] > node->high[axis] ? high[axis] : node->high[axis];
  }
}

/* Boxes of the leaves, then, as children stand behind their parents, of the rest. */
static void find_boxes(thrum_tet_tree *tree) {
  for (int64_t n = tree->node_count - 1; n >= 0; n--) {
    tree_node *node = &tree->nodes[n];
    empty_box(node);
    for (int32_t t = node->first; t < node->first + node->count; t++)
      for (int c = 0; c < 4; c++) {
        const double *x = corner(tree, tree->order[t], c);
        grow_box(node, x, x);
      }
    for (int child = 0; child < 2 && node->count == 0; child++) {
      const tree_node *part = &tree->nodes[node->first + child];
      grow_box(node, part->low, part->high);
    }
  }
}

/* Puts the lower half of [first, last] along an axis in front: quickselect of the place `middle`.
 */
static void halve(int32_t *order, const double *centres, int axis, int64_t first, int64_t last,
                  int64_t middle) {
  centres += axis;
  while (first < last) {
    const double pivot = centres[3 * (int64_t)order[first + (last - first) / 2]];
    int64_t i = first, j = last;

    // what is below the pivot goes in front of what is above
    while (i <= j) {
      while (centres[3 * (int64_t)order[i]] < pivot)
        i++;
      while (centres[3 * (int64_t)order[j]] > pivot)
        j--;
      if (i > j)
        break;
      const int32_t swap = order[i];
      order[i++] = order[j];
      order[j--] = swap;
    }

    // the part that holds the middle goes on
    if (middle <= j)
      last = j;
    else if (middle >= i)
      first = i;
    else
      return;
  }
}

/* Splits node by node until leaves are small; children stand behind all nodes made so far. */
static void split_all(thrum_tet_tree *tree, const double *centres) {
  for (int64_t n = 0; n < tree->node_count; n++) {
    tree_node *node = &tree->nodes[n];
    if (node->count <= LEAF)
      continue;

    // the box of the centres of its tets, which is split across its longest side
    const int32_t first = node->first, count = node->count, half = count / 2;
    empty_box(node);
    for (int32_t t = first; t < first + count; t++) {
      const double *x = centres + 3 * (int64_t)tree->order[t];
      grow_box(node, x, x);
    }

    int axis = 0;
    for (int a = 1; a < 3; a++)
      if (node->high[a] - node->low[a] > node->high[axis] - node->low[axis])
        axis = a;

    // both halves get about as many tets, so the depth is bounded
    halve(tree->order, centres, axis, first, (int64_t)first + count - 1, (int64_t)first + half);
    tree->nodes[tree->node_count] = (tree_node){.first = first, .count = half};
    tree->nodes[tree->node_count + 1] = (tree_node){.first = first + half, .count = count - half};

    node->first = (int32_t)tree->node_count;
    node->count = 0;
    tree->node_count += 2;
  }
  find_boxes(tree);
}

thrum_status thrum_tet_tree_make(const double *vertices, const int32_t *tets, int64_t tet_count,
                                 thrum_tet_tree **tree, thrum_error *error) {
  if (tet_count < 1 || tet_count >= INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "a tree of %lld tetrahedra",
                           (long long)tet_count);

  // a leaf holds at least LEAF / 2 tetrahedra, when there are so many at all
  const int64_t leaves = tet_count / (LEAF / 2) + 1;
  thrum_scope memory = thrum_scope_begin("the search for tetrahedra", error);
  thrum_tet_tree *made = thrum_scope_allocate(&memory, 1, sizeof *made);
  int32_t *order = thrum_scope_allocate(&memory, tet_count, sizeof *order);
  tree_node *nodes = thrum_scope_allocate(&memory, 2 * leaves, sizeof *nodes);
  double *centres = NULL;
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_reserve(&centres, tet_count, 3 * sizeof *centres, memory.what, error));
  if (status < 0) {
    thrum_scope_free(&memory);
    return status;
  }

  // the root holds all, and is split until leaves are small
  for (int64_t t = 0; t < tet_count; t++)
    order[t] = (int32_t)t;
  nodes[0] = (tree_node){.first = 0, .count = (int32_t)tet_count};
  *made = (thrum_tet_tree){memory, vertices, tets, order, nodes, 1};
  find_centres(made, tet_count, centres);
  split_all(made, centres);
  free(centres);
  *tree = made;
  return THRUM_OK;
}

static double least(const double weights[4]) {
  return fmin(fmin(weights[0], weights[1]), fmin(weights[2], weights[3]));
}

/* The weights of a point in one tetrahedron; just 0 and 1 at a corner. */
static thrum_tet_place weigh(const thrum_tet_tree *tree, int32_t tet, const double point[3]) {
  const double *corners[4];
  thrum_tet_place place = {.tet = tet};
  for (int c = 0; c < 4; c++)
    corners[c] = corner(tree, tet, c);
  for (int c = 0; c < 4; c++)
    if (corners[c][0] == point[0] && corners[c][1] == point[1] && corners[c][2] == point[2]) {
      place.weights[c] = 1;
      return place;
    }
  thrum_tet_weights(corners, point, place.weights);
  return place;
}

/* The same with the distance, squared here. */
static thrum_tet_place place_in(const thrum_tet_tree *tree, int32_t tet, const double point[3]) {
  // the corners opposite to each corner
  static const int opposite[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  thrum_tet_place place = weigh(tree, tet, point);
  if (least(place.weights) >= 0)
    return place;
  // the nearest point lies on a face that the point is in front of
  place.distance = INFINITY;
  for (int c = 0; c < 4; c++)
    if (!(place.weights[c] >= 0))
      place.distance =
          fmin(place.distance, thrum_triangle_distance2(corner(tree, tet, opposite[c][0]),
                                                        corner(tree, tet, opposite[c][1]),
                                                        corner(tree, tet, opposite[c][2]), point));
  return place;
}

static bool holds(const tree_node *box, const double point[3]) {
  return point[0] >= box->low[0] && point[0] <= box->high[0] && point[1] >= box->low[1] &&
         point[1] <= box->high[1] && point[2] >= box->low[2] && point[2] <= box->high[2];
}

/* The tetrahedron that a point lies in; false: none. */
static bool find_around(const thrum_tet_tree *tree, const double point[3], thrum_tet_place *found) {
  int32_t stack[DEPTH_MAX] = {0};
  int depth = 1;
  while (depth > 0) {
    const tree_node *node = &tree->nodes[stack[--depth]];
    if (!holds(node, point))
      continue;

    // the tets of a leaf, their boxes first
    for (int32_t n = node->first; n < node->first + node->count; n++) {
      tree_node box;
      empty_box(&box);
      for (int c = 0; c < 4; c++)
        grow_box(&box, corner(tree, tree->order[n], c), corner(tree, tree->order[n], c));
      if (!holds(&box, point))
        continue;

      *found = weigh(tree, tree->order[n], point);
      if (least(found->weights) >= 0)
        return true;
    }

    // an inner node: its children, the first one next
    if (node->count == 0) {
      stack[depth++] = node->first + 1;
      stack[depth++] = node->first;
    }
  }
  return false;
}

static double box_distance2(const tree_node *node, const double point[3]) {
  double sum = 0;
  for (int axis = 0; axis < 3; axis++) {
    const double off = fmax(fmax(node->low[axis] - point[axis], point[axis] - node->high[axis]), 0);
    sum += off * off;
  }
  return sum;
}

/* Is `place` nearer than the best so far, or as near and less extrapolated? */
static bool is_better(const thrum_tet_place *place, const thrum_tet_place *best) {
  if (!(place->distance <= best->distance * (1 + SAME)))
    return false;
  return place->distance < best->distance * (1 - SAME) ||
         least(place->weights) > least(best->weights);
}

thrum_tet_place thrum_tet_tree_find(const thrum_tet_tree *tree, const double point[3]) {
  thrum_tet_place best;
  if (find_around(tree, point, &best))
    return best;

  // outside all tets: the nearest one, by boxes that are nearer than the best so far
  best = (thrum_tet_place){.tet = tree->order[0], .distance = INFINITY};

  int32_t stack[DEPTH_MAX] = {0};
  int depth = 1;
  while (depth > 0 && !(best.distance <= 0)) {
    const tree_node *node = &tree->nodes[stack[--depth]];
    if (box_distance2(node, point) > best.distance * (1 + SAME))
      continue;

    for (int32_t n = node->first; n < node->first + node->count; n++) {
      const thrum_tet_place place = place_in(tree, tree->order[n], point);
      if (is_better(&place, &best))
        best = place;
    }
    if (node->count > 0)
      continue;

    // the nearer child next, so that the best is found early
    const tree_node *children = &tree->nodes[node->first];
    const int nearer = box_distance2(&children[0], point) <= box_distance2(&children[1], point);
    stack[depth++] = node->first + nearer;
    stack[depth++] = node->first + 1 - nearer;
  }

  best.distance = sqrt(best.distance);
  return best;
}
