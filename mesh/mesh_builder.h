/* Building a mesh from numbered vertices, solid elements that name them, and named lists of them:
 * what all readers share. Elements that are no tets are cut into tets of their order (solids.h).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_BUILDER_H
#define THRUM_MESH_MESH_BUILDER_H

#include "mesh/mesh.h"
#include "mesh/solids.h"

/* A solid element of a file. */
typedef struct thrum_element {
  thrum_solid kind;
  bool quadratic;       /* middle nodes follow its corners */
  const int64_t *nodes; /* their numbers, at least 0 */
  int64_t number;       /* its own; 0: elements are counted from 1 */
  int64_t key;          /* what tells its region */
  int64_t line;         /* in the file, 0 unknown */
} thrum_element;

/* A middle node that a cut makes on a diagonal of an element. */
typedef struct thrum_diagonal {
  int64_t ends[2]; /* numbers, ascending */
  int64_t nodes;   /* those of the element, a place in `cut_nodes` */
  int8_t kind, face;
  int32_t place; /* of the one node of all elements at the diagonal, from 0; set by finish */
} thrum_diagonal;

/* An element that was cut. */
typedef struct thrum_cut {
  int64_t nodes; /* a place in `cut_nodes` */
  int64_t tet;   /* the first of its tets */
  int8_t kind, tets;
} thrum_cut;

/* An element that is kept until all are known. */
typedef struct thrum_kept_element {
  thrum_solid kind;
  bool quadratic, cornered; /* with its middle nodes; without those that it has in the file */
  int64_t nodes;            /* a place in `kept_nodes` */
  int64_t number, key, line;
} thrum_kept_element;

typedef struct thrum_named_list {
  char *name; /* owned */
  int64_t count;
  int64_t *numbers; /* of vertices, any order, repeats allowed */
} thrum_named_list;

/* Zeroed to begin with; released by thrum_builder_free. Vertices and keys are the file's numbers
 * until thrum_builder_finish. */
typedef struct thrum_mesh_builder {
  int64_t vertex_count;
  double *positions;     /* vertex_count x 3 */
  int64_t *numbers;      /* vertex_count */
  int64_t *vertex_lines; /* vertex_count: in the file, 0 unknown */
  int64_t tet_count;
  int64_t *tets;        /* tet_count x 4 */
  int64_t *middles;     /* tet_count x 6 where the first tet has ten nodes; -1 - d: of diagonal d */
  int64_t odd_tet;      /* the first whose number of nodes is not that of tet 0; 0: none */
  int64_t *keys;        /* tet_count: what tells its region */
  int64_t *lines;       /* tet_count: in the file, 0 unknown */
  int64_t *tet_numbers; /* tet_count: of the elements */
  int64_t element_count;
  int64_t flat_number, flat_line; /* of the first element whose corners leave no volume; 0: none */
  int64_t cut_elements[THRUM_SOLID_KINDS], cut_tets; /* elements of each kind that were cut */
  int64_t diagonal_count;
  thrum_diagonal *diagonals;
  int64_t cut_node_count;
  int64_t *cut_nodes; /* the nodes of elements that were cut */
  int64_t cut_count;
  thrum_cut *cuts;          /* in the order of their tets */
  int64_t centred_elements; /* that were cut around their centres */
  double cut_change;        /* of the volume of all elements that were cut, as a share */
  int64_t list_count;
  thrum_named_list *lists;
  int64_t last_list;    /* found last */
  int64_t *region_keys; /* of each region, ascending; made by finish */
  bool joins_repeats;   /* of tets that come again the first is kept */
  bool corners;         /* elements of order 2 are taken by their corners, and counted */
  int64_t cornered_tets;
  bool keep_solids; /* hexahedra and wedges become solids of the mesh, where finish can keep them */
  int64_t kept_count, kept_node_count;
  thrum_kept_element *kept; /* all elements, in their order */
  int64_t *kept_nodes;
  int64_t *tet_solids; /* tet_count: the kept element of each, where there are solids; else NULL */
  thrum_error *error;
} thrum_mesh_builder;

thrum_status thrum_builder_vertex(thrum_mesh_builder *b, int64_t number, const double position[3],
                                  int64_t line);
thrum_status thrum_builder_tet(thrum_mesh_builder *b, const int64_t vertices[4], int64_t key,
                               int64_t line);
/* The same of an element of any kind and order; its tets are the last ones. All tets of a file must
 * have as many nodes, which finish checks. */
thrum_status thrum_builder_element(thrum_mesh_builder *b, const thrum_element *element);
/* The tets of a kept element, which becomes a solid. */
thrum_status thrum_builder_solid(thrum_mesh_builder *b, int64_t place);
/* Index of the list of that name, added when it is new; the name must be a good one. */
thrum_status thrum_builder_list(thrum_mesh_builder *b, const char *name, size_t length,
                                int64_t *index);
/* Gives a list another name, of `length` bytes; lists of one name become one group. */
thrum_status thrum_builder_rename(thrum_mesh_builder *b, int64_t list, const char *name,
                                  size_t length);
thrum_status thrum_builder_add(thrum_mesh_builder *b, int64_t list, int64_t vertex);
/* Adds vertices to the list PREFIX_NUMBER. */
thrum_status thrum_builder_mark(thrum_mesh_builder *b, const char *prefix, int64_t number,
                                const int64_t *vertices, int count);

/* Orders the vertices by number, once all are there; a number that comes twice is refused. `name`
 * is the file's. */
thrum_status thrum_builder_order(thrum_mesh_builder *b, const char *name);
/* After that: the index of a vertex; -1 when it is not in the file. */
int64_t thrum_builder_find(const thrum_mesh_builder *b, int64_t number);

/* Orders the vertices by number, looks up what tets and lists name, makes a region of each key
 * (ascending, without materials) and a group of each list, and notes which elements were cut.
 * `name` is the file's. Into an empty mesh, which the caller frees on failure. */
thrum_status thrum_builder_finish(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh);

/* After finish: the region of a key of an element. */
int64_t thrum_builder_region(const thrum_mesh_builder *b, const thrum_mesh *mesh, int64_t key);

/* After finish: calls each region by its key. */
thrum_status thrum_builder_name_regions(const thrum_mesh_builder *b, thrum_mesh *mesh);

/* After finish: where there are several regions, the vertices of each become the group PREFIX_KEY,
 * but those of the key 0 only if `zero`. */
thrum_status thrum_builder_region_groups(const thrum_mesh_builder *b, const char *prefix, bool zero,
                                         thrum_mesh *mesh);

/* ":LINE" behind the name of a file in a message; nothing where the line is 0, which is unknown. */
const char *thrum_builder_place(int64_t line, char text[32]);

void thrum_builder_free(thrum_mesh_builder *b);

#endif
