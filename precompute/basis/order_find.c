/* The estimate of order_error.c where no precompute has made the factor and the modes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/order_find.h"

#include <stdlib.h>

#include "precompute/basis/eigen.h"
#include "precompute/fem/rigid_modes.h"

typedef struct order_search {
  const thrum_fem *fem;
  double room;
  thrum_sparse stiffness, mass;
  thrum_factor *factor;
  double *rigid, *vectors;
} order_search;

static thrum_status assemble(order_search *s, thrum_error *error) {
  const thrum_fem *fem = s->fem;
  THRUM_TRY(thrum_fem_pattern(fem, &s->stiffness, error));
  THRUM_TRY(thrum_fem_mass(fem, THRUM_MASS_CONSISTENT, &s->stiffness, &s->mass, error));
  THRUM_TRY(thrum_fem_stiffness(fem, NULL, &s->stiffness, error));
  if (fem->free_count < 3 * fem->vertex_count)
    return THRUM_OK;

  // Z, and M Z behind it
  const int64_t count = THRUM_RIGID_COUNT * fem->free_count;
  THRUM_TRY(thrum_reserve(&s->rigid, 2 * count, sizeof(double), "the rigid modes", error));
  return thrum_rigid_modes(fem, &s->mass, s->rigid, s->rigid + count, error);
}

/* The factor and its work, the Lanczos vectors, and the fields of the edges, some seven a vertex.
 */
static bool has_room(const order_search *s, int64_t count) {
  const double fields = (double)(3 * count + 15) * (double)s->fem->free_count +
                        (double)(3 * count + 7) * 21.0 * (double)s->fem->vertex_count;
  const double more =
      thrum_factor_bytes(s->factor) + thrum_factor_work_bytes(s->factor) + 8 * fields;
  return more <= s->room;
}

/* *made: whether there was room for it. */
static thrum_status factorise(order_search *s, int64_t count, bool *made, thrum_error *error) {
  // six springs hold a free body while its factor is made
  thrum_support_springs springs;
  if (s->rigid)
    thrum_support_springs_add(s->fem, &s->stiffness, &springs);
  thrum_status status = thrum_factor_plan(&s->stiffness, &s->factor, error);
  *made = status >= 0 && has_room(s, count);
  if (*made)
    status = thrum_factor_compute(&s->stiffness, s->factor, error);
  if (s->rigid)
    thrum_support_springs_remove(&springs, &s->stiffness);
  if (status >= 0 && *made && s->rigid)
    thrum_factor_deflate(s->factor, THRUM_RIGID_COUNT, s->rigid,
                         s->rigid + THRUM_RIGID_COUNT * s->fem->free_count);
  return status;
}

/* *found becomes 0 where there is no room. */
static thrum_status find(order_search *s, const thrum_mesh *mesh, int64_t *found, double *errors,
                         thrum_error *error) {
  double values[THRUM_ORDER_MODES_MAX];
  const int64_t n = s->fem->free_count, count = *found;
  bool made = false;
  THRUM_TRY(assemble(s, error));
  THRUM_TRY(factorise(s, count, &made, error));
  if (!made) {
    *found = 0;
    return THRUM_OK;
  }

  THRUM_TRY(thrum_reserve(&s->vectors, count * n, sizeof(double), "the modes", error));
  THRUM_TRY(thrum_eigen_lowest(&s->stiffness, &s->mass, s->factor, count, values, s->vectors, NULL,
                               error));
  const thrum_order_body body = {mesh, s->fem, s->factor, s->rigid,
                                 s->rigid ? s->rigid + THRUM_RIGID_COUNT * n : NULL};
  return thrum_order_errors(&body, count, s->vectors, errors, error);
}

thrum_status thrum_order_find(const thrum_mesh *mesh, const thrum_fem *fem, double room,
                              int64_t *count, double *errors, thrum_error *error) {
  order_search s = {.fem = fem, .room = room};

  // a mesh of few components has few modes, and a free one six less
  const bool free_body = fem->free_count == 3 * fem->vertex_count;
  int64_t most = fem->free_count - 1 - (free_body ? THRUM_RIGID_COUNT : 0);
  most = most < THRUM_ORDER_MODES_MAX ? most : THRUM_ORDER_MODES_MAX;
  int64_t wanted = *count < most ? *count : most;

  // solids are no tets that bend too little
  if (fem->solids.count > 0)
    wanted = 0;
  const thrum_status status = wanted > 0 ? find(&s, mesh, &wanted, errors, error) : THRUM_OK;
  if (status >= 0)
    *count = wanted > 0 ? wanted : 0;

  thrum_factor_free(s.factor);
  thrum_sparse_free(&s.stiffness);
  thrum_sparse_free(&s.mass);
  free(s.rigid);
  free(s.vectors);
  return status;
}
