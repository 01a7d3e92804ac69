/* Fuzz target of --fix: predicates and groups, and behind a first byte that is odd, files of vertex
 * numbers.
 * sources: mesh/*.c mesh/formats/*.c io/text.c io/file.c
 * platform/interrupt.c platform/allocate.c core/base/quadratic_tet.c core/base/status.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_fix.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static thrum_mesh mesh;
  thrum_error error = {0};

  // one small mesh serves all inputs
  if (mesh.vertices == NULL && thrum_mesh_read("beam:2x1x1@2x1x1", 1, &mesh, &error) < 0)
    abort();
  if (size == 0)
    return 0;

  // the first byte chooses between a specification and a file of numbers
  uint8_t fixed[64] = {0};
  int64_t count = 0;
  char *text = fuzz_text(data + 1, size - 1);
  const char *path = data[0] % 2 != 0 ? fuzz_file(data + 1, size - 1) : text;

  // a text that names a file of this machine would be read, so it is left out
  if (path != NULL && (path != text || (strchr(text, '/') == NULL && access(text, F_OK) != 0))) {
    const thrum_status status = thrum_mesh_fix(&mesh, path, fixed, &count, &error);
    fuzz_check(status, &error);

    // a refusal fixes nothing, and the count is plausible
    for (int v = 0; status < 0 && v < 64; v++)
      if (fixed[v] != 0)
        abort();
    if (status >= 0 && (count < 0 || count > mesh.vertex_count))
      abort();
  }

  free(text);
  return 0;
}
