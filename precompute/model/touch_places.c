/* Places over the surface, by farthest-point sampling (Gonzalez 1985,
 * doi:10.1016/0304-3975(85)90224-5), and their patches, found along the edges of the surface, so
 * that none reaches over to another limb. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/touch_places.h"

#include <math.h>
#include <stdlib.h>

#include "core/base/vec3.h"
#include "mesh/mesh_faces.h"
#include "platform/allocate.h"

typedef struct surface {
  const double *points; /* of all vertices, x 3 */
  int64_t count;        /* of vertices that may be pulled at */
  int32_t *vertex;      /* count */
  int32_t *index;       /* of every vertex among them, -1: none */
  int64_t *begin;       /* count + 1, into the next */
  int32_t *neighbour;   /* indices; an edge is there once a triangle */
  int32_t *queue;       /* count, of a patch that is being found */
  int32_t *seen;        /* count: the last patch that took it, from 1 */
  double *away;         /* count: squared distance from the places so far */
  thrum_scope memory;
} surface;

static double distance2(const surface *s, int64_t a, int64_t b) {
  double between[3];
  for (int c = 0; c < 3; c++)
    between[c] = s->points[3 * s->vertex[a] + c] - s->points[3 * s->vertex[b] + c];
  return thrum_dot3(between, between);
}

static bool is_held(const thrum_fem *fem, int64_t vertex) {
  return fem->dof[3 * vertex] < 0 || fem->dof[3 * vertex + 1] < 0 || fem->dof[3 * vertex + 2] < 0;
}

/* Numbers the free corners of the surface. */
static thrum_status find_vertices(surface *s, const thrum_mesh_faces *faces, const thrum_fem *fem,
                                  thrum_error *error) {
  s->index = thrum_scope_allocate(&s->memory, fem->vertex_count, sizeof *s->index);
  s->vertex = thrum_scope_allocate(&s->memory, fem->vertex_count, sizeof *s->vertex);
  THRUM_TRY(s->memory.status);
  for (int64_t f = 0; f < faces->count; f++)
    for (int c = 0; c < 3 && faces->faces[f].other < 0; c++)
      s->index[faces->faces[f].vertices[c]] = 1;

  // vertices are numbered in the order of the mesh
  for (int32_t v = 0; v < fem->vertex_count; v++) {
    const bool taken = s->index[v] > 0 && !is_held(fem, v);
    s->index[v] = taken ? (int32_t)s->count : -1;
    if (taken)
      s->vertex[s->count++] = v;
  }
  return s->count > 0 ? THRUM_OK
                      : thrum_error_set(error, THRUM_MISSING,
                                        "all of the surface is held: there is no place to pull at");
}

/* Calls for both ends of the sides of a triangle; the first pass counts, the second fills. */
static void join_corners(surface *s, const int32_t corners[3], bool fill) {
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const int32_t from = s->index[corners[a]], to = s->index[corners[b]];
      if (a == b || from < 0 || to < 0)
        continue;
      if (fill)
        s->neighbour[s->begin[from]] = to;
      s->begin[from]++;
    }
}

static thrum_status find_neighbours(surface *s, const thrum_mesh_faces *faces) {
  s->begin = thrum_scope_allocate(&s->memory, s->count + 1, sizeof *s->begin);
  THRUM_TRY(s->memory.status);
  for (int64_t f = 0; f < faces->count; f++)
    if (faces->faces[f].other < 0)
      join_corners(s, faces->faces[f].vertices, false);

  // counts become the first entry of each
  int64_t sum = 0;
  for (int64_t i = 0; i <= s->count; i++) {
    const int64_t own = s->begin[i];
    s->begin[i] = sum;
    sum += own;
  }
  s->neighbour = thrum_scope_allocate(&s->memory, sum + 1, sizeof *s->neighbour);
  THRUM_TRY(s->memory.status);
  for (int64_t f = 0; f < faces->count; f++)
    if (faces->faces[f].other < 0)
      join_corners(s, faces->faces[f].vertices, true);

  // filling has moved every beginning to the next one's
  for (int64_t i = s->count; i > 0; i--)
    s->begin[i] = s->begin[i - 1];
  s->begin[0] = 0;
  return THRUM_OK;
}

static thrum_status find_surface(surface *s, const thrum_mesh *mesh, const thrum_fem *fem,
                                 thrum_error *error) {
  thrum_mesh_faces faces = {0};
  int64_t tets[3];
  s->points = mesh->vertices;
  THRUM_TRY(thrum_mesh_find_faces(mesh, &faces, tets, error));
  thrum_status status = find_vertices(s, &faces, fem, error);
  THRUM_THEN(status, find_neighbours(s, &faces));
  free(faces.faces);

  // what sampling and patches need
  s->queue = thrum_scope_allocate(&s->memory, s->count, sizeof *s->queue);
  s->seen = thrum_scope_allocate(&s->memory, s->count, sizeof *s->seen);
  s->away = thrum_scope_allocate(&s->memory, s->count, sizeof *s->away);
  return status < 0 ? status : s->memory.status;
}

/* Each place is the vertex that is farthest from those before it, beginning with the first. */
static void sample(surface *s, int64_t count, int32_t *middle) {
  int64_t next = 0;
  for (int64_t i = 0; i < s->count; i++)
    s->away[i] = INFINITY;
  for (int64_t n = 0; n < count; n++) {
    const int64_t taken = next;
    middle[n] = (int32_t)taken;
    for (int64_t i = 0; i < s->count; i++) {
      s->away[i] = fmin(s->away[i], distance2(s, i, taken));
      if (s->away[i] > s->away[next])
        next = i;
    }
  }
}

/* Fills the queue with the patch around a vertex, found along edges; returns how many. */
static int64_t find_patch(surface *s, int32_t middle, int32_t mark, double radius) {
  int64_t count = 1;
  s->queue[0] = middle;
  s->seen[middle] = mark;
  for (int64_t n = 0; n < count; n++)
    for (int64_t e = s->begin[s->queue[n]]; e < s->begin[s->queue[n] + 1]; e++) {
      const int32_t i = s->neighbour[e];
      if (s->seen[i] == mark || distance2(s, i, middle) >= radius * radius)
        continue;
      s->seen[i] = mark;
      s->queue[count++] = i;
    }
  return count;
}

/* The vertices of a patch and their shares, which sum up to 1. */
static void fill_patch(const surface *s, int64_t count, double radius, thrum_touch_places *places,
                       int64_t at) {
  double sum = 0;
  for (int64_t n = 0; n < count; n++) {
    places->vertex[at + n] = s->vertex[s->queue[n]];
    places->share[at + n] = 1 - distance2(s, s->queue[n], s->queue[0]) / (radius * radius);
    sum += places->share[at + n];
  }
  for (int64_t n = 0; n < count; n++)
    places->share[at + n] /= sum;
}

/* The patches: once through for their sizes, and once more for what is in them. */
static thrum_status fill_places(surface *s, double radius, thrum_touch_places *places,
                                thrum_error *error) {
  int32_t mark = 0;
  for (int64_t n = 0; n < places->count; n++)
    places->begin[n + 1] = places->begin[n] + find_patch(s, places->middle[n], ++mark, radius);
  const int64_t entries = places->begin[places->count];
  THRUM_TRY(thrum_reserve(&places->vertex, entries, sizeof *places->vertex, "the places", error));
  THRUM_TRY(thrum_reserve(&places->share, entries, sizeof *places->share, "the places", error));

  for (int64_t n = 0; n < places->count; n++) {
    const int64_t count = find_patch(s, places->middle[n], ++mark, radius);
    fill_patch(s, count, radius, places, places->begin[n]);
    places->middle[n] = s->vertex[places->middle[n]];
  }
  return THRUM_OK;
}

thrum_status thrum_touch_places_create(const thrum_mesh *mesh, const thrum_fem *fem, int64_t count,
                                       double radius, thrum_touch_places *places,
                                       thrum_error *error) {
  surface s = {.memory = thrum_scope_begin("the surface", error)};
  thrum_touch_places made = {0};
  thrum_status status = find_surface(&s, mesh, fem, error);

  made.count = count < s.count ? count : s.count;
  THRUM_THEN(status,
             thrum_reserve(&made.middle, made.count, sizeof *made.middle, "the places", error));
  THRUM_THEN(status,
             thrum_reserve(&made.begin, made.count + 1, sizeof *made.begin, "the places", error));
  if (status >= 0) {
    sample(&s, made.count, made.middle);
    status = fill_places(&s, radius, &made, error);
  }

  thrum_scope_free(&s.memory);
  if (status < 0)
    thrum_touch_places_free(&made);
  else
    *places = made;
  return status;
}

void thrum_touch_places_free(thrum_touch_places *places) {
  free(places->middle);
  free(places->begin);
  free(places->vertex);
  free(places->share);
  *places = (thrum_touch_places){0};
}
