/* The energy balance of contact between bodies over a step that was made (contact_energy.c): the
 * work of their forces is exact whatever was predicted; springs hold no more than they took, and
 * what else the bodies gave up counts as lost. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_ENERGY_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_ENERGY_H

#include "contact/contact_pairs_private.h"

/* Did contact between the bodies give back no more than it had taken? */
bool thrum_pairs_allowed(thrum_pairs_run *run);

/* Did the step leave all surfaces apart? After thrum_pairs_allowed. */
bool thrum_pairs_apart(const thrum_pairs_run *run);

/* A body whose touches with others have energies that cannot be booked, as
 * thrum_contact_counts; -1: there is none. After thrum_pairs_allowed. */
int64_t thrum_pairs_beyond(const thrum_pairs_run *run);

/* A depth as a share of a thickness, which may be as small as a number can be. */
double thrum_pairs_share(double depth, double thickness);

/* Lists impacts behind the touches of the last step, where these leave
 * room.
 */
void thrum_pairs_list_impacts(thrum_contact_pairs *pairs, const thrum_pair_touching *impacts,
                              int64_t count);

/* Books the energy and keeps the touches for the next step; returns what it lost [J], with what
 * springs held of touches that have ended. After thrum_pairs_allowed. */
double thrum_pairs_settle(thrum_pairs_run *run);

#endif
