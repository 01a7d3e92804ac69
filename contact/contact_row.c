/* The part that rows of obstacles and rows between bodies have in common (docs/contact.md), see
 * contact_row.h. Cost: about 100 operations a row and call, without those of its point.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_row.h"

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"

#define RECOVERY 0.1 /* share of an excess of depth that a step may take back */

/* --- one row ---------------------------------------------------------------------------------- */

void thrum_contact_row_force(const thrum_contact_row *row, double force[3]) {
  for (int axis = 0; axis < 3; axis++)
    force[axis] = row->touch.force * row->touch.normal[axis] + row->touch.friction[axis];
}

/* Largest eigenvalue of G on the plane across the normal; pushed = G n. */
static double largest_across(const double response[9], const double normal[3],
                             const double pushed[3]) {
  const double along = thrum_dot3(pushed, normal);
  const double trace = response[0] + response[4] + response[8] - along;
  double square = along * along - 2.0 * thrum_dot3(pushed, pushed);
  for (int n = 0; n < 9; n++)
    square += response[n] * response[n];
  return 0.5 * (trace + sqrt(fmax(2.0 * square - trace * trace, 0.0)));
}

void thrum_contact_row_respond(thrum_contact_row *row) {
  double pushed[3];
  thrum_apply3(row->response, row->touch.normal, pushed);
  row->along = thrum_dot3(pushed, row->touch.normal);
  row->across = largest_across(row->response, row->touch.normal, pushed);
}

void thrum_contact_row_approach(thrum_contact_row *row, double h, double settling,
                                const double velocity[3], const double unloaded[3]) {
  thrum_touching *touch = &row->touch;
  const double speed = thrum_dot3(velocity, touch->normal);

  // the speed that the load adds is no impact: a body at rest would be thrown up again and again
  const double gained = 2.0 * (speed - thrum_dot3(unloaded, touch->normal) / h);

  // an approach lasts until the point moves away, and keeps its largest speed
  if (speed < 0.0) {
    const double way = thrum_dot3(unloaded, touch->normal);
    const double impact = thrum_contact_strikes(speed, way, h, settling) ? -speed : 0.0;
    touch->approach = touch->towards ? fmax(touch->approach, impact) : impact;
    touch->towards = 1;
  } else if (speed > 0.0) {
    touch->towards = 0;
  }

  // friction aims at the displacement that stops the tangential velocity within the step
  row->speed = speed;
  row->gained = gained;
  row->unloaded_length = sqrt(thrum_dot3(unloaded, unloaded));
  for (int axis = 0; axis < 3; axis++)
    row->slide[axis] = 0.5 * h * (velocity[axis] - speed * touch->normal[axis]);
}

void thrum_contact_row_solve(thrum_contact_row *row, double at[3], double change[3]) {
  const double *normal = row->touch.normal;
  double before[3], moved[3];
  thrum_contact_row_force(row, before);

  // the normal force from the gap that this row has without its own force
  const double gap = row->gap + thrum_dot3(normal, at);
  const double force =
      thrum_contact_normal(row, gap - row->along * row->touch.force, row->touch.stored);

  // most rows of a step do not touch, and have no friction then
  if (force == 0.0 && row->touch.force == 0.0 &&
      thrum_dot3(row->touch.friction, row->touch.friction) == 0.0) {
    memset(change, 0, 3 * sizeof *change);
    return;
  }
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

  // what the caller adds to all displacements moves this point at once
  thrum_contact_row_force(row, change);
  for (int axis = 0; axis < 3; axis++)
    change[axis] -= before[axis];
  thrum_apply3(row->response, change, moved);
  for (int axis = 0; axis < 3; axis++)
    row->seen[axis] += moved[axis];
}

void thrum_contact_row_measure(thrum_contact_row *row, const double moved[3]) {
  const double along = thrum_dot3(row->touch.normal, moved);
  row->work = row->touch.force * along;
  row->rubbed = thrum_dot3(row->touch.friction, moved);
  row->touch.gap = row->gap + along;
}

/* --- all rows of a step ----------------------------------------------------------------------- */

double thrum_rows_excess(const thrum_row_list *list) {
  double carried = 0.0, pressed = 0.0;
  for (int64_t n = 0; n < list->count; n++) {
    const thrum_contact_row *row = thrum_row_at(list, n);
    carried += row->touch.force;
    pressed += row->stiffness * fmax(-row->gap, 0.0);
  }
  return pressed > carried ? 1.0 - carried / pressed : 0.0;
}

double thrum_contact_row_ceiling(const thrum_contact_row *row, double h, double share) {
  const double excess = share * fmax(-row->gap, 0.0);
  const double out = fmin(sqrt(fmax(row->gained, 0.0) / h * excess), RECOVERY * excess / h);
  const double away = fmax(row->restitution * row->touch.approach, out);
  return row->restitution < 1.0 ? row->gap + 0.5 * h * (row->speed + away) : INFINITY;
}

/* The forces of a row times the displacement of its point without contact [J]. */
static double flow_of(const thrum_contact_row *row) {
  const double *f = row->touch.friction;
  return (row->touch.force + sqrt(thrum_dot3(f, f))) * row->unloaded_length;
}

double thrum_rows_flow(const thrum_row_list *list) {
  double sum = 0.0;
  for (int64_t n = 0; n < list->count; n++)
    sum += flow_of(thrum_row_at(list, n));
  return sum;
}

bool thrum_contact_row_counts(const thrum_contact_row *row) {
  const double held = thrum_contact_energy(row->stiffness, row->touch.gap);
  return isfinite(row->touch.gap) &&
         thrum_contact_energy_counts(fabs(row->work) + fabs(row->rubbed) + fabs(row->driven) +
                                     fabs(flow_of(row)) + held);
}

double thrum_rows_stored(const thrum_row_list *list) {
  double sum = 0.0;
  for (int64_t n = 0; n < list->count; n++)
    sum += thrum_row_at(list, n)->touch.stored;
  return sum;
}

double thrum_rows_keep_stored(const thrum_row_list *list) {

  // the energy that all springs took, and the most that they can hold
  double taken = 0.0, room = 0.0;
  for (int64_t n = 0; n < list->count; n++) {
    thrum_contact_row *row = thrum_row_at(list, n);
    taken += row->touch.stored - row->work;
    // a touch that ends keeps nothing
    row->touch.stored = thrum_contact_energy(row->stiffness, row->touch.gap);
    room += row->touch.stored;
  }

  // each holds its share
  const double kept = fmin(fmax(taken, 0.0), room), share = room > 0.0 ? kept / room : 0.0;
  double stored = 0.0;
  for (int64_t n = 0; n < list->count; n++) {
    thrum_contact_row *row = thrum_row_at(list, n);
    row->touch.stored *= share;
    stored += row->touch.stored;
  }
  return stored;
}

double thrum_rows_cover_loss(const thrum_row_list *list, double stored, double loss) {
  if (!(loss < 0.0) || !(stored > 0.0))
    return stored;
  const double left = fmax(stored + loss, 0.0), share = left / stored;
  for (int64_t n = 0; n < list->count; n++)
    thrum_row_at(list, n)->touch.stored *= share;
  return left;
}
