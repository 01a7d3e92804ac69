/* The forces between bodies in a step, together with those of their obstacles and pulls, by Gauss-
 * Seidel over points (contact_solve.c): each row in turn reads the displacements of its two points,
 * solves its own law, and moves both bodies by the change of its force. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SOLVE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SOLVE_H

#include "contact/contact_pairs_private.h"

/* Solves all rows of the group with those of its members, and gathers their
 * loads. */
void thrum_pairs_solve(thrum_pairs_run *run);

#endif
