/* Reads triangle surfaces; surface_read.c chooses the reader, and each reader is a file
 * surface_read_FORMAT.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_SURFACE_READ_H
#define THRUM_MESH_FORMATS_SURFACE_READ_H

#include <stdbool.h>
#include <stddef.h>

#include "mesh/surface_mesh.h"

/* Reads a surface by its suffix, .obj (Wavefront) or .stl (ASCII and binary); lengths are
 * multiplied by `scale`. An .obj keeps all its vertices and their order, used or not, so that what
 * is made of them plays on the file itself; its texture coordinates, normals, groups and materials
 * are passed over. Corners of an .stl at just the same place become one vertex, in the order in
 * which they come. Triangles are kept as they are, flat ones too. Numbers that are not finite,
 * indices out of range and statements of curved surfaces are refused with the file and the line. On
 * failure *surface is untouched. */
thrum_status thrum_surface_mesh_read(const char *path, double scale, thrum_surface_mesh *surface,
                                     thrum_error *error);
/* Tells whether a name is that of a surface by its suffix, whether or not the file exists. */
bool thrum_surface_mesh_is_named(const char *name);

/* A reader makes a surface from the bytes of a file; `name` is for messages. On
 * failure *surface is untouched. */
typedef thrum_status thrum_surface_parser(const char *name, const void *data, size_t size,
                                          thrum_surface_mesh *surface, thrum_error *error);
thrum_surface_parser thrum_surface_parse_obj, thrum_surface_parse_stl;

#endif
