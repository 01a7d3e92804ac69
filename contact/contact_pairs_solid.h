/* Solids among the members of a step: obstacles with a skin that move as they are told. Private to
 * contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SOLID_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SOLID_H

#include "contact/contact_pairs_private.h"

/* The run of a solid as it moves in the step; no force moves it. */
void thrum_pairs_open_solid(thrum_pairs_run *run, int64_t member, double dt);

/* As thrum_contact_member_bound. */
thrum_skin_bound thrum_pairs_solid_bound(const thrum_contact_member *member);

#endif
