/* Strain and stress of one linear tetrahedron, private to the runtime (thrum/stress.h). Symmetric
 * tensors are six numbers xx, yy, zz, xy, yz, xz. Only + - * / and sqrt: the same bits everywhere.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_READOUT_TET_STRAIN_H
#define THRUM_RUNTIME_READOUT_TET_STRAIN_H

#include "runtime/material/material_law.h"

/* G of the corners' displacements u (4 x 3) and the gradients of shape functions 1..3 (3 x 3). */
void thrum_tet_gradient(const double u[12], const double shape[9], double gradient[3][3]);

/* E = 1/2 (G + G^T + G^T G). */
void thrum_tet_green(double gradient[3][3], double strain[6]);

/* S = lambda tr(E) 1 + 2 mu E. */
void thrum_tet_second_piola(double lambda, double mu, const double strain[6], double stress[6]);

/* S of any law at G, whose Green strain is `strain` and J `ratio`; of other laws than Saint
 * Venant-Kirchhoff's F^-1 P, whose quotient is NaN or infinite where the tetrahedron is flat. */
void thrum_tet_law_second_piola(thrum_law law, double lambda, double mu, double gradient[3][3],
                                const double strain[6], double ratio, double stress[6]);

/* J = det(1 + G). */
double thrum_tet_volume_ratio(double gradient[3][3]);

/* sigma = F S F^T / J; `ratio` is J. */
void thrum_tet_cauchy(double gradient[3][3], double ratio, const double second_piola[6],
                      double cauchy[6]);

/* The least principal stretch, sqrt(1 + 2 e) of the least eigenvalue e of E; negative where J is.
 */
double thrum_tet_least_stretch(const double strain[6], double ratio);

/* A bound below its magnitude, without an eigenvalue: sqrt(1 - 2 |E|), |E| Frobenius; 0 where there
 * is none. */
double thrum_tet_stretch_bound(const double strain[6]);

#endif
