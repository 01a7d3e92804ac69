/* Tests of crowds on a device: against thrum_step by the same equations, the same bits from run to
 * run, exact energy, and what is refused. They need a driver of OpenCL, such as PoCL.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"
#include "tests/support/points_support.h"

#include "accelerator/device.h"

enum { RANK = 9, BODIES = 70, STEPS = 200 };

typedef struct bodies {
  double q[BODIES * RANK], p[BODIES * RANK], load[BODIES * RANK];
} bodies;

static void bodies_make(bodies *b, uint64_t seed, double amplitude) {
  random_state random = {seed};
  random_vector(&random, BODIES * RANK, amplitude, b->q);
  random_vector(&random, BODIES * RANK, 20 * amplitude, b->p);
  random_vector(&random, BODIES * RANK, 400 * amplitude, b->load);
}

/* The same for a model of cubature points, whose frequencies are of about 1 rad/s. */
static void bodies_slow(bodies *b) {
  for (int i = 0; i < BODIES * RANK; i++) {
    b->p[i] /= 20;
    b->load[i] /= 400;
  }
}

static thrum_accelerator *take_device(int32_t single) {
  thrum_accelerator_def def = thrum_default_accelerator_def();
  def.single = single;
  thrum_accelerator *accelerator;
  thrum_error error;
  assert_int_equal(thrum_accelerator_create(&def, &accelerator, &error), THRUM_OK);
  return accelerator;
}

static thrum_crowd_def crowd_of(thrum_integrator integrator, double h) {
  thrum_crowd_def def = thrum_default_crowd_def();
  def.count = BODIES;
  def.state.integrator = integrator;
  def.state.dt = h;
  def.state.tolerance = 1e-13;
  return def;
}

/* Steps the bodies on the device; q and p come back in b. */
static thrum_status step_there(thrum_accelerator *accelerator, const thrum_model *model,
                               const thrum_crowd_def *def, bodies *b, int64_t steps) {
  thrum_crowd *crowd;
  thrum_error error;
  assert_int_equal(thrum_crowd_create(accelerator, model, def, &crowd, &error), THRUM_OK);
  assert_int_equal(thrum_crowd_set(crowd, b->q, b->p, model->rank, &error), THRUM_OK);
  assert_int_equal(thrum_crowd_set_forces(crowd, b->load, model->rank, &error), THRUM_OK);
  const thrum_status status = thrum_crowd_step(crowd, steps, NULL, &error);
  assert_int_equal(thrum_crowd_get(crowd, b->q, b->p, model->rank, &error), THRUM_OK);
  thrum_crowd_destroy(crowd);
  return status;
}

/* The same by thrum_step. */
static void step_here(const thrum_model *model, const thrum_crowd_def *def, bodies *b,
                      int64_t steps) {
  const int64_t r = model->rank;
  for (int64_t n = 0; n < def->count; n++) {
    thrum_state *state;
    assert_int_equal(thrum_state_create(model, &def->state, &state, NULL), THRUM_OK);
    assert_int_equal(thrum_state_set(model, state, b->q + n * r, b->p + n * r, NULL), THRUM_OK);
    assert_int_equal(thrum_state_set_force(model, state, b->load + n * r, NULL), THRUM_OK);
    for (int64_t k = 0; k < steps; k++)
      assert_true(thrum_step(model, state, NULL) >= 0);
    thrum_state_get(model, state, b->q + n * r, b->p + n * r, NULL);
    thrum_state_destroy(state);
  }
}

/* Largest difference, over the largest number. */
static double differ(const double *a, const double *b, int64_t count) {
  double most = 0, all = 0;
  for (int64_t i = 0; i < count; i++) {
    most = fmax(most, fabs(a[i] - b[i]));
    all = fmax(all, fabs(b[i]));
    assert_true(isfinite(a[i]));
  }
  return most / all;
}

/* Each integrator, with damping and loads, where the forces that are not linear are a tenth of all
 * and more. */
static void test_crowd_is_thrum_step(void **unused) {
  (void)unused;
  const thrum_integrator all[] = {THRUM_INTEGRATOR_VERLET, THRUM_INTEGRATOR_MIDPOINT,
                                  THRUM_INTEGRATOR_ENERGY};
  thrum_accelerator *const accelerator = take_device(0);
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  random_model straight;
  random_model_make(&straight, 3, RANK, 20, 200, INFINITY);
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
    thrum_crowd_def def = crowd_of(all[k], 2e-3);
    def.state.damping_alpha = 0.5;
    def.state.damping_beta = 1e-5;
    bodies here, there;
    bodies_make(&here, 7, 0.3);
    there = here;
    step_here(&body.model, &def, &here, STEPS);
    assert_int_equal(step_there(accelerator, &body.model, &def, &there, STEPS), THRUM_OK);
    assert_true(differ(there.q, here.q, BODIES * RANK) < 1e-6);
    assert_true(differ(there.p, here.p, BODIES * RANK) < 1e-6);

    // without the coefficients the runs are others: what is compared is not the linear part
    bodies linear;
    bodies_make(&linear, 7, 0.3);
    step_here(&straight.model, &def, &linear, STEPS);
    assert_true(differ(linear.q, here.q, BODIES * RANK) > 0.1);
  }
  random_model_free(&straight);
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

/* More than one part of bodies, of which the last is not full, and the same bits twice. */
static void test_parts_and_bits(void **unused) {
  (void)unused;
  enum { MANY = 4096 + 70, SHORT = 3 };
  thrum_accelerator *const accelerator = take_device(0);
  random_model body;
  random_model_make(&body, 5, SHORT, 20, 200, 1);
  double *const q = random_alloc(MANY * SHORT, sizeof *q), *const first = random_alloc(MANY * SHORT,
                                                                                       sizeof *q);
  double *const energy = random_alloc(2 * MANY, sizeof *energy);
  thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_ENERGY, 2e-3);
  def.count = MANY;
  for (int run = 0; run < 2; run++) {
    random_state random = {11};
    random_vector(&random, MANY * SHORT, 0.3, q);
    thrum_crowd *crowd;
    assert_int_equal(thrum_crowd_create(accelerator, &body.model, &def, &crowd, NULL), THRUM_OK);
    assert_int_equal(thrum_crowd_set(crowd, q, NULL, SHORT, NULL), THRUM_OK);
    assert_int_equal(thrum_crowd_energies(crowd, energy, energy + MANY, NULL), THRUM_OK);

    // the energies are those of the library
    double work[1000];
    assert_true(thrum_work_count(&body.model) <= 1000);
    for (int n = 0; n < MANY; n += 1000) {
      const double strain = thrum_strain_energy(&body.model, q + n * SHORT, work);
      assert_true(energy[n] == 0 && fabs(energy[MANY + n] / strain - 1) < 1e-6);
    }
    assert_int_equal(thrum_crowd_step(crowd, 20, NULL, NULL), THRUM_OK);
    double start = 0, end = 0;
    for (int n = 0; n < MANY; n++)
      start += energy[MANY + n];
    assert_int_equal(thrum_crowd_energies(crowd, energy, energy + MANY, NULL), THRUM_OK);
    for (int n = 0; n < 2 * MANY; n++)
      end += energy[n];
    assert_true(fabs(end / start - 1) < 1e-6 && energy[0] > 0);

    assert_int_equal(thrum_crowd_get(crowd, q, NULL, SHORT, NULL), THRUM_OK);
    if (run == 0)
      memcpy(first, q, MANY * SHORT * sizeof *q);
    thrum_crowd_destroy(crowd);
  }
  assert_memory_equal(first, q, MANY * SHORT * sizeof *q);

  // a body of the last part is stepped as any other
  thrum_crowd_def one = def;
  one.count = 1;
  random_state random = {11};
  random_vector(&random, MANY * SHORT, 0.3, q);
  thrum_crowd *crowd;
  assert_int_equal(thrum_crowd_create(accelerator, &body.model, &one, &crowd, NULL), THRUM_OK);
  assert_int_equal(thrum_crowd_set(crowd, q + (MANY - 1) * SHORT, NULL, SHORT, NULL), THRUM_OK);
  assert_int_equal(thrum_crowd_step(crowd, 20, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_crowd_get(crowd, q, NULL, SHORT, NULL), THRUM_OK);
  assert_memory_equal(first + (MANY - 1) * SHORT, q, SHORT * sizeof *q);
  thrum_crowd_destroy(crowd);
  free(q);
  free(first);
  free(energy);
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

/* A model of cubature points, by each integrator; its energies, too. */
static void test_points(void **unused) {
  (void)unused;
  enum { COUNT = 11 };
  const thrum_integrator all[] = {THRUM_INTEGRATOR_VERLET, THRUM_INTEGRATOR_MIDPOINT,
                                  THRUM_INTEGRATOR_ENERGY};
  thrum_accelerator *const accelerator = take_device(0);
  both body;
  points_make(&body, 9, RANK, COUNT, 0.4);
  random_model straight;
  random_model_make(&straight, 9, RANK, 1, 3, INFINITY);
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
    thrum_crowd_def def = crowd_of(all[k], 0.1);
    bodies here, there, linear;
    bodies_make(&here, 7, 0.5);
    bodies_slow(&here);
    there = linear = here;

    // on the device, here, and here without what is not linear
    step_here(&body.points, &def, &here, 40);
    step_here(&straight.model, &def, &linear, 40);
    assert_int_equal(step_there(accelerator, &body.points, &def, &there, 40), THRUM_OK);
    assert_true(differ(there.q, here.q, BODIES * RANK) < 1e-5);
    assert_true(differ(there.p, here.p, BODIES * RANK) < 1e-5);
    assert_true(differ(linear.q, here.q, BODIES * RANK) > 0.1);
  }

  // the energies at rest are the library's
  thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_ENERGY, 0.1);
  bodies b;
  bodies_make(&b, 7, 0.5);
  thrum_crowd *crowd;
  double kinetic[BODIES], strain[BODIES];
  assert_int_equal(thrum_crowd_create(accelerator, &body.points, &def, &crowd, NULL), THRUM_OK);
  assert_int_equal(thrum_crowd_set(crowd, b.q, NULL, RANK, NULL), THRUM_OK);
  assert_int_equal(thrum_crowd_energies(crowd, kinetic, strain, NULL), THRUM_OK);
  double *const work = random_alloc((int64_t)thrum_work_count(&body.points), sizeof *work);
  for (int n = 0; n < BODIES; n++) {
    const double here = thrum_strain_energy(&body.points, b.q + n * RANK, work);
    assert_true(kinetic[n] == 0 && fabs(strain[n] / here - 1) < 1e-6);
  }
  free(work);
  thrum_crowd_destroy(crowd);
  both_free(&body);
  random_model_free(&straight);
  thrum_accelerator_destroy(accelerator);
}

/* Devices whose work-items have other numbers of bodies, such as the one of a graphics processor.
 */
static void test_lanes(void **unused) {
  (void)unused;
  const int lanes[] = {1, 8, 1};
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  both points;
  points_make(&points, 9, RANK, 5, 0.4);
  for (int k = 0; k < 3; k++) {
    thrum_accelerator *const accelerator = take_device(k == 2);
    accelerator->lanes = lanes[k];
    accelerator->wide = lanes[k] > 4 ? lanes[k] : 4;
    for (int of_points = 0; of_points < (k == 0 ? 2 : 1); of_points++) {
      const thrum_model *model = of_points ? &points.points : &body.model;
      thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_ENERGY, of_points ? 0.1 : 2e-3);
      bodies here, there;
      bodies_make(&here, 7, 0.3);
      if (of_points)
        bodies_slow(&here);
      there = here;
      step_here(model, &def, &here, 10);
      assert_int_equal(step_there(accelerator, model, &def, &there, 10), THRUM_OK);
      assert_true(differ(there.q, here.q, BODIES * RANK) < 1e-5);
    }
    thrum_accelerator_destroy(accelerator);
  }
  both_free(&points);
  random_model_free(&body);
}

/* A condensed model is a polynomial in fewer coordinates. */
static void test_condensed(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(0);
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  const thrum_model *model;
  void *const memory = condense(&body.model, 4, &model);
  thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_ENERGY, 2e-3);
  bodies here, there;
  bodies_make(&here, 7, 0.03);
  there = here;
  step_here(model, &def, &here, STEPS);
  assert_int_equal(step_there(accelerator, model, &def, &there, STEPS), THRUM_OK);
  assert_true(differ(there.q, here.q, BODIES * model->rank) < 1e-6);

  // what follows would drag in thrum_step
  thrum_crowd *crowd = NULL;
  thrum_error error;
  def.state.damping_beta = 1e-3;
  assert_int_equal(thrum_crowd_create(accelerator, model, &def, &crowd, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "damping_beta"));
  assert_null(crowd);
  free(memory);
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

/* Single precision throughout, as of a device that has no other: seven digits of each step. */
static void test_single(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(1);
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  const thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_MIDPOINT, 2e-3);
  bodies here, there;
  bodies_make(&here, 7, 0.3);
  there = here;
  step_here(&body.model, &def, &here, STEPS);
  assert_int_equal(step_there(accelerator, &body.model, &def, &there, STEPS), THRUM_OK);
  const double off = differ(there.q, here.q, BODIES * RANK);
  assert_true(off < 1e-4 && off > 1e-8);

  // what it cannot hold is refused
  thrum_crowd *crowd;
  thrum_error error;
  assert_int_equal(thrum_crowd_create(accelerator, &body.model, &def, &crowd, NULL), THRUM_OK);
  here.q[0] = 1e40;
  assert_int_equal(thrum_crowd_set(crowd, here.q, NULL, RANK, &error), THRUM_BAD_VALUE);
  thrum_crowd_destroy(crowd);
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

/* A body that Newton does not bring to an end stays where it was; the others go on. */
static void test_one_stops(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(0);
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  const thrum_integrator all[] = {THRUM_INTEGRATOR_VERLET, THRUM_INTEGRATOR_ENERGY};
  for (size_t k = 0; k < 2; k++) {
    thrum_crowd_def def = crowd_of(all[k], 2e-3);
    def.iterations = 2;
    def.tolerance = 1e-2;
    static bodies b, after;
    bodies_make(&b, 7, 0.1);
    for (int i = 0; i < RANK; i++)
      b.q[BODIES / 2 * RANK + i] = k == 0 ? 1e250 : 40;
    thrum_crowd *crowd;
    thrum_error error;
    int64_t stopped[BODIES];
    assert_int_equal(thrum_crowd_create(accelerator, &body.model, &def, &crowd, NULL), THRUM_OK);
    assert_int_equal(thrum_crowd_set(crowd, b.q, b.p, RANK, NULL), THRUM_OK);
    assert_int_equal(thrum_crowd_step(crowd, 5, stopped, &error), THRUM_NOT_CONVERGED);
    assert_non_null(
        strstr(error.message, "1 of 70 bodies have stopped, the first, body 35, after 0"));
    assert_int_equal(thrum_crowd_get(crowd, after.q, after.p, RANK, NULL), THRUM_OK);
    assert_memory_equal(after.p + BODIES / 2 * RANK, b.p + BODIES / 2 * RANK,
                        RANK * sizeof(double));
    for (int n = 0; n < BODIES; n++) {
      assert_int_equal(stopped[n], n == BODIES / 2 ? 0 : -1);
      assert_true((after.q[n * RANK] == b.q[n * RANK]) == (n == BODIES / 2));
    }

    // set anew it goes on
    bodies_make(&b, 7, 0.1);
    assert_int_equal(thrum_crowd_set(crowd, b.q, b.p, RANK, NULL), THRUM_OK);
    assert_int_equal(thrum_crowd_step(crowd, 5, stopped, NULL), THRUM_OK);
    assert_int_equal(stopped[BODIES / 2], -1);
    thrum_crowd_destroy(crowd);
  }
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

/* Damped bodies come to rest and stay there, where all of an increment is rounding: under a load at
 * its static answer, and without one at numbers whose squares are zero in single precision. */
static void test_rest(void **unused) {
  (void)unused;
  enum { SMALL = 2 };
  for (int32_t single = 0; single < 2; single++) {
    thrum_accelerator *const accelerator = take_device(single);
    random_model body;
    random_model_make(&body, 3, SMALL, 20, 200, 1);
    for (int k = 0; k < 2; k++) {
      thrum_crowd_def def = crowd_of(k ? THRUM_INTEGRATOR_MIDPOINT : THRUM_INTEGRATOR_ENERGY, 0.01);
      def.state.damping_alpha = 8;
      const double q[SMALL] = {0.1, -0.05}, load[SMALL] = {3, 2};
      double after[BODIES * SMALL], force[SMALL], work[64];
      thrum_crowd *crowd;
      thrum_error error;
      assert_int_equal(thrum_crowd_create(accelerator, &body.model, &def, &crowd, NULL), THRUM_OK);
      assert_int_equal(thrum_crowd_set(crowd, q, NULL, 0, NULL), THRUM_OK);
      if (thrum_crowd_step(crowd, 1500, NULL, &error) != THRUM_OK)
        fail_msg("%s", error.message);
      assert_int_equal(thrum_crowd_set_forces(crowd, load, 0, NULL), THRUM_OK);
      if (thrum_crowd_step(crowd, 1000, NULL, &error) != THRUM_OK)
        fail_msg("%s", error.message);
      assert_int_equal(thrum_crowd_get(crowd, after, NULL, SMALL, NULL), THRUM_OK);
      thrum_internal_force(&body.model, after, force, work);
      for (int i = 0; i < SMALL; i++)
        assert_true(fabs(force[i] - load[i]) < 1e-5 * fabs(load[i]));
      thrum_crowd_destroy(crowd);
    }
    random_model_free(&body);
    thrum_accelerator_destroy(accelerator);
  }
}

static void refused(thrum_accelerator *accelerator, const thrum_model *model,
                    const thrum_crowd_def *def, thrum_status status, const char *part) {
  thrum_crowd *crowd = NULL;
  thrum_error error;
  assert_int_equal(thrum_crowd_create(accelerator, model, def, &crowd, &error), status);
  assert_null(crowd);
  if (!strstr(error.message, part))
    fail_msg("%s", error.message);
}

static void test_refusals(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(0);
  random_model body;
  random_model_make(&body, 3, RANK, 20, 200, 1);
  thrum_crowd_def def = crowd_of(THRUM_INTEGRATOR_NEWMARK, 2e-3);
  refused(accelerator, &body.model, &def, THRUM_UNSUPPORTED, "not by newmark");
  def = crowd_of(THRUM_INTEGRATOR_ENERGY, 2e-3);
  def.count = 0;
  refused(accelerator, &body.model, &def, THRUM_INVALID_ARGUMENT, "count is not 1");
  def.count = 1;
  def.iterations = 0;
  refused(accelerator, &body.model, &def, THRUM_INVALID_ARGUMENT, "iterations is not");
  def.iterations = 3;
  def.tolerance = NAN;
  refused(accelerator, &body.model, &def, THRUM_INVALID_ARGUMENT, "tolerance is not");
  def.tolerance = 1e-4;
  def.state.dt = -1;
  refused(accelerator, &body.model, &def, THRUM_INVALID_ARGUMENT, "dt");
  def = crowd_of(THRUM_INTEGRATOR_ENERGY, 2e-3);
  def.state.damping_form = THRUM_DAMPING_TANGENT;
  def.state.damping_beta = 1e-3;
  refused(accelerator, &body.model, &def, THRUM_UNSUPPORTED, "tangent");
  def = (thrum_crowd_def){0};
  refused(accelerator, &body.model, &def, THRUM_UNINITIALISED_DEF, "thrum_crowd_def_init");

  // more than any device has
  def = crowd_of(THRUM_INTEGRATOR_ENERGY, 2e-3);
  def.count = INT32_MAX;
  refused(accelerator, &body.model, &def, THRUM_OUT_OF_MEMORY, "take fewer bodies");
  thrum_model other = body.model;
  other.c3 = other.c4 = NULL;
  refused(accelerator, &other, &def, THRUM_MISSING, "neither coefficients nor points");
  both points;
  points_make(&points, 9, RANK, 3, 0.4);
  points_obey(&points, "neo-hookean");
  refused(accelerator, &points.points, &def, THRUM_UNSUPPORTED, "have another law");
  both_free(&points);
  random_model_free(&body);
  thrum_accelerator_destroy(accelerator);
}

static void test_devices(void **unused) {
  (void)unused;
  int32_t count = -1;
  assert_int_equal(thrum_accelerator_count(&count, NULL), THRUM_OK);
  assert_true(count >= 1);
  thrum_accelerator_def def = thrum_default_accelerator_def();
  def.device = count;
  thrum_accelerator *accelerator = NULL;
  thrum_error error;
  assert_int_equal(thrum_accelerator_create(&def, &accelerator, &error), THRUM_INVALID_ARGUMENT);
  assert_null(accelerator);
  assert_string_equal(error.field, "device");
  accelerator = take_device(0);
  thrum_accelerator_info info;
  assert_int_equal(thrum_accelerator_get_info(accelerator, &info, NULL), THRUM_OK);
  assert_true(info.name[0] && info.platform[0] && info.memory > 0 && info.units > 0);
  assert_true(info.buffer_most > 0 && info.has_double && !info.single);
  thrum_accelerator_destroy(accelerator);
  thrum_accelerator_destroy(NULL);
  thrum_crowd_destroy(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_crowd_is_thrum_step),
      cmocka_unit_test(test_parts_and_bits),
      cmocka_unit_test(test_points),
      cmocka_unit_test(test_lanes),
      cmocka_unit_test(test_condensed),
      cmocka_unit_test(test_single),
      cmocka_unit_test(test_one_stops),
      cmocka_unit_test(test_rest),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_devices),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
