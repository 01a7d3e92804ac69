/* Tests of the scene: bodies that share a scene step with the same bits as each of them alone, a
 * rotation of a body together with its world changes nothing, and only what is asked for is built.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "scene/scene_private.h"
#include "tests/support/scene_call.h"
#include "thrum/external_load.h"

enum { RANK = 8, VERTICES = 9, STEPS = 200 };

typedef struct fixture {
  random_model m;
  thrum_scene *scene;
} fixture;

static void make_model(random_model *m) {
  random_model_make(m, 11, RANK, 3, 400, 1);
  random_model_add_mesh(m, 12, VERTICES);
  random_model_pack(m);
}

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  make_model(&f->m);
  *context = f;
  return thrum_scene_create(0.003, &f->scene, &failure) < 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  random_model_free(&f->m);
  free(f);
  return 0;
}

static int32_t add(fixture *f, const thrum_scene_body_def *def) {
  int32_t body = -1;
  MUST(thrum_scene_add_body(f->scene, def, &body, &failure));
  return body;
}

static thrum_scene_body_def def_of(const fixture *f, thrum_integrator integrator) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->m.model;
  def.state.integrator = integrator;
  return def;
}

static void steps(thrum_scene *scene, int count) {
  for (int k = 0; k < count; k++)
    MUST(thrum_scene_step(scene, &failure));
}

/* Takes the same steps by the library's own calls, under gravity and one force over time. */
static void step_alone(const fixture *f, const thrum_state_def *def, const thrum_load *course,
                       const double gravity[3], const double force[3], const int32_t *vertex,
                       double *q, double *p) {
  const thrum_model *model = &f->m.model;
  const thrum_load loads[2] = {{.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}, *course};
  double directions[2 * RANK] = {0}, sum[RANK];
  assert_int_equal(thrum_load_add_gravity(model, gravity, directions, NULL), THRUM_OK);
  assert_int_equal(thrum_load_add_shared(model, vertex, 1, force, directions + RANK, NULL),
                   THRUM_OK);
  thrum_state *state = state_make(model, def);
  for (int k = 0; k < STEPS; k++) {
    thrum_load_sum(loads, directions, 2, RANK, k, def->dt, sum);
    state_push(model, state, sum);
    state_steps(model, state, 1);
  }
  state_read(model, state, q, p);
  state_free(state);
}

/* The states of a scene keep what persists alone, and all work in the scratch of the largest. */
static void bodies_share_scratch(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_ENERGY);
  size_t own = 0;
  assert_int_equal(thrum_state_size(&f->m.model, &def.state, &own, NULL), THRUM_OK);
  def.rank = RANK / 2;
  add(f, &def);
  def.rank = 0;
  add(f, &def);

  for (int n = 0; n < 2; n++)
    assert_true(2 * thrum_state_bytes(f->scene->bodies[n]->state) < own);
  steps(f->scene, 3);

  // a body that starts again borrows it too, and so does one of another integrator
  MUST(thrum_scene_reset(f->scene, &failure));
  MUST(thrum_scene_set_integrator(f->scene, 0, THRUM_INTEGRATOR_IMEXV, &failure));
  steps(f->scene, 3);
  assert_true(2 * thrum_state_bytes(f->scene->bodies[0]->state) < own);
}

static void bodies_side_by_side_have_the_bits_of_each_alone(void **context) {
  fixture *f = *context;

  // the integrators of the bodies, and the loads that they share
  static const thrum_integrator integrators[] = {THRUM_INTEGRATOR_IMEXV, THRUM_INTEGRATOR_NEWMARK,
                                                 THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_IMEXV};
  const double gravity[3] = {0.3, 0, -9.81}, force[3] = {1, -2, 0.5};
  const thrum_load course = {
      .shape = THRUM_LOAD_SINE, .from = 0.01, .until = INFINITY, .frequency = 3};
  const int32_t vertex = 5;

  // bodies of different integrators under the same gravity and the same force
  MUST(thrum_scene_set_gravity(f->scene, gravity, &failure));
  for (int32_t n = 0; n < 4; n++) {
    const thrum_scene_body_def def = def_of(f, integrators[n]);
    assert_int_equal(add(f, &def), n);
    const thrum_scene_load_def load = {.cookie = sizeof load,
                                       .kind = THRUM_SCENE_FORCE,
                                       .vector = {force[0], force[1], force[2]},
                                       .vertices = &vertex,
                                       .count = 1,
                                       .course = course};
    MUST(thrum_scene_add_load(f->scene, n, &load, &failure));
  }

  // each body has the bits of a state that is stepped without a scene
  steps(f->scene, STEPS);
  for (int32_t n = 0; n < 4; n++) {
    double q[RANK], p[RANK], q_alone[RANK], p_alone[RANK];
    thrum_state_def def = thrum_default_state_def();
    def.integrator = integrators[n];
    step_alone(f, &def, &course, gravity, force, &vertex, q_alone, p_alone);
    MUST(thrum_scene_body_get(f->scene, n, q, p, &failure));
    assert_memory_equal(q, q_alone, sizeof q);
    assert_memory_equal(p, p_alone, sizeof p);
  }
  assert_true(fabs(thrum_scene_time(f->scene) - STEPS * 0.003) < 1e-12);
}

/* Rotates a vector by a quaternion: v + 2 w (u x v) + 2 u x (u x v). */
static void turn(const double rotation[4], const double v[3], double out[3]) {
  const double *u = rotation + 1, w = rotation[0];
  const double c[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                       u[0] * v[1] - u[1] * v[0]};
  const double d[3] = {u[1] * c[2] - u[2] * c[1], u[2] * c[0] - u[0] * c[2],
                       u[0] * c[1] - u[1] * c[0]};
  for (int axis = 0; axis < 3; axis++)
    out[axis] = v[axis] + 2 * w * c[axis] + 2 * d[axis];
}

/* A load that is read from one body and added to another has the same effect, bit for bit. */
static void a_reduced_load_is_the_load(void **context) {
  // two equal bodies, of which only the first has the load
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  const int32_t first = add(f, &def), second = add(f, &def), vertex = 5;
  thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_FORCE,
      .vector = {1, -2, 0.5},
      .vertices = &vertex,
      .count = 1,
      .course = {.shape = THRUM_LOAD_SINE, .from = 0.01, .until = INFINITY, .frequency = 3}};
  MUST(thrum_scene_add_load(f->scene, first, &load, &failure));

  // the load is read back in reduced coordinates, and only under an index that exists
  assert_int_equal(thrum_scene_load_count(f->scene, first), 1);
  assert_true(thrum_scene_load_get(f->scene, first, 1, &load, &failure) < 0);
  assert_true(thrum_scene_load_get(f->scene, first, -1, &load, &failure) < 0);
  MUST(thrum_scene_load_get(f->scene, first, 0, &load, &failure));

  // reduced loads without numbers, or with a number that is not finite, are refused
  const double nothing[RANK] = {NAN};
  thrum_scene_load_def wrong = load;
  wrong.reduced = NULL;
  assert_true(thrum_scene_add_load(f->scene, second, &wrong, &failure) < 0);
  wrong.reduced = nothing;
  assert_true(thrum_scene_add_load(f->scene, second, &wrong, &failure) < 0);
  assert_int_equal(thrum_scene_load_count(f->scene, second), 0);

  // under the load that was read back, the second body moves as the first
  MUST(thrum_scene_add_load(f->scene, second, &load, &failure));
  steps(f->scene, STEPS);
  double q[2][RANK];
  MUST(thrum_scene_body_get(f->scene, first, q[0], NULL, &failure));
  MUST(thrum_scene_body_get(f->scene, second, q[1], NULL, &failure));
  assert_true(q[0][0] != 0);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
}

static void turning_a_body_and_its_world_changes_nothing(void **context) {
  fixture *f = *context;

  // gravity, a force whose direction the base motion shares, and a placement, all in general
  // position
  const double gravity[3] = {1, 2, -9}, force[3] = {3, 0, 1}, place[3] = {5, -7, 2};
  const double rotation[4] = {0.5, 0.5, -0.1, sqrt(1 - 0.51)};
  const thrum_load always = {.shape = THRUM_LOAD_CONSTANT, .until = 0.2};
  const thrum_load sway = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 2};
  thrum_scene *turned = NULL;
  MUST(thrum_scene_create(0.003, &turned, &failure));

  // the same scene twice, the second time with everything in it rotated and moved
  for (int k = 0; k < 2; k++) {
    thrum_scene *scene = k == 0 ? f->scene : turned;
    thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);

    // the body starts in a mode, so that its shape matters as well
    def.start_mode = 2;
    def.start_amplitude = 0.05;
    double g[3], push[3];
    memcpy(g, gravity, sizeof g);
    memcpy(push, force, sizeof push);
    if (k == 1) {
      memcpy(def.rotation, rotation, sizeof rotation);
      memcpy(def.position, place, sizeof place);
      turn(rotation, gravity, g);
      turn(rotation, force, push);
    }

    // the base motion and the force have different courses over time
    MUST(thrum_scene_set_gravity(scene, g, &failure));
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
    MUST(thrum_scene_add_base_motion(scene, push, &sway, &failure));
    const thrum_scene_load_def load = {.cookie = sizeof load,
                                       .kind = THRUM_SCENE_FORCE,
                                       .vector = {push[0], push[1], push[2]},
                                       .course = always};
    MUST(thrum_scene_add_load(scene, 0, &load, &failure));
    MUST(thrum_scene_add_probe(scene, "all", 0, NULL, 0, &failure));
    steps(scene, STEPS);
  }

  // the probe of the second scene is the rotated and moved probe of the first
  double x[3], v[3], xt[3], vt[3], x_turned[3], v_turned[3];
  MUST(thrum_scene_probe_get(f->scene, 0, x, v, &failure));
  MUST(thrum_scene_probe_get(turned, 0, xt, vt, &failure));
  turn(rotation, x, x_turned);
  turn(rotation, v, v_turned);
  for (int axis = 0; axis < 3; axis++)
    x_turned[axis] += place[axis];
  assert_true(largest_difference(xt, x_turned, 3) < 1e-7);
  assert_true(largest_difference(vt, v_turned, 3) < 1e-6);

  // the motion is large enough for the comparison to mean something
  assert_true(fabs(v[0]) + fabs(v[1]) + fabs(v[2]) > 1e-3);
  thrum_scene_destroy(turned);
}

/* A body with factors s, e, d of length, stiffness and density moves as the body of factors 1 in a
 * time that is sqrt(d s^2 / e) slower. */
static void a_scaled_body_moves_as_the_small_one_in_its_own_time(void **context) {
  fixture *f = *context;
  const double s = 2, e = 8, d = 0.5, slower = sqrt(d * s * s / e);
  thrum_scene *large = NULL;
  MUST(thrum_scene_create(0.003 * slower, &large, &failure));

  const double gravity[3] = {0, 4, -3};
  // accelerations go as length over time squared
  const double large_gravity[3] = {0, 4 * s / (slower * slower), -3 * s / (slower * slower)};
  MUST(thrum_scene_set_gravity(f->scene, gravity, &failure));
  MUST(thrum_scene_set_gravity(large, large_gravity, &failure));

  // the same start, in lengths of each body
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_ENERGY);
  def.start_mode = 1;
  def.start_amplitude = 0.1;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  def.start_amplitude *= s;
  def.scale = s;
  def.stiffness = e;
  def.density = d;
  MUST(thrum_scene_add_body(large, &def, NULL, &failure));

  // after the same number of steps the modal coordinates are equal
  steps(f->scene, STEPS);
  steps(large, STEPS);
  double q[RANK], q_large[RANK], x[3], v[3], x_large[3], v_large[3];
  MUST(thrum_scene_body_shape(f->scene, 0, q, &failure));
  MUST(thrum_scene_body_shape(large, 0, q_large, &failure));
  assert_true(largest_difference(q, q_large, RANK) < 1e-6 * (fabs(q[0]) + fabs(q[1])));

  // positions go as length, velocities as length over time
  MUST(thrum_scene_body_vertex(f->scene, 0, 4, x, v, &failure));
  MUST(thrum_scene_body_vertex(large, 0, 4, x_large, v_large, &failure));
  for (int axis = 0; axis < 3; axis++) {
    assert_true(fabs(x_large[axis] - s * x[axis]) < 1e-6);
    assert_true(fabs(v_large[axis] - s / slower * v[axis]) < 1e-5);
  }

  // energies go as stiffness times volume
  thrum_scene_energies small_e, large_e;
  MUST(thrum_scene_body_energies(f->scene, 0, &small_e, &failure));
  MUST(thrum_scene_body_energies(large, 0, &large_e, &failure));
  assert_true(fabs(large_e.total - e * s * s * s * small_e.total) <
              1e-6 * e * s * s * s * (fabs(small_e.kinetic) + fabs(small_e.gravity)));
  thrum_scene_destroy(large);
}

static void only_what_is_named_is_built(void **context) {
  fixture *f = *context;
  thrum_scene_body_info first, second, lower;

  // two bodies with the whole model, and one with half the rank
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  thrum_scene_body_def half = def;
  half.rank = RANK / 2;
  add(f, &def);
  add(f, &def);
  add(f, &half);
  MUST(thrum_scene_body(f->scene, 0, &first, &failure));
  MUST(thrum_scene_body(f->scene, 1, &second, &failure));
  MUST(thrum_scene_body(f->scene, 2, &lower, &failure));

  // bodies as they were given step the model itself; others step a copy without a mesh
  assert_ptr_equal(first.stepped, &f->m.model);
  assert_ptr_equal(second.stepped, first.stepped);
  assert_int_equal(lower.stepped->rank, RANK / 2);
  assert_null(lower.stepped->basis);
  assert_null(lower.stepped->vertices);

  // a body's own memory is its state and vectors of the rank, whatever the mesh
  size_t state = 0;
  MUST(thrum_state_size(&f->m.model, &def.state, &state, &failure));
  assert_true(first.bytes < state + (size_t)(9 * RANK) * sizeof(double) + 2000);
  assert_int_equal(first.bytes, second.bytes);
  assert_int_equal(thrum_scene_probe_count(f->scene), 0);
}

static void a_snapshot_brings_back_every_bit(void **context) {
  fixture *f = *context;

  // two bodies with different integrators, stepped away from their start
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  def.start_mode = 1;
  def.start_amplitude = 0.4;
  add(f, &def);
  def.state.integrator = THRUM_INTEGRATOR_NEWMARK;
  add(f, &def);
  steps(f->scene, 50);

  // a snapshot in the middle, and the state at the end of the same run
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = malloc(size), *again = malloc(size), *end = malloc(size);
  assert_true(kept && again && end);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  steps(f->scene, 50);
  MUST(thrum_scene_snapshot(f->scene, end, size, &failure));

  // from the restored snapshot, the same steps end in the same bits
  MUST(thrum_scene_restore(f->scene, kept, size, &failure));
  assert_true(fabs(thrum_scene_time(f->scene) - 0.15) < 1e-12);
  steps(f->scene, 50);
  MUST(thrum_scene_snapshot(f->scene, again, size, &failure));
  assert_memory_equal(again, end, size);

  // a snapshot does not fit a buffer of another size or a scene of other ranks
  assert_int_equal(thrum_scene_restore(f->scene, kept, size - 1, &failure), THRUM_BUFFER_TOO_SMALL);
  MUST(thrum_scene_set_rank(f->scene, 1, 3, &failure));
  assert_int_equal(thrum_scene_restore(f->scene, kept, size, &failure), THRUM_MODEL_MISMATCH);
  free(kept);
  free(again);
  free(end);
}

static void a_reset_starts_over_with_the_same_bits(void **context) {
  fixture *f = *context;

  // a body with an initial shape and a load that ends during the run
  double q[RANK], again[RANK];
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  def.start_mode = 3;
  def.start_amplitude = 0.2;
  add(f, &def);
  const thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_ACCELERATION,
      .vector = {1, 2, 3},
      .course = {.shape = THRUM_LOAD_SINE, .from = 0.02, .until = 0.1, .frequency = 5}};
  MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));

  // the run after the reset repeats the first run
  steps(f->scene, 60);
  MUST(thrum_scene_body_get(f->scene, 0, q, NULL, &failure));
  MUST(thrum_scene_reset(f->scene, &failure));
  assert_true(thrum_scene_time(f->scene) == 0);
  steps(f->scene, 60);
  MUST(thrum_scene_body_get(f->scene, 0, again, NULL, &failure));
  assert_memory_equal(q, again, sizeof q);
}

static void changes_keep_the_motion(void **context) {
  fixture *f = *context;

  // a body in motion
  double q[RANK], p[RANK], q_now[RANK], p_now[RANK];
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  def.start_mode = 1;
  def.start_amplitude = 0.2;
  add(f, &def);
  steps(f->scene, 40);
  MUST(thrum_scene_body_get(f->scene, 0, q, p, &failure));

  // no parameter of the integration may move the body
  MUST(thrum_scene_set_dt(f->scene, 0.001, &failure));
  MUST(thrum_scene_set_damping(f->scene, 0, 0.5, 0.001, &failure));
  MUST(thrum_scene_set_integrator(f->scene, 0, THRUM_INTEGRATOR_ENERGY, &failure));
  MUST(thrum_scene_set_stiffness(f->scene, 0, 2, &failure));
  MUST(thrum_scene_body_get(f->scene, 0, q_now, p_now, &failure));
  assert_true(largest_difference(q, q_now, RANK) < 1e-12);
  assert_true(largest_difference(p, p_now, RANK) < 1e-10);

  // the new parameters are in effect
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(info.stepped->omega2[2] == 2 * f->m.model.omega2[2]);
  assert_int_equal(info.integrator, THRUM_INTEGRATOR_ENERGY);

  // modes that are not stepped follow, and go on from there; the others keep their coordinates
  double followed[RANK];
  MUST(thrum_scene_set_rank(f->scene, 0, 3, &failure));
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(info.condensed && info.rank == 3);
  MUST(thrum_scene_body_get(f->scene, 0, followed, NULL, &failure));
  MUST(thrum_scene_set_rank(f->scene, 0, RANK, &failure));
  MUST(thrum_scene_body_get(f->scene, 0, q_now, NULL, &failure));
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(q_now[i] - (i < 3 ? q : followed)[i]) < 1e-12);
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(!info.condensed && info.rank == RANK);
  steps(f->scene, 40);
  assert_true(fabs(thrum_scene_time(f->scene) - 0.16) < 1e-12);

  // refused changes leave the scene as it was
  assert_true(thrum_scene_set_rank(f->scene, 0, RANK + 1, &failure) < 0);
  assert_true(thrum_scene_set_dt(f->scene, -1, &failure) < 0);
  assert_true(thrum_scene_set_stiffness(f->scene, 0, 0, &failure) < 0);
  assert_true(thrum_scene_set_damping(f->scene, 0, NAN, 0, &failure) < 0);
  assert_true(thrum_scene_set_rank(f->scene, 1, 2, &failure) < 0);
  steps(f->scene, 1);
}

/* A damped body loses what its damping took, over all the states that changes give it. */
static void what_damping_took_is_counted_through_changes(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_ENERGY);
  def.start_mode = 1;
  def.start_amplitude = 0.2;
  def.state.damping_alpha = 0.5;
  add(f, &def);
  thrum_scene_energies first, now;
  thrum_scene_body_info info;
  MUST(thrum_scene_body_energies(f->scene, 0, &first, &failure));

  // none of these changes moves energy; the last leaves the first state, and a snapshot of before
  double before = 0;
  for (int change = 0; change < 4; change++) {
    steps(f->scene, 100);
    if (change == 0)
      MUST(thrum_scene_set_damping(f->scene, 0, 0.7, 0.0005, &failure));
    else if (change == 1)
      MUST(thrum_scene_set_dt(f->scene, 0.002, &failure));
    else if (change == 2)
      MUST(thrum_scene_set_integrator(f->scene, 0, THRUM_INTEGRATOR_MIDPOINT, &failure));
    MUST(thrum_scene_body(f->scene, 0, &info, &failure));
    MUST(thrum_scene_body_energies(f->scene, 0, &now, &failure));
    assert_true(info.dissipated > before);
    assert_true(fabs(first.total - now.total - info.dissipated) < 2e-3 * first.total);
    before = info.dissipated;
  }
  assert_true(before > 0.2 * first.total);

  // a snapshot keeps the sum, and a reset begins it anew
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *memory = malloc(size);
  assert_non_null(memory);
  MUST(thrum_scene_snapshot(f->scene, memory, size, &failure));
  steps(f->scene, 10);
  MUST(thrum_scene_restore(f->scene, memory, size, &failure));
  free(memory);
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(info.dissipated == before);
  MUST(thrum_scene_reset(f->scene, &failure));
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(info.dissipated == 0);
}

/* A step of a body that also gained energy is a step that fell back none the less. */
static void every_step_that_fell_back_is_counted(void **context) {
  // a tenth-order motion at a step where quasi-Newton alone does not solve it
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_NEWMARK);
  def.start_mode = 1;
  def.start_amplitude = 3;
  def.state.newmark_gamma = 0.4;
  def.state.iterations_max = 2;
  add(f, &def);
  thrum_scene_body_info info;
  int64_t fell_back = 0, both = 0, counted = 0;
  for (int k = 0; k < 300; k++) {
    // the scene tells what the report of the state says
    const thrum_status status = thrum_scene_step(f->scene, NULL);
    assert_true(status >= 0);
    MUST(thrum_scene_body(f->scene, 0, &info, &failure));
    const thrum_state_report *r = &info.report;
    const int64_t steps_before = counted;
    counted = r->newton_steps + r->energy_steps + r->substep_steps;
    fell_back += counted - steps_before;
    both += counted > steps_before && status == THRUM_ENERGY_GREW;
    assert_int_equal(info.fallback_steps, fell_back);
  }
  assert_true(both > 0 && fell_back > both);

  // and through a change
  MUST(thrum_scene_set_damping(f->scene, 0, 0.1, 0, &failure));
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_int_equal(info.fallback_steps, fell_back);
}

/* The course of a load is evaluated at the time of the scene, also after dt has changed. */
static void loads_keep_their_time_when_dt_changes(void **context) {
  // without restoring forces the momentum shows the load alone
  fixture *f = *context;
  for (int i = 0; i < RANK; i++)
    f->m.omega2[i] = 0;
  memset(f->m.c3, 0, (size_t)f->m.model.c3_count * sizeof(double));
  memset(f->m.c4, 0, (size_t)f->m.model.c4_count * sizeof(double));
  random_model_pack(&f->m);
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_MIDPOINT);
  add(f, &def);

  // a load with a field over the mesh, whose course starts and ends within the run
  const double field[3 * VERTICES] = {[3] = 1, [10] = -2, [20] = 3};
  const thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_FIELD,
      .field = field,
      .field_count = VERTICES,
      .course = {.shape = THRUM_LOAD_SINE, .from = 0.01, .until = 0.2, .frequency = 4}};
  MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));

  // the time step changes while the load acts
  double p[RANK], expected[RANK] = {0};
  steps(f->scene, 10);
  MUST(thrum_scene_set_dt(f->scene, 0.002, &failure));
  steps(f->scene, 200);
  MUST(thrum_scene_body_get(f->scene, 0, NULL, p, &failure));

  // without a restoring force the momentum is the integral of the load
  assert_int_equal(thrum_load_add_field(&f->m.model, field, expected, NULL), THRUM_OK);
  const double integral = (1 - cos(2 * pi * 4 * 0.19)) / (2 * pi * 4);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(p[i] - integral * expected[i]) < 1e-12);
}

static void a_body_that_fails_stops_and_the_others_go_on(void **context) {
  // one Newton iteration from a large amplitude cannot converge, and there is no fallback
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_NEWMARK);
  def.state.fallback = 0;
  def.state.iterations_max = 1;
  def.state.tolerance = 1e-14;
  def.start_mode = 1;
  def.start_amplitude = 50;
  def.name = "wild";
  add(f, &def);

  // beside it is a body that steps without trouble
  const thrum_scene_body_def quiet = def_of(f, THRUM_INTEGRATOR_IMEXV);
  add(f, &quiet);

  // the scene reports the first failure and goes on
  thrum_status failed = THRUM_OK;
  for (int k = 0; k < 20; k++) {
    const thrum_status status = thrum_scene_step(f->scene, &failure);
    failed = failed < 0 ? failed : status;
  }
  assert_true(failed < 0);
  assert_non_null(strstr(failure.message, "wild"));

  // the failed body keeps its status, and the other one has taken every step
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_int_equal(info.status, failed);
  MUST(thrum_scene_body(f->scene, 1, &info, &failure));
  assert_int_equal(info.status, THRUM_OK);
  assert_int_equal(info.report.steps, 20);

  // a reset clears the failure
  MUST(thrum_scene_reset(f->scene, &failure));
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_int_equal(info.status, THRUM_OK);
}

static void the_matrix_puts_a_surface_where_its_vertices_are(void **context) {
  // a body with a placement, a scale and a rank of its own
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  def.rotation[0] = 0.8;
  def.rotation[2] = 0.6;
  def.position[1] = 3;
  def.scale = 1.5;
  def.rank = 5;
  def.start_mode = 2;
  def.start_amplitude = 0.3;
  add(f, &def);

  // the surface of the whole model, which holds every vertex
  size_t size = 0;
  const thrum_surface_def all = {0};
  const thrum_surface *surface = NULL;
  MUST(thrum_surface_size(&f->m.model, &all, &size, &failure));
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  MUST(thrum_surface_init(memory, size, &f->m.model, &all, &surface, &failure));
  float out[3 * VERTICES];
  double matrix[16], x[3];

  // the matrix maps displayed positions to the positions that the body reports
  steps(f->scene, 5);
  MUST(thrum_scene_body_positions(f->scene, 0, surface, out, 3, &failure));
  thrum_scene_body_matrix(f->scene, 0, matrix);
  for (int v = 0; v < VERTICES; v++) {
    MUST(thrum_scene_body_vertex(f->scene, 0, v, x, NULL, &failure));
    for (int row = 0; row < 3; row++) {
      double sum = matrix[12 + row];
      for (int column = 0; column < 3; column++)
        sum += matrix[4 * column + row] * (double)out[3 * v + column];
      assert_true(fabs(sum - x[row]) < 1e-5);
    }
  }
  free(memory);
}

/* Makes a model of the fixture's: twice as stiff, or of three coordinates. The caller frees it. */
static void *make_other(const fixture *f, bool fewer, const thrum_model **other) {
  const thrum_model_scaling twice = {1, 2, 1};
  size_t size = 0;
  MUST(fewer ? thrum_model_lock_size(&f->m.model, 3, &size, &failure)
             : thrum_model_scale_size(&f->m.model, &size, &failure));
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  MUST(fewer ? thrum_model_lock(memory, size, &f->m.model, 3, other, &failure)
             : thrum_model_scale(memory, size, &f->m.model, &twice, other, &failure));
  return memory;
}

/* A surface reads as many coordinates as the model has that it was made of. */
static void a_surface_of_another_model_is_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  add(f, &def);
  for (int n = 0; n < 2; n++) {
    const thrum_model *other = NULL;
    const thrum_surface_def all = {0};
    const thrum_surface *surface = NULL;
    void *memory = make_other(f, n == 1, &other);
    size_t size = 0;
    MUST(thrum_surface_size(other, &all, &size, &failure));
    void *block = aligned_alloc(64, (size + 63) / 64 * 64);
    MUST(thrum_surface_init(block, size, other, &all, &surface, &failure));

    // it fits its own model alone
    MUST(thrum_surface_fits(surface, other, &failure));
    assert_int_equal(thrum_surface_fits(surface, &f->m.model, &failure), THRUM_MODEL_MISMATCH);
    assert_int_equal(thrum_surface_fits(surface, NULL, &failure), THRUM_INVALID_ARGUMENT);
    assert_int_equal(thrum_surface_fits(NULL, other, &failure), THRUM_INVALID_ARGUMENT);

    // and a body of another one writes nothing
    float out[3 * VERTICES] = {7};
    assert_int_equal(thrum_scene_body_positions(f->scene, 0, surface, out, 3, &failure),
                     THRUM_MODEL_MISMATCH);
    assert_true(out[0] == 7);
    free(block);
    free(memory);
  }
}

static void bad_defs_are_refused(void **context) {
  // a definition that was not initialised has a status of its own
  fixture *f = *context;
  thrum_scene_body_def def = {0};
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_UNINITIALISED_DEF);

  // every other refusal changes one field of a good definition and leaves the scene empty
  const thrum_scene_body_def good = def_of(f, THRUM_INTEGRATOR_IMEXV);
#define REFUSED(change)                                                                            \
  do {                                                                                             \
    def = good;                                                                                    \
    change;                                                                                        \
    assert_true(thrum_scene_add_body(f->scene, &def, NULL, &failure) < 0);                         \
    assert_int_equal(thrum_scene_body_count(f->scene), 0);                                         \
  } while (0)
  REFUSED(def.model = NULL);
  REFUSED(def.rank = RANK + 1);
  REFUSED(def.rank = -1);
  REFUSED(def.scale = 0);
  REFUSED(def.stiffness = NAN);
  REFUSED(def.density = -1);
  REFUSED(def.position[1] = INFINITY);
  REFUSED(def.rotation[0] = 0);
  REFUSED(def.state.tolerance = -1e-9);
  REFUSED(def.start_mode = RANK + 1; def.start_amplitude = 1);
#undef REFUSED

  // the scene's own arguments: time step, probes, loads and gravity
  assert_true(thrum_scene_create(0, &f->scene, &failure) < 0);
  assert_true(thrum_scene_add_probe(f->scene, NULL, 0, NULL, 0, &failure) < 0);
  add(f, &good);
  const int32_t beyond = VERTICES;
  assert_true(thrum_scene_add_probe(f->scene, NULL, 0, &beyond, 1, &failure) < 0);
  const thrum_scene_load_def load = {
      .cookie = sizeof load, .kind = THRUM_SCENE_FORCE, .vertices = &beyond, .count = 1};
  assert_true(thrum_scene_add_load(f->scene, 0, &load, &failure) < 0);
  const double nowhere[3] = {0, NAN, 0};
  assert_true(thrum_scene_set_gravity(f->scene, nowhere, &failure) < 0);
}

/* The scene tells its time step, gravity, obstacles and probes as they were set last. */
static void a_scene_tells_what_was_set(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  add(f, &def);
  add(f, &def);

  // time step and gravity
  const double down[3] = {0.5, 0, -9.81}, none[3] = {0};
  double gravity[3] = {NAN, NAN, NAN};
  thrum_scene_gravity(f->scene, gravity);
  assert_memory_equal(gravity, none, sizeof gravity);
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  thrum_scene_gravity(f->scene, gravity);
  assert_memory_equal(gravity, down, sizeof gravity);
  assert_true(thrum_scene_dt(f->scene) == 0.003);
  MUST(thrum_scene_set_dt(f->scene, 0.002, &failure));
  assert_true(thrum_scene_dt(f->scene) == 0.002);

  // an obstacle is replaced, and keeps its place and number
  thrum_obstacle obstacle = thrum_default_obstacle(), seen;
  int32_t number = -1;
  assert_int_equal(thrum_scene_obstacle_count(f->scene), 0);
  MUST(thrum_scene_add_obstacle(f->scene, &obstacle, &number, &failure));
  obstacle.friction = 0.25;
  MUST(thrum_scene_set_obstacle(f->scene, number, &obstacle, &failure));
  assert_int_equal(thrum_scene_obstacle_count(f->scene), 1);
  MUST(thrum_scene_obstacle_get(f->scene, number, &seen, &failure));
  assert_true(seen.friction == 0.25);

  // one that cannot be leaves the old one, as does a number that does not exist
  obstacle.friction = -1;
  assert_true(thrum_scene_set_obstacle(f->scene, number, &obstacle, &failure) < 0);
  obstacle.friction = 0.5;
  assert_true(thrum_scene_set_obstacle(f->scene, number + 1, &obstacle, &failure) < 0);
  MUST(thrum_scene_obstacle_get(f->scene, number, &seen, &failure));
  assert_true(seen.friction == 0.25);

  // a probe knows its body
  MUST(thrum_scene_add_probe(f->scene, "tip", 1, NULL, 0, &failure));
  assert_int_equal(thrum_scene_probe_body(f->scene, 0), 1);
  assert_int_equal(thrum_scene_probe_body(f->scene, 1), -1);
}

/* One worker is the caller's thread. */
static void count_runs(void *context, int32_t count,
                       void (*task)(void *of, int32_t n, int32_t worker), void *of) {
  ++*(int *)context;
  for (int32_t n = 0; n < count; n++)
    task(of, n, 0);
}

static void one_worker_is_the_caller(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  int runs = 0;
  add(f, &def);
  add(f, &def);
  MUST(thrum_scene_set_workers(f->scene, 1, count_runs, &runs, &failure));
  steps(f->scene, 1);
  assert_int_equal(runs, 0);
  MUST(thrum_scene_set_workers(f->scene, 2, count_runs, &runs, &failure));
  steps(f->scene, 1);
  assert_true(runs > 0);
}

/* A base whose acceleration is a sin(w t) stands at -a sin(w t) / w^2. */
static void the_ground_is_where_the_base_motions_put_it(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  add(f, &def);
  const double frequency = 0.7, omega = 2 * pi * frequency;
  const thrum_load sine = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = frequency};
  MUST(thrum_scene_add_base_motion(f->scene, (const double[3]){2, 0, 0}, &sine, &failure));
  MUST(thrum_scene_add_base_motion(f->scene, (const double[3]){0, -1, 3}, &sine, &failure));
  steps(f->scene, 100);

  double ground[3];
  thrum_scene_ground(f->scene, ground);
  const double time = thrum_scene_time(f->scene), expected[3] = {2, -1, 3};
  for (int axis = 0; axis < 3; axis++)
    assert_true(fabs(ground[axis] + expected[axis] * sin(omega * time) / (omega * omega)) < 1e-12);
}

/* A ground that would be nowhere is refused, and stays where it is. */
static void a_ground_that_goes_nowhere_is_refused(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, THRUM_INTEGRATOR_IMEXV);
  add(f, &def);
  static const double push[3] = {1, 0, 0};
  static const thrum_load courses[] = {
      {.shape = THRUM_LOAD_SINE, .from = INFINITY, .until = INFINITY, .frequency = 1},
      {.shape = THRUM_LOAD_SINE, .from = -INFINITY, .until = INFINITY, .frequency = 1},
      {.shape = THRUM_LOAD_SINE, .until = NAN, .frequency = 1},
      {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 1e-300},
      {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = -1},
      {.shape = THRUM_LOAD_SINE, .from = 1e300, .until = INFINITY, .frequency = 1},
  };
  for (size_t n = 0; n < sizeof courses / sizeof courses[0]; n++)
    assert_int_equal(thrum_scene_add_base_motion(f->scene, push, &courses[n], &failure),
                     THRUM_BAD_VALUE);

  // not even by nothing, where a division by the square of the frequency has no result
  assert_int_equal(
      thrum_scene_add_base_motion(f->scene, (const double[3]){0}, &courses[3], &failure),
      THRUM_BAD_VALUE);

  // nor does a record go further
  static const double times[] = {0, 1e20}, accelerations[] = {0, 0, 0, 1, 0, 0};
  double velocities[6], positions[6], ground[3];
  const thrum_base_motion motion = {2, times, accelerations, velocities, positions};
  thrum_base_motion_integrate(2, times, accelerations, velocities, positions);
  assert_int_equal(thrum_scene_add_base_motion_record(f->scene, &motion, &failure),
                   THRUM_BAD_VALUE);
  steps(f->scene, 3);
  thrum_scene_ground(f->scene, ground);
  assert_true(ground[0] == 0 && ground[1] == 0 && ground[2] == 0);

  // samples that are next to each other leave it somewhere
  static const double close[] = {0, 1e-310};
  const thrum_base_motion sudden = {2, close, accelerations, velocities, positions};
  thrum_base_motion_integrate(2, close, accelerations, velocities, positions);
  thrum_base_motion_at(&sudden, 0, ground, velocities);
  assert_true(isfinite(ground[0]) && isfinite(velocities[0]));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(bodies_side_by_side_have_the_bits_of_each_alone),
      TEST(bodies_share_scratch),
      TEST(a_reduced_load_is_the_load),
      TEST(turning_a_body_and_its_world_changes_nothing),
      TEST(a_scaled_body_moves_as_the_small_one_in_its_own_time),
      TEST(only_what_is_named_is_built),

      // what a scene keeps through changes
      TEST(a_snapshot_brings_back_every_bit),
      TEST(a_reset_starts_over_with_the_same_bits),
      TEST(changes_keep_the_motion),
      TEST(what_damping_took_is_counted_through_changes),
      TEST(every_step_that_fell_back_is_counted),
      TEST(loads_keep_their_time_when_dt_changes),
      TEST(a_body_that_fails_stops_and_the_others_go_on),

      // what it tells, and what it refuses
      TEST(the_matrix_puts_a_surface_where_its_vertices_are),
      TEST(a_surface_of_another_model_is_refused),
      TEST(bad_defs_are_refused),
      TEST(a_scene_tells_what_was_set),
      TEST(one_worker_is_the_caller),
      TEST(the_ground_is_where_the_base_motions_put_it),
      TEST(a_ground_that_goes_nowhere_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
