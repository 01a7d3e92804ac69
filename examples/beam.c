/* The smallest whole program: reads a model, pushes its group "tip" for a moment, steps for three
 * seconds, and says where the tip is.   beam beam.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "thrum/thrum.h"

int main(int argc, char **argv) {
  static double force[THRUM_RANK_MAX], q[THRUM_RANK_MAX];
  const double push[3] = {0, 0, -40}; // [N]
  const int32_t *tip;
  int64_t tip_count;
  thrum_error error = {0};
  const thrum_model *model;
  thrum_state *state;
  thrum_state_def def = thrum_default_state_def();

  // the model, and the vertices of its group
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_model_group(model, "tip", &tip, &tip_count, &error) < 0)
    return fprintf(stderr, "usage: beam MODEL.npz\n%s\n", error.message), 1;

  // a state at rest, and the push as a load on its coordinates
  if (thrum_state_create(model, &def, &state, &error) < 0 ||
      thrum_load_add_shared(model, tip, tip_count, push, force, &error) < 0)
    return fprintf(stderr, "beam: %s\n", error.message), 1;

  // three seconds; the push acts in the first ten steps
  for (int step = 0; step < 1000; step++) {
    thrum_state_set_force(model, state, step < 10 ? force : NULL, NULL);
    if (thrum_step(model, state, &error) < 0)
      return fprintf(stderr, "beam: step %d: %s\n", step, error.message), 1;

    double moved[3];
    if (step % 100 == 99 && thrum_state_get(model, state, q, NULL, NULL) >= 0 &&
        thrum_displacement_mean(model, tip, tip_count, q, moved, NULL) >= 0)
      printf("%.3f s: the tip is %+.5f m off\n", (step + 1) * def.dt, moved[2]);
  }

  thrum_state_destroy(state);
  thrum_model_destroy(model);
  return 0;
}
