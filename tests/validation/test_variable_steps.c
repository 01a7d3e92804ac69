/* Steps whose length is drawn anew each time, as a game's vary: 30 s of free vibration of horse and
 * beam. `energy` keeps its energy, and `imexv` is monitored and gives way to it before it is lost.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "tests/support/random_model.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_folder.h"
#include "validation/experiments/experiment_body.h"

enum { BODIES = 2, STARTS = 2, RANGES = 2 };

static const char *const body_names[BODIES] = {"beam", "horse"};
static const double model_dt = 0.003, duration = LENGTH_OF_RUN(30.0, 5.0), swing = 0.05;

/* Ranges of time steps: half to one and a half times the model's, and the frames of a game [s]. */
static const struct {
  double shortest, longest;
} ranges[RANGES] = {{0.0015, 0.0045}, {0.008, 0.025}};

static const thrum_model *models[BODIES];
static experiment_body bodies[BODIES][STARTS]; /* pushed at the load group, and in the first mode */
static double impulses[BODIES][STARTS];

static int make_bodies(void **context) {
  thrum_error error;
  if (make_folder(context) != 0)
    return 1;

  // each body with both of its starts
  for (int b = 0; b < BODIES; b++) {
    char file[64];
    snprintf(file, sizeof file, "%s.npz", body_names[b]);
    const char *npz = in_folder(file);
    program_result run = thrum_run(folder, "precompute", body_names[b], "-o", npz, "-q", NULL);
    const int code = run.exit_code;
    program_result_free(&run);
    const double softest[3] = {0, 0, 0};
    if (code != 0 || thrum_model_load(npz, &models[b], &error) < 0 ||
        experiment_body_init(body_names[b], models[b], "load", softest, &bodies[b][0], &error) <
            0 ||
        experiment_body_smooth(&bodies[b][0], &bodies[b][1], &error) < 0)
      return 1;

    // the impulse that gives the wanted swing
    for (int start = 0; start < STARTS; start++) {
      double reached;
      if (experiment_impulse(&bodies[b][start], swing, model_dt, &impulses[b][start], &reached,
                             &error) < 0)
        return 1;
    }
  }
  return 0;
}

static int free_bodies(void **context) {
  for (int b = 0; b < BODIES; b++) {
    for (int start = 0; start < STARTS; start++)
      experiment_body_free(&bodies[b][start]);
    thrum_model_destroy(models[b]);
  }
  return remove_folder(context);
}

/* The end of a run. */
typedef struct outcome {
  thrum_state_report report;
  thrum_status status;   /* of the last step */
  double energy_error;   /* the largest, relative to the energy of the start, */
  double energy_last;    /* and that of the end */
  double single, learnt; /* steps with one evaluation, and Jacobians, a step */
} outcome;

/* Steps a body from the start of that number, with steps drawn from that range, or all of its mean;
 * until its energy has grown tenfold. */
static outcome run(int b, int start, int range, bool drawn, thrum_integrator integrator,
                   thrum_split_form form) {
  const double shortest = ranges[range].shortest, longest = ranges[range].longest;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.split_form = form;
  def.dt = 0.5 * (shortest + longest);
  thrum_state *state = NULL;
  double first = 0;
  assert_int_equal(thrum_state_create(models[b], &def, &state, NULL), THRUM_OK);
  assert_int_equal(experiment_kick(&bodies[b][start], impulses[b][start], state, &first, NULL),
                   THRUM_OK);

  // a run ends early when its energy has grown tenfold
  random_state random = {5};
  outcome made = {.status = THRUM_OK};
  while (made.report.time < duration && made.status >= 0 && made.energy_error < 9) {
    if (drawn) {
      double between;
      random_vector(&random, 1, 1.0, &between);
      const double dt = def.dt + 0.5 * (longest - shortest) * between;
      assert_int_equal(thrum_state_set_dt(models[b], state, dt, NULL), THRUM_OK);
    }
    made.status = thrum_step(models[b], state, NULL);
    made.report = thrum_state_report_get(state);
    thrum_energies energies = {NAN, NAN, NAN, NAN};
    thrum_state_energies(models[b], state, &energies, NULL);
    made.energy_last = fabs(energies.total / first - 1);
    made.energy_error = fmax(made.energy_error, made.energy_last);
  }
  made.single = (double)made.report.single_steps / (double)made.report.steps;
  made.learnt = (double)made.report.factorisations / (double)made.report.steps;
  thrum_state_destroy(state);
  return made;
}

static void energy_keeps_its_energy(void **context) {
  (void)context;
  for (int b = 0; b < BODIES; b++)
    for (int start = 0; start < STARTS; start++)
      for (int range = 0; range < RANGES; range++) {
        const outcome made = run(b, start, range, true, THRUM_INTEGRATOR_ENERGY, 0);
        if (made.status < 0 || !(made.energy_error < 1e-12))
          fail_msg("%s, start %d, steps %d: status %d, energy error %.2e", body_names[b], start,
                   range, (int)made.status, made.energy_error);
      }
}

/* Guesses and inverses go on over a change of the step: smooth motion takes one evaluation a step
 * and a Jacobian in eight steps, as with steps of one length. */
static void drawn_steps_cost_what_even_ones_do(void **context) {
  (void)context;
  for (int b = 0; b < BODIES; b++) {
    const outcome drawn = run(b, 1, 0, true, THRUM_INTEGRATOR_ENERGY, 0);
    const outcome even = run(b, 1, 0, false, THRUM_INTEGRATOR_ENERGY, 0);
    if (!(drawn.single > even.single - 0.02 && drawn.learnt < even.learnt + 0.02 &&
          drawn.single > 0.9 && drawn.learnt < 0.15))
      fail_msg("%s: %.3f of the steps single, %.3f with even ones; %.3f Jacobians a step, %.3f",
               body_names[b], drawn.single, even.single, drawn.learnt, even.learnt);
  }
}

static void imexv_gives_way_before_it_is_lost(void **context) {
  (void)context;
  static const thrum_split_form forms[] = {THRUM_FORM_POSITION, THRUM_FORM_THESIS,
                                           THRUM_FORM_QUADRATIC};
  for (int b = 0; b < BODIES; b++)
    for (int start = 0; start < STARTS; start++)
      for (int range = 0; range < RANGES; range++)
        for (size_t n = 0; n < sizeof forms / sizeof forms[0]; n++) {
          const outcome made = run(b, start, range, true, THRUM_INTEGRATOR_IMEXV, forms[n]);
          if (made.status < 0 || !(made.energy_error < 0.35 && made.energy_last < 0.05))
            fail_msg("%s, start %d, steps %d, form %d: status %d, energy error %.2e, last %.2e",
                     body_names[b], start, range, (int)forms[n], (int)made.status,
                     made.energy_error, made.energy_last);

          // a switch is told, and the energy integrator goes on to the end
          if (made.report.scheme == THRUM_SCHEME_ENERGY)
            assert_true(made.status > 0 && made.report.switched_steps > 0);
        }
}

/* Newmark has no account of its energy: smooth motion keeps it, as with steps of one length. */
static void newmark_keeps_the_energy_of_smooth_motion(void **context) {
  (void)context;
  for (int b = 0; b < BODIES; b++)
    for (int range = 0; range < RANGES; range++) {
      const outcome made = run(b, 1, range, true, THRUM_INTEGRATOR_NEWMARK, 0);
      assert_int_equal(made.status, THRUM_OK);
      assert_true(made.energy_error < 5e-3);
      assert_true(made.learnt < 1.5);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(energy_keeps_its_energy),
      cmocka_unit_test(drawn_steps_cost_what_even_ones_do),
      cmocka_unit_test(imexv_gives_way_before_it_is_lost),
      cmocka_unit_test(newmark_keeps_the_energy_of_smooth_motion),
  };
  return cmocka_run_group_tests(tests, make_bodies, free_bodies);
}
