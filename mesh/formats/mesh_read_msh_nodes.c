/* Reads $Nodes of a Gmsh file in text and finds nodes by their tags; see mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "mesh/formats/mesh_read_msh.h"
#include "mesh/mesh_grow.h"

/* Adds a node; returns NULL when there is no memory. */
msh_node *thrum_msh_add_node(msh_reader *r) {
  msh_node *grown = thrum_mesh_grow(r->nodes, &r->node_capacity, r->node_count + 1, sizeof *grown);
  if (!grown)
    return NULL;
  r->nodes = grown;
  msh_node *node = &grown[r->node_count++];
  *node = (msh_node){0};
  return node;
}

static thrum_status read_tag(msh_reader *r) {
  msh_node *node = thrum_msh_add_node(r);
  if (!node)
    return thrum_msh_no_memory(r);
  if (r->node_count > INT32_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than 2^31 - 1 nodes");
  node->line = r->text.line;
  return thrum_msh_integer(r, "the tag of a node", 1, &node->tag);
}

static thrum_status read_position(msh_reader *r, msh_node *node) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  for (int c = 0; c < 3; c++)
    THRUM_TRY(thrum_text_number(&r->text, axes[c], &node->position[c], r->error));
  return THRUM_OK;
}

/* Reads the nodes of version 2; in $ParametricNodes parameters may follow the coordinates. */
static thrum_status read_nodes_2(msh_reader *r, bool parametric) {
  int64_t count = 0;
  THRUM_TRY(thrum_msh_line(r, "the number of nodes"));
  THRUM_TRY(thrum_msh_integer(r, "the number of nodes", 0, &count));
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last node"));
    THRUM_TRY(read_tag(r));
    THRUM_TRY(read_position(r, &r->nodes[r->node_count - 1]));
    if (!parametric)
      THRUM_TRY(thrum_text_finish(&r->text, "the three coordinates", r->error));
  }
  return THRUM_OK;
}

/* Reads a block of nodes: its tags, then as many positions, which parameters may follow. */
static thrum_status read_node_block(msh_reader *r) {
  int64_t unused = 0, parametric = 0, count = 0, first = r->node_count;
  THRUM_TRY(thrum_msh_line(r, "the last block of nodes"));
  THRUM_TRY(thrum_text_integer(&r->text, "a dimension", 0, 3, &unused, r->error));
  THRUM_TRY(thrum_msh_integer(r, "an entity", INT64_MIN, &unused));
  THRUM_TRY(thrum_text_integer(&r->text, "the parametric flag", 0, 1, &parametric, r->error));
  THRUM_TRY(thrum_msh_integer(r, "the number of nodes in the block", 0, &count));

  // several tags may share a line
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_word(r, "the last tag of the block"));
    THRUM_TRY(read_tag(r));
  }

  // each position has a line of its own
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last node of the block"));
    THRUM_TRY(read_position(r, &r->nodes[first + i]));
    if (!parametric)
      THRUM_TRY(thrum_text_finish(&r->text, "the three coordinates", r->error));
  }
  return THRUM_OK;
}

/* Reads the header of $Nodes and $Elements in version 4: blocks, items, least and greatest tag. */
thrum_status thrum_msh_block_header(msh_reader *r, int64_t *blocks, int64_t *items) {
  int64_t tag = 0;
  THRUM_TRY(thrum_msh_line(r, "the number of blocks"));
  THRUM_TRY(thrum_msh_integer(r, "the number of blocks", 0, blocks));
  THRUM_TRY(thrum_msh_integer(r, "the number of items", 0, items));
  for (int i = 0; i < 2; i++)
    THRUM_TRY(thrum_msh_integer(r, "a tag", 0, &tag));
  return THRUM_OK;
}

thrum_status thrum_msh_check_items(msh_reader *r, const char *what, int64_t items, int64_t found) {
  if (items == found)
    return THRUM_OK;
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                         "the section says that it has %lld %s, but its blocks hold %lld",
                         (long long)items, what, (long long)found);
}

static int compare_nodes(const void *a, const void *b) {
  const msh_node *x = a, *y = b;
  return (x->tag > y->tag) - (x->tag < y->tag);
}

/* Sorts the nodes and makes the table from tags to them. */
thrum_status thrum_msh_index_nodes(msh_reader *r) {
  msh_node *nodes = r->nodes;

  // most files have their nodes in order and need no sorting
  bool sorted = true;
  for (int64_t i = 1; i < r->node_count && sorted; i++)
    sorted = nodes[i - 1].tag < nodes[i].tag;

  if (!sorted)
    qsort(nodes, (size_t)r->node_count, sizeof *nodes, compare_nodes);

  // after sorting, equal tags are neighbours
  for (int64_t i = 1; i < r->node_count; i++)
    if (nodes[i - 1].tag == nodes[i].tag)
      return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.150s:%lld: node %lld comes twice",
                             r->text.name, (long long)nodes[i].line, (long long)nodes[i].tag);

  // tags far above the number of nodes would make the table too large; bsearch serves then
  int64_t last = r->node_count > 0 ? nodes[r->node_count - 1].tag : 0;
  if (last / 4 > r->node_count + 256)
    return THRUM_OK;

  r->table_count = last + 1;
  r->table = malloc((size_t)r->table_count * sizeof *r->table);
  if (!r->table)
    return thrum_msh_no_memory(r);

  // tags of no node keep -1
  for (int64_t i = 0; i < r->table_count; i++)
    r->table[i] = -1;
  for (int64_t i = 0; i < r->node_count; i++)
    r->table[nodes[i].tag] = (int32_t)i;
  return THRUM_OK;
}

thrum_status thrum_msh_text_nodes(msh_reader *r, bool parametric) {
  if (r->version == 2)
    return read_nodes_2(r, parametric);

  int64_t blocks = 0, items = 0;
  THRUM_TRY(thrum_msh_block_header(r, &blocks, &items));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_node_block(r));
  return thrum_msh_check_items(r, "nodes", items, r->node_count);
}

thrum_status thrum_msh_node_index(msh_reader *r, int64_t tag, int32_t *index) {
  int32_t found = -1;

  // without a table the sorted nodes are searched
  if (r->table) {
    found = tag >= 0 && tag < r->table_count ? r->table[tag] : -1;
  } else {
    msh_node key = {.tag = tag};
    const msh_node *node = NULL;
    if (r->node_count > 0)
      node = bsearch(&key, r->nodes, (size_t)r->node_count, sizeof key, compare_nodes);
    found = node ? (int32_t)(node - r->nodes) : -1;
  }

  // an element without one of its nodes has no shape
  if (found < 0)
    return thrum_text_fail(&r->text, THRUM_BAD_VALUE, r->error,
                           "the element names node %lld, which is not in $Nodes", (long long)tag);
  *index = found;
  return THRUM_OK;
}

/* Reads the tag of a node and returns the node's index. */
thrum_status thrum_msh_read_node(msh_reader *r, int32_t *index) {
  int64_t tag = 0;
  THRUM_TRY(thrum_msh_integer(r, "a node of the element", 1, &tag));
  return thrum_msh_node_index(r, tag, index);
}
