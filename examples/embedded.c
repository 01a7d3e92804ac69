/* For machines without files and without malloc: the model is linked in as bytes, model and state
 * lie in arrays whose size the linker knows. Of the C library it takes memcpy, libm, and for its
 * one line of output printf. The bytes are made beside it, by cmake -DFILE=beam.npz
 * -DHEADER=model_bytes.h -P bytes.cmake SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "model_bytes.h"
#include "thrum/thrum.h"

#define STEPS 1000
#define MODEL_ROOM (6 * sizeof model_bytes + 65536) /* thrum_model_size says what it takes */
#define STATE_ROOM 1048576                          /* thrum_state_size says what it takes */

static _Alignas(64) unsigned char model_memory[MODEL_ROOM], state_memory[STATE_ROOM];
static double q[THRUM_RANK_MAX];

int main(void) {
  thrum_error error = {0};
  thrum_energies energies = {0};
  const thrum_model *model;
  thrum_state *state;
  thrum_state_def def = thrum_default_state_def();

  // model and state are laid into the arrays; the body starts bent in its first mode
  if (thrum_model_init(model_memory, sizeof model_memory, model_bytes, sizeof model_bytes, &model,
                       &error) < 0 ||
      thrum_state_init(state_memory, sizeof state_memory, model, &def, &state, &error) < 0 ||
      thrum_mode_add(model, 0, 0.05, q, &error) < 0 ||
      thrum_state_set(model, state, q, NULL, &error) < 0)
    return printf("%s\n", error.message), 1;

  for (int step = 0; step < STEPS; step++)
    if (thrum_step(model, state, &error) < 0)
      return printf("step %d: %s\n", step, error.message), 1;

  if (thrum_state_energies(model, state, &energies, &error) < 0)
    return printf("%s\n", error.message), 1;
  printf("rank %d, %d steps: %.6g J\n", (int)model->rank, STEPS, energies.total);
  return 0;
}
