/* Quadrature rules of any degree for ten-node tetrahedra. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_QUADRATURE_H
#define THRUM_PRECOMPUTE_FEM_QUADRATURE_H

#include <stdbool.h>

#include "core/base/quadratic_tet.h"
#include "thrum/status.h"

/* Orders that may be asked for; below 4 the strain energy of straight elements is not exact. */
enum { THRUM_QUADRATURE_ORDER_MIN = 4, THRUM_QUADRATURE_ORDER_MAX = 20 };

/* A rule that integrates polynomials up to degree `order` exactly, with positive weights and all
 * points inside: 11 points for 4, 14 for 5, 24 for 6, and from there n^3 with n = order / 2 + 1.
 * Order 0 is the usual one, 5 for curved edges and 4 for straight ones; 2 is the rule of four
 * points. The caller frees *points. */
thrum_status thrum_quadrature(int order, bool curved, thrum_quadratic_point **points, int *count,
                              thrum_error *error);

#endif
