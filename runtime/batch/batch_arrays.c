/* What goes in and out of all states of a batch at once (thrum/batch.h): the functions for one
 * state, row by row. Cost: that of these functions; for loads and for q some ten nanoseconds a
 * state. SPDX-License-Identifier: Apache-2.0 */
#include "thrum/actuation.h"
#include "thrum/batch.h"

/* Which failure is returned: that of the first state. */
static void note(int64_t index, thrum_status status, const thrum_error *why, thrum_status *worst,
                 thrum_error *error) {
  if (status < 0 && *worst >= 0)
    *worst = thrum_error_set(error, status, "state %lld: %s", (long long)index, why->message);
}

static thrum_status check(const thrum_model *model, thrum_state *const *states, int64_t count,
                          int64_t stride, thrum_error *error) {
  if (!model || count < 0 || (count > 0 && !states) || stride < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model or states are NULL, or count or stride is negative");
  return THRUM_OK;
}

/* Row n; NULL where there are none. */
static const double *row(const double *rows, int64_t stride, int64_t n) {
  return rows ? rows + stride * n : NULL;
}

thrum_status thrum_batch_set_forces(const thrum_model *model, thrum_state *const *states,
                                    int64_t count, const double *forces, int64_t stride,
                                    thrum_error *error) {
  thrum_status worst = THRUM_OK;
  THRUM_TRY(check(model, states, count, stride, error));
  for (int64_t n = 0; n < count; n++) {
    thrum_error why = {.status = THRUM_OK};
    note(n, thrum_state_set_force(model, states[n], row(forces, stride, n), &why), &why, &worst,
         error);
  }
  return worst;
}

thrum_status thrum_batch_set_actuation(const thrum_model *model, thrum_state *const *states,
                                       int64_t count, const double *levels, int64_t stride,
                                       thrum_error *error) {
  thrum_status worst = THRUM_OK;
  THRUM_TRY(check(model, states, count, stride, error));
  for (int64_t n = 0; n < count; n++) {
    thrum_error why = {.status = THRUM_OK};
    note(n, thrum_state_set_actuation(model, states[n], row(levels, stride, n), &why), &why, &worst,
         error);
  }
  return worst;
}

thrum_status thrum_batch_set(const thrum_model *model, thrum_state *const *states, int64_t count,
                             const uint8_t *chosen, const double *q, const double *p,
                             int64_t stride, thrum_error *error) {
  thrum_status worst = THRUM_OK;
  THRUM_TRY(check(model, states, count, stride, error));
  for (int64_t n = 0; n < count; n++) {
    thrum_error why = {.status = THRUM_OK};
    if (!chosen || chosen[n])
      note(n, thrum_state_set(model, states[n], row(q, stride, n), row(p, stride, n), &why), &why,
           &worst, error);
  }
  return worst;
}

thrum_status thrum_batch_get(const thrum_model *model, thrum_state *const *states, int64_t count,
                             double *q, double *p, int64_t stride, thrum_error *error) {
  thrum_status worst = THRUM_OK;
  THRUM_TRY(check(model, states, count, stride, error));
  if (stride < model->rank && count > 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rows of %lld numbers cannot lie %lld apart", (long long)model->rank,
                           (long long)stride);
  for (int64_t n = 0; n < count; n++) {
    thrum_error why = {.status = THRUM_OK};
    const thrum_status status = thrum_state_get(model, states[n], q ? q + stride * n : NULL,
                                                p ? p + stride * n : NULL, &why);
    note(n, status, &why, &worst, error);
  }
  return worst;
}

thrum_status thrum_batch_energies(const thrum_model *model, thrum_state *const *states,
                                  int64_t count, thrum_energies *energies, thrum_error *error) {
  thrum_status worst = THRUM_OK;
  THRUM_TRY(check(model, states, count, 0, error));
  if (count > 0 && !energies)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the energies are NULL");
  for (int64_t n = 0; n < count; n++) {
    thrum_error why = {.status = THRUM_OK};
    note(n, thrum_state_energies(model, states[n], &energies[n], &why), &why, &worst, error);
  }
  return worst;
}
