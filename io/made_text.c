/* Texts of streams in memory, see made_text.h. SPDX-License-Identifier: Apache-2.0 */
#include "io/made_text.h"

#include <stdlib.h>
#include <string.h>

/* One text; NULL where the stream says at one of its three places that there is no memory. */
static char *text_once(made_text_put *put, const void *of, size_t *size) {
  char *text = NULL;
  FILE *stream = open_memstream(&text, size);
  if (stream == NULL)
    return NULL;
  put(stream, of);
  const int failed = ferror(stream);
  if (fclose(stream) == 0 && !failed)
    return text;
  free(text);
  return NULL;
}

char *made_text(made_text_put *put, const void *of, size_t *size) {
  size_t length = 0, again = 0;
  char *first = text_once(put, of, &length), *second = text_once(put, of, &again);
  const int whole =
      first != NULL && second != NULL && length == again && memcmp(first, second, length) == 0;
  free(second);
  if (size != NULL)
    *size = length;
  if (whole)
    return first;
  free(first);
  return NULL;
}
