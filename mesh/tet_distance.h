/* Barycentric coordinates in a tetrahedron, and the distance to a triangle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_TET_DISTANCE_H
#define THRUM_MESH_TET_DISTANCE_H

/* Barycentric coordinates of a point in tetrahedron (corners a, b, c, d). Cramer's rule with one
 * step of refinement, so that sum w_c x_c is the point to rounding in flat tetrahedra too. */
void thrum_tet_weights(const double *const corners[4], const double point[3], double weights[4]);

/* Squared distance of a point to the triangle (a, b, c) [m^2], by the region of its plane that it
 * is above. C. Ericson 2005, Real-Time Collision Detection, 5.1.5. */
double thrum_triangle_distance2(const double *a, const double *b, const double *c,
                                const double point[3]);

#endif
