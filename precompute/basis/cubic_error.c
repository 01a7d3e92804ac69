/* The error of ten-node tetrahedra by hierarchical functions (precompute/basis/hierarchy.h).
 * Twenty-node tetrahedra of third degree are ten-node ones with l_a l_b (l_a - l_b) on each edge
 * and l_a l_b l_c on each face. An edge has its sign from the numbers of its ends. Both kinds of
 * integrals are sums over the points of the ten-node tets: that of the mass misses a little of what
 * is added, which the frequency hardly feels.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/cubic_error.h"

#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "platform/allocate.h"

enum { NODES = THRUM_QUADRATIC_NODES, EDGES = THRUM_QUADRATIC_EDGES, FACES = 4 };
enum { ADDED = EDGES + FACES, ALL = NODES + ADDED };

/* The corners of each face, and its edges. */
static const int face_corners[FACES][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
static const int face_edges[FACES][3] = {{1, 4, 5}, {2, 3, 5}, {0, 3, 4}, {0, 1, 2}};

/* A face of a tet, by its corners in ascending order. */
typedef struct tet_face {
  int32_t corner[3];
  int64_t place; /* ADDED t + EDGES + face */
} tet_face;

/* What the larger space is of. */
typedef struct cubic_problem {
  const thrum_fem *fem;
  int32_t *added; /* tet_count x ADDED: the functions of its edges, then of its faces */
} cubic_problem;

static int compare_faces(const void *left, const void *right) {
  const tet_face *a = left, *b = right;
  for (int i = 0; i < 3; i++)
    if (a->corner[i] != b->corner[i])
      return a->corner[i] < b->corner[i] ? -1 : 1;
  return (a->place > b->place) - (a->place < b->place);
}

static void swap_down(int32_t *a, int32_t *b) {
  if (*a <= *b)
    return;
  const int32_t kept = *a;
  *a = *b;
  *b = kept;
}

/* Numbers the functions: an edge is known by its middle node, a face by its corners. seen:
 * vertex_count; faces: FACES tet_count. Returns how many there are. */
static int32_t number_added(cubic_problem *s, int32_t *seen, tet_face *faces) {
  const thrum_fem *fem = s->fem;
  const int64_t tets = fem->tet_count;
  int32_t count = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++)
    seen[v] = -1;
  for (int64_t t = 0; t < tets; t++) {
    const int32_t *node = fem->nodes + NODES * t;
    for (int e = 0; e < EDGES; e++) {
      int32_t *number = &seen[node[4 + e]];
      if (*number < 0)
        *number = count++;
      s->added[ADDED * t + e] = *number;
    }

    // the three corners of a face in their order
    for (int f = 0; f < FACES; f++) {
      tet_face *face = &faces[FACES * t + f];
      face->place = ADDED * t + EDGES + f;
      for (int i = 0; i < 3; i++)
        face->corner[i] = node[face_corners[f][i]];
      swap_down(&face->corner[0], &face->corner[1]);
      swap_down(&face->corner[1], &face->corner[2]);
      swap_down(&face->corner[0], &face->corner[1]);
    }
  }

  // tets that share a face lie side by side
  qsort(faces, (size_t)(FACES * tets), sizeof *faces, compare_faces);
  for (int64_t i = 0; i < FACES * tets; i++) {
    const bool other =
        i == 0 || memcmp(faces[i].corner, faces[i - 1].corner, sizeof faces[i].corner) != 0;
    count += other;
    s->added[faces[i].place] = count - 1;
  }
  return count;
}

/* A point of a tet: the values and gradients of the shape functions and of what is added. */
typedef struct cubic_point {
  double value[ALL], gradient[ALL][3];
  double weight, lambda, mu, density;
} cubic_point;

/* factor (product of l over `members`, which may repeat) at a point, added to function n. */
static void add_product(const double l[4], double slopes[4][3], const int *members, double factor,
                        int n, cubic_point *point) {
  point->value[n] += factor * l[members[0]] * l[members[1]] * l[members[2]];
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < 3; c++)
      point->gradient[n][c] +=
          factor * l[members[(i + 1) % 3]] * l[members[(i + 2) % 3]] * slopes[members[i]][c];
}

static cubic_point point_of(const cubic_problem *s, int64_t t, int p) {
  const thrum_fem *fem = s->fem;
  const int32_t region = fem->tet_region[t], *node = fem->nodes + NODES * t;
  const int64_t place = t * fem->point_count + p;
  const double *l = fem->rule[p].place;
  cubic_point point = {.weight = fem->weight[place],
                       .lambda = fem->lambda[region],
                       .mu = fem->mu[region],
                       .density = fem->density[region]};
  thrum_quadratic_shape(l, point.value);
  thrum_fem_shape_gradients(fem, t, p, point.gradient);

  // l_0 = 1 - l_1 - l_2 - l_3
  double slopes[4][3] = {{0}};
  for (int a = 1; a < 4; a++)
    for (int c = 0; c < 3; c++) {
      slopes[a][c] = fem->gradient[9 * place + 3 * (a - 1) + c];
      slopes[0][c] -= slopes[a][c];
    }

  // edges, from the end of the lower number to the other, and faces
  for (int e = 0; e < EDGES; e++) {
    const int a = thrum_quadratic_edges[e][0], b = thrum_quadratic_edges[e][1];
    const double sign = node[a] < node[b] ? 1 : -1;
    add_product(l, slopes, (const int[]){a, a, b}, sign, NODES + e, &point);
    add_product(l, slopes, (const int[]){a, b, b}, -sign, NODES + e, &point);
  }
  for (int f = 0; f < FACES; f++)
    add_product(l, slopes, face_corners[f], 1, NODES + EDGES + f, &point);
  return point;
}

/* The place of axis c of function n of a tet in a field; -1: it is held. */
static int64_t place_of(const hierarchy *h, int64_t t, int n, int c) {
  const cubic_problem *s = h->context;
  if (n < NODES)
    return s->fem->dof[3 * (int64_t)s->fem->nodes[NODES * t + n] + c];
  const int64_t added = s->added[ADDED * t + n - NODES];
  return h->held[added] >> c & 1 ? -1 : h->nodes + 3 * added + c;
}

static void take(const hierarchy *h, int64_t t, const double *field, double u[ALL][3]) {
  for (int n = 0; n < ALL; n++)
    for (int c = 0; c < 3; c++) {
      const int64_t at = place_of(h, t, n, c);
      u[n][c] = at < 0 ? 0 : field[at];
    }
}

static void put(const hierarchy *h, int64_t t, double force[ALL][3], double *image) {
  for (int n = 0; n < ALL; n++)
    for (int c = 0; c < 3; c++) {
      const int64_t at = place_of(h, t, n, c);
      if (at >= 0)
        image[at] += force[n][c];
    }
}

/* Adds the forces of the stress at a point where the body is displaced by u. */
static void add_stiffness(const cubic_point *point, double u[ALL][3], double force[ALL][3]) {
  double g[3][3] = {{0}}, stress[3][3];
  for (int n = 0; n < ALL; n++)
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        g[c][d] += u[n][c] * point->gradient[n][d];
  const double pressure = point->lambda * (g[0][0] + g[1][1] + g[2][2]);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      stress[c][d] = point->weight * (point->mu * (g[c][d] + g[d][c]) + (c == d ? pressure : 0));
  for (int n = 0; n < ALL; n++)
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        force[n][c] += stress[c][d] * point->gradient[n][d];
}

/* Adds the forces of the inertia at a point of this acceleration. */
static void add_mass(const cubic_point *point, double u[ALL][3], double force[ALL][3]) {
  for (int c = 0; c < 3; c++) {
    double sum = 0;
    for (int n = 0; n < ALL; n++)
      sum += u[n][c] * point->value[n];
    for (int n = 0; n < ALL; n++)
      force[n][c] += point->weight * point->density * sum * point->value[n];
  }
}

typedef void add_forces(const cubic_point *point, double u[ALL][3], double force[ALL][3]);

static void apply(const hierarchy *h, add_forces *add, const double *field, double *image) {
  const cubic_problem *s = h->context;
  memset(image, 0, sizeof *image * (size_t)h->size);
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    double u[ALL][3], force[ALL][3] = {{0}};
    take(h, t, field, u);
    for (int p = 0; p < s->fem->point_count; p++) {
      const cubic_point point = point_of(s, t, p);
      add(&point, u, force);
    }
    put(h, t, force, image);
  }
}

static void multiply(const hierarchy *h, const double *field, double *image) {
  const cubic_problem *s = h->context;
  apply(h, add_stiffness, field, image);
  thrum_fem_add_free_springs(s->fem, field, image);
}

static void weigh(const hierarchy *h, const double *field, double *image) {
  apply(h, add_mass, field, image);
}

/* Adds the diagonal blocks of what is added at a point. */
static void add_diagonal(const cubic_point *point, const int32_t *added, double *blocks) {
  for (int n = 0; n < ADDED; n++) {
    const double *g = point->gradient[NODES + n];
    const double square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        blocks[9 * (int64_t)added[n] + 3 * c + d] +=
            point->weight *
            ((point->lambda + point->mu) * g[c] * g[d] + (c == d ? point->mu * square : 0));
  }
}

/* Lets go of the axes of a function that one of its nodes does not hold. */
static void free_axes(const thrum_fem *fem, const int32_t *node, const int *corners,
                      int corner_count, const int *edges, int edge_count, uint8_t *held) {
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < corner_count + edge_count; i++) {
      const int n = i < corner_count ? corners[i] : 4 + edges[i - corner_count];
      if (fem->dof[3 * (int64_t)node[n] + c] >= 0)
        *held &= (uint8_t) ~(1U << c);
    }
}

static void prepare(const cubic_problem *s, hierarchy *h) {
  const thrum_fem *fem = s->fem;
  memset(h->held, 7, (size_t)h->count);
  for (int64_t t = 0; t < fem->tet_count; t++) {
    const int32_t *node = fem->nodes + NODES * t, *added = s->added + ADDED * t;
    for (int e = 0; e < EDGES; e++)
      free_axes(fem, node, thrum_quadratic_edges[e], 2, &e, 1, &h->held[added[e]]);
    for (int f = 0; f < FACES; f++)
      free_axes(fem, node, face_corners[f], 3, face_edges[f], 3, &h->held[added[EDGES + f]]);
    for (int p = 0; p < fem->point_count; p++) {
      const cubic_point point = point_of(s, t, p);
      add_diagonal(&point, added, h->inverse);
    }
  }
  hierarchy_invert_blocks(h);
}

thrum_status thrum_cubic_errors(const thrum_order_body *body, int64_t count, const double *modes,
                                double *errors, thrum_error *error) {
  const int64_t tets = body->fem->tet_count;
  cubic_problem s = {.fem = body->fem};
  hierarchy h = {.multiply = multiply, .weigh = weigh, .context = &s};
  h.memory = thrum_scope_begin("the error of ten nodes", error);
  s.added = thrum_scope_allocate(&h.memory, ADDED * tets, sizeof *s.added);
  int32_t *seen = thrum_scope_allocate(&h.memory, body->fem->vertex_count, sizeof *seen);
  tet_face *faces = thrum_scope_allocate(&h.memory, FACES * tets, sizeof *faces);
  thrum_status status = h.memory.status;
  if (status >= 0)
    status = hierarchy_allocate(body, number_added(&s, seen, faces), count, &h);
  if (status >= 0) {
    prepare(&s, &h);
    status = hierarchy_errors(&h, count, modes, errors, error);
  }
  thrum_scope_free(&h.memory);
  return status;
}
