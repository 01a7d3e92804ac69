/* The places of an impact one after the other, with the bodies as a whole on either side: how fast
 * they move against each other, and impulses on them. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "contact/contact_impact_private.h"
#include "core/base/vec3.h"

static thrum_impact_place place_on_obstacle(thrum_contact_run *body, int64_t index) {
  thrum_contact_row *row = body->view.rows + index;
  const thrum_obstacle *obstacle = body->environment->obstacles + row->touch.obstacle;
  thrum_impact_place made = {.row = row, .bodies = {body, NULL}};
  memcpy(made.arms[0], row->lever, sizeof row->lever);
  memcpy(made.velocity, obstacle->velocity, sizeof made.velocity);
  made.springy =
      body->contact->springy != 0 || obstacle->stiffness > 0.0 || obstacle->damping > 0.0;
  return made;
}

/* Both arms end at one point, halfway between the places, so that no angular momentum is made. */
static thrum_impact_place place_between(thrum_pairs_run *run, int64_t index) {
  thrum_pair_row *pair = run->view.rows + index;
  thrum_impact_place made = {.row = &pair->row, .pair = pair};
  double point[3];
  for (int side = 0; side < 2; side++)
    made.bodies[side] = run->view.runs + pair->members[side];
  for (int axis = 0; axis < 3; axis++)
    point[axis] = 0.5 * (pair->starts[0][axis] + pair->starts[1][axis] +
                         made.bodies[0]->impact.passed[axis] + made.bodies[1]->impact.passed[axis]);
  for (int side = 0; side < 2; side++)
    for (int axis = 0; axis < 3; axis++)
      made.arms[side][axis] =
          point[axis] - made.bodies[side]->centre[axis] - made.bodies[side]->impact.passed[axis];
  return made;
}

bool thrum_impact_next(const thrum_impact_rows *rows, thrum_impact_cursor *at,
                       thrum_impact_place *found) {
  // rows on obstacles, body by body; a member that failed has none
  for (; at->body < rows->count; at->body++, at->row = 0) {
    thrum_contact_run *body = rows->runs + at->body;
    const bool steps = rows->pairs == NULL || thrum_pairs_steps(rows->pairs, at->body);
    if (!steps || at->row >= body->contact->row_count)
      continue;
    *found = place_on_obstacle(body, at->row++);
    return true;
  }

  // then those between bodies; no impulse on a body as a whole moves two of its places apart
  while (rows->pairs != NULL && at->row < rows->pairs->row_count &&
         thrum_pairs_is_own(rows->pairs->view.rows + at->row))
    at->row++;
  if (rows->pairs == NULL || at->row >= rows->pairs->row_count)
    return false;
  *found = place_between(rows->pairs, at->row++);
  return true;
}

void thrum_impact_velocity(const thrum_impact_place *at, double out[3]) {
  for (int axis = 0; axis < 3; axis++)
    out[axis] = -at->velocity[axis];
  for (int side = 0; side < 2 && at->bodies[side] != NULL; side++) {
    const thrum_impact_body *of = &at->bodies[side]->impact;
    const double sign = side == 0 ? 1.0 : -1.0;
    double spin[3], turned[3];
    thrum_apply3(of->inverse, of->whirl, spin);
    for (int axis = 0; axis < 3; axis++)
      spin[axis] += of->spin[axis];
    thrum_cross3(spin, at->arms[side], turned);
    for (int axis = 0; axis < 3; axis++)
      out[axis] +=
          sign * (of->velocity[axis] + of->inverse_mass * of->impulse[axis] + turned[axis]);
  }
}

void thrum_impact_push(const thrum_impact_place *at, const double impulse[3]) {
  for (int side = 0; side < 2 && at->bodies[side] != NULL; side++) {
    thrum_impact_body *of = &at->bodies[side]->impact;
    const double sign = side == 0 ? 1.0 : -1.0;
    double torque[3];
    thrum_cross3(at->arms[side], impulse, torque);
    for (int axis = 0; axis < 3; axis++) {
      of->impulse[axis] += sign * impulse[axis];
      of->whirl[axis] += sign * torque[axis];
      at->row->strike.impulse[axis] += side == 0 ? impulse[axis] : 0.0;
    }
  }
}
