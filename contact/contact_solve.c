/* The forces of a step's touches and pulls (docs/contact.md), by Gauss-Seidel over points.
 *
 * The unknown is one displacement over the step, r reduced numbers and three of the translation:
 * d = d_free + W J^T F, W diagonal. Each row in turn reads its point's displacement out of d,
 * solves its own law with the others' forces as they are, and adds the change of its force to d.
 * The laws are gradients of convex functions, so this is descent in each block of one convex
 * function in turn; forces of the step before are the first guess. Cost: 12 r a row and sweep.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_solve.h"

#include <math.h>
#include <string.h>

#include "contact/contact_guess.h"
#include "contact/contact_point.h"
#include "contact/contact_pull.h"

/* Solves one row; returns by how much its point had moved since the last sweep [m]. */
static double solve_row(thrum_contact_run *run, thrum_contact_row *row) {
  const double *rows = thrum_point_rows(run, row->touch.point);
  double at[3], change[3];
  thrum_point_moved(run, rows, row->lever, run->view.moved, at);
  const double off = thrum_point_since(at, row->seen);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= row->drift[axis];
  thrum_contact_row_solve(row, at, change);
  thrum_point_push(run, rows, row->lever, change);
  return off;
}

/* Solves all pulls and rows once, one after the other (projected Gauss-Seidel); returns the largest
 * distance by which a point had moved since the sweep before [m]. */
double thrum_contact_sweep(thrum_contact_run *run) {
  double change = 0.0;
  for (int64_t n = 0; n < run->contact->pull_count; n++)
    change = fmax(change, thrum_contact_pull_solve(run, n));
  for (int64_t n = 0; n < run->contact->row_count; n++)
    change = fmax(change, solve_row(run, run->view.rows + n));
  return change;
}

/* Recomputes moved from the unloaded step and the forces that rows and pulls have; returns the
 * largest displacement. */
double thrum_contact_begin_sweeps(thrum_contact_run *run) {
  double largest = 0.0, force[3];

  // the step without contact and pulls
  memcpy(run->view.moved, run->view.unloaded, (size_t)run->contact->rank * sizeof(double));
  memcpy(run->moved, run->unloaded, sizeof run->unloaded);
  memcpy(run->turned, run->unloaded_turn, sizeof run->turned);

  // the forces with which rows and pulls start, those of the last step
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    largest = fmax(largest, row->unloaded_length + fabs(row->gap));
    thrum_contact_row_force(row, force);
    thrum_point_push(run, thrum_point_rows(run, row->touch.point), row->lever, force);
  }
  for (int64_t n = 0; n < run->contact->pull_count; n++) {
    const thrum_pull_row *row = run->view.pull_rows + n;
    largest = fmax(largest, sqrt(thrum_dot3(row->offset, row->offset)));
    thrum_point_push(run, thrum_contact_pull_basis(run, n), row->lever, row->force);
  }
  return largest;
}

/* Adds the forces of rows and pulls to the load of the step and to the wrench on the body as a
 * whole. */
void thrum_contact_gather(thrum_contact_run *run) {
  const int64_t rank = run->contact->rank;
  const thrum_contact_environment *environment = run->environment;
  double force[3];

  // what acts without contact
  for (int64_t i = 0; i < rank; i++)
    run->view.load[i] = environment->load ? environment->load[i] : 0.0;
  memcpy(run->force, environment->force, sizeof run->force);
  memcpy(run->torque, environment->torque, sizeof run->torque);

  // what rows and pulls add
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    thrum_contact_row_force(row, force);
    thrum_point_load(run, thrum_point_rows(run, row->touch.point), row->lever, force);
  }
  for (int64_t n = 0; n < run->contact->pull_count; n++)
    thrum_point_load(run, thrum_contact_pull_basis(run, n), run->view.pull_rows[n].lever,
                     run->view.pull_rows[n].force);
}

void thrum_contact_solve(thrum_contact_run *run) {
  thrum_contact *contact = run->contact;
  const double largest = thrum_contact_begin_sweeps(run);
  thrum_contact_guess(run);

  // sweeps until no point moves by more than the tolerance
  for (int32_t n = 0; contact->row_count + contact->pull_count > 0 && n < contact->sweeps_max;
       n++) {
    contact->sweeps++;
    if (!(thrum_contact_sweep(run) > contact->tolerance * largest))
      break;
  }

  thrum_contact_gather(run);
}
