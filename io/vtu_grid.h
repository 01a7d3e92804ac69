/* Writes VTK's XML files of tetrahedra and other solids (.vtu), in base64 or as text.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_VTU_GRID_H
#define THRUM_IO_VTU_GRID_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef enum vtu_type { VTU_FLOAT64, VTU_INT64, VTU_INT32, VTU_UINT8 } vtu_type;

/* An array on all points or on all cells. */
typedef struct vtu_array {
  const char *name;
  vtu_type type;
  int columns; /* 3: a vector, 1: a scalar */
  bool on_cells;
  const void *values; /* NULL: the grid makes them when they are written */
} vtu_array;

/* VTK's type of cells of each form of solid (solid_form of thrum/model.h), in the same order of
 * nodes. Solid-shells are cells of the solids that they are. */
extern const uint8_t vtu_cell_types[9];

/* A grid of tetrahedra, or of solids where there are some. */
typedef struct vtu_grid {
  int64_t point_count, tet_count;
  const double *points;    /* point_count x 3 [m] */
  const int32_t *tets;     /* tet_count x 4, 0-based */
  const int32_t *midsides; /* tet_count x 6 of ten-node tetrahedra, in VTK's order; NULL: linear */
  int64_t solid_count;     /* 0: the tetrahedra are the cells */
  const uint8_t *solid_form;
  const int32_t *solid_ends, *solid_nodes; /* as those of a model */
  const vtu_array *arrays;
  int64_t array_count;
  const char *vectors; /* name of the point vectors to show first; NULL: none */
  const double *time;  /* [s]; NULL: none */
  bool ascii;          /* numbers as text */
  /* Returns the values of array `index`, which stay until the next call. It may be NULL if all
   * arrays have their values. */
  const void *(*make_values)(void *context, int64_t index);
  void *context;
} vtu_grid;

/* Writes the whole file; a failure leaves its mark on the stream. */
void vtu_grid_write(FILE *file, const vtu_grid *grid);

#endif
