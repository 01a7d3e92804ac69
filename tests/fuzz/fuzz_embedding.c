/* Fuzz target of the surface file: the zip, the .npy members, the check of the embedding, and the
 * display of it. Inputs get valid checksums.
 * sources: runtime/readout/embedding*.c core/model/archive.c
 * core/model/file_buffer.c core/base/large_memory.c
 * core/model/zip.c core/base/npy.c core/base/crc32.c runtime/readout/surface*.c
 * core/base/status.c SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_zip.h"
#include "thrum/embedding.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const thrum_embedding *embedding = NULL;
  const thrum_surface *surface = NULL;
  thrum_error error = {0};
  const char *path = fuzz_file(data, size);
  if (path == NULL)
    return 0;

  // a refusal leaves nothing
  const thrum_status status = thrum_embedding_load(path, &embedding, &error);
  fuzz_check(status, &error);
  if (status < 0) {
    if (embedding != NULL)
      abort();
    return 0;
  }

  // a model with the frequencies that the file was made for
  const thrum_model model = {.rank = embedding->rank, .omega2 = embedding->omega2};
  if (thrum_surface_load(path, &model, &surface, &error) >= 0) {
    // such a model can be shown with this surface
    static double q[THRUM_RANK_MAX];
    const int64_t count = thrum_surface_vertex_count(surface);
    float *out = malloc((size_t)count * 6 * sizeof *out);
    if (out == NULL ||
        thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, count, out, 6, NULL) < 0 ||
        thrum_surface_normals(surface, out, 6, out + 3, 6, NULL) < 0)
      abort();
    free(out);
    thrum_surface_destroy(surface);
  }

  thrum_embedding_destroy(embedding);
  return 0;
}
