/* The programs that fill a closed surface with tetrahedra: Gmsh and TetGen, where they are
 * installed. They are run as programs of their own, never linked.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_MESH_TOOL_H
#define THRUM_APP_MESH_TOOL_H

#include "mesh/mesh.h"
#include "mesh/surface_mesh.h"

typedef enum mesh_tool { MESH_TOOL_NONE = -1, MESH_TOOL_GMSH, MESH_TOOL_TETGEN } mesh_tool;
extern const char *const mesh_tool_names[]; /* names, ended by NULL */

/* The one that is wanted, or, of MESH_TOOL_NONE, the better one of those installed: Gmsh, but
 * TetGen for a surface of several shells (docs/meshes.md). Refuses, and says how to get it, when it
 * is not there. */
thrum_status mesh_tool_choose(mesh_tool wanted, int64_t shells, mesh_tool *tool,
                              thrum_error *error);

/* A surface to be meshed, and how. */
typedef struct mesh_tool_job {
  const char *path; /* of the surface, for messages */
  mesh_tool tool;
  double size;   /* longest edges inside, about [m]; 0: as the surface has them */
  bool cavities; /* shells that go round the other way stay empty (TetGen) */
  bool verbose;  /* show all that the tool says */
} mesh_tool_job;

/* Meshes a surface whose triangles all stay as they are. What the tool finds wrong becomes one
 * line: THRUM_BAD_VALUE, with the lines of the file, where triangles cross; THRUM_UNSUPPORTED where
 * the tool fails, and another may not. */
thrum_status mesh_tool_run(const mesh_tool_job *job, const thrum_surface_mesh *surface,
                           thrum_mesh *mesh, thrum_error *error);

/* Is a name that of a geometry by its suffix: .step, .stp, .iges, .igs, .brep? */
bool mesh_tool_is_geometry(const char *path);

/* Meshes a geometry by Gmsh's OpenCASCADE, into metres by the unit that the file names. Each face
 * is the group face_N. Edges are as long as `size` at most, where it is above 0, and a sixteenth of
 * a circle. With order 2 middle nodes lie on the geometry; where elements would turn inside out by
 * that, *straight says that all are in the middle of their edges. */
thrum_status mesh_tool_geometry(const mesh_tool_job *job, int order, thrum_mesh *mesh,
                                bool *straight, thrum_error *error);

#endif
