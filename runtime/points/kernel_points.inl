/* The passes over cubature points (core/polynomial/points.h), over vectors of 8 lanes, for a
 * file that has included core/polynomial/kernel_lanes.h. Lanes are the points of a block
 * throughout: a gradient sums its coordinates in ascending order; forces and tangents sum the nine
 * components, and then the blocks, in lanes, which are added at the end (a tangent's in each
 * block).
 *
 * Cost: a force takes 18 products and sums for each coordinate and point and reads each gradient
 * once from where it lies and once more from the cache nearest to it; a tangent 9 r (r + 8)/2 for
 * each point.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/polynomial/packed.h"
#include "core/polynomial/points.h"
#include "runtime/points/point_law.h"

/* Components that are summed at once: as many as leave registers for the loads. */
#ifndef POINT_SUMS
#define POINT_SUMS 3
#endif

/* Columns of a tangent that are summed at once. */
#ifndef POINT_COLUMNS
#define POINT_COLUMNS 4
#endif

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

/* The gradients of a block, packed in one of two precisions. */
typedef struct point_block {
  const double *at;
  const float *single; /* in place of `at` */
} point_block;

/* Block b; where the model is not packed it is gathered into the scratch first. */
INLINE point_block point_block_of(const thrum_model *model, int64_t b, double *work) {
  const int64_t at = THRUM_POINT_BLOCK * b * model->rank;
  point_block block = {work, NULL};
  if (!thrum_points_are_packed(model))
    thrum_points_gather(model, b, work);
  else if (model->packed)
    block.at = model->packed + at;
  else
    block.single = model->packed_single + at;
  return block;
}

/* The scratch behind a block. */
INLINE double *point_scratch(const thrum_model *model, double *work) {
  return work + THRUM_POINT_BLOCK * model->rank;
}

INLINE v8 point_load(point_block block, bool single, int64_t at) {
  return single ? v8_load_single(block.single + at) : v8_load(block.at + at);
}

/* G at the points of a block, of n coordinates from `first` on. */
INLINE void point_sums(point_block block, bool single, int64_t first, int64_t n, const double *q,
                       v8_matrix *g) {
  for (int c = 0; c < THRUM_POINT_ROWS; c += POINT_SUMS) {
    v8 sum[POINT_SUMS];
    for (int k = 0; k < POINT_SUMS; k++)
      sum[k] = v8_zero();
    for (int64_t i = 0; i < n; i++) {
      const v8 x = v8_set1(q[i]);
      const int64_t at = THRUM_POINT_BLOCK * (first + i) + 8 * c;
      for (int k = 0; k < POINT_SUMS; k++)
        sum[k] = v8_add(sum[k], v8_mul(point_load(block, single, at + 8 * k), x));
    }
    for (int k = 0; k < POINT_SUMS; k++)
      g->at[c + k] = sum[k];
  }
}

/* The same on top of held coordinates (NULL: none) at block b. */
PASS v8_matrix point_gather(point_block block, int64_t b, const double *held, int64_t first,
                            int64_t n, const double *q) {
  v8_matrix g;
  if (block.single)
    point_sums(block, true, first, n, q, &g);
  else
    point_sums(block, false, first, n, q, &g);
  for (int c = 0; c < THRUM_POINT_ROWS && held; c++)
    g.at[c] = v8_add(v8_load(held + 8 * (THRUM_POINT_ROWS * b + c)), g.at[c]);
  return g;
}

/* Strains and stresses at the points of a block. */
typedef struct point_state {
  v8_matrix g;
  v8_symmetric n, t, s; /* N, C:N, C:E; or of another law than Saint Venant-Kirchhoff's: */
  v8_matrix p;          /* stress and energy without their linear parts */
  v8 energy;
  v8_moduli m;
  thrum_law law;
  int64_t count;         /* of points in the lanes, */
  const int32_t *region; /* theirs where they have several laws, */
  const uint8_t *laws;   /* those of the regions, */
  const double *plastic; /* and what has flowed at them; NULL: nothing */
} point_state;

/* Prepares what points of another law or of several ones have at block b. */
INLINE void point_prepare(const thrum_model *model, int64_t b, point_state *at) {
  const int64_t left = model->point_count - 8 * b;
  at->count = left < 8 ? left : 8;
  if (at->law != THRUM_LAW_BY_REGION)
    return;
  at->region = model->point_region + 8 * b;
  at->laws = model->region_law;
}

/* Gradients and moduli in lanes, for laws that are evaluated point by point. */
PASS thrum_point_lanes point_lanes(const point_state *at, double *gradient) {
  thrum_point_lanes lanes = {.count = at->count, .gradient = gradient, .plastic = at->plastic};
  for (int64_t k = 0; k < at->count; k++)
    lanes.law[k] = at->region ? (thrum_law)at->laws[at->region[k]] : at->law;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    v8_store(gradient + 8 * c, at->g.at[c]);
  v8_store(lanes.lambda, at->m.lambda);
  v8_store(lanes.mu, at->m.mu);
  return lanes;
}

/* Stress and energy by another law. */
PASS void point_obey(point_state *at) {
  double gradient[THRUM_POINT_BLOCK], stress[THRUM_POINT_BLOCK], energy[8];
  const thrum_point_lanes lanes = point_lanes(at, gradient);
  thrum_point_law_stress(&lanes, energy, stress);
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    at->p.at[c] = v8_load(stress + 8 * c);
  at->energy = v8_load(energy);
}

/* Block b of a model of this law at the gradient g. */
INLINE point_state point_strain(const thrum_model *model, thrum_law law, int64_t b,
                                const v8_matrix *g) {
  point_state at = {.g = *g, .m = point_moduli(model, b), .law = thrum_block_law(model, law, b)};
  if (at.law != THRUM_LAW_STVK) {
    point_prepare(model, b, &at);
    at.plastic = model->point_plastic ? model->point_plastic + THRUM_POINT_BLOCK * b : NULL;
    point_obey(&at);
    return at;
  }
  at.n = v8_quadratic_strain(g);
  const v8_symmetric linear = v8_linear_strain(&at.g), strain = v8_plus(&linear, &at.n);
  at.t = v8_stress(at.m.lambda, at.m.mu, &at.n);
  at.s = v8_stress(at.m.lambda, at.m.mu, &strain);
  return at;
}

/* N : (S - T / 2). */
INLINE v8 point_energy(const point_state *at) {
  if (at->law != THRUM_LAW_STVK)
    return at->energy;
  const v8 half = v8_set1(-0.5);
  v8 x[6];
  for (int c = 0; c < 6; c++)
    x[c] = v8_mul(at->n.at[c], v8_add(at->s.at[c], v8_mul(half, at->t.at[c])));
  const v8 shear = v8_add(v8_add(x[3], x[4]), x[5]);
  return v8_add(v8_add(v8_add(x[0], x[1]), x[2]), v8_add(shear, shear));
}

/* T + G S. */
INLINE v8_matrix point_force(const point_state *at) {
  if (at->law != THRUM_LAW_STVK)
    return at->p;
  v8_matrix p;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    p.at[c] = v8_add(at->t.at[point_place[c]], v8_row_times(&at->g, &at->s, c / 3, c % 3));
  return p;
}

/* dP / dF of another law, 9 x 9 in lanes; not used for Saint Venant-Kirchhoff material. */
typedef struct point_tangent_law {
  double at[9 * THRUM_POINT_BLOCK];
} point_tangent_law;

/* Fills it where the law is another one. */
PASS void point_take_tangent(const point_state *at, point_tangent_law *tangent) {
  double gradient[THRUM_POINT_BLOCK];
  if (at->law == THRUM_LAW_STVK)
    return;
  const thrum_point_lanes lanes = point_lanes(at, gradient);
  thrum_point_law_tangent(&lanes, tangent->at);
}

/* The same times D. */
INLINE v8_matrix point_law_stiffness(const point_tangent_law *tangent, const v8_matrix *d) {
  v8_matrix p;
  for (int i = 0; i < THRUM_POINT_ROWS; i++) {
    const double *row = tangent->at + THRUM_POINT_BLOCK * i;
    p.at[i] = v8_mul(v8_load(row), d->at[0]);
    for (int j = 1; j < THRUM_POINT_ROWS; j++)
      p.at[i] = v8_add(p.at[i], v8_mul(v8_load(row + 8 * j), d->at[j]));
  }
  return p;
}

/* dP along D, of moduli, gradient and stress in all lanes. */
INLINE v8_matrix point_stiffness(const point_state *at, const point_tangent_law *tangent,
                                 const v8_matrix *d) {
  if (at->law != THRUM_LAW_STVK)
    return point_law_stiffness(tangent, d);
  const v8_moduli m = at->m;
  const v8_matrix *g = &at->g;
  const v8_symmetric *s = &at->s;
  const v8_symmetric dn = v8_mixed_strain(g, d), linear = v8_linear_strain(d);
  const v8_symmetric de = v8_plus(&linear, &dn);
  const v8_symmetric dt = v8_stress(m.lambda, m.mu, &dn), ds = v8_stress(m.lambda, m.mu, &de);
  v8_matrix p;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    p.at[c] = v8_add(v8_add(dt.at[point_place[c]], v8_row_times(d, s, c / 3, c % 3)),
                     v8_row_times(g, &ds, c / 3, c % 3));
  return p;
}

/* lanes (8 x n) += sum_c P_c G_c,i of n coordinates from `first` on. */
INLINE void point_add_lanes(point_block block, bool single, const v8_matrix *force, int64_t first,
                            int64_t n, double *lanes) {
  for (int64_t i = 0; i < n; i++) {
    const int64_t at = THRUM_POINT_BLOCK * (first + i);
    v8 sum = v8_mul(force->at[0], point_load(block, single, at));
    for (int c = 1; c < THRUM_POINT_ROWS; c++)
      sum = v8_add(sum, v8_mul(force->at[c], point_load(block, single, at + 8 * c)));
    v8_store(lanes + 8 * i, v8_add(v8_load(lanes + 8 * i), sum));
  }
}

PASS void point_scatter(point_block block, const v8_matrix *force, int64_t first, int64_t n,
                        double *lanes) {
  if (block.single)
    point_add_lanes(block, true, force, first, n, lanes);
  else
    point_add_lanes(block, false, force, first, n, lanes);
}

/* Eight vectors of lanes, each added up. */
INLINE v8 point_fold(const double *lanes) {
  return v8_sums(v8_load(lanes), v8_load(lanes + 8), v8_load(lanes + 16), v8_load(lanes + 24),
                 v8_load(lanes + 32), v8_load(lanes + 40), v8_load(lanes + 48),
                 v8_load(lanes + 56));
}

INLINE void point_clear_lanes(int64_t n, double *lanes) {
  memset(lanes, 0, (size_t)(8 * thrum_whole(n)) * sizeof *lanes);
}

/* to (n) += the lanes. */
PASS void point_add_up(int64_t n, const double *lanes, double *to) {
  for (int64_t i = 0; i < n; i += 8) {
    const v8 sum = v8_add(v8_load_range(to + i, 0, n - i), point_fold(lanes + 8 * i));
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
  thrum_law law;
} point_range;

/* The state of block b, with its gradients. */
INLINE point_state point_state_of(const thrum_model *model, point_block block, int64_t b,
                                  point_range range, const double *q) {
  const v8_matrix g = point_gather(block, b, range.held, range.first, range.n, q);
  return point_strain(model, range.law, b, &g);
}

PASS double points_value(const thrum_model *model, point_range range, const double *q,
                         double *work) {
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    const point_state at = point_state_of(model, block, b, range, q);
    sum = v8_add(sum, point_energy(&at));
  }
  return v8_sum(sum);
}

/* gradient (wanted) += the forces; returns V's nonlinear part. */
PASS double points_force(const thrum_model *model, point_range range, const double *q,
                         double *gradient, double *work) {
  double *lanes = point_scratch(model, work);
  point_clear_lanes(range.wanted, lanes);
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    const point_state at = point_state_of(model, block, b, range, q);
    const v8_matrix force = point_force(&at);
    sum = v8_add(sum, point_energy(&at));
    point_scatter(block, &force, range.first, range.wanted, lanes);
  }
  point_add_up(range.wanted, lanes, gradient);
  return v8_sum(sum);
}

/* The same at two points, from one read of the gradients. */
PASS void points_forces(const thrum_model *model, const double *const q[2],
                        double *const gradient[2], double value[2], double *work) {
  const int64_t rank = model->rank;
  const point_range range = {NULL, 0, rank, rank, thrum_law_of_model(model)};
  double *lanes[2] = {point_scratch(model, work)};
  lanes[1] = lanes[0] + 8 * thrum_whole(rank);
  v8 sum[2] = {v8_zero(), v8_zero()};
  for (int k = 0; k < 2; k++)
    point_clear_lanes(rank, lanes[k]);

  // each block at both
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    for (int k = 0; k < 2; k++) {
      const point_state at = point_state_of(model, block, b, range, q[k]);
      const v8_matrix force = point_force(&at);
      sum[k] = v8_add(sum[k], point_energy(&at));
      point_scatter(block, &force, 0, rank, lanes[k]);
    }
  }
  for (int k = 0; k < 2; k++) {
    point_add_up(rank, lanes[k], gradient[k]);
    value[k] = v8_sum(sum[k]);
  }
}

/* product (wanted) += T v, of v that is zero behind the wanted ones. */
PASS void points_tangent_vector(const thrum_model *model, int64_t wanted, const double *q,
                                const double *v, double *product, double *work) {
  const point_range range = {NULL, 0, model->rank, wanted, thrum_law_of_model(model)};
  double *lanes = point_scratch(model, work);
  point_tangent_law tangent;
  point_clear_lanes(wanted, lanes);
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    const point_state at = point_state_of(model, block, b, range, q);
    const v8_matrix d = point_gather(block, b, NULL, 0, wanted, v);
    point_take_tangent(&at, &tangent);
    const v8_matrix force = point_stiffness(&at, &tangent, &d);
    point_scatter(block, &force, 0, wanted, lanes);
  }
  point_add_up(wanted, lanes, product);
}

/* columns (8 x THRUM_POINT_BLOCK) = dP along the gradients of `count` coordinates from `first` on,
 * zero for the others. */
PASS void point_columns(point_block block, const point_state *at, const point_tangent_law *tangent,
                        int64_t first, int64_t count, double *columns) {
  for (int64_t j = 0; j < 8; j++, columns += THRUM_POINT_BLOCK) {
    v8_matrix p, d;
    for (int c = 0; c < THRUM_POINT_ROWS; c++) {
      const int64_t from = THRUM_POINT_BLOCK * (first + j) + 8 * c;
      d.at[c] = j >= count     ? v8_zero()
                : block.single ? point_load(block, true, from)
                               : point_load(block, false, from);
    }
    p = point_stiffness(at, tangent, &d);
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      v8_store(columns + 8 * c, p.at[c]);
  }
}

/* The products of one coordinate's gradients with eight columns, summed in lanes. */
INLINE v8 point_row(point_block block, bool single, int64_t i, const double *columns) {
  v8 g[THRUM_POINT_ROWS], sum[8];
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    g[c] = point_load(block, single, THRUM_POINT_BLOCK * i + 8 * c);
  for (int j = 0; j < 8; j += POINT_COLUMNS) {
    const double *from = columns + THRUM_POINT_BLOCK * j;
    for (int k = 0; k < POINT_COLUMNS; k++)
      sum[j + k] = v8_mul(g[0], v8_load(from + THRUM_POINT_BLOCK * k));
    for (int c = 1; c < THRUM_POINT_ROWS; c++)
      for (int k = 0; k < POINT_COLUMNS; k++)
        sum[j + k] =
            v8_add(sum[j + k], v8_mul(g[c], v8_load(from + THRUM_POINT_BLOCK * k + 8 * c)));
  }
  return v8_sums(sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7]);
}

/* Rows from j on of columns j to j + 7 of the hessian; those above the diagonal hold nothing. */
INLINE void point_square(point_block block, bool single, point_range range, int64_t j,
                         const double *columns, double *hessian) {
  const v8_mask mask = v8_range(0, range.n - j);
  for (int64_t i = j; i < range.n; i++) {
    double *row = hessian + i * range.n + j;
    const v8 sum = point_row(block, single, range.first + i, columns);
    v8_store_first(row, v8_add(v8_load_mask(row, mask), sum), range.n - j);
  }
}

/* hessian (n x n), its lower triangle, += T of one block. */
PASS void point_tangent(point_block block, const point_state *at, point_range range,
                        double *columns, double *hessian) {
  point_tangent_law tangent;
  point_take_tangent(at, &tangent);
  for (int64_t j = 0; j < range.n; j += 8) {
    point_columns(block, at, &tangent, range.first + j, range.n - j, columns);
    if (block.single)
      point_square(block, true, range, j, columns, hessian);
    else
      point_square(block, false, range, j, columns, hessian);
  }
}

/* hessian (n x n) += T; gradient (n), if not NULL, += the forces; returns V's nonlinear part. */
PASS double points_tangent(const thrum_model *model, point_range range, const double *q,
                           double *gradient, double *hessian, double *work) {
  double *lanes = point_scratch(model, work), *columns = lanes + 8 * thrum_whole(model->rank);
  point_clear_lanes(range.n, lanes);
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    const point_state at = point_state_of(model, block, b, range, q);
    sum = v8_add(sum, point_energy(&at));
    if (gradient) {
      const v8_matrix force = point_force(&at);
      point_scatter(block, &force, range.first, range.n, lanes);
    }
    point_tangent(block, &at, range, columns, hessian);
  }

  // both triangles from the lower one
  if (gradient)
    point_add_up(range.n, lanes, gradient);
  for (int64_t i = 0; i < range.n; i++)
    for (int64_t j = i + 1; j < range.n; j++)
      hessian[i * range.n + j] = hessian[j * range.n + i];
  return v8_sum(sum);
}

/* --- the table ---------------------------------------------------------------------------------
 */

static inline point_range point_all(const thrum_model *model) {
  const point_range range = {NULL, 0, model->rank, model->rank, thrum_law_of_model(model)};
  return range;
}

static inline point_range point_left(const thrum_model *model, int64_t split,
                                     const double *restricted) {
  const point_range range = {restricted, split, model->rank - split, model->rank - split,
                             thrum_law_of_model(model)};
  return range;
}

static double points_pass_energy(const thrum_model *model, const double *q, double *work) {
  return points_value(model, point_all(model), q, work);
}

static double points_pass_force(const thrum_model *model, const double *q, double *gradient,
                                double *work) {
  return points_force(model, point_all(model), q, gradient, work);
}

static double points_pass_tangent(const thrum_model *model, const double *q, double *gradient,
                                  double *hessian, double *work) {
  return points_tangent(model, point_all(model), q, gradient, hessian, work);
}

static void points_pass_tangent_vector(const thrum_model *model, const double *q, const double *v,
                                       double *product, double *work) {
  points_tangent_vector(model, model->rank, q, v, product, work);
}

static double points_pass_force_part(const thrum_model *model, int64_t split, const double *q,
                                     double *gradient, double *work) {
  const point_range range = {NULL, 0, model->rank, split, thrum_law_of_model(model)};
  return points_force(model, range, q, gradient, work);
}

static void points_pass_tangent_vector_part(const thrum_model *model, int64_t split,
                                            const double *q, const double *v, double *product,
                                            double *work) {
  points_tangent_vector(model, split, q, v, product, work);
}

PASS void points_pass_restrict(const thrum_model *model, int64_t split, const double *q,
                               double *restricted, double *work) {
  const point_range range = {NULL, 0, split, split, thrum_law_of_model(model)};
  v8 sum = v8_zero();
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const point_block block = point_block_of(model, b, work);
    const point_state at = point_state_of(model, block, b, range, q);
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
  for (int64_t i = 0; i < n; i++) {
    quadratic += 0.5 * model->omega2[split + i] * q[i] * q[i];
    gradient[i] = model->omega2[split + i] * q[i];
  }
  const double whole = points_force(model, point_left(model, split, restricted), q, gradient, work);
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
