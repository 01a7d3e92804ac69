/* Finer hexahedra, see refine_solids.h. An element is a lattice of 3 x 3 x 3 places, of
 * solid-shells without the middle layer; a place lies between the corners that its odd numbers
 * leave open.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/refine_solids.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/number_map.h"
#include "mesh/solids.h"
#include "platform/allocate.h"

#define WHAT "the finer mesh"

enum { CORNERS = 8, NEW_MAX = 19, PARTS_MAX = 8 };

/* The corner of a hexahedron on each side along its three directions. */
static const int corner_of[2][2][2] = {{{0, 4}, {3, 7}}, {{1, 5}, {2, 6}}};

typedef struct refining {
  const thrum_mesh *mesh;
  const uint8_t *fixed;
  bool sheet;
  thrum_mesh *finer;
  uint8_t *held;
  thrum_number_map seen; /* new vertices, by the corners around them */
} refining;

static bool is_sheet(const thrum_mesh *mesh) {
  for (int64_t s = 0; s < mesh->solid_count; s++)
    if (mesh->solid_form[s] != THRUM_FORM_SHELL8)
      return false;
  return true;
}

int64_t thrum_mesh_refined_count(const thrum_mesh *mesh) {
  for (int64_t s = 0; s < mesh->solid_count; s++)
    if (mesh->solid_form[s] != THRUM_FORM_HEX8 && mesh->solid_form[s] != THRUM_FORM_SHELL8)
      return 0;
  return (is_sheet(mesh) ? PARTS_MAX / 2 : PARTS_MAX) * mesh->solid_count;
}

/* The corners around a place of the lattice, the one with the lower numbers first and the one
 * across from it last; returns how many. */
static int around(const int32_t *node, const int at[3], int32_t corners[CORNERS]) {
  int count = 0;
  for (int n = 0; n < CORNERS; n++) {
    const int side[3] = {n & 1, n >> 1 & 1, n >> 2};
    bool in = true;
    for (int d = 0; d < 3; d++)
      in = in && (at[d] == 1 || at[d] == 2 * side[d]);
    if (in)
      corners[count++] = node[corner_of[side[0]][side[1]][side[2]]];
  }
  return count;
}

static int64_t pair_key(int32_t a, int32_t b) {
  return a < b ? (int64_t)a << 32 | b : (int64_t)b << 32 | a;
}

/* Of an edge its ends; of a face, or the element, its least corner and the one across, as a
 * negative number. */
static int64_t key_of(int count, const int32_t *corners) {
  if (count == 2)
    return pair_key(corners[0], corners[1]);
  int least = 0;
  for (int i = 1; i < count; i++)
    least = corners[i] < corners[least] ? i : least;
  return -1 - pair_key(corners[least], corners[count - 1 - least]);
}

/* The vertex at a place, which is made where it is new. */
static thrum_status vertex_at(refining *r, const int32_t *node, const int at[3], int32_t *vertex,
                              thrum_error *error) {
  int32_t corners[CORNERS] = {0};
  const int count = around(node, at, corners);
  *vertex = corners[0];
  if (count == 1)
    return THRUM_OK;
  const int64_t key = key_of(count, corners), found = thrum_number_map_find(&r->seen, key);
  if (found >= 0) {
    *vertex = (int32_t)found;
    return THRUM_OK;
  }

  thrum_mesh *finer = r->finer;
  const int64_t made = finer->vertex_count++;
  r->held[made] = 7;
  for (int i = 0; i < count; i++) {
    r->held[made] &= r->fixed[corners[i]];
    for (int d = 0; d < 3; d++)
      finer->vertices[3 * made + d] += r->mesh->vertices[3 * (int64_t)corners[i] + d] / count;
  }
  *vertex = (int32_t)made;
  return thrum_number_map_add(&r->seen, key, made, error);
}

/* The part of element s at one of its corners. */
static thrum_status put_part(refining *r, int64_t s, const int corner[3], thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  thrum_mesh *finer = r->finer;
  const int32_t *node = mesh->solid_nodes + CORNERS * s;
  int32_t *to = finer->solid_nodes + CORNERS * finer->solid_count;
  int64_t numbers[CORNERS];
  int cut[THRUM_SOLID_TETS_MAX][4];
  for (int n = 0; n < CORNERS; n++) {
    const int side[3] = {n & 1, n >> 1 & 1, n >> 2};
    const int at[3] = {corner[0] + side[0], corner[1] + side[1],
                       r->sheet ? 2 * side[2] : corner[2] + side[2]};
    const int place = corner_of[side[0]][side[1]][side[2]];
    THRUM_TRY(vertex_at(r, node, at, &to[place], error));
    numbers[place] = to[place];
  }

  const int tets = thrum_solid_cut(THRUM_SOLID_HEXAHEDRON, numbers, cut);
  for (int t = 0; t < tets; t++, finer->tet_count++) {
    for (int c = 0; c < 4; c++)
      finer->tets[4 * finer->tet_count + c] = to[cut[t][c]];
    finer->tet_region[finer->tet_count] = mesh->tet_region[s > 0 ? mesh->solid_tet_ends[s - 1] : 0];
  }
  finer->solid_form[finer->solid_count] = mesh->solid_form[s];
  finer->solid_tet_ends[finer->solid_count] = (int32_t)finer->tet_count;
  finer->solid_ends[finer->solid_count] = (int32_t)(CORNERS * (finer->solid_count + 1));
  finer->solid_count++;
  return THRUM_OK;
}

static thrum_status reserve_all(refining *r, thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  thrum_mesh *finer = r->finer;
  const int64_t vertices = mesh->vertex_count + NEW_MAX * mesh->solid_count;
  const int64_t parts = (r->sheet ? PARTS_MAX / 2 : PARTS_MAX) * mesh->solid_count;
  const int64_t tets = THRUM_SOLID_TETS_MAX * parts, regions = mesh->region_count;
  THRUM_TRY(thrum_reserve(&r->held, vertices, 1, WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->vertices, vertices, 3 * sizeof(double), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->tets, tets, 4 * sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->tet_region, tets, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_form, parts, 1, WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_ends, parts, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_tet_ends, parts, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_nodes, parts, CORNERS * sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->materials, regions, sizeof *finer->materials, WHAT, error));
  memcpy(finer->materials, mesh->materials, (size_t)regions * sizeof *finer->materials);
  finer->region_count = regions;
  finer->has_material = mesh->has_material;
  if (mesh->springs) {
    THRUM_TRY(thrum_reserve(&finer->springs, vertices, 3 * sizeof(double), WHAT, error));
    memcpy(finer->springs, mesh->springs, 3 * (size_t)mesh->vertex_count * sizeof(double));
  }
  return THRUM_OK;
}

static thrum_status refine(refining *r, thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  THRUM_TRY(reserve_all(r, error));
  r->finer->vertex_count = mesh->vertex_count;
  memcpy(r->finer->vertices, mesh->vertices, 3 * (size_t)mesh->vertex_count * sizeof(double));
  memcpy(r->held, r->fixed, (size_t)mesh->vertex_count);
  for (int64_t s = 0; s < mesh->solid_count; s++)
    for (int n = 0; n < (r->sheet ? PARTS_MAX / 2 : PARTS_MAX); n++)
      THRUM_TRY(put_part(r, s, (const int[3]){n & 1, n >> 1 & 1, n >> 2}, error));
  return THRUM_OK;
}

thrum_status thrum_mesh_refine(const thrum_mesh *mesh, const uint8_t *fixed, thrum_mesh *finer,
                               uint8_t **held, thrum_error *error) {
  thrum_mesh made = {0};
  refining r = {.mesh = mesh, .fixed = fixed, .finer = &made, .sheet = is_sheet(mesh)};
  const thrum_status status = refine(&r, error);
  thrum_number_map_free(&r.seen);
  if (status >= 0) {
    *held = r.held;
    r.held = NULL;
  }
  free(r.held);
  return thrum_mesh_deliver(status, &made, finer);
}
