/* The energy balance of contact over a step that was made, which bounds it (docs/contact.md).
 * Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_ENERGY_H
#define THRUM_RUNTIME_CONTACT_CONTACT_ENERGY_H

#include "contact/contact_private.h"

/* Measures what the rows did in the step from view.q to q (rank); returns their
 * work on the body relative to the obstacles [J]. */
double thrum_contact_measure(thrum_contact_run *run, const double *q);

/* Bounds the energy that goes through the rows in the step: the sum of their
 * forces times the free displacements of their points [J]. */
double thrum_contact_flow(const thrum_contact_run *run);

/* Can the energies of the step that was made be booked, or are they beyond the
 * range of finite numbers? After thrum_contact_measure. */
bool thrum_contact_counts(const thrum_contact_run *run);

/* The failure of a body whose energies cannot. */
thrum_status thrum_contact_beyond(thrum_error *error);

/* Books the energy of the step that thrum_contact_measure measured, and keeps the touches for the
 * next step. */
void thrum_contact_settle(thrum_contact_run *run);

#endif
