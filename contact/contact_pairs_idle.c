/* Candidates that wait without a row: places of slow bodies that are apart, did not touch before
 * and bear nothing in this step. Of two faces that lie on each other these are most.
 *
 * A row without a force changes nothing. So none is made while the gap that it would have at the
 * end of the step,
 *
 *   g' = g + n (x_a' - x_a - x_b' + x_b),
 *
 * is not below 0 as the bodies move under the forces of all rows; where it is, the row is made, and
 * all are solved again. What could strike is never left out (contact_impact.c).
 * Cost: 6 r a vertex and 60 operations a candidate, twice a step.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_idle.h"

#include <string.h>

#include "contact/contact_pairs_private.h"
#include "contact/contact_pairs_search.h"
#include "contact/contact_point.h"

/* How many of the four vertices are on the first side. */
static int first_side(const thrum_pair_candidate *c) {
  return c->key.kind == THRUM_PAIR_EDGES ? 2 : 1;
}

/* What a rotation over the step displaces points by, as a matrix for their arms: t x l(a) with the
 * lever of thrum_point_mean_arm, (t x a + t x (t x a) / 2) / (1 + t.t / 4). */
static void turn_matrix_of(const double turn[3], double matrix[9]) {
  const double square = thrum_dot3(turn, turn), scale = 1.0 / (1.0 + 0.25 * square);
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    double across[3];
    thrum_cross3(turn, unit, across);
    for (int n = 0; n < 3; n++)
      matrix[3 * n + axis] = scale * (across[n] + 0.5 * (turn[axis] * turn[n] - square * unit[n]));
  }
}

/* What moves a vertex of a member over the step, as the solve has it, found once a look [m]. */
static const double *way_of(thrum_pairs_run *run, int64_t member, int64_t vertex) {
  const int64_t index = run->view.first_vertex[member] + vertex;
  double *way = run->view.solved_ways + 3 * index;
  if (run->view.solved_way_known[index])
    return way;
  const thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  thrum_point_shape(body, view.rows + 3 * vertex * skin->rank, body->view.moved, way);

  // by the body as a whole
  double arm[3], turned[3];
  thrum_subtract3(thrum_pairs_place(run, member, vertex), body->centre, arm);
  thrum_apply3(body->turn_matrix, arm, turned);
  for (int axis = 0; axis < 3; axis++)
    way[axis] += body->moved[axis] + turned[axis];
  run->view.solved_way_known[index] = 1;
  return way;
}

void thrum_pairs_look_again(thrum_pairs_run *run) {
  memset(run->view.solved_way_known, 0,
         (size_t)run->view.first_vertex[run->count] * sizeof *run->view.solved_way_known);
  for (int64_t n = 0; n < run->count; n++)
    turn_matrix_of(run->view.runs[n].turned, run->view.runs[n].turn_matrix);
}

/* The point halfway between the two places at the start of the step, where a force would act. */
static void middle_of(thrum_pairs_run *run, const thrum_pair_candidate *c, double middle[3]) {
  memset(middle, 0, 3 * sizeof *middle);
  for (int n = 0; n < 4; n++) {
    const int side = n >= first_side(c);
    const double *place = thrum_pairs_place(run, c->members[side], c->vertices[n]);
    for (int axis = 0; axis < 3; axis++)
      middle[axis] += 0.5 * c->weights[n] * place[axis];
  }
}

/* The levers are those of the places, where a row has that of the middle between them: along the
 * normal both move by the same. */
bool thrum_pairs_closes(thrum_pairs_run *run, const thrum_pair_candidate *c, double thickness) {
  double gap = c->apart - thickness;
  for (int n = 0; n < 4; n++) {
    const int side = n >= first_side(c);
    const double weight = side == 0 ? c->weights[n] : -c->weights[n];
    gap += weight * thrum_dot3(c->normal, way_of(run, c->members[side], c->vertices[n]));
  }
  return !(gap >= 0.0);
}

/* May the places strike each other, by the motion of the bodies as a whole? What a step adds to
 * their speed is no impact. */
static bool may_strike(thrum_pairs_run *run, const thrum_pair_candidate *c) {
  double middle[3], speed = 0.0, way = 0.0;
  middle_of(run, c, middle);

  // along the normal, how fast the places part and how far the step has them part
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + c->members[side];
    const thrum_translation *translation = body->environment->translation;
    const double sign = side == 0 ? 1.0 : -1.0;
    double arm[3], spun[3], turned[3];
    thrum_subtract3(middle, body->centre, arm);
    thrum_cross3(body->spin, arm, spun);
    thrum_cross3(body->turned, arm, turned);
    for (int axis = 0; axis < 3; axis++) {
      const double along = sign * c->normal[axis];
      speed += along * (spun[axis] + (translation ? translation->velocity[axis] : 0.0));
      way += along * (body->moved[axis] + turned[axis]);
    }
  }
  const double gained = 2.0 * (speed - way / run->view.runs[c->members[0]].dt);
  return speed < 0.0 && -speed > THRUM_RESTING * gained;
}

/* Did one of the touches of the last step have the first place of a candidate? */
static bool touched_before(const thrum_pairs_run *run, const thrum_pair_candidate *c) {
  thrum_pair_key key = c->key;
  key.second = -1;
  const int64_t at = thrum_pairs_find_before(run, &key);
  if (at == run->history->before_count)
    return false;
  key.second = run->view.before[at].key.second;
  return thrum_pair_compare(&run->view.before[at].key, &key) == 0;
}

bool thrum_pairs_is_idle(thrum_pairs_run *run, const thrum_pair_candidate *c, double thickness) {
  return c->slow && !run->moved && c->apart >= thickness && !touched_before(run, c) &&
         !may_strike(run, c);
}
