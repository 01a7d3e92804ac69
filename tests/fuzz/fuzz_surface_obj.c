/* Fuzz target of the reader precompute/surface_mesh_obj.c.
 * sources: precompute/surface_mesh*.c precompute/mesh*.c precompute/text.c precompute/quality.c
 * sources: precompute/places.c precompute/file.c precompute/interrupt.c runtime/status.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_surface.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_surface_parse(thrum_surface_parse_obj, data, size);
}
