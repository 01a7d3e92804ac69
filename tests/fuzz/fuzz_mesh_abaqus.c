/* Fuzz target of the reader of Abaqus decks, mesh/formats/mesh_read_abaqus.c. Inputs that name
 * other files are passed over, so that a run depends on its input alone.
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "tests/fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char word[] = "INPUT";
  const size_t length = sizeof word - 1;
  for (size_t i = 0; i + length <= size; i++)
    if (thrum_text_equals((thrum_word){(const char *)data + i, length}, word))
      return 0;
  return fuzz_mesh_parse(thrum_mesh_parse_abaqus, data, size);
}
