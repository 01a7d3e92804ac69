/* The recorder of a run: rows, frames and the end of every body.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "driver/run/basis_check.h"
#include "driver/run/run.h"
#include "platform/allocate.h"

static double time_at(const driver_run *run, int64_t step) {
  // a product, where a sum would gather rounding
  return (double)step * driver_run_request(run)->def.dt;
}

thrum_status driver_run_open_body(driver_run *run, int32_t n, const char *path,
                                  const thrum_model *shown, thrum_error *error) {
  driver_body *body = &run->bodies[n];
  const simulate_request *request = body->figures.request;
  const size_t rank = (size_t)shown->rank;
  const bool frames = request->frames_rate > 0 || request->frames_every > 0;
  THRUM_TRY(thrum_reserve(&body->q, 3 * rank, sizeof *body->q, "a run of this model", error));
  body->p = body->q + rank;
  body->extents = body->p + rank;

  // a model without a basis has no displacements
  if (shown->basis != NULL)
    THRUM_TRY(thrum_basis_extents(shown, body->extents, error));
  body->figures.peak = shown->basis != NULL ? 0 : NAN;
  body->figures.peak_vertex = -1;
  simulate_figures_begin(&body->figures);

  // the measures may refuse the model, so they come before the files
  THRUM_TRY(simulate_measures_open(request, shown, &body->measures, error));
  THRUM_TRY(run_output_open(path, shown, frames, body->name != NULL, &body->output, error));
  if (body->moves)
    THRUM_TRY(run_output_open_places(&body->output, error));

  // the bodies of a scene are followed by probes of its own
  return body->name == NULL
             ? run_probes_open(request, shown, &body->output.folder, &body->probes, error)
             : THRUM_OK;
}

/* Energies, coordinates and peaks of a body at this step. */
static thrum_status look(driver_run *run, int32_t n, thrum_error *error) {
  const driver_stepper *stepper = &run->stepper;
  driver_body *body = &run->bodies[n];
  const thrum_model *model = body->output.model;
  double *peak = &body->figures.peak;
  int64_t *vertex = &body->figures.peak_vertex;
  THRUM_TRY(stepper->kind->energies(stepper->self, n, &body->energies, error));
  THRUM_TRY(stepper->kind->coordinates(stepper->self, n, body->q, error));
  if (stepper->kind->raise_peak != NULL)
    stepper->kind->raise_peak(stepper->self, n, peak, vertex);
  else if (model->basis != NULL)
    return thrum_displacement_peak(model, body->extents, body->q, peak, vertex, error);
  return THRUM_OK;
}

/* The measures of a body at q, or at its displacements where they are of the full order. */
static thrum_status measure(driver_run *run, int32_t n, double time, thrum_error *error) {
  driver_body *body = &run->bodies[n];
  if (body->measures.field)
    THRUM_TRY(run->stepper.kind->displacements(run->stepper.self, n, body->measures.field, error));
  return simulate_measures_look(&body->measures, body->q, time, error);
}

/* Keeps the state for the judgement of the basis; one that cannot be left is passed over. */
static thrum_status note_for_basis(driver_run *run, int32_t n, int64_t step, thrum_error *error) {
  driver_body *body = &run->bodies[n];
  double q[THRUM_RANK_MAX];
  if (body->measures.basis.memory == NULL)
    return THRUM_OK;
  const thrum_status status = run->stepper.kind->snapshot(run->stepper.self, n, q, body->p, error);
  if (status == THRUM_NOT_FINITE)
    return THRUM_OK;
  THRUM_TRY(status);
  double matrix[16];
  const bool placed = run->stepper.kind->placement != NULL;
  if (placed)
    run->stepper.kind->placement(run->stepper.self, n, matrix);
  basis_record_note(&body->measures.basis, step, body->q, body->p, placed ? matrix : NULL);
  return THRUM_OK;
}

/* Adds the state of a body to its figures, and as a row to its series. */
static thrum_status record_body(driver_run *run, int32_t n, int64_t step, bool row,
                                thrum_error *error) {
  const driver_stepper *stepper = &run->stepper;
  driver_body *body = &run->bodies[n];
  const double time = time_at(run, step);
  simulate_figures_add(&body->figures, row ? run->rows : -1, &body->energies);
  THRUM_TRY(measure(run, n, time, error));
  THRUM_TRY(note_for_basis(run, n, step, error));
  if (!row)
    return THRUM_OK;

  // where a free body is stands beside q
  THRUM_TRY(run_output_record(&body->output, step, time, body->q, &body->energies, error));
  if (body->probes.field != NULL)
    THRUM_TRY(stepper->kind->displacements(stepper->self, n, body->probes.field, error));
  THRUM_TRY(run_probes_record(&body->probes, &body->output.folder, step, time, body->q, error));
  if (body->output.places == NULL)
    return THRUM_OK;
  double matrix[16];
  stepper->kind->placement(stepper->self, n, matrix);
  return run_output_place(&body->output, matrix, error);
}

thrum_status driver_run_record(driver_run *run, int64_t step, bool row, thrum_error *error) {
  // all are looked at first: a row is of all bodies or of none
  thrum_status status = THRUM_OK;

  for (int32_t n = 0; n < run->body_count && status >= 0; n++)
    status = look(run, n, error);
  if (status == THRUM_NOT_FINITE && step > 0) {
    // the state is finite, its energy is not any more: the run ends here, the rows before stand
    run->status = status;
    return thrum_error_set(&run->stop, THRUM_OK, "%s", error->message);
  }
  for (int32_t n = 0; n < run->body_count && status >= 0; n++)
    status = record_body(run, n, step, row, error);
  run->rows += row;
  if (status < 0 || !row || run->stepper.kind->record_row == NULL)
    return status;
  return run->stepper.kind->record_row(run->stepper.self, step, time_at(run, step), error);
}

static thrum_status write_frame(driver_run *run, int32_t n, double time, thrum_error *error) {
  const driver_stepper *stepper = &run->stepper;
  driver_body *body = &run->bodies[n];
  const simulate_request *request = body->figures.request;
  double base[3] = {0};
  if (simulate_measures_are_open(&body->measures)) {
    THRUM_TRY(stepper->kind->coordinates(stepper->self, n, body->q, error));
    THRUM_TRY(measure(run, n, time, error));
  }

  // displacements are relative to the base, unless they are asked for from the ground
  THRUM_TRY(stepper->kind->displacements(stepper->self, n, body->output.displacement, error));
  if (request->ground)
    base_motions_position(request->base_motions, request->base_motion_count, time, base);
  const node_stress *nodes = &body->measures.nodes;
  const vtu_stress stress = {nodes->largest, body->measures.von_mises, nodes->patches};
  return run_output_frame(&body->output, time, base, &stress, error);
}

thrum_status driver_run_frame(driver_run *run, int64_t step, thrum_error *error) {
  for (int32_t n = 0; n < run->body_count; n++)
    THRUM_TRY(write_frame(run, n, time_at(run, step), error));
  run->frames++;
  return THRUM_OK;
}

thrum_status driver_run_end(driver_run *run, thrum_error *error) {
  for (int32_t n = 0; n < run->body_count; n++) {
    driver_body *body = &run->bodies[n];
    const thrum_status status =
        run->stepper.kind->snapshot(run->stepper.self, n, body->q, body->p, error);
    // a run that left the range of finite numbers may have no end to continue from
    if (status < 0 && status != THRUM_NOT_FINITE)
      return status;
    THRUM_TRY(run_output_end(&body->output, status >= 0 ? body->q : NULL, body->p, error));
    THRUM_TRY(run_probes_end(&body->probes, &body->output.folder, error));
  }

  // who stops the judgement has the files of all bodies
  for (int32_t n = 0; n < run->body_count; n++) {
    // a motion that was lost says nothing of the basis
    driver_body *body = &run->bodies[n];
    basis_record *basis = &body->measures.basis;
    if (run->status >= 0 && !body->figures.energy_grew)
      THRUM_TRY(basis_check_judge(basis, run->seconds_step, error));
    else if (basis->memory != NULL)
      basis->estimate = basis_estimate_none(run->status < 0 ? "the run could not go on to its end"
                                                            : "the energy of the run grew");
    body->figures.basis_wrong =
        basis_estimate_is_large(&body->measures.basis.estimate, &body->figures.request->basis);
  }
  return THRUM_OK;
}
