/* The use that fuzz targets make of a scene file. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_SCENE_H
#define THRUM_TESTS_FUZZ_FUZZ_SCENE_H

#include "driver/scene/scene_spec.h"
#include "tests/fuzz/fuzz_file.h"

/* Reads a scene file; what was read must be complete. */
static inline void fuzz_scene_read(const char *bytes, size_t size) {
  scene_spec spec = {0};
  thrum_error error = {0};

  // the reader must not need the bytes after its call
  char *copy = fuzz_text((const uint8_t *)bytes, size);
  const thrum_status status = scene_spec_read_text("folder/scene.json", copy, size, &spec, &error);
  fuzz_check(status, &error);
  free(copy);

  // every body has a name and a model, every list its items
  for (int64_t n = 0; status >= 0 && n < spec.bodies.count; n++) {
    const scene_body_spec *body = &scene_bodies(&spec)[n];
    if (body->name == NULL || body->model == NULL || !(body->scale > 0) || body->rank < 0 ||
        strlen(body->name) > 63)
      abort();
  }

  for (int64_t n = 0; status >= 0 && n < spec.probes.count; n++)
    if (scene_probes(&spec)[n].name == NULL || scene_probes(&spec)[n].target == NULL)
      abort();

  scene_spec_free(&spec);
}

#endif
