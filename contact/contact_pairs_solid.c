/* Solids among the members of a step: obstacles with a skin that move as they are told. To rows and
 * sweeps a solid is a body without coordinates, of which no force moves anything.
 *
 * From the placement A, o to A', o' the origin moves by o' - o, and the rotation A'A^T is that of
 * the Cayley transform of theta, |theta| = 2 tan(angle / 2), so that theta x lever is the exact
 * displacement of a point (docs/contact.md, eq. 6).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_solid.h"

#include <math.h>
#include <string.h>

#define HALF_TURN 1e-6 /* 1 + cos of the largest angle of a step, just below 180 degrees */

/* The rotation from one placement to the next, as the angle of a step. */
static void turn_of(const thrum_contact_solid *solid, double turn[3]) {
  const double *from = solid->now.axes, *to = solid->next.axes;
  double r[9];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      r[3 * i + j] = thrum_dot3(to + 3 * i, from + 3 * j);

  // 2 sin(angle) axis over 1 + cos(angle), with trace = 1 + 2 cos(angle)
  const double scale = 2.0 / fmax(1.0 + r[0] + r[4] + r[8], HALF_TURN);
  turn[0] = scale * (r[7] - r[5]);
  turn[1] = scale * (r[2] - r[6]);
  turn[2] = scale * (r[3] - r[1]);
}

void thrum_pairs_open_solid(thrum_pairs_run *run, int64_t member, double dt) {
  const thrum_contact_solid *solid = run->members[member].solid;
  thrum_contact_run *made = run->view.runs + member;
  thrum_translation *way = &run->view.wholes[member].way;
  thrum_contact *contact = run->view.contacts + member;
  memset(made, 0, sizeof *made);
  memset(contact, 0, sizeof *contact);
  *way = (thrum_translation){.mass = INFINITY};
  run->view.environments[member] = (thrum_contact_environment){.translation = way};
  made->contact = contact;
  made->view = thrum_contact_view_of(contact);
  made->environment = run->view.environments + member;
  made->dt = dt;
  memcpy(made->axes, solid->now.axes, sizeof made->axes);
  memcpy(made->origin, solid->now.origin, sizeof made->origin);
  memcpy(made->centre, solid->now.origin, sizeof made->centre);

  // how it moves, whatever forces there are
  turn_of(solid, made->unloaded_turn);
  for (int axis = 0; axis < 3; axis++) {
    made->unloaded[axis] = solid->next.origin[axis] - solid->now.origin[axis];
    way->velocity[axis] = made->unloaded[axis] / dt;
    made->spin[axis] = made->unloaded_turn[axis] / dt;
    made->moved[axis] = made->unloaded[axis];
    made->turned[axis] = made->unloaded_turn[axis];
    made->sought[axis] = made->unloaded[axis];
    made->sought_turn[axis] = made->unloaded_turn[axis];
  }
}

thrum_skin_bound thrum_pairs_solid_bound(const thrum_contact_member *member) {
  const thrum_contact_solid *solid = member->solid;
  const thrum_skin_node *root = thrum_skin_view_of(member->skin).nodes;
  thrum_skin_bound bound = {.radius = root->radius};
  double way[3], turn[3];
  memcpy(bound.axes, solid->now.axes, sizeof bound.axes);
  memcpy(bound.half, member->skin->half, sizeof bound.half);
  thrum_apply3(solid->now.axes, root->middle, bound.middle);
  for (int axis = 0; axis < 3; axis++)
    bound.middle[axis] += solid->now.origin[axis];
  thrum_subtract3(solid->next.origin, solid->now.origin, way);
  turn_of(solid, turn);
  const double arm = sqrt(thrum_dot3(root->middle, root->middle)) + root->radius;
  bound.motion = sqrt(thrum_dot3(way, way)) + sqrt(thrum_dot3(turn, turn)) * arm;
  return bound;
}
