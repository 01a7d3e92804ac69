/* The forces between bodies in a step, together with those of their obstacles and pulls, by
 * Gauss-Seidel over points (contact_solve.c): each row in turn reads the displacements of its two
 * points, solves its own law, and moves both bodies by the change of its force.
 *
 * The forces act on both bodies at one point, halfway through the step, so that no torque is left
 * over: with c the mean centre of mass over the step and P the point, the torque on each body is
 * (P - c) x F, and momentum and angular momentum of all bodies together change by rounding only.
 *
 * Groups that touch in many places, without links and pulls, are solved for at once where sweeps do
 * not settle (contact_pairs_newton.c); sweeps after it give each row its law exactly.
 *
 * Cost: 24 r a row and sweep.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_solve.h"

#include <math.h>
#include <string.h>

#include "contact/contact_guess.h"
#include "contact/contact_pairs_link.h"
#include "contact/contact_pairs_newton.h"
#include "contact/contact_pairs_rows.h"
#include "contact/contact_point.h"
#include "contact/contact_solve.h"

#define HARDER 6   /* times as many sweeps where a step is made again */
#define EARLY 4    /* sweeps after which those of two bodies may be too slow */
#define LATEST 12  /* sweeps after which they are, where they are near their tolerance */
#define ROUND 3    /* sweeps after they were solved at once, and between two over all rows */
#define MANY 24    /* rows from which they are */
#define EXACT 10.0 /* times the tolerance of a sweep that they are solved to */

/* Displacement of the first point of a row against its second. */
static void moved_of(const thrum_pairs_run *run, const thrum_pair_row *row, double out[3]) {
  double other[3];
  const thrum_contact_run *a = run->view.runs + row->members[0];
  const thrum_contact_run *b = run->view.runs + row->members[1];
  if (thrum_pairs_is_own(row)) {
    thrum_point_shape(a, thrum_pairs_basis(row, 0), a->view.moved, out);
    return;
  }
  thrum_point_moved(a, thrum_pairs_basis(row, 0), row->row.lever, a->view.moved, out);
  thrum_point_moved(b, thrum_pairs_basis(row, 1), row->lever, b->view.moved, other);
  for (int axis = 0; axis < 3; axis++)
    out[axis] -= other[axis];
}

/* Adds what a force between the two points moves. */
static void push(const thrum_pairs_run *run, const thrum_pair_row *row, const double force[3]) {
  const double back[3] = {-force[0], -force[1], -force[2]};
  if (thrum_pairs_is_own(row)) {
    thrum_shape_push(run->view.runs + row->members[0], thrum_pairs_basis(row, 0), force);
    return;
  }
  thrum_point_push(run->view.runs + row->members[0], thrum_pairs_basis(row, 0), row->row.lever,
                   force);
  thrum_point_push(run->view.runs + row->members[1], thrum_pairs_basis(row, 1), row->lever, back);
}

/* Solves one row; returns by how much its points had moved against each other since the last sweep
 * [m]. */
static double solve_row(thrum_pairs_run *run, thrum_pair_row *pair) {
  double at[3], change[3];
  moved_of(run, pair, at);
  const double off = thrum_point_since(at, pair->row.seen);
  thrum_contact_row_solve(&pair->row, at, change);
  if (change[0] != 0.0 || change[1] != 0.0 || change[2] != 0.0)
    push(run, pair, change);
  return off;
}

/* --- first guess (contact_guess.c) ------------------------------------------------------------ */

static bool is_between(const void *run, int64_t n, const int32_t *bodies) {
  const thrum_pair_key *key = &((const thrum_pairs_run *)run)->view.rows[n].key;
  return key->bodies[0] == bodies[0] && key->bodies[1] == bodies[1];
}

static void pair_moved(const void *run, int64_t n, double at[3]) {
  moved_of(run, ((const thrum_pairs_run *)run)->view.rows + n, at);
}

static void push_pair(void *run, int64_t n, const double force[3]) {
  push(run, ((const thrum_pairs_run *)run)->view.rows + n, force);
}

/* The rows of two bodies follow each other, but for those that were found later. */
static void guess_all(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_key *key = &run->view.rows[n].key;
    const thrum_pair_key *last = n > 0 ? &run->view.rows[n - 1].key : NULL;
    if (last == NULL || last->bodies[0] != key->bodies[0] || last->bodies[1] != key->bodies[1])
      thrum_contact_guess_group(&(thrum_row_group){.rows = thrum_pairs_rows_of(run),
                                                   .run = run,
                                                   .of = key->bodies,
                                                   .has = is_between,
                                                   .moved = pair_moved,
                                                   .push = push_pair});
  }
}

/* --- the solve -------------------------------------------------------------------------------- */

/* The displacements without forces, then those of the forces of the last step; returns the largest
 * displacement. */
static double begin_sweeps(thrum_pairs_run *run) {
  double largest = 0.0, force[3];

  // the bodies alone, with their own touches
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      largest = fmax(largest, thrum_contact_begin_sweeps(run->view.runs + n));

  // the forces between them that the last step ended with
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    largest = fmax(largest, row->row.unloaded_length + fabs(row->row.gap));
    thrum_contact_row_force(&row->row, force);
    push(run, row, force);
  }
  largest = fmax(largest, thrum_links_begin(run));

  if (run->closing)
    return largest;

  // what waited and closes under these forces has none itself yet
  const int64_t woken = thrum_pairs_wake(run, false);
  for (int64_t n = run->row_count - woken; n < run->row_count; n++) {
    const thrum_contact_row *row = &run->view.rows[n].row;
    largest = fmax(largest, row->unloaded_length + fabs(row->gap));
  }

  // touches that begin: a guess as if those of two bodies were one spring saves sweeps
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      thrum_contact_guess(run->view.runs + n);
  guess_all(run);
  return largest;
}

/* Solves a row of a sweep over all: it bears where it has a force, or had one; *begins becomes true
 * where it had none and has one. Returns by how much its points moved since it was solved last [m].
 */
static double solve_any(thrum_pairs_run *run, thrum_pair_row *pair, bool *begins) {
  const bool had = thrum_pairs_pushes(pair);
  const double off = solve_row(run, pair);
  pair->bears = had || thrum_pairs_pushes(pair);
  *begins = *begins || (pair->bears && !had);
  return off;
}

/* --- sweeps ----------------------------------------------------------------------------------- */

/* Solves all pulls, rows and links once, or of the rows between bodies those that bear alone;
 * returns by how much what it solved had moved since the last time [m]. *begins: does a row bear
 * that did not? */
static double sweep(thrum_pairs_run *run, bool all, bool *begins) {
  double change = 0.0;
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      change = fmax(change, thrum_contact_sweep(run->view.runs + n));
  for (int64_t n = 0; n < run->row_count; n++) {
    thrum_pair_row *row = run->view.rows + n;
    if (all)
      change = fmax(change, solve_any(run, row, begins));
    else if (row->bears)
      change = fmax(change, solve_row(run, row));
  }

  // links last, so that a sweep leaves them closed
  return fmax(change, thrum_links_solve(run));
}

/* Do many rows push the members of the group, and nothing else, so that all can be solved at once?
 */
static bool are_many(const thrum_pairs_run *run) {
  bool alone = run->link_count == 0 && run->view.newton_rows != NULL;
  int64_t rows = run->row_count;
  for (int64_t n = 0; n < run->count && alone; n++) {
    if (!thrum_pairs_steps(run, n))
      continue;
    alone = run->view.runs[n].contact->pull_count == 0;
    rows += run->view.runs[n].contact->row_count;
  }
  return alone && rows >= MANY && rows <= THRUM_NEWTON_ROWS;
}

/* Where the force of a row acts: halfway between its points, halfway through the step. */
static void place(const thrum_pairs_run *run, thrum_pair_row *row) {
  double moved[2][3];
  const int from = thrum_pairs_is_own(row) ? 1 : 0;
  for (int side = from; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + row->members[side];
    thrum_point_moved(body, thrum_pairs_basis(row, side), side == 0 ? row->row.lever : row->lever,
                      body->view.moved, moved[side]);
  }
  for (int axis = 0; axis < 3; axis++)
    row->position[axis] = 0.5 * (row->starts[0][axis] + row->starts[1][axis]) +
                          0.25 * (moved[from][axis] + moved[1][axis]);
}

/* Adds the force of a row to the loads and wrenches of its members. */
static void load(const thrum_pairs_run *run, thrum_pair_row *row) {
  double force[3];
  thrum_contact_row_force(&row->row, force);
  if (thrum_pairs_is_own(row)) {
    thrum_shape_load(run->view.runs + row->members[0], thrum_pairs_basis(row, 0), force);
    return;
  }

  // the lever arms are about the mean centre of mass over the step, as the solve has it
  for (int side = 0; side < 2; side++) {
    thrum_contact_run *body = run->view.runs + row->members[side];
    double *lever = side == 0 ? row->row.lever : row->lever;
    for (int axis = 0; axis < 3; axis++) {
      lever[axis] = row->position[axis] - body->centre[axis] - 0.5 * body->moved[axis];
      force[axis] = side == 0 ? force[axis] : -force[axis];
    }
    thrum_point_load(body, thrum_pairs_basis(row, side), lever, force);
  }
}

/* Loads and wrenches of all members. */
static void gather(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++)
    place(run, run->view.rows + n);
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      thrum_contact_gather(run->view.runs + n);

  for (int64_t n = 0; n < run->row_count; n++)
    load(run, run->view.rows + n);
  thrum_links_gather(run);
}

/* Would twelve sweeps more, each of which leaves as much as one of the last two, still miss the
 * tolerance? change and before: by how much places moved in the last sweep, and two sweeps before.
 * A solve of all rows at once costs as much. */
static bool is_slow(double change, double before, double tolerance) {
  const double two = change / before, six = two * two * two;
  return six * six * change > tolerance;
}

void thrum_pairs_solve(thrum_pairs_run *run) {
  const thrum_contact_pairs *pairs = run->pairs;
  const double largest = begin_sweeps(run), tolerance = pairs->tolerance * largest;
  const int64_t most = run->again ? HARDER * pairs->sweeps_max : pairs->sweeps_max;
  bool all = true, many = !run->closing, slow = false;
  double last[2] = {0.0, 0.0};
  int64_t end = most;
  for (int64_t n = 0, since = 0; n < end; n++) {
    run->history->sweeps++;
    bool begins = false;

    // what is solved at once has its forces by the laws of single rows again after a few sweeps
    if (slow) {
      many = false;
      if (are_many(run) && thrum_pairs_newton(run, EXACT * tolerance))
        end = n + ROUND;
    }
    const double change = run->closing ? thrum_links_solve(run) : sweep(run, all, &begins);
    const bool settled = !(change > tolerance);
    if (settled && all)
      break;
    slow = many && (n + 1 == LATEST || (n + 1 >= EARLY && change > EXACT * tolerance &&
                                        is_slow(change, last[n % 2], tolerance)));
    last[n % 2] = change;

    // rows without a force are left out while the same rows bear: which do so is found first, by
    // sweeps over all, as what is solved without a row that has to bear is no step towards the end
    since = all ? 0 : since + 1;
    all = run->row_count == 0 || run->closing || begins || settled || slow || end < most ||
          since == ROUND || n + 2 == most;
  }
  gather(run);
}
