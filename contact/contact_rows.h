/* Which points may touch what in a step, and the rows of those and of the pulls (docs/contact.md).
 * Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_ROWS_H
#define THRUM_RUNTIME_CONTACT_CONTACT_ROWS_H

#include "contact/contact_private.h"

/* Fills the rows of the step from its displacements without contact. */
void thrum_contact_rows(thrum_contact_run *run);

/* The same with those of the points that wait, where one of them closes as the body moves now, or
 * in any case where `any`; returns whether that was so. */
bool thrum_contact_wake(thrum_contact_run *run, bool any);

/* Takes restitution and friction out of all rows, so that they only stop what comes
 * in. */
void thrum_contact_release(thrum_contact_run *run);

#endif
