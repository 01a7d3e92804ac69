/* The full-order body of a model, see model_fem.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/model_fem.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "precompute/fem/about_state.h"
#include "precompute/fem/quadrature.h"
#include "precompute/model/model_fill.h"
#include "thrum/actuation.h"

void thrum_model_return_mesh(thrum_mesh *mesh) {
  free(mesh->materials);
  free(mesh->laws);
  if (mesh->about)
    free(mesh->vertices);
  *mesh = (thrum_mesh){0};
}

thrum_status thrum_model_borrow_mesh(const thrum_model *model, thrum_mesh *mesh,
                                     thrum_error *error) {
  if (model->vertices == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh, so its stiffness and mass are unknown");

  // arrays of the model stand in the mesh as they are
  mesh->vertex_count = model->vertex_count;
  mesh->tet_count = model->tet_count;
  mesh->region_count = model->region_count;
  mesh->vertices = thrum_model_writable(model->vertices);
  mesh->tets = thrum_model_writable(model->tets);
  mesh->midsides = thrum_model_writable(model->midsides);
  mesh->tet_region = thrum_model_writable(model->tet_region);
  mesh->springs = thrum_model_writable(model->springs);
  mesh->elastic_count = model->elastic_count;
  mesh->elastic = thrum_model_writable(model->elastic);
  mesh->solid_count = model->solid_count;
  mesh->solid_form = thrum_model_writable(model->solid_form);
  mesh->solid_ends = thrum_model_writable(model->solid_ends);
  mesh->solid_nodes = thrum_model_writable(model->solid_nodes);
  mesh->solid_tet_ends = thrum_model_writable(model->solid_tet_ends);

  // the shape without stress is another one
  mesh->about = thrum_model_writable(model->about);
  if (mesh->about) {
    mesh->vertices = NULL;
    THRUM_TRY(thrum_reserve(&mesh->vertices, 3 * mesh->vertex_count, sizeof *mesh->vertices,
                            "the mesh", error));
    for (int64_t c = 0; c < 3 * mesh->vertex_count; c++)
      mesh->vertices[c] = model->vertices[c] - model->about[c];
  }

  // only materials and laws are of another form, so they are copied
  THRUM_TRY(thrum_reserve(&mesh->materials, mesh->region_count, sizeof *mesh->materials,
                          "the materials", error));
  if (model->region_law &&
      thrum_reserve(&mesh->laws, mesh->region_count, sizeof *mesh->laws, "the laws", error) < 0) {
    thrum_model_return_mesh(mesh);
    return THRUM_OUT_OF_MEMORY;
  }
  for (int64_t i = 0; i < mesh->region_count; i++)
    mesh->materials[i] = (thrum_material){model->material[3 * i], model->material[3 * i + 1],
                                          model->material[3 * i + 2]};
  for (int64_t i = 0; mesh->laws && i < mesh->region_count; i++)
    mesh->laws[i] = (thrum_region_law){thrum_law_of_region(model, i),
                                       model->region_yield ? model->region_yield[i] : 0};

  mesh->has_material = true;
  return THRUM_OK;
}

// u_0^T M u_0 of the first column of U, which is 1 in the mass that it was made with
static thrum_status first_square(const thrum_model_fem *body, const thrum_model *model,
                                 double *square, thrum_error *error) {
  const thrum_fem *fem = &body->fem;
  const int64_t n = fem->free_count;
  double *column = NULL;
  THRUM_TRY(thrum_reserve(&column, 2 * n, sizeof *column, "a column of the basis", error));

  // the column on the free components, and M times it behind it
  for (int64_t f = 0; f < n; f++)
    column[f] = model->basis[fem->component[f] * model->rank];
  thrum_sparse_product(&body->mass, column, 1, column + n);

  *square = 0;
  for (int64_t f = 0; f < n; f++)
    *square += column[f] * column[n + f];
  free(column);
  return THRUM_OK;
}

static thrum_status make_mass(thrum_model_fem *body, const thrum_model *model, thrum_error *error) {
  double off[2] = {0, INFINITY};
  thrum_status status = THRUM_OK;

  // the lumped one is tried first, so that the consistent one stays when there is no basis
  for (int kind = 1; kind >= 0 && status >= 0; kind--) {
    double square = 1;
    thrum_sparse_free(&body->mass);
    status = thrum_fem_mass(&body->fem, (thrum_mass)kind, &body->stiffness, &body->mass, error);
    if (status >= 0 && model->basis)
      status = first_square(body, model, &square, error);
    off[kind] = fabs(square - 1);
  }

  // the mass in which the basis is nearer to orthonormal is the one it was made with
  if (status >= 0 && off[1] < off[0]) {
    thrum_sparse_free(&body->mass);
    body->kind = THRUM_MASS_LUMPED;
    status = thrum_fem_mass(&body->fem, body->kind, &body->stiffness, &body->mass, error);
  }

  return status;
}

// the order of quadrature that the model says it was made with; 0: the usual one
static int order_of(const thrum_model *model) {
  cJSON *meta = model->meta && model->meta_bytes > 0
                    ? cJSON_ParseWithLength((const char *)model->meta, (size_t)model->meta_bytes)
                    : NULL;
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(meta, "options");
  const double order =
      cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(options, "quadrature_order"));
  cJSON_Delete(meta);

  // other programs may have written anything
  return order >= THRUM_QUADRATURE_ORDER_MIN && order <= THRUM_QUADRATURE_ORDER_MAX ? (int)order
                                                                                    : 0;
}

thrum_status thrum_model_fem_create(const thrum_model *model, thrum_model_fem *body,
                                    thrum_error *error) {
  thrum_model_fem made = {0};
  thrum_status status = thrum_model_borrow_mesh(model, &made.mesh, error);

  // the mass is found by trying; the stiffness is that at rest
  THRUM_THEN(status, thrum_fem_create_of_order(&made.mesh, model->fixed, order_of(model), &made.fem,
                                               error));
  THRUM_THEN(status, thrum_fem_take_state(&made.mesh, &made.fem, error));
  THRUM_THEN(status, thrum_fem_pattern(&made.fem, &made.stiffness, error));
  THRUM_THEN(status, make_mass(&made, model, error));
  THRUM_THEN(status, thrum_fem_stiffness(&made.fem, NULL, &made.stiffness, error));
  if (status >= 0)
    *body = made;
  else
    thrum_model_fem_free(&made);
  return status;
}

thrum_status thrum_model_fem_elements(const thrum_model *model, thrum_model_fem *body,
                                      thrum_error *error) {
  thrum_model_fem made = {0};
  thrum_status status = thrum_model_borrow_mesh(model, &made.mesh, error);
  THRUM_THEN(status, thrum_fem_create_of_order(&made.mesh, model->fixed, order_of(model), &made.fem,
                                               error));
  THRUM_THEN(status, thrum_fem_take_state(&made.mesh, &made.fem, error));
  made.fem.law = thrum_law_of_model(model);
  made.fem.laws = made.mesh.laws;
  if (status >= 0)
    *body = made;
  else
    thrum_model_fem_free(&made);
  return status;
}

/* The groups of a model, for as long as its mesh needs them. */
static thrum_status lend_groups(const thrum_model *model, thrum_mesh *mesh, thrum_error *error) {
  THRUM_TRY(
      thrum_reserve(&mesh->groups, model->group_count, sizeof *mesh->groups, "the groups", error));
  mesh->group_count = model->group_count;
  for (int64_t g = 0; g < model->group_count; g++) {
    const int64_t begin = g > 0 ? model->group_ends[g - 1] : 0;
    mesh->groups[g] =
        (thrum_group){.name = thrum_model_writable(thrum_model_group_name(model, g)),
                      .count = model->group_ends[g] - begin,
                      .vertices = (int32_t *)thrum_model_writable(model->group_vertices) + begin};
  }
  return THRUM_OK;
}

thrum_status thrum_model_fem_actuate(const thrum_model *model, thrum_model_fem *body,
                                     thrum_error *error) {
  const int64_t count = thrum_model_actuators(model);
  if (count == 0)
    return THRUM_OK;
  struct thrum_fem_acting *acting = NULL;
  THRUM_TRY(
      thrum_reserve(&body->actuators, count, sizeof *body->actuators, "the actuators", error));
  THRUM_TRY(thrum_reserve(&body->acting, 1, sizeof *body->acting, "the actuators", error));
  acting = body->acting;
  acting->count = count;
  acting->actuators = body->actuators;
  THRUM_TRY(
      thrum_reserve(&acting->levels, 2 * count, sizeof *acting->levels, "the actuators", error));
  acting->rest = acting->levels + count;
  thrum_status status = lend_groups(model, &body->mesh, error);
  for (int64_t k = 0; k < count && status >= 0; k++)
    status = thrum_actuator_read(&body->mesh, model->fixed, thrum_model_actuator_text(model, k),
                                 &body->actuators[k], error);
  free(body->mesh.groups);
  body->mesh.groups = NULL;
  body->mesh.group_count = 0;
  for (int64_t k = 0; k < count && status >= 0; k++)
    acting->rest[k] = thrum_fem_actuator_rest(&body->fem, &body->actuators[k]);
  if (status >= 0)
    body->fem.acting = acting;
  return status;
}

void thrum_model_fem_free(thrum_model_fem *body) {
  for (int64_t k = 0; body->acting && k < body->acting->count; k++)
    thrum_actuator_free(&body->actuators[k]);
  if (body->acting)
    free(body->acting->levels);
  free(body->acting);
  free(body->actuators);
  thrum_fem_free(&body->fem);
  thrum_sparse_free(&body->stiffness);
  thrum_sparse_free(&body->mass);
  thrum_model_return_mesh(&body->mesh);
  *body = (thrum_model_fem){0};
}
