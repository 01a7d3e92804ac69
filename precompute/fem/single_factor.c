/* Sparse Cholesky factors in single precision, see single_factor.h. The algorithm is the
 * left-looking supernodal one of CHOLMOD (Chen, Davis, Hager, Rajamanickam 2008,
 * doi:10.1145/1391989.1391995), whose version in Debian knows double precision alone. Supernodes
 * are cut into panels, so that the half of a diagonal block that is not used stays small.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/single_factor.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define TOGETHER 32 /* columns that a solve takes through the factor in one pass */
#define PANEL 256   /* columns: deep enough for SGEMM at its best */

// a part of a supernode: `width` columns from `first` on, stored column-major, `height` rows each
typedef struct panel {
  int64_t first, width, height;
  const int64_t *row; /* height */
  float *value;       /* height x width */
  int64_t done;       /* rows of it that later panels have used already */
  int64_t next;       /* in the list of those that wait for the same panel; -1: the last one */
} panel;

struct thrum_single_factor {
  int64_t size, count;
  const int64_t *order;
  panel *panels;
  int32_t *owner; /* n: the panel of a column */
  float *value;
  float *scale;         /* n, diagonal of S in the order of L */
  float *work, *update; /* of a solve: n x its columns, and of one panel */
  int64_t work_columns; /* that both hold */
  int64_t height_max;
};

// columns of A in the order of L, the lower triangle
typedef struct permuted {
  int64_t *begin; /* n + 1 */
  int32_t *row;
  float *value;
} permuted;

static int64_t panels_of(int64_t width) {
  return (width + PANEL - 1) / PANEL;
}

int64_t thrum_single_factor_entries(const thrum_supernodes *pattern) {
  int64_t entries = 0;
  for (int64_t s = 0; s < pattern->count; s++) {
    const int64_t width = pattern->first[s + 1] - pattern->first[s];
    const int64_t rows = pattern->begin[s + 1] - pattern->begin[s], pieces = panels_of(width);
    for (int64_t i = 0; i < pieces; i++)
      entries += (width * (i + 1) / pieces - width * i / pieces) * (rows - width * i / pieces);
  }
  return entries;
}

// the panels of all supernodes, and what they need
static thrum_status cut_panels(const thrum_supernodes *pattern, thrum_single_factor *f,
                               thrum_error *error) {
  for (int64_t s = 0; s < pattern->count; s++)
    f->count += panels_of(pattern->first[s + 1] - pattern->first[s]);

  if (!(f->panels = thrum_allocate(f->count, sizeof *f->panels, "the factor", error)) ||
      !(f->owner = thrum_allocate(f->size, sizeof *f->owner, "the factor", error)) ||
      !(f->scale = thrum_allocate(f->size, sizeof *f->scale, "the factor", error)) ||
      !(f->value = thrum_allocate(thrum_single_factor_entries(pattern), sizeof *f->value,
                                  "the factor", error)))
    return THRUM_OUT_OF_MEMORY;

  // panels follow each other in memory as their columns do
  float *value = f->value;
  int64_t next = 0;
  for (int64_t s = 0; s < pattern->count; s++) {
    const int64_t width = pattern->first[s + 1] - pattern->first[s];
    const int64_t rows = pattern->begin[s + 1] - pattern->begin[s], pieces = panels_of(width);
    for (int64_t i = 0; i < pieces; i++, next++) {
      const int64_t from = width * i / pieces, to = width * (i + 1) / pieces;
      f->panels[next] = (panel){.first = pattern->first[s] + from,
                                .width = to - from,
                                .height = rows - from,
                                .row = pattern->row + pattern->begin[s] + from,
                                .value = value,
                                .next = -1};
      value += (to - from) * (rows - from);
      f->height_max = rows - from > f->height_max ? rows - from : f->height_max;
      for (int64_t c = from; c < to; c++)
        f->owner[pattern->first[s] + c] = (int32_t)next;
    }
  }
  return THRUM_OK;
}

static void permuted_free(permuted *p) {
  free(p->begin);
  free(p->row);
  free(p->value);
}

// S A S in the order of L, by counting
static thrum_status permute(const thrum_sparse *matrix, thrum_single_factor *f, permuted *p,
                            thrum_error *error) {
  const int64_t n = f->size, entries = matrix->begin[n];
  int32_t *place = thrum_allocate(n, sizeof *place, "the factor", error);
  if (!place || !(p->begin = thrum_allocate(n + 2, sizeof *p->begin, "the factor", error)) ||
      !(p->row = thrum_allocate(entries, sizeof *p->row, "the factor", error)) ||
      !(p->value = thrum_allocate(entries, sizeof *p->value, "the factor", error))) {
    free(place);
    return THRUM_OUT_OF_MEMORY;
  }

  // where each row of A stands in L, and the scale of its diagonal
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < n; i++) {
    const double diagonal = matrix->value[matrix->begin[f->order[i]]];
    place[f->order[i]] = (int32_t)i;
    f->scale[i] = (float)(1 / sqrt(diagonal));
    if (!(diagonal > 0) || !isfinite(f->scale[i]) || !(f->scale[i] > 0))
      status = thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
  }

  // an entry goes to the column that comes first in L: count, then fill
  memset(p->begin, 0, sizeof *p->begin * (size_t)(n + 2));
  for (int pass = 0; pass < 2 && status >= 0; pass++) {
    for (int64_t j = 0; j < n; j++)
      for (int64_t e = matrix->begin[j]; e < matrix->begin[j + 1]; e++) {
        const int32_t a = place[j], b = place[matrix->row[e]];
        const int32_t column = a < b ? a : b, row = a < b ? b : a;
        if (pass == 0) {
          p->begin[column + 2]++;
          continue;
        }
        const int64_t at = p->begin[column + 1]++;
        p->row[at] = row;
        p->value[at] = (float)(matrix->value[e] * (double)f->scale[row] * (double)f->scale[column]);
      }
    for (int64_t j = 0; j < n && pass == 0; j++)
      p->begin[j + 2] += p->begin[j + 1];
  }

  free(place);
  return status;
}

// what an earlier panel takes from this one: target -= its rows from `done` on times those in the
// columns of the target
static void subtract(const panel *from, int64_t done, int64_t used, const int32_t *local,
                     panel *target, float *update) {
  const int64_t height = from->height - done;
  const int h = (int)height, u = (int)used, w = (int)from->width, ld = (int)from->height;
  const float *rows = from->value + done;
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, h, u, w, 1, rows, ld, rows, ld, 0, update,
              h);

  // the rows of the update are some of those of the target
  for (int64_t c = 0; c < used; c++) {
    float *column = target->value + (from->row[done + c] - target->first) * target->height;
    const float *values = update + c * height;
    const int64_t *row = from->row + done;
    for (int64_t i = c; i < height; i++)
      column[local[row[i]]] -= values[i];
  }
}

// the numbers of one panel, from A and from the panels before it that wait for it
static thrum_status compute_panel(thrum_single_factor *f, const permuted *a, int64_t index,
                                  int64_t *waiting, int32_t *local, float *update,
                                  thrum_error *error) {
  panel *target = &f->panels[index];
  for (int64_t i = 0; i < target->height; i++)
    local[target->row[i]] = (int32_t)i;

  // the entries of A
  memset(target->value, 0, sizeof(float) * (size_t)(target->height * target->width));
  for (int64_t c = 0; c < target->width; c++)
    for (int64_t e = a->begin[target->first + c]; e < a->begin[target->first + c + 1]; e++)
      target->value[c * target->height + local[a->row[e]]] = a->value[e];

  // each panel that has rows among these columns, and then waits for the next one that it reaches
  for (int64_t d = waiting[index], next; d >= 0; d = next) {
    panel *from = &f->panels[d];
    next = from->next;
    int64_t used = 0;
    while (from->done + used < from->height &&
           from->row[from->done + used] < target->first + target->width)
      used++;
    subtract(from, from->done, used, local, target, update);
    from->done += used;
    if (from->done < from->height) {
      const int32_t owner = f->owner[from->row[from->done]];
      from->next = waiting[owner];
      waiting[owner] = d;
    }
  }

  // the dense factor of the diagonal block, and the rows below
  const int w = (int)target->width, ld = (int)target->height, below = ld - w;
  const int info = LAPACKE_spotrf_work(LAPACK_COL_MAJOR, 'L', w, target->value, ld);
  if (info != 0)
    return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
  if (below == 0)
    return THRUM_OK;
  cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, below, w, 1,
              target->value, ld, target->value + w, ld);

  // it waits for the panel of its first row below
  target->done = w;
  const int32_t owner = f->owner[target->row[w]];
  target->next = waiting[owner];
  waiting[owner] = index;
  return THRUM_OK;
}

static thrum_status compute(const thrum_sparse *matrix, thrum_single_factor *f,
                            thrum_error *error) {
  permuted a = {0};
  thrum_scope memory = thrum_scope_begin("the factor", error);
  int64_t *waiting = thrum_scope_allocate(&memory, f->count, sizeof *waiting);
  int32_t *local = thrum_scope_allocate(&memory, f->size, sizeof *local);
  float *update = thrum_scope_allocate(&memory, f->height_max * PANEL, sizeof *update);
  thrum_status status = memory.status;
  THRUM_THEN(status, permute(matrix, f, &a, error));

  // panels in order; waiting: the first panel that waits for each, -1 none
  for (int64_t p = 0; p < f->count && status >= 0; p++)
    waiting[p] = -1;
  for (int64_t p = 0; p < f->count && status >= 0; p++)
    status = compute_panel(f, &a, p, waiting, local, update, error);

  permuted_free(&a);
  thrum_scope_free(&memory);
  return status;
}

thrum_status thrum_single_factor_create(const thrum_supernodes *pattern, const thrum_sparse *matrix,
                                        thrum_single_factor **factor, thrum_error *error) {
  thrum_single_factor *made = calloc(1, sizeof *made);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a sparse factor");
  made->size = pattern->size;
  made->order = pattern->order;

  thrum_status status = cut_panels(pattern, made, error);
  THRUM_THEN(status, compute(matrix, made, error));
  if (status >= 0)
    *factor = made;
  else
    thrum_single_factor_free(made);
  return status;
}

// room for the columns of a solve, kept for the next one
static thrum_status reserve(thrum_single_factor *f, int64_t columns, thrum_error *error) {
  if (columns <= f->work_columns)
    return THRUM_OK;
  free(f->work);
  free(f->update);
  f->work_columns = 0;
  f->work = thrum_allocate(f->size * columns, sizeof *f->work, "the solution", error);
  f->update = thrum_allocate(f->height_max * columns, sizeof *f->update, "the solution", error);
  if (!f->work || !f->update)
    return THRUM_OUT_OF_MEMORY;
  f->work_columns = columns;
  return THRUM_OK;
}

// L x = b; the columns of a row stand together, so BLAS sees the transposed matrix x^T
static void forward(thrum_single_factor *f, int columns) {
  for (int64_t p = 0; p < f->count; p++) {
    const panel *at = &f->panels[p];
    const int w = (int)at->width, ld = (int)at->height, below = ld - w;
    float *own = f->work + at->first * columns;
    cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, columns, w, 1,
                at->value, ld, own, columns);

    // what these unknowns take from the rows below
    if (below > 0)
      cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, columns, below, w, 1, own, columns,
                  at->value + w, ld, 0, f->update, columns);
    for (int i = 0; i < below; i++) {
      float *row = f->work + at->row[w + i] * columns;
      for (int c = 0; c < columns; c++)
        row[c] -= f->update[i * (int64_t)columns + c];
    }
  }
}

// L^T x = b
static void backward(thrum_single_factor *f, int columns) {
  for (int64_t p = f->count - 1; p >= 0; p--) {
    const panel *at = &f->panels[p];
    const int w = (int)at->width, ld = (int)at->height, below = ld - w;
    float *own = f->work + at->first * columns;

    // what the rows below take from these unknowns
    for (int i = 0; i < below; i++)
      memcpy(f->update + i * (int64_t)columns, f->work + at->row[w + i] * columns,
             sizeof(float) * (size_t)columns);
    if (below > 0)
      cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, columns, w, below, -1, f->update,
                  columns, at->value + w, ld, 1, own, columns);
    cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasNoTrans, CblasNonUnit, columns, w, 1,
                at->value, ld, own, columns);
  }
}

thrum_status thrum_single_factor_solve(thrum_single_factor *f, const double *right, int64_t columns,
                                       double *solution, thrum_error *error) {
  const int64_t n = f->size;
  THRUM_TRY(reserve(f, columns < TOGETHER ? columns : TOGETHER, error));

  // each column is brought to unit size, which keeps it in the range of single precision
  double unit[TOGETHER] = {0};
  for (int64_t first = 0; first < columns; first += TOGETHER) {
    const int64_t width = columns - first < TOGETHER ? columns - first : TOGETHER;
    const double *from = right + first * n;
    double *to = solution + first * n;

    for (int64_t c = 0; c < width; c++) {
      double largest = 0;
      for (int64_t i = 0; i < n; i++)
        largest = fmax(largest, fabs(from[c * n + f->order[i]]) * (double)f->scale[i]);
      unit[c] = largest > 0 ? largest : 1;
    }
    for (int64_t i = 0; i < n; i++)
      for (int64_t c = 0; c < width; c++)
        f->work[i * width + c] = (float)(from[c * n + f->order[i]] * (double)f->scale[i] / unit[c]);

    forward(f, (int)width);
    backward(f, (int)width);

    for (int64_t i = 0; i < n; i++)
      for (int64_t c = 0; c < width; c++)
        to[c * n + f->order[i]] = unit[c] * (double)f->scale[i] * (double)f->work[i * width + c];
  }
  return THRUM_OK;
}

void thrum_single_factor_free(thrum_single_factor *factor) {
  if (!factor)
    return;
  free(factor->panels);
  free(factor->owner);
  free(factor->scale);
  free(factor->value);
  free(factor->work);
  free(factor->update);
  free(factor);
}
