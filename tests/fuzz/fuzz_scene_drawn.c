/* Fuzz target of the reader of scene files, by files drawn from the tables of their keys.
 *
 * sources: driver/scene/scene_spec.c driver/scene/scene_keys.c driver/spec/shared_options.c
 * driver/spec/basis_asked.c config/options.c config/options_json.c config/options_command.c
 * config/parse.c config/message.c config/message_error.c driver/spec/load_spec.c
 * mesh/vertex_places.c driver/spec/base_motion_spec.c driver/spec/actuate_spec.c
 * driver/spec/start_spec.c driver/make/mesh_model.c driver/make/named_model.c
 * driver/spec/model_names.c driver/spec/region_material.c driver/spec/region_elastic.c
 * mesh/elastic.c driver/record/run_entries.c driver/scene/scene_words.c io/json_read.c io/text.c
 * io/file.c io/paths.c mesh/mesh_groups.c mesh/formats/mesh_read.c platform/interrupt.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c SPDX-License-Identifier: Apache-2.0 */
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
