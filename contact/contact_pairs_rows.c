/* The rows of a step between bodies: what two places that may touch say to the solve
 * (docs/contact.md).
 *
 * The gap of a row is the distance less the thickness. Its spring is as stiff as the softer body
 * over the thickness, and stiffer where that would not stop the approach within half of it:
 *
 *   k = max(A E / t, m (2 v / t)^2),   m = h^2 / (2 n G n),
 *
 * with v the speed of the approach and m the mass that the places show in the step. Whatever
 * restitution says, a spring pushes until the depth is below half the thickness.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_rows.h"

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"
#include "contact/contact_pairs_idle.h"
#include "contact/contact_pairs_private.h"
#include "contact/contact_pairs_search.h"
#include "contact/contact_point.h"
#include "contact/contact_rows.h"

#define DEEPEST 0.5 /* of the thickness: springs push up to here whatever restitution says */

/* How many of the four points are on the first side. */
static int first_side(const thrum_pair_candidate *c) {
  return c->key.kind == THRUM_PAIR_EDGES ? 2 : 1;
}

/* Room for the three rows of U of a side of a row. */
static double *room_of(const thrum_pairs_run *run, const thrum_pair_row *row, int side) {
  const int64_t index = row - run->view.rows;
  return run->view.row_basis + (2 * index + side) * 3 * run->pairs->rank_max;
}

/* The point of one side: its rows of U, where its way starts, and the area that it stands for; the
 * gap becomes that at the start of the way. */
static double fill_side(thrum_pairs_run *run, const thrum_pair_candidate *c, int side,
                        thrum_pair_row *row) {
  const int from = side == 0 ? 0 : first_side(c), to = side == 0 ? first_side(c) : 4;
  const thrum_skin *skin = run->members[c->members[side]].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const int64_t r = skin->rank;
  double *restrict basis = room_of(run, row, side), area = 0.0;
  row->basis[side] = NULL;
  for (int n = from; n < to; n++) {
    const double weight = c->weights[n];
    if (weight == 0.0)
      continue;
    const double *restrict rows = view.rows + 3 * (int64_t)c->vertices[n] * r;
    const double *place = thrum_pairs_place(run, c->members[side], c->vertices[n]);
    // a vertex has its own rows in the skin, to which weights of rounding beside it add nothing
    if (row->basis[side] == NULL && weight == 1.0) {
      row->basis[side] = rows;
    } else if (row->basis[side] == NULL) {
      for (int64_t i = 0; i < 3 * r; i++)
        basis[i] = weight * rows[i];
      row->basis[side] = basis;
    } else if (row->basis[side] == basis) {
      for (int64_t i = 0; i < 3 * r; i++)
        basis[i] += weight * rows[i];
    }
    for (int axis = 0; axis < 3; axis++)
      row->starts[side][axis] += weight * (place[axis] + place[6 + axis]);
    if (!thrum_pairs_is_own(row))
      row->row.gap += (side == 0 ? weight : -weight) * thrum_dot3(c->normal, place + 6);
    area += weight * view.areas[c->vertices[n]];
  }
  return area;
}

/* Puts into the row how two places of one body move against each other, and their mean, in place of
 * the rows of U of both. */
static void fill_own(const thrum_pairs_run *run, thrum_pair_row *row) {
  const int64_t count = 3 * run->members[row->members[0]].skin->rank;
  double *apart = room_of(run, row, 0), *mean = room_of(run, row, 1);
  for (int64_t i = 0; i < count; i++) {
    const double first = row->basis[0][i], second = row->basis[1][i];
    apart[i] = first - second;
    mean[i] = second + 0.5 * apart[i];
  }
  row->basis[0] = apart;
  row->basis[1] = mean;
}

/* The touch that a row goes on from: the same, or else one of the same vertex or edge that no other
 * row goes on from; NULL where there is none. */
static const thrum_pair_touching *touch_before(const thrum_pairs_run *run,
                                               const thrum_pair_row *row, bool exact) {
  // the first touch that does not come before the row's first place
  thrum_pair_key key = row->key;
  if (!exact)
    key.second = -1;
  for (int64_t from = thrum_pairs_find_before(run, &key); from < run->history->before_count;
       from++) {
    const thrum_pair_touching *touch = run->view.before + from;
    key.second = touch->key.second;
    if (thrum_pair_compare(&touch->key, &key) != 0)
      return NULL;
    if (exact ? touch->key.second == row->key.second : !run->view.taken[from])
      return run->view.taken[from] ? NULL : touch;
    if (exact)
      return NULL;
  }
  return NULL;
}

/* Goes on from a touch of the last step. */
static void go_on(thrum_pairs_run *run, thrum_pair_row *row, bool exact) {
  const thrum_pair_touching *before = row->known ? NULL : touch_before(run, row, exact);
  if (before == NULL)
    return;
  thrum_touching *touch = &row->row.touch;
  run->view.taken[before - run->view.before] = 1;
  row->known = 1;
  touch->force = before->force;
  touch->stored = before->stored;

  // an approach lasts until the point moves away, and keeps its largest speed
  if (row->row.speed > 0.0)
    touch->approach = before->approach;
  else if (before->towards)
    touch->approach = fmax(before->approach, touch->approach);
  if (row->row.speed == 0.0)
    touch->towards = before->towards;

  // friction stays in the plane across the normal of now
  const double along = thrum_dot3(before->friction, touch->normal);
  for (int axis = 0; axis < 3; axis++)
    touch->friction[axis] = before->friction[axis] - along * touch->normal[axis];
}

/* The arm of one side of a row about its body's centre of mass. The force acts halfway between the
 * two points (contact_pairs_solve.c), so places that are near meet there: with arms to their own
 * ends, the torque of friction would differ from what is solved for by half of the thickness times
 * it, in each step. Places that are still far apart do not meet at the middle of their way. */
static void arm_of(const thrum_pairs_run *run, const thrum_pair_row *row, int side, double arm[3]) {
  const thrum_contact_run *body = run->view.runs + row->members[side];
  double apart[3];
  thrum_subtract3(row->starts[1 - side], row->starts[side], apart);
  thrum_subtract3(row->starts[side], body->centre, arm);
  if (!thrum_pairs_is_own(row) && sqrt(thrum_dot3(apart, apart)) > THRUM_NEAR * row->thickness)
    return;
  for (int axis = 0; axis < 3; axis++)
    arm[axis] += 0.5 * apart[axis];
}

/* The levers with which the rotations that are predicted displace the points exactly. Two places of
 * one body need that of the middle between them alone, which says where the force acts. */
static void fill_levers(const thrum_pairs_run *run, thrum_pair_row *row) {
  for (int side = thrum_pairs_is_own(row) ? 1 : 0; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + row->members[side];
    double arm[3];
    arm_of(run, row, side, arm);
    thrum_point_mean_arm(run->solved ? body->turned : body->unloaded_turn, arm,
                         side == 0 ? row->row.lever : row->lever);
  }
}

/* How the two points answer to a force between them, at their levers. */
static void fill_response(const thrum_pairs_run *run, thrum_pair_row *row) {
  thrum_contact_row *of = &row->row;
  memset(of->response, 0, sizeof of->response);
  if (thrum_pairs_is_own(row)) {
    thrum_shape_response(run->view.runs + row->members[0], thrum_pairs_basis(row, 0), of->response);
    thrum_contact_row_respond(of);
    return;
  }

  // the responses of both bodies add up: the force acts on one and against the other
  for (int side = 0; side < 2; side++) {
    const double *lever = side == 0 ? of->lever : row->lever;
    double response[9];
    thrum_point_response(run->view.runs + row->members[side], thrum_pairs_basis(row, side), lever,
                         response);
    for (int n = 0; n < 9; n++)
      of->response[n] += response[n];
  }

  thrum_contact_row_respond(of);
}

/* How the two points move against each other. */
static void fill_motion(thrum_pairs_run *run, const thrum_pair_row *row, double velocity[3],
                        double unloaded[3]) {
  memset(velocity, 0, 3 * sizeof *velocity);
  memset(unloaded, 0, 3 * sizeof *unloaded);
  if (thrum_pairs_is_own(row)) {
    const thrum_contact_run *body = run->view.runs + row->members[0];
    thrum_point_shape(body, thrum_pairs_basis(row, 0), body->view.p, velocity);
    thrum_point_shape(body, thrum_pairs_basis(row, 0), body->view.unloaded, unloaded);
    return;
  }
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + row->members[side];
    const double *basis = thrum_pairs_basis(row, side), sign = side == 0 ? 1.0 : -1.0;
    double arm[3], other[3], v[3], d[3];
    arm_of(run, row, side, arm);

    // before a solve the levers of the row are those without forces
    const double *lever = side == 0 ? row->row.lever : row->lever;
    if (run->solved) {
      thrum_point_mean_arm(body->unloaded_turn, arm, other);
      lever = other;
    }
    thrum_point_motion(body, basis, arm, lever, v, d);
    for (int axis = 0; axis < 3; axis++) {
      velocity[axis] += sign * v[axis];
      unloaded[axis] += sign * d[axis];
    }
  }
}

void thrum_pairs_refresh(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    // a step that is made again has the levers that the last attempt was booked with
    if (!run->again)
      fill_levers(run, run->view.rows + n);
    fill_response(run, run->view.rows + n);
  }
}

/* The solid that a candidate is at; NULL where both are bodies. */
static const thrum_contact_solid *solid_of(const thrum_pairs_run *run,
                                           const thrum_pair_candidate *c) {
  const thrum_contact_solid *first = run->members[c->members[0]].solid;
  return first ? first : run->members[c->members[1]].solid;
}

/* The row of a candidate; false where nothing can move either place. */
static bool fill_row(thrum_pairs_run *run, const thrum_pair_candidate *c, thrum_pair_row *row) {
  // what the search knows
  memset(row, 0, sizeof *row);
  row->key = c->key;
  memcpy(row->members, c->members, sizeof row->members);
  memcpy(row->row.touch.normal, c->normal, sizeof c->normal);
  const thrum_skin *skins[2] = {run->members[c->members[0]].skin, run->members[c->members[1]].skin};
  row->thickness = thrum_pairs_thickness(run->pairs, skins[0], skins[1]);
  row->row.gap = c->apart - row->thickness;

  // how the two places move
  const double first = fill_side(run, c, 0, row), second = fill_side(run, c, 1, row);
  double velocity[3], unloaded[3];
  if (thrum_pairs_is_own(row))
    fill_own(run, row);
  fill_levers(run, row);
  fill_response(run, row);
  fill_motion(run, row, velocity, unloaded);

  // the law between them: a spring as stiff as the softer body's material over the thickness
  const thrum_contact_solid *solid = solid_of(run, c);
  row->row.friction = solid ? solid->friction : run->pairs->friction;
  row->row.restitution = solid ? solid->restitution : run->pairs->restitution;
  const double area = c->key.kind == THRUM_PAIR_EDGES ? fmin(first, second) : first;
  const double harder =
      row->row.restitution < 1.0 ? 10.0 * THRUM_HARDER * THRUM_PAIRS_THICKNESS : 1.0;
  row->row.stiffness = harder * area * fmin(skins[0]->young, skins[1]->young) / row->thickness;
  const double settling =
      fmax(run->view.runs[row->members[0]].settling, run->view.runs[row->members[1]].settling);
  thrum_contact_row_approach(&row->row, run->view.runs[row->members[0]].dt, settling, velocity,
                             unloaded);
  return row->row.along > 0.0 && isfinite(row->row.along);
}

/* Stops the approach of a row within half the thickness, also one that the bodies press on in this
 * step alone, and lets it keep no more energy than its spring can hold. */
static void stiffen(const thrum_pairs_run *run, thrum_pair_row *row) {
  const double h = run->view.runs[row->members[0]].dt;
  thrum_contact_row *of = &row->row;
  const double pressed = 0.5 * of->gained - of->speed;
  const double rate = 2.0 * fmax(of->touch.approach, pressed) / row->thickness;
  of->stiffness = fmax(of->stiffness, 0.5 * h * h / of->along * rate * rate);
  of->stiffness = fmin(of->stiffness, THRUM_CONTACT_STIFFNESS_MAX);
  of->touch.stored = fmin(of->touch.stored, thrum_contact_energy(of->stiffness, of->gap));
}

/* The gap up to which the spring of each row from `had` on pushes, but at least to half the
 * thickness. The excess of depth is that of the rows which the step begins with: rows that are made
 * later change no ceiling, and forces that are solved for are no forces of the last step. */
static void raise_ceilings(thrum_pairs_run *run, int64_t had) {
  if (had == 0) {
    const thrum_row_list list = thrum_pairs_rows_of(run);
    run->excess = thrum_rows_excess(&list);
  }
  for (int64_t n = had; n < run->row_count; n++) {
    thrum_pair_row *pair = run->view.rows + n;
    const double h = run->view.runs[pair->members[0]].dt;
    pair->row.ceiling =
        fmax(thrum_contact_row_ceiling(&pair->row, h, run->excess), -DEEPEST * pair->thickness);
  }
}

/* Is there a row with this key, or for a rim with this vertex, among the first `count`, which
 * ascend by their keys? */
static bool has_row(const thrum_pairs_run *run, int64_t count, const thrum_pair_candidate *c) {
  for (int64_t n = 0; n < count; n++) {
    const thrum_pair_key *key = &run->view.rows[n].key;
    if (thrum_pair_compare(key, &c->key) == 0)
      return true;
    if (!c->inside && key->kind == c->key.kind && key->first == c->key.first &&
        key->bodies[0] == c->key.bodies[0] && key->bodies[1] == c->key.bodies[1])
      return true;
  }
  return false;
}

/* Makes the row of a candidate. touch_max is the caller's limit: the report counts what it leaves
 * out. */
static void add_row(thrum_pairs_run *run, const thrum_pair_candidate *c) {
  if (run->row_count == run->pairs->touch_max)
    run->history->dropped++;
  else
    run->row_count += fill_row(run, c, run->view.rows + run->row_count);
}

/* What rows from `had` on start from; returns how many there are. */
static int64_t begin_rows(thrum_pairs_run *run, int64_t had) {
  // what was there before goes on, first where it was, then where it has slid to
  for (int pass = 0; pass < 2; pass++)
    for (int64_t n = had; n < run->row_count; n++)
      go_on(run, run->view.rows + n, pass == 0);
  for (int64_t n = had; n < run->row_count; n++)
    stiffen(run, run->view.rows + n);
  raise_ceilings(run, had);
  return run->row_count - had;
}

/* The thickness between the places of a candidate [m]. */
static double thickness_of(const thrum_pairs_run *run, const thrum_pair_candidate *c) {
  return thrum_pairs_thickness(run->pairs, run->members[c->members[0]].skin,
                               run->members[c->members[1]].skin);
}

int64_t thrum_pairs_add_rows(thrum_pairs_run *run) {
  const int64_t had = run->row_count;
  run->idle_count = 0;
  for (int64_t n = 0; n < run->candidate_count; n++) {
    const int32_t index = run->view.order[n];
    const thrum_pair_candidate *c = run->view.candidates + index;
    if (had > 0 && has_row(run, had, c))
      continue;
    if (thrum_pairs_is_idle(run, c, thickness_of(run, c)))
      run->view.idle[run->idle_count++] = index;
    else
      add_row(run, c);
  }
  return begin_rows(run, had);
}

int64_t thrum_pairs_wake(thrum_pairs_run *run, bool all) {
  const int64_t had = run->row_count, waited = run->idle_count;
  if (waited == 0)
    return 0;

  // each that has to, in the order of their keys
  run->idle_count = 0;
  thrum_pairs_look_again(run);
  for (int64_t n = 0; n < waited; n++) {
    const int32_t index = run->view.idle[n];
    const thrum_pair_candidate *c = run->view.candidates + index;
    if (all || thrum_pairs_closes(run, c, thickness_of(run, c)))
      add_row(run, c);
    else
      run->view.idle[run->idle_count++] = index;
  }
  return run->row_count > had ? begin_rows(run, had) : 0;
}

bool thrum_pairs_wake_all(thrum_pairs_run *run, bool all) {
  bool any = thrum_pairs_wake(run, all) > 0;
  for (int64_t n = 0; n < run->count; n++)
    if (thrum_pairs_steps(run, n))
      any = thrum_contact_wake(run->view.runs + n, all) || any;
  return any;
}

void thrum_pairs_release(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    thrum_pair_row *pair = run->view.rows + n;
    thrum_contact_row *row = &pair->row;
    const double h = run->view.runs[pair->members[0]].dt;
    const double stop = row->gap + 0.5 * h * fmin(row->speed, 0.0);
    row->ceiling = fmin(row->ceiling, fmax(stop, fmin(-DEEPEST * pair->thickness, row->gap)));
    row->friction = 0.0;
  }
}
