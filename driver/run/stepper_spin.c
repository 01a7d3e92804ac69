/* A model that spins: its frame is stepped together with its state.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/stepper_spin.h"

#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "platform/allocate.h"
#include "precompute/model/solid_inertia.h"

#define DEGREE 0.017453292519943295 /* [rad] */

thrum_status stepper_spin_open(const simulate_request *request, const thrum_model *model,
                               const double *q, const double *p, stepper_spin *spin,
                               thrum_error *error) {
  if (!simulate_spins(request))
    return THRUM_OK;
  thrum_status status = thrum_solid_inertia_create(model, &spin->inertia, error);
  THRUM_THEN(status, thrum_rigid_frame_of(model, &spin->frame, error));
  THRUM_THEN(status, thrum_reserve(&spin->work, thrum_floating_frame_work_count(spin->inertia),
                                   sizeof *spin->work, "a body that spins", error));
  THRUM_THEN(status,
             thrum_floating_frame_settle(spin->inertia, q, p, &spin->frame, spin->work, error));
  THRUM_TRY(config_error_in(error, status, "--spin"));

  // the option gives the angular velocity in degrees
  double rates[3];
  for (int axis = 0; axis < 3; axis++)
    rates[axis] = DEGREE * request->spin[axis];
  thrum_floating_frame_spin(NULL, rates, &spin->frame);
  return THRUM_OK;
}

thrum_status stepper_spin_step(stepper_spin *spin, const thrum_model *model, thrum_state *state,
                               thrum_error *error) {
  static const double none[3] = {0};
  if (spin->inertia == NULL)
    return thrum_step(model, state, error);
  return thrum_floating_frame_step(model, state, spin->inertia, NULL, &spin->frame, none, NULL,
                                   spin->work, error);
}

void stepper_spin_add_energy(const stepper_spin *spin, thrum_energies *energies) {
  if (spin->inertia == NULL)
    return;
  const double rotation = thrum_rigid_frame_energy(&spin->frame, NULL);
  energies->kinetic += rotation;
  energies->total += rotation;
}

void stepper_spin_now(const stepper_spin *spin, double rates[3]) {
  memset(rates, 0, 3 * sizeof *rates);
  if (spin->inertia != NULL)
    thrum_rigid_frame_velocity(&spin->frame, NULL, rates);
  for (int axis = 0; axis < 3; axis++)
    rates[axis] /= DEGREE;
}

void stepper_spin_close(stepper_spin *spin) {
  thrum_inertia_destroy(spin->inertia);
  free(spin->work);
  *spin = (stepper_spin){.inertia = NULL};
}
