/* Makes a mesh from the arrays of VTK's unstructured grid. Cost: linear in the arrays.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/vtk_cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "io/text.h"
#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

/* The solid cells, by VTK's numbers; nodes at the centres of faces and cells come last and are left
 * out. */
typedef struct vtk_solid {
  int type, points;
  thrum_solid solid;
  bool quadratic;
} vtk_solid;

enum { POINTS_MAX = 27, VOXEL = 11 /* a box whose points go along x, then y, then z */ };

static const vtk_solid SOLIDS[] = {
    {10, 4, THRUM_SOLID_TET, false},        {VOXEL, 8, THRUM_SOLID_HEXAHEDRON, false},
    {12, 8, THRUM_SOLID_HEXAHEDRON, false}, {13, 6, THRUM_SOLID_WEDGE, false},
    {14, 5, THRUM_SOLID_PYRAMID, false},    {24, 10, THRUM_SOLID_TET, true},
    {25, 20, THRUM_SOLID_HEXAHEDRON, true}, {26, 15, THRUM_SOLID_WEDGE, true},
    {27, 13, THRUM_SOLID_PYRAMID, true},    {29, 27, THRUM_SOLID_HEXAHEDRON, true},
    {32, 18, THRUM_SOLID_WEDGE, true}};

thrum_status thrum_cells_take(thrum_cells *cells, const thrum_cells_array *array,
                              thrum_error *error) {
  const thrum_status status =
      thrum_mesh_append(&cells->arrays, &cells->array_count, array, sizeof *array, error);
  if (status < 0)
    free(array->values);
  return status;
}

void thrum_cells_free(thrum_cells *cells) {
  for (int64_t i = 0; i < cells->array_count; i++)
    free(cells->arrays[i].values);
  free(cells->arrays);
  *cells = (thrum_cells){0};
}

thrum_cells_type thrum_cells_type_of(thrum_word name) {
  static const struct {
    const char *name;
    thrum_cells_type type;
  } types[] = {{"double", {8, false, true}},      {"float", {4, false, true}},
               {"char", {1, true, true}},         {"unsigned_char", {1, true, false}},
               {"short", {2, true, true}},        {"unsigned_short", {2, true, false}},
               {"int", {4, true, true}},          {"unsigned_int", {4, true, false}},
               {"long", {8, true, true}},         {"unsigned_long", {8, true, false}},
               {"vtktypeint64", {8, true, true}}, {"vtktypeuint64", {8, true, false}},
               {"vtktypeint32", {4, true, true}}, {"vtktypeuint32", {4, true, false}},
               {"vtkIdType", {4, true, true}},    {"Float64", {8, false, true}},
               {"Float32", {4, false, true}},     {"Int8", {1, true, true}},
               {"UInt8", {1, true, false}},       {"Int16", {2, true, true}},
               {"UInt16", {2, true, false}},      {"Int32", {4, true, true}},
               {"UInt32", {4, true, false}},      {"Int64", {8, true, true}},
               {"UInt64", {8, true, false}}};

  // the legacy and the XML format have other names for the same types
  for (size_t i = 0; i < sizeof types / sizeof *types; i++)
    if (thrum_text_equals(name, types[i].name))
      return types[i].type;

  return (thrum_cells_type){0};
}

double thrum_cells_number(thrum_cells_type type, const unsigned char *bytes, bool little) {
  uint64_t bits = 0;
  for (int i = 0; i < type.size; i++)
    bits = bits << 8 | bytes[little ? type.size - 1 - i : i];

  // floating numbers have the same bits in memory as in the file
  if (!type.whole && type.size == 8) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
  }

  if (!type.whole) {
    const uint32_t half = (uint32_t)bits;
    float value;
    memcpy(&value, &half, sizeof value);
    return (double)value;
  }

  // the top bit of a signed number counts negative
  const uint64_t top = UINT64_C(1) << (8 * type.size - 1);
  return type.is_signed && (bits & top) ? -(double)(top - (bits & (top - 1))) : (double)bits;
}

static const thrum_cells_array *find(const thrum_cells *cells, thrum_cells_place place,
                                     const char *name) {
  for (int64_t i = 0; i < cells->array_count; i++) {
    const thrum_cells_array *a = &cells->arrays[i];
    if (a->place == place && (!name || thrum_text_equals(thrum_word_of(a->name), name)))
      return a;
  }
  return NULL;
}

/* Finds a cell array of one number for each cell by its name; returns NULL when there is none. */
static const thrum_cells_array *find_cell_data(const thrum_cells *cells, const char *name) {
  const thrum_cells_array *a = find(cells, THRUM_CELLS_CELL_DATA, name);
  return a && a->count == cells->cell_count ? a : NULL;
}

static const char GHOSTS[] = "vtkGhostType"; /* cell data of what VTK hides or has twice */

/* The names that programs give to cell data that tells regions. */
static const char *const REGION_NAMES[] = {
    "region",        "regions",   "MaterialIds", "material",  "CellEntityIds",
    "gmsh:physical", "medit:ref", "RegionId",    "attribute", "mat_id",
    "material_id",   "MatID",     "cell_tags",   "PartId"};
enum { REGION_NAMES_COUNT = sizeof REGION_NAMES / sizeof *REGION_NAMES };

static const thrum_cells_array *find_region(const thrum_cells *cells) {
  for (int i = 0; i < REGION_NAMES_COUNT; i++) {
    const thrum_cells_array *a = find_cell_data(cells, REGION_NAMES[i]);
    if (a && a->whole)
      return a;
  }
  return NULL;
}

/* The parts of the grid that tets are made from. */
typedef struct grid {
  const char *name;
  const thrum_cells_array *points, *connectivity, *offsets, *types;
  const thrum_cells_array *region, *young, *poisson, *density;
  thrum_error *error;
} grid;

static thrum_status find_grid(const thrum_cells *cells, grid *g) {
  g->points = find(cells, THRUM_CELLS_POINTS, NULL);
  g->connectivity = find(cells, THRUM_CELLS_CONNECTIVITY, NULL);
  g->offsets = find(cells, THRUM_CELLS_OFFSETS, NULL);
  g->types = find(cells, THRUM_CELLS_TYPES, NULL);
  g->region = find_region(cells);
  g->young = find_cell_data(cells, "young");
  g->poisson = find_cell_data(cells, "poisson");
  g->density = find_cell_data(cells, "density");

  // without these four arrays there are no tets; the others are optional
  if (!g->points || !g->connectivity || !g->offsets || !g->types)
    return thrum_error_set(g->error, THRUM_MISSING,
                           "%.200s: the grid has no %s; is it an unstructured grid, and whole?",
                           g->name,
                           !g->points         ? "points"
                           : !g->connectivity ? "cells"
                           : !g->offsets      ? "ends of cells"
                                              : "types of cells");

  // indices into the arrays are safe only if their lengths agree
  if (g->points->count != 3 * cells->point_count || g->types->count != cells->cell_count ||
      g->offsets->count != cells->cell_count)
    return thrum_error_set(g->error, THRUM_BAD_SHAPE,
                           "%.200s: %lld coordinates, %lld types and %lld ends of cells do not fit "
                           "%lld points and %lld cells",
                           g->name, (long long)g->points->count, (long long)g->types->count,
                           (long long)g->offsets->count, (long long)cells->point_count,
                           (long long)cells->cell_count);

  // what no cell holds would be lost
  const int64_t cells_end = g->offsets->count - 1;
  if (cells_end >= 0 && g->offsets->values[cells_end] < (double)g->connectivity->count)
    return thrum_error_set(
        g->error, THRUM_BAD_SHAPE,
        "%.200s: the last cell ends at %.17g of the connectivity, which has %lld "
        "numbers",
        g->name, g->offsets->values[cells_end], (long long)g->connectivity->count);

  // a point at infinity would make every later computation useless
  for (int64_t i = 0; i < g->points->count; i++)
    if (!isfinite(g->points->values[i]))
      return thrum_error_set(g->error, THRUM_BAD_VALUE,
                             "%.200s: point %lld is not at a finite place", g->name,
                             (long long)(i / 3));

  return THRUM_OK;
}

/* Finds the solid that a cell's type is; *flat tells cells without volume, of which there is none.
 */
static const vtk_solid *find_solid(double type, bool *flat) {
  static const unsigned char without_volume[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9, 21,
                                                 22, 23, 28, 30, 34, 35, 36, 68, 69, 70};
  *flat = false;
  for (size_t i = 0; i < sizeof SOLIDS / sizeof *SOLIDS; i++)
    if (type == SOLIDS[i].type)
      return &SOLIDS[i];
  for (size_t i = 0; i < sizeof without_volume; i++)
    *flat = *flat || type == without_volume[i];
  return NULL;
}

static thrum_status bad_cell(const grid *g, int64_t cell, const char *fault) {
  return thrum_error_set(g->error, THRUM_BAD_VALUE, "%.200s: cell %lld %s", g->name,
                         (long long)cell, fault);
}

/* Returns the key of a cell's region; cells of one region have one material. */
static int64_t region_key(const grid *g, int64_t cell) {
  return g->region ? (int64_t)g->region->values[cell] : 0;
}

/* Turns a wedge so that its second triangle lies where the first one's normal points. VTK has it on
 * the other side, and programs write both. */
static void turn_wedge(const grid *g, const vtk_solid *solid, int64_t *vertices) {
  static const int swaps[5][2] = {{1, 2}, {4, 5}, {6, 8}, {9, 11}, {13, 14}};
  const double *corner[4];
  double edges[3][3];

  // the first triangle and one corner of the second tell
  for (int c = 0; c < 4; c++) {
    if (3 * vertices[c] + 2 >= g->points->count) // which is refused later
      return;
    corner[c] = g->points->values + 3 * vertices[c];
  }
  for (int c = 1; c < 4; c++)
    for (int axis = 0; axis < 3; axis++)
      edges[c - 1][axis] = corner[c][axis] - corner[0][axis];
  if (thrum_triple3(edges[0], edges[1], edges[2]) >= 0)
    return;

  // two corners of each triangle change places, and middle nodes with them
  for (int s = 0; s < (solid->quadratic ? 5 : 2); s++) {
    const int64_t swap = vertices[swaps[s][0]];
    vertices[swaps[s][0]] = vertices[swaps[s][1]];
    vertices[swaps[s][1]] = swap;
  }
}

static thrum_status add_cell(const grid *g, int64_t cell, double first, thrum_mesh_builder *b) {
  const double end = g->offsets->values[cell];
  bool flat;
  const vtk_solid *solid = find_solid(g->types->values[cell], &flat);

  if (!(end >= first && end <= (double)g->connectivity->count))
    return bad_cell(g, cell, "ends beyond the connectivity, or before it begins");

  // cells without volume, such as a triangulated boundary, may stand beside the solids
  if (flat)
    return THRUM_OK;
  if (!solid)
    return thrum_error_set(g->error, THRUM_UNSUPPORTED,
                           "%.200s: cell %lld is of type %g, which is not supported; the body must "
                           "be meshed with tetrahedra (type 10 or 24), hexahedra, wedges or "
                           "pyramids",
                           g->name, (long long)cell, g->types->values[cell]);
  if (end - first != solid->points)
    return bad_cell(g, cell, "has another number of points than its type");

  int64_t vertices[POINTS_MAX];
  for (int a = 0; a < solid->points; a++) {
    const double v = g->connectivity->values[(int64_t)first + a];

    // converting a number beyond the integers would be undefined
    if (!(v >= 0 && v < 2147483648.0 && v == floor(v)))
      return bad_cell(g, cell, "names a point that is out of range or no whole number");
    vertices[a] = (int64_t)v;
  }

  // a wild number must not be converted
  if (g->region && !(fabs(g->region->values[cell]) < 1e15))
    return bad_cell(g, cell, "has a region that is out of range");

  // points stand in the order that elements have here
  if (solid->solid == THRUM_SOLID_WEDGE)
    turn_wedge(g, solid, vertices);
  for (int c = 2; c < 8 && solid->type == VOXEL; c += 4) {
    const int64_t swap = vertices[c];
    vertices[c] = vertices[c + 1];
    vertices[c + 1] = swap;
  }
  return thrum_builder_element(b, &(thrum_element){.kind = solid->solid,
                                                   .quadratic = solid->quadratic,
                                                   .nodes = vertices,
                                                   .key = region_key(g, cell)});
}

/* Refuses cells that are hidden, or are copies of another piece's. */
static thrum_status check_ghosts(const thrum_cells *cells, const grid *g) {
  enum { COPY = 1, REFINED = 8, HIDDEN = 32 };
  const thrum_cells_array *types = find_cell_data(cells, GHOSTS);
  const thrum_cells_array *levels = find_cell_data(cells, "vtkGhostLevels");

  // other bits of the type say where a cell lies, and any level above 0 is a copy
  for (int64_t c = 0; c < cells->cell_count && (types || levels); c++) {
    const double type = types ? types->values[c] : 0;
    const int bits = type >= 0 && type < 256 ? (int)type : 0;
    if ((bits & (COPY | REFINED | HIDDEN)) || (levels && levels->values[c] > 0))
      return thrum_error_set(g->error, THRUM_UNSUPPORTED,
                             "%.200s: cell %lld is a ghost or hidden ('%s'), which is not read; "
                             "save the grid without ghost cells",
                             g->name, (long long)c, types ? types->name : levels->name);
  }
  return THRUM_OK;
}

static thrum_status comes_twice(const grid *g, const thrum_cells_array *a) {
  static const char *const grid_words[] = {"points", "connectivity", "offsets", "types"};
  const char *name = a->place <= THRUM_CELLS_TYPES ? grid_words[a->place] : a->name;
  return thrum_error_set(g->error, THRUM_UNSUPPORTED,
                         "%.200s: the array '%s' comes twice, as of several time steps; save one "
                         "of them",
                         g->name, thrum_text_excerpt(thrum_word_of(name)).text);
}

/* Refuses arrays of the grid, of regions and of materials that are there twice. */
static thrum_status check_once(const thrum_cells *cells, const grid *g) {
  const thrum_cells_array *const used[] = {g->points, g->connectivity, g->offsets, g->types,
                                           g->region, g->young,        g->poisson, g->density};
  for (size_t u = 0; u < sizeof used / sizeof *used; u++)
    for (int64_t i = 0; i < cells->array_count && used[u]; i++) {
      const thrum_cells_array *a = &cells->arrays[i];
      if (a != used[u] && a->place == used[u]->place &&
          (a->place <= THRUM_CELLS_TYPES || strcmp(a->name, used[u]->name) == 0))
        return comes_twice(g, a);
    }
  return THRUM_OK;
}

/* Makes a group of whole point data of one column whose values are 0 and 1; without any 1 there is
 * no group. */
static thrum_status add_group(const thrum_cells *cells, const grid *g, const thrum_cells_array *a,
                              thrum_mesh_builder *b) {
  if (a->place != THRUM_CELLS_POINT_DATA || !a->whole || a->columns > 1 ||
      a->count != cells->point_count || thrum_mesh_name_fault(a->name, strlen(a->name)))
    return THRUM_OK;

  // any other value makes it data of another kind
  for (int64_t i = 0; i < a->count; i++)
    if (a->values[i] != 0 && a->values[i] != 1)
      return THRUM_OK;

  // arrays of one name would become one list
  int64_t list = 0;
  const int64_t before = b->list_count;
  THRUM_TRY(thrum_builder_list(b, a->name, strlen(a->name), &list));
  if (b->list_count == before)
    return comes_twice(g, a);
  for (int64_t i = 0; i < a->count; i++)
    if (a->values[i] == 1)
      THRUM_TRY(thrum_builder_add(b, list, i));
  return THRUM_OK;
}

/* Sets the material of each region, which must be the same for all its cells. */
static thrum_status add_materials(const grid *g, const thrum_mesh_builder *b, int64_t cell_count,
                                  thrum_mesh *mesh) {
  if (!g->young || !g->poisson || !g->density)
    return THRUM_OK;

  mesh->has_material = true;
  for (int64_t cell = 0; cell < cell_count; cell++) {
    bool flat;
    if (!find_solid(g->types->values[cell], &flat))
      continue;

    // regions are in the order of their keys
    const thrum_material own = {g->young->values[cell], g->poisson->values[cell],
                                g->density->values[cell]};
    thrum_material *material = &mesh->materials[thrum_builder_region(b, mesh, region_key(g, cell))];
    if (!isfinite(own.young) || !isfinite(own.poisson) || !isfinite(own.density))
      return bad_cell(g, cell, "has a material that is not finite");

    // the first cell of a region sets its material
    if (material->young == 0 && material->poisson == 0 && material->density == 0)
      *material = own;
    if (material->young != own.young || material->poisson != own.poisson ||
        material->density != own.density)
      return bad_cell(g, cell,
                      "has another material than others of its region; give each material "
                      "its own number in the cell array 'region'");
  }
  return THRUM_OK;
}

/* Finds the cell data that the user names as the regions. */
static thrum_status find_named_region(const thrum_cells *cells, const char *name, grid *g) {
  g->region = find_cell_data(cells, name);
  if (!g->region)
    return thrum_error_set(g->error, THRUM_MISSING,
                           "%.200s: there is no cell data '%s' of one number a cell", g->name,
                           thrum_text_excerpt(thrum_word_of(name)).text);
  for (int64_t c = 0; c < g->region->count; c++)
    if (g->region->values[c] != floor(g->region->values[c]))
      return thrum_error_set(g->error, THRUM_BAD_VALUE,
                             "%.200s: cell data '%s' is %g in cell %lld, so it does not number "
                             "regions",
                             g->name, thrum_text_excerpt(thrum_word_of(name)).text,
                             g->region->values[c], (long long)c);
  return THRUM_OK;
}

static bool names_region(const thrum_cells_array *a) {
  int i = 0;
  while (i < REGION_NAMES_COUNT && !thrum_text_equals(thrum_word_of(a->name), REGION_NAMES[i]))
    i++;
  return i < REGION_NAMES_COUNT;
}

/* Tells which cell data was taken for the regions by its name, or which could be: whole numbers of
 * more than one value. */
static void note_regions(const thrum_cells *cells, const grid *g, bool named, thrum_mesh *mesh) {
  if (g->region) {
    if (mesh->region_count > 1 && !named && strcmp(g->region->name, "region") != 0)
      thrum_mesh_add_note(mesh, "the %lld regions are those of the cell data '%s'",
                          (long long)mesh->region_count,
                          thrum_text_excerpt(thrum_word_of(g->region->name)).text);
    return;
  }

  // numbers of one value would make one region
  for (int64_t i = 0; i < cells->array_count; i++) {
    const thrum_cells_array *a = &cells->arrays[i];
    if (a->place != THRUM_CELLS_CELL_DATA || !(a->whole || names_region(a)) ||
        strcmp(a->name, GHOSTS) == 0)
      continue;
    int64_t c = 1;
    while (c < a->count && a->values[c] == a->values[0])
      c++;
    if (a->count == cells->cell_count && c < a->count)
      thrum_mesh_add_note(mesh,
                          "the cell data '%s' is not used; if it tells regions, give "
                          "--regions %s",
                          thrum_text_excerpt(thrum_word_of(a->name)).text,
                          thrum_text_excerpt(thrum_word_of(a->name)).text);
    else if (a->count != cells->cell_count && names_region(a))
      thrum_mesh_add_note(mesh, "the cell data '%s' is not used: it has not one number a cell",
                          thrum_text_excerpt(thrum_word_of(a->name)).text);
  }
}

/* Names the parts of a material that are there without the others. */
static void note_materials(const thrum_cells *cells, thrum_mesh *mesh) {
  static const char *const names[] = {"young", "poisson", "density"};
  for (size_t i = 0; i < sizeof names / sizeof *names && !mesh->has_material; i++)
    if (find(cells, THRUM_CELLS_CELL_DATA, names[i]))
      thrum_mesh_add_note(mesh,
                          "the cell data '%s' is not used: a material is young, poisson and "
                          "density, each of one number a cell",
                          names[i]);
}

static thrum_status build(const thrum_cells *cells, const char *regions, grid *g,
                          thrum_mesh_builder *b, thrum_mesh *mesh) {
  THRUM_TRY(find_grid(cells, g));
  if (regions)
    THRUM_TRY(find_named_region(cells, regions, g));
  THRUM_TRY(check_ghosts(cells, g));
  THRUM_TRY(check_once(cells, g));
  for (int64_t v = 0; v < cells->point_count; v++)
    THRUM_TRY(thrum_builder_vertex(b, v, g->points->values + 3 * v, 0));
  for (int64_t c = 0; c < cells->cell_count; c++)
    THRUM_TRY(add_cell(g, c, c > 0 ? g->offsets->values[c - 1] : 0, b));
  for (int64_t i = 0; i < cells->array_count; i++)
    THRUM_TRY(add_group(cells, g, &cells->arrays[i], b));

  // regions are known only when all cells were added
  THRUM_TRY(thrum_builder_finish(b, g->name, mesh));
  THRUM_TRY(add_materials(g, b, cells->cell_count, mesh));
  if (g->region)
    THRUM_TRY(thrum_builder_name_regions(b, mesh));
  note_regions(cells, g, regions != NULL, mesh);
  note_materials(cells, mesh);

  // regions are groups where the file has none of its own
  return mesh->group_count > 0 ? THRUM_OK : thrum_builder_region_groups(b, "region", true, mesh);
}

thrum_status thrum_cells_mesh(const thrum_cells *cells, const thrum_mesh_source *source,
                              thrum_mesh *mesh, thrum_error *error) {
  thrum_mesh_builder builder = {
      .error = error, .corners = source->corners, .keep_solids = source->solids};
  thrum_mesh read = {0};
  grid g = {.name = source->name, .error = error};

  const thrum_status status = build(cells, source->regions, &g, &builder, &read);
  thrum_builder_free(&builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
