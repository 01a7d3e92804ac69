/* Parts of a step of the rigid-body frame (rigid_frame.c), which floating_frame.c uses as well;
 * private to the runtime. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_FRAMES_RIGID_FRAME_PRIVATE_H
#define THRUM_RUNTIME_FRAMES_RIGID_FRAME_PRIVATE_H

#include <stdbool.h>

#include "thrum/rigid_frame.h"

/* Axes of the mesh in the world now, attitude times placement (NULL: none). */
void thrum_rigid_frame_axes(const thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                            double axes[9]);

/* Solves y + half w x (y + s) = b, w = inverse y + offset, by Newton's method, with a step halved
 * until the residual falls; false where it is not found. */
bool thrum_rigid_frame_solve(const double inverse[9], const double offset[3], double half,
                             const double s[3], const double b[3], double y[3], double w[3]);

/* Rotates the frame, whose axes in the world are given, by the Cayley transform of v = h/2 w in the
 * mesh's axes; the attitude is made orthonormal again. */
void thrum_rigid_frame_rotate(thrum_rigid_frame *rigid_frame, const thrum_placement *placement,
                              const double axes[9], const double v[3]);

#endif
