/* Stepping allocates nothing: every call of the C library's allocator from the library or this file
 * is routed through a counter (link option --wrap, see tests/CMakeLists.txt).
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/points_support.h"
#include "tests/support/scene_wind_def.h"

#include <unistd.h>

#include "io/npz.h"
#include "thrum/scene.h"

static int64_t calls;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
int __real_posix_memalign(void **memory, size_t alignment, size_t size);
void __real_free(void *memory);

void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
int __wrap_posix_memalign(void **memory, size_t alignment, size_t size);
void __wrap_free(void *memory);

void *__wrap_malloc(size_t size) {
  calls++;
  return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
  calls++;
  return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size) {
  calls++;
  return __real_realloc(memory, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size) {
  calls++;
  return __real_aligned_alloc(alignment, size);
}

int __wrap_posix_memalign(void **memory, size_t alignment, size_t size) {
  calls++;
  return __real_posix_memalign(memory, alignment, size);
}

void __wrap_free(void *memory) {
  calls++;
  __real_free(memory);
}

enum { RANK = 6 };

/* Makes every call that a running simulation makes, failures and fallbacks included. */
static void use(const thrum_model *model, thrum_state *state) {
  static const double q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
  static const double huge[RANK] = {1e250};
  double q_now[RANK], p_now[RANK], f[RANK];
  thrum_energies energies;
  thrum_error error;

  thrum_state_set(model, state, q, q, &error);
  random_state random = {1};

  // every tenth load is beyond what a step can follow
  for (int k = 0; k < 100; k++) {
    random_vector(&random, RANK, 5.0, f);
    thrum_state_set_force(model, state, k % 10 == 9 ? huge : f, &error);
    thrum_step(model, state, &error);
    thrum_state_get(model, state, q_now, p_now, &error);
    thrum_state_energies(model, state, &energies, &error);
    thrum_state_report_get(state);
    if (k % 20 == 0)
      thrum_state_set_dt(model, state, 0.05 + 0.01 * k, &error);
  }
}

static void no_call_of_a_running_simulation_allocates(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      thrum_state_def def = imexv_def();
      def.integrator = (thrum_integrator)integrator;
      def.damping_form = (thrum_damping_form)form;
      def.damping_beta = 0.001;
      def.dt = 0.1;

      thrum_state *state = state_make(&m.model, &def);

      // the counter stands still while the state steps
      const int64_t before = calls;
      use(&m.model, state);
      assert_int_equal(calls, before);
      assert_true(thrum_state_report_get(state).steps > 0);

      state_free(state);
    }
  random_model_free(&m);
}

static void plastic_flow_allocates_nothing(void **context) {
  (void)context;
  both made;
  points_make(&made, 21, RANK, 11, 0.5);
  points_obey(&made, "corotational");
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.1;
  def.plastic.yield = 0.05;
  thrum_state *state = state_make(&made.points, &def);
  const int64_t before = calls;
  use(&made.points, state);
  assert_int_equal(calls, before);
  assert_true(thrum_state_report_get(state).plastic_work > 0);
  state_free(state);
  both_free(&made);
}

static void planning_and_laying_out_a_state_allocate_nothing(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  const thrum_state_def def = imexv_def();
  size_t size = 0;
  thrum_state *state = NULL;

  // the size is computed without memory
  int64_t before = calls;
  assert_int_equal(thrum_state_size(&m.model, &def, &size, NULL), THRUM_OK);
  assert_int_equal(calls, before);

  // only the test itself allocates
  void *memory = aligned_alloc(64, size);
  assert_int_equal(calls, before + 1);

  // and the state is laid out in that memory alone
  before = calls;
  assert_int_equal(thrum_state_init(memory, size, &m.model, &def, &state, NULL), THRUM_OK);
  assert_int_equal(calls, before);

  free(memory);
  random_model_free(&m);
}

static void stepping_a_batch_and_showing_it_allocate_nothing(void **context) {
  (void)context;
  enum { STATES = 11, VERTICES = 20 };
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 60.0, 0.5);
  random_model_add_mesh(&m, 5, VERTICES);
  thrum_state_def def = imexv_def();
  def.dt = 0.03;

  // more states than one group holds, all in motion
  thrum_state *states[STATES];
  const double p[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
  for (int n = 0; n < STATES; n++) {
    states[n] = state_make(&m.model, &def);
    state_put(&m.model, states[n], NULL, p);
  }

  // all memory is planned before the first step
  const int32_t triangle[3] = {1, 2, 3};
  const thrum_surface_def shown = {.triangles = triangle, .triangle_count = 1};
  size_t batch_bytes = 0, surface_bytes = 0;
  const thrum_surface *surface = NULL;
  assert_int_equal(thrum_batch_size(&m.model, &batch_bytes, NULL), THRUM_OK);
  assert_int_equal(thrum_surface_size(&m.model, &shown, &surface_bytes, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, batch_bytes), *memory = aligned_alloc(64, surface_bytes);

  double q[RANK];
  float out[6 * VERTICES];

  // laying out, stepping and computing what is shown take none
  const int64_t before = calls;
  assert_int_equal(thrum_surface_init(memory, surface_bytes, &m.model, &shown, &surface, NULL),
                   THRUM_OK);
  for (int k = 0; k < 100; k++) {
    assert_true(thrum_batch_step(&m.model, states, STATES, NULL, workspace, batch_bytes, NULL) >=
                0);
    state_read(&m.model, states[k % STATES], q, NULL);
    assert_int_equal(
        thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, VERTICES, out, 6, NULL),
        THRUM_OK);
    assert_int_equal(thrum_surface_normals(surface, out, 6, out + 3, 6, NULL), THRUM_OK);
  }

  assert_int_equal(calls, before);

  for (int n = 0; n < STATES; n++)
    state_free(states[n]);
  free(workspace);
  free(memory);
  random_model_free(&m);
}

static void stepping_a_scene_allocates_nothing(void **context) {
  (void)context;
  enum { VERTICES = 20 };
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 60.0, 0.5);
  random_model_add_mesh(&m, 5, VERTICES);

  // a scene in which everything acts: gravity, wind, an obstacle and a base motion
  const int32_t triangle[3] = {1, 2, 3};
  const double down[3] = {0, 0, -9.81}, wind[3] = {3, 0, 0};
  const thrum_load sway = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 2};
  const thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene *scene = NULL;
  assert_int_equal(thrum_scene_create(0.01, &scene, NULL), THRUM_OK);
  assert_int_equal(thrum_scene_set_gravity(scene, down, NULL), THRUM_OK);
  assert_int_equal(
      thrum_scene_set_wind(scene, (thrum_scene_wind_def[1]){wind_of(wind, 1.2, 1)}, NULL),
      THRUM_OK);
  assert_int_equal(thrum_scene_add_obstacle(scene, &floor, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_scene_add_base_motion(scene, wind, &sway, NULL), THRUM_OK);

  // bodies with and without vertices that touch, one of them scaled
  for (int n = 0; n < 4; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &m.model;
    def.scale = n == 3 ? 2 : 1;
    def.touch = def.triangles = triangle;
    def.touch_count = n == 1 ? 3 : 0;
    def.triangle_count = 1;
    assert_int_equal(thrum_scene_add_body(scene, &def, NULL, NULL), THRUM_OK);
  }

  // a probe and a pull
  assert_int_equal(thrum_scene_add_probe(scene, NULL, 0, NULL, 0, NULL), THRUM_OK);
  assert_int_equal(thrum_scene_pull_start(scene, 2, 5, wind, 10, -1, NULL, NULL), THRUM_OK);

  // steps and readings take no memory
  thrum_scene_energies energies;
  double x[3], v[3];
  const int64_t before = calls;
  for (int k = 0; k < 100; k++) {
    assert_true(thrum_scene_step(scene, NULL) >= 0);
    assert_int_equal(thrum_scene_probe_get(scene, 0, x, v, NULL), THRUM_OK);
    assert_int_equal(thrum_scene_body_energies(scene, k % 4, &energies, NULL), THRUM_OK);
  }

  assert_int_equal(calls, before);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

/* The counter sees the library: loading a model is documented to take a block. */
static void the_counter_sees_an_allocation_inside_the_library(void **context) {
  (void)context;
  char path[] = "/tmp/thrum_allocation_XXXXXX";
  const int file = mkstemp(path);
  assert_true(file >= 0);
  close(file);

  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  assert_int_equal(thrum_model_save(path, &m.model, NULL), THRUM_OK);

  // both loading and freeing are counted
  const thrum_model *loaded = NULL;
  int64_t before = calls;
  assert_int_equal(thrum_model_load(path, &loaded, NULL), THRUM_OK);
  assert_true(calls > before);

  before = calls;
  thrum_model_destroy(loaded);
  assert_true(calls > before);

  unlink(path);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_call_of_a_running_simulation_allocates),
      cmocka_unit_test(plastic_flow_allocates_nothing),
      cmocka_unit_test(planning_and_laying_out_a_state_allocate_nothing),
      cmocka_unit_test(stepping_a_batch_and_showing_it_allocate_nothing),
      cmocka_unit_test(stepping_a_scene_allocates_nothing),
      cmocka_unit_test(the_counter_sees_an_allocation_inside_the_library),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
