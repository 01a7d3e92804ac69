/* First guess at the forces of touches that begin in a step. Private to the runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_GUESS_H
#define THRUM_RUNTIME_CONTACT_CONTACT_GUESS_H

#include "contact/contact_row.h"

/* Rows that may share one force: those of one obstacle, or between two bodies. */
typedef struct thrum_row_group {
  thrum_row_list rows;
  void *run;         /* of the step, for the functions below */
  const int32_t *of; /* the obstacle, or the two bodies */

  /* Is row n one of the group? */
  bool (*has)(const void *run, int64_t n, const int32_t *of);
  /* Displacement of its point relative to what it touches, as predicted now [m]. */
  void (*moved)(const void *run, int64_t n, double at[3]);
  /* Adds what a force at it [N] moves to the predicted displacements. */
  void (*push)(void *run, int64_t n, const double force[3]);
} thrum_row_group;

/* Guesses the force of all rows of the group that begin as if they were one: sweeps alone would
 * find it only slowly, as each row sees the others' forces one after the other. */
void thrum_contact_guess_group(const thrum_row_group *group);

/* The same for each obstacle of a body. */
void thrum_contact_guess(thrum_contact_run *run);

#endif
