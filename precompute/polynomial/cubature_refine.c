/* Learned gradients of cubature points, see cubature_refine.h.
 *
 * With g = G q and the residual e = scale (sum_p P_p : G_p - R), the objective is |e|^2 / 2 in the
 * mean over states. Its derivative by G_p is P_p e^T + (dP_p along G_p e) q^T, as dP is symmetric:
 * products of matrices throughout, five of states x 9 points x rank.
 *
 * Steps are those of soap.h along the slopes of refine_slope.h, in single precision, with a
 * rate that falls to zero as half a cosine. Errors are judged in double precision. Batches follow
 * each other in the order of the states, which are random, so that the same input gives the same
 * points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/cubature_refine.h"

#include <cblas.h>
#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "platform/allocate.h"
#include "precompute/polynomial/quartic_stress.h"
#include "precompute/polynomial/refine_slope.h"
#include "precompute/polynomial/soap.h"

#define ROWS 9      /* components of a gradient */
#define RATE 3e-3   /* of the first step, over the rms of the gradients */
#define LEAST 1e-8f /* slope below which nothing moves, over the rms of the first */
#define REPORTS 200 /* of progress */

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

static thrum_law law_of(const thrum_free_points *points, int64_t p) {
  return points->laws ? points->laws[p] : THRUM_LAW_STVK;
}

/* The stress at each point of each state. */
static void take_stresses(const thrum_free_points *points, int64_t states, const double *gradient,
                          double *stress) {
  for (int64_t n = 0; n < states * points->count; n++) {
    const int64_t p = n % points->count;
    double g[3][3], at[3][3];
    memcpy(g, gradient + ROWS * n, sizeof g);
    thrum_nonlinear_stress(law_of(points, p), points->lambda[p], points->mu[p], g, at);
    memcpy(stress + ROWS * n, at, sizeof at);
  }
}

/* Makes each gradient in `along` the change of the stress along it. */
static void take_tangents(const thrum_free_points *points, int64_t states, const double *gradient,
                          double *along) {
  for (int64_t n = 0; n < states * points->count; n++) {
    const int64_t p = n % points->count;
    double g[3][3], d[3][3], change[3][3];
    memcpy(g, gradient + ROWS * n, sizeof g);
    memcpy(d, along + ROWS * n, sizeof d);
    thrum_nonlinear_tangent(law_of(points, p), points->lambda[p], points->mu[p], g, d, change);
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

/* Points, a batch of states and all that a descent needs, as single-precision numbers in units in
 * which the gradients have the rms 1 and the largest modulus is 1. */
typedef struct descent {
  int64_t count, rank;
  const thrum_law *laws;  /* borrowed; NULL: as of the points */
  double length, modulus; /* of the units */
  float *lambda, *mu, *gradients, *q, *force, *scale, *slope, *work;
  thrum_soap soap;
} descent;

static double rms(int64_t count, const double *x) {
  return cblas_dnrm2((int)count, x, 1) / sqrt((double)count);
}

/* Row c n + p of the gradients in single precision is row 9 p + c of the points. */
static double *row_of(const thrum_free_points *points, int64_t row) {
  const int64_t n = points->count;
  return points->gradients + (ROWS * (row % n) + row / n) * points->rank;
}

static descent descent_begin(const thrum_free_points *points, thrum_scope *memory) {
  const int64_t n = points->count, r = points->rank, states = THRUM_REFINE_BATCH;
  descent of = {
      .count = n, .rank = r, .laws = points->laws, .length = rms(ROWS * n * r, points->gradients)};

  // all arrays
#define NEED(count) thrum_scope_allocate(memory, (count), sizeof(float))
  of.lambda = NEED(n);
  of.mu = NEED(n);
  of.gradients = NEED(ROWS * n * r);
  of.slope = NEED(ROWS * n * r);
  of.q = NEED(states * r);
  of.force = NEED(states * r);
  of.scale = NEED(states);
  of.work = NEED(thrum_refine_slope_work(n, r, states));
#undef NEED
  of.soap = thrum_soap_begin(n, r, (float)RATE, memory);
  if (memory->status < 0)
    return of;

  // moduli and gradients in their units
  for (int64_t p = 0; p < n; p++)
    of.modulus = fmax(of.modulus, fmax(fabs(points->lambda[p]), points->mu[p]));
  for (int64_t p = 0; p < n; p++) {
    of.lambda[p] = (float)(points->lambda[p] / of.modulus);
    of.mu[p] = (float)(points->mu[p] / of.modulus);
  }
  for (int64_t row = 0; row < ROWS * n; row++)
    for (int64_t i = 0; i < r; i++)
      of.gradients[row * r + i] = (float)(row_of(points, row)[i] / of.length);
  return of;
}

/* The slope in the batch from state `first` on. */
static void batch_slope(descent *of, const thrum_force_samples *samples, int64_t first) {
  const int64_t r = of->rank;
  for (int64_t s = 0; s < THRUM_REFINE_BATCH; s++) {
    of->scale[s] = (float)(samples->scale[first + s] * of->length * of->modulus);
    for (int64_t i = 0; i < r; i++) {
      of->q[s * r + i] = (float)(samples->q[(first + s) * r + i] * of->length);
      of->force[s * r + i] = (float)samples->force[(first + s) * r + i];
    }
  }
  const thrum_single_points points = {of->count, r, of->laws, of->lambda, of->mu, of->gradients};
  const thrum_single_samples batch = {THRUM_REFINE_BATCH, of->q, of->force, of->scale};
  thrum_refine_slope(&points, &batch, of->slope, of->work);
}

/* All steps. */
static thrum_status descend(const thrum_force_samples *samples, int64_t steps, descent *of,
                            const thrum_reporter *reporter, double begin, thrum_error *error) {
  const int64_t batches = samples->count / THRUM_REFINE_BATCH, pause = 1 + steps / REPORTS;
  const int64_t numbers = ROWS * of->count * of->rank;
  for (int64_t n = 0; n < steps; n++) {
    const double part = (double)n / (double)steps;
    batch_slope(of, samples, n % batches * THRUM_REFINE_BATCH);
    if (n == 0)
      of->soap.least = LEAST * cblas_snrm2((int)numbers, of->slope, 1) / sqrtf((float)numbers);
    if (!(of->soap.least > 0))
      return THRUM_OK;
    THRUM_TRY(thrum_soap_step(&of->soap, of->slope, 0.5 * (1 + cos(THRUM_PI * part)), of->gradients,
                              error));
    if (n % pause == 0)
      THRUM_TRY(thrum_report(reporter, begin + (1 - begin) * part, error));
  }
  return THRUM_OK;
}

/* The gradients of a descent back into the points. */
static void put_back(const descent *of, thrum_free_points *points) {
  for (int64_t row = 0; row < ROWS * of->count; row++)
    for (int64_t i = 0; i < of->rank; i++)
      row_of(points, row)[i] = of->gradients[row * of->rank + i] * of->length;
}

thrum_status thrum_cubature_refine(const thrum_force_samples *samples, int64_t steps,
                                   thrum_free_points *points, const thrum_reporter *reporter,
                                   double begin, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the cubature", error);
  const int64_t numbers = ROWS * points->count * points->rank;
  const size_t bytes = (size_t)numbers * sizeof(double);
  double *before = thrum_scope_allocate(&memory, numbers, sizeof(double));
  double *work =
      thrum_scope_allocate(&memory, thrum_refine_work(points, THRUM_REFINE_BATCH), sizeof(double));
  descent of = descent_begin(points, &memory);
  thrum_status status = memory.status;

  // what gains nothing is taken back
  if (status >= 0) {
    memcpy(before, points->gradients, bytes);
    const double at_first = thrum_refine_error(points, samples, work);
    status = descend(samples, steps, &of, reporter, begin, error);
    put_back(&of, points);
    if (status < 0 || !(thrum_refine_error(points, samples, work) < at_first))
      memcpy(points->gradients, before, bytes);
  }
  thrum_scope_free(&memory);
  return status;
}
