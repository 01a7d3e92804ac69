/* What the runtime's own files share about the polynomial V(q), design (1): evaluation by a given
 * kernel, and V restricted to the implicit modes for the inner iteration of design 5; and plain
 * products with a matrix. Private to runtime/.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POLYNOMIAL_POLYNOMIAL_PRIVATE_H
#define THRUM_RUNTIME_POLYNOMIAL_POLYNOMIAL_PRIVATE_H

#include "runtime/polynomial/kernel_private.h"
#include "runtime/polynomial/packed.h"
#include "thrum/polynomial.h"

/* --- products with a matrix (polynomial_kernel.c) ------------------------------------------------
 * `block` is rows x columns, row-major and contiguous. A sum over columns runs in 8 lanes (lane =
 * column mod 8, ascending), added as ((0+4)+(2+6))+((1+5)+(3+7)); a sum over rows is ascending. */

/* y += B m; m: columns, y: rows. */
void thrum_kernel_product(int64_t rows, int64_t columns, const double *block, const double *m,
                          double *y);

/* w += B^T x; x: rows, w: columns. */
void thrum_kernel_transposed(int64_t rows, int64_t columns, const double *block, const double *x,
                             double *w);

/* --- V by a given kernel: see thrum/polynomial.h ------------------------------------------------
 */
double thrum_energy_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                       double *work);
double thrum_force_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                      double *force, double *work);
void thrum_tangent_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                      double *tangent, double *work);

/* Two points from one read of the coefficients: the bits of thrum_force_by at each. */
void thrum_forces_by(const thrum_kernel *by, const thrum_model *model, const double *const q[2],
                     double *const force[2], double energy[2], double *work);

/* Force and tangent from one read; the tangent has the bits of thrum_tangent_by, force and energy
 * have others than thrum_force_by in their last places. */
double thrum_force_tangent_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                              double *force, double *tangent, double *work);
void thrum_tangent_vector_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                             const double *v, double *product, double *work);

/* The first `split` entries of the force, and V(q). */
double thrum_force_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                        const double *q, double *force, double *work);

/* The first `split` entries of T v for a v whose other entries, which are not read, are zero. */
void thrum_tangent_vector_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                               const double *q, const double *v, double *product, double *work);

/* --- V with the first `split` coordinates held ---------------------------------------------------
 * n = rank - split coordinates remain. A restricted polynomial is one array of
 * thrum_restricted_count(n) doubles, as runtime/polynomial/packed.h says. Its quartic part is read
 * from the model where it lies: so the functions that use it take the model and the split again. */

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
