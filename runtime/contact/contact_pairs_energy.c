/* The energy balance of contact between bodies over a step that was made (contact_energy.c): the
 * work of their forces is exact whatever was predicted; springs hold no more than they took, and
 * what else the bodies gave up counts as lost. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_pairs_private.h"
#include "runtime/contact/contact_point.h"

#define ROUNDING 1e-10 /* share of the energy flow of contact that rounding may add */
#define TOO_DEEP 0.9   /* of the thickness: a step that ends deeper is made again */

/* Fills work, rubbed and the gap of a row. */
static void measure_row(const thrum_pairs_run *run, thrum_pair_row *pair) {
  const thrum_contact_run *a = run->view.runs + pair->members[0];
  const thrum_contact_run *b = run->view.runs + pair->members[1];
  thrum_contact_row *row = &pair->row;
  double moved[3], other[3];
  thrum_point_moved(a, thrum_pairs_basis(run, pair, 0), row->lever, a->view.made, moved);
  thrum_point_moved(b, thrum_pairs_basis(run, pair, 1), pair->lever, b->view.made, other);
  for (int axis = 0; axis < 3; axis++)
    moved[axis] -= other[axis];
  const double along = thrum_dot3(row->touch.normal, moved);
  row->work = row->touch.force * along;
  row->rubbed = thrum_dot3(row->touch.friction, moved);
  row->touch.gap = row->gap + along;
}

double thrum_pairs_measure(thrum_pairs_run *run) {
  double work = 0.0;
  for (int64_t n = 0; n < run->row_count; n++) {
    measure_row(run, run->view.rows + n);
    work += run->view.rows[n].row.work + run->view.rows[n].row.rubbed;
  }
  return work;
}

/* The sum of the forces times the free displacements of their points [J]. */
static double flow_of(const thrum_pairs_run *run) {
  double sum = 0.0;
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_contact_row *row = &run->view.rows[n].row;
    const double *f = row->touch.friction;
    sum += (row->touch.force + sqrt(thrum_dot3(f, f))) * row->unloaded_length;
  }
  return sum;
}

/* What the springs of the group held before the step [J]. */
static double held(const thrum_pairs_run *run) {
  double sum = 0.0;
  for (int64_t n = 0; n < run->row_count; n++)
    sum += run->view.rows[n].row.touch.stored;
  return sum;
}

bool thrum_pairs_allowed(thrum_pairs_run *run) {
  const double left = held(run) + run->pairs->budget - thrum_pairs_measure(run);
  return left >= -ROUNDING * (run->pairs->flow + flow_of(run));
}

bool thrum_pairs_apart(const thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *pair = run->view.rows + n;
    const double most = fmax(TOO_DEEP * pair->thickness, -pair->row.gap);
    if (-pair->row.touch.gap > most)
      return false;
  }
  return true;
}

/* Updates what the springs hold (keep_stored of contact_energy.c); returns the sum [J]. */
static double keep_stored(const thrum_pairs_run *run) {

  // the energy that all springs took, and the most that they can hold
  double taken = 0.0, room = 0.0;
  for (int64_t n = 0; n < run->row_count; n++) {
    thrum_contact_row *row = &run->view.rows[n].row;
    taken += row->touch.stored - row->work;
    row->touch.stored = thrum_contact_energy(row->stiffness, row->touch.gap);
    room += row->touch.stored;
  }

  // each holds its share
  const double kept = fmin(fmax(taken, 0.0), room), share = room > 0.0 ? kept / room : 0.0;
  double stored = 0.0;
  for (int64_t n = 0; n < run->row_count; n++) {
    run->view.rows[n].row.touch.stored *= share;
    stored += run->view.rows[n].row.touch.stored;
  }
  return stored;
}

/* Keeps the rows that touched as the touches of the next step. */
static void keep_touches(thrum_pairs_run *run) {
  thrum_contact_pairs *pairs = run->pairs;
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *pair = run->view.rows + n;
    const thrum_touching *touch = &pair->row.touch;
    if (touch->force == 0.0 && touch->gap >= 0.0)
      continue;
    const double distance = touch->gap + pair->thickness;
    pairs->distance = pairs->touch_count > 0 ? fmin(pairs->distance, distance) : distance;
    pairs->depth = fmax(pairs->depth, -touch->gap);
    pairs->deepest_share = fmax(pairs->deepest_share, -touch->gap / pair->thickness);
    pairs->normal += touch->force;
    if (pairs->touch_count == pairs->touch_max) {
      pairs->dropped++;
      continue;
    }

    thrum_pair_touching *kept = run->view.touches + pairs->touch_count++;
    *kept = (thrum_pair_touching){.key = pair->key,
                                  .towards = touch->towards,
                                  .force = touch->force,
                                  .approach = touch->approach,
                                  .stored = touch->stored,
                                  .distance = distance,
                                  .thickness = pair->thickness};
    memcpy(kept->normal, touch->normal, sizeof kept->normal);
    memcpy(kept->friction, touch->friction, sizeof kept->friction);
    memcpy(kept->position, pair->position, sizeof kept->position);
  }
  pairs->deepest = fmax(pairs->deepest, pairs->depth);
}

void thrum_pairs_settle(thrum_pairs_run *run) {
  thrum_contact_pairs *pairs = run->pairs;
  const double before = held(run), work = thrum_pairs_measure(run), stored = keep_stored(run);

  // what all springs held before counts as lost until their group has settled
  pairs->stored += stored;
  pairs->lost -= work + stored;
  pairs->budget += before - work - stored;
  pairs->flow += flow_of(run);
  keep_touches(run);
}
