/* A growing text, for reports and tables. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_STRING_BUILDER_H
#define THRUM_IO_STRING_BUILDER_H

#include <stdbool.h>
#include <stddef.h>

/* A zeroed one is empty; free(bytes) when done. Once memory has failed, nothing more is added. */
typedef struct experiment_text {
  char *bytes; /* ended by 0; NULL while empty */
  size_t size;
  size_t room;
  bool failed;
} experiment_text;

__attribute__((format(printf, 2, 3))) void experiment_text_add(experiment_text *text,
                                                               const char *format, ...);

/* The same with &, < and > as HTML wants them. */
void experiment_text_escape(experiment_text *text, const char *plain);

#endif
