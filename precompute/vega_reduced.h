/* Bases and polynomials as VegaFEM stores them: .U (or .URendering.float) and .cub.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_VEGA_REDUCED_H
#define THRUM_PRECOMPUTE_VEGA_REDUCED_H

#include "precompute/precompute.h"

/* Reads a basis in double or single precision (the file's size says which) into imported->rows,
 * rank and basis. The structs are zeroed or from one of the readers; release with
 * thrum_imported_basis_free. */
thrum_status thrum_vega_basis_read(const char *path, thrum_imported_basis *imported,
                                   thrum_error *error);

/* Reads the polynomials of the force's components and integrates them into imported->linear, c3,
 * c4, the coefficients of the potential. It must have the rank of the basis read first; without one
 * imported->rank becomes its own.
 * THRUM_BAD_VALUE, with the component, when the force is no gradient to 1e-6. imported->defect: by
 * how much of the largest coefficient of their degree components disagree. */
thrum_status thrum_vega_cubic_read(const char *path, thrum_imported_basis *imported,
                                   thrum_error *error);

void thrum_imported_basis_free(thrum_imported_basis *imported); /* leaves it empty */

/* Write U, and the force that is the gradient of V. `single`: in single precision. The model needs
 * a basis for the first. */
thrum_status thrum_vega_basis_write(const char *path, const thrum_model *model, bool single,
                                    thrum_error *error);
thrum_status thrum_vega_cubic_write(const char *path, const thrum_model *model, thrum_error *error);

#endif
