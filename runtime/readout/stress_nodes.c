/* Stress at nodes: planning, laying out, reading (thrum/stress.h, design 11). With the four points
 * at barycentric a and three times b, a function that is linear in a tetrahedron and has the values
 * f_p there has at corner p
 *   (f_p - b sum f)/(a - b)
 * and half the sum of two corners at the node between them. Of straight edges strains are linear in
 * a ten-node tetrahedron, and small ones are extrapolated exactly.
 * Cost of a reading: four stresses a tetrahedron, about 2,000 operations.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/finite.h"
#include "core/base/lame.h"
#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "runtime/material/material_law.h"
#include "runtime/readout/stress_private.h"
#include "runtime/readout/tet_strain.h"
#include "thrum/stress.h"

#define STRESS_NODES_MAGIC UINT64_C(0x7468726d676e3031)

/* a = (5 + 3 sqrt 5)/20 and b = (5 - sqrt 5)/20 of the four points. */
static const double near_corner = 0.58541019662496845446, away = 0.13819660112501051518;

/* The header; behind it, each at a multiple of 64: weight (room), vertex (room), region (room),
 * slot (node_count a tet), first and seen (vertex_count + 1 each). */
struct thrum_stress_nodes {
  uint64_t magic;
  const thrum_model *model;
  int64_t count; /* pairs of a vertex and a region */
  int64_t room;  /* for them */
  int32_t node_count;
};

typedef struct layout {
  double *weight; /* one over the volume around each pair [1/m^3] */
  int32_t *vertex, *region, *slot, *first, *seen;
} layout;

static size_t place(unsigned char *base, size_t at, size_t size, void **array) {
  if (base)
    *array = base + at;
  return at + thrum_round_up(size);
}

/* Where the arrays lie from `base` on; returns the bytes of all. base NULL: only counts. */
static size_t lay_out(const thrum_model *model, int64_t room, int32_t node_count, void *base,
                      layout *out) {
  void *arrays[6] = {0};
  const size_t pairs = (size_t)room, tets = (size_t)model->tet_count;
  const size_t vertices = (size_t)model->vertex_count + 1;
  size_t at = thrum_round_up(sizeof(thrum_stress_nodes));
  at = place(base, at, pairs * sizeof(double), &arrays[0]);
  at = place(base, at, pairs * sizeof(int32_t), &arrays[1]);
  at = place(base, at, pairs * sizeof(int32_t), &arrays[2]);
  at = place(base, at, (size_t)node_count * tets * sizeof(int32_t), &arrays[3]);
  at = place(base, at, vertices * sizeof(int32_t), &arrays[4]);
  at = place(base, at, vertices * sizeof(int32_t), &arrays[5]);
  *out = (layout){arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5]};
  return at;
}

static layout layout_of(const thrum_stress_nodes *nodes) {
  layout l;
  lay_out(nodes->model, nodes->room, nodes->node_count, (void *)(uintptr_t)nodes, &l);
  return l;
}

static int32_t node_count_of(const thrum_model *model) {
  return model->midsides ? THRUM_QUADRATIC_NODES : 4;
}

static int32_t node_of(const thrum_model *model, int64_t tet, int a) {
  return a < 4 ? model->tets[4 * tet + a] : model->midsides[6 * tet + a - 4];
}

/* No more pairs than nodes of tetrahedra, and than vertices times regions. */
static int64_t room_of(const thrum_model *model) {
  const int64_t nodes = node_count_of(model) * model->tet_count;
  const int64_t all = model->vertex_count * model->region_count;
  return nodes < all ? nodes : all;
}

thrum_status thrum_stress_nodes_size(const thrum_model *model, size_t *size, thrum_error *error) {
  layout none;
  if (!model || !size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or size is NULL");
  if (!model->tets)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh, so it has no stress: precompute it from a mesh");
  if (model->solid_count > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "stress at nodes is that of tetrahedra, and the model has other elements");
  if (room_of(model) > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "the mesh has too many nodes for stresses");
  *size = lay_out(model, room_of(model), node_count_of(model), NULL, &none);
  return THRUM_OK;
}

/* Gradients of the barycentric coordinates 1, 2, 3 at point p of a tet, and of a ten-node one the
 * slopes of its shape functions there; returns six volumes, not above 0 where it folds over. */
static double map_point(const thrum_model *model, int64_t tet, int p, double shape[9],
                        double slopes[THRUM_QUADRATIC_NODES][3]) {
  double nodes[THRUM_QUADRATIC_NODES][3], at[4] = {away, away, away, away}, edges[3][3], cross[3];
  if (!model->midsides) {
    thrum_tet_edges(model->vertices, model->tets + 4 * tet, edges);
    thrum_cross3(edges[1], edges[2], cross);
    return thrum_stress_points_shape(model, tet, shape) ? thrum_dot3(edges[0], cross) : 0;
  }
  at[p] = near_corner;
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
    memcpy(nodes[a], model->vertices + 3 * (int64_t)node_of(model, tet, a), sizeof nodes[a]);
  thrum_quadratic_slopes(at, slopes);
  return thrum_quadratic_map(nodes, slopes, shape);
}

/* Six volumes of a tet; 0 where it has none. */
static double volume_of(const thrum_model *model, int64_t tet) {
  double shape[9], slopes[THRUM_QUADRATIC_NODES][3], sum = 0;
  const int points = model->midsides ? 4 : 1;
  for (int p = 0; p < points; p++) {
    const double six = map_point(model, tet, p, shape, slopes);
    if (!(six > 0) || !isfinite(six))
      return 0;
    sum += six / points;
  }
  return sum;
}

/* Calls each node of each tet of a region once a vertex: counts the pairs of each vertex where l->
 * slot is not to be filled yet, else numbers them. */
static void visit_region(const thrum_stress_nodes *nodes, const layout *l, int32_t region,
                         bool number) {
  const thrum_model *model = nodes->model;
  for (int64_t t = 0; t < model->tet_count; t++) {
    if (model->tet_region[t] != region)
      continue;
    for (int a = 0; a < nodes->node_count; a++) {
      const int32_t v = node_of(model, t, a);
      const bool fresh = l->seen[v] != region + 1;
      l->seen[v] = region + 1;

      // counts stand one place behind, where their sums will be
      if (!number) {
        l->first[v + 1] += fresh;
        continue;
      }
      if (fresh) {
        l->vertex[l->first[v]] = v;
        l->region[l->first[v]] = region;
        l->first[v]++;
      }
      l->slot[nodes->node_count * t + a] = l->first[v] - 1;
    }
  }
}

/* Pairs by vertex and then by region, and their volumes. */
static void number_pairs(thrum_stress_nodes *nodes, const layout *l) {
  const thrum_model *model = nodes->model;
  for (int32_t region = 0; region < model->region_count; region++)
    visit_region(nodes, l, region, false);
  for (int64_t v = 0; v < model->vertex_count; v++)
    l->first[v + 1] += l->first[v];
  nodes->count = l->first[model->vertex_count];
  memset(l->seen, 0, (size_t)(model->vertex_count + 1) * sizeof *l->seen);
  for (int32_t region = 0; region < model->region_count; region++)
    visit_region(nodes, l, region, true);
}

thrum_status thrum_stress_nodes_init(void *memory, size_t memory_size, const thrum_model *model,
                                     const thrum_stress_nodes **nodes, thrum_error *error) {
  size_t size;
  layout l;
  THRUM_TRY(thrum_stress_nodes_size(model, &size, error));
  if (!memory || !nodes)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or nodes is NULL");
  THRUM_TRY(thrum_alignment_check("stress nodes", memory, memory_size, size, error));

  // pairs are numbered in the memory itself
  memset(memory, 0, size);
  thrum_stress_nodes header = {0, model, 0, room_of(model), node_count_of(model)};
  lay_out(model, header.room, header.node_count, memory, &l);
  number_pairs(&header, &l);

  // a node weighs its tetrahedra by their volumes
  for (int64_t t = 0; t < model->tet_count; t++) {
    const double six = volume_of(model, t);
    if (!(six > 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "tetrahedron %lld of the model has no positive volume",
                             (long long)t + 1);
    for (int a = 0; a < header.node_count; a++)
      l.weight[l.slot[header.node_count * t + a]] += six;
  }
  for (int64_t n = 0; n < header.count; n++)
    l.weight[n] = 1 / l.weight[n];

  // the tag comes last, so that a failed call leaves no nodes
  header.magic = STRESS_NODES_MAGIC;
  memcpy(memory, &header, sizeof header);
  *nodes = memory;
  return THRUM_OK;
}

int64_t thrum_stress_nodes_count(const thrum_stress_nodes *nodes) {
  return nodes ? nodes->count : 0;
}

int32_t thrum_stress_nodes_vertex(const thrum_stress_nodes *nodes, int64_t n) {
  return layout_of(nodes).vertex[n];
}

int32_t thrum_stress_nodes_region(const thrum_stress_nodes *nodes, int64_t n) {
  return layout_of(nodes).region[n];
}

int32_t thrum_stress_nodes_extrapolated(const thrum_stress_nodes *nodes) {
  return nodes && nodes->node_count == THRUM_QUADRATIC_NODES;
}

/* G at point p. */
static void gradient_at(const thrum_stress_nodes *nodes, int64_t tet, const double *u,
                        const double shape[9], double slopes[THRUM_QUADRATIC_NODES][3],
                        double g[3][3]) {
  const thrum_model *model = nodes->model;
  double corners[12], by_place[3][3] = {{0}};
  if (nodes->node_count == 4) {
    for (int a = 0; a < 4; a++)
      memcpy(corners + 3 * a, u + 3 * (int64_t)node_of(model, tet, a), 3 * sizeof *u);
    thrum_tet_gradient(corners, shape, g);
    return;
  }

  // by the barycentric coordinates first, and then by the place
  for (int a = 0; a < nodes->node_count; a++)
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++)
        by_place[i][k] += u[3 * (int64_t)node_of(model, tet, a) + i] * slopes[a][k];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      g[i][j] =
          by_place[i][0] * shape[j] + by_place[i][1] * shape[3 + j] + by_place[i][2] * shape[6 + j];
}

/* Cauchy stress at G in a region; NaN where it is inside out. */
static void cauchy_at(const thrum_model *model, int64_t region, thrum_law law, double g[3][3],
                      double cauchy[6]) {
  const double *material = model->material + 3 * region;
  const thrum_lame lame = thrum_lame_of(material[0], material[1]);
  double strain[6], stress[6];
  thrum_tet_green(g, strain);
  const double ratio = thrum_tet_volume_ratio(g);
  thrum_tet_law_second_piola(law, lame.lambda, lame.mu, g, strain, ratio, stress);
  for (int c = 0; c < 6; c++)
    cauchy[c] = NAN;
  if (ratio > 0)
    thrum_tet_cauchy(g, ratio, stress, cauchy);
}

/* Stress at the nodes of a tet; returns six volumes. */
static double read_tet(const thrum_stress_nodes *nodes, int64_t tet, const double *u,
                       double at[THRUM_QUADRATIC_NODES][6]) {
  double shape[9], slopes[THRUM_QUADRATIC_NODES][3], g[3][3], point[4][6], volume = 0;
  const int points = nodes->node_count == 4 ? 1 : 4;
  const int64_t region = nodes->model->tet_region[tet];
  const thrum_law law = thrum_law_of_region(nodes->model, region);
  for (int p = 0; p < points; p++) {
    volume += map_point(nodes->model, tet, p, shape, slopes) / points;
    gradient_at(nodes, tet, u, shape, slopes, g);
    cauchy_at(nodes->model, region, law, g, point[p]);
  }

  // one stress is that of all nodes, and four are extrapolated
  for (int c = 0; c < 6; c++) {
    const double sum = points == 4 ? point[0][c] + point[1][c] + point[2][c] + point[3][c] : 0;
    for (int a = 0; a < 4; a++)
      at[a][c] = points == 4 ? (point[a][c] - away * sum) / (near_corner - away) : point[0][c];
    for (int e = 0; points == 4 && e < THRUM_QUADRATIC_EDGES; e++)
      at[4 + e][c] = (at[thrum_quadratic_edges[e][0]][c] + at[thrum_quadratic_edges[e][1]][c]) / 2;
  }
  return volume;
}

thrum_status thrum_stress_nodes_read(const thrum_stress_nodes *nodes, const double *u,
                                     double *cauchy, double *von_mises, thrum_error *error) {
  if (!nodes || nodes->magic != STRESS_NODES_MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the stress nodes were not made by thrum_stress_nodes_init");
  if (!u || !cauchy)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "u or cauchy is NULL");
  if (!thrum_all_finite(u, 3 * nodes->model->vertex_count))
    return thrum_error_set(error, THRUM_BAD_VALUE, "a displacement is not finite");

  // each tetrahedron adds to its nodes
  const layout l = layout_of(nodes);
  memset(cauchy, 0, (size_t)(6 * nodes->count) * sizeof *cauchy);
  for (int64_t t = 0; t < nodes->model->tet_count; t++) {
    double at[THRUM_QUADRATIC_NODES][6];
    const double volume = read_tet(nodes, t, u, at);
    for (int a = 0; a < nodes->node_count; a++)
      for (int c = 0; c < 6; c++)
        cauchy[6 * (int64_t)l.slot[nodes->node_count * t + a] + c] += volume * at[a][c];
  }

  // the mean, and what von Mises makes of it
  for (int64_t n = 0; n < nodes->count; n++) {
    for (int c = 0; c < 6; c++)
      cauchy[6 * n + c] *= l.weight[n];
    if (von_mises)
      von_mises[n] = thrum_von_mises(cauchy + 6 * n);
  }
  return THRUM_OK;
}
