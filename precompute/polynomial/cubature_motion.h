/* How far motion by cubature points is from motion by all points of the mesh, design 18.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_MOTION_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_MOTION_H

#include "precompute/polynomial/cubature.h"

/* Motions are measured where the gradients at all points of the mesh have so many numbers at most.
 */
#define THRUM_MOTION_NUMBERS_MOST 25000000

/* Steps the model beside one that is summed over all points of the mesh, from the same starts and
 * under the same loads, within the range of training and beyond it; into the last fields of
 * figures, which are NaN where it is not measured: of a mesh of more numbers than that, one that
 * several ranks share, and a body with a coordinate that has no stiffness. model: of points, with
 * its basis, vertices and law. */
thrum_status thrum_cubature_motion(const thrum_fem *fem, const thrum_cubature_def *def,
                                   const thrum_model *model, thrum_cubature_figures *figures,
                                   thrum_error *error);

#endif
