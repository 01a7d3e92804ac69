/* Places of a body that a run follows. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/run_probes.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "core/base/plain_text.h"
#include "driver/record/run_plot.h"
#include "io/json.h"
#include "platform/allocate.h"

#define CURVES_MAX 6  /* in the plot */
#define TITLE_MAX 40  /* bytes of a probe's name there, which may double as quotes do */
#define CURVE_MAX 256 /* of a script, beyond which no curve is with such a title */

/* --- what is followed ------------------------------------------------------------------------- */

static thrum_status add(run_probes *probes, const load_target *target, thrum_error *error) {
  run_probe *probe = &probes->list[probes->count];
  *probe = (run_probe){.text = "all"};
  if (target->vertex > 0)
    snprintf(probe->text, sizeof probe->text, "vertex=%" PRId64, target->vertex);
  else if (!target->all)
    snprintf(probe->text, sizeof probe->text, "%s", target->name);
  thrum_plain_text(probe->text);
  THRUM_TRY(load_target_find(probes->model, target, &probe->at, error));
  probes->count++;
  return THRUM_OK;
}

/* Where the loads act; a target of two loads is followed once, and the whole body is no place. */
static thrum_status add_of_loads(const simulate_request *request, run_probes *probes,
                                 thrum_error *error) {
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n];
    bool seen = load->gravity || load->target.all;
    for (int64_t k = 0; k < n && !seen; k++)
      seen = load_target_equal(&request->loads[k].target, &load->target);
    if (!seen)
      THRUM_TRY(add(probes, &load->target, error));
  }
  return THRUM_OK;
}

/* A name for the head of a column, without commas and quotes. */
static void put_name(FILE *rows, const char *text) {
  for (const char *c = text; *c != 0; c++)
    fputc(*c == ',' ? ' ' : *c == '"' ? '\'' : *c, rows);
}

static bool put_head(const run_probes *probes) {
  static const char *const axes[] = {"x_m", "y_m", "z_m"};
  fputs("step,time_s", probes->rows);
  for (int64_t n = 0; n < probes->count; n++)
    for (int axis = 0; axis < 3; axis++) {
      fputc(',', probes->rows);
      put_name(probes->rows, probes->list[n].text);
      fprintf(probes->rows, ".%s", axes[axis]);
    }
  return fputc('\n', probes->rows) != EOF;
}

static thrum_status open_probes(const simulate_request *request, const run_folder *folder,
                                run_probes *probes, thrum_error *error) {
  const int64_t most = request->probe_count + request->load_count;
  THRUM_TRY(thrum_reserve(&probes->list, most + 1, sizeof *probes->list, "the probes", error));
  for (int64_t n = 0; n < request->probe_count; n++)
    THRUM_TRY(config_error_in(error, add(probes, &request->probes[n].target, error),
                              "--probe '%.100s'", request->probes[n].name));
  if (request->probe_count == 0)
    THRUM_TRY(add_of_loads(request, probes, error));
  if (probes->count == 0)
    return THRUM_OK;
  if (probes->full)
    THRUM_TRY(thrum_reserve(&probes->field, 3 * probes->model->vertex_count, sizeof(double),
                            "the probes", error));
  errno = 0;
  probes->rows = run_folder_create(folder, RUN_PROBES_CSV);
  return probes->rows != NULL && put_head(probes)
             ? THRUM_OK
             : run_folder_write_failed(folder, RUN_PROBES_CSV, error);
}

thrum_status run_probes_open(const simulate_request *request, const thrum_model *model,
                             const run_folder *folder, run_probes *probes, thrum_error *error) {
  *probes = (run_probes){.model = model, .full = request->full};

  // a model without shapes has no places to follow
  const bool shapes = model->vertices != NULL && (request->full || model->basis != NULL);
  if (!shapes && request->probe_count == 0)
    return THRUM_OK;
  const thrum_status status =
      shapes ? open_probes(request, folder, probes, error)
             : thrum_error_set(error, THRUM_MISSING,
                               "--probe: the model has no mesh or no basis to follow a place of");
  if (status < 0)
    run_probes_close(probes);
  return status;
}

/* --- rows ------------------------------------------------------------------------------------- */

/* The mean of what moves there. */
static thrum_status mean_of(const run_probes *probes, const run_probe *probe, const double *q,
                            double mean[3], thrum_error *error) {
  if (!probes->full)
    return thrum_displacement_mean(probes->model, probe->at.list, probe->at.count, q, mean, error);
  double sum[3] = {0};
  for (int64_t n = 0; n < probe->at.count; n++)
    for (int axis = 0; axis < 3; axis++)
      sum[axis] += probes->field[3 * (probe->at.list != NULL ? probe->at.list[n] : n) + axis];
  for (int axis = 0; axis < 3; axis++)
    mean[axis] = sum[axis] / (double)probe->at.count;
  return THRUM_OK;
}

static void note(run_probe *probe, double time) {
  const double *u = probe->last;
  const double away = hypot(hypot(u[0], u[1]), u[2]);
  if (away > probe->farthest) {
    probe->farthest = away;
    probe->farthest_time = time;
  }
  for (int axis = 0; axis < 3; axis++) {
    probe->low[axis] = fmin(probe->low[axis], u[axis]);
    probe->high[axis] = fmax(probe->high[axis], u[axis]);
  }
}

thrum_status run_probes_record(run_probes *probes, const run_folder *folder, int64_t step,
                               double time, const double *q, thrum_error *error) {
  if (probes->rows == NULL)
    return THRUM_OK;
  errno = 0;
  bool done = fprintf(probes->rows, "%" PRId64 ",%.17g", step, time) > 0;
  for (int64_t n = 0; n < probes->count; n++) {
    run_probe *probe = &probes->list[n];
    THRUM_TRY(mean_of(probes, probe, q, probe->last, error));
    note(probe, time);
    const double *u = probe->last;
    done = done && fprintf(probes->rows, ",%.17g,%.17g,%.17g", u[0], u[1], u[2]) > 0;
  }
  done = done && fputc('\n', probes->rows) != EOF;
  probes->row_count++;
  return done ? THRUM_OK : run_folder_write_failed(folder, RUN_PROBES_CSV, error);
}

thrum_status run_probes_end(run_probes *probes, const run_folder *folder, thrum_error *error) {
  errno = 0;
  return run_folder_close_file(&probes->rows)
             ? THRUM_OK
             : run_folder_write_failed(folder, RUN_PROBES_CSV, error);
}

void run_probes_close(run_probes *probes) {
  for (int64_t n = 0; n < probes->count; n++)
    load_vertices_free(&probes->list[n].at);
  free(probes->list);
  free(probes->field);
  if (probes->rows != NULL)
    fclose(probes->rows);
  *probes = (run_probes){0};
}

/* --- what is said ----------------------------------------------------------------------------- */

/* The axis along which it moves furthest. */
static int widest(const run_probe *probe) {
  int found = 0;
  for (int axis = 1; axis < 3; axis++)
    if (probe->high[axis] - probe->low[axis] > probe->high[found] - probe->low[found])
      found = axis;
  return found;
}

void run_probes_plot(run_probes *probes, const run_folder *folder, const char *title) {
  static const char *const strokes[CURVES_MAX] = {
      "lw 2 lc rgb '#08306b'", "dt (8,4) lw 2 lc rgb '#d2600a'",
      "lw 1 lc rgb '#2e8b57'", "dt (2,3) lw 2 lc rgb '#7b3fb3'",
      "lw 1 lc rgb '#6baed6'", "dt (8,4,2,4) lc rgb '#111111'"};
  const int64_t every = run_plot_every(probes->row_count);
  char curves[CURVES_MAX * CURVE_MAX] = "";
  size_t used = 0;
  for (int64_t n = 0; n < probes->count && n < CURVES_MAX; n++) {
    char name[RUN_PLOT_QUOTED];
    const int axis = widest(&probes->list[n]);
    run_plot_quote(probes->list[n].text, TITLE_MAX, name);
    used += (size_t)snprintf(curves + used, sizeof curves - used,
                             "%s'" RUN_PROBES_CSV "' using 2:%d every %" PRId64
                             "::1 with lines %s title '%c of %s' noenhanced",
                             n > 0 ? ", \\\n  " : "", (int)(3 + 3 * n + axis), every, strokes[n],
                             "xyz"[axis], name);
  }
  if (probes->count > 0)
    probes->plot = run_plot_draw(folder->work, &(run_plot){.script = "probes.gp",
                                                           .png = "probes.png",
                                                           .svg = "probes.svg",
                                                           .title = title,
                                                           .vertical = "displacement [m]",
                                                           .settings = "set format y '%.3g'\n",
                                                           .curves = curves});
}

/* The only vertex of a probe; -1: it has more. */
static int64_t only_vertex(const run_probe *probe) {
  return probe->at.count != 1 ? -1 : probe->at.list != NULL ? probe->at.list[0] : 0;
}

void run_probes_json(const run_probes *probes, cJSON *object) {
  cJSON *list = cJSON_AddArrayToObject(object, "probes");
  for (int64_t n = 0; n < probes->count; n++) {
    const run_probe *probe = &probes->list[n];
    const int64_t vertex = only_vertex(probe);
    cJSON *row = json_add_row(list);
    json_string(row, "at", probe->text);
    json_number(row, "vertices", (double)probe->at.count);
    json_number(row, "vertex", vertex >= 0 ? (double)vertex + 1 : NAN);
    if (vertex >= 0)
      json_numbers(row, "place_m", probes->model->vertices + 3 * vertex, 3);
    json_numbers(row, "last_m", probe->last, 3);
    json_number(row, "farthest_m", probe->farthest);
    json_number(row, "farthest_s", probe->farthest_time);
  }
}

const report_line run_probes_lines[] = {
    REPORT_LINE("probe",
                "{at}[ (vertex {vertex} at {place_m:g})]: {last_m:.4g} m at the end, farthest "
                "{farthest_m:.6g} m at {farthest_s:.4g} s",
                .each = "probes"),
    {0}};
