/* Symmetric forms of degree 2 to 4 as arrays of rank^degree entries, in which coordinates are
 * easily changed. Private to libthrum. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_PARAMETERS_FORM_H
#define THRUM_RUNTIME_PARAMETERS_FORM_H

#include <stdint.h>

/* Entries of c3 (degree 3) or c4 (degree 4), in block order; each monomial is shared evenly by the
 * orders of its indices. */
void thrum_form_expand(int64_t rank, int degree, const double *monomials, double *form);

/* The first index becomes the last, and is changed by `matrix` (rank x rank): to[.., a] = sum_i
 * form[i, ..] matrix[i, a]. */
void thrum_form_turn_one(int64_t rank, int degree, const double *matrix, const double *form,
                         double *to);

/* All indices, which changes coordinates by q = matrix q'. work: as the form. */
void thrum_form_turn(int64_t rank, int degree, const double *matrix, double *form, double *work);

/* The monomials of a form that need not be symmetric. */
void thrum_form_collapse(int64_t rank, int degree, const double *form, double *monomials);

#endif
