/* Faults of a surface by its sorted edges and triangles; see surface_check.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "io/text.h"
#include "mesh/surface_sides.h"
#include "platform/allocate.h"

/* Below this part of its longest side squared a triangle has no area. */
#define FLAT 1e-14

static void note(thrum_surface_fault *fault, int64_t triangle, int32_t from, int32_t to) {
  fault->count++;
  if (fault->triangle >= 0 && fault->triangle <= triangle)
    return;
  *fault = (thrum_surface_fault){fault->count, triangle, {from, to}};
}

/* Measures a triangle. */
typedef struct measures {
  double area[3]; /* twice the area vector */
  double twice;   /* its length */
  double middle[3];
  double longest2; /* its longest side squared */
  double sides;    /* their sum */
  double volume;   /* six times that of the tetrahedron over it from the first vertex in use */
} measures;

static measures measure(const thrum_surface_mesh *surface, int64_t t) {
  measures m = {.twice = 0};
  const double *x[3], *origin = surface->vertices + 3 * (int64_t)surface->triangles[0];
  for (int c = 0; c < 3; c++)
    x[c] = surface->vertices + 3 * (int64_t)surface->triangles[3 * t + c];

  // lengths of the sides
  for (int c = 0; c < 3; c++) {
    double squared = 0;
    for (int axis = 0; axis < 3; axis++)
      squared += (x[c][axis] - x[(c + 1) % 3][axis]) * (x[c][axis] - x[(c + 1) % 3][axis]);
    m.longest2 = fmax(m.longest2, squared);
    m.sides += sqrt(squared);
  }

  // twice the area as a vector, and the volume to one origin for all triangles
  for (int axis = 0; axis < 3; axis++) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    m.area[axis] =
        (x[1][b] - x[0][b]) * (x[2][c] - x[0][c]) - (x[1][c] - x[0][c]) * (x[2][b] - x[0][b]);
    m.middle[axis] = (x[0][axis] + x[1][axis] + x[2][axis]) / 3;
    m.volume += m.area[axis] * (x[0][axis] - origin[axis]);
    m.twice += m.area[axis] * m.area[axis];
  }

  m.twice = sqrt(m.twice);
  return m;
}

static bool is_flat(const int32_t v[3], const measures *m) {
  return v[0] == v[1] || v[1] == v[2] || v[2] == v[0] || !(m->twice > FLAT * m->longest2);
}

bool thrum_surface_is_flat(const thrum_surface_mesh *surface, int64_t triangle) {
  const measures m = measure(surface, triangle);
  return is_flat(surface->triangles + 3 * triangle, &m);
}

static void check_triangles(const thrum_surface_mesh *surface, thrum_surface_checked *checked) {
  double total = 0, lengths = 0;
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    const measures m = measure(surface, t);
    const int32_t *v = surface->triangles + 3 * t;
    total += m.volume;
    lengths += m.sides;

    if (is_flat(v, &m))
      note(&checked->flat, t, v[0], v[0] == v[1] ? v[2] : v[1]);

    for (int64_t n = 0; n < 9; n++) {
      const double x = surface->vertices[3 * (int64_t)v[n / 3] + n % 3];
      checked->box_min[n % 3] = fmin(checked->box_min[n % 3], x);
      checked->box_max[n % 3] = fmax(checked->box_max[n % 3], x);
    }
  }

  checked->volume = total / 6;
  checked->edge_mean = lengths / (3 * (double)surface->triangle_count);
}

static void check_twice(const thrum_surface_mesh *surface, thrum_surface_side *sides,
                        thrum_surface_checked *checked) {
  // each triangle by its vertices in ascending order
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    int32_t v[3];
    memcpy(v, surface->triangles + 3 * t, sizeof v);
    for (int i = 1; i < 3; i++)
      for (int j = i; j > 0 && v[j] < v[j - 1]; j--) {
        const int32_t swap = v[j];
        v[j] = v[j - 1];
        v[j - 1] = swap;
      }
    sides[t] = (thrum_surface_side){v[0], v[1], v[2], (int32_t)t, true};
  }

  // equal triangles stand together
  thrum_surface_sides_sort(sides, surface->triangle_count);
  for (int64_t n = 1; n < surface->triangle_count; n++)
    if (sides[n].low == sides[n - 1].low && sides[n].high == sides[n - 1].high &&
        sides[n].third == sides[n - 1].third)
      note(&checked->twice, sides[n].triangle, sides[n].low, sides[n].high);
}

/* One edge and the `count` triangles at it. */
static void check_edge(const thrum_surface_side *at, int64_t count,
                       thrum_surface_checked *checked) {
  const int32_t t = at[0].triangle;
  if (count == 1)
    note(&checked->open, t, at->low, at->high);
  if (count > 2)
    note(&checked->crowded, t, at->low, at->high);
  if (count == 2 && at[0].forth == at[1].forth)
    note(&checked->turned, t, at->low, at->high);
}

/* Sorts the sides and joins triangles that share one: root[t] of each leads to the first of its
 * shell. What is wrong with edges goes into `checked`, unless it is NULL. */
static void join_edges(const thrum_surface_mesh *surface, thrum_surface_side *sides, int32_t *root,
                       thrum_surface_checked *checked) {
  // each side by its ends in ascending order, and which way the triangle runs along it
  const int64_t count = 3 * surface->triangle_count;
  for (int64_t n = 0; n < count; n++) {
    const int32_t from = surface->triangles[n];
    const int32_t to = surface->triangles[n % 3 == 2 ? n - 2 : n + 1];
    sides[n] = (thrum_surface_side){from < to ? from : to, from < to ? to : from, -1,
                                    (int32_t)(n / 3), from < to};
  }

  // equal sides stand together, and each triangle begins as a shell of its own
  thrum_surface_sides_sort(sides, count);
  for (int64_t t = 0; t < surface->triangle_count; t++)
    root[t] = (int32_t)t;

  // triangles that share a side belong to one shell
  for (int64_t n = 0, end; n < count; n = end) {
    for (end = n + 1;
         end < count && sides[end].low == sides[n].low && sides[end].high == sides[n].high; end++)
      root[thrum_surface_root(root, sides[end].triangle)] =
          thrum_surface_root(root, sides[n].triangle);
    if (checked != NULL)
      check_edge(sides + n, end - n, checked);
  }
}

thrum_status thrum_surface_check(const thrum_surface_mesh *surface, thrum_surface_checked *checked,
                                 thrum_error *error) {
  const size_t triangles = (size_t)surface->triangle_count;
  if (triangles == 0)
    return thrum_error_set(error, THRUM_MISSING, "the surface has no triangles");
  thrum_scope scope = thrum_scope_begin("the check of the surface", error);
  thrum_surface_side *sides =
      thrum_scope_allocate(&scope, surface->triangle_count, 3 * sizeof *sides);
  int32_t *root = thrum_scope_allocate(&scope, surface->triangle_count, sizeof *root);

  // no fault has been seen, and the box is empty
  const thrum_surface_fault none = {0, -1, {0, 0}};
  thrum_surface_checked made = {.flat = none,
                                .twice = none,
                                .open = none,
                                .crowded = none,
                                .turned = none,
                                .box_min = {INFINITY, INFINITY, INFINITY},
                                .box_max = {-INFINITY, -INFINITY, -INFINITY}};

  // triangles alone, then in pairs, then along their sides
  if (scope.status >= 0) {
    check_triangles(surface, &made);
    check_twice(surface, sides, &made);
    join_edges(surface, sides, root, &made);
    for (size_t t = 0; t < triangles; t++)
      made.shells += thrum_surface_root(root, (int32_t)t) == (int32_t)t;
    *checked = made;
  }

  thrum_scope_free(&scope);
  return scope.status;
}

/* A shell in the making: its volume times six, and its largest triangle. */
typedef struct shell {
  double volume, area;
  int64_t largest;
} shell;

/* A point a thousandth of the triangle's size before its middle, `sign` times along its normal. */
static void find_point(const thrum_surface_mesh *surface, int64_t t, double sign, double point[3]) {
  const measures m = measure(surface, t);
  for (int axis = 0; axis < 3; axis++)
    point[axis] = m.middle[axis] + sign * 1e-3 * m.area[axis] / sqrt(m.twice);
}

/* Returns six times the volume of all. */
static double measure_shells(const thrum_surface_mesh *surface, int32_t *root, shell *shells) {
  double total = 0;
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    const measures m = measure(surface, t);
    shell *of = &shells[thrum_surface_root(root, (int32_t)t)];
    of->volume += m.volume;
    total += m.volume;
    if (m.twice > of->area) {
      of->area = m.twice;
      of->largest = t;
    }
  }
  return total;
}

thrum_status thrum_surface_cavities(const thrum_surface_mesh *surface, double **points,
                                    int64_t *count, thrum_error *error) {
  const size_t triangles = (size_t)surface->triangle_count;
  thrum_scope scope = thrum_scope_begin("the check of the surface", error);
  thrum_surface_side *sides =
      thrum_scope_allocate(&scope, surface->triangle_count, 3 * sizeof *sides);
  int32_t *root = thrum_scope_allocate(&scope, surface->triangle_count, sizeof *root);
  shell *shells = thrum_scope_allocate(&scope, surface->triangle_count, sizeof *shells);
  double *made = NULL;
  thrum_status status = scope.status;
  THRUM_THEN(status, thrum_reserve(&made, surface->triangle_count, 3 * sizeof *made,
                                   "the check of the surface", error));

  // a shell whose volume has the other sign bounds a cavity
  int64_t found = 0;
  if (status >= 0 && triangles > 0) {
    join_edges(surface, sides, root, NULL);
    const double total = measure_shells(surface, root, shells);
    for (size_t t = 0; t < triangles; t++)
      if (root[t] == (int32_t)t && shells[t].volume * total < 0)
        find_point(surface, shells[t].largest, total > 0 ? 1 : -1, made + 3 * found++);
  }

  thrum_scope_free(&scope);
  if (status >= 0) {
    *points = made;
    *count = found;
  }
  return status;
}

thrum_status thrum_surface_refuse(const thrum_surface_mesh *surface,
                                  const thrum_surface_fault *fault, const char *path,
                                  const char *what, thrum_error *error) {
  const double *x = surface->vertices + 3 * (int64_t)fault->edge[0];
  const double *y = surface->vertices + 3 * (int64_t)fault->edge[1];
  thrum_text text = {.name = path,
                     .error = error,
                     .line = surface->binary ? 0 : surface->triangle_line[fault->triangle]};
  char facet[48] = "";
  if (surface->binary)
    snprintf(facet, sizeof facet, " in facet %lld",
             (long long)surface->triangle_line[fault->triangle]);
  return thrum_text_fail(&text, THRUM_BAD_VALUE,
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
      return thrum_surface_refuse(surface, faults[n].fault, path, faults[n].what, error);
  return THRUM_OK;
}
