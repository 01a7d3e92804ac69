/* A point of a body in a step (docs/contact.md): where it is, how it moves, and how it answers to a
 * force. Its three rows of U lie in the model one after the other; axes of the placement turn what
 * they say into the world, and a translation adds its own.
 * The products of each sweep are there for AVX2 as well, with the bits of two_lanes.h.
 * Cost: 3 r each, the response 9 r.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_point.h"

#include <math.h>
#include <string.h>

#include "contact/contact_private.h"
#include "core/base/two_lanes.h"

/* --- products with three rows of U ------------------------------------------------------------ */

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

/* As thrum_rows_times: its four lanes are one register. */
__attribute__((target("avx2"))) static void times_wide(int64_t n, const double *rows,
                                                       const double *x, double u[3]) {
  __m256d sum[3] = {_mm256_setzero_pd(), _mm256_setzero_pd(), _mm256_setzero_pd()};
  double rest[3] = {0.0, 0.0, 0.0};
  int64_t i = 0;
  for (; i + 4 <= n; i += 4) {
    const __m256d of = _mm256_loadu_pd(x + i);
    for (int axis = 0; axis < 3; axis++)
      sum[axis] = _mm256_add_pd(sum[axis], _mm256_mul_pd(_mm256_loadu_pd(rows + axis * n + i), of));
  }
  for (; i < n; i++)
    for (int axis = 0; axis < 3; axis++)
      rest[axis] += rows[axis * n + i] * x[i];

  // (0 + 2) + (1 + 3)
  for (int axis = 0; axis < 3; axis++) {
    const __m128d two =
        _mm_add_pd(_mm256_castpd256_pd128(sum[axis]), _mm256_extractf128_pd(sum[axis], 1));
    u[axis] = _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two)) + rest[axis];
  }
}

/* As thrum_rows_push, of which each element is a sum of its own. */
__attribute__((target("avx2"))) static void
push_wide(int64_t n, const double *rows, const double f[3], const double *w, double *x) {
  const __m256d f0 = _mm256_set1_pd(f[0]), f1 = _mm256_set1_pd(f[1]), f2 = _mm256_set1_pd(f[2]);
  int64_t i = 0;
  for (; i + 4 <= n; i += 4) {
    __m256d sum = _mm256_mul_pd(_mm256_loadu_pd(rows + i), f0);
    sum = _mm256_add_pd(sum, _mm256_mul_pd(_mm256_loadu_pd(rows + n + i), f1));
    sum = _mm256_add_pd(sum, _mm256_mul_pd(_mm256_loadu_pd(rows + 2 * n + i), f2));
    sum = _mm256_mul_pd(_mm256_loadu_pd(w + i), sum);
    _mm256_storeu_pd(x + i, _mm256_add_pd(_mm256_loadu_pd(x + i), sum));
  }
  for (; i < n; i++)
    x[i] += w[i] * (rows[i] * f[0] + rows[n + i] * f[1] + rows[2 * n + i] * f[2]);
}

static bool is_wide(int64_t n) {
  return n >= 4 && __builtin_cpu_supports("avx2");
}
#else
#define times_wide thrum_rows_times
#define push_wide thrum_rows_push

static bool is_wide(int64_t n) {
  (void)n;
  return false;
}
#endif

/* u = rows x */
static void times(int64_t n, const double *rows, const double *x, double u[3]) {
  if (is_wide(n))
    times_wide(n, rows, x, u);
  else
    thrum_rows_times(n, rows, x, u);
}

/* --- points ----------------------------------------------------------------------------------- */

void thrum_point_shape(const thrum_contact_run *run, const double *rows, const double *x,
                       double out[3]) {
  double u[3];
  times(run->contact->rank, rows, x, u);
  thrum_apply3(run->axes, u, out);
}

const double *thrum_point_rows(const thrum_contact_run *run, int64_t point) {
  return run->model->basis + 3 * (int64_t)run->view.vertices[point] * run->contact->rank;
}

void thrum_point_rest(const thrum_contact_run *run, const double rest[3], double x[3]) {
  thrum_apply3(run->axes, rest, x);
  for (int axis = 0; axis < 3; axis++)
    x[axis] += run->origin[axis];
}

void thrum_point_start(const thrum_contact_run *run, const double *rows, const double rest[3],
                       double x[3]) {
  double u[3];
  thrum_point_rest(run, rest, x);
  thrum_point_shape(run, rows, run->view.q, u);
  for (int axis = 0; axis < 3; axis++)
    x[axis] += u[axis];
}

void thrum_point_way(const thrum_contact_run *run, const double *rows, const double rest[3],
                     const double *d, double x[3], double out[3]) {
  double u[3], turned[3], moved[3];
  thrum_point_rest(run, rest, x);
  thrum_rows_times_both(run->contact->rank, rows, run->view.q, d, u, moved);
  thrum_apply3(run->axes, u, turned);
  thrum_apply3(run->axes, moved, out);
  for (int axis = 0; axis < 3; axis++)
    x[axis] += turned[axis];
}

void thrum_point_shift(const thrum_contact_run *run, const double *rows, const double rest[3],
                       const double x[3], double shift[3]) {
  double u[3], at[3];
  memset(shift, 0, 3 * sizeof *shift);
  if (!run->impact.struck)
    return;
  thrum_rows_times(run->contact->rank, rows, run->view.q, u);
  for (int axis = 0; axis < 3; axis++)
    u[axis] += rest[axis];
  thrum_apply3(run->impact.axes, u, at);
  for (int axis = 0; axis < 3; axis++)
    shift[axis] = x[axis] - at[axis] - run->impact.origin[axis];
}

void thrum_point_lever(const thrum_contact_run *run, const double x[3], double arm[3],
                       double lever[3]) {
  for (int axis = 0; axis < 3; axis++)
    arm[axis] = x[axis] - run->centre[axis];
  thrum_cross3(run->unloaded_turn, arm, lever);
  for (int axis = 0; axis < 3; axis++)
    lever[axis] = arm[axis] + 0.5 * lever[axis];
}

void thrum_point_mean_arm(const double turn[3], const double arm[3], double lever[3]) {
  // l = a + t/2 x l, solved for l
  const double w[3] = {0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]};
  const double along = thrum_dot3(w, arm), scale = 1.0 / (1.0 + thrum_dot3(w, w));
  double across[3];
  thrum_cross3(w, arm, across);
  for (int axis = 0; axis < 3; axis++)
    lever[axis] = scale * (arm[axis] + across[axis] + along * w[axis]);
}

/* out += shift + turn x lever */
static void add_whole(const double shift[3], const double turn[3], const double lever[3],
                      double out[3]) {
  double turned[3];
  thrum_cross3(turn, lever, turned);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += shift[axis] + turned[axis];
}

void thrum_point_velocity(const thrum_contact_run *run, const double *rows, const double arm[3],
                          double velocity[3]) {
  static const double zero[3] = {0.0, 0.0, 0.0};
  const thrum_translation *translation = run->environment->translation;
  thrum_point_shape(run, rows, run->view.p, velocity);
  add_whole(translation ? translation->velocity : zero, run->spin, arm, velocity);
}

void thrum_point_unloaded(const thrum_contact_run *run, const double *rows, const double lever[3],
                          double out[3]) {
  thrum_point_shape(run, rows, run->view.unloaded, out);
  add_whole(run->unloaded, run->unloaded_turn, lever, out);
}

void thrum_point_sought(const thrum_contact_run *run, const double *rows, const double lever[3],
                        double out[3]) {
  thrum_point_shape(run, rows, run->view.sought, out);
  add_whole(run->sought, run->sought_turn, lever, out);
}

void thrum_point_motion(const thrum_contact_run *run, const double *rows, const double arm[3],
                        const double lever[3], double velocity[3], double out[3]) {
  static const double zero[3] = {0.0, 0.0, 0.0};
  const thrum_translation *translation = run->environment->translation;
  double v[3], d[3];
  thrum_rows_times_both(run->contact->rank, rows, run->view.p, run->view.unloaded, v, d);
  thrum_apply3(run->axes, v, velocity);
  thrum_apply3(run->axes, d, out);

  // what moves the body as a whole
  add_whole(translation ? translation->velocity : zero, run->spin, arm, velocity);
  add_whole(run->unloaded, run->unloaded_turn, lever, out);
}

void thrum_point_moved(const thrum_contact_run *run, const double *rows, const double lever[3],
                       const double *d, double out[3]) {
  thrum_point_shape(run, rows, d, out);
  add_whole(run->moved, run->turned, lever, out);
}

void thrum_direction_moved(const thrum_contact_run *run, const double *rows, const double lever[3],
                           const double *d, double out[3]) {
  static const double zero[3] = {0.0, 0.0, 0.0};
  thrum_point_shape(run, rows, d, out);
  add_whole(zero, run->turned, lever, out);
}

double thrum_point_since(const double at[3], double seen[3]) {
  const double off[3] = {at[0] - seen[0], at[1] - seen[1], at[2] - seen[2]};
  memcpy(seen, at, 3 * sizeof *seen);
  return sqrt(thrum_dot3(off, off));
}

void thrum_shape_push(thrum_contact_run *run, const double *rows, const double force[3]) {
  double own[3];
  thrum_apply3_transposed(run->axes, force, own);
  if (is_wide(run->contact->rank))
    push_wide(run->contact->rank, rows, own, run->view.weights, run->view.moved);
  else
    thrum_rows_push(run->contact->rank, rows, own, run->view.weights, run->view.moved);
}

void thrum_direction_push(thrum_contact_run *run, const double *rows, const double lever[3],
                          const double force[3]) {
  double torque[3], turned[3];
  thrum_shape_push(run, rows, force);

  // zero weights are no zero angle where the torque is beyond the finite numbers
  if (!run->environment->rigid_frame)
    return;
  thrum_cross3(lever, force, torque);
  thrum_apply3(run->turn_weight, torque, turned);
  for (int axis = 0; axis < 3; axis++)
    run->turned[axis] += turned[axis];
}

void thrum_point_push(thrum_contact_run *run, const double *rows, const double lever[3],
                      const double force[3]) {
  thrum_direction_push(run, rows, lever, force);
  for (int axis = 0; axis < 3 && run->mass_weight > 0.0; axis++)
    run->moved[axis] += run->mass_weight * force[axis];
}

void thrum_shape_load(thrum_contact_run *run, const double *rows, const double force[3]) {
  double own[3];
  thrum_apply3_transposed(run->axes, force, own);
  thrum_rows_push(run->contact->rank, rows, own, NULL, run->view.load);
}

void thrum_direction_load(thrum_contact_run *run, const double *rows, const double lever[3],
                          const double force[3]) {
  double torque[3];
  thrum_shape_load(run, rows, force);
  thrum_cross3(lever, force, torque);
  for (int axis = 0; axis < 3; axis++)
    run->torque[axis] += torque[axis];
}

void thrum_point_load(thrum_contact_run *run, const double *rows, const double lever[3],
                      const double force[3]) {
  thrum_direction_load(run, rows, lever, force);
  for (int axis = 0; axis < 3; axis++)
    run->force[axis] += force[axis];
}

/* response += [lever]^T turn_weight [lever], of the rotation. */
static void add_rigid_frame(const thrum_contact_run *run, const double lever[3],
                            double response[9]) {
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    double torque[3], turned[3], moved[3];
    thrum_cross3(lever, unit, torque);
    thrum_apply3(run->turn_weight, torque, turned);
    thrum_cross3(turned, lever, moved);
    for (int i = 0; i < 3; i++)
      response[3 * i + axis] += moved[i];
  }
}

/* The response of the shape to a force on a point, and of its mean motion by `whole` [m/N]. */
static void respond(const thrum_contact_run *run, const double *rows, double whole,
                    double response[9]) {
  // the sum over the modes of weight times row times row, in the frame of the body
  double sum[9], half[9];
  thrum_rows_square(run->contact->rank, rows, run->view.weights, sum);

  // turned into the world from both sides
  for (int a = 0; a < 3; a++)
    thrum_apply3(run->axes, sum + 3 * a, half + 3 * a);

  // half is (axes sum)^T, as sum is symmetric
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const double *row = run->axes + 3 * a;
      response[3 * a + b] =
          row[0] * half[b] + row[1] * half[3 + b] + row[2] * half[6 + b] + (a == b ? whole : 0.0);
    }
}

void thrum_point_response(const thrum_contact_run *run, const double *rows, const double lever[3],
                          double response[9]) {
  respond(run, rows, run->mass_weight, response);

  // a free body answers by its translation and rotation too
  add_rigid_frame(run, lever, response);
}

void thrum_shape_response(const thrum_contact_run *run, const double *rows, double response[9]) {
  respond(run, rows, 0.0, response);
}
