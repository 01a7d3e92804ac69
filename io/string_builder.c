/* A growing text. SPDX-License-Identifier: Apache-2.0 */
#include "io/string_builder.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define ROOM_FIRST 4096

/* Room for `more` bytes and the 0 after them. */
static bool reserve(experiment_text *text, size_t more) {
  size_t room = text->room > 0 ? text->room : ROOM_FIRST;
  while (room - text->size <= more)
    room *= 2;
  if (room == text->room)
    return true;
  char *grown = realloc(text->bytes, room);
  if (grown == NULL) {
    text->failed = true;
    return false;
  }
  text->bytes = grown;
  text->room = room;
  return true;
}

void experiment_text_add(experiment_text *text, const char *format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = vsnprintf(NULL, 0, format, arguments);
  if (length >= 0 && !text->failed && reserve(text, (size_t)length)) {
    vsnprintf(text->bytes + text->size, (size_t)length + 1, format, again);
    text->size += (size_t)length;
  }
  va_end(again);
  va_end(arguments);
}

void experiment_text_escape(experiment_text *text, const char *plain) {
  for (const char *at = plain; *at != 0; at++) {
    const char *entity = *at == '&' ? "&amp;" : *at == '<' ? "&lt;" : *at == '>' ? "&gt;" : NULL;
    if (entity != NULL) {
      experiment_text_add(text, "%s", entity);
    } else {
      experiment_text_add(text, "%c", *at);
    }
  }
}
