/* The judgement of the basis of a run at its end. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/basis_check.h"

#include <math.h>
#include <stdlib.h>

#include "driver/run/basis_rerun.h"
#include "platform/allocate.h"
#include "platform/clock.h"

#define INSTANTS 8 /* parts of a run, each with its largest motion, beside the largest of all */

/* The judge and what it has seen: sums of squares of the motion of the mesh and of what is lacking.
 */
typedef struct judgement {
  basis_record *record;
  thrum_basis_judge *judge;
  double *forces; /* two fields; owned */
  double rate2;
  double seconds; /* that the steps of the run took */
  double moved, lacking;
} judgement;

/* The square of the rate of the motion: of all velocities over all displacements. */
static double rate_of(const basis_record *record) {
  double speed = 0, size = 0;
  for (int64_t n = 0; n < record->count; n++) {
    size += record->rows[n].size;
    for (int64_t i = 0; i < record->model->rank; i++)
      speed += record->rows[n].p[i] * record->rows[n].p[i];
  }
  return size > 0 ? speed / size : 0;
}

/* Before the first step nothing has moved yet. */
static thrum_status look(judgement *j, const basis_row *row, thrum_error *error) {
  const int64_t all = 3 * j->record->model->vertex_count;
  double moved = 0, lacking = 0;
  if (row->step == 0)
    return THRUM_OK;
  THRUM_TRY(basis_record_forces(j->record, thrum_basis_judge_masses(j->judge), row->step, j->forces,
                                j->forces + all, error));
  THRUM_TRY(
      thrum_basis_judge_look(j->judge, row->q, j->forces + all, j->rate2, &moved, &lacking, error));
  j->moved += moved;
  j->lacking += lacking;
  j->record->estimate.instants++;
  return THRUM_OK;
}

static thrum_status look_at_all(judgement *j, thrum_error *error) {
  const basis_record *record = j->record;
  j->rate2 = rate_of(record);
  THRUM_TRY(thrum_reserve(&j->forces, 6 * record->model->vertex_count, sizeof *j->forces,
                          "the judgement of the basis", error));
  THRUM_TRY(look(j, &record->rows[BASIS_ROWS_MAX], error));
  for (int64_t n = 0; n < INSTANTS; n++) {
    // the largest motion of a part of the run, which may be the largest of all
    const int64_t end = (n + 1) * record->count / INSTANTS;
    int64_t at = n * record->count / INSTANTS;
    for (int64_t k = at; k < end; k++)
      at = record->rows[k].size > record->rows[at].size ? k : at;
    if (at < end && record->rows[at].step != record->rows[BASIS_ROWS_MAX].step)
      THRUM_TRY(look(j, &record->rows[at], error));
  }
  return THRUM_OK;
}

static thrum_status judge_all(judgement *j, thrum_error *error) {
  basis_estimate *estimate = &j->record->estimate;
  THRUM_TRY(basis_estimate_judge(j->record->model, INSTANTS + 1, &j->record->request->basis,
                                 &j->judge, estimate, error));
  if (j->judge == NULL)
    return THRUM_OK;
  THRUM_TRY(look_at_all(j, error));

  // a motion that left all bounds tells nothing
  const double share = sqrt(j->lacking / j->moved);
  if (!isfinite(j->lacking) || !isfinite(j->moved)) {
    *estimate = basis_estimate_none("the motion is beyond all bounds");
    return THRUM_OK;
  }
  if (j->moved > 0) {
    estimate->share = share;
    estimate->why = NULL;
  }

  // where nothing is left over but rounding a richer model would be made of that
  return j->lacking > 0 ? basis_rerun(j->record, j->judge, j->seconds, error) : THRUM_OK;
}

thrum_status basis_check_judge(basis_record *record, double seconds, thrum_error *error) {
  thrum_error detail = {0};
  judgement j = {.record = record, .seconds = seconds};
  if (record->memory == NULL || record->count < 2 || record->request->basis.together)
    return THRUM_OK;
  const double began = clock_seconds();
  const thrum_status status = judge_all(&j, &detail);
  thrum_basis_judge_free(j.judge);
  free(j.forces);

  // a mesh that cannot be solved says nothing against the run
  if (status == THRUM_OUT_OF_MEMORY) {
    *error = detail;
    return status;
  }
  if (status < 0 && record->estimate.why == NULL)
    record->estimate.why = "the mesh could not be solved";
  if (record->estimate.why == NULL)
    record->estimate.seconds = clock_seconds() - began;
  return THRUM_OK;
}
