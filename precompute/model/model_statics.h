/* Linear static answers of the full-order body of a model. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_MODEL_STATICS_H
#define THRUM_PRECOMPUTE_MODEL_MODEL_STATICS_H

#include "precompute/model/model_fem.h"

/* Solves K x = f by `factor`, whose solves of a free body keep to what the rigid modes leave. */
typedef struct thrum_model_statics {
  thrum_model_fem body;
  thrum_factor *factor;
  double *rigid, *dual; /* Z and M Z of a free body, free_count x 6; else NULL */
} thrum_model_statics;

/* The model must stay while the answers are used, and the struct where it is. THRUM_MISSING without
 * a mesh, THRUM_SINGULAR when a part can move. On failure what was made is to be freed, too. */
thrum_status thrum_model_statics_create(const thrum_model *model, thrum_model_statics *statics,
                                        thrum_error *error);
/* The same in two steps: the body, and a factor that is planned; then the factor's numbers. */
thrum_status thrum_model_statics_plan(const thrum_model *model, thrum_model_statics *statics,
                                      thrum_error *error);
thrum_status thrum_model_statics_factorise(thrum_model_statics *statics, thrum_error *error);
void thrum_model_statics_free(thrum_model_statics *statics); /* a zeroed one is fine */

#endif
