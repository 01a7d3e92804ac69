/* Mending surfaces by their sorted sides, see surface_repair.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_repair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/surface_check.h"
#include "mesh/surface_join.h"
#include "mesh/surface_sides.h"
#include "platform/allocate.h"

/* Vertices this close, in diagonals of the box, are one: files have 6 digits and more. */
static const double CLOSE = 1e-6;

/* Passes over the surface. A row of triangles without area, as where many vertices lie on one edge,
 * takes a pass for each; beside it a pass halves what lies on an edge. */
enum { PASSES_MAX = 50, ROW_MAX = 1000 };

typedef struct repair {
  thrum_surface_mesh *surface;
  thrum_surface_repairs *done;
  thrum_surface_side *sides; /* of the triangles that there were when they were sorted */
  int64_t side_count;
  double reach; /* how far close vertices are apart at most [m] */
  thrum_error *error;
} repair;

static const double *place(const repair *r, int32_t v) {
  return r->surface->vertices + 3 * (int64_t)v;
}

static double distance2(const double a[3], const double b[3]) {
  double d[3];
  thrum_subtract3(a, b, d);
  return thrum_dot3(d, d);
}

/* Marks a triangle as gone; marked ones are dropped together. The first corner stays, since volumes
 * are measured from that of the first triangle. */
static void remove_triangle(repair *r, int64_t t) {
  r->surface->triangles[3 * t + 1] = -1;
}

static bool is_gone(const repair *r, int64_t t) {
  return r->surface->triangles[3 * t + 1] < 0;
}

static void drop_gone(repair *r) {
  thrum_surface_mesh *s = r->surface;
  int64_t kept = 0;
  for (int64_t t = 0; t < s->triangle_count; t++) {
    if (is_gone(r, t))
      continue;
    memmove(s->triangles + 3 * kept, s->triangles + 3 * t, 3 * sizeof *s->triangles);
    s->triangle_line[kept++] = s->triangle_line[t];
  }
  s->triangle_count = kept;
}

/* Makes the list of sides anew, equal ones next to each other. */
static thrum_status sort_sides(repair *r) {
  const thrum_surface_mesh *s = r->surface;
  const int64_t count = 3 * s->triangle_count;
  free(r->sides);
  r->sides = NULL;
  THRUM_TRY(thrum_reserve(&r->sides, count + 1, sizeof *r->sides, "the surface", r->error));
  for (int64_t n = 0; n < count; n++) {
    const int32_t from = s->triangles[n], to = s->triangles[n % 3 == 2 ? n - 2 : n + 1];
    r->sides[n] = (thrum_surface_side){from < to ? from : to, from < to ? to : from, -1,
                                       (int32_t)(n / 3), from < to};
  }
  thrum_surface_sides_sort(r->sides, count);
  r->side_count = count;
  return THRUM_OK;
}

/* How many sides from n on have the ends of side n. */
static int64_t equal_sides(const repair *r, int64_t n) {
  int64_t end = n + 1;
  while (end < r->side_count && r->sides[end].low == r->sides[n].low &&
         r->sides[end].high == r->sides[n].high)
    end++;
  return end - n;
}

/* The first side with these ends; they are there. */
static int64_t find_side(const repair *r, int32_t a, int32_t b) {
  const int32_t low = a < b ? a : b, high = a < b ? b : a;
  int64_t from = 0, to = r->side_count;
  while (from < to) {
    const int64_t middle = from + (to - from) / 2;
    const thrum_surface_side *side = &r->sides[middle];
    if (side->low < low || (side->low == low && side->high < high))
      from = middle + 1;
    else
      to = middle;
  }
  return from;
}

/* --- open edges --------------------------------------------------------------------------------
 */

static int compare_vertices(const void *a, const void *b) {
  const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
  return (x > y) - (x < y);
}

/* The vertices of open edges with their places along x. */
typedef struct repair_place {
  double x;
  int32_t vertex;
} repair_place;

static int compare_places(const void *a, const void *b) {
  const repair_place *x = a, *y = b;
  if (x->x != y->x)
    return x->x < y->x ? -1 : 1;
  return compare_vertices(&x->vertex, &y->vertex);
}

/* Gathers the vertices of open edges, each once, in the order of x; *places is the caller's. */
static thrum_status gather_open(repair *r, repair_place **places, int64_t *count) {
  const int64_t all = 3 * r->surface->triangle_count;
  int32_t *ends = NULL;
  *count = 0;
  THRUM_TRY(sort_sides(r));
  THRUM_TRY(thrum_reserve(&ends, 2 * all + 1, sizeof *ends, "the surface", r->error));
  int64_t found = 0;
  for (int64_t n = 0, same; n < all; n += same) {
    same = equal_sides(r, n);
    if (same > 1)
      continue;
    ends[found++] = r->sides[n].low;
    ends[found++] = r->sides[n].high;
  }

  // each vertex once, and then along x
  qsort(ends, (size_t)found, sizeof *ends, compare_vertices);
  thrum_status status = thrum_reserve(places, found + 1, sizeof **places, "the surface", r->error);
  for (int64_t i = 0; i < found && status >= 0; i++)
    if (i == 0 || ends[i] != ends[i - 1])
      (*places)[(*count)++] = (repair_place){place(r, ends[i])[0], ends[i]};
  if (status >= 0)
    qsort(*places, (size_t)*count, sizeof **places, compare_places);
  free(ends);
  return status;
}

/* Makes vertices of open edges one that are close to each other. */
static thrum_status join_close(repair *r) {
  thrum_surface_mesh *s = r->surface;
  repair_place *places = NULL;
  int32_t *into = NULL;
  int64_t count = 0;
  thrum_status status = gather_open(r, &places, &count);
  THRUM_THEN(status,
             thrum_reserve(&into, s->vertex_count + 1, sizeof *into, "the surface", r->error));
  for (int64_t v = 0; v < s->vertex_count && status >= 0; v++)
    into[v] = (int32_t)v;

  // a vertex is joined with the first one near it along x
  for (int64_t i = 0; i < count && status >= 0; i++)
    for (int64_t j = i + 1; j < count && places[j].x - places[i].x <= r->reach; j++) {
      const int32_t a = places[i].vertex, b = places[j].vertex;
      if (into[b] != b || distance2(place(r, a), place(r, b)) > r->reach * r->reach)
        continue;
      into[b] = into[a];
      r->done->joined++;
    }
  for (int64_t n = 0; n < 3 * s->triangle_count && status >= 0; n++)
    s->triangles[n] = into[s->triangles[n]];
  free(places);
  free(into);
  return status;
}

/* Puts a vertex on the side from `from` to `to` of a triangle, which becomes two. */
static thrum_status split(repair *r, int64_t t, int32_t from, int32_t to, int32_t middle) {
  thrum_surface_builder builder = {.made = *r->surface, .error = r->error};
  int32_t *v = r->surface->triangles + 3 * t;
  int c = 0;
  while (c < 2 && v[c] != from)
    c++;
  if (v[(c + 1) % 3] != to) // the triangle goes the other way along it
    while (v[c] != to)
      c = (c + 1) % 3;

  // one half keeps the place of the triangle
  const int32_t next = v[(c + 1) % 3], top = v[(c + 2) % 3];
  const int64_t line = r->surface->triangle_line[t];
  v[(c + 1) % 3] = middle;
  const thrum_status status =
      thrum_surface_add_triangle(&builder, (const int32_t[3]){middle, next, top}, line);
  *r->surface = builder.made;
  r->done->split += status >= 0;
  return status;
}

/* Where a point is along a segment, from 0 to 1; -1: not on its inside, or not within reach. */
static double share_on(const repair *r, const double a[3], const double b[3], const double x[3]) {
  double along[3], arm[3], off[3];
  thrum_subtract3(b, a, along);
  thrum_subtract3(x, a, arm);
  const double square = thrum_dot3(along, along), share = thrum_dot3(along, arm) / square;
  if (!(square > 0) || !(share > 0) || !(share < 1))
    return -1;
  for (int c = 0; c < 3; c++)
    off[c] = arm[c] - share * along[c];
  return thrum_dot3(off, off) <= r->reach * r->reach ? share : -1;
}

/* Splits triangles whose open edge runs through a vertex of another one; *more tells that there may
 * be others, since a triangle is split once a pass. */
static thrum_status split_open(repair *r, bool *more) {
  repair_place *places = NULL;
  bool *touched = NULL;
  int64_t count = 0;
  const thrum_surface_mesh *s = r->surface;
  const int64_t triangles = s->triangle_count;
  *more = false;
  thrum_status status = gather_open(r, &places, &count);
  THRUM_THEN(status,
             thrum_reserve(&touched, triangles + 1, sizeof *touched, "the surface", r->error));
  if (status >= 0)
    memset(touched, 0, (size_t)triangles * sizeof *touched);

  for (int64_t n = 0, same; n < 3 * triangles && count > 0 && status >= 0; n += same) {
    const thrum_surface_side side = r->sides[n];
    same = equal_sides(r, n);
    if (same > 1 || touched[side.triangle])
      continue;

    // vertices beyond the ends along x cannot lie on it
    const double *a = place(r, side.low), *b = place(r, side.high);
    const double least = fmin(a[0], b[0]) - r->reach, most = fmax(a[0], b[0]) + r->reach;
    int64_t first = 0;
    for (int64_t low = 0, high = count; low < high; first = low) {
      const int64_t middle = low + (high - low) / 2;
      if (places[middle].x < least)
        low = middle + 1;
      else
        high = middle;
    }

    // the one nearest to the middle, so that passes are few where many lie on one edge
    const int32_t *own = s->triangles + 3 * (int64_t)side.triangle;
    int32_t best = -1;
    double nearest = 1;
    for (int64_t i = first; i < count && places[i].x <= most; i++) {
      const int32_t v = places[i].vertex;
      if (v == own[0] || v == own[1] || v == own[2])
        continue;
      const double share = share_on(r, a, b, place(r, v)), off = fabs(share - 0.5);
      best = share > 0 && off < nearest ? v : best;
      nearest = best == v ? off : nearest;
    }
    if (best < 0)
      continue;
    touched[side.triangle] = *more = true;
    status = split(r, side.triangle, side.low, side.high, best);
  }
  free(places);
  free(touched);
  return status;
}

/* --- triangles without area --------------------------------------------------------------------
 */

/* The corner opposite to the longest side. */
static int middle_corner(const repair *r, int64_t t) {
  const int32_t *v = r->surface->triangles + 3 * t;
  int best = 0;
  double longest = -1;
  for (int c = 0; c < 3; c++) {
    const double side = distance2(place(r, v[(c + 1) % 3]), place(r, v[(c + 2) % 3]));
    best = side > longest ? c : best;
    longest = fmax(longest, side);
  }
  return best;
}

/* Takes a triangle without area away (`any` as below); its middle corner goes to the neighbour at
 * its longest side, which no other one may have touched in this pass. */
static thrum_status flatten(repair *r, int64_t t, bool any, bool *touched, bool *more) {
  const int32_t *v = r->surface->triangles + 3 * t;
  const int c = middle_corner(r, t);
  const int32_t middle = v[c], from = v[(c + 1) % 3], to = v[(c + 2) % 3];
  const int64_t first = find_side(r, from, to), same = equal_sides(r, first);
  if (same > 2)
    return THRUM_OK;
  const int64_t other = same == 1                                ? -1
                        : r->sides[first].triangle == (int32_t)t ? r->sides[first + 1].triangle
                                                                 : r->sides[first].triangle;
  const int32_t *u = other >= 0 ? r->surface->triangles + 3 * other : NULL;
  if (touched[t] || (other >= 0 && touched[other]))
    return THRUM_OK;

  // a neighbour without area is better split by its own neighbour first, so that less is made
  const bool same_corner = u && (u[0] == middle || u[1] == middle || u[2] == middle);
  if (!any && !same_corner && other >= 0 && thrum_surface_is_flat(r->surface, other))
    return THRUM_OK;

  // a neighbour with the same corner lies on the triangle, and both enclose nothing
  touched[t] = *more = true;
  r->done->flat++;
  remove_triangle(r, t);
  if (other < 0)
    return THRUM_OK;
  touched[other] = true;
  if (same_corner) {
    r->done->flat++;
    remove_triangle(r, other);
    return THRUM_OK;
  }
  return split(r, other, from, to, middle);
}

/* One pass over the triangles without area; `any` also splits neighbours that have none. */
static thrum_status mend_flat(repair *r, bool any, bool *more) {
  const int64_t triangles = r->surface->triangle_count;
  bool *touched = NULL;
  *more = false;
  for (int64_t t = 0; t < triangles; t++) {
    const int32_t *v = r->surface->triangles + 3 * t;
    if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
      continue;
    remove_triangle(r, t);
    r->done->flat++;
  }
  drop_gone(r);

  // the sides stay as they were at the beginning of the pass
  THRUM_TRY(sort_sides(r));
  const int64_t count = r->surface->triangle_count;
  THRUM_TRY(thrum_reserve(&touched, count + 1, sizeof *touched, "the surface", r->error));
  memset(touched, 0, (size_t)count * sizeof *touched);
  thrum_status status = THRUM_OK;
  for (int64_t t = 0; t < count && status >= 0; t++)
    if (!touched[t] && thrum_surface_is_flat(r->surface, t))
      status = flatten(r, t, any, touched, more);
  free(touched);
  drop_gone(r);
  return status;
}

/* --- triangles on each other -------------------------------------------------------------------
 */

/* Leaves one of the triangles with the same corners that go round the same way, and none of pairs
 * that go round opposite ways. */
static thrum_status mend_twice(repair *r) {
  thrum_surface_mesh *s = r->surface;
  free(r->sides);
  r->sides = NULL;
  THRUM_TRY(
      thrum_reserve(&r->sides, s->triangle_count + 1, sizeof *r->sides, "the surface", r->error));
  for (int64_t t = 0; t < s->triangle_count; t++) {
    const int32_t *v = s->triangles + 3 * t;
    int c = v[0] < v[1] ? 0 : 1;
    c = v[c] < v[2] ? c : 2;

    // with the smallest corner in front the order of the others tells the way round
    const int32_t a = v[(c + 1) % 3], b = v[(c + 2) % 3];
    r->sides[t] = (thrum_surface_side){v[c], a < b ? a : b, a < b ? b : a, (int32_t)t, a < b};
  }
  thrum_surface_sides_sort(r->sides, s->triangle_count);

  for (int64_t n = 0, end; n < s->triangle_count; n = end) {
    int64_t ways[2] = {0, 0}, kept;
    for (end = n;
         end < s->triangle_count && r->sides[end].low == r->sides[n].low &&
         r->sides[end].high == r->sides[n].high && r->sides[end].third == r->sides[n].third;
         end++)
      ways[r->sides[end].forth]++;
    if (end - n == 1)
      continue;
    kept = ways[0] == ways[1] ? 0 : 1;
    const bool way = ways[1] > ways[0];
    const int64_t pairs = ways[0] < ways[1] ? ways[0] : ways[1];
    r->done->walls += pairs;
    r->done->twice += end - n - 2 * pairs - kept;
    for (int64_t i = n; i < end; i++) {
      const bool keep = kept > 0 && r->sides[i].forth == way;
      kept -= keep;
      if (!keep)
        remove_triangle(r, r->sides[i].triangle);
    }
  }
  drop_gone(r);
  return THRUM_OK;
}

static thrum_status mend(repair *r) {
  bool more = true;
  THRUM_TRY(join_close(r));
  for (int pass = 0; more && pass < ROW_MAX; pass++)
    THRUM_TRY(mend_flat(r, false, &more));
  more = true;
  for (int pass = 0; more && pass < PASSES_MAX; pass++)
    THRUM_TRY(mend_flat(r, true, &more));
  more = true;
  for (int pass = 0; more && pass < PASSES_MAX; pass++)
    THRUM_TRY(split_open(r, &more));
  return mend_twice(r);
}

thrum_status thrum_surface_repair(thrum_surface_mesh *surface, thrum_surface_repairs *repairs,
                                  thrum_error *error) {
  thrum_surface_repairs done = {0};
  repair r = {.surface = surface, .done = &done, .error = error};
  double least[3], most[3];
  int64_t unused = 0;
  thrum_box3(surface->vertices, surface->vertex_count, least, most);
  r.reach = CLOSE * sqrt(distance2(least, most));
  thrum_status status = mend(&r);
  free(r.sides);

  // vertices that are left without a triangle go
  if (status >= 0 && surface->triangle_count > 0)
    status = thrum_surface_join(surface, &unused, error);
  *repairs = done;
  return status;
}
