/* The mesh writers share the file being written and the names of groups and regions.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_OUT_H
#define THRUM_MESH_FORMATS_MESH_OUT_H

#include "io/file.h"
#include "mesh/mesh.h"

typedef struct thrum_mesh_write_options {
  bool binary;     /* .msh, .vtk; a .vtu is binary unless `ascii` */
  bool ascii;      /* .vtu: numbers as text */
  int msh_version; /* .msh: 41 (also 0) or 22 */
} thrum_mesh_write_options;

/* Counts of the parts of a mesh that the format has no place for. */
typedef struct thrum_mesh_lost {
  int64_t groups;    /* left out */
  int64_t names;     /* of groups that are there, under a number or a changed name */
  int64_t materials; /* left out */
  int64_t regions;   /* joined with others */
  int64_t directed;  /* materials with directions, of which the isotropic mean is there */
} thrum_mesh_lost;

/* A file being written; after a failure everything further is passed over. */
typedef struct thrum_mesh_out {
  thrum_file_writer file;
  thrum_status status;
  thrum_error *error;
  bool binary; /* numbers are bytes, in formats that have both */
  size_t used;
  char buffer[1 << 14];
} thrum_mesh_out;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void thrum_out_text(thrum_mesh_out *out, const char *format, ...); /* at most 1000 bytes */
/* Hands the buffer to the file. */
void thrum_out_flush(thrum_mesh_out *out);
void thrum_out_bytes(thrum_mesh_out *out, const void *bytes, size_t size);
/* Writes the shortest text of 15 to 17 digits that reads back as the same double in every locale.
 */
void thrum_out_number(thrum_mesh_out *out, double value);
/* Writes three numbers with `separator` between them. */
void thrum_out_vertex(thrum_mesh_out *out, const double position[3], const char *separator);

/* The mesh that a writer writes. `region_group` is the group that has exactly a region's
 * vertices, -1 for none; `group_region` is the region of such a group. */
typedef struct thrum_mesh_written {
  const thrum_mesh *mesh;
  thrum_mesh_write_options options;
  int64_t *region_group; /* region_count */
  int64_t *group_region; /* group_count */
  thrum_mesh_lost lost;
} thrum_mesh_written;

/* Return the name of a group or a region with the characters of `bad` replaced by '_' and counted
 * in w->lost.names. The result is `text`. */
const char *thrum_write_group_name(thrum_mesh_written *w, int64_t group, const char *bad,
                                   char text[256]);
const char *thrum_write_region_name(thrum_mesh_written *w, int64_t region, const char *bad,
                                    char text[256]);

/* Room for what a writer needs, zeroed, which the caller frees; where there is none, the output has
 * failed. */
bool thrum_out_reserve(thrum_mesh_out *out, void *memory, int64_t count, size_t size);

/* Marks the vertices of a group with 1 among the vertex_count `marks`, and the others with 0. */
void thrum_write_mark_group(const thrum_mesh *mesh, int64_t group, uint8_t *marks);

/* Writes a number of a list, ten to a line; `column`: 0 at first. Then ends the list. */
void thrum_out_member(thrum_mesh_out *out, int64_t number, int *column);
void thrum_out_end_members(thrum_mesh_out *out, int column);
/* Writes such a list of the elements of a region. */
void thrum_out_region_elements(thrum_mesh_out *out, const thrum_mesh *mesh, int64_t region);

/* Returns the number of each vertex's group, from 1, 0 for none, for formats that have one number
 * for each vertex. Groups that overlap earlier ones are lost, and groups that stand for regions
 * have no number here. The caller frees the result; it is NULL when there is no memory, and then
 * the output has failed. */
int32_t *thrum_write_marks(thrum_mesh_out *out, thrum_mesh_written *w);

#endif
