/* Displacements of a body's vertices: u = U q, their mean and their peak, and starts of a given
 * amplitude. Needs a model with a basis (THRUM_MISSING otherwise). Pure functions; any thread;
 * nothing allocated. A failure leaves the outputs as they were. THRUM_INVALID_ARGUMENT for NULL;
 * THRUM_BAD_VALUE for a q with an entry that is not a number within 1e100.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DISPLACEMENT_H
#define THRUM_DISPLACEMENT_H

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* u = U q of `count` vertices from `first` (0-based): displacements, count x 3 [m]; q: rank. */
THRUM_API thrum_status thrum_displacement(const thrum_model *model, const double *q, int64_t first,
                                          int64_t count, double *displacements, thrum_error *error);

/* Mean displacement (x, y, z) [m] of `count` vertices under q (rank): the displacement on which a
 * force that they share does work. vertices (0-based) NULL: all of the model, and count is ignored.
 */
THRUM_API thrum_status thrum_displacement_mean(const thrum_model *model, const int32_t *vertices,
                                               int64_t count, const double *q, double mean[3],
                                               thrum_error *error);

/* q (rank) += the multiple of basis vector `mode` (0-based) under which the vertex that moves
 * furthest is displaced by |amplitude| [m]; the sign is the amplitude's. */
THRUM_API thrum_status thrum_mode_add(const thrum_model *model, int64_t mode, double amplitude,
                                      double *q, thrum_error *error);

/* extents (rank): the largest vertex displacement under a unit of each basis vector [kg^-1/2]. */
THRUM_API thrum_status thrum_basis_extents(const thrum_model *model, double *extents,
                                           thrum_error *error);

/* Keeps a running peak: where a vertex moves further under q than *length [m], *length becomes the
 * largest displacement and *vertex (0-based) the vertex. `extents` of thrum_basis_extents bounds
 * the displacement, so that most calls cost `rank` operations and not the whole body. */
THRUM_API thrum_status thrum_displacement_peak(const thrum_model *model, const double *extents,
                                               const double *q, double *length, int64_t *vertex,
                                               thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
