/* Support for fuzz targets of what a program does with a model: an input is a model file behind
 * PLAN_BYTES bytes that choose what is done. Inputs get valid checksums.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_USE_H
#define THRUM_TESTS_FUZZ_FUZZ_USE_H

#define PLAN_BYTES 64
#define FUZZ_ZIP_AT PLAN_BYTES

#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_zip.h"
#include "thrum/scene.h"

#define RANK_MOST 16

/* Memory as the library wants it, of just this size, so that a sanitizer sees what lies beyond. */
static inline void *block(size_t size) {
  void *memory = NULL;
  if (posix_memalign(&memory, 64, size > 0 ? size : 1) != 0)
    abort();
  memset(memory, 0xff, size);
  return memory;
}

static inline void must_be_finite(const double *values, int64_t count) {
  for (int64_t n = 0; n < count; n++)
    if (!isfinite(values[n]))
      abort();
}

static inline void draw_vector(fuzz_draw *draw, int64_t count, double size, double *values) {
  for (int64_t n = 0; n < count; n++)
    values[n] = draw_about(draw, size);
}

static inline thrum_state_def draw_def(fuzz_draw *draw, int64_t rank) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = (thrum_integrator)draw_index(draw, 10);
  def.dt = draw_above(draw, 0.01);
  def.iterations_max = 1 + (int32_t)draw_index(draw, 20);

  // choices that are seldom away from their defaults
  const unsigned bits = draw_byte(draw);
  if (bits & 1)
    def.damping_alpha = draw_above(draw, 1);
  if (bits & 2)
    def.damping_beta = draw_above(draw, 1e-3);
  def.damping_form = bits & 4 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
  def.split_rule = (thrum_split_rule)(bits >> 3 & 3);
  def.explicit_count = (int32_t)draw_index(draw, rank + 1);
  def.split_form = (thrum_split_form)draw_index(draw, 3);
  def.solver = bits & 32 ? THRUM_SOLVER_NEWTON : THRUM_SOLVER_QUASI_NEWTON;
  def.adaptive = !(bits & 64);
  def.fallback = !(bits & 128);
  return def;
}

/* Another model made of it, which is then used in its place. */
static inline const thrum_model *derive(const thrum_model *model, fuzz_draw *draw, void **memory) {
  const thrum_model *made = model;
  const thrum_model_scaling by = {draw_above(draw, 64), draw_above(draw, 64), draw_above(draw, 64)};
  const int64_t rank = draw_index(draw, model->rank + 2);
  thrum_error error = {0};
  size_t size = 0;
  thrum_status status = THRUM_OK;

  // locked, scaled, condensed, or as it is
  switch (draw_byte(draw) % 4) {
  case 0:
    status = thrum_model_lock_size(model, rank, &size, &error);
    *memory = block(size);
    THRUM_THEN(status, thrum_model_lock(*memory, size, model, rank, &made, &error));
    break;
  case 1:
    status = thrum_model_scale_size(model, &size, &error);
    *memory = block(size);
    THRUM_THEN(status, thrum_model_scale(*memory, size, model, &by, &made, &error));
    break;
  case 2:
    status = thrum_model_condense_size(model, rank, &size, &error);
    *memory = block(size);
    THRUM_THEN(status, thrum_model_condense(*memory, size, model, rank, &made, &error));
    break;
  default:
    break;
  }
  fuzz_check(status, &error);
  return status >= 0 ? made : NULL;
}

/* A model that is used, and the memory that it lies in. */
typedef struct fuzz_opened {
  const thrum_model *model; /* NULL: the file or what was made of it is refused, or too large */
  void *memory, *other;
} fuzz_opened;

static inline fuzz_opened fuzz_open(const uint8_t *data, size_t size, fuzz_draw *draw) {
  fuzz_opened made = {NULL, NULL, NULL};
  const thrum_model *model = NULL;
  thrum_error error = {0};
  size_t needed = 0;

  // the file is read out of memory of just its size
  thrum_status status = thrum_model_size(data + PLAN_BYTES, size - PLAN_BYTES, &needed, &error);
  if (status >= 0) {
    made.memory = block(needed);
    status =
        thrum_model_init(made.memory, needed, data + PLAN_BYTES, size - PLAN_BYTES, &model, &error);
  }
  fuzz_check(status, &error);
  if (status >= 0 && model->rank <= RANK_MOST)
    made.model = derive(model, draw, &made.other);
  return made;
}

static inline void fuzz_close(fuzz_opened *opened) {
  free(opened->other);
  free(opened->memory);
}

#endif
