/* The loop of `thrum simulate`: steps in batches between the rows and frames that are due, timed
 * apart from the output. SPDX-License-Identifier: Apache-2.0 */
#include "driver/simulate_run.h"

#include <inttypes.h>
#include <signal.h>
#include <string.h>

#include "config/progress.h"
#include "driver/simulate_full.h"
#include "platform/clock.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"

/* Set by the first Ctrl-C; the second one ends the program as usual. */
static volatile sig_atomic_t stop_requested;

static void request_stop(int signal_number) {
  (void)signal_number;
  stop_requested = 1;
}

bool simulate_stop_requested(void) {
  return stop_requested != 0;
}

/* What the caller has set to be ignored, as nohup does, stays so. */
void simulate_watch_signals(void) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  for (size_t n = 0; n < sizeof signals / sizeof signals[0]; n++) {
    struct sigaction action;
    if (sigaction(signals[n], NULL, &action) != 0 || action.sa_handler == SIG_IGN)
      continue;
    memset(&action, 0, sizeof action);
    action.sa_handler = request_stop;
    action.sa_flags = (int)SA_RESETHAND;
    sigemptyset(&action.sa_mask);
    sigaction(signals[n], &action, NULL);
  }
}

/* Time after `step` steps: a product, where the state's own sum gathers rounding. */
static double time_at(const simulation *run, int64_t step) {
  return (double)step * run->request->def.dt;
}

static int64_t steps_done(const simulation *run) {
  return run->full != NULL ? simulate_full_report(run).steps
                           : thrum_state_report_get(run->state).steps;
}

/* run->q and the energies of the present step, and the peak of the displacements so far. */
static thrum_status see(simulation *run, thrum_energies *energies, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  if (run->full != NULL)
    return simulate_full_see(run, energies, error);
  thrum_status status = thrum_state_get(run->model, run->state, run->q, NULL, error);
  if (status >= 0)
    status = thrum_state_energies(run->model, run->state, energies, error);
  if (status >= 0 && run->model->basis != NULL)
    status = thrum_displacement_peak(run->model, run->extents, run->q, &figures->peak,
                                     &figures->peak_vertex, error);
  return status;
}

/* Energies and displacement at the present step; a row of the series when `row` is one. */
static thrum_status observe(simulation *run, int64_t row, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const int64_t step = steps_done(run);
  thrum_energies energies;
  thrum_status status = see(run, &energies, error);
  if (status == THRUM_NOT_FINITE && step > 0) {
    // the state is finite, its energy is not any more: the run ends here, the rows before stand
    figures->status = status;
    return thrum_error_set(&figures->stop, THRUM_OK, "%s", error->message);
  }
  if (status < 0)
    return status;
  simulate_figures_add(figures, row, &energies);
  status = simulate_measures_look(&run->measures, run->q, time_at(run, step), error);
  if (status < 0 || row < 0)
    return status;
  return cli_run_output_record(&run->output, step, time_at(run, step), run->q, &energies, error);
}

/* Loads and the base's motion of a step into run->force; the latter alone into run->inertia. */
static thrum_status set_force(simulation *run, int64_t step) {
  const simulate_request *request = run->request;
  const size_t rank = (size_t)run->model->rank;
  if (request->load_count == 0 && request->base_motion_count == 0)
    return THRUM_OK;
  thrum_load_sum(run->courses, run->directions, request->load_count, run->model->rank, step,
                 request->def.dt, run->force);
  if (request->base_motion_count > 0) {
    double mean[3];
    cli_base_motions_mean(request->base_motions, request->base_motion_count, step, request->def.dt,
                          mean);
    memset(run->inertia, 0, rank * sizeof *run->inertia);
    const thrum_status status =
        thrum_base_motion_load(run->model, mean, run->inertia, &run->figures.stop);
    if (status < 0)
      return status;
    for (size_t i = 0; i < rank; i++)
      run->force[i] += run->inertia[i];
  }
  return thrum_state_set_force(run->model, run->state, run->force, &run->figures.stop);
}

/* What the step from run->before did for the energy; run->before is then the step's end. */
static void count_work(simulation *run) {
  const thrum_state_def *def = &run->request->def;
  simulate_figures *figures = &run->figures;
  const int64_t rank = run->model->rank;
  thrum_state_get(run->model, run->state, run->after, NULL, NULL);
  if (run->request->load_count > 0 || run->request->base_motion_count > 0) {
    const double all = thrum_load_work(run->force, run->before, run->after, rank);
    const double base = thrum_load_work(run->inertia, run->before, run->after, rank);
    figures->work_load += all - base;
    figures->work_base += base;
  }
  figures->dissipated += thrum_damping_loss(run->model, def->damping_alpha, def->damping_beta,
                                            run->before, run->after, def->dt);
  memcpy(run->before, run->after, (size_t)rank * sizeof *run->before);
}

/* One step under its loads, counted. */
static thrum_status step_once(simulation *run, int64_t step, bool worked) {
  if (run->full != NULL)
    return simulate_full_step(run, step);
  thrum_status status = set_force(run, step);
  if (status >= 0)
    status = thrum_step(run->model, run->state, &run->figures.stop);
  if (status >= 0 && worked)
    count_work(run);
  return status;
}

/* Steps up to `target` or until a step fails or somebody asks to stop. */
static void advance(simulation *run, int64_t target) {
  const simulate_request *request = run->request;
  simulate_figures *figures = &run->figures;
  const bool worked = request->load_count > 0 || request->base_motion_count > 0 ||
                      request->def.damping_alpha > 0 || request->def.damping_beta > 0;
  if (run->full == NULL)
    thrum_state_get(run->model, run->state, run->before, NULL, NULL);
  const double began = clock_seconds();
  for (int64_t step = steps_done(run); step < target; step++) {
    if (stop_requested)
      break;
    const thrum_status status = step_once(run, step, worked);
    if (status < 0) {
      figures->status = status;
      break;
    }
    figures->fallback_steps += status == THRUM_FELL_BACK;
  }
  figures->seconds_step += clock_seconds() - began;
}

/* The step at which something is due next. */
static int64_t next_stop(const simulate_request *request, int64_t step, int64_t frame_step) {
  int64_t target = step + (request->full ? 1 : SIMULATE_BATCH_STEPS);
  const int64_t record = (step / request->record_every + 1) * request->record_every;
  if (record < target)
    target = record;
  if (frame_step < target)
    target = frame_step;
  return target < request->steps ? target : request->steps;
}

/* Writes the row and the frame that are due at this step. */
static thrum_status write_due(simulation *run, int64_t step, int64_t *frame_step,
                              thrum_error *error) {
  thrum_status status = THRUM_OK;
  // the counts move on, so a step that could not be left is not written twice
  if (step == run->output.rows * run->request->record_every)
    status = observe(run, run->output.rows, error);
  if (status < 0 || step != *frame_step)
    return status;
  const double time = time_at(run, step);
  double base[3] = {0};
  if (run->request->ground)
    cli_base_motions_position(run->request->base_motions, run->request->base_motion_count, time,
                              base);
  if (run->full != NULL) {
    status = simulate_full_frame(run, time, base, error);
    *frame_step = simulate_frame_step(run->request, run->output.frames);
    return status;
  }
  status = thrum_state_get(run->model, run->state, run->q, NULL, error);
  if (status >= 0)
    status = simulate_measures_look(&run->measures, run->q, time, error);
  if (status >= 0)
    status = cli_run_output_frame(&run->output, time, run->q, base, run->measures.von_mises, error);
  *frame_step = simulate_frame_step(run->request, run->output.frames);
  return status;
}

/* The whole run: rows and frames where they are due, steps between. */
thrum_status simulate_run_steps(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  int64_t frame_step = run->output.displacement != NULL ? 0 : INT64_MAX;
  int64_t step = 0;
  thrum_status status = write_due(run, 0, &frame_step, error);
  while (status >= 0 && step < request->steps && run->figures.status >= 0 && !stop_requested) {
    advance(run, next_stop(request, step, frame_step));
    step = steps_done(run);
    status = write_due(run, step, &frame_step, error);
    if (clock_seconds() - run->began > SIMULATE_PROGRESS_AFTER) {
      config_progress_update(&run->progress, "simulate", (double)step / (double)request->steps);
      run->progress.began = run->began;
    }
  }
  if (status >= 0 && run->figures.status != THRUM_NOT_FINITE && step % request->record_every != 0)
    status = observe(run, -1, error);
  return status;
}

/* Says why a run ended before its time. */
void simulate_note_end(simulation *run) {
  simulate_figures *figures = &run->figures;
  const char *name = run->request->model_path;
  figures->report =
      run->full != NULL ? simulate_full_report(run) : thrum_state_report_get(run->state);
  figures->full = simulate_full_figures(run);
  const double time = time_at(run, figures->report.steps);
  figures->report.time = time;
  if (figures->status < 0) {
    thrum_error detail = figures->stop;
    thrum_error_set(&figures->stop, figures->status,
                    "%.100s: stopped at %g s, step %" PRId64 ": %s", name, time,
                    figures->report.steps,
                    detail.message[0] != 0 ? detail.message : thrum_status_text(figures->status));
  } else if (figures->report.steps < run->request->steps) {
    figures->status = THRUM_INTERRUPTED;
    thrum_error_set(&figures->stop, THRUM_INTERRUPTED, "%.100s: interrupted at %g s, step %" PRId64,
                    name, time, figures->report.steps);
  } else {
    // the texts of fallbacks are no reason to have stopped
    figures->stop.message[0] = 0;
    if (figures->fallback_steps > 0)
      figures->status = THRUM_FELL_BACK;
  }
  simulate_figures_end(figures);
}
