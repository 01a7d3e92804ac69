/* The energy balance of contact between bodies over a step that was made (contact_energy.c): the
 * work of their forces is exact whatever was predicted; springs hold no more than they took, and
 * what else the bodies gave up counts as lost. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_energy.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "contact/contact_elastic.h"
#include "contact/contact_law.h"
#include "contact/contact_pairs_private.h"
#include "contact/contact_point.h"

#define TOO_DEEP 0.9 /* of the thickness: a step that ends deeper is made again */

/* The work that a solid which moves does through a row, whose side `side` it is [J]. */
static double driven_by(const thrum_contact_row *row, int side, const double moved[3]) {
  const double sign = side == 0 ? -1.0 : 1.0;
  return sign * (row->touch.force * thrum_dot3(row->touch.normal, moved) +
                 thrum_dot3(row->touch.friction, moved));
}

/* Displacement of the place on one side of a row in the step that was made. */
static void made_of(const thrum_pairs_run *run, const thrum_pair_row *pair, int side,
                    double moved[3]) {
  const thrum_contact_run *body = run->view.runs + pair->members[side];
  thrum_point_moved(body, thrum_pairs_basis(pair, side), side == 0 ? pair->row.lever : pair->lever,
                    body->view.made, moved);
}

/* Fills work, rubbed and the gap of a row; what they are of is one place against the other. */
static void measure_row(const thrum_pairs_run *run, thrum_pair_row *pair) {
  thrum_contact_row *row = &pair->row;
  double moved[3], other[3];

  // two places of one body
  row->driven = 0.0;
  if (thrum_pairs_is_own(pair)) {
    const thrum_contact_run *body = run->view.runs + pair->members[0];
    thrum_point_shape(body, thrum_pairs_basis(pair, 0), body->view.made, moved);
    thrum_contact_row_measure(row, moved);
    return;
  }

  // two bodies, or a solid that does work
  made_of(run, pair, 0, moved);
  made_of(run, pair, 1, other);
  if (run->members[pair->members[0]].solid != NULL)
    row->driven = driven_by(row, 0, moved);
  if (run->members[pair->members[1]].solid != NULL)
    row->driven = driven_by(row, 1, other);
  for (int axis = 0; axis < 3; axis++)
    moved[axis] -= other[axis];
  thrum_contact_row_measure(row, moved);
}

/* The work of the rows on the bodies in the steps that were made [J]. */
static double work_of(const thrum_pairs_run *run) {
  double work = 0.0;
  for (int64_t n = 0; n < run->row_count; n++)
    work += run->view.rows[n].row.work + run->view.rows[n].row.rubbed;
  return work;
}

/* Fills what the rows did in the steps that were made; returns their work. The members'
 * thrum_contact_measure comes before. */
static double measure(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++)
    measure_row(run, run->view.rows + n);
  return work_of(run);
}

bool thrum_pairs_allowed(thrum_pairs_run *run) {
  const thrum_row_list list = thrum_pairs_rows_of(run);

  // what is owed is no part of it, and impacts may have been booked in the other account
  const double budget = thrum_pairs_is_elastic(run) ? 0.0 : run->history->budget;
  const double left = thrum_rows_stored(&list) + budget - measure(run);
  const double flow = run->history->flow + run->flow + thrum_rows_flow(&list);
  return left >= -THRUM_ROUNDING * flow;
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

/* The body of a row whose place has moved further in the step; a solid is none. */
static int64_t further(const thrum_pairs_run *run, const thrum_pair_row *pair) {
  double moved[3], other[3];
  made_of(run, pair, 0, moved);
  made_of(run, pair, 1, other);
  const double own = thrum_dot3(moved, moved), others = thrum_dot3(other, other);
  const bool first = run->members[pair->members[1]].solid != NULL || isnan(own) || others <= own;
  return pair->members[first && run->members[pair->members[0]].solid == NULL ? 0 : 1];
}

int64_t thrum_pairs_beyond(const thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++)
    if (!thrum_contact_row_counts(&run->view.rows[n].row))
      return further(run, run->view.rows + n);
  return -1;
}

/* Keeps the rows that touched as the touches of the next step. */
double thrum_pairs_share(double depth, double thickness) {
  return fmin(depth / thickness, DBL_MAX);
}

static void keep_touches(thrum_pairs_run *run) {
  thrum_pairs_history *history = run->history;
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *pair = run->view.rows + n;
    const thrum_touching *touch = &pair->row.touch;
    if (touch->force == 0.0 && touch->gap >= 0.0)
      continue;

    // the report counts all, also those for which there is no room
    const double distance = touch->gap + pair->thickness;
    history->distance = history->touch_count > 0 ? fmin(history->distance, distance) : distance;
    history->depth = fmax(history->depth, -touch->gap);
    history->deepest_share =
        fmax(history->deepest_share, thrum_pairs_share(-touch->gap, pair->thickness));
    history->normal += touch->force;
    if (run->first_touch + history->touch_count == run->pairs->touch_max) {
      history->dropped++;
      continue;
    }

    // the next step starts from these forces, and finds its row by the key
    thrum_pair_touching *kept = run->view.touches + run->first_touch + history->touch_count++;
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
  history->deepest = fmax(history->deepest, history->depth);

  // touches take the place of impacts that are listed
  const int64_t left = run->pairs->touch_max - run->first_touch - history->touch_count;
  history->struck = history->struck < left ? history->struck : left;
}

void thrum_pairs_list_impacts(thrum_contact_pairs *pairs, const thrum_pair_touching *impacts,
                              int64_t count) {
  const thrum_pairs_view view = thrum_pairs_view_of(pairs);
  thrum_pairs_history *history = &pairs->history;
  for (int64_t n = 0; n < count && history->touch_count + history->struck < pairs->touch_max; n++)
    *thrum_pairs_impact_at(pairs, &view, history->struck++) = impacts[n];
}

/* Is a body one of the group? Their numbers ascend. */
static bool is_member(const thrum_pairs_run *run, int32_t number) {
  int64_t from = 0, to = run->count;
  while (from < to) {
    const int64_t middle = from + (to - from) / 2;
    if (run->members[middle].number < number)
      from = middle + 1;
    else
      to = middle;
  }
  return from < run->count && run->members[from].number == number;
}

/* What the springs of the group held after the last step, those of touches that have ended too [J].
 */
static double held_before(const thrum_pairs_run *run) {
  double sum = 0.0;
  for (int64_t n = 0; n < run->history->before_count; n++) {
    const thrum_pair_touching *touch = run->view.before + n;
    if (touch->stored > 0.0 && is_member(run, touch->key.bodies[0]) &&
        is_member(run, touch->key.bodies[1]))
      sum += touch->stored;
  }
  return sum;
}

double thrum_pairs_settle(thrum_pairs_run *run) {
  thrum_pairs_history *history = run->history;
  const thrum_row_list list = thrum_pairs_rows_of(run);
  const double before = thrum_rows_stored(&list), work = work_of(run);
  const double held = thrum_rows_keep_stored(&list);
  const double loss = history->budget + before - work - held;
  const double stored = thrum_rows_cover_loss(&list, held, loss);

  // what all springs held before counts as lost until their group has settled
  history->stored += stored;
  history->lost += run->taken - work - stored;
  history->driven += run->driven;
  history->budget += before - work - stored;
  history->flow += run->flow + thrum_rows_flow(&list);
  for (int64_t n = 0; n < run->row_count; n++)
    history->driven += run->view.rows[n].row.driven;
  keep_touches(run);
  return held_before(run) - work - stored;
}
