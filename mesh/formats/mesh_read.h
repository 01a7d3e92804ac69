/* Reads meshes; mesh_read.c chooses the reader, and each reader is a file mesh_read_FORMAT.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_READ_H
#define THRUM_MESH_FORMATS_MESH_READ_H

#include <stdbool.h>
#include <stddef.h>

#include "mesh/mesh.h"
#include "platform/allocate.h"

/* Reads a mesh: the generator `beam:NXxNYxNZ@LXxLYxLZ[,hex | ,split=N][,parts=N]`, or a file by its
 * suffix: .veg (Vega), .msh (Gmsh), .node or .ele (TetGen), .mesh (Medit), .vtk and .vtu (VTK),
 * .inp (Abaqus). The beam fills [0,LX] x [-LY/2,LY/2] x [-LZ/2,LZ/2]; its groups are the faces left
 * (x = 0), right (x = LX), front and back (y = -LY/2, LY/2), bottom and top (z = -LZ/2, LZ/2), and
 * tip, the one, two or four vertices of the right face that are nearest to its centre. A file's
 * groups are the vertices of its element sets (.veg) and of its physical groups (.msh, named by
 * $PhysicalNames or else physical_DIMENSION_TAG); its regions are the *REGIONs and the physical
 * volumes. What they are in the other formats stands in docs/meshes.md and on top of each reader.
 * Every length, the generator's too, is multiplied by `scale`. The result is clean: inverted tets
 * are flipped, unreferenced vertices dropped (groups renumbered), both counted; zero-volume tets,
 * indices out of range, non-finite numbers, repeated tets, faces of three tets and neighbours that
 * overlap are refused with the file, the line and the element named (1-based, as in the file). On
 * failure *mesh is untouched. */
thrum_status thrum_mesh_read(const char *name, double scale, thrum_mesh *mesh, thrum_error *error);

enum { THRUM_ORDER_AUTO = -1 };

/* What becomes of hexahedra and wedges. */
typedef enum thrum_element_choice {
  THRUM_ELEMENT_AUTO,  /* they stay, thin ones as solid-shells; wedges of 6 nodes do not */
  THRUM_ELEMENT_TET,   /* they are cut into tetrahedra */
  THRUM_ELEMENT_SOLID, /* they stay, none is a solid-shell */
  THRUM_ELEMENT_SHELL, /* they stay, those of order 1 are solid-shells */
  THRUM_ELEMENT_FILE   /* they stay as for SOLID, for who writes them again: order 2 cuts them */
} thrum_element_choice;

/* How a mesh is to be read. */
typedef struct thrum_mesh_read_options {
  double scale;        /* above 0: lengths times this are metres, behind the unit */
  int order;           /* of the tets: 0, as the file has them, which who makes a model of them may
                          change, and THRUM_ORDER_AUTO, the same where a recipe says otherwise; 1,
                          linear, tets of ten nodes by their corners, which are counted; 2, of ten
                          nodes, linear ones with a node in the middle of each edge */
  const char *regions; /* of VTK files: the cell data that tells the regions; NULL: by the names
                          that programs give it */
  const char *unit;    /* of the file, such as "mm-t-s", see thrum_mesh_unit; NULL: SI */
  thrum_element_choice element; /* order 2 cuts them into tets of ten nodes */
  const char *tets_for; /* what takes tetrahedra alone, such as "parameters": where the element is
                           left open, all are cut, and a note says for what; NULL: nothing */
} thrum_mesh_read_options;

/* Do the options say in which unit the file is? */
static inline bool thrum_mesh_unit_is_said(const thrum_mesh_read_options *options) {
  return options->unit != NULL || options->scale != 1;
}

/* The same with options; `options` is not NULL. */
thrum_status thrum_mesh_read_with(const char *name, const thrum_mesh_read_options *options,
                                  thrum_mesh *mesh, thrum_error *error);

/* The same with the order alone, and hexahedra and wedges cut, as thrum_mesh_read cuts them. */
thrum_status thrum_mesh_read_order(const char *name, double scale, int order, thrum_mesh *mesh,
                                   thrum_error *error);

/* Refuses a mesh that was read so where elements were to stay, and it has none that can. */
thrum_status thrum_mesh_check_kept(const char *name, const thrum_mesh_read_options *options,
                                   const thrum_mesh *mesh, thrum_error *error);

/* Tells whether a name is that of a mesh by its suffix or as a generator, whether or not the file
 * exists. */
bool thrum_mesh_is_named(const char *name);

/* The bytes of a file. `name` is for messages and, for .veg, the path that *INCLUDE is relative
 * to; `regions` as among the options; `corners`: tets of higher order are read by their corners;
 * `solids`: hexahedra and wedges stay. */
typedef struct thrum_mesh_source {
  const char *name;
  const void *data;
  size_t size;
  const char *regions;
  bool corners, solids;
} thrum_mesh_source;

/* A reader makes a raw mesh, not yet clean. */
typedef thrum_status thrum_mesh_parser(const thrum_mesh_source *source, thrum_mesh *mesh,
                                       thrum_error *error);
thrum_mesh_parser thrum_mesh_parse_veg, thrum_mesh_parse_msh, thrum_mesh_parse_medit,
    thrum_mesh_parse_vtk, thrum_mesh_parse_vtu, thrum_mesh_parse_abaqus;
/* The name of one of TetGen's pair of files, of which `path` is one; NULL: no memory. */
char *thrum_tetgen_name(const char *path, const char *suffix, thrum_scope *scope);
/* Reads TetGen's pair of files. */
thrum_status thrum_mesh_parse_tetgen(const thrum_mesh_source *nodes,
                                     const thrum_mesh_source *elements, thrum_mesh *mesh,
                                     thrum_error *error);

#endif
