/* A fresh search for modes that were missed, see mode_check.h.
 *
 * Lanczos from one vector cannot see the second copy of a repeated frequency but by rounding, and
 * any method can miss what its start vector lacks. Here a block of other vectors is taken through
 * K^-1 M a few times, everything kept mass-orthogonal to the modes and to each other (a block
 * Krylov space of the complement), and Rayleigh-Ritz shows the lowest value there is. Its values
 * are upper bounds, so what it finds below the last mode is truly there. BLOCK x STEPS solves in
 * blocks: a small part of what the modes took. Block Lanczos: Golub, Underwood 1977,
 * doi:10.1016/B978-0-12-587260-7.50018-2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/mode_check.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/lapack_status.h"

#define BLOCK 8
#define STEPS 4
#define ROUNDS_MAX 20
#define CLUSTER 1e-6 /* relative; closer than that to the last mode is no lower than it */
#define GUARD 16     /* Ritz vectors refined with the missed modes, which keep the next ones away */
#define PASSES 4     /* of subspace iteration between two looks at the residuals */
#define LOOKS_MAX 20
#define RESIDUAL 1e-13 /* relative to |K| |x|; ten times what rounding leaves */

typedef struct search {
  const thrum_sparse *stiffness, *mass;
  thrum_factor *factor;
  int64_t n, count;
  double *space; /* n x BLOCK STEPS, M-orthonormal */
  double *work;  /* n x THRUM_GRAM_WORK */
  double *small; /* (count + BLOCK STEPS) x BLOCK STEPS, twice as much and more */
  double *values;
  thrum_scope memory;
} search;

static thrum_status search_allocate(search *s, thrum_error *error) {
  const int64_t columns = BLOCK * STEPS, tall = s->count + columns;
  s->memory = thrum_scope_begin("the mode search", error);
  s->space = thrum_scope_allocate(&s->memory, s->n * columns, sizeof(double));
  s->work = thrum_scope_allocate(&s->memory, s->n * THRUM_GRAM_WORK, sizeof(double));
  s->small = thrum_scope_allocate(&s->memory, tall * columns, sizeof(double));
  s->values = thrum_scope_allocate(&s->memory, columns, sizeof(double));
  return s->memory.status;
}

// x -= Q (Q^T M x), twice for rounding's sake
static void project(search *s, const double *q, int64_t columns, double *x, int64_t width) {
  for (int pass = 0; pass < 2; pass++)
    thrum_mass_project(s->mass, q, columns, x, width, s->small, s->work);
}

// columns of unit mass norm; what is shorter than `least` is rounding and becomes zero
static void scale_to_unit(search *s, double *x, int64_t width, double least) {
  for (int64_t c = 0; c < width; c++) {
    double square;
    thrum_mass_gram(s->mass, x + c * s->n, 1, x + c * s->n, 1, &square, s->work);
    cblas_dscal((int)s->n, square > least * least ? 1 / sqrt(square) : 0, x + c * s->n, 1);
  }
}

// one block more: K^-1 M of the block before, orthogonal to the modes and to what is there
static thrum_status grow(search *s, const double *modes, int64_t first, int64_t width,
                         int64_t *grown, thrum_error *error) {
  double *block = s->space + first * s->n;
  const double *before = first >= width ? block - width * s->n : block;
  thrum_sparse_product_in(s->mass, before, width, s->work, s->work + s->n * THRUM_SOLVE_BLOCK);
  THRUM_TRY(thrum_factor_solve_roughly(s->factor, s->work, width, block, error));
  scale_to_unit(s, block, width, 0);
  project(s, modes, s->count, block, width);
  project(s, s->space, first, block, width);
  scale_to_unit(s, block, width, 1e-7);
  return thrum_mass_orthonormalise(s->mass, width, block, 1e-8, grown, s->work, error);
}

// the space from start vectors of its own; *columns: its dimension
static thrum_status make_space(search *s, const double *modes, int round, int64_t *columns,
                               thrum_error *error) {
  // pseudo-random start vectors, the same in every run
  uint64_t state = 0xd1b54a32d192ed03u + (uint64_t)round;
  for (int64_t i = 0; i < BLOCK * s->n; i++) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    s->space[i] = (double)(state >> 11) / 9007199254740992.0 - 0.5;
  }

  // a Krylov space in the complement of the known modes
  const int64_t room =
      thrum_ranks_size(s->mass->ranks, s->n) - thrum_factor_deflated(s->factor) - s->count;
  *columns = 0;
  for (int step = 0; step < STEPS && *columns < room; step++) {
    // a small body's complement fills up before its steps are done
    int64_t grown = 0, width = step == 0 ? BLOCK : *columns < BLOCK ? *columns : BLOCK;
    THRUM_TRY(grow(s, modes, *columns, width, &grown, error));
    *columns += grown;
    if (grown < width)
      break;
  }
  return THRUM_OK;
}

// Ritz values of the space, ascending, in s->values; vectors in s->small
static thrum_status ritz(search *s, int64_t columns, thrum_error *error) {
  const int c = (int)columns;
  thrum_mass_gram(s->stiffness, s->space, columns, s->space, columns, s->small, s->work);
  return thrum_lapack_status(LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', c, s->small, c, s->values),
                             THRUM_NOT_CONVERGED, "the search for missed modes failed", error);
}

// subspace iteration until the modes are exact: a copy of a repeated mode starts from its Ritz
// vector, which is rougher than what Lanczos gives, and comes no faster than the next ones are away
static thrum_status refine(const search *s, int64_t all, double *values, double *vectors,
                           thrum_error *error) {
  double *residuals = NULL;
  thrum_status status =
      thrum_reserve(&residuals, s->count, sizeof *residuals, "the residuals of the modes", error);

  double worst = INFINITY;
  for (int look = 0; look < LOOKS_MAX && worst > RESIDUAL && status >= 0; look++) {
    status = thrum_eigen_refine(s->mass, s->factor, all, PASSES, values, vectors, error);
    THRUM_THEN(status, thrum_eigen_residuals(s->stiffness, s->mass, s->count, values, vectors,
                                             residuals, error));

    // the worst of those that are asked for
    worst = 0;
    for (int64_t i = 0; i < s->count && status >= 0; i++)
      worst = fmax(worst, residuals[i]);
  }
  free(residuals);
  return status;
}

// the modes and `more` Ritz vectors together, made exact; the lowest ones stay
static thrum_status merge(search *s, int64_t columns, int64_t more, double *values, double *vectors,
                          thrum_error *error) {
  const int64_t n = s->n, all = s->count + more;

  // room for all of them together
  thrum_scope memory = thrum_scope_begin("the mode search", error);
  double *joint = thrum_scope_allocate(&memory, n * all, sizeof *joint);
  double *joint_values = thrum_scope_allocate(&memory, all, sizeof *joint_values);
  thrum_status status = memory.status;

  // the Ritz vectors stand behind the modes, and all are refined as one space
  if (status >= 0) {
    memcpy(joint, vectors, sizeof *joint * (size_t)(n * s->count));
    memcpy(joint_values, values, sizeof *values * (size_t)s->count);
    memcpy(joint_values + s->count, s->values, sizeof *values * (size_t)more);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)more, (int)columns, 1,
                s->space, (int)n, s->small, (int)columns, 0, joint + n * s->count, (int)n);
    status = refine(s, all, joint_values, joint, error);
  }

  // the lowest ones are the modes now
  if (status >= 0) {
    memcpy(vectors, joint, sizeof *joint * (size_t)(n * s->count));
    memcpy(values, joint_values, sizeof *values * (size_t)s->count);
  }

  thrum_scope_free(&memory);
  return status;
}

static thrum_status search_all(search *s, double *values, double *vectors, int64_t *recovered,
                               double *next, thrum_error *error) {
  for (int round = 0; round < ROUNDS_MAX; round++) {
    // a space outside the known modes, and its Ritz values
    int64_t columns = 0, lower = 0;
    THRUM_TRY(make_space(s, vectors, round, &columns, error));
    if (columns > 0)
      THRUM_TRY(ritz(s, columns, error));
    *next = columns > 0 ? s->values[0] : INFINITY;

    // the search ends once it finds nothing below the highest known mode
    while (lower < columns && s->values[lower] < (1 - CLUSTER) * values[s->count - 1])
      lower++;
    if (lower == 0)
      return THRUM_OK;

    // missed modes join the known ones
    *recovered += lower;
    const int64_t more = columns - lower < GUARD ? columns : lower + GUARD;
    THRUM_TRY(merge(s, columns, more, values, vectors, error));
  }

  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "the linear modes stay incomplete: %lld more were found in %d searches; "
                         "change --modes",
                         (long long)*recovered, ROUNDS_MAX);
}

thrum_status thrum_mode_search(const thrum_sparse *stiffness, const thrum_sparse *mass,
                               thrum_factor *factor, int64_t count, double *values, double *vectors,
                               int64_t *recovered, double *next, thrum_error *error) {
  search s = {
      .stiffness = stiffness, .mass = mass, .factor = factor, .n = mass->size, .count = count};
  *recovered = 0;
  *next = INFINITY;
  thrum_status status = search_allocate(&s, error);
  THRUM_THEN(status, search_all(&s, values, vectors, recovered, next, error));
  thrum_scope_free(&s.memory);
  return status;
}

double thrum_mode_shift(int64_t count, const double *values, double next, int64_t *below) {
  // right above the last one: `next` is an estimate from above, and the true one may be near
  const double last = values[count - 1];
  *below = count;
  if (!isfinite(next))
    return 2 * last;
  if (next > (1 + 1e-4) * last)
    return last * (1 + 1e-5);

  // the last mode has neighbours that were not asked for: count below its cluster
  for (int64_t i = count - 1; i > 0; i--)
    if (values[i] > (1 + 1e-4) * values[i - 1]) {
      *below = i;
      return 0.5 * (values[i] + values[i - 1]);
    }
  *below = 0;
  return 0.5 * values[0];
}
