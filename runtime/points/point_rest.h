/* The stiffness that no cubature point stands for, of a body that may flow; private to the runtime,
 * see point_rest.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POINTS_POINT_REST_H
#define THRUM_RUNTIME_POINTS_POINT_REST_H

#include <stdbool.h>

#include "core/polynomial/points.h"

/* The stiffness K of the points beside that of the whole body, W = diag(omega^2): shares (rank) l
 * and shapes (rank x rank, one a row) v with K v = l W v and v^T W v = 1. work: rank x rank. */
void thrum_rest_shares(const thrum_model *model, double *shapes, double *shares, double *work);

/* Fills what lies behind the plastic strains of `plastic` and never changes: the matrix X by which
 * the points see a displacement shortened, q - X q. */
void thrum_rest_prepare(const thrum_model *model, const double *shapes, const double *shares,
                        double *plastic);

/* Fills what lies there and follows from the plastic strains: the force that the rest has released
 * at each coordinate, and the constant of V: thrum_points_released. */
void thrum_rest_release(const thrum_model *model, const double *shapes, const double *shares,
                        double *plastic);

/* The terms of V that were released. */
double thrum_released_energy(const thrum_model *model, const double *q);

/* Where the points of a model that shortens see q: seen = q - X q. */
void thrum_points_see(const thrum_model *model, const double *q, double *seen);

/* Takes a force of the points from the shape that they see to q, in place: force - X^T force. */
void thrum_points_return(const thrum_model *model, double *force);

/* Takes a tangent of theirs (both triangles) there, in place: (1 - X)^T tangent (1 - X). */
void thrum_points_return_tangent(const thrum_model *model, double *tangent);

#endif
