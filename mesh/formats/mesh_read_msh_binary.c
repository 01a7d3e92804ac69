/* Reads the sections of binary Gmsh files, versions 2.2 and 4.1, of either byte order: $Entities,
 * $Nodes, $Elements; the lines around them are text. Format: Gmsh reference manual,
 * https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format. Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "mesh/formats/mesh_read_msh.h"

/* Elements have at most so many nodes, and elements of version 2.2 at most so many tags. */
enum { NODES_MAX = 64, TAGS_MAX = 1000 };

static thrum_status no_memory(msh_reader *r) {
  return thrum_text_fail(&r->text, THRUM_OUT_OF_MEMORY, r->error, "not enough memory");
}

/* Binary data has no lines, so a message names the line in front of it. */
static thrum_status fail(msh_reader *r, const char *what) {
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                         "in the binary data behind this line: %s", what);
}

static uint64_t take_bits(const msh_reader *r, const unsigned char *bytes, int size) {
  uint64_t bits = 0;
  for (int i = 0; i < size; i++)
    bits = bits << 8 | bytes[r->little ? size - 1 - i : i];
  return bits;
}

/* Takes the next `size` bytes; returns NULL when the file ends before. */
static const unsigned char *take(msh_reader *r, size_t size) {
  if ((size_t)(r->text.stop - r->text.next) < size)
    return NULL;
  const unsigned char *bytes = (const unsigned char *)r->text.next;
  r->text.next += size;
  return bytes;
}

static thrum_status cut_short(msh_reader *r) {
  return fail(r, "the file ends too early; is it cut short?");
}

/* Reads a whole number of 4 bytes, which is signed, or of 8. */
static thrum_status whole(msh_reader *r, int size, int64_t *value) {
  const unsigned char *bytes = take(r, (size_t)size);
  if (!bytes)
    return cut_short(r);

  // a count near 2^63 is damage, and sizes computed from it would overflow
  const uint64_t bits = take_bits(r, bytes, size);
  if (size == 8 && bits > INT64_MAX / 64)
    return fail(r, "a count or a tag is out of range");

  *value = size == 8                  ? (int64_t)bits
           : bits < UINT64_C(1) << 31 ? (int64_t)bits
                                      : (int64_t)bits - (INT64_C(1) << 32);
  return THRUM_OK;
}

static thrum_status real(msh_reader *r, double *value) {
  const unsigned char *bytes = take(r, 8);
  if (!bytes)
    return cut_short(r);
  const uint64_t bits = take_bits(r, bytes, 8);
  memcpy(value, &bits, sizeof *value);
  return isfinite(*value) ? THRUM_OK : fail(r, "a coordinate is not a finite number");
}

thrum_status thrum_msh_binary_format(msh_reader *r) {
  r->binary = true;
  r->little = true;

  int64_t one = 0;

  // the number 1 is written in the order of the bytes of the file
  thrum_status status = whole(r, 4, &one);
  if (status >= 0 && one == 16777216)
    r->little = false;
  else if (status >= 0 && one != 1)
    status = fail(r, "there is no 1 to tell the order of the bytes");
  return status;
}

/* Reads `tag box physicals`; for curves, surfaces and volumes the bounding entities follow. */
static thrum_status read_entity(msh_reader *r, int dimension) {
  msh_entity entity = {.dimension = dimension, .first = r->entity_physical_count};
  int64_t bounding = 0, tag = 0;
  THRUM_TRY(whole(r, 4, &entity.tag));

  // the box serves only the display
  if (!take(r, 8 * (dimension == 0 ? 3 : 6)))
    return cut_short(r);
  THRUM_TRY(whole(r, 8, &entity.count));

  // a tet inherits the physical groups of its volume
  for (int64_t i = 0; i < entity.count; i++) {
    THRUM_TRY(whole(r, 4, &tag));
    THRUM_TRY(thrum_msh_add_entity_physical(r, dimension, tag));
  }

  // the bounding entities serve only the geometry
  if (dimension > 0)
    THRUM_TRY(whole(r, 8, &bounding));
  for (int64_t i = 0; i < bounding; i++)
    THRUM_TRY(whole(r, 4, &tag));

  return thrum_msh_add_entity(r, &entity);
}

thrum_status thrum_msh_binary_entities(msh_reader *r) {
  int64_t counts[4] = {0, 0, 0, 0};
  thrum_status status = THRUM_OK;
  for (int d = 0; d < 4 && status >= 0; d++)
    status = whole(r, 8, &counts[d]);
  for (int d = 0; d < 4; d++)
    for (int64_t i = 0; i < counts[d] && status >= 0; i++)
      status = read_entity(r, d);
  if (status >= 0)
    thrum_msh_sort_entities(r);
  return status;
}

static thrum_status read_position(msh_reader *r, msh_node *node) {
  for (int c = 0; c < 3; c++)
    THRUM_TRY(real(r, &node->position[c]));
  return THRUM_OK;
}

static thrum_status read_tag(msh_reader *r, int size) {
  msh_node *node = thrum_msh_add_node(r);
  if (!node)
    return no_memory(r);
  if (r->node_count > INT32_MAX)
    return fail(r, "more than 2^31 - 1 nodes");
  node->line = r->text.line;
  THRUM_TRY(whole(r, size, &node->tag));
  if (node->tag < 1)
    return fail(r, "the tag of a node is below 1");
  return THRUM_OK;
}

/* Reads the line of the count, which is text in version 2. */
static thrum_status count_line(msh_reader *r, int64_t *count) {
  if (!thrum_text_next_line(&r->text))
    return cut_short(r);
  return thrum_text_integer(&r->text, "the number of items", 0, INT64_MAX, count, r->error);
}

static thrum_status read_nodes_2(msh_reader *r) {
  int64_t count = 0;
  THRUM_TRY(count_line(r, &count));
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(read_tag(r, 4));
    THRUM_TRY(read_position(r, &r->nodes[r->node_count - 1]));
  }
  return THRUM_OK;
}

static thrum_status read_node_block(msh_reader *r) {
  int64_t dimension = 0, entity = 0, parametric = 0, count = 0;
  const int64_t first = r->node_count;
  double unused = 0;
  THRUM_TRY(whole(r, 4, &dimension));
  THRUM_TRY(whole(r, 4, &entity));
  THRUM_TRY(whole(r, 4, &parametric));
  THRUM_TRY(whole(r, 8, &count));

  // the dimension is the number of parameters of a parametric node
  if ((dimension < 0 || dimension > 3 || parametric < 0 || parametric > 1))
    return fail(r, "a block of nodes has no dimension from 0 to 3");

  // all tags come before all positions
  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_tag(r, 8));
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(read_position(r, &r->nodes[first + i]));
    for (int64_t p = 0; p < dimension && parametric; p++)
      THRUM_TRY(real(r, &unused));
  }
  return THRUM_OK;
}

/* Reads the numbers of blocks and items; the least and the greatest tag are passed over. */
static thrum_status read_block_header(msh_reader *r, int64_t *blocks, int64_t *items) {
  int64_t tag = 0;
  THRUM_TRY(whole(r, 8, blocks));
  THRUM_TRY(whole(r, 8, items));
  for (int i = 0; i < 2; i++)
    THRUM_TRY(whole(r, 8, &tag));
  return THRUM_OK;
}

thrum_status thrum_msh_binary_nodes(msh_reader *r) {
  if (r->version == 2)
    return read_nodes_2(r);
  int64_t blocks = 0, items = 0;
  THRUM_TRY(read_block_header(r, &blocks, &items));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_node_block(r));
  if (items != r->node_count)
    return fail(r, "the blocks hold another number of nodes than the section says");
  return THRUM_OK;
}

/* Returns the number of nodes of an element type below dimension 3 or of a tet; 0 for others. */
static int node_count(int64_t type) {
  static const unsigned char counts[] = {0, 2, 3, 4, 4, 0, 0,  0,  3,  6,  9,  0, 0, 0, 0,
                                         1, 8, 0, 0, 0, 9, 10, 12, 15, 15, 21, 4, 5, 6};
  return type >= 1 && type < (int64_t)sizeof counts ? counts[type] : 0;
}

static thrum_status check_element(msh_reader *r, int64_t type, int dimension) {
  THRUM_TRY(thrum_msh_check_type(r, type, dimension));
  if (node_count(type) == 0)
    return fail(r, "an element's type is unknown");
  return THRUM_OK;
}

/* Reads the nodes of an element, of `size` bytes each, and adds them to its physical groups. */
static thrum_status read_element(msh_reader *r, int64_t type, int size, const int32_t *physicals,
                                 int64_t physical_count) {
  int32_t nodes[NODES_MAX];
  const int count = node_count(type);
  for (int n = 0; n < count; n++) {
    int64_t tag = 0;
    THRUM_TRY(whole(r, size, &tag));

    // nodes of elements in no group are not needed
    if ((type == MSH_TET || physical_count > 0))
      THRUM_TRY(thrum_msh_node_index(r, tag, &nodes[n]));
  }

  // a tet in several physical volumes belongs to the region of the first
  if (type == MSH_TET)
    THRUM_TRY(thrum_msh_add_tet(r, nodes, physical_count > 0 ? physicals[0] : MSH_NO_PHYSICAL));
  for (int64_t p = 0; p < physical_count; p++)
    THRUM_TRY(thrum_msh_add_to_physical(r, physicals[p], nodes, count));
  return THRUM_OK;
}

/* Reads the elements of version 2: those of one type follow `type count tags`. */
static thrum_status read_elements_2(msh_reader *r) {
  int64_t total = 0, read = 0;
  THRUM_TRY(count_line(r, &total));
  while (read < total) {
    // each block has its own header
    int64_t type = 0, count = 0, tags = 0;
    THRUM_TRY(whole(r, 4, &type));
    THRUM_TRY(whole(r, 4, &count));
    THRUM_TRY(whole(r, 4, &tags));
    THRUM_TRY(check_element(r, type, thrum_msh_type_dimension(type)));

    // damaged counts would make the loop read on through the file
    if ((count < 1 || tags < 0 || tags > TAGS_MAX || count > total - read))
      return fail(r, "a block of elements has impossible counts");

    for (int64_t i = 0; i < count; i++) {
      int64_t number = 0, tag = 0, physical = 0, index = 0;
      THRUM_TRY(whole(r, 4, &number));

      // the first tag is the physical group; its sign is only an orientation
      for (int64_t k = 0; k < tags; k++) {
        THRUM_TRY(whole(r, 4, &tag));
        physical = k == 0 ? (tag < 0 ? -tag : tag) : physical;
      }

      // physical group 0 means none
      if (physical != 0)
        THRUM_TRY(thrum_msh_find_physical(r, thrum_msh_type_dimension(type), physical, &index));
      const int32_t list = (int32_t)index;
      THRUM_TRY(read_element(r, type, 4, &list, physical != 0));
    }
    read += count;
  }
  return THRUM_OK;
}

static thrum_status read_element_block(msh_reader *r, int64_t *items) {
  int64_t dimension = 0, tag = 0, type = 0, count = 0, number = 0;
  THRUM_TRY(whole(r, 4, &dimension));
  THRUM_TRY(whole(r, 4, &tag));
  THRUM_TRY(whole(r, 4, &type));
  THRUM_TRY(whole(r, 8, &count));
  THRUM_TRY(check_element(r, type, (int)dimension));

  // the elements of a block lie in the physical groups of its entity
  int64_t physical_count;
  const int32_t *physicals = thrum_msh_entity_physicals(r, (int)dimension, tag, &physical_count);

  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(whole(r, 8, &number));
    THRUM_TRY(read_element(r, type, 8, physicals, physical_count));
    ++*items;
  }
  return THRUM_OK;
}

thrum_status thrum_msh_binary_elements(msh_reader *r) {
  if (r->version == 2)
    return read_elements_2(r);
  int64_t blocks = 0, count = 0, items = 0;
  THRUM_TRY(read_block_header(r, &blocks, &count));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_element_block(r, &items));
  if (items != count)
    return fail(r, "the blocks hold another number of elements than the section says");
  return THRUM_OK;
}
