/* A mesh in arrays, see device_mesh.h. SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/device_mesh.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/lame.h"
#include "core/base/quadratic_tet.h"

#define LINEAR_NODES 4
#define ENTRIES_MOST INT32_MAX /* of the arrays that 32-bit numbers point into */

static thrum_status check(const thrum_model *model, thrum_error *error) {
  if (!model->tets || !model->vertices || !model->material || !model->tet_region)
    return thrum_error_set(error, THRUM_MISSING, "the model has no mesh");
  if (model->solid_form)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a device steps tetrahedra, and this mesh has hexahedra or wedges");
  if (model->springs)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a device has no springs to the ground, and this mesh has some");
  const int64_t nodes = model->midsides ? THRUM_QUADRATIC_NODES : LINEAR_NODES;
  if (model->tet_count > ENTRIES_MOST / (nodes * nodes))
    return thrum_error_set(error, THRUM_UNSUPPORTED, "a device takes up to %lld tetrahedra",
                           (long long)(ENTRIES_MOST / (nodes * nodes)));
  return THRUM_OK;
}

// an array of so many numbers; false where there is no memory
static bool make(void *array, int64_t count, size_t size) {
  void *const made = calloc(count > 0 ? (size_t)count : 1, size);
  memcpy(array, &made, sizeof made);
  return made != NULL;
}

static bool make_all(device_mesh *m) {
  const int64_t all = m->tets * m->nodes;
  return make(&m->node, all, sizeof *m->node) &&
         make(&m->gradients, 9 * m->tets, sizeof *m->gradients) &&
         make(&m->volume, m->tets, sizeof *m->volume) &&
         make(&m->moduli, 2 * m->tets, sizeof *m->moduli) &&
         make(&m->slopes, (int64_t)m->points * m->nodes * 3, sizeof *m->slopes) &&
         make(&m->shares, m->points, sizeof *m->shares) &&
         make(&m->around_ends, m->vertices, sizeof *m->around_ends) &&
         make(&m->around, all, sizeof *m->around) &&
         make(&m->mass_ends, m->vertices, sizeof *m->mass_ends) &&
         make(&m->mass_columns, all * m->nodes, sizeof *m->mass_columns) &&
         make(&m->mass, all * m->nodes, sizeof *m->mass) &&
         make(&m->diagonal_mass, 3 * m->vertices, sizeof *m->diagonal_mass) &&
         make(&m->diagonal_stiffness, 3 * m->vertices, sizeof *m->diagonal_stiffness);
}

void device_mesh_free(device_mesh *m) {
  void *const arrays[] = {m->node,
                          m->gradients,
                          m->volume,
                          m->moduli,
                          m->slopes,
                          m->shares,
                          m->around_ends,
                          m->around,
                          m->mass_ends,
                          m->mass_columns,
                          m->mass,
                          m->diagonal_mass,
                          m->diagonal_stiffness};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
    free(arrays[i]);
  *m = (device_mesh){0};
}

/* Shape functions of a linear tetrahedron by its barycentric coordinates 1, 2, 3. */
static const double linear_slopes[LINEAR_NODES][3] = {
    {-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static void take_rule(device_mesh *m, const thrum_quadratic_point *rule) {
  for (int p = 0; p < m->points; p++) {
    double slopes[THRUM_QUADRATIC_NODES][3];
    if (rule)
      thrum_quadratic_slopes(rule[p].place, slopes);
    else
      memcpy(slopes, linear_slopes, sizeof linear_slopes);
    memcpy(m->slopes + (int64_t)p * m->nodes * 3, slopes, (size_t)m->nodes * 3 * sizeof(double));
    m->shares[p] = rule ? rule[p].weight : 1;
  }
}

// nodes, volume, gradients and moduli of a tetrahedron
static thrum_status take_tet(const thrum_model *model, device_mesh *m, int64_t t,
                             thrum_error *error) {
  double place[THRUM_QUADRATIC_NODES][3], gradients[9];
  for (int a = 0; a < m->nodes; a++) {
    const int32_t v = a < 4 ? model->tets[4 * t + a] : model->midsides[6 * t + a - 4];
    m->node[a * m->tets + t] = v;
    memcpy(place[a], model->vertices + 3 * (int64_t)v, sizeof place[a]);
  }
  if (m->nodes == THRUM_QUADRATIC_NODES && thrum_quadratic_is_curved(place))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "tetrahedron %lld has curved edges, and a device takes straight ones",
                           (long long)t + 1);

  // the middles of the edges give the map of a linear one, too
  for (int a = 4; a < THRUM_QUADRATIC_NODES && m->nodes == LINEAR_NODES; a++)
    for (int c = 0; c < 3; c++)
      place[a][c] = 0.5 * (place[thrum_quadratic_edges[a - 4][0]][c] +
                           place[thrum_quadratic_edges[a - 4][1]][c]);
  double slopes[THRUM_QUADRATIC_NODES][3];
  thrum_quadratic_slopes((const double[4]){0.25, 0.25, 0.25, 0.25}, slopes);
  m->volume[t] = thrum_quadratic_map(place, slopes, gradients) / 6;
  if (!(m->volume[t] > 0))
    return thrum_error_set(error, THRUM_BAD_VALUE, "tetrahedron %lld has no volume",
                           (long long)t + 1);
  for (int k = 0; k < 9; k++)
    m->gradients[k * m->tets + t] = gradients[k];
  const double *material = model->material + 3 * (int64_t)model->tet_region[t];
  const thrum_lame lame = thrum_lame_of(material[0], material[1]);
  m->moduli[t] = lame.lambda;
  m->moduli[m->tets + t] = lame.mu;
  return THRUM_OK;
}

// what is around each vertex
static void take_around(device_mesh *m) {
  const int64_t all = m->tets * m->nodes;
  for (int64_t k = 0; k < all; k++)
    m->around_ends[m->node[k]]++;
  int32_t end = 0;
  for (int64_t v = 0; v < m->vertices; v++) {
    const int32_t count = m->around_ends[v];
    m->around_ends[v] = end; // for now where its run starts
    end += count;
  }
  for (int64_t k = 0; k < all; k++)
    m->around[m->around_ends[m->node[k]]++] = (int32_t)k;
}

/* The integral of N_a N_b over an element of volume 1. */
static void mass_of_one(const device_mesh *m, double mass[THRUM_QUADRATIC_NODES][10]) {
  memset(mass, 0, sizeof(double[THRUM_QUADRATIC_NODES][10]));
  if (m->nodes == LINEAR_NODES) {
    for (int a = 0; a < LINEAR_NODES; a++)
      for (int b = 0; b < LINEAR_NODES; b++)
        mass[a][b] = (a == b ? 2 : 1) / 20.0;
    return;
  }
  int count;
  const thrum_quadratic_point *rule = thrum_quadratic_rule(true, &count);
  for (int p = 0; p < count; p++) {
    double shape[THRUM_QUADRATIC_NODES];
    thrum_quadratic_shape(rule[p].place, shape);
    for (int a = 0; a < m->nodes; a++)
      for (int b = 0; b < m->nodes; b++)
        mass[a][b] += rule[p].weight * shape[a] * shape[b];
  }
}

// rows of the mass matrix, each from the elements around its vertex
static void take_mass(const thrum_model *model, device_mesh *m) {
  double one[THRUM_QUADRATIC_NODES][10];
  mass_of_one(m, one);
  int32_t end = 0;
  for (int64_t v = 0; v < m->vertices; v++) {
    const int32_t start = end;

    // each element around the vertex adds its row
    for (int32_t k = v == 0 ? 0 : m->around_ends[v - 1]; k < m->around_ends[v]; k++) {
      const int64_t a = m->around[k] / m->tets, t = m->around[k] % m->tets;
      const double density = model->material[3 * (int64_t)model->tet_region[t] + 2];
      for (int b = 0; b < m->nodes; b++) {
        const int32_t column = m->node[b * m->tets + t];
        int32_t at = start;

        // the columns of a row are few: they are looked through
        while (at < end && m->mass_columns[at] != column)
          at++;
        if (at == end)
          m->mass_columns[end++] = column;
        m->mass[at] += density * m->volume[t] * one[a][b];
        if (column == v)
          for (int c = 0; c < 3; c++)
            m->diagonal_mass[3 * v + c] += density * m->volume[t] * one[a][b];
      }
    }
    m->mass_ends[v] = end;
  }
}

// the diagonal of K at rest, by which conjugate gradients scale
static void take_diagonal(device_mesh *m) {
  for (int64_t t = 0; t < m->tets; t++)
    for (int p = 0; p < m->points; p++)
      for (int a = 0; a < m->nodes; a++) {
        const double *slope = m->slopes + 3 * ((int64_t)p * m->nodes + a);
        const double weight = m->shares[p] * m->volume[t];
        double g[3], square = 0;

        // the gradient of the node's shape function in space
        for (int c = 0; c < 3; c++) {
          g[c] = 0;
          for (int k = 0; k < 3; k++)
            g[c] += slope[k] * m->gradients[(3 * k + c) * m->tets + t];
          square += g[c] * g[c];
        }
        const double lambda = m->moduli[t], mu = m->moduli[m->tets + t];
        for (int c = 0; c < 3; c++)
          m->diagonal_stiffness[3 * (int64_t)m->node[a * m->tets + t] + c] +=
              weight * ((lambda + mu) * g[c] * g[c] + mu * square);
      }
}

thrum_status device_mesh_make(const thrum_model *model, device_mesh *mesh, thrum_error *error) {
  THRUM_TRY(check(model, error));
  int count = 1;
  const thrum_quadratic_point *rule = model->midsides ? thrum_quadratic_rule(false, &count) : NULL;
  device_mesh m = {.vertices = model->vertex_count,
                   .tets = model->tet_count,
                   .nodes = model->midsides ? THRUM_QUADRATIC_NODES : LINEAR_NODES,
                   .points = count};
  thrum_status status = THRUM_OK;
  if (!make_all(&m))
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a mesh of %lld tetrahedra",
                             (long long)m.tets);
  if (status == THRUM_OK)
    take_rule(&m, rule);
  for (int64_t t = 0; t < m.tets && status == THRUM_OK; t++)
    status = take_tet(model, &m, t, error);
  if (status != THRUM_OK) {
    device_mesh_free(&m);
    return status;
  }
  take_around(&m);
  take_mass(model, &m);
  take_diagonal(&m);
  *mesh = m;
  return THRUM_OK;
}
