/* Lays the coefficients of a model out for the passes of a kernel (thrum/model.h,
 * core/polynomial/packed.h), or its cubature points (core/polynomial/points.h). Cost: two
 * passes over c3 and c4, once for a model; of a small one up to 3 numbers more for each. One pass
 * over the gradients of points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "core/base/alignment_check.h"
#include "core/polynomial/packed.h"
#include "core/polynomial/points.h"
#include "thrum/polynomial.h"

/* Row d of block c from the file's order: its columns lie a row of c4 apart. */
static void gather(const thrum_model *model, int64_t c, int64_t d, double *row) {
  const int64_t n = model->rank;
  const double *c3 = model->c3 + thrum_c3_index(n, 0, c, d);
  for (int64_t b = 0; b <= c; b++) {
    const int64_t columns = (n - b) * (n - b + 1) / 2;
    const double *c4 = model->c4 + thrum_c4_index(n, 0, b, c, d);
    *row++ = c3[b * (n - c)];
    for (int64_t a = 0; a <= b; a++)
      *row++ = c4[a * columns];
  }
}

/* The same mirrored: there a row of c4 is one of ours, from its end to its beginning. */
static void gather_mirrored(const thrum_model *model, int64_t c, int64_t d, double *row) {
  const int64_t n = model->rank, i = n - 1 - d, j = n - 1 - c;
  const double *c3 = model->c3 + thrum_c3_index(n, i, j, n - 1);
  const double *c4 = model->c4 + thrum_c4_index(n, i, j, n - 1, n - 1);
  for (int64_t b = 0, k = 0; b <= c; b++) {
    *row++ = c3[-b];
    for (int64_t a = 0; a <= b; a++, k++)
      *row++ = c4[-k];
  }
}

/* Copies the numbers of one row, which lies at `at` in its group of `size` rows. */
static void take(const thrum_model *model, int64_t columns, int64_t size, int64_t at, double *row) {
  for (int64_t k = 0; k < columns; k++) {
    const int64_t here = at + 8 * size * (k / 8) + k % 8;
    row[k] = model->packed ? model->packed[here] : (double)model->packed_single[here];
  }
}

/* The columns of row t, counted from its block's first, of block c at `at`. */
static void take_row(const thrum_model *model, int64_t c, int64_t t, int64_t at, double *row) {
  const int64_t first = t / THRUM_PACK_ROWS * THRUM_PACK_ROWS;
  at += 8 * (first * thrum_pack_vectors(c) + (t - first));
  take(model, thrum_pack_columns(c), thrum_pack_size(model->rank - c, first), at, row);
}

void thrum_pack_row(const thrum_model *model, int64_t c, int64_t d, int64_t at, double *row) {
  if (thrum_is_packed(model))
    take_row(model, c, model->rank - 1 - d, at, row);
  else
    gather(model, c, d, row);
}

void thrum_pack_row_mirrored(const thrum_model *model, int64_t c, int64_t d, int64_t at,
                             double *row) {
  if (thrum_is_packed(model))
    take_row(model, c, d - c, model->packed_count + at, row);
  else
    gather_mirrored(model, c, d, row);
}

/* Places of the blocks in c3 and c4, and the number of columns of those of c4. */
typedef struct blocks {
  int64_t c3[THRUM_PAIRS_RANK_MOST], c4[THRUM_PAIRS_RANK_MOST], columns[THRUM_PAIRS_RANK_MOST];
} blocks;

static blocks blocks_of(int64_t n) {
  blocks at;
  // block j has j + 1 rows in both
  for (int64_t j = 0, c3 = 0, c4 = 0; j < n; j++) {
    at.c3[j] = c3;
    at.c4[j] = c4;
    at.columns[j] = thrum_pair_count(n - j);
    c3 += (j + 1) * (n - j);
    c4 += (j + 1) * at.columns[j];
  }
  return at;
}

static int64_t smaller(int64_t a, int64_t b) {
  return a < b ? a : b;
}

static int64_t larger(int64_t a, int64_t b) {
  return a < b ? b : a;
}

/* The factorials that the derivative by q_i q_j q_k q_l, i <= j <= k <= l, has of equal ones. */
static double factorials(int64_t i, int64_t j, int64_t k, int64_t l) {
  double times = i == j ? 2.0 : 1.0;
  times *= j != k ? 1.0 : i == j ? 3.0 : 2.0;
  times *= k != l ? 1.0 : j != k ? 2.0 : i == j ? 4.0 : 3.0;
  return times;
}

/* B of the pairs (d, c) and (b, a), from the places of the blocks. */
static double by_pairs(const thrum_model *model, const blocks *at, int64_t d, int64_t c, int64_t b,
                       int64_t a) {
  const int64_t i = smaller(a, c), l = larger(b, d);
  const int64_t j = smaller(larger(a, c), smaller(b, d)), k = larger(larger(a, c), smaller(b, d));
  if (j < 0)
    return 0.0;
  const double times = factorials(i, j, k, l) * (d == c ? 0.5 : 1.0) * (b == a ? 0.5 : 1.0);
  if (i < 0)
    return times * model->c3[at->c3[k] + j * (model->rank - k) + (l - k)];
  return times * model->c4[at->c4[j] + (i + 1) * at->columns[j] - at->columns[k] + (l - k)];
}

/* The columns (b, a), from <= a <= b, of row (d, c) of B, into row[a]. */
static void gather_run(const thrum_model *model, const blocks *at, int64_t d, int64_t c, int64_t b,
                       int64_t from, double *row) {
  if (c < 0) {
    for (int64_t a = from; a <= b; a++)
      row[a] = by_pairs(model, at, d, c, b, a);
    return;
  }

  // where a is none of the others, their order and factor stay for a run of them: before c, between
  // c and the next, behind d
  const int64_t e = smaller(b, d), l = larger(b, d), begin = larger(from, 0);
  const int64_t j = smaller(c, e), k = larger(c, e);
  const double times = factorials(-1, j, k, l) * (d == c ? 0.5 : 1.0);
  for (int64_t a = begin; a < c && a < b; a++)
    row[a] = times * model->c4[at->c4[j] + (a + 1) * at->columns[j] - at->columns[k] + (l - k)];
  for (int64_t a = larger(begin, c + 1); a < e; a++)
    row[a] = times * model->c4[at->c4[a] + (c + 1) * at->columns[a] - at->columns[e] + (l - e)];
  for (int64_t a = larger(begin, e + 1); a < b; a++)
    row[a] = times * model->c4[at->c4[e] + (c + 1) * at->columns[e] - at->columns[a] + (l - a)];

  // the places where a equals another index have factors of their own
  const int64_t equal[] = {-1, c, e, b};
  for (int n = 0; n < 4; n++)
    if (equal[n] >= from && equal[n] <= b)
      row[equal[n]] = by_pairs(model, at, d, c, b, equal[n]);
}

/* Row k of B from its group's columns on, from the file's order. */
static void gather_pairs(const thrum_model *model, int64_t k, double *row) {
  const int64_t n = model->rank, first = k / 8 * 8;
  const blocks at = blocks_of(n);
  int64_t d = 0, b = 0;
  while (thrum_pack_first(d + 1) <= k)
    d++;
  while (thrum_pack_first(b + 1) <= first)
    b++;
  const int64_t c = k - thrum_pack_first(d) - 1;
  for (int64_t a = first - thrum_pack_first(b) - 1; b < n; b++, a = -1)
    gather_run(model, &at, d, c, b, a, row + thrum_pack_first(b) + 1);
}

/* Place of row k of B; a group begins with its own columns. */
static int64_t pairs_row_at(int64_t n, int64_t k) {
  const int64_t first = k / 8 * 8;
  return thrum_pairs_at(n) + first * thrum_pairs_rows(n) - first * (first - 8) / 2 + 8 * (k % 8);
}

void thrum_pairs_row(const thrum_model *model, int64_t k, double *row) {
  const int64_t n = model->rank, rows = thrum_pairs_rows(n), first = k / 8 * 8;
  for (int64_t j = 0; j < rows; j++)
    row[j] = 0.0;
  if (thrum_is_packed(model))
    take(model, rows - first, 8, pairs_row_at(n, k), row + first);
  else if (k < thrum_pack_first(n))
    gather_pairs(model, k, row);
}

static bool all_single(const double *values, int64_t count) {
  for (int64_t k = 0; k < count; k++)
    if (!(fabs(values[k]) <= FLT_MAX) || (double)(float)values[k] != values[k])
      return false;
  return true;
}

static bool single_pays(const thrum_model *model) {
  if (thrum_has_points(model))
    return thrum_points_pack_count(model) * (int64_t)sizeof(double) > THRUM_POINTS_SINGLE_BYTES &&
           all_single(model->point_gradients, THRUM_POINT_ROWS * model->point_count * model->rank);
  return thrum_pack_count(model->rank) * (int64_t)sizeof(double) > THRUM_PACK_SINGLE_BYTES &&
         all_single(model->c3, model->c3_count) && all_single(model->c4, model->c4_count);
}

size_t thrum_model_pack_size(const thrum_model *model) {
  const int64_t count =
      thrum_has_points(model) ? thrum_points_pack_count(model) : thrum_pack_all(model->rank);
  return (size_t)count * sizeof(double);
}

/* Puts a row, `columns` long, into its group. */
static void place(const double *row, int64_t columns, int64_t size, int64_t at, double *to,
                  float *to_single) {
  for (int64_t k = 0; k < thrum_whole(columns); k++) {
    const int64_t here = at + 8 * size * (k / 8) + k % 8;
    const double value = k < columns ? row[k] : 0.0;
    if (to)
      to[here] = value;
    else
      to_single[here] = (float)value;
  }
}

/* All rows of B, of a model that is not packed yet. */
static void pack_pairs(const thrum_model *model, double *to) {
  double row[(THRUM_PAIRS_RANK_MOST * (THRUM_PAIRS_RANK_MOST + 3) / 2 + 7) / 8 * 8];
  const int64_t n = model->rank, rows = thrum_pairs_rows(n);
  for (int64_t k = 0; k < rows; k++) {
    const int64_t first = k / 8 * 8;
    thrum_pairs_row(model, k, row);
    place(row + first, rows - first, 8, pairs_row_at(n, k), to, NULL);
  }
}

/* Row t of block c of one of the orders. */
static void gather_downward(const thrum_model *model, int64_t c, int64_t t, double *row) {
  gather(model, c, model->rank - 1 - t, row);
}

static void gather_upward(const thrum_model *model, int64_t c, int64_t t, double *row) {
  gather_mirrored(model, c, c + t, row);
}

/* All blocks of one order from `at` on; returns where they end. */
static int64_t pack_order(const thrum_model *model,
                          void (*gather_row)(const thrum_model *, int64_t, int64_t, double *),
                          double *row, int64_t at, double *to, float *to_single) {
  const int64_t n = model->rank;
  for (int64_t c = 0; c < n; c++)
    for (int64_t first = 0; first < n - c; first += THRUM_PACK_ROWS) {
      const int64_t size = thrum_pack_size(n - c, first);
      for (int64_t r = 0; r < size; r++) {
        gather_row(model, c, first + r, row);
        place(row, thrum_pack_columns(c), size, at + 8 * r, to, to_single);
      }
      at += 8 * size * thrum_pack_vectors(c);
    }
  return at;
}

/* The gradient of coordinate i at point p, component c; 0 behind the last point. */
static double gradient_at(const thrum_model *model, int64_t p, int64_t c, int64_t i) {
  return p < model->point_count
             ? model->point_gradients[(THRUM_POINT_ROWS * p + c) * model->rank + i]
             : 0.0;
}

/* Block b of the file's order, from `at` on. */
static void place_points(const thrum_model *model, int64_t b, int64_t at, double *to,
                         float *to_single) {
  for (int64_t i = 0; i < model->rank; i++)
    for (int64_t c = 0; c < THRUM_POINT_ROWS; c++)
      for (int64_t lane = 0; lane < 8; lane++, at++) {
        const double value = gradient_at(model, 8 * b + lane, c, i);
        if (to)
          to[at] = value;
        else
          to_single[at] = (float)value;
      }
}

void thrum_points_gather(const thrum_model *model, int64_t b, double *to) {
  place_points(model, b, 0, to, NULL);
}

static void pack_points(thrum_model *model, double *to, float *to_single) {
  for (int64_t b = 0; b < thrum_point_blocks(model); b++)
    place_points(model, b, THRUM_POINT_BLOCK * b * model->rank, to, to_single);
  model->packed_gradients = model->point_gradients;
}

/* All blocks of both orders, and the products by pairs of a small rank. */
static void pack_coefficients(thrum_model *model, double *memory, double *to, float *to_single) {
  const int64_t n = model->rank;
  model->packed_count = thrum_pack_count(n);

  // a row is gathered where no packed one has been placed yet: at the end of the second order
  double *row = memory + 2 * model->packed_count - 8 * thrum_pack_vectors(n - 1);
  const int64_t at = pack_order(model, gather_downward, row, 0, to, to_single);
  pack_order(model, gather_upward, row, at, to, to_single);
  if (thrum_pairs_count(n) > 0)
    pack_pairs(model, to);
  model->packed_c3 = model->c3;
  model->packed_c4 = model->c4;
}

thrum_status thrum_model_pack(thrum_model *model, void *memory, size_t memory_size,
                              thrum_error *error) {
  // the arguments and the memory
  if (!model || !memory || !((model->c3 && model->c4) || thrum_has_points(model)) ||
      model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model or memory is NULL, or the model has no rank, or neither c3 "
                           "and c4 nor cubature points");
  if ((uintptr_t)memory % THRUM_ALIGNMENT != 0)
    return thrum_error_set(error, THRUM_MISALIGNED,
                           "the memory of packed coefficients must be aligned to 64 bytes");
  if (memory_size < thrum_model_pack_size(model))
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the memory has %zu bytes, the packed coefficients need %zu",
                           memory_size, thrum_model_pack_size(model));

  // half the width where every coefficient survives it, which the kernels read faster
  const bool single = single_pays(model);
  model->packed = NULL;
  model->packed_single = NULL;
  double *to = single ? NULL : memory;
  float *to_single = single ? memory : NULL;
  if (thrum_has_points(model))
    pack_points(model, to, to_single);
  else
    pack_coefficients(model, memory, to, to_single);
  model->packed = to;
  model->packed_single = to_single;
  return THRUM_OK;
}
