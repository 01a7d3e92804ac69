/* The forces of a step's touches and pulls (docs/contact.md), by Gauss-Seidel over points. Private
 * to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_SOLVE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_SOLVE_H

#include "contact/contact_private.h"

/* The three parts of a solve: moved from the forces that rows and pulls have
 * (returns the largest displacement [m]); one sweep over pulls and rows (returns the largest
 * distance by which a point had moved since the last [m]); load and wrench from the forces. */
double thrum_contact_begin_sweeps(thrum_contact_run *run);
double thrum_contact_sweep(thrum_contact_run *run);
void thrum_contact_gather(thrum_contact_run *run);

/* Solves for the forces of all rows and pull rows; fills moved, and load for the
 * state. */
void thrum_contact_solve(thrum_contact_run *run);

#endif
