/* How the frequencies of a body change with the places of its vertices.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_SHAPE_GRADIENT_H
#define THRUM_DRIVER_MODEL_SHAPE_GRADIENT_H

#include "thrum/model.h"

/* Relative changes of the frequencies of the first `modes` basis vectors, which are modes of the
 * mesh: *found, modes x vertices x 3 [1/m], which the caller frees. Of modes that share a frequency
 * each row is the mean of theirs, as a single one has a kink there. A middle node has derivatives
 * of its own: a corner whose straight edges follow has half of theirs beside. THRUM_MISSING where
 * the model has no mesh or basis, THRUM_UNSUPPORTED for ten-node tetrahedra of lumped
 * mass. */
thrum_status shape_gradient_find(const thrum_model *model, int64_t modes, double **found,
                                 thrum_error *error);

#endif
