/* Named vertex groups: their names are checked, their vertices sorted. Cost: n log n in the
 * size of a group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_groups.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/mesh_grow.h"

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

static thrum_group *find_group(thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  return NULL;
}

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
}

thrum_status thrum_mesh_add_group(thrum_mesh *mesh, const char *name, const int32_t *vertices,
                                  int64_t count, thrum_error *error) {
  if (count == 0)
    return THRUM_OK;

  // a group of that name takes the vertices too
  thrum_group *group = find_group(mesh, name);
  if (group) {
    int64_t capacity = group->count;
    if (!thrum_mesh_grow(&group->vertices, &capacity, group->count + count, sizeof *vertices))
      return no_memory(error);
    memcpy(group->vertices + group->count, vertices, (size_t)count * sizeof *vertices);
    group->count = sort_unique(group->vertices, group->count + count);
    return THRUM_OK;
  }

  // a new one gets a copy of name and vertices
  if (mesh->group_count == THRUM_MESH_GROUPS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "more than %d groups", THRUM_MESH_GROUPS_MAX);
  char *copy = malloc(strlen(name) + 1);
  int32_t *list = malloc((size_t)count * sizeof *list);
  thrum_group *groups =
      realloc(mesh->groups, (size_t)(mesh->group_count + 1) * sizeof *mesh->groups);
  if (groups)
    mesh->groups = groups;
  if (!copy || !list || !groups) {
    free(copy);
    free(list);
    return no_memory(error);
  }

  memcpy(copy, name, strlen(name) + 1);
  memcpy(list, vertices, (size_t)count * sizeof *list);
  groups[mesh->group_count++] =
      (thrum_group){.name = copy, .count = sort_unique(list, count), .vertices = list};
  return THRUM_OK;
}

thrum_status thrum_mesh_add_region_group(thrum_mesh *mesh, int32_t region, const char *name,
                                         thrum_error *error) {
  int32_t *vertices = malloc(((size_t)mesh->tet_count * 10 + 1) * sizeof *vertices);
  if (!vertices)
    return no_memory(error);
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
    mesh->region_names = calloc((size_t)mesh->region_count + 1, sizeof *mesh->region_names);
  char *copy = malloc(length + 1);
  if (!mesh->region_names || !copy) {
    free(copy);
    return no_memory(error);
  }
  memcpy(copy, name, length);
  copy[length] = '\0';
  free(mesh->region_names[region]);
  mesh->region_names[region] = copy;
  return THRUM_OK;
}

thrum_region_text thrum_mesh_region_text(const thrum_mesh *mesh, int64_t region) {
  thrum_region_text name;
  if (mesh->region_names && mesh->region_names[region])
    snprintf(name.text, sizeof name.text, "%s", mesh->region_names[region]);
  else
    snprintf(name.text, sizeof name.text, "%lld", (long long)region + 1);
  return name;
}
