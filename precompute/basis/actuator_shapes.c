/* Static answers to actuators, design 2: with V(u) - a m(u) in place of V the body at rest moves by
 * u = a x + 1/2 a^2 y, K x = grad m, K y = 2 H x - d^2 R(x, x), H the second derivative of m. With
 * x scaled to unit mass by its length, a modal derivative has d^2 R alone, and H is added here; so
 * it is for a mode, whose shape the actuator changes. Cost: a solve for each actuator, and one for
 * each of its pairs with another shape.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/actuator_shapes.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define FLAT 1e-9 /* of the body's volume: a surface that encloses less encloses none */

thrum_status thrum_actuator_responses(const thrum_fem *fem, const thrum_sparse *mass,
                                      thrum_factor *factor, int64_t count,
                                      const thrum_actuator *actuators, double *responses,
                                      double *omega2, double *lengths, double *compliance,
                                      thrum_error *error) {
  const int64_t n = fem->free_count;
  thrum_scope memory = thrum_scope_begin("the shapes of the actuators", error);
  double *all = thrum_scope_allocate(&memory, 3 * fem->vertex_count, sizeof *all);
  double *force = thrum_scope_allocate(&memory, 2 * n, sizeof *force);
  thrum_status status = memory.status;
  double volume = 0, whole = 0;
  thrum_fem_weigh(fem, &volume, &whole);
  for (int64_t k = 0; k < count && status >= 0; k++) {
    double *x = responses + k * n, *product = force + n;
    if (actuators[k].kind == THRUM_ACTUATOR_GAS &&
        !(thrum_fem_actuator_rest(fem, &actuators[k]) > FLAT * volume)) {
      status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                               "--actuator '%.100s': its surface encloses nothing that a gas could "
                               "fill",
                               actuators[k].text);
      break;
    }
    memset(all, 0, (size_t)(3 * fem->vertex_count) * sizeof *all);
    thrum_fem_actuator(fem, &actuators[k], NULL, 1, all);
    thrum_fem_gather(fem, all, force);
    status = thrum_factor_solve(factor, force, 1, x, error);
    if (status < 0)
      break;

    // one whose forces meet what is held alone moves nothing
    thrum_sparse_product(mass, x, 1, product);
    const double square = cblas_ddot((int)n, x, 1, product, 1);
    compliance[k] = cblas_ddot((int)n, x, 1, force, 1);
    if (!(square > 0 && compliance[k] > 0)) {
      status =
          thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                          "--actuator '%.100s': it moves nothing of the body", actuators[k].text);
      break;
    }
    lengths[k] = sqrt(square);
    omega2[k] = compliance[k] / square;
    cblas_dscal((int)n, 1 / lengths[k], x, 1);
  }
  thrum_scope_free(&memory);
  return status;
}

/* Column of the derivative of shapes i <= j. */
static int64_t pair_at(int64_t shapes, int64_t i, int64_t j) {
  return i * shapes - i * (i - 1) / 2 + (j - i);
}

thrum_status thrum_actuator_derivatives(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                                        const thrum_actuator *actuators, const double *lengths,
                                        int64_t shapes, const double *fields, double *derivatives,
                                        thrum_error *error) {
  const int64_t n = fem->free_count;
  if (count == 0)
    return THRUM_OK;
  thrum_sparse curve = {0};
  thrum_scope memory = thrum_scope_begin("the shapes of the actuators", error);
  double *solved = thrum_scope_allocate(&memory, n * shapes, sizeof *solved);
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_fem_pattern(fem, &curve, error));
  for (int64_t k = 0; k < count && status >= 0; k++) {
    const int64_t own = shapes - count + k;
    memset(curve.value, 0, (size_t)curve.begin[n] * sizeof *curve.value);
    thrum_fem_actuator_stiffness(fem, &actuators[k], NULL, 1 / lengths[k], &curve);
    thrum_sparse_product(&curve, fields, shapes, solved);
    status = thrum_factor_solve(factor, solved, shapes, solved, error);
    for (int64_t i = 0; i < shapes && status >= 0; i++) {
      const int64_t at = i <= own ? pair_at(shapes, i, own) : pair_at(shapes, own, i);
      cblas_daxpy((int)n, i == own ? 2 : 1, solved + i * n, 1, derivatives + at * n, 1);
    }
  }
  thrum_sparse_free(&curve);
  thrum_scope_free(&memory);
  return status;
}
