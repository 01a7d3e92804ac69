/* Support for fuzz targets of readers that take a path: the input as a file. A message must be one
 * line. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_FILE_H
#define THRUM_TESTS_FUZZ_FUZZ_FILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "thrum/status.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char fuzz_path[64];

static inline void fuzz_remove_file(void) {
  unlink(fuzz_path);
}

/* The input in a file of its own process; NULL when there is no room for it. */
static inline const char *fuzz_file(const uint8_t *data, size_t size) {
  if (fuzz_path[0] == 0) {
    snprintf(fuzz_path, sizeof fuzz_path, "%s/thrum-fuzz-%ld",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp", (long)getpid());
    atexit(fuzz_remove_file);
  }
  FILE *file = fopen(fuzz_path, "wb");
  if (file == NULL)
    return NULL;
  const int written = fwrite(data, 1, size, file) == size;
  return fclose(file) == 0 && written ? fuzz_path : NULL;
}

/* A failure has a message of one line. */
static inline void fuzz_check(thrum_status status, const thrum_error *error) {
  if (status < 0 && (error->status != status || !error->message[0] || strchr(error->message, '\n')))
    abort();
}

/* The input as a text ended by 0 (malloc). */
static inline char *fuzz_text(const uint8_t *data, size_t size) {
  char *text = malloc(size + 1);
  if (text == NULL)
    abort();
  if (size > 0)
    memcpy(text, data, size);
  text[size] = 0;
  return text;
}

#endif
