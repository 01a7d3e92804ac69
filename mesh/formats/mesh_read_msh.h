/* The files of the Gmsh reader share its state and the functions by which nodes, physical groups
 * and tets are added to it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_READ_MSH_H
#define THRUM_MESH_FORMATS_MESH_READ_MSH_H

#include "io/text.h"
#include "mesh/mesh.h"

enum { MSH_TET = 4, MSH_NO_PHYSICAL = -1 };

typedef struct msh_physical {
  int dimension;
  int64_t tag;
  char *name; /* NULL: not named in the file */
  int64_t count, capacity;
  int32_t *vertices;
} msh_physical;

/* An entity of version 4, whose elements belong to its physical groups. */
typedef struct msh_entity {
  int dimension;
  int64_t tag;
  int64_t first, count; /* in entity_physicals */
} msh_entity;

typedef struct msh_node {
  int64_t tag, line;
  double position[3];
} msh_node;

typedef struct msh_reader {
  thrum_text text;
  int version;         /* 2 or 4; 0 before $MeshFormat */
  bool binary, little; /* bytes, lowest first, in $Entities, $Nodes and $Elements */
  bool has_entities, has_nodes, has_elements;
  int64_t physical_count;
  msh_physical *physicals; /* THRUM_MESH_GROUPS_MAX */
  int64_t last_physical;   /* found last */
  int64_t entity_count, entity_capacity;
  msh_entity *entities; /* by dimension and tag once read */
  int64_t entity_physical_count, entity_physical_capacity;
  int32_t *entity_physicals;
  int64_t node_count, node_capacity;
  msh_node *nodes; /* by tag once read */
  int64_t table_count;
  int32_t *table; /* node of a tag, -1 none; NULL when tags are too sparse for one */
  int64_t tet_capacity, line_capacity, region_capacity;
  thrum_mesh mesh; /* tet_region holds physicals until the end, NO_PHYSICAL for none */
  thrum_error *error;
} msh_reader;

/* These functions are shared by the sections in text. */
thrum_status thrum_msh_no_memory(msh_reader *r);
/* Moves to the next line of a section; its end, or that of the file, is refused. */
thrum_status thrum_msh_line(msh_reader *r, const char *what);
/* Goes on to the next line when the present one is used up. */
thrum_status thrum_msh_word(msh_reader *r, const char *what);
thrum_status thrum_msh_integer(msh_reader *r, const char *what, int64_t low, int64_t *value);
/* Reads the header of $Nodes and $Elements in version 4: blocks, items, least and greatest tag. */
thrum_status thrum_msh_block_header(msh_reader *r, int64_t *blocks, int64_t *items);
thrum_status thrum_msh_check_items(msh_reader *r, const char *what, int64_t items, int64_t found);
thrum_status thrum_msh_read_node(msh_reader *r, int32_t *index);

/* Read the sections of a file in ASCII; the names of physical groups are text in every file. */
thrum_status thrum_msh_physical_names(msh_reader *r);
thrum_status thrum_msh_text_entities(msh_reader *r);
thrum_status thrum_msh_text_nodes(msh_reader *r, bool parametric);
thrum_status thrum_msh_text_elements(msh_reader *r);

/* Finds the index of a physical group, which is added when it is new. */
thrum_status thrum_msh_find_physical(msh_reader *r, int dimension, int64_t tag, int64_t *index);
thrum_status thrum_msh_add_to_physical(msh_reader *r, int64_t index, const int32_t *vertices,
                                       int count);
/* Add an entity; the physical groups that it belongs to are added first, by their tags. */
thrum_status thrum_msh_add_entity_physical(msh_reader *r, int dimension, int64_t tag);
thrum_status thrum_msh_add_entity(msh_reader *r, const msh_entity *entity);
/* Sorts the entities once all are there. */
void thrum_msh_sort_entities(msh_reader *r);
/* Returns the *count physical groups of an entity; NULL and 0 when there are none. */
const int32_t *thrum_msh_entity_physicals(const msh_reader *r, int dimension, int64_t tag,
                                          int64_t *count);

/* Adds a node; returns NULL when there is no memory. */
msh_node *thrum_msh_add_node(msh_reader *r);
/* Orders the nodes by tag, refuses repeats, and makes the table unless the tags are too sparse. */
thrum_status thrum_msh_index_nodes(msh_reader *r);
thrum_status thrum_msh_node_index(msh_reader *r, int64_t tag, int32_t *index);

/* Returns the dimension of an element type, -1 when it is unknown. */
int thrum_msh_type_dimension(int64_t type);
/* Refuses solid elements other than tets. */
thrum_status thrum_msh_check_type(msh_reader *r, int64_t type, int dimension);
thrum_status thrum_msh_add_tet(msh_reader *r, const int32_t tet[4], int64_t physical);

/* Read the number that tells the order of the bytes, and the sections, of a binary file. */
thrum_status thrum_msh_binary_format(msh_reader *r);
thrum_status thrum_msh_binary_entities(msh_reader *r);
thrum_status thrum_msh_binary_nodes(msh_reader *r);
thrum_status thrum_msh_binary_elements(msh_reader *r);

#endif
