/* The polynomial V(q), design (1), for libthrum's own files: evaluation by a given
 * kernel, and V restricted to the implicit modes for the inner iteration of design 5. Private to
 * libthrum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_POLYNOMIAL_POLYNOMIAL_PRIVATE_H
#define THRUM_CORE_POLYNOMIAL_POLYNOMIAL_PRIVATE_H

#include "core/polynomial/kernel_private.h"
#include "core/polynomial/packed.h"
#include "core/polynomial/points.h"
#include "thrum/polynomial.h"

/* --- V by a given kernel: see thrum/polynomial.h ---------------------------------------------- */
double thrum_strain_energy_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                              double *work);

/* The size of what actuators add to V(q) [J], 0 without levels: where it is below 0, V and the
 * kinetic energy that it is exchanged with cancel, and errors are small beside this. */
double thrum_exchanged_energy_by(const thrum_kernel *by, const thrum_model *model, const double *q);

double thrum_internal_force_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                               double *force, double *work);
void thrum_tangent_stiffness_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                                double *tangent, double *work);

/* Two points from one read of the coefficients: the bits of thrum_internal_force_by at each. */
void thrum_internal_forces_by(const thrum_kernel *by, const thrum_model *model,
                              const double *const q[2], double *const force[2], double energy[2],
                              double *work);

/* Force and tangent from one read; the tangent has the bits of thrum_tangent_stiffness_by, force
 * and energy have others than thrum_internal_force_by in their last places. */
double thrum_internal_force_tangent_by(const thrum_kernel *by, const thrum_model *model,
                                       const double *q, double *force, double *tangent,
                                       double *work);

/* The same for a Jacobian to which the tangent adds `weight` times itself: what acts may lack what
 * is little there. */
void thrum_tangent_stiffness_near(const thrum_kernel *by, const thrum_model *model, double weight,
                                  const double *q, double *tangent, double *work);
double thrum_internal_force_tangent_near(const thrum_kernel *by, const thrum_model *model,
                                         double weight, const double *q, double *force,
                                         double *tangent, double *work);

void thrum_tangent_product_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                              const double *v, double *product, double *work);

/* The first `split` entries of the force, and V(q). */
double thrum_internal_force_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                 const double *q, double *force, double *work);

/* The first `split` entries of T v for a v whose other entries, which are not read, are zero. */
void thrum_tangent_product_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                const double *q, const double *v, double *product, double *work);

/* --- V with the first `split` coordinates held ---------------------------------------------------
 * n = rank - split coordinates remain. A restricted polynomial is one array of
 * thrum_restriction_count(model, n) doubles, as core/polynomial/packed.h and points.h say. What
 * is of degree 4 in them is read from the model where it lies: so the functions that use it take
 * the model and the split again. */

/* Restricts V at q (rank; the entries from split on are not read) into `restricted`, without the
 * constant term V(q_E, 0), whose coefficients are not read. work: thrum_work_count(model). */
void thrum_polynomial_restrict(const thrum_kernel *by, const thrum_model *model, int32_t split,
                               const double *q, double *restricted, double *work);

/* Value at q_high (n), constant term left out; `gradient` (n) gets R_I. work as above. */
double thrum_restricted_gradient(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                 const double *restricted, const double *q_high, double *gradient,
                                 double *work);

/* `hessian` (n x n, both triangles) gets T_II at q_high. work as above. */
void thrum_restricted_hessian(const thrum_kernel *by, const thrum_model *model, int32_t split,
                              const double *restricted, const double *q_high, double *hessian,
                              double *work);

#endif
