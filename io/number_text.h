/* Writes numbers as text. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_NUMBER_TEXT_H
#define THRUM_IO_NUMBER_TEXT_H

#include <stddef.h>

#define THRUM_NUMBER_TEXT 40

/* Writes the shortest text of 15 to 17 digits that reads back as the same double, with a point in
 * every locale; returns its length. */
size_t thrum_number_text(double value, char text[THRUM_NUMBER_TEXT]);

/* The same in at most `width` characters, 10 or more, for readers that take no more: without zeros
 * that say nothing, and where that is not enough with fewer digits. */
size_t thrum_number_text_within(double value, size_t width, char text[THRUM_NUMBER_TEXT]);

#endif
