/* The first guess at the forces of touches that begin in this step (docs/contact.md).
 *
 * Points that move as one, such as those of a face that lands flat, are almost one unknown; taken
 * in turn they would need as many sweeps as k G is large to share a force. So the rows of one
 * obstacle, or of two bodies, without a force so far are first taken as one spring, each point with
 * its share of the stiffness, and its force is theirs. It changes where the sweeps begin, not where
 * they end. Cost: 18 r a row that touches anew.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_guess.h"

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"
#include "contact/contact_point.h"

/* Row n where it is one of the group and comes in without a force so far, else NULL. */
static thrum_contact_row *begins(const thrum_row_group *group, int64_t n) {
  thrum_contact_row *row = thrum_row_at(&group->rows, n);
  return row->touch.force == 0.0 && row->gap >= 0.0 && row->stiffness > 0.0 &&
                 group->has(group->run, n, group->of)
             ? row
             : NULL;
}

/* The mean gap at the end of the rows that begin, weighted by their stiffness. */
static double mean_gap(const thrum_row_group *group, double stiffness) {
  double sum = 0.0, at[3];
  for (int64_t n = 0; n < group->rows.count; n++) {
    const thrum_contact_row *row = begins(group, n);
    if (row == NULL)
      continue;
    group->moved(group->run, n, at);
    sum += row->stiffness / stiffness * (row->gap + thrum_dot3(row->touch.normal, at));
  }
  return sum;
}

/* Adds a force to what is moved, shared by stiffness. */
static void push_all(const thrum_row_group *group, double stiffness, double force) {
  for (int64_t n = 0; n < group->rows.count; n++) {
    const thrum_contact_row *row = begins(group, n);
    double share[3];
    if (row == NULL)
      continue;
    for (int axis = 0; axis < 3; axis++)
      share[axis] = row->stiffness / stiffness * force * row->touch.normal[axis];
    group->push(group->run, n, share);
  }
}

/* Joins the rows that begin into one, by their stiffness; returns their number. */
static int64_t join(const thrum_row_group *group, thrum_contact_row *joined) {
  int64_t count = 0;
  memset(joined, 0, sizeof *joined);

  // sums weighted by stiffness
  for (int64_t n = 0; n < group->rows.count; n++) {
    const thrum_contact_row *row = begins(group, n);
    if (row == NULL)
      continue;
    count++;
    joined->stiffness += row->stiffness;
    joined->damping += row->damping;
    joined->gap += row->stiffness * row->gap;
    joined->ceiling += row->stiffness * row->ceiling;
    joined->along = fmax(joined->along, row->along);
  }

  joined->gap /= joined->stiffness;
  joined->ceiling /= joined->stiffness;
  return count;
}

void thrum_contact_guess_group(const thrum_row_group *group) {
  thrum_contact_row joined;
  if (join(group, &joined) < 2 || !isnormal(joined.stiffness))
    return;
  const double stiffness = joined.stiffness, unloaded = mean_gap(group, stiffness);
  if (!(unloaded < 0.0))
    return;

  // the response of all points to a force that could stop one of them
  const double probe = -unloaded / joined.along;
  push_all(group, stiffness, probe);
  joined.along = (mean_gap(group, stiffness) - unloaded) / probe;

  // the force of one row with that response, in place of the trial force
  const double force = joined.along > 0.0 ? thrum_contact_normal(&joined, unloaded, INFINITY) : 0.0;
  push_all(group, stiffness, force - probe);
  if (!(force > 0.0))
    return;

  // each row takes its share by stiffness, and with a force begins no more
  for (int64_t n = 0; n < group->rows.count; n++) {
    thrum_contact_row *row = begins(group, n);
    if (row != NULL)
      row->touch.force = row->stiffness / stiffness * force;
  }
}

/* --- the rows of an obstacle ------------------------------------------------------------------ */

static bool is_of_obstacle(const void *run, int64_t n, const int32_t *obstacle) {
  return ((const thrum_contact_run *)run)->view.rows[n].touch.obstacle == *obstacle;
}

static void point_moved(const void *of, int64_t n, double at[3]) {
  const thrum_contact_run *run = of;
  const thrum_contact_row *row = run->view.rows + n;
  thrum_point_moved(run, thrum_point_rows(run, row->touch.point), row->lever, run->view.moved, at);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= row->drift[axis];
}

static void push_point(void *of, int64_t n, const double force[3]) {
  thrum_contact_run *run = of;
  const thrum_contact_row *row = run->view.rows + n;
  thrum_point_push(run, thrum_point_rows(run, row->touch.point), row->lever, force);
}

void thrum_contact_guess(thrum_contact_run *run) {
  for (int32_t n = 0; n < run->environment->obstacle_count && run->contact->row_count > 1; n++)
    thrum_contact_guess_group(&(thrum_row_group){.rows = thrum_rows_of(run),
                                                 .run = run,
                                                 .of = &n,
                                                 .has = is_of_obstacle,
                                                 .moved = point_moved,
                                                 .push = push_point});
}
