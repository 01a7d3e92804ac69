/* Somebody's program on an installed Thrum: one oscillator made by hand, stepped for one period.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

int main(void) {
  /* omega = 2 pi: the period is one second */
  const double omega2 = 39.47841760435743, c3 = 0, c4 = 0;
  const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  thrum_model model = {0};
  model.format = format;
  model.rank = 1;
  model.c3_count = thrum_c3_count(1);
  model.c4_count = thrum_c4_count(1);
  model.omega2 = &omega2;
  model.c3 = &c3;
  model.c4 = &c4;

  thrum_error error = {.status = THRUM_OK};
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.001;
  size_t size = 0;
  thrum_state *state = NULL;
  if (thrum_model_check(&model, &error) < 0 || thrum_state_size(&model, &def, &size, &error) < 0) {
    fprintf(stderr, "%s\n", error.message);
    return 1;
  }
  size = (size + 63) / 64 * 64;
  void *memory = aligned_alloc(64, size);
  const double start = 1;
  double q = 0;
  int failed = memory == NULL || thrum_state_init(memory, size, &model, &def, &state, &error) < 0 ||
               thrum_state_set(&model, state, &start, NULL, &error) < 0;
  for (int step = 0; step < 1000 && !failed; step++) {
    failed = thrum_step(&model, state, &error) < 0;
  }
  failed = failed || thrum_state_get(&model, state, &q, NULL, &error) < 0;
  free(memory);
  if (failed) {
    fprintf(stderr, "%s\n", error.message);
    return 1;
  }
  printf("thrum %s: q = %.6f after one period\n", thrum_version(), q);
  return fabs(q - 1) < 1e-4 ? 0 : 1;
}
