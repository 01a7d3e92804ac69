/* Springs that pull points of a body to targets (docs/contact.md).
 *
 * With e the offset from the target at the start of the step, v its speed, dx the displacement of
 * the point relative to the target over the step, y = k tr(G)/6 and b = y/(1+y),
 *
 *   F = -k (e + dx/2) - b k (3/2 dx - h/2 v) - c dx/h = bias - rate dx:
 *
 * the midpoint rule for a spring that the step resolves, and F = -k (e' + h/2 v') for a stiff one,
 * which is at rest on its target after two steps. Where what is not stepped gives way by C, the
 * offset has C F as well, so (1 + k C) F is that law, of the spring in series with C; b and the
 * critical damping are of k / (1 + k tr(C)/3). Solved by a 3 x 3 system for each pull.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pull.h"

#include <math.h>
#include <string.h>

#include "contact/contact_point.h"

double *thrum_contact_pull_basis(const thrum_contact_run *run, int64_t index) {
  return run->view.pulled + index * 3 * run->contact->rank;
}

/* Mixes the rows of U of the three vertices of a pull by their weights. */
static double *mix_rows(const thrum_contact_run *run, const thrum_pull *pull, int64_t index) {
  const int64_t count = 3 * (int64_t)run->contact->rank;
  double *mixed = thrum_contact_pull_basis(run, index);
  memset(mixed, 0, (size_t)count * sizeof *mixed);
  for (int corner = 0; corner < 3; corner++) {
    const double *rows = run->model->basis + pull->vertices[corner] * count;
    for (int64_t i = 0; i < count; i++)
      mixed[i] += pull->weights[corner] * rows[i];
  }
  return mixed;
}

/* Fills the linear law of a pull, force = bias - rate x displacement: the mean force of the spring
 * over the step where it is soft, its force at the end where it is stiff, and the damper. */
static void fill_law(const thrum_contact_run *run, const thrum_pull *pull, thrum_pull_row *row) {
  const double h = run->dt, k = pull->stiffness;
  const double response = (row->response[0] + row->response[4] + row->response[8]) / 3.0;
  const double series = 1.0 + k * (pull->give[0] + pull->give[4] + pull->give[8]) / 3.0;
  const double stiff = 0.5 * (k / series) * response, blend = stiff / (1.0 + stiff);
  const double mass = response > 0.0 ? 0.5 * h * h / response : 0.0;
  const double damping = pull->damping >= 0.0 ? pull->damping : 2.0 * sqrt(k * series * mass);
  row->rate = 0.5 * k + 1.5 * blend * k + damping / h;
  for (int axis = 0; axis < 3; axis++)
    row->bias[axis] = -k * row->offset[axis] + 0.5 * blend * k * h * row->velocity[axis];
  for (int n = 0; n < 9; n++)
    row->series[n] = k * pull->give[n] + (n % 4 == 0 ? 1.0 : 0.0);
}

/* The largest force of a pull. A force that displaces the point by more than the body's size shows
 * nothing more, and a target that jumps would tear the body apart. */
static double most_of(const thrum_contact_run *run, const thrum_pull *pull, const double *rows) {
  if (pull->force_max > 0.0)
    return pull->force_max;

  // static compliance of the point, over the modes that resist, and of what is not stepped
  const int64_t rank = run->contact->rank;
  double compliance = pull->give[0] + pull->give[4] + pull->give[8];
  for (int64_t i = 0; i < rank; i++) {
    const double u[3] = {rows[i], rows[rank + i], rows[2 * rank + i]};
    if (run->model->omega2[i] > 0.0)
      compliance += thrum_dot3(u, u) / run->model->omega2[i];
  }

  // twice the force on a free body lets the pull lift it
  const double *force = run->environment->force;
  const double whole = run->environment->translation ? 2.0 * sqrt(thrum_dot3(force, force)) : 0.0;
  return compliance > 0.0 ? run->contact->diagonal / compliance + whole : INFINITY;
}

/* Fills a pull row: the point's rows of U, its place and velocity relative to the target, its law.
 */
static void fill_row(const thrum_contact_run *run, int64_t index) {
  const thrum_pull *pull = run->environment->pulls + index;
  thrum_pull_row *row = run->view.pull_rows + index;
  const double *rows = mix_rows(run, pull, index);
  double rest[3] = {0.0, 0.0, 0.0}, x[3], arm[3];

  // the force of the last step is the first guess
  memset(row, 0, sizeof *row);
  memcpy(row->force, run->view.pull_forces + 3 * index, sizeof row->force);

  // kinematics of the point, relative to the target
  for (int corner = 0; corner < 3; corner++)
    for (int axis = 0; axis < 3; axis++)
      rest[axis] += pull->weights[corner] * run->model->vertices[3 * pull->vertices[corner] + axis];
  thrum_point_start(run, rows, rest, x);
  thrum_point_lever(run, x, arm, row->lever);
  thrum_point_response(run, rows, row->lever, row->response);
  thrum_point_velocity(run, rows, arm, row->velocity);
  for (int axis = 0; axis < 3; axis++) {
    row->offset[axis] = x[axis] - pull->target[axis];
    row->velocity[axis] -= pull->velocity[axis];
    row->drift[axis] = run->dt * pull->velocity[axis];
  }

  fill_law(run, pull, row);
  row->most = most_of(run, pull, rows);
}

void thrum_contact_pulls(thrum_contact_run *run) {
  run->contact->pull_count = run->environment->pull_count;
  for (int64_t index = 0; index < run->contact->pull_count; index++)
    fill_row(run, index);
}

double thrum_contact_pull_solve(thrum_contact_run *run, int64_t index) {
  thrum_pull_row *row = run->view.pull_rows + index;
  const double *rows = thrum_contact_pull_basis(run, index);
  double at[3], own[3], force[3], change[3], moved[3];

  // displacement of the point without this pull's own force
  thrum_point_moved(run, rows, row->lever, run->view.moved, at);
  const double off = thrum_point_since(at, row->seen);
  thrum_apply3(row->response, row->force, own);
  for (int axis = 0; axis < 3; axis++)
    at[axis] = row->bias[axis] - row->rate * (at[axis] - row->drift[axis] - own[axis]);

  // (1 + k C + rate G) force = bias - rate x displacement
  double matrix[9];
  for (int n = 0; n < 9; n++)
    matrix[n] = row->rate * row->response[n] + row->series[n];
  if (!thrum_solve3(matrix, at, force))
    return off;

  // no more than the limit of the pull
  const double length = sqrt(thrum_dot3(force, force));
  const double scale = length > row->most ? row->most / length : 1.0;
  for (int axis = 0; axis < 3; axis++) {
    force[axis] *= scale;
    change[axis] = force[axis] - row->force[axis];
  }
  if (!isfinite(change[0]) || !isfinite(change[1]) || !isfinite(change[2]))
    return off;

  // the change of force moves all points of the body, and this one at once
  memcpy(row->force, force, sizeof force);
  thrum_point_push(run, rows, row->lever, change);
  thrum_apply3(row->response, change, moved);
  for (int axis = 0; axis < 3; axis++)
    row->seen[axis] += moved[axis];
  return off;
}
