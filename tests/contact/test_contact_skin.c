/* Tests of what a skin knows against its definitions (contact_skin.h), over surfaces whose places
 * and rows of U are drawn: edges, neighbours, areas, bounds, the tree and its spheres, and gaps of
 * a surface to itself. And of the order in which touches are sorted.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "contact/contact_distance.h"
#include "contact/contact_pairs_sort.h"
#include "contact/contact_skin.h"
#include "tests/support/random_model.h"

enum {
  SIDE = 6,
  VERTICES = SIDE * SIDE,
  TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1),
  RANK = 3,
  REGIONS = 3
};

/* A sheet that is rolled up, so that its ends come near each other, with vertices off their places.
 */
typedef struct fixture {
  double vertices[3 * VERTICES], basis[3 * VERTICES * RANK], material[3 * REGIONS];
  int32_t triangles[3 * TRIANGLES];
  thrum_model model;
  thrum_skin *skin;
  thrum_skin_view view;
} fixture;

static int setup(void **context) {
  fixture *f = random_alloc(1, sizeof *f);
  random_state random = {91};
  int count = 0;
  for (int v = 0; v < VERTICES; v++) {
    const double angle = 5.2 * (v % SIDE) / (SIDE - 1);
    f->vertices[3 * v] = cos(angle) + 0.1 * random_uniform(&random);
    f->vertices[3 * v + 1] = 1.5 * sin(angle) + 0.1 * random_uniform(&random);
    f->vertices[3 * v + 2] = 0.7 * (v / SIDE) + 0.1 * random_uniform(&random);
  }
  for (int32_t v = 0; v < SIDE * (SIDE - 1); v++) {
    const int32_t both[6] = {v, v + 1, v + SIDE, v + SIDE + 1, v + SIDE, v + 1};
    if (v % SIDE == SIDE - 1)
      continue;
    memcpy(f->triangles + 3 * count, both, sizeof both);
    count += 2;
  }
  random_vector(&random, 3 * VERTICES * RANK, 1, f->basis);
  for (int n = 0; n < REGIONS; n++)
    f->material[3 * n] = n == 1 ? 7 : 3 + n;
  f->model = (thrum_model){.rank = RANK,
                           .vertex_count = VERTICES,
                           .vertices = f->vertices,
                           .basis = f->basis,
                           .material = f->material,
                           .region_count = REGIONS};
  size_t size = 0;
  if (thrum_skin_size(&f->model, f->triangles, TRIANGLES, &size, NULL) != THRUM_OK)
    return -1;
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  if (memory == NULL ||
      thrum_skin_init(memory, size, &f->model, f->triangles, TRIANGLES, &f->skin, NULL) != THRUM_OK)
    return -1;
  f->view = thrum_skin_view_of(f->skin);
  *context = f;
  return 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  free(f->skin);
  free(f);
  return 0;
}

static const double *rest(const fixture *f, int64_t v) {
  return f->vertices + 3 * v;
}

static double distance(const double a[3], const double b[3]) {
  double off[3];
  thrum_subtract3(a, b, off);
  return sqrt(thrum_dot3(off, off));
}

static void is_near(double value, double expected) {
  if (!(fabs(value - expected) <= 1e-12 * (1 + fabs(expected))))
    fail_msg("%.17g is not %.17g", value, expected);
}

/* --- edges ------------------------------------------------------------------------------------ */

/* Has a triangle an edge between two vertices, in any direction? `third` gets its other corner. */
static bool has_edge(const int32_t corners[3], int32_t a, int32_t b, int32_t *third) {
  for (int n = 0; n < 3; n++) {
    const int32_t p = corners[n], q = corners[(n + 1) % 3];
    *third = corners[(n + 2) % 3];
    if ((p == a && q == b) || (p == b && q == a))
      return true;
  }
  return false;
}

static void an_edge_knows_its_ends_and_faces(void **context) {
  const fixture *f = *context;
  int64_t sides = 0;
  for (int64_t e = 0; e < f->skin->edge_count; e++) {
    const thrum_skin_edge *edge = f->view.edges + e;
    int found = 0;
    assert_true(edge->ends[0] < edge->ends[1]);
    for (int t = 0; t < TRIANGLES; t++) {
      int32_t third;
      if (!has_edge(f->triangles + 3 * t, edge->ends[0], edge->ends[1], &third))
        continue;
      found++;
      assert_true(edge->opposite[0] == third || edge->opposite[1] == third);
    }
    assert_int_equal(found, edge->opposite[1] < 0 ? 1 : 2);
    assert_true(edge->opposite[0] >= 0 && edge->opposite[0] != edge->opposite[1]);
    sides += found;
  }
  assert_int_equal(sides, 3 * TRIANGLES);
}

static void each_place_is_tried_by_one_triangle(void **context) {
  const fixture *f = *context;
  int vertices[VERTICES] = {0}, edges[3 * TRIANGLES] = {0};
  for (int t = 0; t < TRIANGLES; t++) {
    const thrum_skin_triangle *triangle = f->view.triangles + t;
    for (int n = 0; n < 3; n++) {
      int32_t third;
      const thrum_skin_edge *edge = f->view.edges + triangle->edges[n];
      vertices[triangle->corners[n]] += (triangle->tried >> n) & 1;
      edges[triangle->edges[n]] += (triangle->tried & (THRUM_SKIN_EDGE << n)) != 0;

      // edge n runs from corner n to the next
      assert_true(has_edge(triangle->corners, edge->ends[0], edge->ends[1], &third));
      assert_int_equal(third, triangle->corners[(n + 2) % 3]);
    }
  }
  for (int v = 0; v < VERTICES; v++)
    assert_int_equal(vertices[v], 1);
  for (int64_t e = 0; e < f->skin->edge_count; e++)
    assert_int_equal(edges[e], 1);
}

static void a_ring_is_all_that_an_edge_joins_to_a_vertex(void **context) {
  const fixture *f = *context;
  for (int v = 0; v < VERTICES; v++) {
    int joined = 0;
    for (int64_t e = 0; e < f->skin->edge_count; e++) {
      const int32_t *ends = f->view.edges[e].ends;
      if (ends[0] != v && ends[1] != v)
        continue;
      const int32_t other = ends[0] == v ? ends[1] : ends[0];
      int times = 0;
      for (int32_t n = f->view.ring_begins[v]; n < f->view.ring_begins[v + 1]; n++)
        times += f->view.rings[n] == other;
      assert_int_equal(times, 1);
      joined++;
    }
    assert_int_equal(joined, f->view.ring_begins[v + 1] - f->view.ring_begins[v]);
  }
}

/* --- sizes ------------------------------------------------------------------------------------ */

static void areas_and_bounds_are_those_of_the_surface(void **context) {
  const fixture *f = *context;
  double areas[VERTICES] = {0}, extents[RANK] = {0}, tilts[RANK] = {0}, half[3] = {0};
  for (int t = 0; t < TRIANGLES; t++) {
    const int32_t *corners = f->triangles + 3 * t;
    double e[3], g[3], normal[3], longest = 0;
    thrum_subtract3(rest(f, corners[1]), rest(f, corners[0]), e);
    thrum_subtract3(rest(f, corners[2]), rest(f, corners[0]), g);
    thrum_cross3(e, g, normal);
    const double twice = sqrt(thrum_dot3(normal, normal));
    for (int n = 0; n < 3; n++) {
      areas[corners[n]] += twice / 6;
      longest = fmax(longest, distance(rest(f, corners[n]), rest(f, corners[(n + 1) % 3])));
    }

    // the least height stands on the longest side
    for (int n = 0; n < 3; n++)
      for (int i = 0; i < RANK; i++) {
        double u[3];
        for (int axis = 0; axis < 3; axis++)
          u[axis] = f->basis[(3 * corners[n] + axis) * RANK + i] -
                    f->basis[(3 * corners[(n + 1) % 3] + axis) * RANK + i];
        tilts[i] = fmax(tilts[i], sqrt(thrum_dot3(u, u)) * longest / twice);
      }
  }
  for (int v = 0; v < VERTICES; v++) {
    is_near(f->view.areas[v], areas[v]);
    for (int axis = 0; axis < 3; axis++)
      half[axis] = fmax(half[axis], fabs(rest(f, v)[axis] - f->view.nodes[0].middle[axis]));
    for (int i = 0; i < RANK; i++) {
      const double *u = f->basis + 3 * v * RANK + i;
      extents[i] =
          fmax(extents[i], sqrt(u[0] * u[0] + u[RANK] * u[RANK] + u[2 * RANK] * u[2 * RANK]));
    }
  }
  for (int i = 0; i < RANK; i++) {
    is_near(f->view.extents[i], extents[i]);
    is_near(f->view.tilts[i], tilts[i]);
  }
  for (int axis = 0; axis < 3; axis++)
    is_near(f->skin->half[axis], half[axis]);
  is_near(f->skin->diagonal, 2 * sqrt(thrum_dot3(half, half)));
  is_near(f->skin->young, 7);
}

/* --- the tree --------------------------------------------------------------------------------- */

static void a_node_holds_its_triangles(void **context) {
  const fixture *f = *context;
  assert_int_equal(f->view.nodes[0].count, TRIANGLES);
  for (int64_t k = 0; k < f->skin->node_count; k++) {
    const thrum_skin_node *node = f->view.nodes + k;
    double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY},
           mean[3 * RANK] = {0};
    double radius = 0, spread[RANK] = {0};
    for (int pass = 0; pass < 2; pass++)
      for (int64_t t = node->first; t < node->first + node->count; t++)
        for (int n = 0; n < 3; n++) {
          const int64_t v = f->view.triangles[t].corners[n];
          const double *rows = f->basis + 3 * v * RANK;
          for (int axis = 0; axis < 3 && pass == 0; axis++) {
            least[axis] = fmin(least[axis], rest(f, v)[axis]);
            most[axis] = fmax(most[axis], rest(f, v)[axis]);
          }
          for (int i = 0; i < 3 * RANK && pass == 0; i++)
            mean[i] += rows[i] / (3.0 * node->count);
          for (int i = 0; i < RANK && pass == 1; i++) {
            const double off[3] = {rows[i] - mean[i], rows[RANK + i] - mean[RANK + i],
                                   rows[2 * RANK + i] - mean[2 * RANK + i]};
            spread[i] = fmax(spread[i], sqrt(thrum_dot3(off, off)));
          }
          if (pass == 1)
            radius = fmax(radius, distance(rest(f, v), node->middle));
        }

    // the middle of the box, the sphere about it, and how it moves and grows
    for (int axis = 0; axis < 3; axis++)
      is_near(node->middle[axis], 0.5 * (least[axis] + most[axis]));
    is_near(node->radius, radius);
    for (int i = 0; i < 3 * RANK; i++)
      is_near(f->view.node_rows[3 * k * RANK + i], mean[i]);
    for (int i = 0; i < RANK; i++)
      is_near(f->view.spreads[k * RANK + i], spread[i]);
  }
}

static void halves_lie_apart_along_the_longest_side(void **context) {
  const fixture *f = *context;
  for (int64_t k = 0; k < f->skin->node_count; k++) {
    const thrum_skin_node *node = f->view.nodes + k;
    assert_true((node->left < 0) == (node->count <= THRUM_SKIN_LEAF));
    if (node->left < 0)
      continue;
    const thrum_skin_node *left = f->view.nodes + node->left, *right = f->view.nodes + node->right;
    assert_true(left->first == node->first && right->first == left->first + left->count);
    assert_true(left->count + right->count == node->count && left->count == node->count / 2);

    // the side of the box that is longest
    double sides[3], ends[2] = {-INFINITY, INFINITY};
    for (int axis = 0; axis < 3; axis++) {
      double least = INFINITY, most = -INFINITY;
      for (int64_t n = 3 * node->first; n < 3 * (node->first + node->count); n++) {
        const double x = rest(f, f->view.triangles[n / 3].corners[n % 3])[axis];
        least = fmin(least, x);
        most = fmax(most, x);
      }
      sides[axis] = most - least;
    }
    const int axis =
        sides[1] > sides[0] ? (sides[2] > sides[1] ? 2 : 1) : (sides[2] > sides[0] ? 2 : 0);
    for (int64_t t = node->first; t < node->first + node->count; t++) {
      double sum = 0;
      for (int n = 0; n < 3; n++)
        sum += rest(f, f->view.triangles[t].corners[n])[axis];
      if (t < right->first)
        ends[0] = fmax(ends[0], sum);
      else
        ends[1] = fmin(ends[1], sum);
    }
    assert_true(ends[0] <= ends[1]);
  }
}

/* --- gaps to itself --------------------------------------------------------------------------- */

/* The distance between vertices and edges of two triangles that have no vertex in common, by all of
 * them. */
static double gap_between(const fixture *f, const int32_t *a, const int32_t *b) {
  static const double still[3] = {0, 0, 0};
  double gap = INFINITY;
  for (int kind = 0; kind < 2; kind++)
    for (int n = 0; n < 3; n++)
      for (int m = 0; m < (kind ? 3 : 2); m++) {
        const int32_t *p = m == 1 && !kind ? b : a, *q = p == a ? b : a;
        const int32_t point[4] = {p[n], q[0], q[1], q[2]},
                      ends[4] = {a[n], a[(n + 1) % 3], b[m], b[(m + 1) % 3]};
        const int32_t *of = kind ? ends : point;
        thrum_quad quad;
        bool shared = false;
        for (int k = 0; k < 4; k++) {
          quad.x[k] = rest(f, of[k]);
          quad.d[k] = still;
          for (int j = kind ? 2 : 1; j < 4 && k < (kind ? 2 : 1); j++)
            shared = shared || of[k] == of[j];
        }
        if (!shared)
          gap =
              fmin(gap, thrum_quad_nearest(kind ? THRUM_EDGE_EDGE : THRUM_VERTEX_TRIANGLE, &quad, 0)
                            .distance);
      }
  return gap;
}

static void a_node_knows_how_near_it_is_to_the_rest(void **context) {
  const fixture *f = *context;
  thrum_skin_prepare_own(f->skin);
  assert_true(f->skin->own_known);
  for (int64_t k = 0; k < f->skin->node_count; k++) {
    const thrum_skin_node *node = f->view.nodes + k;
    double gap = INFINITY;
    for (int64_t t = node->first; t < node->first + node->count; t++)
      for (int s = 0; s < TRIANGLES; s++)
        gap = fmin(gap, gap_between(f, f->view.triangles[t].corners, f->view.triangles[s].corners));
    is_near(f->view.own_gaps[k], gap);
  }

  // once is enough
  f->view.own_gaps[0] = 77;
  thrum_skin_prepare_own(f->skin);
  assert_true(f->view.own_gaps[0] == 77);
  thrum_skin_prepare_own(NULL);
}

/* Two triangles that are drawn, with a vertex in common or none. */
static void two_triangles_know_how_near_they_are(void **context) {
  const fixture *f = *context;
  fixture *two = random_alloc(1, sizeof *two);
  random_state random = {97};
  for (int k = 0; k < 300; k++) {
    const int32_t triangles[6] = {0, 1, 2, k % 2 ? 2 : 3, 4, 5};
    size_t size = 0;
    thrum_skin *skin = NULL;
    random_vector(&random, 3 * 6, 1, two->vertices);
    assert_int_equal(thrum_skin_solid_size(two->vertices, 6, triangles, 2, &size, NULL), THRUM_OK);
    assert_true(size <= (size_t)f->skin->bytes);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    assert_int_equal(
        thrum_skin_solid_init(memory, size, two->vertices, 6, triangles, 2, &skin, NULL), THRUM_OK);
    thrum_skin_prepare_own(skin);
    is_near(thrum_skin_view_of(skin).own_gaps[0], gap_between(two, triangles, triangles + 3));
    assert_true(skin->young == INFINITY);
    free(memory);
  }
  free(two);
}

/* --- order ------------------------------------------------------------------------------------ */

static int compare(const void *a, const void *b) {
  return thrum_pair_compare(&((const thrum_pair_touching *)a)->key,
                            &((const thrum_pair_touching *)b)->key);
}

static void touches_are_sorted_by_their_keys(void **context) {
  (void)context;
  enum { MOST = 300 };
  static thrum_pair_touching items[MOST];
  static thrum_pair_sorted room[2 * MOST];
  static int32_t order[MOST];
  random_state random = {95};
  for (int k = 0; k < 60; k++) {
    const int64_t count = random_index(&random, MOST);

    // numbers of one byte or of many; now and then in order already, or all alike
    const int64_t most = k % 3 == 0 ? 3 : k % 3 == 1 ? 1000 : INT32_MAX;
    for (int64_t n = 0; n < count; n++) {
      int32_t *numbers[4] = {&items[n].key.bodies[0], &items[n].key.bodies[1], &items[n].key.first,
                             &items[n].key.second};
      for (int i = 0; i < 4; i++)
        *numbers[i] = (int32_t)(k % 5 == 4 ? (i == 3 ? n : 7) : random_index(&random, most));
      items[n].key.kind = k % 5 == 4 ? 1 : (int32_t)random_index(&random, 3);
    }

    // in order but for two that follow each other
    if (k % 4 == 3 && count > 2) {
      qsort(items, (size_t)count, sizeof items[0], compare);
      const int64_t at = random_index(&random, count - 1);
      const thrum_pair_touching kept = items[at];
      items[at] = items[at + 1];
      items[at + 1] = kept;
    }
    thrum_pairs_sort(items, sizeof items[0], count, order, room);

    // ascending, equal ones as they were, and each there once
    int seen[MOST] = {0};
    for (int64_t n = 0; n < count; n++) {
      seen[order[n]]++;
      if (n == 0)
        continue;
      const int compared = thrum_pair_compare(&items[order[n - 1]].key, &items[order[n]].key);
      assert_true(compared < 0 || (compared == 0 && order[n - 1] < order[n]));
    }
    for (int64_t n = 0; n < count; n++)
      assert_int_equal(seen[n], 1);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_edge_knows_its_ends_and_faces),
      cmocka_unit_test(each_place_is_tried_by_one_triangle),
      cmocka_unit_test(a_ring_is_all_that_an_edge_joins_to_a_vertex),
      cmocka_unit_test(areas_and_bounds_are_those_of_the_surface),
      cmocka_unit_test(a_node_holds_its_triangles),
      cmocka_unit_test(halves_lie_apart_along_the_longest_side),
      cmocka_unit_test(a_node_knows_how_near_it_is_to_the_rest),
      cmocka_unit_test(two_triangles_know_how_near_they_are),
      cmocka_unit_test(touches_are_sorted_by_their_keys),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
