/* What commands with a folder of results share. SPDX-License-Identifier: Apache-2.0 */
#include "app/results.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/named_model.h"
#include "io/file.h"
#include "precompute/build_info.h"

thrum_status cli_results_write(const char *folder, const char *name, experiment_text *text,
                               thrum_error *error) {
  char path[CLI_MODEL_PATH_MAX];
  thrum_status status;
  const int length = snprintf(path, sizeof path, "%s/%s", folder, name);
  if (text->failed || text->bytes == NULL) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s", name);
  } else if (length < 0 || length >= (int)sizeof path) {
    status = thrum_error_set(error, THRUM_IO, "-o %.200s: the path is too long", folder);
  } else {
    status = thrum_file_write_atomic(path, text->bytes, text->size, error);
  }
  free(text->bytes);
  memset(text, 0, sizeof *text);
  return status;
}

/* The processor's name from /proc/cpuinfo, where there is one. */
static const char *machine_name(void) {
  static const char key[] = "model name";
  static char line[256];
  FILE *file = fopen("/proc/cpuinfo", "r");
  const char *name = "unknown processor";
  while (file != NULL && fgets(line, sizeof line, file) != NULL) {
    const char *colon = strchr(line, ':');
    if (strncmp(line, key, sizeof key - 1) != 0 || colon == NULL)
      continue;
    line[strcspn(line, "\n")] = 0;
    name = colon + 1 + (colon[1] == ' ');
    break;
  }
  if (file != NULL)
    fclose(file);
  return name;
}

experiment_place cli_results_place(const char *command) {
  return (experiment_place){
      .machine = machine_name(),
      .compiler = thrum_build_compiler(),
      .blas_core = thrum_build_blas_core(),
      .command = command,
  };
}
