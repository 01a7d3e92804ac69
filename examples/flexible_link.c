/* A flexible link for another engine: a free body of Thrum that takes a wrench at a site and gives
 * the site's pose and twist, its mass matrix and its bias. Here the other engine is one rigid link.
 * The two are an arm, whose joint is solved in each step: first in free flight, where no momentum
 * may be lost, then hung from the world, beside the same arm as a scene of Thrum alone. The program
 * fails where a momentum changes by 1e-10 of its size, or the tip is 2 % off.
 * It needs the library of scenes, pkg-config thrum-scene. flexible_link free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/scene.h"

#define STEP 0.001 /* [s] */

/* --- vectors and matrices ----------------------------------------------------------------------
 */

static void cross(const double a[3], const double b[3], double out[3]) {
  const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
  memcpy(out, c, sizeof c);
}

/* out = m x, or m^T x. */
static void turn(const double m[9], bool back, const double x[3], double out[3]) {
  double y[3];
  for (int i = 0; i < 3; i++)
    y[i] = back ? m[i] * x[0] + m[3 + i] * x[1] + m[6 + i] * x[2]
                : m[3 * i] * x[0] + m[3 * i + 1] * x[1] + m[3 * i + 2] * x[2];
  memcpy(out, y, sizeof y);
}

static void invert(const double m[9], double out[9]) {
  double rows[3][3];
  for (int i = 0; i < 3; i++)
    cross(m + 3 * ((i + 1) % 3), m + 3 * ((i + 2) % 3), rows[i]);
  const double det = m[0] * rows[0][0] + m[1] * rows[0][1] + m[2] * rows[0][2];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out[3 * i + j] = rows[j][i] / det;
}

static double distance(const double a[3], const double b[3]) {
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
              (a[2] - b[2]) * (a[2] - b[2]));
}

/* --- the flexible link --------------------------------------------------------------------------
 * Its velocities are, in this order: that of the centre of mass in the world, the angular one and
 * those of the coordinates, both in the axes of the body. */

/* A place of the body: the mean of vertices, and the rotation of them about it. */
typedef struct site {
  double rest[3];       /* from the centre of mass, in the mesh [m] */
  double *shift, *tilt; /* 3 x rank each: displacement and rotation, by coordinate */
} site;

typedef struct flexible_link {
  const thrum_model *model;
  thrum_inertia *inertia;
  thrum_state *state;
  thrum_rigid_frame frame;
  double step;                         /* [s] */
  double mass, centre[3], velocity[3]; /* [kg], [m], [m/s] */
  double *numbers;                     /* of the inertia */
  double *q, *p, *load, *work;
  void *kept; /* the state of a step that is tried again */
  thrum_rigid_frame kept_frame;
  double kept_centre[3], kept_velocity[3];
} flexible_link;

typedef struct wrench {
  double place[3], force[3], torque[3]; /* in the world: [m], [N], and about the place [N m] */
} wrench;

static int64_t rank_of(const flexible_link *link) {
  return link->model->rank;
}

/* The site of a named group. The rotation is that which fits the displacements best. */
static thrum_status site_make(const flexible_link *link, const char *group, site *made,
                              thrum_error *error) {
  const thrum_model *model = link->model;
  const int64_t r = model->rank;
  const int32_t *list = NULL;
  int64_t count = 0;
  THRUM_TRY(thrum_model_group(model, group, &list, &count, error));
  memset(made, 0, sizeof *made);
  made->shift = calloc((size_t)(3 * r), sizeof(double));
  made->tilt = calloc((size_t)(3 * r), sizeof(double));
  if (made->shift == NULL || made->tilt == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a site");

  // means over the vertices
  double mean[3] = {0};
  for (int64_t v = 0; v < count; v++)
    for (int axis = 0; axis < 3; axis++) {
      mean[axis] += model->vertices[3 * list[v] + axis] / (double)count;
      for (int64_t i = 0; i < r; i++)
        made->shift[axis * r + i] += model->basis[(3 * list[v] + axis) * r + i] / (double)count;
    }

  // the rotation is sum y x u over the second moments of the y, which the places are from the mean
  double moments[9] = {0}, inverse[9];
  for (int64_t v = 0; v < count; v++) {
    double y[3], square = 0;
    for (int axis = 0; axis < 3; axis++) {
      y[axis] = model->vertices[3 * list[v] + axis] - mean[axis];
      square += y[axis] * y[axis];
    }
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        moments[3 * a + b] += (a == b ? square : 0) - y[a] * y[b];
    for (int64_t i = 0; i < r; i++) {
      const double *u = model->basis + 3 * list[v] * r + i;
      double turned[3];
      cross(y, (double[3]){u[0], u[r], u[2 * r]}, turned);
      for (int axis = 0; axis < 3; axis++)
        made->tilt[axis * r + i] += turned[axis];
    }
  }
  invert(moments, inverse);
  for (int64_t i = 0; i < r; i++) {
    double *t = made->tilt + i, turned[3];
    turn(inverse, false, (double[3]){t[0], t[r], t[2 * r]}, turned);
    for (int axis = 0; axis < 3; axis++)
      t[axis * r] = turned[axis];
  }
  for (int axis = 0; axis < 3; axis++)
    made->rest[axis] = mean[axis] - link->frame.centre[axis];
  return THRUM_OK;
}

static void site_free(site *made) {
  free(made->shift);
  free(made->tilt);
}

/* rows x, of three rows of the rank. */
static void rows_times(int64_t r, const double *rows, const double *x, double out[3]) {
  for (int axis = 0; axis < 3; axis++) {
    out[axis] = 0;
    for (int64_t i = 0; i < r; i++)
      out[axis] += rows[axis * r + i] * x[i];
  }
}

/* Pose and twist of a site, for the other engine: place [m], rotation vector of the tilt in the
 * body, velocity [m/s] and angular velocity [rad/s] in the world. Any but the first may be NULL. */
static thrum_status link_site(flexible_link *link, const site *at, double place[3], double tilt[3],
                              double velocity[3], double spin[3], thrum_error *error) {
  const int64_t r = rank_of(link);
  const double *attitude = link->frame.attitude;
  double arm[3], moved[3], w[3];
  THRUM_TRY(thrum_state_get(link->model, link->state, link->q, link->p, error));
  rows_times(r, at->shift, link->q, arm);
  for (int axis = 0; axis < 3; axis++)
    arm[axis] += at->rest[axis];
  turn(attitude, false, arm, arm);
  for (int axis = 0; axis < 3; axis++)
    place[axis] = link->centre[axis] + arm[axis];
  if (tilt)
    rows_times(r, at->tilt, link->q, tilt);

  // its own motion in the body, and that of the body
  thrum_rigid_frame_velocity(&link->frame, NULL, w);
  if (velocity) {
    rows_times(r, at->shift, link->p, moved);
    turn(attitude, false, moved, moved);
    cross(w, arm, velocity);
    for (int axis = 0; axis < 3; axis++)
      velocity[axis] += moved[axis] + link->velocity[axis];
  }
  if (spin) {
    rows_times(r, at->tilt, link->p, moved);
    turn(attitude, false, moved, spin);
    for (int axis = 0; axis < 3; axis++)
      spin[axis] += w[axis];
  }
  return THRUM_OK;
}

/* The column G e_i of the gyration at q: sum m (U q) x U_i. */
static void gyration(const flexible_link *link, int64_t i, double out[3]) {
  const int64_t r = rank_of(link);
  const double *products = link->numbers + 9 + 9 * r;
  memset(out, 0, 3 * sizeof *out);
  for (int64_t j = 0; j < r; j++) {
    const double *m = products + 9 * (j * r + i), q = link->q[j];
    out[0] += q * (m[5] - m[7]);
    out[1] += q * (m[6] - m[2]);
    out[2] += q * (m[1] - m[3]);
  }
}

/* The mass matrix (6 + rank)^2 at the present shape, and the bias (6 + rank) of the equation
 * M a + bias = J^T wrench: gyroscopic and elastic forces, without gravity. */
static thrum_status link_equation(flexible_link *link, double *mass, double *bias,
                                  thrum_error *error) {
  const int64_t r = rank_of(link), n = 6 + r;
  double tensor[9], w[3], momentum[3];
  THRUM_TRY(thrum_state_get(link->model, link->state, link->q, link->p, error));
  memset(mass, 0, (size_t)(n * n) * sizeof *mass);
  memset(bias, 0, (size_t)n * sizeof *bias);
  thrum_inertia_tensor(link->inertia, link->q, tensor, link->work);
  for (int a = 0; a < 3; a++) {
    mass[a * n + a] = link->mass;
    for (int b = 0; b < 3; b++)
      mass[(3 + a) * n + 3 + b] = tensor[3 * a + b];
  }
  for (int64_t i = 0; i < r; i++) {
    double column[3];
    gyration(link, i, column);
    mass[(6 + i) * n + 6 + i] = 1;
    for (int a = 0; a < 3; a++)
      mass[(3 + a) * n + 6 + i] = mass[(6 + i) * n + 3 + a] = column[a];
  }

  // the inertia changes with the shape: it is quadratic in q, so differences are exact
  double ahead[9], behind[9], changed[3];
  for (int64_t i = 0; i < r; i++)
    link->load[i] = link->q[i] + link->p[i];
  thrum_inertia_tensor(link->inertia, link->load, ahead, link->work);
  for (int64_t i = 0; i < r; i++)
    link->load[i] = link->q[i] - link->p[i];
  thrum_inertia_tensor(link->inertia, link->load, behind, link->work);
  thrum_rigid_frame_velocity(&link->frame, NULL, w);
  turn(link->frame.attitude, true, w, w);
  for (int k = 0; k < 9; k++)
    ahead[k] = 0.5 * (ahead[k] - behind[k]);
  turn(ahead, false, w, changed);

  // w x the momentum in the axes of the body, and what turning and stiffness ask of the coordinates
  turn(link->frame.attitude, true, link->frame.momentum, momentum);
  cross(w, momentum, bias + 3);
  for (int a = 0; a < 3; a++)
    bias[3 + a] += changed[a];
  thrum_floating_frame_force(link->inertia, NULL, &link->frame, link->q, link->p, link->load,
                             link->work);
  thrum_internal_force(link->model, link->q, bias + 6, link->work);
  for (int64_t i = 0; i < r; i++)
    bias[6 + i] -= link->load[i];
  return THRUM_OK;
}

/* Keeps the link as it is, and puts it back. */
static void link_keep(flexible_link *link) {
  memcpy(link->kept, link->state, thrum_state_kept_bytes(link->state));
  link->kept_frame = link->frame;
  memcpy(link->kept_centre, link->centre, sizeof link->centre);
  memcpy(link->kept_velocity, link->velocity, sizeof link->velocity);
}

static void link_back(flexible_link *link) {
  memcpy(link->state, link->kept, thrum_state_kept_bytes(link->state));
  link->frame = link->kept_frame;
  memcpy(link->centre, link->kept_centre, sizeof link->centre);
  memcpy(link->velocity, link->kept_velocity, sizeof link->velocity);
}

/* One step under a wrench at a site and an acceleration of gravity. The torque is that about where
 * the centre is in the middle of the step, so that no angular momentum is lost. */
static thrum_status link_step(flexible_link *link, const site *at, const wrench *by,
                              const double gravity[3], thrum_error *error) {
  const int64_t r = rank_of(link);
  double force[3], torque[3], arm[3];
  turn(link->frame.attitude, true, by->force, force);
  turn(link->frame.attitude, true, by->torque, torque);
  for (int64_t i = 0; i < r; i++) {
    link->load[i] = 0;
    for (int axis = 0; axis < 3; axis++)
      link->load[i] +=
          at->shift[axis * r + i] * force[axis] + at->tilt[axis * r + i] * torque[axis];
  }
  THRUM_TRY(thrum_state_set_force(link->model, link->state, link->load, error));

  for (int axis = 0; axis < 3; axis++) {
    const double change = link->step * (by->force[axis] / link->mass + gravity[axis]);
    const double move = link->step * (link->velocity[axis] + 0.5 * change);
    arm[axis] = by->place[axis] - (link->centre[axis] + 0.5 * move);
    link->centre[axis] += move;
    link->velocity[axis] += change;
  }
  cross(arm, by->force, torque);
  for (int axis = 0; axis < 3; axis++)
    torque[axis] += by->torque[axis];
  return thrum_floating_frame_step(link->model, link->state, link->inertia, NULL, &link->frame,
                                   torque, NULL, link->work, error);
}

static thrum_status link_make(const thrum_model *model, double step, flexible_link *link,
                              thrum_error *error) {
  const size_t r = (size_t)model->rank;
  thrum_state_def def = thrum_default_state_def();
  def.dt = step;
  memset(link, 0, sizeof *link);
  link->model = model;
  link->step = step;
  THRUM_TRY(thrum_inertia_create(model, 0, NULL, &link->inertia, error));
  THRUM_TRY(thrum_state_create(model, &def, &link->state, error));
  THRUM_TRY(thrum_rigid_frame_of(model, &link->frame, error));

  // in a rigid shift every vertex moves by one over the root of the mass
  link->mass = 1 / (model->rigid[0] * model->rigid[0]);
  memcpy(link->centre, link->frame.centre, sizeof link->centre);

  size_t work = thrum_floating_frame_work_count(link->inertia) + 9 * r;
  if (work < thrum_work_count(model))
    work = thrum_work_count(model);
  link->numbers = calloc((size_t)thrum_inertia_number_count(model->rank), sizeof(double));
  link->q = calloc(r, sizeof(double));
  link->p = calloc(r, sizeof(double));
  link->load = calloc(r, sizeof(double));
  link->work = calloc(work, sizeof(double));
  link->kept = malloc(thrum_state_kept_bytes(link->state));
  if (!link->numbers || !link->q || !link->p || !link->load || !link->work || !link->kept)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a link");
  thrum_inertia_numbers(link->inertia, link->numbers);
  return thrum_floating_frame_settle(link->inertia, link->q, NULL, &link->frame, link->work, error);
}

static void link_free(flexible_link *link) {
  thrum_state_destroy(link->state);
  thrum_inertia_destroy(link->inertia);
  free(link->numbers);
  free(link->q);
  free(link->p);
  free(link->load);
  free(link->work);
  free(link->kept);
}

/* --- the other engine: one rigid link, free or hung from a place of it --------------------------
 */

typedef struct rigid_link {
  thrum_rigid_frame frame; /* its rotation about the centre of mass, or about where it is hung */
  bool hung;
  double mass, pivot[3], velocity[3]; /* what it turns about, in the world */
  double centre[3], joint[3];         /* from there, in the body: of mass, and the joint */
} rigid_link;

/* A link with the mass and the inertia of the model at rest. */
static thrum_status rigid_make(flexible_link *as, bool hung, const double from[3],
                               const double joint[3], rigid_link *link, thrum_error *error) {
  double tensor[9];
  memset(link, 0, sizeof *link);
  THRUM_TRY(thrum_rigid_frame_of(as->model, &link->frame, error));
  link->mass = as->mass;
  link->hung = hung;
  thrum_inertia_tensor(as->inertia, as->q, tensor, as->work);
  for (int axis = 0; axis < 3; axis++) {
    link->pivot[axis] = link->frame.centre[axis] + (hung ? from[axis] : 0);
    link->centre[axis] = hung ? -from[axis] : 0;
    link->joint[axis] = joint[axis] - (hung ? from[axis] : 0);
  }

  // about where it is hung it has more
  const double *c = link->centre, square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      tensor[3 * a + b] += link->mass * ((a == b ? square : 0) - c[a] * c[b]);
  invert(tensor, link->frame.inverse);
  return THRUM_OK;
}

static void rigid_joint(const rigid_link *link, double place[3]) {
  turn(link->frame.attitude, false, link->joint, place);
  for (int axis = 0; axis < 3; axis++)
    place[axis] += link->pivot[axis];
}

static void rigid_step(rigid_link *link, const wrench *by, const double gravity[3]) {
  double arm[3], torque[3], weight[3], pull[3];
  for (int axis = 0; axis < 3; axis++) {
    const double change = link->hung ? 0 : STEP * (by->force[axis] / link->mass + gravity[axis]);
    const double move = STEP * (link->velocity[axis] + 0.5 * change);
    arm[axis] = by->place[axis] - (link->pivot[axis] + 0.5 * move);
    link->pivot[axis] += move;
    link->velocity[axis] += change;
    weight[axis] = link->hung ? link->mass * gravity[axis] : 0;
  }
  cross(arm, by->force, torque);

  // the weight pulls where the centre is in the middle of the step
  const thrum_rigid_frame start = link->frame;
  for (int round = 0; round < 4; round++) {
    double before[3], after[3], all[3];
    turn(start.attitude, false, link->centre, before);
    turn(link->frame.attitude, false, link->centre, after);
    for (int axis = 0; axis < 3; axis++)
      before[axis] = 0.5 * (before[axis] + after[axis]);
    cross(before, weight, pull);
    for (int axis = 0; axis < 3; axis++)
      all[axis] = torque[axis] + pull[axis] + by->torque[axis];
    link->frame = start;
    thrum_rigid_frame_step(&link->frame, NULL, all, STEP, NULL);
  }
}

/* --- the arm ------------------------------------------------------------------------------------
 */

typedef struct arm {
  flexible_link soft;
  rigid_link rigid;
  site joint, tip;
  double force[3], friction; /* of the joint: [N] on the soft link, and [N m s] */
} arm;

/* Both links under the joint's force: how far it is open after the step. */
static thrum_status try_step(arm *a, const rigid_link *from, const wrench *on_soft,
                             const double gravity[3], double gap[3], thrum_error *error) {
  wrench on_rigid = *on_soft;
  double soft[3], rigid[3];
  for (int axis = 0; axis < 3; axis++) {
    on_rigid.force[axis] = -on_soft->force[axis];
    on_rigid.torque[axis] = -on_soft->torque[axis];
  }
  link_back(&a->soft);
  a->rigid = *from;
  THRUM_TRY(link_step(&a->soft, &a->joint, on_soft, gravity, error));
  rigid_step(&a->rigid, &on_rigid, gravity);
  THRUM_TRY(link_site(&a->soft, &a->joint, soft, NULL, NULL, NULL, error));
  rigid_joint(&a->rigid, rigid);
  for (int axis = 0; axis < 3; axis++)
    gap[axis] = soft[axis] - rigid[axis];
  return THRUM_OK;
}

/* One step of the arm: the force that closes the joint by Newton's method, with differences. */
static thrum_status arm_step(arm *a, const double gravity[3], thrum_error *error) {
  const rigid_link from = a->rigid;
  wrench by = {{0}, {0}, {0}};
  double spin[3], turning[3], gap[3], slope[9], inverse[9], change[3];
  link_keep(&a->soft);
  THRUM_TRY(link_site(&a->soft, &a->joint, by.place, NULL, NULL, spin, error));
  thrum_rigid_frame_velocity(&a->rigid.frame, NULL, turning);
  memcpy(by.force, a->force, sizeof by.force);
  for (int axis = 0; axis < 3; axis++)
    by.torque[axis] = -a->friction * (spin[axis] - turning[axis]);

  // what a newton more in each direction does
  THRUM_TRY(try_step(a, &from, &by, gravity, gap, error));
  for (int b = 0; b < 3; b++) {
    double moved[3];
    wrench other = by;
    other.force[b] += 1;
    THRUM_TRY(try_step(a, &from, &other, gravity, moved, error));
    for (int axis = 0; axis < 3; axis++)
      slope[3 * axis + b] = moved[axis] - gap[axis];
  }
  invert(slope, inverse);
  for (int round = 0; round < 3; round++) {
    turn(inverse, false, gap, change);
    for (int axis = 0; axis < 3; axis++)
      by.force[axis] -= change[axis];
    THRUM_TRY(try_step(a, &from, &by, gravity, gap, error));
  }
  memcpy(a->force, by.force, sizeof by.force);
  return THRUM_OK;
}

static thrum_status arm_make(const thrum_model *model, bool hung, arm *a, thrum_error *error) {
  site left = {{0}, NULL, NULL};
  memset(a, 0, sizeof *a);

  // the second link begins where the first one ends
  THRUM_TRY(link_make(model, STEP, &a->soft, error));
  thrum_status status = site_make(&a->soft, "left", &left, error);
  if (status >= 0)
    status = site_make(&a->soft, "right", &a->tip, error);
  if (status >= 0)
    status = site_make(&a->soft, "left", &a->joint, error);
  if (status >= 0) {
    status = rigid_make(&a->soft, hung, left.rest, a->tip.rest, &a->rigid, error);
    for (int axis = 0; axis < 3; axis++)
      a->soft.centre[axis] += a->tip.rest[axis] - left.rest[axis];
  }
  site_free(&left);
  return status;
}

static void arm_free(arm *a) {
  site_free(&a->joint);
  site_free(&a->tip);
  link_free(&a->soft);
}

/* Momentum, and angular momentum about the origin, of a free arm. */
static void arm_momentum(const arm *a, double momentum[6]) {
  double turned[3];
  for (int axis = 0; axis < 3; axis++)
    momentum[axis] =
        a->soft.mass * a->soft.velocity[axis] + a->rigid.mass * a->rigid.velocity[axis];
  cross(a->soft.centre, a->soft.velocity, momentum + 3);
  cross(a->rigid.pivot, a->rigid.velocity, turned);
  for (int axis = 0; axis < 3; axis++)
    momentum[3 + axis] = a->soft.mass * momentum[3 + axis] + a->rigid.mass * turned[axis] +
                         a->soft.frame.momentum[axis] + a->rigid.frame.momentum[axis];
}

/* The velocities in the order of the equation. */
static thrum_status link_velocities(flexible_link *link, double *v, thrum_error *error) {
  memcpy(v, link->velocity, sizeof link->velocity);
  thrum_rigid_frame_velocity(&link->frame, NULL, v + 3);
  turn(link->frame.attitude, true, v + 3, v + 3);
  return thrum_state_get(link->model, link->state, NULL, v + 6, error);
}

/* 1/2 v M v beside the energies of the library. */
static thrum_status check_mass(flexible_link *link, double *off, thrum_error *error) {
  const int64_t r = rank_of(link), n = 6 + r;
  double *mass = malloc((size_t)(n * n) * sizeof *mass), *bias = malloc((size_t)n * sizeof *bias);
  double *v = malloc((size_t)n * sizeof *v), energy = 0;
  thrum_energies energies;
  thrum_status status = mass && bias && v
                            ? link_equation(link, mass, bias, error)
                            : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory");
  if (status >= 0)
    status = thrum_state_energies(link->model, link->state, &energies, error);
  if (status >= 0) {
    status = link_velocities(link, v, error);
    for (int64_t i = 0; i < n; i++)
      for (int64_t j = 0; j < n; j++)
        energy += 0.5 * v[i] * mass[i * n + j] * v[j];
    double all = energies.kinetic + thrum_rigid_frame_energy(&link->frame, NULL);
    for (int axis = 0; axis < 3; axis++)
      all += 0.5 * link->mass * link->velocity[axis] * link->velocity[axis];
    *off = fabs(energy / all - 1);
  }
  free(mass);
  free(bias);
  free(v);
  return status;
}

/* A short step from a bent and turning state: what M a + bias leaves, as a share of the bias. */
static thrum_status check_bias(const thrum_model *model, double *off, thrum_error *error) {
  const int64_t r = model->rank, n = 6 + r;
  const double spin[3] = {3, -20, 8}, none[3] = {0};
  const wrench free_of = {{0}, {0}, {0}};
  double *all = calloc((size_t)(n * n + 4 * n), sizeof *all), left = 0, size = 0;
  double *mass = all, *bias = all + n * n, *before = bias + n, *after = before + n;
  site at = {{0}, NULL, NULL};
  flexible_link link;
  thrum_status status = link_make(model, 1e-7, &link, error);
  if (all == NULL)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory");

  // the three softest coordinates move
  for (int i = 0; i < 3 && i < r && status >= 0; i++) {
    link.q[i] = 0.01 * (1 + i) * sqrt(link.mass);
    link.p[i] = 2 * (2 - i) * sqrt(link.mass);
  }
  if (status >= 0)
    status = site_make(&link, "left", &at, error);
  if (status >= 0)
    status = thrum_state_set(model, link.state, link.q, link.p, error);
  if (status >= 0)
    status =
        thrum_floating_frame_settle(link.inertia, link.q, link.p, &link.frame, link.work, error);
  if (status >= 0) {
    thrum_floating_frame_spin(NULL, spin, &link.frame);
    status = link_equation(&link, mass, bias, error);
  }

  // the acceleration is the change of the velocities
  if (status >= 0)
    status = link_velocities(&link, before, error);
  if (status >= 0)
    status = link_step(&link, &at, &free_of, none, error);
  if (status >= 0)
    status = link_velocities(&link, after, error);
  for (int64_t i = 0; i < n && status >= 0; i++) {
    double sum = bias[i];
    for (int64_t j = 0; j < n; j++)
      sum += mass[i * n + j] * (after[j] - before[j]) / link.step;
    left = fmax(left, fabs(sum));
    size = fmax(size, fabs(bias[i]));
  }
  *off = left / size;
  site_free(&at);
  free(all);
  link_free(&link);
  return status;
}

/* Turns both links about the joint, each with its own spin [rad/s]. */
static void start_turning(arm *a, const double soft[3], const double rigid[3]) {
  double inertia[9], place[3], out[3];
  rigid_joint(&a->rigid, place);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = a->soft.centre[axis] - place[axis];
  cross(soft, out, a->soft.velocity);
  thrum_floating_frame_spin(NULL, soft, &a->soft.frame);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = a->rigid.pivot[axis] - place[axis];
  cross(rigid, out, a->rigid.velocity);
  invert(a->rigid.frame.inverse, inertia);
  turn(inertia, false, rigid, a->rigid.frame.momentum);
}

/* Half a second of free flight, both links turning against each other with friction in the joint:
 * how much of the momenta is lost, and how far the energy of the mass matrix is off. */
static thrum_status fly(arm *a, double *lost, double *off, thrum_error *error) {
  const double none[3] = {0}, soft[3] = {0, 4, 9}, rigid[3] = {2, -5, 1};
  double first[6], now[6], size[2] = {0, 0};
  a->friction = 2e-5;
  start_turning(a, soft, rigid);
  arm_momentum(a, first);
  for (int axis = 0; axis < 3; axis++) {
    size[0] += fabs(a->soft.mass * a->soft.velocity[axis]);
    size[1] += fabs(a->soft.frame.momentum[axis]) + fabs(a->rigid.frame.momentum[axis]);
  }

  *lost = *off = 0;
  for (int step = 1; step <= 500; step++) {
    double wrong;
    THRUM_TRY(arm_step(a, none, error));
    arm_momentum(a, now);
    for (int k = 0; k < 6; k++)
      *lost = fmax(*lost, fabs(now[k] - first[k]) / size[k / 3]);
    THRUM_TRY(check_mass(&a->soft, &wrong, error));
    *off = fmax(*off, wrong);
  }
  return THRUM_OK;
}

/* The same arm as a scene: two bodies of the model, the first of them a thousand times as stiff. */
static thrum_status scene_arm(const thrum_model *model, const arm *a, thrum_scene *scene,
                              thrum_error *error) {
  const double gravity[3] = {0, 0, -9.81};
  thrum_scene_link_def joint = thrum_default_scene_link_def();
  const int32_t *left, *right;
  int64_t left_count, right_count;
  THRUM_TRY(thrum_model_group(model, "left", &left, &left_count, error));
  THRUM_TRY(thrum_model_group(model, "right", &right, &right_count, error));
  THRUM_TRY(thrum_scene_set_gravity(scene, gravity, error));
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = model;
    def.free = def.coupled = 1;
    def.stiffness = n == 0 ? 1000 : 1;
    for (int axis = 0; axis < 3; axis++)
      def.position[axis] = n * (a->tip.rest[axis] - a->joint.rest[axis]);
    THRUM_TRY(thrum_scene_add_body(scene, &def, NULL, error));
  }

  // the first hangs from the world, the second from the first
  joint.kind = THRUM_LINK_BALL;
  joint.vertices = left;
  joint.count = left_count;
  THRUM_TRY(thrum_scene_add_link(scene, &joint, NULL, error));
  joint.body = 1;
  joint.other = 0;
  joint.other_vertices = right;
  joint.other_count = right_count;
  THRUM_TRY(thrum_scene_add_link(scene, &joint, NULL, error));
  return thrum_scene_add_probe(scene, "tip", 1, right, right_count, error);
}

/* Half a second of the fall of a hung arm: how far the tip is from that of the scene, as a share of
 * its way, and how far it was bent away from where it is at rest. */
static thrum_status swing(const thrum_model *model, arm *a, double *off, double *bent,
                          thrum_error *error) {
  const double gravity[3] = {0, 0, -9.81};
  double first[3], tip[3], other[3], straight[3], way = 0, far = 0;
  thrum_scene *scene = NULL;
  THRUM_TRY(thrum_scene_create(STEP, &scene, error));
  thrum_status status = scene_arm(model, a, scene, error);
  if (status >= 0)
    status = link_site(&a->soft, &a->tip, first, NULL, NULL, NULL, error);

  *bent = 0;
  for (int step = 1; step <= 500 && status >= 0; step++) {
    status = thrum_scene_step(scene, error);
    if (status >= 0)
      status = arm_step(a, gravity, error);
    if (status >= 0)
      status = link_site(&a->soft, &a->tip, tip, NULL, NULL, NULL, error);
    if (status >= 0)
      status = thrum_scene_probe_get(scene, 0, other, NULL, error);
    if (status < 0)
      break;

    // where the tip of a rigid body would be
    turn(a->soft.frame.attitude, false, a->tip.rest, straight);
    for (int axis = 0; axis < 3; axis++)
      straight[axis] += a->soft.centre[axis];
    *bent = fmax(*bent, distance(tip, straight));
    way = fmax(way, distance(tip, first));
    far = fmax(far, distance(tip, other));
  }
  *off = far / way;
  thrum_scene_destroy(scene);
  return status;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *model = NULL;
  double lost = 0, off = 0, tip = 0, bent = 0, bias = 0;
  arm a;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return fprintf(stderr, "usage: flexible_link MODEL.npz\n%s\n", error.message), 1;

  thrum_status status = arm_make(model, false, &a, &error);
  if (status >= 0)
    status = fly(&a, &lost, &off, &error);
  arm_free(&a);
  if (status >= 0) {
    status = arm_make(model, true, &a, &error);
    if (status >= 0)
      status = swing(model, &a, &tip, &bent, &error);
    arm_free(&a);
  }
  if (status >= 0)
    status = check_bias(model, &bias, &error);
  thrum_model_destroy(model);
  if (status < 0)
    return fprintf(stderr, "flexible_link: %s\n", error.message), 1;

  printf("mass matrix: 1/2 v M v is the energy to %.1e; M a + bias is 0 to %.1e\n", off, bias);
  printf("free flight: momenta change by %.1e of their size\n", lost);
  printf("hung: the tip is %.2f %% of its way from that of the scene, and bends by %.0f mm\n",
         100 * tip, 1000 * bent);
  return !(lost < 1e-10 && off < 1e-10 && bias < 1e-3 && tip < 0.02);
}
