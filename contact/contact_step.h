/* Steps with contact: predict, solve, step, look at what it really did (docs/contact.md). Private
 * to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_STEP_H
#define THRUM_RUNTIME_CONTACT_CONTACT_STEP_H

#include "contact/contact_private.h"

/* A run at the start of a step. */
thrum_status thrum_contact_open(const thrum_model *model, thrum_state *state,
                                thrum_contact *contact,
                                const thrum_contact_environment *environment,
                                thrum_contact_run *run, thrum_error *error);

/* The parts of it that the environment has, taken and put back. */
thrum_contact_whole thrum_contact_keep_whole(const thrum_contact_environment *environment);
void thrum_contact_put_back_whole(const thrum_contact_environment *environment,
                                  const thrum_contact_whole *kept);

/* Is that motion, as it is now, in the range of finite numbers? */
bool thrum_contact_whole_is_finite(const thrum_contact_environment *environment);

/* Where the body is as a whole at the start of its step, and how it goes on without
 * contact. */
void thrum_contact_place(thrum_contact_run *run);

/* Has searches go by the displacements that were solved for. */
void thrum_contact_seek(thrum_contact_run *run);

/* Predicts the step, solves its pulls alone, and finds its rows. */
thrum_status thrum_contact_prepare(thrum_contact_run *run, thrum_error *error);

/* Sets the load that was solved for, and finds the rotation that its torque makes.
 */
thrum_status thrum_contact_apply(thrum_contact_run *run, thrum_error *error);

/* The step of the state under that load; with an inertia also of the frame, into
 * `stepped`, and `turned` is its rotation. */
thrum_status thrum_contact_advance(thrum_contact_run *run, thrum_error *error);

/* Did the contact with obstacles give back no more than it had taken, up to
 * rounding? */
bool thrum_contact_allowed(thrum_contact_run *run);

/* Back to the start of the step, with a prediction corrected by how it ended;
 * `again` counts it as another attempt. */
void thrum_contact_return(thrum_contact_run *run);
void thrum_contact_again(thrum_contact_run *run);

/* Calms the coordinates that a step cannot follow after one that was made; returns the energy that
 * they had [J]. */
double thrum_contact_calm(thrum_contact_run *run);

/* Books the energy of the step, and moves the body as a whole. True where it has calmed it, as it
 * rests on an obstacle: once a step is what damps it critically. */
bool thrum_contact_finish(thrum_contact_run *run);

#endif
