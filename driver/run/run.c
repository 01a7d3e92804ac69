/* The loop of a run: steps in batches between the rows and frames that are due, timed apart from
 * the output. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/run.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "config/message.h"
#include "driver/model/model_meta.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/stop_request.h"

#define PROGRESS_AFTER 0.5 /* shorter runs show no progress [s] */

thrum_status driver_run_open(driver_run *run, int32_t body_count, thrum_error *error) {
  THRUM_TRY(thrum_reserve(&run->bodies, body_count, sizeof *run->bodies, "a run", error));
  run->body_count = body_count;
  return THRUM_OK;
}

void driver_run_close(driver_run *run) {
  for (int32_t n = 0; n < run->body_count; n++) {
    run_output_close(&run->bodies[n].output);
    run_probes_close(&run->bodies[n].probes);
    simulate_measures_close(&run->bodies[n].measures);
    free(run->bodies[n].q);
  }
  free(run->bodies);
  driver_stepper_close(&run->stepper);
  *run = (driver_run){0};
}

int64_t driver_run_step_count(const driver_run *run) {
  return run->stepper.kind->steps(run->stepper.self);
}

/* Steps up to `target`, or until a step fails or the user asks to stop. */
static thrum_status advance(driver_run *run, int64_t step, int64_t target, thrum_error *error) {
  const driver_stepper *stepper = &run->stepper;
  const double began = clock_seconds();
  for (; step < target && run->status >= 0 && !thrum_stop_requested(); step++) {
    const thrum_status status = stepper->kind->advance(stepper->self, step, &run->stop);
    if (status < 0)
      run->status = status;
  }
  run->seconds_step += clock_seconds() - began;

  // no memory says nothing about the body, so it is no result
  if (run->status == THRUM_OUT_OF_MEMORY)
    return thrum_error_set(error, run->status, "%s", run->stop.message);
  return THRUM_OK;
}

/* The step at which a row, a frame or a look at the clock is due next. */
static int64_t next_stop(const driver_run *run, int64_t step, int64_t frame_step) {
  const simulate_request *request = driver_run_request(run);
  int64_t target = (step / request->record_every + 1) * request->record_every;
  if (frame_step < target)
    target = frame_step;
  if (step + run->stepper.kind->steps_between_looks < target)
    target = step + run->stepper.kind->steps_between_looks;
  return target < request->steps ? target : request->steps;
}

/* Writes the row and the frame that are due at this step; *frame_step becomes the next frame's. */
static thrum_status write_due(driver_run *run, int64_t step, int64_t *frame_step,
                              thrum_error *error) {
  const simulate_request *request = driver_run_request(run);
  // the counts move on, so a step that could not be left is not written twice
  if (step == run->rows * request->record_every)
    THRUM_TRY(driver_run_record(run, step, true, error));
  if (run->status < 0 || step != *frame_step)
    return THRUM_OK;
  THRUM_TRY(driver_run_frame(run, step, error));
  *frame_step = simulate_frame_step(request, run->frames);
  return THRUM_OK;
}

static thrum_status loop(driver_run *run, thrum_error *error) {
  const simulate_request *request = driver_run_request(run);
  const bool frames = request->frames_rate > 0 || request->frames_every > 0;
  int64_t frame_step = frames ? 0 : INT64_MAX, step = 0;
  THRUM_TRY(write_due(run, 0, &frame_step, error));
  while (step < request->steps && run->status >= 0 && !thrum_stop_requested()) {
    THRUM_TRY(advance(run, step, next_stop(run, step, frame_step), error));

    // once there is a state to write, a step is waited for
    if (step == 0)
      thrum_stop_request_end_by(NULL, NULL);
    step = driver_run_step_count(run);

    // a failed step is not counted by the bodies that failed, so nothing is due after it
    if (run->status >= 0)
      THRUM_TRY(write_due(run, step, &frame_step, error));
    if (clock_seconds() - run->began > PROGRESS_AFTER) {
      config_progress_update(&run->progress, "simulate", (double)step / (double)request->steps);
      run->progress.began = run->began;
    }
  }

  // the figures include the last state, also where it has no row
  const bool stands = run->status >= 0 ||
                      (run->stepper.kind->stands_after_failure && run->status != THRUM_NOT_FINITE);
  if (stands && step % request->record_every != 0)
    THRUM_TRY(driver_run_record(run, step, false, error));
  return THRUM_OK;
}

/* The figures of a body once its last step is made. */
static void complete_figures(driver_run *run, int32_t n) {
  simulate_figures *figures = &run->bodies[n].figures;
  figures->status = THRUM_OK;
  run->stepper.kind->report(run->stepper.self, n, figures);
  figures->report.time = (double)figures->report.steps * figures->request->def.dt;

  // its own failure says more than that of the run
  if (figures->status >= 0 && run->status < 0)
    figures->status = run->status;
  else if (figures->status >= 0 && figures->fallback_steps > 0)
    figures->status = THRUM_FELL_BACK;
  figures->stop = run->stop;
  simulate_figures_end(figures);
}

/* Says why a run ended before its time. */
static void note_end(driver_run *run) {
  const simulate_request *request = driver_run_request(run);
  const int64_t steps = driver_run_step_count(run);
  const double time = (double)steps * request->def.dt;
  const thrum_error detail = run->stop;
  if (detail.status < 0 && detail.message[0] != 0) {
    // a step that fails tells its number and its time itself, a record that fails (status 0) not
    thrum_error_set(&run->stop, run->status, "%.100s: stopped: %s", run->name, detail.message);
  } else if (run->status < 0) {
    thrum_error_set(&run->stop, run->status, "%.100s: stopped at %g s, step %" PRId64 ": %s",
                    run->name, time, steps,
                    detail.message[0] != 0 ? detail.message : thrum_status_text(run->status));
  } else if (steps < request->steps) {
    run->status = THRUM_INTERRUPTED;
    thrum_error_set(&run->stop, THRUM_INTERRUPTED, "%.100s: interrupted at %g s, step %" PRId64,
                    run->name, time, steps);
  } else {
    // the texts of fallbacks are no reason to have stopped
    run->stop.message[0] = 0;
  }

  for (int32_t n = 0; n < run->body_count; n++) {
    complete_figures(run, n);
    if (run->status == THRUM_OK && run->bodies[n].figures.fallback_steps > 0)
      run->status = THRUM_FELL_BACK;
  }
}

thrum_status driver_run_steps(driver_run *run, bool quiet, thrum_error *error) {
  run->began = clock_seconds();
  run->progress = config_progress_make(quiet);
  const thrum_status status = loop(run, error);
  config_progress_end(&run->progress,
                      status >= 0 && driver_run_step_count(run) == driver_run_request(run)->steps);
  if (status >= 0)
    note_end(run);
  return status;
}

run_outcome driver_run_outcome(const driver_run *run) {
  simulate_figures all = {.status = run->status};
  for (int32_t n = 0; n < run->body_count; n++) {
    all.energy_grew = all.energy_grew || run->bodies[n].figures.energy_grew;
    all.condensed_wrong = all.condensed_wrong || run->bodies[n].figures.condensed_wrong;
    all.basis_wrong = all.basis_wrong || run->bodies[n].figures.basis_wrong;
  }
  return simulate_outcome(&all);
}

/* Energy that the run gained by itself: in its free motion, beside the work of its loads, or as its
 * steps saw it. */
static void warn_of_growth(const simulate_figures *figures, const char *who) {
  const int64_t grown_steps = figures->report.grown_steps;

  // growth in free motion says most, then the gain beside the work, then single steps
  if (figures->grew_freely) {
    double from = 0, to = 0;
    driver_drift_ends(&figures->windows, &from, &to);
    config_warn("%sthe energy grew from %.3g J to %.3g J, the mean of the last tenth of the run, "
                "though %s",
                who, from, to,
                figures->grew_beside_loads ? "the loads did next to no work" : "no load acted");
  } else if (figures->gained) {
    config_warn("%sthe body gained %.3g J that no load did as work", who,
                simulate_figures_balance(figures));
  } else if (figures->energy_grew) {
    config_warn("%sat %" PRId64
                " step%s the energy was more than twice what start and loads explain",
                who, grown_steps, grown_steps == 1 ? "" : "s");
  }
}

#define STIFF_POINTS 1.5 /* stiffness of points that flow over that of the body that is told */

#define STRAIN_BEYOND 1.5 /* plastic strain over the largest of the training that is told */

/* Whether the gradients of the model's points were learned, by the file or, in older ones, meta. */
static bool are_learned(const thrum_model *model) {
  if (model->point_training)
    return model->point_training[THRUM_TRAINING_LEARNED] > 0;
  cJSON *meta = model_meta_parse(model);
  const cJSON *steps = model_meta_find(meta, "cubature", "refine");
  const bool learned = cJSON_IsNumber(steps) && steps->valuedouble > 0;
  cJSON_Delete(meta);
  return learned;
}

/* Whether the model's points were chosen for a body that flows, by precompute --yield or by a yield
 * of a region. */
static bool know_flow(const thrum_model *model) {
  if (model->point_training)
    return model->point_training[THRUM_TRAINING_YIELD] > 0;
  cJSON *meta = model_meta_parse(model);
  const bool told = model_meta_find(meta, "cubature", "test_error") != NULL;
  const bool known = cJSON_IsNumber(model_meta_find(meta, "cubature", "yield"));
  cJSON_Delete(meta);
  return known || !told || model->region_yield != NULL;
}

/* Points see a shape shortened where they have more stiffness than the body that flows; and those
 * that were learned are of no place. */
static void warn_of_points(const simulate_figures *figures, const char *who) {
  if (!figures->request->full && !isinf(figures->request->def.plastic.yield) &&
      are_learned(figures->model))
    config_warn(
        "%sthe gradients of the model's cubature points were learned, so that what flows is "
        "the strain of no place of the body: precompute it without --cubature-refine",
        who);
  else if (!figures->request->full && !isinf(figures->request->def.plastic.yield) &&
           figures->model->point_count > 0 && !know_flow(figures->model))
    config_warn(
        "%sthe model's cubature points were not trained on plastic flow: strain and work of "
        "what flows may be several times too small; precompute it with --yield %g",
        who, figures->request->def.plastic.yield);

  // points that know less flow than this run had
  const double *training = figures->request->full ? NULL : figures->model->point_training;
  const double known = training ? training[THRUM_TRAINING_PLASTIC] : 0;
  if (known > 0 && figures->plastic_strain > STRAIN_BEYOND * known)
    config_warn("%sthe plastic strain reaches %.3g, and the model's cubature points were trained "
                "on up to %.3g: precompute it with a larger --cubature-range",
                who, figures->plastic_strain, known);
  if (figures->point_stiffness > STIFF_POINTS)
    config_warn(
        "%sthe model's cubature points are too few for plastic flow: along one shape they "
        "have %.3g times the stiffness of the body, and strains at them are taken smaller by "
        "the root of that; train them on it (precompute --yield X --train LOAD) or take more "
        "(--cubature-error)",
        who, figures->point_stiffness);
}

/* Is what the run lacks the inertia of what follows, or the energy of few coordinates that are bent
 * far, which the integrator manifold has? */
static bool would_manifold_do(const simulate_figures *figures) {
  return figures->request->def.integrator != THRUM_INTEGRATOR_MANIFOLD &&
         simulate_condensed_believed(0, 0, figures->vibration_share, figures->impact_share);
}

void driver_run_warn(const driver_run *run) {
  // why the run ended early comes first
  if (run->stop.message[0] != 0)
    config_warn("%s", run->stop.message);

  // then each body tells what speaks against its motion
  for (int32_t n = 0; n < run->body_count; n++) {
    const driver_body *body = &run->bodies[n];
    const simulate_figures *figures = &body->figures;

    // in a scene each message names its body
    char who[128] = "";
    if (body->name != NULL)
      snprintf(who, sizeof who, "body '%.100s': ", body->name);

    // solves that were hard, and energy that grew
    warn_of_points(figures, who);
    if (figures->fallback_steps > 0)
      config_warn("%s%" PRId64 " step%s needed %s: a lower --dt makes them easier to solve", who,
                  figures->fallback_steps, figures->fallback_steps == 1 ? "" : "s",
                  figures->full.free_count > 0 ? "to be taken as several shorter ones"
                                               : "a fallback beyond quasi-Newton");
    warn_of_growth(figures, who);

    // coordinates that follow lack inertia, which touch modes show otherwise than slaves
    if (figures->condensed_wrong && figures->follows_loads)
      config_warn("%swhat follows at rest, touch modes, would vibrate by %.2g %% of the motion, "
                  "%.2g %% of which is off after impacts: that is not shown; pull more slowly, or "
                  "step them (thrum precompute --touch-stepped)",
                  who, 100 * figures->vibration_share, 100 * figures->impact_share);
    else if (figures->condensed_wrong)
      config_warn("%sthe condensed model %s %.2g %% of the kinetic energy, has %.2g %% of the "
                  "strain energy wrong where the body is bent most, and lacks vibration of %.2g %% "
                  "of the motion, %.2g %% of which is off after impacts: do not trust this motion; "
                  "take %sanother number of coordinates, or the model uncondensed",
                  who,
                  figures->request->def.integrator == THRUM_INTEGRATOR_MANIFOLD
                      ? "has in what follows"
                      : "leaves out",
                  100 * figures->inertia_share, 100 * figures->energy_defect,
                  100 * figures->vibration_share, 100 * figures->impact_share,
                  would_manifold_do(figures) ? "--integrator manifold, which steps the inertia of "
                                               "what follows, "
                                             : "");

    // the shape: compression, and displacements beyond the reach of the basis
    simulate_measures_warn(&body->measures, who);
  }
}
