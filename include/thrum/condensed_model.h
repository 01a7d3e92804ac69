/* Condensed models: the stiff coordinates of a body follow the soft ones at rest, and are not
 * stepped (design 16). With q = (x, y), x the first k coordinates (the masters), y the others (the
 * slaves), and a_h = dV/dy_h at y = 0 without its linear part, quadratic in x:
 *
 *   y_h(x) = -a_h(x) / w_h^2 + f_h / w_h^2,    V_c(x) = V(x, 0) - 1/2 sum_h a_h(x)^2 / w_h^2,
 *
 * again a quartic polynomial, in k coordinates. f_h is a load on a slave. V_c is V at its least
 * over y, but for terms of V in x y y, x x x y and higher: where the slaves are not small it may be
 * wrong, and unlike V nothing bounds it below.
 *
 * A master that stretches the body moves, as the slaves do, by the square of what bends it. So of a
 * model with a mesh V_c has no monomials that are of order above 4 in what bends, where such a
 * master counts twice, and no slave follows a product of it: these terms belong to sums of which
 * V_c has not the rest. A master stretches where w^4 / (4 c4_iiii), the energy at which its quartic
 * energy is as large as its quadratic one, is above 0.05 of that of the mesh at strains of 1,
 * 1/2 int E dX.
 *
 * Two models belong together. The *stepped* model has rank k, the polynomial V_c, and no mesh: it
 * is what states, batches and the functions of thrum/polynomial.h take. Its *shape model*,
 * thrum_condensed_shape_model, has the mesh and the basis of all r coordinates: it is what
 * displacements, surfaces, stress, monitors and loads take, with the r coordinates that
 * thrum_condensed_shape makes of x. A function that needs a basis therefore refuses the stepped
 * model (THRUM_MISSING) and never shows a body without its slaves.
 *
 * The cost: the slaves have no inertia and do not vibrate. thrum_condensed_inertia_share says
 * how much of the kinetic energy that leaves out. Sources: Vizzaccaro et al. 2020,
 * doi:10.1007/s11071-020-05813-1; Touze et al. 2021, doi:10.1007/s00466-021-02051-1.
 *
 * Functions of models are pure: any thread. Those of a state are for the thread that has it.
 * Nothing is allocated.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONDENSED_MODEL_H
#define THRUM_CONDENSED_MODEL_H

#include "thrum/api.h"
#include "thrum/model.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Energy [J] of the mesh at strains of 1, 1/2 int E dX, by which thrum_model_condense tells masters
 * that stretch the body from those that bend it; of a model without tetrahedra its `unit_energy`. 0
 * where neither is there, and for NULL. */
THRUM_API double thrum_model_unit_energy(const thrum_model *model);

/* Bytes that thrum_model_condense needs for this model and this number of masters, into *size.
 * THRUM_INVALID_ARGUMENT for NULL or masters out of 1 to one less than the model's rank, or above
 * thrum_model_masters of a model that was precomputed condensed; THRUM_MISSING for a model without
 * a polynomial; THRUM_UNSUPPORTED for one of cubature points or with a gas, which acts at level 0;
 * THRUM_BAD_VALUE where a slave has no stiffness. */
THRUM_API thrum_status thrum_model_condense_size(const thrum_model *model, int64_t masters,
                                                 size_t *size, thrum_error *error);

/* The stepped model of the lowest `masters` coordinates, in `memory` (the caller's, aligned to 64,
 * thrum_model_condense_size bytes). `model` is its shape model and must outlive it. A model that is
 * itself stepped is refused. THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or as
 * thrum_model_condense_size. Cost: masters^4 (rank - masters) / 4 operations. */
THRUM_API thrum_status thrum_model_condense(void *memory, size_t memory_size,
                                            const thrum_model *model, int64_t masters,
                                            const thrum_model **condensed, thrum_error *error);

/* The model that shows a body: the shape model of a stepped one, `model` itself where it is not
 * condensed. */
THRUM_API const thrum_model *thrum_condensed_shape_model(const thrum_model *model);

/* q (shape model's rank) = (x, y(x)) for the masters x (rank) of a stepped model. load: NULL, or
 * the load on all coordinates (shape model's rank), whose static answer y gets. Of a model that is
 * not condensed: a copy. q and x do not overlap. */
THRUM_API void thrum_condensed_shape(const thrum_model *model, const double *x, const double *load,
                                     double *q);

/* Velocities of all coordinates, p (shape model's rank) = (v, dy/dx v), at the masters x with the
 * velocities v (rank each). p overlaps neither. */
THRUM_API void thrum_condensed_velocity(const thrum_model *model, const double *x, const double *v,
                                        double *p);

/* reduced (rank) = the force on the masters of a load on all coordinates (shape model's rank) at x:
 * f_i + sum_h f_h dy_h/dx_i. It depends on x: thrum_state_set_load takes x in the middle of a step.
 * reduced overlaps neither. */
THRUM_API void thrum_condensed_load(const thrum_model *model, const double *x, const double *load,
                                    double *reduced);

/* Sets the external load of the steps to come, as thrum_state_set_force does, by the load on all
 * coordinates (shape model's rank). What acts on the slaves acts on the masters as they follow in
 * the middle of the step to come, which the state extrapolates from the two steps before (order 2,
 * design 16): set it before each step where it acts on slaves, also where it does not change. Of a
 * model that is not condensed it is thrum_state_set_force. Errors as of that. */
THRUM_API thrum_status thrum_state_set_load(const thrum_model *model, thrum_state *state,
                                            const double *load, thrum_error *error);

/* The same without setting it: reduced (rank) = the force on the masters in the step to come. The
 * arrays do not overlap. */
THRUM_API thrum_status thrum_state_reduce_load(const thrum_model *model, thrum_state *state,
                                               const double *load, double *reduced,
                                               thrum_error *error);

/* Kinetic energy of the slaves over that of the whole [1] at x with the velocities v (rank each):
 * the inertia that condensing leaves out. 0 at rest, and of a model that is not condensed. */
THRUM_API double thrum_condensed_inertia_share(const thrum_model *model, const double *x,
                                               const double *v);

#ifdef __cplusplus
}
#endif
#endif
