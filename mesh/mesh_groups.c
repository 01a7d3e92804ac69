/* Named vertex groups: their names are checked, their vertices sorted. Cost: n log n in the
 * size of a group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_groups.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

const char *thrum_mesh_name_fault(const char *name, size_t length) {
  if (length == 0)
    return "a name is empty";
  if (length > THRUM_MESH_NAME_MAX)
    return "a name is longer than 255 bytes";

  // printable UTF-8, as names end up in JSON and on terminals
  for (size_t i = 0; i < length;) {
    const unsigned char lead = (unsigned char)name[i];
    if (lead < 0x20 || lead == 0x7f)
      return "a name holds a control character";
    const int bytes = thrum_utf8_length(name + i, length - i);
    if (bytes == 0)
      return "a name is not UTF-8";
    i += (size_t)bytes;
  }
  return NULL;
}

thrum_status thrum_mesh_name_check(const thrum_text *text, thrum_word name) {
  const char *fault = thrum_mesh_name_fault(name.text, name.length);
  return fault ? thrum_text_fail(text, THRUM_BAD_FORMAT, "%s", fault) : THRUM_OK;
}

thrum_status thrum_mesh_append_few(const thrum_text *text, const char *what, void *array,
                                   int64_t *count, const void *item, size_t size) {
  if (*count == THRUM_MESH_GROUPS_MAX)
    return thrum_text_fail(text, THRUM_UNSUPPORTED, "more than %d %s", THRUM_MESH_GROUPS_MAX, what);
  return thrum_mesh_append(array, count, item, size, text->error);
}

static int compare_vertices(const void *a, const void *b) {
  int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
  return (x > y) - (x < y);
}

static int64_t sort_unique(int32_t *vertices, int64_t count) {
  qsort(vertices, (size_t)count, sizeof *vertices, compare_vertices);
  int64_t kept = 0;
  for (int64_t i = 0; i < count; i++)
    if (kept == 0 || vertices[i] != vertices[kept - 1])
      vertices[kept++] = vertices[i];
  return kept;
}

thrum_group *thrum_mesh_find_group(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  return NULL;
}

thrum_status thrum_mesh_keep_text(const char *text, size_t length, char **kept,
                                  thrum_error *error) {
  char *copy = NULL;
  THRUM_TRY(thrum_reserve(&copy, (int64_t)length + 1, 1, "the mesh", error));
  memcpy(copy, text, length);
  free(*kept);
  *kept = copy;
  return THRUM_OK;
}

thrum_status thrum_mesh_add_group(thrum_mesh *mesh, const char *name, const int32_t *vertices,
                                  int64_t count, thrum_error *error) {
  if (count == 0)
    return THRUM_OK;

  // a group of that name takes the vertices too
  thrum_group *group = thrum_mesh_find_group(mesh, name);
  const int64_t before = group ? group->count : 0;
  thrum_group made = {0};
  if (!group && mesh->group_count == THRUM_MESH_GROUPS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "more than %d groups", THRUM_MESH_GROUPS_MAX);
  thrum_status status =
      thrum_reserve(&made.vertices, before + count, sizeof *vertices, "the mesh", error);
  if (status >= 0) {
    if (before > 0)
      memcpy(made.vertices, group->vertices, (size_t)before * sizeof *vertices);
    memcpy(made.vertices + before, vertices, (size_t)count * sizeof *vertices);
    made.count = sort_unique(made.vertices, before + count);
  }

  // its list is another now, or it is a new one, with a copy of the name
  if (status >= 0 && group) {
    free(group->vertices);
    group->vertices = made.vertices;
    group->count = made.count;
    return THRUM_OK;
  }
  THRUM_THEN(status, thrum_mesh_keep_text(name, strlen(name), &made.name, error));
  THRUM_THEN(status,
             thrum_mesh_append(&mesh->groups, &mesh->group_count, &made, sizeof made, error));
  if (status < 0) {
    free(made.name);
    free(made.vertices);
  }
  return status;
}

thrum_status thrum_mesh_add_region_group(thrum_mesh *mesh, int32_t region, const char *name,
                                         thrum_error *error) {
  int32_t *vertices = NULL;
  THRUM_TRY(thrum_reserve(&vertices, 10 * mesh->tet_count, sizeof *vertices, "the mesh", error));
  int64_t count = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    if (mesh->tet_region[t] == region)
      count += thrum_mesh_nodes(mesh, t, vertices + count);
  thrum_status status = thrum_mesh_add_group(mesh, name, vertices, count, error);
  free(vertices);
  return status;
}

thrum_status thrum_mesh_name_region(thrum_mesh *mesh, int64_t region, const char *name,
                                    size_t length, thrum_error *error) {
  if (!mesh->region_names)
    THRUM_TRY(thrum_reserve(&mesh->region_names, mesh->region_count, sizeof *mesh->region_names,
                            "the mesh", error));
  return thrum_mesh_keep_text(name, length, &mesh->region_names[region], error);
}

thrum_region_text thrum_mesh_region_text(const thrum_mesh *mesh, int64_t region) {
  thrum_region_text name;
  if (mesh->region_names && mesh->region_names[region])
    snprintf(name.text, sizeof name.text, "%s", mesh->region_names[region]);
  else
    snprintf(name.text, sizeof name.text, "%lld", (long long)region + 1);
  return name;
}
