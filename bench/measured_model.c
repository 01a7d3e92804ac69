/* The body that benches use when no model file is given. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "bench/measured_model.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_fix.h"
#include "platform/allocate.h"
#include "precompute/precompute.h"
#include "thrum/polynomial.h"

/* The model of a mesh at this rank; held: which vertices are fixed, NULL: none. */
static thrum_status make(const char *name, const char *held, int64_t rank, thrum_model **model,
                         thrum_error *error) {
  thrum_mesh mesh = {0};
  thrum_precomputed *result = NULL;
  uint8_t *fixed = NULL;
  int64_t count = 0;
  thrum_status status = thrum_reserve(&result, 1, sizeof *result, "a model", error);
  THRUM_THEN(status, thrum_mesh_read(name, 1.0, &mesh, error));
  THRUM_THEN(status, thrum_reserve(&fixed, mesh.vertex_count, 1, "a model", error));
  if (held != NULL)
    THRUM_THEN(status, thrum_mesh_fix(&mesh, held, fixed, &count, error));

  if (status >= 0) {
    thrum_precompute_options options = thrum_default_precompute_options();
    options.modes = (rank + 1) / 2;
    options.rank = rank;
    status = thrum_precompute(&mesh, fixed, &options, result, error);
  }

  thrum_mesh_free(&mesh);
  free(fixed);

  // packed as a model from a file is, so that its steps are as fast
  if (status >= 0) {
    const size_t size = thrum_model_pack_size(&result->model);
    void *packed = thrum_allocate_aligned(size, "a model", error);
    status = packed ? thrum_model_pack(&result->model, packed, size, error) : THRUM_OUT_OF_MEMORY;
    if (status < 0) {
      free(packed);
      thrum_precomputed_free(result);
    }
  }

  if (status < 0) {
    free(result);
    return status;
  }

  // the model is the first member
  *model = &result->model;
  return status;
}

thrum_status bench_model_beam(int64_t rank, thrum_model **model, thrum_error *error) {
  return make("beam:20x3x3@1x0.15x0.15,split=6", "x<0.001", rank, model, error);
}

thrum_status bench_model_block(int64_t rank, thrum_model **model, thrum_error *error) {
  return make("beam:14x14x10@0.3x0.3x0.2", NULL, rank, model, error);
}

void bench_model_free(thrum_model *model) {
  if (!model)
    return;
  thrum_precomputed *result = (thrum_precomputed *)(void *)model;
  free((void *)(uintptr_t)(model->packed ? (const void *)model->packed : model->packed_single));
  thrum_precomputed_free(result);
  free(result);
}
