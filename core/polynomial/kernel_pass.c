/* The passes over the coefficients one at a time (thrum/kernel_pass.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/kernel_pass.h"

#include "core/polynomial/points.h"
#include "core/polynomial/polynomial_private.h"

#define PAIRS_OPERATIONS 4.0 /* with a number of those by pairs */

size_t thrum_pass_result_count(const thrum_model *model) {
  return (size_t)(model->rank * model->rank + thrum_restriction_count(model, model->rank));
}

thrum_status thrum_pass_run(const thrum_model *model, thrum_kernel_id kernel, thrum_pass pass,
                            int32_t explicit_modes, const double *q, const double *v,
                            double *result, double *work, thrum_error *error) {
  if (!model || !q || !v || !result || !work)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "an argument is NULL");
  if (!thrum_has_energy(model))
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no polynomial of all its coordinates: where it was "
                           "precomputed condensed, take what thrum_model_condense makes of it");
  if (explicit_modes < 0 || explicit_modes > model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%d explicit modes of a model with %lld",
                           (int)explicit_modes, (long long)model->rank);

  // what a restriction leaves lies behind the other results
  const thrum_kernel *by = thrum_kernel_get((int32_t)kernel);
  double *restricted = result + model->rank * model->rank;
  switch (pass) {
  case THRUM_PASS_ENERGY:
    result[0] = thrum_strain_energy_by(by, model, q, work);
    return THRUM_OK;
  case THRUM_PASS_FORCE:
    thrum_internal_force_by(by, model, q, result, work);
    return THRUM_OK;
  case THRUM_PASS_TANGENT:
    thrum_tangent_stiffness_by(by, model, q, result, work);
    return THRUM_OK;
  case THRUM_PASS_TANGENT_VECTOR:
    thrum_tangent_product_by(by, model, q, v, result, work);
    return THRUM_OK;

  // those of a split
  case THRUM_PASS_RESTRICT:
    thrum_polynomial_restrict(by, model, explicit_modes, q, restricted, work);
    return THRUM_OK;
  case THRUM_PASS_RESTRICTED_TANGENT:
    thrum_restricted_hessian(by, model, explicit_modes, restricted, q + explicit_modes, result,
                             work);
    return THRUM_OK;
  case THRUM_PASS_COUNT:
    break;
  }
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no pass %d", (int)pass);
}

/* Terms of degree 3 and 4 of so many coordinates. */
static double terms(int64_t rank) {
  return (double)(thrum_c3_count(rank) + thrum_c4_count(rank));
}

thrum_pass_cost thrum_pass_cost_of(int64_t rank, thrum_pass pass, int64_t explicit_modes) {
  static const double operations[THRUM_PASS_COUNT] = {
#define X(name, each, key, text) each,
      THRUM_PASS_LIST(X)
#undef X
  };
  if (rank < 1 || rank > THRUM_RANK_MAX || (int)pass < 0 || (int)pass >= THRUM_PASS_COUNT ||
      explicit_modes < 0 || explicit_modes > rank)
    return (thrum_pass_cost){0.0, 0.0};

  // tangents of small models are products with a symmetric matrix, one number for each two pairs
  const double pairs = (double)thrum_pack_first(rank);
  if ((pass == THRUM_PASS_TANGENT && thrum_pairs_count(rank) > 0) ||
      (pass == THRUM_PASS_TANGENT_VECTOR && rank <= THRUM_PAIRS_VECTOR_RANK_MOST)) {
    const double numbers = 0.5 * pairs * (pairs + 1.0);
    return (thrum_pass_cost){PAIRS_OPERATIONS * numbers, numbers};
  }

  // a restriction meets the terms with modes of both kinds, its derivatives those of I alone
  const double inner = terms(rank - explicit_modes);
  double numbers = terms(rank);
  if (pass == THRUM_PASS_RESTRICTED_TANGENT)
    numbers = inner;
  else if (pass == THRUM_PASS_RESTRICT)
    numbers -= inner + terms(explicit_modes);
  return (thrum_pass_cost){operations[pass] * numbers, numbers};
}
