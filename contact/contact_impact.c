/* Impacts of near-rigid bodies (docs/contact.md, "How a body bounces"): impulses on the bodies as a
 * whole, with restitution by Newton's law in the form of Moreau,
 *
 *   v' + e v >= 0,   P >= 0,   P (v' + e v) = 0   along each normal,
 *
 * for all places that touch at once, and Coulomb's friction on the tangential velocity. The impulse
 * acts at the time of the impact: the bodies are moved to it, struck, and moved back with their new
 * velocities, so that the step which follows passes through the impact at its time.
 *
 * Shapes and their velocities stay: a body is near-rigid where what it could be deformed by is
 * small. Since the kinetic energy is a convex function of the impulses, e <= 1 never raises it;
 * what friction and unequal restitutions could add is found in the sum and taken back.
 *
 * Rows that sweeps do not settle are solved at once (contact_impact_newton.c).
 * Cost: about 150 operations a row and sweep, in steps with an impact alone. Sources: Moreau 1988,
 * doi:10.1007/978-3-7091-2624-0_1; Jean 1999, doi:10.1016/S0045-7825(98)00383-1.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "contact/contact_impact_private.h"
#include "contact/contact_pairs_rows.h"
#include "contact/contact_rows.h"
#include "core/state/state_layout.h"
#include "runtime/frames/rigid_frame_private.h"

#define SOFT 5e-3       /* v / (omega_1 diagonal) above which a body is not near-rigid */
#define SWEEPS_MAX 500  /* over the rows of an impact that are not solved at once */
#define FEW 6           /* sweeps before all rows are solved at once, and after it */
#define TOLERANCE 1e-10 /* of the fastest approach: sweeps end that change velocities less */
#define ROUNDING 1e-3   /* of all impulses, by which they may be cut so that they add no energy */

#define FAINT 1e-3 /* of the speed that loads add to either body: slower approaches are rest */

#define HALVINGS 4 /* of the friction of an impact that would add energy, before it has none */

/* The law that a solve of an impact follows. */
typedef struct means {
  double friction; /* share of each row's coefficient */
  bool bounces;    /* with the rows' restitution */
} means;

/* --- bodies ----------------------------------------------------------------------------------- */

void thrum_contact_look(thrum_contact_run *body) {
  thrum_impact_body *impact = &body->impact;
  const thrum_translation *way = body->environment->translation;
  const thrum_rigid_frame *frame = body->environment->rigid_frame;
  memset(impact->impulse, 0, sizeof impact->impulse);
  memset(impact->whirl, 0, sizeof impact->whirl);
  memcpy(impact->spin, body->spin, sizeof impact->spin);
  if (way == NULL)
    return;
  memcpy(impact->velocity, way->velocity, sizeof impact->velocity);
  impact->inverse_mass = isfinite(way->mass) ? 1.0 / way->mass : 0.0;
  if (frame == NULL)
    return;

  // the angular velocity is linear in the angular momentum, so three of them are the inverse
  thrum_rigid_frame unit = *frame;
  memset(unit.internal, 0, sizeof unit.internal);
  thrum_rigid_frame_velocity(frame, body->environment->placement, impact->spin);
  for (int axis = 0; axis < 3; axis++) {
    double column[3];
    for (int n = 0; n < 3; n++)
      unit.momentum[n] = n == axis;
    thrum_rigid_frame_velocity(&unit, body->environment->placement, column);
    for (int n = 0; n < 3; n++)
      impact->inverse[3 * n + axis] = column[n];
  }
}

/* The square of the speed up to which a body counts as rigid: less where it vibrates, below 0 for
 * one that never does, as what is linked answers with what it is linked to. */
static double limit_of(const thrum_contact_run *body) {
  const thrum_translation *way = body->environment->translation;
  if (way == NULL || body->linked)
    return -1.0;
  if (!isfinite(way->mass))
    return INFINITY;
  double lowest = INFINITY, energy = 0.0;
  for (int32_t i = 0; i < body->contact->rank; i++) {
    const double q = body->view.q[i], p = body->view.p[i], square = body->model->omega2[i];
    lowest = fmin(lowest, square);
    energy += p * p + square * q * q;
  }
  const double size = SOFT * body->contact->diagonal;
  return size * size * lowest - energy / way->mass;
}

static void open_bodies(const thrum_impact_rows *rows) {
  for (int64_t n = 0; n < rows->count; n++) {
    thrum_contact_run *body = rows->runs + n;
    body->impact.taken = false;
    if (body->contact == NULL || (rows->pairs != NULL && rows->pairs->members[n].status < 0))
      continue;
    memset(body->impact.passed, 0, sizeof body->impact.passed);
    body->impact.limit = limit_of(body);
    thrum_contact_look(body);
  }
}

/* The part of the energy of a coupled body that its frame does not keep while the shape's own
 * angular momentum s stays, s I^-1 P [J]: 0 of others. What an impact changes of it is no work at
 * the points that touch, but what holds the velocity of the shape. */
static double gyration_of(const thrum_contact_run *body) {
  const thrum_contact_environment *environment = body->environment;
  if (environment->inertia == NULL)
    return 0.0;
  const thrum_rigid_frame *frame = environment->rigid_frame;
  double axes[9], momentum[3], answer[3];
  thrum_rigid_frame_axes(frame, environment->placement, axes);
  thrum_apply3_transposed(axes, frame->momentum, momentum);
  thrum_apply3(frame->inverse, momentum, answer);
  return thrum_dot3(frame->internal, answer);
}

/* Moves a body as a whole through a time, without contact. */
static void pass(thrum_contact_run *body, double time) {
  const thrum_contact_environment *environment = body->environment;
  thrum_translation *way = environment->translation;

  // a solid goes on as it is told to
  if (way == NULL || !isfinite(way->mass)) {
    for (int axis = 0; axis < 3 && way != NULL; axis++)
      body->impact.passed[axis] += time * way->velocity[axis];
    return;
  }

  // a body moves under its loads, which is undone by the same way back
  double before[3];
  memcpy(before, way->position, sizeof before);
  thrum_translation_step(way, environment->force, time);
  for (int axis = 0; axis < 3; axis++)
    body->impact.passed[axis] += way->position[axis] - before[axis];
  if (environment->rigid_frame)
    thrum_rigid_frame_step(environment->rigid_frame, environment->placement, environment->torque,
                           time, NULL);
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Adds the velocity that an impulse at the end of an arm gives to its point. */
static void respond(const thrum_contact_run *body, const double arm[3], const double impulse[3],
                    double out[3]) {
  double torque[3], turned[3], moved[3];
  thrum_cross3(arm, impulse, torque);
  thrum_apply3(body->impact.inverse, torque, turned);
  thrum_cross3(turned, arm, moved);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += body->impact.inverse_mass * impulse[axis] + moved[axis];
}

/* How fast one side of a place moves along the normal as the step starts [m/s], and how far it goes
 * so in the step [m], by its body as a whole and its pulls. */
static double speed_of(const thrum_impact_place *at, int side, double *way) {
  const thrum_contact_run *body = at->bodies[side];
  double spun[3], turned[3];
  thrum_cross3(body->impact.spin, at->arms[side], spun);
  thrum_cross3(body->turned, at->arms[side], turned);
  for (int axis = 0; axis < 3; axis++) {
    spun[axis] += body->impact.velocity[axis];
    turned[axis] += body->moved[axis];
  }
  *way = thrum_dot3(turned, at->row->touch.normal);
  return thrum_dot3(spun, at->row->touch.normal);
}

/* Are both bodies near-rigid at this speed, without a spring between them that was asked for? */
static bool is_rigid(const thrum_impact_place *at, double speed) {
  bool rigid = !at->springy;
  for (int side = 0; side < 2 && at->bodies[side] != NULL; side++)
    rigid = rigid && speed * speed <= at->bodies[side]->impact.limit;
  return rigid;
}

/* How fast the places of a row move apart along its normal as the step starts [m/s]; *way: how far
 * they do so in the step [m]; *pressed: what the loads on either body add to its own speed [m/s].
 */
static double speed_apart(const thrum_impact_place *at, double *way, double *pressed) {
  const double h = at->bodies[0]->dt;
  double speed = -thrum_dot3(at->velocity, at->row->touch.normal);
  *way = h * speed;
  *pressed = 0.0;
  for (int side = 0; side < 2 && at->bodies[side] != NULL; side++) {
    double goes;
    const double of = speed_of(at, side, &goes), sign = side == 0 ? 1.0 : -1.0;
    speed += sign * of;
    *way += sign * goes;
    *pressed = fmax(*pressed, 2.0 * fabs(of - goes / h));
  }
  return speed;
}

/* The time from the start of the step at which a row strikes, which may be after its end; INFINITY
 * where it does not. */
static double time_of(const thrum_impact_place *at) {
  const double h = at->bodies[0]->dt, gap = at->row->gap;
  double way, pressed;
  const double speed = speed_apart(at, &way, &pressed);

  // what the load adds is no impact, nor what is left of an approach where bodies lie on each other
  const double gained = 2.0 * (speed - way / h);
  double settling = at->bodies[0]->settling;
  if (at->bodies[1] != NULL)
    settling = fmax(settling, at->bodies[1]->settling);
  const double slow = fmax(thrum_contact_resting(gained, h, settling), FAINT * pressed);
  if (!(speed < 0.0) || !(-speed > slow) || !is_rigid(at, -speed))
    return INFINITY;

  // gap + speed t - gained/h t^2/2 = 0
  const double square = speed * speed + 2.0 * gained / h * gap;
  if (gap <= 0.0 || square < 0.0)
    return gap <= 0.0 ? 0.0 : INFINITY;
  return 2.0 * gap / (sqrt(square) - speed);
}

/* Marks the rows that strike in this step; returns the time of the first and, in *fastest, the
 * fastest approach. */
static double mark_strikes(const thrum_impact_rows *rows, double *fastest) {
  double first = INFINITY, h = 0.0;
  thrum_impact_place at;
  *fastest = 0.0;
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
    const double time = time_of(&at);
    h = at.bodies[0]->dt;
    double velocity[3];
    memset(&at.row->strike, 0, sizeof at.row->strike);
    if (!(time <= THRUM_SOON * h))
      continue;

    // all that strike in a step strike together, and so does what is as near but for rounding: a
    // face that lands flat must not be struck at some of its points
    thrum_impact_velocity(&at, velocity);
    at.row->strike.part = THRUM_STRIKES;
    first = fmin(first, time);
    *fastest = fmax(*fastest, -thrum_dot3(velocity, at.row->touch.normal));
    for (int side = 0; side < 2 && at.bodies[side] != NULL; side++)
      at.bodies[side]->impact.taken = true;
  }
  return first <= h ? first : INFINITY;
}

/* The gap of a row at a time of the step, as the bodies go before the impact [m]. A body that an
 * earlier impact of the step has put on another way is inside what it struck at the start of that
 * way, and not at this time. */
static double gap_at(const thrum_impact_place *at, double time) {
  const double h = at->bodies[0]->dt, share = time / h;
  double way, pressed;
  const double speed = speed_apart(at, &way, &pressed);
  return at->row->gap + time * speed + share * share * (way - h * speed);
}

/* Marks the rows that bear on what is struck at a time: they may not give way. */
static void mark_bearing(const thrum_impact_rows *rows, double time, double fastest) {
  bool more = true;
  thrum_impact_place at;

  // from body to body, as long as the impact reaches another one
  while (more) {
    more = false;
    for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
      const bool reached =
          at.bodies[0]->impact.taken || (at.bodies[1] != NULL && at.bodies[1]->impact.taken);
      if (at.row->strike.part != THRUM_NO_PART || !reached || !is_rigid(&at, fastest))
        continue;

      // what does not touch bears nothing
      if (!(at.row->touch.force > 0.0) && !(gap_at(&at, time) <= 0.0))
        continue;
      at.row->strike.part = THRUM_BEARS;
      more = true;
      for (int side = 0; side < 2 && at.bodies[side] != NULL; side++)
        at.bodies[side]->impact.taken = true;
    }
  }
}

/* Fills what each part of the impact needs, at its time. */
static void fill_parts(const thrum_impact_rows *rows, const means *by) {
  thrum_impact_place at;

  // a solve begins without impulses
  for (int64_t n = 0; n < rows->count; n++) {
    memset(rows->runs[n].impact.impulse, 0, sizeof rows->runs[n].impact.impulse);
    memset(rows->runs[n].impact.whirl, 0, sizeof rows->runs[n].impact.whirl);
  }

  // the speed that each row asks for
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
    thrum_row_strike *strike = &at.row->strike;
    const double *normal = at.row->touch.normal;
    if (strike->part == THRUM_NO_PART)
      continue;
    memset(strike->impulse, 0, sizeof strike->impulse);
    thrum_impact_velocity(&at, strike->before);
    const double approach = fmax(-thrum_dot3(strike->before, normal), 0.0);
    const bool bounces = strike->part == THRUM_STRIKES && by->bounces;
    strike->away = bounces ? at.row->restitution * approach : 0.0;
    strike->friction = by->friction * at.row->friction;

    // how the place answers to an impulse along the normal, and a bound of that across it
    double trace = 0.0;
    strike->along = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const double unit[3] = {axis == 0, axis == 1, axis == 2};
      double moved[3] = {0.0};
      for (int side = 0; side < 2 && at.bodies[side] != NULL; side++)
        respond(at.bodies[side], at.arms[side], unit, moved);
      trace += moved[axis];
      strike->along += normal[axis] * thrum_dot3(normal, moved);
    }
    strike->across = trace - strike->along;
  }
}

/* Solves one part; returns by how much its velocity changed [m/s]. */
static double solve_part(const thrum_impact_place *at) {
  thrum_row_strike *strike = &at->row->strike;
  const double *normal = at->row->touch.normal;
  double velocity[3], change[3];

  // the normal impulse that leaves the speed asked for, or none
  thrum_impact_velocity(at, velocity);
  const double had = thrum_dot3(strike->impulse, normal);
  const double speed = thrum_dot3(velocity, normal);
  const double force = fmax(had + (strike->away - speed) / strike->along, 0.0);
  for (int axis = 0; axis < 3; axis++)
    change[axis] = (force - had) * normal[axis];
  thrum_impact_push(at, change);
  const double moved = fabs(force - had) * strike->along;
  if (!(strike->friction > 0.0))
    return moved;

  // friction against the tangential velocity, within Coulomb's bound
  double across[3];
  thrum_impact_velocity(at, velocity);
  const double rest = thrum_dot3(velocity, normal);
  for (int axis = 0; axis < 3; axis++)
    across[axis] = strike->impulse[axis] - force * normal[axis] -
                   (velocity[axis] - rest * normal[axis]) / strike->across;
  const double length = sqrt(thrum_dot3(across, across)), most = strike->friction * force;
  const double share = length > most ? most / length : 1.0;
  for (int axis = 0; axis < 3; axis++)
    change[axis] = share * across[axis] + force * normal[axis] - strike->impulse[axis];
  thrum_impact_push(at, change);
  return moved + sqrt(thrum_dot3(change, change)) * strike->across;
}

/* Solves for all impulses: by sweeps over the rows and, where these do not settle, all at once.
 * Then a few sweeps give each row its law. */
static void solve(const thrum_impact_rows *rows, double fastest) {
  int most = SWEEPS_MAX;
  for (int sweep = 0; sweep < most; sweep++) {
    double change = 0.0;
    thrum_impact_place at;
    if (sweep == FEW && thrum_impact_newton(rows, TOLERANCE * fastest))
      most = 2 * FEW;
    for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);)
      if (at.row->strike.part != THRUM_NO_PART)
        change = fmax(change, solve_part(&at));
    if (!(change > TOLERANCE * fastest))
      return;
  }
}

/* Returns the energy that the impulse of a row takes [J], beyond the work of what moves by itself.
 */
static double loss_of(const thrum_impact_place *at) {
  const thrum_row_strike *strike = &at->row->strike;
  double after[3];
  thrum_impact_velocity(at, after);
  return -0.5 * (thrum_dot3(strike->impulse, strike->before) + thrum_dot3(strike->impulse, after));
}

/* Cuts all impulses so that the impact adds no energy, or takes none where e = 1 without friction:
 * by rounding, as a solve ends within a tolerance. False where more than that would have to go.
 *
 * With all impulses times s, the loss is s a - s^2 b / 2, a = -sum P v and b = sum P (v' - v). */
static bool cut(const thrum_impact_rows *rows, const means *by) {
  double a = 0.0, b = 0.0;
  bool elastic = by->bounces;
  thrum_impact_place at;

  // the two sums over all rows of the impact
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
    const thrum_row_strike *strike = &at.row->strike;
    double after[3];
    if (strike->part == THRUM_NO_PART)
      continue;
    thrum_impact_velocity(&at, after);
    elastic = elastic && at.row->restitution >= 1.0 && !(strike->friction > 0.0);
    a -= thrum_dot3(strike->impulse, strike->before);
    b += thrum_dot3(strike->impulse, after) - thrum_dot3(strike->impulse, strike->before);
  }
  const double whole = 2.0 * a / b, share = whole < 1.0 || elastic ? whole : 1.0;
  if (!(share >= (elastic ? 0.0 : 1.0 - ROUNDING)) || isinf(share))
    return false;

  // less of each, or more
  for (thrum_impact_cursor n = {0, 0}; share != 1.0 && thrum_impact_next(rows, &n, &at);) {
    double less[3];
    for (int axis = 0; axis < 3; axis++)
      less[axis] = (share - 1.0) * at.row->strike.impulse[axis];
    if (at.row->strike.part != THRUM_NO_PART)
      thrum_impact_push(&at, less);
  }
  return true;
}

/* The work that an obstacle or a solid which moves does by the impulse of a row [J]. */
static double work_of(const thrum_impact_place *at) {
  double moves[3] = {at->velocity[0], at->velocity[1], at->velocity[2]}, sum = 0.0;
  if (at->bodies[1] == NULL)
    return thrum_dot3(at->row->strike.impulse, moves);
  for (int side = 0; side < 2; side++) {
    const thrum_impact_body *of = &at->bodies[side]->impact;
    if (of->inverse_mass > 0.0)
      continue;
    thrum_cross3(of->spin, at->arms[side], moves);
    for (int axis = 0; axis < 3; axis++)
      moves[axis] += of->velocity[axis];
    sum += (side == 0 ? -1.0 : 1.0) * thrum_dot3(at->row->strike.impulse, moves);
  }
  return sum;
}

/* --- the impact ------------------------------------------------------------------------------- */

/* The impulse of a row along its normal and across it [N s]. */
static double split(const thrum_contact_row *row, double across[3]) {
  const double along = thrum_dot3(row->strike.impulse, row->touch.normal);
  for (int axis = 0; axis < 3; axis++)
    across[axis] = row->strike.impulse[axis] - along * row->touch.normal[axis];
  return along;
}

/* Lists a place on an obstacle behind the touches of the last step, where these leave room. */
static void list_on_obstacle(const thrum_impact_place *at) {
  thrum_contact *contact = at->bodies[0]->contact;
  contact->impacts++;
  if (contact->touch_count + contact->struck >= contact->touch_max)
    return;
  thrum_touching *listed =
      thrum_contact_impact_at(contact, &at->bodies[0]->view, contact->struck++);
  *listed = (thrum_touching){.point = at->row->touch.point,
                             .obstacle = at->row->touch.obstacle,
                             .face = at->row->touch.face};
  memcpy(listed->normal, at->row->touch.normal, sizeof listed->normal);
  listed->force = split(at->row, listed->friction);
}

/* Lists a place between two bodies, at the time of the impact. */
static void list_between(thrum_pairs_run *run, const thrum_impact_place *at) {
  const thrum_contact_run *first = at->bodies[0];
  run->impacts++;
  if (run->first_struck + run->struck >= run->pairs->touch_max)
    return;
  thrum_pair_touching *listed = run->view.struck + run->first_struck + run->struck++;
  *listed = (thrum_pair_touching){.key = at->pair->key, .thickness = at->pair->thickness};
  memcpy(listed->normal, at->row->touch.normal, sizeof listed->normal);
  listed->force = split(at->row, listed->friction);
  listed->distance = at->pair->thickness;
  for (int axis = 0; axis < 3; axis++)
    listed->position[axis] = at->arms[0][axis] + first->centre[axis] + first->impact.passed[axis];
}

/* Books the energy of the impact, and what went through it: with the bodies' own contact, or with
 * that between them. Where an impulse acts it is listed. */
static void book(const thrum_impact_rows *rows) {
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
    if (at.row->strike.part == THRUM_NO_PART)
      continue;

    // energy that is lost or done, and what rounding is a share of
    const thrum_row_strike *strike = &at.row->strike;
    const double lost = loss_of(&at), driven = work_of(&at);
    const double flow = sqrt(thrum_dot3(strike->impulse, strike->impulse) *
                             thrum_dot3(strike->before, strike->before));
    if (at.bodies[1] == NULL) {
      at.bodies[0]->contact->flow += flow;
      at.bodies[0]->contact->impact += lost;
      at.bodies[0]->contact->driven += driven;
      if (flow > 0.0)
        list_on_obstacle(&at);
    } else {
      rows->pairs->flow += flow;
      rows->pairs->taken += lost;
      rows->pairs->driven += driven;
      if (flow > 0.0)
        list_between(rows->pairs, &at);
    }
  }
}

/* Gives a body its impulse. */
static void take(thrum_contact_run *body) {
  const thrum_contact_environment *environment = body->environment;
  thrum_impact_body *impact = &body->impact;
  for (int axis = 0; axis < 3; axis++)
    environment->translation->velocity[axis] += impact->inverse_mass * impact->impulse[axis];
  for (int axis = 0; axis < 3 && environment->rigid_frame; axis++)
    environment->rigid_frame->momentum[axis] += impact->whirl[axis];
}

/* Notes where a body really starts, which the search goes by, and how far from there the start of
 * its new way is. */
static void note(thrum_contact_run *body, double time) {
  thrum_impact_body *impact = &body->impact;
  double velocity[3], spin[3];
  thrum_apply3(impact->inverse, impact->whirl, spin);
  for (int axis = 0; axis < 3; axis++)
    velocity[axis] = impact->inverse_mass * impact->impulse[axis];
  if (!impact->struck) {
    memcpy(impact->axes, body->axes, sizeof impact->axes);
    memcpy(impact->origin, body->origin, sizeof impact->origin);
  }
  impact->struck = true;
  impact->turned +=
      time * (sqrt(thrum_dot3(spin, spin)) + 2.0 * sqrt(thrum_dot3(impact->spin, impact->spin)));
  impact->moved += time * sqrt(thrum_dot3(velocity, velocity));
}

/* All that is struck goes to its time, or back from it. */
static void pass_all(const thrum_impact_rows *rows, double time) {
  for (int64_t n = 0; n < rows->count; n++)
    if (rows->runs[n].impact.taken)
      pass(rows->runs + n, time);
}

/* Gives a row to all that wait without one, and may bear; returns whether there was any. */
static bool wake(const thrum_impact_rows *rows) {
  if (rows->pairs != NULL)
    return thrum_pairs_wake_all(rows->pairs, true);
  bool any = false;
  for (int64_t n = 0; n < rows->count; n++)
    any = thrum_contact_wake(rows->runs + n, true) || any;
  return any;
}

bool thrum_contact_strike(const thrum_impact_rows *rows) {
  double fastest;
  open_bodies(rows);
  double first = mark_strikes(rows, &fastest);
  if (!(first < INFINITY))
    return false;

  if (wake(rows))
    first = mark_strikes(rows, &fastest);
  const double time = rows->early ? 0.0 : first;

  // to the time of the impact, where velocities and inertia are looked at again
  mark_bearing(rows, time, fastest);
  for (int64_t n = 0; n < rows->count; n++)
    if (rows->runs[n].impact.taken)
      rows->runs[n].impact.gyration = gyration_of(rows->runs + n);
  pass_all(rows, time);
  for (int64_t n = 0; n < rows->count; n++)
    if (rows->runs[n].impact.taken)
      thrum_contact_look(rows->runs + n);

  // what gains energy asks for less: half of the friction and so on, none, at last no restitution
  bool allowed = false;
  for (int n = 0; n <= HALVINGS + 2 && !allowed; n++) {
    const means by = {n <= HALVINGS ? ldexp(1.0, -n) : 0.0, n < HALVINGS + 2};
    fill_parts(rows, &by);
    solve(rows, fastest);
    allowed = cut(rows, &by);
  }

  // impulses, and back to the start of the step on the new ways
  if (allowed)
    book(rows);
  for (int64_t n = 0; n < rows->count && allowed; n++)
    if (rows->runs[n].impact.taken && rows->runs[n].impact.inverse_mass > 0.0) {
      take(rows->runs + n);
      note(rows->runs + n, time);
    }
  pass_all(rows, -time);
  for (int64_t n = 0; n < rows->count && allowed; n++)
    if (rows->runs[n].impact.taken)
      rows->runs[n].contact->impact -= gyration_of(rows->runs + n) - rows->runs[n].impact.gyration;
  return allowed;
}

bool thrum_contact_strays(const thrum_impact_rows *rows) {
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; thrum_impact_next(rows, &n, &at);) {
    const thrum_contact_row *row = at.row;
    const double h = at.bodies[0]->dt, end = row->gap + h * (row->speed - 0.5 * row->gained);
    const bool struck =
        at.bodies[0]->impact.struck || (at.bodies[1] != NULL && at.bodies[1]->impact.struck);
    // what the loads add in a step is not much
    if (struck && row->gap < 0.0 && end < -h * fabs(row->gained))
      return true;
  }
  return false;
}
