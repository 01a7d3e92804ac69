/* Many bodies of one model: the model is shared and never changes, each body is a state; all states
 * lie in one block, and a new body is a copy of its bytes.   step_batch beam.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/thrum.h"

#define BODIES 100

int main(int argc, char **argv) {
  static double q[THRUM_RANK_MAX];
  thrum_error error = {0};
  const thrum_model *model;
  thrum_state *bodies[BODIES];
  size_t size;
  thrum_state_def def = thrum_default_state_def();

  // the model, and how much memory one of its states takes
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_state_size(model, &def, &size, &error) < 0)
    return fprintf(stderr, "usage: step_batch MODEL.npz\n%s\n", error.message), 1;

  // the first state is laid out; the others are copies of it
  const size_t stride = (size + 63) / 64 * 64;
  char *memory = aligned_alloc(64, BODIES * stride);
  if (memory == NULL || thrum_state_init(memory, size, model, &def, &bodies[0], &error) < 0)
    return fprintf(stderr, "step_batch: %s\n", error.message), 1;
  for (int n = 1; n < BODIES; n++)
    bodies[n] = memcpy(memory + (size_t)n * stride, memory, size);

  // each one a little further out than the one before
  for (int n = 0; n < BODIES; n++) {
    memset(q, 0, sizeof q);
    if (thrum_mode_add(model, 0, 0.001 * n, q, &error) < 0 ||
        thrum_state_set(model, bodies[n], q, NULL, &error) < 0)
      return fprintf(stderr, "step_batch: %s\n", error.message), 1;
  }

  // bodies are independent: these two loops may change places or run on threads, and one call of
  // thrum_batch_step may take the place of the inner one
  for (int step = 0; step < 300; step++)
    for (int n = 0; n < BODIES; n++)
      if (thrum_step(model, bodies[n], &error) < 0)
        return fprintf(stderr, "step_batch: body %d: %s\n", n, error.message), 1;

  thrum_energies first = {0}, last = {0};
  if (thrum_state_energies(model, bodies[0], &first, NULL) < 0 ||
      thrum_state_energies(model, bodies[BODIES - 1], &last, NULL) < 0)
    return 1;
  printf("%d bodies in %zu kB: the first has %.3g J, the last %.3g J\n", BODIES,
         BODIES * stride / 1024, first.total, last.total);

  free(memory);
  thrum_model_destroy(model);
  return first.total == 0 && last.total > 0 ? 0 : 1;
}
