/* A reduced body in plain C, without heap, for controllers: strain energy, force, tangent stiffness
 * and two integrators. It needs math.h alone, and all its numbers are constants.
 *
 *   V(q) = 1/2 sum omega_i^2 q_i^2 + cubic + quartic terms, exact for a St. Venant-Kirchhoff
 *   material;   q'' + D q' + R(q) = f,   R the gradient of V,   u = U q the displacement
 *
 * q [m kg^1/2], p = dq/dt, f [N kg^-1/2]; the basis is mass-orthonormal. SI units. No function
 * keeps anything: `memory` is scratch of BODY_MEMORY(BODY_RANK) doubles that the caller owns, and
 * each thread has its own. Compile with -ffp-contract=off: energy and force then have the same bits
 * on every machine. */
#ifndef BODY_CODE_H
#define BODY_CODE_H

#include <math.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

/* Columns of the coefficients: a product of two coordinates, or one alone, for each. */
#define BODY_COLUMNS(rank) ((rank) * ((rank) + 3) / 2)

/* Doubles that an evaluation and a step need, and two square matrices. */
#define BODY_MEMORY(rank) (2 * BODY_COLUMNS(rank) + 20 * (rank) + 2 + 2 * (rank) * (rank))

typedef struct body_numbers {
  int rank;             /* coordinates */
  const double *omega2; /* (rank), squared angular frequencies [1/s^2] */
  /* Cubic and quartic terms q_d q_c q_b q_a, n > d >= c >= b >= a >= -1 with q_{-1} = 1: for each c
   * the rows d = n-1 .. c, in a row the columns (b, a), b <= c, a fastest. */
  const double *coefficients;
  const unsigned char *follows; /* (rank), 1: follows the square of a much softer coordinate */
} body_numbers;

/* What an evaluation works on. */
typedef struct body_scratch {
  double *products, *weights;         /* by column: q_b q_a, and the terms of V beside it */
  double *lifted;                     /* 1, q */
  double *row, *column, *sums, *more; /* parts of the gradient */
  double *lanes;                      /* eight partial sums for each coordinate */
} body_scratch;

/* --- sums ------------------------------------------------------------------------------------ */

/* Eight partial sums become one, always in this order. */
static inline double body_lanes_sum(const double lane[8]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/* lane += row . products, and weights += x row unless it is 0. */
static inline void body_row(int count, const double *row, const double *products, double x,
                            double *weights, double *lane) {
  int i;
  for (i = 0; i < count; i++)
    lane[i % 8] += row[i] * products[i];
  for (i = 0; weights && i < count; i++)
    weights[i] += x * row[i];
}

static inline double body_dot(int count, const double *a, const double *b) {
  double lane[8] = {0};
  body_row(count, a, b, 0.0, 0, lane);
  return body_lanes_sum(lane);
}

/* Each coordinate's eight sums as one; they begin again at 0. */
static inline void body_gather(int n, double *lanes, double *sums) {
  int i;
  for (i = 0; i < n; i++)
    sums[i] = body_lanes_sum(lanes + 8 * i);
  for (i = 0; i < 8 * n; i++)
    lanes[i] = 0.0;
}

/* --- energy, force, tangent ------------------------------------------------------------------ */

/* Cuts the scratch from `memory`, all 0 but the coordinates and their products. */
static inline body_scratch body_begin(int n, const double *q, double *memory) {
  body_scratch s;
  int a, b, at = 0;
  s.products = memory;
  s.weights = s.products + BODY_COLUMNS(n);
  s.lifted = s.weights + BODY_COLUMNS(n);
  s.row = s.lifted + n + 1;
  s.column = s.row + n;
  s.sums = s.column + n + 1;
  s.more = s.sums + n;
  s.lanes = s.more + n;
  for (a = 0; a < 2 * BODY_COLUMNS(n) + 13 * n + 2; a++)
    memory[a] = 0.0;

  // a cubic term is a quartic one with a fourth factor 1
  s.lifted[0] = 1.0;
  for (a = 0; a < n; a++)
    s.lifted[a + 1] = q[a];
  for (b = 0; b < n; b++)
    for (a = 0; a < b + 2; a++)
      s.products[at++] = q[b] * s.lifted[a];
  return s;
}

/* The terms of degree 2. */
static inline double body_quadratic(const body_numbers *body, const double *q) {
  double sum = 0.0;
  int i;
  for (i = 0; i < body->rank; i++)
    sum += 0.5 * body->omega2[i] * q[i] * q[i];
  return sum;
}

/* One pass over the coefficients, with the weights of the columns if they are wanted. */
static inline void body_pass(const body_numbers *body, const double *q, int weighted,
                             const body_scratch *s) {
  const int n = body->rank;
  const double *row = body->coefficients;
  int c, d;
  for (c = 0; c < n; c++) {
    for (d = n - 1; d >= c; d--) {
      double lane[8] = {0}, sum;
      body_row(BODY_COLUMNS(c + 1), row, s->products, q[c] * q[d], weighted ? s->weights : 0, lane);
      sum = body_lanes_sum(lane);
      s->row[d] += q[c] * sum;
      s->lanes[8 * c + (n - 1 - d) % 8] += sum * q[d];
      row += BODY_COLUMNS(c + 1);
    }
  }
  body_gather(n, s->lanes, s->sums);
}

/* Strain energy V(q) [J]. q: (rank). */
static inline double body_energy(const body_numbers *body, const double *q, double *memory) {
  const body_scratch s = body_begin(body->rank, q, memory);
  body_pass(body, q, 0, &s);
  return body_quadratic(body, q) + body_dot(body->rank, q, s.sums);
}

/* Internal force R(q), the gradient of V, into `force` (rank); returns V. */
static inline double body_force(const body_numbers *body, const double *q, double *force,
                                double *memory) {
  const int n = body->rank;
  const body_scratch s = body_begin(n, q, memory);
  const double *weights = s.weights;
  int b, i;
  body_pass(body, q, 1, &s);

  // the columns meet both of their coordinates
  for (b = 0; b < n; b++) {
    body_row(b + 2, weights, s.lifted, q[b], s.column, s.lanes + 8 * b);
    weights += b + 2;
  }
  body_gather(n, s.lanes, s.more);
  for (i = 0; i < n; i++)
    force[i] = body->omega2[i] * q[i] + ((s.row[i] + s.column[i + 1]) + (s.sums[i] + s.more[i]));
  return body_quadratic(body, q) + body_dot(n, q, s.sums);
}

/* Tangent stiffness T(q), the second derivative of V, into `tangent` (rank x rank). */
static inline void body_tangent(const body_numbers *body, const double *q, double *tangent,
                                double *memory) {
  const int n = body->rank;
  const body_scratch s = body_begin(n, q, memory);
  const double *row = body->coefficients;
  double *slope = s.row, *at; /* of what meets q_d q_c */
  int a, b, c, d;

  // half of it first: it is added to its mirror image at the end
  for (a = 0; a < n * n; a++)
    tangent[a] = 0.0;
  for (c = 0; c < n; c++) {
    for (d = n - 1; d >= c; d--) {
      tangent[d * n + c] += body_dot(BODY_COLUMNS(c + 1), row, s.products);
      for (b = 0; b <= c; b++)
        slope[b] = 0.0;

      // one derivative by a column, the other by a coordinate of the row
      at = s.weights;
      for (b = 0; b <= c; b++) {
        for (a = 0; a < b + 2; a++, row++) {
          slope[b] += *row * s.lifted[a];
          if (a > 0)
            slope[a - 1] += *row * q[b];
          *at++ += q[c] * q[d] * *row;
        }
      }
      for (b = 0; b <= c; b++) {
        tangent[d * n + b] += q[c] * slope[b];
        tangent[c * n + b] += q[d] * slope[b];
      }
    }
  }

  // both derivatives by the columns, then the other half
  at = s.weights;
  for (b = 0; b < n; b++) {
    at++;
    for (a = 0; a <= b; a++)
      tangent[b * n + a] += *at++;
  }
  for (b = 0; b < n; b++) {
    for (a = 0; a < b; a++)
      tangent[b * n + a] = tangent[a * n + b] = tangent[b * n + a] + tangent[a * n + b];
    tangent[b * n + b] = 2.0 * tangent[b * n + b] + body->omega2[b];
  }
}

/* --- places ---------------------------------------------------------------------------------- */

/* u = rows q, with the rows of a place (3 x rank): its displacement [m], or of dq/dt its velocity.
 */
static inline void body_displacement(const body_numbers *body, const double *rows, const double *q,
                                     double u[3]) {
  int axis, i;
  for (axis = 0; axis < 3; axis++) {
    u[axis] = 0.0;
    for (i = 0; i < body->rank; i++)
      u[axis] += rows[axis * body->rank + i] * q[i];
  }
}

/* f += rows^T newtons: a force [N] on a place, or an acceleration [m/s^2] with the rows of mass. */
static inline void body_pull(const body_numbers *body, const double *rows, const double newtons[3],
                             double *f) {
  int axis, i;
  for (axis = 0; axis < 3; axis++)
    for (i = 0; i < body->rank; i++)
      f[i] += rows[axis * body->rank + i] * newtons[axis];
}

/* --- steps ----------------------------------------------------------------------------------- */

/* x = matrix^-1 x by elimination with row exchanges; the matrix is used up. */
static inline void body_solve(int n, double *matrix, double *x) {
  int i, j, k;
  for (k = 0; k < n; k++) {
    int pivot = k;
    for (i = k + 1; i < n; i++)
      if (fabs(matrix[i * n + k]) > fabs(matrix[pivot * n + k]))
        pivot = i;
    for (j = k; pivot != k && j < n; j++) {
      const double kept = matrix[k * n + j];
      matrix[k * n + j] = matrix[pivot * n + j];
      matrix[pivot * n + j] = kept;
    }
    if (pivot != k) {
      const double kept = x[k];
      x[k] = x[pivot];
      x[pivot] = kept;
    }

    // the rows below lose their entry of this column
    for (i = k + 1; i < n; i++) {
      const double factor = matrix[i * n + k] / matrix[k * n + k];
      for (j = k + 1; j < n; j++)
        matrix[i * n + j] -= factor * matrix[k * n + j];
      x[i] -= factor * x[k];
    }
  }
  for (k = n - 1; k >= 0; k--) {
    for (j = k + 1; j < n; j++)
      x[k] -= matrix[k * n + j] * x[j];
    x[k] /= matrix[k * n + k];
  }
}

static inline double body_largest(int n, const double *x) {
  double most = 0.0;
  int i;
  for (i = 0; i < n; i++)
    most = fabs(x[i]) <= most ? most : fabs(x[i]);
  return most;
}

/* d -= correction; returns 1 where the next one would be below rounding. */
static inline int body_correct(int n, const double *q, const double *correction, double *d) {
  int i;
  for (i = 0; i < n; i++)
    d[i] -= correction[i];
  return body_largest(n, correction) <= 1e-10 * body_largest(n, d) + 1e-13 * body_largest(n, q);
}

/* q += d, p = 2 d / length - p, where it is finite; returns `iterations`, or 0. */
static inline int body_commit(int n, const double *d, const double *length, int iterations,
                              double *q, double *p) {
  int i;
  for (i = 0; i < n; i++)
    if (!(fabs(q[i] + d[i]) < 1e300 && fabs(2.0 * d[i] / length[i] - p[i]) < 1e300))
      return 0;
  for (i = 0; i < n; i++) {
    q[i] += d[i];
    p[i] = 2.0 * d[i] / length[i] - p[i];
  }
  return iterations;
}

/* One step of h [s] by the implicit midpoint rule, with damping D = alpha + beta omega^2 [1/s]
 * under the load f (rank). Newton's method takes `most` iterations at most; returns how many it
 * took, or 0 where they did not suffice: then q and p stay as they are. */
static inline int body_step_midpoint(const body_numbers *body, double *q, double *p,
                                     const double *f, double h, double alpha, double beta, int most,
                                     double *memory) {
  const int n = body->rank;
  double *jacobian = memory + 2 * BODY_COLUMNS(n) + 13 * n + 2;
  double *d = jacobian + 2 * n * n, *middle = d + n, *residual = middle + n, *length = residual + n;
  int i, j, k;
  for (i = 0; i < n; i++) {
    d[i] = h * p[i];
    length[i] = h;
  }

  for (k = 1; k <= most; k++) {
    for (i = 0; i < n; i++)
      middle[i] = q[i] + 0.5 * d[i];
    body_force(body, middle, residual, memory);
    body_tangent(body, middle, jacobian, memory);
    for (i = 0; i < n; i++) {
      const double damping = alpha + beta * body->omega2[i];
      residual[i] = d[i] - h * p[i] + 0.5 * h * h * (residual[i] + damping * d[i] / h - f[i]);
      for (j = 0; j < n; j++)
        jacobian[i * n + j] *= 0.25 * h * h;
      jacobian[i * n + i] += 1.0 + 0.5 * h * damping;
    }

    body_solve(n, jacobian, residual);
    if (body_correct(n, q, residual, d))
      return body_commit(n, d, length, k, q, p);
  }
  return 0;
}

/* The length of a step of h for coordinate i, at which a mode with h omega <= 1 turns at its own
 * frequency, and its damping over the length. */
static inline double body_own_length(const body_numbers *body, int i, double h, double alpha,
                                     double beta, double *damping) {
  const double x = 0.5 * h * sqrt(body->omega2[i]);
  const int own = !body->follows[i] && x > 0.0 && 2.0 * x <= 1.0;
  const double weight = own ? x / sin(x) : 1.0;
  *damping = (alpha + beta * body->omega2[i]) * weight * weight / h;
  return own ? h * tan(x) / x : h;
}

/* As body_step_midpoint, by a discrete gradient of V that conserves the energy where nothing pulls
 * or damps: the mean of both end forces, plus sigma d with which R_mean . d = V(q + d) - V(q). */
static inline int body_step_energy(const body_numbers *body, double *q, double *p, const double *f,
                                   double h, double alpha, double beta, int most, double *memory) {
  const int n = body->rank;
  double *first = memory + 2 * BODY_COLUMNS(n) + 13 * n + 2, *jacobian = first + n * n;
  double *d = jacobian + n * n, *end = d + n, *start = end + n, *force = start + n;
  double *length = force + n, *damping = length + n, *turned = damping + n;
  int i, j, k;
  body_force(body, q, start, memory);
  body_tangent(body, q, first, memory);
  for (i = 0; i < n; i++) {
    length[i] = body_own_length(body, i, h, alpha, beta, damping + i);
    d[i] = length[i] * p[i];
  }

  for (k = 1; k <= most; k++) {
    const double square = body_dot(n, d, d) + 1e-300;
    double sigma = 0.0;
    for (i = 0; i < n; i++)
      end[i] = q[i] + d[i];
    body_force(body, end, force, memory);
    body_tangent(body, end, jacobian, memory);

    // sigma, and T d of the end, of which its slope is made
    for (i = 0; i < n; i++) {
      turned[i] = body_dot(n, jacobian + i * n, d);
      sigma -= d[i] * (turned[i] - body_dot(n, first + i * n, d));
    }
    sigma /= 12.0 * square;
    for (j = 0; j < n; j++)
      turned[j] = (0.5 * (force[j] - start[j]) - 0.5 * turned[j] - 2.0 * sigma * d[j]) / square;

    // the equation of the step in the place of the force, and its derivative
    for (i = 0; i < n; i++) {
      const double half = 0.5 * length[i] * length[i];
      for (j = 0; j < n; j++)
        jacobian[i * n + j] = half * (0.5 * jacobian[i * n + j] + d[i] * turned[j]);
      jacobian[i * n + i] += 1.0 + half * (sigma + damping[i]);
      force[i] = d[i] - length[i] * p[i] +
                 half * (0.5 * (start[i] + force[i]) + (sigma + damping[i]) * d[i] - f[i]);
    }

    body_solve(n, jacobian, force);
    if (body_correct(n, q, force, d))
      return body_commit(n, d, length, k, q, p);
  }
  return 0;
}

#endif
