/* Which vertices and triangles, and which edges, of two bodies may touch in a step. Private to
 * contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SEARCH_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SEARCH_H

#include "contact/contact_pairs_private.h"

/* Finds all candidates of the step, pruned and in the order of their keys.
 */
void thrum_pairs_search(thrum_pairs_run *run);

/* Position and displacement of a vertex of a member, and the part of the
 * latter that leads to the start of its way after an impact (thrum_point_shift). */
const double *thrum_pairs_find_place(thrum_pairs_run *run, int64_t member, int64_t vertex);

/* The same, once in a search. */
static inline const double *thrum_pairs_place(thrum_pairs_run *run, int64_t member,
                                              int64_t vertex) {
  const int64_t index = run->view.first_vertex[member] + vertex;
  return run->view.place_known[index] ? run->view.places + 9 * index
                                      : thrum_pairs_find_place(run, member, vertex);
}

#endif
