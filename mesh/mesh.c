/* The mesh itself: release, volume and hash. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "io/file_hash.h"
#include "mesh/mesh_grow.h"

void thrum_mesh_free(thrum_mesh *mesh) {
  for (int64_t g = 0; g < mesh->group_count; g++) {
    free(mesh->groups[g].name);
    free(mesh->groups[g].vertices);
  }

  // arrays by vertex, tet and region
  free(mesh->groups);
  free(mesh->vertices);
  free(mesh->tets);
  free(mesh->midsides);
  free(mesh->tet_region);
  thrum_mesh_drop_solids(mesh);
  free(mesh->materials);
  free(mesh->laws);
  free(mesh->elastic);
  free(mesh->springs);
  free(mesh->about);
  for (int64_t i = 0; i < mesh->region_count && mesh->region_names; i++)
    free(mesh->region_names[i]);
  free(mesh->region_names);

  // what is known of the file
  free(mesh->file_vertex);
  free(mesh->file_number);
  free(mesh->tet_line);
  free(mesh->tet_number);
  free(mesh->notes);
  *mesh = (thrum_mesh){0};
}

void thrum_mesh_drop_solids(thrum_mesh *mesh) {
  free(mesh->solid_form);
  free(mesh->solid_ends);
  free(mesh->solid_nodes);
  free(mesh->solid_tet_ends);
  mesh->solid_form = NULL;
  mesh->solid_ends = mesh->solid_nodes = mesh->solid_tet_ends = NULL;
  mesh->solid_count = 0;
}

thrum_status thrum_mesh_deliver(thrum_status status, thrum_mesh *read, thrum_mesh *mesh) {
  if (status < 0)
    thrum_mesh_free(read);
  else
    *mesh = *read;
  return status;
}

int64_t thrum_mesh_add_note(thrum_mesh *mesh, const char *format, ...) {
  if (thrum_mesh_grow(&mesh->notes, mesh->note_count, 1, sizeof *mesh->notes, NULL) < 0)
    return 0;
  thrum_mesh_note *note = &mesh->notes[mesh->note_count++];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(note->text, sizeof note->text, format, arguments);
  va_end(arguments);
  return mesh->note_count;
}

int64_t thrum_mesh_number(const thrum_mesh *mesh, int64_t v) {
  return mesh->file_number && v < mesh->file_vertex_count ? mesh->file_number[v] : v + 1;
}

int64_t thrum_mesh_vertex_of(const thrum_mesh *mesh, int64_t number) {
  const int64_t count = mesh->file_vertex_count > 0 ? mesh->file_vertex_count : mesh->vertex_count;
  for (int64_t v = 0; v < count; v++)
    if (thrum_mesh_number(mesh, v) == number)
      return mesh->file_vertex ? mesh->file_vertex[v] : v;
  return -1;
}

thrum_tet_text thrum_mesh_tet_text(const thrum_mesh *mesh, int64_t t) {
  thrum_tet_text name;
  snprintf(name.text, sizeof name.text, "%s %lld",
           mesh->cut_elements > 0 || mesh->solid_count > 0 ? "element" : "tet",
           mesh->tet_number ? (long long)mesh->tet_number[t] : (long long)t + 1);
  return name;
}

int thrum_mesh_nodes(const thrum_mesh *mesh, int64_t t, int32_t nodes[10]) {
  memcpy(nodes, mesh->tets + 4 * t, 4 * sizeof *nodes);
  if (!mesh->midsides)
    return 4;
  memcpy(nodes + 4, mesh->midsides + 6 * t, 6 * sizeof *nodes);
  return 10;
}

int32_t thrum_mesh_middle_node(const thrum_mesh *mesh, int64_t t, int32_t from, int32_t to) {
  const int32_t *corner = mesh->tets + 4 * t;
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
    const int32_t a = corner[thrum_quadratic_edges[e][0]], b = corner[thrum_quadratic_edges[e][1]];
    if ((a == from && b == to) || (a == to && b == from))
      return mesh->midsides[6 * t + e];
  }
  return -1;
}

double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t) {
  if (mesh->midsides) {
    int32_t node[10];
    double places[10][3];
    thrum_mesh_nodes(mesh, t, node);
    for (int a = 0; a < 10; a++)
      memcpy(places[a], mesh->vertices + 3 * (int64_t)node[a], sizeof places[a]);
    return thrum_quadratic_volume(places);
  }

  double edges[3][3];
  thrum_tet_edges(mesh->vertices, mesh->tets + 4 * t, edges);
  return thrum_triple3(edges[0], edges[1], edges[2]) / 6;
}

/* The eight bytes of a number, lowest first, on any machine. */
static uint64_t hash_number(uint64_t hash, uint64_t number) {
  unsigned char bytes[8];
  for (int i = 0; i < 8; i++)
    bytes[i] = (unsigned char)(number >> 8 * i);
  return hash_bytes(hash, bytes, sizeof bytes);
}

uint64_t thrum_mesh_hash(const thrum_mesh *mesh) {
  uint64_t hash = hash_number(0, (uint64_t)mesh->vertex_count);
  hash = hash_number(hash, (uint64_t)mesh->tet_count);

  // positions to the last bit, then what joins them
  for (int64_t i = 0; i < 3 * mesh->vertex_count; i++) {
    uint64_t bits;
    memcpy(&bits, &mesh->vertices[i], sizeof bits);
    hash = hash_number(hash, bits);
  }
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    hash = hash_number(hash, (uint64_t)mesh->tets[i]);
  for (int64_t t = 0; t < mesh->tet_count; t++)
    hash = hash_number(hash, (uint64_t)mesh->tet_region[t]);
  for (int64_t i = 0; i < 6 * mesh->tet_count && mesh->midsides; i++)
    hash = hash_number(hash, (uint64_t)mesh->midsides[i]);
  for (int64_t i = 0; i < mesh->solid_count; i++)
    hash = hash_number(hash, mesh->solid_form[i]);
  for (int64_t i = 0; i < thrum_mesh_solid_nodes(mesh); i++)
    hash = hash_number(hash, (uint64_t)mesh->solid_nodes[i]);
  return hash;
}
