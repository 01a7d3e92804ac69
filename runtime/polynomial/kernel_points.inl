/* The passes over cubature points (runtime/polynomial/points.h), over vectors of 8 lanes, for a
 * file that has included runtime/polynomial/kernel_lanes.h. Where a gradient meets the coordinates,
 * lanes are coordinates and each of its nine sums is in lanes i mod 8; in the law of the material,
 * lanes are points; in the tangent they are coordinates again. A force adds up points in ascending
 * order, and the components of each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "runtime/polynomial/points.h"

/* Sums of three components at once, which leave registers for the loads. */
#define POINT_SUMS 3

/* A matrix by rows, and a symmetric one: xx, yy, zz, xy, yz, zx; one number in each lane. */
typedef struct v8_matrix {
  v8 at[9];
} v8_matrix;

typedef struct v8_symmetric {
  v8 at[6];
} v8_symmetric;

/* Place of component (a, b) of a symmetric matrix. */
static const int point_place[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};

/* sym G. */
INLINE v8_symmetric v8_linear_strain(const v8_matrix *g) {
  const v8 half = v8_set1(0.5);
  const v8_symmetric e = {{g->at[0], g->at[4], g->at[8], v8_mul(half, v8_add(g->at[1], g->at[3])),
                           v8_mul(half, v8_add(g->at[5], g->at[7])),
                           v8_mul(half, v8_add(g->at[2], g->at[6]))}};
  return e;
}

/* sum_k G_ka D_kb. */
INLINE v8 v8_columns(const v8_matrix *g, const v8_matrix *d, int a, int b) {
  return v8_add(v8_add(v8_mul(g->at[a], d->at[b]), v8_mul(g->at[3 + a], d->at[3 + b])),
                v8_mul(g->at[6 + a], d->at[6 + b]));
}

/* G^T G / 2. */
INLINE v8_symmetric v8_quadratic_strain(const v8_matrix *g) {
  const v8 half = v8_set1(0.5);
  const v8_symmetric n = {
      {v8_mul(half, v8_columns(g, g, 0, 0)), v8_mul(half, v8_columns(g, g, 1, 1)),
       v8_mul(half, v8_columns(g, g, 2, 2)), v8_mul(half, v8_columns(g, g, 0, 1)),
       v8_mul(half, v8_columns(g, g, 1, 2)), v8_mul(half, v8_columns(g, g, 2, 0))}};
  return n;
}

/* sym(G^T D). */
INLINE v8_symmetric v8_mixed_strain(const v8_matrix *g, const v8_matrix *d) {
  const v8 half = v8_set1(0.5);
  const v8_symmetric n = {{v8_columns(g, d, 0, 0), v8_columns(g, d, 1, 1), v8_columns(g, d, 2, 2),
                           v8_mul(half, v8_add(v8_columns(g, d, 0, 1), v8_columns(g, d, 1, 0))),
                           v8_mul(half, v8_add(v8_columns(g, d, 1, 2), v8_columns(g, d, 2, 1))),
                           v8_mul(half, v8_add(v8_columns(g, d, 2, 0), v8_columns(g, d, 0, 2)))}};
  return n;
}

/* lambda tr(E) 1 + 2 mu E. */
INLINE v8_symmetric v8_stress(v8 lambda, v8 mu, const v8_symmetric *e) {
  const v8 pressure = v8_mul(lambda, v8_add(v8_add(e->at[0], e->at[1]), e->at[2]));
  const v8 twice = v8_add(mu, mu);
  v8_symmetric s;
  for (int c = 0; c < 6; c++)
    s.at[c] = c < 3 ? v8_add(pressure, v8_mul(twice, e->at[c])) : v8_mul(twice, e->at[c]);
  return s;
}

/* a + b of symmetric ones. */
INLINE v8_symmetric v8_plus(const v8_symmetric *a, const v8_symmetric *b) {
  v8_symmetric sum;
  for (int c = 0; c < 6; c++)
    sum.at[c] = v8_add(a->at[c], b->at[c]);
  return sum;
}

/* Row k of G S, column b. */
INLINE v8 v8_row_times(const v8_matrix *g, const v8_symmetric *s, int k, int b) {
  return v8_add(v8_add(v8_mul(g->at[3 * k], s->at[point_place[b]]),
                       v8_mul(g->at[3 * k + 1], s->at[point_place[3 + b]])),
                v8_mul(g->at[3 * k + 2], s->at[point_place[6 + b]]));
}

/* Moduli of a block, times the weights; zero in the lanes behind the last point. */
typedef struct v8_moduli {
  v8 lambda, mu;
} v8_moduli;

INLINE v8_moduli point_moduli(const thrum_model *model, int64_t block) {
  const int64_t first = 8 * block, left = model->point_count - first;
  const v8 weight = v8_load_range(model->point_weights + first, 0, left);
  const double *lambda = model->point_moduli + first, *mu = lambda + model->point_count;
  const v8_moduli m = {v8_mul(weight, v8_load_range(lambda, 0, left)),
                       v8_mul(weight, v8_load_range(mu, 0, left))};
  return m;
}

/* Three rows of one point's gradients times n coordinates, from `rows` on, `stride` apart. */
INLINE void point_sums(const double *rows, int64_t stride, int64_t n, const double *q, v8 *sum) {
  for (int c = 0; c < POINT_SUMS; c++)
    sum[c] = v8_zero();
  int64_t i = 0;
  for (; i + 8 <= n; i += 8) {
    const v8 x = v8_load(q + i);
    for (int c = 0; c < POINT_SUMS; c++)
      sum[c] = v8_add(sum[c], v8_mul(v8_load(rows + c * stride + i), x));
  }

  // the last lanes that there are
  if (i < n) {
    const v8_mask mask = v8_range(0, n - i);
    const v8 x = v8_load_mask(q + i, mask);
    for (int c = 0; c < POINT_SUMS; c++)
      sum[c] = v8_add(sum[c], v8_mul(v8_load_mask(rows + c * stride + i, mask), x));
  }
}

/* G at the points of a block: held coordinates (NULL: none), and n more from `first` on. */
PASS v8_matrix point_gather(const thrum_model *model, int64_t block, const double *held,
                            int64_t first, int64_t n, const double *q) {
  const int64_t rank = model->rank, left = model->point_count - 8 * block;
  const double *rows = model->point_gradients + 8 * THRUM_POINT_ROWS * block * rank + first;
  v8 sum[THRUM_POINT_ROWS][8];
  for (int64_t p = 0; p < 8; p++)
    for (int c = 0; c < THRUM_POINT_ROWS; c += POINT_SUMS) {
      v8 three[POINT_SUMS];
      point_sums(rows + (THRUM_POINT_ROWS * p + c) * rank, rank, p < left ? n : 0, q, three);
      for (int k = 0; k < POINT_SUMS; k++)
        sum[c + k][p] = three[k];
    }

  // lanes become points
  v8_matrix g;
  for (int c = 0; c < THRUM_POINT_ROWS; c++) {
    const v8 *s = sum[c];
    g.at[c] = v8_sums(s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7]);
    if (held)
      g.at[c] = v8_add(v8_load(held + 8 * (THRUM_POINT_ROWS * block + c)), g.at[c]);
  }
  return g;
}

/* Strains and stresses at the points of a block. */
typedef struct point_state {
  v8_matrix g;
  v8_symmetric n, t, s; /* N, C:N, C:E */
  v8_moduli m;
} point_state;

INLINE point_state point_strain(const thrum_model *model, int64_t block, const double *held,
                                int64_t first, int64_t n, const double *q) {
  point_state at;
  at.g = point_gather(model, block, held, first, n, q);
  at.m = point_moduli(model, block);
  at.n = v8_quadratic_strain(&at.g);
  const v8_symmetric linear = v8_linear_strain(&at.g), strain = v8_plus(&linear, &at.n);
  at.t = v8_stress(at.m.lambda, at.m.mu, &at.n);
  at.s = v8_stress(at.m.lambda, at.m.mu, &strain);
  return at;
}

/* N : (S - T / 2). */
INLINE v8 point_energy(const point_state *at) {
  const v8 half = v8_set1(-0.5);
  v8 x[6];
  for (int c = 0; c < 6; c++)
    x[c] = v8_mul(at->n.at[c], v8_add(at->s.at[c], v8_mul(half, at->t.at[c])));
  const v8 shear = v8_add(v8_add(x[3], x[4]), x[5]);
  return v8_add(v8_add(v8_add(x[0], x[1]), x[2]), v8_add(shear, shear));
}

/* T + G S. */
INLINE v8_matrix point_force(const point_state *at) {
  v8_matrix p;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    p.at[c] = v8_add(at->t.at[point_place[c]], v8_row_times(&at->g, &at->s, c / 3, c % 3));
  return p;
}

/* dP along D, of moduli, gradient and stress in all lanes. */
INLINE v8_matrix point_stiffness(v8_moduli m, const v8_matrix *g, const v8_symmetric *s,
                                 const v8_matrix *d) {
  const v8_symmetric dn = v8_mixed_strain(g, d), linear = v8_linear_strain(d);
  const v8_symmetric de = v8_plus(&linear, &dn);
  const v8_symmetric dt = v8_stress(m.lambda, m.mu, &dn), ds = v8_stress(m.lambda, m.mu, &de);
  v8_matrix p;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    p.at[c] = v8_add(v8_add(dt.at[point_place[c]], v8_row_times(d, s, c / 3, c % 3)),
                     v8_row_times(g, &ds, c / 3, c % 3));
  return p;
}

/* to_i += sum_c P_c G_c,i over the points of a block, of n coordinates from `first` on. */
PASS void point_scatter(const thrum_model *model, int64_t block, const v8_matrix *force,
                        int64_t first, int64_t n, double *to) {
  const int64_t rank = model->rank, left = model->point_count - 8 * block;
  double p[THRUM_POINT_ROWS][8];
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    v8_store(p[c], force->at[c]);

  // each point in turn
  const double *rows = model->point_gradients + 8 * THRUM_POINT_ROWS * block * rank + first;
  for (int64_t k = 0; k < 8 && k < left; k++, rows += THRUM_POINT_ROWS * rank)
    for (int64_t i = 0; i < n; i += 8) {
      const v8_mask mask = v8_range(0, n - i);
      v8 sum = v8_load_mask(to + i, mask);
      for (int c = 0; c < THRUM_POINT_ROWS; c++)
        sum = v8_add(sum, v8_mul(v8_set1(p[c][k]), v8_load_mask(rows + c * rank + i, mask)));
      v8_store_first(to + i, sum, n - i);
    }
}

/* --- whole evaluations --------------------------------------------------------------------------
 */

/* Coordinates that move, those that are held, and those whose forces are wanted. */
typedef struct point_range {
  const double *held; /* of a restriction; NULL: none */
  int64_t first, n;   /* that move, of all of the model */
  int64_t wanted;     /* of these, the first */
} point_range;

PASS double points_value(const thrum_model *model, point_range range, const double *q) {
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_state at = point_strain(model, b, range.held, range.first, range.n, q);
    sum = v8_add(sum, point_energy(&at));
  }
  return v8_sum(sum);
}

/* gradient (wanted) += the forces; returns V's nonlinear part. */
PASS double points_force(const thrum_model *model, point_range range, const double *q,
                         double *gradient) {
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_state at = point_strain(model, b, range.held, range.first, range.n, q);
    const v8_matrix force = point_force(&at);
    sum = v8_add(sum, point_energy(&at));
    point_scatter(model, b, &force, range.first, range.wanted, gradient);
  }
  return v8_sum(sum);
}

/* The same at two points, from one read of the gradients. */
PASS void points_forces(const thrum_model *model, const double *const q[2],
                        double *const gradient[2], double value[2], double *work) {
  v8 sum[2] = {v8_zero(), v8_zero()};
  (void)work;
  for (int64_t b = 0; b < thrum_point_blocks(model); b++)
    for (int k = 0; k < 2; k++) {
      const point_state at = point_strain(model, b, NULL, 0, model->rank, q[k]);
      const v8_matrix force = point_force(&at);
      sum[k] = v8_add(sum[k], point_energy(&at));
      point_scatter(model, b, &force, 0, model->rank, gradient[k]);
    }
  for (int k = 0; k < 2; k++)
    value[k] = v8_sum(sum[k]);
}

/* product (wanted) += T v, of v that is zero behind the wanted ones. */
PASS void points_tangent_vector(const thrum_model *model, int64_t wanted, const double *q,
                                const double *v, double *product) {
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_state at = point_strain(model, b, NULL, 0, model->rank, q);
    const v8_matrix d = point_gather(model, b, NULL, 0, wanted, v);
    const v8_matrix force = point_stiffness(at.m, &at.g, &at.s, &d);
    point_scatter(model, b, &force, 0, wanted, product);
  }
}

/* rows (9 x stride) = dP along the gradient of each of n coordinates, at point k of a block. */
PASS void point_columns(const thrum_model *model, int64_t block, int64_t k, const point_state *at,
                        int64_t first, int64_t n, int64_t stride, double *to) {
  const double *rows =
      model->point_gradients + THRUM_POINT_ROWS * (8 * block + k) * model->rank + first;
  double lane[8];
  v8_matrix g;
  v8_symmetric s;
  v8_moduli m;

  // one point in all lanes
#define SPREAD(from, into) (v8_store(lane, (from)), (into) = v8_set1(lane[k]))
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    SPREAD(at->g.at[c], g.at[c]);
  for (int c = 0; c < 6; c++)
    SPREAD(at->s.at[c], s.at[c]);
  SPREAD(at->m.lambda, m.lambda);
  SPREAD(at->m.mu, m.mu);
#undef SPREAD

  // eight coordinates at a time
  for (int64_t i = 0; i < n; i += 8) {
    const v8_mask mask = v8_range(0, n - i);
    v8_matrix d;
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      d.at[c] = v8_load_mask(rows + c * model->rank + i, mask);
    const v8_matrix p = point_stiffness(m, &g, &s, &d);
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      v8_store(to + c * stride + i, p.at[c]);
  }
}

/* Rows of the lower triangle, in blocks of 8 whose last columns reach beyond it. */
PASS void point_square(int64_t n, const double *rows, int64_t rank, const double *columns,
                       int64_t stride, double *hessian) {
  for (int64_t top = 0; top < n; top += 8)
    for (int64_t j = 0; j <= top; j += 8) {
      v8 y[THRUM_POINT_ROWS];
      for (int c = 0; c < THRUM_POINT_ROWS; c++)
        y[c] = v8_load(columns + c * stride + j);
      const v8_mask mask = v8_range(0, n - j);
      for (int64_t i = top; i < n && i < top + 8; i++) {
        double *row = hessian + i * n + j;
        v8 sum = v8_load_mask(row, mask);
        for (int c = 0; c < THRUM_POINT_ROWS; c++)
          sum = v8_add(sum, v8_mul(v8_set1(rows[c * rank + i]), y[c]));
        v8_store_first(row, sum, n - j);
      }
    }
}

/* hessian (n x n) += T; gradient (n), if not NULL, += the forces; returns V's nonlinear part. */
PASS double points_tangent(const thrum_model *model, point_range range, const double *q,
                           double *gradient, double *hessian, double *work) {
  const int64_t n = range.n, stride = thrum_whole(n), rank = model->rank;
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_state at = point_strain(model, b, range.held, range.first, n, q);
    sum = v8_add(sum, point_energy(&at));
    if (gradient) {
      const v8_matrix force = point_force(&at);
      point_scatter(model, b, &force, range.first, n, gradient);
    }
    for (int64_t k = 0; k < 8 && 8 * b + k < model->point_count; k++) {
      point_columns(model, b, k, &at, range.first, n, stride, work);
      point_square(n, model->point_gradients + THRUM_POINT_ROWS * (8 * b + k) * rank + range.first,
                   rank, work, stride, hessian);
    }
  }

  // both triangles from the lower one
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = i + 1; j < n; j++)
      hessian[i * n + j] = hessian[j * n + i];
  return v8_sum(sum);
}

/* --- the table ---------------------------------------------------------------------------------
 */

static inline point_range point_all(const thrum_model *model) {
  const point_range range = {NULL, 0, model->rank, model->rank};
  return range;
}

static inline point_range point_left(const thrum_model *model, int64_t split,
                                     const double *restricted) {
  const point_range range = {restricted, split, model->rank - split, model->rank - split};
  return range;
}

static double points_pass_energy(const thrum_model *model, const double *q, double *work) {
  (void)work;
  return points_value(model, point_all(model), q);
}

static double points_pass_force(const thrum_model *model, const double *q, double *gradient,
                                double *work) {
  (void)work;
  return points_force(model, point_all(model), q, gradient);
}

static double points_pass_tangent(const thrum_model *model, const double *q, double *gradient,
                                  double *hessian, double *work) {
  return points_tangent(model, point_all(model), q, gradient, hessian, work);
}

static void points_pass_tangent_vector(const thrum_model *model, const double *q, const double *v,
                                       double *product, double *work) {
  (void)work;
  points_tangent_vector(model, model->rank, q, v, product);
}

static double points_pass_force_part(const thrum_model *model, int64_t split, const double *q,
                                     double *gradient, double *work) {
  const point_range range = {NULL, 0, model->rank, split};
  (void)work;
  return points_force(model, range, q, gradient);
}

static void points_pass_tangent_vector_part(const thrum_model *model, int64_t split,
                                            const double *q, const double *v, double *product,
                                            double *work) {
  (void)work;
  points_tangent_vector(model, split, q, v, product);
}

PASS void points_pass_restrict(const thrum_model *model, int64_t split, const double *q,
                               double *restricted, double *work) {
  (void)work;
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_state at = point_strain(model, b, NULL, 0, split, q);
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      v8_store(restricted + 8 * (THRUM_POINT_ROWS * b + c), at.g.at[c]);
    sum = v8_add(sum, point_energy(&at));
  }
  restricted[8 * THRUM_POINT_ROWS * thrum_point_blocks(model)] = v8_sum(sum);
}

/* Linear terms come with a restriction. */
static double points_pass_restricted_gradient(const thrum_model *model, int64_t split,
                                              const double *restricted, const double *q,
                                              double *gradient, double *work) {
  const int64_t n = model->rank - split;
  double quadratic = 0;
  (void)work;
  for (int64_t i = 0; i < n; i++) {
    quadratic += 0.5 * model->omega2[split + i] * q[i] * q[i];
    gradient[i] = model->omega2[split + i] * q[i];
  }
  const double whole = points_force(model, point_left(model, split, restricted), q, gradient);
  return quadratic + (whole - restricted[8 * THRUM_POINT_ROWS * thrum_point_blocks(model)]);
}

static void points_pass_restricted_hessian(const thrum_model *model, int64_t split,
                                           const double *restricted, const double *q,
                                           double *hessian, double *work) {
  const int64_t n = model->rank - split;
  memset(hessian, 0, (size_t)(n * n) * sizeof *hessian);
  for (int64_t i = 0; i < n; i++)
    hessian[i * n + i] = model->omega2[split + i];
  points_tangent(model, point_left(model, split, restricted), q, NULL, hessian, work);
}

/* The passes over points of a kernel; it has no others. */
#define THRUM_POINTS_TABLE(kernel_id)                                                              \
  {                                                                                                \
    .id = kernel_id, .energy = points_pass_energy, .force = points_pass_force,                     \
    .forces = points_forces, .tangent = points_pass_tangent,                                       \
    .tangent_vector = points_pass_tangent_vector, .force_part = points_pass_force_part,            \
    .tangent_vector_part = points_pass_tangent_vector_part, .restrict_to = points_pass_restrict,   \
    .restricted_gradient = points_pass_restricted_gradient,                                        \
    .restricted_hessian = points_pass_restricted_hessian,                                          \
  }
