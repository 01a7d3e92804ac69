/* Learned gradients of cubature points, see cubature_refine.h.
 *
 * With g = G q and the residual e = scale (sum_p P_p : G_p - R), the objective is |e|^2 / 2 in the
 * mean over states. Its derivative by G_p is P_p e^T + (dP_p along G_p e) q^T, as dP is symmetric:
 * products of matrices throughout, five of states x 9 points x rank.
 *
 * Steps are those of Adam, with a rate that falls to zero as half a cosine. Batches follow each
 * other in the order of the states, which are random, so that the same input gives the same points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/cubature_refine.h"

#include <cblas.h>
#include <math.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/polynomial/quartic_stress.h"

#define ROWS 9             /* components of a gradient */
#define RATE 1e-3          /* of the first step, over the rms of the gradients */
#define MEAN_DECAY 0.9     /* of the mean of slopes */
#define SQUARE_DECAY 0.999 /* of the mean of their squares */
#define LEAST 1e-8         /* slope below which nothing moves, over the rms of the first */
#define REPORTS 200        /* of progress */
#define PI 3.14159265358979323846

int64_t thrum_refine_work(const thrum_free_points *points, int64_t states) {
  return states * (3 * ROWS * points->count + points->rank);
}

/* product (states x 9 points) = rows (states x rank) gradients^T. */
static void along_gradients(const thrum_free_points *points, int64_t states, const double *rows,
                            double *product) {
  const int n = (int)(ROWS * points->count), r = (int)points->rank;
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, (int)states, n, r, 1, rows, r,
              points->gradients, r, 0, product, n);
}

/* The stress at each point of each state. */
static void take_stresses(const thrum_free_points *points, int64_t states, const double *gradient,
                          double *stress) {
  for (int64_t n = 0; n < states * points->count; n++) {
    const int64_t p = n % points->count;
    double g[3][3], at[3][3];
    memcpy(g, gradient + ROWS * n, sizeof g);
    thrum_quartic_stress(points->lambda[p], points->mu[p], g, at);
    memcpy(stress + ROWS * n, at, sizeof at);
  }
}

/* What stands in `along` becomes the change of the stress along it. */
static void take_tangents(const thrum_free_points *points, int64_t states, const double *gradient,
                          double *along) {
  for (int64_t n = 0; n < states * points->count; n++) {
    const int64_t p = n % points->count;
    double g[3][3], d[3][3], change[3][3];
    memcpy(g, gradient + ROWS * n, sizeof g);
    memcpy(d, along + ROWS * n, sizeof d);
    thrum_quartic_tangent(points->lambda[p], points->mu[p], g, d, change);
    memcpy(along + ROWS * n, change, sizeof change);
  }
}

double thrum_refine_objective(const thrum_free_points *points, const thrum_force_samples *samples,
                              int64_t first, int64_t count, double *slope, double *work) {
  const int n = (int)(ROWS * points->count), r = (int)points->rank, states = (int)count;
  const double *q = samples->q + first * r, *force = samples->force + first * r;
  double *gradient = work, *stress = gradient + count * n, *along = stress + count * n,
         *residual = along + count * n;

  // forces of the points
  along_gradients(points, count, q, gradient);
  take_stresses(points, count, gradient, stress);
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, states, r, n, 1, stress, n,
              points->gradients, r, 0, residual, r);

  // how far they are off; for the slope times the scale once more
  double sum = 0;
  for (int64_t s = 0; s < count; s++)
    for (int64_t i = 0; i < r; i++) {
      const double scale = samples->scale[first + s];
      const double off = scale * residual[s * r + i] - force[s * r + i];
      sum += off * off;
      residual[s * r + i] = scale * off;
    }
  if (!slope)
    return sum / (2 * (double)count);

  // stresses by residuals, and changes of the stress by states
  along_gradients(points, count, residual, along);
  take_tangents(points, count, gradient, along);
  const double share = 1 / (double)count;
  cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, r, states, share, stress, n, residual, r,
              0, slope, r);
  cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, r, states, share, along, n, q, r, 1,
              slope, r);
  return sum / (2 * (double)count);
}

double thrum_refine_error(const thrum_free_points *points, const thrum_force_samples *samples,
                          double *work) {
  double sum = 0;
  for (int64_t s = 0; s < samples->count; s += THRUM_REFINE_BATCH) {
    const int64_t left = samples->count - s,
                  count = left < THRUM_REFINE_BATCH ? left : THRUM_REFINE_BATCH;
    sum += 2 * (double)count * thrum_refine_objective(points, samples, s, count, NULL, work);
  }
  return sqrt(sum / (double)samples->count);
}

static double rms(int64_t count, const double *x) {
  return cblas_dnrm2((int)count, x, 1) / sqrt((double)count);
}

/* What Adam remembers of the steps before. */
typedef struct adam {
  int64_t count;
  double rate, least;
  double *slope, *mean, *square; /* count */
  double kept_mean, kept_square; /* MEAN_DECAY and SQUARE_DECAY to the number of the step */
} adam;

/* One step, of which `share` of the rate is taken. */
static void adam_step(adam *a, double share, double *x) {
  a->kept_mean *= MEAN_DECAY;
  a->kept_square *= SQUARE_DECAY;
  const double rate = a->rate * share / (1 - a->kept_mean), whole = 1 / (1 - a->kept_square);
  for (int64_t i = 0; i < a->count; i++) {
    a->mean[i] += (1 - MEAN_DECAY) * (a->slope[i] - a->mean[i]);
    a->square[i] += (1 - SQUARE_DECAY) * (a->slope[i] * a->slope[i] - a->square[i]);
    x[i] -= rate * a->mean[i] / (sqrt(a->square[i] * whole) + a->least);
  }
}

/* All steps. */
static thrum_status descend(const thrum_force_samples *samples, int64_t steps, adam *a,
                            thrum_free_points *points, double *work, const thrum_reporter *reporter,
                            double begin, thrum_error *error) {
  const int64_t batches = samples->count / THRUM_REFINE_BATCH, pause = 1 + steps / REPORTS;
  a->rate = RATE * rms(a->count, points->gradients);
  a->kept_mean = a->kept_square = 1;
  for (int64_t n = 0; n < steps; n++) {
    const double part = (double)n / (double)steps;
    thrum_refine_objective(points, samples, n % batches * THRUM_REFINE_BATCH, THRUM_REFINE_BATCH,
                           a->slope, work);
    if (n == 0)
      a->least = LEAST * rms(a->count, a->slope);
    if (!(a->least > 0))
      return THRUM_OK;
    adam_step(a, 0.5 * (1 + cos(PI * part)), points->gradients);
    if (n % pause == 0)
      THRUM_TRY(thrum_report(reporter, begin + (1 - begin) * part, error));
  }
  return THRUM_OK;
}

thrum_status thrum_cubature_refine(const thrum_force_samples *samples, int64_t steps,
                                   thrum_free_points *points, const thrum_reporter *reporter,
                                   double begin, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the cubature", error);
  adam a = {.count = ROWS * points->count * points->rank};
#define NEED(count) thrum_scope_allocate(&memory, (count), sizeof(double))
  a.slope = NEED(a.count);
  a.mean = NEED(a.count);
  a.square = NEED(a.count);
  double *before = NEED(a.count), *work = NEED(thrum_refine_work(points, THRUM_REFINE_BATCH));
#undef NEED
  thrum_status status = memory.status;

  // what gains nothing is taken back
  if (status >= 0) {
    const size_t bytes = (size_t)a.count * sizeof *before;
    memcpy(before, points->gradients, bytes);
    const double at_first = thrum_refine_error(points, samples, work);
    status = descend(samples, steps, &a, points, work, reporter, begin, error);
    if (status < 0 || !(thrum_refine_error(points, samples, work) < at_first))
      memcpy(points->gradients, before, bytes);
  }
  thrum_scope_free(&memory);
  return status;
}
