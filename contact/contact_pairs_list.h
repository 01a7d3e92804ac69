/* Lists of the places of two members that are near each other, kept from step to step (Verlet 1967,
 * doi:10.1103/PhysRev.159.98): bodies that lie on each other need not be searched again. Private to
 * contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_LIST_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_LIST_H

#include "contact/contact_pairs_private.h"

/* How far any vertex of a member moves in the step that is searched, at most
 * [m]. */
double thrum_pairs_way_bound(const thrum_pairs_run *run, int64_t member);

/* The list of two members that holds in this step, where places move by at
 * most `way` against each other and `slack` is the difference of the reaches [m]; NULL: none. */
thrum_pair_list *thrum_pairs_list_find(const thrum_pairs_run *run, int64_t a, int64_t b,
                                       double thickness, double way, double slack);

/* A list to be made of two members as they are now; `full`: there was no room
 * for one, and others have to go. NULL: there is no room. */
thrum_pair_list *thrum_pairs_list_open(const thrum_pairs_run *run, int64_t a, int64_t b,
                                       double thickness, bool full);

/* An entry more, false where there is no room; the list is made. */
bool thrum_pairs_list_add(const thrum_pairs_run *run, thrum_pair_list *list, int32_t kind,
                          int32_t first, int32_t second);
void thrum_pairs_list_close(const thrum_pairs_run *run, thrum_pair_list *list);

#endif
