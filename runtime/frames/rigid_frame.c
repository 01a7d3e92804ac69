/* The rotation of a free body (thrum/rigid_frame.h), in the mesh's axes: with L the angular
 * momentum in the world, Q the attitude times the placement, P = Q^T L, t = Q^T torque, w the mean
 * angular velocity,
 *
 *   w = J^-1 (P + P')/2,   Q' = Q C,   C = (1 - h/2 [w])^-1 (1 + h/2 [w]),   L' = L + h torque.
 *
 * P' = C^T (P + h t), so P' - P = -h/2 w x (P' + P + h t) + h t, and the energy 1/2 P J^-1 P
 * changes by w (P' - P) = h t w: the torque times the angle h w, whatever h is. With y = (P +
 * P')/2,
 *
 *   y + h/2 w x (y + h/2 t) = P + h/2 t,   w = J^-1 y,
 *
 * which Newton's method solves, started at the right-hand side; it has a solution, as w y = w (P +
 * h/2 t) bounds y. Where Newton's method does not find it, as for a thin rod that a torque spins
 * many times in a step, the step is made in 2, 4, 8, ... parts. Each part changes the energy by the
 * torque times its angle, so their sum does. Cost: about 3 Newton iterations of 3 x 3. Source:
 * Austin, Krishnaprasad & Wang 1993, Almost Poisson integration of rigid body systems,
 * doi:10.1006/jcph.1993.1128.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/frames/rigid_frame_private.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"

#define NEWTON_MAX 40
#define TOLERANCE 1e-15
#define SOLVED 1e-12   /* residual up to which a solution that stopped at rounding is one */
#define ANGLE_MAX 8.0  /* of a part [rad]: no part that turns further is tried */
#define PARTS_MAX 4096 /* of a step that Newton's method does not solve at once */

static const double identity[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};

void thrum_rigid_frame_axes(const thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                            double axes[9]) {
  thrum_multiply3(rigid_frame->attitude, placement ? placement->axes : identity, axes);
}

/* w = J^-1 y + offset */
static void mean_velocity(const double inverse[9], const double offset[3], const double y[3],
                          double w[3]) {
  thrum_apply3(inverse, y, w);
  for (int axis = 0; axis < 3; axis++)
    w[axis] += offset[axis];
}

/* y + h/2 w x (y + s) - b, s = h/2 t; returns its square. */
static double residual(const double inverse[9], const double offset[3], double half,
                       const double s[3], const double b[3], const double y[3], double out[3]) {
  double w[3];
  const double sum[3] = {y[0] + s[0], y[1] + s[1], y[2] + s[2]};
  mean_velocity(inverse, offset, y, w);
  thrum_cross3(w, sum, out);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = y[axis] + half * out[axis] - b[axis];
  return thrum_dot3(out, out);
}

/* Jacobian of the residual: column j is e_j + h/2 (J^-1 e_j x (y + s) + w x e_j). */
static void jacobian(const double inverse[9], const double offset[3], double half,
                     const double s[3], const double y[3], double out[9]) {
  double w[3];
  const double sum[3] = {y[0] + s[0], y[1] + s[1], y[2] + s[2]};
  mean_velocity(inverse, offset, y, w);
  for (int j = 0; j < 3; j++) {
    const double unit[3] = {j == 0, j == 1, j == 2};
    const double column[3] = {inverse[j], inverse[3 + j], inverse[6 + j]};
    double first[3], second[3];
    thrum_cross3(column, sum, first);
    thrum_cross3(w, unit, second);
    for (int i = 0; i < 3; i++)
      out[3 * i + j] = unit[i] + half * (first[i] + second[i]);
  }
}

bool thrum_rigid_frame_solve(const double inverse[9], const double offset[3], double half,
                             const double s[3], const double b[3], double y[3], double w[3]) {
  double r[3], matrix[9], step[3], trial[3], tried[3];
  memcpy(y, b, 3 * sizeof *y);
  double square = residual(inverse, offset, half, s, b, y, r);

  // to rounding of the right-hand side
  const double size = thrum_dot3(b, b), enough = TOLERANCE * TOLERANCE * size;
  for (int n = 0; n < NEWTON_MAX && square > enough; n++) {
    jacobian(inverse, offset, half, s, y, matrix);
    if (!thrum_solve3(matrix, r, step))
      break;

    // the longest step that brings the residual down
    double length = 1.0, next = INFINITY;
    for (int halving = 0; halving < 30; halving++, length *= 0.5) {
      for (int axis = 0; axis < 3; axis++)
        trial[axis] = y[axis] - length * step[axis];
      next = residual(inverse, offset, half, s, b, trial, tried);
      if (next < square)
        break;
    }
    if (!(next < square))
      break;

    memcpy(y, trial, sizeof trial);
    memcpy(r, tried, sizeof tried);
    square = next;
  }
  mean_velocity(inverse, offset, y, w);
  return square <= SOLVED * SOLVED * size;
}

void thrum_rigid_frame_rotate(thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                              const double axes[9], const double v[3]) {
  // C = 1 + 2/(1 + v^2) ([v] + [v]^2)
  const double scale = 2.0 / (1.0 + thrum_dot3(v, v));
  const double hat[9] = {0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0};
  double square[9], c[9], whole[9], now[9], gram[9];
  thrum_multiply3(hat, hat, square);
  for (int n = 0; n < 9; n++)
    c[n] = identity[n] + scale * (hat[n] + square[n]);

  // now = axes C placed^T
  thrum_multiply3(axes, c, whole);
  for (int i = 0; i < 3; i++)
    thrum_apply3(placement ? placement->axes : identity, whole + 3 * i, now + 3 * i);

  // one step of Newton's method for the nearest rotation: rounding does not add up
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      gram[3 * i + j] = 1.5 * identity[3 * i + j] - 0.5 * thrum_dot3(now + 3 * i, now + 3 * j);
  thrum_multiply3(gram, now, rigid_frame->attitude);
}

/* One part of a step; false where its mean angular velocity was not found. `angle` grows by that of
 * the part. */
static bool step_part(thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                      const double torque[3], double dt, double angle[3]) {
  double axes[9], p[3], s[3], b[3], y[3], w[3], v[3], turned[3], offset[3];
  const double half = 0.5 * dt;

  // momentum and torque in the mesh's axes, where the inertia is constant
  thrum_rigid_frame_axes(rigid_frame, placement, axes);
  thrum_apply3_transposed(axes, rigid_frame->momentum, p);
  thrum_apply3_transposed(axes, torque, s);
  for (int axis = 0; axis < 3; axis++) {
    s[axis] *= half;
    b[axis] = p[axis] + s[axis];
  }

  // the mean angular velocity; the momentum in the world is exact
  thrum_apply3(rigid_frame->inverse, rigid_frame->internal, offset);
  for (int axis = 0; axis < 3; axis++)
    offset[axis] = -offset[axis];
  const bool solved = thrum_rigid_frame_solve(rigid_frame->inverse, offset, half, s, b, y, w);
  for (int axis = 0; axis < 3; axis++) {
    v[axis] = half * w[axis];
    rigid_frame->momentum[axis] += dt * torque[axis];
  }

  thrum_apply3(axes, v, turned);
  for (int axis = 0; axis < 3; axis++)
    angle[axis] += 2.0 * turned[axis];
  thrum_rigid_frame_rotate(rigid_frame, placement, axes, v);
  return solved;
}

/* Does the body turn by so much in a step that no number of parts is enough? */
static bool spins_beyond(const thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                         double dt) {
  double spin[3];
  thrum_rigid_frame_velocity(rigid_frame, placement, spin);
  return !(dt * sqrt(thrum_dot3(spin, spin)) <= ANGLE_MAX * PARTS_MAX);
}

void thrum_rigid_frame_step(thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                            const double torque[3], double dt, double angle[3]) {
  thrum_rigid_frame made = *rigid_frame;
  double sum[3] = {0.0};
  bool solved = step_part(&made, placement, torque, dt, sum);

  // what has no solution in one step has one in shorter ones, each from the start of the step again
  const bool beyond = !solved && spins_beyond(rigid_frame, placement, dt);
  for (int parts = 2; !solved && !beyond && parts <= PARTS_MAX; parts *= 2) {
    made = *rigid_frame;
    memset(sum, 0, sizeof sum);
    solved = true;
    for (int n = 0; n < parts && solved; n++)
      solved = step_part(&made, placement, torque, dt / parts, sum);
  }

  // a frame or torque beyond the finite numbers is passed on, and the step that asked sees it
  *rigid_frame = made;
  if (angle)
    memcpy(angle, sum, sizeof sum);
}

void thrum_rigid_frame_velocity(const thrum_rigid_frame *rigid_frame,
                                const thrum_placement *placement, double velocity[3]) {
  double axes[9], p[3], w[3];
  thrum_rigid_frame_axes(rigid_frame, placement, axes);
  thrum_apply3_transposed(axes, rigid_frame->momentum, p);
  thrum_subtract3(p, rigid_frame->internal, p);
  thrum_apply3(rigid_frame->inverse, p, w);
  thrum_apply3(axes, w, velocity);
}

double thrum_rigid_frame_energy(const thrum_rigid_frame *rigid_frame,
                                const thrum_placement *placement) {
  double velocity[3], axes[9], internal[3];
  thrum_rigid_frame_velocity(rigid_frame, placement, velocity);
  thrum_rigid_frame_axes(rigid_frame, placement, axes);
  thrum_apply3(axes, rigid_frame->internal, internal);
  return 0.5 * (thrum_dot3(velocity, rigid_frame->momentum) + thrum_dot3(velocity, internal));
}

thrum_placement thrum_placement_now(const thrum_placement *placement,
                                    const thrum_rigid_frame *rigid_frame,
                                    const double position[3]) {
  thrum_placement now;
  const double *axes = placement ? placement->axes : identity;
  memcpy(now.axes, axes, sizeof now.axes);
  for (int axis = 0; axis < 3; axis++)
    now.origin[axis] =
        (placement ? placement->origin[axis] : 0.0) + (position ? position[axis] : 0.0);
  if (!rigid_frame)
    return now;

  // the centre stays: origin + A c = origin' + R A c
  double before[3], after[3];
  thrum_apply3(axes, rigid_frame->centre, before);
  thrum_apply3(rigid_frame->attitude, before, after);
  thrum_multiply3(rigid_frame->attitude, axes, now.axes);
  for (int axis = 0; axis < 3; axis++)
    now.origin[axis] += before[axis] - after[axis];
  return now;
}

/* The axis a of a rigid mode, which is a x (X - c) over its mass norm: a rotation about the centre.
 * It follows from the differences of the mode between the corners of a tetrahedron. False where
 * that has no volume. */
static bool axis_of(const thrum_model *model, int mode, double a[3]) {
  const int32_t *tet = model->tets;
  double edges[9], slopes[9];
  const double *first = model->vertices + 3 * (int64_t)tet[0];
  for (int e = 0; e < 3; e++)
    for (int axis = 0; axis < 3; axis++)
      edges[3 * e + axis] = model->vertices[3 * (int64_t)tet[e + 1] + axis] - first[axis];

  // the gradient of the mode, a row for each axis
  for (int axis = 0; axis < 3; axis++) {
    double rise[3];
    for (int e = 0; e < 3; e++)
      rise[e] = model->rigid[(3 * (int64_t)tet[e + 1] + axis) * 6 + mode] -
                model->rigid[(3 * (int64_t)tet[0] + axis) * 6 + mode];
    if (!thrum_solve3(edges, rise, slopes + 3 * axis))
      return false;
  }

  // half the curl of the mode
  a[0] = 0.5 * (slopes[7] - slopes[5]);
  a[1] = 0.5 * (slopes[2] - slopes[6]);
  a[2] = 0.5 * (slopes[3] - slopes[1]);
  return true;
}

thrum_status thrum_rigid_frame_of(const thrum_model *model, thrum_rigid_frame *rigid_frame,
                                  thrum_error *error) {
  if (!model || !rigid_frame)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or the frame is NULL");
  if (!model->rigid || !model->tets || model->tet_count < 1)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no rigid modes: only a body that nothing holds turns");

  // J^-1 = sum of a a^T; a x (X - c) = w at a corner X gives c, by least squares over the modes
  thrum_rigid_frame made = {.attitude = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
  double normal[9] = {0.0}, right[3] = {0.0}, a[3], from[3], product[3];
  const int64_t corner = model->tets[0];
  for (int mode = 3; mode < 6; mode++) {
    if (!axis_of(model, mode, a))
      return thrum_error_set(error, THRUM_SINGULAR, "the first tetrahedron has no volume");

    // with |a|^2 1 - a a^T = [a]^T [a]: c minimises |a x (X - c) - w|^2
    thrum_cross3(a, model->vertices + 3 * corner, from);
    for (int axis = 0; axis < 3; axis++)
      from[axis] -= model->rigid[(3 * corner + axis) * 6 + mode];
    thrum_cross3(from, a, product);
    for (int i = 0; i < 3; i++) {
      right[i] += product[i];
      for (int j = 0; j < 3; j++) {
        made.inverse[3 * i + j] += a[i] * a[j];
        normal[3 * i + j] += (i == j ? thrum_dot3(a, a) : 0.0) - a[i] * a[j];
      }
    }
  }
  if (!thrum_solve3(normal, right, made.centre))
    return thrum_error_set(error, THRUM_SINGULAR, "the rigid modes have no centre");
  *rigid_frame = made;
  return THRUM_OK;
}
