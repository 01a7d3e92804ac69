/* Meshes are written by the writer that the suffix of the file names. Cost: linear in the mesh,
 * times the number of regions for their names.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_write.h"

#include <string.h>

#include "mesh/elastic.h"
#include "mesh/formats/file_suffix.h"
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_elements.h"
#include "platform/allocate.h"

/* Finds the group that has exactly the vertices of a region; returns -1 when there is none. */
static int64_t find_region_group(const thrum_mesh *mesh, int64_t region, uint8_t *in_region) {
  memset(in_region, 0, (size_t)mesh->vertex_count);

  // regions have no names of their own, but a group of the same vertices has one
  int64_t count = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    if (mesh->tet_region[t] == region) {
      int32_t v[10];
      const int nodes = thrum_mesh_nodes(mesh, t, v);
      for (int a = 0; a < nodes; a++) {
        count += !in_region[v[a]];
        in_region[v[a]] = 1;
      }
    }
  }

  // a group of as many vertices, all of them in the region, has exactly these
  for (int64_t g = 0; g < mesh->group_count; g++) {
    const thrum_group *group = &mesh->groups[g];
    int64_t i = 0;
    while (group->count == count && i < count && in_region[group->vertices[i]])
      i++;
    if (i == count && group->count == count)
      return g;
  }

  return -1;
}

static thrum_status match_regions(thrum_mesh_written *w, thrum_scope *memory, thrum_error *error) {
  const thrum_mesh *m = w->mesh;
  thrum_scope scope = thrum_scope_begin("the groups of regions", error);
  uint8_t *in_region = thrum_scope_allocate(&scope, m->vertex_count, 1);
  w->region_group = thrum_scope_allocate(memory, m->region_count, sizeof *w->region_group);
  w->group_region = thrum_scope_allocate(memory, m->group_count, sizeof *w->group_region);
  thrum_status status = scope.status < 0 ? scope.status : memory->status;

  // the group is written as the region, so that it is not written twice
  for (int64_t g = 0; g < m->group_count && status >= 0; g++)
    w->group_region[g] = -1;
  for (int64_t i = 0; i < m->region_count && status >= 0; i++) {
    int64_t g = find_region_group(m, i, in_region);

    // a group names one region only
    if (g >= 0 && w->group_region[g] >= 0)
      g = -1;
    w->region_group[i] = g;
    if (g >= 0)
      w->group_region[g] = i;
  }

  thrum_scope_free(&scope);
  return status;
}

/* Writes one file up to its commit. */
static thrum_status write_file(const char *path, thrum_mesh_writer *writer, thrum_mesh_written *w,
                               thrum_scope *memory, thrum_mesh_out **result, thrum_error *error) {
  thrum_mesh_out *out = thrum_scope_allocate(memory, 1, sizeof *out);
  THRUM_TRY(memory->status);

  // the writer stops at the first failure, and the status is checked only here
  out->error = error;
  out->status = thrum_file_writer_open(path, &out->file, error);
  if (out->status >= 0) {
    writer(out, w);
    thrum_out_flush(out);
  }

  *result = out;
  return out->status;
}

/* Writes one file, or TetGen's two, which are both complete before either takes its place. */
static thrum_status write_files(const char *const *paths, thrum_mesh_writer *const *writers,
                                int count, thrum_mesh_written *w, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the output", error);
  thrum_mesh_out *outs[2] = {NULL, NULL};
  thrum_status status = match_regions(w, &memory, error);

  // each step is done for both files, so that a failure before the last leaves both old files
  for (int i = 0; i < count && status >= 0; i++)
    status = write_file(paths[i], writers[i], w, &memory, &outs[i], error);
  for (int i = 0; i < count && status >= 0; i++)
    status = thrum_file_writer_finish(&outs[i]->file, error);
  for (int i = 0; i < count && status >= 0; i++)
    status = thrum_file_writer_commit(&outs[i]->file, error);

  // files that were not committed are removed
  for (int i = 0; i < count; i++)
    if (outs[i])
      thrum_file_writer_abandon(&outs[i]->file);
  thrum_scope_free(&memory);
  return status;
}

static thrum_status write_tetgen(const char *path, thrum_mesh_written *w, thrum_error *error) {
  thrum_mesh_writer *const writers[2] = {thrum_mesh_write_node, thrum_mesh_write_ele};
  thrum_scope scope = thrum_scope_begin("the names of the files", error);
  const char *const paths[2] = {thrum_tetgen_name(path, ".node", &scope),
                                thrum_tetgen_name(path, ".ele", &scope)};
  thrum_status status = scope.status;
  THRUM_THEN(status, write_files(paths, writers, 2, w, error));
  thrum_scope_free(&scope);
  return status;
}

bool thrum_mesh_write_takes(const char *path, thrum_solid_form form) {
  if (thrum_file_has_suffix(path, ".veg"))
    return form == THRUM_FORM_TET4;
  if (thrum_file_has_suffix(path, ".node") || thrum_file_has_suffix(path, ".ele"))
    return form == THRUM_FORM_TET4 || form == THRUM_FORM_TET10;
  return !thrum_file_has_suffix(path, ".mesh") ||
         (form != THRUM_FORM_WEDGE15 && form != THRUM_FORM_HEX20);
}

/* Refuses elements that the format does not have. */
static thrum_status check_forms(const char *path, const thrum_mesh *mesh, thrum_error *error) {
  int64_t counts[THRUM_FORMS];
  thrum_mesh_count_forms(mesh, counts);
  for (int form = 0; form < THRUM_FORMS; form++)
    if (counts[form] > 0 && !thrum_mesh_write_takes(path, (thrum_solid_form)form))
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "%.200s: the format has no %s; write another one, or give --element "
                             "tet",
                             path, thrum_solid_forms[form].name);
  return THRUM_OK;
}

thrum_status thrum_mesh_write(const char *path, const thrum_mesh *mesh,
                              const thrum_mesh_write_options *options, thrum_mesh_lost *lost,
                              thrum_error *error) {
  static const struct {
    const char *suffix;
    thrum_mesh_writer *write;
  } writers[] = {{".veg", thrum_mesh_write_veg},    {".msh", thrum_mesh_write_msh},
                 {".mesh", thrum_mesh_write_medit}, {".vtk", thrum_mesh_write_vtk},
                 {".vtu", thrum_mesh_write_vtu},    {".inp", thrum_mesh_write_abaqus}};

  if (mesh->midsides && thrum_file_has_suffix(path, ".veg"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: Vega's format has no tets of ten nodes; write another one, or "
                           "give --order 1",
                           path);

  THRUM_TRY(check_forms(path, mesh, error));
  thrum_mesh_written w = {.mesh = mesh, .options = *options};
  thrum_status status = THRUM_UNSUPPORTED;

  // only TetGen's format needs two files
  if (thrum_file_has_suffix(path, ".node") || thrum_file_has_suffix(path, ".ele")) {
    status = write_tetgen(path, &w, error);
  } else {
    size_t i = 0;
    const size_t count = sizeof writers / sizeof *writers;
    while (i < count && !thrum_file_has_suffix(path, writers[i].suffix))
      i++;
    if (i == count)
      return thrum_error_set(error, status,
                             "%.200s: unknown kind of mesh; name a .veg, .msh, .node, .ele, .mesh, "
                             ".vtk, .vtu or .inp file",
                             path);
    status = write_files(&path, &writers[i].write, 1, &w, error);
  }

  // directions are those of decks, and layers have no place anywhere
  for (int64_t i = 0; i < mesh->region_count; i++) {
    const int64_t begin = thrum_mesh_elastic_begin(mesh, i);
    if (begin < thrum_mesh_elastic_begin(mesh, i + 1) &&
        (!thrum_file_has_suffix(path, ".inp") ||
         mesh->elastic[THRUM_ELASTIC_NUMBERS * begin + THRUM_ELASTIC_THICKNESS] > 0))
      w.lost.directed++;
  }
  if (status >= 0)
    *lost = w.lost;
  return status;
}
