/* Places where a user will pull, and how the body answers there.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_HANDLES_H
#define THRUM_PRECOMPUTE_BASIS_HANDLES_H

#include "precompute/fem/fem.h"

/* `spec` is vertex=N, by its number in the file, or a group of the mesh, which must stay. */
thrum_status thrum_handle_find(const thrum_mesh *mesh, const char *spec, thrum_handle *handle,
                               thrum_error *error);

/* The static responses K^-1 f to unit forces along x, y, z on every handle, shared evenly by its
 * vertices, each of unit mass norm: responses n x 3 count, column-major; omega2 (3 count) their
 * Rayleigh quotients. Where a whole handle is held along an axis: zero and INFINITY; refuses one
 * that is held along all. Of a free body: to the forces less their resultant. */
thrum_status thrum_handle_responses(const thrum_fem *fem, const thrum_sparse *mass,
                                    thrum_factor *factor, int64_t count,
                                    const thrum_handle *handles, double *responses, double *omega2,
                                    thrum_error *error);

#endif
