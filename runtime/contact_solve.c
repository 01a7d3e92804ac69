/* The forces of a step's touches and pulls (docs/contact.md), by Gauss-Seidel over points.
 *
 * The unknown is one displacement over the step, r reduced numbers and three of the translation:
 * d = d_free + W J^T F, W diagonal. Each row in turn reads its point's displacement out of d,
 * solves its own law with the others' forces as they are, and adds the change of its force to d.
 * The laws are gradients of convex functions, so this is descent in each block of one convex
 * function in turn; forces of the step before are the first guess. Cost: 12 r a row and sweep.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "contact.h"

/* moved += W J^T force for the three rows of U of a point. */
static void push(thrum_contact_run *run, const double *rows, const double force[3]) {
  const int64_t rank = run->contact->rank;
  double own[3];
  thrum_apply3_transposed(run->axes, force, own);
  for (int64_t i = 0; i < rank; i++)
    run->view.moved[i] += run->view.weights[i] * (rows[i] * own[0] + rows[rank + i] * own[1] +
                                                  rows[2 * rank + i] * own[2]);
  for (int axis = 0; axis < 3; axis++)
    run->moved[axis] += run->mass_weight * force[axis];
}

/* Displacement of a point over the step. */
static void read(const thrum_contact_run *run, const double *rows, const double *moved,
                 double out[3]) {
  double u[3];
  thrum_gather3(rows, run->contact->rank, moved, u);
  thrum_apply3(run->axes, u, out);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += run->moved[axis];
}

static const double *rows_of(const thrum_contact_run *run, const thrum_contact_row *row) {
  return run->model->basis + 3 * (int64_t)run->view.vertices[row->touch.point] * run->contact->rank;
}

static void force_of(const thrum_contact_row *row, double force[3]) {
  for (int axis = 0; axis < 3; axis++)
    force[axis] = row->touch.force * row->touch.normal[axis] + row->touch.friction[axis];
}

/* How far a point is from where it was seen last, which becomes here. */
static double since(const double at[3], double seen[3]) {
  const double off[3] = {at[0] - seen[0], at[1] - seen[1], at[2] - seen[2]};
  memcpy(seen, at, 3 * sizeof *seen);
  return sqrt(thrum_dot3(off, off));
}

/* Solves one row; returns by how much the point had moved since the last sweep. */
static double solve_row(thrum_contact_run *run, thrum_contact_row *row) {
  const double *rows = rows_of(run, row), *normal = row->touch.normal;
  double at[3], before[3], change[3], moved[3];
  read(run, rows, run->view.moved, at);
  const double off = since(at, row->seen);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= row->drift[axis];
  force_of(row, before);
  const double gap = row->gap + thrum_dot3(normal, at);
  const double force =
      thrum_contact_normal(row, gap - row->along * row->touch.force, row->touch.stored);
  for (int axis = 0; axis < 3; axis++)
    change[axis] = (force - row->touch.force) * normal[axis];
  row->touch.force = force;
  thrum_apply3(row->response, change, moved);
  // what is across the normal, less what friction does now
  for (int axis = 0; axis < 3; axis++)
    at[axis] += moved[axis];
  const double along = thrum_dot3(normal, at);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= along * normal[axis] + row->across * row->touch.friction[axis];
  thrum_contact_friction(row, force, at, row->touch.friction);
  force_of(row, change);
  for (int axis = 0; axis < 3; axis++)
    change[axis] -= before[axis];
  push(run, rows, change);
  thrum_apply3(row->response, change, moved);
  for (int axis = 0; axis < 3; axis++)
    row->seen[axis] += moved[axis];
  return off;
}

/* x = (1 + rate G)^-1 b, G symmetric and positive semidefinite, by elimination. */
static void solve_shifted(const double response[9], double rate, const double b[3], double x[3]) {
  double a[12];
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++)
      a[4 * i + j] = rate * response[3 * i + j] + (i == j ? 1.0 : 0.0);
    a[4 * i + 3] = b[i];
  }
  for (int pivot = 0; pivot < 3; pivot++)
    for (int i = pivot + 1; i < 3; i++) {
      const double factor = a[4 * i + pivot] / a[5 * pivot];
      for (int j = pivot; j < 4; j++)
        a[4 * i + j] -= factor * a[4 * pivot + j];
    }
  for (int i = 2; i >= 0; i--) {
    double sum = a[4 * i + 3];
    for (int j = i + 1; j < 3; j++)
      sum -= a[4 * i + j] * x[j];
    x[i] = sum / a[5 * i];
  }
}

static double solve_pull(thrum_contact_run *run, const thrum_pull *pull, thrum_pull_row *row) {
  const double *rows = thrum_contact_pulled_rows(run, pull);
  double at[3], own[3], force[3], change[3], moved[3];
  read(run, rows, run->view.moved, at);
  const double off = since(at, row->seen);
  thrum_apply3(row->response, row->force, own);
  for (int axis = 0; axis < 3; axis++)
    at[axis] = row->bias[axis] - row->rate * (at[axis] - row->drift[axis] - own[axis]);
  solve_shifted(row->response, row->rate, at, force);
  for (int axis = 0; axis < 3; axis++)
    change[axis] = force[axis] - row->force[axis];
  if (!isfinite(change[0]) || !isfinite(change[1]) || !isfinite(change[2]))
    return off;
  memcpy(row->force, force, sizeof force);
  push(run, rows, change);
  thrum_apply3(row->response, change, moved);
  for (int axis = 0; axis < 3; axis++)
    row->seen[axis] += moved[axis];
  return off;
}

static double sweep(thrum_contact_run *run) {
  double change = 0.0;
  for (int64_t n = 0; n < run->contact->pull_count; n++)
    change = fmax(change, solve_pull(run, run->around->pulls + n, run->view.pull_rows + n));
  for (int64_t n = 0; n < run->contact->row_count; n++)
    change = fmax(change, solve_row(run, run->view.rows + n));
  return change;
}

/* moved from free and the forces that rows and pulls have; returns the largest displacement. */
static double begin_sweeps(thrum_contact_run *run) {
  double largest = 0.0, at[3], force[3];
  memcpy(run->view.moved, run->view.free, (size_t)run->contact->rank * sizeof(double));
  memcpy(run->moved, run->free, sizeof run->free);
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    read(run, rows_of(run, row), run->view.free, at);
    largest = fmax(largest, sqrt(thrum_dot3(at, at)) + fabs(row->gap));
  }
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    force_of(run->view.rows + n, force);
    push(run, rows_of(run, run->view.rows + n), force);
  }
  for (int64_t n = 0; n < run->contact->pull_count; n++) {
    const thrum_pull_row *row = run->view.pull_rows + n;
    push(run, thrum_contact_pulled_rows(run, run->around->pulls + n), row->force);
    largest = fmax(largest, sqrt(thrum_dot3(row->offset, row->offset)));
  }
  return largest;
}

/* load and force with those of rows and pulls. */
static void gather_load(thrum_contact_run *run) {
  const int64_t rank = run->contact->rank;
  const thrum_around *around = run->around;
  for (int64_t i = 0; i < rank; i++)
    run->view.load[i] = around->load ? around->load[i] : 0.0;
  memcpy(run->force, around->force, sizeof run->force);
  for (int64_t n = 0; n < run->contact->row_count + run->contact->pull_count; n++) {
    const int64_t pull = n - run->contact->row_count;
    const double *rows = pull >= 0 ? thrum_contact_pulled_rows(run, around->pulls + pull)
                                   : rows_of(run, run->view.rows + n);
    double force[3], own[3];
    if (pull >= 0)
      memcpy(force, run->view.pull_rows[pull].force, sizeof force);
    else
      force_of(run->view.rows + n, force);
    thrum_apply3_transposed(run->axes, force, own);
    for (int64_t i = 0; i < rank; i++)
      run->view.load[i] += rows[i] * own[0] + rows[rank + i] * own[1] + rows[2 * rank + i] * own[2];
    for (int axis = 0; axis < 3; axis++)
      run->force[axis] += force[axis];
  }
}

void thrum_contact_solve(thrum_contact_run *run) {
  thrum_contact *contact = run->contact;
  const double largest = begin_sweeps(run);
  if (contact->row_count + contact->pull_count > 0) {
    for (int32_t n = 0; n < contact->sweeps_max; n++) {
      contact->sweeps++;
      if (!(sweep(run) > contact->tolerance * largest))
        break;
    }
  }
  gather_load(run);
}
