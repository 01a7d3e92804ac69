/* Writes VTK's legacy files (version 3, ASCII or big-endian binary). Cell data: `region`, and
 * with materials `young`, `poisson`, `density`; point data: 0 and 1 for each group. Cost: linear in
 * the mesh, for every group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"

enum { VTK_TETRA = 10, VTK_QUADRATIC_TETRA = 24 };

typedef enum column_kind {
  COLUMN_POINTS,
  COLUMN_GROUP,
  COLUMN_REGION,
  COLUMN_YOUNG,
  COLUMN_POISSON,
  COLUMN_DENSITY
} column_kind;

/* One array of the file: the number and size of its values, which are whole or floating. */
typedef struct column {
  column_kind kind;
  int64_t group;
  int64_t count;
  int size;
  bool whole;
  const uint8_t *mark; /* of a group: vertex_count */
} column;

static column make_column(const thrum_mesh *m, column_kind kind, int64_t group) {
  column c = {.kind = kind, .group = group, .count = m->tet_count, .size = 8};

  // all other arrays have a value for each tet
  if (kind == COLUMN_POINTS)
    c.count = 3 * m->vertex_count;
  if (kind == COLUMN_GROUP)
    c.count = m->vertex_count;

  // marks and regions are whole numbers of the smallest type that holds them
  c.whole = kind != COLUMN_POINTS && kind != COLUMN_YOUNG && kind != COLUMN_POISSON &&
            kind != COLUMN_DENSITY;
  if (kind == COLUMN_GROUP)
    c.size = 1;
  if (kind == COLUMN_REGION)
    c.size = 4;
  return c;
}

static int64_t whole_value(const thrum_mesh *m, const column *c, int64_t i) {
  return c->kind == COLUMN_REGION ? m->tet_region[i] : c->mark[i];
}

static double real_value(const thrum_mesh *m, const column *c, int64_t i) {
  if (c->kind == COLUMN_POINTS)
    return m->vertices[i];
  const thrum_material *material = &m->materials[m->tet_region[i]];
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

  for (int64_t i = 0; i < c->count; i++) {
    const char *after = i + 1 == c->count || i % per_line == per_line - 1 ? "\n" : " ";

    // whole and floating numbers go through their bits, so that the order of the bytes is fixed
    if (binary) {
      uint64_t bits;
      const double value = c->whole ? 0 : real_value(m, c, i);
      memcpy(&bits, &value, sizeof bits);
      put_bits(out, c->whole ? (uint64_t)whole_value(m, c, i) : bits, c->size);
    } else if (c->whole) {
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

static bool mark_group(thrum_mesh_out *out, const thrum_mesh *m, int64_t g, uint8_t **mark) {
  if (!*mark)
    *mark = malloc((size_t)m->vertex_count + 1);
  if (!*mark) {
    out->status = thrum_error_set(out->error, THRUM_OUT_OF_MEMORY, "not enough memory");
    return false;
  }

  // one array serves all groups in turn
  memset(*mark, 0, (size_t)m->vertex_count);
  for (int64_t i = 0; i < m->groups[g].count; i++)
    (*mark)[m->groups[g].vertices[i]] = 1;
  return true;
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

static const char *column_name(column_kind kind) {
  return kind == COLUMN_REGION    ? "region"
         : kind == COLUMN_YOUNG   ? "young"
         : kind == COLUMN_POISSON ? "poisson"
                                  : "density";
}

static void put_legacy_cells(thrum_mesh_out *out, const thrum_mesh *m, bool binary) {
  const int size = m->midsides ? 11 : 5, type = m->midsides ? VTK_QUADRATIC_TETRA : VTK_TETRA;

  // the number of nodes stands before them
  thrum_out_text(out, "CELLS %lld %lld\n", (long long)m->tet_count, size * (long long)m->tet_count);
  for (int64_t t = 0; t < m->tet_count; t++) {
    int32_t v[10];
    const int nodes = thrum_mesh_nodes(m, t, v);
    for (int a = -1; a < nodes; a++) {
      const int32_t number = a < 0 ? nodes : v[a];
      if (binary)
        put_bits(out, (uint64_t)number, 4);
      else
        thrum_out_text(out, "%d%s", (int)number, a + 1 < nodes ? " " : "\n");
    }
  }

  // the format wants a type for each cell, though all are tets
  thrum_out_text(out, "%sCELL_TYPES %lld\n", binary ? "\n" : "", (long long)m->tet_count);
  for (int64_t t = 0; t < m->tet_count; t++)
    if (binary)
      put_bits(out, (uint64_t)type, 4);
    else
      thrum_out_text(out, "%d\n", type);
}

void thrum_mesh_write_vtk(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  const bool binary = w->options.binary;
  const column points = make_column(m, COLUMN_POINTS, 0);

  thrum_out_text(out,
                 "# vtk DataFile Version 3.0\nmesh written by thrum, in metres\n%s\n"
                 "DATASET UNSTRUCTURED_GRID\nPOINTS %lld double\n",
                 binary ? "BINARY" : "ASCII", (long long)m->vertex_count);
  put_column(out, m, &points, binary);
  put_legacy_cells(out, m, binary);

  // the names of the arrays are those that the reader knows
  thrum_out_text(out, "%sCELL_DATA %lld\nFIELD FieldData %d\n", binary ? "\n" : "",
                 (long long)m->tet_count, m->has_material ? 4 : 1);
  for (int k = COLUMN_REGION; k <= (m->has_material ? COLUMN_DENSITY : COLUMN_REGION); k++) {
    const column c = make_column(m, (column_kind)k, 0);
    thrum_out_text(out, "%s 1 %lld %s\n", column_name(c.kind), (long long)c.count,
                   c.whole ? "int" : "double");
    put_column(out, m, &c, binary);
  }

  // a group is an array of 0 and 1, which ParaView can threshold
  if (m->group_count > 0)
    thrum_out_text(out, "POINT_DATA %lld\nFIELD FieldData %lld\n", (long long)m->vertex_count,
                   (long long)m->group_count);
  uint8_t *mark = NULL;
  for (int64_t g = 0; g < m->group_count && mark_group(out, m, g, &mark); g++) {
    column c = make_column(m, COLUMN_GROUP, g);
    c.mark = mark;
    put_word(out, m->groups[g].name);
    thrum_out_text(out, " 1 %lld unsigned_char\n", (long long)c.count);
    put_column(out, m, &c, binary);
  }

  free(mark);
}
