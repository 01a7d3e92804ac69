/* The arrays of a freshly precomputed model, see model_fill.h. SPDX-License-Identifier: Apache-2.0
 */
#include "precompute/model/model_fill.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/elastic.h"
#include "platform/allocate.h"

void *thrum_model_writable(const void *array) {
  // a model only reads its arrays; until the caller has it they are ours
  union {
    const void *read;
    void *write;
  } pointer = {.read = array};
  return pointer.write;
}

/* A copy of an array for *kept, a member of the model. */
static thrum_status keep(void *kept, const void *source, int64_t count, size_t size,
                         thrum_error *error) {
  void *made = NULL;
  THRUM_TRY(thrum_reserve(&made, count, size, "the model", error));
  if (count > 0)
    memcpy(made, source, (size_t)count * size);
  memcpy(kept, &made, sizeof made);
  return THRUM_OK;
}

static thrum_status fill_groups(const thrum_mesh *mesh, thrum_model *model, thrum_error *error) {
  if (mesh->group_count == 0)
    return THRUM_OK;

  for (int64_t g = 0; g < mesh->group_count; g++) {
    model->group_name_bytes += (int64_t)strlen(mesh->groups[g].name) + 1;
    model->group_vertex_count += mesh->groups[g].count;
  }

  // names one after the other, and the vertices of all groups with the end of each
  THRUM_TRY(thrum_reserve(&model->group_names, model->group_name_bytes, 1, "the model", error));
  THRUM_TRY(
      thrum_reserve(&model->group_ends, mesh->group_count, sizeof(int32_t), "the model", error));
  THRUM_TRY(thrum_reserve(&model->group_vertices, model->group_vertex_count, sizeof(int32_t),
                          "the model", error));
  model->group_count = mesh->group_count;

  uint8_t *names = thrum_model_writable(model->group_names);
  int32_t *ends = thrum_model_writable(model->group_ends), end = 0;
  int32_t *vertices = thrum_model_writable(model->group_vertices);
  for (int64_t g = 0; g < mesh->group_count; g++) {
    const thrum_group *group = &mesh->groups[g];
    const size_t length = strlen(group->name) + 1;
    memcpy(names, group->name, length);
    names += length;
    if (group->count > 0)
      memcpy(vertices + end, group->vertices, sizeof *vertices * (size_t)group->count);
    ends[g] = end += (int32_t)group->count;
  }
  return THRUM_OK;
}

// the arrays that later stages write
static thrum_status fill_reduced(int64_t rank, bool points, thrum_model *model,
                                 thrum_error *error) {
  model->rank = rank;
  model->c3_count = points ? 0 : thrum_c3_count(rank);
  model->c4_count = points ? 0 : thrum_c4_count(rank);

  // other readers know ten-node tetrahedra and solids by the version
  const bool quadratic = model->midsides != NULL;
  int32_t format[2] = {quadratic ? THRUM_MODEL_FORMAT_MAJOR_QUADRATIC : THRUM_MODEL_FORMAT_MAJOR,
                       (quadratic ? THRUM_MODEL_FORMAT_MINOR_QUADRATIC : THRUM_MODEL_FORMAT_MINOR) +
                           (points ? THRUM_MODEL_FORMAT_MINOR_POINTS : 0)};
  if (model->solid_count > 0) {
    format[0] = THRUM_MODEL_FORMAT_MAJOR_SOLIDS;
    format[1] = THRUM_MODEL_FORMAT_MINOR_SOLIDS +
                (model->elastic_count > 0 ? THRUM_MODEL_FORMAT_MINOR_ELASTIC : 0) +
                (model->about ? THRUM_MODEL_FORMAT_MINOR_ABOUT : 0);
  }

  // the polynomial, and the basis that it is of
  if (!points) {
    THRUM_TRY(thrum_reserve(&model->c3, model->c3_count, sizeof(double), "the model", error));
    THRUM_TRY(thrum_reserve(&model->c4, model->c4_count, sizeof(double), "the model", error));
  }
  THRUM_TRY(keep(&model->format, format, 2, sizeof *format, error));
  THRUM_TRY(thrum_reserve(&model->omega2, rank, sizeof(double), "the model", error));
  THRUM_TRY(thrum_reserve(&model->axis_mass, 3 * rank, sizeof(double), "the model", error));
  return thrum_reserve(&model->basis, 3 * model->vertex_count * rank, sizeof(double), "the model",
                       error);
}

static thrum_status fill_solids(const thrum_mesh *mesh, thrum_model *model, thrum_error *error) {
  const int64_t count = mesh->solid_count;
  if (count == 0)
    return THRUM_OK;
  model->solid_count = count;
  model->solid_node_count = thrum_mesh_solid_nodes(mesh);
  THRUM_TRY(keep(&model->solid_form, mesh->solid_form, count, 1, error));
  THRUM_TRY(keep(&model->solid_ends, mesh->solid_ends, count, sizeof(int32_t), error));
  THRUM_TRY(keep(&model->solid_nodes, mesh->solid_nodes, model->solid_node_count, sizeof(int32_t),
                 error));
  return keep(&model->solid_tet_ends, mesh->solid_tet_ends, count, sizeof(int32_t), error);
}

thrum_status thrum_model_fill_mesh(const thrum_mesh *mesh, const uint8_t *fixed, int64_t rank,
                                   bool points, thrum_model *model, thrum_error *error) {
  model->vertex_count = mesh->vertex_count;
  model->tet_count = mesh->tet_count;
  model->region_count = mesh->region_count;

  // materials as rows of E, nu and rho
  THRUM_TRY(
      thrum_reserve(&model->material, 3 * mesh->region_count, sizeof(double), "the model", error));
  double *material = thrum_model_writable(model->material);
  for (int64_t i = 0; i < mesh->region_count; i++) {
    material[3 * i] = mesh->materials[i].young;
    material[3 * i + 1] = mesh->materials[i].poisson;
    material[3 * i + 2] = mesh->materials[i].density;
  }

  // the mesh is copied, so the model needs it no longer
  const int64_t tets = mesh->tet_count, vertices = mesh->vertex_count;
  THRUM_TRY(keep(&model->vertices, mesh->vertices, 3 * vertices, sizeof(double), error));
  THRUM_TRY(keep(&model->tets, mesh->tets, 4 * tets, sizeof(int32_t), error));
  THRUM_TRY(keep(&model->tet_region, mesh->tet_region, tets, sizeof(int32_t), error));
  THRUM_TRY(keep(&model->fixed, fixed, vertices, 1, error));
  if (mesh->midsides)
    THRUM_TRY(keep(&model->midsides, mesh->midsides, 6 * tets, sizeof(int32_t), error));
  if (mesh->springs)
    THRUM_TRY(keep(&model->springs, mesh->springs, 3 * vertices, sizeof(double), error));
  THRUM_TRY(fill_solids(mesh, model, error));
  if (mesh->about)
    THRUM_TRY(keep(&model->about, mesh->about, 3 * vertices, sizeof(double), error));
  double *places = thrum_model_writable(model->vertices);
  for (int64_t c = 0; c < 3 * vertices && mesh->about; c++)
    places[c] += mesh->about[c];
  model->elastic_count = mesh->elastic_count;
  if (mesh->elastic_count > 0)
    THRUM_TRY(keep(&model->elastic, mesh->elastic, THRUM_ELASTIC_NUMBERS * mesh->elastic_count,
                   sizeof(double), error));
  THRUM_TRY(fill_reduced(rank, points, model, error));
  return fill_groups(mesh, model, error);
}

/* Fills the laws of the regions, and their yields where one has any. */
static thrum_status fill_laws(const thrum_fem *fem, thrum_model *model, thrum_error *error) {
  uint8_t *laws = NULL;
  double *yields = NULL;
  THRUM_TRY(thrum_reserve(&laws, fem->region_count, 1, "the model", error));
  model->region_law = laws;
  model->law_count = fem->region_count;
  if (thrum_fem_has_yield(fem))
    THRUM_TRY(thrum_reserve(&yields, fem->region_count, sizeof *yields, "the model", error));
  model->region_yield = yields;

  // a region without a yield of its own has 0
  for (int64_t i = 0; i < fem->region_count; i++) {
    laws[i] = (uint8_t)fem->laws[i].law;
    if (yields)
      yields[i] = fem->laws[i].yield;
  }
  return THRUM_OK;
}

thrum_status thrum_model_fill_law(const thrum_fem *fem, thrum_model *model, thrum_error *error) {
  const thrum_law law = fem->law;
  if (law == THRUM_LAW_STVK)
    return THRUM_OK;
  int32_t *format = thrum_model_writable(model->format);
  if (law == THRUM_LAW_BY_REGION) {
    format[0] = THRUM_MODEL_FORMAT_MAJOR_REGIONS;
    format[1] = THRUM_MODEL_FORMAT_MINOR_REGIONS;
    return fill_laws(fem, model, error);
  }
  format[0] = THRUM_MODEL_FORMAT_MAJOR_LAW;
  format[1] = THRUM_MODEL_FORMAT_MINOR_LAW;
  const char *name = thrum_law_name(law);
  model->law_bytes = (int64_t)strlen(name) + 1;
  return keep(&model->point_law, name, model->law_bytes, 1, error);
}

thrum_status thrum_model_fill_axis_mass(const thrum_fem *fem, thrum_mass kind, thrum_model *model,
                                        thrum_error *error) {
  double *mass = NULL;
  THRUM_TRY(thrum_reserve(&mass, fem->vertex_count, sizeof *mass, "the model", error));
  thrum_fem_vertex_mass(fem, kind, mass);

  double *axis_mass = thrum_model_writable(model->axis_mass);
  memset(axis_mass, 0, sizeof *axis_mass * (size_t)(3 * model->rank));
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    for (int64_t i = 0; i < model->rank; i++)
      axis_mass[c % 3 * model->rank + i] += mass[c / 3] * model->basis[c * model->rank + i];
  thrum_ranks_sum(fem->ranks, axis_mass, 3 * model->rank);

  free(mass);
  return THRUM_OK;
}

thrum_status thrum_model_fill_rigid(const thrum_fem *fem, const double *modes, thrum_model *model,
                                    thrum_error *error) {
  double *rigid = NULL;
  THRUM_TRY(thrum_reserve(&rigid, 18 * fem->vertex_count, sizeof *rigid, "the model", error));
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    for (int i = 0; i < 6; i++)
      rigid[6 * c + i] = modes[i * fem->free_count + fem->dof[c]];
  model->rigid = rigid;
  return THRUM_OK;
}

void thrum_model_fill_free(thrum_model *model) {
  model->meta = NULL;
#define X(type, name, rows, columns, presence, meaning) free(thrum_model_writable(model->name));
  THRUM_MODEL_ARRAYS(X)
#undef X
  *model = (thrum_model){0};
}
