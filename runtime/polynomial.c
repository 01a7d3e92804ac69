/* The reduced strain energy V(q), its gradient R, its Hessian T and T v, design (1).
 *
 * Coefficients lie in blocks over j (thrum/model.h): block j of c4 is a matrix B with rows i <= j
 * and columns (k,l), j <= k <= l. With x_i = q_i q_j and m_kl = q_k q_l its share of V is x^T B m,
 * so one pass that forms y = B m and adds B^T x to w gives the energy x^T y and both halves of the
 * gradient: R_i += q_j y_i,  R_j += q_i y_i,  and once at the end  R_k += w_kl q_l,  R_l += w_kl
 * q_k. Block j of c3 is the same with columns k and m = q. T v is the derivative of that along v.
 * For T the second derivatives of x and m meet y and w; the mixed ones are X + X^T, where row a of
 * X is the pair gradient of G_a = sum_i q_i B_ia + sum_j q_j B_aj. Cost: rank^4/24 coefficients, 2
 * (V), 4 (R), 8 (T v) or 6 (T) operations each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "polynomial.h"

#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

int64_t thrum_c3_index(int64_t rank, int64_t i, int64_t j, int64_t k) {
  int64_t block = 0;
  for (int64_t t = 0; t < j; t++)
    block += (t + 1) * (rank - t);
  return block + i * (rank - j) + (k - j);
}

int64_t thrum_c4_index(int64_t rank, int64_t i, int64_t j, int64_t k, int64_t l) {
  int64_t block = 0;
  for (int64_t t = 0; t < j; t++)
    block += (t + 1) * thrum_pair_count(rank - t);
  int64_t columns = thrum_pair_count(rank - j);
  return block + i * columns + (columns - thrum_pair_count(rank - k)) + (l - k);
}

size_t thrum_work_count(const thrum_model *model) {
  return (size_t)(4 * thrum_pair_count(model->rank) + 4 * model->rank);
}

/* The cubic and quartic terms of a polynomial in n coordinates. c4 starts at its block 0; each of
 * its blocks is preceded by `skip` rows that belong to coordinates held elsewhere. */
typedef struct form {
  int64_t n;
  const double *c3;
  const double *c4;
  int64_t skip;
} form;

static form form_of_model(const thrum_model *model) {
  return (form){model->rank, model->c3, model->c4, 0};
}

/* x_i = q_i q_j for i <= j. */
static void row_monomials(int64_t j, const double *q, double *x) {
  for (int64_t i = 0; i <= j; i++)
    x[i] = q[i] * q[j];
}

/* Value of the form at q. */
static double form_value(const form *f, const double *q, double *work) {
  int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *x = m + pairs, *y = x + n, value = 0;
  const double *c3 = f->c3, *c4 = f->c4;
  thrum_pair_monomials(n, q, m);
  for (int64_t j = 0; j < n; j++) {
    int64_t rows = j + 1, columns = thrum_pair_count(n - j);
    row_monomials(j, q, x);
    memset(y, 0, (size_t)rows * sizeof *y);
    thrum_kernel_product(rows, n - j, c3, q + j, y);
    c4 += f->skip * columns;
    thrum_kernel_product(rows, columns, c4, m + (pairs - columns), y);
    value += thrum_kernel_dot(rows, x, y);
    c3 += rows * (n - j);
    c4 += rows * columns;
  }
  return value;
}

/* gradient += grad of the form at q; returns its value, the same bits as form_value. */
static double form_gradient(const form *f, const double *q, double *gradient, double *work) {
  int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *w = m + pairs, *x = w + pairs, *y = x + n, value = 0;
  const double *c3 = f->c3, *c4 = f->c4;
  thrum_pair_monomials(n, q, m);
  memset(w, 0, (size_t)pairs * sizeof *w);
  for (int64_t j = 0; j < n; j++) {
    int64_t rows = j + 1, columns = thrum_pair_count(n - j), first = pairs - columns;
    row_monomials(j, q, x);
    memset(y, 0, (size_t)rows * sizeof *y);
    // the columns of c3 are single coordinates: their w is the gradient itself
    thrum_kernel_both(rows, n - j, c3, q + j, x, y, gradient + j);
    c4 += f->skip * columns;
    thrum_kernel_both(rows, columns, c4, m + first, x, y, w + first);
    value += thrum_kernel_dot(rows, x, y);
    thrum_kernel_axpy(rows, q[j], y, gradient);
    gradient[j] += thrum_kernel_dot(rows, q, y);
    c3 += rows * (n - j);
    c4 += rows * columns;
  }
  thrum_pair_gradient(n, w, q, gradient);
  return value;
}

/* g += sum_{j>=a} q_j (row a of block j), over the columns of c3 and of c4 from a on. Starts with
 * block a at c3 and c4. */
static void add_rows(const form *f, int64_t a, const double *c3, const double *c4, const double *q,
                     double *g3, double *g4) {
  int64_t n = f->n, pairs = thrum_pair_count(n);
  for (int64_t j = a; j < n; j++) {
    int64_t columns = thrum_pair_count(n - j);
    c4 += f->skip * columns;
    thrum_kernel_axpy(n - j, q[j], c3 + a * (n - j), g3 + j);
    thrum_kernel_axpy(columns, q[j], c4 + a * columns, g4 + (pairs - columns));
    c3 += (j + 1) * (n - j);
    c4 += (j + 1) * columns;
  }
}

/* tangent += Hessian of the form at q. On entry tangent must be symmetric. */
static void form_hessian(const form *f, const double *q, double *tangent, double *work) {
  int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *w = m + pairs, *g4 = w + pairs, *g3 = g4 + pairs, *y = g3 + n;
  const double *c3 = f->c3, *c4 = f->c4;
  thrum_pair_monomials(n, q, m);
  memset(w, 0, (size_t)pairs * sizeof *w);
  // half of T now, T = half + half^T at the end
  for (int64_t t = 0; t < n * n; t++)
    tangent[t] *= 0.5;
  for (int64_t a = 0; a < n; a++) {
    int64_t rows = a + 1, columns = thrum_pair_count(n - a), first = pairs - columns;
    memset(y, 0, (size_t)rows * sizeof *y);
    memset(g3 + a, 0, (size_t)(n - a) * sizeof *g3);
    memset(g4 + first, 0, (size_t)columns * sizeof *g4);
    thrum_kernel_both(rows, n - a, c3, q + a, q, y, g3 + a);
    const double *block = c4 + f->skip * columns;
    thrum_kernel_both(rows, columns, block, m + first, q, y, g4 + first);
    // w = sum_j q_j sum_i q_i B_ij, before the rows of later blocks are added
    thrum_kernel_axpy(columns, q[a], g4 + first, w + first);
    // y_ia is the coefficient of q_i q_a: once off the diagonal, twice (half + half^T) on it
    for (int64_t i = 0; i < rows; i++)
      tangent[i * n + a] += y[i];
    add_rows(f, a, c3, c4, q, g3, g4);
    for (int64_t k = a; k < n; k++)
      tangent[a * n + k] += g3[k];
    thrum_pair_gradient(n - a, g4 + first, q + a, tangent + a * n + a);
    c3 += rows * (n - a);
    c4 = block + rows * columns;
  }
  const double *pair = w;
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      tangent[k * n + l] += *pair++;
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      tangent[k * n + l] = tangent[l * n + k] = tangent[k * n + l] + tangent[l * n + k];
}

double thrum_energy(const thrum_model *model, const double *q, double *work) {
  double quadratic = 0;
  for (int64_t i = 0; i < model->rank; i++)
    quadratic += 0.5 * model->omega2[i] * q[i] * q[i];
  form f = form_of_model(model);
  return quadratic + form_value(&f, q, work);
}

double thrum_force(const thrum_model *model, const double *q, double *force, double *work) {
  double quadratic = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    quadratic += 0.5 * model->omega2[i] * q[i] * q[i];
    force[i] = model->omega2[i] * q[i];
  }
  form f = form_of_model(model);
  return quadratic + form_gradient(&f, q, force, work);
}

void thrum_tangent(const thrum_model *model, const double *q, double *tangent, double *work) {
  int64_t n = model->rank;
  memset(tangent, 0, (size_t)(n * n) * sizeof *tangent);
  for (int64_t i = 0; i < n; i++)
    tangent[i * n + i] = model->omega2[i];
  form f = form_of_model(model);
  form_hessian(&f, q, tangent, work);
}

void thrum_tangent_vector(const thrum_model *model, const double *q, const double *v,
                          double *product, double *work) {
  int64_t n = model->rank, pairs = thrum_pair_count(n);
  double *m = work, *dm = m + pairs, *w = dm + pairs, *dw = w + pairs;
  double *x = dw + pairs, *dx = x + n, *y = dx + n, *dy = y + n;
  const double *c3 = model->c3, *c4 = model->c4;
  thrum_pair_monomials(n, q, m);
  for (int64_t k = 0, t = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      dm[t++] = v[k] * q[l] + q[k] * v[l];
  memset(w, 0, (size_t)(2 * pairs) * sizeof *w);
  for (int64_t i = 0; i < n; i++)
    product[i] = model->omega2[i] * v[i];
  // every line is the derivative along v of a line of form_gradient
  for (int64_t j = 0; j < n; j++) {
    int64_t rows = j + 1, columns = thrum_pair_count(n - j), first = pairs - columns;
    row_monomials(j, q, x);
    for (int64_t i = 0; i < rows; i++)
      dx[i] = v[i] * q[j] + q[i] * v[j];
    memset(y, 0, (size_t)(2 * n) * sizeof *y);
    thrum_kernel_product(rows, n - j, c3, q + j, y);
    thrum_kernel_both(rows, n - j, c3, v + j, dx, dy, product + j);
    thrum_kernel_both_twice(rows, columns, c4, (const double *[]){m + first, dm + first},
                            (const double *[]){x, dx}, (double *[]){y, dy},
                            (double *[]){w + first, dw + first});
    thrum_kernel_axpy(rows, v[j], y, product);
    thrum_kernel_axpy(rows, q[j], dy, product);
    product[j] += thrum_kernel_dot(rows, v, y) + thrum_kernel_dot(rows, q, dy);
    c3 += rows * (n - j);
    c4 += rows * columns;
  }
  thrum_pair_gradient(n, w, v, product);
  thrum_pair_gradient(n, dw, q, product);
}

/* The cubic and quartic part of a restricted polynomial. */
static form form_of_restricted(const thrum_model *model, int32_t split, const double *restricted) {
  int64_t n = model->rank - split;
  // block `split` of c4 starts where the blocks before it end; its first `split` rows are skipped
  int64_t start = n ? thrum_c4_index(model->rank, 0, split, split, split) : 0;
  return (form){n, restricted + n + thrum_pair_count(n), model->c4 + start, split};
}

double thrum_restricted_gradient(const thrum_model *model, int32_t split, const double *restricted,
                                 const double *q_high, double *gradient, double *work) {
  form f = form_of_restricted(model, split, restricted);
  const double *linear = restricted, *quadratic = restricted + f.n;
  memset(gradient, 0, (size_t)f.n * sizeof *gradient);
  thrum_pair_gradient(f.n, quadratic, q_high, gradient);
  double value = 0;
  for (int64_t i = 0; i < f.n; i++) {
    // a quadratic form is half its gradient times q
    value += (linear[i] + 0.5 * gradient[i]) * q_high[i];
    gradient[i] += linear[i];
  }
  return value + form_gradient(&f, q_high, gradient, work);
}

void thrum_restricted_hessian(const thrum_model *model, int32_t split, const double *restricted,
                              const double *q_high, double *hessian, double *work) {
  form f = form_of_restricted(model, split, restricted);
  const double *quadratic = restricted + f.n;
  memset(hessian, 0, (size_t)(f.n * f.n) * sizeof *hessian);
  for (int64_t k = 0; k < f.n; k++)
    for (int64_t l = k; l < f.n; l++) {
      hessian[k * f.n + l] += *quadratic;
      hessian[l * f.n + k] += *quadratic++;
    }
  form_hessian(&f, q_high, hessian, work);
}
