/* The mesh of a model file. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/mesh_of_model.h"

#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/model/model_meta.h"
#include "mesh/elastic.h"
#include "mesh/formats/file_suffix.h"
#include "mesh/mesh_groups.h"
#include "precompute/model/model_fem.h"
#include "thrum/actuation.h"

bool mesh_of_model_is_named(const char *name) {
  return thrum_file_has_suffix(name, ".npz");
}

/* A copy of `count` items; NULL where there is nothing to copy, and where there is no memory, which
 * *whole says. */
static void *copy(const void *data, int64_t count, size_t size, bool *whole) {
  if (data == NULL)
    return NULL;
  void *made = malloc((size_t)count * size + 1);
  if (made != NULL)
    memcpy(made, data, (size_t)count * size);
  *whole = *whole && made != NULL;
  return made;
}

static void copy_groups(const thrum_model *model, thrum_mesh *mesh, bool *whole) {
  mesh->groups = calloc((size_t)model->group_count + 1, sizeof *mesh->groups);
  *whole = *whole && mesh->groups != NULL;
  for (int64_t g = 0; g < model->group_count && *whole; g++) {
    const char *name = thrum_model_group_name(model, g);
    const int32_t *vertices = NULL;
    thrum_group *group = &mesh->groups[g];
    if (thrum_model_group(model, name, &vertices, &group->count, NULL) < 0)
      continue;
    group->name = copy(name, (int64_t)strlen(name) + 1, 1, whole);
    group->vertices = copy(vertices, group->count, sizeof *vertices, whole);
    mesh->group_count = g + 1;
  }
}

/* The names of the regions, which `meta` has; a name that no mesh may have is left out. */
static thrum_status name_regions(const thrum_model *model, thrum_mesh *mesh, thrum_error *error) {
  cJSON *meta = model_meta_parse(model);
  thrum_status status = THRUM_OK;
  for (int64_t m = 0; m < model->region_count && status >= 0; m++) {
    const char *name = model_meta_region(meta, m);
    if (name != NULL)
      status = thrum_mesh_name_region(mesh, m, name, strlen(name), error);
  }
  cJSON_Delete(meta);
  return status;
}

thrum_status mesh_of_model_read(const char *path, thrum_mesh *mesh, uint8_t **fixed,
                                thrum_error *error) {
  const thrum_model *model = NULL;
  thrum_mesh lent = {0}, made = {0};
  uint8_t *held = NULL;
  bool whole = true;
  THRUM_TRY(thrum_model_load(path, &model, error));
  if (model->about) {
    thrum_model_destroy(model);
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s is about a state, which is no shape to begin with: give the "
                           "mesh that it was made from",
                           path);
  }
  thrum_status status = thrum_model_borrow_mesh(model, &lent, error);
  if (status >= 0 && thrum_model_actuators(model) > 0)
    config_warn("%s: its mesh is taken, and its actuators are not: give --actuator again", path);

  // the materials are a copy already, all else stays in the model
  if (status >= 0) {
    made = lent;
    made.groups = NULL;
    made.group_count = 0;
    made.vertices = copy(lent.vertices, 3 * lent.vertex_count, sizeof *lent.vertices, &whole);
    made.tets = copy(lent.tets, 4 * lent.tet_count, sizeof *lent.tets, &whole);
    made.midsides = copy(lent.midsides, 6 * lent.tet_count, sizeof *lent.midsides, &whole);
    made.tet_region = copy(lent.tet_region, lent.tet_count, sizeof *lent.tet_region, &whole);
    made.springs = copy(lent.springs, 3 * lent.vertex_count, sizeof *lent.springs, &whole);
    made.elastic = copy(lent.elastic, THRUM_ELASTIC_NUMBERS * lent.elastic_count,
                        sizeof *lent.elastic, &whole);
    made.solid_count = lent.solid_count;
    made.solid_form = copy(lent.solid_form, lent.solid_count, 1, &whole);
    made.solid_ends = copy(lent.solid_ends, lent.solid_count, sizeof *lent.solid_ends, &whole);
    made.solid_nodes =
        copy(lent.solid_nodes, model->solid_node_count, sizeof *lent.solid_nodes, &whole);
    made.solid_tet_ends =
        copy(lent.solid_tet_ends, lent.solid_count, sizeof *lent.solid_tet_ends, &whole);
    made.file_vertex_count = lent.vertex_count;
    held = copy(model->fixed, model->vertex_count, 1, &whole);
    copy_groups(model, &made, &whole);
    if (!whole)
      status =
          thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the mesh of %.200s", path);
    THRUM_THEN(status, name_regions(model, &made, error));
  }

  thrum_model_destroy(model);
  if (status < 0)
    free(held);
  else
    *fixed = held;
  return thrum_mesh_deliver(status, &made, mesh);
}
