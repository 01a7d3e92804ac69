/* Links between members of a step (thrum/link.h, docs/links.md): what joins two places or fixes
 * their directions to each other is solved with the touches, and then by steps that are made again
 * until it holds at their end. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_LINK_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_LINK_H

#include "contact/contact_pairs_private.h"

/* Links as their bodies begin the step, and are predicted to end it. */
void thrum_links_open(thrum_pairs_run *run, thrum_link *links, int64_t count);

/* False where the conditions of the links cannot be solved for; nothing may step then with the
 * members that links tie. */
bool thrum_links_aim(thrum_pairs_run *run);
bool thrum_links_tie(const thrum_pairs_run *run, int64_t member);

/* Does a joint hold the two members together? They do not touch then. */
bool thrum_links_join(const thrum_pairs_run *run, int64_t a, int64_t b);

/* The parts of a solve, as those of contact_solve.c: pushes with the forces
 * that links have; solves all of them at once, and returns by how much they were off [m]; loads. */
double thrum_links_begin(thrum_pairs_run *run);
double thrum_links_solve(thrum_pairs_run *run);
void thrum_links_gather(thrum_pairs_run *run);

/* Looks at the step that was made, and aims by how it ended; returns by how
 * much it left the conditions open, in parts of the bodies' size. */
double thrum_links_look(thrum_pairs_run *run);

/* As thrum_pairs_beyond, of links. After thrum_links_look. */
int64_t thrum_links_beyond(const thrum_pairs_run *run);

/* Books the energy of the links. */
void thrum_links_settle(thrum_pairs_run *run);

#endif
