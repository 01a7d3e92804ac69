/* Links between members of a step (thrum/link.h, docs/links.md): what joins two places or fixes
 * their directions to each other is solved with the touches, and then by steps that are made again
 * until it holds at their end.
 *
 * A place or direction x of a body with the rotation R goes from R u to R' u', with R' the Cayley
 * transform of theta times R. With the mean of both, its displacement is exactly
 *
 *   x' - x = moved + (1 + [theta]/2) R (u' - u) + theta x (R u + R' u')/2,                   (1)
 *
 * linear in what a solve can change. The forces act with the same rows and levers, so their work is
 * that of the force times the displacement, and their torques are about the mean place.
 *
 * Cost: 24 r a link and look, a factor of all conditions of a group once a step.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_link.h"

#include <math.h>
#include <string.h>

#include "contact/contact_point.h"
#include "core/linear_algebra/dense.h"
#include "core/state/state_layout.h"

#define REDUNDANT 1e-12 /* of a condition's own response: those that repeat stay solvable */
#define FAINT 1e-100 /* [N/m] below which a spring has no force, and no compliance, that counts */
#define SETTLING 2   /* steps in which a joint comes to rest, which no drift is counted of */

/* --- the two sides ---------------------------------------------------------------------------- */

static thrum_contact_run *body_of(const thrum_pairs_run *run, const thrum_link_run *link,
                                  int side) {
  return run->view.runs + link->link->sides[side].member;
}

static bool is_solid(const thrum_pairs_run *run, const thrum_link_run *link, int side) {
  return run->members[link->link->sides[side].member].solid != NULL;
}

/* Rows of U of a place or direction, as the body turns in the step. */
static double *basis_of(const thrum_pairs_run *run, const thrum_link_run *link, int side,
                        int32_t of) {
  const int64_t index = 2 * (link - run->view.links) + side;
  return run->view.link_basis + (index * THRUM_LINK_PLACES + of) * 3 * run->pairs->rank_max;
}

static const double *rest_of(const thrum_link_run *link, int side, int32_t of) {
  return link->link->sides[side].rest + 3 * of;
}

static const double *rows_of(const thrum_pairs_run *run, const thrum_link_run *link, int side,
                             int32_t of) {
  const double *rows = link->link->sides[side].rows;
  return rows ? rows + 3 * of * (int64_t)body_of(run, link, side)->contact->rank : NULL;
}

/* Displacement of a place or direction by what the solve or the step has moved, of the coordinates
 * d (rank). */
static void moved_of(const thrum_pairs_run *run, const thrum_link_run *link, int side, int32_t of,
                     const double *d, double out[3]) {
  const thrum_contact_run *body = body_of(run, link, side);
  const double *basis = basis_of(run, link, side, of), *lever = link->lever[side][of];
  if (of == 0)
    thrum_point_moved(body, basis, lever, d, out);
  else
    thrum_direction_moved(body, basis, lever, d, out);
}

/* Adds what a force on one condition moves on one side. */
static void push_side(thrum_pairs_run *run, const thrum_link_run *link, const thrum_link_row *row,
                      int side, double force) {
  thrum_contact_run *body = body_of(run, link, side);
  const int32_t of = row->of[side];
  const double *basis = basis_of(run, link, side, of), *lever = link->lever[side][of];
  const double *along = row->along[side];
  const double by[3] = {force * along[0], force * along[1], force * along[2]};
  if (of == 0)
    thrum_point_push(body, basis, lever, by);
  else
    thrum_direction_push(body, basis, lever, by);
}

/* The same as a load of the step. */
static void load_side(thrum_pairs_run *run, const thrum_link_run *link, const thrum_link_row *row,
                      int side) {
  thrum_contact_run *body = body_of(run, link, side);
  const int32_t of = row->of[side];
  const double *basis = basis_of(run, link, side, of), *lever = link->lever[side][of];
  const double *along = row->along[side], force = row->force;
  const double by[3] = {force * along[0], force * along[1], force * along[2]};
  if (of == 0)
    thrum_point_load(body, basis, lever, by);
  else
    thrum_direction_load(body, basis, lever, by);
}

/* Displacement along a condition on one side. */
static double along_side(const thrum_pairs_run *run, const thrum_link_run *link,
                         const thrum_link_row *row, int side, bool made) {
  const thrum_contact_run *body = body_of(run, link, side);
  double moved[3];
  moved_of(run, link, side, row->of[side], made ? body->view.made : body->view.moved, moved);
  return thrum_dot3(row->along[side], moved);
}

static double along_row(const thrum_pairs_run *run, const thrum_link_run *link,
                        const thrum_link_row *row, bool made) {
  return along_side(run, link, row, 0, made) + along_side(run, link, row, 1, made);
}

/* --- the start of a step ---------------------------------------------------------------------- */

/* Where a place or direction of a body begins, and how fast. */
static void open_place(const thrum_pairs_run *run, thrum_link_run *link, int side, int32_t of) {
  const thrum_contact_run *body = body_of(run, link, side);
  const double *rest = rest_of(link, side, of), *rows = rows_of(run, link, side, of);
  double *start = link->start[side][of], *velocity = link->velocity[side][of], turned[3];
  if (of == 0) {
    thrum_point_start(body, rows, rest, start);
    thrum_subtract3(start, body->centre, start);
    thrum_point_velocity(body, rows, start, velocity);
    return;
  }

  // a direction is where the body turns and deforms it to
  thrum_apply3(body->axes, rest, start);
  thrum_point_shape(body, rows, body->view.q, velocity);
  for (int axis = 0; axis < 3; axis++)
    start[axis] += velocity[axis];
  thrum_point_shape(body, rows, body->view.p, velocity);
  thrum_cross3(body->spin, start, turned);
  for (int axis = 0; axis < 3; axis++)
    velocity[axis] += turned[axis];
}

void thrum_links_open(thrum_pairs_run *run, thrum_link *links, int64_t count) {
  run->link_count = count;
  for (int64_t n = 0; n < count; n++) {
    memset(run->view.links + n, 0, sizeof run->view.links[n]);
    run->view.links[n].link = links + n;
    for (int side = 0; side < 2; side++)
      run->view.runs[links[n].sides[side].member].linked = true;
  }
}

bool thrum_links_join(const thrum_pairs_run *run, int64_t a, int64_t b) {
  for (int64_t n = 0; n < run->link_count; n++) {
    const thrum_link *link = run->view.links[n].link;
    const int64_t first = link->sides[0].member, second = link->sides[1].member;
    if (link->kind != THRUM_LINK_SPRING &&
        ((first == a && second == b) || (first == b && second == a)))
      return true;
  }
  return false;
}

/* --- conditions ------------------------------------------------------------------------------- */

/* The place of a side from that of the other: at the start or at the end of the step. */
static void apart(const thrum_pairs_run *run, const thrum_link_run *link, bool ended,
                  double out[3]) {
  const thrum_contact_run *a = body_of(run, link, 0), *b = body_of(run, link, 1);
  for (int axis = 0; axis < 3; axis++) {
    const double arms = ended ? link->end[0][0][axis] - link->end[1][0][axis]
                              : link->start[0][0][axis] - link->start[1][0][axis];
    const double moved = ended ? a->moved[axis] - b->moved[axis] : 0.0;
    out[axis] = a->centre[axis] - b->centre[axis] + moved + arms;
  }
}

/* A joint's condition that is open by `value` and opens at `rate` closes in one step; as it begins,
 * it comes to rest in two, without the oscillation that a velocity which does not fit would leave.
 */
static double closing(const thrum_link *link, double h, double value, double rate) {
  return link->steps == 0 ? 0.25 * h * rate - 0.5 * value : -value;
}

/* The next condition, with the force that it had. */
static thrum_link_row *new_row(thrum_link_run *link, int32_t first, int32_t second) {
  thrum_link_row *row = link->rows + link->row_count++;
  *row = (thrum_link_row){.force = row->force};
  row->of[0] = first;
  row->of[1] = second;
  return row;
}

/* Along a vector of the world, of the two places. */
static thrum_link_row *new_place_row(thrum_link_run *link, const double along[3]) {
  thrum_link_row *row = new_row(link, 0, 0);
  for (int axis = 0; axis < 3; axis++) {
    row->along[0][axis] = along[axis];
    row->along[1][axis] = -along[axis];
  }
  return row;
}

/* The law of a spring and damper along a row: force = -k open - rate displacement. */
static void fill_spring(thrum_link_row *row, double k, double open, double rate) {
  row->compliance = 1.0 / rate;
  row->target = -k * open / rate;
}

/* A spring with a length acts along the mean of its two directions, with the mean of its two
 * lengths; one without in all three directions. */
static void fill_springs(const thrum_pairs_run *run, thrum_link_run *link) {
  const thrum_link *of = link->link;
  const double h = body_of(run, link, 0)->dt, k = of->stiffness, c = of->damping;
  const bool world = is_solid(run, link, 0) || is_solid(run, link, 1);
  double before[3], after[3], mean[3];
  apart(run, link, false, before);
  apart(run, link, true, after);
  const double length = sqrt(thrum_dot3(before, before));
  const double sum = length + sqrt(thrum_dot3(after, after));

  // in all directions, with the damper too where no momentum has to be kept
  const double rate = 0.5 * k + (world ? c / h : 0.0);
  for (int axis = 0; axis < 3 && of->length == 0.0 && rate > FAINT; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    fill_spring(new_place_row(link, unit), k, before[axis], rate);
  }

  // along the spring
  const bool central = of->length > 0.0, damped = !world && c > 0.0;
  const double along = (central ? 0.5 * k : 0.0) + (central || damped ? c / h : 0.0);
  if (!(along > FAINT))
    return;
  for (int axis = 0; axis < 3; axis++)
    mean[axis] = sum > 0.0 ? (before[axis] + after[axis]) / sum : 0.0;
  fill_spring(new_place_row(link, mean), central ? k : 0.0, length - of->length, along);
}

/* The two places stay together. */
static void fill_ball(const thrum_pairs_run *run, thrum_link_run *link) {
  double open[3];
  apart(run, link, false, open);
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    const double rate = link->velocity[0][0][axis] - link->velocity[1][0][axis];
    new_place_row(link, unit)->target =
        closing(link->link, body_of(run, link, 0)->dt, open[axis], rate);
  }
}

/* A direction of the first side stays at a right angle to one of the second. Their product is
 * bilinear, so its change is exactly that along the means of both ends. */
static void fill_angle(const thrum_pairs_run *run, thrum_link_run *link, int32_t first,
                       int32_t second) {
  const double *a = link->start[0][first], *b = link->start[1][second];
  const double value = thrum_dot3(a, b), rate = thrum_dot3(link->velocity[0][first], b) +
                                                thrum_dot3(a, link->velocity[1][second]);
  thrum_link_row *row = new_row(link, first, second);
  for (int axis = 0; axis < 3; axis++) {
    row->along[0][axis] = 0.5 * (b[axis] + link->end[1][second][axis]);
    row->along[1][axis] = 0.5 * (a[axis] + link->end[0][first][axis]);
  }
  row->target = closing(link->link, body_of(run, link, 0)->dt, value, rate);
}

/* The conditions of a link as the step is predicted, or was made. */
static void fill_rows(const thrum_pairs_run *run, thrum_link_run *link) {
  const thrum_link_kind kind = link->link->kind;
  link->row_count = 0;
  if (kind == THRUM_LINK_SPRING)
    fill_springs(run, link);
  else
    fill_ball(run, link);

  // the first directions parallel, then the others
  if (kind == THRUM_LINK_HINGE || kind == THRUM_LINK_WELD) {
    fill_angle(run, link, 1, 2);
    fill_angle(run, link, 1, 3);
  }
  if (kind == THRUM_LINK_WELD)
    fill_angle(run, link, 2, 3);
}

/* --- aiming ----------------------------------------------------------------------------------- */

/* The rows of U of (1), in the axes of the body: R^T (1 + [theta]/2) R U. */
static void turn_rows(const thrum_contact_run *body, const double *rows, double *turned) {
  const int64_t rank = body->contact->rank;
  double half[3], own[3];
  thrum_apply3_transposed(body->axes, body->turned, own);
  for (int axis = 0; axis < 3; axis++)
    half[axis] = 0.5 * own[axis];
  for (int64_t i = 0; i < rank; i++) {
    const double u[3] = {rows[i], rows[rank + i], rows[2 * rank + i]};
    double across[3];
    thrum_cross3(half, u, across);
    for (int axis = 0; axis < 3; axis++)
      turned[axis * rank + i] = u[axis] + across[axis];
  }
}

/* The end of a place or direction under the coordinates' displacement d: the Cayley transform of
 * the rotation, of where it would be without. */
static void end_place(const thrum_pairs_run *run, thrum_link_run *link, int side, int32_t of,
                      const double *d) {
  const thrum_contact_run *body = body_of(run, link, side);
  const double *start = link->start[side][of];
  double *end = link->end[side][of], shape[3], mean[3], across[3];
  memcpy(shape, start, sizeof shape);
  if (link->link->sides[side].rows != NULL) {
    thrum_point_shape(body, rows_of(run, link, side, of), d, shape);
    for (int axis = 0; axis < 3; axis++)
      shape[axis] += start[axis];
  }

  // R' R^T x = x + theta x mean(x)
  thrum_point_mean_arm(body->turned, shape, mean);
  thrum_cross3(body->turned, mean, across);
  for (int axis = 0; axis < 3; axis++) {
    end[axis] = shape[axis] + across[axis];
    link->lever[side][of][axis] = 0.5 * (start[axis] + end[axis]);
  }
}

/* All of a link for the step as it is predicted, or as it was made. */
static void aim(const thrum_pairs_run *run, thrum_link_run *link, bool made) {
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = body_of(run, link, side);
    const double *d = made ? body->view.made : body->view.moved;
    for (int32_t of = 0; of < THRUM_LINK_PLACES; of++) {
      end_place(run, link, side, of, d);
      if (link->link->sides[side].rows != NULL)
        turn_rows(body, rows_of(run, link, side, of), basis_of(run, link, side, of));
    }
  }
  fill_rows(run, link);
}

/* Nothing has moved. */
static void clear(thrum_contact_run *body) {
  memset(body->view.moved, 0, (size_t)body->contact->rank * sizeof *body->view.moved);
  memset(body->moved, 0, sizeof body->moved);
  memset(body->turned, 0, sizeof body->turned);
}

/* Fills a column of the response: how all conditions move under a unit of force of one. */
static void fill_column(thrum_pairs_run *run, const thrum_link_run *link, const thrum_link_row *row,
                        int64_t column) {
  const int64_t size = run->link_rows;
  for (int side = 0; side < 2; side++)
    push_side(run, link, row, side, 1.0);
  int64_t at = 0;
  for (int64_t n = 0; n < run->link_count; n++)
    for (int32_t k = 0; k < run->view.links[n].row_count; k++)
      run->view.link_response[size * at++ + column] =
          along_row(run, run->view.links + n, run->view.links[n].rows + k, false);
  for (int side = 0; side < 2; side++)
    clear(body_of(run, link, side));

  // a condition that nothing can meet asks for nothing
  double *own = run->view.link_response + (size + 1) * column;
  *own = (*own + row->compliance) * (1.0 + REDUNDANT);
  if (!(*own > 0.0))
    *own = 1.0;
}

/* The response of all conditions to all, as its factors; false where it has none. */
static bool factor(thrum_pairs_run *run) {
  run->link_rows = 0;
  for (int64_t n = 0; n < run->link_count; n++)
    run->link_rows += run->view.links[n].row_count;

  // a member that could not begin its step has nothing to clear
  for (int64_t n = 0; n < run->link_count; n++)
    for (int side = 0; side < 2 && run->view.links[n].row_count > 0; side++)
      clear(body_of(run, run->view.links + n, side));

  int64_t column = 0;
  for (int64_t n = 0; n < run->link_count; n++)
    for (int32_t k = 0; k < run->view.links[n].row_count; k++)
      fill_column(run, run->view.links + n, run->view.links[n].rows + k, column++);
  return thrum_dense_factor(run->view.link_response, (int32_t)run->link_rows,
                            run->view.link_pivots);
}

/* Does the link hold in this step: are both of its members in it? */
static bool holds(const thrum_pairs_run *run, const thrum_link_run *link) {
  bool both = true;
  for (int side = 0; side < 2; side++)
    both = both &&
           (is_solid(run, link, side) || thrum_pairs_steps(run, link->link->sides[side].member));
  return both;
}

bool thrum_links_aim(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->link_count; n++) {
    thrum_link_run *link = run->view.links + n;
    link->row_count = 0;
    memset(link->rows, 0, sizeof link->rows);
    if (!holds(run, link))
      continue;
    for (int side = 0; side < 2; side++)
      for (int32_t of = 0; of < THRUM_LINK_PLACES; of++)
        open_place(run, link, side, of);
    aim(run, link, false);
  }
  return factor(run);
}

bool thrum_links_tie(const thrum_pairs_run *run, int64_t member) {
  for (int64_t n = 0; n < run->link_count; n++)
    for (int side = 0; side < 2; side++)
      if (run->view.links[n].row_count > 0 && !is_solid(run, run->view.links + n, side) &&
          run->view.links[n].link->sides[side].member == member)
        return true;
  return false;
}

/* --- the solve -------------------------------------------------------------------------------- */

double thrum_links_begin(thrum_pairs_run *run) {
  double largest = 0.0;
  for (int64_t n = 0; n < run->link_count; n++) {
    const thrum_link_run *link = run->view.links + n;
    for (int32_t k = 0; k < link->row_count; k++) {
      const thrum_link_row *row = link->rows + k;
      largest = fmax(largest, fabs(row->target) + fabs(along_row(run, link, row, false)));
      for (int side = 0; side < 2; side++)
        push_side(run, link, row, side, row->force);
    }
  }
  return largest;
}

double thrum_links_solve(thrum_pairs_run *run) {
  double *room = run->view.link_room, largest = 0.0;
  int64_t at = 0;
  if (run->link_rows == 0)
    return 0.0;

  // how far each condition is from its law
  for (int64_t n = 0; n < run->link_count; n++) {
    const thrum_link_run *link = run->view.links + n;
    for (int32_t k = 0; k < link->row_count; k++) {
      const thrum_link_row *row = link->rows + k;
      room[at] = row->target - row->compliance * row->force - along_row(run, link, row, false);
      largest = fmax(largest, fabs(room[at++]));
    }
  }

  // the forces that all of them together need for it
  thrum_dense_solve(run->view.link_response, (int32_t)run->link_rows, run->view.link_pivots, room);
  at = 0;
  for (int64_t n = 0; n < run->link_count; n++) {
    thrum_link_run *link = run->view.links + n;
    for (int32_t k = 0; k < link->row_count; k++, at++) {
      link->rows[k].force += room[at];
      for (int side = 0; side < 2; side++)
        push_side(run, link, link->rows + k, side, room[at]);
    }
  }
  return largest;
}

void thrum_links_gather(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->link_count; n++) {
    const thrum_link_run *link = run->view.links + n;
    for (int32_t k = 0; k < link->row_count; k++)
      for (int side = 0; side < 2; side++)
        load_side(run, link, link->rows + k, side);
  }
}

/* --- the step that was made ------------------------------------------------------------------- */

/* The work of a link's forces, with the rows that they acted with. */
static void measure(const thrum_pairs_run *run, thrum_link_run *link) {
  for (int side = 0; side < 2; side++) {
    link->work[side] = 0.0;
    for (int32_t k = 0; k < link->row_count; k++)
      link->work[side] += link->rows[k].force * along_side(run, link, link->rows + k, side, true);
  }
}

/* By how much its conditions are open, in parts of the bodies' size. */
static double open_share(const thrum_pairs_run *run, const thrum_link_run *link) {
  const double size =
      fmax(body_of(run, link, 0)->contact->diagonal, body_of(run, link, 1)->contact->diagonal);
  double largest = 0.0;
  for (int32_t k = 0; k < link->row_count; k++) {
    const thrum_link_row *row = link->rows + k;
    const double off = along_row(run, link, row, true) + row->compliance * row->force - row->target;
    largest = fmax(largest, row->of[0] == 0 && size > 0.0 ? fabs(off) / size : fabs(off));
  }
  return largest;
}

double thrum_links_look(thrum_pairs_run *run) {
  double largest = 0.0;
  for (int64_t n = 0; n < run->count; n++) {
    const thrum_contact_run *body = run->view.runs + n;
    if (!thrum_pairs_steps(run, n))
      continue;
    const double *q = thrum_state_view_of(body->state).q;
    for (int32_t i = 0; i < body->contact->rank; i++)
      body->view.made[i] = q[i] - body->view.q[i];
  }

  // what the forces did, then where the next ones would act
  for (int64_t n = 0; n < run->link_count; n++) {
    thrum_link_run *link = run->view.links + n;
    if (link->row_count == 0)
      continue;
    measure(run, link);
    aim(run, link, true);
    largest = fmax(largest, open_share(run, link));
  }
  return largest;
}

/* Energy of a spring that is `apart`. */
static double energy_of(const thrum_link *link, const double apart_by[3]) {
  const double longer = sqrt(thrum_dot3(apart_by, apart_by)) - link->length;
  return link->kind == THRUM_LINK_SPRING ? 0.5 * link->stiffness * (longer * longer) : 0.0;
}

/* Force and torque of the last step on the first side. */
static void report_forces(const thrum_link_run *link, thrum_link_report *report) {
  memset(report->force, 0, sizeof report->force);
  memset(report->torque, 0, sizeof report->torque);
  for (int32_t k = 0; k < link->row_count; k++) {
    const thrum_link_row *row = link->rows + k;
    double torque[3];
    thrum_cross3(link->lever[0][row->of[0]], row->along[0], torque);
    for (int axis = 0; axis < 3; axis++) {
      report->force[axis] += row->of[0] == 0 ? row->force * row->along[0][axis] : 0.0;
      report->torque[axis] += row->of[0] == 0 ? 0.0 : row->force * torque[axis];
    }
  }
}

/* Can the energies of a link in the step that was made be booked? */
static bool counts(const thrum_pairs_run *run, const thrum_link_run *link) {
  double after[3];
  apart(run, link, true, after);
  return thrum_contact_energy_counts(fabs(link->work[0]) + fabs(link->work[1]) +
                                     energy_of(link->link, after));
}

int64_t thrum_links_beyond(const thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->link_count; n++) {
    const thrum_link_run *link = run->view.links + n;
    if (link->row_count == 0 || counts(run, link))
      continue;

    // the body on which it did more work, for a solid is moved by none
    const double own = fabs(link->work[0]), others = fabs(link->work[1]);
    const bool first = is_solid(run, link, 1) || isnan(own) || others <= own;
    return link->link->sides[first && !is_solid(run, link, 0) ? 0 : 1].member;
  }
  return -1;
}

static void settle(const thrum_pairs_run *run, thrum_link_run *link) {
  thrum_link_report *report = &link->link->report;
  double before[3], after[3], driven = 0.0, work = 0.0;
  apart(run, link, false, before);
  apart(run, link, true, after);

  // work on the bodies = driven - stored - lost
  for (int side = 0; side < 2; side++) {
    work += is_solid(run, link, side) ? 0.0 : link->work[side];
    driven -= is_solid(run, link, side) ? link->work[side] : 0.0;
  }
  const double held = link->link->steps == 0 ? energy_of(link->link, before) : report->stored;
  report->stored = energy_of(link->link, after);
  report->driven += driven;
  report->lost += driven - work - (report->stored - held);

  // how well it holds
  report_forces(link, report);
  report->drift = link->link->kind == THRUM_LINK_SPRING ? 0.0 : sqrt(thrum_dot3(after, after));
  if (link->link->steps >= SETTLING)
    report->largest_drift = fmax(report->largest_drift, report->drift);
  link->link->steps++;
}

void thrum_links_settle(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->link_count; n++)
    if (run->view.links[n].row_count > 0)
      settle(run, run->view.links + n);
}
