/* Reads TetGen's pair of files: NAME.node (index, three coordinates, attributes, a boundary marker)
 * and NAME.ele (index, 4 or 10 nodes, attributes), # comments. Nodes count from 0 or 1, as the
 * first index says. Markers other than 0 are the groups marker_N; the first attribute of a tet
 * tells its region, and of several regions each is the group region_N. Format: TetGen manual,
 * https://wias-berlin.de/software/tetgen/fformats.html Cost: linear in the files.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_builder.h"

enum { COLUMNS_MAX = 100 };

typedef struct tetgen_reader {
  thrum_text text;
  thrum_mesh_builder builder;
  int64_t base; /* the first index */
} tetgen_reader;

/* Reads a whole number that the header may leave out. */
static thrum_status optional(tetgen_reader *r, const char *what, int64_t high, int64_t *value) {
  if (!thrum_text_more(&r->text))
    return THRUM_OK;
  return thrum_text_integer(&r->text, what, 0, high, value);
}

static thrum_status read_node(tetgen_reader *r, int64_t i, int64_t attributes, int64_t markers) {
  double position[3] = {0}, unused = 0;
  int64_t marker = 0;
  THRUM_TRY(thrum_text_need_line(&r->text, "the last node"));
  THRUM_TRY(thrum_text_item(&r->text, "the index of a node", i, &r->base));
  THRUM_TRY(thrum_text_position(&r->text, position));

  // attributes are TetGen's own data; the marker makes a group
  for (int64_t a = 0; a < attributes; a++)
    THRUM_TRY(thrum_text_number(&r->text, "an attribute of the node", &unused));
  if (markers > 0 && thrum_text_more(&r->text))
    THRUM_TRY(
        thrum_text_integer(&r->text, "the marker of the node", INT32_MIN, INT32_MAX, &marker));

  THRUM_TRY(thrum_text_finish(&r->text, "the node"));
  const int64_t number = i + r->base;
  THRUM_TRY(thrum_builder_vertex(&r->builder, number, position, r->text.line));
  return marker == 0 ? THRUM_OK : thrum_builder_mark(&r->builder, "marker", marker, &number, 1);
}

static thrum_status read_nodes(tetgen_reader *r) {
  int64_t count = 0, dimension = 3, attributes = 0, markers = 0;
  THRUM_TRY(thrum_text_need_line(&r->text, "the number of nodes"));
  THRUM_TRY(thrum_text_integer(&r->text, "the number of nodes", 1, INT32_MAX, &count));
  THRUM_TRY(optional(r, "the dimension", 3, &dimension));

  // a flat mesh has no volume to simulate
  if (dimension != 3)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, "the dimension is %lld; a body needs 3",
                           (long long)dimension);

  // the header may end after the dimension
  THRUM_TRY(optional(r, "the number of attributes", COLUMNS_MAX, &attributes));
  THRUM_TRY(optional(r, "the number of markers", 1, &markers));

  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_node(r, i, attributes, markers));
  return THRUM_OK;
}

/* Reads the region of a tet, its first attribute, which must be whole. */
static thrum_status read_region(tetgen_reader *r, int64_t *key) {
  double value = 0;
  THRUM_TRY(thrum_text_number(&r->text, "the region of the tet", &value));
  if (value != floor(value) || fabs(value) > 1e9)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "the region of the tet is %g; number regions with whole numbers", value);
  *key = (int64_t)value;
  return THRUM_OK;
}

static thrum_status read_tet(tetgen_reader *r, int64_t i, int64_t nodes, int64_t attributes) {
  // TetGen's places of the middle nodes on edges 01, 12, 20, 03, 13, 23
  static const int middles[6] = {6, 7, 9, 5, 8, 4};
  int64_t vertices[10] = {0}, ordered[10], key = 0;
  double unused = 0;

  THRUM_TRY(thrum_text_need_line(&r->text, "the last tet"));
  THRUM_TRY(thrum_text_item(&r->text, "the index of a tet", i, &(int64_t){r->base}));
  for (int64_t n = 0; n < nodes; n++)
    THRUM_TRY(thrum_text_integer(&r->text, "a node of the tet", r->base,
                                 r->builder.vertex_count - 1 + r->base, &vertices[n]));

  // the first attribute is the region, the others have no meaning here
  for (int64_t a = 0; a < attributes && thrum_text_more(&r->text); a++)
    THRUM_TRY(a == 0 ? read_region(r, &key)
                     : thrum_text_number(&r->text, "an attribute of the tet", &unused));

  THRUM_TRY(thrum_text_finish(&r->text, "the tet"));
  memcpy(ordered, vertices, sizeof ordered);
  for (int e = 0; e < 6 && nodes == 10; e++)
    ordered[4 + e] = vertices[middles[e]];
  return thrum_builder_element(&r->builder, &(thrum_element){.quadratic = nodes == 10,
                                                             .nodes = ordered,
                                                             .key = key,
                                                             .line = r->text.line});
}

static thrum_status read_tets(tetgen_reader *r) {
  int64_t count = 0, nodes = 4, attributes = 0;
  THRUM_TRY(thrum_text_need_line(&r->text, "the number of tets"));
  THRUM_TRY(thrum_text_integer(&r->text, "the number of tets", 1, INT32_MAX, &count));
  THRUM_TRY(optional(r, "the number of nodes of a tet", 10, &nodes));

  if (nodes != 4 && nodes != 10)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "a tet has 4 or 10 nodes, not %lld",
                           (long long)nodes);

  // the header may end after the number of nodes
  THRUM_TRY(optional(r, "the number of attributes", COLUMNS_MAX, &attributes));
  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_tet(r, i, nodes, attributes));
  return THRUM_OK;
}

static thrum_status read_both(tetgen_reader *r, const thrum_mesh_source *elements,
                              thrum_mesh *mesh) {
  THRUM_TRY(read_nodes(r));
  THRUM_TRY(thrum_text_view(elements->name, elements->data, elements->size, '#', 0, &r->text,
                            r->text.error));
  r->text.fortran = true;
  THRUM_TRY(read_tets(r));
  THRUM_TRY(thrum_builder_finish(&r->builder, elements->name, mesh));
  THRUM_TRY(thrum_builder_name_regions(&r->builder, mesh));
  return thrum_builder_region_groups(&r->builder, "region", true, mesh);
}

thrum_status thrum_mesh_parse_tetgen(const thrum_mesh_source *nodes,
                                     const thrum_mesh_source *elements, thrum_mesh *mesh,
                                     thrum_error *error) {
  tetgen_reader r = {.builder = {.error = error, .corners = elements->corners}};
  thrum_mesh read = {0};

  // the nodes come first, since the tets are checked against their number
  THRUM_TRY(thrum_text_view(nodes->name, nodes->data, nodes->size, '#', 0, &r.text, error));
  r.text.fortran = true;
  const thrum_status status = read_both(&r, elements, &read);
  thrum_builder_free(&r.builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
