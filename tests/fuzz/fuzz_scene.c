/* Fuzz target of scene files: what the reader makes of one, up to the models.
 * sources: cli/scene_read.c cli/scene_keys.c cli/scene_values.c cli/record_read.c cli/json_read.c
 * sources: cli/load_spec.c cli/shake_spec.c cli/start_spec.c cli/simulate_options.c
 * sources: cli/options_file.c cli/args.c cli/model_name.c cli/parse.c cli/message.c
 * sources: precompute/mesh.c precompute/text.c precompute/file.c precompute/interrupt.c
 * sources: runtime/status.c runtime/state_def.c runtime/kernel.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "cli/scene_spec.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  scene_spec spec = {0};
  thrum_error error = {0};
  char *bytes = fuzz_text(data, size);
  const thrum_status status = cli_scene_read_text("folder/scene.json", bytes, size, &spec, &error);
  fuzz_check(status, &error);
  free(bytes);
  // what was read is whole: every body has a name and a model, every list its items
  for (int64_t n = 0; status >= 0 && n < spec.bodies.count; n++) {
    const scene_body_spec *body = &scene_bodies(&spec)[n];
    if (body->name == NULL || body->model == NULL || !(body->scale > 0) || body->rank < 0 ||
        strlen(body->name) > 63)
      abort();
  }
  for (int64_t n = 0; status >= 0 && n < spec.probes.count; n++)
    if (scene_probes(&spec)[n].name == NULL || scene_probes(&spec)[n].target == NULL)
      abort();
  cli_scene_free(&spec);
  return 0;
}
