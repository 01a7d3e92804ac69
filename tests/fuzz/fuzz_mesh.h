/* The use that every fuzz target of a mesh reader makes of its mesh: it is cleaned, examined and
 * freed. A target is built with clang -fsanitize=fuzzer; tests/fuzz/test_fuzz.sh builds and runs
 * them all. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_MESH_H
#define THRUM_TESTS_FUZZ_FUZZ_MESH_H

#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_flags.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Examines and frees a mesh that is clean where `status` says no failure; after one it must be
 * empty, and the message one line. */
static inline void fuzz_mesh_examine(thrum_status status, thrum_mesh *mesh,
                                     const thrum_error *error) {
  if (status < 0) {
    if (mesh->vertices || mesh->tets || error->status != status || !error->message[0] ||
        strchr(error->message, '\n'))
      abort();
    return;
  }
  thrum_error later = {0};
  thrum_mesh_examined examined;
  if (thrum_mesh_examine(mesh, &examined, &later) >= 0)
    thrum_mesh_flags(mesh, &examined);
  else if (!later.message[0])
    abort();
  thrum_mesh_free(mesh);
}

/* The same of a mesh as its reader left it, which can be cleaned or is refused with a message. */
static inline void fuzz_mesh_use(thrum_status status, thrum_mesh *mesh, const thrum_error *error) {
  thrum_error later = {0};
  if (status >= 0 && thrum_mesh_clean(mesh, "input", 1, &later) < 0) {
    if (!later.message[0])
      abort();
    thrum_mesh_free(mesh);
    return;
  }
  fuzz_mesh_examine(status, mesh, error);
}

static inline int fuzz_mesh_parse(thrum_mesh_parser *parse, const uint8_t *data, size_t size) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  const thrum_status status =
      parse(&(thrum_mesh_source){"input", data, size, NULL, false, size % 2 == 1}, &mesh, &error);
  fuzz_mesh_use(status, &mesh, &error);
  return 0;
}

#endif
