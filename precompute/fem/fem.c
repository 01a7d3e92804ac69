/* Tetrahedra of Saint Venant-Kirchhoff material, design 1: at a point of weight w of a tet, which
 * is its volume in a linear one, where F = 1 + G is constant,
 *   E = (F^T F - 1)/2,  S = lambda tr(E) 1 + 2 mu E,  V = w (lambda/2 tr(E)^2 + mu E:E),
 *   force on node a: w F S g_a, g_a the gradient of its shape function.
 * Energy and force cost O(tets).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/lame.h"
#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "precompute/fem/quadrature.h"

/* Far outside, products of numbers leave the range of doubles, where LAPACK prints its complaints.
 */
static bool is_moderate(double value) {
  return value >= 1e-30 && value <= 1e30;
}

static thrum_status check_materials(const thrum_mesh *mesh, thrum_error *error) {
  if (mesh->region_count < 1 || !mesh->materials)
    return thrum_error_set(error, THRUM_MISSING,
                           "no material: give --young, --poisson and --density");

  for (int64_t i = 0; i < mesh->region_count; i++) {
    const thrum_material *material = &mesh->materials[i];
    const long long region = i + 1;
    if (!is_moderate(material->young))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "Young's modulus of region %lld is %g Pa; it must be positive, and "
                             "between 1e-30 and 1e30",
                             region, material->young);

    // the bounds within which the energy is positive
    if (!(material->poisson > -1 && material->poisson < 0.5))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "Poisson's ratio of region %lld is %g; it must lie between -1 and 1/2",
                             region, material->poisson);

    if (!is_moderate(material->density))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "density of region %lld is %g kg/m^3; it must be positive, and "
                             "between 1e-30 and 1e30",
                             region, material->density);
  }

  return THRUM_OK;
}

static thrum_status allocate(const thrum_mesh *mesh, thrum_fem *fem, thrum_error *error) {
  const int64_t vertices = mesh->vertex_count, tets = fem->tet_count;
  // a component must fit an int32, as it does in the model file
  if (vertices < 4 || mesh->tet_count < 1 || vertices > INT32_MAX / 3 ||
      tets > INT32_MAX / fem->node_count)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a mesh of %lld vertices and %lld tets is out of range",
                           (long long)vertices, (long long)mesh->tet_count);

  thrum_scope *memory = &fem->memory;
  fem->dof = thrum_scope_allocate(memory, 3 * vertices, sizeof *fem->dof);
  fem->component = thrum_scope_allocate(memory, 3 * vertices, sizeof *fem->component);
  fem->gradient = thrum_scope_allocate(memory, 9 * tets * fem->point_count, sizeof(double));
  fem->weight = thrum_scope_allocate(memory, tets * fem->point_count, sizeof(double));
  fem->volume = thrum_scope_allocate(memory, tets, sizeof(double));
  fem->lambda = thrum_scope_allocate(memory, mesh->region_count, sizeof(double));
  fem->mu = thrum_scope_allocate(memory, mesh->region_count, sizeof(double));
  fem->density = thrum_scope_allocate(memory, mesh->region_count, sizeof(double));
  fem->incident_begin = thrum_scope_allocate(memory, vertices + 2, sizeof(int64_t));
  fem->incident = thrum_scope_allocate(
      memory, tets > 0 ? fem->node_count * tets : thrum_mesh_solid_nodes(mesh), sizeof(int64_t));
  return memory->status;
}

// the solids of a mesh, which one made by hand may have of any nodes
static thrum_status make_solids(const thrum_mesh *mesh, thrum_fem *fem, thrum_error *error) {
  for (int64_t i = 0; i < thrum_mesh_solid_nodes(mesh); i++)
    if (mesh->solid_nodes[i] < 0 || mesh->solid_nodes[i] >= mesh->vertex_count)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the elements refer to vertex %lld, which does not exist",
                             (long long)mesh->solid_nodes[i] + 1);
  return thrum_solid_elements_make(mesh, fem->lambda, fem->mu, &fem->memory, &fem->solids, error);
}

// a mesh made by hand may hold any index
static thrum_status check_indices(const thrum_fem *fem, int64_t t, thrum_error *error) {
  const int32_t *node = fem->nodes + fem->node_count * t;
  const int32_t region = fem->tet_region[t];
  bool inside = region >= 0 && region < fem->region_count;
  for (int a = 0; a < fem->node_count; a++)
    inside = inside && node[a] >= 0 && node[a] < fem->vertex_count;
  if (inside)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "tet %lld refers to a vertex or region that does not exist",
                         (long long)t + 1);
}

// the places of the nodes of a ten-node tet
static void node_places(const thrum_fem *fem, int64_t t, double places[THRUM_FEM_NODES_MAX][3]) {
  for (int a = 0; a < fem->node_count; a++)
    memcpy(places[a], fem->vertices + 3 * (int64_t)fem->nodes[fem->node_count * t + a],
           sizeof places[a]);
}

// gradients and weights at the points of a ten-node tet
static thrum_status measure_quadratic(thrum_fem *fem, int64_t t, thrum_error *error) {
  double places[THRUM_FEM_NODES_MAX][3];
  node_places(fem, t, places);
  fem->volume[t] = 0;

  // the determinant must be positive at each point, and is its weight too
  for (int p = 0; p < fem->point_count; p++) {
    const int64_t point = t * fem->point_count + p;
    const double det = thrum_quadratic_map(places, fem->slopes[p], fem->gradient + 9 * point);
    if (!(det > 0) || !isfinite(1 / det))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "tet %lld is turned inside out at a point: the map of its ten nodes "
                             "has determinant %g m^3 there, which must be positive",
                             (long long)t + 1, det);
    fem->weight[point] = fem->rule[p].weight * det / 6;
    fem->volume[t] += fem->weight[point];
  }
  return THRUM_OK;
}

// shape gradients of corners 1..3 are the rows of the inverse of the matrix of edge columns
static thrum_status measure_linear(thrum_fem *fem, int64_t t, thrum_error *error) {
  const int32_t *corner = fem->nodes + 4 * t;

  // edges from corner 0, and their cross products: the cofactors of the inverse
  double edge[3][3], *gradient = fem->gradient + 9 * t;
  thrum_tet_edges(fem->vertices, corner, edge);
  for (int a = 0; a < 3; a++)
    thrum_cross3(edge[(a + 1) % 3], edge[(a + 2) % 3], gradient + 3 * a);

  // six times the volume
  const double det = thrum_dot3(edge[0], gradient);
  if (!(det > 0) || !isfinite(1 / det))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "tet %lld has volume %g m^3; it must be positive", (long long)t + 1,
                           det / 6);

  for (int c = 0; c < 9; c++)
    gradient[c] /= det;
  fem->volume[t] = fem->weight[t] = det / 6;
  return THRUM_OK;
}

static void number_components(const uint8_t *fixed, thrum_fem *fem) {
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++) {
    const bool held = fixed && (fixed[c / 3] >> (c % 3) & 1);
    fem->dof[c] = held ? -1 : (int32_t)fem->free_count;
    if (!held)
      fem->component[fem->free_count++] = (int32_t)c;
  }
}

// the tets around each vertex, by counting sort, so in ascending order
static void list_incident(thrum_fem *fem) {
  int64_t *begin = fem->incident_begin;
  memset(begin, 0, sizeof *begin * ((size_t)fem->vertex_count + 2));
  const thrum_solid_elements *solids = &fem->solids;
  const int64_t entries =
      solids->count > 0 ? solids->ends[solids->count - 1] : fem->node_count * fem->tet_count;
  const int32_t *nodes = solids->count > 0 ? solids->nodes : fem->nodes;
  for (int64_t e = 0; e < entries; e++)
    begin[nodes[e] + 2]++;
  for (int64_t v = 0; v < fem->vertex_count; v++)
    begin[v + 2] += begin[v + 1];
  for (int64_t e = 0, s = 0; e < entries; e++) {
    while (solids->count > 0 && e >= solids->ends[s])
      s++;
    fem->incident[begin[nodes[e] + 1]++] = solids->count > 0 ? s : e;
  }
}

// corners and middle nodes of ten-node tets in one array
static thrum_status join_nodes(const thrum_mesh *mesh, thrum_fem *fem) {
  int32_t *joined = thrum_scope_allocate(&fem->memory, 10 * mesh->tet_count, sizeof *joined);
  fem->nodes = joined;
  THRUM_TRY(fem->memory.status);
  for (int64_t t = 0; t < mesh->tet_count; t++)
    thrum_mesh_nodes(mesh, t, joined + 10 * t);
  return THRUM_OK;
}

// the points of ten-node tets, and the slopes of the shape functions there
static thrum_status choose_rule(thrum_fem *fem, int order, thrum_error *error) {
  // one curved tetrahedron is enough for the finer rule
  bool curved = false;
  for (int64_t t = 0; t < fem->tet_count && !curved; t++) {
    double places[THRUM_FEM_NODES_MAX][3];
    THRUM_TRY(check_indices(fem, t, error));
    node_places(fem, t, places);
    curved = thrum_quadratic_is_curved(places);
  }

  // the slopes at the points are the same for all
  fem->usual_order = curved ? 5 : 4;
  THRUM_TRY(thrum_quadrature(order, curved, &fem->rule, &fem->point_count, error));
  fem->slopes = thrum_scope_allocate(&fem->memory, fem->point_count, sizeof *fem->slopes);
  THRUM_TRY(fem->memory.status);
  for (int p = 0; p < fem->point_count; p++)
    thrum_quadratic_slopes(fem->rule[p].place, fem->slopes[p]);
  return THRUM_OK;
}

static thrum_status fill(const thrum_mesh *mesh, const uint8_t *fixed, int order, thrum_fem *fem,
                         thrum_error *error) {
  thrum_status status = THRUM_OK;
  if (mesh->midsides && mesh->solid_count == 0) {
    THRUM_TRY(join_nodes(mesh, fem));
    THRUM_TRY(choose_rule(fem, order, error));
  }
  status = allocate(mesh, fem, error);

  // Lame's constants from Young's modulus and Poisson's ratio
  for (int64_t i = 0; i < mesh->region_count && status >= 0; i++) {
    const thrum_material *material = &mesh->materials[i];
    const thrum_lame lame = thrum_lame_of(material->young, material->poisson);
    fem->lambda[i] = lame.lambda;
    fem->mu[i] = lame.mu;
    fem->density[i] = material->density;
  }

  if (mesh->solid_count > 0)
    THRUM_THEN(status, make_solids(mesh, fem, error));
  for (int64_t t = 0; t < fem->tet_count && status >= 0; t++) {
    status = check_indices(fem, t, error);
    THRUM_THEN(status,
               fem->rule ? measure_quadratic(fem, t, error) : measure_linear(fem, t, error));
  }
  if (status < 0)
    return status;

  number_components(fixed, fem);
  list_incident(fem);
  if (fem->free_count == 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "every vertex is fixed: leave something free to move");
  return THRUM_OK;
}

double thrum_fem_yield(const thrum_fem *fem, int64_t region, double yield) {
  if (fem->law != THRUM_LAW_BY_REGION)
    return yield;
  const thrum_region_law *own = &fem->laws[region];
  return own->law == THRUM_LAW_STVK ? INFINITY : own->yield > 0 ? own->yield : yield;
}

bool thrum_fem_has_yield(const thrum_fem *fem) {
  for (int64_t i = 0; fem->law == THRUM_LAW_BY_REGION && i < fem->region_count; i++)
    if (fem->laws[i].yield > 0)
      return true;
  return false;
}

thrum_status thrum_fem_create_of_order(const thrum_mesh *mesh, const uint8_t *fixed, int order,
                                       thrum_fem *fem, thrum_error *error) {
  THRUM_TRY(check_materials(mesh, error));

  // the mesh's arrays are borrowed
  thrum_fem made = {.memory = thrum_scope_begin("the finite elements", error),
                    .vertex_count = mesh->vertex_count,
                    .tet_count = mesh->solid_count > 0 ? 0 : mesh->tet_count,
                    .region_count = mesh->region_count,
                    .vertices = mesh->vertices,
                    .node_count = mesh->midsides && mesh->solid_count == 0 ? 10 : 4,
                    .point_count = 1,
                    .nodes = mesh->tets,
                    .tet_region = mesh->tet_region,
                    .laws = mesh->laws,
                    .springs = mesh->springs};

  // a body that failed half way leaves nothing
  thrum_status status = fill(mesh, fixed, order, &made, error);
  if (status < 0)
    thrum_fem_free(&made);
  else
    *fem = made;
  return status;
}

thrum_status thrum_fem_create(const thrum_mesh *mesh, const uint8_t *fixed, thrum_fem *fem,
                              thrum_error *error) {
  return thrum_fem_create_of_order(mesh, fixed, 0, fem, error);
}

void thrum_fem_free(thrum_fem *fem) {
  free(fem->rule);
  thrum_scope_free(&fem->memory);
  *fem = (thrum_fem){0};
}

// by the chain rule: the gradients of the barycentric coordinates times the slopes by them
static void chain(const double *stored, double slopes[THRUM_FEM_NODES_MAX][3],
                  double gradients[THRUM_FEM_NODES_MAX][3]) {
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
    for (int c = 0; c < 3; c++)
      gradients[a][c] =
          slopes[a][0] * stored[c] + slopes[a][1] * stored[3 + c] + slopes[a][2] * stored[6 + c];
}

void thrum_fem_shape_gradients(const thrum_fem *fem, int64_t t, int p,
                               double gradients[THRUM_FEM_NODES_MAX][3]) {
  const double *stored = fem->gradient + 9 * (t * fem->point_count + p);
  if (fem->rule) {
    chain(stored, fem->slopes[p], gradients);
    return;
  }
  for (int c = 0; c < 3; c++) {
    gradients[1][c] = stored[c];
    gradients[2][c] = stored[3 + c];
    gradients[3][c] = stored[6 + c];
    gradients[0][c] = -(stored[c] + stored[3 + c] + stored[6 + c]);
  }
}

void thrum_fem_weigh(const thrum_fem *fem, double *volume, double *mass) {
  const thrum_solid_elements *solids = &fem->solids;
  *volume = *mass = 0;
  for (int64_t t = 0; t < fem->tet_count; t++) {
    *volume += fem->volume[t];
    *mass += fem->volume[t] * fem->density[fem->tet_region[t]];
  }
  for (int64_t s = 0; s < solids->count; s++) {
    *volume += solids->volume[s];
    *mass += solids->volume[s] * fem->density[solids->region[s]];
  }
}

void thrum_fem_gather(const thrum_fem *fem, const double *all, double *free_ones) {
  for (int64_t i = 0; i < fem->free_count; i++)
    free_ones[i] = all[fem->component[i]];
}

void thrum_fem_scatter(const thrum_fem *fem, const double *free_ones, double *all) {
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    all[c] = fem->dof[c] < 0 ? 0 : free_ones[fem->dof[c]];
}

double thrum_fem_add_springs(const thrum_fem *fem, int lanes, const double *u, double *image) {
  double energy = 0;
  for (int64_t c = 0; fem->springs && c < 3 * fem->vertex_count; c++)
    for (int64_t i = lanes * c; fem->springs[c] > 0 && i < lanes * (c + 1); i++) {
      const double force = fem->springs[c] * u[i];
      energy += 0.5 * force * u[i];
      if (image)
        image[i] += force;
    }
  return energy;
}

void thrum_fem_add_free_springs(const thrum_fem *fem, const double *u, double *image) {
  for (int64_t i = 0; fem->springs && i < fem->free_count; i++)
    image[i] += fem->springs[fem->component[i]] * u[i];
}
