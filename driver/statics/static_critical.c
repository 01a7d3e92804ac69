/* A basis may hold the modes that buckle and still lose its stability too early or too late, by a
 * shape that the mesh does not take. The equilibrium of the model at nine tenths of its critical
 * load is carried over to the mesh, which goes from there to its own. The least eigenvalue of the
 * tangent, over the one at rest, is taken for
 *   s = 1 - (factor/critical)^p
 * in both. The model knows its s and its critical load, which gives p: 1 for a straight column,
 * more for an arch. The mesh then buckles at about factor/(1 - s)^(1/p).
 * Cost: about eight factorisations of the mesh. SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_critical.h"

#include <math.h>
#include <stdlib.h>

#include "driver/spec/static_solve.h"
#include "platform/allocate.h"
#include "precompute/full/full.h"
#include "runtime/material/material_law.h"
#include "thrum/displacement.h"

#define BEFORE 0.9           /* of the critical load, where the mesh is asked */
#define COMPONENTS_MAX 30000 /* beyond, it would take longer than anybody expects */

/* The mesh from the displacement u under the loads at `factor`. */
static thrum_status rest(const static_request *request, const thrum_model *model, double factor,
                         const double *u, double *forces, thrum_full_equilibrium *found,
                         thrum_error *error) {
  thrum_full_def def = thrum_default_full_def();
  def.law = thrum_law_of_model(model);
  thrum_full *body = NULL;
  for (int64_t n = 0; n < request->load_count; n++)
    THRUM_TRY(load_spec_fill(model, &request->loads[n], forces, error));
  for (int64_t c = 0; c < 3 * model->vertex_count; c++)
    forces[c] *= factor;
  const thrum_full_loading loading = {.forces = forces, .watch = true};
  thrum_status status = thrum_full_create(model, NULL, &def, &body, error);
  THRUM_THEN(status, thrum_full_displace(body, u, error));
  THRUM_THEN(status, thrum_full_rest_under(body, &loading, found, error));
  thrum_full_free(body);
  return status;
}

thrum_status static_critical_look(const static_request *request, const thrum_model *model,
                                  double critical, double *mesh, thrum_error *error) {
  const int64_t all = 3 * model->vertex_count;
  if (!request->monitor || request->from != NULL || model->tets == NULL || model->basis == NULL ||
      model->rigid != NULL || all > COMPONENTS_MAX || !isfinite(critical))
    return THRUM_OK;
  double *memory = NULL;
  THRUM_TRY(thrum_reserve(&memory, model->rank + 2 * all, sizeof *memory, "the monitor", error));
  double *q = memory, *u = q + model->rank, *forces = u + all;

  // the model before it buckles, then its mesh
  static_problem problem = {.model = model,
                            .said = request->model_path,
                            .loads = request->loads,
                            .count = request->load_count,
                            .def = request->def};
  problem.def.factor = BEFORE * critical;
  thrum_equilibrium_report report = {0};
  thrum_full_equilibrium found;
  thrum_status status = static_solve(&problem, q, NULL, &report, error);
  THRUM_THEN(status, thrum_displacement(model, q, 0, model->vertex_count, u, error));
  THRUM_THEN(status, rest(request, model, problem.def.factor, u, forces, &found, error));

  // what did not come there, lost its stability or stiffened on the way tells nothing
  const double left = found.least / model->omega2[0], own = report.least / model->omega2[0];
  if (status >= 0 && found.jumps == 0 && !found.lost && left < 1 && own > 0 && own < 1)
    *mesh = problem.def.factor * pow(1 - left, -log(BEFORE) / log(1 - own));
  free(memory);
  return status == THRUM_OUT_OF_MEMORY ? status : THRUM_OK;
}
