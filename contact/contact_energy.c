/* The energy balance of contact over a step that was made, which bounds it (docs/contact.md).
 *
 * With F the forces of the step and dx what its points really did, relative to their obstacles,
 * work = sum F dx is exact whatever was predicted. The springs' stores fall by the work along their
 * normals, are no more than phi at the end, and not negative; what else the body gave up counts as
 * lost. Negative losses are taken out of the springs: so stored + lost = granted - work, and both
 * are at least 0 as long as that sum is.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_energy.h"

#include <math.h>
#include <string.h>

#include "contact/contact_point.h"
#include "contact/contact_pull.h"
#include "contact/contact_row.h"

/* Fills work, rubbed, driven and the gap of a row. */
static void measure_row(const thrum_contact_run *run, thrum_contact_row *row) {
  const double *rows = thrum_point_rows(run, row->touch.point);
  double moved[3], force[3];
  thrum_point_moved(run, rows, row->lever, run->view.made, moved);
  thrum_contact_row_force(row, force);
  for (int axis = 0; axis < 3; axis++)
    moved[axis] -= row->drift[axis];
  row->driven = thrum_dot3(force, row->drift);
  thrum_contact_row_measure(row, moved);
}

/* The work of the step that was measured [J]. */
static double work_of_rows(const thrum_contact_run *run) {
  double work = 0.0;
  for (int64_t n = 0; n < run->contact->row_count; n++)
    work += run->view.rows[n].work + run->view.rows[n].rubbed;
  return work;
}

double thrum_contact_measure(thrum_contact_run *run, const double *q) {
  for (int32_t i = 0; i < run->contact->rank; i++)
    run->view.made[i] = q[i] - run->view.q[i];
  for (int64_t n = 0; n < run->contact->row_count; n++)
    measure_row(run, run->view.rows + n);
  return work_of_rows(run);
}

double thrum_contact_flow(const thrum_contact_run *run) {
  const thrum_row_list list = thrum_rows_of(run);
  return thrum_rows_flow(&list);
}

/* Energy of springs that were there before the first step. */
static double granted_now(const thrum_contact_run *run) {
  const thrum_row_list list = thrum_rows_of(run);
  return run->contact->fresh ? thrum_rows_stored(&list) : 0.0;
}

/* Keeps the rows that touched as the touches of the next step. */
static void keep_touches(thrum_contact_run *run) {
  thrum_contact *contact = run->contact;
  contact->touch_count = 0;
  contact->depth = contact->normal = 0.0;
  for (int64_t n = 0; n < contact->row_count; n++) {
    thrum_touching touch = run->view.rows[n].touch;
    if (touch.force == 0.0 && touch.gap >= 0.0)
      continue;
    run->view.touches[contact->touch_count++] = touch;
    contact->depth = fmax(contact->depth, -touch.gap);
    contact->normal += touch.force;
  }

  // touches take the place of impacts that are listed
  const int64_t left = contact->touch_max - contact->touch_count;
  contact->struck = contact->struck < left ? contact->struck : left;
}

/* Work of the pulls on the body. */
static double work_of_pulls(const thrum_contact_run *run) {
  double sum = 0.0, moved[3];
  for (int64_t n = 0; n < run->contact->pull_count; n++) {
    const thrum_pull_row *row = run->view.pull_rows + n;
    thrum_point_moved(run, thrum_contact_pull_basis(run, n), row->lever, run->view.made, moved);
    sum += thrum_dot3(row->force, moved);
  }
  return sum;
}

bool thrum_contact_counts(const thrum_contact_run *run) {
  bool counts = thrum_contact_energy_counts(work_of_pulls(run));
  for (int64_t n = 0; n < run->contact->row_count && counts; n++)
    counts = thrum_contact_row_counts(run->view.rows + n);
  return counts;
}

thrum_status thrum_contact_beyond(thrum_error *error) {
  return thrum_error_set(error, THRUM_NOT_FINITE,
                         "the step would leave the range of finite numbers with the energy of a "
                         "touch or with the body as a whole: it flies apart; use a shorter step");
}

void thrum_contact_settle(thrum_contact_run *run) {
  thrum_contact *contact = run->contact;
  const double granted = granted_now(run), work = work_of_rows(run);
  const thrum_row_list list = thrum_rows_of(run);
  const double stored = thrum_rows_keep_stored(&list);

  // the balance: work on the body is granted + driven - stored - lost
  for (int64_t n = 0; n < contact->row_count; n++)
    contact->driven += run->view.rows[n].driven;
  contact->flow += thrum_contact_flow(run);
  contact->granted += granted;
  contact->lost += contact->stored + granted - work - stored;
  contact->stored = thrum_rows_cover_loss(&list, stored, contact->lost);
  contact->lost += stored - contact->stored;
  contact->pulled += work_of_pulls(run);

  // what the next step starts with
  keep_touches(run);
  for (int64_t n = 0; n < contact->pull_count; n++)
    memcpy(run->view.pull_forces + 3 * n, run->view.pull_rows[n].force, 3 * sizeof(double));
  contact->fresh = 0;
  contact->steps++;
}
