/* Which points may touch what in a step, and the rows of those and of the pulls (docs/contact.md).
 *
 * Broad phase: no point is further from its place at rest than reach = sum_i e_i (|q_i| + |dq_i|),
 * e the largest displacement of a point under a unit of q_i; a signed distance changes by no more
 * than a point moves. First all points against an obstacle by their sphere, then each by its place
 * at rest; of what is left the displacements are evaluated. A point that ends inside is a row; it
 * meets the plane through where it enters.
 * Cost: r for the body, about 20 operations a point and obstacle near the body, 6 r a point near an
 * obstacle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_point.h"
#include "runtime/contact/contact_private.h"
#include "runtime/contact/contact_row.h"
#include "runtime/contact/obstacle_private.h"

#define ENTRY_HALVINGS 24

/* A point in a step. */
typedef struct moving_point {
  const double *rows; /* three rows of U */
  double start[3];    /* [m] */
  double arm[3];      /* about the centre of mass [m] */
  double lever[3];    /* about halfway [m] */
  double unloaded[3]; /* displacement without contact and pulls [m] */
  double likely[3];   /* with the pulls alone [m] */
} moving_point;

static const double *rest_of(const thrum_contact_run *run, int64_t point) {
  return run->model->vertices + 3 * (int64_t)run->view.vertices[point];
}

static moving_point point_of(const thrum_contact_run *run, int64_t point) {
  moving_point made = {.rows = thrum_point_rows(run, point)};
  thrum_point_start(run, made.rows, rest_of(run, point), made.start);
  thrum_point_lever(run, made.start, made.arm, made.lever);
  thrum_point_unloaded(run, made.rows, made.lever, made.unloaded);
  if (run->contact->pull_count > 0)
    thrum_point_moved(run, made.rows, made.lever, run->view.moved, made.likely);
  else
    memcpy(made.likely, made.unloaded, sizeof made.unloaded);
  return made;
}

/* The touch of the step before, NULL where there was none. Rows ask in ascending order, so *from
 * only moves forward. */
static const thrum_touching *touch_before(const thrum_contact_run *run, int32_t point,
                                          int32_t obstacle, int32_t face, int64_t *from) {
  for (; *from < run->contact->touch_count; ++*from) {
    const thrum_touching *touch = run->view.touches + *from;
    if (touch->point > point)
      return NULL;
    if (touch->point < point || touch->obstacle < obstacle ||
        (touch->obstacle == obstacle && touch->face < face))
      continue;
    return touch->obstacle == obstacle && touch->face == face ? touch : NULL;
  }
  return NULL;
}

/* Gap at the start of a point that ends inside, linear on its way to where it enters: the plane of
 * a curved obstacle that the step meets. */
static double entry_gap(const thrum_obstacle *obstacle, int32_t face, const double start[3],
                        const double way[3], double gap, double normal[3]) {
  if (gap <= 0.0 || obstacle->shape == THRUM_OBSTACLE_PLANE)
    return gap;

  // bisection for where the way crosses the face
  double outside = 0.0, inside = 1.0, x[3];
  for (int n = 0; n < ENTRY_HALVINGS; n++) {
    const double middle = 0.5 * (outside + inside);
    double unused[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = start[axis] + middle * way[axis];
    if (thrum_obstacle_face_gap(obstacle, face, x, unused) < 0.0)
      inside = middle;
    else
      outside = middle;
  }
  for (int axis = 0; axis < 3; axis++)
    x[axis] = start[axis] + inside * way[axis];

  // the plane through that point, followed back to the start
  const double depth = thrum_obstacle_face_gap(obstacle, face, x, normal);
  return fmax(depth - inside * thrum_dot3(normal, way), 0.0);
}

/* Fills a row whose touch and gap are set; `before` is the same touch in the last step, or NULL. */
static void fill_row(const thrum_contact_run *run, const moving_point *point,
                     const thrum_obstacle *obstacle, const thrum_touching *before,
                     thrum_contact_row *row) {
  const double h = run->dt, area = run->view.areas[row->touch.point];
  const double pressure = obstacle->stiffness > 0.0 ? obstacle->stiffness : run->contact->stiffness;

  // how the point answers to a force
  memcpy(row->lever, point->lever, sizeof row->lever);
  thrum_point_response(run, point->rows, row->lever, row->response);
  thrum_contact_row_respond(row);

  // the law: stiffness and damping are per area
  row->stiffness = pressure * area;
  row->damping = obstacle->damping * area / h;
  row->restitution = obstacle->restitution;
  row->friction = obstacle->friction;

  // what overlaps before the first step was put there, so its energy is a gift
  if (run->contact->fresh)
    row->touch.stored = thrum_contact_energy(row->stiffness, row->gap);

  // a touch that goes on keeps its forces and no more energy than its spring can hold
  if (before) {
    row->touch.towards = before->towards;
    row->touch.force = before->force;
    memcpy(row->touch.friction, before->friction, sizeof before->friction);
    row->touch.approach = before->approach;
    row->touch.stored = fmin(before->stored, thrum_contact_energy(row->stiffness, row->gap));
  }

  // velocity and displacement relative to the obstacle
  double velocity[3], unloaded[3];
  thrum_point_velocity(run, point->rows, point->arm, velocity);
  for (int axis = 0; axis < 3; axis++) {
    row->drift[axis] = h * obstacle->velocity[axis];
    velocity[axis] -= obstacle->velocity[axis];
    unloaded[axis] = point->unloaded[axis] - row->drift[axis];
  }
  thrum_contact_row_approach(row, h, velocity, unloaded);
}

/* Does a displacement end inside? `way` gets it relative to the obstacle. */
static bool enters(const thrum_contact_run *run, const thrum_obstacle *obstacle, int32_t face,
                   const moving_point *point, const double displacement[3], double way[3]) {
  double end[3], unused[3];
  for (int axis = 0; axis < 3; axis++) {
    way[axis] = displacement[axis] - run->dt * obstacle->velocity[axis];
    end[axis] = point->start[axis] + way[axis];
  }
  return thrum_obstacle_face_gap(obstacle, face, end, unused) < 0.0;
}

/* Adds the row of a point and a face where it may touch in this step. */
static void try_face(thrum_contact_run *run, const moving_point *point, int32_t index,
                     int32_t number, int32_t face, int64_t *from) {
  const thrum_obstacle *obstacle = run->environment->obstacles + number;
  thrum_contact *contact = run->contact;
  double normal[3], way[3];

  // only a point that is or ends inside touches
  double gap = thrum_obstacle_face_gap(obstacle, face, point->start, normal);
  const bool ends_inside = enters(run, obstacle, face, point, point->unloaded, way) ||
                           enters(run, obstacle, face, point, point->likely, way);
  if (gap >= 0.0 && !ends_inside)
    return;

  // touch_max is the caller's limit: the report counts what it leaves out
  if (contact->row_count == contact->touch_max) {
    contact->dropped++;
    return;
  }

  // the row begins on the plane where the point enters
  gap = entry_gap(obstacle, face, point->start, way, gap, normal);
  thrum_contact_row *row = run->view.rows + contact->row_count;
  memset(row, 0, sizeof *row);
  row->touch.point = index;
  row->touch.obstacle = number;
  row->touch.face = face;
  memcpy(row->touch.normal, normal, sizeof normal);
  row->gap = gap;
  fill_row(run, point, obstacle, touch_before(run, index, number, face, from), row);
  // a point that is held cannot be pushed
  if (row->along > 0.0)
    contact->row_count++;
}

/* Bound of the distance of any point from its place at rest, now and at the end of the step. */
static double reach_of(const thrum_contact_run *run) {
  const double *unloaded = run->view.unloaded, *moved = run->view.moved;

  // the deformation, by the largest displacement of a point under each coordinate
  double own = 0.0, size = 0.0;
  for (int32_t i = 0; i < run->contact->rank; i++)
    own += run->view.extents[i] * (fabs(run->view.q[i]) + fmax(fabs(unloaded[i]), fabs(moved[i])));
  for (int n = 0; n < 9; n++)
    size += run->axes[n] * run->axes[n];
  own *= sqrt(size);

  // the rotation moves a point by its distance from the centre of mass, which lies within the
  // points' sphere or close to it
  const double turn = sqrt(fmax(thrum_dot3(run->unloaded_turn, run->unloaded_turn),
                                thrum_dot3(run->turned, run->turned)));
  return own + turn * (own + 2.0 * run->contact->radius * sqrt(size)) +
         sqrt(fmax(thrum_dot3(run->unloaded, run->unloaded), thrum_dot3(run->moved, run->moved)));
}

/* May any point of the body come near this obstacle? */
static bool near_body(const thrum_contact_run *run, const thrum_obstacle *obstacle, double reach) {
  double middle[3], unused[3], size = 0.0;
  thrum_apply3(run->axes, run->contact->middle, middle);
  for (int axis = 0; axis < 3; axis++)
    middle[axis] += run->origin[axis];
  for (int n = 0; n < 9; n++)
    size += run->axes[n] * run->axes[n];
  return thrum_obstacle_gap(obstacle, middle, unused) <= reach + run->contact->radius * sqrt(size);
}

/* Rows of all points and obstacles. */
static void add_rows(thrum_contact_run *run, double reach) {
  const thrum_contact_environment *environment = run->environment;
  int64_t from = 0;
  for (int64_t index = 0; index < run->contact->point_count; index++) {

    // displacements are evaluated only for a point near an obstacle
    moving_point point;
    bool evaluated = false;
    double rest[3], unused[3];
    thrum_point_rest(run, rest_of(run, index), rest);

    // each obstacle within reach, face by face
    for (int64_t number = 0; number < environment->obstacle_count; number++) {
      const thrum_obstacle *obstacle = environment->obstacles + number;
      const double moved = run->dt * sqrt(thrum_dot3(obstacle->velocity, obstacle->velocity));
      if (thrum_obstacle_gap(obstacle, rest, unused) > reach + moved)
        continue;
      if (!evaluated)
        point = point_of(run, index);
      evaluated = true;
      for (int32_t face = 0; face < thrum_obstacle_faces(obstacle); face++)
        try_face(run, &point, (int32_t)index, (int32_t)number, face, &from);
    }
  }
}

/* Sets the gaps up to which springs push. */
static void raise_ceilings(thrum_contact_run *run) {
  const thrum_row_list list = thrum_rows_of(run);
  const double share = thrum_rows_excess(&list);
  for (int64_t n = 0; n < run->contact->row_count; n++)
    run->view.rows[n].ceiling = thrum_contact_row_ceiling(run->view.rows + n, run->dt, share);
}

void thrum_contact_rows(thrum_contact_run *run) {
  const thrum_contact_environment *environment = run->environment;
  const double reach = reach_of(run);
  bool any = false;
  run->contact->row_count = 0;

  // most steps are far from everything: one sphere of all points answers for them
  for (int64_t n = 0; n < environment->obstacle_count && !any; n++) {
    const thrum_obstacle *o = environment->obstacles + n;
    any = near_body(run, o, reach + run->dt * sqrt(thrum_dot3(o->velocity, o->velocity)));
  }
  if (any)
    add_rows(run, reach);
  raise_ceilings(run);
}

void thrum_contact_release(thrum_contact_run *run) {
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    thrum_contact_row *row = run->view.rows + n;
    row->ceiling = fmin(row->ceiling, row->gap + 0.5 * run->dt * fmin(row->speed, 0.0));
    row->friction = 0.0;
  }
}
