/* A text of a stream in memory, whole or not at all. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_MADE_TEXT_H
#define THRUM_IO_MADE_TEXT_H

#include <stdio.h>

/* Writes the text of something, each time the same. */
typedef void made_text_put(FILE *stream, const void *of);

/* The text that `put` writes, which the caller frees; NULL: there is no memory for all of it. size:
 * its bytes without the 0 behind them; NULL: not wanted. It is written twice, since a stream that
 * could not grow has lost some bytes and may not say so. */
char *made_text(made_text_put *put, const void *of, size_t *size);

#endif
