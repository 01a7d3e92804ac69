/* Fuzz target of the reader of scene files, by files drawn from the tables of their keys.
 *
 * sources: driver/scene_spec.c driver/scene_keys.c driver/shared_options.c driver/basis_asked.c config/options.c
 * config/options_json.c config/options_command.c config/parse.c config/message.c
 * driver/load_spec.c mesh/vertex_places.c driver/base_motion_spec.c
 * driver/start_spec.c driver/mesh_model.c driver/named_model.c driver/model_names.c
 * driver/region_material.c driver/run_entries.c driver/scene_words.c io/json_read.c io/text.c
 * io/file.c io/paths.c mesh/mesh_groups.c mesh/formats/mesh_read.c platform/interrupt.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_scene.h"
#include "tests/fuzz/fuzz_table.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static drawn_text text;
  fuzz_draw draw = {data, size};
  text.used = 0;
  draw_record(&draw, scene_keys, false, 0, &text);
  fuzz_scene_read(text.bytes, text.used);
  return 0;
}
