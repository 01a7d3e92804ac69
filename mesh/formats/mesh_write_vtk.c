/* Writes VTK's legacy files (version 3, ASCII or big-endian binary). Cell data: `region`, and
 * with materials `young`, `poisson`, `density`; point data: 0 and 1 for each group. Cost: linear in
 * the mesh, for every group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "io/vtu_grid.h"
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

typedef enum column_kind {
  COLUMN_POINTS,
  COLUMN_GROUP,
  COLUMN_REGION,
  COLUMN_YOUNG,
  COLUMN_POISSON,
  COLUMN_DENSITY
} column_kind;

/* The name, the size and the type of the values of each: marks and regions are whole numbers of the
 * smallest type that holds them. */
static const struct {
  const char *name;
  int size;
  bool whole;
} KINDS[] = {[COLUMN_POINTS] = {"POINTS", 8, false},   [COLUMN_GROUP] = {"", 1, true},
             [COLUMN_REGION] = {"region", 4, true},    [COLUMN_YOUNG] = {"young", 8, false},
             [COLUMN_POISSON] = {"poisson", 8, false}, [COLUMN_DENSITY] = {"density", 8, false}};

/* One array of the file. */
typedef struct column {
  column_kind kind;
  int64_t count;       /* of values */
  const uint8_t *mark; /* of a group: vertex_count */
} column;

static int64_t whole_value(const thrum_mesh *m, const column *c, int64_t i) {
  return c->kind == COLUMN_REGION ? thrum_mesh_element_region(m, i) : c->mark[i];
}

static double real_value(const thrum_mesh *m, const column *c, int64_t i) {
  if (c->kind == COLUMN_POINTS)
    return m->vertices[i];
  const thrum_material *material = &m->materials[thrum_mesh_element_region(m, i)];
  return c->kind == COLUMN_YOUNG     ? material->young
         : c->kind == COLUMN_POISSON ? material->poisson
                                     : material->density;
}

/* Writes the last `size` bytes of a number, big-endian. */
static void put_bits(thrum_mesh_out *out, uint64_t bits, int size) {
  unsigned char bytes[8];
  for (int i = 0; i < size; i++)
    bytes[i] = (unsigned char)(bits >> 8 * (size - 1 - i) & 0xff);
  thrum_out_bytes(out, bytes, (size_t)size);
}

/* Writes all numbers of an array, as text or as bytes. */
static void put_column(thrum_mesh_out *out, const thrum_mesh *m, const column *c, bool binary) {
  const int64_t per_line = c->kind == COLUMN_POINTS ? 3 : 10;
  const bool whole = KINDS[c->kind].whole;

  for (int64_t i = 0; i < c->count; i++) {
    const char *after = i + 1 == c->count || i % per_line == per_line - 1 ? "\n" : " ";

    // whole and floating numbers go through their bits, so that the order of the bytes is fixed
    if (binary) {
      uint64_t bits;
      const double value = whole ? 0 : real_value(m, c, i);
      memcpy(&bits, &value, sizeof bits);
      put_bits(out, whole ? (uint64_t)whole_value(m, c, i) : bits, KINDS[c->kind].size);
    } else if (whole) {
      thrum_out_text(out, "%lld%s", (long long)whole_value(m, c, i), after);
    } else {
      thrum_out_number(out, real_value(m, c, i));
      thrum_out_text(out, "%s", after);
    }
  }

  // the keyword behind the bytes needs a line of its own
  if (binary)
    thrum_out_text(out, "\n");
}

/* Writes a name as a word; in legacy files bytes that a word cannot have become %XX. */
static void put_word(thrum_mesh_out *out, const char *name) {
  for (; *name; name++) {
    const unsigned char c = (unsigned char)*name;
    if (c > ' ' && c < 0x7f && c != '%' && c != '"')
      thrum_out_bytes(out, name, 1);
    else
      thrum_out_text(out, "%%%02X", c);
  }
}

static void put_legacy_cells(thrum_mesh_out *out, const thrum_mesh *m, bool binary) {
  const int64_t elements = thrum_mesh_element_count(m);
  int64_t counts[THRUM_FORMS], numbers = elements;
  thrum_mesh_count_forms(m, counts);
  for (int form = 0; form < THRUM_FORMS; form++)
    numbers += counts[form] * thrum_solid_forms[form].nodes;

  // the number of nodes stands before them
  thrum_out_text(out, "CELLS %lld %lld\n", (long long)elements, (long long)numbers);
  for (int64_t e = 0; e < elements; e++) {
    const thrum_mesh_element element = thrum_mesh_element_at(m, e);
    for (int a = -1; a < element.count; a++) {
      const int32_t number = a < 0 ? element.count : element.nodes[a];
      if (binary)
        put_bits(out, (uint64_t)number, 4);
      else
        thrum_out_text(out, "%d%s", (int)number, a + 1 < element.count ? " " : "\n");
    }
  }

  // the format wants a type for each cell
  thrum_out_text(out, "%sCELL_TYPES %lld\n", binary ? "\n" : "", (long long)elements);
  for (int64_t e = 0; e < elements; e++) {
    const int type = vtu_cell_types[thrum_mesh_element_at(m, e).form];
    if (binary)
      put_bits(out, (uint64_t)type, 4);
    else
      thrum_out_text(out, "%d\n", type);
  }
}

void thrum_mesh_write_vtk(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  const bool binary = w->options.binary;
  const column points = {COLUMN_POINTS, 3 * m->vertex_count, NULL};

  thrum_out_text(out,
                 "# vtk DataFile Version 3.0\nmesh written by thrum, in metres\n%s\n"
                 "DATASET UNSTRUCTURED_GRID\nPOINTS %lld double\n",
                 binary ? "BINARY" : "ASCII", (long long)m->vertex_count);
  put_column(out, m, &points, binary);
  put_legacy_cells(out, m, binary);

  // the names of the arrays are those that the reader knows
  thrum_out_text(out, "%sCELL_DATA %lld\nFIELD FieldData %d\n", binary ? "\n" : "",
                 (long long)thrum_mesh_element_count(m), m->has_material ? 4 : 1);
  for (int k = COLUMN_REGION; k <= (m->has_material ? COLUMN_DENSITY : COLUMN_REGION); k++) {
    const column c = {(column_kind)k, thrum_mesh_element_count(m), NULL};
    thrum_out_text(out, "%s 1 %lld %s\n", KINDS[k].name, (long long)c.count,
                   KINDS[k].whole ? "int" : "double");
    put_column(out, m, &c, binary);
  }

  // a group is an array of 0 and 1, which ParaView can threshold
  if (m->group_count > 0)
    thrum_out_text(out, "POINT_DATA %lld\nFIELD FieldData %lld\n", (long long)m->vertex_count,
                   (long long)m->group_count);
  uint8_t *mark = NULL;
  for (int64_t g = 0; g < m->group_count; g++) {
    if (!mark && !thrum_out_reserve(out, &mark, m->vertex_count, 1))
      return;
    const column c = {COLUMN_GROUP, m->vertex_count, mark};
    thrum_write_mark_group(m, g, mark);
    put_word(out, m->groups[g].name);
    thrum_out_text(out, " 1 %lld unsigned_char\n", (long long)c.count);
    put_column(out, m, &c, binary);
  }

  free(mark);
}
