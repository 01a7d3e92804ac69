/* Newton's method from held components to all of them, see about_state.h. Cost: a factor an
 * iteration. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/about_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

thrum_status thrum_fem_take_state(const thrum_mesh *mesh, thrum_fem *fem, thrum_error *error) {
  if (mesh->about == NULL)
    return THRUM_OK;
  if (mesh->solid_count == 0 || mesh->springs)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a body about a state has solids and no springs to the ground");
  fem->about_force = thrum_scope_allocate(&fem->memory, 3 * fem->vertex_count, sizeof(double));
  THRUM_TRY(fem->memory.status);
  fem->about_energy = thrum_fem_energy(fem, mesh->about, fem->about_force);
  fem->about = mesh->about;
  return THRUM_OK;
}

#define LEAST_STEP (1.0 / 1024)
#define RELATIVE 1e-9 /* of the forces on free components to the largest on all so far */
enum { ITERATIONS = 25 };

typedef struct search {
  const thrum_fem *fem;
  const double *field;
  thrum_sparse stiffness;
  double *u, *force, *right;
  thrum_error *error;
} search;

static double largest(const double *values, int64_t count) {
  double most = 0;
  for (int64_t i = 0; i < count; i++)
    most = fmax(most, isfinite(values[i]) ? fabs(values[i]) : INFINITY);
  return most;
}

/* Corrects u until nothing pulls at the free components; positive where it does not. */
static thrum_status correct(search *s, bool *found) {
  const thrum_fem *fem = s->fem;
  const int64_t n = fem->free_count;
  double before = INFINITY, most = 0; // the forces of the first guess, where nothing moves
  *found = false;
  for (int k = 0; k < ITERATIONS; k++) {
    thrum_factor *factor = NULL;
    thrum_fem_energy(fem, s->u, s->force);
    thrum_fem_gather(fem, s->force, s->right);
    const double left = largest(s->right, n);
    most = fmax(most, largest(s->force, 3 * fem->vertex_count));
    *found = left <= RELATIVE * most;
    if (!isfinite(left))
      return THRUM_OK;

    // once below, one more step takes it to rounding
    if (*found && left >= before / 2)
      return THRUM_OK;
    before = left;
    THRUM_TRY(thrum_fem_stiffness(fem, s->u, &s->stiffness, s->error));
    thrum_status status = thrum_factor_create(&s->stiffness, &factor, s->error);
    if (status == THRUM_SINGULAR) {
      *found = false;
      return THRUM_OK;
    }
    THRUM_THEN(status, thrum_factor_solve(factor, s->right, 1, s->right, s->error));
    thrum_factor_free(factor);
    THRUM_TRY(status);
    for (int64_t i = 0; i < n; i++)
      s->u[fem->component[i]] -= s->right[i];
  }
  return THRUM_OK;
}

static thrum_status follow(search *s) {
  const int64_t all = 3 * s->fem->vertex_count;
  double at = 0, step = 1, *kept = s->force + all;
  while (at < 1) {
    bool found = false;
    memcpy(kept, s->u, (size_t)all * sizeof *kept);
    const double next = fmin(1, at + step);
    for (int64_t c = 0; c < all; c++)
      s->u[c] += (next - at) * s->field[c];
    for (int64_t c = 0; c < all; c++)
      s->u[c] = s->fem->dof[c] < 0 ? next * s->field[c] : s->u[c];
    THRUM_TRY(correct(s, &found));
    if (found) {
      at = next;
      step *= 2;
      continue;
    }
    memcpy(s->u, kept, (size_t)all * sizeof *kept);
    step /= 2;
    if (step < LEAST_STEP)
      return thrum_error_set(s->error, THRUM_SINGULAR,
                             "the body gives way at %.3g of the state: it buckles, or an element "
                             "turns inside out; ask for less",
                             at);
  }
  return THRUM_OK;
}

thrum_status thrum_about_state(const thrum_fem *fem, const double *field, double *u,
                               thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the state", error);
  search s = {.fem = fem, .field = field, .error = error};
  const int64_t all = 3 * fem->vertex_count;
  s.u = thrum_scope_allocate(&memory, all, sizeof *s.u);
  s.force = thrum_scope_allocate(&memory, 2 * all, sizeof *s.force);
  s.right = thrum_scope_allocate(&memory, all, sizeof *s.right);
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_fem_pattern(fem, &s.stiffness, error));
  THRUM_THEN(status, follow(&s));
  if (status >= 0)
    memcpy(u, s.u, (size_t)all * sizeof *u);
  thrum_sparse_free(&s.stiffness);
  thrum_scope_free(&memory);
  return status;
}
