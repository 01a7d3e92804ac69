/* Tests of what all rows of contact do against their definitions (contact_row.h, docs/contact.md),
 * over random responses, normals and motions: a row that is solved alone satisfies its laws at the
 * place where its forces take it, and the books of energy of many rows add up.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "contact/contact_law.h"
#include "contact/contact_row.h"
#include "tests/support/random_model.h"

enum { DRAWS = 2000, MOST = 5 };

static void is_near(double value, double expected, double scale) {
  if (!(fabs(value - expected) <= 1e-12 * scale))
    fail_msg("%.17g is not %.17g", value, expected);
}

/* A direction across the normal, turned by an angle about it. */
static void across(const double normal[3], double angle, double out[3]) {
  const double other[3] = {normal[1], normal[2], -normal[0]};
  double first[3], second[3];
  thrum_cross3(normal, other, first);
  const double length = sqrt(thrum_dot3(first, first));
  for (int axis = 0; axis < 3; axis++)
    first[axis] /= length;
  thrum_cross3(normal, first, second);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = cos(angle) * first[axis] + sin(angle) * second[axis];
}

/* A row with a response that is positive, a normal, and a law. */
static thrum_contact_row row_make(random_state *random) {
  thrum_contact_row row = {.ceiling = INFINITY, .touch.stored = INFINITY};
  double square[9];
  random_vector(random, 9, 1, square);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      row.response[3 * a + b] = thrum_dot3(square + 3 * a, square + 3 * b) + (a == b ? 0.1 : 0);
  random_vector(random, 3, 1, row.touch.normal);
  const double length = sqrt(thrum_dot3(row.touch.normal, row.touch.normal));
  for (int axis = 0; axis < 3; axis++)
    row.touch.normal[axis] /= length;
  thrum_contact_row_respond(&row);

  // from outside or inside, with a speed across that friction aims to stop
  row.gap = random_uniform(random);
  row.stiffness = exp(2 * random_uniform(random));
  row.damping = random_index(random, 2) ? fabs(random_uniform(random)) : 0;
  row.friction = random_index(random, 3) ? 0.6 : 0;
  across(row.touch.normal, 3 * random_uniform(random), row.slide);
  return row;
}

/* --- one row ---------------------------------------------------------------------------------- */

static void a_response_is_read_along_the_normal_and_at_its_largest_across(void **context) {
  (void)context;
  random_state random = {51};
  for (int n = 0; n < 50; n++) {
    const thrum_contact_row row = row_make(&random);
    double moved[3], way[3], largest = 0;
    thrum_apply3(row.response, row.touch.normal, moved);
    is_near(row.along, thrum_dot3(row.touch.normal, moved), row.along);
    for (int k = 0; k < 400; k++) {
      across(row.touch.normal, 3.2 * k / 400, way);
      thrum_apply3(row.response, way, moved);
      largest = fmax(largest, thrum_dot3(way, moved));
    }
    assert_true(row.across >= largest * (1 - 1e-12) && row.across <= largest * (1 + 1e-4) + 1e-5);
  }
}

static void an_approach_lasts_until_the_place_moves_away(void **context) {
  (void)context;
  const double h = 0.01, settling = 0.003, none[3] = {0};
  thrum_contact_row row = {.touch.normal = {0, 0, 1}};

  // three approaches without a load keep the largest speed, the first whatever was there before
  row.touch.approach = 9;
  const double speeds[3] = {1, 3, 2};
  for (int n = 0; n < 3; n++) {
    const double velocity[3] = {4, -2, -speeds[n]}, unloaded[3] = {3 * h, 4 * h, -speeds[n] * h};
    thrum_contact_row_approach(&row, h, settling, velocity, unloaded);
    is_near(row.touch.approach, n == 0 ? 1 : 3, 1);
    assert_int_equal(row.touch.towards, 1);
    is_near(row.speed, -speeds[n], 1);
    is_near(row.gained, 0, 1);
    is_near(row.unloaded_length, h * sqrt(25 + speeds[n] * speeds[n]), 1);
    is_near(row.slide[0], 0.5 * h * 4, 1);
    is_near(row.slide[1], 0.5 * h * -2, 1);
    is_near(row.slide[2], 0, 1);
  }

  // at a stand it lasts, and away it ends
  thrum_contact_row_approach(&row, h, settling, none, none);
  assert_int_equal(row.touch.towards, 1);
  thrum_contact_row_approach(&row, h, settling, (const double[3]){0, 0, 1}, none);
  assert_int_equal(row.touch.towards, 0);
}

static void what_the_load_adds_while_a_body_lies_down_is_no_impact(void **context) {
  (void)context;
  const double h = 0.01, load = -30; // [m/s^2]
  for (int n = 0; n < 2; n++) {
    const double settling = n ? 4 * h : 0.5 * h, most = 2 * -load * h * (n ? 4 : 1);
    for (int above = 0; above < 2; above++) {
      const double speed = most * (above ? 1.01 : 0.99), velocity[3] = {0, 0, -speed};
      const double unloaded[3] = {0, 0, -speed * h + 0.5 * load * h * h};
      thrum_contact_row row = {.touch.normal = {0, 0, 1}};
      thrum_contact_row_approach(&row, h, settling, velocity, unloaded);
      is_near(row.gained, -load * h, 1);
      is_near(row.touch.approach, above ? speed : 0, 1);
    }
  }
}

static void a_row_solved_alone_satisfies_its_laws(void **context) {
  (void)context;
  random_state random = {52};
  int pressed = 0, slid = 0, idle = 0;
  for (int n = 0; n < DRAWS; n++) {
    thrum_contact_row row = row_make(&random);
    double free[3], force[3], pushed[3], all[3] = {0, 0, 0};
    random_vector(&random, 3, 2, free);

    // sweeps until nothing changes: its displacement is the free one and what its force adds
    for (int sweep = 0; sweep < 400; sweep++) {
      double at[3], change[3];
      thrum_contact_row_force(&row, force);
      thrum_apply3(row.response, force, pushed);
      for (int axis = 0; axis < 3; axis++)
        at[axis] = free[axis] + pushed[axis];
      thrum_contact_row_solve(&row, at, change);
      for (int axis = 0; axis < 3; axis++)
        all[axis] += change[axis];
    }
    thrum_contact_row_force(&row, force);
    thrum_apply3(row.response, force, pushed);
    for (int axis = 0; axis < 3; axis++) {
      is_near(all[axis], force[axis], 1 + fabs(force[axis]));
      is_near(row.seen[axis], pushed[axis], 1 + fabs(pushed[axis]));
    }

    // the spring, at the gap without its own force
    double place[3];
    for (int axis = 0; axis < 3; axis++)
      place[axis] = free[axis] + pushed[axis];
    const double gap = row.gap + thrum_dot3(row.touch.normal, place);
    const double normal =
        thrum_contact_normal(&row, gap - row.along * row.touch.force, row.touch.stored);
    assert_true(fabs(normal - row.touch.force) <= 1e-9 * (1 + normal));

    // Coulomb's cone: across the normal, no more than its bound, at the bound against what is left
    // of the way
    const double *f = row.touch.friction, bound = row.friction * row.touch.force;
    const double size = sqrt(thrum_dot3(f, f));
    double off[3], least = INFINITY;
    assert_true(fabs(thrum_dot3(f, row.touch.normal)) <= 1e-9 * (1 + bound));
    assert_true(size <= bound * (1 + 1e-12));
    const double along = thrum_dot3(place, row.touch.normal);
    for (int axis = 0; axis < 3; axis++)
      off[axis] = place[axis] - along * row.touch.normal[axis];
    for (int k = 0; k <= 100; k++) {
      double left = 0;
      for (int axis = 0; axis < 3; axis++)
        left += pow(off[axis] - 0.01 * k * row.slide[axis], 2);
      least = fmin(least, sqrt(left));
    }
    if (size < bound * (1 - 1e-6))
      assert_true(least <= 0.006);
    pressed += row.touch.force > 0;
    slid += size > 0 && size >= bound * (1 - 1e-6);
    idle += row.touch.force == 0;
  }
  assert_true(pressed > DRAWS / 4 && slid > DRAWS / 10 && idle > DRAWS / 10);
}

static void what_no_longer_touches_gives_its_forces_back(void **context) {
  (void)context;
  random_state random = {53};
  for (int kind = 0; kind < 2; kind++) {
    thrum_contact_row row = row_make(&random);
    double at[3], change[3], before[3];
    row.gap = 1;
    row.touch.force = kind;
    across(row.touch.normal, 0.3, row.touch.friction);
    thrum_contact_row_force(&row, before);
    for (int axis = 0; axis < 3; axis++)
      at[axis] = 9 * row.touch.normal[axis];
    thrum_contact_row_solve(&row, at, change);
    for (int axis = 0; axis < 3; axis++) {
      is_near(change[axis], -before[axis], 1);
      assert_true(row.touch.friction[axis] == 0);
    }
    assert_true(row.touch.force == 0);
  }
}

static void a_row_measures_its_work_and_its_gap(void **context) {
  (void)context;
  thrum_contact_row row = {
      .gap = 0.5, .touch = {.normal = {0, 0.6, 0.8}, .force = 7, .friction = {2, 0.8, -0.6}}};
  const double moved[3] = {1, 2, 3};
  thrum_contact_row_measure(&row, moved);
  is_near(row.touch.gap, 0.5 + 3.6, 1);
  is_near(row.work, 7 * 3.6, 1);
  is_near(row.rubbed, 2 + 1.6 - 1.8, 1);
  assert_true(thrum_contact_row_counts(&row));

  // each of its energies has to be a number that can be summed
  double *const energies[4] = {&row.work, &row.rubbed, &row.driven, &row.unloaded_length};
  for (int n = 0; n < 4; n++) {
    const double kept = *energies[n];
    *energies[n] = n < 2 ? -2 * THRUM_ENERGY_MOST : 2 * THRUM_ENERGY_MOST;
    assert_false(thrum_contact_row_counts(&row));
    *energies[n] = NAN;
    assert_false(thrum_contact_row_counts(&row));
    *energies[n] = kept;
  }
  for (int n = 0; n < 3; n++)
    for (int other = n + 1; other < 3; other++) {
      thrum_contact_row both = {0};
      double *const sums[3] = {&both.work, &both.rubbed, &both.driven};
      *sums[n] = *sums[other] = 0.7 * THRUM_ENERGY_MOST;
      assert_false(thrum_contact_row_counts(&both));
    }
  row.touch.gap = INFINITY;
  assert_false(thrum_contact_row_counts(&row));
  row.touch.gap = -1e200;
  row.stiffness = 1;
  assert_false(thrum_contact_row_counts(&row));
}

static void a_ceiling_lets_out_what_restitution_or_an_excess_gives(void **context) {
  (void)context;
  const double h = 0.01;
  thrum_contact_row row = {
      .gap = -0.2, .speed = -3, .restitution = 0.5, .gained = 1e9, .touch.approach = 1};

  // by restitution, and by a tenth of the excess in a step where that is more
  is_near(thrum_contact_row_ceiling(&row, h, 0), -0.2 + 0.5 * h * (-3 + 0.5), 1);
  is_near(thrum_contact_row_ceiling(&row, h, 0.5), -0.2 + 0.5 * h * (-3 + 0.1 * 0.1 / h), 1);
  is_near(thrum_contact_row_ceiling(&row, h, 0.1), -0.2 + 0.5 * h * (-3 + 0.5), 1);

  // no faster than what presses on can stop; nothing where it is outside or nothing presses
  row.touch.approach = 0;
  row.gained = 0.004;
  is_near(thrum_contact_row_ceiling(&row, h, 1), -0.2 + 0.5 * h * (-3 + sqrt(0.4 * 0.2)), 1);
  row.gained = -1;
  is_near(thrum_contact_row_ceiling(&row, h, 1), -0.2 + 0.5 * h * -3, 1);
  row.gained = 0.004;
  row.gap = 0.2;
  is_near(thrum_contact_row_ceiling(&row, h, 1), 0.2 + 0.5 * h * -3, 1);

  // a spring that gives all back pushes to its end
  row.restitution = 1;
  assert_true(thrum_contact_row_ceiling(&row, h, 1) == INFINITY);
}

/* --- all rows of a step ----------------------------------------------------------------------- */

/* Rows with forces, depths and stores, in a list with something between them. */
typedef struct many {
  struct {
    thrum_contact_row row;
    double more;
  } items[MOST];
  thrum_row_list list;
} many;

static void many_make(many *m, random_state *random) {
  *m = (many){0};
  m->list = (thrum_row_list){m->items, MOST, sizeof m->items[0]};
  for (int n = 0; n < MOST; n++) {
    thrum_contact_row *row = &m->items[n].row;
    row->gap = random_uniform(random);
    row->stiffness = 5 + random_uniform(random);
    row->unloaded_length = fabs(random_uniform(random));
    row->touch.force = fabs(random_uniform(random));
    row->touch.gap = random_uniform(random);
    row->touch.stored = fabs(random_uniform(random));
    row->work = 3 * random_uniform(random);
    random_vector(random, 3, 1, row->touch.friction);
  }
}

static void springs_deeper_than_their_forces_have_an_excess(void **context) {
  (void)context;
  random_state random = {54};
  int excess = 0;
  for (int k = 0; k < 100; k++) {
    many m;
    many_make(&m, &random);
    double carried = 0, pressed = 0, flow = 0;
    for (int n = 0; n < MOST; n++) {
      const thrum_contact_row *row = &m.items[n].row;
      const double *f = row->touch.friction;
      carried += row->touch.force;
      pressed += row->gap < 0 ? -row->gap * row->stiffness : 0;
      flow +=
          row->unloaded_length * (row->touch.force + sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
    }
    is_near(thrum_rows_excess(&m.list), pressed > carried ? (pressed - carried) / pressed : 0, 1);
    is_near(thrum_rows_flow(&m.list), flow, flow);
    excess += pressed > carried;
  }
  assert_true(excess > 10 && excess < 90);
}

static void springs_hold_what_they_took_and_no_more_than_their_depth(void **context) {
  (void)context;
  random_state random = {55};
  int full = 0, empty = 0;
  for (int k = 0; k < 200; k++) {
    many m;
    many_make(&m, &random);
    double taken = 0, room = 0, sum = 0, share = -1;
    for (int n = 0; n < MOST; n++) {
      const thrum_contact_row *row = &m.items[n].row;
      taken += row->touch.stored - row->work;
      room += thrum_contact_energy(row->stiffness, row->touch.gap);
    }
    const double kept = fmin(fmax(taken, 0), room), stored = thrum_rows_keep_stored(&m.list);
    is_near(stored, kept, 1 + kept);

    // each by the same share of what its depth is, and nothing outside
    for (int n = 0; n < MOST; n++) {
      const thrum_contact_row *row = &m.items[n].row;
      const double own = thrum_contact_energy(row->stiffness, row->touch.gap);
      is_near(row->touch.stored, room > 0 ? own * kept / room : 0, 1 + own);
      sum += row->touch.stored;
    }
    is_near(sum, stored, 1 + stored);
    is_near(thrum_rows_stored(&m.list), stored, 1 + stored);
    full += taken > room;
    empty += taken < 0;

    // a loss below 0 is taken out of them, as far as they hold it; one above is none
    if (!(stored > 0))
      continue;
    assert_true(thrum_rows_cover_loss(&m.list, stored, 1) == stored);
    assert_true(thrum_rows_stored(&m.list) == stored ||
                fabs(thrum_rows_stored(&m.list) - stored) <= 1e-15 * stored);
    share = k % 2 ? 0.3 : 2;
    const double left = thrum_rows_cover_loss(&m.list, stored, -share * stored);
    is_near(left, fmax(1 - share, 0) * stored, stored);
    is_near(thrum_rows_stored(&m.list), left, stored);
    for (int n = 0; n < MOST; n++)
      m.items[n].row.touch.stored = 0;
    assert_true(thrum_rows_cover_loss(&m.list, 0, -1) == 0 && thrum_rows_stored(&m.list) == 0);
  }
  assert_true(full > 20 && empty > 10);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_response_is_read_along_the_normal_and_at_its_largest_across),
      cmocka_unit_test(an_approach_lasts_until_the_place_moves_away),
      cmocka_unit_test(what_the_load_adds_while_a_body_lies_down_is_no_impact),
      cmocka_unit_test(a_row_solved_alone_satisfies_its_laws),
      cmocka_unit_test(what_no_longer_touches_gives_its_forces_back),
      cmocka_unit_test(a_row_measures_its_work_and_its_gap),
      cmocka_unit_test(a_ceiling_lets_out_what_restitution_or_an_excess_gives),
      cmocka_unit_test(springs_deeper_than_their_forces_have_an_excess),
      cmocka_unit_test(springs_hold_what_they_took_and_no_more_than_their_depth),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
