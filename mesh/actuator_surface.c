/* The surface of a chamber: faces of the body, caps over their open edges, and how its volume is
 * taken (actuator.h).
 *
 * An edge is open where the faces of both sides do not cancel. A cap is a fan from the mean of an
 * open edge's vertices; what it adds to the volume is a polynomial of the vertices as all else. An
 * edge that stays may be left open: what a fixed surface there adds is constant, and one that
 * slides in a plane x_a = c adds nothing to the integral of (x_a - c) n_a, nor to those along other
 * axes. So the axes that no such plane is across are taken, or with one plane each its place as
 * origin. Cost: linear, but for a sort of the edges.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "mesh/actuator.h"
#include "mesh/mesh_faces.h"
#include "platform/allocate.h"

/* An edge of a face, in the direction that it goes round in. */
typedef struct edge {
  int32_t from, to, middle; /* middle: -1 of linear faces */
} edge;

typedef struct edges {
  int64_t count;
  edge *list;
} edges;

void thrum_actuator_free_surface(thrum_actuator_surface *surface) {
  free(surface->faces);
  free(surface->mean_ends);
  free(surface->mean_nodes);
  *surface = (thrum_actuator_surface){0};
}

/* --- faces ------------------------------------------------------------------------------------ */

/* The faces of the surface whose corners are marked. */
static thrum_status take_faces(const thrum_mesh *mesh, const uint8_t *marks, const char *spec,
                               thrum_actuator_surface *surface, thrum_error *error) {
  thrum_mesh_faces faces = {0};
  int64_t tets[3], count = 0;
  THRUM_TRY(thrum_mesh_find_faces(mesh, &faces, tets, error));
  for (int64_t f = 0; f < faces.count; f++) {
    const thrum_mesh_face *face = &faces.faces[f];
    const int32_t *v = face->vertices;
    if (face->other < 0 && marks[v[0]] && marks[v[1]] && marks[v[2]])
      faces.faces[count++] = *face;
  }

  surface->nodes = mesh->midsides ? 6 : 3;
  thrum_status status = THRUM_OK;
  if (count == 0)
    status = thrum_error_set(error, THRUM_MISSING,
                             "'%.100s': no face of the body's surface has its corners in the group",
                             spec);
  THRUM_THEN(status, thrum_reserve(&surface->faces, count * surface->nodes, sizeof(int32_t),
                                   "the actuator", error));
  for (int64_t f = 0; f < count && status >= 0; f++) {
    const thrum_mesh_face *face = &faces.faces[f];
    int32_t *to = surface->faces + f * surface->nodes;
    to[0] = face->vertices[0];
    to[1] = face->vertices[face->even ? 1 : 2];
    to[2] = face->vertices[face->even ? 2 : 1];
    for (int k = 0; k < 3 && surface->nodes == 6; k++)
      to[3 + k] = thrum_mesh_middle_node(mesh, face->tet, to[k], to[(k + 1) % 3]);
  }
  surface->face_count = status >= 0 ? count : 0;
  free(faces.faces);
  return status;
}

/* --- open edges ------------------------------------------------------------------------------- */

static int compare(int32_t a, int32_t b) {
  return (a > b) - (a < b);
}

static int by_ends(const void *x, const void *y) {
  const edge *a = x, *b = y;
  const int32_t low[2] = {a->from < a->to ? a->from : a->to, b->from < b->to ? b->from : b->to};
  const int32_t high[2] = {a->from < a->to ? a->to : a->from, b->from < b->to ? b->to : b->from};
  const int first = compare(low[0], low[1]);
  return first != 0 ? first : compare(high[0], high[1]);
}

static int by_from(const void *x, const void *y) {
  const edge *a = x, *b = y;
  const int first = compare(a->from, b->from);
  return first != 0 ? first : compare(a->to, b->to);
}

/* The edges that are gone along once more in one direction than in the other, by their begins. */
static thrum_status find_open(const thrum_actuator_surface *surface, edges *open,
                              thrum_error *error) {
  const int64_t all = 3 * surface->face_count;
  THRUM_TRY(thrum_reserve(&open->list, all, sizeof *open->list, "the actuator", error));
  for (int64_t e = 0; e < all; e++) {
    const int32_t *face = surface->faces + e / 3 * surface->nodes;
    open->list[e] =
        (edge){face[e % 3], face[(e + 1) % 3], surface->nodes == 6 ? face[3 + e % 3] : -1};
  }
  qsort(open->list, (size_t)all, sizeof *open->list, by_ends);

  // runs of one edge
  open->count = 0;
  for (int64_t first = 0, last; first < all; first = last) {
    int64_t sum = 0;
    const edge one = open->list[first];
    for (last = first; last < all && by_ends(&one, &open->list[last]) == 0; last++)
      sum += open->list[last].from == one.from ? 1 : -1;
    const edge back = {one.to, one.from, one.middle};
    for (; sum != 0; sum += sum > 0 ? -1 : 1)
      open->list[open->count++] = sum > 0 ? one : back;
  }
  qsort(open->list, (size_t)open->count, sizeof *open->list, by_from);
  return THRUM_OK;
}

static thrum_status say_open(const char *spec, const edge *one, const char *advice,
                             thrum_error *error) {
  return thrum_error_set(
      error, THRUM_INVALID_ARGUMENT,
      "'%.100s': the surface is open at the edge between vertices %ld and %ld: %s", spec,
      (long)one->from + 1, (long)one->to + 1, advice);
}

/* --- caps ------------------------------------------------------------------------------------- */

/* The open edge that begins at a vertex; -1: there is none, or there are several. */
static int64_t begins_at(const edges *open, int32_t vertex) {
  int64_t low = 0, high = open->count;
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (open->list[middle].from < vertex)
      low = middle + 1;
    else
      high = middle;
  }
  if (low == open->count || open->list[low].from != vertex ||
      (low + 1 < open->count && open->list[low + 1].from == vertex))
    return -1;
  return low;
}

/* A new mean of nodes; returns its number as a node. */
static int32_t add_mean(thrum_actuator_surface *surface, int64_t vertices, const int32_t *nodes,
                        int64_t count) {
  memcpy(surface->mean_nodes + surface->term_count, nodes, (size_t)count * sizeof *nodes);
  surface->term_count += count;
  surface->mean_ends[surface->mean_count] = surface->term_count;
  return (int32_t)(vertices + surface->mean_count++);
}

/* One cap over the `count` edges of a loop, which go round the other way in it. */
static void add_fan(thrum_actuator_surface *surface, int64_t vertices, const edge *loop,
                    int64_t count, int32_t *room) {
  for (int64_t n = 0; n < count; n++)
    room[n] = loop[n].from;
  const int32_t middle = add_mean(surface, vertices, room, count);
  int32_t before = -1, first = -1;
  for (int64_t n = 0; n < count; n++) {
    int32_t *face = surface->faces + surface->face_count++ * surface->nodes;
    const edge *e = &loop[n];
    face[0] = e->to;
    face[1] = e->from;
    face[2] = middle;
    if (surface->nodes == 3)
      continue;

    // the middles of its edges, which neighbours share
    if (n == 0)
      first = before = add_mean(surface, vertices, (int32_t[]){e->from, middle}, 2);
    const int32_t after =
        n + 1 < count ? add_mean(surface, vertices, (int32_t[]){e->to, middle}, 2) : first;
    face[3] = e->middle;
    face[4] = before;
    face[5] = after;
    before = after;
  }
}

/* Closes every loop of open edges. */
static thrum_status add_caps(int64_t vertices, const edges *open, const char *spec,
                             thrum_actuator_surface *surface, thrum_error *error) {
  const int64_t n = open->count;
  edge *loop = NULL;
  int32_t *room = NULL, *faces = NULL;
  uint8_t *done = NULL;
  thrum_status status = thrum_reserve(&loop, n, sizeof *loop, "the caps", error);
  THRUM_THEN(status, thrum_reserve(&room, n, sizeof *room, "the caps", error));
  THRUM_THEN(status, thrum_reserve(&done, n, 1, "the caps", error));
  THRUM_THEN(status, thrum_reserve(&faces, (surface->face_count + n) * surface->nodes,
                                   sizeof *faces, "the caps", error));
  THRUM_THEN(status, thrum_reserve(&surface->mean_ends, 2 * n, sizeof(int64_t), "the caps", error));
  THRUM_THEN(status,
             thrum_reserve(&surface->mean_nodes, 3 * n, sizeof(int32_t), "the caps", error));
  if (status >= 0) {
    memcpy(faces, surface->faces, (size_t)(surface->face_count * surface->nodes) * sizeof *faces);
    free(surface->faces);
    surface->faces = faces;
    faces = NULL;
  }

  // each loop from its first edge on, which may come only once
  for (int64_t e = 0; e < n && status >= 0; e++) {
    int64_t count = 0, at = e;
    while (status >= 0 && at >= 0 && !done[at]) {
      done[at] = 1;
      loop[count++] = open->list[at];
      at = begins_at(open, open->list[at].to);
    }
    if (count > 0 && at != e)
      status =
          say_open(spec, &open->list[e], "there is no single loop that a cap could close", error);
    else if (count > 0)
      add_fan(surface, vertices, loop, count, room);
  }
  free(loop);
  free(room);
  free(done);
  free(faces);
  return status;
}

/* --- edges that stay -------------------------------------------------------------------------- */

/* What the planes that open edges slide in leave of the axes. */
typedef struct planes {
  int count[3]; /* 0, 1, or 2: several */
  double at[3];
} planes;

/* Notes the plane that an edge slides in; false: it moves. */
static bool note_edge(const thrum_mesh *mesh, const uint8_t *fixed, const edge *e, planes *found) {
  const uint8_t held =
      (uint8_t)(fixed[e->from] & fixed[e->to] & (e->middle >= 0 ? fixed[e->middle] : 7));
  if (held == 7)
    return true;
  for (int axis = 0; axis < 3; axis++) {
    const double at = mesh->vertices[3 * (int64_t)e->from + axis];
    if (!(held >> axis & 1) || mesh->vertices[3 * (int64_t)e->to + axis] != at)
      continue;
    if (found->count[axis] == 0)
      found->at[axis] = at;
    if (found->count[axis] == 0 || found->at[axis] != at)
      found->count[axis]++;
    return true;
  }
  return false;
}

/* The axes along which the volume is taken, and their origins. */
static thrum_status choose_axes(const thrum_mesh *mesh, const uint8_t *fixed, const edges *open,
                                const char *spec, thrum_actuator_surface *surface,
                                thrum_error *error) {
  planes found = {{0}, {0}};
  for (int64_t e = 0; e < open->count; e++)
    if (!note_edge(mesh, fixed, &open->list[e], &found))
      return say_open(
          spec, &open->list[e],
          "hold it, or close it as chamber:GROUP,cap, as a pressure within an edge that "
          "moves has no energy",
          error);
  int most = 2;
  for (int axis = 0; axis < 3; axis++)
    most = found.count[axis] < most ? found.count[axis] : most;
  if (most >= 2)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "'%.100s': its open edges slide in several planes across each axis, so "
                           "that its volume is not known: close them by caps",
                           spec);
  int axes = 0;
  for (int axis = 0; axis < 3; axis++)
    axes += found.count[axis] == most;
  for (int axis = 0; axis < 3; axis++) {
    surface->weight[axis] = found.count[axis] == most ? 1.0 / axes : 0.0;
    surface->origin[axis] = found.at[axis];
  }
  return THRUM_OK;
}

thrum_status thrum_actuator_find_surface(const thrum_mesh *mesh, const uint8_t *fixed,
                                         const thrum_group *group, bool caps, bool open_allowed,
                                         const char *spec, thrum_actuator_surface *surface,
                                         thrum_error *error) {
  uint8_t *marks = NULL;
  edges open = {0};
  *surface = (thrum_actuator_surface){0};
  if (mesh->solid_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "'%.100s': surfaces of chambers are those of tetrahedra: give --element "
                           "tet, which cuts the elements",
                           spec);
  THRUM_TRY(thrum_reserve(&marks, mesh->vertex_count, 1, "the actuator", error));
  for (int64_t n = 0; n < group->count; n++)
    marks[group->vertices[n]] = 1;
  thrum_status status = take_faces(mesh, marks, spec, surface, error);
  free(marks);

  // what is open is closed, or stays
  THRUM_THEN(status, find_open(surface, &open, error));
  if (status >= 0 && open.count > 0 && caps) {
    status = add_caps(mesh->vertex_count, &open, spec, surface, error);
    open.count = 0;
  }
  if (status >= 0 && open.count > 0 && !open_allowed)
    status =
        say_open(spec, &open.list[0], "a chamber is closed, or closed by caps: GROUP,cap", error);
  THRUM_THEN(status, choose_axes(mesh, fixed, &open, spec, surface, error));
  free(open.list);
  if (status < 0)
    thrum_actuator_free_surface(surface);
  return status;
}
