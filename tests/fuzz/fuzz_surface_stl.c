/* Fuzz target of the reader mesh/formats/surface_read_stl.c.
 * sources: mesh/*.c mesh/formats/*.c io/text.c io/file.c
 * platform/allocate.c platform/interrupt.c core/base/quadratic_tet.c core/base/status.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/surface_read.h"
#include "tests/fuzz/fuzz_surface.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_surface_parse(thrum_surface_parse_stl, data, size);
}
