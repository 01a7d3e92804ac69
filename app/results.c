/* The folder of results of `thrum experiments` and `thrum tradeoff`.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/results.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "bench/bench.h"
#include "config/message.h"
#include "driver/make/named_model.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/program.h"
#include "precompute/build_info.h"

#define SCRIPT "report.py"

thrum_status results_open(const char *folder, const char *name, thrum_file_writer *writer,
                          thrum_error *error) {
  char path[NAMED_MODEL_PATH_MAX];
  const int length = snprintf(path, sizeof path, "%s/%s", folder, name);
  if (length < 0 || length >= (int)sizeof path)
    return thrum_error_set(error, THRUM_IO, "-o %.200s: the path is too long", folder);
  return thrum_file_writer_open(path, writer, error);
}

thrum_status results_write_json(const char *folder, const char *name, cJSON *object,
                                thrum_error *error) {
  char *text = json_text(object);
  cJSON_Delete(object);
  if (text == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s", name);

  thrum_file_writer writer = {NULL, NULL, NULL};
  thrum_status status = results_open(folder, name, &writer, error);
  if (status >= 0) {
    fprintf(writer.stream, "%s\n", text);
    status = thrum_file_writer_commit(&writer, error);
  }
  free(text);
  return status;
}

void results_add_machine(cJSON *object) {
  json_string(object, "machine", bench_processor());
  cJSON_AddStringToObject(object, "compiler", thrum_build_compiler());
  cJSON_AddStringToObject(object, "blas_core", thrum_build_blas_core());
}

/* The script: that of the installed program, else that of the sources it was built from. */
static void find_script(char path[NAMED_MODEL_PATH_MAX]) {
  if (path_share(SCRIPT, path, NAMED_MODEL_PATH_MAX) && access(path, R_OK) == 0)
    return;
#ifdef THRUM_SOURCE_REPORT
  snprintf(path, NAMED_MODEL_PATH_MAX, "%s", THRUM_SOURCE_REPORT);
#else
  // the message that the page is not made then names the script alone
  snprintf(path, NAMED_MODEL_PATH_MAX, "%s", SCRIPT);
#endif
}

void results_make_page(const char *folder, const char *kind, const char *table) {
  char script[NAMED_MODEL_PATH_MAX], path[NAMED_MODEL_PATH_MAX], kind_text[32];
  find_script(script);
  snprintf(path, sizeof path, "%s/%s.csv", folder, table);
  snprintf(kind_text, sizeof kind_text, "%s", kind);

  // -I: neither the user's packages nor the present folder are searched for modules
  char *const argv[] = {"python3", "-I", script, kind_text, path, NULL};
  // what it says goes beside standard output, where the command may print JSON
  if (!program_run(argv, &(program_place){.messages = true}))
    config_warn("the tables are written, but not their page; with Python 3 installed make it with: "
                "python3 %s %s %s",
                script, kind, path);
}
