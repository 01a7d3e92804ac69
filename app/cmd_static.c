/* `thrum static`: where a body comes to rest under a load. The search is the runtime's
 * (thrum/equilibrium.h); here it is asked for, shown and written.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/cmd.h"
#include "app/mpi_program.h"
#include "config/message.h"
#include "driver/model/locking.h"
#include "driver/model/model_cut.h"
#include "driver/spec/static_solve.h"
#include "driver/statics/static_critical.h"
#include "driver/statics/static_full.h"
#include "driver/statics/static_monitor.h"
#include "driver/statics/static_path.h"
#include "io/file.h"
#include "io/npy_file.h"
#include "io/paths.h"
#include "io/vtu.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/interrupt.h"
#include "thrum/displacement.h"

#define CRITICAL_MOST 0.05 /* error of a model's critical load above which it is said */

/* --- the path, as it is found ----------------------------------------------------------------- */

static thrum_status displaced(const thrum_model *model, const load_target *target, const double *q,
                              double mean[3], thrum_error *error) {
  load_vertices at = {0};
  thrum_status status = load_target_find(model, target, &at, error);
  THRUM_THEN(status, thrum_displacement_mean(model, at.list, at.count, q, mean, error));
  load_vertices_free(&at);
  return config_error_in(error, status, "--at");
}

/* The path of a reduced model, and where it is. */
typedef struct reduced_path {
  static_path file;
  const thrum_model *model;
  const double *q;
} reduced_path;

static thrum_status mean_at(const void *context, const load_target *target, double mean[3],
                            thrum_error *error) {
  const reduced_path *path = context;
  return displaced(path->model, target, path->q, mean, error);
}

static void put_point(void *context, const thrum_equilibrium_point *point) {
  reduced_path *path = context;
  path->q = point->q;
  const static_path_point row = {point->factor, point->energy, point->least, point->jumped != 0};
  static_path_put(&path->file, &row, path);
}

/* --- the answer's files ----------------------------------------------------------------------- */

static thrum_status write_q(const static_answer *answer, thrum_error *error) {
  return thrum_npy_write_f8(answer->request->output, answer->q, answer->model->rank, 0, error);
}

/* The stress of the answer, the frame for ParaView and the field of displacements, whichever is
 * wanted. */
static thrum_status show_fields(static_answer *answer, thrum_error *error) {
  const thrum_model *model = answer->model;
  double *field = NULL;
  if (model->basis == NULL && answer->request->frame == NULL && answer->request->field == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&field, 3 * model->vertex_count, sizeof *field, "the frame", error));
  thrum_status status = thrum_displacement(model, answer->q, 0, model->vertex_count, field, error);
  THRUM_THEN(status, static_stress_look(model, field, &answer->stress, error));

  // the frame has the stress as well
  const vtu_stress stress = static_stress_frame(&answer->stress);
  if (answer->request->frame != NULL)
    THRUM_THEN(status, vtu_write_whole(answer->request->frame, model, field, &stress, error));
  if (answer->request->field != NULL)
    THRUM_THEN(status,
               thrum_npy_write_f8(answer->request->field, field, model->vertex_count, 3, error));
  free(field);
  return status;
}

static thrum_status measure(static_answer *answer, double *extents, thrum_error *error) {
  const static_request *request = answer->request;
  answer->peak_vertex = -1;
  answer->peak = NAN;
  for (int64_t n = 0; n < request->target_count; n++) {
    THRUM_TRY(
        displaced(answer->model, &request->targets[n], answer->q, answer->displaced[n], error));
  }

  // a model without a basis has no vertices to be displaced
  if (answer->model->basis == NULL)
    return THRUM_OK;
  answer->peak = 0;
  THRUM_TRY(thrum_basis_extents(answer->model, extents, error));
  return thrum_displacement_peak(answer->model, extents, answer->q, &answer->peak,
                                 &answer->peak_vertex, error);
}

/* q of --from, where the path starts. */
static thrum_status start_from(const static_request *request, const thrum_model *model, double *q,
                               thrum_error *error) {
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  if (request->from == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_npy_read_f8(request->from, &values, &rows, &columns, error));
  thrum_status status = THRUM_OK;
  if (columns == 0 && rows == model->rank)
    memcpy(q, values, (size_t)rows * sizeof *q);
  else
    status =
        thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                        "--from %.200s: it has %lld x %lld numbers; wanted is q of %lld, as -o "
                        "writes it",
                        request->from, (long long)rows, (long long)columns, (long long)model->rank);
  free(values);
  return status;
}

static thrum_status find(static_answer *answer, double *q, double *mode, thrum_error *error) {
  const static_request *request = answer->request;
  reduced_path path = {.model = answer->model};
  thrum_status status = static_path_open(request, mean_at, &path.file, error);
  const static_problem problem = {.model = answer->model,
                                  .said = request->model_path,
                                  .loads = request->loads,
                                  .count = request->load_count,
                                  .actuates = request->actuates,
                                  .actuate_count = request->actuate_count,
                                  .from = request->from != NULL,
                                  .progress = {request->path != NULL ? put_point : NULL, &path},
                                  .def = request->def};
  const double began = clock_seconds();
  THRUM_THEN(status, start_from(request, answer->model, q, error));
  THRUM_THEN(status, static_solve(&problem, q, mode, &answer->report, error));
  answer->seconds = clock_seconds() - began;
  THRUM_THEN(status, static_path_close(&path.file, error));
  static_path_abandon(&path.file);
  return status;
}

/* Can all files be written that are asked for? A search may take minutes, and one of them that
 * cannot leaves none of the others. */
static thrum_status check_outputs(const static_request *request, thrum_error *error) {
  const char *const paths[] = {request->output, request->path, request->reactions, request->field,
                               request->frame};
  for (size_t n = 0; n < sizeof paths / sizeof paths[0]; n++) {
    thrum_file_writer writer = {0};
    if (paths[n] != NULL)
      THRUM_TRY(thrum_file_writer_open(paths[n], &writer, error));
    thrum_file_writer_abandon(&writer);
  }
  return THRUM_OK;
}

static thrum_status answer_all(static_answer *answer, double *memory, thrum_error *error) {
  const static_request *request = answer->request;
  double *q = memory, *mode = q + answer->model->rank, *extents = mode + answer->model->rank;
  answer->q = q;
  answer->mode = mode;
  THRUM_TRY(check_outputs(request, error));

  // the whole mesh is solved elsewhere and has no reduced answer to measure
  if (request->full) {
    const thrum_status found = static_full_find(answer, q, error);
    return found >= 0 && request->output != NULL ? write_q(answer, error) : found;
  }

  // what to show is looked up before the search, so that a slip costs nothing
  THRUM_TRY(static_forces_check(request, answer->model, error));
  THRUM_TRY(measure(answer, extents, error));
  THRUM_TRY(find(answer, q, mode, error));
  THRUM_TRY(measure(answer, extents, error));
  THRUM_TRY(static_monitor_look(answer, &answer->belief, error));
  if (answer->report.instability == THRUM_INSTABILITY_BIFURCATION)
    THRUM_TRY(static_critical_look(request, answer->model, answer->report.critical,
                                   &answer->critical_mesh, error));
  THRUM_TRY(static_forces_reduced(request, answer->model, q, &answer->forces, error));
  if (request->output != NULL)
    THRUM_TRY(write_q(answer, error));
  return show_fields(answer, error);
}

static void warn_flags(const static_answer *answer) {
  const thrum_equilibrium_report *report = &answer->report;
  locking_warn(path_basename(answer->request->model_path), answer->model);
  if (report->instability != THRUM_INSTABILITY_NONE)
    config_warn("the body %s at %.6g of the load%s",
                report->instability == THRUM_INSTABILITY_LIMIT ? "snaps through" : "buckles",
                report->critical,
                report->jumps > 0 ? "; the answer is a stable shape that it falls to" : "");
  if (fabs(answer->critical_mesh / report->critical - 1) > CRITICAL_MOST)
    config_warn(
        "the basis has the critical load wrong: the whole mesh loses its stability at about "
        "%.6g of the load; take --full, or a model of more --modes or with --handles",
        answer->critical_mesh);
  if (report->least < 0)
    config_warn("the equilibrium is unstable");
  if (isfinite(answer->lost_at))
    config_warn("the branch could be followed to %.6g of the load alone: the answer may be of "
                "another one; go there in several runs with --from",
                answer->lost_at);
  if (isfinite(answer->lower_energy))
    config_warn("the path led to a higher branch: another shape has %.6g J of energy in body and "
                "load, this one %.6g J; go there in several runs with --from, or by another way",
                answer->lower_energy, report->energy + report->load_energy);
  if (answer->forces.inverted > 0)
    config_warn("%" PRId64 " tetrahedra are turned inside out, the worst is number %" PRId64
                ": no real body rests there; lower the load, or take --full with another --law",
                answer->forces.inverted, answer->forces.inverted_tet + 1);
  if (answer->request->monitor)
    static_forces_warn(answer->request, &answer->forces);
  static_monitor_warn(answer);
}

static int run_request(const static_request *request) {
  thrum_error error = {0};
  const thrum_model *loaded = NULL;
  static_answer answer = {.request = request,
                          .critical_from = NAN,
                          .critical_to = NAN,
                          .critical_share = NAN,
                          .least_start = NAN,
                          .critical_mesh = NAN,
                          .lost_at = NAN,
                          .lower_energy = NAN};
  double *memory = NULL;

  mesh_model_def def = request->mesh_def;
  if (request->full)
    def.reading.tets_for = mesh_model_tets_for(request->law, NULL, request->quadrature);
  thrum_status status =
      mesh_model_load(request->model_path, &def, request->quiet, &loaded, NULL, &error);

  // an equilibrium is sought in all coordinates
  THRUM_THEN(status,
             model_check_whole(loaded, request->model_path, "static",
                               "without --condense, and with --touch-stepped in place of --touch",
                               &error));
  if (status >= 0 && request->rank > 0 && request->rank != loaded->rank)
    status =
        thrum_error_set(&error, THRUM_INVALID_ARGUMENT,
                        "--rank %lld: an equilibrium is sought in all %lld coordinates of "
                        "%.200s, for a body whose coordinates are cut off is too stiff: leave "
                        "--rank out, or precompute the model with that rank",
                        (long long)request->rank, (long long)loaded->rank, request->model_path);
  answer.model = loaded;
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");

  // q, the mode of an instability and the extents of the basis
  THRUM_THEN(status,
             thrum_reserve(&memory, 3 * answer.model->rank, sizeof *memory, "the answer", &error));
  THRUM_THEN(status, thrum_reserve(&answer.displaced, request->target_count,
                                   sizeof *answer.displaced, "the answer", &error));
  THRUM_THEN(status, answer_all(&answer, memory, &error));

  // an instability on the way is flagged
  const bool flagged = status >= 0 && static_flag(&answer) != NULL;
  if (status >= 0) {
    static_report_print(&answer, request->json);
    warn_flags(&answer);
  }
  const int code = config_end(status, flagged, &error);

  free(memory);
  free(answer.displaced);
  static_forces_free(&answer.forces);
  node_stress_close(&answer.stress);
  thrum_model_destroy(loaded);
  return code;
}

int cmd_static_shared(int argc, char **argv, const thrum_full_shared *shared,
                      const thrum_precompute_shared *precompute) {
  static_request request = {.shared = shared};
  // no more loads and targets than arguments, and items of an options file
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);
  const int64_t room = argc + CONFIG_FILE_ITEMS_MAX;
  request.actuates = thrum_scope_allocate(&scope, room, sizeof *request.actuates);
  request.loads = thrum_scope_allocate(&scope, room, sizeof *request.loads);
  request.targets = thrum_scope_allocate(&scope, room, sizeof *request.targets);
  request.at = thrum_scope_allocate(&scope, room, sizeof *request.at);
  request.moves = thrum_scope_allocate(&scope, room, sizeof *request.moves);

  int code = scope.status < 0 ? config_refuse(&error) : static_options_read(argc, argv, &request);
  if (code == COMMAND_DONE && shared != NULL && !request.full)
    code = mpi_program_wants_full("static");
  request.mesh_def.shared = precompute;
  if (code == COMMAND_DONE)
    code = run_request(&request);
  thrum_scope_free(&scope);
  config_file_free(&request.file);
  return code;
}

int cmd_static(int argc, char **argv) {
  return cmd_static_shared(argc, argv, NULL, NULL);
}
