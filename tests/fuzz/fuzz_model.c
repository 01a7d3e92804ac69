/* Fuzz target of the model file: the zip, the .npy members, the check of the model, and the first
 * cut of its rank. Inputs get valid checksums, since otherwise none would pass them.
 * sources: core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_zip.h"
#include "thrum/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const thrum_model *model = NULL;
  thrum_error error = {0};
  const char *path = fuzz_file(data, size);
  if (path == NULL)
    return 0;

  // a refusal leaves nothing
  thrum_status status = thrum_model_load(path, &model, &error);
  fuzz_check(status, &error);
  if (status < 0) {
    if (model != NULL)
      abort();
    return 0;
  }

  // a model that was loaded is valid by its own check
  if (thrum_model_check(model, &error) < 0)
    abort();

  // the vertices of a group are vertices of the mesh
  const int32_t *vertices = NULL;
  int64_t count = 0;
  if (thrum_model_group(model, "tip", &vertices, &count, NULL) >= 0)
    for (int64_t n = 0; n < count; n++)
      if (vertices[n] < 0 || vertices[n] >= model->vertex_count)
        abort();

  thrum_model_destroy(model);
  return 0;
}
