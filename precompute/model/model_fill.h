/* The arrays of a freshly precomputed model, one heap block each.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_MODEL_FILL_H
#define THRUM_PRECOMPUTE_MODEL_MODEL_FILL_H

#include "precompute/fem/fem.h"
#include "thrum/model.h"

/* Allocates every array but meta and copies in format, mesh, materials, fixed and groups; omega2,
 * c3, c4, basis and axis_mass are left to be written. `model` must be zeroed; on failure what was
 * allocated stays in it for thrum_model_fill_free. */
thrum_status thrum_model_fill_mesh(const thrum_mesh *mesh, const uint8_t *fixed, int64_t rank,
                                   bool points, thrum_model *model, thrum_error *error);

/* Adds the law of the cubature points, or those of the regions with their yields, and the version
 * of the format that goes with it; nothing for Saint Venant-Kirchhoff material. */
thrum_status thrum_model_fill_law(const thrum_fem *fem, thrum_model *model, thrum_error *error);

/* axis_mass = U^T M 1 from the model's basis. 1 is taken on all vertices, held ones included: a
 * body force acts through the whole mass of the elements around a free vertex. */
thrum_status thrum_model_fill_axis_mass(const thrum_fem *fem, thrum_mass kind, thrum_model *model,
                                        thrum_error *error);

/* Adds the rigid modes Z (free_count x 6, column-major) of a body with nothing held. */
thrum_status thrum_model_fill_rigid(const thrum_fem *fem, const double *modes, thrum_model *model,
                                    thrum_error *error);

/* The array behind a model's const pointer, for code that is still making the model, or that only
 * reads through another pointer. */
void *thrum_model_writable(const void *array);

void thrum_model_fill_free(thrum_model *model); /* leaves it empty; meta is the caller's */

#endif
