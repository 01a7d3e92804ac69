/* The forces between bodies in a step, together with those of their obstacles and pulls, by
 * Gauss-Seidel over points (contact_solve.c): each row in turn reads the displacements of its two
 * points, solves its own law, and moves both bodies by the change of its force.
 *
 * The forces act on both bodies at one point, halfway through the step, so that no torque is left
 * over: with c the mean centre of mass over the step and P the point, the torque on each body is
 * (P - c) x F, and momentum and angular momentum of all bodies together change by rounding only.
 *
 * Cost: 24 r a row and sweep.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_pairs_private.h"
#include "runtime/contact/contact_point.h"

/* Force of a row on its first side [N]. */
static void force_of(const thrum_contact_row *row, double force[3]) {
  for (int axis = 0; axis < 3; axis++)
    force[axis] = row->touch.force * row->touch.normal[axis] + row->touch.friction[axis];
}

/* Displacement of the first point of a row against its second. */
static void moved_of(const thrum_pairs_run *run, const thrum_pair_row *row, double out[3]) {
  double other[3];
  const thrum_contact_run *a = run->view.runs + row->members[0];
  const thrum_contact_run *b = run->view.runs + row->members[1];
  thrum_point_moved(a, thrum_pairs_basis(run, row, 0), row->row.lever, a->view.moved, out);
  thrum_point_moved(b, thrum_pairs_basis(run, row, 1), row->lever, b->view.moved, other);
  for (int axis = 0; axis < 3; axis++)
    out[axis] -= other[axis];
}

/* Adds what a force between the two points moves. */
static void push(const thrum_pairs_run *run, const thrum_pair_row *row, const double force[3]) {
  const double back[3] = {-force[0], -force[1], -force[2]};
  thrum_point_push(run->view.runs + row->members[0], thrum_pairs_basis(run, row, 0), row->row.lever,
                   force);
  thrum_point_push(run->view.runs + row->members[1], thrum_pairs_basis(run, row, 1), row->lever,
                   back);
}

/* Solves one row; returns by how much its points had moved against each other since the last sweep
 * [m]. As solve_row of contact_solve.c. */
static double solve_row(thrum_pairs_run *run, thrum_pair_row *pair) {
  thrum_contact_row *row = &pair->row;
  const double *normal = row->touch.normal;
  double at[3], before[3], change[3], moved[3];
  moved_of(run, pair, at);
  const double off = thrum_point_since(at, row->seen);
  force_of(row, before);

  // the normal force from the gap that this row has without its own force
  const double gap = row->gap + thrum_dot3(normal, at);
  const double force =
      thrum_contact_normal(row, gap - row->along * row->touch.force, row->touch.stored);
  for (int axis = 0; axis < 3; axis++)
    change[axis] = (force - row->touch.force) * normal[axis];
  row->touch.force = force;
  thrum_apply3(row->response, change, moved);

  // friction from the tangential displacement that this row has without its friction
  for (int axis = 0; axis < 3; axis++)
    at[axis] += moved[axis];
  const double along = thrum_dot3(normal, at);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= along * normal[axis] + row->across * row->touch.friction[axis];
  thrum_contact_friction(row, force, at, row->touch.friction);

  // the change of force moves all points of both bodies, and these at once
  force_of(row, change);
  for (int axis = 0; axis < 3; axis++)
    change[axis] -= before[axis];
  if (change[0] != 0.0 || change[1] != 0.0 || change[2] != 0.0)
    push(run, pair, change);
  thrum_apply3(row->response, change, moved);
  for (int axis = 0; axis < 3; axis++)
    row->seen[axis] += moved[axis];
  return off;
}

/* --- first guess (contact_guess.c) ------------------------------------------------------------ */

static bool begins(const thrum_pair_row *row, const int32_t bodies[2]) {
  return row->key.bodies[0] == bodies[0] && row->key.bodies[1] == bodies[1] &&
         row->row.touch.force == 0.0 && row->row.gap >= 0.0 && row->row.stiffness > 0.0;
}

/* The mean gap at the end of the rows that begin, weighted by their stiffness. */
static double mean_gap(const thrum_pairs_run *run, const int32_t bodies[2], double stiffness) {
  double sum = 0.0, at[3];
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    if (!begins(row, bodies))
      continue;
    moved_of(run, row, at);
    sum += row->row.stiffness / stiffness * (row->row.gap + thrum_dot3(row->row.touch.normal, at));
  }
  return sum;
}

/* Adds a force to what is moved, shared by stiffness. */
static void push_all(const thrum_pairs_run *run, const int32_t bodies[2], double stiffness,
                     double force) {
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    double share[3];
    if (!begins(row, bodies))
      continue;
    for (int axis = 0; axis < 3; axis++)
      share[axis] = row->row.stiffness / stiffness * force * row->row.touch.normal[axis];
    push(run, row, share);
  }
}

/* Joins the new rows of two bodies into one, by their stiffness; returns their number. */
static int64_t join(const thrum_pairs_run *run, const int32_t bodies[2],
                    thrum_contact_row *joined) {
  int64_t count = 0;
  memset(joined, 0, sizeof *joined);
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_contact_row *row = &run->view.rows[n].row;
    if (!begins(run->view.rows + n, bodies))
      continue;
    count++;
    joined->stiffness += row->stiffness;
    joined->gap += row->stiffness * row->gap;
    joined->ceiling += row->stiffness * row->ceiling;
    joined->along = fmax(joined->along, row->along);
  }
  joined->gap /= joined->stiffness;
  joined->ceiling /= joined->stiffness;
  return count;
}

/* Guesses the force of all new rows of two bodies as if they were one. */
static void guess(thrum_pairs_run *run, const int32_t bodies[2]) {
  thrum_contact_row joined;
  if (join(run, bodies, &joined) < 2 || !isnormal(joined.stiffness))
    return;
  const double stiffness = joined.stiffness, unloaded = mean_gap(run, bodies, stiffness);
  if (!(unloaded < 0.0))
    return;

  // the response of all points to a force that could stop one of them
  const double probe = -unloaded / joined.along;
  push_all(run, bodies, stiffness, probe);
  joined.along = (mean_gap(run, bodies, stiffness) - unloaded) / probe;
  const double force = joined.along > 0.0 ? thrum_contact_normal(&joined, unloaded, INFINITY) : 0.0;
  push_all(run, bodies, stiffness, force - probe);
  if (!(force > 0.0))
    return;

  // each row takes its share by stiffness; a row with a force begins no more, so all at once
  for (int64_t n = 0; n < run->row_count; n++)
    if (begins(run->view.rows + n, bodies))
      run->view.rows[n].row.touch.force = run->view.rows[n].row.stiffness / stiffness * force;
}

/* The rows of two bodies follow each other, but for those that were found later. */
static void guess_all(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_key *key = &run->view.rows[n].key;
    const thrum_pair_key *last = n > 0 ? &run->view.rows[n - 1].key : NULL;
    if (last == NULL || last->bodies[0] != key->bodies[0] || last->bodies[1] != key->bodies[1])
      guess(run, key->bodies);
  }
}

/* --- the solve -------------------------------------------------------------------------------- */

/* The displacements without forces, then those of the forces of the last step; returns the largest
 * displacement. */
static double begin_sweeps(thrum_pairs_run *run) {
  double largest = 0.0, force[3];
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      largest = fmax(largest, thrum_contact_begin_sweeps(run->view.runs + n));
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    largest = fmax(largest, row->row.unloaded_length + fabs(row->row.gap));
    force_of(&row->row, force);
    push(run, row, force);
  }
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      thrum_contact_guess(run->view.runs + n);
  guess_all(run);
  return largest;
}

static double sweep(thrum_pairs_run *run) {
  double change = 0.0;
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      change = fmax(change, thrum_contact_sweep(run->view.runs + n));
  for (int64_t n = 0; n < run->row_count; n++)
    change = fmax(change, solve_row(run, run->view.rows + n));
  return change;
}

/* Where the force of a row acts: halfway between its points, halfway through the step. */
static void place(const thrum_pairs_run *run, thrum_pair_row *row) {
  double moved[2][3];
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + row->members[side];
    thrum_point_moved(body, thrum_pairs_basis(run, row, side),
                      side == 0 ? row->row.lever : row->lever, body->view.moved, moved[side]);
  }
  for (int axis = 0; axis < 3; axis++)
    row->position[axis] = 0.5 * (row->starts[0][axis] + row->starts[1][axis]) +
                          0.25 * (moved[0][axis] + moved[1][axis]);
}

/* Loads and wrenches of all members. */
static void gather(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++)
    place(run, run->view.rows + n);
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].status >= 0)
      thrum_contact_gather(run->view.runs + n);

  // the lever arms are about the mean centre of mass over the step, as the solve has it
  for (int64_t n = 0; n < run->row_count; n++) {
    thrum_pair_row *row = run->view.rows + n;
    double force[3];
    force_of(&row->row, force);
    for (int side = 0; side < 2; side++) {
      thrum_contact_run *body = run->view.runs + row->members[side];
      double *lever = side == 0 ? row->row.lever : row->lever;
      for (int axis = 0; axis < 3; axis++) {
        lever[axis] = row->position[axis] - body->centre[axis] - 0.5 * body->moved[axis];
        force[axis] = side == 0 ? force[axis] : -force[axis];
      }
      thrum_point_load(body, thrum_pairs_basis(run, row, side), lever, force);
    }
  }
}

void thrum_pairs_solve(thrum_pairs_run *run) {
  thrum_contact_pairs *pairs = run->pairs;
  const double largest = begin_sweeps(run);
  for (int64_t n = 0; n < pairs->sweeps_max; n++) {
    pairs->sweeps++;
    if (!(sweep(run) > pairs->tolerance * largest))
      break;
  }
  gather(run);
}
