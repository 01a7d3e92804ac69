/* The arrays of a freshly precomputed model, see model_fill.h. SPDX-License-Identifier: Apache-2.0
 */
#include "precompute/model/model_fill.h"

#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

double *thrum_model_writable(const double *array) {
  // a model only reads its arrays; until the caller has it they are ours
  union {
    const double *read;
    double *write;
  } pointer = {.read = array};
  return pointer.write;
}

static void free_const(const void *array) {
  union {
    const void *read;
    void *write;
  } pointer = {.read = array};
  free(pointer.write);
}

static void *copy(const void *source, int64_t count, size_t size, thrum_error *error) {
  void *made = thrum_allocate(count, size, "the model", error);
  if (made && count > 0)
    memcpy(made, source, (size_t)count * size);
  return made;
}

static thrum_status fill_groups(const thrum_mesh *mesh, thrum_model *model, thrum_error *error) {
  if (mesh->group_count == 0)
    return THRUM_OK;

  for (int64_t g = 0; g < mesh->group_count; g++) {
    model->group_name_bytes += (int64_t)strlen(mesh->groups[g].name) + 1;
    model->group_vertex_count += mesh->groups[g].count;
  }

  // names one after the other, and the vertices of all groups with the end of each
  uint8_t *names = thrum_allocate(model->group_name_bytes, 1, "the model", error);
  model->group_names = names;
  int32_t *ends =
      names ? thrum_allocate(mesh->group_count, sizeof *ends, "the model", error) : NULL;
  model->group_ends = ends;
  int32_t *vertices =
      ends ? thrum_allocate(model->group_vertex_count, sizeof *vertices, "the model", error) : NULL;
  model->group_vertices = vertices;
  if (!vertices)
    return THRUM_OUT_OF_MEMORY;

  model->group_count = mesh->group_count;

  int32_t end = 0;
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

  // other readers know ten-node tetrahedra by the version
  const bool quadratic = model->midsides != NULL;
  const int32_t format[2] = {
      quadratic ? THRUM_MODEL_FORMAT_MAJOR_QUADRATIC : THRUM_MODEL_FORMAT_MAJOR,
      (quadratic ? THRUM_MODEL_FORMAT_MINOR_QUADRATIC : THRUM_MODEL_FORMAT_MINOR) +
          (points ? THRUM_MODEL_FORMAT_MINOR_POINTS : 0)};

  // the polynomial, and the basis that it is of
  if (!points &&
      (!(model->c3 = thrum_allocate(model->c3_count, sizeof(double), "the model", error)) ||
       !(model->c4 = thrum_allocate(model->c4_count, sizeof(double), "the model", error))))
    return THRUM_OUT_OF_MEMORY;
  if (!(model->format = copy(format, 2, sizeof *format, error)) ||
      !(model->omega2 = thrum_allocate(rank, sizeof(double), "the model", error)) ||
      !(model->axis_mass = thrum_allocate(3 * rank, sizeof(double), "the model", error)) ||
      !(model->basis =
            thrum_allocate(3 * model->vertex_count * rank, sizeof(double), "the model", error)))
    return THRUM_OUT_OF_MEMORY;
  return THRUM_OK;
}

thrum_status thrum_model_fill_mesh(const thrum_mesh *mesh, const uint8_t *fixed, int64_t rank,
                                   bool points, thrum_model *model, thrum_error *error) {
  model->vertex_count = mesh->vertex_count;
  model->tet_count = mesh->tet_count;
  model->region_count = mesh->region_count;

  // materials as rows of E, nu and rho
  double *material = thrum_allocate(3 * mesh->region_count, sizeof *material, "the model", error);
  model->material = material;
  if (!material)
    return THRUM_OUT_OF_MEMORY;
  for (int64_t i = 0; i < mesh->region_count; i++) {
    material[3 * i] = mesh->materials[i].young;
    material[3 * i + 1] = mesh->materials[i].poisson;
    material[3 * i + 2] = mesh->materials[i].density;
  }

  // the mesh is copied, so the model needs it no longer
  if (!(model->vertices = copy(mesh->vertices, 3 * mesh->vertex_count, sizeof(double), error)) ||
      !(model->tets = copy(mesh->tets, 4 * mesh->tet_count, sizeof(int32_t), error)) ||
      !(model->tet_region = copy(mesh->tet_region, mesh->tet_count, sizeof(int32_t), error)) ||
      !(model->fixed = copy(fixed, mesh->vertex_count, 1, error)))
    return THRUM_OUT_OF_MEMORY;
  if (mesh->midsides &&
      !(model->midsides = copy(mesh->midsides, 6 * mesh->tet_count, sizeof(int32_t), error)))
    return THRUM_OUT_OF_MEMORY;
  THRUM_TRY(fill_reduced(rank, points, model, error));
  return fill_groups(mesh, model, error);
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
#define X(type, name, rows, columns, presence, meaning) free_const(model->name);
  THRUM_MODEL_ARRAYS(X)
#undef X
  *model = (thrum_model){0};
}
