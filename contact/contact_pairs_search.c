/* Which vertices and triangles, and which edges, of two bodies may touch in a step.
 *
 * Broad phase: the trees of the two skins are descended together, where spheres that hold the nodes
 * over the step may come within the thickness of each other (contact_skin.c). Narrow phase: of two
 * triangles near each other, each vertex and edge that they have to try (representative triangles:
 * Curtis, Tamstorf & Manocha 2008, doi:10.1145/1342250.1342260). Two places that are near already
 * meet in the plane between them now, others in that of the time at which they come near
 * (contact_distance.c). Only vertices and edges that are reached are evaluated, at 6 r each.
 *
 * A vertex meets a triangle from outside; it may lie behind it by less than the thickness, where it
 * was pressed in. Edges meet where both stand out towards the other body: those inside a flat face
 * add nothing to its vertices. On the rim of a triangle only the nearest counts.
 *
 * A body is searched for touches with itself in the same way, by the displacements of its shape
 * alone. Places that share a vertex, and those that are near at rest already, are left out.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_search.h"

#include <math.h>
#include <string.h>

#include "contact/contact_distance.h"
#include "contact/contact_pairs_link.h"
#include "contact/contact_pairs_list.h"
#include "contact/contact_pairs_private.h"
#include "contact/contact_pairs_sort.h"
#include "contact/contact_point.h"
#include "core/base/vec3.h"

#define MARGIN 0.5     /* thicknesses by which a row may miss, and a list reaches further */
#define STANDS_OUT 0.1 /* sine of the angle to its faces from which an edge counts */
#define OWN_BEHIND 1.0 /* the same in one body, where it may be the far side of a thin wall */
#define SHARP 0.3      /* the same of an edge that was pressed in */
#define ASKEW 0.05     /* sine of the angle between two edges from which they count */
#define LEAF_KNOWN 2   /* of a node whose sphere and box are known; 1: its sphere */
#define SLOW 0.5       /* of the slack: bodies that move further in a step have no list */
#define RING_MAX 32    /* triangles near a vertex, of which more are all tried */
#define STACK 128      /* pairs of nodes that wait: twice the depth of two trees is enough */

/* What a search knows of a triangle: nothing, its corners, and its box as well. */
enum { CORNERS_KNOWN = 1, BOX_KNOWN = 2 };

/* Two bodies that are searched, or one with itself. */
typedef struct search {
  thrum_pairs_run *run;
  int64_t members[2];
  const thrum_skin *skins[2];
  thrum_skin_view views[2];
  int32_t numbers[2];
  double thickness;
  double reach;          /* within which boxes are near each other [m] */
  bool stays_flat[2];    /* faces of a side that are flat at rest are so still */
  bool struck;           /* one of them was, by an impact of the step */
  bool wide;             /* nodes are near where boxes in them can be */
  thrum_pair_list *list; /* what is near goes into it; NULL: it is tried */
  bool full;             /* there was no room for it */
  double way;            /* bound of how far two places move against each other [m] */
} search;

/* Position, displacement and the shift in it of a point; place: nine numbers. */
static void fill_way(const thrum_pairs_run *run, const thrum_contact_run *body, const double *rows,
                     const double rest[3], double place[9]) {
  thrum_point_way(body, rows, rest, body->view.sought, place, place + 3);
  memset(place + 6, 0, 3 * sizeof *place);
  if (run->own)
    return;

  // by the body as a whole
  double arm[3], lever[3], turned[3];
  thrum_subtract3(place, body->centre, arm);
  thrum_point_mean_arm(body->sought_turn, arm, lever);
  thrum_cross3(body->sought_turn, lever, turned);
  for (int axis = 0; axis < 3; axis++)
    place[3 + axis] += body->sought[axis] + turned[axis];
  if (!body->impact.struck)
    return;

  // from where it really is
  thrum_point_shift(body, rows, rest, place, place + 6);
  for (int axis = 0; axis < 3; axis++) {
    place[axis] -= place[6 + axis];
    place[3 + axis] += place[6 + axis];
  }
}

const double *thrum_pairs_find_place(thrum_pairs_run *run, int64_t member, int64_t vertex) {
  const int64_t index = run->view.first_vertex[member] + vertex;
  double *place = run->view.places + 9 * index;
  const thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const double *rows = view.rows + 3 * vertex * skin->rank;
  fill_way(run, body, rows, view.rest + 3 * vertex, place);
  run->view.place_known[index] = 1;
  return place;
}

/* The sphere of a node: middle and displacement (3 each), radius over the step, length of the
 * displacement. */
static const double *sphere_of(const search *s, int side, int32_t node) {
  thrum_pairs_run *run = s->run;
  const int64_t index = run->view.first_node[s->members[side]] + node;
  double *sphere = run->view.spheres + 8 * index;
  if (run->view.sphere_known[index])
    return sphere;

  const thrum_contact_run *body = run->view.runs + s->members[side];
  const thrum_skin_view *view = &s->views[side];
  const int64_t r = s->skins[side]->rank;
  const double *rows = view->node_rows + 3 * node * r, *spread = view->spreads + node * r;
  double way[9];
  fill_way(run, body, rows, view->nodes[node].middle, way);
  memcpy(sphere, way, 6 * sizeof *way);

  // it holds its triangles at both ends of the step
  const double *d = body->view.sought, *turn = body->sought_turn;
  double radius = view->nodes[node].radius;
  if (!run->own)
    radius += (sqrt(thrum_dot3(turn, turn)) + body->impact.turned) * radius;
  for (int64_t i = 0; i < r; i++)
    radius += spread[i] * (fabs(body->view.q[i]) + fabs(d[i]));
  sphere[6] = radius;
  sphere[7] = sqrt(thrum_dot3(way + 3, way + 3));
  run->view.sphere_known[index] = 1;
  return sphere;
}

/* Can boxes in two spheres be near each other over the step? */
static bool can_be_near(const search *s, const double p[8], const double q[8]) {
  const double reach = p[6] + p[7] + q[6] + q[7] + s->reach;
  bool near = true;
  for (int axis = 0; axis < 3; axis++)
    near = near && fabs(p[axis] - q[axis]) <= reach;
  return near;
}

/* Do two spheres come within the reach of each other on their ways? */
static bool are_near(const search *s, int32_t a, int32_t b) {
  const double *p = sphere_of(s, 0, a), *q = sphere_of(s, 1, b);
  const double reach = p[6] + q[6] + s->reach;
  double apart[3], way[3];
  if (s->wide)
    return can_be_near(s, p, q);
  thrum_subtract3(p, q, apart);

  // most are near at the start, or further than both can come
  const double now = thrum_dot3(apart, apart), most = reach + p[7] + q[7];
  if (now <= reach * reach || now > most * most)
    return now <= reach * reach;
  thrum_subtract3(p + 3, q + 3, way);
  const double square = thrum_dot3(way, way);
  const double time = square > 0.0 ? fmin(fmax(-thrum_dot3(apart, way) / square, 0.0), 1.0) : 0.0;
  for (int axis = 0; axis < 3; axis++)
    apart[axis] += time * way[axis];
  return thrum_dot3(apart, apart) <= reach * reach;
}

/* Are two nodes of one body, which may be the same, kept apart by how far their places were from
 * each other at rest? No two have moved against each other by more than the middles of the nodes
 * have, and what the spheres have grown by since. */
static bool stay_apart(const search *s, int32_t a, int32_t b) {
  if (!s->skins[0]->own_known)
    return false;
  const thrum_skin_view *view = &s->views[0];
  const double *p = sphere_of(s, 0, a), *q = sphere_of(s, 1, b);

  // how far the middles are from where they would be without deformation, and go in the step
  double rest[3], turned[3], off[3], way[3];
  thrum_subtract3(view->nodes[a].middle, view->nodes[b].middle, rest);
  thrum_apply3(s->run->view.runs[s->members[0]].axes, rest, turned);
  thrum_subtract3(p, q, off);
  thrum_subtract3(off, turned, off);
  thrum_subtract3(p + 3, q + 3, way);

  const double moved = sqrt(thrum_dot3(off, off)) + sqrt(thrum_dot3(way, way));
  const double grown = p[6] - view->nodes[a].radius + q[6] - view->nodes[b].radius;
  const double gap = fmax(view->own_gaps[a], view->own_gaps[b]);
  return gap - moved - grown > (1.0 + MARGIN) * s->thickness;
}

/* --- triangles -------------------------------------------------------------------------------- */

/* The box of some places. */
static thrum_pair_box box_of(const double *const places[], int count) {
  thrum_pair_box b;
  for (int axis = 0; axis < 3; axis++) {
    double least = INFINITY, most = -INFINITY;
    for (int n = 0; n < count; n++) {
      const double start = places[n][axis], end = start + places[n][3 + axis];
      const double low = start < end ? start : end, high = start < end ? end : start;
      least = low < least ? low : least;
      most = high > most ? high : most;
    }
    b.least[axis] = least;
    b.most[axis] = most;
  }
  return b;
}

static bool overlap(const thrum_pair_box *a, const thrum_pair_box *b, double reach) {
  bool any = true;
  for (int axis = 0; axis < 3; axis++)
    any = any && a->least[axis] <= b->most[axis] + reach && b->least[axis] <= a->most[axis] + reach;
  return any;
}

/* The directions in which the faces of an edge lie, at a time: across the edge alone, as how far
 * along it the third vertex lies says nothing of the face. at: a point of the edge; along: its
 * direction. Returns how many there are. */
static int faces_of(const search *s, int side, int32_t edge, const double at[3], double time,
                    const double along[3], double ways[2][3]) {
  const thrum_skin_edge *of = s->views[side].edges + edge;
  int count = 0;
  for (int n = 0; n < 2; n++) {
    if (of->opposite[n] < 0)
      continue;
    const double *place = thrum_pairs_place(s->run, s->members[side], of->opposite[n]);
    double *way = ways[count];
    for (int axis = 0; axis < 3; axis++)
      way[axis] = place[axis] + time * place[3 + axis] - at[axis];
    const double share = thrum_dot3(way, along) / thrum_dot3(along, along);
    for (int axis = 0; axis < 3; axis++)
      way[axis] -= share * along[axis];
    const double length = sqrt(thrum_dot3(way, way));
    if (!(length > 0.0))
      continue;
    for (int axis = 0; axis < 3; axis++)
      way[axis] /= length;
    count++;
  }
  return count;
}

/* Does an edge lie inside a face that is flat at the start of the step? */
static bool is_flat(const search *s, int side, int32_t edge) {
  const thrum_skin_edge *of = s->views[side].edges + edge;
  if (of->opposite[0] < 0 || of->opposite[1] < 0)
    return false;
  const double *x[4];
  const int32_t vertices[4] = {of->ends[0], of->ends[1], of->opposite[0], of->opposite[1]};
  for (int n = 0; n < 4; n++)
    x[n] = thrum_pairs_place(s->run, s->members[side], vertices[n]);
  double across[2][3];
  return thrum_faces_are_flat(x[0], x[1], x + 2, THRUM_SKIN_FLAT, across);
}

/* Fills the corners of a triangle of a member. */
static void find_corners(const search *s, int side, int32_t triangle, thrum_pair_triangle *found) {
  const thrum_skin_triangle *of = s->views[side].triangles + triangle;
  for (int n = 0; n < 3; n++)
    found->places[n] = thrum_pairs_place(s->run, s->members[side], of->corners[n]);
  found->tried = found->flat_known = 0;
  found->faces = -1;
}

/* Whether a triangle is known in this search, and how far. */
static inline int32_t *known_of(const search *s, int side, int32_t triangle) {
  const int64_t member = s->members[side];
  return s->run->view.triangle_known + 2 * (s->run->view.first_node[member] + member) + triangle;
}

/* The triangle with its corners, found once in a search. */
static inline thrum_pair_triangle *corners_of(const search *s, int side, int32_t triangle) {
  int32_t *known = known_of(s, side, triangle);
  thrum_pair_triangle *found = s->run->view.triangles + (known - s->run->view.triangle_known);
  if (*known == 0) {
    find_corners(s, side, triangle, found);
    *known = CORNERS_KNOWN;
  }
  return found;
}

/* The same with its box. */
static inline thrum_pair_triangle *triangle_of(const search *s, int side, int32_t triangle) {
  int32_t *known = known_of(s, side, triangle);
  thrum_pair_triangle *found = corners_of(s, side, triangle);
  if (*known != BOX_KNOWN) {
    found->box = box_of(found->places, 3);
    *known = BOX_KNOWN;
  }
  return found;
}

/* Does a triangle try its edge n? One in a flat face touches nothing that its ends do not. */
static bool tries_edge(const search *s, int side, int32_t triangle, int n,
                       thrum_pair_triangle *found) {
  const thrum_skin_triangle *of = s->views[side].triangles + triangle;
  const int32_t bit = THRUM_SKIN_EDGE << n;
  if (!(of->tried & bit) || (s->stays_flat[side] && (of->tried & (THRUM_SKIN_IN_FACE << n))))
    return false;
  if (!(found->flat_known & bit) && !is_flat(s, side, of->edges[n]))
    found->tried |= bit;
  found->flat_known |= bit;
  return found->tried & bit;
}

/* All edges that it tries. */
static int32_t tried_of(const search *s, int side, int32_t triangle, thrum_pair_triangle *found) {
  for (int n = 0; n < 3; n++)
    tries_edge(s, side, triangle, n, found);
  return found->tried;
}

/* --- two places ------------------------------------------------------------------------------- */

/* Unit normal of a triangle at a time; false where it has no area. */
static bool normal_of(const thrum_quad *quad, double time, double normal[3]) {
  double x[3][3], e[3], f[3];
  for (int n = 0; n < 3; n++)
    for (int axis = 0; axis < 3; axis++)
      x[n][axis] = quad->x[n + 1][axis] + time * quad->d[n + 1][axis];
  thrum_subtract3(x[1], x[0], e);
  thrum_subtract3(x[2], x[0], f);
  thrum_cross3(e, f, normal);
  const double length = sqrt(thrum_dot3(normal, normal));
  for (int axis = 0; axis < 3; axis++)
    normal[axis] /= length;
  return isnormal(length);
}

/* Does a vertex stand out along a direction: does no edge of it lead into that? One inside a flat
 * face that leans over a rim does not, as the face meets the rim elsewhere. */
static bool stands_out(const search *s, int side, int32_t vertex, double time,
                       const double direction[3]) {
  const thrum_skin_view *view = &s->views[side];
  const double *at = thrum_pairs_place(s->run, s->members[side], vertex);
  for (int32_t n = view->ring_begins[vertex]; n < view->ring_begins[vertex + 1]; n++) {
    const double *other = thrum_pairs_place(s->run, s->members[side], view->rings[n]);
    double way[3];
    for (int axis = 0; axis < 3; axis++)
      way[axis] = other[axis] + time * other[3 + axis] - at[axis] - time * at[3 + axis];
    const double along = thrum_dot3(way, direction);
    if (along > 0.0 && along * along > STANDS_OUT * STANDS_OUT * thrum_dot3(way, way))
      return false;
  }
  return true;
}

/* The normal on a triangle towards a vertex that lies outside, or inside by less than the
 * thickness; false where it does not. */
static bool face_normal(const search *s, const thrum_quad *quad, double time,
                        const thrum_nearest *nearest, const thrum_pair_candidate *candidate,
                        thrum_pair_triangle *triangle, double normal[3], double *apart) {
  double later[3];
  const double *face = time == 0.0 ? triangle->normal : later;
  if (time != 0.0 && !normal_of(quad, time, later))
    return false;

  // its corners are the last three of the four
  if (time == 0.0 && triangle->faces < 0)
    triangle->faces = normal_of(quad, 0.0, triangle->normal);
  if (time == 0.0 && !triangle->faces)
    return false;
  const double outside = thrum_dot3(face, nearest->apart);

  // over the triangle itself the face counts, which also holds for a vertex that was pressed in
  if (nearest->inside || nearest->distance < THRUM_MET * s->thickness) {
    memcpy(normal, face, 3 * sizeof *face);
    *apart = outside;
    const double behind = s->run->own ? OWN_BEHIND : THRUM_NEAR;
    return outside > (time > 0.0 ? 0.0 : -behind * s->thickness);
  }

  // beyond its rim the nearest point of the rim
  if (!(outside > 0.0))
    return false;
  for (int axis = 0; axis < 3; axis++)
    normal[axis] = nearest->apart[axis] / nearest->distance;
  *apart = nearest->distance;

  // the vertex looks back along it
  const double back[3] = {-normal[0], -normal[1], -normal[2]};
  const int side = candidate->key.kind == THRUM_PAIR_REVERSE;
  return stands_out(s, side, candidate->vertices[0], time, back);
}

/* Where an edge's faces lie: the least and the largest sine of the angle between them and the plane
 * across `normal`, positive on its side; `into` gets their mean direction. along: the edge. */
static void angles_of(const search *s, int side, int32_t edge, const double at[3], double time,
                      const double along[3], const double normal[3], double *least, double *most,
                      double into[3]) {
  double ways[2][3];
  const int count = faces_of(s, side, edge, at, time, along, ways);
  *least = INFINITY;
  *most = -INFINITY;
  memset(into, 0, 3 * sizeof *into);
  for (int n = 0; n < count; n++) {
    const double sine = thrum_dot3(ways[n], normal);
    for (int axis = 0; axis < 3; axis++)
      into[axis] += ways[n][axis];
    *least = fmin(*least, sine);
    *most = fmax(*most, sine);
  }
}

/* The normal between two edges that stand out towards each other; false where they do not. */
static bool edge_normal(const search *s, const thrum_quad *quad, double time,
                        const thrum_nearest *nearest, const int32_t edges[2], double normal[3],
                        double *apart) {
  if (!nearest->inside)
    return false;
  double x[4][3], u[3], v[3], at[2][3], into[2][3], least[2], most[2];
  for (int n = 0; n < 4; n++)
    for (int axis = 0; axis < 3; axis++)
      x[n][axis] = quad->x[n][axis] + time * quad->d[n][axis];
  thrum_subtract3(x[1], x[0], u);
  thrum_subtract3(x[3], x[2], v);
  thrum_cross3(u, v, normal);
  const double length = sqrt(thrum_dot3(normal, normal));
  if (length < ASKEW * sqrt(thrum_dot3(u, u) * thrum_dot3(v, v)))
    return false;
  for (int axis = 0; axis < 3; axis++) {
    normal[axis] /= length;
    at[0][axis] = nearest->weights[0] * x[0][axis] + nearest->weights[1] * x[1][axis];
    at[1][axis] = nearest->weights[2] * x[2][axis] + nearest->weights[3] * x[3][axis];
  }

  // it points out of the second body and into the first
  for (int side = 0; side < 2; side++)
    angles_of(s, side, edges[side], at[side], time, side == 0 ? u : v, normal, least + side,
              most + side, into[side]);
  if (thrum_dot3(normal, into[0]) - thrum_dot3(normal, into[1]) < 0.0) {
    for (int axis = 0; axis < 3; axis++)
      normal[axis] = -normal[axis];
    for (int side = 0; side < 2; side++) {
      const double kept = -least[side];
      least[side] = -most[side];
      most[side] = kept;
    }
  }

  // no face of either in front of the plane between them, and one of each behind it
  *apart = thrum_dot3(normal, nearest->apart);
  const double sharp = *apart > 0.0 ? STANDS_OUT : SHARP;
  return least[0] > -STANDS_OUT && most[0] > sharp && most[1] < STANDS_OUT && -least[1] > sharp &&
         *apart > (time > 0.0 ? 0.0 : -s->thickness);
}

/* Are two places of one body so near at rest that they do not count as touching? */
static bool is_left_out(const search *s, thrum_quad_kind kind,
                        const thrum_pair_candidate *candidate) {
  static const double still[3] = {0.0, 0.0, 0.0};
  thrum_quad rest;
  for (int n = 0; n < 4; n++) {
    rest.x[n] = s->views[0].rest + 3 * (int64_t)candidate->vertices[n];
    rest.d[n] = still;
  }
  return thrum_quad_nearest(kind, &rest, 0.0).distance <= THRUM_NEAR * s->thickness;
}

/* Two places of a vertex and a triangle or of two edges, which are so near at the start of the
 * step: a candidate where they may touch. The other of `triangle` and `edges` is NULL. */
static void try_quad(search *s, thrum_quad_kind kind, const thrum_quad *quad, thrum_nearest nearest,
                     thrum_pair_candidate *candidate, thrum_pair_triangle *triangle,
                     const int32_t edges[2]) {
  thrum_pairs_run *run = s->run;
  const double reach = (1.0 + MARGIN) * s->thickness;
  double time = 0.0;

  // how far they move matters to what does not touch yet
  const double here = nearest.distance;
  const bool near = here <= s->thickness || (here <= reach && s->way <= here);
  const double motion = near ? 0.0 : thrum_quad_motion(kind, quad);
  if (here > reach + motion || (run->own && is_left_out(s, kind, candidate)))
    return;

  // what is near already meets as it is now, unless it moves far within the step
  if (here > s->thickness && (here > THRUM_NEAR * s->thickness || motion > here)) {
    time = thrum_quad_meets(kind, quad, s->thickness);
    if (time > 1.0)
      return;
    nearest = thrum_quad_nearest(kind, quad, time);
  }

  double apart = 0.0;
  if (!(kind == THRUM_VERTEX_TRIANGLE
            ? face_normal(s, quad, time, &nearest, candidate, triangle, candidate->normal, &apart)
            : edge_normal(s, quad, time, &nearest, edges, candidate->normal, &apart)))
    return;

  // back to the start along the normal, as the row has it
  double way = 0.0;
  for (int n = 0; n < 4; n++) {
    const double sign = n == 0 || (n == 1 && kind == THRUM_EDGE_EDGE) ? 1.0 : -1.0;
    way += sign * nearest.weights[n] * thrum_dot3(candidate->normal, quad->d[n]);
  }
  candidate->apart = apart - time * way;
  if (fmin(candidate->apart, candidate->apart + way) > reach)
    return;
  if (run->candidate_count == 2 * run->pairs->touch_max) {
    run->history->dropped++;
    return;
  }
  memcpy(candidate->weights, nearest.weights, sizeof candidate->weights);
  candidate->inside = nearest.inside;
  candidate->slow = s->way < INFINITY && !s->struck;
  candidate->least = fabs(apart);
  run->view.candidates[run->candidate_count++] = *candidate;
}

/* A vertex of `side` against a triangle of the other side. known: the closest points at the start
 * of the step, or NULL. */
static void try_vertex(search *s, int side, int32_t vertex, int32_t triangle,
                       const thrum_nearest *known) {
  const int other = 1 - side;
  const int32_t *corners = s->views[other].triangles[triangle].corners;
  if (s->run->own && (vertex == corners[0] || vertex == corners[1] || vertex == corners[2]))
    return;
  thrum_pair_candidate candidate = {
      .key = {{s->numbers[0], s->numbers[1]},
              side == 0 || s->run->own ? THRUM_PAIR_VERTEX : THRUM_PAIR_REVERSE,
              vertex,
              triangle},
      .members = {(int32_t)s->members[side], (int32_t)s->members[other]},
      .vertices = {vertex, corners[0], corners[1], corners[2]}};

  // the ways of the four vertices through the step
  thrum_quad quad;
  for (int n = 0; n < 4; n++) {
    quad.x[n] = thrum_pairs_place(s->run, candidate.members[n > 0], candidate.vertices[n]);
    quad.d[n] = quad.x[n] + 3;
  }
  const thrum_nearest nearest =
      known != NULL ? *known : thrum_quad_nearest(THRUM_VERTEX_TRIANGLE, &quad, 0.0);
  try_quad(s, THRUM_VERTEX_TRIANGLE, &quad, nearest, &candidate, corners_of(s, other, triangle),
           NULL);
}

static bool have_common_end(const thrum_skin_edge *a, const thrum_skin_edge *b) {
  return a->ends[0] == b->ends[0] || a->ends[0] == b->ends[1] || a->ends[1] == b->ends[0] ||
         a->ends[1] == b->ends[1];
}

static void try_edges(search *s, int32_t a, int32_t b) {
  const thrum_skin_edge *first = s->views[0].edges + a, *second = s->views[1].edges + b;
  const int32_t edges[2] = {a, b};
  if (s->run->own && have_common_end(first, second))
    return;

  // the ways of their four ends through the step
  thrum_pair_candidate candidate = {
      .key = {{s->numbers[0], s->numbers[1]}, THRUM_PAIR_EDGES, a, b},
      .members = {(int32_t)s->members[0], (int32_t)s->members[1]},
      .vertices = {first->ends[0], first->ends[1], second->ends[0], second->ends[1]}};
  thrum_quad quad;
  for (int n = 0; n < 4; n++) {
    quad.x[n] = thrum_pairs_place(s->run, candidate.members[n > 1], candidate.vertices[n]);
    quad.d[n] = quad.x[n] + 3;
  }
  try_quad(s, THRUM_EDGE_EDGE, &quad, thrum_quad_nearest(THRUM_EDGE_EDGE, &quad, 0.0), &candidate,
           NULL, edges);
}

/* Notes two places in the list. */
static void note(search *s, int32_t kind, int32_t first, int32_t second) {
  if (!thrum_pairs_list_add(s->run, s->list, kind, first, second))
    s->full = true;
}

/* The same in a search; all of them where a list is made, as faces may bend while it holds. */
static int32_t tries(const search *s, int side, int32_t triangle, thrum_pair_triangle *found) {
  return s->list != NULL ? s->views[side].triangles[triangle].tried
                         : tried_of(s, side, triangle, found);
}

/* Edge n of a triangle as a box. */
static thrum_pair_box box_of_edge(const thrum_pair_triangle *found, int n) {
  const double *const ends[2] = {found->places[n], found->places[(n + 1) % 3]};
  return box_of(ends, 2);
}

/* The edges of two triangles that may touch, of those that these try. */
static void try_all_edges(search *s, const int32_t triangles[2],
                          const thrum_pair_triangle *const found[2], const int32_t tried[2]) {
  const thrum_skin_triangle *first = s->views[0].triangles + triangles[0];
  const thrum_skin_triangle *second = s->views[1].triangles + triangles[1];

  // each pair of edges is tried by one pair of triangles alone
  for (int n = 0; n < 3; n++) {
    if (!(tried[0] & (THRUM_SKIN_EDGE << n)))
      continue;
    const thrum_pair_box box = box_of_edge(found[0], n);
    for (int m = 0; m < 3; m++) {
      if (!(tried[1] & (THRUM_SKIN_EDGE << m)))
        continue;
      const thrum_pair_box other = box_of_edge(found[1], m);
      if (!overlap(&box, &other, s->reach))
        continue;
      if (s->list != NULL) {
        note(s, THRUM_PAIR_EDGES, 3 * triangles[0] + n, 3 * triangles[1] + m);
        continue;
      }

      // in one body the lower edge comes first, so that a touch has one key from step to step
      const int32_t a = first->edges[n], b = second->edges[m];
      const bool turn = s->run->own && b < a;
      try_edges(s, turn ? b : a, turn ? a : b);
    }
  }
}

/* The box of a leaf, found once in a search with its triangles. */
static const thrum_pair_box *box_of_leaf(const search *s, int side, int32_t node) {
  const int64_t index = s->run->view.first_node[s->members[side]] + node;
  const thrum_skin_node *leaf = s->views[side].nodes + node;
  thrum_pair_box *box = s->run->view.boxes + index;
  if (s->run->view.sphere_known[index] == LEAF_KNOWN)
    return box;

  // it holds the boxes of all its triangles
  *box = triangle_of(s, side, leaf->first)->box;
  for (int32_t n = 1; n < leaf->count; n++) {
    const thrum_pair_box *of = &triangle_of(s, side, leaf->first + n)->box;
    for (int axis = 0; axis < 3; axis++) {
      box->least[axis] = of->least[axis] < box->least[axis] ? of->least[axis] : box->least[axis];
      box->most[axis] = of->most[axis] > box->most[axis] ? of->most[axis] : box->most[axis];
    }
  }
  s->run->view.sphere_known[index] = LEAF_KNOWN;
  return box;
}

/* The vertices that a triangle of `side` tries, against the triangles of a leaf of the other side.
 */
static void try_vertices(search *s, int side, int32_t triangle, const thrum_pair_triangle *found,
                         const thrum_skin_node *leaf, const thrum_pair_box *whole) {
  const thrum_skin_triangle *of = s->views[side].triangles + triangle;
  const thrum_pair_triangle *others = triangle_of(s, 1 - side, leaf->first);
  for (int n = 0; n < 3; n++) {
    if (!(of->tried & (1 << n)))
      continue;
    const thrum_pair_box box = box_of(found->places + n, 1);
    if (!overlap(&box, whole, s->reach))
      continue;
    for (int32_t m = 0; m < leaf->count; m++) {
      if (!overlap(&box, &others[m].box, s->reach))
        continue;
      if (s->list != NULL)
        note(s, side == 0 ? THRUM_PAIR_VERTEX : THRUM_PAIR_REVERSE, of->corners[n],
             leaf->first + m);
      else
        try_vertex(s, side, of->corners[n], leaf->first + m, NULL);
    }
  }
}

/* The triangles of two leaves, or of one with each other. */
static void try_leaves(search *s, int32_t a, int32_t b) {
  const bool same = s->run->own && a == b;
  const thrum_skin_node *p = s->views[0].nodes + a, *q = s->views[1].nodes + b;
  const thrum_pair_box *whole = box_of_leaf(s, 0, a), *other = box_of_leaf(s, 1, b);
  if (!overlap(whole, other, s->reach))
    return;

  // the vertices of either side
  thrum_pair_triangle *first = triangle_of(s, 0, p->first), *second = triangle_of(s, 1, q->first);
  for (int32_t m = 0; m < q->count && !same; m++)
    if (overlap(&second[m].box, whole, s->reach))
      try_vertices(s, 1, q->first + m, second + m, p, whole);
  for (int32_t n = 0; n < p->count; n++) {
    if (!overlap(&first[n].box, other, s->reach))
      continue;
    try_vertices(s, 0, p->first + n, first + n, q, other);

    // edges where both triangles have some
    int32_t tried[2] = {tries(s, 0, p->first + n, first + n), 0};
    for (int32_t m = same ? n + 1 : 0; m < q->count && tried[0] > 7; m++) {
      const int32_t triangles[2] = {p->first + n, q->first + m};
      const thrum_pair_triangle *const found[2] = {first + n, second + m};
      tried[1] = tries(s, 1, triangles[1], second + m);
      if (tried[1] > 7 && overlap(&first[n].box, &second[m].box, s->reach))
        try_all_edges(s, triangles, found, tried);
    }
  }
}

/* Two nodes whose triangles are to be tried against each other. */
typedef int32_t node_pair[2];

/* Opens a node of one body that is to be tried against itself: each half with itself, and both with
 * each other; returns how many pairs there are then. */
static int open_own(const thrum_skin_node *node, node_pair *stack, int count) {
  const int32_t halves[3][2] = {
      {node->left, node->right}, {node->right, node->right}, {node->left, node->left}};
  memcpy(stack + count, halves, sizeof halves);
  return count + 3;
}

/* Descends both trees. */
static void descend(search *s) {
  node_pair stack[STACK];
  int count = 0;
  stack[count][0] = stack[count][1] = 0;
  count++;
  while (count > 0) {
    const int32_t a = stack[--count][0], b = stack[count][1];
    const thrum_skin_node *p = s->views[0].nodes + a, *q = s->views[1].nodes + b;
    const bool same = s->run->own && a == b;
    if ((!same && !are_near(s, a, b)) || (s->run->own && stay_apart(s, a, b)))
      continue;
    if (same && p->left >= 0) {
      count = open_own(p, stack, count);
      continue;
    }
    if (p->left < 0 && q->left < 0) {
      try_leaves(s, a, b);
      continue;
    }

    // the larger of the two is opened
    const bool first = q->left < 0 || (p->left >= 0 && p->radius >= q->radius);
    for (int half = 0; half < 2; half++) {
      stack[count][0] = !first ? a : half ? p->left : p->right;
      stack[count][1] = first ? b : half ? q->left : q->right;
      count++;
    }
  }
}

/* --- lists ------------------------------------------------------------------------------------ */

/* The place in the order of keys of what an entry names on a side. */
static int32_t named_by(const search *s, const thrum_pair_entry *entry, int side) {
  const int32_t named = side == 0 ? entry->first : entry->second;
  return entry->kind == THRUM_PAIR_EDGES ? s->views[side].triangles[named / 3].edges[named % 3]
                                         : named;
}

/* Does an entry come before another one in the order of keys? */
static bool is_before(const search *s, const thrum_pair_entry *a, const thrum_pair_entry *b) {
  if (a->kind != b->kind)
    return a->kind < b->kind;
  const int32_t first = named_by(s, a, 0), other = named_by(s, b, 0);
  return first != other ? first < other : named_by(s, a, 1) < named_by(s, b, 1);
}

/* Sorts the entries of a list by what their keys will be (Shell 1959), so that candidates need not
 * be, and counts those of each place. */
static void sort_list(const search *s, const thrum_pair_list *list) {
  thrum_pair_entry *entries = s->run->view.entries + list->from;
  int64_t gap = 1;
  while (gap < list->count / 9)
    gap = 3 * gap + 1;
  for (; gap > 0; gap /= 3)
    for (int64_t n = gap; n < list->count; n++) {
      const thrum_pair_entry moved = entries[n];
      int64_t to = n;
      for (; to >= gap && is_before(s, &moved, entries + to - gap); to -= gap)
        entries[to] = entries[to - gap];
      entries[to] = moved;
    }

  // where each place has its last entry is known from behind
  for (int64_t n = list->count - 2; n >= 0; n--) {
    const bool same =
        entries[n].first == entries[n + 1].first && entries[n].kind == entries[n + 1].kind;
    entries[n].alike = same ? entries[n + 1].alike + 1 : 1;
  }
}

/* A list of two members, which have none that holds; NULL: there is no room for it. */
static thrum_pair_list *make_list(search *s) {
  // where there is no room the lists of others are given up for it, once
  for (int turn = 0; turn < 2; turn++) {
    s->list = thrum_pairs_list_open(s->run, s->members[0], s->members[1], s->thickness, turn > 0);
    s->full = s->list == NULL;

    // a descent within the wider reach fills the list in place of trying what it finds
    s->reach = (1.0 + 2.0 * MARGIN) * s->thickness;
    if (!s->full)
      descend(s);
    thrum_pair_list *made = s->list;
    s->list = NULL;
    s->reach = (1.0 + MARGIN) * s->thickness;
    if (s->full)
      continue;

    thrum_pairs_list_close(s->run, made);
    sort_list(s, made);
    return made;
  }
  return NULL;
}

/* The edge of a side that an entry names; -1: it lies inside a flat face. */
static int32_t edge_of(const search *s, int side, int32_t named, thrum_pair_triangle *found) {
  const int n = named % 3;
  return tries_edge(s, side, named / 3, n, found) ? s->views[side].triangles[named / 3].edges[n]
                                                  : -1;
}

/* The edges of a list that are near one edge. */
static void try_listed_edges(search *s, const thrum_pair_entry *entry, int64_t count) {
  thrum_pair_triangle *first = corners_of(s, 0, entry->first / 3);
  const int32_t a = edge_of(s, 0, entry->first, first);
  if (a < 0)
    return;
  const thrum_pair_box box = box_of_edge(first, entry->first % 3);
  for (int64_t n = 0; n < count; n++) {
    thrum_pair_triangle *second = corners_of(s, 1, entry[n].second / 3);
    const int32_t b = edge_of(s, 1, entry[n].second, second);
    if (b < 0)
      continue;
    const thrum_pair_box other = box_of_edge(second, entry[n].second % 3);
    if (overlap(&box, &other, s->reach))
      try_edges(s, a, b);
  }
}

/* A triangle that is near a vertex of a list, and the weights of their closest point. */
typedef struct neighbour {
  int32_t triangle;
  bool inside;
  double weights[3];
} neighbour;

/* A vertex of a list and the triangles near it. */
typedef struct ring {
  int side;       /* of the vertex */
  int32_t vertex; /* in the skin */
  int64_t from;   /* the first candidate of the vertex */
  int64_t count;
  neighbour around[RING_MAX];
} ring;

static int side_of(const thrum_pair_entry *entry) {
  return entry->kind == THRUM_PAIR_REVERSE;
}

/* Fills the triangles of the ring. */
static void find_ring(const search *s, const thrum_pair_entry *entries, ring *r) {
  const double *at = thrum_pairs_place(s->run, s->members[r->side], r->vertex);
  for (int64_t n = 0; n < r->count; n++) {
    neighbour *next = r->around + n;
    next->triangle = entries[n].second;
    const double *const *x = corners_of(s, 1 - r->side, next->triangle)->places;
    next->inside = thrum_triangle_closest(at, x[0], x[1], x[2], next->weights);
  }
}

/* Tries the vertex of the ring against one of its triangles. */
static void try_neighbour(search *s, const ring *r, const neighbour *of) {
  const double *at = thrum_pairs_place(s->run, s->members[r->side], r->vertex);
  const double *const *x = corners_of(s, 1 - r->side, of->triangle)->places;
  const double *const quad[4] = {at, x[0], x[1], x[2]};
  const double furthest = s->reach + s->way / THRUM_SURE;
  const thrum_nearest nearest = thrum_vertex_nearest(quad, of->weights, of->inside);
  if (thrum_dot3(nearest.apart, nearest.apart) > furthest * furthest)
    return;

  // boxes of places within the reach overlap, and those of others may
  if (nearest.distance >= THRUM_SURE * s->reach) {
    const thrum_pair_box box = box_of(&at, 1);
    if (!overlap(&box, &triangle_of(s, 1 - r->side, of->triangle)->box, s->reach))
      return;
  }
  try_vertex(s, r->side, r->vertex, of->triangle, &nearest);
}

/* Do the corners of a triangle have one in common with those of a candidate of the ring so far? */
static bool shares_corner(const search *s, const ring *r, int32_t triangle, int64_t to) {
  const int32_t *corners = s->views[1 - r->side].triangles[triangle].corners;
  bool shares = false;
  for (int64_t n = r->from; n < to; n++)
    for (int m = 1; m < 4; m++) {
      const int32_t other = s->run->view.candidates[n].vertices[m];
      shares = shares || other == corners[0] || other == corners[1] || other == corners[2];
    }
  return shares;
}

/* Tries the triangles that the vertex is over, and of the others those alone that have no corner in
 * common with one that it touches: all others would be on a rim, for which such a one speaks
 * (is_spoken_for). False where one of them might have spoken for another one; then all have to be
 * tried. */
static bool try_over(search *s, const ring *r) {
  thrum_pairs_run *run = s->run;
  for (int64_t n = 0; n < r->count; n++)
    if (r->around[n].inside)
      try_neighbour(s, r, r->around + n);

  // one behind a face may be spoken for by any other
  const int64_t over = run->candidate_count;
  bool sure = over > r->from;
  for (int64_t n = r->from; n < over; n++)
    sure = sure && run->view.candidates[n].apart >= 0.0;
  for (int64_t n = 0; n < r->count && sure; n++)
    if (!r->around[n].inside && !shares_corner(s, r, r->around[n].triangle, over)) {
      try_neighbour(s, r, r->around + n);
      sure = run->candidate_count == over;
    }
  return sure;
}

/* The triangles of a list that are near one vertex, of which there are few. */
static void try_ring(search *s, const thrum_pair_entry *entries, int64_t count) {
  thrum_pairs_run *run = s->run;
  const int64_t dropped = run->history->dropped;
  ring r;
  r.side = side_of(entries);
  r.vertex = entries->first;
  r.count = count;
  r.from = run->candidate_count;
  find_ring(s, entries, &r);
  if (count > 1 && try_over(s, &r))
    return;

  // all of them
  run->candidate_count = r.from;
  run->history->dropped = dropped;
  for (int64_t n = 0; n < count; n++)
    try_neighbour(s, &r, r.around + n);
}

/* The same where there are any number of them. */
static void try_listed_vertex(search *s, const thrum_pair_entry *entries, int64_t count) {
  if (count <= RING_MAX) {
    try_ring(s, entries, count);
    return;
  }

  // more than a ring has room for are tried one by one
  const int side = side_of(entries);
  const double *place = thrum_pairs_place(s->run, s->members[side], entries->first);
  const thrum_pair_box box = box_of(&place, 1);
  for (int64_t n = 0; n < count; n++)
    if (overlap(&box, &triangle_of(s, 1 - side, entries[n].second)->box, s->reach))
      try_vertex(s, side, entries->first, entries[n].second, NULL);
}

/* Tries the places in a list. */
static void try_list(search *s, const thrum_pair_list *list) {
  const thrum_pair_entry *entries = s->run->view.entries + list->from;
  for (int64_t n = 0, count; n < list->count; n += count) {
    count = entries[n].alike;
    if (entries[n].kind == THRUM_PAIR_EDGES)
      try_listed_edges(s, entries + n, count);
    else
      try_listed_vertex(s, entries + n, count);
  }
}

/* Searches two members: slow ones by a list, from step to step. */
static void search_two(search *s) {
  const thrum_contact_run *a = s->run->view.runs + s->members[0];
  const thrum_contact_run *b = s->run->view.runs + s->members[1];
  const double slack = MARGIN * s->thickness;
  const double way =
      thrum_pairs_way_bound(s->run, s->members[0]) + thrum_pairs_way_bound(s->run, s->members[1]);
  s->wide = way <= SLOW * slack;
  s->struck = a->impact.struck || b->impact.struck;
  if (!s->wide) {
    descend(s);
    return;
  }
  s->way = way;

  // there are far more pairs that are apart than lists
  if (!are_near(s, 0, 0))
    return;

  // what a list has is what a search finds
  const thrum_pair_list *list =
      thrum_pairs_list_find(s->run, s->members[0], s->members[1], s->thickness, way, slack);
  if (list == NULL)
    list = make_list(s);
  if (list != NULL)
    try_list(s, list);
  else
    descend(s);
}

/* --- pruning ---------------------------------------------------------------------------------- */

/* Is the candidate one of a vertex whose other candidate speaks for it? */
static bool is_spoken_for(const thrum_pair_candidate *c, const thrum_pair_candidate *by) {
  // an inside that is further than an outside is the far face of a thin body
  if (c->apart < 0.0 && by->apart >= 0.0 && by->least < c->least)
    return true;
  if (c->inside)
    return false;

  // a rim counts where nothing is nearer that shares it
  if (!by->inside && !(by->least < c->least) &&
      !(by->least == c->least && by->key.second < c->key.second))
    return false;
  bool shares = false;
  for (int n = 1; n < 4; n++)
    for (int m = 1; m < 4; m++)
      shares = shares || c->vertices[n] == by->vertices[m];
  return shares;
}

static bool is_same_vertex(const thrum_pair_key *a, const thrum_pair_key *b) {
  return a->bodies[0] == b->bodies[0] && a->bodies[1] == b->bodies[1] && a->kind == b->kind &&
         a->first == b->first && a->kind != THRUM_PAIR_EDGES;
}

/* Keeps in view.order the candidates that no other speaks for, ascending by their keys. */
static void prune(thrum_pairs_run *run) {
  const thrum_pair_candidate *c = run->view.candidates;
  int32_t *order = run->view.order;
  const int64_t count = run->candidate_count;
  thrum_pairs_sort(c, sizeof *c, count, order, run->view.sorting);

  // the candidates of one vertex follow each other; what is dropped is marked first
  for (int64_t from = 0, to; from < count; from = to) {
    for (to = from + 1; to < count; to++)
      if (!is_same_vertex(&c[order[from]].key, &c[order[to]].key))
        break;
    for (int64_t n = from; n < to; n++) {
      thrum_pair_candidate *of = run->view.candidates + order[n];
      for (int64_t m = from; m < to && !of->pruned; m++)
        of->pruned = n != m && is_spoken_for(of, c + order[m]);
    }
  }
  int64_t kept = 0;
  for (int64_t n = 0; n < count; n++)
    if (!c[order[n]].pruned)
      order[kept++] = order[n];
  run->candidate_count = kept;
}

/* Forgets the candidates so far that others speak for, of pairs of members that have been searched:
 * what touches is far less than what is near. */
static void make_room(thrum_pairs_run *run) {
  thrum_pair_candidate *c = run->view.candidates;
  const int64_t count = run->candidate_count;
  int64_t kept = 0;
  prune(run);
  for (int64_t n = 0; n < count; n++)
    if (!c[n].pruned)
      c[kept++] = c[n];
  run->candidate_count = kept;
}

/* Are the faces of a member that are flat at rest hardly bent? By the linear part of their angles;
 * what turns and stretches them adds its square to that, as what is turned is bent by a stretch. */
static bool stays_flat(const thrum_pairs_run *run, int64_t member) {
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  double bent = 0.0, tilted = 0.0;
  for (int64_t i = 0; i < skin->rank; i++) {
    const double q = fabs(run->view.runs[member].view.q[i]);
    bent += view.bends[i] * q;
    tilted += view.tilts[i] * q;
  }
  return bent + tilted * tilted < THRUM_SKIN_FLATTER * THRUM_SKIN_FLAT;
}

/* Two members to search, which may be one. */
static search search_of(thrum_pairs_run *run, int64_t a, int64_t b) {
  search s = {.run = run,
              .members = {a, b},
              .skins = {run->members[a].skin, run->members[b].skin},
              .numbers = {run->members[a].number, run->members[b].number}};
  s.views[0] = thrum_skin_view_of(s.skins[0]);
  s.views[1] = thrum_skin_view_of(s.skins[1]);
  s.thickness = thrum_pairs_thickness(run->pairs, s.skins[0], s.skins[1]);
  s.reach = (1.0 + MARGIN) * s.thickness;
  s.way = INFINITY;
  for (int side = 0; side < 2; side++)
    s.stays_flat[side] = stays_flat(run, s.members[side]);
  return s;
}

static void forget_places(thrum_pairs_run *run) {
  memset(run->view.place_known, 0,
         (size_t)run->view.first_vertex[run->count] * sizeof *run->view.place_known);
  memset(run->view.sphere_known, 0,
         (size_t)run->view.first_node[run->count] * sizeof *run->view.sphere_known);
  memset(run->view.triangle_known, 0,
         (size_t)(run->view.first_node[run->count] + run->count) * 2 *
             sizeof *run->view.triangle_known);
}

/* Searches the members that may touch themselves. */
static void search_own(thrum_pairs_run *run) {
  bool any = false;
  for (int64_t n = 0; n < run->count; n++) {
    if (!thrum_pairs_steps(run, n) || run->members[n].skin == NULL ||
        !run->members[n].touches_itself)
      continue;
    any = run->own = true;
    search s = search_of(run, n, n);
    descend(&s);
  }

  // places for other bodies are by the motion of the body as a whole too
  run->own = false;
  if (any)
    forget_places(run);
}

/* May two members of a group touch each other? */
static bool may_touch(const thrum_contact_member *a, const thrum_contact_member *b) {
  if (a->status < 0 || b->status < 0 || a->skin == NULL || b->skin == NULL)
    return false;
  if (a->solid != NULL || b->solid != NULL)
    return a->solid == NULL || b->solid == NULL;
  return !a->passes_bodies && !b->passes_bodies;
}

void thrum_pairs_search(thrum_pairs_run *run) {
  run->candidate_count = 0;
  forget_places(run);
  search_own(run);

  // all pairs of members that may touch; spheres of whole bodies answer for most
  int64_t full = run->pairs->touch_max;
  for (int64_t a = 0; a < run->count; a++)
    for (int64_t b = a + 1; b < run->count; b++) {
      if (!may_touch(run->members + a, run->members + b) || thrum_links_join(run, a, b))
        continue;
      search s = search_of(run, a, b);
      search_two(&s);
      if (run->candidate_count <= full)
        continue;
      make_room(run);
      full = run->candidate_count + run->pairs->touch_max / 2;
    }
  prune(run);
}
