/* What contact that takes no energy has lost in a step goes back (docs/contact.md). The springs of
 * rows conserve the energy of the step that was predicted, and the step that was made ends a little
 * off, with normals and arms that have turned. With e = 1 and no friction or damping nothing may be
 * missing, so the impulses of the step are made larger or smaller by a share that makes up for it:
 *
 *   p' = p + s J^T F,   b s + a s^2 / 2 = E,   b = (J^T F) v,   a = (J^T F) M^-1 (J^T F),
 *
 * with F the forces of all rows together and s the root of the lesser size. It is along J^T F,
 * so that it adds neither momentum nor, as both sides act at one point, angular momentum.
 * Cost: 6 r a row. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_elastic.h"

#include <math.h>
#include <string.h>

#include "contact/contact_impact.h"
#include "contact/contact_point.h"
#include "core/state/state_layout.h"
#include "runtime/guard/guards.h"

/* --- a body ----------------------------------------------------------------------------------- */

static bool is_solid(const thrum_contact_run *body) {
  return body->state == NULL;
}

/* Can a body be given what steps miss? Where its integrator conserves the energy, its shape has no
 * part of the angular momentum, and no link holds it. */
static bool is_plain(const thrum_contact_run *body) {
  const thrum_state *state = body->state;
  return !body->linked && !body->environment->inertia &&
         state->def.integrator == THRUM_INTEGRATOR_ENERGY && state->scheme == THRUM_SCHEME_ENERGY;
}

bool thrum_contact_is_elastic(const thrum_contact_run *run) {
  const thrum_contact_environment *environment = run->environment;
  bool elastic = is_plain(run) && environment->obstacle_count > 0;
  for (int64_t n = 0; n < environment->obstacle_count && elastic; n++) {
    const thrum_obstacle *obstacle = environment->obstacles + n;
    elastic =
        obstacle->restitution >= 1.0 && !(obstacle->friction > 0.0) && !(obstacle->damping > 0.0);
  }
  return elastic;
}

bool thrum_pairs_is_elastic(const thrum_pairs_run *run) {
  bool elastic = run->pairs->restitution >= 1.0 && !(run->pairs->friction > 0.0);
  for (int64_t n = 0; n < run->count && elastic; n++) {
    const thrum_contact_solid *solid = run->members[n].solid;
    elastic = solid == NULL ? is_plain(run->view.runs + n) && run->members[n].status >= 0
                            : solid->restitution >= 1.0 && !(solid->friction > 0.0);
  }
  return elastic;
}

/* The momentum of the shape that the next step starts from. */
static double *momentum_of(const thrum_contact_run *body) {
  const thrum_state_view view = thrum_state_view_of(body->state);
  return body->state->carried ? view.p_corrected : view.p;
}

/* As it is now, without a force. */
static void begin(thrum_contact_run *body) {
  thrum_contact_look(body);
  if (!is_solid(body))
    memset(body->view.made, 0, (size_t)body->contact->rank * sizeof *body->view.made);
}

/* Adds a force at the end of an arm, which bends the body by the rows of U of its place. */
static void add_force(thrum_contact_run *body, const double *basis, const double arm[3],
                      const double force[3], double sign) {
  double torque[3], local[3];
  thrum_cross3(arm, force, torque);
  thrum_apply3_transposed(body->axes, force, local);
  for (int axis = 0; axis < 3; axis++) {
    body->impact.impulse[axis] += sign * force[axis];
    body->impact.whirl[axis] += sign * torque[axis];
  }
  const int64_t r = is_solid(body) ? 0 : body->contact->rank;
  for (int64_t i = 0; i < r; i++)
    body->view.made[i] +=
        sign * (local[0] * basis[i] + local[1] * basis[r + i] + local[2] * basis[2 * r + i]);
}

/* Adds what the forces do by the velocities of the body, and how it answers. */
static void add_rates(const thrum_contact_run *body, double *b, double *a) {
  const thrum_impact_body *of = &body->impact;
  double turned[3];
  *b += thrum_dot3(of->impulse, of->velocity) + thrum_dot3(of->whirl, of->spin);
  if (is_solid(body))
    return;
  thrum_apply3(of->inverse, of->whirl, turned);
  *a += of->inverse_mass * thrum_dot3(of->impulse, of->impulse) + thrum_dot3(of->whirl, turned);
  const double *p = momentum_of(body);
  for (int32_t i = 0; i < body->contact->rank; i++) {
    *b += body->view.made[i] * p[i];
    *a += body->view.made[i] * body->view.made[i];
  }
}

/* Adds a share of the forces to the momenta of the shape. Where the step has two of them, that
 * which is seen grows by the same energy as that which is carried on. */
static void take_shape(const thrum_contact_run *body, double share) {
  const thrum_state_view view = thrum_state_view_of(body->state);
  const double *p = momentum_of(body);
  double more = 0.0, off = 0.0, square = 0.0;
  for (int32_t i = 0; i < body->contact->rank; i++) {
    const double change = share * body->view.made[i];
    more += change * (p[i] + 0.5 * change);
    off += change * (view.p[i] - p[i]);
    view.p[i] += change;
    square += view.p[i] * view.p[i];
    if (body->state->carried)
      view.p_corrected[i] += change;
  }

  // p by a factor whose square takes `off` from its energy; more than it has is left alone
  const double left = square > 0.0 ? 1.0 - 2.0 * off / square : 1.0;
  const double factor = left >= 0.0 ? sqrt(left) : 1.0;
  for (int32_t i = 0; i < body->contact->rank; i++)
    view.p[i] *= factor;
  thrum_guards_take(body->state, -more);
}

/* The same of the body. */
static void take(thrum_contact_run *body, double share) {
  const thrum_contact_environment *environment = body->environment;
  const thrum_impact_body *of = &body->impact;
  take_shape(body, share);
  for (int axis = 0; axis < 3 && environment->translation; axis++)
    environment->translation->velocity[axis] += share * of->inverse_mass * of->impulse[axis];
  for (int axis = 0; axis < 3 && environment->rigid_frame; axis++)
    environment->rigid_frame->momentum[axis] += share * of->whirl[axis];
}

/* The share of the forces that gives an energy; 0 where none does. */
static double share_of(double energy, double b, double a) {
  const double square = b * b + 2.0 * a * energy;
  if (!(a > 0.0) || !(square >= 0.0))
    return 0.0;
  const double share = 2.0 * energy / (b + copysign(sqrt(square), b));
  return isfinite(share) ? share : 0.0;
}

/* --- rows ------------------------------------------------------------------------------------- */

double thrum_contact_give(thrum_contact_run *run, double energy, double *driven) {
  double b = 0.0, a = 0.0, against = 0.0;
  *driven = 0.0;
  if (energy == 0.0)
    return 0.0;

  // the forces of the step, against obstacles that may move
  begin(run);
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    const thrum_contact_row *row = run->view.rows + n;
    double force[3];
    if (!(row->touch.force > 0.0))
      continue;
    thrum_contact_row_force(row, force);
    add_force(run, thrum_point_rows(run, row->touch.point), row->lever, force, 1.0);
    against += thrum_dot3(force, run->environment->obstacles[row->touch.obstacle].velocity);
  }
  add_rates(run, &b, &a);

  // as much of them as gives the energy
  const double share = share_of(energy, b - against, a);
  if (share == 0.0)
    return 0.0;
  take(run, share);
  *driven = share * against;
  return energy;
}

/* Adds the force of a row between bodies, or within one. */
static void add_pair(thrum_pairs_run *run, const thrum_pair_row *pair) {
  double force[3], arm[3] = {0.0, 0.0, 0.0};
  thrum_contact_row_force(&pair->row, force);
  if (thrum_pairs_is_own(pair)) {
    thrum_contact_run *body = run->view.runs + pair->members[0];
    const thrum_impact_body kept = body->impact;
    add_force(body, thrum_pairs_basis(pair, 0), arm, force, 1.0);
    body->impact = kept;
    return;
  }

  // both sides at one point of the world, about where their centres of mass are now
  for (int side = 0; side < 2; side++) {
    thrum_contact_run *body = run->view.runs + pair->members[side];
    for (int axis = 0; axis < 3; axis++)
      arm[axis] = pair->position[axis] - body->centre[axis] - body->moved[axis];
    add_force(body, thrum_pairs_basis(pair, side), arm, force, side == 0 ? 1.0 : -1.0);
  }
}

double thrum_pairs_give(thrum_pairs_run *run, double energy, double *driven) {
  double b = 0.0, a = 0.0;
  *driven = 0.0;
  if (energy == 0.0)
    return 0.0;

  // the forces of the step on all bodies
  for (int64_t n = 0; n < run->count; n++)
    begin(run->view.runs + n);
  for (int64_t n = 0; n < run->row_count; n++)
    if (run->view.rows[n].row.touch.force > 0.0)
      add_pair(run, run->view.rows + n);
  double solids = 0.0;
  for (int64_t n = 0; n < run->count; n++)
    add_rates(run->view.runs + n, run->members[n].solid ? &solids : &b, &a);

  // the forces on solids are against those on bodies
  const double share = share_of(energy, b + solids, a);
  if (share == 0.0)
    return 0.0;
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].solid == NULL)
      take(run->view.runs + n, share);
  *driven = -share * solids;
  return energy;
}
