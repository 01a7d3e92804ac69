/* Gmsh .msh files, versions 2.2 and 4.1, in ASCII (binary sections: mesh_msh_binary.c):
 * $PhysicalNames, $Entities, $Nodes, $Elements; other sections are passed over. Tetrahedra (type 4)
 * are the mesh. Physical volumes are its regions; physical groups of any dimension are vertex
 * groups. Version 2 writes an element once for each physical group that it is in: tets that come
 * again are joined with the first. Vertices are ordered by their tags, which may have gaps. Cost:
 * linear in the file, n log n in the nodes when they are not in order.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/mesh_msh.h"

static thrum_status no_memory(msh_reader *r) {
  return thrum_text_fail(&r->text, THRUM_OUT_OF_MEMORY, r->error, "not enough memory");
}

/* Moves to the next line of a section; its end, or that of the file, is refused. */
static thrum_status section_line(msh_reader *r, const char *what) {
  if (!thrum_text_next_line(&r->text))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "the file ends before %s; is it cut short?", what);
  if (*r->text.start == '$')
    return thrum_text_fail(
        &r->text, THRUM_BAD_FORMAT, r->error, "expected %s, found '%s'", what,
        thrum_text_excerpt(r->text.start, (size_t)(r->text.end - r->text.start)).text);
  return THRUM_OK;
}

/* Goes on to the next line when the present one is used up. */
static thrum_status section_word(msh_reader *r, const char *what) {
  return thrum_text_more(&r->text) ? THRUM_OK : section_line(r, what);
}

static thrum_status integer(msh_reader *r, const char *what, int64_t low, int64_t *value) {
  return thrum_text_integer(&r->text, what, low, INT64_MAX, value, r->error);
}

/* Index of a physical group, added when it is new. */
thrum_status thrum_msh_find_physical(msh_reader *r, int dimension, int64_t tag, int64_t *index) {
  for (int64_t step = 0; step < r->physical_count; step++) {
    // the one found last comes first: elements of a group stand together
    int64_t i = (r->last_physical + step) % r->physical_count;
    if (r->physicals[i].tag == tag && r->physicals[i].dimension == dimension) {
      *index = r->last_physical = i;
      return THRUM_OK;
    }
  }
  if (r->physical_count == THRUM_MESH_GROUPS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than %d physical groups",
                           THRUM_MESH_GROUPS_MAX);
  *index = r->last_physical = r->physical_count++;
  r->physicals[*index] = (msh_physical){.dimension = dimension, .tag = tag};
  return THRUM_OK;
}

thrum_status thrum_msh_add_to_physical(msh_reader *r, int64_t index, const int32_t *vertices,
                                       int count) {
  msh_physical *p = &r->physicals[index];
  int32_t *grown = thrum_mesh_grow(p->vertices, &p->capacity, p->count + count, sizeof *grown);
  if (!grown)
    return no_memory(r);
  p->vertices = grown;
  for (int i = 0; i < count; i++)
    grown[p->count++] = vertices[i];
  return THRUM_OK;
}

static thrum_status read_format(msh_reader *r) {
  thrum_status status = section_line(r, "the version");
  double version = 0;
  int64_t binary = 0, size = 8;
  if (status >= 0)
    status = thrum_text_number(&r->text, "the version", &version, r->error);
  if (status >= 0)
    status = integer(r, "the kind, 0 for ASCII", 0, &binary);
  if (status >= 0)
    status = integer(r, "the size of numbers", 0, &size);
  if (status < 0)
    return status;
  if (!(version >= 2 && version < 2.3) && version != 4.1)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "version %g is not read, only 2.2 and 4.1; convert it with: gmsh "
                           "FILE -save -format msh41 -o NEW.msh",
                           version);
  r->version = version < 3 ? 2 : 4;
  return binary != 0 ? thrum_msh_binary_format(r) : THRUM_OK;
}

/* `dimension tag "name"` */
static thrum_status read_physical_name(msh_reader *r) {
  int64_t dimension = 0, tag = 0, index = 0;
  thrum_status status = section_line(r, "the last physical name");
  if (status >= 0)
    status = thrum_text_integer(&r->text, "the dimension", 0, 3, &dimension, r->error);
  if (status >= 0)
    status = integer(r, "the tag of the physical group", 1, &tag);
  if (status >= 0)
    status = thrum_msh_find_physical(r, (int)dimension, tag, &index);
  if (status < 0)
    return status;
  thrum_text_more(&r->text);
  const char *start = r->text.at, *end = r->text.end;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }
  size_t length = (size_t)(end - start);
  const char *fault = thrum_mesh_name_fault(start, length);
  if (fault)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "%s", fault);
  if (r->physicals[index].name)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "physical group %lld of dimension %d is named twice", (long long)tag,
                           (int)dimension);
  char *name = malloc(length + 1);
  if (!name)
    return no_memory(r);
  memcpy(name, start, length);
  name[length] = '\0';
  r->physicals[index].name = name;
  return THRUM_OK;
}

static thrum_status read_physical_names(msh_reader *r) {
  int64_t count = 0;
  thrum_status status = section_line(r, "the number of physical names");
  if (status >= 0)
    status = integer(r, "the number of physical names", 0, &count);
  for (int64_t i = 0; i < count && status >= 0; i++)
    status = read_physical_name(r);
  return status;
}

thrum_status thrum_msh_add_entity_physical(msh_reader *r, int dimension, int64_t tag) {
  int64_t index = 0;
  // a sign only says which way round the group is
  thrum_status status = thrum_msh_find_physical(r, dimension, tag < 0 ? -tag : tag, &index);
  if (status < 0)
    return status;
  int32_t *grown = thrum_mesh_grow(r->entity_physicals, &r->entity_physical_capacity,
                                   r->entity_physical_count + 1, sizeof *grown);
  if (!grown)
    return no_memory(r);
  r->entity_physicals = grown;
  grown[r->entity_physical_count++] = (int32_t)index;
  return THRUM_OK;
}

thrum_status thrum_msh_add_entity(msh_reader *r, const msh_entity *entity) {
  msh_entity *grown =
      thrum_mesh_grow(r->entities, &r->entity_capacity, r->entity_count + 1, sizeof *grown);
  if (!grown)
    return no_memory(r);
  r->entities = grown;
  grown[r->entity_count++] = *entity;
  return THRUM_OK;
}

/* `tag box physicals...`: the box is three numbers for points, else six. */
static thrum_status read_entity(msh_reader *r, int dimension) {
  msh_entity entity = {.dimension = dimension, .first = r->entity_physical_count};
  double box = 0;
  thrum_status status = section_line(r, "the last entity");
  if (status >= 0)
    status = integer(r, "the tag of the entity", INT64_MIN, &entity.tag);
  for (int i = 0; i < (dimension == 0 ? 3 : 6) && status >= 0; i++)
    status = thrum_text_number(&r->text, "the entity's box", &box, r->error);
  if (status >= 0)
    status = integer(r, "the number of physical groups", 0, &entity.count);
  for (int64_t i = 0; i < entity.count && status >= 0; i++) {
    int64_t tag = 0;
    status =
        thrum_text_integer(&r->text, "a physical group", -INT64_MAX, INT64_MAX, &tag, r->error);
    if (status >= 0)
      status = thrum_msh_add_entity_physical(r, dimension, tag);
  }
  return status < 0 ? status : thrum_msh_add_entity(r, &entity);
}

static int compare_entities(const void *a, const void *b) {
  const msh_entity *x = a, *y = b;
  if (x->dimension != y->dimension)
    return x->dimension < y->dimension ? -1 : 1;
  return (x->tag > y->tag) - (x->tag < y->tag);
}

void thrum_msh_sort_entities(msh_reader *r) {
  if (r->entity_count > 0)
    qsort(r->entities, (size_t)r->entity_count, sizeof *r->entities, compare_entities);
}

const int32_t *thrum_msh_entity_physicals(const msh_reader *r, int dimension, int64_t tag,
                                          int64_t *count) {
  const msh_entity key = {.dimension = dimension, .tag = tag};
  const msh_entity *entity = NULL;
  if (r->entity_count > 0)
    entity = bsearch(&key, r->entities, (size_t)r->entity_count, sizeof key, compare_entities);
  *count = entity ? entity->count : 0;
  return *count > 0 ? r->entity_physicals + entity->first : NULL;
}

static thrum_status read_entities(msh_reader *r) {
  if (r->version != 4)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Entities does not belong into a file of version 2");
  if (r->has_entities || r->has_elements)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Entities comes twice or after $Elements");
  r->has_entities = true;
  if (r->binary)
    return thrum_msh_binary_entities(r);
  int64_t counts[4] = {0, 0, 0, 0};
  thrum_status status = section_line(r, "the numbers of entities");
  for (int d = 0; d < 4 && status >= 0; d++)
    status = integer(r, "the number of entities", 0, &counts[d]);
  for (int d = 0; d < 4; d++)
    for (int64_t i = 0; i < counts[d] && status >= 0; i++)
      status = read_entity(r, d);
  if (status >= 0)
    thrum_msh_sort_entities(r);
  return status;
}

/* A new node with its tag; NULL when there is no memory. */
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
    return no_memory(r);
  if (r->node_count > INT32_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than 2^31 - 1 nodes");
  node->line = r->text.line;
  return integer(r, "the tag of a node", 1, &node->tag);
}

static thrum_status read_position(msh_reader *r, msh_node *node) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  thrum_status status = THRUM_OK;
  for (int c = 0; c < 3 && status >= 0; c++)
    status = thrum_text_number(&r->text, axes[c], &node->position[c], r->error);
  return status;
}

/* Parameters may follow the coordinates, in $ParametricNodes. */
static thrum_status read_nodes_2(msh_reader *r, bool parametric) {
  int64_t count = 0;
  thrum_status status = section_line(r, "the number of nodes");
  if (status >= 0)
    status = integer(r, "the number of nodes", 0, &count);
  for (int64_t i = 0; i < count && status >= 0; i++) {
    status = section_line(r, "the last node");
    if (status >= 0)
      status = read_tag(r);
    if (status >= 0)
      status = read_position(r, &r->nodes[r->node_count - 1]);
    if (status >= 0 && !parametric)
      status = thrum_text_finish(&r->text, "the three coordinates", r->error);
  }
  return status;
}

/* Tags first, then as many positions, each on its line, perhaps with parameters behind. */
static thrum_status read_node_block(msh_reader *r) {
  int64_t unused = 0, parametric = 0, count = 0, first = r->node_count;
  thrum_status status = section_line(r, "the last block of nodes");
  if (status >= 0)
    status = thrum_text_integer(&r->text, "a dimension", 0, 3, &unused, r->error);
  if (status >= 0)
    status = integer(r, "an entity", INT64_MIN, &unused);
  if (status >= 0)
    status = thrum_text_integer(&r->text, "the parametric flag", 0, 1, &parametric, r->error);
  if (status >= 0)
    status = integer(r, "the number of nodes in the block", 0, &count);
  for (int64_t i = 0; i < count && status >= 0; i++) {
    status = section_word(r, "the last tag of the block");
    if (status >= 0)
      status = read_tag(r);
  }
  for (int64_t i = 0; i < count && status >= 0; i++) {
    status = section_line(r, "the last node of the block");
    if (status >= 0)
      status = read_position(r, &r->nodes[first + i]);
    if (status >= 0 && !parametric)
      status = thrum_text_finish(&r->text, "the three coordinates", r->error);
  }
  return status;
}

/* The header of $Nodes and $Elements in version 4: blocks, items, least and greatest tag. */
static thrum_status read_block_header(msh_reader *r, int64_t *blocks, int64_t *items) {
  int64_t tag = 0;
  thrum_status status = section_line(r, "the number of blocks");
  if (status >= 0)
    status = integer(r, "the number of blocks", 0, blocks);
  if (status >= 0)
    status = integer(r, "the number of items", 0, items);
  for (int i = 0; i < 2 && status >= 0; i++)
    status = integer(r, "a tag", 0, &tag);
  return status;
}

static thrum_status check_items(msh_reader *r, const char *what, int64_t items, int64_t found) {
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
  bool sorted = true;
  for (int64_t i = 1; i < r->node_count && sorted; i++)
    sorted = nodes[i - 1].tag < nodes[i].tag;
  if (!sorted)
    qsort(nodes, (size_t)r->node_count, sizeof *nodes, compare_nodes);
  for (int64_t i = 1; i < r->node_count; i++)
    if (nodes[i - 1].tag == nodes[i].tag)
      return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.150s:%lld: node %lld comes twice",
                             r->text.name, (long long)nodes[i].line, (long long)nodes[i].tag);
  int64_t last = r->node_count > 0 ? nodes[r->node_count - 1].tag : 0;
  if (last / 4 > r->node_count + 256)
    return THRUM_OK;
  r->table_count = last + 1;
  r->table = malloc((size_t)r->table_count * sizeof *r->table);
  if (!r->table)
    return no_memory(r);
  for (int64_t i = 0; i < r->table_count; i++)
    r->table[i] = -1;
  for (int64_t i = 0; i < r->node_count; i++)
    r->table[nodes[i].tag] = (int32_t)i;
  return THRUM_OK;
}

static thrum_status read_some_nodes(msh_reader *r, bool parametric) {
  if (r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "$Nodes comes twice");
  r->has_nodes = true;
  thrum_status status;
  if (r->binary) {
    status = thrum_msh_binary_nodes(r);
  } else if (r->version == 2) {
    status = read_nodes_2(r, parametric);
  } else {
    int64_t blocks = 0, items = 0;
    status = read_block_header(r, &blocks, &items);
    for (int64_t b = 0; b < blocks && status >= 0; b++)
      status = read_node_block(r);
    if (status >= 0)
      status = check_items(r, "nodes", items, r->node_count);
  }
  return status < 0 ? status : thrum_msh_index_nodes(r);
}

static thrum_status read_nodes(msh_reader *r) {
  return read_some_nodes(r, false);
}

static thrum_status read_parametric_nodes(msh_reader *r) {
  return read_some_nodes(r, true);
}

thrum_status thrum_msh_node_index(msh_reader *r, int64_t tag, int32_t *index) {
  int32_t found = -1;
  if (r->table) {
    found = tag >= 0 && tag < r->table_count ? r->table[tag] : -1;
  } else {
    msh_node key = {.tag = tag};
    const msh_node *node = NULL;
    if (r->node_count > 0)
      node = bsearch(&key, r->nodes, (size_t)r->node_count, sizeof key, compare_nodes);
    found = node ? (int32_t)(node - r->nodes) : -1;
  }
  if (found < 0)
    return thrum_text_fail(&r->text, THRUM_BAD_VALUE, r->error,
                           "the element names node %lld, which is not in $Nodes", (long long)tag);
  *index = found;
  return THRUM_OK;
}

/* Next word of the line, the tag of a node, as its index. */
static thrum_status read_node_index(msh_reader *r, int32_t *index) {
  int64_t tag = 0;
  thrum_status status = integer(r, "a node of the element", 1, &tag);
  return status < 0 ? status : thrum_msh_node_index(r, tag, index);
}

/* Dimension of an element type, -1 when it is unknown. */
int thrum_msh_type_dimension(int64_t type) {
  static const signed char dimensions[] = {-1, 1, 2, 2, 3, 3, 3, 3, 1, 2, 2, 3, 3, 3, 3, 0,
                                           2,  3, 3, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 3, 3, 3};
  return type >= 1 && type < (int64_t)sizeof dimensions ? dimensions[type] : -1;
}

thrum_status thrum_msh_check_type(msh_reader *r, int64_t type, int dimension) {
  if (type == MSH_TET || (dimension >= 0 && dimension < 3))
    return THRUM_OK;
  if (type == 11 || (type >= 29 && type <= 31))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "tetrahedra of higher order (type %lld) are not supported; mesh again "
                           "with: gmsh -3 -order 1",
                           (long long)type);
  return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                         "elements of type %lld are not supported; the body must be meshed with "
                         "tetrahedra (type 4) alone",
                         (long long)type);
}

thrum_status thrum_msh_add_tet(msh_reader *r, const int32_t tet[4], int64_t physical) {
  thrum_mesh *m = &r->mesh;
  int64_t t = m->tet_count;
  int32_t *tets = thrum_mesh_grow(m->tets, &r->tet_capacity, t + 1, 4 * sizeof *tets);
  m->tets = tets ? tets : m->tets;
  int64_t *lines = thrum_mesh_grow(m->tet_line, &r->line_capacity, t + 1, sizeof *lines);
  m->tet_line = lines ? lines : m->tet_line;
  int32_t *regions = thrum_mesh_grow(m->tet_region, &r->region_capacity, t + 1, sizeof *regions);
  m->tet_region = regions ? regions : m->tet_region;
  if (!tets || !lines || !regions)
    return no_memory(r);
  memcpy(tets + 4 * t, tet, 4 * sizeof *tet);
  lines[t] = r->text.line;
  regions[t] = (int32_t)physical;
  m->tet_count = t + 1;
  return THRUM_OK;
}

/* The nodes of one element, which is in these physical groups. */
static thrum_status read_element_nodes(msh_reader *r, int64_t type, const int32_t *physicals,
                                       int64_t physical_count) {
  int32_t nodes[4] = {0};
  int count = 0;
  thrum_status status = THRUM_OK;
  if (type == MSH_TET) {
    for (; count < 4 && status >= 0; count++)
      status = read_node_index(r, &nodes[count]);
    if (status >= 0)
      status = thrum_text_finish(&r->text, "the four nodes", r->error);
    if (status >= 0)
      status = thrum_msh_add_tet(r, nodes, physical_count > 0 ? physicals[0] : MSH_NO_PHYSICAL);
    for (int64_t p = 0; p < physical_count && status >= 0; p++)
      status = thrum_msh_add_to_physical(r, physicals[p], nodes, 4);
    return status;
  }
  // others only serve their groups
  while (physical_count > 0 && status >= 0 && thrum_text_more(&r->text)) {
    status = read_node_index(r, &nodes[0]);
    for (int64_t p = 0; p < physical_count && status >= 0; p++)
      status = thrum_msh_add_to_physical(r, physicals[p], nodes, 1);
  }
  return status;
}

/* `number type tag_count tags... nodes...`; the first tag is the physical group, 0 for none. */
static thrum_status read_element_2(msh_reader *r) {
  int64_t number = 0, type = 0, tags = 0, physical = 0, index = 0;
  thrum_status status = section_line(r, "the last element");
  if (status >= 0)
    status = integer(r, "the number of an element", 0, &number);
  if (status >= 0)
    status = integer(r, "the type of an element", 1, &type);
  if (status >= 0)
    status = thrum_msh_check_type(r, type, thrum_msh_type_dimension(type));
  if (status >= 0)
    status = integer(r, "the number of tags", 0, &tags);
  for (int64_t i = 0; i < tags && status >= 0; i++) {
    int64_t tag = 0;
    status = thrum_text_integer(&r->text, "a tag", -INT64_MAX, INT64_MAX, &tag, r->error);
    physical = i == 0 ? (tag < 0 ? -tag : tag) : physical;
  }
  if (status >= 0 && physical != 0)
    status = thrum_msh_find_physical(r, thrum_msh_type_dimension(type), physical, &index);
  if (status < 0)
    return status;
  int32_t list = (int32_t)index;
  return read_element_nodes(r, type, &list, physical != 0);
}

static thrum_status read_element_block(msh_reader *r, int64_t *items) {
  int64_t dimension = 0, type = 0, count = 0, number = 0, tag = 0;
  thrum_status status = section_line(r, "the last block of elements");
  if (status >= 0)
    status = thrum_text_integer(&r->text, "a dimension", 0, 3, &dimension, r->error);
  if (status >= 0)
    status = integer(r, "an entity", INT64_MIN, &tag);
  if (status >= 0)
    status = integer(r, "the type of the elements", 1, &type);
  if (status >= 0)
    status = integer(r, "the number of elements in the block", 0, &count);
  if (status >= 0)
    status = thrum_msh_check_type(r, type, (int)dimension);
  if (status < 0)
    return status;
  int64_t physical_count;
  const int32_t *physicals = thrum_msh_entity_physicals(r, (int)dimension, tag, &physical_count);
  for (int64_t i = 0; i < count && status >= 0; i++) {
    status = section_line(r, "the last element of the block");
    if (status >= 0)
      status = integer(r, "the number of an element", 0, &number);
    if (status >= 0)
      status = read_element_nodes(r, type, physicals, physical_count);
    *items += status >= 0;
  }
  return status;
}

static thrum_status read_elements(msh_reader *r) {
  if (r->has_elements || !r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Elements comes twice or before $Nodes");
  r->has_elements = true;
  if (r->binary)
    return thrum_msh_binary_elements(r);
  int64_t count = 0, blocks = 0, items = 0;
  thrum_status status;
  if (r->version == 2) {
    status = section_line(r, "the number of elements");
    if (status >= 0)
      status = integer(r, "the number of elements", 0, &count);
    for (int64_t i = 0; i < count && status >= 0; i++)
      status = read_element_2(r);
    return status;
  }
  status = read_block_header(r, &blocks, &count);
  for (int64_t b = 0; b < blocks && status >= 0; b++)
    status = read_element_block(r, &items);
  return status < 0 ? status : check_items(r, "elements", count, items);
}

/* Reads up to the line $EndNAME; right after a section that was read it must be the next one. */
static thrum_status end_section(msh_reader *r, const char *name, size_t length, bool skip) {
  while (thrum_text_next_line(&r->text)) {
    const char *line = r->text.start;
    if ((size_t)(r->text.end - line) == length + 4 && memcmp(line, "$End", 4) == 0 &&
        memcmp(line + 4, name, length) == 0)
      return THRUM_OK;
    if (!skip)
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                             "expected $End%s, found '%s'; is a count too small?",
                             thrum_text_excerpt(name, length).text,
                             thrum_text_excerpt(line, (size_t)(r->text.end - line)).text);
  }
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                         "the file ends before $End%s; is it cut short?",
                         thrum_text_excerpt(name, length).text);
}

static thrum_status read_section(msh_reader *r) {
  static const struct {
    const char *keyword;
    thrum_status (*read)(msh_reader *r);
  } sections[] = {{"$MeshFormat", read_format},
                  {"$PhysicalNames", read_physical_names},
                  {"$Entities", read_entities},
                  {"$Nodes", read_nodes},
                  {"$ParametricNodes", read_parametric_nodes},
                  {"$Elements", read_elements}};
  const char *start = r->text.start;
  size_t length = (size_t)(r->text.end - start);
  bool format = thrum_text_equals(start, length, "$MeshFormat");
  if (*start != '$' || length < 2 || (format == (r->version != 0)))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "expected %s, found '%s'; is it a Gmsh mesh of version 2.2 or 4.1?",
                           r->version ? "a section such as $Nodes" : "$MeshFormat",
                           thrum_text_excerpt(start, length).text);
  if (thrum_text_equals(start, length, "$PartitionedEntities"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "partitioned meshes are not supported; save it unpartitioned");
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (thrum_text_equals(start, length, sections[i].keyword)) {
      thrum_status status = sections[i].read(r);
      return status < 0 ? status : end_section(r, start + 1, length - 1, false);
    }
  return end_section(r, start + 1, length - 1, true);
}

/* Keeps the first of tets that come several times; their groups have all of them already. */
static thrum_status join_repeats(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  int64_t *earlier = thrum_mesh_tet_repeats(m), kept = 0;
  if (!earlier)
    return no_memory(r);
  for (int64_t t = 0; t < m->tet_count; t++) {
    if (earlier[t] >= 0)
      continue;
    memmove(m->tets + 4 * kept, m->tets + 4 * t, 4 * sizeof *m->tets);
    m->tet_line[kept] = m->tet_line[t];
    m->tet_region[kept++] = m->tet_region[t];
  }
  m->tet_count = kept;
  free(earlier);
  return THRUM_OK;
}

/* Regions: the physical volumes that tets are in, and one for tets in none. */
static thrum_status number_regions(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  int32_t *region = malloc((size_t)(r->physical_count + 1) * sizeof *region);
  if (!region)
    return no_memory(r);
  for (int64_t i = 0; i <= r->physical_count; i++)
    region[i] = -1;
  for (int64_t t = 0; t < m->tet_count; t++)
    region[m->tet_region[t] + 1] = 0;
  for (int64_t i = 0; i <= r->physical_count; i++)
    if (region[i] == 0)
      region[i] = (int32_t)m->region_count++;
  for (int64_t t = 0; t < m->tet_count; t++)
    m->tet_region[t] = region[m->tet_region[t] + 1];
  free(region);
  m->region_count = m->region_count > 0 ? m->region_count : 1;
  m->materials = calloc((size_t)m->region_count, sizeof *m->materials);
  return m->materials ? THRUM_OK : no_memory(r);
}

static thrum_status take_nodes(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  m->vertices = malloc(((size_t)r->node_count + 1) * 3 * sizeof *m->vertices);
  m->file_number = malloc(((size_t)r->node_count + 1) * sizeof *m->file_number);
  if (!m->vertices || !m->file_number)
    return no_memory(r);
  m->vertex_count = m->file_vertex_count = r->node_count;
  for (int64_t i = 0; i < r->node_count; i++) {
    memcpy(m->vertices + 3 * i, r->nodes[i].position, 3 * sizeof(double));
    m->file_number[i] = r->nodes[i].tag;
  }
  return THRUM_OK;
}

static thrum_status add_groups(msh_reader *r) {
  for (int64_t i = 0; i < r->physical_count; i++) {
    const msh_physical *p = &r->physicals[i];
    char made[64];
    snprintf(made, sizeof made, "physical_%d_%lld", p->dimension, (long long)p->tag);
    thrum_status status =
        thrum_mesh_add_group(&r->mesh, p->name ? p->name : made, p->vertices, p->count, r->error);
    if (status < 0)
      return status;
  }
  return THRUM_OK;
}

static thrum_status read_all(msh_reader *r) {
  thrum_status status = THRUM_OK;
  while (status >= 0 && thrum_text_next_line(&r->text))
    status = read_section(r);
  if (status >= 0 && (!r->has_nodes || !r->has_elements))
    status = thrum_text_fail(&r->text, THRUM_MISSING, r->error,
                             "there is no $%s section; is it a Gmsh mesh, and is it whole?",
                             !r->version    ? "MeshFormat"
                             : r->has_nodes ? "Elements"
                                            : "Nodes");
  if (status >= 0)
    status = join_repeats(r);
  if (status >= 0)
    status = number_regions(r);
  if (status >= 0)
    status = take_nodes(r);
  return status < 0 ? status : add_groups(r);
}

thrum_status thrum_mesh_parse_msh(const char *name, const void *data, size_t size, thrum_mesh *mesh,
                                  thrum_error *error) {
  msh_reader r = {.error = error};
  thrum_status status = thrum_text_view(name, data, size, 0, 0, &r.text, error);
  if (status < 0)
    return status;
  r.physicals = malloc(THRUM_MESH_GROUPS_MAX * sizeof *r.physicals);
  status = r.physicals ? read_all(&r) : no_memory(&r);
  for (int64_t i = 0; i < r.physical_count; i++) {
    free(r.physicals[i].name);
    free(r.physicals[i].vertices);
  }
  free(r.physicals);
  free(r.entities);
  free(r.entity_physicals);
  free(r.nodes);
  free(r.table);
  thrum_text_close(&r.text);
  if (status >= 0)
    *mesh = r.mesh;
  else
    thrum_mesh_free(&r.mesh);
  return status;
}
