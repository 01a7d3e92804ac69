/* Candidates that wait without a row: places of slow bodies that are apart, did not touch before
 * and bear nothing in this step. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_IDLE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_IDLE_H

#include "contact/contact_pairs_private.h"

/* May a candidate wait without a row? thickness: between its places [m]. */
bool thrum_pairs_is_idle(thrum_pairs_run *run, const thrum_pair_candidate *c, double thickness);

/* Is the gap of a candidate below 0 at the end of the step, as the bodies are
 * moved since thrum_pairs_look_again? */
bool thrum_pairs_closes(thrum_pairs_run *run, const thrum_pair_candidate *c, double thickness);
void thrum_pairs_look_again(thrum_pairs_run *run);

#endif
