/* Reads $Nodes and $Elements of a Gmsh file; see mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read_msh.h"

#include <string.h>

/* Elements of version 2 have at most so many tags. */
enum { TAGS_MAX = 1000 };

/* Reads the header of $Nodes and $Elements in version 4: blocks, items, least and greatest tag. */
static thrum_status block_header(msh_reader *r, int64_t *blocks, int64_t *items) {
  int64_t tag = 0;
  THRUM_TRY(thrum_msh_line(r, "the number of blocks"));
  THRUM_TRY(thrum_msh_whole(r, "the number of blocks", 8, 0, INT64_MAX, blocks));
  THRUM_TRY(thrum_msh_whole(r, "the number of items", 8, 0, INT64_MAX, items));
  for (int i = 0; i < 2; i++)
    THRUM_TRY(thrum_msh_whole(r, "a tag", 8, 0, INT64_MAX, &tag));
  return THRUM_OK;
}

static thrum_status check_items(msh_reader *r, const char *what, int64_t items, int64_t found) {
  if (items == found)
    return THRUM_OK;
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                         "the section says that it has %lld %s, but its blocks hold %lld",
                         (long long)items, what, (long long)found);
}

/* --- nodes ------------------------------------------------------------------------------------ */

/* Reads coordinates, behind which parameters may stand. */
static thrum_status read_position(msh_reader *r, bool parametric, int64_t parameters,
                                  double position[3]) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  double unused = 0;
  for (int c = 0; c < 3; c++)
    THRUM_TRY(thrum_msh_real(r, axes[c], &position[c]));

  // in text the parameters are the rest of the line
  for (int64_t p = 0; p < parameters && parametric && r->binary; p++)
    THRUM_TRY(thrum_msh_real(r, "a parameter", &unused));
  if (r->binary || parametric)
    return THRUM_OK;
  return thrum_text_finish(&r->text, "the three coordinates");
}

/* Reads the nodes of version 2; in $ParametricNodes parameters may follow the coordinates. */
static thrum_status read_nodes_2(msh_reader *r, bool parametric) {
  int64_t count = 0, tag = 0;
  double position[3];
  THRUM_TRY(thrum_msh_count(r, "the number of nodes", &count));
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last node"));
    THRUM_TRY(thrum_msh_whole(r, "the tag of a node", 4, 1, INT64_MAX, &tag));
    THRUM_TRY(read_position(r, parametric, 0, position));
    THRUM_TRY(thrum_builder_vertex(&r->builder, tag, position, r->text.line));
  }
  return THRUM_OK;
}

/* Reads a block of nodes: its tags, then as many positions, which parameters may follow. */
static thrum_status read_node_block(msh_reader *r) {
  int64_t dimension = 0, entity = 0, parametric = 0, count = 0, tag = 0;
  const int64_t first = r->builder.vertex_count;
  static const double unknown[3] = {0};
  THRUM_TRY(thrum_msh_line(r, "the last block of nodes"));
  THRUM_TRY(thrum_msh_whole(r, "a dimension", 4, 0, 3, &dimension));
  THRUM_TRY(thrum_msh_whole(r, "an entity", 4, INT64_MIN, INT64_MAX, &entity));
  THRUM_TRY(thrum_msh_whole(r, "the parametric flag", 4, 0, 1, &parametric));
  THRUM_TRY(thrum_msh_whole(r, "the number of nodes in the block", 8, 0, INT64_MAX, &count));

  // several tags may share a line
  for (int64_t i = 0; i < count; i++) {
    if (!r->binary && !thrum_text_more(&r->text))
      THRUM_TRY(thrum_msh_line(r, "the last tag of the block"));
    THRUM_TRY(thrum_msh_whole(r, "the tag of a node", 8, 1, INT64_MAX, &tag));
    THRUM_TRY(thrum_builder_vertex(&r->builder, tag, unknown, r->text.line));
  }

  // each position has a line of its own
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last node of the block"));
    THRUM_TRY(read_position(r, parametric, dimension, r->builder.positions + 3 * (first + i)));
  }
  return THRUM_OK;
}

thrum_status thrum_msh_nodes(msh_reader *r, bool parametric) {
  if (r->version == 2)
    return read_nodes_2(r, parametric);

  int64_t blocks = 0, items = 0;
  THRUM_TRY(block_header(r, &blocks, &items));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_node_block(r));
  return check_items(r, "nodes", items, r->builder.vertex_count);
}

/* --- elements --------------------------------------------------------------------------------- */

/* The dimension of each type of element, -1 where it is unknown, and the number of its nodes, 0 for
 * solids that are not read. */
static const struct {
  signed char dimension, nodes;
} TYPES[] = {{-1, 0}, {1, 2},  {2, 3},  {2, 4},  {3, 4},  {3, 8},  {3, 6},  {3, 5},
             {1, 3},  {2, 6},  {2, 9},  {3, 10}, {3, 27}, {3, 18}, {3, 14}, {0, 1},
             {2, 8},  {3, 20}, {3, 15}, {3, 13}, {2, 9},  {2, 10}, {2, 12}, {2, 15},
             {2, 15}, {2, 21}, {1, 4},  {1, 5},  {1, 6},  {3, 0},  {3, 0},  {3, 0}};

/* The solids that are read. Nodes at the centres of faces and elements come last and are left out.
 */
typedef struct msh_solid {
  int type;
  thrum_solid solid;
  bool quadratic;
} msh_solid;

static const msh_solid SOLIDS[] = {
    {4, THRUM_SOLID_TET, false},        {5, THRUM_SOLID_HEXAHEDRON, false},
    {6, THRUM_SOLID_WEDGE, false},      {7, THRUM_SOLID_PYRAMID, false},
    {11, THRUM_SOLID_TET, true},        {12, THRUM_SOLID_HEXAHEDRON, true},
    {13, THRUM_SOLID_WEDGE, true},      {14, THRUM_SOLID_PYRAMID, true},
    {17, THRUM_SOLID_HEXAHEDRON, true}, {18, THRUM_SOLID_WEDGE, true},
    {19, THRUM_SOLID_PYRAMID, true}};

const signed char thrum_msh_middles[THRUM_SOLID_KINDS][12] = {
    {4, 5, 6, 7, 9, 8},
    {5, 8, 10, 6, 7, 9, 11, 12},
    {6, 9, 7, 12, 14, 13, 8, 10, 11},
    {8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}};

static const msh_solid *find_solid(int64_t type) {
  for (size_t i = 0; i < sizeof SOLIDS / sizeof *SOLIDS; i++)
    if (SOLIDS[i].type == type)
      return &SOLIDS[i];
  return NULL;
}

static bool is_known(int64_t type) {
  return type >= 1 && type < (int64_t)(sizeof TYPES / sizeof *TYPES);
}

static int dimension_of(int64_t type) {
  return is_known(type) ? TYPES[type].dimension : -1;
}

/* Refuses solid elements that are not read, and in bytes those whose length is unknown. */
static thrum_status check_type(msh_reader *r, int64_t type, int dimension) {
  // what lies below dimension 3 only marks groups
  if (!find_solid(type) && !(dimension >= 0 && dimension < 3)) {
    if (type >= 29 && type <= 31)
      return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                             "tetrahedra of order 3 and more (type %lld) are not supported; mesh "
                             "again with: gmsh -3 -order 2",
                             (long long)type);
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "elements of type %lld are not supported; the body must be meshed with "
                           "solids of order 1 or 2, such as tetrahedra (type 4 or 11)",
                           (long long)type);
  }

  // bytes can be passed over only where their number is known
  if (r->binary && (!is_known(type) || TYPES[type].nodes == 0))
    return thrum_msh_bad_bytes(r, "an element's type is unknown");
  return THRUM_OK;
}

/* Reads a node of an element, of `size` bytes. */
static thrum_status read_node(msh_reader *r, int size, int64_t *tag) {
  THRUM_TRY(thrum_msh_whole(r, "a node of the element", size, 1, INT64_MAX, tag));
  if (thrum_builder_find(&r->builder, *tag) >= 0)
    return THRUM_OK;
  return thrum_text_fail(&r->text, THRUM_BAD_VALUE,
                         "the element names node %lld, which is not in $Nodes", (long long)*tag);
}

/* Adds a solid of Gmsh's nodes. */
static thrum_status add_solid(msh_reader *r, const msh_solid *solid, const int64_t *nodes,
                              int64_t number, int64_t key) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[solid->solid];
  int64_t ordered[THRUM_SOLID_NODES_MAX];
  memcpy(ordered, nodes, (size_t)shape->corners * sizeof *nodes);
  for (int e = 0; e < shape->edges && solid->quadratic; e++)
    ordered[shape->corners + e] = nodes[thrum_msh_middles[solid->solid][e]];
  return thrum_builder_element(&r->builder, &(thrum_element){.kind = solid->solid,
                                                             .quadratic = solid->quadratic,
                                                             .nodes = ordered,
                                                             .number = number,
                                                             .key = key,
                                                             .line = r->text.line});
}

/* Reads the nodes of an element, of `size` bytes each, and adds them to its physical groups. */
static thrum_status read_element(msh_reader *r, int64_t type, int size, int64_t number,
                                 const int64_t *physicals, int64_t physical_count) {
  const msh_solid *solid = find_solid(type);
  int64_t nodes[MSH_NODES_MAX] = {0}, tag = 0;

  // in text an element that is no solid goes on to the end of its line
  const int count = solid || r->binary ? TYPES[type].nodes : INT32_MAX;
  for (int n = 0; n < count && (solid || r->binary || thrum_text_more(&r->text)); n++) {
    // elements below dimension 3 matter only as members of groups
    if (!solid && physical_count == 0 && !r->binary)
      return THRUM_OK;
    THRUM_TRY(read_node(r, size, &tag));
    if (solid)
      nodes[n] = tag;
    for (int64_t p = 0; p < physical_count; p++)
      THRUM_TRY(thrum_builder_add(&r->builder, r->physicals[physicals[p]].list, tag));
  }
  if (!solid)
    return THRUM_OK;
  if (!r->binary)
    THRUM_TRY(thrum_text_finish(&r->text, "the nodes of the element"));

  // a solid in several physical volumes belongs to the region of the first
  return add_solid(r, solid, nodes, number, physical_count > 0 ? physicals[0] : MSH_NO_PHYSICAL);
}

/* Reads the tags and nodes of an element of version 2. */
static thrum_status read_tagged_element(msh_reader *r, int64_t type, int64_t number, int64_t tags) {
  int64_t tag = 0, physical = 0, index = 0;

  // the first tag is the physical group; its sign is only an orientation
  for (int64_t k = 0; k < tags; k++) {
    THRUM_TRY(thrum_msh_whole(r, "a tag", 4, -INT64_MAX, INT64_MAX, &tag));
    physical = k == 0 ? (tag < 0 ? -tag : tag) : physical;
  }

  // physical group 0 means none
  if (physical != 0)
    THRUM_TRY(thrum_msh_find_physical(r, dimension_of(type), physical, &index));
  return read_element(r, type, 4, number, &index, physical != 0);
}

/* Reads elements of version 2: in text `number type tags` and the rest of one element, in bytes a
 * header `type count tags` and as many, each after its number. */
static thrum_status read_elements_2(msh_reader *r, int64_t left, int64_t *read) {
  int64_t number = 0, type = 0, tags = 0;
  *read = 1;
  THRUM_TRY(thrum_msh_line(r, "the last element"));
  if (!r->binary)
    THRUM_TRY(thrum_msh_whole(r, "the number of an element", 4, 0, INT64_MAX, &number));
  THRUM_TRY(thrum_msh_whole(r, "the type of an element", 4, 1, INT64_MAX, &type));
  THRUM_TRY(check_type(r, type, dimension_of(type)));
  if (r->binary)
    THRUM_TRY(thrum_msh_whole(r, "the number of elements", 4, INT64_MIN, INT64_MAX, read));
  THRUM_TRY(
      thrum_msh_whole(r, "the number of tags", 4, r->binary ? INT64_MIN : 0, INT64_MAX, &tags));

  // damaged counts would make the loop read on through the file
  if (r->binary && (*read < 1 || *read > left || tags < 0 || tags > TAGS_MAX))
    return thrum_msh_bad_bytes(r, "a block of elements has impossible counts");

  for (int64_t i = 0; i < *read; i++) {
    if (r->binary)
      THRUM_TRY(thrum_msh_whole(r, "the number of an element", 4, INT64_MIN, INT64_MAX, &number));
    THRUM_TRY(read_tagged_element(r, type, number, tags));
  }
  return THRUM_OK;
}

static thrum_status read_element_block(msh_reader *r, int64_t *items) {
  int64_t dimension = 0, type = 0, count = 0, number = 0, tag = 0;
  THRUM_TRY(thrum_msh_line(r, "the last block of elements"));
  THRUM_TRY(thrum_msh_whole(r, "a dimension", 4, 0, 3, &dimension));
  THRUM_TRY(thrum_msh_whole(r, "an entity", 4, INT64_MIN, INT64_MAX, &tag));
  THRUM_TRY(thrum_msh_whole(r, "the type of the elements", 4, 1, INT64_MAX, &type));
  THRUM_TRY(thrum_msh_whole(r, "the number of elements in the block", 8, 0, INT64_MAX, &count));
  THRUM_TRY(check_type(r, type, (int)dimension));

  // the elements of a block lie in the physical groups of its entity
  int64_t physical_count;
  const int64_t *physicals = thrum_msh_entity_physicals(r, (int)dimension, tag, &physical_count);

  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last element of the block"));
    THRUM_TRY(thrum_msh_whole(r, "the number of an element", 8, 0, INT64_MAX, &number));
    THRUM_TRY(read_element(r, type, 8, number, physicals, physical_count));
    ++*items;
  }
  return THRUM_OK;
}

thrum_status thrum_msh_elements(msh_reader *r) {
  int64_t count = 0, blocks = 0, items = 0, read = 0;

  // version 2 has one list of all elements
  if (r->version == 2) {
    THRUM_TRY(thrum_msh_count(r, "the number of elements", &count));
    for (; items < count; items += read)
      THRUM_TRY(read_elements_2(r, count - items, &read));
    return THRUM_OK;
  }

  // version 4: blocks of elements of one entity and one type
  THRUM_TRY(block_header(r, &blocks, &count));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_element_block(r, &items));
  return check_items(r, "elements", count, items);
}
