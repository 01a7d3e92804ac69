/* The monitors of `thrum static`: those of the runtime, and some corrections of the whole mesh.
 *
 * A basis that cannot bend as far as it is pulled gives a shape that is too stiff, and nothing in
 * it tells. The whole mesh does: from where the answer has it, Newton's corrections say how far it
 * goes on. They take the tangent there, factorised: in a slender body that is well bent the factor
 * at rest is no help, since it takes the stretch of the bent shape for its bending. A body that
 * nothing holds has no equilibrium of its own, and is judged by one correction of its shape
 * (precompute/model/basis_judge.h). SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_monitor.h"

#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "driver/spec/actuate_spec.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/estimate.h"
#include "precompute/full/full.h"
#include "runtime/material/material_law.h"
#include "thrum/displacement.h"
#include "thrum/monitor.h"

#define CORRECTIONS_MAX 64 /* of Newton */
#define CORRECTED 1e-3     /* the last correction over the largest, in the energy norm */

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

/* Adds what the actuators do where the answer is. */
static thrum_status add_acting(const static_answer *answer, double *forces, thrum_error *error) {
  const static_request *request = answer->request;
  const thrum_model *model = answer->model;
  const int64_t all = 3 * model->vertex_count;
  thrum_model_fem body = {0};
  double *u = NULL;
  if (!actuate_specs_act(model, request->actuate_count))
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&u, 2 * all, sizeof *u, "the monitor", error));
  thrum_status status = thrum_model_fem_elements(model, &body, error);
  THRUM_THEN(status, thrum_model_fem_actuate(model, &body, error));
  THRUM_THEN(status, thrum_displacement(model, answer->q, 0, model->vertex_count, u, error));
  if (status >= 0) {
    actuate_specs_strength(model, request->actuates, request->actuate_count, request->def.factor,
                           body.acting->levels);
    thrum_fem_acting_energy(&body.fem, u, u + all);
    for (int64_t c = 0; c < all; c++)
      forces[c] -= u[all + c];
  }
  thrum_model_fem_free(&body);
  free(u);
  return status;
}

/* The body of the mesh under the same levels. */
static thrum_status set_levels(const static_answer *answer, thrum_full *body, thrum_error *error) {
  const static_request *request = answer->request;
  double levels[THRUM_ACTUATORS_MAX];
  if (!actuate_specs_act(answer->model, request->actuate_count))
    return THRUM_OK;
  actuate_specs_strength(answer->model, request->actuates, request->actuate_count,
                         request->def.factor, levels);
  return thrum_full_set_actuation(body, levels, error);
}

/* So many corrections as take about as long as a judgement may. */
static int32_t affordable(const thrum_basis_judge *judge, const basis_asked *asked) {
  const thrum_model_statics *statics = thrum_basis_judge_statics(judge);
  const double seconds = thrum_estimate_solves(statics->factor, statics->body.fem.free_count, 1);
  if (asked->judging == BASIS_JUDGE_ON || seconds * CORRECTIONS_MAX < BASIS_SECONDS_MOST)
    return CORRECTIONS_MAX;
  return seconds < BASIS_SECONDS_MOST ? (int32_t)(BASIS_SECONDS_MOST / seconds) : 1;
}

/* The mesh goes on from the answer, and the estimate is how far. What it leaves in *estimate stays
 * where that leads nowhere. */
static thrum_status go_on(const static_answer *answer, const double *forces, int32_t corrections,
                          basis_estimate *estimate, thrum_error *error) {
  const thrum_model *model = answer->model;
  const int64_t all = 3 * model->vertex_count;
  thrum_full_def def = thrum_default_full_def();
  def.law = thrum_law_of_model(model);
  def.tolerance = CORRECTED;
  thrum_full_equilibrium found = {0};
  thrum_full *body = NULL;
  double *u = NULL, lacking = 0, moved = 0;
  bool ended = false;
  THRUM_TRY(thrum_reserve(&u, 2 * all, sizeof *u, "the monitor", error));
  double *there = u + all;

  thrum_status status = thrum_displacement(model, answer->q, 0, model->vertex_count, u, error);
  THRUM_THEN(status, thrum_full_create(model, NULL, &def, &body, error));
  THRUM_THEN(status, thrum_full_displace(body, u, error));
  THRUM_THEN(status, set_levels(answer, body, error));
  THRUM_THEN(status, thrum_full_correct(body, forces, corrections, &found, &ended, error));
  if (status >= 0) {
    thrum_full_get(body, there, NULL);
    for (int64_t c = 0; c < all; c++) {
      lacking += (there[c] - u[c]) * (there[c] - u[c]);
      moved += there[c] * there[c];
    }
  }

  // two corrections say more than the one by the factor at rest, also of a mesh that is on its way
  const double share = sqrt(lacking / moved);
  if (status >= 0 && moved > 0 && isfinite(share) &&
      (ended || found.iterations > 1 || share > estimate->share)) {
    estimate->share = share;
    estimate->about = ended;
    estimate->corrections = found.iterations;
  }
  thrum_full_free(body);
  free(u);
  return status;
}

/* How far the mesh would go on from the answer, over where it would be. */
static thrum_status look_whole(const static_answer *answer, basis_estimate *estimate,
                               thrum_error *error) {
  const thrum_model *model = answer->model;
  const basis_asked *asked = &answer->request->basis;
  const double began = clock_seconds();
  thrum_basis_judge *judge = NULL;
  double *forces = NULL, moved = 0, lacking = 0;
  THRUM_TRY(basis_estimate_judge(model, 1, asked, &judge, estimate, error));
  if (judge == NULL)
    return THRUM_OK;

  // one correction, which is zero where the mesh asks for rounding alone
  thrum_status status =
      thrum_reserve(&forces, 3 * model->vertex_count, sizeof *forces, "the monitor", error);
  THRUM_THEN(status, fill_forces(answer->request, model, forces, error));
  THRUM_THEN(status, add_acting(answer, forces, error));
  THRUM_THEN(status, thrum_basis_judge_look(judge, answer->q, forces, 0, &moved, &lacking, error));
  THRUM_THEN(status, fill_forces(answer->request, model, forces, error));
  const bool known = status >= 0 && moved > 0 && isfinite(moved) && isfinite(lacking);
  if (known) {
    *estimate = basis_estimate_none(NULL);
    estimate->share = sqrt(lacking / moved);
    estimate->instants = 1;
  }
  const int32_t corrections = affordable(judge, asked);
  thrum_basis_judge_free(judge);

  // and those that follow
  if (known && lacking > 0 && model->rigid == NULL)
    status = go_on(answer, forces, corrections, estimate, error);
  if (known)
    estimate->seconds = clock_seconds() - began;
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
