/* Fuzz target of snapshots of scenes: a scene is built and stepped as the input says, its snapshot
 * is changed in places and gets the checksum of the changed bytes. What is refused leaves the scene
 * as it was, and what is restored can be stepped.
 * sources: scene/*.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>

#include "core/base/seal.h"
#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_random.h"
#include "thrum/scene.h"

#define RANK 4
#define VERTICES 6
#define SNAPSHOT_MAX 65536

/* The version in the head of a snapshot, behind the letters and the byte order. */
#define VERSION_AT 12

/* Up to three bodies over a floor, which may touch each other; one may be pulled, one condensed,
 * one with a level of detail. */
static thrum_scene *make(fuzz_draw *draw) {
  static const int32_t touch[VERTICES] = {0, 1, 2, 3, 4, 5};
  static const int32_t triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  static const double gravity[3] = {0, 0, -1}, target[3] = {0, 1, 0};
  thrum_scene *scene = NULL;
  thrum_obstacle floor = thrum_default_obstacle();
  const unsigned bits = draw_byte(draw);
  floor.centre[2] = -0.5;
  floor.velocity[2] = bits & 1 ? 0.1 : 0;
  if (thrum_scene_create(0.01, &scene, NULL) < 0 ||
      thrum_scene_set_gravity(scene, gravity, NULL) < 0)
    abort();

  // bodies with what the bits say: points that touch, surfaces that touch, a condensed second one
  const int64_t count = 1 + draw_index(draw, 3);
  for (int64_t n = 0; n < count; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = fuzz_random_model(RANK, VERTICES);
    def.state.integrator = (thrum_integrator)draw_index(draw, 10);
    def.state.iterations_max = 6;
    def.touch = bits & 2 ? touch : NULL;
    def.touch_count = bits & 2 ? VERTICES : 0;
    def.start_mode = 1;
    def.start_amplitude = 0.1;
    def.condense = bits & 4 && n == 1 ? 2 : 0;
    def.triangles = bits & 32 ? triangles : NULL;
    def.triangle_count = bits & 32 ? 4 : 0;
    def.position[0] = 0.3 * (double)n;
    if (thrum_scene_add_body(scene, &def, NULL, NULL) < 0)
      abort();
  }
  if (bits & 2 && thrum_scene_add_obstacle(scene, &floor, NULL, NULL) < 0)
    abort();
  const thrum_scene_detail level = {.masters = 2, .beyond = 0.5, .still = 1, .jump = 1};
  if (bits & 16 && thrum_scene_set_detail(scene, 0, &level, NULL) < 0)
    abort();
  thrum_contact_pairs_def contact = thrum_default_contact_pairs_def();
  contact.touch_max = 32;
  if (bits & 32 && thrum_scene_set_collisions(scene, &contact, NULL) < 0)
    abort();
  if (bits & 8)
    thrum_scene_pull_start(scene, 0, 2, target, 10, -1, &(int32_t){0}, NULL);
  return scene;
}

/* Changes as many places as the input has. */
static void change(unsigned char *bytes, size_t size, fuzz_draw *draw) {
  do {
    const size_t at = (size_t)draw_index(draw, (int64_t)size);
    const unsigned how = draw_byte(draw);
    const double number = draw_any(draw);
    const int64_t whole = (int64_t)draw_byte(draw) - 8;
    if (how % 4 == 0)
      bytes[at] ^= (unsigned char)(1u << how / 4 % 8);
    else if (how % 4 == 1)
      memcpy(bytes + at / 8 * 8, &number, at / 8 * 8 + 8 <= size ? 8 : 0);
    else if (how % 4 == 2)
      memcpy(bytes + at / 8 * 8, &whole, at / 8 * 8 + 8 <= size ? 8 : 0);
    else
      memcpy(bytes + at / 4 * 4, &whole, at / 4 * 4 + 4 <= size ? 4 : 0);
  } while (draw->left > 0);
}

static void use(thrum_scene *scene) {
  thrum_error error = {0};
  for (int step = 0; step < 2; step++) {
    fuzz_check(thrum_scene_update_detail(scene, &error), &error);
    fuzz_check(thrum_scene_step(scene, &error), &error);
    for (int32_t body = 0; body < thrum_scene_body_count(scene); body++) {
      double q[RANK], p[RANK], place[16];
      thrum_scene_energies energies;

      // whatever was restored, no number that is read is NaN or Inf
      if (thrum_scene_body_get(scene, body, q, p, &error) >= 0)
        for (int n = 0; n < RANK; n++)
          if (!isfinite(q[n]) || !isfinite(p[n]))
            abort();
      fuzz_check(thrum_scene_body_energies(scene, body, &energies, &error), &error);
      thrum_scene_body_matrix(scene, body, place);
    }
  }

  // a reset scene steps again
  fuzz_check(thrum_scene_reset(scene, &error), &error);
  fuzz_check(thrum_scene_step(scene, &error), &error);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static unsigned char snapshot[SNAPSHOT_MAX], before[SNAPSHOT_MAX], now[SNAPSHOT_MAX];
  fuzz_draw draw = {data, size};
  thrum_error error = {0};
  thrum_scene *scene = make(&draw);
  for (int64_t steps = draw_index(&draw, 6); steps > 0; steps--) {
    thrum_scene_update_detail(scene, NULL);
    thrum_scene_step(scene, NULL);
  }
  const size_t bytes = thrum_scene_snapshot_size(scene);
  if (bytes > sizeof snapshot || thrum_scene_snapshot(scene, snapshot, bytes, &error) < 0)
    abort();

  // the scene goes on, so that what is refused can be told from what is restored
  thrum_scene_step(scene, NULL);
  if (thrum_scene_snapshot(scene, before, bytes, &error) < 0)
    abort();
  change(snapshot + THRUM_SEAL_BYTES, bytes - THRUM_SEAL_BYTES, &draw);

  // sealed anew as what it was
  thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 'c', 'n'}, 0};
  memcpy(&kind.version, snapshot + VERSION_AT, sizeof kind.version);
  thrum_seal_put(snapshot, bytes, kind);
  const thrum_status status = thrum_scene_restore(scene, snapshot, bytes, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    use(scene);
  else if (thrum_scene_snapshot(scene, now, bytes, &error) < 0 || memcmp(before, now, bytes) != 0)
    abort();

  thrum_scene_destroy(scene);
  return 0;
}
