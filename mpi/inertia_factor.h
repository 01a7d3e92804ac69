/* A factor L D L^T by MUMPS (Amestoy et al. 2001, doi:10.1137/S0895479899358194) of a symmetric
 * matrix that need not be positive definite: its negative pivots count the negative eigenvalues.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_INERTIA_FACTOR_H
#define THRUM_MPI_INERTIA_FACTOR_H

#include <petscksp.h>

#include "thrum/status.h"

/* MUMPS's threshold of the pivots that it puts off, which make the factor larger than planned: its
 * own; and none, for a matrix that is of use only where it proves positive definite. */
#define INERTIA_PUT_OFF 0.01
#define INERTIA_AS_THEY_COME 0.0

/* Makes the factor of the matrix, whose numbers may have changed since, in the solver. What fails
 * inside of MUMPS is no failure here: the preconditioner tells it (PCGetFailedReason). */
thrum_status inertia_factor_make(Mat matrix, KSP ksp, double threshold, PC *pc, Mat *factor,
                                 thrum_error *error);

#endif
