/* The step of Newton's method and the search along it, where all rows of a contact are solved at
 * once (contact_pairs_newton.c, contact_impact_newton.c).
 *
 * The matrix has a Cholesky factor, of which rows without an element in common with the one above
 * are left as they are: those of bodies that do not touch. Cost: m^3/6 where all do.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_newton.h"

#include <math.h>
#include <string.h>

#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define WIDE
#define INLINED __attribute__((always_inline))
#else
#define INLINED
#endif

#define ITERATIONS_MAX 20 /* of a solve */
#define SEARCHES_MAX 8    /* slopes along a step */
#define FLATTER 0.3       /* of the slope at the start of a step: what its end may have */

/* to += s0 b0 + s1 b1 + s2 b2, of four numbers each. */
static inline INLINED void add_four(const double s[3], const double *b, int64_t stride,
                                    double *to) {
  for (int k = 0; k < 4; k++)
    to[k] += s[0] * b[k] + s[1] * b[stride + k] + s[2] * b[2 * stride + k];
}

/* matrix += B^T change B. Each element is a sum of its own, so that lanes change no bit. */
static inline INLINED void add(const thrum_newton_columns *at, const double *restrict ways,
                               const double change[9], double *restrict pushed, int64_t stride,
                               double *restrict matrix) {
  const int64_t width = at->count[0] + at->count[1];
  memset(pushed, 0, (size_t)(3 * width) * sizeof *pushed);
  for (int axis = 0; axis < 3; axis++)
    for (int64_t q = 0; q < width; q += 4)
      add_four(change + 3 * axis, ways + q, width, pushed + axis * width + q);

  // row by row of the sum, from the four on that the diagonal is in
  for (int64_t p = 0; p < width; p++) {
    const bool second = p >= at->count[0];
    const double s[3] = {pushed[p], pushed[width + p], pushed[2 * width + p]};
    const int64_t row = second ? at->first[1] + p - at->count[0] : at->first[0] + p;
    double *restrict of = matrix + row * stride;
    for (int64_t q = p / 4 * 4; q < at->count[0]; q += 4)
      add_four(s, ways + q, width, of + at->first[0] + q);
    for (int64_t q = second ? p / 4 * 4 : at->count[0]; q < width; q += 4)
      add_four(s, ways + q, width, of + at->first[1] + q - at->count[0]);
  }
}

/* The Cholesky factor U, U^T U = matrix, row by row, from the four on that the diagonal is in. */
static inline INLINED bool factor(int64_t m, double *matrix) {
  const int64_t stride = THRUM_NEWTON_STRIDE(m);
  for (int64_t k = 0; k < m; k++) {
    double *restrict row = matrix + k * stride;
    if (!(row[k] > 0.0) || !isfinite(row[k]))
      return false;
    const double scale = 1.0 / sqrt(row[k]);
    for (int64_t q = k; q < m; q++)
      row[q] *= scale;

    // the rows below lose what this one explains
    for (int64_t p = k + 1; p < m; p++) {
      double *restrict below = matrix + p * stride;
      const double share = row[p];
      for (int64_t q = p / 4 * 4; q < stride && share != 0.0; q += 4)
        for (int n = 0; n < 4; n++)
          below[q + n] -= share * row[q + n];
    }
  }
  return true;
}

#ifdef WIDE
/* The same, four numbers in one register. */
__attribute__((target("avx2"))) static void add_wide(const thrum_newton_columns *at,
                                                     const double *ways, const double change[9],
                                                     double *pushed, int64_t stride,
                                                     double *matrix) {
  add(at, ways, change, pushed, stride, matrix);
}

__attribute__((target("avx2"))) static bool factor_wide(int64_t m, double *matrix) {
  return factor(m, matrix);
}

static bool is_wide(void) {
  return __builtin_cpu_supports("avx2");
}
#else
#define add_wide add
#define factor_wide factor

static bool is_wide(void) {
  return false;
}
#endif

void thrum_newton_add(const thrum_newton_columns *at, const double *ways, const double change[9],
                      double *pushed, int64_t stride, double *matrix) {
  if (is_wide())
    add_wide(at, ways, change, pushed, stride, matrix);
  else
    add(at, ways, change, pushed, stride, matrix);
}

bool thrum_newton_root(const double weight[9], double root[9]) {
  memset(root, 0, 9 * sizeof *root);
  root[0] = sqrt(weight[0]);
  root[3] = weight[3] / root[0];
  root[6] = weight[6] / root[0];
  root[4] = sqrt(weight[4] - root[3] * root[3]);
  root[7] = (weight[7] - root[6] * root[3]) / root[4];
  root[8] = sqrt(weight[8] - root[6] * root[6] - root[7] * root[7]);
  // a root that is none makes the last one none
  return isfinite(root[8]) && root[8] > 0.0;
}

bool thrum_newton_step(int64_t m, double *matrix, const double *gradient, double *step) {
  const int64_t stride = THRUM_NEWTON_STRIDE(m);
  if (!(is_wide() ? factor_wide(m, matrix) : factor(m, matrix)))
    return false;

  // U^T y = -gradient, then U step = y
  double square = 0.0;
  for (int64_t q = 0; q < m; q++)
    step[q] = -gradient[q];
  for (int64_t k = 0; k < m; k++) {
    const double *restrict row = matrix + k * stride;
    step[k] /= row[k];
    for (int64_t q = k + 1; q < m; q++)
      step[q] -= row[q] * step[k];
  }
  for (int64_t k = m - 1; k >= 0; k--) {
    const double *restrict row = matrix + k * stride;
    double sum = step[k];
    for (int64_t q = k + 1; q < m; q++)
      sum -= row[q] * step[q];
    step[k] = sum / row[k];
    square += step[k] * step[k];
  }

  // one number that is none spreads over all of them
  return isfinite(square);
}

double thrum_newton_search(thrum_newton_slope slope_at, const void *of, double start) {
  const double flat = FLATTER * fabs(start);

  // mostly the whole step
  double low = 0.0, high = 1.0, share = 1.0, slope = slope_at(of, 1.0);
  if (!(slope > flat))
    return share;

  // halves, towards where the slope changes its sign
  for (int n = 1; n < SEARCHES_MAX && fabs(slope) > flat; n++) {
    *(slope > 0.0 ? &high : &low) = share;
    share = 0.5 * (low + high);
    slope = slope_at(of, share);
  }
  return share;
}

/* --- the solve -------------------------------------------------------------------------------- */

/* A solve at the beginning of a step. */
typedef struct along_step {
  const thrum_newton_system *system;
  const thrum_newton_laws *laws;
  void *of;
} along_step;

static double dot(const double *a, const double *b, int64_t count) {
  double sum = 0.0;
  for (int64_t i = 0; i < count; i++)
    sum += a[i] * b[i];
  return sum;
}

/* The slope of the function at a share of the step. */
static double slope_at(const void *along, double share) {
  const along_step *at = along;
  const thrum_newton_system *s = at->system;
  const double own = dot(s->z, s->step, s->m) + share * dot(s->step, s->step, s->m);
  return at->laws->fall(at->of, share, own);
}

bool thrum_newton_minimise(const thrum_newton_system *system, const thrum_newton_laws *laws,
                           void *of, double tolerance, bool *settled) {
  const along_step at = {system, laws, of};
  const int64_t m = system->m;
  bool fresh = true;
  *settled = false;
  for (int n = 0; n < ITERATIONS_MAX && !*settled; n++) {
    laws->linearise(of);
    if (!thrum_newton_step(m, system->matrix, system->gradient, system->step))
      return false;

    // as far as the function falls
    const double longest = laws->ways(of);
    const double share = thrum_newton_search(slope_at, &at, dot(system->gradient, system->step, m));
    for (int64_t q = 0; q < m; q++)
      system->z[q] += share * system->step[q];
    laws->take(of, share);

    // after a whole step rows go on from their forces, unless they have settled
    *settled = fresh && share == 1.0 && longest <= tolerance;
    fresh = share == 1.0;
    if (fresh && !*settled)
      laws->go_on(of);
  }
  return true;
}
