/* The names of the models that come with Thrum. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_NAMES_H
#define THRUM_DRIVER_MODEL_NAMES_H

#include <stdbool.h>

/* X(name, what it is) */
#define CLI_MODEL_LIST(X)                                                                          \
  X(beam, "a cantilever")                                                                          \
  X(basket, "a basket with a handle")                                                              \
  X(bridge, "an arch bridge")                                                                      \
  X(horse, "a standing horse")                                                                     \
  X(tower, "a tower")                                                                              \
  X(heart, "a heart")

enum {
#define X(name, text) CLI_MODEL_##name,
  CLI_MODEL_LIST(X)
#undef X
      CLI_MODEL_COUNT
};
extern const char *const cli_model_names[CLI_MODEL_COUNT];

/* Is this the name of a model, or a spec such as beam: or sine:, and no file? */
bool is_model_name_or_spec(const char *text);

#endif
