/* A sheet from a surface, see surface_sheet.h. Cost: n log n in the facets, times the layers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/mesh_builder.h"
#include "mesh/surface_check.h"
#include "mesh/surface_sides.h"
#include "platform/allocate.h"

#define FOLD_MOST 0.5 /* cosine between the mean normal at a vertex and that of a facet there */

typedef struct sheet {
  const thrum_surface_mesh *surface;
  const thrum_sheet_options *options;
  const char *path;
  int64_t facet_count;
  int32_t (*facet)[4]; /* -1 last: a triangle */
  int64_t *triangle;   /* of each facet, its first */
  double (*normal)[3]; /* of each vertex: from the middle to the top, over half the thickness */
  uint8_t *edge;       /* vertices of open edges */
  thrum_scope memory;
  thrum_error *error;
} sheet;

static const double *place(const sheet *s, int32_t v) {
  return s->surface->vertices + 3 * (int64_t)v;
}

static int corners_of(const int32_t facet[4]) {
  return facet[3] < 0 ? 3 : 4;
}

/* --- facets ----------------------------------------------------------------------------------- */

/* Two triangles of one line of the file that share the side from the first corner of both are a
 * polygon of four corners; longer fans stay triangles. */
static bool is_pair(const thrum_surface_mesh *surface, int64_t t) {
  const int64_t *line = surface->triangle_line;
  if (surface->binary || surface->polygons == 0 || t + 1 >= surface->triangle_count ||
      line[t] != line[t + 1])
    return false;
  if ((t > 0 && line[t - 1] == line[t]) ||
      (t + 2 < surface->triangle_count && line[t + 2] == line[t]))
    return false;
  const int32_t *a = surface->triangles + 3 * t, *b = a + 3;
  return a[0] == b[0] && a[2] == b[1];
}

/* The unit normal of a facet at corner c, and the angle there. */
static double corner_normal(const sheet *s, int64_t f, int c, double normal[3]) {
  const int32_t *facet = s->facet[f];
  const int n = corners_of(facet);
  double to[3], from[3];
  thrum_subtract3(place(s, facet[(c + 1) % n]), place(s, facet[c]), to);
  thrum_subtract3(place(s, facet[(c + n - 1) % n]), place(s, facet[c]), from);
  thrum_cross3(to, from, normal);
  const double area = sqrt(thrum_dot3(normal, normal));
  for (int d = 0; d < 3; d++)
    normal[d] = area > 0 ? normal[d] / area : 0;
  return atan2(area, thrum_dot3(to, from));
}

/* The first corner from which facet f goes back, against what it encloses; -1: it is convex. A
 * hexahedron on one that is not has parts inside out. */
static int corner_back(const sheet *s, int64_t f) {
  const int32_t *facet = s->facet[f];
  double along[3], across[3], area[3], normal[3];
  thrum_subtract3(place(s, facet[2]), place(s, facet[0]), along);
  thrum_subtract3(place(s, facet[3]), place(s, facet[1]), across);
  thrum_cross3(along, across, area);
  for (int c = 0; c < 4; c++) {
    corner_normal(s, f, c, normal);
    if (!(thrum_dot3(area, normal) > 0))
      return c;
  }
  return -1;
}

static void add_facet(sheet *s, int64_t triangle, const int32_t facet[4]) {
  memcpy(s->facet[s->facet_count], facet, sizeof *s->facet);
  s->triangle[s->facet_count++] = triangle;
}

static void find_facets(sheet *s) {
  const thrum_surface_mesh *surface = s->surface;
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    const int32_t *a = surface->triangles + 3 * t;
    const bool four = is_pair(surface, t);
    add_facet(s, t, (int32_t[]){a[0], a[1], a[2], four ? a[5] : -1});
    const int back = four ? corner_back(s, s->facet_count - 1) : -1;
    t += four;
    if (back < 0)
      continue;

    // two triangles that meet at that corner
    const int32_t round[4] = {a[0], a[1], a[2], a[5]};
    s->facet_count--;
    for (int half = 0; half < 2; half++)
      add_facet(
          s, t - 1 + half,
          (int32_t[]){round[back], round[(back + 1 + half) % 4], round[(back + 2 + half) % 4], -1});
  }
}

/* Marks the vertices of sides that one facet has. */
static void mark_edges(const sheet *s, thrum_surface_side *sides) {
  int64_t count = 0;
  for (int64_t f = 0; f < s->facet_count; f++)
    for (int c = 0, n = corners_of(s->facet[f]); c < n; c++) {
      const int32_t a = s->facet[f][c], b = s->facet[f][(c + 1) % n];
      sides[count++] = (thrum_surface_side){a < b ? a : b, a < b ? b : a, -1, (int32_t)f, a < b};
    }
  thrum_surface_sides_sort(sides, count);
  for (int64_t n = 0, end; n < count; n = end) {
    for (end = n + 1;
         end < count && sides[end].low == sides[n].low && sides[end].high == sides[n].high;)
      end++;
    if (end == n + 1)
      s->edge[sides[n].low] = s->edge[sides[n].high] = 1;
  }
}

/* --- normals ---------------------------------------------------------------------------------- */

static thrum_status refuse(const sheet *s, int64_t f, int c, const char *what) {
  const int32_t *facet = s->facet[f];
  const thrum_surface_fault fault = {
      1, s->triangle[f], {facet[c], facet[(c + 1) % corners_of(facet)]}};
  return thrum_surface_refuse(s->surface, &fault, s->path, what, s->error);
}

/* The mean direction of each vertex, over the mean of what it has along the facets' normals. */
static thrum_status make_normals(sheet *s, double *along, double *angles) {
  double normal[3];
  for (int64_t f = 0; f < s->facet_count; f++)
    for (int c = 0; c < corners_of(s->facet[f]); c++) {
      const double angle = corner_normal(s, f, c, normal);
      for (int d = 0; d < 3; d++)
        s->normal[s->facet[f][c]][d] += angle * normal[d];
    }
  for (int64_t v = 0; v < s->surface->vertex_count; v++) {
    const double length = sqrt(thrum_dot3(s->normal[v], s->normal[v]));
    for (int d = 0; d < 3 && length > 0; d++)
      s->normal[v][d] /= length;
  }

  // what each facet has of it, which must not be too little
  for (int64_t f = 0; f < s->facet_count; f++)
    for (int c = 0; c < corners_of(s->facet[f]); c++) {
      const int32_t v = s->facet[f][c];
      const double angle = corner_normal(s, f, c, normal);
      const double cosine = thrum_dot3(normal, s->normal[v]);
      if (!(cosine > FOLD_MOST))
        return refuse(s, f, c, "the surface folds too sharply for a sheet: edges at such corners");
      along[v] += angle * cosine;
      angles[v] += angle;
    }
  for (int64_t v = 0; v < s->surface->vertex_count; v++)
    for (int d = 0; d < 3 && along[v] > 0; d++)
      s->normal[v][d] *= angles[v] / along[v];
  return THRUM_OK;
}

/* --- elements --------------------------------------------------------------------------------- */

/* How far level k lies above the surface. */
static double height_of(const sheet *s, int64_t k) {
  static const double shift[] = {-0.5, -1, 0};
  return s->options->thickness * ((double)k / (double)s->options->layers + shift[s->options->side]);
}

static void lift(const sheet *s, int32_t v, int64_t k, double at[3]) {
  for (int d = 0; d < 3; d++)
    at[d] = place(s, v)[d] + height_of(s, k) * s->normal[v][d];
}

/* At the lowest and highest level each corner goes round as that of the facet does, and each side
 * goes the same way. */
static thrum_status check_facet(const sheet *s, int64_t f) {
  const int32_t *facet = s->facet[f];
  const int n = corners_of(facet);
  for (int64_t k = 0; k <= s->options->layers; k += s->options->layers)
    for (int c = 0; c < n; c++) {
      const int32_t next = facet[(c + 1) % n], before = facet[(c + n - 1) % n];
      double at[3], there[3], back[3], to[3], from[3], cross[3], normal[3], side[3];
      lift(s, facet[c], k, at);
      lift(s, next, k, there);
      lift(s, before, k, back);
      thrum_subtract3(there, at, to);
      thrum_subtract3(back, at, from);
      thrum_subtract3(place(s, next), place(s, facet[c]), side);
      thrum_cross3(to, from, cross);
      corner_normal(s, f, c, normal);
      if (!(thrum_dot3(cross, normal) > 0 && thrum_dot3(to, side) > 0))
        return refuse(s, f, c,
                      "the surface bends too sharply for this thickness, whose elements would "
                      "turn inside out: edges");
    }
  return THRUM_OK;
}

/* The number of a vertex at a level, from 1. */
static int64_t number_of(const sheet *s, int32_t v, int64_t k) {
  return v * (s->options->layers + 1) + k + 1;
}

static thrum_status add_elements(const sheet *s, thrum_mesh_builder *b) {
  for (int64_t f = 0; f < s->facet_count; f++) {
    const int32_t *facet = s->facet[f];
    const int n = corners_of(facet);
    THRUM_TRY(check_facet(s, f));
    for (int64_t k = 0; k < s->options->layers; k++) {
      int64_t nodes[8];
      for (int c = 0; c < n; c++) {
        nodes[c] = number_of(s, facet[c], k);
        nodes[n + c] = number_of(s, facet[c], k + 1);
      }
      THRUM_TRY(thrum_builder_element(
          b, &(thrum_element){.kind = n == 3 ? THRUM_SOLID_WEDGE : THRUM_SOLID_HEXAHEDRON,
                              .nodes = nodes}));
    }
  }
  return THRUM_OK;
}

/* The vertices of a level, or of those between two, all or those of open edges, as a group. */
static thrum_status add_group(const sheet *s, thrum_mesh_builder *b, const char *name, int64_t from,
                              int64_t to, bool edge) {
  int64_t list = 0;
  bool any = !edge;
  for (int64_t v = 0; v < s->surface->vertex_count; v++)
    any = any || s->edge[v];
  if (!any)
    return THRUM_OK;
  THRUM_TRY(thrum_builder_list(b, name, strlen(name), &list));
  for (int64_t v = 0; v < s->surface->vertex_count; v++)
    for (int64_t k = from; k <= to && (!edge || s->edge[v]); k++)
      THRUM_TRY(thrum_builder_add(b, list, number_of(s, (int32_t)v, k)));
  return THRUM_OK;
}

static thrum_status add_groups(const sheet *s, thrum_mesh_builder *b) {
  const int64_t top = s->options->layers;
  THRUM_TRY(add_group(s, b, "bottom", 0, 0, false));
  THRUM_TRY(add_group(s, b, "top", top, top, false));
  THRUM_TRY(add_group(s, b, "edge", 0, top, true));
  if (top % 2 != 0)
    return THRUM_OK;
  THRUM_TRY(add_group(s, b, "middle", top / 2, top / 2, false));
  return add_group(s, b, "edge_middle", top / 2, top / 2, true);
}

static thrum_status build(sheet *s, thrum_mesh *mesh) {
  thrum_mesh_builder b = {.keep_solids = true, .error = s->error};
  thrum_status status = THRUM_OK;
  for (int64_t v = 0; v < s->surface->vertex_count; v++)
    for (int64_t k = 0; k <= s->options->layers && status >= 0; k++) {
      double at[3];
      lift(s, (int32_t)v, k, at);
      status = thrum_builder_vertex(&b, number_of(s, (int32_t)v, k), at, 0);
    }
  THRUM_THEN(status, thrum_builder_order(&b, s->path));
  THRUM_THEN(status, add_elements(s, &b));
  THRUM_THEN(status, add_groups(s, &b));
  THRUM_THEN(status, thrum_builder_finish(&b, s->path, mesh));
  thrum_builder_free(&b);
  return status;
}

/* What a mesher minds but for open edges, and neighbours that go round opposite ways. */
static thrum_status check(const sheet *s) {
  thrum_surface_checked checked;
  THRUM_TRY(thrum_surface_check(s->surface, &checked, s->error));
  checked.open.count = 0;
  THRUM_TRY(thrum_surface_meshable(s->surface, &checked, s->path, s->error));
  if (checked.turned.count == 0)
    return THRUM_OK;
  return thrum_surface_refuse(s->surface, &checked.turned, s->path,
                              "neighbours go round opposite ways, so the sheet has no top: edges",
                              s->error);
}

thrum_status thrum_surface_sheet(const thrum_surface_mesh *surface,
                                 const thrum_sheet_options *options, const char *path,
                                 thrum_mesh *mesh, thrum_error *error) {
  const int64_t triangles = surface->triangle_count, vertices = surface->vertex_count;
  sheet s = {.surface = surface,
             .options = options,
             .path = path,
             .memory = thrum_scope_begin("the sheet", error),
             .error = error};
  s.facet = thrum_scope_allocate(&s.memory, triangles, sizeof *s.facet);
  s.triangle = thrum_scope_allocate(&s.memory, triangles, sizeof *s.triangle);
  s.normal = thrum_scope_allocate(&s.memory, vertices, sizeof *s.normal);
  s.edge = thrum_scope_allocate(&s.memory, vertices, 1);
  double *along = thrum_scope_allocate(&s.memory, 2 * vertices, sizeof *along);
  thrum_surface_side *sides = thrum_scope_allocate(&s.memory, 3 * triangles, sizeof *sides);
  thrum_status status = s.memory.status;
  THRUM_THEN(status, check(&s));
  if (status >= 0) {
    find_facets(&s);
    mark_edges(&s, sides);
    status = make_normals(&s, along, along + vertices);
  }
  thrum_mesh made = {0};
  THRUM_THEN(status, build(&s, &made));
  thrum_scope_free(&s.memory);
  return thrum_mesh_deliver(status, &made, mesh);
}
