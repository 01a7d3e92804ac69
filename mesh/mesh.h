/* Tetrahedral meshes with materials and named vertex groups, as the readers produce them and the
 * rest of precompute consumes them.
 *
 * A mesh is one struct of owned arrays; thrum_mesh_free releases it. The readers leave lengths as
 * they are in the file, thrum_mesh_clean (mesh_clean.h) turns them into metres; thrum_mesh_read
 * (formats/mesh_read.h) does both.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_H
#define THRUM_MESH_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/material/material_law.h"
#include "thrum/status.h"

typedef struct thrum_material {
  double young;   /* E [Pa] */
  double poisson; /* nu */
  double density; /* rho [kg/m^3] */
} thrum_material;

/* The law of a region, and the elastic strain beyond which it flows; 0: it has none of its own. */
typedef struct thrum_region_law {
  thrum_law law; /* not THRUM_LAW_BY_REGION */
  double yield;
} thrum_region_law;

typedef struct thrum_group {
  char *name;
  int64_t count;
  int32_t *vertices; /* 0-based, ascending, no duplicates */
} thrum_group;

/* A line that tells the user what a reader has done, such as how many elements it cut. */
typedef struct thrum_mesh_note {
  char text[240];
} thrum_mesh_note;

typedef struct thrum_mesh {
  int64_t vertex_count;
  double *vertices; /* vertex_count x 3 */
  int64_t tet_count;
  int32_t *tets;         /* tet_count x 4, 0-based */
  int32_t *midsides;     /* tet_count x 6: the middle nodes of ten-node tets, in the order of
                            thrum_quadratic_edges; NULL: linear tets */
  int64_t made_midsides; /* the last vertices: middle nodes that are not in the file */
  int32_t *tet_region;   /* tet_count, 0-based */
  /* Elements that strain as what they are, and not as the tets that they are cut into, which then
   * are their shape alone. All tets belong to one, one after the other. */
  int64_t solid_count;     /* 0: the tets are the elements */
  uint8_t *solid_form;     /* solid_count, thrum_solid_form */
  int32_t *solid_ends;     /* solid_count: the end of its nodes in solid_nodes */
  int32_t *solid_nodes;    /* in the order of Abaqus and VTK */
  int32_t *solid_tet_ends; /* solid_count: the end of its tets */
  int64_t region_count;
  thrum_material *materials; /* region_count */
  thrum_region_law *laws;    /* region_count; NULL: one law, which is not the mesh's to say */
  int64_t elastic_count;     /* layers of regions whose elasticity has directions */
  double *elastic;           /* elastic_count x THRUM_ELASTIC_NUMBERS, elastic.h; NULL: none */
  char **region_names;       /* region_count, NULL where the file has none; NULL: it has none */
  double
      *springs;  /* vertex_count x 3: stiffness to the ground along x, y and z [N/m]; NULL: none */
  double *about; /* vertex_count x 3: the state about which a model is made, a displacement from
                    `vertices`, where nothing is stressed; of solids; NULL: that [m] */
  bool has_material; /* the file (or generator) said what it is made of; else all zero */
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
  int64_t *tet_number;   /* tet_count: the number of its element in the file; NULL: from 1 */
  int64_t cut_elements;  /* hexahedra, wedges and pyramids that were cut into tets */
  int64_t cornered_tets; /* tets of higher order that were read by their four corners */
  int64_t note_count;
  int64_t cut_note; /* the note that says what was cut, from 1; 0: there is none */
  thrum_mesh_note *notes;
} thrum_mesh;

void thrum_mesh_free(thrum_mesh *mesh); /* leaves it empty; an empty (zeroed) mesh is fine */

/* The tets are the elements from now on. */
void thrum_mesh_drop_solids(thrum_mesh *mesh);

/* The nodes of solid s, and the first of its tets. */
static inline int32_t *thrum_mesh_solid_at(const thrum_mesh *mesh, int64_t s) {
  return mesh->solid_nodes + (s > 0 ? mesh->solid_ends[s - 1] : 0);
}
static inline int64_t thrum_mesh_solid_tet(const thrum_mesh *mesh, int64_t s) {
  return s > 0 ? mesh->solid_tet_ends[s - 1] : 0;
}

/* The nodes of all solids. */
static inline int64_t thrum_mesh_solid_nodes(const thrum_mesh *mesh) {
  return mesh->solid_count > 0 ? mesh->solid_ends[mesh->solid_count - 1] : 0;
}

/* The end of a reader: hands `read` over to *mesh, or frees it where `status` is a failure, and
 * *mesh is untouched then. Returns `status`. */
thrum_status thrum_mesh_deliver(thrum_status status, thrum_mesh *read, thrum_mesh *mesh);

/* Adds a note and returns its number, from 1; 0: there was no memory for it. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int64_t
thrum_mesh_add_note(thrum_mesh *mesh, const char *format, ...);

/* The number that the file gives to its vertex v, before any was dropped. */
int64_t thrum_mesh_number(const thrum_mesh *mesh, int64_t v);

/* The vertex to which the file gives a number; -1: there is none, or it was dropped. */
int64_t thrum_mesh_vertex_of(const thrum_mesh *mesh, int64_t number);

/* How messages call tet `t`: "tet 7", or "element 7" where elements were cut, by the number in the
 * file. */
typedef struct thrum_tet_text {
  char text[40];
} thrum_tet_text;
thrum_tet_text thrum_mesh_tet_text(const thrum_mesh *mesh, int64_t t);

/* 64-bit FNV-1a over vertices, tets, regions, and middle nodes where there are any: identifies the
 * mesh in a model's meta. Solids count where there are any. */
uint64_t thrum_mesh_hash(const thrum_mesh *mesh);

/* The nodes of tet `t`, corners first, as thrum_quadratic_edges orders them; returns how many, 4 or
 * 10. */
int thrum_mesh_nodes(const thrum_mesh *mesh, int64_t t, int32_t nodes[10]);

/* The middle node between two corners of tet `t` of a mesh of ten-node tets; -1 where they are not
 * corners of it. */
int32_t thrum_mesh_middle_node(const thrum_mesh *mesh, int64_t t, int32_t from, int32_t to);

/* Volume of tet `t` (signed) [m^3]. */
double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t);

#endif
