/* Words of a command as a shell reads them back. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_SHELL_WORD_H
#define THRUM_IO_SHELL_WORD_H

#include <stdio.h>

/* Writes a word, in single quotes where a shell would read more into it. */
void shell_word_put(FILE *stream, const char *word);

#endif
