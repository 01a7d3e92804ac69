/* Tests of an impact whose rows are all solved at once (contact_impact_newton.c) over bodies that
 * are made by hand: the bodies have the sum of what acts on them; impulses push, and what they push
 * on leaves as fast as was asked for; friction lies in its cone and against the velocity that is
 * left (complementarity, Moreau 1988).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "contact/contact_impact_private.h"
#include "tests/support/random_model.h"

enum { BODIES = 6, PAIRS = 5, FLOOR = 2, WIDTH = THRUM_NEWTON_STRIDE(6 * BODIES) };

/* Bodies that fly, one that does not turn, one that is not struck, one that moves as it is told,
 * and one that has failed. */
typedef enum kind { FLIES, SLIDES, TOLD, APART, FAILED } kind;
static const kind kinds[BODIES] = {FLIES, TOLD, FLIES, FAILED, SLIDES, APART};

typedef struct impact {
  thrum_contact_member members[BODIES];
  thrum_contact_run runs[BODIES];
  thrum_contact contacts[BODIES];
  thrum_contact_environment environments[BODIES];
  thrum_contact_row floor[BODIES][FLOOR];
  thrum_pair_row rows[PAIRS];
  thrum_obstacle obstacle;
  thrum_contact_pairs pairs;
  double room[(WIDTH + 3) * WIDTH];
  thrum_pairs_run run;
  thrum_impact_rows all;
} impact;

static void body_make(impact *m, int n, random_state *random) {
  thrum_contact_run *body = m->runs + n;
  thrum_impact_body *of = &body->impact;
  double root[9];
  m->environments[n].obstacles = &m->obstacle;
  m->environments[n].obstacle_count = 1;
  m->contacts[n].row_count = kinds[n] == TOLD ? 0 : FLOOR;
  m->members[n].status = kinds[n] == FAILED ? THRUM_NOT_FINITE : THRUM_OK;
  *body = (thrum_contact_run){.contact = &m->contacts[n], .environment = &m->environments[n]};
  body->view.rows = m->floor[n];
  random_vector(random, 3, 1, body->centre);
  random_vector(random, 3, 0.2, of->passed);
  random_vector(random, 3, 1, of->velocity);
  random_vector(random, 3, 1, of->spin);
  of->taken = kinds[n] != APART;

  // what was there before says nothing
  random_vector(random, 9, 1, of->root);
  of->column = 3;
  if (kinds[n] == TOLD || kinds[n] == FAILED)
    return;
  of->inverse_mass = exp(random_uniform(random));
  random_vector(random, 9, 1, root);
  for (int a = 0; a < 3 && kinds[n] != SLIDES; a++)
    for (int b = 0; b < 3; b++)
      of->inverse[3 * a + b] = thrum_dot3(root + 3 * a, root + 3 * b) + (a == b ? 0.2 : 0);
}

static void row_make(thrum_contact_row *row, double friction, thrum_strike_part part,
                     random_state *random) {
  random_vector(random, 3, 1, row->touch.normal);
  const double length = sqrt(thrum_dot3(row->touch.normal, row->touch.normal));
  for (int axis = 0; axis < 3; axis++)
    row->touch.normal[axis] /= length;
  row->strike.part = part;
  row->strike.away = part == THRUM_STRIKES ? fabs(random_uniform(random)) : 0;
  row->strike.friction = friction;
}

/* Rows between bodies, of which one is of a body with itself and takes no part, and on an obstacle
 * that moves. */
static void impact_make(impact *m, double friction, random_state *random) {
  static const int32_t sides[PAIRS][2] = {{0, 2}, {4, 2}, {0, 0}, {1, 4}, {2, 1}};
  memset(m, 0, sizeof *m);
  random_vector(random, 3, 0.5, m->obstacle.velocity);
  for (int n = 0; n < BODIES; n++) {
    body_make(m, n, random);
    for (int k = 0; k < FLOOR; k++) {
      random_vector(random, 3, 1, m->floor[n][k].lever);
      row_make(m->floor[n] + k, friction,
               kinds[n] == APART ? THRUM_NO_PART
               : k               ? THRUM_BEARS
                                 : THRUM_STRIKES,
               random);
    }
  }
  for (int n = 0; n < PAIRS; n++) {
    thrum_pair_row *pair = m->rows + n;
    memcpy(pair->members, sides[n], sizeof pair->members);
    random_vector(random, 6, 1, pair->starts[0]);
    row_make(&pair->row, friction, n == 3 ? THRUM_BEARS : THRUM_STRIKES, random);
  }
  m->pairs.member_max = BODIES;
  m->run = (thrum_pairs_run){
      .pairs = &m->pairs, .members = m->members, .count = BODIES, .row_count = PAIRS};
  m->run.view.runs = m->runs;
  m->run.view.rows = m->rows;
  m->run.view.impact_room = m->room;
  m->all = (thrum_impact_rows){m->runs, BODIES, &m->run, false};

  // how each place answers, by unit impulses on bodies that are at rest
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(&m->all, &n, &at);) {
    double trace = 0, along = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double unit[3] = {axis == 0, axis == 1, axis == 2},
                   back[3] = {-unit[0], -unit[1], -unit[2]};
      double before[3], after[3];
      thrum_impact_velocity(&at, before);
      thrum_impact_push(&at, unit);
      thrum_impact_velocity(&at, after);
      thrum_impact_push(&at, back);
      thrum_subtract3(after, before, after);
      trace += after[axis];
      along += at.row->touch.normal[axis] * thrum_dot3(at.row->touch.normal, after);
    }
    at.row->strike.along = along;
    at.row->strike.across = trace - along;
  }
  for (int n = 0; n < BODIES; n++) {
    memset(m->runs[n].impact.impulse, 0, sizeof m->runs[n].impact.impulse);
    memset(m->runs[n].impact.whirl, 0, sizeof m->runs[n].impact.whirl);
    for (int k = 0; k < FLOOR; k++)
      memset(m->floor[n][k].strike.impulse, 0, 3 * sizeof(double));
  }
  for (int n = 0; n < PAIRS; n++)
    memset(m->rows[n].row.strike.impulse, 0, 3 * sizeof(double));
}

/* The arms of a row between bodies end at one point, halfway between its places as the bodies have
 * gone. */
static void arm_of(const impact *m, const thrum_pair_row *pair, int side, double arm[3]) {
  const thrum_contact_run *a = m->runs + pair->members[0], *b = m->runs + pair->members[1];
  const thrum_contact_run *own = m->runs + pair->members[side];
  for (int axis = 0; axis < 3; axis++)
    arm[axis] = 0.5 * (pair->starts[0][axis] + a->impact.passed[axis] + pair->starts[1][axis] +
                       b->impact.passed[axis]) -
                own->centre[axis] - own->impact.passed[axis];
}

/* The velocity of a body at the end of an arm under what has acted on it. */
static void add_velocity(const thrum_contact_run *body, const double arm[3], double sign,
                         double out[3]) {
  const thrum_impact_body *of = &body->impact;
  double spin[3], turned[3];
  thrum_apply3(of->inverse, of->whirl, spin);
  for (int axis = 0; axis < 3; axis++)
    spin[axis] += of->spin[axis];
  thrum_cross3(spin, arm, turned);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += sign * (of->velocity[axis] + of->inverse_mass * of->impulse[axis] + turned[axis]);
}

/* Adds an impulse at the end of an arm to what a body should have. */
static void add_impulse(const double arm[3], const double impulse[3], double sign, double sum[6]) {
  double torque[3];
  thrum_cross3(arm, impulse, torque);
  for (int axis = 0; axis < 3; axis++) {
    sum[axis] += sign * impulse[axis];
    sum[3 + axis] += sign * torque[axis];
  }
}

/* How far a row is from its laws at the velocity of its place. */
static double off_law(const thrum_contact_row *row, const double v[3]) {
  const thrum_row_strike *strike = &row->strike;
  const double *n = row->touch.normal;
  const double force = thrum_dot3(strike->impulse, n), speed = thrum_dot3(v, n) - strike->away;
  double off = fmax(-force, 0) + fmax(-speed, 0) + fmin(fabs(force), fabs(speed)), across[3],
         left[3];
  for (int axis = 0; axis < 3; axis++) {
    across[axis] = strike->impulse[axis] - force * n[axis];
    left[axis] = v[axis] - (speed + strike->away) * n[axis];
  }

  // within the cone; what still slides is pushed against by all of it
  const double size = sqrt(thrum_dot3(across, across)), rest = sqrt(thrum_dot3(left, left)),
               most = strike->friction * force;
  off = fmax(off, size - most);
  if (strike->friction > 0 && force > 1e-6)
    off = fmax(off, fmin(rest, (most * rest + thrum_dot3(across, left)) / most));
  return off;
}

/* Solves an impact; how far it is from its laws. */
static double solve(impact *m, int *pressed) {
  static const double none[3] = {0, 0, 0};
  double sums[BODIES][6] = {{0}}, most = 0;
  assert_true(thrum_impact_newton(&m->all, 1e-12));
  for (int n = 0; n < BODIES; n++)
    for (int k = 0; k < m->contacts[n].row_count && kinds[n] != FAILED; k++)
      add_impulse(m->floor[n][k].lever, m->floor[n][k].strike.impulse, 1, sums[n]);
  for (int n = 0; n < PAIRS; n++)
    for (int side = 0; side < 2; side++) {
      double arm[3];
      arm_of(m, m->rows + n, side, arm);
      add_impulse(arm, m->rows[n].row.strike.impulse, side ? -1 : 1,
                  sums[m->rows[n].members[side]]);
    }

  // momentum, and angular momentum
  for (int n = 0; n < BODIES; n++)
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(sums[n][axis] - m->runs[n].impact.impulse[axis]) <=
                  1e-11 * (1 + fabs(sums[n][axis])));
      assert_true(fabs(sums[n][3 + axis] - m->runs[n].impact.whirl[axis]) <=
                  1e-11 * (1 + fabs(sums[n][3 + axis])));
    }

  // the laws of all rows that take part; the others have nothing
  for (int n = 0; n < BODIES; n++)
    for (int k = 0; k < m->contacts[n].row_count; k++) {
      const thrum_contact_row *row = m->floor[n] + k;
      double v[3] = {-m->obstacle.velocity[0], -m->obstacle.velocity[1], -m->obstacle.velocity[2]};
      if (kinds[n] == FAILED || kinds[n] == APART) {
        assert_memory_equal(row->strike.impulse, none, sizeof none);
        continue;
      }
      add_velocity(m->runs + n, row->lever, 1, v);
      most = fmax(most, off_law(row, v));
      *pressed += thrum_dot3(row->strike.impulse, row->touch.normal) > 0;
    }
  for (int n = 0; n < PAIRS; n++) {
    double v[3] = {0, 0, 0}, arm[3];
    if (m->rows[n].members[0] == m->rows[n].members[1]) {
      assert_memory_equal(m->rows[n].row.strike.impulse, none, sizeof none);
      continue;
    }
    for (int side = 0; side < 2; side++) {
      arm_of(m, m->rows + n, side, arm);
      add_velocity(m->runs + m->rows[n].members[side], arm, side ? -1 : 1, v);
    }
    most = fmax(most, off_law(&m->rows[n].row, v));
    *pressed += thrum_dot3(m->rows[n].row.strike.impulse, m->rows[n].row.touch.normal) > 0;
  }
  return most;
}

static void impulses_satisfy_the_laws_of_all_rows(void **context) {
  (void)context;
  impact *m = random_alloc(1, sizeof *m);
  for (int rough = 0; rough < 2; rough++) {
    random_state random = {(uint64_t)(81 + rough)};
    int near = 0, pressed = 0;
    for (int k = 0; k < 200; k++) {
      impact_make(m, rough ? 0.3 : 0, &random);
      near += solve(m, &pressed) <= (rough ? 1e-5 : 1e-8);
    }
    print_message("friction %g: %d of 200 to the end, %d rows pressed\n", rough ? 0.3 : 0.0, near,
                  pressed);
    assert_true(pressed > 400);
    assert_true(near >= (rough ? 60 : 175));
  }
  free(m);
}

static void what_has_no_room_or_no_inertia_is_not_solved(void **context) {
  (void)context;
  impact *m = random_alloc(1, sizeof *m);
  random_state random = {85};

  // bodies that turn about one axis alone
  for (int axis = 0; axis < 3; axis++) {
    impact_make(m, 0, &random);
    memset(m->runs[0].impact.inverse, 0, sizeof m->runs[0].impact.inverse);
    m->runs[0].impact.inverse[4 * axis] = 1;
    assert_false(thrum_impact_newton(&m->all, 1e-12));
  }

  // two bodies where there is room for one
  impact_make(m, 0, &random);
  const thrum_impact_rows two = {m->runs, 3, NULL, false}, one = {m->runs, 1, NULL, false};
  assert_false(thrum_impact_newton(&two, 1e-12));
  assert_true(thrum_impact_newton(&one, 1e-12));

  // none that gives way
  for (int n = 0; n < BODIES; n++)
    m->runs[n].impact.taken = false;
  assert_false(thrum_impact_newton(&m->all, 1e-12));
  free(m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(impulses_satisfy_the_laws_of_all_rows),
      cmocka_unit_test(what_has_no_room_or_no_inertia_is_not_solved),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
