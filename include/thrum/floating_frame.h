/* A free body whose rotation and shape act on each other: its frame (thrum/rigid_frame.h) and its
 * reduced coordinates, stepped together with the inertia of the deformed shape and with
 * centrifugal, Coriolis and Euler forces (design 20).
 *
 * The frame is the floating one of linear mean axes: the coordinates are orthogonal to the rigid
 * modes, so that its origin is the centre of mass and the shape has no angular momentum at rest. A
 * step conserves the angular momentum and the whole energy,
 *
 *   1/2 w I(q) w + w G(q) qdot + 1/2 |qdot|^2 + V(q),
 *
 * but for the work of torque and load and the damping, at any time step. p of the state is qdot,
 * the velocity of the shape in the frame. The energy of the frame (thrum_rigid_frame_energy) is the
 * first two terms, and that of the state the others.
 *
 * Memory: the caller owns state, frame, inertia and `work`, which is scratch of
 * thrum_floating_frame_work_count doubles with any content between calls. A snapshot is one of the
 * state and a copy of the frame. No function here allocates.
 *
 * Threads: an inertia may be shared; each thread has a state, a frame and work of its own.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_FLOATING_FRAME_H
#define THRUM_FLOATING_FRAME_H

#include "thrum/api.h"
#include "thrum/inertia.h"
#include "thrum/rigid_frame.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Doubles of scratch that the functions below need; 0 for NULL. */
THRUM_API size_t thrum_floating_frame_work_count(const thrum_inertia *inertia);

/* Gives the frame the inertia of the shape q and the angular momentum of its motion p (each rank;
 * p may be NULL: at rest). Call it when a frame was made, or a state was set or restored without
 * its frame. THRUM_BAD_VALUE, with the frame as it was, where the inertia of the shape has no
 * inverse. */
THRUM_API thrum_status thrum_floating_frame_settle(const thrum_inertia *inertia, const double *q,
                                                   const double *p, thrum_rigid_frame *rigid_frame,
                                                   double *work, thrum_error *error);

/* Sets the momentum of a settled frame to that of an angular velocity in the world [rad/s];
 * placement may be NULL. Any thread. */
THRUM_API void thrum_floating_frame_spin(const thrum_placement *placement, const double spin[3],
                                         thrum_rigid_frame *rigid_frame);

/* The force of the rotation on each coordinate at this shape and velocity (each rank) [kg^1/2
 * m/s^2]: centrifugal and Coriolis force, without Euler's, of the angular acceleration. `force`:
 * rank; placement may be NULL. */
THRUM_API void thrum_floating_frame_force(const thrum_inertia *inertia,
                                          const thrum_placement *placement,
                                          const thrum_rigid_frame *rigid_frame, const double *q,
                                          const double *p, double *force, double *work);

/* One step of state and frame, of the state's dt, under the state's load and a mean torque about
 * the centre of mass [N m], in the world; placement may be NULL. The load counts in the axes of the
 * body at the start of the step. `angle` (may be NULL) gets the rotation vector of the step in the
 * world [rad]. The state is one of energy, with rest damping, of a model that is not condensed,
 * with the inertia's rank: THRUM_UNSUPPORTED or THRUM_MODEL_MISMATCH otherwise. THRUM_FELL_BACK
 * where shorter steps were needed, THRUM_NOT_CONVERGED or THRUM_NOT_FINITE where these failed too;
 * a failure leaves state and frame as they were. */
THRUM_API thrum_status thrum_floating_frame_step(const thrum_model *model, thrum_state *state,
                                                 const thrum_inertia *inertia,
                                                 const thrum_placement *placement,
                                                 thrum_rigid_frame *rigid_frame,
                                                 const double torque[3], double angle[3],
                                                 double *work, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
