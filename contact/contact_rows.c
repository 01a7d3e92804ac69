/* Which points may touch what in a step, and the rows of those and of the pulls (docs/contact.md).
 *
 * Broad phase: no point is further from its place at rest than reach = sum_i e_i (|q_i| + |dq_i|),
 * e the largest displacement of a point under a unit of q_i; a signed distance changes by no more
 * than a point moves. First all points against an obstacle by their sphere, then so many that
 * follow each other in the list, then each by its place at rest; of what is left the displacements
 * are evaluated. A point that ends inside is a row; it meets the plane through where it enters.
 * Cost: r for the body, about 10 operations a point of a body near an obstacle, 6 r a point near
 * one.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_rows.h"

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"
#include "contact/contact_point.h"
#include "contact/contact_row.h"
#include "contact/obstacle_private.h"

#define ENTRY_HALVINGS 24
#define TOGETHER 16         /* points that are first tested by one sphere */
#define ABOVE (1.0 + 1e-12) /* times a bound, whose rounding it is above */

/* A point in a step. */
typedef struct moving_point {
  const double *rows; /* three rows of U */
  double start[3];    /* on its way [m] */
  double shift[3];    /* from where it really is to there, where an impact has put it there [m] */
  double arm[3];      /* about the centre of mass [m] */
  double lever[3];    /* about halfway [m] */
  double unloaded[3]; /* displacement without contact and pulls [m] */
  double likely[3];   /* as a search has it, by the pulls or the forces of the last step [m] */
} moving_point;

static const double *rest_of(const thrum_contact_run *run, int64_t point) {
  return run->model->vertices + 3 * (int64_t)run->view.vertices[point];
}

static moving_point point_of(const thrum_contact_run *run, int64_t point) {
  moving_point made = {.rows = thrum_point_rows(run, point)};
  thrum_point_start(run, made.rows, rest_of(run, point), made.start);
  thrum_point_shift(run, made.rows, rest_of(run, point), made.start, made.shift);
  thrum_point_lever(run, made.start, made.arm, made.lever);
  thrum_point_unloaded(run, made.rows, made.lever, made.unloaded);
  if (run->foresees)
    thrum_point_sought(run, made.rows, made.lever, made.likely);
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

/* Pressure per depth [N/m^3]. What holds up a free body is its contact alone, so a surface that
 * nobody made soft gives way by far less than the body does. One that gives back all of an impact
 * stays soft enough for steps to resolve it. */
static double pressure_of(const thrum_contact_run *run, const thrum_obstacle *obstacle) {
  if (obstacle->stiffness > 0.0)
    return obstacle->stiffness;
  const double own = run->contact->stiffness;
  if (run->contact->springy || obstacle->damping > 0.0 || !(obstacle->restitution < 1.0) ||
      run->environment->translation == NULL)
    return own;
  return fmin(THRUM_HARDER * own, THRUM_CONTACT_STIFFNESS_MAX);
}

/* Fills a row whose touch and gap are set; `before` is the same touch in the last step, or NULL. */
static void fill_row(const thrum_contact_run *run, const moving_point *point,
                     const thrum_obstacle *obstacle, const thrum_touching *before,
                     thrum_contact_row *row) {
  const double h = run->dt, area = run->view.areas[row->touch.point];
  const double pressure = pressure_of(run, obstacle);

  // how the point answers to a force
  thrum_point_response(run, point->rows, row->lever, row->response);
  thrum_contact_row_respond(row);

  // the law: stiffness and damping are per area
  row->stiffness = pressure * area;
  row->damping = obstacle->damping * area / h;
  row->restitution = obstacle->restitution;
  row->friction = obstacle->friction;

  // what overlaps before the first step was put there, so its energy is a gift
  if (run->contact->fresh && !run->impact.struck)
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
    velocity[axis] -= obstacle->velocity[axis];
    unloaded[axis] = point->unloaded[axis] - row->drift[axis];
  }
  thrum_contact_row_approach(row, h, run->settling, velocity, unloaded);
}

/* Where a point really is at the start of the step. */
static void place_of(const moving_point *point, double at[3]) {
  for (int axis = 0; axis < 3; axis++)
    at[axis] = point->start[axis] - point->shift[axis];
}

/* Does a displacement end inside? `way` gets it relative to the obstacle, from where the point
 * really is. */
static bool enters(const thrum_contact_run *run, const thrum_obstacle *obstacle, int32_t face,
                   const moving_point *point, const double displacement[3], double way[3]) {
  // impacts of bodies as a whole take in what is about to strike
  const double soon = run->environment->translation ? THRUM_SOON : 1.0;
  double end[3], unused[3];
  place_of(point, end);
  for (int axis = 0; axis < 3; axis++) {
    way[axis] = point->shift[axis] + displacement[axis] - run->dt * obstacle->velocity[axis];
    end[axis] += soon * way[axis];
  }
  return thrum_obstacle_face_gap(obstacle, face, end, unused) < 0.0;
}

/* May a point that is outside now and that the forces of the last step keep there wait without a
 * row? One that touched may not, nor may one that could strike. */
static bool may_wait(const thrum_contact_run *run, const thrum_obstacle *obstacle,
                     const moving_point *point, const double normal[3]) {
  if (run->all || run->impact.struck || !(obstacle->restitution < 1.0))
    return false;
  double velocity[3], way[3];
  thrum_point_velocity(run, point->rows, point->arm, velocity);
  thrum_subtract3(velocity, obstacle->velocity, velocity);
  for (int axis = 0; axis < 3; axis++)
    way[axis] = point->unloaded[axis] - run->dt * obstacle->velocity[axis];
  return !thrum_contact_strikes(thrum_dot3(velocity, normal), thrum_dot3(way, normal), run->dt,
                                run->settling);
}

/* A row of a point and a face, without its law. */
static void begin_row(const thrum_contact_run *run, const moving_point *point,
                      const thrum_touching *touch, double gap, thrum_contact_row *row) {
  const thrum_obstacle *obstacle = run->environment->obstacles + touch->obstacle;
  memset(row, 0, sizeof *row);
  row->touch = *touch;
  row->gap = gap + thrum_dot3(touch->normal, point->shift);
  memcpy(row->lever, point->lever, sizeof row->lever);
  for (int axis = 0; axis < 3; axis++)
    row->drift[axis] = run->dt * obstacle->velocity[axis];
}

/* Adds the row of a point and a face where it may touch in this step. */
static void try_face(thrum_contact_run *run, const moving_point *point, int32_t index,
                     int32_t number, int32_t face, int64_t *from) {
  const thrum_obstacle *obstacle = run->environment->obstacles + number;
  thrum_contact *contact = run->contact;
  thrum_touching touch = {.point = index, .obstacle = number, .face = face};
  double way[3], other[3], at[3];

  // only a point that is or ends inside touches
  place_of(point, at);
  double gap = thrum_obstacle_face_gap(obstacle, face, at, touch.normal);
  const bool enters_alone = enters(run, obstacle, face, point, point->unloaded, way);
  const bool likely =
      gap < 0.0 || enters(run, obstacle, face, point, point->likely, enters_alone ? other : way);
  if (!likely && !enters_alone)
    return;
  const thrum_touching *before = touch_before(run, index, number, face, from);
  const bool waits = !likely && before == NULL && may_wait(run, obstacle, point, touch.normal);

  // touch_max is the caller's limit: the report counts what it leaves out
  if (contact->row_count + run->waiting == contact->touch_max) {
    contact->dropped++;
    return;
  }

  // the row begins on the plane where the point enters
  gap = entry_gap(obstacle, face, at, way, gap, touch.normal);
  if (waits) {
    begin_row(run, point, &touch, gap, run->view.rows + contact->touch_max - ++run->waiting);
    return;
  }
  thrum_contact_row *row = run->view.rows + contact->row_count;
  begin_row(run, point, &touch, gap, row);
  fill_row(run, point, obstacle, before, row);
  // a point that is held cannot be pushed
  if (row->along > 0.0)
    contact->row_count++;
}

/* Largest factor by which the axes of the placement stretch a length: the root of the largest row
 * sum of A^T A, which is 1 for a rotation. */
static double stretch_of(const double axes[9]) {
  double most = 0.0;
  for (int i = 0; i < 3; i++) {
    double sum = 0.0;
    for (int j = 0; j < 3; j++)
      sum += fabs(axes[i] * axes[j] + axes[3 + i] * axes[3 + j] + axes[6 + i] * axes[6 + j]);
    most = fmax(most, sum);
  }
  return ABOVE * sqrt(most);
}

/* Bound of the distance of any point from its place at rest, now and at the end of the step. */
static double reach_of(const thrum_contact_run *run, double stretch) {
  const double *unloaded = run->view.unloaded, *moved = run->view.moved;

  // the deformation, by the largest displacement of a point under each coordinate
  double own = 0.0;
  for (int32_t i = 0; i < run->contact->rank; i++)
    own += run->view.extents[i] * (fabs(run->view.q[i]) + fmax(fabs(unloaded[i]), fabs(moved[i])));
  own *= stretch;

  // the rotation moves a point by its distance from the centre of mass, which lies within the
  // points' sphere or close to it
  const double turn = sqrt(fmax(thrum_dot3(run->unloaded_turn, run->unloaded_turn),
                                thrum_dot3(run->turned, run->turned)));
  return own + (turn + run->impact.turned) * (own + 2.0 * run->contact->radius * stretch) +
         run->impact.moved +
         sqrt(fmax(thrum_dot3(run->unloaded, run->unloaded), thrum_dot3(run->moved, run->moved)));
}

/* May a point in the sphere about `middle`, in the mesh, come near one of the obstacles? */
static bool near_any(const thrum_contact_run *run, const double middle[3], double reach) {
  const thrum_contact_environment *environment = run->environment;
  double at[3], unused[3];
  thrum_point_rest(run, middle, at);
  for (int64_t n = 0; n < environment->obstacle_count; n++) {
    const thrum_obstacle *o = environment->obstacles + n;
    const double moved = run->dt * sqrt(thrum_dot3(o->velocity, o->velocity));
    if (thrum_obstacle_gap(o, at, unused) <= reach + moved)
      return true;
  }
  return false;
}

/* The middle of the box of some points at rest; returns the radius about it. */
static double box_of_points(const thrum_contact_run *run, int64_t from, int64_t to,
                            double middle[3]) {
  double least[3], most[3], half[3];
  memcpy(least, rest_of(run, from), sizeof least);
  memcpy(most, least, sizeof most);
  for (int64_t n = from + 1; n < to; n++) {
    const double *x = rest_of(run, n);
    for (int axis = 0; axis < 3; axis++) {
      least[axis] = x[axis] < least[axis] ? x[axis] : least[axis];
      most[axis] = x[axis] > most[axis] ? x[axis] : most[axis];
    }
  }
  for (int axis = 0; axis < 3; axis++) {
    middle[axis] = 0.5 * (least[axis] + most[axis]);
    half[axis] = 0.5 * (most[axis] - least[axis]);
  }
  return sqrt(thrum_dot3(half, half));
}

/* Rows of one point and all obstacles within reach, face by face. */
static void add_point(thrum_contact_run *run, int64_t index, double reach, int64_t *from) {
  const thrum_contact_environment *environment = run->environment;
  moving_point point;
  bool evaluated = false;
  double rest[3], unused[3];
  thrum_point_rest(run, rest_of(run, index), rest);

  // displacements are evaluated only for a point near an obstacle
  for (int64_t number = 0; number < environment->obstacle_count; number++) {
    const thrum_obstacle *obstacle = environment->obstacles + number;
    const double moved = run->dt * sqrt(thrum_dot3(obstacle->velocity, obstacle->velocity));
    if (thrum_obstacle_gap(obstacle, rest, unused) > reach + moved)
      continue;
    if (!evaluated)
      point = point_of(run, index);
    evaluated = true;
    for (int32_t face = 0; face < thrum_obstacle_faces(obstacle); face++)
      try_face(run, &point, (int32_t)index, (int32_t)number, face, from);
  }
}

/* Rows of all points and obstacles. Points that follow each other in the list are mostly near each
 * other, so one sphere answers for many of them. */
static void add_rows(thrum_contact_run *run, double reach, double stretch) {
  const int64_t count = run->contact->point_count;
  int64_t from = 0;
  for (int64_t first = 0, last; first < count; first = last) {
    double middle[3];
    last = first + TOGETHER < count ? first + TOGETHER : count;
    const double radius = box_of_points(run, first, last, middle);
    if (!near_any(run, middle, reach + stretch * radius))
      continue;
    for (int64_t index = first; index < last; index++)
      add_point(run, index, reach, &from);
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
  const double stretch = stretch_of(run->axes), reach = reach_of(run, stretch);
  thrum_contact *contact = run->contact;
  const int64_t dropped = contact->dropped;
  contact->row_count = run->waiting = 0;

  // most steps are far from everything: one sphere of all points answers for them
  if (near_any(run, contact->middle, reach + contact->radius * stretch))
    add_rows(run, reach, stretch);

  // where there is no room for both, none waits
  if (contact->dropped > dropped && run->waiting > 0) {
    contact->dropped = dropped;
    run->all = true;
    thrum_contact_rows(run);
    return;
  }
  raise_ceilings(run);
}

bool thrum_contact_wake(thrum_contact_run *run, bool any) {
  for (int64_t n = 1; n <= run->waiting && !any; n++) {
    const thrum_contact_row *row = run->view.rows + run->contact->touch_max - n;
    double at[3];
    thrum_point_moved(run, thrum_point_rows(run, row->touch.point), row->lever, run->view.moved,
                      at);
    thrum_subtract3(at, row->drift, at);
    any = !(row->gap + thrum_dot3(row->touch.normal, at) >= 0.0);
  }
  if (!any || run->waiting == 0)
    return false;
  run->all = true;
  thrum_contact_rows(run);
  return true;
}

void thrum_contact_release(thrum_contact_run *run) {
  for (int64_t n = 0; n < run->contact->row_count; n++) {
    thrum_contact_row *row = run->view.rows + n;
    row->ceiling = fmin(row->ceiling, row->gap + 0.5 * run->dt * fmin(row->speed, 0.0));
    row->friction = 0.0;
  }
}
