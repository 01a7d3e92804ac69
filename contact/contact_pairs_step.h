/* The step of a group of bodies, which may be one alone. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_STEP_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_STEP_H

#include "contact/contact_pairs_private.h"

/* Steps a group from the start, and books what it did. A member that fails keeps what it had. */
thrum_status thrum_pairs_step_group(thrum_pairs_run *run, const thrum_contact_links *links,
                                    thrum_error *error);

/* The first part of that, without links: all up to the loads of the states. A failure leaves the
 * contacts and the bodies as a whole changed. */
thrum_status thrum_pairs_begin_group(thrum_pairs_run *run, thrum_error *error);

#endif
