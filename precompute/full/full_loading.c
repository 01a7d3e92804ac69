/* Loads that turn with a group of vertices, and groups that are turned.
 *
 * A follower's forces are Q g_v: g_v at rest, Q the rotation that takes the offsets r_v of the
 * group's vertices from their mean nearest to the present ones d_v (Horn 1987,
 * doi:10.1364/JOSAA.4.000629). A moment m is g_v = J^-1 m x r_v, J = sum |r|^2 1 - r r^T. Where
 * vertices move by du, Q turns by dw: H dw = sum Q r x du, H = sum (Q r . d) 1 - Q r d^T, and the
 * forces change by dw x Q g: three products of a column and a row for each follower.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/full/full_loading.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"

#define FLAT 1e-9 /* least share of an inertia that counts as one */

/* --- rotations -------------------------------------------------------------------------------- */

static int64_t member(const int32_t *vertices, int64_t k) {
  return vertices != NULL ? vertices[k] : k;
}

/* The mean over a group of a field, or of rest + field. */
static void mean_of(const int32_t *vertices, int64_t count, const double *rest, const double *field,
                    double mean[3]) {
  mean[0] = mean[1] = mean[2] = 0;
  for (int64_t k = 0; k < count; k++) {
    const int64_t v = member(vertices, k);
    for (int axis = 0; axis < 3; axis++)
      mean[axis] +=
          (rest[3 * v + axis] + (field != NULL ? field[3 * v + axis] : 0)) / (double)count;
  }
}

static void apply(double matrix[3][3], const double vector[3], double out[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = thrum_dot3(matrix[i], vector);
}

/* The matrix of a quaternion w, x, y, z of length 1. */
static void matrix_of(const double q[4], double turn[3][3]) {
  const double w = q[0], *v = q + 1;
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    turn[i][i] = 1 - 2 * (v[j] * v[j] + v[k] * v[k]);
    turn[i][j] = 2 * (v[i] * v[j] - w * v[k]);
    turn[i][k] = 2 * (v[i] * v[k] + w * v[j]);
  }
}

/* The rotation by `share` of axis times angle. */
static void rotation(const double by[3], double share, double turn[3][3]) {
  const double angle = sqrt(thrum_dot3(by, by));
  double q[4] = {cos(share * angle / 2)};
  for (int axis = 0; axis < 3 && angle > 0; axis++)
    q[1 + axis] = sin(share * angle / 2) * by[axis] / angle;
  matrix_of(q, turn);
}

/* One sweep of Jacobi's rotations over a symmetric 4 x 4 matrix and the vectors in its columns. */
static void jacobi_sweep(double a[4][4], double vectors[4][4]) {
  for (int i = 0; i < 4; i++)
    for (int j = i + 1; j < 4; j++) {
      if (a[i][j] == 0)
        continue;

      // the rotation that makes this entry zero
      const double theta = (a[j][j] - a[i][i]) / (2 * a[i][j]);
      const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
      const double c = 1 / sqrt(t * t + 1), s = t * c;

      // it turns columns, and then rows and vectors
      for (int k = 0; k < 4; k++) {
        const double x = a[k][i], y = a[k][j];
        a[k][i] = c * x - s * y;
        a[k][j] = s * x + c * y;
      }
      for (int k = 0; k < 4; k++) {
        const double x = a[i][k], y = a[j][k], p = vectors[k][i], q = vectors[k][j];
        a[i][k] = c * x - s * y;
        a[j][k] = s * x + c * y;
        vectors[k][i] = c * p - s * q;
        vectors[k][j] = s * p + c * q;
      }
    }
}

/* The rotation nearest to sum = sum of d r^T: Horn's quaternion, the eigenvector of the largest
 * eigenvalue. It needs no inverse, so vertices in a plane will do. */
static void nearest_rotation(double sum[3][3], double turn[3][3]) {
  double a[4][4], vectors[4][4] = {{0}};
  a[0][0] = sum[0][0] + sum[1][1] + sum[2][2];
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    a[0][i + 1] = a[i + 1][0] = sum[k][j] - sum[j][k];
    a[i + 1][i + 1] = sum[i][i] - sum[j][j] - sum[k][k];
    a[i + 1][j + 1] = a[j + 1][i + 1] = sum[i][j] + sum[j][i];
  }

  // a dozen sweeps are more than any 4 x 4 matrix needs
  for (int n = 0; n < 4; n++)
    vectors[n][n] = 1;
  for (int sweep = 0; sweep < 12; sweep++)
    jacobi_sweep(a, vectors);

  int largest = 0;
  for (int n = 1; n < 4; n++)
    if (a[n][n] > a[largest][largest])
      largest = n;
  const double q[4] = {vectors[0][largest], vectors[1][largest], vectors[2][largest],
                       vectors[3][largest]};
  matrix_of(q, turn);
}

/* out = matrix^-1 right by cofactors; false where it is singular. */
static bool solve3(double matrix[3][3], const double right[3], double out[3]) {
  double cofactor[3][3];
  for (int i = 0; i < 3; i++)
    thrum_cross3(matrix[(i + 1) % 3], matrix[(i + 2) % 3], cofactor[i]);
  const double determinant = thrum_dot3(matrix[0], cofactor[0]);
  const double size = matrix[0][0] + matrix[1][1] + matrix[2][2];
  if (!(fabs(determinant) > FLAT * fabs(size * size * size)))
    return false;
  for (int i = 0; i < 3; i++)
    out[i] = (cofactor[0][i] * right[0] + cofactor[1][i] * right[1] + cofactor[2][i] * right[2]) /
             determinant;
  return true;
}

/* --- followers -------------------------------------------------------------------------------- */

/* Adds |r|^2 1 - r r^T. */
static void add_inertia(const double r[3], const double d[3], double inertia[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      inertia[i][j] += (i == j ? thrum_dot3(r, d) : 0) - r[i] * d[j];
}

/* Forces of one follower at rest, 3 for each of its vertices. */
static thrum_status forces_at_rest(const thrum_full_follower *follower, const double *rest,
                                   double *forces, thrum_error *error) {
  double mean[3], inertia[3][3] = {{0}}, spin[3];
  mean_of(follower->vertices, follower->count, rest, NULL, mean);
  for (int64_t k = 0; k < follower->count; k++) {
    double r[3];
    thrum_subtract3(rest + 3 * member(follower->vertices, k), mean, r);
    add_inertia(r, r, inertia);
  }

  // vertices on a line, or a single one, tell no rotation
  if (!solve3(inertia, follower->moment, spin))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a load that turns with its group needs vertices in a plane or in "
                           "space, and these %lld lie on a line: name a larger group, such as a "
                           "whole face",
                           (long long)follower->count);

  for (int64_t k = 0; k < follower->count; k++) {
    double r[3];
    thrum_subtract3(rest + 3 * member(follower->vertices, k), mean, r);
    thrum_cross3(spin, r, forces + 3 * k);
    for (int axis = 0; axis < 3; axis++)
      forces[3 * k + axis] += follower->force[axis] / (double)follower->count;
  }
  return THRUM_OK;
}

thrum_status full_followers_make(const thrum_full_loading *loading, const double *rest,
                                 full_followers *followers, thrum_error *error) {
  int64_t count = 0;
  for (int64_t n = 0; n < loading->follower_count; n++)
    count += loading->followers[n].count;

  // the forces of all followers in one block
  full_followers made = {.loading = loading, .rest = rest};
  THRUM_TRY(thrum_reserve(&made.at_rest, 3 * count, sizeof *made.at_rest, "the loads", error));
  double *at = made.at_rest;
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < loading->follower_count && status >= 0; n++) {
    status = forces_at_rest(&loading->followers[n], rest, at, error);
    at += 3 * loading->followers[n].count;
  }

  if (status >= 0)
    *followers = made;
  else
    free(made.at_rest);
  return status;
}

void full_followers_free(full_followers *followers) {
  free(followers->at_rest);
  *followers = (full_followers){0};
}

/* The rotation of a follower's group where it is displaced by `place`. */
static void turned_by(const full_followers *f, const thrum_full_follower *one, const double *place,
                      double turn[3][3]) {
  double before[3], now[3], sum[3][3] = {{0}};
  mean_of(one->vertices, one->count, f->rest, NULL, before);
  mean_of(one->vertices, one->count, f->rest, place, now);
  for (int64_t k = 0; k < one->count; k++) {
    const int64_t v = member(one->vertices, k);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        sum[i][j] += (f->rest[3 * v + i] + place[3 * v + i] - now[i]) * //
                     (f->rest[3 * v + j] - before[j]);
  }
  nearest_rotation(sum, turn);
}

void full_followers_add(const full_followers *followers, const double *place, double scale,
                        double *forces) {
  const double *at = followers->at_rest;
  for (int64_t n = 0; n < followers->loading->follower_count; n++) {
    const thrum_full_follower *one = &followers->loading->followers[n];
    double turn[3][3], force[3];
    turned_by(followers, one, place, turn);
    for (int64_t k = 0; k < one->count; k++, at += 3) {
      apply(turn, at, force);
      for (int axis = 0; axis < 3; axis++)
        forces[3 * member(one->vertices, k) + axis] += scale * force[axis];
    }
  }
}

/* H of the derivative of a rotation. */
static void rotation_stiffness(const full_followers *f, const thrum_full_follower *one,
                               const double *place, double turn[3][3], double h[3][3]) {
  double before[3], now[3];
  mean_of(one->vertices, one->count, f->rest, NULL, before);
  mean_of(one->vertices, one->count, f->rest, place, now);
  memset(h, 0, 9 * sizeof(double));
  for (int64_t k = 0; k < one->count; k++) {
    const int64_t v = member(one->vertices, k);
    double r[3], turned[3], d[3];
    thrum_subtract3(f->rest + 3 * v, before, r);
    apply(turn, r, turned);
    for (int axis = 0; axis < 3; axis++)
      d[axis] = f->rest[3 * v + axis] + place[3 * v + axis] - now[axis];
    add_inertia(turned, d, h);
  }
}

void full_followers_product(const full_followers *followers, const double *place, int64_t n,
                            double *turn, double *feel) {
  const thrum_full_follower *one = &followers->loading->followers[n / 3];
  const double *at = followers->at_rest;
  for (int64_t m = 0; m < n / 3; m++)
    at += 3 * followers->loading->followers[m].count;

  // row k of H^-1 is a column of the inverse of its transpose
  double q[3][3], h[3][3], transposed[3][3], row[3] = {0}, before[3];
  const double axis[3] = {n % 3 == 0, n % 3 == 1, n % 3 == 2};
  turned_by(followers, one, place, q);
  rotation_stiffness(followers, one, place, q, h);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      transposed[i][j] = h[j][i];
  if (!solve3(transposed, axis, row))
    return;

  mean_of(one->vertices, one->count, followers->rest, NULL, before);
  for (int64_t k = 0; k < one->count; k++, at += 3) {
    const int64_t v = member(one->vertices, k);
    double r[3], turned[3], force[3];
    apply(q, at, force);
    thrum_cross3(axis, force, turn + 3 * v);
    thrum_subtract3(followers->rest + 3 * v, before, r);
    apply(q, r, turned);
    thrum_cross3(row, turned, feel + 3 * v);
  }
}

/* --- turned groups ---------------------------------------------------------------------------- */

void full_turns_place(const thrum_full_loading *loading, const double *rest, const double *start,
                      double share, double *held) {
  for (int64_t n = 0; n < loading->turn_count; n++) {
    const thrum_full_turn *one = &loading->turns[n];
    double turn[3][3], from[3], at_rest[3], to[3];
    rotation(one->by, share, turn);
    mean_of(one->vertices, one->count, rest, start, from);
    mean_of(one->vertices, one->count, rest, NULL, at_rest);

    // the mean goes straight to where it is to be
    for (int axis = 0; axis < 3; axis++)
      to[axis] = one->moved ? from[axis] + share * (at_rest[axis] + one->to[axis] - from[axis])
                            : from[axis];

    for (int64_t k = 0; k < one->count; k++) {
      const int64_t v = member(one->vertices, k);
      double offset[3], turned[3];
      for (int axis = 0; axis < 3; axis++)
        offset[axis] = rest[3 * v + axis] + start[3 * v + axis] - from[axis];
      apply(turn, offset, turned);
      for (int axis = 0; axis < 3; axis++)
        held[3 * v + axis] = to[axis] + turned[axis] - rest[3 * v + axis];
    }
  }
}
