/* Fuzz target of what a client may send to `thrum view`: what is answered bears this machine's own
 * name.
 * sources: app/view/http_request.c
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "app/view/http_request.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Does the head hold the text? */
static int holds(const char *head, size_t length, const char *text) {
  for (size_t n = 0; n + strlen(text) <= length; n++) {
    if (memcmp(head + n, text, strlen(text)) == 0)
      return 1;
  }
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  // of its own size, so that a byte read beyond it is noticed
  char *text = malloc(size + (size == 0));
  if (text == NULL)
    return 0;
  memcpy(text, data, size);
  const size_t length = cli_http_head_length(text, size);
  cli_http_request request = {.path = "untouched"};
  if (length > size)
    abort();
  if (length > 0) {
    const int status = cli_http_parse(text, length, 8080, &request);
    if (status != 200 && strcmp(request.path, "untouched") != 0)
      abort();
    if (status == 200 && (request.path[0] != '/' || !holds(text, length, ":8080")))
      abort();
  }
  free(text);
  return 0;
}
