/* Touches and candidates in the order of their keys: a radix sort by bytes, of which those that all
 * keys share are left out. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SORT_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_SORT_H

#include "contact/contact_pairs_private.h"

/* Fills order (count) with the places of `count` items of `size` bytes that
 * begin with a key, ascending; room (2 x count) is overwritten. */
void thrum_pairs_sort(const void *items, size_t size, int64_t count, int32_t *order,
                      thrum_pair_sorted *room);

#endif
