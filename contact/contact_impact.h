/* Impacts of near-rigid bodies, private to the runtime (docs/contact.md, "How a body bounces").
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_IMPACT_H
#define THRUM_RUNTIME_CONTACT_CONTACT_IMPACT_H

#include "contact/contact_pairs_private.h"

#define THRUM_IMPACTS_MAX 8 /* of a step; what comes after them is left to the springs */

/* Rows that may hold impacts: those of `count` bodies on their obstacles and, unless it is NULL,
 * those between the members of a group, whose runs they are. */
typedef struct thrum_impact_rows {
  thrum_contact_run *runs;
  int64_t count;
  thrum_pairs_run *pairs;
  bool early; /* impacts are made at the start of the step */
} thrum_impact_rows;

/* Fills the velocities of a body as it is now, and its inverse inertia; it has no impulse yet. */
void thrum_contact_look(thrum_contact_run *body);

/* Makes the first impact of the step, where there is one: changes velocities and places of the
 * bodies that it reaches, books its energy, and returns true. Then the step has to be predicted and
 * its rows found again. Rows have been found, and none has been solved. */
bool thrum_contact_strike(const thrum_impact_rows *rows);

/* Do the ways of bodies that were struck at their time lead into something else? The springs do not
 * know that those ways begin at the impact, so the impacts have to be made early then. */
bool thrum_contact_strays(const thrum_impact_rows *rows);

#endif
