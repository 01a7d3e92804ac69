/* Fuzz target of the reader mesh/formats/mesh_read_vtu.c. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "tests/fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_mesh_parse(thrum_mesh_parse_vtu, data, size);
}
