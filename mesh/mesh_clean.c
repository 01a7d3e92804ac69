/* Checking and cleaning a mesh that was read: scale, bad tets, winding, unreferenced vertices.
 *
 * A tet counts as flat below 1e-12 of its extent cubed: coordinates that are coplanar on
 * paper miss zero by their rounding alone, about 1e-16 of (distance from the origin)/(extent), so
 * bodies up to 10^3 extents from the origin are caught; slivers as meshers leave them stay far
 * above. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/mesh.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_faces.h"
#include "mesh/midsides.h"
#include "mesh/solids.h"
#include "mesh/tet_repeats.h"
#include "platform/allocate.h"

static const double FLAT = 1e-12;

/* Where a message points: "file:line" of tet t as far as it is known. */
typedef struct place {
  char text[200];
} place;

static place tet_place(const thrum_mesh *mesh, const char *name, int64_t t) {
  place where;
  size_t length = strlen(name);
  const char *shown = length > 150 ? name + length - 150 : name;
  if (mesh->tet_line && mesh->tet_line[t] > 0)
    snprintf(where.text, sizeof where.text, "%s%s:%lld", length > 150 ? "..." : "", shown,
             (long long)mesh->tet_line[t]);
  else
    snprintf(where.text, sizeof where.text, "%s%s", length > 150 ? "..." : "", shown);
  return where;
}

static thrum_status scale_vertices(thrum_mesh *mesh, const char *name, double scale,
                                   thrum_error *error) {
  if (!isfinite(scale) || scale <= 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the scale is %g; it turns lengths into metres and must be above 0",
                           scale);
  for (int64_t i = 0; i < 3 * mesh->vertex_count; i++) {
    if (!isfinite(mesh->vertices[i]) || !isfinite(scale * mesh->vertices[i]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: vertex %lld is not at a finite place (scale %g)", name,
                             (long long)thrum_mesh_number(mesh, (int32_t)(i / 3)), scale);
    // adding 0 takes the sign off -0, so that equal meshes have equal bytes
    mesh->vertices[i] = scale * mesh->vertices[i] + 0.0;
  }
  return THRUM_OK;
}

static thrum_status check_tet_vertices(const thrum_mesh *mesh, const char *name,
                                       thrum_error *error) {
  // nodes that exist
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t v[10];
    const int nodes = thrum_mesh_nodes(mesh, t, v);
    for (int a = 0; a < nodes; a++)
      if (v[a] < 0 || v[a] >= mesh->vertex_count)
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "%s: %s names vertex %lld, but there are %lld vertices",
                               tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text,
                               (long long)v[a] + 1, (long long)mesh->vertex_count);

    // and differ
    for (int a = 0; a < nodes; a++)
      for (int b = a + 1; b < nodes; b++)
        if (v[a] == v[b])
          return thrum_error_set(error, THRUM_BAD_VALUE,
                                 "%s: %s has vertex %lld twice; remove or mend it",
                                 tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text,
                                 (long long)thrum_mesh_number(mesh, v[a]));

    if (mesh->tet_region[t] < 0 || mesh->tet_region[t] >= mesh->region_count)
      return thrum_error_set(error, THRUM_BAD_VALUE, "%s: %s is in no region",
                             tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text);
  }
  return THRUM_OK;
}

/* Volume of tet t in units of its extent cubed, so that no length is too small or too large; the
 * extent is the largest difference in a coordinate between two of its vertices. */
static double tet_shape(const thrum_mesh *mesh, int64_t t, double *extent) {
  const int32_t *v = mesh->tets + 4 * t;
  double edges[3][3];
  *extent = 0;

  for (int c = 0; c < 3; c++) {
    double first = mesh->vertices[3 * (int64_t)v[0] + c], low = 0, high = 0;
    for (int b = 1; b < 4; b++) {
      double d = mesh->vertices[3 * (int64_t)v[b] + c] - first;
      edges[b - 1][c] = d;
      low = d < low ? d : low;
      high = d > high ? d : high;
    }
    *extent = high - low > *extent ? high - low : *extent;
  }

  // lengths relative to the extent, so that the result does not depend on the unit
  for (int i = 0; i < 9; i++)
    edges[i / 3][i % 3] /= *extent > 0 ? *extent : 1;
  return thrum_triple3(edges[0], edges[1], edges[2]) / 6;
}

static thrum_status check_repeats(const thrum_mesh *mesh, const char *name, thrum_error *error) {
  int64_t *earlier = NULL, t = 0;
  thrum_status status = thrum_mesh_tet_repeats(mesh, &earlier, error);
  while (status >= 0 && t < mesh->tet_count && earlier[t] < 0)
    t++;
  if (status >= 0 && t < mesh->tet_count)
    status =
        thrum_error_set(error, THRUM_BAD_VALUE, "%s: %s has the same vertices as %s; remove one",
                        tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text,
                        thrum_mesh_tet_text(mesh, earlier[t]).text);
  free(earlier);
  return status;
}

/* Turns inverted tets round: of four points only one winding is right. */
static thrum_status fix_winding(thrum_mesh *mesh, const char *name, thrum_error *error) {
  int64_t inverted = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    double extent, shape = tet_shape(mesh, t, &extent);

    const int32_t *v = mesh->tets + 4 * t;
    if (!(fabs(shape) > FLAT))
      return thrum_error_set(
          error, THRUM_BAD_VALUE,
          "%s: %s (vertices %lld %lld %lld %lld) has no volume; remove or mend it",
          tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text,
          (long long)thrum_mesh_number(mesh, v[0]), (long long)thrum_mesh_number(mesh, v[1]),
          (long long)thrum_mesh_number(mesh, v[2]), (long long)thrum_mesh_number(mesh, v[3]));

    // far outside, products of lengths leave the range of doubles
    if (!(extent > 1e-30 && extent < 1e30))
      return thrum_error_set(error, THRUM_BAD_VALUE, "%s: %s is %g m large; check the scale",
                             tet_place(mesh, name, t).text, thrum_mesh_tet_text(mesh, t).text,
                             extent);
    inverted += shape < 0;
  }

  if (inverted == 0)
    return THRUM_OK;

  // two corners change places
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t *v = mesh->tets + 4 * t, swap = v[2];
    double extent;
    if (tet_shape(mesh, t, &extent) > 0)
      continue;
    v[2] = v[3];
    v[3] = swap;

    // and with them the middle nodes of their edges
    if (mesh->midsides)
      thrum_midsides_flip(mesh->midsides + 6 * t);
  }

  mesh->flipped_tets = inverted;
  return THRUM_OK;
}

/* Reflects the solids that are wound the other way, as all of their tets are. One of which some are
 * is too twisted. */
static thrum_status turn_solids(thrum_mesh *mesh, const char *name, thrum_error *error) {
  int64_t t = 0, first = 0;
  for (int64_t s = 0; s < mesh->solid_count; first = mesh->solid_ends[s++]) {
    const int64_t begin = t;
    int64_t inverted = 0;
    for (; t < mesh->solid_tet_ends[s]; t++) {
      double extent;
      inverted += tet_shape(mesh, t, &extent) < 0;
    }
    if (inverted > 0 && inverted < t - begin)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%s: %s is so twisted that parts of it lie inside out; mend it, or "
                             "give --element tet, which cuts it around its centre",
                             tet_place(mesh, name, begin).text,
                             thrum_mesh_tet_text(mesh, begin).text);
    if (inverted == 0)
      continue;

    // the other winding of all nodes
    const thrum_solid_form_shape *form = &thrum_solid_forms[mesh->solid_form[s]];
    int32_t nodes[THRUM_SOLID_NODES_MAX];
    memcpy(nodes, mesh->solid_nodes + first, (size_t)form->nodes * sizeof *nodes);
    for (int n = 0; n < form->nodes; n++)
      mesh->solid_nodes[first + n] = nodes[thrum_solid_mirrored(form->kind, n)];
  }
  return THRUM_OK;
}

/* Refuses faces of three tets, and neighbours on the same side of their face: those are tangled,
 * where inverted tets were only wound the other way. */
static thrum_status check_faces(const thrum_mesh *mesh, const char *name, thrum_error *error) {
  thrum_mesh_faces faces = {0};
  int64_t tets[3] = {-1, -1, -1};
  thrum_status status = thrum_mesh_find_faces(mesh, &faces, tets, error);
  free(faces.faces);
  if (status != THRUM_BAD_VALUE)
    return status;

  // the place that is named is that of the last tet, the later mistake
  const int64_t last = tets[2] >= 0 ? tets[2] : tets[1];
  if (tets[2] >= 0)
    return thrum_error_set(
        error, status,
        "%s: %s, %s and %s share one face, where only two can be; "
        "remove what overlaps",
        tet_place(mesh, name, last).text, thrum_mesh_tet_text(mesh, tets[0]).text,
        thrum_mesh_tet_text(mesh, tets[1]).text, thrum_mesh_tet_text(mesh, tets[2]).text);
  return thrum_error_set(error, status,
                         "%s: %s and %s lie on the same side of the face that they share, "
                         "so they overlap; mesh the body again",
                         tet_place(mesh, name, last).text, thrum_mesh_tet_text(mesh, tets[0]).text,
                         thrum_mesh_tet_text(mesh, tets[1]).text);
}

/* Renumbers a group in place; an emptied one is removed by the caller. */
static void renumber_group(thrum_group *group, const int32_t *map) {
  int64_t kept = 0;
  for (int64_t i = 0; i < group->count; i++)
    if (map[group->vertices[i]] >= 0)
      group->vertices[kept++] = map[group->vertices[i]];
  group->count = kept;
}

static void renumber(thrum_mesh *mesh, const int32_t *map, int32_t kept) {
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    if (map[v] >= 0)
      memmove(mesh->vertices + 3 * (int64_t)map[v], mesh->vertices + 3 * v, 3 * sizeof(double));
  mesh->vertex_count = kept;

  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    mesh->tets[i] = map[mesh->tets[i]];
  for (int64_t i = 0; i < 6 * mesh->tet_count && mesh->midsides; i++)
    mesh->midsides[i] = map[mesh->midsides[i]];
  for (int64_t i = 0; i < thrum_mesh_solid_nodes(mesh); i++)
    mesh->solid_nodes[i] = map[mesh->solid_nodes[i]];

  // a group whose vertices are all dropped goes with them
  int64_t groups = 0;
  for (int64_t g = 0; g < mesh->group_count; g++) {
    thrum_group group = mesh->groups[g];
    renumber_group(&group, map);
    if (group.count > 0) {
      mesh->groups[groups++] = group;
    } else {
      free(group.name);
      free(group.vertices);
    }
  }

  mesh->group_count = groups;
}

static thrum_status drop_vertices(thrum_mesh *mesh, thrum_error *error) {
  int32_t *map = NULL;
  THRUM_TRY(thrum_reserve(&map, mesh->vertex_count, sizeof *map, "the mesh", error));

  // vertices of tets, in their order
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    map[v] = -1;
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    map[mesh->tets[i]] = 0;
  for (int64_t i = 0; i < 6 * mesh->tet_count && mesh->midsides; i++)
    map[mesh->midsides[i]] = 0;
  int32_t kept = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    if (map[v] == 0)
      map[v] = kept++;

  // middle nodes that were made are in no file, and were not dropped from it
  mesh->dropped_vertices = 0;
  for (int64_t v = 0; v < mesh->file_vertex_count; v++)
    mesh->dropped_vertices += map[v] < 0;
  if (kept == mesh->vertex_count) {
    free(map);
    return THRUM_OK;
  }

  // the map stays, for lists of vertices that are numbered as in the file
  renumber(mesh, map, kept);
  mesh->file_vertex = map;
  return THRUM_OK;
}

/* Refuses middle nodes that neighbours do not share, and those that turn an element inside out. */
static thrum_status check_midsides(const thrum_mesh *mesh, const char *name, thrum_error *error) {
  thrum_midside_fault fault;
  const thrum_status status = thrum_midsides_check(mesh, &fault, error);
  if (status != THRUM_BAD_VALUE)
    return status;

  // an element that was cut may be too warped for its own middle nodes alone
  return thrum_error_set(error, status, "%s: %s %s%s", tet_place(mesh, name, fault.tet).text,
                         thrum_mesh_tet_text(mesh, fault.tet).text, fault.text,
                         mesh->cut_elements > 0 ? "; --order 1 cuts it by its corners" : "");
}

thrum_status thrum_mesh_clean(thrum_mesh *mesh, const char *name, double scale,
                              thrum_error *error) {
  if (mesh->tet_count == 0)
    return thrum_error_set(error, THRUM_MISSING, "%.200s: the mesh holds no tetrahedra", name);
  // a mesh that was put together by hand has no other vertices than these
  if (mesh->file_vertex_count == 0)
    mesh->file_vertex_count = mesh->vertex_count;
  if (mesh->vertex_count > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%.200s: more than 2^31 - 1 vertices", name);
  THRUM_TRY(scale_vertices(mesh, name, scale, error));
  THRUM_TRY(check_tet_vertices(mesh, name, error));
  THRUM_TRY(check_repeats(mesh, name, error));
  THRUM_TRY(turn_solids(mesh, name, error));
  THRUM_TRY(fix_winding(mesh, name, error));
  THRUM_TRY(check_faces(mesh, name, error));
  if (mesh->midsides)
    THRUM_TRY(check_midsides(mesh, name, error));
  return drop_vertices(mesh, error);
}
