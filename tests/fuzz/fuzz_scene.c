/* Fuzz target of the reader of scene files, up to the models.
 *
 * sources: driver/scene_spec.c driver/scene_keys.c driver/shared_options.c config/options.c
 * config/options_json.c config/options_command.c config/parse.c config/message.c
 * driver/load_spec.c driver/base_motion_spec.c driver/start_spec.c driver/mesh_model.c
 * driver/named_model.c driver/model_names.c io/json_read.c io/text.c io/file.c io/paths.c
 * mesh/formats/mesh_read.c platform/interrupt.c runtime/base/status.c runtime/loads/*.c
 * runtime/dynamics/state_def.c runtime/dynamics/state_names.c runtime/polynomial/kernel.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_spec.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  scene_spec spec = {0};
  thrum_error error = {0};

  // the reader must not need the bytes after its call
  char *bytes = fuzz_text(data, size);
  const thrum_status status = scene_spec_read_text("folder/scene.json", bytes, size, &spec, &error);
  fuzz_check(status, &error);
  free(bytes);

  // what was read is complete: every body has a name and a model, every list its items
  for (int64_t n = 0; status >= 0 && n < spec.bodies.count; n++) {
    const scene_body_spec *body = &scene_bodies(&spec)[n];
    if (body->name == NULL || body->model == NULL || !(body->scale > 0) || body->rank < 0 ||
        strlen(body->name) > 63)
      abort();
  }

  for (int64_t n = 0; status >= 0 && n < spec.probes.count; n++)
    if (scene_probes(&spec)[n].name == NULL || scene_probes(&spec)[n].target == NULL)
      abort();

  scene_spec_free(&spec);
  return 0;
}
