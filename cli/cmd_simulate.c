/* `thrum simulate`: steps a model file and writes what happened. The mathematics is the runtime's;
 * here it is asked for, timed, shown and written. SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/run_output.h"
#include "cli/simulate_options.h"
#include "cli/simulate_report.h"

#define STATE_ALIGNMENT 64
#define BATCH_STEPS 1024   /* between two looks at the clock, the progress and the signals */
#define PROGRESS_AFTER 0.5 /* shorter runs show no progress [s] */
#define HASH_CHUNK 65536

/* One run in the making. All arrays lie in `memory`. */
typedef struct simulation {
  const simulate_request *request;
  const thrum_model *model;
  double *memory;
  double *q, *p, *force, *extents; /* rank each */
  double *directions;              /* load_count x rank */
  thrum_load *courses;             /* load_count */
  void *state_memory;
  thrum_state *state;
  cli_run_output output;
  cli_progress progress;
  simulate_figures figures;
  double began; /* the steps [s] */
} simulation;

/* Set by the first Ctrl-C; the second one ends the program as usual. */
static volatile sig_atomic_t stop_requested;

static void request_stop(int signal_number) {
  (void)signal_number;
  stop_requested = 1;
}

/* What the caller has set to be ignored, as nohup does, stays so. A file beyond the size limit is
 * to be an error of writing and not the end of the program. */
static void watch_signals(void) {
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
#ifdef SIGXFSZ
  signal(SIGXFSZ, SIG_IGN);
#endif
}

/* 64-bit FNV-1a of a file's bytes. */
static thrum_status hash_file(const char *path, uint64_t *hash, thrum_error *error) {
  static const uint64_t offset = UINT64_C(0xcbf29ce484222325), prime = UINT64_C(0x100000001b3);
  FILE *file = fopen(path, "rb");
  unsigned char *bytes = malloc(HASH_CHUNK);
  uint64_t value = offset;
  bool failed = file == NULL || bytes == NULL;
  for (size_t count = 1; !failed && count > 0;) {
    count = fread(bytes, 1, HASH_CHUNK, file);
    for (size_t n = 0; n < count; n++)
      value = (value ^ bytes[n]) * prime;
    failed = ferror(file) != 0;
  }
  free(bytes);
  if (file != NULL)
    fclose(file);
  if (failed)
    return thrum_error_set(error, THRUM_IO, "%.300s: cannot be read", path);
  *hash = value;
  return THRUM_OK;
}

static thrum_status allocate(simulation *run, thrum_error *error) {
  const size_t rank = (size_t)run->model->rank, loads = (size_t)run->request->load_count;
  run->memory = calloc((4 + loads) * rank, sizeof *run->memory);
  run->courses = calloc(loads + 1, sizeof *run->courses);
  if (run->memory == NULL || run->courses == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a run of this model");
  run->q = run->memory;
  run->p = run->q + rank;
  run->force = run->p + rank;
  run->extents = run->force + rank;
  run->directions = run->extents + rank;
  return THRUM_OK;
}

static thrum_status reduce_loads(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  for (int64_t n = 0; n < request->load_count; n++) {
    const cli_load *load = &request->loads[n];
    const thrum_status status =
        cli_load_reduce(run->model, load, run->directions + n * run->model->rank, error);
    if (status < 0)
      return status;
    run->courses[n] = load->course;
  }
  return THRUM_OK;
}

static thrum_status make_start(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  for (int64_t n = 0; n < request->start_count; n++) {
    const thrum_status status =
        cli_start_add(run->model, &request->starts[n], run->q, run->p, error);
    if (status < 0)
      return status;
  }
  return THRUM_OK;
}

/* What is allowed and yet hardly meant; said when nothing can be refused any more. */
static void warn_before(const simulation *run) {
  const simulate_request *request = run->request;
  const int64_t rank = run->model->rank;
  if (request->load_count == 0 && request->start_count == 0)
    cli_warn("no --load and no --start: the body stays at rest");
  for (int64_t n = 0; n < request->load_count; n++) {
    bool idle = true;
    for (int64_t i = 0; i < rank; i++)
      idle = idle && run->directions[n * rank + i] == 0;
    if (idle)
      cli_warn("--load '%s' moves nothing: it is zero, or all of its vertices are held",
               request->loads[n].text);
  }
  // an explicit mode beyond the bound of Stoermer-Verlet grows from the first step on (design 4)
  const int32_t count = thrum_state_report_get(run->state).explicit_modes;
  const double dt = request->def.dt;
  if (count > 0 && dt * sqrt(run->model->omega2[count - 1]) >= 2) {
    cli_warn("explicit mode %d is beyond the stability bound: dt omega = %.3g, not below 2",
             (int)count, dt * sqrt(run->model->omega2[count - 1]));
  }
}

static thrum_status make_state(simulation *run, thrum_error *error) {
  const thrum_state_def *def = &run->request->def;
  thrum_error detail = {0};
  size_t size = 0;
  if (def->split_rule == THRUM_SPLIT_COUNT && def->explicit_count > run->model->rank) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--split %d: the model has only %lld modes", (int)def->explicit_count,
                           (long long)run->model->rank);
  }
  thrum_status status = thrum_state_size(run->model, def, &size, error);
  if (status < 0)
    return status;
  // aligned_alloc wants a multiple of the alignment
  size = (size + STATE_ALIGNMENT - 1) / STATE_ALIGNMENT * STATE_ALIGNMENT;
  run->state_memory = aligned_alloc(STATE_ALIGNMENT, size);
  if (run->state_memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a state of %zu bytes", size);
  status = thrum_state_init(run->state_memory, size, run->model, def, &run->state, error);
  if (status < 0)
    return status;
  status = thrum_state_set(run->model, run->state, run->q, run->p, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "--start: %s", detail.message);
  return THRUM_OK;
}

/* Time after `step` steps: a product, where the state's own sum gathers rounding. */
static double time_at(const simulation *run, int64_t step) {
  return (double)step * run->request->def.dt;
}

/* Energies and displacement at the present step; a row of the series when `row` is one. */
static thrum_status observe(simulation *run, int64_t row, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const int64_t step = thrum_state_report_get(run->state).steps;
  thrum_energies energies;
  thrum_status status = thrum_state_get(run->model, run->state, run->q, NULL, error);
  if (status >= 0)
    status = thrum_state_energies(run->model, run->state, &energies, error);
  if (status == THRUM_NOT_FINITE && step > 0) {
    // the state is finite, its energy is not any more: the run ends here, the rows before stand
    figures->status = status;
    return thrum_error_set(&figures->stop, THRUM_OK, "%s", error->message);
  }
  if (status < 0)
    return status;
  simulate_figures_add(figures, row, &energies);
  if (run->model->basis != NULL) {
    status = thrum_displacement_peak(run->model, run->extents, run->q, &figures->peak,
                                     &figures->peak_vertex, error);
    if (status < 0)
      return status;
  }
  if (row < 0)
    return THRUM_OK;
  return cli_run_output_record(&run->output, step, time_at(run, step), run->q, &energies, error);
}

/* Steps up to `target` or until a step fails or somebody asks to stop. */
static void advance(simulation *run, int64_t target) {
  const simulate_request *request = run->request;
  simulate_figures *figures = &run->figures;
  const thrum_model *model = run->model;
  const double began = cli_seconds();
  for (int64_t step = thrum_state_report_get(run->state).steps; step < target; step++) {
    thrum_status status = THRUM_OK;
    if (stop_requested)
      break;
    if (request->load_count > 0) {
      thrum_load_sum(run->courses, run->directions, request->load_count, model->rank, step,
                     request->def.dt, run->force);
      status = thrum_state_set_force(model, run->state, run->force, &figures->stop);
    }
    if (status >= 0)
      status = thrum_step(model, run->state, &figures->stop);
    if (status < 0) {
      figures->status = status;
      break;
    }
    figures->fallback_steps += status == THRUM_FELL_BACK;
  }
  figures->seconds_step += cli_seconds() - began;
}

/* The step at which something is due next. */
static int64_t next_stop(const simulate_request *request, int64_t step, int64_t frame_step) {
  int64_t target = step + BATCH_STEPS;
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
  status = thrum_state_get(run->model, run->state, run->q, NULL, error);
  if (status >= 0)
    status = cli_run_output_frame(&run->output, time_at(run, step), run->q, error);
  *frame_step = simulate_frame_step(run->request, run->output.frames);
  return status;
}

/* The whole run: rows and frames where they are due, steps between. */
static thrum_status run_steps(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  int64_t frame_step = run->output.displacement != NULL ? 0 : INT64_MAX;
  int64_t step = 0;
  thrum_status status = write_due(run, 0, &frame_step, error);
  while (status >= 0 && step < request->steps && run->figures.status >= 0 && !stop_requested) {
    advance(run, next_stop(request, step, frame_step));
    step = thrum_state_report_get(run->state).steps;
    status = write_due(run, step, &frame_step, error);
    if (cli_seconds() - run->began > PROGRESS_AFTER) {
      cli_progress_update(&run->progress, "simulate", (double)step / (double)request->steps);
      run->progress.began = run->began;
    }
  }
  if (status >= 0 && run->figures.status != THRUM_NOT_FINITE && step % request->record_every != 0)
    status = observe(run, -1, error);
  return status;
}

/* Says why a run ended before its time. */
static void note_end(simulation *run) {
  simulate_figures *figures = &run->figures;
  const char *name = run->request->model_path;
  figures->report = thrum_state_report_get(run->state);
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

static thrum_status finish_output(simulation *run, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const simulate_request *request = run->request;
  char title[256];
  snprintf(title, sizeof title, "%.120s: %s, dt = %g s", cli_basename(request->model_path),
           simulate_integrator_name(request->def.integrator), request->def.dt);
  thrum_status status = thrum_state_get(run->model, run->state, run->q, run->p, error);
  // a run that left the range of finite numbers may have no end to continue from
  const bool whole = status >= 0;
  if (whole || status == THRUM_NOT_FINITE)
    status = cli_run_output_end(&run->output, whole ? run->q : NULL, run->p, error);
  const double plotting = cli_seconds();
  figures->seconds_output = plotting - run->began - figures->seconds_step;
  if (status >= 0)
    cli_run_output_plot(&run->output, title);
  return status;
}

/* run.json holds the seconds up to its own writing. */
static thrum_status report(simulation *run, double began, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const double now = cli_seconds();
  figures->seconds_total = now - began;
  figures->seconds_plot = now - run->began - figures->seconds_step - figures->seconds_output;
  cJSON *object = simulate_report_json(figures, &run->output);
  const thrum_status status = cli_run_output_commit(&run->output, object, error);
  if (status < 0 || !run->request->json) {
    cJSON_Delete(object);
    if (status >= 0)
      simulate_report_table(figures, &run->output);
    return status;
  }
  cli_json_print(object);
  return status;
}

static void warn_flags(const simulate_figures *figures) {
  if (figures->stop.message[0] != 0)
    cli_warn("%s", figures->stop.message);
  if (figures->fallback_steps > 0)
    cli_warn("%" PRId64 " steps needed a fallback beyond quasi-Newton", figures->fallback_steps);
  if (figures->energy_grew)
    cli_warn("the energy grew by %.3g %% without a load", 100 * figures->drift);
}

/* All that can be refused, before anything is written. */
static thrum_status prepare(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  thrum_status status = allocate(run, error);
  if (status >= 0)
    status = reduce_loads(run, error);
  if (status >= 0)
    status = make_start(run, error);
  if (status >= 0)
    status = make_state(run, error);
  if (status >= 0 && run->model->basis != NULL)
    status = thrum_basis_extents(run->model, run->extents, error);
  run->figures.peak = run->model->basis != NULL ? 0 : NAN;
  run->figures.peak_vertex = -1;
  const bool frames = request->frames_rate > 0 || request->frames_every > 0;
  if (status >= 0)
    status = cli_run_output_open(request->run_path, run->model, frames, &run->output, error);
  return status;
}

static thrum_status simulate(simulation *run, double began, thrum_error *error) {
  thrum_status status = prepare(run, error);
  if (status < 0)
    return status;
  warn_before(run);
  run->began = cli_seconds();
  run->figures.seconds_read = run->began - began;
  run->progress = cli_progress_make(run->request->quiet);
  simulate_figures_begin(&run->figures);
  watch_signals();
  status = run_steps(run, error);
  if (status < 0) {
    cli_progress_abandon(&run->progress);
    return status;
  }
  note_end(run);
  if (run->figures.report.steps == run->request->steps) {
    cli_progress_done(&run->progress);
  } else {
    cli_progress_abandon(&run->progress);
  }
  status = finish_output(run, error);
  if (status >= 0)
    status = report(run, began, error);
  if (status >= 0)
    warn_flags(&run->figures);
  return status;
}

static int run_request(const simulate_request *request) {
  const double began = cli_seconds();
  thrum_error error = {0};
  simulation *run = calloc(1, sizeof *run);
  if (run == NULL) {
    error.status = THRUM_OUT_OF_MEMORY;
    return cli_refuse(&error);
  }
  run->request = request;
  thrum_status status = thrum_model_load(request->model_path, &run->model, &error);
  if (status >= 0)
    status = hash_file(request->model_path, &run->figures.model_hash, &error);
  run->figures.request = request;
  run->figures.model = run->model;
  if (status >= 0)
    status = simulate(run, began, &error);
  int code = status < 0 ? cli_refuse(&error) : CLI_DONE;
  if (status >= 0 && (run->figures.status != THRUM_OK || run->figures.energy_grew))
    code = CLI_FLAGGED;
  cli_run_output_close(&run->output);
  free(run->memory);
  free(run->courses);
  free(run->state_memory);
  thrum_model_free(run->model);
  free(run);
  return code;
}

int cmd_simulate(int argc, char **argv) {
  simulate_request request = {0};
  // no more loads and starts than arguments
  request.loads = calloc((size_t)argc, sizeof *request.loads);
  request.starts = calloc((size_t)argc, sizeof *request.starts);
  int code = CLI_DONE;
  if (request.loads == NULL || request.starts == NULL) {
    const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
    code = cli_refuse(&error);
  } else {
    code = simulate_options_read(argc, argv, &request);
    if (code == CLI_DONE && request.help) {
      simulate_help();
    } else if (code == CLI_DONE) {
      code = run_request(&request);
    }
  }
  free(request.loads);
  free(request.starts);
  return code;
}
