/* What contact that takes no energy has lost in a step goes back (docs/contact.md, "What takes no
 * energy"). Private to contact. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONTACT_CONTACT_ELASTIC_H
#define THRUM_CONTACT_CONTACT_ELASTIC_H

#include "contact/contact_pairs_private.h"

/* Does no obstacle of a body take energy, with e = 1 and neither friction nor damping, and can the
 * body be given what steps miss? */
bool thrum_contact_is_elastic(const thrum_contact_run *run);

/* Does nothing in a group take energy from what it touches in it? */
bool thrum_pairs_is_elastic(const thrum_pairs_run *run);

/* After a step and the motion of the body as a whole: changes its velocities along the forces of
 * its obstacles so that its energy grows by `energy` [J], which may be below 0. Returns the energy
 * that it gave: that, or 0. *driven: the work of moving obstacles in it [J]. */
double thrum_contact_give(thrum_contact_run *run, double energy, double *driven);

/* The same of the bodies of a group along the forces between them. */
double thrum_pairs_give(thrum_pairs_run *run, double energy, double *driven);

#endif
