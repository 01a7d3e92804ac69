/* Fuzz target of the JSON reader that options files use.
 * sources: io/json_read.c io/text.c io/file.c platform/interrupt.c
 * core/base/status.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/json_read.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  json_document document = {0};
  thrum_error error = {0};

  // a copy of exactly the input's size, so that a sanitizer sees any byte read beyond it
  char *bytes = malloc(size > 0 ? size : 1);
  if (bytes == NULL)
    return 0;
  if (size > 0)
    memcpy(bytes, data, size);
  const thrum_status status = json_read("input", bytes, size, &document, &error);
  fuzz_check(status, &error);
  free(bytes);

  // a refusal leaves nothing
  if (status < 0) {
    if (document.nodes != NULL || document.texts != NULL)
      abort();
    return 0;
  }

  // every node but the first is reached exactly once, and every text ends
  int64_t reached = 0;
  for (int64_t n = 0; n < document.count; n++) {
    const json_node *node = &document.nodes[n];
    reached += (node->first >= 0) + (node->next >= 0);
    if (node->first >= document.count || node->next >= document.count || node->line < 1 ||
        (node->text != NULL && strlen(node->text) > size) ||
        (node->key != NULL && strlen(node->key) > size))
      abort();
  }
  if (reached != document.count - 1)
    abort();

  json_free(&document);
  return 0;
}
