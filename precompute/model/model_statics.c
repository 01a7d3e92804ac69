/* Linear static answers of a model's body, see model_statics.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/model_statics.h"

#include <stdlib.h>

#include "platform/allocate.h"
#include "platform/threads.h"
#include "precompute/fem/rigid_modes.h"

/* The rigid modes of a free body. */
static thrum_status find_rigid(thrum_model_statics *s, thrum_error *error) {
  const thrum_fem *fem = &s->body.fem;
  const int64_t count = THRUM_RIGID_COUNT * fem->free_count;
  THRUM_TRY(thrum_reserve(&s->rigid, count, sizeof(double), "the rigid modes", error));
  THRUM_TRY(thrum_reserve(&s->dual, count, sizeof(double), "the rigid modes", error));
  return thrum_rigid_modes(fem, &s->body.mass, s->rigid, s->dual, error);
}

thrum_status thrum_model_statics_plan(const thrum_model *model, thrum_model_statics *statics,
                                      thrum_error *error) {
  *statics = (thrum_model_statics){0};
  THRUM_TRY(thrum_threads_ready(1, error));
  THRUM_TRY(thrum_model_fem_create(model, &statics->body, error));
  if (model->rigid != NULL)
    THRUM_TRY(find_rigid(statics, error));
  return thrum_factor_plan(&statics->body.stiffness, &statics->factor, error);
}

thrum_status thrum_model_statics_factorise(thrum_model_statics *s, thrum_error *error) {
  const thrum_fem *fem = &s->body.fem;
  thrum_support_springs springs;

  // a free body's stiffness is singular until six springs hold it
  if (s->rigid)
    thrum_support_springs_add(fem, &s->body.stiffness, &springs);
  const thrum_status status = thrum_factor_compute(&s->body.stiffness, s->factor, error);
  if (s->rigid)
    thrum_support_springs_remove(&springs, &s->body.stiffness);
  if (status >= 0 && s->rigid)
    thrum_factor_deflate(s->factor, THRUM_RIGID_COUNT, s->rigid, s->dual);
  return status;
}

thrum_status thrum_model_statics_create(const thrum_model *model, thrum_model_statics *statics,
                                        thrum_error *error) {
  THRUM_TRY(thrum_model_statics_plan(model, statics, error));
  return thrum_model_statics_factorise(statics, error);
}

void thrum_model_statics_free(thrum_model_statics *statics) {
  thrum_factor_free(statics->factor);
  thrum_model_fem_free(&statics->body);
  free(statics->rigid);
  free(statics->dual);
  *statics = (thrum_model_statics){0};
}
