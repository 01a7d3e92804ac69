/* Normals of a drawn surface, and how they follow the coordinates. As the viewer's smooth.js.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/smooth_normals.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "core/base/vec3.h"

static const double crease = 0.76604444311897803; /* cos 40 degrees: sharper is an edge */

/* A side of a triangle, from the lower to the higher of its vertices. */
typedef struct side {
  int32_t low, high;               /* vertices of the surface */
  int64_t low_corner, high_corner; /* the corners of the triangle at them, 3 triangle + 0..2 */
} side;

void smooth_normals_free(smooth_normals *normals) {
  thrum_scope_free(&normals->memory);
  *normals = (smooth_normals){0};
}

/* --- where the surface is split ----------------------------------------------------------------
 */

static int compare_sides(const void *left, const void *right) {
  const side *a = left, *b = right;
  if (a->low != b->low)
    return a->low < b->low ? -1 : 1;
  if (a->high != b->high)
    return a->high < b->high ? -1 : 1;
  return (a->low_corner > b->low_corner) - (a->low_corner < b->low_corner);
}

/* The corner that stands for all that are joined with this one. */
static int64_t root_of(int64_t *parent, int64_t corner) {
  while (parent[corner] != corner)
    corner = parent[corner] = parent[parent[corner]];
  return corner;
}

/* Twice the area of a triangle, along its normal. */
static void area_of(const render_mesh *shown, int64_t triangle, double area[3]) {
  const int32_t *at = shown->triangles + 3 * triangle;
  const double *x = shown->positions;
  double first[3], second[3];
  thrum_subtract3(x + 3 * at[1], x + 3 * at[0], first);
  thrum_subtract3(x + 3 * at[2], x + 3 * at[0], second);
  thrum_cross3(first, second, area);
}

static bool is_smooth(const double a[3], const double b[3]) {
  return thrum_dot3(a, b) > crease * sqrt(thrum_dot3(a, a) * thrum_dot3(b, b));
}

/* Joins the corners of triangles that meet at a vertex without an edge between them. */
static void join_corners(const render_mesh *shown, const double *areas, side *sides,
                         int64_t *parent) {
  const int64_t count = 3 * shown->triangle_count;
  for (int64_t corner = 0; corner < count; corner++) {
    const int64_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
    const int32_t from = shown->triangles[corner], to = shown->triangles[next];
    parent[corner] = corner;
    sides[corner] = from < to ? (side){from, to, corner, next} : (side){to, from, next, corner};
  }

  // sides between the same two vertices become neighbours
  qsort(sides, (size_t)count, sizeof *sides, compare_sides);
  for (int64_t n = 1; n < count; n++) {
    const side *a = sides + n - 1, *b = sides + n;
    if (a->low != b->low || a->high != b->high ||
        !is_smooth(areas + 3 * (a->low_corner / 3), areas + 3 * (b->low_corner / 3)))
      continue;
    parent[root_of(parent, a->low_corner)] = root_of(parent, b->low_corner);
    parent[root_of(parent, a->high_corner)] = root_of(parent, b->high_corner);
  }
}

/* Numbers the groups of joined corners in the order of their first; returns how many there are. */
static int64_t number_groups(int64_t corners, int64_t *parent, int64_t *number) {
  int64_t groups = 0;
  for (int64_t corner = 0; corner < corners; corner++)
    number[corner] = -1;
  for (int64_t corner = 0; corner < corners; corner++) {
    const int64_t root = root_of(parent, corner);
    if (number[root] < 0)
      number[root] = groups++;
  }
  return groups;
}

/* --- normals ------------------------------------------------------------------------------------
 */

/* How the area of a triangle changes with one coordinate, to first order. */
static void area_change(const render_mesh *shown, int64_t triangle, int64_t column,
                        double change[3]) {
  const int32_t *at = shown->triangles + 3 * triangle;
  double side_by[2][3], moved_by[2][3], turned[3];
  for (int n = 0; n < 2; n++)
    for (int axis = 0; axis < 3; axis++) {
      const int64_t from = 3 * (int64_t)at[0] + axis, to = 3 * (int64_t)at[n + 1] + axis;
      side_by[n][axis] = shown->positions[to] - shown->positions[from];
      moved_by[n][axis] = (double)shown->basis[to * shown->rank + column] -
                          (double)shown->basis[from * shown->rank + column];
    }

  thrum_cross3(moved_by[0], side_by[1], change);
  thrum_cross3(side_by[0], moved_by[1], turned);
  for (int axis = 0; axis < 3; axis++)
    change[axis] += turned[axis];
}

/* Adds a vector of each triangle to its three corners: `out` has `stride` numbers a component. */
static void add_to_corners(const smooth_normals *normals, int64_t triangle, const double vector[3],
                           int64_t stride, int64_t column, float *out) {
  for (int n = 0; n < 3; n++) {
    const int64_t vertex = normals->triangles[3 * triangle + n];
    for (int axis = 0; axis < 3; axis++)
      out[(3 * vertex + axis) * stride + column] += (float)vector[axis];
  }
}

/* Normals at rest to unit length, their changes with them. */
static void normalise(smooth_normals *normals, int64_t rank) {
  for (int64_t v = 0; v < normals->vertex_count; v++) {
    float *normal = normals->normals + 3 * v;
    const double at[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    const double norm = sqrt(thrum_dot3(at, at)), length = norm > 0 ? norm : 1;
    for (int axis = 0; axis < 3; axis++)
      normal[axis] = (float)(at[axis] / length);
    for (int64_t n = 0; n < 3 * rank; n++)
      normals->change[3 * rank * v + n] /= (float)length;
  }
}

static void fill(const render_mesh *shown, const double *areas, int64_t *parent,
                 const int64_t *number, smooth_normals *normals) {
  for (int64_t corner = 0; corner < 3 * shown->triangle_count; corner++) {
    const int64_t vertex = number[root_of(parent, corner)];
    normals->triangles[corner] = (int32_t)vertex;
    normals->source[vertex] = shown->triangles[corner];
  }

  // large triangles count for more, at rest and in the changes alike
  for (int64_t t = 0; t < shown->triangle_count; t++) {
    double change[3];
    add_to_corners(normals, t, areas + 3 * t, 1, 0, normals->normals);
    for (int64_t column = 0; column < shown->rank; column++) {
      area_change(shown, t, column, change);
      add_to_corners(normals, t, change, shown->rank, column, normals->change);
    }
  }
  normalise(normals, shown->rank);
}

/* Room for `count` split vertices; frees what it took on failure. */
static thrum_status allocate(int64_t count, int64_t triangles, int64_t rank,
                             smooth_normals *normals, thrum_error *error) {
  smooth_normals made = {.vertex_count = count,
                         .memory = thrum_scope_begin("the normals of the surface", error)};
  made.source = thrum_scope_allocate(&made.memory, count, sizeof *made.source);
  made.triangles = thrum_scope_allocate(&made.memory, 3 * triangles, sizeof *made.triangles);
  made.normals = thrum_scope_allocate(&made.memory, 3 * count, sizeof *made.normals);
  made.change = thrum_scope_allocate(&made.memory, 3 * count, (size_t)rank * sizeof *made.change);
  const thrum_status status = made.memory.status;
  if (status < 0)
    smooth_normals_free(&made);
  else
    *normals = made;
  return status;
}

thrum_status smooth_normals_make(const render_mesh *shown, smooth_normals *normals,
                                 thrum_error *error) {
  const int64_t triangles = shown->triangle_count;
  thrum_scope work = thrum_scope_begin("the normals of the surface", error);
  double *areas = thrum_scope_allocate(&work, 3 * triangles, sizeof *areas);
  side *sides = thrum_scope_allocate(&work, 3 * triangles, sizeof *sides);
  int64_t *parent = thrum_scope_allocate(&work, 3 * triangles, sizeof *parent);
  int64_t *number = thrum_scope_allocate(&work, 3 * triangles, sizeof *number);
  thrum_status status = work.status;

  // where it is split decides how many vertices there are
  if (status >= 0) {
    for (int64_t t = 0; t < triangles; t++)
      area_of(shown, t, areas + 3 * t);
    join_corners(shown, areas, sides, parent);
    const int64_t count = number_groups(3 * triangles, parent, number);
    status = allocate(count, triangles, shown->rank, normals, error);
  }
  if (status >= 0)
    fill(shown, areas, parent, number, normals);
  thrum_scope_free(&work);
  return status;
}
