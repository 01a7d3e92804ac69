/* The energy and the inertia of condensed models. SPDX-License-Identifier: Apache-2.0 */
#include "driver/condensed_check.h"

#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"

/* An energy this much larger than the last one looked at is looked at again, so that a run of any
 * length costs a few passes over the mesh. */
#define LOOK_AGAIN 1.2

thrum_status condensed_check_open(const thrum_model *model, condensed_check *check,
                                  thrum_error *error) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  *check = (condensed_check){.model = model, .defect = NAN};
  if (shape->tets == NULL || shape->basis == NULL)
    return THRUM_OK;

  // the mesh, without its matrices
  THRUM_TRY(thrum_model_borrow_mesh(shape, &check->mesh, error));
  thrum_status status = thrum_fem_create(&check->mesh, shape->fixed, &check->fem, error);
  if (status >= 0) {
    check->q =
        thrum_allocate(shape->rank, sizeof *check->q, "the check of a condensed model", error);
    check->u = thrum_allocate(3 * shape->vertex_count, sizeof *check->u,
                              "the check of a condensed model", error);
    status = check->q && check->u ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  }
  if (status < 0)
    condensed_check_close(check);
  return status;
}

void condensed_check_close(condensed_check *check) {
  thrum_fem_free(&check->fem);
  free(check->mesh.materials);
  free(check->q);
  free(check->u);
  *check = (condensed_check){.defect = NAN};
}

void condensed_check_look(condensed_check *check, const double *x, const double *v,
                          double potential) {
  // what the slaves would have of the kinetic energy
  const double share = thrum_condensed_inertia_share(check->model, x, v);
  double masters = 0;
  for (int64_t i = 0; i < check->model->rank; i++)
    masters += 0.5 * v[i] * v[i];
  const double whole = masters / (1 - share);
  check->kinetic = fmax(check->kinetic, whole);
  check->inertia = fmax(check->inertia, share * whole);

  // the energy of the mesh, where the body is bent more than at any time before
  if (check->u == NULL || !(fabs(potential) > LOOK_AGAIN * check->energy))
    return;
  const thrum_model *shape = thrum_condensed_shape_model(check->model);
  thrum_condensed_shape(check->model, x, NULL, check->q);
  thrum_displacement(shape, check->q, 0, shape->vertex_count, check->u, NULL);
  check->energy = fabs(potential);
  check->defect = fabs(thrum_fem_energy(&check->fem, check->u, NULL) - potential) / check->energy;
}

void condensed_check_report(const condensed_check *check, const thrum_model *model,
                            simulate_figures *figures) {
  figures->masters = model->rank;
  figures->gap = thrum_condensed_gap(model);
  figures->inertia_share = check->kinetic > 0 ? check->inertia / check->kinetic : 0;
  figures->energy_defect = check->energy > 0 ? check->defect : NAN;
}
