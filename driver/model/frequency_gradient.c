/* The derivatives of frequencies in the whole mesh: of a mode phi of unit mass
 *
 *   d omega^2/d theta = phi^T (dK/d theta - omega^2 dM/d theta) phi,
 *
 * and of modes that share a frequency the eigenvalues of the matrix of these products. K is linear
 * in Lame's constants of each region, and M in its density. In elements with enhanced strains,
 * whose part is eliminated, K is linear in E alone: the derivative by nu is a central difference
 * there. Cost: two reductions and one mass matrix a region, or four reductions. Source: Fox &
 * Kapoor 1968, doi:10.2514/3.5008.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/frequency_gradient.h"

#include <lapacke.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/lame.h"
#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/model/model_fem.h"
#include "precompute/polynomial/polynomial_reduce.h"

#define NU_STEP 1e-4 /* of the way to the end of the range of nu: differences to about 1e-8 */
#define SHARED 1e-6  /* of omega^2, within which modes have one frequency */

int64_t frequency_shared_end(const double *omega2, int64_t modes, int64_t first) {
  int64_t end = first;
  while (end < modes && omega2[end] - omega2[first] <= SHARED * omega2[first])
    end++;
  return end;
}

typedef struct work {
  const thrum_model *model;
  thrum_model_fem body;
  int64_t modes, regions;
  double *density;            /* regions */
  double *vectors;            /* free components x modes, column-major */
  double *product;            /* the same: M vectors */
  double *lambda, *mu, *mass; /* rank x rank of a region; mass: modes x modes */
  double *matrix, *values;    /* modes x modes, modes */
  int64_t rank;
} work;

/* Are there elements of which the moduli are in the rows? */
static bool has_rows(const thrum_fem *fem) {
  for (int64_t s = 0; s < fem->solids.count; s++)
    if (thrum_solid_has_rows(&fem->solids, s))
      return true;
  return false;
}

/* phi^T K phi of the body whose region has this E and nu, the elements made anew. */
static thrum_status varied_stiffness(const work *w, int64_t region, double young, double poisson,
                                     double *to, thrum_error *error) {
  thrum_model varied = *w->model;
  thrum_model_fem body = {0};
  double *material = NULL;
  THRUM_TRY(thrum_reserve(&material, 3 * w->regions, sizeof *material, "the materials", error));
  memcpy(material, w->model->material, 3 * (size_t)w->regions * sizeof *material);
  material[3 * region] = young;
  material[3 * region + 1] = poisson;
  varied.material = material;
  thrum_status status = thrum_model_fem_elements(&varied, &body, error);
  THRUM_THEN(status, thrum_reduced_stiffness(&body.fem, w->rank, w->model->basis, to, error));
  thrum_model_fem_free(&body);
  free(material);
  return status;
}

/* One region of elements with rows: d K / d log E into lambda, and d K / d nu into mu. K is linear
 * in E, so that a difference by halves is exact. */
static thrum_status differences(work *w, int64_t g, thrum_error *error) {
  const double young = w->model->material[3 * g], nu = w->model->material[3 * g + 1];
  const double step = NU_STEP * fmin(1 + nu, 0.5 - nu);
  const int64_t entries = w->rank * w->rank;
  double *half = NULL;
  THRUM_TRY(thrum_reserve(&half, entries, sizeof *half, "the derivatives of frequencies", error));
  thrum_status status = varied_stiffness(w, g, 1.5 * young, nu, w->lambda, error);
  THRUM_THEN(status, varied_stiffness(w, g, 0.5 * young, nu, half, error));
  for (int64_t i = 0; i < entries && status >= 0; i++)
    w->lambda[i] -= half[i];
  THRUM_THEN(status, varied_stiffness(w, g, young, nu + step, w->mu, error));
  THRUM_THEN(status, varied_stiffness(w, g, young, nu - step, half, error));
  for (int64_t i = 0; i < entries && status >= 0; i++)
    w->mu[i] = (w->mu[i] - half[i]) / (2 * step);
  free(half);
  return status;
}

/* phi^T K_g phi for lambda or mu of one region, each as large as its E. */
static thrum_status region_stiffness(work *w, int64_t region, bool of_mu, double *to,
                                     thrum_error *error) {
  for (int64_t g = 0; g < w->regions; g++) {
    w->body.fem.lambda[g] = g == region && !of_mu ? w->model->material[3 * g] : 0;
    w->body.fem.mu[g] = g == region && of_mu ? w->model->material[3 * g] : 0;
  }
  return thrum_reduced_stiffness(&w->body.fem, w->rank, w->model->basis, to, error);
}

static thrum_status region_mass(work *w, int64_t region, thrum_error *error) {
  const int64_t n = w->body.fem.free_count, k = w->modes;
  thrum_sparse mass = {0};
  for (int64_t g = 0; g < w->regions; g++)
    w->body.fem.density[g] = g == region ? w->density[g] : 0;
  THRUM_TRY(thrum_fem_mass(&w->body.fem, w->body.kind, &w->body.stiffness, &mass, error));
  thrum_sparse_product(&mass, w->vectors, k, w->product);
  thrum_sparse_free(&mass);
  for (int64_t i = 0; i < k; i++)
    for (int64_t j = 0; j < k; j++) {
      double sum = 0;
      for (int64_t c = 0; c < n; c++)
        sum += w->vectors[i * n + c] * w->product[j * n + c];
      w->mass[i * k + j] = sum;
    }
  return THRUM_OK;
}

/* d omega^2 of all modes for the change a lambda-part + b mu-part - omega^2 c mass, over 2 omega^2,
 * into column `region` of `to`. */
static thrum_status put_change(work *w, double a, double b, double c, int64_t region, double *to,
                               thrum_error *error) {
  const double *omega2 = w->model->omega2;
  const int64_t r = w->rank, k = w->modes;
  for (int64_t first = 0, last = 0; first < k; first = last) {
    last = frequency_shared_end(omega2, k, first);
    const int64_t n = last - first;
    for (int64_t i = 0; i < n; i++)
      for (int64_t j = 0; j < n; j++) {
        const int64_t at = (first + i) * r + first + j, mass_at = (first + i) * k + first + j;
        w->matrix[i * n + j] =
            a * w->lambda[at] + b * w->mu[at] - omega2[first] * c * w->mass[mass_at];
      }
    if (n == 1)
      w->values[0] = w->matrix[0];
    else
      THRUM_TRY(thrum_lapack_status(
          LAPACKE_dsyev(LAPACK_COL_MAJOR, 'N', 'U', (int)n, w->matrix, (int)n, w->values),
          THRUM_NOT_CONVERGED, "the changes of modes that share a frequency", error));
    for (int64_t i = 0; i < n; i++)
      to[(first + i) * w->regions + region] =
          omega2[first] > 0 ? w->values[i] / (2 * omega2[first]) : NAN;
  }
  return THRUM_OK;
}

/* One region: lambda = E l(nu) and mu = E m(nu), so that E changes both by the same share. */
static thrum_status find_region(work *w, int64_t g, frequency_gradient *found, thrum_error *error) {
  if (has_rows(&w->body.fem)) {
    THRUM_TRY(differences(w, g, error));
    THRUM_TRY(region_mass(w, g, error));
    THRUM_TRY(put_change(w, 1, 0, 0, g, found->young, error));
    THRUM_TRY(put_change(w, 0, 1, 0, g, found->poisson, error));
    return put_change(w, 0, 0, 1, g, found->density, error);
  }
  THRUM_TRY(region_stiffness(w, g, false, w->lambda, error));
  THRUM_TRY(region_stiffness(w, g, true, w->mu, error));
  THRUM_TRY(region_mass(w, g, error));
  const double nu = w->model->material[3 * g + 1];
  const thrum_lame by_young = thrum_lame_of(1, nu), by_nu = thrum_lame_by_poisson(1, nu);
  THRUM_TRY(put_change(w, by_young.lambda, by_young.mu, 0, g, found->young, error));
  THRUM_TRY(put_change(w, by_nu.lambda, by_nu.mu, 0, g, found->poisson, error));
  return put_change(w, 0, 0, 1, g, found->density, error);
}

static thrum_status open(work *w, thrum_error *error) {
  const thrum_model *model = w->model;
  THRUM_TRY(thrum_model_fem_create(model, &w->body, error));

  // springs to the ground are of no region
  w->body.fem.springs = NULL;
  const int64_t n = w->body.fem.free_count, k = w->modes, r = w->rank;
  double *block = NULL;
  THRUM_TRY(thrum_reserve(&block, w->regions + 2 * n * k + 2 * r * r + 2 * k * k + k, sizeof *block,
                          "the derivatives of frequencies", error));
  w->density = block;
  w->vectors = block + w->regions;
  w->product = w->vectors + n * k;
  w->lambda = w->product + n * k;
  w->mu = w->lambda + r * r;
  w->mass = w->mu + r * r;
  w->matrix = w->mass + k * k;
  w->values = w->matrix + k * k;
  memcpy(w->density, w->body.fem.density, (size_t)w->regions * sizeof *w->density);
  for (int64_t i = 0; i < k; i++)
    for (int64_t c = 0; c < n; c++)
      w->vectors[i * n + c] = model->basis[w->body.fem.component[c] * r + i];
  return THRUM_OK;
}

thrum_status frequency_gradient_find(const thrum_model *model, int64_t modes,
                                     frequency_gradient *found, thrum_error *error) {
  *found = (frequency_gradient){.modes = modes < model->rank ? modes : model->rank,
                                .regions = model->region_count};
  if (model->basis == NULL || model->tets == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or basis, by which its frequencies change");
  if (model->elastic)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "how frequencies change is found by E and nu of each region, and a "
                           "material of this model has directions");
  const int64_t count = found->modes * found->regions;
  THRUM_TRY(thrum_reserve(&found->young, 3 * count, sizeof *found->young,
                          "the derivatives of frequencies", error));
  found->poisson = found->young + count;
  found->density = found->poisson + count;

  work w = {.model = model, .modes = found->modes, .regions = found->regions, .rank = model->rank};
  thrum_status status = open(&w, error);
  for (int64_t g = 0; g < found->regions && status >= 0; g++)
    status = find_region(&w, g, found, error);
  free(w.density);
  thrum_model_fem_free(&w.body);
  return status;
}

void frequency_gradient_free(frequency_gradient *found) {
  free(found->young);
  found->young = found->poisson = found->density = NULL;
}
