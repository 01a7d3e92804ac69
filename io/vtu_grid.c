/* Writes .vtu files (VTK XML unstructured grid).
 *
 * A .vtu is XML whose arrays stand in their elements, as text or in base64 after their length in
 * bytes as one UInt64.
 * The format also allows all bytes behind the elements (AppendedData), raw and so a quarter
 * shorter, but VTK 9.2 and ParaView 5.11 cannot read such files where their expat has the mend of
 * CVE-2023-52425, as Debian 12's has (https://gitlab.kitware.com/vtk/vtk/-/issues/19258).
 * Format: "VTK XML formats", https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/vtu_grid.h"

#include <inttypes.h>
#include <string.h>

#include "io/base64.h"
#include "io/number_text.h"

const uint8_t vtu_cell_types[9] = {10, 24, 13, 26, 12, 25, 13, 12, 24};

#define CHUNK 4096 /* generated values are written in pieces of this many */

/* The arrays of the grid itself stand first in the file, in this order. */
enum { POINTS, CONNECTIVITY, OFFSETS, TYPES, GRID_ARRAYS };

static const char *const type_names[] = {"Float64", "Int64", "Int32", "UInt8"};
static const int type_bytes[] = {8, 8, 4, 1};

/* One array as it stands in the file. */
typedef struct placed_array {
  const char *name;
  vtu_type type;
  int columns;
  int per_line;  /* numbers in a line of text */
  int64_t count; /* of numbers */
} placed_array;

static int64_t cell_count(const vtu_grid *grid) {
  return grid->solid_count > 0 ? grid->solid_count : grid->tet_count;
}

static placed_array array_at(const vtu_grid *grid, int64_t n) {
  const int64_t points = grid->point_count, cells = cell_count(grid);
  const int nodes = grid->midsides ? 10 : 4;

  // the grid's own arrays have fixed names; the caller's follow behind them
  switch (n) {
  case POINTS:
    return (placed_array){"Points", VTU_FLOAT64, 3, 3, 3 * points};
  case CONNECTIVITY:
    // VTK wants one plain list
    return (placed_array){"connectivity", VTU_INT32, 1, nodes,
                          grid->solid_count > 0 ? grid->solid_ends[cells - 1] : nodes * cells};
  case OFFSETS:
    return (placed_array){"offsets", VTU_INT64, 1, 10, cells};
  case TYPES:
    return (placed_array){"types", VTU_UINT8, 1, 10, cells};
  default: {
    const vtu_array *a = &grid->arrays[n - GRID_ARRAYS];
    return (placed_array){a->name, a->type, a->columns, a->columns > 1 ? a->columns : 10,
                          a->columns * (a->on_cells ? cells : points)};
  }
  }
}

static uint64_t bytes_of(const placed_array *array) {
  return (uint64_t)array->count * (uint64_t)type_bytes[array->type];
}

/* Corners and middle nodes of ten-node tetrahedra in one list, from number `first` on. */
static const void *join_nodes(const vtu_grid *grid, int64_t first, int64_t chunk[CHUNK]) {
  int32_t *nodes = (int32_t *)(void *)chunk;
  for (int64_t k = 0; k < CHUNK && first + k < 10 * grid->tet_count; k++) {
    const int64_t t = (first + k) / 10, a = (first + k) % 10;
    nodes[k] = a < 4 ? grid->tets[4 * t + a] : grid->midsides[6 * t + a - 4];
  }
  return nodes;
}

/* Returns the values of array n from `first` on, at least CHUNK of them or up to the end; offsets
 * and types of tetrahedra are generated into `chunk`, and so are the nodes of quadratic ones. */
static const void *values_of(const vtu_grid *grid, int64_t n, int64_t first, int64_t chunk[CHUNK]) {
  const placed_array array = array_at(grid, n);
  const size_t skipped = (size_t)first * (size_t)type_bytes[array.type];

  // points and linear tets are in memory as VTK wants them; the ends and types of cells are not
  switch (n) {
  case POINTS:
    return (const char *)grid->points + skipped;
  case CONNECTIVITY:
    if (grid->solid_count > 0)
      return (const char *)grid->solid_nodes + skipped;
    return grid->midsides ? join_nodes(grid, first, chunk) : (const char *)grid->tets + skipped;
  case OFFSETS:
    for (int64_t k = 0; k < CHUNK && first + k < array.count; k++)
      chunk[k] = grid->solid_count > 0 ? grid->solid_ends[first + k]
                                       : (grid->midsides ? 10 : 4) * (first + k + 1);
    return chunk;
  case TYPES:
    for (int64_t k = 0; k < CHUNK && first + k < array.count; k++)
      ((uint8_t *)chunk)[k] = vtu_cell_types[grid->solid_count > 0 ? grid->solid_form[first + k]
                                                                   : grid->midsides != NULL];
    return chunk;
  default: {
    // arrays without values are made when they are written, so that only one is in memory
    const void *values = grid->arrays[n - GRID_ARRAYS].values;
    if (values == NULL)
      values = grid->make_values(grid->context, n - GRID_ARRAYS);
    return (const char *)values + skipped;
  }
  }
}

/* --- numbers ---------------------------------------------------------------------------------- */

static void put_number(FILE *file, vtu_type type, const void *values, int64_t n) {
  char text[THRUM_NUMBER_TEXT];

  // real numbers are written so that they read back exactly
  switch (type) {
  case VTU_FLOAT64:
    thrum_number_text(((const double *)values)[n], text);
    fputs(text, file);
    break;
  case VTU_INT64:
    fprintf(file, "%" PRId64, ((const int64_t *)values)[n]);
    break;
  case VTU_INT32:
    fprintf(file, "%" PRId32, ((const int32_t *)values)[n]);
    break;
  case VTU_UINT8:
    fprintf(file, "%d", ((const unsigned char *)values)[n]);
    break;
  }
}

/* Writes all numbers of an array, as text or as the base64 of their length and their bytes. */
static void put_values(FILE *file, const vtu_grid *grid, int64_t n, bool as_text) {
  const placed_array array = array_at(grid, n);
  const uint64_t length = bytes_of(&array);
  const bool generated =
      n == OFFSETS || n == TYPES || (n == CONNECTIVITY && grid->midsides && grid->solid_count == 0);
  thrum_base64 bytes = {.stream = file};
  int64_t chunk[CHUNK];

  if (!as_text)
    thrum_base64_put(&bytes, &length, sizeof length);

  // generated arrays come in pieces, so that no memory for the whole is needed
  for (int64_t first = 0; first < array.count;) {
    const int64_t left = array.count - first, count = generated && left > CHUNK ? CHUNK : left;
    const void *values = values_of(grid, n, first, chunk);
    if (!as_text)
      thrum_base64_put(&bytes, values, (size_t)count * (size_t)type_bytes[array.type]);

    // text is broken into lines that people can read
    for (int64_t k = 0; k < count && as_text; k++) {
      const int64_t number = first + k + 1;
      put_number(file, array.type, values, k);
      fputc(number == array.count || number % array.per_line == 0 ? '\n' : ' ', file);
    }
    first += count;
  }
  if (!as_text) {
    thrum_base64_end(&bytes);
    fputc('\n', file);
  }
}

/* --- XML -------------------------------------------------------------------------------------- */

/* Writes a name so that it can stand inside quotes of XML. */
static void put_escaped(FILE *file, const char *name) {
  // names of groups come from files and may hold any character
  for (; *name != '\0'; name++) {
    switch (*name) {
    case '&':
      fputs("&amp;", file);
      break;

    case '<':
      fputs("&lt;", file);
      break;

    case '>':
      fputs("&gt;", file);
      break;

    case '"':
      fputs("&quot;", file);
      break;

    default:
      fputc(*name, file);
    }
  }
}

static void put_array(FILE *file, const vtu_grid *grid, int64_t n) {
  const placed_array array = array_at(grid, n);
  fprintf(file, "        <DataArray type=\"%s\" Name=\"", type_names[array.type]);
  put_escaped(file, array.name);
  fprintf(file, "\" NumberOfComponents=\"%d\" format=\"%s\">\n", array.columns,
          grid->ascii ? "ascii" : "binary");
  put_values(file, grid, n, grid->ascii);
  fputs("        </DataArray>\n", file);
}

/* Writes the arrays on points or on cells that are vectors, or those that are not. */
static void put_data(FILE *file, const vtu_grid *grid, bool on_cells, bool vectors) {
  for (int64_t n = 0; n < grid->array_count; n++)
    if (grid->arrays[n].on_cells == on_cells && (grid->arrays[n].columns == 3) == vectors)
      put_array(file, grid, GRID_ARRAYS + n);
}

static const char *byte_order(void) {
  const uint16_t probe = 1;
  unsigned char first;
  memcpy(&first, &probe, 1);
  return first == 1 ? "LittleEndian" : "BigEndian";
}

void vtu_grid_write(FILE *file, const vtu_grid *grid) {
  // the bytes are those of this machine, so the header tells their order
  fprintf(file,
          "<?xml version=\"1.0\"?>\n"
          "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" "
          "header_type=\"UInt64\">\n"
          "  <UnstructuredGrid>\n",
          byte_order());
  if (grid->time != NULL)
    fprintf(file,
            "    <FieldData>\n"
            "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
            "format=\"ascii\">%.17g</DataArray>\n"
            "    </FieldData>\n",
            *grid->time);

  // the grid
  fprintf(file,
          "    <Piece NumberOfPoints=\"%" PRId64 "\" NumberOfCells=\"%" PRId64 "\">\n"
          "      <Points>\n",
          grid->point_count, cell_count(grid));
  put_array(file, grid, POINTS);
  fputs("      </Points>\n      <Cells>\n", file);
  for (int n = CONNECTIVITY; n <= TYPES; n++)
    put_array(file, grid, n);
  fputs("      </Cells>\n", file);

  // the data on it, vectors first
  if (grid->vectors != NULL)
    fprintf(file, "      <PointData Vectors=\"%s\">\n", grid->vectors);
  else
    fputs("      <PointData>\n", file);
  put_data(file, grid, false, true);
  put_data(file, grid, false, false);
  fputs("      </PointData>\n      <CellData>\n", file);
  put_data(file, grid, true, true);
  put_data(file, grid, true, false);
  fputs("      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n", file);
}
