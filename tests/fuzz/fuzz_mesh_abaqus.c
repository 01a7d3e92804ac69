/* Fuzz target of the reader mesh/formats/abaqus_read.c. SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_mesh_parse(thrum_mesh_parse_abaqus, data, size);
}
