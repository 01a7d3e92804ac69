/* Shapes that modes gain where the materials of regions change, design 22.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_PARAMETER_SHAPES_H
#define THRUM_PRECOMPUTE_BASIS_PARAMETER_SHAPES_H

#include "precompute/fem/fem.h"

/* How many shapes a body of so many regions is given beside `modes` modes. */
int64_t thrum_parameter_shape_count(int64_t regions, int64_t modes);

/* Up to `count` shapes that the first of `modes` unit modes psi (n x modes, column-major; omega2)
 * gain most of where lambda, mu or density of one region change, into `shapes` (fields of 3
 * vertex_count, one after the other), and how many there are into *found. factor: of the stiffness.
 * Moduli and densities of the body are changed for the while. */
thrum_status thrum_parameter_shapes(thrum_fem *fem, thrum_mass kind, thrum_factor *factor,
                                    int64_t modes, const double *psi, const double *omega2,
                                    int64_t count, double *shapes, int64_t *found,
                                    thrum_error *error);

#endif
