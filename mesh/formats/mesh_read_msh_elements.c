/* Reads $Elements of a Gmsh file in text; see mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "mesh/formats/mesh_read_msh.h"
#include "mesh/mesh_grow.h"

/* Returns the dimension of an element type, -1 when it is unknown. */
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

  // each array is stored at once, so that it is freed even if the next one cannot grow
  int32_t *tets = thrum_mesh_grow(m->tets, &r->tet_capacity, t + 1, 4 * sizeof *tets);
  m->tets = tets ? tets : m->tets;
  int64_t *lines = thrum_mesh_grow(m->tet_line, &r->line_capacity, t + 1, sizeof *lines);
  m->tet_line = lines ? lines : m->tet_line;
  int32_t *regions = thrum_mesh_grow(m->tet_region, &r->region_capacity, t + 1, sizeof *regions);
  m->tet_region = regions ? regions : m->tet_region;

  if (!tets || !lines || !regions)
    return thrum_msh_no_memory(r);

  // lines and regions go with the tets, for messages and materials
  memcpy(tets + 4 * t, tet, 4 * sizeof *tet);
  lines[t] = r->text.line;
  regions[t] = (int32_t)physical;
  m->tet_count = t + 1;
  return THRUM_OK;
}

/* Reads the nodes of an element and adds them to its physical groups. */
static thrum_status read_element_nodes(msh_reader *r, int64_t type, const int32_t *physicals,
                                       int64_t physical_count) {
  int32_t nodes[4] = {0};
  int count = 0;

  // a tet in several physical volumes belongs to the region of the first
  if (type == MSH_TET) {
    for (; count < 4; count++)
      THRUM_TRY(thrum_msh_read_node(r, &nodes[count]));
    THRUM_TRY(thrum_text_finish(&r->text, "the four nodes", r->error));
    THRUM_TRY(thrum_msh_add_tet(r, nodes, physical_count > 0 ? physicals[0] : MSH_NO_PHYSICAL));
    for (int64_t p = 0; p < physical_count; p++)
      THRUM_TRY(thrum_msh_add_to_physical(r, physicals[p], nodes, 4));
    return THRUM_OK;
  }

  // elements below dimension 3 matter only as members of groups
  while (physical_count > 0 && thrum_text_more(&r->text)) {
    THRUM_TRY(thrum_msh_read_node(r, &nodes[0]));
    for (int64_t p = 0; p < physical_count; p++)
      THRUM_TRY(thrum_msh_add_to_physical(r, physicals[p], nodes, 1));
  }
  return THRUM_OK;
}

/* Reads `number type tag_count tags... nodes...`; the first tag is the physical group, 0 for none.
 */
static thrum_status read_element_2(msh_reader *r) {
  int64_t number = 0, type = 0, tags = 0, physical = 0, index = 0;
  THRUM_TRY(thrum_msh_line(r, "the last element"));
  THRUM_TRY(thrum_msh_integer(r, "the number of an element", 0, &number));
  THRUM_TRY(thrum_msh_integer(r, "the type of an element", 1, &type));
  THRUM_TRY(thrum_msh_check_type(r, type, thrum_msh_type_dimension(type)));
  THRUM_TRY(thrum_msh_integer(r, "the number of tags", 0, &tags));

  // the first tag is the physical group; its sign is only an orientation
  for (int64_t i = 0; i < tags; i++) {
    int64_t tag = 0;
    THRUM_TRY(thrum_text_integer(&r->text, "a tag", -INT64_MAX, INT64_MAX, &tag, r->error));
    physical = i == 0 ? (tag < 0 ? -tag : tag) : physical;
  }

  // physical group 0 means none
  if (physical != 0)
    THRUM_TRY(thrum_msh_find_physical(r, thrum_msh_type_dimension(type), physical, &index));
  int32_t list = (int32_t)index;
  return read_element_nodes(r, type, &list, physical != 0);
}

static thrum_status read_element_block(msh_reader *r, int64_t *items) {
  int64_t dimension = 0, type = 0, count = 0, number = 0, tag = 0;
  THRUM_TRY(thrum_msh_line(r, "the last block of elements"));
  THRUM_TRY(thrum_text_integer(&r->text, "a dimension", 0, 3, &dimension, r->error));
  THRUM_TRY(thrum_msh_integer(r, "an entity", INT64_MIN, &tag));
  THRUM_TRY(thrum_msh_integer(r, "the type of the elements", 1, &type));
  THRUM_TRY(thrum_msh_integer(r, "the number of elements in the block", 0, &count));
  THRUM_TRY(thrum_msh_check_type(r, type, (int)dimension));

  // the elements of a block lie in the physical groups of its entity
  int64_t physical_count;
  const int32_t *physicals = thrum_msh_entity_physicals(r, (int)dimension, tag, &physical_count);

  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(thrum_msh_line(r, "the last element of the block"));
    THRUM_TRY(thrum_msh_integer(r, "the number of an element", 0, &number));
    THRUM_TRY(read_element_nodes(r, type, physicals, physical_count));
    ++*items;
  }
  return THRUM_OK;
}

thrum_status thrum_msh_text_elements(msh_reader *r) {
  int64_t count = 0, blocks = 0, items = 0;

  // version 2 has one list of all elements
  if (r->version == 2) {
    THRUM_TRY(thrum_msh_line(r, "the number of elements"));
    THRUM_TRY(thrum_msh_integer(r, "the number of elements", 0, &count));
    for (int64_t i = 0; i < count; i++)
      THRUM_TRY(read_element_2(r));
    return THRUM_OK;
  }

  // version 4: blocks of elements of one entity and one type
  THRUM_TRY(thrum_msh_block_header(r, &blocks, &count));
  for (int64_t b = 0; b < blocks; b++)
    THRUM_TRY(read_element_block(r, &items));
  return thrum_msh_check_items(r, "elements", count, items);
}
