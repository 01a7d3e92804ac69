/* Sides of the triangles of a surface, sorted so that equal ones stand together, and the parts of a
 * surface that they join. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_SIDES_H
#define THRUM_MESH_SURFACE_SIDES_H

#include <stdbool.h>
#include <stdint.h>

/* A side of a triangle, or a triangle: its vertices ascending. */
typedef struct thrum_surface_side {
  int32_t low, high, third; /* third: -1 of an edge */
  int32_t triangle;
  bool forth; /* the triangle goes from low to high */
} thrum_surface_side;

/* Sorts by the vertices, and equal sides by their triangles. */
void thrum_surface_sides_sort(thrum_surface_side *sides, int64_t count);

/* The root of i in a union-find forest over triangles or vertices; shortens the way to it. */
int32_t thrum_surface_root(int32_t *parent, int32_t i);

#endif
