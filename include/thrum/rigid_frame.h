/* The rigid-body frame of a free body: its rotation about the centre of mass, in which the elastic
 * coordinates live (docs/contact.md).
 *
 * Stepped by itself, the frame has the inertia of the body at rest. Centrifugal and Coriolis
 * forces, by which spin and shape act on each other, are left out then: it serves bodies that turn
 * slowly against their lowest frequency. A step keeps the angular momentum and changes the energy
 * by torque times angle. thrum/floating_frame.h steps frame and shape together, with these forces.
 *
 * A frame is a plain value: copy it, and step a copy in one thread at a time. No function here
 * allocates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RIGID_FRAME_H
#define THRUM_RIGID_FRAME_H

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where a body's mesh stands in the world: world = origin + axes mesh. */
typedef struct thrum_placement {
  double axes[9];   /* 3 x 3 row-major, a rotation; default the identity */
  double origin[3]; /* [m] */
} thrum_placement;

/* A copyable value without pointers. A mesh point x stands, before any translation, at
 * place(centre) + attitude (place(x) - place(centre)). */
typedef struct thrum_rigid_frame {
  double centre[3];   /* of mass, in the mesh [m] */
  double inverse[9];  /* of the inertia about it, in the mesh [1/(kg m^2)]; symmetric, row-major */
  double attitude[9]; /* rotation since the placement, in the world; row-major */
  double momentum[3]; /* angular momentum about the centre, in the world [kg m^2/s] */
  double internal[3]; /* what the motion of the shape in the frame has of it, in the mesh; 0 where
                         the frame is stepped by itself */
} thrum_rigid_frame;

/* Sets a frame at rest, with the centre of mass and the inertia of a free body's model.
 * THRUM_INVALID_ARGUMENT for NULL, THRUM_MISSING for a model without rigid modes, THRUM_SINGULAR
 * where its rigid modes give no centre. */
THRUM_API thrum_status thrum_rigid_frame_of(const thrum_model *model,
                                            thrum_rigid_frame *rigid_frame, thrum_error *error);

/* One step of dt [s] under a mean torque about the centre [N m], in the world; placement may be
 * NULL. `angle` (may be NULL) gets the rotation vector [rad] whose product with the torque is the
 * change of energy. Cayley's transform of the implicit midpoint rule: exact in the momentum, of
 * order 2. A step whose equation Newton's method does not solve, as that of a thin rod which the
 * torque spins many times in it, is made in shorter ones. */
THRUM_API void thrum_rigid_frame_step(thrum_rigid_frame *rigid_frame,
                                      const thrum_placement *placement, const double torque[3],
                                      double dt, double angle[3]);

/* Kinetic energy of the rotation [J]: with 1/2 |p|^2 of the shape that of the body about its
 * centre, also where the two are stepped together. */
THRUM_API double thrum_rigid_frame_energy(const thrum_rigid_frame *rigid_frame,
                                          const thrum_placement *placement);

/* Angular velocity in the world [rad/s]. */
THRUM_API void thrum_rigid_frame_velocity(const thrum_rigid_frame *rigid_frame,
                                          const thrum_placement *placement, double velocity[3]);

/* Placement of the mesh now: `placement` (NULL: identity), rotated by the frame (NULL: not at all)
 * and moved by `position` [m] (NULL: 0). */
THRUM_API thrum_placement thrum_placement_now(const thrum_placement *placement,
                                              const thrum_rigid_frame *rigid_frame,
                                              const double position[3]);

#ifdef __cplusplus
}
#endif
#endif
