/* A step of subspace iteration in a space of finite elements that has been made larger, see
 * hierarchy.h. Conjugate gradients solve for x. They are preconditioned by the factor of the given
 * stiffness, the block of the nodes in this basis, and by the 3 x 3 blocks of what is added. The
 * spaces of both meet at an angle that does not depend on the size of the mesh, and neither does
 * the number of steps. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/hierarchy.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/fem/rigid_modes.h"

#define STEPS_MAX 300
#define SETTLED 1e-4  /* of what is let go so far: the rest, in the norm of the preconditioner */
#define NOTHING 0.002 /* of the energy of a mode that counts as nothing let go */

thrum_status hierarchy_allocate(const thrum_order_body *body, int64_t added, int64_t modes,
                                hierarchy *s) {
  s->factor = body->factor;
  s->rigid = body->rigid;
  s->rigid_dual = body->rigid_dual;
  s->nodes = body->fem->free_count;
  s->count = added;
  s->size = s->nodes + 3 * added;
  s->held = thrum_scope_allocate(&s->memory, added, sizeof *s->held);
  s->inverse = thrum_scope_allocate(&s->memory, 9 * added, sizeof(double));
  double **const fields[] = {&s->r, &s->z, &s->p, &s->image};
  double **const blocks[] = {&s->x, &s->load, &s->weighed};
  for (int n = 0; n < 4; n++)
    *fields[n] = thrum_scope_allocate(&s->memory, s->size, sizeof(double));
  for (int n = 0; n < 3; n++)
    *blocks[n] = thrum_scope_allocate(&s->memory, modes * s->size, sizeof(double));
  return s->memory.status;
}

void hierarchy_invert_blocks(hierarchy *s) {
  for (int64_t e = 0; e < s->count; e++) {
    double m[3][3], cofactor[9];
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++) {
        const bool out = (s->held[e] >> c & 1) || (s->held[e] >> d & 1);
        m[c][d] = out ? c == d : s->inverse[9 * e + 3 * c + d];
      }
    for (int c = 0; c < 3; c++)
      thrum_cross3(m[(c + 1) % 3], m[(c + 2) % 3], cofactor + 3 * c);
    const double determinant = thrum_dot3(m[0], cofactor);
    for (int c = 0; c < 9; c++)
      s->inverse[9 * e + c] = cofactor[c] / determinant;
  }
}

void hierarchy_clear_held(const hierarchy *s, double *field) {
  double *added = field + s->nodes;
  for (int64_t i = 0; i < 3 * s->count; i++)
    if (s->held[i / 3] >> (i % 3) & 1)
      added[i] = 0;
}

/* field -= left (right . field) on the corners, for each of the six columns: with Z and M Z what
 * is rigid is gone, with M Z and Z the load that would move it. */
static void project(const hierarchy *s, const double *left, const double *right, double *field) {
  const int64_t n = s->nodes;
  for (int i = 0; left && i < THRUM_RIGID_COUNT; i++)
    cblas_daxpy((int)n, -cblas_ddot((int)n, right + i * n, 1, field, 1), left + i * n, 1, field, 1);
}

/* Z and M Z are of the corners, and M of the edges' part of a field is missing in M Z . field. */
static void drop_rigid(const hierarchy *s, double *field, double *work) {
  if (!s->rigid)
    return;
  s->weigh(s, field, work);
  const int64_t n = s->nodes;
  for (int i = 0; i < THRUM_RIGID_COUNT; i++) {
    const double *rigid = s->rigid + i * n;
    cblas_daxpy((int)n, -cblas_ddot((int)n, rigid, 1, work, 1), rigid, 1, field, 1);
  }
}

static double dot(const hierarchy *s, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < s->size; i++)
    sum += a[i] * b[i];
  return sum;
}

static thrum_status precondition(const hierarchy *s, thrum_error *error) {
  const int64_t n = s->nodes;
  THRUM_TRY(thrum_factor_solve_roughly(s->factor, s->r, 1, s->z, error));
  for (int64_t i = 0; i < 3 * s->count; i++)
    s->z[n + i] = thrum_dot3(s->inverse + 3 * i, s->r + n + i / 3 * 3);
  hierarchy_clear_held(s, s->z);
  return THRUM_OK;
}

/* Solves K x = omega^2 M psi from x = psi: each step lets go of length * now. On entry r is the
 * load; on return that of x, K x. */
static thrum_status let_go(const hierarchy *s, double *x, double *load, thrum_error *error) {
  double released = 0, before = 0;
  const double energy = dot(s, load, x);
  s->multiply(s, x, s->image);
  for (int64_t i = 0; i < s->size; i++)
    s->r[i] = load[i] - s->image[i];
  memset(s->p, 0, sizeof *s->p * (size_t)s->size);

  for (int step = 0; step < STEPS_MAX; step++) {
    // what is left counts against what has been let go
    THRUM_TRY(precondition(s, error));
    const double now = dot(s, s->r, s->z);
    if (!(now > SETTLED * fmax(released, NOTHING * energy)))
      break;
    for (int64_t i = 0; i < s->size; i++)
      s->p[i] = s->z[i] + (step > 0 ? now / before : 0) * s->p[i];
    before = now;

    s->multiply(s, s->p, s->image);
    const double length = now / dot(s, s->p, s->image);
    released += length * now;
    for (int64_t i = 0; i < s->size; i++) {
      x[i] += length * s->p[i];
      s->r[i] -= length * s->image[i];
    }
  }

  for (int64_t i = 0; i < s->size; i++)
    load[i] -= s->r[i];
  return THRUM_OK;
}

/* The eigenvalues of K and M on the span of the columns of x, ascending. */
static thrum_status ritz(const hierarchy *s, int64_t count, double *values, thrum_error *error) {
  double stiff[THRUM_ORDER_MODES_MAX * THRUM_ORDER_MODES_MAX];
  double mass[THRUM_ORDER_MODES_MAX * THRUM_ORDER_MODES_MAX];
  for (int64_t i = 0; i < count; i++)
    for (int64_t j = i; j < count; j++) {
      stiff[j * count + i] = dot(s, s->x + i * s->size, s->load + j * s->size);
      mass[j * count + i] = dot(s, s->x + i * s->size, s->weighed + j * s->size);
    }
  const int k = (int)count;
  return thrum_lapack_status(
      LAPACKE_dsygv(LAPACK_COL_MAJOR, 1, 'N', 'U', k, stiff, k, mass, k, values), THRUM_SINGULAR,
      "the modes are dependent once what is added moves", error);
}

/* K x and M x of all columns. */
static void measure(const hierarchy *s, int64_t count) {
  for (int64_t i = 0; i < count; i++) {
    s->multiply(s, s->x + i * s->size, s->load + i * s->size);
    s->weigh(s, s->x + i * s->size, s->weighed + i * s->size);
  }
}

thrum_status hierarchy_errors(hierarchy *s, int64_t count, const double *modes, double *errors,
                              thrum_error *error) {
  const int64_t n = s->nodes;
  double given[THRUM_ORDER_MODES_MAX], let[THRUM_ORDER_MODES_MAX], found[THRUM_ORDER_MODES_MAX];

  // the values of the modes, whatever mass they were made with
  memset(s->x, 0, sizeof *s->x * (size_t)(count * s->size));
  for (int64_t i = 0; i < count; i++)
    memcpy(s->x + i * s->size, modes + i * n, sizeof *modes * (size_t)n);
  measure(s, count);
  THRUM_TRY(ritz(s, count, given, error));

  // a step of subspace iteration
  for (int64_t i = 0; i < count; i++) {
    double *x = s->x + i * s->size, *load = s->load + i * s->size;
    const double omega2 = dot(s, x, load) / dot(s, x, s->weighed + i * s->size);
    for (int64_t j = 0; j < s->size; j++)
      load[j] = omega2 * s->weighed[i * s->size + j];
    project(s, s->rigid_dual, s->rigid, load);
    THRUM_TRY(let_go(s, x, load, error));
    drop_rigid(s, x, s->image);
    s->weigh(s, x, s->weighed + i * s->size);
  }
  THRUM_TRY(ritz(s, count, let, error));
  for (int64_t i = 0; i < count; i++)
    found[i] = sqrt(fmax(given[i] / let[i], 1)) - 1;
  memcpy(errors, found, sizeof *errors * (size_t)count);
  return THRUM_OK;
}
