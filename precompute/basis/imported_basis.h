/* A basis and a polynomial made elsewhere, brought into Thrum's form.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_IMPORTED_BASIS_H
#define THRUM_PRECOMPUTE_BASIS_IMPORTED_BASIS_H

#include "precompute/fem/fem.h"
#include "thrum/model.h"

/* U S into `basis` (3 vertex_count x rank) and S into `change` (rank x rank, row-major), with
 * U^T M U = 1 and U^T K U diagonal and ascending; S = 1 and the bits of U where that is so to 1e-11
 * already. rigid_dual: M Z of a free body, else NULL. Fills what figures say of the basis. Refuses
 * rows that are not the mesh's, rows that move where held, dependent columns, and for a free body
 * columns that are not M-orthogonal to Z. */
thrum_status thrum_imported_basis_fill(const thrum_fem *fem, const thrum_mesh *mesh,
                                       const thrum_sparse *mass, const double *rigid_dual,
                                       const thrum_imported_basis *imported, double *basis,
                                       double *change, thrum_imported_figures *figures,
                                       thrum_error *error);

/* The imported polynomial in the coordinates of the changed basis: linear (rank x rank), c3, c4.
 * Refuses one whose linear part differs from U^T K U by 1e-6. */
thrum_status thrum_imported_polynomial(const thrum_fem *fem, const thrum_imported_basis *imported,
                                       const double *change, const thrum_model *model,
                                       double *linear, double *c3, double *c4,
                                       thrum_imported_figures *figures, thrum_error *error);

/* Compares the model's energy with the body's at a large displacement and its opposite, which the
 * cubic and quartic parts lead; refuses a difference above 1e-6. */
thrum_status thrum_imported_check(const thrum_fem *fem, const thrum_model *model,
                                  thrum_imported_figures *figures, thrum_error *error);

#endif
