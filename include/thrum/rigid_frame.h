/* How a body that nothing holds turns as a whole: a rigid frame about its centre of mass, in which
 * its elastic coordinates live (docs/contact.md).
 *
 * The frame has the inertia of the body at rest; what spinning does to the shape and the shape to
 * the spin, centrifugal and Coriolis forces, is left out: for bodies that turn slowly against their
 * lowest frequency. A step keeps the angular momentum, and changes the energy by torque times
 * angle.
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
} thrum_rigid_frame;

/* At rest, with the centre and the inertia of a free body's model (THRUM_MISSING for one without
 * rigid modes). */
THRUM_API thrum_status thrum_rigid_frame_of(const thrum_model *model,
                                            thrum_rigid_frame *rigid_frame, thrum_error *error);

/* One step under a mean torque about the centre [N m], in the world; placement may be NULL. `angle`
 * (may be NULL) gets the rotation vector [rad] whose product with the torque is the change of
 * energy. Cayley's transform of the implicit midpoint rule: exact in the momentum, of order 2. */
THRUM_API void thrum_rigid_frame_step(thrum_rigid_frame *rigid_frame,
                                      const thrum_placement *placement, const double torque[3],
                                      double dt, double angle[3]);

/* Kinetic energy of the turning [J]. */
THRUM_API double thrum_rigid_frame_energy(const thrum_rigid_frame *rigid_frame,
                                          const thrum_placement *placement);

/* Angular velocity in the world [rad/s]. */
THRUM_API void thrum_rigid_frame_velocity(const thrum_rigid_frame *rigid_frame,
                                          const thrum_placement *placement, double velocity[3]);

/* Where the mesh stands now: placement (NULL: identity), turned, moved by `position` (NULL: 0). */
THRUM_API thrum_placement thrum_placement_now(const thrum_placement *placement,
                                              const thrum_rigid_frame *rigid_frame,
                                              const double position[3]);

#ifdef __cplusplus
}
#endif
#endif
