/* Tests of the laws of one touch against their definitions (docs/contact.md), over random springs,
 * dampers and motions: the force found in closed form is the one that the law gives at the gap
 * which this force leads to.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "contact/contact_law.h"
#include "tests/support/random_model.h"

enum { DRAWS = 4000 };

/* A spring and a damper with nothing that limits their force. */
static thrum_contact_row row_make(random_state *random) {
  thrum_contact_row row = {0};
  row.gap = random_uniform(random);
  row.along = exp(2 * random_uniform(random));
  row.stiffness = exp(3 * random_uniform(random));
  row.damping = random_index(random, 2) ? fabs(random_uniform(random)) : 0;
  row.ceiling = INFINITY;
  return row;
}

/* The discrete gradient of phi between two gaps and the damper, not below 0. */
static double law(const thrum_contact_row *row, double end) {
  const double start = row->gap, k = row->stiffness;
  const double slope =
      (thrum_contact_energy(k, end) - thrum_contact_energy(k, start)) / (end - start);
  return fmax(-slope + row->damping * (fmax(-end, 0) - fmax(-start, 0)), 0);
}

static void the_spring_pushes_by_its_discrete_gradient(void **context) {
  (void)context;
  random_state random = {31};
  int pushed = 0;
  for (int n = 0; n < DRAWS; n++) {
    const thrum_contact_row row = row_make(&random);
    const double gap_free = row.gap + 2 * random_uniform(&random);
    const double force = thrum_contact_normal(&row, gap_free, INFINITY);
    const double end = gap_free + row.along * force;

    // where the gaps are nearly the same their quotient is rounding
    pushed += force > 0;
    if (fabs(end - row.gap) > 1e-4)
      assert_true(fabs(force - law(&row, end)) <= 1e-9 * (1 + force));
  }

  // all regimes were drawn: from outside and from inside, staying and leaving
  assert_true(pushed > DRAWS / 4 && pushed < DRAWS);
}

static void no_spring_gives_back_more_than_it_holds_or_pushes_beyond_its_ceiling(void **context) {
  (void)context;
  random_state random = {32};
  int held = 0, stopped = 0;
  for (int n = 0; n < DRAWS; n++) {
    thrum_contact_row row = row_make(&random);
    const double gap_free = row.gap + 2 * random_uniform(&random);
    const double free = thrum_contact_normal(&row, gap_free, INFINITY);
    const double stored = 0.1 * fabs(random_uniform(&random));
    const double force = thrum_contact_normal(&row, gap_free, stored);
    const double end = gap_free + row.along * force;

    // the lesser of the two forces, and all of the energy that is there
    assert_true(force <= free * (1 + 1e-12));
    assert_true(end <= row.gap || force * (end - row.gap) <= stored * (1 + 1e-9));
    if (force < free * (1 - 1e-9)) {
      assert_true(fabs(force * (end - row.gap) - stored) <= 1e-9 * stored);
      held++;
    }

    // the ceiling ends the push
    row.ceiling = gap_free + 0.5 * random_uniform(&random);
    const double under = thrum_contact_normal(&row, gap_free, INFINITY);
    const double most = fmax(row.ceiling - gap_free, 0) / row.along;
    assert_true(fabs(under - fmin(free, most)) <= 1e-12 * free);
    stopped += under < free;
  }
  assert_true(held > DRAWS / 20 && stopped > DRAWS / 20);
}

static void friction_stops_what_it_can_and_never_drives(void **context) {
  (void)context;
  random_state random = {33};
  int stopped = 0;
  for (int n = 0; n < DRAWS; n++) {
    thrum_contact_row row = {.across = exp(random_uniform(&random)), .friction = 0.7};
    double free[3], force[3], off[3], along = 0, length = 0, square = 0, work = 0;
    random_vector(&random, 3, 1, free);
    random_vector(&random, 3, n % 4 ? 1 : 0, row.slide);
    thrum_contact_friction(&row, 1.3, free, force);

    // the place on the way from 0 to `slide` that is nearest to the free displacement
    for (int axis = 0; axis < 3; axis++) {
      along += free[axis] * row.slide[axis];
      length += row.slide[axis] * row.slide[axis];
    }
    const double share = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
    for (int axis = 0; axis < 3; axis++) {
      off[axis] = free[axis] - share * row.slide[axis];
      square += off[axis] * off[axis];
    }

    // towards it: as far as it is, or as the cone allows
    const double scale = fmin(1 / row.across, 0.7 * 1.3 / sqrt(square));
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(force[axis] + scale * off[axis]) <= 1e-12);
      work += force[axis] * (free[axis] + row.across * force[axis]);
    }
    assert_true(work <= 1e-12);
    stopped += scale == 1 / row.across;
  }
  assert_true(stopped > DRAWS / 20 && stopped < DRAWS);
}

static void the_rate_of_a_force_is_how_it_falls_with_the_gap(void **context) {
  (void)context;
  random_state random = {35};
  const double h = 1e-6;
  int falls = 0;
  for (int n = 0; n < DRAWS; n++) {
    thrum_contact_row row = row_make(&random);
    const double stored = random_index(&random, 2) ? fabs(random_uniform(&random)) : INFINITY;
    const double gap_free = row.gap + 2 * random_uniform(&random);
    if (random_index(&random, 3) == 0)
      row.ceiling = row.gap + random_uniform(&random);

    // one of the two where the law has a corner, so it lies between differences to either side
    const double force = thrum_contact_normal(&row, gap_free, stored);
    const double before = (thrum_contact_normal(&row, gap_free - h, stored) - force) / h;
    const double after = (force - thrum_contact_normal(&row, gap_free + h, stored)) / h;
    const double rate = thrum_contact_normal_rate(&row, gap_free, stored, force);
    assert_true(rate >= fmin(before, after) - 1e-4 * (1 + fabs(before) + fabs(after)));
    assert_true(rate <= fmax(before, after) + 1e-4 * (1 + fabs(before) + fabs(after)));
    assert_true(rate >= 0 && rate * row.along <= 1 + 1e-12);
    falls += rate > 0;
  }
  assert_true(falls > DRAWS / 4 && falls < DRAWS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_spring_pushes_by_its_discrete_gradient),
      cmocka_unit_test(no_spring_gives_back_more_than_it_holds_or_pushes_beyond_its_ceiling),
      cmocka_unit_test(friction_stops_what_it_can_and_never_drives),
      cmocka_unit_test(the_rate_of_a_force_is_how_it_falls_with_the_gap),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
