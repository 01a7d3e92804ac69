/* The rows of a step between bodies: what two places that may touch say to the solve
 * (docs/contact.md). Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_ROWS_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_ROWS_H

#include "contact/contact_pairs_private.h"

/* Makes rows of the candidates that have none and need not wait; returns how
 * many. */
int64_t thrum_pairs_add_rows(thrum_pairs_run *run);

/* Makes rows of the candidates that wait and close as the bodies are moved
 * now, or of all that wait; returns how many. */
int64_t thrum_pairs_wake(thrum_pairs_run *run, bool all);

/* The same with the rows that members have with their own obstacles; returns whether there was any.
 */
bool thrum_pairs_wake_all(thrum_pairs_run *run, bool all);

/* The levers and responses of all rows for the rotations predicted now. */
void thrum_pairs_refresh(thrum_pairs_run *run);

/* As thrum_contact_release, for rows between bodies. */
void thrum_pairs_release(thrum_pairs_run *run);

#endif
