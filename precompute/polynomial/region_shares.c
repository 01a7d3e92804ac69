/* The polynomial with one modulus at 1 Pa and all others at zero, in which it is linear, and the
 * mass with one density at 1 kg/m^3. Cost: as many reductions as there are moduli.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/region_shares.h"

#include <cblas.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/polynomial/polynomial_reduce.h"

/* U^T M U and U^T M 1 of the densities of the body. */
static thrum_status put_mass(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                             const thrum_model *model, double *to, thrum_error *error) {
  const int64_t n = fem->free_count, r = model->rank;
  thrum_sparse mass = {0};
  thrum_scope memory = thrum_scope_begin("the masses of the regions", error);
  double *columns = thrum_scope_allocate(&memory, n * r, sizeof *columns);
  double *products = thrum_scope_allocate(&memory, n * r, sizeof *products);
  double *vertex = thrum_scope_allocate(&memory, fem->vertex_count, sizeof *vertex);
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_fem_mass(fem, kind, pattern, &mass, error));
  if (status >= 0) {
    for (int64_t i = 0; i < r; i++)
      for (int64_t f = 0; f < n; f++)
        columns[i * n + f] = model->basis[fem->component[f] * r + i];
    thrum_sparse_product(&mass, columns, r, products);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, (int)r, (int)r, (int)n, 1, columns, (int)n,
                products, (int)n, 0, to, (int)r);

    // all vertices, held ones as well, as of axis_mass
    thrum_fem_vertex_mass(fem, kind, vertex);
    memset(to + r * r, 0, (size_t)(3 * r) * sizeof *to);
    for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
      cblas_daxpy((int)r, vertex[c / 3], model->basis + c * r, 1, to + r * r + c % 3 * r, 1);
  }
  thrum_sparse_free(&mass);
  thrum_scope_free(&memory);
  return status;
}

/* One modulus or density at 1, all others at 0. */
static void set_alone(thrum_fem *fem, const double *one) {
  for (int64_t g = 0; g < fem->region_count; g++) {
    fem->lambda[g] = one == fem->lambda + g;
    fem->mu[g] = one == fem->mu + g;
    fem->density[g] = one == fem->density + g;
  }
}

static thrum_status put_shares(thrum_fem *fem, thrum_mass kind, const thrum_model *model,
                               double *energy, double *mass, thrum_error *error) {
  const int64_t r = model->rank;
  thrum_sparse pattern = {0};
  thrum_status status = thrum_fem_pattern(fem, &pattern, error);
  for (int64_t n = 0; n < 2 * fem->region_count && status >= 0; n++) {
    double *linear = energy + n * model->energy_size, *c3 = linear + r * r;
    set_alone(fem, (n % 2 == 0 ? fem->lambda : fem->mu) + n / 2);
    status = thrum_polynomial_reduce(fem, r, r, model->basis, linear, c3, c3 + model->c3_count,
                                     NULL, error);
  }
  for (int64_t g = 0; g < fem->region_count && status >= 0; g++) {
    set_alone(fem, fem->density + g);
    status = put_mass(fem, kind, &pattern, model, mass + g * model->mass_size, error);
  }
  thrum_sparse_free(&pattern);
  return status;
}

thrum_status thrum_region_shares(thrum_fem *fem, thrum_mass kind, const thrum_model *model,
                                 double *energy, double *mass, thrum_error *error) {
  const int64_t regions = fem->region_count;
  double *const values[] = {fem->lambda, fem->mu, fem->density};
  double *kept = NULL;
  if (fem->solids.count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the energies of regions are those of tetrahedra: make the model with "
                           "--element tet, which cuts its elements");
  THRUM_TRY(thrum_reserve(&kept, 3 * regions, sizeof *kept, "the regions", error));
  for (int n = 0; n < 3; n++)
    memcpy(kept + n * regions, values[n], (size_t)regions * sizeof *kept);
  const thrum_status status = put_shares(fem, kind, model, energy, mass, error);
  for (int n = 0; n < 3; n++)
    memcpy(values[n], kept + n * regions, (size_t)regions * sizeof *kept);
  free(kept);
  return status;
}
