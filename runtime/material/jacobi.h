/* Eigenvectors of very small symmetric matrices. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_JACOBI_H
#define THRUM_RUNTIME_MATERIAL_JACOBI_H

/* Eigenvalues of a symmetric `matrix` (size x size, row-major) onto its diagonal, in no order, and
 * its orthonormal eigenvectors into the columns of `vectors` (the same shape). For a few rows,
 * where LAPACK's calls cost more than the work and may start threads for it. Any thread. */
void thrum_jacobi(int size, double *matrix, double *vectors);

#endif
