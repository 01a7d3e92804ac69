/* Finer solids, see refine_solids.h. A vertex is known by the nodes that its place depends on and
 * by how much: their hash is the same from all elements around it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/refine_solids.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/elastic.h"
#include "mesh/mesh_shells.h"
#include "mesh/number_map.h"
#include "mesh/solid_shape.h"
#include "mesh/solids.h"
#include "platform/allocate.h"

#define WHAT "the finer mesh"

enum { PARTS_MAX = 8, NODES_MAX = THRUM_SOLID_NODES_MAX, ONE = 4096 };

typedef struct refining {
  const thrum_mesh *mesh;
  const uint8_t *fixed;
  bool sheet;
  thrum_mesh *finer;
  uint8_t *held;
  thrum_number_map seen; /* vertices by their hash */
} refining;

static bool is_refinable(const thrum_mesh *mesh, int64_t s) {
  const thrum_solid kind = thrum_solid_forms[mesh->solid_form[s]].kind;
  return kind == THRUM_SOLID_HEXAHEDRON || kind == THRUM_SOLID_WEDGE;
}

thrum_status thrum_mesh_refined_size(const thrum_mesh *mesh, thrum_refined_size *size,
                                     thrum_error *error) {
  bool sheet = false;
  *size = (thrum_refined_size){0};
  for (int64_t s = 0; s < mesh->solid_count; s++)
    if (!is_refinable(mesh, s))
      return THRUM_OK;
  THRUM_TRY(thrum_mesh_is_sheet(mesh, &sheet, error));
  const int64_t parts = sheet ? PARTS_MAX / 2 : PARTS_MAX;
  *size = (thrum_refined_size){parts * mesh->solid_count, parts * mesh->vertex_count};
  return THRUM_OK;
}

/* Where a place of a part is in the whole element. */
static void whole_place(thrum_solid kind, bool sheet, int part, const double at[3],
                        double whole[3]) {
  const int across = part >> 2;
  whole[2] = sheet ? at[2] : (at[2] + 2 * across - 1) / 2;
  for (int d = 0; d < 2; d++) {
    if (kind == THRUM_SOLID_HEXAHEDRON)
      whole[d] = (at[d] + 2 * (part >> d & 1) - 1) / 2;
    else if ((part & 3) == 3) // the triangle in the middle, half a turn
      whole[d] = (1 - at[d]) / 2;
    else
      whole[d] = (at[d] + ((part & 3) == d + 1)) / 2;
  }
}

static uint64_t mix(uint64_t x) {
  x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
  x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
  return x ^ x >> 31;
}

/* The vertex at a place of an element, which is made where it is new. Values of shape functions are
 * dyadic at the places of parts, and so the same from everywhere. */
static thrum_status vertex_at(refining *r, thrum_solid_form form, const int32_t *node,
                              const double place[3], int32_t *vertex, thrum_error *error) {
  double shape[NODES_MAX], position[3] = {0};
  uint64_t hash = 0;
  uint8_t held = 7;
  thrum_solid_shape_at(form, place, shape, NULL);
  for (int n = 0; n < thrum_solid_forms[form].nodes; n++) {
    const int64_t weight = llround(shape[n] * ONE);
    if (weight == 0)
      continue;
    if (weight == ONE) {
      *vertex = node[n];
      return THRUM_OK;
    }
    hash += mix((uint64_t)node[n] << 20 ^ (uint64_t)(weight + 8 * ONE));
    held &= r->fixed[node[n]];
    for (int d = 0; d < 3; d++)
      position[d] += shape[n] * r->mesh->vertices[3 * (int64_t)node[n] + d];
  }

  const int64_t key = (int64_t)(hash >> 1), found = thrum_number_map_find(&r->seen, key);
  *vertex = (int32_t)(found >= 0 ? found : r->finer->vertex_count);
  if (found >= 0)
    return THRUM_OK;
  const int64_t made = r->finer->vertex_count++;
  r->held[made] = held;
  memcpy(r->finer->vertices + 3 * made, position, sizeof position);
  return thrum_number_map_add(&r->seen, key, made, error);
}

/* The tetrahedra that are the shape of a part. */
static void put_tets(thrum_mesh *finer, thrum_solid kind, int nodes, const int32_t *node,
                     int32_t region) {
  int64_t numbers[NODES_MAX];
  int cut[THRUM_SOLID_MIDDLE_TETS_MAX][4];
  for (int n = 0; n < nodes; n++)
    numbers[n] = node[n];
  const int tets = nodes > thrum_solid_shapes[kind].corners
                       ? thrum_solid_cut_middles(kind, numbers, cut)
                       : thrum_solid_cut(kind, numbers, cut);
  for (int t = 0; t < tets; t++, finer->tet_count++) {
    for (int c = 0; c < 4; c++)
      finer->tets[4 * finer->tet_count + c] = node[cut[t][c]];
    finer->tet_region[finer->tet_count] = region;
  }
}

static thrum_status put_part(refining *r, int64_t s, int part, thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  thrum_mesh *finer = r->finer;
  const thrum_solid_form form = (thrum_solid_form)mesh->solid_form[s];
  const thrum_solid kind = thrum_solid_forms[form].kind;
  const int nodes = thrum_solid_forms[form].nodes;
  const int64_t begin = thrum_mesh_solid_nodes(finer);
  const int32_t *node = thrum_mesh_solid_at(mesh, s);
  for (int n = 0; n < nodes; n++) {
    double at[3], whole[3];
    thrum_solid_node_place(kind, n, at);
    whole_place(kind, r->sheet, part, at, whole);
    THRUM_TRY(vertex_at(r, form, node, whole, &finer->solid_nodes[begin + n], error));
  }
  put_tets(finer, kind, nodes, finer->solid_nodes + begin,
           mesh->tet_region[thrum_mesh_solid_tet(mesh, s)]);
  finer->solid_form[finer->solid_count] = mesh->solid_form[s];
  finer->solid_tet_ends[finer->solid_count] = (int32_t)finer->tet_count;
  finer->solid_ends[finer->solid_count++] = (int32_t)(begin + nodes);
  return THRUM_OK;
}

static thrum_status reserve_all(refining *r, thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  thrum_mesh *finer = r->finer;
  const int64_t parts = (r->sheet ? PARTS_MAX / 2 : PARTS_MAX) * mesh->solid_count;
  const int64_t regions = mesh->region_count;
  const int64_t nodes = parts / mesh->solid_count * thrum_mesh_solid_nodes(mesh);
  const int64_t vertices = mesh->vertex_count + nodes, tets = THRUM_SOLID_MIDDLE_TETS_MAX * parts;
  THRUM_TRY(thrum_reserve(&r->held, vertices, 1, WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->vertices, vertices, 3 * sizeof(double), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->tets, tets, 4 * sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->tet_region, tets, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_form, parts, 1, WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_ends, parts, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_tet_ends, parts, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->solid_nodes, nodes, sizeof(int32_t), WHAT, error));
  THRUM_TRY(thrum_reserve(&finer->materials, regions, sizeof *finer->materials, WHAT, error));
  memcpy(finer->materials, mesh->materials, (size_t)regions * sizeof *finer->materials);
  THRUM_TRY(thrum_reserve(&finer->elastic, mesh->elastic_count * THRUM_ELASTIC_NUMBERS,
                          sizeof *finer->elastic, WHAT, error));
  if (mesh->elastic_count > 0)
    memcpy(finer->elastic, mesh->elastic,
           (size_t)mesh->elastic_count * THRUM_ELASTIC_NUMBERS * sizeof *finer->elastic);
  finer->elastic_count = mesh->elastic_count;
  finer->region_count = regions;
  finer->has_material = mesh->has_material;
  return THRUM_OK;
}

static thrum_status refine(refining *r, thrum_error *error) {
  const thrum_mesh *mesh = r->mesh;
  THRUM_TRY(reserve_all(r, error));
  r->finer->vertex_count = mesh->vertex_count;
  memcpy(r->finer->vertices, mesh->vertices, 3 * (size_t)mesh->vertex_count * sizeof(double));
  memcpy(r->held, r->fixed, (size_t)mesh->vertex_count);
  for (int64_t s = 0; s < mesh->solid_count; s++)
    for (int part = 0; part < (r->sheet ? PARTS_MAX / 2 : PARTS_MAX); part++)
      THRUM_TRY(put_part(r, s, part, error));
  return THRUM_OK;
}

thrum_status thrum_mesh_refine(const thrum_mesh *mesh, const uint8_t *fixed, thrum_mesh *finer,
                               uint8_t **held, thrum_error *error) {
  thrum_mesh made = {0};
  refining r = {.mesh = mesh, .fixed = fixed, .finer = &made};
  thrum_status status = thrum_mesh_is_sheet(mesh, &r.sheet, error);
  THRUM_THEN(status, refine(&r, error));
  thrum_number_map_free(&r.seen);
  if (status >= 0) {
    *held = r.held;
    r.held = NULL;
  }
  free(r.held);
  return thrum_mesh_deliver(status, &made, finer);
}
