/* Judges what the basis of a model leaves out of its motion, design 10.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_BASIS_JUDGE_H
#define THRUM_PRECOMPUTE_MODEL_BASIS_JUDGE_H

#include "precompute/model/model_statics.h"

/* The body behind a model, a factor of its stiffness at rest, and the directions that it was found
 * to lack. One thread at a time. */
typedef struct thrum_basis_judge thrum_basis_judge;

/* Makes the judge of a model with a mesh and a basis, which must stay, and plans its factor. It has
 * room for so many directions. THRUM_MISSING without mesh or basis. */
thrum_status thrum_basis_judge_create(const thrum_model *model, int64_t directions,
                                      thrum_basis_judge **judge, thrum_error *error);
void thrum_basis_judge_free(thrum_basis_judge *judge); /* NULL is fine */

/* The body and its factor, planned until thrum_basis_judge_begin has computed it, which comes
 * before anything that follows. */
const thrum_model_statics *thrum_basis_judge_statics(const thrum_basis_judge *judge);
thrum_status thrum_basis_judge_begin(thrum_basis_judge *judge, thrum_error *error);

/* Masses of the vertices (vertex_count) [kg], as gravity takes them; the judge's. */
const double *thrum_basis_judge_masses(const thrum_basis_judge *judge);

/* What the mesh asks for at the shape q (rank) under forces on all components (3 vertex_count) [N],
 * whose part that accelerates the coordinates is taken off: the sums of the squares over all
 * components of where the mesh would be, into *moved, and of the displacement that is lacking, into
 * *lacking [m^2].
 * rate2: the square of the rate at which the body moves, rms velocity over rms displacement
 * [1/s^2]; 0: at rest. The displacement becomes a direction where there is room. */
thrum_status thrum_basis_judge_look(thrum_basis_judge *judge, const double *q, const double *forces,
                                    double rate2, double *moved, double *lacking,
                                    thrum_error *error);

/* Solves that a look takes, about. */
#define THRUM_BASIS_LOOK_SOLVES 12

/* Directions so far, as displacements of the free components (free_count each). */
int64_t thrum_basis_judge_directions(const thrum_basis_judge *judge, const double **directions);

#endif
