/* All rows of a group of bodies at once, between them and on their obstacles, by Newton's method in
 * the coordinates of all, where sweeps over rows do not settle: places of two faces share a load in
 * many ways, and sweeps shift it between them for hundreds of turns; and in a stack each body waits
 * for the one below. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_NEWTON_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_NEWTON_H

#include "contact/contact_pairs_private.h"

/* Solves all rows of the group at once, also those of its bodies on their
 * obstacles, of which there are no more than THRUM_NEWTON_ROWS together, to within a tolerance [m];
 * false where it is not met. Where it cannot nothing changes. */
bool thrum_pairs_newton(thrum_pairs_run *run, double tolerance);

#endif
