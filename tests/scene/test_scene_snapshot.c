/* Tests of snapshots of scenes with changed bits: refused, and the scene stays as it was, or
 * harmless where the checksum was made for them. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "core/base/seal.h"
#include "tests/support/scene_call.h"

/* The head of snapshots of scenes, as scene_snapshot.c writes it. */
static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 'c', 'n'}, 13};

enum { VERTICES = 8 };

/* A free cube on a floor, and its snapshot while it touches. */
typedef struct fixture {
  body cube;
  thrum_precomputed made;
  thrum_scene *scene;
  unsigned char *snapshot, *now;
  size_t size;
} fixture;

static int setup(void **context) {
  static const double down[3] = {0, 0, -9.81};
  static int32_t touch[VERTICES];
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->cube = body_make("beam:1x1x1@0.1x0.1x0.1", NULL);
  f->made = body_precompute(&f->cube, 2, 2);
  assert_int_equal(f->made.model.vertex_count, VERTICES);
  for (int32_t v = 0; v < VERTICES; v++)
    touch[v] = v;

  // it falls by a few millimetres onto the floor, and stays in contact
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.touch = touch;
  def.touch_count = VERTICES;
  def.free = 1;
  def.position[2] = 0.002;
  MUST(thrum_scene_create(0.002, &f->scene, &failure));
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  const thrum_obstacle floor = thrum_default_obstacle();
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));

  // a level of detail that changes nothing, for what snapshots keep of it
  const thrum_scene_detail level = {.masters = 1, .still = 1e-12, .jump = 1};
  MUST(thrum_scene_set_detail(f->scene, 0, &level, &failure));
  thrum_scene_body_info info = {0};
  for (int k = 0; k < 200 && info.contact.touching == 0; k++) {
    MUST(thrum_scene_update_detail(f->scene, &failure));
    MUST(thrum_scene_step(f->scene, &failure));
    MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  }
  assert_true(info.contact.touching > 0);

  f->size = thrum_scene_snapshot_size(f->scene);
  f->snapshot = need(f->size, 1);
  f->now = need(f->size, 1);
  MUST(thrum_scene_snapshot(f->scene, f->snapshot, f->size, &failure));
  *context = f;
  return 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  thrum_precomputed_free(&f->made);
  body_free(&f->cube);
  free(f->snapshot);
  free(f->now);
  free(f);
  return 0;
}

static thrum_status restore(fixture *f) {
  return thrum_scene_restore(f->scene, f->snapshot, f->size, &failure);
}

/* The scene is where the snapshot `kept` was taken. */
static void expect_at(fixture *f, const unsigned char *kept) {
  MUST(thrum_scene_snapshot(f->scene, f->now, f->size, &failure));
  assert_memory_equal(f->now, kept, f->size);
}

/* One bit of each byte, another one from byte to byte. */
static unsigned char bit_of(size_t byte) {
  return (unsigned char)(1u << (3 * byte + byte / 8) % 8);
}

/* A def of a free body with a few faces, which have to outlive it. */
static thrum_scene_body_def body_of(const fixture *f, int32_t faces[15]) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  const int32_t *tets = f->made.model.tets;
  def.model = &f->made.model;
  def.free = 1;
  def.position[2] = 1;
  def.triangles = faces;
  def.triangle_count = 5;
  for (int64_t t = 0; t < 5; t++)
    for (int k = 0; k < 3; k++)
      faces[3 * t + k] = tets[4 * t + (k == 0 ? 0 : 3 - k)];
  return def;
}

/* Each way in which a body may be refused leaves the snapshot of the scene as it is. */
static void refuse_bodies(fixture *f, const thrum_scene_body_def *def) {
  static const int32_t touch[1] = {0};
  const size_t size = thrum_scene_snapshot_size(f->scene);
  unsigned char *before = need(size, 1), *after = need(size, 1);
  MUST(thrum_scene_snapshot(f->scene, before, size, &failure));
  for (int n = 0; n < 5; n++) {
    thrum_scene_body_def wrong = *def;
    wrong.touch = touch;
    wrong.touch_count = 1;
    wrong.touch_stiffness = n == 0 ? 1e31 : 0;
    wrong.position[0] = n == 1 ? 1e31 : 0;
    wrong.velocity[1] = n == 2 ? 1e300 : 0;
    wrong.start_mode = n == 3 ? 99 : 0;
    wrong.state.tolerance = n == 4 ? 7 : 0;
    assert_true(thrum_scene_add_body(f->scene, &wrong, NULL, &failure) < 0);
    assert_int_equal(thrum_scene_snapshot_size(f->scene), size);
    MUST(thrum_scene_snapshot(f->scene, after, size, &failure));
    assert_memory_equal(after, before, size);
  }
  MUST(thrum_scene_restore(f->scene, before, size, &failure));
  free(before);
  free(after);
}

/* What is refused leaves the scene as it was, so that its snapshots remain its own: also where the
 * body would have needed more room for touches. */
static void a_refused_body_leaves_snapshots_their_scene(void **context) {
  fixture *f = *context;
  const thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  int32_t faces[15];
  const thrum_scene_body_def def = body_of(f, faces);
  MUST(thrum_scene_set_collisions(f->scene, &pairs, &failure));
  for (int bodies = 0; bodies < 9; bodies++) {
    MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
    refuse_bodies(f, &def);
  }
}

/* A scene takes its own snapshot wherever its bodies and its eye are. */
static void a_snapshot_far_away_is_taken(void **context) {
  fixture *f = *context;
  static const double reaches[] = {1e10, 1e20, 1e30, 1e31, 1e160, 1e300};
  for (int n = 0; n < 6; n++) {
    const double reach = reaches[n], eye[3] = {reach, -reach, reach};
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &f->made.model;
    def.free = 1;
    def.position[0] = def.position[1] = def.velocity[0] = reach;

    // beyond 1e30 nothing is
    const bool taken = thrum_scene_add_body(f->scene, &def, NULL, &failure) >= 0;
    assert_true(taken == (reach <= 1e30));
    assert_true((thrum_scene_set_eye(f->scene, eye, &failure) >= 0) == taken);
    MUST(thrum_scene_update_detail(f->scene, &failure));
    MUST(thrum_scene_step(f->scene, &failure));
    MUST(thrum_scene_update_detail(f->scene, &failure));
    const size_t size = thrum_scene_snapshot_size(f->scene);
    unsigned char *own = need(size, 1);
    MUST(thrum_scene_snapshot(f->scene, own, size, &failure));
    MUST(thrum_scene_restore(f->scene, own, size, &failure));
    free(own);
  }
}

static void a_changed_bit_is_refused(void **context) {
  fixture *f = *context;
  for (size_t byte = 0; byte < f->size; byte++) {
    f->snapshot[byte] ^= bit_of(byte);
    if (restore(f) >= 0)
      fail_msg("a bit of byte %zu of %zu is not noticed", byte, f->size);
    f->snapshot[byte] ^= bit_of(byte);
  }
  expect_at(f, f->snapshot);
  MUST(restore(f));
}

static void a_changed_bit_under_a_right_checksum_is_refused_or_harmless(void **context) {
  fixture *f = *context;
  unsigned char *kept = need(f->size, 1);
  memcpy(kept, f->snapshot, f->size);
  int taken = 0, refused = 0;

  for (size_t byte = THRUM_SEAL_BYTES; byte < f->size; byte++) {
    memcpy(f->snapshot, kept, f->size);
    f->snapshot[byte] ^= bit_of(byte);
    thrum_seal_put(f->snapshot, f->size, kind);
    if (restore(f) < 0) {
      // half of it must not have been taken
      expect_at(f, kept);
      refused++;
      continue;
    }

    // steps may fail, but the body is somewhere
    double q[VERTICES], p[VERTICES];
    taken++;
    thrum_scene_update_detail(f->scene, &failure);
    thrum_scene_step(f->scene, &failure);
    thrum_scene_step(f->scene, &failure);
    if (thrum_scene_body_get(f->scene, 0, q, p, &failure) >= 0)
      assert_true(isfinite(q[0]) && isfinite(q[1]) && isfinite(p[0]) && isfinite(p[1]));
    MUST(thrum_scene_restore(f->scene, kept, f->size, &failure));
  }

  assert_true(taken > 0 && refused > 0);
  free(kept);
}

static void a_snapshot_of_another_version_or_scene_is_refused(void **context) {
  fixture *f = *context;
  thrum_seal_kind later = kind;
  later.version++;
  thrum_seal_put(f->snapshot, f->size, later);
  assert_int_equal(restore(f), THRUM_UNSUPPORTED);
  assert_non_null(strstr(failure.message, "version"));
  thrum_seal_put(f->snapshot, f->size, kind);
  MUST(restore(f));

  // a scene that was changed since
  MUST(thrum_scene_set_dt(f->scene, 0.001, &failure));
  assert_int_equal(restore(f), THRUM_MODEL_MISMATCH);
  assert_int_equal(thrum_scene_restore(f->scene, NULL, f->size, &failure), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_scene_restore(f->scene, f->snapshot, f->size - 1, &failure),
                   THRUM_BUFFER_TOO_SMALL);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
  const struct CMUnitTest tests[] = {
      TEST(a_changed_bit_is_refused),
      TEST(a_refused_body_leaves_snapshots_their_scene),
      TEST(a_snapshot_far_away_is_taken),
      TEST(a_changed_bit_under_a_right_checksum_is_refused_or_harmless),
      TEST(a_snapshot_of_another_version_or_scene_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
