/* Faults of a surface by its sorted edges and triangles; see surface_check.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/surface_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/places.h"
#include "precompute/text.h"

/* A side of a triangle, or a triangle: its vertices ascending. */
typedef struct side {
  int32_t low, high, third; /* third: -1 of an edge */
  int32_t triangle;
  bool forth; /* the triangle goes from low to high */
} side;

/* Below this part of its longest side squared a triangle has no area. */
#define FLAT 1e-14

static int compare_sides(const void *a, const void *b) {
  const side *x = a, *y = b;
  if (x->low != y->low)
    return x->low < y->low ? -1 : 1;
  if (x->high != y->high)
    return x->high < y->high ? -1 : 1;
  if (x->third != y->third)
    return x->third < y->third ? -1 : 1;
  return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static void note(thrum_surface_fault *fault, int64_t triangle, int32_t from, int32_t to) {
  fault->count++;
  if (fault->triangle >= 0 && fault->triangle <= triangle)
    return;
  *fault = (thrum_surface_fault){fault->count, triangle, {from, to}};
}

/* The corners of a triangle. */
static void find_corners(const thrum_surface_mesh *surface, int64_t t, const double *x[3]) {
  for (int c = 0; c < 3; c++)
    x[c] = surface->vertices + 3 * (int64_t)surface->triangles[3 * t + c];
}

/* Squared sides of a triangle, its area vector times two, and six times its volume from `origin`.
 */
static double measure(const double *const x[3], const double origin[3], double *longest,
                      double *volume, double *sides) {
  double e[2][3], area[3], sum = 0;
  for (int axis = 0; axis < 3; axis++) {
    e[0][axis] = x[1][axis] - x[0][axis];
    e[1][axis] = x[2][axis] - x[0][axis];
  }
  *longest = 0;
  *volume = 0;
  for (int c = 0; c < 3; c++) {
    double squared = 0;
    for (int axis = 0; axis < 3; axis++)
      squared += (x[c][axis] - x[(c + 1) % 3][axis]) * (x[c][axis] - x[(c + 1) % 3][axis]);
    *longest = fmax(*longest, squared);
    *sides += sqrt(squared);
  }
  for (int axis = 0; axis < 3; axis++) {
    area[axis] =
        e[0][(axis + 1) % 3] * e[1][(axis + 2) % 3] - e[0][(axis + 2) % 3] * e[1][(axis + 1) % 3];
    sum += area[axis] * area[axis];
    *volume += area[axis] * (x[0][axis] - origin[axis]);
  }
  return sqrt(sum);
}

static void check_triangles(const thrum_surface_mesh *surface, thrum_surface_checked *checked) {
  const double *x[3];
  double total = 0, lengths = 0;
  find_corners(surface, 0, x);
  // near the surface, so that little cancels
  const double origin[3] = {x[0][0], x[0][1], x[0][2]};
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    double longest, volume;
    find_corners(surface, t, x);
    const double area = measure(x, origin, &longest, &volume, &lengths);
    total += volume;
    const int32_t *v = surface->triangles + 3 * t;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0] || !(area > FLAT * longest))
      note(&checked->flat, t, v[0], v[0] == v[1] ? v[2] : v[1]);
    for (int c = 0; c < 3; c++)
      for (int axis = 0; axis < 3; axis++) {
        checked->box_min[axis] = fmin(checked->box_min[axis], x[c][axis]);
        checked->box_max[axis] = fmax(checked->box_max[axis], x[c][axis]);
      }
  }
  checked->volume = total / 6;
  checked->edge_mean = lengths / (3 * (double)surface->triangle_count);
}

static void check_twice(const thrum_surface_mesh *surface, side *sides,
                        thrum_surface_checked *checked) {
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    int32_t v[3];
    memcpy(v, surface->triangles + 3 * t, sizeof v);
    for (int i = 1; i < 3; i++)
      for (int j = i; j > 0 && v[j] < v[j - 1]; j--) {
        const int32_t swap = v[j];
        v[j] = v[j - 1];
        v[j - 1] = swap;
      }
    sides[t] = (side){v[0], v[1], v[2], (int32_t)t, true};
  }
  qsort(sides, (size_t)surface->triangle_count, sizeof *sides, compare_sides);
  for (int64_t n = 1; n < surface->triangle_count; n++)
    if (sides[n].low == sides[n - 1].low && sides[n].high == sides[n - 1].high &&
        sides[n].third == sides[n - 1].third)
      note(&checked->twice, sides[n].triangle, sides[n].low, sides[n].high);
}

/* The first of the triangles that are joined with t; shortens the way to it. */
static int32_t find_root(int32_t *root, int32_t t) {
  while (root[t] != t)
    t = root[t] = root[root[t]];
  return t;
}

/* One edge and the `count` triangles at it. */
static void check_edge(const side *at, int64_t count, int32_t *root,
                       thrum_surface_checked *checked) {
  const int32_t t = at[0].triangle;
  if (count == 1)
    note(&checked->open, t, at->low, at->high);
  if (count > 2)
    note(&checked->crowded, t, at->low, at->high);
  if (count == 2 && at[0].forth == at[1].forth)
    note(&checked->turned, t, at->low, at->high);
  for (int64_t n = 1; n < count; n++)
    root[find_root(root, at[n].triangle)] = find_root(root, t);
}

static void check_edges(const thrum_surface_mesh *surface, side *sides, int32_t *root,
                        thrum_surface_checked *checked) {
  const int64_t count = 3 * surface->triangle_count;
  for (int64_t n = 0; n < count; n++) {
    const int32_t from = surface->triangles[n];
    const int32_t to = surface->triangles[n % 3 == 2 ? n - 2 : n + 1];
    sides[n] =
        (side){from < to ? from : to, from < to ? to : from, -1, (int32_t)(n / 3), from < to};
  }
  qsort(sides, (size_t)count, sizeof *sides, compare_sides);
  for (int64_t t = 0; t < surface->triangle_count; t++)
    root[t] = (int32_t)t;
  for (int64_t n = 0, end; n < count; n = end) {
    for (end = n + 1;
         end < count && sides[end].low == sides[n].low && sides[end].high == sides[n].high;)
      end++;
    check_edge(sides + n, end - n, root, checked);
  }
  for (int64_t t = 0; t < surface->triangle_count; t++)
    checked->shells += find_root(root, (int32_t)t) == t;
}

thrum_status thrum_surface_check(const thrum_surface_mesh *surface, thrum_surface_checked *checked,
                                 thrum_error *error) {
  const size_t triangles = (size_t)surface->triangle_count;
  if (triangles == 0)
    return thrum_error_set(error, THRUM_MISSING, "the surface has no triangles");
  side *sides = malloc(3 * triangles * sizeof *sides);
  int32_t *root = malloc(triangles * sizeof *root);
  const thrum_surface_fault none = {0, -1, {0, 0}};
  thrum_surface_checked made = {.flat = none,
                                .twice = none,
                                .open = none,
                                .crowded = none,
                                .turned = none,
                                .box_min = {INFINITY, INFINITY, INFINITY},
                                .box_max = {-INFINITY, -INFINITY, -INFINITY}};
  const bool room = sides != NULL && root != NULL;
  if (room) {
    check_triangles(surface, &made);
    check_twice(surface, sides, &made);
    check_edges(surface, sides, root, &made);
    *checked = made;
  }
  free(sides);
  free(root);
  return room ? THRUM_OK
              : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory to check the surface");
}

static thrum_status refuse(const thrum_surface_mesh *surface, const thrum_surface_fault *fault,
                           const char *path, const char *what, thrum_error *error) {
  const double *x = surface->vertices + 3 * (int64_t)fault->edge[0];
  const double *y = surface->vertices + 3 * (int64_t)fault->edge[1];
  thrum_text text = {.name = path,
                     .line = surface->binary ? 0 : surface->triangle_line[fault->triangle]};
  char facet[48] = "";
  if (surface->binary)
    snprintf(facet, sizeof facet, " in facet %lld",
             (long long)surface->triangle_line[fault->triangle]);
  return thrum_text_fail(&text, THRUM_BAD_VALUE, error,
                         "%s: %lld, the first%s from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g)",
                         what, (long long)fault->count, facet, x[0], x[1], x[2], y[0], y[1], y[2]);
}

thrum_status thrum_surface_meshable(const thrum_surface_mesh *surface,
                                    const thrum_surface_checked *checked, const char *path,
                                    thrum_error *error) {
  const struct {
    const thrum_surface_fault *fault;
    const char *what;
  } faults[] = {{&checked->flat, "triangles without area"},
                {&checked->twice, "triangles that are there twice"},
                {&checked->open, "the surface is not closed: edges of one triangle"},
                {&checked->crowded,
                 "the surface crosses or touches itself: edges of three triangles or more"}};
  for (size_t n = 0; n < sizeof faults / sizeof *faults; n++)
    if (faults[n].fault->count > 0)
      return refuse(surface, faults[n].fault, path, faults[n].what, error);
  return THRUM_OK;
}

/* Numbers the vertices anew in the order of their first use; new_number: -1 at first. */
static thrum_status renumber(thrum_surface_mesh *surface, thrum_places *places, int32_t *new_number,
                             double *kept, int64_t *count, int64_t *joined, thrum_error *error) {
  for (int64_t n = 0; n < 3 * surface->triangle_count; n++) {
    const int32_t old = surface->triangles[n];
    if (new_number[old] < 0) {
      const double *x = surface->vertices + 3 * (int64_t)old;
      const thrum_status status =
          thrum_places_find(places, kept, *count, x, &new_number[old], error);
      if (status < 0)
        return status;
      if (new_number[old] == *count)
        memcpy(kept + 3 * (*count)++, x, 3 * sizeof *kept);
      else
        ++*joined;
    }
    surface->triangles[n] = new_number[old];
  }
  return THRUM_OK;
}

thrum_status thrum_surface_join(thrum_surface_mesh *surface, int64_t *joined, thrum_error *error) {
  const size_t all = (size_t)surface->vertex_count;
  thrum_places places = {0};
  int32_t *new_number = malloc((all + 1) * sizeof *new_number);
  double *kept = malloc((3 * all + 1) * sizeof *kept);
  int64_t count = 0;
  thrum_status status = THRUM_OK;
  *joined = 0;
  if (new_number == NULL || kept == NULL) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface");
  } else {
    memset(new_number, 0xff, all * sizeof *new_number);
    status = renumber(surface, &places, new_number, kept, &count, joined, error);
  }
  free(new_number);
  thrum_places_free(&places);
  if (status < 0) {
    free(kept);
    return status;
  }
  free(surface->vertices);
  surface->vertices = kept;
  surface->vertex_count = count;
  return THRUM_OK;
}
