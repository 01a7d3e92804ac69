/* Vertices by where they are at rest: `x<0.01&z>0` (comparisons in metres joined by &; also <= and
 * >=), or `near:x,y,z` [m], the one vertex nearest to a point.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_VERTEX_PLACES_H
#define THRUM_MESH_VERTEX_PLACES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

/* Is the text meant as a place, and not as a name? */
bool thrum_vertex_places_meant(const char *text);

/* marks[v] = whether vertex v (vertices: vertex_count x 3) is at the place that `length` bytes of
 * text say; it may be none. With marks undefined, THRUM_BAD_FORMAT for a text that says no place,
 * THRUM_BAD_VALUE for a point further from all vertices than the diagonal of their box. */
thrum_status thrum_vertex_places_mark(const double *vertices, int64_t vertex_count,
                                      const char *text, size_t length, uint8_t *marks,
                                      thrum_error *error);

/* Refuses a text that names no vertex, and says how far the vertices extend. */
thrum_status thrum_vertex_places_none(const double *vertices, int64_t vertex_count,
                                      const char *text, thrum_error *error);

/* The vertices at a place, ascending, one at least: *list (*count), which the caller frees. On
 * failure, as of the two above, both are untouched. */
thrum_status thrum_vertex_places_list(const double *vertices, int64_t vertex_count,
                                      const char *text, int32_t **list, int64_t *count,
                                      thrum_error *error);

#endif
