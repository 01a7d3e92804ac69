/* The frame of a model that spins, for the stepper of a reduced model (thrum/floating_frame.h).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_STEPPER_SPIN_H
#define THRUM_DRIVER_RUN_STEPPER_SPIN_H

#include "driver/run/simulate_options.h"

/* Zeroed: the body does not spin. */
typedef struct stepper_spin {
  thrum_inertia *inertia; /* NULL: it does not spin */
  thrum_rigid_frame frame;
  double *work;
} stepper_spin;

/* The frame of a request with --spin at the start q and p (rank each); without one nothing.
 * stepper_spin_close frees, whatever came of it. */
thrum_status stepper_spin_open(const simulate_request *request, const thrum_model *model,
                               const double *q, const double *p, stepper_spin *spin,
                               thrum_error *error);

/* One step of the state, and of the frame where there is one. */
thrum_status stepper_spin_step(stepper_spin *spin, const thrum_model *model, thrum_state *state,
                               thrum_error *error);

/* Adds the energy of the rotation to that of the shape. */
void stepper_spin_add_energy(const stepper_spin *spin, thrum_energies *energies);

/* The angular velocity in the world [degrees/s]; 0 where the body does not spin. */
void stepper_spin_now(const stepper_spin *spin, double rates[3]);

void stepper_spin_close(stepper_spin *spin);

#endif
