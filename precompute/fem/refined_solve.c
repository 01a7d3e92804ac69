/* Conjugate gradients with a factor in single precision as preconditioner: a few steps where plain
 * refinement would take as many, and a few more where the condition is so large that refinement
 * would not end (Hestenes, Stiefel 1952, doi:10.6028/jres.049.044). The columns of a block step
 * together, each with numbers of its own, because solves and products are cheaper together.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/refined_solve.h"

#include <cblas.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define BLOCK 32        /* columns; as many as callers solve for together */
#define STEPS_MAX 200   /* a condition of 1e12 and more */
#define TOLERANCE 1e-10 /* of the residual in the norm of A^-1; it falls by 1e4 in most steps */

typedef struct refinement {
  int64_t n, columns;
  double *residual, *correction, *direction; /* n x columns: r, z, p; z makes room for A p */
  double energy[BLOCK], start[BLOCK];        /* r.z of each column, now and at first */
  double before[BLOCK];                      /* r.z one step ago; 0: at the first */
  double square[BLOCK];                      /* r.r when r.z was computed */
} refinement;

// z = A^-1 r, roughly, and p = z + (r.z / before) p
static thrum_status turn(thrum_single_factor *factor, refinement *s, bool first,
                         thrum_error *error) {
  const int n = (int)s->n;
  THRUM_TRY(thrum_single_factor_solve(factor, s->residual, s->columns, s->correction, error));

  for (int64_t c = 0; c < s->columns; c++) {
    const double *r = s->residual + c * s->n, *z = s->correction + c * s->n;
    double *p = s->direction + c * s->n;
    const double before = s->before[c] = first ? 0 : s->energy[c];
    s->energy[c] = cblas_ddot(n, r, 1, z, 1);
    s->square[c] = cblas_ddot(n, r, 1, r, 1);
    if (first)
      s->start[c] = s->energy[c];

    // a direction that is conjugate to all before it
    cblas_dscal(n, first || !(before > 0) ? 0 : s->energy[c] / before, p, 1);
    cblas_daxpy(n, 1, z, 1, p, 1);
  }
  return THRUM_OK;
}

// x += a p, r -= a A p, with the step a of each column; returns whether any column goes on
static bool advance(const thrum_sparse *matrix, refinement *s, double *solution) {
  const int n = (int)s->n;
  bool more = false;
  double *image = s->correction;
  thrum_sparse_product(matrix, s->direction, s->columns, image);
  for (int64_t c = 0; c < s->columns; c++) {
    const double *p = s->direction + c * s->n;
    double *r = s->residual + c * s->n;
    const double curvature = cblas_ddot(n, p, 1, image + c * s->n, 1);

    // a column that has converged stands still
    if (!(s->energy[c] > TOLERANCE * TOLERANCE * s->start[c]) || !(curvature > 0))
      continue;
    const double step = s->energy[c] / curvature;
    cblas_daxpy(n, step, p, 1, solution + c * s->n, 1);
    cblas_daxpy(n, -step, image + c * s->n, 1, r, 1);

    // what r.z has become: it falls as in the step before, and at least as r.r, since the residual
    // gets rougher
    const double share = cblas_ddot(n, r, 1, r, 1) / s->square[c];
    const double fall = s->before[c] > 0 ? s->energy[c] / s->before[c] : 1;
    more = more || fmin(share, fall) * s->energy[c] > TOLERANCE * TOLERANCE * s->start[c];
  }
  return more;
}

static thrum_status solve_block(const thrum_sparse *matrix, thrum_single_factor *factor,
                                refinement *s, double *solution, int64_t *solved,
                                thrum_error *error) {
  memset(solution, 0, sizeof *solution * (size_t)(s->n * s->columns));
  memset(s->direction, 0, sizeof *solution * (size_t)(s->n * s->columns));

  // steps until the residuals of all columns are small
  for (int step = 0; step < STEPS_MAX; step++) {
    THRUM_TRY(turn(factor, s, step == 0, error));
    *solved += s->columns;
    if (!advance(matrix, s, solution))
      return THRUM_OK;
  }
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "the solves did not converge: the stiffness is too badly conditioned; "
                         "mend the mesh or fix more with --fix");
}

thrum_status thrum_refined_solve(const thrum_sparse *matrix, thrum_single_factor *factor,
                                 const double *right, int64_t columns, double *solution,
                                 int64_t *solved, thrum_error *error) {
  const int64_t n = matrix->size, most = columns < BLOCK ? columns : BLOCK;
  thrum_scope memory = thrum_scope_begin("the solution", error);
  refinement s = {.n = n};
  s.residual = thrum_scope_allocate(&memory, n * most, sizeof *s.residual);
  s.correction = thrum_scope_allocate(&memory, n * most, sizeof *s.correction);
  s.direction = thrum_scope_allocate(&memory, n * most, sizeof *s.direction);
  thrum_status status = memory.status;

  for (int64_t first = 0; first < columns && status >= 0; first += BLOCK) {
    s.columns = columns - first < BLOCK ? columns - first : BLOCK;
    memcpy(s.residual, right + first * n, sizeof *right * (size_t)(n * s.columns));
    status = solve_block(matrix, factor, &s, solution + first * n, solved, error);
  }

  thrum_scope_free(&memory);
  return status;
}
