/* Measures what a mesh is like. Pieces come from a union-find over vertices; the surface from the
 * faces of one tet; its parts from a union-find over its triangles along shared edges; its genus
 * from the Euler characteristic V - E + F = 2 (surfaces - genus). Cost: see the header.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_examine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/mesh_elements.h"
#include "mesh/mesh_faces.h"
#include "mesh/mesh_thickness.h"
#include "mesh/model_quality.h"
#include "mesh/point_hash.h"
#include "mesh/solid_shape.h"
#include "mesh/surface_sides.h"
#include "platform/allocate.h"

static void join(int32_t *parent, int32_t a, int32_t b) {
  const int32_t x = thrum_surface_root(parent, a), y = thrum_surface_root(parent, b);
  if (x < y)
    parent[y] = x;
  else
    parent[x] = y;
}

static int32_t *make_forest(thrum_scope *scope, int64_t count) {
  int32_t *parent = thrum_scope_allocate(scope, count, sizeof *parent);
  for (int64_t i = 0; parent && i < count; i++)
    parent[i] = (int32_t)i;
  return parent;
}

static thrum_status count_pieces(const thrum_mesh *mesh, thrum_mesh_examined *e,
                                 thrum_error *error) {
  // one tree for each piece, over the vertices
  thrum_scope scope = thrum_scope_begin("the pieces of the mesh", error);
  int32_t *parent = make_forest(&scope, mesh->vertex_count);
  int64_t *size = thrum_scope_allocate(&scope, mesh->vertex_count, sizeof *size);

  // a tetrahedron joins its corners
  const bool room = scope.status >= 0;
  for (int64_t i = 0; i < 4 * mesh->tet_count && room; i++)
    join(parent, mesh->tets[i], mesh->tets[i / 4 * 4]);
  for (int64_t t = 0; t < mesh->tet_count && room; t++)
    size[thrum_surface_root(parent, mesh->tets[4 * t])]++;

  // only a root counts tetrahedra
  for (int64_t v = 0; v < mesh->vertex_count && room; v++) {
    e->pieces += size[v] > 0;
    e->largest_piece = size[v] > e->largest_piece ? size[v] : e->largest_piece;
  }

  thrum_scope_free(&scope);
  return scope.status;
}

static thrum_status count_coincident(const thrum_mesh *mesh, thrum_mesh_examined *e,
                                     thrum_error *error) {
  thrum_point_hash places = {0};
  thrum_status status = THRUM_OK;
  for (int64_t v = 0; v < mesh->vertex_count && status >= 0; v++) {
    int32_t first = 0;
    status =
        thrum_point_hash_find(&places, mesh->vertices, v, mesh->vertices + 3 * v, &first, error);
    e->coincident_vertices += first != v;
  }
  thrum_point_hash_free(&places);
  return status;
}

/* Sorted edges: how many there are, which join triangles, and which are hinges. */
static void walk_edges(const thrum_surface_side *edges, int64_t count, int32_t *parent,
                       thrum_mesh_examined *e) {
  for (int64_t i = 0, next; i < count; i = next) {
    for (next = i + 1;
         next < count && edges[next].low == edges[i].low && edges[next].high == edges[i].high;
         next++)
      join(parent, edges[next].triangle, edges[i].triangle);
    e->surface_edges++;
    e->hinges += next - i > 2;
  }
}

static thrum_status measure_surface(const thrum_mesh *mesh, const thrum_mesh_faces *faces,
                                    uint8_t *on_surface, thrum_mesh_examined *e,
                                    thrum_error *error) {
  // edges of the triangles that bound one tetrahedron alone
  int64_t triangles = 0;
  for (int64_t i = 0; i < faces->count; i++)
    triangles += faces->faces[i].other < 0;
  thrum_scope scope = thrum_scope_begin("the surface of the mesh", error);
  thrum_surface_side *edges = thrum_scope_allocate(&scope, triangles, 3 * sizeof *edges);
  int32_t *parent = make_forest(&scope, triangles);
  if (scope.status < 0)
    goto cleanup;

  for (int64_t i = 0, n = 0; i < faces->count; i++) {
    const int32_t *v = faces->faces[i].vertices;
    if (faces->faces[i].other >= 0)
      continue;
    // the vertices ascend, so the lower end of an edge comes first
    edges[3 * n] = (thrum_surface_side){v[0], v[1], -1, (int32_t)n, true};
    edges[3 * n + 1] = (thrum_surface_side){v[0], v[2], -1, (int32_t)n, true};
    edges[3 * n + 2] = (thrum_surface_side){v[1], v[2], -1, (int32_t)n, true};
    n++;
    for (int a = 0; a < 3; a++)
      on_surface[v[a]] = 1;
  }

  // equal edges stand together, and join their triangles
  thrum_surface_sides_sort(edges, 3 * triangles);
  walk_edges(edges, 3 * triangles, parent, e);
  e->surface_triangles = triangles;
  for (int64_t i = 0; i < triangles; i++)
    e->surfaces += thrum_surface_root(parent, (int32_t)i) == i;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    e->surface_vertices += on_surface[v];

  // V - E + F of closed surfaces is 2 for each, less 2 for every hole through the body
  const int64_t euler = e->surface_vertices - e->surface_edges + triangles;
  const bool closed = e->hinges == 0 && euler % 2 == 0 && euler <= 2 * e->surfaces;
  e->genus = closed ? e->surfaces - euler / 2 : -1;

  // every edge of the surface has its middle node there
  e->surface_vertices += mesh->midsides ? e->surface_edges : 0;
  e->interior_vertices = mesh->vertex_count - e->surface_vertices;

cleanup:
  thrum_scope_free(&scope);
  return scope.status;
}

static thrum_status examine_surface(const thrum_mesh *mesh, thrum_mesh_examined *e,
                                    thrum_error *error) {
  // the faces, and which vertices lie on the surface
  thrum_mesh_faces faces = {0};
  int64_t tets[3];
  uint8_t *on_surface = NULL;
  THRUM_TRY(thrum_reserve(&on_surface, mesh->vertex_count, 1, "the mesh", error));
  thrum_status status = thrum_mesh_find_faces(mesh, &faces, tets, error);
  THRUM_THEN(status, measure_surface(mesh, &faces, on_surface, e, error));
  THRUM_THEN(status, thrum_mesh_cells_across(mesh, &faces, &e->cells_across, error));

  // a tetrahedron with all corners on the surface has no interior
  for (int64_t t = 0; t < mesh->tet_count && status >= 0; t++) {
    const int32_t *v = mesh->tets + 4 * t;
    e->shallow_tets += on_surface[v[0]] && on_surface[v[1]] && on_surface[v[2]] && on_surface[v[3]];
  }

  free(faces.faces);
  free(on_surface);
  return status;
}

/* Keeps the worst few in order. */
static void note_worst(thrum_mesh_examined *e, int64_t tet, double ratio) {
  int place = THRUM_EXAMINE_WORST;
  while (place > 0 && (e->worst[place - 1] < 0 || ratio < e->worst_ratio[place - 1]))
    place--;
  if (place == THRUM_EXAMINE_WORST)
    return;
  for (int i = THRUM_EXAMINE_WORST - 1; i > place; i--) {
    e->worst[i] = e->worst[i - 1];
    e->worst_ratio[i] = e->worst_ratio[i - 1];
  }
  e->worst[place] = tet;
  e->worst_ratio[place] = ratio;
}

static void measure_edge(const thrum_mesh *mesh, int32_t from, int32_t to, thrum_mesh_examined *e) {
  double way[3];
  thrum_subtract3(mesh->vertices + 3 * (int64_t)to, mesh->vertices + 3 * (int64_t)from, way);
  const double edge = hypot(hypot(way[0], way[1]), way[2]);
  e->edge_min = e->edge_min > 0 && e->edge_min < edge ? e->edge_min : edge;
  e->edge_max = e->edge_max > edge ? e->edge_max : edge;
}

/* Counts the shape of element n of so many. */
static void note_ratio(thrum_mesh_examined *e, int64_t n, int64_t count, double ratio) {
  const int bin = (int)(ratio * THRUM_EXAMINE_BINS);
  e->histogram[bin < 0 ? 0 : bin < THRUM_EXAMINE_BINS ? bin : THRUM_EXAMINE_BINS - 1]++;
  e->ratio_min = n == 0 || ratio < e->ratio_min ? ratio : e->ratio_min;
  e->ratio_mean += ratio / (double)count;
  note_worst(e, n, ratio);
}

static void add_volume(const thrum_mesh *mesh, int32_t region, double volume,
                       thrum_mesh_examined *e) {
  e->volume += volume;
  e->mass += mesh->has_material ? volume * mesh->materials[region].density : 0;
}

static void measure_tet(const thrum_mesh *mesh, int64_t t, thrum_mesh_examined *e) {
  const double *corners[4];
  double volume;
  for (int a = 0; a < 4; a++)
    corners[a] = mesh->vertices + 3 * (int64_t)mesh->tets[4 * t + a];
  const double ratio = thrum_tet_mean_ratio(corners, &volume);
  if (mesh->midsides)
    volume = thrum_mesh_tet_volume(mesh, t);

  // the tets of solids are no elements
  if (mesh->solid_count > 0)
    return;
  add_volume(mesh, mesh->tet_region[t], volume, e);
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4; b++)
      measure_edge(mesh, mesh->tets[4 * t + a], mesh->tets[4 * t + b], e);
  note_ratio(e, t, mesh->tet_count, ratio);
}

/* The volume of a solid, whose faces are those of its shape functions, by its points. */
static double solid_volume(const thrum_mesh *mesh, const thrum_mesh_element *element,
                           thrum_solid_table *table) {
  double places[THRUM_SOLID_NODES_MAX][3], jacobian[3][3], gradients[3][3], volume = 0;
  for (int n = 0; n < element->count; n++)
    memcpy(places[n], mesh->vertices + 3 * (int64_t)element->nodes[n], sizeof places[n]);
  for (int p = 0; p < table->points; p++)
    volume += table->weight[p] *
              thrum_solid_map(table->nodes, places, table->slopes[p], jacobian, gradients);
  return volume;
}

/* `table`: that of the last element's form. */
static void measure_solid(const thrum_mesh *mesh, int64_t s, thrum_solid_table *table,
                          thrum_mesh_examined *e) {
  const thrum_mesh_element element = thrum_mesh_element_at(mesh, s);
  const thrum_solid kind = thrum_solid_forms[element.form].kind;
  if (s == 0 || mesh->solid_form[s] != mesh->solid_form[s - 1])
    thrum_solid_table_make((thrum_solid_form)element.form, table);
  add_volume(mesh, thrum_mesh_element_region(mesh, s), solid_volume(mesh, &element, table), e);
  for (int n = 0; n < thrum_solid_shapes[kind].edges; n++) {
    const int *ends = thrum_solid_shapes[kind].edge[n];
    measure_edge(mesh, element.nodes[ends[0]], element.nodes[ends[1]], e);
  }
  note_ratio(e, s, mesh->solid_count,
             thrum_solid_shape_measure(kind, mesh->vertices, element.nodes));
}

static void measure_body(const thrum_mesh *mesh, thrum_mesh_examined *e) {
  thrum_box3(mesh->vertices, mesh->vertex_count, e->box_min, e->box_max);
  for (int c = 0; c < 3; c++)
    e->extent = fmax(e->extent, e->box_max[c] - e->box_min[c]);
  for (int i = 0; i < THRUM_EXAMINE_WORST; i++)
    e->worst[i] = -1;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    measure_tet(mesh, t, e);
  thrum_solid_table table;
  for (int64_t s = 0; s < mesh->solid_count; s++)
    measure_solid(mesh, s, &table, e);
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++)
    e->poisson_max = fmax(e->poisson_max, mesh->materials[i].poisson);
}

thrum_status thrum_mesh_examine(const thrum_mesh *mesh, thrum_mesh_examined *examined,
                                thrum_error *error) {
  thrum_mesh_examined e = {0};
  THRUM_TRY(count_pieces(mesh, &e, error));
  THRUM_TRY(count_coincident(mesh, &e, error));
  THRUM_TRY(examine_surface(mesh, &e, error));
  measure_body(mesh, &e);
  *examined = e;
  return THRUM_OK;
}
