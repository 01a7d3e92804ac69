/* A wind for tests. Header only. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_SCENE_WIND_DEF_H
#define THRUM_TESTS_SUPPORT_SCENE_WIND_DEF_H

#include <string.h>

#include "thrum/scene.h"

/* The def of a wind; drag is that of every body. */
static inline thrum_scene_wind_def wind_of(const double velocity[3], double density, double drag) {
  thrum_scene_wind_def def = thrum_default_scene_wind_def();
  memcpy(def.velocity, velocity, sizeof def.velocity);
  def.density = density;
  def.drag = drag;
  return def;
}

#endif
