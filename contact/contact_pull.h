/* Springs that pull points of a body to targets (docs/contact.md). Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PULL_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PULL_H

#include "contact/contact_private.h"

/* Fills the pull rows of the step. */
void thrum_contact_pulls(thrum_contact_run *run);

/* The three rows of U of the point of a pull. */
double *thrum_contact_pull_basis(const thrum_contact_run *run, int64_t index);

/* Solves one pull; returns by how much its point had moved since it was solved last
 * [m]. */
double thrum_contact_pull_solve(thrum_contact_run *run, int64_t index);

#endif
