/* A call that finds no memory says so and leaves the scene as it was, whichever of its allocations
 * fails; what is built with such failures in between steps with the bits of what is built without.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/failing_allocator.h"
#include "tests/support/scene_call.h"
#include "tests/support/two_bars.h"

typedef two_bars fixture;

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  two_bars_make(f, "beam:2x1x1@0.4x0.1x0.1,split=6", 1e6);
  *context = f;
  return 0;
}

static int teardown(void **context) {
  two_bars_free(*context);
  free(*context);
  return 0;
}

/* --- calls that allocate ---------------------------------------------------------------------- */

static thrum_status add_free(const fixture *f, thrum_scene *scene) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  const double place[3] = {0.1 * thrum_scene_body_count(scene), 0, 0.3};
  memcpy(def.position, place, sizeof place);
  def.model = &f->free_bar.model;
  def.free = 1;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.touch = f->triangles;
  def.touch_count = 3;
  def.position[1] = 0.2 * thrum_scene_body_count(scene);
  return thrum_scene_add_body(scene, &def, NULL, &failure);
}

static thrum_status add_self(const fixture *f, thrum_scene *scene) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->held_bar.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.self_contact = 1;
  def.scale = 2;
  def.position[2] = 1;
  def.start_mode = 1;
  def.start_amplitude = 0.01;
  return thrum_scene_add_body(scene, &def, NULL, &failure);
}

static thrum_status add_condensed(const fixture *f, thrum_scene *scene) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->held_bar.model;
  def.condense = 2;
  def.position[2] = 2;
  return thrum_scene_add_body(scene, &def, NULL, &failure);
}

static thrum_status add_coupled(const fixture *f, thrum_scene *scene) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->free_bar.model;
  def.free = def.coupled = 1;
  def.spin[2] = 10;
  def.position[2] = 3;
  return thrum_scene_add_body(scene, &def, NULL, &failure);
}

static thrum_status add_plane(const fixture *f, thrum_scene *scene) {
  (void)f;
  thrum_obstacle floor = thrum_default_obstacle();

  // what lies between two members is none of the scene's, and differs from call to call
  static int calls;
  const size_t after = offsetof(thrum_obstacle, inside) + sizeof floor.inside;
  memset((char *)&floor + after, ++calls, offsetof(thrum_obstacle, velocity) - after);
  return thrum_scene_add_obstacle(scene, &floor, NULL, &failure);
}

static thrum_status add_box(const fixture *f, thrum_scene *scene) {
  (void)f;
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.position[2] = -1;
  return thrum_scene_add_solid(scene, &def, NULL, &failure);
}

static thrum_status add_field(const fixture *f, thrum_scene *scene) {
  (void)f;
  static const double heights[6] = {0, 0.1, 0, 0.1, 0, 0.1}, times[2] = {0, 1};
  static const double places[14] = {0, 0, -2, 1, 0, 0, 0, 0, 0, -1.9, 1, 0, 0, 0};
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.shape = THRUM_SOLID_HEIGHT_FIELD;
  def.heights = heights;
  def.rows = 2;
  def.columns = 3;
  def.path_times = times;
  def.path_places = places;
  def.path_count = 2;
  return thrum_scene_add_solid(scene, &def, NULL, &failure);
}

static thrum_status collide(const fixture *f, thrum_scene *scene) {
  (void)f;
  const thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  return thrum_scene_set_collisions(scene, &def, &failure);
}

static thrum_status add_force(const fixture *f, thrum_scene *scene) {
  (void)f;
  const thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_FORCE,
      .vector = {0, 1, 2},
      .course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 3}};
  return thrum_scene_add_load(scene, 0, &load, &failure);
}

static thrum_status add_acceleration(const fixture *f, thrum_scene *scene) {
  (void)f;
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_ACCELERATION,
                                     .vector = {0, 0, -1},
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  return thrum_scene_add_load(scene, 1, &load, &failure);
}

static thrum_status move_ground(const fixture *f, thrum_scene *scene) {
  (void)f;
  const double amplitude[3] = {0.1, 0, 0};
  const thrum_load course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 5};
  return thrum_scene_add_base_motion(scene, amplitude, &course, &failure);
}

static thrum_status blow(const fixture *f, thrum_scene *scene) {
  (void)f;
  thrum_scene_wind_def def = thrum_default_scene_wind_def();
  def.velocity[0] = 2;
  return thrum_scene_set_wind(scene, &def, &failure);
}

static thrum_status link_bars(const fixture *f, thrum_scene *scene) {
  (void)f;
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = THRUM_LINK_BALL;
  def.other = 1;
  return thrum_scene_add_link(scene, &def, NULL, &failure);
}

static thrum_status link_spring(const fixture *f, thrum_scene *scene) {
  (void)f;
  static const double times[2] = {0, 1}, places[6] = {0, 0, 0, 0, 0, 0.1};
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = THRUM_LINK_SPRING;
  def.body = 1;
  def.stiffness = 10;
  for (int axis = 0; axis < 3; axis++)
    def.other_place[axis] = 2;
  def.path_times = times;
  def.path_places = places;
  def.path_count = 2;
  return thrum_scene_add_link(scene, &def, NULL, &failure);
}

static thrum_status pull(const fixture *f, thrum_scene *scene) {
  (void)f;
  const double target[3] = {0, 0, 1};
  return thrum_scene_pull_start(scene, 2, 3, target, 50, -1, NULL, &failure);
}

static thrum_status probe(const fixture *f, thrum_scene *scene) {
  static const int32_t corners[2] = {0, 1};
  (void)f;
  return thrum_scene_add_probe(scene, "corners", 0, corners, 2, &failure);
}

static thrum_status watch(const fixture *f, thrum_scene *scene) {
  (void)f;
  const thrum_scene_detail detail = {.masters = 2, .beyond = 1, .jump = 1};
  return thrum_scene_set_detail(scene, 4, &detail, &failure);
}

static thrum_status update(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_update_detail(scene, &failure);
}

static thrum_status stiffen(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_stiffness(scene, 1, 1.5, &failure);
}

static thrum_status damp(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_damping(scene, 0, 0.5, 1e-4, &failure);
}

static thrum_status choose_newmark(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_integrator(scene, 2, THRUM_INTEGRATOR_NEWMARK, &failure);
}

static thrum_status shorten(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_dt(scene, 0.001, &failure);
}

static thrum_status condense_more(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_condensed(scene, 3, 1, &failure);
}

static void run_all(void *context, int32_t count, void (*task)(void *of, int32_t n, int32_t worker),
                    void *of) {
  (void)context;
  for (int32_t n = 0; n < count; n++)
    task(of, n, n % 2);
}

static thrum_status share(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_set_workers(scene, 2, run_all, NULL, &failure);
}

static thrum_status look(const fixture *f, thrum_scene *scene) {
  (void)f;
  thrum_scene_overlap deepest;
  return thrum_scene_find_overlap(scene, &deepest, &failure);
}

static thrum_status start_again(const fixture *f, thrum_scene *scene) {
  (void)f;
  return thrum_scene_reset(scene, &failure);
}

typedef struct attempt {
  const char *what;
  thrum_status (*call)(const fixture *f, thrum_scene *scene);
} attempt;

static const attempt attempts[] = {{"a free body", add_free},
                                   {"another", add_free},
                                   {"a body that touches itself", add_self},
                                   {"a condensed body", add_condensed},
                                   {"a held body", add_condensed},
                                   {"a coupled body", add_coupled},
                                   {"a plane", add_plane},
                                   {"a load", add_force},
                                   {"a load of a whole body", add_acceleration},
                                   {"a base motion", move_ground},
                                   {"collisions", collide},
                                   {"a box", add_box},
                                   {"a height field on a path", add_field},
                                   {"a body among all of these", add_free},
                                   {"collisions anew", collide},
                                   {"the wind", blow},
                                   {"a joint", link_bars},
                                   {"a spring", link_spring},
                                   {"a pull", pull},
                                   {"a probe", probe},
                                   {"the stiffness", stiffen},
                                   {"the damping", damp},
                                   {"the integrator", choose_newmark},
                                   {"the time step", shorten},
                                   {"fewer coordinates", condense_more},
                                   {"workers", share},
                                   {"overlaps", look},
                                   {"the start", start_again}};
enum { ATTEMPTS = sizeof attempts / sizeof *attempts };

/* --- tests ------------------------------------------------------------------------------------ */

static uint8_t *snapshot_of(const thrum_scene *scene, size_t *size) {
  *size = thrum_scene_snapshot_size(scene);
  uint8_t *bytes = need(*size, 1);
  MUST(thrum_scene_snapshot(scene, bytes, *size, &failure));
  return bytes;
}

static void assert_same(const thrum_scene *scene, const uint8_t *bytes, size_t size,
                        const char *what, int64_t n) {
  size_t now = 0;
  uint8_t *others = snapshot_of(scene, &now);
  if (now != size || memcmp(bytes, others, size) != 0)
    fail_msg("%s: allocation %lld changed the scene", what, (long long)n);
  free(others);
}

/* Makes a call with each of its allocations failing in turn, and then without. */
static void insist(const fixture *f, thrum_scene *scene, const attempt *a) {
  size_t size = 0;
  uint8_t *before = snapshot_of(scene, &size);
  for (int64_t n = 1;; n++) {
    fail_call(n);
    const thrum_status status = a->call(f, scene);
    if (!has_failed()) {
      if (status < 0)
        fail_msg("%s: %s", a->what, failure.message);
      break;
    }
    if (status != THRUM_OUT_OF_MEMORY)
      fail_msg("%s: allocation %lld ends with %d", a->what, (long long)n, (int)status);
    assert_same(scene, before, size, a->what, n);
  }
  free(before);
}

static void a_call_without_memory_leaves_the_scene_as_it_was(void **context) {
  const fixture *f = *context;
  thrum_scene *scenes[2];
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_create(0.002, &scenes[n], &failure));

  // one is built with failures, after some steps of what is there, the other without
  for (int n = 0; n < ATTEMPTS; n++) {
    insist(f, scenes[0], &attempts[n]);
    MUST(attempts[n].call(f, scenes[1]));
    for (int k = 0; k < 2; k++) {
      MUST(thrum_scene_step(scenes[k], &failure));
      MUST(thrum_scene_step(scenes[k], &failure));
    }
  }

  // and both go on with the same bits
  size_t size = 0;
  for (int k = 0; k < 20; k++)
    for (int n = 0; n < 2; n++)
      MUST(thrum_scene_step(scenes[n], &failure));
  uint8_t *without = snapshot_of(scenes[1], &size);
  assert_same(scenes[0], without, size, "all of it", 0);
  free(without);
  for (int n = 0; n < 2; n++)
    thrum_scene_destroy(scenes[n]);
}

static void a_level_of_detail_that_finds_no_memory_is_not_changed(void **context) {
  const fixture *f = *context;
  static const attempt changes[] = {{"a level of detail", watch}, {"its change", update}};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  for (int n = 0; n < 5; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &f->held_bar.model;
    def.position[0] = 10;
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }
  for (int n = 0; n < 2; n++)
    insist(f, scene, &changes[n]);

  // the last call was carried out
  thrum_scene_detail_report report;
  MUST(thrum_scene_body_detail(scene, 4, &report, &failure));
  assert_int_equal(report.reduced, 1);
  thrum_scene_destroy(scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_call_without_memory_leaves_the_scene_as_it_was),
      cmocka_unit_test(a_level_of_detail_that_finds_no_memory_is_not_changed),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
