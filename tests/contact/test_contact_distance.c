/* Tests of distances between triangles, vertices and edges: none of the points that they stand for
 * are nearer, a time of the step is the place there, and two that approach meet at their reach.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "contact/contact_distance.h"
#include "core/base/vec3.h"
#include "tests/support/random_model.h"
#include "thrum/contact_pairs.h"

enum { DRAWS = 2000, SAMPLES = 12 };

/* Four points, and the displacements of all over a step. */
typedef struct points {
  double x[4][3], d[4][3];
} points;

static thrum_quad quad_of(const points *p) {
  thrum_quad quad;
  for (int n = 0; n < 4; n++) {
    quad.x[n] = p->x[n];
    quad.d[n] = p->d[n];
  }
  return quad;
}

static points points_make(random_state *random) {
  points p;
  random_vector(random, 12, 1, p.x[0]);
  random_vector(random, 12, 1, p.d[0]);
  return p;
}

/* From the point of the second side with the last weights to that of the first. */
static void between(thrum_quad_kind kind, const points *p, const double w[4], double apart[3]) {
  const int first = kind == THRUM_VERTEX_TRIANGLE ? 1 : 2;
  for (int axis = 0; axis < 3; axis++) {
    apart[axis] = 0;
    for (int n = 0; n < 4; n++)
      apart[axis] += (n < first ? w[n] : -w[n]) * p->x[n][axis];
  }
}

/* Weights of a random point of each side. */
static void draw_weights(random_state *random, thrum_quad_kind kind, double w[4]) {
  const double s = fabs(random_uniform(random)), t = fabs(random_uniform(random));
  if (kind == THRUM_EDGE_EDGE) {
    w[0] = 1 - s;
    w[1] = s;
    w[2] = 1 - t;
    w[3] = t;
    return;
  }
  w[0] = 1;
  w[1] = (1 - s) * t;
  w[2] = (1 - s) * (1 - t);
  w[3] = s;
}

static void no_points_of_the_two_sides_are_nearer(void **context) {
  (void)context;
  random_state random = {41};
  int inside[2] = {0, 0};
  for (int n = 0; n < DRAWS; n++) {
    const thrum_quad_kind kind = n % 2 ? THRUM_EDGE_EDGE : THRUM_VERTEX_TRIANGLE;
    const points p = points_make(&random);
    const thrum_quad quad = quad_of(&p);
    const thrum_nearest found = thrum_quad_nearest(kind, &quad, 0);
    inside[kind] += found.inside;

    // the weights are of points of the sides, and these are as far apart as it says
    double apart[3], w[4];
    between(kind, &p, found.weights, apart);
    for (int k = 0; k < 4; k++)
      assert_true(found.weights[k] >= 0 && found.weights[k] <= 1);
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs(apart[axis] - found.apart[axis]) <= 1e-14);
    assert_true(fabs(sqrt(thrum_dot3(apart, apart)) - found.distance) <= 1e-14);

    for (int k = 0; k < SAMPLES; k++) {
      draw_weights(&random, kind, w);
      between(kind, &p, w, apart);
      assert_true(sqrt(thrum_dot3(apart, apart)) >= found.distance - 1e-14);
    }
  }
  assert_true(inside[0] > DRAWS / 40 && inside[1] > DRAWS / 40);
}

static void a_time_of_the_step_is_the_place_there(void **context) {
  (void)context;
  random_state random = {42};
  for (int n = 0; n < DRAWS; n++) {
    const thrum_quad_kind kind = n % 2 ? THRUM_EDGE_EDGE : THRUM_VERTEX_TRIANGLE;
    const double time = fabs(random_uniform(&random));
    const points p = points_make(&random);
    points there = p;
    for (int k = 0; k < 12; k++)
      there.x[k / 3][k % 3] += time * p.d[k / 3][k % 3];
    const thrum_quad quad = quad_of(&p), moved = quad_of(&there);
    const thrum_nearest now = thrum_quad_nearest(kind, &quad, time);
    assert_true(fabs(now.distance - thrum_quad_nearest(kind, &moved, 0).distance) <= 1e-14);
  }
}

static void two_that_approach_meet_at_their_reach_and_not_before(void **context) {
  (void)context;
  random_state random = {43};
  const double reach = 0.05;
  int met = 0, close = 0;
  for (int n = 0; n < DRAWS; n++) {
    const thrum_quad_kind kind = n % 2 ? THRUM_EDGE_EDGE : THRUM_VERTEX_TRIANGLE;
    const points p = points_make(&random);
    const thrum_quad quad = quad_of(&p);
    const double time = thrum_quad_meets(kind, &quad, reach), last = fmin(time, 1);

    // what moves with all points alike is no approach
    points carried = p;
    for (int k = 0; k < 12; k++)
      carried.d[k / 3][k % 3] += 1 + k % 3;
    const thrum_quad with = quad_of(&carried);
    assert_true(fabs(thrum_quad_motion(kind, &with) - thrum_quad_motion(kind, &quad)) <= 1e-13);

    // at that time most are at the reach; where two only graze it, the advances may stop a little
    // before. At no earlier time are they nearer.
    if (time <= 1 && time > 0) {
      const double left = thrum_quad_nearest(kind, &quad, time).distance - reach;
      assert_true(left >= -1e-14);
      close += left <= 1e-3 * reach;
      met++;
    }
    for (int k = 0; k < SAMPLES && time > 0; k++)
      assert_true(thrum_quad_nearest(kind, &quad, last * k / SAMPLES).distance >= reach - 1e-14);
  }
  assert_true(met > DRAWS / 40 && met < DRAWS / 2 && close > 0.9 * met);
}

static void a_vertex_is_over_a_triangle_whose_closest_point_is_inside(void **unused) {
  (void)unused;
  random_state random = {5};
  int over = 0;
  for (int n = 0; n < DRAWS; n++) {
    const points p = points_make(&random);
    const thrum_quad quad = quad_of(&p);
    const thrum_nearest nearest = thrum_quad_nearest(THRUM_VERTEX_TRIANGLE, &quad, 0);
    double weights[3];
    const bool is = thrum_triangle_closest(p.x[0], p.x[1], p.x[2], p.x[3], weights);
    assert_int_equal(is, nearest.inside);
    over += is;

    // with its weights known the nearest point is the same
    const thrum_nearest known = thrum_vertex_nearest(quad.x, weights, is);
    assert_memory_equal(known.weights, nearest.weights, sizeof known.weights);
    assert_memory_equal(known.apart, nearest.apart, sizeof known.apart);
    assert_true(known.distance == nearest.distance && known.inside == nearest.inside);

    // and so is one that is right above a point of it, but for one over a corner
    double above[3], normal[3], e[3], f[3];
    thrum_subtract3(p.x[2], p.x[1], e);
    thrum_subtract3(p.x[3], p.x[1], f);
    thrum_cross3(e, f, normal);
    for (int axis = 0; axis < 3; axis++)
      above[axis] = p.x[1][axis] + 0.25 * e[axis] + 0.25 * f[axis] + 3 * normal[axis];
    assert_true(thrum_triangle_closest(above, p.x[1], p.x[2], p.x[3], weights));
    assert_false(thrum_triangle_closest(p.x[1], p.x[1], p.x[2], p.x[3], weights));
  }
  assert_true(over > DRAWS / 50 && over < DRAWS / 2);
}

/* Twice the volume that three vectors span, with its sign. */
static double volume_of(const double a[3], const double b[3], const double c[3],
                        const double d[3]) {
  double u[3], v[3], w[3];
  thrum_subtract3(b, a, u);
  thrum_subtract3(c, a, v);
  thrum_subtract3(d, a, w);
  return thrum_triple3(u, v, w);
}

static void a_point_is_inside_where_all_its_weights_are_above_0(void **context) {
  (void)context;
  static const int32_t faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  random_state random = {47};
  int inside = 0;
  for (int n = 0; n < DRAWS; n++) {
    double x[4][3], at[3] = {0, 0, 0}, weights[4], sum = 0, nearest = INFINITY;
    random_vector(&random, 12, 1, x[0]);

    // with weights near one above 0 as a rule
    for (int k = 0; k < 4; k++)
      sum += weights[k] = random_uniform(&random) + 0.6;
    for (int k = 0; k < 4; k++)
      for (int axis = 0; axis < 3; axis++)
        at[axis] += weights[k] / sum * x[k][axis];
    const double whole = volume_of(x[0], x[1], x[2], x[3]);
    bool within = true;
    for (int k = 0; k < 4; k++) {
      const double *y[4] = {x[0], x[1], x[2], x[3]};
      double of[3];
      y[k] = at;
      within = within && volume_of(y[0], y[1], y[2], y[3]) / whole > 0;

      // the nearest point of each face
      const int32_t *f = faces + 3 * k;
      double off[3];
      thrum_triangle_closest(at, x[f[0]], x[f[1]], x[f[2]], of);
      for (int axis = 0; axis < 3; axis++)
        off[axis] =
            of[0] * x[f[0]][axis] + of[1] * x[f[1]][axis] + of[2] * x[f[2]][axis] - at[axis];
      nearest = fmin(nearest, sqrt(thrum_dot3(off, off)));
    }
    const double found = thrum_triangles_distance(x[0], faces, 4, at);
    assert_true(fabs(fabs(found) - nearest) <= 1e-12 * (1 + nearest));
    if (nearest > 1e-9)
      assert_true((found < 0) == within);
    inside += within;
  }
  assert_true(inside > DRAWS / 10 && inside < DRAWS - DRAWS / 10);
}

static void edges_that_meet_at_an_end_are_on_a_rim(void **context) {
  (void)context;
  for (int n = 0; n < 4; n++) {
    // a cross, of which one end is drawn back to where the other passes, and further
    for (int beyond = 0; beyond < 2; beyond++) {
      points p = {.x = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 1}, {0, 1, 1}}};
      for (int axis = 0; axis < 2; axis++)
        p.x[n][axis] *= beyond ? -0.5 : 0;
      const thrum_quad quad = quad_of(&p);
      assert_false(thrum_quad_nearest(THRUM_EDGE_EDGE, &quad, 0).inside);
    }
  }
  const points cross = {.x = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 1}, {0, 1, 1}}};
  const thrum_quad quad = quad_of(&cross);
  assert_true(thrum_quad_nearest(THRUM_EDGE_EDGE, &quad, 0).inside);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_points_of_the_two_sides_are_nearer),
      cmocka_unit_test(a_time_of_the_step_is_the_place_there),
      cmocka_unit_test(a_vertex_is_over_a_triangle_whose_closest_point_is_inside),
      cmocka_unit_test(two_that_approach_meet_at_their_reach_and_not_before),
      cmocka_unit_test(a_point_is_inside_where_all_its_weights_are_above_0),
      cmocka_unit_test(edges_that_meet_at_an_end_are_on_a_rim),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
