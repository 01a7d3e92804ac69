/* The polynomials of actuators, exactly as those of the body are, by Gram products.
 *
 * A volume is a sum of -w x_c (a_d b_e - a_e b_d) over points of faces, where the place x and the
 * edges a, b are affine in q. With q_0 = 1 before the others all three are linear, the sum over
 * points is one product of the pairs of (a, b) with x, and the coefficient of q_i q_j q_k is the
 * sum of its entries whose indices are these, of constant, linear and quadratic monomials too. A
 * strain has S0 : (G + 1/2 G^T G), linear and quadratic. Cost: 3 points (r + 1)^3 and 9 points r^2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/actuator_reduce.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_tet.h"

enum { BLOCK = 96 }; /* rows of a product */

static int64_t pairs_of(int64_t count) {
  return count * (count + 1) / 2;
}

/* --- volumes ---------------------------------------------------------------------------------- */

/* What makes the cubic form of one surface. */
typedef struct cubic_form {
  const thrum_fem *fem;
  const thrum_actuator_surface *surface;
  const double *basis;
  int64_t rank, n; /* n = rank + 1 */
  int64_t rows;    /* that wait */
  double *pairs;   /* BLOCK x pairs of n */
  double *places;  /* BLOCK x n */
  double *sums;    /* pairs of n x n */
  double *nodes;   /* 6 x 3 x n */
  double *at;      /* 3 x 3 x n: place and both edges */
} cubic_form;

/* Adds the three rows of a node, 1 first, times `by`. */
static void add_node(const cubic_form *c, int64_t node, double by, double *rows) {
  const int64_t vertices = c->fem->vertex_count;
  if (node < vertices) {
    for (int axis = 0; axis < 3; axis++) {
      rows[axis * c->n] += by * c->fem->vertices[3 * node + axis];
      cblas_daxpy((int)c->rank, by, c->basis + (3 * node + axis) * c->rank, 1,
                  rows + axis * c->n + 1, 1);
    }
    return;
  }
  const thrum_actuator_surface *s = c->surface;
  const int64_t m = node - vertices, first = m > 0 ? s->mean_ends[m - 1] : 0;
  for (int64_t k = first; k < s->mean_ends[m]; k++)
    add_node(c, s->mean_nodes[k], by / (double)(s->mean_ends[m] - first), rows);
}

static void flush(cubic_form *c) {
  if (c->rows > 0)
    cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, (int)pairs_of(c->n), (int)c->n,
                (int)c->rows, 1, c->pairs, (int)pairs_of(c->n), c->places, (int)c->n, 1, c->sums,
                (int)c->n);
  c->rows = 0;
}

/* Adds one axis of one point: `by` x (a_d b_e - a_e b_d). */
static void add_row(cubic_form *c, int axis, double by) {
  const int64_t n = c->n;
  const int d = (axis + 1) % 3, e = (axis + 2) % 3;
  const double *a = c->at + 3 * n, *b = c->at + 6 * n;
  double *pair = c->pairs + c->rows * pairs_of(n), *place = c->places + c->rows * n;
  memcpy(place, c->at + axis * n, (size_t)n * sizeof *place);
  cblas_dscal((int)n, by, place, 1);
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = i; j < n; j++, pair++) {
      *pair = a[d * n + i] * b[e * n + j] - a[e * n + i] * b[d * n + j];
      if (j > i)
        *pair += a[d * n + j] * b[e * n + i] - a[e * n + j] * b[d * n + i];
    }
  if (++c->rows == BLOCK)
    flush(c);
}

static void add_faces(cubic_form *c) {
  const thrum_actuator_surface *s = c->surface;
  const int64_t n = c->n;
  thrum_face_point points[THRUM_FACE_POINTS];
  const int count = thrum_face_points(s->nodes, points);
  for (int64_t f = 0; f < s->face_count; f++) {
    memset(c->nodes, 0, (size_t)(3 * s->nodes * n) * sizeof *c->nodes);
    for (int a = 0; a < s->nodes; a++)
      add_node(c, s->faces[f * s->nodes + a], 1, c->nodes + 3 * a * n);
    for (int p = 0; p < count; p++) {
      memset(c->at, 0, (size_t)(9 * n) * sizeof *c->at);
      for (int a = 0; a < s->nodes; a++) {
        const double by[3] = {points[p].shape[a], points[p].slope[a][0], points[p].slope[a][1]};
        for (int k = 0; k < 3; k++)
          cblas_daxpy((int)(3 * n), by[k], c->nodes + 3 * a * n, 1, c->at + 3 * k * n, 1);
      }
      for (int axis = 0; axis < 3; axis++) {
        c->at[axis * n] -= s->origin[axis];
        if (s->weight[axis] != 0)
          add_row(c, axis, -points[p].weight * s->weight[axis]);
      }
    }
  }
  flush(c);
}

/* The entry of a pair and a coordinate. */
static double sum_at(const cubic_form *c, int64_t i, int64_t j, int64_t k) {
  return c->sums[((pairs_of(c->n) - pairs_of(c->n - i)) + (j - i)) * c->n + k];
}

/* The coefficient of q_i q_j q_k, i <= j <= k. */
static double coefficient(const cubic_form *c, int64_t i, int64_t j, int64_t k) {
  double sum = sum_at(c, i, j, k);
  if (j < k)
    sum += sum_at(c, i, k, j);
  if (i < j)
    sum += sum_at(c, j, k, i);
  return sum;
}

/* The same of any order. */
static double coefficient_of(const cubic_form *c, int64_t i, int64_t j, int64_t k) {
  const int64_t low = i < j ? i : j, high = i < j ? j : i;
  if (k <= low)
    return coefficient(c, k, low, high);
  return k <= high ? coefficient(c, low, k, high) : coefficient(c, low, high, k);
}

static thrum_status reduce_volume(const thrum_fem *fem, const thrum_actuator *actuator,
                                  const thrum_model *model, double *linear, double *quadratic,
                                  double *cubic, thrum_error *error) {
  const int64_t r = model->rank, n = r + 1;
  thrum_scope memory = thrum_scope_begin("the actuators", error);
  cubic_form c = {.fem = fem,
                  .surface = &actuator->surface,
                  .basis = model->basis,
                  .rank = r,
                  .n = n,
                  .pairs = thrum_scope_allocate(&memory, BLOCK * pairs_of(n), sizeof(double)),
                  .places = thrum_scope_allocate(&memory, BLOCK * n, sizeof(double)),
                  .sums = thrum_scope_allocate(&memory, pairs_of(n) * n, sizeof(double)),
                  .nodes = thrum_scope_allocate(&memory, 18 * n, sizeof(double)),
                  .at = thrum_scope_allocate(&memory, 9 * n, sizeof(double))};
  if (memory.status >= 0) {
    add_faces(&c);

    // the force of each coordinate k has as often what a monomial has of it
    for (int64_t k = 0; k < r; k++)
      linear[k] = coefficient(&c, 0, 0, k + 1);
    for (int64_t i = 0; i < r; i++)
      for (int64_t k = 0; k < r; k++)
        quadratic[i * r + k] = (i == k ? 2 : 1) * coefficient_of(&c, 0, i + 1, k + 1);
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++)
        for (int64_t k = 0; k < r; k++)
          *cubic++ = (1 + (k == i) + (k == j)) * coefficient_of(&c, i + 1, j + 1, k + 1);
  }
  thrum_scope_free(&memory);
  return memory.status;
}

/* --- strains ---------------------------------------------------------------------------------- */

static thrum_status reduce_strain(const thrum_fem *fem, const thrum_actuator *actuator,
                                  const thrum_model *model, double *linear, double *quadratic,
                                  thrum_error *error) {
  const int64_t r = model->rank;
  thrum_scope memory = thrum_scope_begin("the actuators", error);
  double *g = thrum_scope_allocate(&memory, 9 * r, sizeof *g);
  double *pushed = thrum_scope_allocate(&memory, 9 * r, sizeof *pushed);
  for (int64_t t = 0; t < fem->tet_count && memory.status >= 0; t++) {
    const int32_t region = fem->tet_region[t], *node = fem->nodes + fem->node_count * t;
    if (actuator->region >= 0 && region != actuator->region)
      continue;
    double strain[3][3], stress[3][3], shape[THRUM_FEM_NODES_MAX][3];
    memcpy(strain, actuator->strain, sizeof strain);
    thrum_stress(fem->lambda[region], fem->mu[region], strain, stress);
    for (int p = 0; p < fem->point_count; p++) {
      const double weight = fem->weight[t * fem->point_count + p];
      thrum_fem_shape_gradients(fem, t, p, shape);

      // row 3 c + d: du_c / dX_d of each coordinate
      memset(g, 0, (size_t)(9 * r) * sizeof *g);
      memset(pushed, 0, (size_t)(9 * r) * sizeof *pushed);
      for (int a = 0; a < fem->node_count; a++)
        for (int c = 0; c < 9; c++)
          cblas_daxpy((int)r, shape[a][c % 3], model->basis + (3 * (int64_t)node[a] + c / 3) * r, 1,
                      g + c * r, 1);
      for (int c = 0; c < 9; c++) {
        cblas_daxpy((int)r, weight * stress[c / 3][c % 3], g + c * r, 1, linear, 1);
        for (int e = 0; e < 3; e++)
          cblas_daxpy((int)r, weight * stress[e][c % 3], g + (c / 3 * 3 + e) * r, 1, pushed + c * r,
                      1);
      }
      cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, (int)r, (int)r, 9, 1, g, (int)r, pushed,
                  (int)r, 1, quadratic, (int)r);
    }
  }

  // symmetric but for rounding
  for (int64_t i = 0; i < r && memory.status >= 0; i++)
    for (int64_t j = 0; j < i; j++)
      quadratic[i * r + j] = quadratic[j * r + i] =
          0.5 * (quadratic[i * r + j] + quadratic[j * r + i]);
  thrum_scope_free(&memory);
  return memory.status;
}

/* --- a model ---------------------------------------------------------------------------------- */

/* Arrays that the model has from here on. */
typedef struct made {
  uint8_t *texts;
  int32_t *kind, *ends;
  double *rest, *linear, *quadratic, *cubic, *places, *rows;
} made;

static thrum_status make_arrays(int64_t count, const thrum_actuator *actuators, thrum_model *model,
                                made *m, thrum_error *error) {
  const int64_t r = model->rank;
  int64_t bytes = 0, chambers = 0, guides = 0;
  for (int64_t k = 0; k < count; k++) {
    bytes += (int64_t)strlen(actuators[k].text) + 1;
    chambers +=
        actuators[k].kind == THRUM_ACTUATOR_PRESSURE || actuators[k].kind == THRUM_ACTUATOR_GAS;
    guides += actuators[k].guide_count;
  }
  THRUM_TRY(thrum_reserve(&m->texts, bytes, 1, "the actuators", error));
  model->actuator_texts = m->texts;
  THRUM_TRY(thrum_reserve(&m->kind, count, sizeof *m->kind, "the actuators", error));
  model->actuator_kind = m->kind;
  THRUM_TRY(thrum_reserve(&m->rest, 3 * count, sizeof *m->rest, "the actuators", error));
  model->actuator_rest = m->rest;
  THRUM_TRY(thrum_reserve(&m->linear, count * r, sizeof *m->linear, "the actuators", error));
  model->actuator_linear = m->linear;
  THRUM_TRY(
      thrum_reserve(&m->quadratic, count * r * r, sizeof *m->quadratic, "the actuators", error));
  model->actuator_quadratic = m->quadratic;
  model->actuator_count = count;
  model->actuator_bytes = bytes;
  model->actuator_square = r * r;
  if (chambers > 0) {
    model->chamber_count = chambers;
    model->actuator_cube = pairs_of(r) * r;
    THRUM_TRY(thrum_reserve(&m->cubic, chambers * model->actuator_cube, sizeof *m->cubic,
                            "the actuators", error));
    model->actuator_cubic = m->cubic;
  }
  if (guides > 0) {
    model->guide_count = guides;
    THRUM_TRY(thrum_reserve(&m->ends, count, sizeof *m->ends, "the actuators", error));
    model->guide_ends = m->ends;
    THRUM_TRY(thrum_reserve(&m->places, 3 * guides, sizeof *m->places, "the actuators", error));
    model->guide_places = m->places;
    THRUM_TRY(thrum_reserve(&m->rows, 3 * guides * r, sizeof *m->rows, "the actuators", error));
    model->guide_rows = m->rows;
  }
  return THRUM_OK;
}

/* Guides of a tendon, and its force at rest into `force` (rank). */
static void fill_guides(const thrum_fem *fem, const thrum_actuator *one, const thrum_model *model,
                        double *places, double *rows, double *force) {
  const int64_t r = model->rank;
  for (int64_t n = 0; n < one->guide_count; n++) {
    const int64_t v = one->guides[n];
    memcpy(places + 3 * n, v >= 0 ? fem->vertices + 3 * v : one->places + 3 * n,
           3 * sizeof *places);
    if (v >= 0)
      memcpy(rows + 3 * n * r, model->basis + 3 * v * r, (size_t)(3 * r) * sizeof *rows);
  }
  for (int64_t n = 0; n + 1 < one->guide_count; n++) {
    double d[3], square = 0;
    for (int axis = 0; axis < 3; axis++) {
      d[axis] = places[3 * n + 3 + axis] - places[3 * n + axis];
      square += d[axis] * d[axis];
    }
    for (int axis = 0; axis < 3; axis++) {
      cblas_daxpy((int)r, -d[axis] / sqrt(square), rows + (3 * n + 3 + axis) * r, 1, force, 1);
      cblas_daxpy((int)r, d[axis] / sqrt(square), rows + (3 * n + axis) * r, 1, force, 1);
    }
  }
}

/* Share of the static answer to a force that the coordinates hold, in the energy norm. */
static double share_of(const thrum_model *model, const double *force, double compliance) {
  double held = 0;
  for (int64_t i = 0; i < model->rank; i++)
    held += force[i] * force[i] / model->omega2[i];
  return compliance > 0 ? sqrt(fmin(held / compliance, 1)) : 0;
}

thrum_status thrum_actuators_reduce(const thrum_fem *fem, int64_t count,
                                    const thrum_actuator *actuators, const double *compliance,
                                    thrum_model *model, thrum_error *error) {
  const int64_t r = model->rank;
  made m = {0};
  double *force = NULL;
  THRUM_TRY(make_arrays(count, actuators, model, &m, error));
  THRUM_TRY(thrum_reserve(&force, r, sizeof *force, "the actuators", error));
  int64_t chamber = 0, guides = 0;
  uint8_t *text = m.texts;
  thrum_status status = THRUM_OK;
  for (int64_t k = 0; k < count && status >= 0; k++) {
    const thrum_actuator *one = &actuators[k];
    double *linear = m.linear + k * r, *quadratic = m.quadratic + k * r * r;
    const size_t bytes = strlen(one->text) + 1;
    memcpy(text, one->text, bytes);
    text += bytes;
    m.kind[k] = one->kind;
    m.rest[3 * k] = thrum_fem_actuator_rest(fem, one);
    m.rest[3 * k + 1] = one->outside;

    // its polynomial, or its guides
    const double *at_rest = linear;
    if (one->kind == THRUM_ACTUATOR_STRAIN) {
      status = reduce_strain(fem, one, model, linear, quadratic, error);
    } else if (one->kind == THRUM_ACTUATOR_TENDON) {
      memset(force, 0, (size_t)r * sizeof *force);
      fill_guides(fem, one, model, m.places + 3 * guides, m.rows + 3 * guides * r, force);
      guides += one->guide_count;
      at_rest = force;
    } else {
      status = reduce_volume(fem, one, model, linear, quadratic,
                             m.cubic + chamber++ * model->actuator_cube, error);
    }
    if (m.ends)
      m.ends[k] = (int32_t)guides;
    m.rest[3 * k + 2] = share_of(model, at_rest, compliance[k]);
  }
  free(force);
  return status;
}
