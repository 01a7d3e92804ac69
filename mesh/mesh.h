/* Tetrahedral meshes with materials and named vertex groups, as the readers produce them and the
 * rest of precompute consumes them.
 *
 * A mesh is one struct of owned arrays; thrum_mesh_free releases it. The readers leave lengths as
 * they are in the file, thrum_mesh_clean turns them into metres; thrum_mesh_read does both.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_H
#define THRUM_MESH_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

typedef struct thrum_material {
  double young;   /* E [Pa] */
  double poisson; /* nu */
  double density; /* rho [kg/m^3] */
} thrum_material;

typedef struct thrum_group {
  char *name;
  int64_t count;
  int32_t *vertices; /* 0-based, ascending, no duplicates */
} thrum_group;

typedef struct thrum_mesh {
  int64_t vertex_count;
  double *vertices; /* vertex_count x 3 */
  int64_t tet_count;
  int32_t *tets;       /* tet_count x 4, 0-based */
  int32_t *tet_region; /* tet_count, 0-based */
  int64_t region_count;
  thrum_material *materials; /* region_count */
  bool has_material;         /* the file (or generator) said what it is made of; else all zero */
  int64_t group_count;
  thrum_group *groups;
  /* what cleaning changed, for the counted warnings */
  int64_t flipped_tets;
  int64_t dropped_vertices;
  int64_t file_vertex_count; /* before dropping */
  int32_t *file_vertex;  /* file_vertex_count: 0-based vertex here, -1 dropped; NULL: identity */
  int64_t *file_number;  /* file_vertex_count, ascending: the number that the file gives each
                            vertex (Gmsh's node tags); NULL: 1 to file_vertex_count */
  int64_t *tet_line;     /* tet_count: line of each tet in the file, 0 unknown; NULL: unknown */
  int64_t cornered_tets; /* tets of higher order that were read by their four corners */
} thrum_mesh;

/* Reads a mesh: the generator `beam:NXxNYxNZ@LXxLYxLZ`, or a file by its suffix: .veg (Vega),
 * .msh (Gmsh), .node or .ele (TetGen), .mesh (Medit), .vtk and .vtu (VTK), .inp (Abaqus).
 * The beam fills [0,LX] x [-LY/2,LY/2] x [-LZ/2,LZ/2]; its groups are the faces left (x = 0), right
 * (x = LX), front and back (y = -LY/2, LY/2), bottom and top (z = -LZ/2, LZ/2), and tip, the one,
 * two or four vertices of the right face that are nearest to its centre. A file's groups are the
 * vertices of its element sets (.veg) and of its physical groups (.msh, named by $PhysicalNames or
 * else physical_DIMENSION_TAG); its regions are the *REGIONs and the physical volumes. What they
 * are in the other formats stands in docs/meshes.md and on top of each reader. Every length, the
 * generator's too, is multiplied by `scale`. The result is clean: inverted tets are flipped,
 * unreferenced vertices dropped (groups renumbered), both counted; zero-volume tets, indices out of
 * range, non-finite numbers, repeated tets, faces of three tets and neighbours that overlap are
 * refused with the file, the line and the element named (1-based, as in the file). On failure *mesh
 * is untouched. */
thrum_status thrum_mesh_read(const char *name, double scale, thrum_mesh *mesh, thrum_error *error);
/* The name is that of a mesh by its ending or as a generator, whether or not it is there. */
bool thrum_mesh_is_named(const char *name);

/* The readers behind it, one file each: raw meshes, not yet clean, from the bytes of a file. `name`
 * is for messages and, for .veg, the place that *INCLUDE is relative to. */
typedef thrum_status thrum_mesh_parser(const char *name, const void *data, size_t size,
                                       thrum_mesh *mesh, thrum_error *error);
thrum_mesh_parser thrum_mesh_parse_veg, thrum_mesh_parse_msh, thrum_mesh_parse_medit,
    thrum_mesh_parse_vtk, thrum_mesh_parse_vtu, thrum_mesh_parse_abaqus;
/* TetGen's pair; `elements_name` is the .ele file's. */
thrum_status thrum_mesh_parse_tetgen(const char *name, const void *nodes, size_t nodes_size,
                                     const char *elements_name, const void *elements,
                                     size_t elements_size, thrum_mesh *mesh, thrum_error *error);
/* The generator. */
thrum_status thrum_mesh_beam(const char *spec, thrum_mesh *mesh, thrum_error *error);

/* Scales, checks and cleans in place, as described at thrum_mesh_read. `name` is for messages. On
 * failure the mesh may be half cleaned and is only good for thrum_mesh_free. */
thrum_status thrum_mesh_clean(thrum_mesh *mesh, const char *name, double scale, thrum_error *error);

void thrum_mesh_free(thrum_mesh *mesh); /* leaves it empty; an empty (zeroed) mesh is fine */

/* Adds to `fixed` (vertex_count bytes, bits 0..2 = x, y, z held) what `spec` names:
 * with < or > a predicate in metres such as `x<0.01&z>0` (& joins; also <= and >=); else an
 * existing file, a list of 1-based vertices (commas, spaces, newlines, a:b ranges, # comments;
 * numbered as in the mesh file, so dropped vertices are looked up through the map kept by clean);
 * else a group of the mesh. A suffix `:xyz`, `:z`, ... picks components, default all.
 * *count gets how many vertices it named; naming none is refused. On failure nothing is changed. */
thrum_status thrum_mesh_fix(const thrum_mesh *mesh, const char *spec, uint8_t *fixed,
                            int64_t *count, thrum_error *error);

/* 64-bit FNV-1a over vertices, tets, regions: identifies the mesh in a model's meta. */
uint64_t thrum_mesh_hash(const thrum_mesh *mesh);

/* Volume of tet `t` (signed) [m^3]. */
double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t);

#endif
