/* Tests of condensed bodies in scenes: they step with the bits of their model alone, are shown with
 * their slaves, scale exactly, and go on from a snapshot with the same bits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "tests/support/scene_call.h"
#include "thrum/external_load.h"

enum { RANK = 8, MASTERS = 3, VERTICES = 9, STEPS = 200 };

static void make_model(random_model *m) {
  random_model_make(m, 11, RANK, 3, 100, 1);
  random_model_add_mesh(m, 12, VERTICES);
  random_model_pack(m);
}

static thrum_scene_body_def def_of(const random_model *m) {
  static const double q[RANK] = {0.2, -0.1, 0.1}, p[RANK] = {1, 0.5, -0.5};
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &m->model;
  def.condense = MASTERS;
  def.state.integrator = THRUM_INTEGRATOR_ENERGY;
  def.q = q;
  def.p = p;
  return def;
}

/* A scene of one body at dt, with gravity. */
static thrum_scene *scene_of(const thrum_scene_body_def *def, double dt, const double gravity[3]) {
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(dt, &scene, &failure));
  if (gravity)
    MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  MUST(thrum_scene_add_body(scene, def, NULL, &failure));
  return scene;
}

static void steps(thrum_scene *scene, int count) {
  for (int k = 0; k < count; k++)
    MUST(thrum_scene_step(scene, &failure));
}

static void a_condensed_body_has_the_bits_of_its_model_alone_and_shows_its_slaves(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_scene_body_def def = def_of(&m);
  thrum_scene *scene = scene_of(&def, 0.003, NULL);
  steps(scene, STEPS);

  // the same by the library's own calls
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  thrum_state_def state_def = def.state;
  state_def.dt = 0.003;
  thrum_state *state = state_make(stepped, &state_def);
  state_put(stepped, state, def.q, def.p);
  state_steps(stepped, state, STEPS);

  // its coordinates, all of them
  double x[MASTERS], v[MASTERS], shape[RANK], velocity[RANK], q[RANK], p[RANK];
  MUST(thrum_state_get(stepped, state, x, v, &failure));
  thrum_condensed_shape(stepped, x, NULL, shape);
  thrum_condensed_velocity(stepped, x, v, velocity);
  MUST(thrum_scene_body_get(scene, 0, q, p, &failure));
  assert_memory_equal(q, shape, sizeof q);
  assert_memory_equal(p, velocity, sizeof p);

  // a vertex is where the shape model has it
  double u[3], position[3];
  MUST(thrum_displacement(&m.model, shape, 4, 1, u, &failure));
  MUST(thrum_scene_body_vertex(scene, 0, 4, position, NULL, &failure));
  for (int axis = 0; axis < 3; axis++)
    assert_true(fabs(position[axis] - m.vertices[12 + axis] - u[axis]) <= 1e-12);
  thrum_scene_body_info info;
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  assert_int_equal(info.rank, MASTERS);
  assert_int_equal(info.shown, RANK);
  assert_int_equal(info.condensed, 1);

  state_free(state);
  free(memory);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

static void a_scaled_body_is_the_body_scaled(void **context) {
  (void)context;
  random_model m;
  make_model(&m);

  // lengths by 2, the same frequencies: gravity twice as large makes all displacements twice as
  // large
  const double once[3] = {1, 2, -3}, twice[3] = {2, 4, -6};
  thrum_scene_body_def def = def_of(&m);
  def.q = def.p = NULL;
  thrum_scene *small = scene_of(&def, 0.003, once);
  def.scale = 2;
  def.stiffness = 4;
  thrum_scene *large = scene_of(&def, 0.003, twice);
  steps(small, STEPS);
  steps(large, STEPS);

  // both are shown by the same coordinates of the model as it was given, slaves included
  double a[RANK], b[RANK], slaves = 0;
  MUST(thrum_scene_body_shape(small, 0, a, &failure));
  MUST(thrum_scene_body_shape(large, 0, b, &failure));
  for (int i = 0; i < RANK; i++) {
    assert_true(fabs(a[i] - b[i]) <= 1e-9 * (1e-3 + fabs(a[i])));
    slaves += i < MASTERS ? 0 : fabs(a[i]);
  }
  assert_true(slaves > 1e-6);
  thrum_scene_destroy(small);
  thrum_scene_destroy(large);
  random_model_free(&m);
}

static void a_constant_load_ends_where_the_energy_and_its_potential_are_least(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const double gravity[3] = {3, -2, 1};
  thrum_scene_body_def def = def_of(&m);
  def.q = def.p = NULL;
  def.state.damping_alpha = 6;
  thrum_scene *scene = scene_of(&def, 0.003, gravity);
  steps(scene, 4000);

  // R of the condensed model is the force on the masters, the slaves' part of the load included
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  double q[RANK], f[RANK] = {0}, reduced[MASTERS], force[MASTERS];
  double *work = random_alloc((int64_t)thrum_work_count(stepped), sizeof(double));
  MUST(thrum_scene_body_get(scene, 0, q, NULL, &failure));
  MUST(thrum_load_add_gravity(&m.model, gravity, f, &failure));
  thrum_condensed_load(stepped, q, f, reduced);
  thrum_internal_force(stepped, q, force, work);
  for (int i = 0; i < MASTERS; i++)
    assert_true(fabs(force[i] - reduced[i]) <= 1e-6 * (1 + fabs(reduced[i])));

  // and the slaves have their static answer
  double shape[RANK];
  thrum_condensed_shape(stepped, q, f, shape);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(shape[i] - q[i]) <= 1e-12);

  free(work);
  free(memory);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

/* 50 steps, a snapshot, 50 steps, back, and the same 50 again. */
static void go_back(thrum_scene *scene) {
  steps(scene, 50);
  const size_t size = thrum_scene_snapshot_size(scene);
  void *kept = malloc(size);
  assert_non_null(kept);
  MUST(thrum_scene_snapshot(scene, kept, size, &failure));

  // steps on, back to the snapshot, and on again
  double first[RANK], again[RANK], at[RANK], restored[RANK];
  MUST(thrum_scene_body_get(scene, 0, at, NULL, &failure));
  steps(scene, 50);
  MUST(thrum_scene_body_get(scene, 0, first, NULL, &failure));

  // a step at once, as reading the shape first would hide what it is read with
  MUST(thrum_scene_restore(scene, kept, size, &failure));
  steps(scene, 50);
  MUST(thrum_scene_body_get(scene, 0, again, NULL, &failure));
  MUST(thrum_scene_restore(scene, kept, size, &failure));
  MUST(thrum_scene_body_get(scene, 0, restored, NULL, &failure));
  assert_memory_equal(restored, at, sizeof at);
  assert_memory_equal(again, first, sizeof first);
  free(kept);
}

static void a_snapshot_goes_on_with_the_same_bits(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const double gravity[3] = {3, -2, 1};
  const thrum_scene_body_def def = def_of(&m);
  thrum_scene *scene = scene_of(&def, 0.003, gravity);
  go_back(scene);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

static void a_snapshot_under_a_pull_and_a_changing_load_goes_on_with_the_same_bits(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_scene_body_def def = def_of(&m);
  thrum_scene *scene = scene_of(&def, 0.003, NULL);

  // the slaves answer to a load that is another one in each step, where the pull reads the shape
  const double target[3] = {1, 0, 1};
  const thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_FORCE,
      .vector = {5, -3, 4},
      .course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 3}};
  MUST(thrum_scene_add_load(scene, 0, &load, &failure));
  MUST(thrum_scene_pull_start(scene, 0, 4, target, 20, 0.1, NULL, &failure));
  go_back(scene);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

static void the_number_of_masters_can_change_without_a_jump_of_the_shape(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_scene_body_def def = def_of(&m);
  thrum_scene *scene = scene_of(&def, 0.003, NULL);
  steps(scene, 50);

  // coordinates that become masters go on from where they followed
  double before[RANK], after[RANK];
  MUST(thrum_scene_body_get(scene, 0, before, NULL, &failure));
  MUST(thrum_scene_set_rank(scene, 0, MASTERS + 2, &failure));
  MUST(thrum_scene_body_get(scene, 0, after, NULL, &failure));
  for (int i = 0; i < MASTERS + 2; i++)
    assert_true(after[i] == before[i]);
  thrum_scene_body_info info;
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  assert_int_equal(info.rank, MASTERS + 2);
  assert_int_equal(info.condensed, 1);
  steps(scene, 50);

  // the rank of the model steps all coordinates
  MUST(thrum_scene_set_rank(scene, 0, RANK, &failure));
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  assert_true(info.rank == RANK && info.condensed == 0);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

static void a_body_is_condensed_and_stepped_whole_again_between_two_steps(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_scene_body_def def = def_of(&m);
  def.condense = 0;
  def.state.damping_alpha = 0.5;
  const double gravity[3] = {0.3, -0.2, 0.1};
  thrum_scene *scene = scene_of(&def, 0.003, gravity);
  steps(scene, 50);

  // what begins to follow is where the masters and the load put it; the masters stay
  double whole[RANK], condensed[RANK], back[RANK], at[MASTERS], rest[RANK], f[RANK] = {0};
  thrum_scene_body_info before, after;
  MUST(thrum_scene_body(scene, 0, &before, &failure));
  MUST(thrum_scene_body_get(scene, 0, whole, NULL, &failure));
  MUST(thrum_scene_set_condensed(scene, 0, MASTERS, &failure));
  MUST(thrum_scene_body_get(scene, 0, condensed, NULL, &failure));
  MUST(thrum_scene_body(scene, 0, &after, &failure));
  assert_int_equal(after.rank, MASTERS);
  assert_int_equal(after.condensed, 1);
  memcpy(at, condensed, sizeof at);
  assert_memory_equal(at, whole, sizeof at);
  MUST(thrum_load_add_gravity(&m.model, gravity, f, &failure));
  thrum_condensed_shape(after.stepped, at, f, rest);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(condensed[i] - rest[i]) <= 1e-13);

  // losses go on being counted, and the way back has no jump
  steps(scene, 50);
  MUST(thrum_scene_body_get(scene, 0, condensed, NULL, &failure));
  MUST(thrum_scene_set_condensed(scene, 0, 0, &failure));
  MUST(thrum_scene_body_get(scene, 0, back, NULL, &failure));
  assert_memory_equal(back, condensed, sizeof back);
  steps(scene, 50);
  MUST(thrum_scene_body(scene, 0, &after, &failure));
  assert_int_equal(after.rank, RANK);
  assert_true(after.dissipated > before.dissipated && before.dissipated > 0);

  // there are no such numbers of masters, and the body stays as it was
  assert_int_equal(thrum_scene_set_condensed(scene, 0, RANK, &failure), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_scene_set_condensed(scene, 0, -1, &failure), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_scene_set_condensed(scene, 1, 2, &failure), THRUM_INVALID_ARGUMENT);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

/* A load that is not finite fails the step, and the slaves do not keep their answer to it. */
static void a_load_beyond_numbers_leaves_the_shape_as_it_was(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_scene_body_def def = def_of(&m);
  thrum_scene *scene = scene_of(&def, 0.003, NULL);
  steps(scene, 3);
  double before[RANK], after[RANK];
  MUST(thrum_scene_body_shape(scene, 0, before, &failure));

  // gravity times the mass of a mode
  const double gravity[3] = {1e308, 1e308, -1e308};
  MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  assert_int_equal(thrum_scene_step(scene, &failure), THRUM_BAD_VALUE);
  MUST(thrum_scene_body_shape(scene, 0, after, &failure));
  assert_memory_equal(after, before, sizeof before);

  thrum_scene_destroy(scene);
  random_model_free(&m);
}

static void what_cannot_be_condensed_is_refused(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.003, &scene, &failure));

  // each def asks for something that does not go together
  thrum_scene_body_def def = def_of(&m);
  def.rank = 5;
  assert_int_equal(thrum_scene_add_body(scene, &def, NULL, &failure), THRUM_INVALID_ARGUMENT);
  def.rank = 0;
  def.condense = RANK;
  assert_int_equal(thrum_scene_add_body(scene, &def, NULL, &failure), THRUM_INVALID_ARGUMENT);
  def.condense = -1;
  assert_int_equal(thrum_scene_add_body(scene, &def, NULL, &failure), THRUM_BAD_VALUE);
  def.condense = MASTERS;
  def.start_mode = MASTERS + 1;
  assert_int_equal(thrum_scene_add_body(scene, &def, NULL, &failure), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_scene_body_count(scene), 0);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

/* A model whose slaves answer to loads alone, as touch modes do: the polynomial of its masters, and
 * a map of zeros. */
typedef struct follower_model {
  random_model m;
  thrum_model model;
  void *locked;
  double map[(RANK - MASTERS) * MASTERS * (MASTERS + 1) / 2];
} follower_model;

static const thrum_model *make_followers(follower_model *f) {
  const thrum_model *low = NULL;
  size_t size = 0;
  make_model(&f->m);
  MUST(thrum_model_lock_size(&f->m.model, MASTERS, &size, &failure));
  f->locked = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(f->locked);
  MUST(thrum_model_lock(f->locked, size, &f->m.model, MASTERS, &low, &failure));

  // its polynomial is what is stepped; the others follow none of its coordinates
  memset(f->map, 0, sizeof f->map);
  f->model = f->m.model;
  f->model.slave_map = f->map;
  f->model.slave_count = RANK - MASTERS;
  f->model.slave_pairs = MASTERS * (MASTERS + 1) / 2;
  f->model.condensed_c3 = low->c3;
  f->model.condensed_c3_count = low->c3_count;
  f->model.condensed_c4 = low->c4;
  f->model.condensed_c4_count = low->c4_count;
  f->model.c3 = f->model.c4 = NULL;
  f->model.c3_count = f->model.c4_count = 0;
  return low;
}

static void free_followers(follower_model *f) {
  free(f->locked);
  random_model_free(&f->m);
}

static void slaves_that_answer_to_loads_alone_leave_the_masters_their_bits(void **context) {
  (void)context;
  follower_model f;
  const thrum_model *low = make_followers(&f);
  const double gravity[3] = {3, -2, 1};
  thrum_scene_body_def def = def_of(&f.m);
  def.model = &f.model;
  def.condense = 0;
  thrum_scene *with = scene_of(&def, 0.003, gravity);
  def.model = low;
  thrum_scene *without = scene_of(&def, 0.003, gravity);
  steps(with, STEPS);
  steps(without, STEPS);

  // what is stepped has the same bits, and what follows is at rest under its load
  double q[RANK], p[RANK], x[RANK], v[RANK], load[RANK] = {0};
  MUST(thrum_scene_body_get(with, 0, q, p, &failure));
  MUST(thrum_scene_body_get(without, 0, x, v, &failure));
  assert_memory_equal(q, x, MASTERS * sizeof *q);
  assert_memory_equal(p, v, MASTERS * sizeof *p);
  MUST(thrum_load_add_gravity(&f.m.model, gravity, load, &failure));
  for (int h = MASTERS; h < RANK; h++) {
    const double rest = load[h] / f.m.model.omega2[h];
    assert_true(fabs(q[h] - rest) <= 1e-14 * fabs(rest) && p[h] == 0);
  }

  thrum_scene_destroy(with);
  thrum_scene_destroy(without);
  free_followers(&f);
}

enum { PULLED = 4 };

/* Where the target of the pull is, from the vertex at rest. */
static const double away[3] = {2e-4, -1e-4, 3e-4};

static thrum_scene *pull_followers(const follower_model *f, double damping, double stiffness,
                                   double target[3]) {
  thrum_scene_body_def def = def_of(&f->m);
  def.model = &f->model;
  def.condense = 0;
  def.q = def.p = NULL;
  def.state.damping_alpha = damping;
  thrum_scene *scene = scene_of(&def, 0.003, NULL);
  for (int axis = 0; axis < 3; axis++)
    target[axis] = f->m.vertices[3 * PULLED + axis] + away[axis];
  MUST(thrum_scene_pull_start(scene, 0, PULLED, target, stiffness, 0, NULL, &failure));
  return scene;
}

/* Under a spring the body shows the answer of all its coordinates to the spring's force, and that
 * force follows from the length that the spring still has. Both hold whether the spring is softer
 * or stiffer than the body. */
static void what_follows_answers_a_pull_at_rest(void **context) {
  (void)context;
  follower_model f;
  make_followers(&f);
  for (double stiffness = 0.1; stiffness < 1e5; stiffness *= 100) {
    double target[3], at[3], force[3];
    thrum_scene *scene = pull_followers(&f, 6, stiffness, target);
    steps(scene, 4000);
    MUST(thrum_scene_pull_get(scene, 0, at, force, &failure));

    // u = sum over all coordinates of U (U^T f) / w^2, which a small pull obeys
    const double *rows = f.m.model.basis + 3 * PULLED * RANK;
    double u[3] = {0}, size = 0, strength = 0;
    for (int i = 0; i < RANK; i++) {
      double answer = 0;
      for (int axis = 0; axis < 3; axis++)
        answer += rows[axis * RANK + i] * force[axis] / f.m.model.omega2[i];
      for (int axis = 0; axis < 3; axis++)
        u[axis] += rows[axis * RANK + i] * answer;
    }
    for (int axis = 0; axis < 3; axis++) {
      size += fabs(u[axis]);
      strength += fabs(force[axis]);
    }
    assert_true(size > 0 && strength > 0);
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(at[axis] - f.m.vertices[3 * PULLED + axis] - u[axis]) <= 0.01 * size);
      assert_true(fabs(stiffness * (target[axis] - at[axis]) - force[axis]) <= 0.01 * strength);
    }
    thrum_scene_destroy(scene);
  }
  free_followers(&f);
}

/* The work of a pull on the masters becomes their energy; its work on what follows comes back. */
static void the_energy_of_a_pull_is_accounted_for(void **context) {
  (void)context;
  follower_model f;
  double target[3];
  make_followers(&f);
  thrum_scene *scene = pull_followers(&f, 0, 1e4, target);
  for (int k = 0; k < STEPS; k++) {
    thrum_scene_energies now;
    thrum_scene_body_info info;
    MUST(thrum_scene_step(scene, &failure));
    MUST(thrum_scene_body_energies(scene, 0, &now, &failure));
    MUST(thrum_scene_body(scene, 0, &info, &failure));
    const double energy = now.kinetic + now.potential;
    assert_true(fabs(energy - info.contact.pulled) <= 1e-9 * (energy + 1e-12));
  }

  // let go, the body keeps it, and nothing follows any more
  double q[RANK];
  thrum_scene_energies before, after;
  MUST(thrum_scene_pull_end(scene, 0, &failure));
  MUST(thrum_scene_body_energies(scene, 0, &before, &failure));
  steps(scene, STEPS);
  MUST(thrum_scene_body_energies(scene, 0, &after, &failure));
  MUST(thrum_scene_body_get(scene, 0, q, NULL, &failure));
  assert_true(fabs(after.kinetic + after.potential - before.kinetic - before.potential) <=
              1e-9 * (before.kinetic + before.potential));
  for (int h = MASTERS; h < RANK; h++)
    assert_true(q[h] == 0);
  thrum_scene_destroy(scene);
  free_followers(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_condensed_body_has_the_bits_of_its_model_alone_and_shows_its_slaves),
      cmocka_unit_test(a_scaled_body_is_the_body_scaled),
      cmocka_unit_test(a_constant_load_ends_where_the_energy_and_its_potential_are_least),

      // snapshots, and changes between two steps
      cmocka_unit_test(a_snapshot_goes_on_with_the_same_bits),
      cmocka_unit_test(a_snapshot_under_a_pull_and_a_changing_load_goes_on_with_the_same_bits),
      cmocka_unit_test(the_number_of_masters_can_change_without_a_jump_of_the_shape),
      cmocka_unit_test(a_body_is_condensed_and_stepped_whole_again_between_two_steps),

      // refusals
      cmocka_unit_test(a_load_beyond_numbers_leaves_the_shape_as_it_was),
      cmocka_unit_test(what_cannot_be_condensed_is_refused),

      // slaves that answer to loads and pulls alone
      cmocka_unit_test(slaves_that_answer_to_loads_alone_leave_the_masters_their_bits),
      cmocka_unit_test(what_follows_answers_a_pull_at_rest),
      cmocka_unit_test(the_energy_of_a_pull_is_accounted_for),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
