/* Says what is wrong with what is around a body (thrum/contact.h). Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_CHECK_H
#define THRUM_RUNTIME_CONTACT_CONTACT_CHECK_H

#include "contact/contact_private.h"

/* Refuses an environment with impossible values, and says which. */
thrum_status thrum_contact_environment_check(const thrum_model *model, const thrum_contact *contact,
                                             const thrum_contact_environment *environment,
                                             thrum_error *error);

#endif
