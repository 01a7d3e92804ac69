/* Tests of the theorem of docs/contact.md: contact returns no more energy than it took, for any
 * stiffness, step, friction, restitution and integrator; and its energy report is exact.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"
#include "tests/support/sanitized.h"

static void expect_account(const thrum_contact_report *report, double scale) {
  assert_true(isfinite(report->stored) && isfinite(report->lost));
  assert_true(report->stored >= 0);
  // as far as the solves go, which end at 1e-10 of a step
  assert_true(report->lost >= -2e-8 * scale);
}

typedef struct extreme {
  thrum_integrator integrator;
  double dt, stiffness, friction, restitution, shape, height;
} extreme;

/* Throws a body on the floor and returns the largest relative growth of its energy. */
static double throw_down(const extreme *x, int64_t steps, thrum_contact_report *report) {
  // the body and the time step of this case
  rig_def def = rig_default();
  def.integrator = x->integrator;
  def.dt = x->dt;
  def.stiffness = x->stiffness;
  def.points = 5;
  def.shape = x->shape;
  if (x->integrator == THRUM_INTEGRATOR_VERLET || x->integrator == THRUM_INTEGRATOR_RK4)
    def.omega = fmin(def.omega, 0.3 / x->dt); // three times that is stable

  // thrown obliquely at the floor
  rig r;
  rig_make(&r, &def);
  r.floor.friction = x->friction;
  r.floor.restitution = x->restitution;
  r.translation.velocity[0] = 1;
  r.translation.velocity[2] = -1;
  r.translation.position[2] = x->height;

  // the energy and the balance of the report after every step
  const double first = rig_energy(&r);
  double gain = 0;
  for (int64_t n = 0; n < steps; n++) {
    rig_steps(&r, 1);
    const double energy = rig_energy(&r);
    assert_true(isfinite(energy));
    gain = fmax(gain, (energy - first) / first);
    *report = thrum_contact_report_get(r.contact);
    expect_account(report, first);
  }

  rig_free(&r);
  return gain;
}

static void contact_never_adds_energy(void **state) {
  (void)state;
  static const double steps[] = {1e-5, 1e-3, 1e-2, 1e-1}, stiffness[] = {1e-3, 1e3, 1e6, 1e15};
  static const double friction[] = {0, 0.5, 10}, restitution[] = {0, 0.5, 1};

  // the gain of the integrators themselves: two do not conserve this energy
  static const double allowed[] = {2e-3, 1e-2, 1e-3, 1e-2, 1e-9, 1e-2, 1e-9, 1e-9, 1e-9};

  for (int i = 0; i < 9; i++) {
    double worst = 0;
    int64_t redone = 0, declined = 0, made = 0;
    for (int n = 0; n < 4 * 4 * 9; n++) {
      const double dt = steps[n % 4];
      // the body starts some steps above the floor
      const extreme x = {all_integrators[i],  dt,  stiffness[n / 4 % 4], friction[n / 16 % 3],
                         restitution[n / 48], 0.1, fmin(10.3 * dt, 0.2)};

      // the largest gain of all cases, and how often a step was repeated or declined
      thrum_contact_report report;
      worst = fmax(worst, throw_down(&x, LENGTH_OF_RUN(300, 60), &report));
      redone += report.redone;
      declined += report.declined;
      made += report.steps;
    }

    // the bound is that of the integrator, and no step is made without contact
    print_message("%-8s largest gain %.1e, %lld steps, %lld redone, %lld without contact\n",
                  thrum_integrator_name((thrum_integrator)i), worst, (long long)made,
                  (long long)redone, (long long)declined);
    assert_true(worst <= allowed[i]);
    assert_int_equal(declined, 0);
  }
}

static void a_step_that_gave_too_much_is_made_again(void **state) {
  (void)state;
  // large steps of a flexible body: the prediction is poor, and nothing was lost yet
  const extreme x = {THRUM_INTEGRATOR_ENERGY, 0.01, 1e4, 0, 1, 0.5, 0.5};
  thrum_contact_report report;
  assert_true(throw_down(&x, 600, &report) <= 1e-9);
  print_message("%lld of %lld steps made again\n", (long long)report.redone,
                (long long)report.steps);
  assert_true(report.redone > 0 && report.declined == 0);
}

static void the_account_is_exact(void **state) {
  (void)state;
  // this integrator conserves energy, so the difference is that of the contact's report
  static const double restitution[] = {0, 0.5, 1}, shape[] = {0, 0.2};

  for (int n = 0; n < 6; n++) {
    // a rigid or a flexible body over a floor with restitution, once with a damper
    rig_def def = rig_default();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.shape = shape[n / 3];
    def.points = 4;
    rig r;
    rig_make(&r, &def);

    // the body falls obliquely
    r.floor.restitution = restitution[n % 3];
    r.floor.damping = n == 1 ? 200 : 0;
    r.translation.position[2] = 0.3;
    r.translation.velocity[1] = 2;

    // the energy of the body and that of the contact add up to the first energy at every step
    const double first = rig_energy(&r);
    for (int64_t step = 0; step < LENGTH_OF_RUN(3000, 1000); step++) {
      rig_steps(&r, 1);
      const thrum_contact_report report = thrum_contact_report_get(r.contact);
      const double sum = rig_energy(&r) + report.stored + report.lost;
      assert_true(fabs(sum - first) <= 1e-10 * first);
    }

    rig_free(&r);
  }
}

static void an_obstacle_that_moves_does_work_of_its_own(void **state) {
  (void)state;

  // a body that rests on a floor, both of them rising with the same speed
  const double speed = 0.5;
  rig_def def = rig_default();
  def.points = 4;
  rig r;
  rig_make(&r, &def);
  r.translation.position[2] = r.environment.force[2] / (4 * def.stiffness);
  r.translation.velocity[2] = speed;
  r.floor.velocity[2] = speed;

  // the caller moves the floor with its velocity
  for (int n = 0; n < 2000; n++) {
    rig_steps(&r, 1);
    r.floor.centre[2] += speed * def.dt;
  }

  // the work of the floor lifts the body, and nothing is lost
  const thrum_contact_report report = thrum_contact_report_get(r.contact);
  const double lifted = RIG_MASS * RIG_GRAVITY * speed * 2000 * def.dt;
  assert_true(fabs(report.driven - lifted) <= 1e-9 * lifted);
  assert_true(fabs(report.lost) <= 1e-9 * lifted);
  assert_true(fabs(rig_energy(&r) - report.driven - 0.5 * RIG_MASS * speed * speed) <=
              1e-3 * lifted);
  rig_free(&r);
}

static void a_body_put_into_the_floor_comes_out_slowly(void **state) {
  (void)state;
  static const double stiffness[] = {1e4, 1e8, 1e15};

  for (int n = 0; n < 3; n++) {
    // the body starts 0.1 m deep in the floor
    rig_def def = rig_default();
    def.stiffness = stiffness[n];
    def.points = 4;
    rig r;
    rig_make(&r, &def);
    r.translation.position[2] = -0.1;

    // it comes out no faster than by a fall over that depth
    double fastest = 0;
    for (int step = 0; step < 4000; step++) {
      rig_steps(&r, 1);
      fastest = fmax(fastest, r.translation.velocity[2]);
    }
    const thrum_contact_report report = thrum_contact_report_get(r.contact);
    assert_true(fastest <= sqrt(2 * RIG_GRAVITY * 0.1));

    // it ends at the depth of its weight; the report holds the energy of the initial depth
    const double depth = RIG_MASS * RIG_GRAVITY / (4 * stiffness[n]);
    assert_true(fabs(r.translation.position[2] + depth) <= 1e-6 * 0.1);
    assert_true(fabs(report.granted - 4 * 0.5 * stiffness[n] * 0.01) <= 1e-9 * report.granted);
    rig_free(&r);
  }
}

static void a_snapshot_goes_on_bit_for_bit(void **state) {
  (void)state;

  // a flexible body in the middle of an impact
  rig_def def = rig_default();
  def.points = 5;
  def.shape = 0.2;
  rig r;
  rig_make(&r, &def);
  r.translation.position[2] = 0.01;
  r.translation.velocity[0] = 0.3;
  rig_steps(&r, 60);

  // a snapshot is a copy of the contact, the state and the translation
  const size_t size = thrum_contact_bytes(r.contact);
  void *contact = malloc(size), *body = state_snapshot(r.state);
  assert_non_null(contact);
  memcpy(contact, r.contact, size);
  const thrum_translation translation = r.translation;

  // the same steps from the same snapshot, twice
  double q[2][RIG_RANK];
  thrum_translation end[2];
  for (int n = 0; n < 2; n++) {
    rig_steps(&r, 200);
    state_read(&r.m.model, r.state, q[n], NULL);
    end[n] = r.translation;
    memcpy(r.contact, contact, size);
    memcpy(r.state, body, thrum_state_bytes(r.state));
    r.translation = translation;
  }

  // both continuations are equal
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(&end[0], &end[1], sizeof end[0]);
  free(contact);
  free(body);
  rig_free(&r);
}

static void begin_step_and_end_are_a_step(void **state) {
  (void)state;
  double q[2][RIG_RANK];
  thrum_translation way[2];
  thrum_contact_report report[2];

  for (int apart = 0; apart < 2; apart++) {
    // a flexible body that falls on the floor
    rig_def def = rig_default();
    def.points = 5;
    def.shape = 0.2;
    rig r;
    rig_make(&r, &def);
    r.translation.position[2] = 0.01;
    const thrum_model *model = &r.m.model;

    // one call per step, or the three calls that it consists of
    for (int n = 0; n < 400; n++) {
      if (!apart) {
        rig_steps(&r, 1);
        continue;
      }
      assert_int_equal(thrum_contact_begin(model, r.state, r.contact, &r.environment, NULL),
                       THRUM_OK);
      assert_true(thrum_step(model, r.state, NULL) >= 0);
      assert_int_equal(thrum_contact_end(model, r.state, r.contact, &r.environment, NULL),
                       THRUM_OK);
    }

    state_read(model, r.state, q[apart], NULL);
    way[apart] = r.translation;
    report[apart] = thrum_contact_report_get(r.contact);
    rig_free(&r);
  }

  // there was an impact, no step was repeated, and both runs are equal bit for bit
  assert_true(report[0].redone == 0 && report[0].lost > 0);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(&way[0], &way[1], sizeof way[0]);
  assert_true(report[0].lost == report[1].lost && report[0].stored == report[1].stored);
}

static void a_stiff_pull_follows_its_target(void **state) {
  (void)state;
  static const double steps[] = {1e-5, 1e-3, 1e-1}, stiffness[] = {1e-3, 1e3, 1e9, 1e15};

  for (int n = 0; n < 9 * 3 * 4; n++) {
    // integrators, steps and stiffnesses in all combinations
    rig_def def = rig_default();
    def.integrator = all_integrators[n % 9];
    def.dt = steps[n / 9 % 3];
    def.shape = 0.1;
    if (def.integrator == THRUM_INTEGRATOR_VERLET || def.integrator == THRUM_INTEGRATOR_RK4)
      def.omega = fmin(def.omega, 0.3 / def.dt);

    // a body without weight or floor, pulled at one point
    rig r;
    rig_make(&r, &def);
    r.environment.obstacle_count = 0;
    r.environment.force[2] = 0;
    thrum_pull pull = {.vertices = {2, 2, 2}, .weights = {1, 0, 0}, .damping = -1};
    pull.stiffness = stiffness[n / 27];
    pull.force_max = 1e30;
    r.environment.pulls = &pull;
    r.environment.pull_count = 1;

    // the target moves to and fro, and then rests
    const int moves = LENGTH_OF_RUN(300, 60);
    for (int step = 0; step < 2 * moves; step++) {
      const double at = step < moves ? 0.1 * sin(0.4 * step) : 0.1;
      pull.target[0] = r.m.vertices[6] + at;
      pull.target[1] = r.m.vertices[7];
      pull.target[2] = r.m.vertices[8];
      rig_steps(&r, 1);
      assert_true(fabs(r.translation.position[0]) < 0.5);
    }

    // the pulled point has reached its target where the spring is stiff
    double q[RIG_RANK];
    state_read(&r.m.model, r.state, q, NULL);
    double x = r.translation.position[0] - 0.1;
    for (int i = 0; i < RIG_RANK; i++)
      x += r.m.basis[6 * RIG_RANK + i] * q[i];
    assert_true(stiffness[n / 27] < 1e9 || fabs(x) <= 1e-3);
    rig_free(&r);
  }
}

/* Pulled by a target that jumps, a flexible body keeps a bounded energy at any stiffness. */
static void a_pull_does_not_tear_a_body_apart(void **state) {
  (void)state;
  static const double steps[] = {1e-3, 1e-2}, stiffness[] = {1e3, 1e6, 1e9, 1e15};
  static const thrum_integrator integrators[] = {THRUM_INTEGRATOR_IMEXV, THRUM_INTEGRATOR_ENERGY};
  double largest = 0;

  for (int n = 0; n < 16; n++) {
    // a very flexible body without rigid translation
    rig_def def = rig_default();
    def.integrator = integrators[n % 2];
    def.dt = steps[n / 2 % 2];
    def.shape = 0.5;
    rig r;
    rig_make(&r, &def);
    r.environment.translation = NULL;
    r.environment.obstacle_count = 0;

    // a pull at one point, without a limit of its force
    thrum_pull pull = {.vertices = {2, 2, 2}, .weights = {1, 0, 0}, .damping = -1};
    pull.stiffness = stiffness[n / 4];
    r.environment.pulls = &pull;
    r.environment.pull_count = 1;
    random_state random = {9};

    // about this energy displaces the point by one metre
    double compliance = 0;
    for (int i = 0; i < 3 * RIG_RANK; i++)
      compliance +=
          r.m.basis[6 * RIG_RANK + i] * r.m.basis[6 * RIG_RANK + i] / r.m.omega2[i % RIG_RANK];

    // the target jumps every 60 steps
    for (int step = 0; step < LENGTH_OF_RUN(3000, 600); step++) {
      if (step % 60 == 0)
        random_vector(&random, 3, 2, pull.target);
      rig_steps(&r, 1);
      largest = fmax(largest, state_energy(&r.m.model, r.state).total * compliance);
    }
    rig_free(&r);
  }

  print_message("largest energy: %.2g m^2 over the compliance\n", largest);
  assert_true(largest <= 40);
}

/* A body that flies apart within a step on the floor fails, and all of it stays as it was. */
static void an_energy_beyond_numbers_fails_the_step(void **context) {
  (void)context;
  rig_def def = rig_default();
  def.integrator = THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER;
  def.points = 5;
  def.shape = 0.2;
  def.stiffness = 1e12;
  rig r;
  rig_make(&r, &def);
  r.translation.position[2] = -1e-4;
  const double q[RIG_RANK] = {0}, p[RIG_RANK] = {1e153};
  state_put(&r.m.model, r.state, q, p);

  thrum_error error = {0};
  const thrum_contact_report before = thrum_contact_report_get(r.contact);
  assert_int_equal(thrum_contact_step(&r.m.model, r.state, r.contact, &r.environment, &error),
                   THRUM_NOT_FINITE);
  const thrum_contact_report after = thrum_contact_report_get(r.contact);
  assert_non_null(strstr(error.message, "touch"));
  assert_memory_equal(&after, &before, sizeof before);
  assert_true(r.translation.position[2] == -1e-4);

  // the same of a step in two halves, which cannot put the state back
  assert_int_equal(thrum_contact_begin(&r.m.model, r.state, r.contact, &r.environment, &error),
                   THRUM_OK);
  assert_int_equal(thrum_step(&r.m.model, r.state, &error), THRUM_OK);
  assert_int_equal(thrum_contact_end(&r.m.model, r.state, r.contact, &r.environment, &error),
                   THRUM_NOT_FINITE);
  assert_true(r.translation.position[2] == -1e-4);
  rig_free(&r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(contact_never_adds_energy),
      cmocka_unit_test(a_step_that_gave_too_much_is_made_again),
      cmocka_unit_test(the_account_is_exact),
      cmocka_unit_test(an_obstacle_that_moves_does_work_of_its_own),
      cmocka_unit_test(a_body_put_into_the_floor_comes_out_slowly),
      cmocka_unit_test(a_snapshot_goes_on_bit_for_bit),
      cmocka_unit_test(begin_step_and_end_are_a_step),
      cmocka_unit_test(a_stiff_pull_follows_its_target),
      cmocka_unit_test(a_pull_does_not_tear_a_body_apart),
      cmocka_unit_test(an_energy_beyond_numbers_fails_the_step),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
