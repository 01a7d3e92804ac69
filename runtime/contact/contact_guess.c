/* The first guess at the forces of touches that begin in this step (docs/contact.md).
 *
 * Points that move as one, such as those of a face that lands flat, are almost one unknown; taken
 * in turn they would need as many sweeps as k G is large to share a force. So the rows of one
 * obstacle without a force so far are first taken as one spring, each point with its share of the
 * stiffness, and its force is theirs. It changes where the sweeps begin, not where they end.
 * Cost: 18 r a row that touches anew.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_point.h"
#include "runtime/contact/contact_private.h"

/* A row that comes in without a force so far. */
static bool begins(const thrum_contact_row *row, int32_t obstacle) {
  return row->touch.obstacle == obstacle && row->touch.force == 0.0 && row->gap >= 0.0 &&
         row->stiffness > 0.0;
}

static void along_normal(const thrum_contact_row *row, double force, double out[3]) {
  for (int axis = 0; axis < 3; axis++)
    out[axis] = force * row->touch.normal[axis];
}

/* Gap at the end of the step as moved has it. */
static double gap_of(const thrum_contact_run *run, const thrum_contact_row *row) {
  double at[3];
  thrum_point_moved(run, thrum_point_rows(run, row->touch.point), row->lever, run->view.moved, at);
  for (int axis = 0; axis < 3; axis++)
    at[axis] -= row->drift[axis];
  return row->gap + thrum_dot3(row->touch.normal, at);
}

/* The mean gap at the end of the rows that begin, weighted by their stiffness. */
static double mean_gap(const thrum_contact_run *run, int32_t obstacle, double stiffness) {
  double sum = 0.0;
  for (int64_t n = 0; n < run->contact->row_count; n++)
    if (begins(run->view.rows + n, obstacle))
      sum += run->view.rows[n].stiffness / stiffness * gap_of(run, run->view.rows + n);
  return sum;
}

/* Adds a force to moved, shared by stiffness. */
static void push_all(thrum_contact_run *run, int32_t obstacle, double stiffness, double force) {
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    double share[3];
    if (!begins(row, obstacle))
      continue;
    along_normal(row, row->stiffness / stiffness * force, share);
    thrum_point_push(run, thrum_point_rows(run, row->touch.point), row->lever, share);
  }
}

/* Joins the new rows of an obstacle into one, by their stiffness; returns their number. */
static int64_t join(const thrum_contact_run *run, int32_t obstacle, thrum_contact_row *joined) {
  int64_t count = 0;
  memset(joined, 0, sizeof *joined);

  // sums weighted by stiffness
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    if (!begins(row, obstacle))
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

/* Guesses the force of all new rows of an obstacle as if they were one: sweeps alone would find it
 * only slowly, as each row sees the others' forces one after the other. */
static void guess(thrum_contact_run *run, int32_t obstacle) {
  thrum_contact_row joined;
  if (join(run, obstacle, &joined) < 2 || !isnormal(joined.stiffness))
    return;
  const double stiffness = joined.stiffness, unloaded = mean_gap(run, obstacle, stiffness);
  if (!(unloaded < 0.0))
    return;

  // the response of all points to a force that could stop one of them
  const double probe = -unloaded / joined.along;
  push_all(run, obstacle, stiffness, probe);
  joined.along = (mean_gap(run, obstacle, stiffness) - unloaded) / probe;

  // the force of one row with that response, in place of the trial force
  double force = joined.along > 0.0 ? thrum_contact_normal(&joined, unloaded, INFINITY) : 0.0;
  push_all(run, obstacle, stiffness, force - probe);
  if (!(force > 0.0))
    return;

  // each row takes its share by stiffness
  for (int64_t n = 0; n < run->contact->row_count; n++)
    if (begins(run->view.rows + n, obstacle))
      run->view.rows[n].touch.force = run->view.rows[n].stiffness / stiffness * force;
}

void thrum_contact_guess(thrum_contact_run *run) {
  for (int64_t n = 0; n < run->environment->obstacle_count && run->contact->row_count > 1; n++)
    guess(run, (int32_t)n);
}
