/* The reference of an error in time: `energy` at a step far below those compared.
 *
 * The scheme is of order 2, so the run with twice the step is off by four times as much, and a
 * third of the difference of the two is the error of the finer one.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/fine_reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "validation/experiments/scheme.h"

#define TOLERANCE 1e-12 /* of its solves */

/* Steps from the kick on, `finer` steps in each spacing, and writes q of each moment. */
static thrum_status follow(const experiment_body *body, double impulse,
                           const experiment_reference *at, int finer, double *q,
                           thrum_error *error) {
  const thrum_model *model = body->model;
  thrum_state_def def = experiment_scheme_def(EXPERIMENT_SCHEME_ENERGY, at->spacing / finer);
  thrum_state *state = NULL;
  double energy;
  def.tolerance = TOLERANCE;
  THRUM_TRY(thrum_state_create(model, &def, &state, error));

  // the first moment is the kick itself
  thrum_status status = experiment_kick(body, impulse, state, &energy, error);
  for (int64_t k = 0; k < at->count && status >= 0; k++) {
    for (int n = 0; n < finer && k > 0 && status >= 0; n++)
      status = thrum_step(model, state, error);
    THRUM_THEN(status, thrum_state_get(model, state, q + k * model->rank, NULL, error));
  }
  thrum_state_destroy(state);
  return status;
}

thrum_status experiment_reference_make(const experiment_body *body, double impulse, double spacing,
                                       int64_t count, experiment_reference *reference,
                                       thrum_error *error) {
  const int64_t rank = body->model->rank;
  *reference = (experiment_reference){.spacing = spacing, .count = count};
  double *coarse = NULL;
  thrum_status status =
      thrum_reserve(&reference->q, count * rank, sizeof *reference->q, "the reference", error);
  THRUM_THEN(status, thrum_reserve(&coarse, count * rank, sizeof *coarse, "the reference", error));
  THRUM_THEN(status,
             follow(body, impulse, reference, EXPERIMENT_REFERENCE_FINER, reference->q, error));
  THRUM_THEN(status,
             follow(body, impulse, reference, EXPERIMENT_REFERENCE_FINER / 2, coarse, error));

  // order 2: the coarse run is off by four times the error of the fine one
  experiment_deviation sums = {0, 0};
  for (int64_t k = 0; k < count && status >= 0; k++)
    experiment_deviation_add(&sums, reference, rank, k, coarse + k * rank);
  reference->error = experiment_deviation_value(&sums) / 3;
  free(coarse);
  return status;
}

void experiment_reference_free(experiment_reference *reference) {
  free(reference->q);
  memset(reference, 0, sizeof *reference);
}

void experiment_deviation_add(experiment_deviation *sums, const experiment_reference *reference,
                              int64_t rank, int64_t index, const double *q) {
  const double *right = reference->q + index * rank;
  for (int64_t i = 0; i < rank; i++) {
    sums->difference += (q[i] - right[i]) * (q[i] - right[i]);
    sums->size += right[i] * right[i];
  }
}

double experiment_deviation_value(const experiment_deviation *sums) {
  return sqrt(sums->difference / sums->size);
}
