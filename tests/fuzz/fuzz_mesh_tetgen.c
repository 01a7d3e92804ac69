/* Fuzz target of the reader mesh/formats/mesh_read_tetgen.c: an input is the .node file, a 0, and
 * the .ele file. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "tests/fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const uint8_t *split = size > 0 ? memchr(data, 0, size) : NULL;
  const size_t nodes = split ? (size_t)(split - data) : size;
  const uint8_t *elements = split ? split + 1 : data;
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  const thrum_mesh_source sources[2] = {
      {"input.node", data, nodes, NULL, false},
      {"input.ele", elements, split ? size - nodes - 1 : 0, NULL, false}};
  const thrum_status status = thrum_mesh_parse_tetgen(&sources[0], &sources[1], &mesh, &error);
  fuzz_mesh_use(status, &mesh, &error);
  return 0;
}
