/* Tests of the solve of all rows of a group at once (contact_pairs_newton.c) over groups that are
 * made by hand: what it says moves is what its forces move, by sums of their own; each row
 * satisfies its laws there; and it gets there in few iterations, which it would not with a
 * derivative that is wrong.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"
#include "contact/contact_pairs_newton.h"
#include "contact/contact_pairs_private.h"
#include "tests/support/random_model.h"

enum { MEMBERS = 5, RANK = 9, ROWS = 6, FLOOR = 2, POINTS = 3 };

/* The members of a group: free ones, a held one, a solid, and one that has failed. */
typedef enum kind { FREE, HELD, SOLID, FAILED, LIGHT } kind;
static const kind kinds[MEMBERS] = {FREE, SOLID, HELD, FAILED, LIGHT};
static const int32_t ranks[MEMBERS] = {7, 0, 9, 4, 2};

/* A group, with all that the solve reads of it, and where each body would be without forces. */
typedef struct group {
  thrum_contact_member members[MEMBERS];
  thrum_contact_run runs[MEMBERS];
  thrum_contact contacts[MEMBERS];
  thrum_contact_environment environments[MEMBERS];
  thrum_rigid_frame frame;
  thrum_model models[MEMBERS];
  double bases[MEMBERS][POINTS * 3 * RANK], weights[MEMBERS][RANK], moved[MEMBERS][RANK];
  double start[MEMBERS][RANK], way[MEMBERS][3], turn[MEMBERS][3];
  int32_t vertices[POINTS];
  thrum_contact_row floor[MEMBERS][FLOOR];
  thrum_pair_row rows[ROWS];
  double row_bases[ROWS][2][3 * RANK];
  thrum_newton_row newton_rows[ROWS + MEMBERS * FLOOR];
  double newton_ways[(ROWS + MEMBERS * FLOOR) * 6 * THRUM_NEWTON_BODY(RANK)];
  double
      newton_room[(2 * MEMBERS * THRUM_NEWTON_BODY(RANK) + 9) * MEMBERS * THRUM_NEWTON_BODY(RANK)];
  thrum_newton_body newton_bodies[MEMBERS];
  thrum_contact_solid solid;
  thrum_pairs_run run;
} group;

/* A rotation, by its axis and angle at random. */
static void axes_make(random_state *random, double axes[9]) {
  double w[4], square = 0;
  random_vector(random, 4, 1, w);
  for (int n = 0; n < 4; n++)
    square += w[n] * w[n];
  for (int n = 0; n < 4; n++)
    w[n] /= sqrt(square);
  const double made[9] = {1 - 2 * (w[2] * w[2] + w[3] * w[3]), 2 * (w[1] * w[2] - w[0] * w[3]),
                          2 * (w[1] * w[3] + w[0] * w[2]),     2 * (w[1] * w[2] + w[0] * w[3]),
                          1 - 2 * (w[1] * w[1] + w[3] * w[3]), 2 * (w[2] * w[3] - w[0] * w[1]),
                          2 * (w[1] * w[3] - w[0] * w[2]),     2 * (w[2] * w[3] + w[0] * w[1]),
                          1 - 2 * (w[1] * w[1] + w[2] * w[2])};
  memcpy(axes, made, sizeof made);
}

static void body_make(group *g, int m, random_state *random) {
  thrum_contact_run *body = g->runs + m;
  const bool steps = kinds[m] != SOLID && kinds[m] != FAILED;
  g->contacts[m].rank = ranks[m];
  g->contacts[m].row_count = steps ? FLOOR : 0;
  g->members[m].status = kinds[m] == FAILED ? THRUM_NOT_FINITE : THRUM_OK;
  g->members[m].solid = kinds[m] == SOLID ? &g->solid : NULL;
  g->models[m].basis = g->bases[m];
  random_vector(random, POINTS * 3 * RANK, 1, g->bases[m]);
  for (int i = 0; i < RANK; i++)
    g->weights[m][i] = exp(random_uniform(random) - 1);
  random_vector(random, RANK, 0.3, g->start[m]);
  random_vector(random, 3, 0.5, g->way[m]);
  random_vector(random, 3, 0.3, g->turn[m]);

  // as it moves without forces
  *body = (thrum_contact_run){
      .model = &g->models[m], .contact = &g->contacts[m], .environment = &g->environments[m]};
  body->view.vertices = g->vertices;
  body->view.weights = g->weights[m];
  body->view.moved = g->moved[m];
  body->view.rows = g->floor[m];
  memcpy(g->moved[m], g->start[m], sizeof g->start[m]);
  memcpy(body->moved, g->way[m], sizeof body->moved);
  memcpy(body->turned, g->turn[m], sizeof body->turned);
  axes_make(random, body->axes);
  if (!steps || kinds[m] == HELD)
    return;
  body->mass_weight = kinds[m] == LIGHT ? 2 : 0.4;
  g->environments[m].rigid_frame = &g->frame;
  double root[9];
  random_vector(random, 9, 1, root);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      body->turn_weight[3 * a + b] = thrum_dot3(root + 3 * a, root + 3 * b) + (a == b ? 0.2 : 0);
}

/* --- by sums of the test's own ---------------------------------------------------------------- */

/* Where a place of a member goes under the displacement of its shape, the way and the turn. */
static void place_of(const group *g, int64_t m, const double *basis, const double lever[3],
                     const double *d, const double way[3], const double turn[3], double out[3]) {
  const int64_t r = ranks[m];
  double u[3] = {0, 0, 0}, turned[3];
  for (int axis = 0; axis < 3; axis++)
    for (int64_t i = 0; i < r; i++)
      u[axis] += basis[axis * r + i] * d[i];
  thrum_cross3(turn, lever, turned);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = thrum_dot3(g->runs[m].axes + 3 * axis, u) + way[axis] + turned[axis];
}

/* Adds what a force on a place moves. */
static void push(const group *g, int64_t m, const double *basis, const double lever[3],
                 const double force[3], double *d, double way[3], double turn[3]) {
  const int64_t r = ranks[m];
  const thrum_contact_run *body = g->runs + m;
  double own[3], torque[3], turned[3];
  if (kinds[m] == SOLID || kinds[m] == FAILED)
    return;
  thrum_apply3_transposed(body->axes, force, own);
  for (int64_t i = 0; i < r; i++)
    d[i] +=
        g->weights[m][i] * (own[0] * basis[i] + own[1] * basis[r + i] + own[2] * basis[2 * r + i]);
  thrum_cross3(lever, force, torque);
  thrum_apply3(body->turn_weight, torque, turned);
  for (int axis = 0; axis < 3; axis++) {
    way[axis] += body->mass_weight * force[axis];
    turn[axis] += turned[axis];
  }
}

/* The response of a row, by a unit of force along each axis. */
static void respond(const group *g, const int64_t of[2], const double *const basis[2],
                    const double *const lever[2], double response[9]) {
  memset(response, 0, 9 * sizeof *response);
  for (int side = 0; side < 2 && of[side] >= 0; side++)
    for (int axis = 0; axis < 3; axis++) {
      const double unit[3] = {axis == 0, axis == 1, axis == 2};
      double d[RANK] = {0}, way[3] = {0}, turn[3] = {0}, moved[3];
      push(g, of[side], basis[side], lever[side], unit, d, way, turn);
      place_of(g, of[side], basis[side], lever[side], d, way, turn, moved);
      for (int n = 0; n < 3; n++)
        response[3 * n + axis] += moved[n];
    }
}

/* --- rows ------------------------------------------------------------------------------------- */

static void law_make(thrum_contact_row *row, double friction, random_state *random) {
  random_vector(random, 3, 1, row->touch.normal);
  const double length = sqrt(thrum_dot3(row->touch.normal, row->touch.normal));
  for (int axis = 0; axis < 3; axis++)
    row->touch.normal[axis] /= length;
  thrum_contact_row_respond(row);
  row->gap = 0.3 * random_uniform(random);
  row->stiffness = exp(2 * random_uniform(random)) / row->along;
  row->ceiling = INFINITY;
  row->touch.stored = INFINITY;
  row->friction = friction;
  row->touch.force = random_index(random, 2) ? fabs(random_uniform(random)) : 0;

  // it aims at a way across the normal
  random_vector(random, 3, 0.2, row->slide);
  const double along = thrum_dot3(row->slide, row->touch.normal);
  for (int axis = 0; axis < 3; axis++)
    row->slide[axis] -= along * row->touch.normal[axis];
}

/* Rows between members, the last of one body with itself, and rows on obstacles that move. */
static void group_make(group *g, double friction, random_state *random) {
  static const int32_t sides[ROWS][2] = {{0, 2}, {4, 0}, {2, 4}, {1, 0}, {4, 1}, {0, 0}};
  memset(g, 0, sizeof *g);
  for (int n = 0; n < POINTS; n++)
    g->vertices[n] = POINTS - 1 - n;
  for (int m = 0; m < MEMBERS; m++)
    body_make(g, m, random);
  for (int n = 0; n < ROWS; n++) {
    thrum_pair_row *row = g->rows + n;
    const bool own = sides[n][0] == sides[n][1];
    for (int side = 0; side < 2; side++) {
      row->members[side] = sides[n][side];
      row->basis[side] = g->row_bases[n][side];
      random_vector(random, 3 * RANK, 1, g->row_bases[n][side]);
      random_vector(random, 3, own ? 0 : 0.5, side == 0 ? row->row.lever : row->lever);
    }
    const int64_t of[2] = {sides[n][0], own ? -1 : sides[n][1]};
    const double *const levers[2] = {row->row.lever, row->lever};
    respond(g, of, row->basis, levers, row->row.response);

    // two places of one body are apart by its shape alone
    for (int k = 0; own && k < 3; k++)
      row->row.response[4 * k] -= g->runs[of[0]].mass_weight;
    law_make(&row->row, friction, random);
  }
  for (int m = 0; m < MEMBERS; m++)
    for (int n = 0; n < g->contacts[m].row_count; n++) {
      thrum_contact_row *row = g->floor[m] + n;
      row->touch.point = n;
      random_vector(random, 3, 0.5, row->lever);
      random_vector(random, 3, 0.1, row->drift);
      const int64_t of[2] = {m, -1};
      const double *const basis[2] = {g->bases[m] + 3 * (int64_t)g->vertices[n] * ranks[m], NULL};
      const double *const levers[2] = {row->lever, NULL};
      respond(g, of, basis, levers, row->response);
      law_make(row, friction, random);
    }
  g->run.members = g->members;
  g->run.count = MEMBERS;
  g->run.row_count = ROWS;
  g->run.view.runs = g->runs;
  g->run.view.rows = g->rows;
  g->run.view.newton_rows = g->newton_rows;
  g->run.view.newton_ways = g->newton_ways;
  g->run.view.newton_room = g->newton_room;
  g->run.view.newton_bodies = g->newton_bodies;
}

/* All members as the forces of all rows move them. */
static void move_all(const group *g, double d[MEMBERS][RANK], double way[MEMBERS][3],
                     double turn[MEMBERS][3]) {
  static const double none[3] = {0, 0, 0};
  memcpy(d, g->start, sizeof g->start);
  memcpy(way, g->way, sizeof g->way);
  memcpy(turn, g->turn, sizeof g->turn);
  for (int n = 0; n < ROWS; n++) {
    const thrum_pair_row *row = g->rows + n;
    double force[3], nowhere[3] = {0}, against[3];
    thrum_contact_row_force(&row->row, force);
    for (int axis = 0; axis < 3; axis++)
      against[axis] = -force[axis];
    const int64_t a = row->members[0], b = row->members[1];
    if (a == b) {
      push(g, a, row->basis[0], none, force, d[a], nowhere, turn[a]);
      continue;
    }
    push(g, a, row->basis[0], row->row.lever, force, d[a], way[a], turn[a]);
    push(g, b, row->basis[1], row->lever, against, d[b], way[b], turn[b]);
  }
  for (int m = 0; m < MEMBERS; m++)
    for (int n = 0; n < g->contacts[m].row_count; n++) {
      double force[3];
      thrum_contact_row_force(g->floor[m] + n, force);
      push(g, m, g->bases[m] + 3 * (int64_t)g->vertices[n] * ranks[m], g->floor[m][n].lever, force,
           d[m], way[m], turn[m]);
    }
}

/* Where the two places of a row go against each other. */
static void way_of_row(const group *g, const thrum_pair_row *row, double d[MEMBERS][RANK],
                       double way[MEMBERS][3], double turn[MEMBERS][3], double x[3]) {
  static const double none[3] = {0, 0, 0};
  const int64_t a = row->members[0], b = row->members[1];
  double other[3] = {0, 0, 0};
  if (a == b) {
    place_of(g, a, row->basis[0], none, d[a], none, none, x);
    return;
  }
  place_of(g, a, row->basis[0], row->row.lever, d[a], way[a], turn[a], x);
  place_of(g, b, row->basis[1], row->lever, d[b], way[b], turn[b], other);
  thrum_subtract3(x, other, x);
}

/* How far a row is from its laws at a displacement x, relative to its force. */
static double off_law(const thrum_contact_row *row, const double x[3]) {
  const double *n = row->touch.normal, *f = row->touch.friction, along = thrum_dot3(n, x);
  const double normal = thrum_contact_normal(row, row->gap + along - row->along * row->touch.force,
                                             row->touch.stored);
  double free[3], friction[3], off = fabs(normal - row->touch.force);
  for (int axis = 0; axis < 3; axis++)
    free[axis] = x[axis] - along * n[axis] - row->across * f[axis];
  thrum_contact_friction(row, normal, free, friction);
  for (int axis = 0; axis < 3; axis++)
    off = fmax(off, fabs(friction[axis] - f[axis]));
  return off / (1 + normal);
}

/* Starts where the sweeps do: at the forces that the rows have. */
static void begin(group *g) {
  double d[MEMBERS][RANK], way[MEMBERS][3], turn[MEMBERS][3];
  move_all(g, d, way, turn);
  for (int m = 0; m < MEMBERS; m++) {
    memcpy(g->moved[m], d[m], sizeof d[m]);
    memcpy(g->runs[m].moved, way[m], sizeof way[m]);
    memcpy(g->runs[m].turned, turn[m], sizeof turn[m]);
  }
}

/* Solves a group; how far it is from all laws, or -1 where it did not settle. */
static double solve(group *g, int *pressed) {
  double d[MEMBERS][RANK], way[MEMBERS][3], turn[MEMBERS][3], most = 0;
  begin(g);
  const bool settled = thrum_pairs_newton(&g->run, 1e-10);

  // what moves is what the forces move, settled or not
  move_all(g, d, way, turn);
  for (int m = 0; m < MEMBERS; m++) {
    for (int64_t i = 0; i < ranks[m]; i++)
      assert_true(fabs(g->moved[m][i] - d[m][i]) <= 1e-11 * (1 + fabs(d[m][i])));
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(g->runs[m].moved[axis] - way[m][axis]) <= 1e-11 * (1 + fabs(way[m][axis])));
      assert_true(fabs(g->runs[m].turned[axis] - turn[m][axis]) <=
                  1e-11 * (1 + fabs(turn[m][axis])));
    }
  }
  if (!settled)
    return -1;

  // each row's laws, and the displacement that it was solved at
  for (int n = 0; n < ROWS; n++) {
    double x[3];
    way_of_row(g, g->rows + n, d, way, turn, x);
    most = fmax(most, off_law(&g->rows[n].row, x));
    *pressed += g->rows[n].row.touch.force > 0;
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs(x[axis] - g->rows[n].row.seen[axis]) <= 1e-7 * (1 + fabs(x[axis])));
  }
  for (int m = 0; m < MEMBERS; m++)
    for (int n = 0; n < g->contacts[m].row_count; n++) {
      const thrum_contact_row *row = g->floor[m] + n;
      double x[3];
      place_of(g, m, g->bases[m] + 3 * (int64_t)g->vertices[n] * ranks[m], row->lever, d[m], way[m],
               turn[m], x);
      for (int axis = 0; axis < 3; axis++)
        assert_true(fabs(x[axis] - row->seen[axis]) <= 1e-7 * (1 + fabs(x[axis])));
      thrum_subtract3(x, row->drift, x);
      most = fmax(most, off_law(row, x));
      *pressed += row->touch.force > 0;
    }
  return most;
}

static void forces_of_a_group_satisfy_the_laws_of_all_rows(void **context) {
  (void)context;
  group *g = random_alloc(1, sizeof *g);
  for (int rough = 0; rough < 2; rough++) {
    random_state random = {(uint64_t)(71 + rough)};
    int settled = 0, pressed = 0;
    double worst = 0;
    for (int k = 0; k < 200; k++) {
      group_make(g, rough ? 0.5 : 0, &random);
      const double off = solve(g, &pressed);
      settled += off >= 0;
      worst = fmax(worst, off);
    }
    print_message("friction %g: %d of 200 settled, off by %.1e, %d rows pressed\n",
                  rough ? 0.5 : 0.0, settled, worst, pressed);
    assert_true(worst <= 1e-7);
    assert_true(pressed > 200);
    assert_true(settled >= (rough ? 30 : 170));
  }
  free(g);
}

static void what_answers_to_no_force_is_not_solved(void **context) {
  (void)context;
  group *g = random_alloc(1, sizeof *g);
  random_state random = {75};
  group_make(g, 0, &random);
  for (int m = 0; m < MEMBERS; m++)
    g->members[m].status = THRUM_NOT_FINITE;
  assert_false(thrum_pairs_newton(&g->run, 1e-10));

  // nor one whose weight is none
  group_make(g, 0, &random);
  g->weights[2][3] = NAN;
  assert_false(thrum_pairs_newton(&g->run, 1e-10));
  free(g);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forces_of_a_group_satisfy_the_laws_of_all_rows),
      cmocka_unit_test(what_answers_to_no_force_is_not_solved),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
