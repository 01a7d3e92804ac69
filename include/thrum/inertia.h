/* The inertia of a free body as a function of its shape: what couples its deformation to its
 * rotation (design 20; thrum/floating_frame.h steps with it).
 *
 * With x = X + U q from the centre of mass, mass m, and the sums over the mass matrix,
 *
 *   inertia     I(q) = sum m (|x|^2 1 - x x^T),               quadratic in q,
 *   gyration    G(q) qdot = sum m (U q) x (U qdot),           linear in each:
 *
 * the angular momentum of a body that turns with w is I w + G qdot. Both follow from 9 r + 9 r
 * (r + 1)/2 numbers, sums of products of the basis with the places at rest and with itself, which
 * are made once of the mesh, the material and the basis of a model.
 *
 * Threads: made once, an inertia is only read, and may be shared by any number of threads. Only
 * thrum_inertia_create allocates.
 *
 * Source: Shabana 2013, Dynamics of multibody systems, 5.3, doi:10.1017/CBO9781107337213.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_INERTIA_H
#define THRUM_INERTIA_H

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Opaque. */
typedef struct thrum_inertia thrum_inertia;

/* Makes the inertia of a free body's model for its first `rank` coordinates (0: all), scaled as
 * thrum_model_scale does (NULL: not), with the mass matrix, consistent or lumped, for which the
 * basis is orthonormal, or from `inertia` of a model that has it. The caller owns it and passes it
 * to thrum_inertia_destroy; the model may go. THRUM_MISSING for a model without mesh, basis or
 * rigid modes, nor `inertia`, THRUM_NOT_FINITE for one that is not finite; THRUM_UNSUPPORTED for a
 * condensed model, for hexahedra and wedges without `inertia`, for cubature points of another law
 * than Saint Venant-Kirchhoff, and for a basis that is not orthonormal for the mass or not
 * orthogonal to the rigid modes (1e-6); THRUM_INVALID_ARGUMENT, THRUM_OUT_OF_MEMORY. Time: r^2
 * numbers a vertex. */
THRUM_API thrum_status thrum_inertia_create(const thrum_model *model, int64_t rank,
                                            const thrum_model_scaling *by, thrum_inertia **inertia,
                                            thrum_error *error);

/* Returns the memory; NULL does nothing. */
THRUM_API void thrum_inertia_destroy(thrum_inertia *inertia);

/* Coordinates that it is for; 0 for NULL. */
THRUM_API int64_t thrum_inertia_rank(const thrum_inertia *inertia);

/* Numbers that thrum_inertia_numbers writes for this many coordinates. */
static inline int64_t thrum_inertia_number_count(int64_t rank) {
  return 9 + 9 * rank * (rank + 1);
}

/* Writes the numbers that I and G are made of, which `inertia` of a model without its mesh points
 * to: sum m X X^T (3 x 3) [kg m^2], with X from the centre of mass; sum m X U_i^T (rank x 3 x 3)
 * [kg^1/2 m]; sum m U_j U_i^T (rank x rank x 3 x 3, j first) [1]. Any thread. */
THRUM_API void thrum_inertia_numbers(const thrum_inertia *inertia, double *numbers);

/* I(q) about the centre of mass, in the mesh [kg m^2], symmetric; q: rank. `work` has room for
 * 9 rank doubles. */
THRUM_API void thrum_inertia_tensor(const thrum_inertia *inertia, const double *q, double tensor[9],
                                    double *work);

#ifdef __cplusplus
}
#endif
#endif
