/* What may be named where a model is wanted: those that come with Thrum, specs, scene files.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_MODEL_NAMES_H
#define THRUM_DRIVER_SPEC_MODEL_NAMES_H

#include <stdbool.h>

/* X(name, what it is) */
#define MODEL_NAME_LIST(X)                                                                         \
  X(beam, "a cantilever")                                                                          \
  X(basket, "a basket with a handle")                                                              \
  X(bridge, "an arch bridge")                                                                      \
  X(horse, "a standing horse")                                                                     \
  X(tower, "a tower")                                                                              \
  X(heart, "a heart")

enum {
#define X(name, text) MODEL_NAME_##name,
  MODEL_NAME_LIST(X)
#undef X
      MODEL_NAME_COUNT
};
extern const char *const model_names[MODEL_NAME_COUNT];

/* Is this the name of a model, or a spec such as beam: or sine:, and no file? */
bool is_model_name_or_spec(const char *text);

/* Is this the name of a scene file? One that ends with .json and is no folder. */
bool is_scene_name(const char *path);

#endif
