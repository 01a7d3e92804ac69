/* The files of the Gmsh reader share its state, and the lines and numbers of a section, which are
 * text or bytes. Whoever reads a number says how many bytes it has in a binary file and what it is,
 * for messages; in text it is the next word.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_READ_MSH_H
#define THRUM_MESH_FORMATS_MESH_READ_MSH_H

#include "io/text.h"
#include "mesh/mesh_builder.h"

enum { MSH_NO_PHYSICAL = -1, MSH_NODES_MAX = 27 };

typedef struct msh_physical {
  int dimension;
  int64_t tag;
  bool named;   /* in the file */
  int64_t list; /* of the builder */
} msh_physical;

/* An entity of version 4, whose elements belong to its physical groups. */
typedef struct msh_entity {
  int dimension;
  int64_t tag;
  int64_t first, count; /* in entity_physicals */
} msh_entity;

typedef struct msh_reader {
  thrum_text text;
  int version;         /* 2 or 4; 0 before $MeshFormat */
  bool binary, little; /* bytes, lowest first, in $Entities, $Nodes and $Elements */
  bool has_entities, has_nodes, has_elements;
  int64_t physical_count;
  msh_physical *physicals;
  int64_t last_physical; /* found last */
  int64_t entity_count;
  msh_entity *entities; /* by dimension and tag once read */
  int64_t entity_physical_count;
  int64_t *entity_physicals;
  thrum_mesh_builder builder; /* a tet's key is its first physical volume, or NO_PHYSICAL */
} msh_reader;

/* Refuses binary data, which has no lines: the message names the line in front of it. */
thrum_status thrum_msh_bad_bytes(msh_reader *r, const char *what);
/* Moves to the next line of a section; its end, or that of the file, is refused. thrum_msh_line
 * does nothing in binary data, which has no lines. */
thrum_status thrum_msh_text_line(msh_reader *r, const char *what);
thrum_status thrum_msh_line(msh_reader *r, const char *what);
/* A line with one number, which is text in binary files too. */
thrum_status thrum_msh_count(msh_reader *r, const char *what, int64_t *count);
/* Reads a whole number of 4 bytes or of 8, within [low, high]. */
thrum_status thrum_msh_whole(msh_reader *r, const char *what, int size, int64_t low, int64_t high,
                             int64_t *value);
thrum_status thrum_msh_real(msh_reader *r, const char *what, double *value);
/* Reads the number 1 behind the header of a binary file, which tells the order of the bytes. */
thrum_status thrum_msh_byte_order(msh_reader *r);

/* Finds the index of a physical group, which is added when it is new. */
thrum_status thrum_msh_find_physical(msh_reader *r, int dimension, int64_t tag, int64_t *index);
/* Returns the *count physical groups of an entity; NULL and 0 when there are none. */
const int64_t *thrum_msh_entity_physicals(const msh_reader *r, int dimension, int64_t tag,
                                          int64_t *count);

/* Read the sections. */
thrum_status thrum_msh_physical_names(msh_reader *r);
thrum_status thrum_msh_entities(msh_reader *r);
thrum_status thrum_msh_nodes(msh_reader *r, bool parametric);
thrum_status thrum_msh_elements(msh_reader *r);

/* Where Gmsh has the middle nodes of each kind, in the order that elements have here. */
extern const signed char thrum_msh_middles[THRUM_SOLID_KINDS][12];

#endif
