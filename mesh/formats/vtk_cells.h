/* Holds the arrays of VTK's unstructured grid, which are the same in legacy and XML files, and
 * makes a mesh of them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_VTK_CELLS_H
#define THRUM_MESH_FORMATS_VTK_CELLS_H

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"

typedef enum thrum_cells_place {
  THRUM_CELLS_POINTS, /* the grid itself */
  THRUM_CELLS_CONNECTIVITY,
  THRUM_CELLS_OFFSETS, /* where each cell ends in the connectivity */
  THRUM_CELLS_TYPES,
  THRUM_CELLS_POINT_DATA,
  THRUM_CELLS_CELL_DATA,
  THRUM_CELLS_OTHER /* to be passed over */
} thrum_cells_place;

/* An array of the grid; whole numbers are exact up to 2^53, which no index reaches. */
typedef struct thrum_cells_array {
  thrum_cells_place place;
  char name[256];
  bool whole; /* of an integer type */
  int64_t columns;
  int64_t count;  /* of values */
  double *values; /* owned */
} thrum_cells_array;

/* The arrays of a grid. It begins zeroed, and thrum_cells_free releases it. */
typedef struct thrum_cells {
  int64_t point_count, cell_count;
  int64_t array_count;
  thrum_cells_array *arrays;
} thrum_cells;

/* Adds an array and takes its values over, also on failure. */
thrum_status thrum_cells_take(thrum_cells *cells, const thrum_cells_array *array,
                              thrum_error *error);

/* Makes a mesh of the solids of the grid. The cell array source->regions, or else `region` (or as
 * other programs call it), tells regions, cell arrays `young`, `poisson` and `density` their
 * materials; a whole point array of 0 and 1 is a group. On failure *mesh is untouched. */
thrum_status thrum_cells_mesh(const thrum_cells *cells, const thrum_mesh_source *source,
                              thrum_mesh *mesh, thrum_error *error);

enum { THRUM_CELLS_BITS = -1 /* in the place of a size: eight numbers a byte, in legacy files */ };

/* A type of numbers in VTK files: its size in bytes (0: no such type), and whether it is whole or
 * signed. thrum_cells_type_of knows the names of both kinds of file, such as "double" and
 * "Float64". */
typedef struct thrum_cells_type {
  int size;
  bool whole, is_signed;
} thrum_cells_type;
thrum_cells_type thrum_cells_type_of(thrum_word name);
/* Reads one number of that type. */
double thrum_cells_number(thrum_cells_type type, const unsigned char *bytes, bool little);

void thrum_cells_free(thrum_cells *cells);

#endif
