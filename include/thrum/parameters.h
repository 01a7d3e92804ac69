/* Bodies of other materials, without another precompute: a model that was made with `thrum
 * precompute --parameters` holds what Lame's lambda and mu and the density of each region add to
 * its polynomial and its mass, all of which are linear in them.
 *
 *   thrum_model_parameters_get(model, values, &error);
 *   values[1] *= 1.2;                                                // mu of the first region
 *   thrum_model_set_parameters(memory, size, model, values, turn, work, &softer, &error);
 *
 * The new model has modes of its own, steps as any other and costs the same. Its basis spans what
 * that of the old one spans: it is the body of other values as far as its motion lies in there.
 *
 * Parameters are numbered 3 g for lambda [Pa], 3 g + 1 for mu [Pa] and 3 g + 2 for the density
 * [kg/m^3] of region g. Derivatives of runs by them: thrum/gradient.h. Equations:
 * docs/mathematics/22_gradients.md. Nothing here allocates. Any thread.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PARAMETERS_H
#define THRUM_PARAMETERS_H

#include <stddef.h>

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How many parameters a model has: 3 region_count, or 0 where it was made without, and for NULL. */
THRUM_API int64_t thrum_model_parameter_count(const thrum_model *model);

/* Their values into `values` (thrum_model_parameter_count). THRUM_UNSUPPORTED for a model without
 * parameters, THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_model_parameters_get(const thrum_model *model, double *values,
                                                  thrum_error *error);

/* Bytes that thrum_model_set_parameters needs for this model, into *size, and doubles of its work,
 * 2 rank^4 + 3 rank^2 + 3 rank, into *work; either may be NULL. Failures as above. */
THRUM_API thrum_status thrum_model_parameters_size(const thrum_model *model, size_t *size,
                                                   size_t *work, thrum_error *error);

/* The body of other parameters, in `memory` (the caller's, aligned to 64, of *size bytes).
 * Vertices, tetrahedra, groups and meta stay where `model` has them, so it must outlive *set.
 * turn (rank x rank; may be NULL): q = turn q' of one motion in both models. work: *work doubles,
 * free again after the call. THRUM_BAD_VALUE for values that are not finite, a density or mu that
 * is not above 0, or 3 lambda + 2 mu that is not; THRUM_UNSUPPORTED for a free body whose densities
 * change by different factors, as it turns about another point; THRUM_MISALIGNED,
 * THRUM_BUFFER_TOO_SMALL, or as above. Cost: about 16 rank^5 operations for each region. */
THRUM_API thrum_status thrum_model_set_parameters(void *memory, size_t memory_size,
                                                  const thrum_model *model, const double *values,
                                                  double *turn, double *work,
                                                  const thrum_model **set, thrum_error *error);

/* How V changes with one parameter, 0 <= parameter < thrum_model_parameter_count, to first order:
 * into linear (rank x rank), c3 (c3_count) and c4 (c4_count) per unit of it. A density changes V in
 * coordinates that keep unit mass, x = q + 1/2 M q of that much density with mass M, which goes
 * into `mass` (rank x rank); of a modulus that is zero. work as above. THRUM_INVALID_ARGUMENT for
 * a parameter that there is not, or as above. */
THRUM_API thrum_status thrum_model_parameter_slope(const thrum_model *model, int64_t parameter,
                                                   double *linear, double *c3, double *c4,
                                                   double *mass, double *work, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
