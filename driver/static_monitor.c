/* The monitors of `thrum static`: those of the runtime, and one correction of the whole mesh.
 *
 * A basis that cannot bend as far as it is pulled gives a shape that is too stiff, and nothing in
 * it tells. The whole mesh does: with its forces where the answer has it, one correction of Newton
 * says how much further it would give way. SPDX-License-Identifier: Apache-2.0 */
#include "driver/static_monitor.h"

#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "platform/allocate.h"
#include "precompute/full/full.h"
#include "thrum/displacement.h"
#include "thrum/monitor.h"

#define COMPONENTS_MAX 150000 /* beyond, the correction would take longer than anybody expects */
#define UNDONE_MOST 0.05      /* share of the energy above which it is said */

static thrum_status look_runtime(const thrum_model *model, const double *q, static_belief *belief,
                                 thrum_error *error) {
  const thrum_monitor_def def = thrum_default_monitor_def();
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
    belief->reach = record.reach_most;
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

/* The share of the energy of body and load that one correction of the whole mesh adds. */
static thrum_status look_whole(const static_answer *answer, static_belief *belief,
                               thrum_error *error) {
  const thrum_model *model = answer->model;
  thrum_full_def def = thrum_default_full_def();
  def.law = thrum_law_of_model(model);
  const double found = answer->report.energy + answer->report.load_energy;
  thrum_full *body = NULL;
  double undone = 0;
  double *forces = NULL;
  THRUM_TRY(thrum_reserve(&forces, 6 * model->vertex_count, sizeof *forces, "the monitor", error));
  double *u = forces + 3 * model->vertex_count;

  thrum_status status = fill_forces(answer->request, model, forces, error);
  THRUM_THEN(status, thrum_displacement(model, answer->q, 0, model->vertex_count, u, error));
  THRUM_THEN(status, thrum_full_create(model, NULL, &def, &body, error));
  THRUM_THEN(status, thrum_full_set(body, u, NULL, error));
  THRUM_THEN(status, thrum_full_undone(body, forces, &undone, error));
  if (status >= 0 && undone >= 0 && found < 0)
    belief->undone = undone / (undone - found);
  thrum_full_free(body);
  free(forces);
  return status;
}

thrum_status static_monitor_look(const static_answer *answer, static_belief *belief,
                                 thrum_error *error) {
  const thrum_model *model = answer->model;
  *belief = (static_belief){.reach = NAN, .stretch = NAN, .undone = NAN};
  if (!answer->request->monitor || model->tets == NULL || model->basis == NULL)
    return THRUM_OK;
  THRUM_TRY(look_runtime(model, answer->q, belief, error));

  // a free body has no tangent to solve with, and an unstable answer no energy to compare
  if (model->rigid != NULL || answer->report.least < 0 ||
      3 * model->vertex_count > COMPONENTS_MAX || answer->request->from != NULL)
    return THRUM_OK;
  return look_whole(answer, belief, error);
}

void static_monitor_warn(const static_answer *answer) {
  const static_belief *belief = &answer->belief;

  // an inverted element was compressed first, and is said by its number
  if ((belief->warnings & THRUM_WARNING_COMPRESSED) && answer->forces.inverted == 0)
    config_warn(
        "a tetrahedron is compressed to %.3f of its length; below 0.577, StVK gives way: do "
        "not trust this shape%s",
        belief->stretch, answer->request->full ? ", or take another --law" : "");

  // a basis may be too stiff where the body moves far, and the mesh tells how much it lacks
  if (belief->warnings & THRUM_WARNING_REACH)
    config_warn("the body moved %.2g times as far as the tenth of its diagonal that the basis is "
                "made for: it may be too stiff there",
                belief->reach);
  if (belief->undone > UNDONE_MOST)
    config_warn("the basis cannot show this shape: the whole mesh would give way further, by "
                "%.2g %% of the energy or more; take a higher rank, or --full",
                100 * belief->undone);
}
