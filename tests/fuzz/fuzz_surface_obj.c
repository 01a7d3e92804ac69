/* Fuzz target of the reader mesh/formats/obj_read.c.
 * sources: mesh/surface_mesh*.c mesh/mesh*.c mesh/formats/*.c io/text.c mesh/model_quality.c
 * sources: mesh/point_hash.c io/file.c platform/interrupt.c runtime/base/status.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_surface.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_surface_parse(thrum_surface_parse_obj, data, size);
}
