/* The monitors of `thrum static`: those of the runtime, and one correction of the whole mesh.
 *
 * A basis that cannot bend as far as it is pulled gives a shape that is too stiff, and nothing in
 * it tells. The whole mesh does: with its forces where the answer has it, one correction of Newton
 * says how far it would go on (precompute/model/basis_judge.h). SPDX-License-Identifier: Apache-2.0
 */
#include "driver/static_monitor.h"

#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/displacement.h"
#include "thrum/monitor.h"

static thrum_status look_runtime(const thrum_model *model, const double *q, static_belief *belief,
                                 thrum_error *error) {
  thrum_monitor_def def = thrum_default_monitor_def();
  def.reach_most = INFINITY;
  const thrum_monitor *monitor = NULL;
  thrum_monitor_record record;
  size_t size = 0;
  thrum_monitor_clear(&record);
  THRUM_TRY(thrum_monitor_size(model, &def, &size, error));
  void *memory = NULL;
  THRUM_TRY(thrum_reserve_aligned(&memory, size, "the monitor", error));

  thrum_status status = thrum_monitor_init(memory, size, model, &def, &monitor, error);
  THRUM_THEN(status, thrum_monitor_look(monitor, q, &record, error));
  if (status >= 0) {
    belief->warnings = record.warnings;
    belief->stretch = record.stretch_least;
  }
  free(memory);
  return status;
}

/* The loads at their factor, on all components. */
static thrum_status fill_forces(const static_request *request, const thrum_model *model,
                                double *forces, thrum_error *error) {
  const size_t components = 3 * (size_t)model->vertex_count;
  for (size_t c = 0; c < components; c++)
    forces[c] = 0;
  for (int64_t n = 0; n < request->load_count; n++)
    THRUM_TRY(load_spec_fill(model, &request->loads[n], forces, error));
  for (size_t c = 0; c < components; c++)
    forces[c] *= request->def.factor;
  return THRUM_OK;
}

/* How far the mesh would go on from the answer, over where it would be. */
static thrum_status look_whole(const static_answer *answer, basis_estimate *estimate,
                               thrum_error *error) {
  const thrum_model *model = answer->model;
  const double began = clock_seconds();
  thrum_basis_judge *judge = NULL;
  double *forces = NULL, moved = 0, lacking = 0;
  THRUM_TRY(basis_estimate_judge(model, 1, &answer->request->basis, &judge, estimate, error));
  if (judge == NULL)
    return THRUM_OK;

  thrum_status status =
      thrum_reserve(&forces, 3 * model->vertex_count, sizeof *forces, "the monitor", error);
  THRUM_THEN(status, fill_forces(answer->request, model, forces, error));
  THRUM_THEN(status, thrum_basis_judge_look(judge, answer->q, forces, 0, &moved, &lacking, error));
  if (status >= 0 && moved > 0 && isfinite(moved) && isfinite(lacking)) {
    *estimate = basis_estimate_none(NULL);
    estimate->share = sqrt(lacking / moved);
    estimate->instants = 1;
    estimate->seconds = clock_seconds() - began;
  }
  thrum_basis_judge_free(judge);
  free(forces);
  return status;
}

/* Why the basis of an answer is not judged; NULL: it is. */
static const char *why_not(const static_answer *answer) {
  if (answer->request->basis.judging == BASIS_JUDGE_OFF)
    return "it was not asked for";
  if (answer->model->tets == NULL || answer->model->basis == NULL)
    return "the model has no mesh inside";
  return answer->report.least < 0 ? "the answer is unstable" : NULL;
}

thrum_status static_monitor_look(const static_answer *answer, static_belief *belief,
                                 thrum_error *error) {
  const thrum_model *model = answer->model;
  *belief = (static_belief){.stretch = NAN, .judged = answer->request->monitor};
  if (!answer->request->monitor)
    return THRUM_OK;
  const char *why = why_not(answer);
  belief->error = basis_estimate_none(why != NULL ? why : "nothing has moved");
  if (model->tets == NULL || model->basis == NULL)
    return THRUM_OK;
  THRUM_TRY(look_runtime(model, answer->q, belief, error));
  if (why != NULL)
    return THRUM_OK;

  // a mesh that cannot be solved says nothing against the answer
  thrum_error detail = {0};
  const thrum_status status = look_whole(answer, &belief->error, &detail);
  if (status != THRUM_OUT_OF_MEMORY)
    return THRUM_OK;
  *error = detail;
  return status;
}

void static_monitor_warn(const static_answer *answer) {
  const static_belief *belief = &answer->belief;

  // an inverted element was compressed first, and is said by its number
  if ((belief->warnings & THRUM_WARNING_COMPRESSED) && answer->forces.inverted == 0)
    config_warn(
        "a tetrahedron is compressed to %.3f of its length; below 0.577, StVK gives way: do "
        "not trust this shape%s",
        belief->stretch, answer->request->full ? ", or take another --law" : "");

  // what the basis cannot show
  if (belief->judged)
    basis_estimate_warn(&belief->error, &answer->request->basis, "", "shape");
}
