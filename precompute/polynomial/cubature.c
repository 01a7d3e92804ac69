/* Cubature points of a reduced body, see cubature.h.
 *
 * States. The lowest k coordinates x are drawn evenly in energy (x_i = random / w_i) and scaled to
 * a displacement of a random share of the range. The others follow as in static condensation, y_h =
 * -a_h(x) / w_h^2, where a(x) is the even part of the force at U x: so the states lie near the
 * manifold of modes and their derivatives, on which the body moves. In half of the states each of
 * them is off by a random factor, as it is when it vibrates.
 *
 * For a body that flows, every second state has flowed, at once and from where nothing had, in
 * another state: half of them in the next one that is drawn, the others in their own motion carried
 * further. So points are judged by the force that holds a bent body.
 *
 * Least squares. Row (s, i) is the internal force R_i of state s over |R_s|, in the norm of the
 * static response, sum R_i^2 / w_i^2; so every state counts alike, and |A x - b|^2 over the number
 * of states is the square of the relative rms error. Only A^T A is kept. Where there are more
 * points than CANDIDATES, that many are drawn.
 *
 * Cost: three evaluations of the full-order force a state, and rows x candidates^2. A state to
 * refine on takes one, and two more for each pair of coordinates that are drawn; with a law other
 * than Saint Venant-Kirchhoff's it takes three. Eight states are evaluated at once (fem_forces.h),
 * except where the body flows.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/cubature.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "precompute/fem/fem_forces.h"
#include "precompute/fem/fem_tet.h"
#include "precompute/polynomial/cubature_refine.h"
#include "precompute/polynomial/nonnegative.h"
#include "precompute/polynomial/quartic_stress.h"
#include "runtime/material/plastic_flow.h"

#define TEST_STATES 40 /* to judge by */
#define STATES (THRUM_CUBATURE_STATES - TEST_STATES)
#define CHUNK THRUM_FEM_LANES   /* states that are made, and whose rows are held, at once */
#define ROWS 9                  /* components of a gradient */
#define SMALLEST 0.05           /* amplitude of a state, of the largest */
#define OFF 0.5                 /* by which followers are off, in half of the states */
#define GAIN 5.0                /* by which refining is expected to lower the error */
#define LEARNING_SECONDS 3.6e-9 /* of a point, a coordinate and a state of a step */
#define CHOSEN 0.2 /* of the time at which points are chosen, where they are then refined, */
#define MADE 0.4   /* and at which the states to refine on are made */

typedef struct cubature {
  const thrum_fem *fem;
  const thrum_cubature_def *def;
  const thrum_model *model;
  int64_t rank, count; /* count: candidates */
  int64_t *candidate;  /* their points */
  double *gradient;    /* (ROWS count) x rank */
  double *q, *force;   /* rank a state: coordinates; nonlinear force over its norm, in the norm */
  double *flowed;      /* rank a state: coordinates at which it has flowed; zeros: nowhere */
  double *plastic;     /* points of the mesh x 9: what has flowed in the state at hand */
  double *scale;       /* a state: 1 / |R| */
  double *norm;        /* rank: 1 / w_i */
  double *quadratic;   /* rank for each pair j <= i of the drawn ones: the even part of the force in
                        * q_i q_j of the units below; NULL: it is evaluated */
  double *unit;        /* one for each coordinate that is drawn */
  double reach;        /* largest displacement of a state [m] */
  double *field, *force_field, *other_field; /* 3 vertex_count */
  double *fields, *force_fields;             /* 3 vertex_count x CHUNK, of states side by side */
  double *off;                               /* CHUNK x rank: factors of what followers do */
  double *products[2], *projections[2], target[2];
  uint64_t random;
  double share; /* of the time, in which points are chosen: 1, or less where they are refined */
  bool flows;   /* some region does, beyond a yield */
  int64_t few;  /* points at which they might have been learned; 0: not reached yet */
  double strain, flow; /* largest norm of Green's strain, and of what has flowed, at a candidate */
  const thrum_reporter *reporter;
} cubature;

/* Evenly in [-1, 1): a linear congruential generator by Knuth's constants. */
static double draw(cubature *c) {
  c->random = c->random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (double)(c->random >> 11) / 4503599627370496.0 - 1.0;
}

/* field = U q. */
static void expand(const cubature *c, const double *q, double *field) {
  cblas_dgemv(CblasRowMajor, CblasNoTrans, (int)(3 * c->model->vertex_count), (int)c->rank, 1,
              c->model->basis, (int)c->rank, q, 1, 0, field, 1);
}

/* reduced = U^T field. */
static void reduce(const cubature *c, const double *field, double *reduced) {
  cblas_dgemv(CblasRowMajor, CblasTrans, (int)(3 * c->model->vertex_count), (int)c->rank, 1,
              c->model->basis, (int)c->rank, field, 1, 0, reduced, 1);
}

/* Largest displacement of a vertex. */
static double largest(const cubature *c) {
  double most = 0;
  for (int64_t v = 0; v < c->model->vertex_count; v++) {
    const double *u = c->field + 3 * v;
    most = fmax(most, u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  }
  return sqrt(most);
}

/* The even part of the force at U q, reduced: what is quadratic in q, of Saint Venant-Kirchhoff
 * material. */
static void even_force(const cubature *c, const double *q, double *reduced) {
  const int rows = (int)(3 * c->model->vertex_count);
  expand(c, q, c->field);
  thrum_fem_energy(c->fem, c->field, c->force_field);
  cblas_dscal(rows, -1, c->field, 1);
  thrum_fem_energy(c->fem, c->field, c->other_field);
  cblas_daxpy(rows, 1, c->other_field, 1, c->force_field, 1);
  reduce(c, c->force_field, reduced);
  cblas_dscal((int)c->rank, 0.5, reduced, 1);
}

/* The same from its coefficients, where there are some. */
static void quadratic_force(const cubature *c, const double *q, double *reduced) {
  const double *row = c->quadratic;
  memset(reduced, 0, (size_t)c->rank * sizeof *reduced);
  for (int64_t i = 0; i < c->def->masters; i++)
    for (int64_t j = 0; j <= i; j++, row += c->rank)
      cblas_daxpy((int)c->rank, q[i] / c->unit[i] * q[j] / c->unit[j], row, 1, reduced, 1);
}

/* The factors by which followers are off in state s: of every second one they are 1. */
static void draw_off(cubature *c, int64_t s, double *off) {
  for (int64_t h = c->def->masters; h < c->rank; h++)
    off[h] = s % 2 == 0 ? 1 : 1 + OFF * draw(c);
}

/* Adds to q what the coordinates from k on do while the others are at q, where the even part of the
 * force is, times these factors. */
static void follow(const cubature *c, const double *even, const double *off, double *q) {
  for (int64_t h = c->def->masters; h < c->rank; h++)
    q[h] -= even[h] * c->norm[h] * c->norm[h] * off[h];
}

/* A point of a region that has flowed at the gradient g as far as it does at once, from where
 * nothing had; zeros within the yield. */
static void flow_at(const cubature *c, int32_t region, double g[3][3], double plastic[3][3]) {
  const double yield = thrum_fem_yield(c->fem, region, c->def->yield);
  const thrum_plastic material = {yield, INFINITY, INFINITY};
  double none[3][3] = {{0}};
  if (!thrum_plastic_flow(&material, 1, g, none, 1, plastic))
    memset(plastic, 0, sizeof none);
}

/* The body of state s, of which `body` is a copy, with what has flowed in it. */
static const thrum_fem *flowed_body(cubature *c, int64_t s, thrum_fem *body) {
  if (!c->flows)
    return c->fem;
  expand(c, c->flowed + s * c->rank, c->other_field);
  for (int64_t point = 0; point < c->fem->tet_count * c->fem->point_count; point++) {
    const int64_t t = point / c->fem->point_count;
    thrum_tet tet;
    double plastic[3][3];
    thrum_fem_tet_at(c->fem, t, (int)(point % c->fem->point_count), c->other_field, &tet);
    flow_at(c, c->fem->tet_region[t], tet.displacement, plastic);
    memcpy(c->plastic + ROWS * point, plastic, sizeof plastic);
  }
  *body = *c->fem;
  body->plastic = c->plastic;
  return body;
}

/* Where every second state has flowed: further along its own motion, or in the one before. */
static void choose_flow(cubature *c, int64_t s) {
  const int64_t r = c->rank;
  double *flowed = c->flowed + s * r;
  if (!c->flows || s % 2 == 0)
    return;
  memcpy(flowed, c->q + (s % 4 == 1 ? s : s - 1) * r, (size_t)r * sizeof *flowed);
  const double share = 0.5 + 0.5 * draw(c);
  for (int64_t i = 0; i < r && s % 4 == 1; i++)
    c->q[s * r + i] *= share;
}

/* Draws the lowest coordinates of a state, the others zero; returns how far it is to move the body.
 */
static double draw_masters(cubature *c, double *q) {
  memset(q, 0, (size_t)c->rank * sizeof *q);
  for (int64_t i = 0; i < c->def->masters; i++)
    q[i] = draw(c) * c->norm[i];
  return c->reach * (SMALLEST + (1 - SMALLEST) * (0.5 + 0.5 * draw(c)));
}

/* The force of state s, reduced, becomes what of it is not linear, in the norm and over its size.
 */
static void judge_force(const cubature *c, int64_t s) {
  const int64_t r = c->rank;
  const double *q = c->q + s * r;
  double *force = c->force + s * r, size = 0;
  for (int64_t i = 0; i < r; i++)
    size += force[i] * force[i] * c->norm[i] * c->norm[i];
  c->scale[s] = 1 / sqrt(size);
  for (int64_t i = 0; i < r; i++)
    force[i] = (force[i] - c->model->omega2[i] * q[i]) * c->norm[i] * c->scale[s];
}

/* Draws state s of a body that flows, and takes its force. */
static void make_state(cubature *c, int64_t s) {
  double *q = c->q + s * c->rank, even[THRUM_RANK_MAX];
  const double reach = draw_masters(c, q);
  expand(c, q, c->field);
  cblas_dscal((int)c->def->masters, reach / largest(c), q, 1);
  draw_off(c, s, c->off);
  even_force(c, q, even);
  follow(c, even, c->off, q);
  choose_flow(c, s);

  // the force of the whole body
  thrum_fem body;
  const thrum_fem *with = flowed_body(c, s, &body);
  expand(c, q, c->field);
  thrum_fem_energy(with, c->field, c->force_field);
  reduce(c, c->force_field, c->force + s * c->rank);
  judge_force(c, s);
}

/* The fields of CHUNK states, of which the lowest `count` coordinates are not zero. */
static void expand_chunk(const cubature *c, const double *q, int64_t count) {
  const int rows = (int)(3 * c->model->vertex_count), r = (int)c->rank;
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, rows, CHUNK, (int)count, 1, c->model->basis,
              r, q, r, 0, c->fields, CHUNK);
}

/* to (CHUNK x rank) = weight to + scale times the forces there, reduced. */
static void reduce_chunk(const cubature *c, double scale, double weight, double *to) {
  const int rows = (int)(3 * c->model->vertex_count), r = (int)c->rank;
  thrum_fem_forces(c->fem, c->fields, c->force_fields);
  cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, CHUNK, r, rows, scale, c->force_fields,
              CHUNK, c->model->basis, r, weight, to, r);
}

/* The even parts of the forces of CHUNK states, into `even`: the fields are theirs. */
static void even_forces(const cubature *c, const double *q, double *even) {
  for (int64_t k = 0; k < CHUNK && c->quadratic; k++)
    quadratic_force(c, q + k * c->rank, even + k * c->rank);
  if (c->quadratic)
    return;
  expand_chunk(c, q, c->def->masters);
  reduce_chunk(c, 0.5, 0, even);
  cblas_dscal((int)(3 * CHUNK * c->model->vertex_count), -1, c->fields, 1);
  reduce_chunk(c, 0.5, 1, even);
}

/* Largest displacement of a vertex in field k. */
static double largest_of(const cubature *c, int64_t k) {
  double most = 0;
  for (int64_t v = 0; v < c->model->vertex_count; v++) {
    const double *u = c->fields + 3 * CHUNK * v + k;
    const double x = u[0], y = u[CHUNK], z = u[2 * CHUNK];
    most = fmax(most, x * x + y * y + z * z);
  }
  return sqrt(most);
}

/* Draws CHUNK states from s on of a body that does not flow, and takes their forces. */
static void make_chunk(cubature *c, int64_t s) {
  const int64_t r = c->rank, masters = c->def->masters;
  double *q = c->q + s * r, *force = c->force + s * r, reach[CHUNK];
  for (int64_t k = 0; k < CHUNK; k++) {
    reach[k] = draw_masters(c, q + k * r);
    draw_off(c, s + k, c->off + k * r);
  }

  // as far as the range allows, and what follows; the forces' place holds their even parts
  expand_chunk(c, q, masters);
  for (int64_t k = 0; k < CHUNK; k++)
    cblas_dscal((int)masters, reach[k] / largest_of(c, k), q + k * r, 1);
  even_forces(c, q, force);
  for (int64_t k = 0; k < CHUNK; k++)
    follow(c, force + k * r, c->off + k * r, q + k * r);

  // the forces of the whole body
  expand_chunk(c, q, r);
  reduce_chunk(c, 1, 0, force);
  for (int64_t k = 0; k < CHUNK; k++)
    judge_force(c, s + k);
}

/* The same of every body. */
static void make_states(cubature *c, int64_t s) {
  if (!c->flows) {
    make_chunk(c, s);
    return;
  }
  for (int64_t k = 0; k < CHUNK; k++)
    make_state(c, s + k);
}

/* G of every basis vector at a point of the mesh: ROWS x rank. */
static void point_gradients(const thrum_fem *fem, const thrum_model *model, int64_t point,
                            double *to) {
  const int64_t r = model->rank, t = point / fem->point_count;
  const int32_t *node = fem->nodes + fem->node_count * t;
  double shape[THRUM_FEM_NODES_MAX][3];
  thrum_fem_shape_gradients(fem, t, (int)(point % fem->point_count), shape);
  memset(to, 0, (size_t)(ROWS * r) * sizeof *to);

  // differences to node 0, so that a translation gives exact zeros
  for (int a = 1; a < fem->node_count; a++)
    for (int c = 0; c < 3; c++) {
      const double *u = model->basis + (3 * (int64_t)node[a] + c) * r;
      const double *u0 = model->basis + (3 * (int64_t)node[0] + c) * r;
      for (int d = 0; d < 3; d++)
        for (int64_t i = 0; i < r; i++)
          to[(3 * c + d) * r + i] += (u[i] - u0[i]) * shape[a][d];
    }
}

/* Stress without its linear part of another law, where the point has flowed at the gradient
 * `before`. */
static void law_stress(cubature *c, int32_t region, double before[3][3], double g[3][3],
                       double p[3][3]) {
  const double lambda = c->fem->lambda[region], mu = c->fem->mu[region];
  double plastic[3][3] = {{0}};
  if (c->flows) {
    flow_at(c, region, before, plastic);
    c->flow = fmax(c->flow, thrum_plastic_strain(plastic));
  }
  thrum_flowed_stress(thrum_fem_law(c->fem, region), lambda, mu, g, plastic, p);
  thrum_take_linear_stress_off(lambda, mu, g, p);
}

/* The norm of Green's strain (g + g^T + g^T g) / 2. */
static double green_norm(double g[3][3]) {
  double sum = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double twice = g[i][j] + g[j][i];
      for (int k = 0; k < 3; k++)
        twice += g[k][i] * g[k][j];
      sum += 0.25 * twice * twice;
    }
  return sqrt(sum);
}

/* The force of one candidate in one state, weighted by its own volume, in the rows' scale. */
static void candidate_row(cubature *c, int64_t n, int64_t s, const double *gradient,
                          const double *before, double *row) {
  const int64_t point = c->candidate[n];
  const int32_t region = c->fem->tet_region[point / c->fem->point_count];
  double g[3][3], flowed[3][3], p[3][3];
  memcpy(g, gradient, sizeof g);
  memcpy(flowed, before, sizeof flowed);
  c->strain = fmax(c->strain, green_norm(g));
  if (thrum_fem_law(c->fem, region) == THRUM_LAW_STVK)
    thrum_quartic_stress(c->fem->lambda[region], c->fem->mu[region], g, p);
  else
    law_stress(c, region, flowed, g, p);
  const double weight = c->fem->weight[point] * c->scale[s];
  const double *rows = c->gradient + ROWS * n * c->rank;
  memset(row, 0, (size_t)c->rank * sizeof *row);
  for (int k = 0; k < ROWS; k++) {
    const double stress = weight * p[k / 3][k % 3];
    for (int64_t i = 0; i < c->rank; i++)
      row[i] += stress * rows[k * c->rank + i];
  }
  for (int64_t i = 0; i < c->rank; i++)
    row[i] *= c->norm[i];
}

/* G of all candidates in `count` states: (ROWS candidates) x count. */
static void take_gradients(const cubature *c, const double *q, int64_t count, double *gradients) {
  const int r = (int)c->rank;
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, (int)(ROWS * c->count), (int)count, r, 1,
              c->gradient, r, q, r, 0, gradients, (int)count);
}

/* Adds the rows of `count` states from `first` on to the products of a set. */
static void add_states(cubature *c, int64_t first, int64_t count, int set, double *gradients,
                       double *rows) {
  const int64_t r = c->rank, height = count * r;
  double *before = c->flows ? gradients + ROWS * c->count * CHUNK : gradients;
  take_gradients(c, c->q + first * r, count, gradients);
  if (c->flows)
    take_gradients(c, c->flowed + first * r, count, before);

  for (int64_t n = 0; n < c->count; n++)
    for (int64_t s = 0; s < count; s++) {
      double g[ROWS], flowed[ROWS];
      for (int k = 0; k < ROWS; k++) {
        g[k] = gradients[(ROWS * n + k) * count + s];
        flowed[k] = before[(ROWS * n + k) * count + s];
      }
      candidate_row(c, n, first + s, g, flowed, rows + n * height + s * r);
    }

  // A^T A, A^T b and b^T b
  const double *b = c->force + first * r;
  cblas_dsyrk(CblasRowMajor, CblasLower, CblasNoTrans, (int)c->count, (int)height, 1, rows,
              (int)height, 1, c->products[set], (int)c->count);
  cblas_dgemv(CblasRowMajor, CblasNoTrans, (int)c->count, (int)height, 1, rows, (int)height, b, 1,
              1, c->projections[set], 1);
  c->target[set] += cblas_ddot((int)height, b, 1, b, 1);
}

/* Both triangles of the products, of which DSYRK writes the lower. */
static void mirror(cubature *c) {
  for (int set = 0; set < 2; set++)
    for (int64_t i = 0; i < c->count; i++)
      for (int64_t j = 0; j < i; j++)
        c->products[set][j * c->count + i] = c->products[set][i * c->count + j];
}

static thrum_status make_squares(cubature *c, double *gradients, double *rows, thrum_error *error) {
  for (int64_t s = 0; s < STATES + TEST_STATES; s += CHUNK) {
    make_states(c, s);
    THRUM_TRY(
        thrum_report(c->reporter, 0.4 * c->share * (double)s / (STATES + TEST_STATES), error));
  }
  for (int64_t s = 0; s < STATES + TEST_STATES; s += CHUNK) {
    add_states(c, s, CHUNK, s < STATES ? 0 : 1, gradients, rows);
    THRUM_TRY(thrum_report(c->reporter, c->share * (0.4 + 0.5 * (double)s / (STATES + TEST_STATES)),
                           error));
  }
  mirror(c);
  return THRUM_OK;
}
_Static_assert(STATES % CHUNK == 0 && TEST_STATES % CHUNK == 0, "a chunk is of one set");
_Static_assert(THRUM_REFINE_BATCH % CHUNK == 0, "states to refine on are whole chunks");

static thrum_squares squares_of(const cubature *c, int set) {
  return (thrum_squares){c->count, c->products[set], c->projections[set], c->target[set]};
}

/* Relative rms error in a set of states. */
static double error_of(const cubature *c, int set, int64_t used, const int64_t *places,
                       const double *x) {
  const thrum_squares squares = squares_of(c, set);
  return sqrt(thrum_squares_of(&squares, used, places, x) / (set == 0 ? STATES : TEST_STATES));
}

double thrum_cubature_cost(int64_t points, int64_t rank) {
  return THRUM_CUBATURE_POINT_COST * (double)(points * rank) /
         (double)(thrum_c3_count(rank) + thrum_c4_count(rank));
}

double thrum_cubature_learning(int64_t points, int64_t rank, int64_t steps) {
  return LEARNING_SECONDS * (double)(points * rank) * (double)(steps * THRUM_REFINE_BATCH);
}

static bool enough(void *context, int64_t used, const int64_t *places, const double *x) {
  cubature *c = context;
  // many points are judged now and then, as that takes the square of their number
  if (used % (1 + used / 50) != 0)
    return false;
  const double off = error_of(c, 1, used, places, x);
  if (off <= c->def->error * GAIN && c->few == 0)
    c->few = used;
  return off <= c->def->error * (c->def->refine > 0 ? GAIN : 1);
}

/* Chooses candidates among all points, without repeats, in ascending order. */
static void choose_candidates(cubature *c) {
  const int64_t all = c->fem->tet_count * c->fem->point_count;
  int64_t wanted = c->count;
  for (int64_t p = 0, n = 0; p < all; p++)
    if ((0.5 + 0.5 * draw(c)) * (double)(all - p) < (double)wanted) {
      c->candidate[n++] = p;
      wanted--;
    }
}

/* Does point p of the mesh come after q? By their laws first, so that the blocks in which points
 * are evaluated have one law each, but for those in which it changes. */
static bool comes_after(const thrum_fem *fem, int64_t p, int64_t q) {
  const thrum_law of_p = thrum_fem_law(fem, fem->tet_region[p / fem->point_count]);
  const thrum_law of_q = thrum_fem_law(fem, fem->tet_region[q / fem->point_count]);
  return of_p == of_q ? p > q : of_p > of_q;
}

/* Points by the least squares, in their order, with their volumes. */
static thrum_status choose_points(cubature *c, int64_t *places, double *x, int64_t *used,
                                  thrum_cubature_figures *figures, thrum_error *error) {
  const int64_t most = c->def->most < c->count ? c->def->most : c->count;
  const thrum_squares squares = squares_of(c, 0);
  THRUM_TRY(thrum_nonnegative(&squares, most, enough, c, places, x, used, error));
  *figures = (thrum_cubature_figures){.points = *used,
                                      .candidates = c->count,
                                      .states = STATES,
                                      .test_states = TEST_STATES,
                                      .few = c->def->refine > 0 ? 0 : c->few,
                                      .strain = c->strain,
                                      .plastic = c->flow,
                                      .train_error = error_of(c, 0, *used, places, x),
                                      .test_error = error_of(c, 1, *used, places, x),
                                      .force_cost = thrum_cubature_cost(*used, c->rank)};
  if (*used == 0)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "no cubature point lowers the error of the force: the body has no "
                           "nonlinear part to speak of within the range of its states");

  // points in their order in the mesh, law by law
  for (int64_t k = 0; k < *used; k++) {
    x[k] *= c->fem->weight[c->candidate[places[k]]];
    places[k] = c->candidate[places[k]];
  }
  for (int64_t k = 1; k < *used; k++)
    for (int64_t i = k; i > 0 && comes_after(c->fem, places[i - 1], places[i]); i--) {
      const int64_t place = places[i];
      const double weight = x[i];
      places[i] = places[i - 1];
      x[i] = x[i - 1];
      places[i - 1] = place;
      x[i - 1] = weight;
    }
  return THRUM_OK;
}

thrum_status thrum_cubature_fill(const thrum_fem *fem, int64_t count, const int64_t *places,
                                 const double *weights, thrum_model *model, thrum_error *error) {
  double *weight = NULL, *moduli = NULL, *gradients = NULL;
  int32_t *regions = NULL;
  const int64_t numbers = ROWS * count * model->rank;
  thrum_status status = thrum_reserve(&weight, count, sizeof(double), "the cubature", error);
  THRUM_THEN(status, thrum_reserve(&moduli, 2 * count, sizeof(double), "the cubature", error));
  THRUM_THEN(status, thrum_reserve(&gradients, numbers, sizeof(double), "the cubature", error));
  if (fem->law == THRUM_LAW_BY_REGION)
    THRUM_THEN(status, thrum_reserve(&regions, count, sizeof *regions, "the cubature", error));
  model->point_region = regions;
  model->point_weights = weight;
  model->point_moduli = moduli;
  model->point_gradients = gradients;
  model->point_count = count;
  THRUM_TRY(status);

  for (int64_t p = 0; p < count; p++) {
    const int32_t region = fem->tet_region[places[p] / fem->point_count];
    weight[p] = weights[p];
    if (regions)
      regions[p] = region;
    moduli[p] = fem->lambda[region];
    moduli[count + p] = fem->mu[region];
    point_gradients(fem, model, places[p], gradients + ROWS * p * model->rank);
  }
  return THRUM_OK;
}

/* Coordinates of `count` states in the norm. */
static void scale_states(const cubature *c, int64_t count, double *q) {
  for (int64_t s = 0; s < count; s++)
    for (int64_t i = 0; i < c->rank; i++)
      q[s * c->rank + i] /= c->norm[i];
}

/* Columns of the gradients times 1 / w_i, or back. */
static void scale_gradients(const cubature *c, bool back, int64_t rows, double *gradients) {
  for (int64_t n = 0; n < rows; n++)
    for (int64_t i = 0; i < c->rank; i++)
      gradients[n * c->rank + i] *= back ? 1 / c->norm[i] : c->norm[i];
}

/* Coefficients of the even part of the force, which spare two of three forces of each state to
 * come; of units in which a coordinate moves the body as far as states do. */
static thrum_status take_quadratic(cubature *c, double *quadratic, double *unit,
                                   thrum_error *error) {
  const int64_t k = c->def->masters, r = c->rank;
  double q[THRUM_RANK_MAX] = {0};
  for (int64_t i = 0; i < k; i++) {
    q[i] = 1;
    expand(c, q, c->field);
    unit[i] = c->reach / largest(c);
    q[i] = 0;
  }

  // squares, and then products, which are what a sum has beside the squares
#define ROW(i, j) (quadratic + ((i) * ((i) + 1) / 2 + (j)) * r)
  for (int64_t i = 0; i < k; i++) {
    q[i] = unit[i];
    even_force(c, q, ROW(i, i));
    q[i] = 0;
  }
  for (int64_t i = 0; i < k; i++) {
    for (int64_t j = 0; j < i; j++) {
      q[i] = unit[i];
      q[j] = unit[j];
      even_force(c, q, ROW(i, j));
      cblas_daxpy((int)r, -1, ROW(i, i), 1, ROW(i, j), 1);
      cblas_daxpy((int)r, -1, ROW(j, j), 1, ROW(i, j), 1);
      q[i] = q[j] = 0;
    }
    THRUM_TRY(thrum_report(c->reporter, CHOSEN, error));
  }
#undef ROW
  c->quadratic = quadratic;
  c->unit = unit;
  return THRUM_OK;
}

/* Makes `count` more states in place of those before. */
static thrum_status make_more(cubature *c, int64_t count, thrum_error *error) {
  for (int64_t s = 0; s < count; s += CHUNK) {
    make_states(c, s);
    const double part = (double)s / (double)count;
    THRUM_TRY(thrum_report(c->reporter, CHOSEN + (MADE - CHOSEN) * part, error));
  }
  scale_states(c, count, c->q);
  return THRUM_OK;
}

/* Learns the gradients of the model's points in new states; errors are then those in these, and in
 * the states that the points were judged by. */
static thrum_status refine(cubature *c, thrum_model *model, thrum_cubature_figures *figures,
                           thrum_error *error) {
  const int64_t n = model->point_count, r = c->rank, k = c->def->masters,
                batch = THRUM_REFINE_BATCH;
  const int64_t least = THRUM_REFINE_STATES * n, steps = c->def->refine;
  const int64_t count = ((least > steps ? least : steps) + batch - 1) / batch * batch;
  // an array that thrum_cubature_fill has made; const is for readers of the model
  double *gradients = (double *)(uintptr_t)model->point_gradients;
  thrum_free_points points = {.count = n, .rank = r, .gradients = gradients};

  // the states to judge by stay, others take the place of the rest
  scale_states(c, TEST_STATES, c->q + STATES * r);
  const thrum_force_samples judge = {.count = TEST_STATES,
                                     .rank = r,
                                     .q = c->q + STATES * r,
                                     .force = c->force + STATES * r,
                                     .scale = c->scale + STATES};
  thrum_scope memory = thrum_scope_begin("the cubature", error);
#define NEED(count) thrum_scope_allocate(&memory, (count), sizeof(double))
  c->q = NEED(count * r);
  c->force = NEED(count * r);
  c->scale = NEED(count);
  double *moduli = NEED(2 * n), *work = NEED(thrum_refine_work(&points, batch));
  thrum_law *laws = thrum_scope_allocate(&memory, n, sizeof *laws);
  double *quadratic = NEED(k * (k + 1) / 2 * r), *unit = NEED(k);
#undef NEED
  points.lambda = moduli;
  points.mu = moduli ? moduli + n : NULL;
  for (int64_t p = 0; p < 2 * n && memory.status == THRUM_OK; p++)
    moduli[p] = model->point_moduli[p] * model->point_weights[p % n];

  // the even part of the force is quadratic in Saint Venant-Kirchhoff material alone
  thrum_status status = memory.status;
  if (status >= 0 && c->fem->law == THRUM_LAW_STVK)
    status = take_quadratic(c, quadratic, unit, error);
  for (int64_t p = 0; p < n && status >= 0 && c->fem->law != THRUM_LAW_STVK; p++) {
    laws[p] = thrum_fem_law(c->fem, model->point_region ? model->point_region[p] : 0);
    points.laws = laws;
  }
  THRUM_THEN(status, make_more(c, count, error));
  if (status >= 0) {
    const thrum_force_samples samples = {count, r, c->q, c->force, c->scale};
    scale_gradients(c, false, ROWS * n, gradients);
    figures->chosen_error = figures->test_error;
    status = thrum_cubature_refine(&samples, c->def->refine, &points, c->reporter, MADE, error);
    figures->states = count;
    figures->train_error = thrum_refine_error(&points, &samples, work);
    figures->test_error = thrum_refine_error(&points, &judge, work);
    scale_gradients(c, true, ROWS * n, gradients);
  }
  thrum_scope_free(&memory);
  return status;
}

thrum_status thrum_cubature(const thrum_fem *fem, const thrum_cubature_def *def, thrum_model *model,
                            thrum_cubature_figures *figures, const thrum_reporter *reporter,
                            thrum_error *error) {
  const int64_t r = model->rank, all = fem->tet_count * fem->point_count;
  cubature c = {.fem = fem,
                .def = def,
                .model = model,
                .rank = r,
                .reach = def->range * thrum_box3_diagonal(model->vertices, model->vertex_count),
                .count = all < THRUM_CUBATURE_CANDIDATES ? all : THRUM_CUBATURE_CANDIDATES,
                .random = 1,
                .share = def->refine > 0 ? CHOSEN : 1,
                .flows = def->yield < INFINITY || thrum_fem_has_yield(fem),
                .reporter = reporter};

  // candidates and states, the rows of a chunk, and the products of both sets
  thrum_scope memory = thrum_scope_begin("the cubature", error);
#define NEED(count) thrum_scope_allocate(&memory, (count), sizeof(double))
  c.candidate = thrum_scope_allocate(&memory, c.count, sizeof *c.candidate);
  c.gradient = NEED(ROWS * c.count * r);
  c.q = NEED((STATES + TEST_STATES) * r);
  c.force = NEED((STATES + TEST_STATES) * r);
  c.flowed = NEED(c.flows ? (STATES + TEST_STATES) * r : 1);
  c.plastic = NEED(c.flows ? ROWS * all : 1);
  c.scale = NEED(STATES + TEST_STATES);
  c.norm = NEED(r);
  c.field = NEED(3 * model->vertex_count);
  c.force_field = NEED(3 * model->vertex_count);
  c.other_field = NEED(3 * model->vertex_count);
  c.fields = NEED(3 * CHUNK * model->vertex_count);
  c.force_fields = NEED(3 * CHUNK * model->vertex_count);
  c.off = NEED(CHUNK * r);
  for (int set = 0; set < 2; set++) {
    c.products[set] = NEED(c.count * c.count);
    c.projections[set] = NEED(c.count);
  }
  double *gradients = NEED((c.flows ? 2 : 1) * ROWS * c.count * CHUNK),
         *rows = NEED(c.count * CHUNK * r);
  int64_t *places = thrum_scope_allocate(&memory, c.count, sizeof *places), used = 0;
  double *x = NEED(c.count);
#undef NEED

  if (memory.status == THRUM_OK) {
    // a coordinate without stiffness has no static response
    for (int64_t i = 0; i < r; i++)
      c.norm[i] = 1 / sqrt(fmax(model->omega2[i], 1e-12 * model->omega2[r - 1]));
    choose_candidates(&c);
    for (int64_t n = 0; n < c.count; n++)
      point_gradients(fem, model, c.candidate[n], c.gradient + ROWS * n * r);
  }

  thrum_status status = memory.status;
  THRUM_THEN(status, make_squares(&c, gradients, rows, error));
  THRUM_THEN(status, choose_points(&c, places, x, &used, figures, error));
  THRUM_THEN(status, thrum_cubature_fill(fem, used, places, x, model, error));
  if (status >= 0 && def->refine > 0)
    status = refine(&c, model, figures, error);
  thrum_scope_free(&memory);
  return status;
}
