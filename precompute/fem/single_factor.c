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
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define TOGETHER 32 /* columns that a solve takes through the factor in one pass */
#define PANEL 256   /* columns: deep enough for SGEMM at its best */
#define REACH 512   /* columns of a product: many to one copy of what is multiplied */
#define CORNER 64   /* columns of a triangle that STRSM solves at once: it is slow on larger ones */

// a part of a supernode: `width` columns from `first` on, stored column-major, `height` rows each
typedef struct panel {
  int64_t first, width, height;
  const int64_t *row; /* height */
  float *value;       /* height x width */
} panel;

// columns with the same rows below them
typedef struct supernode {
  int64_t first, width, height;
  const int64_t *row; /* height */
  panel *panels;
  int64_t count; /* of panels */
  int64_t done;  /* rows of it that later supernodes have used already */
  int64_t next;  /* in the list of those that wait for the same supernode; -1: the last one */
} supernode;

struct thrum_single_factor {
  thrum_scope memory; /* of the arrays but those of a solve */
  int64_t size, count, panel_count;
  const int64_t *order;
  supernode *nodes; /* count */
  panel *panels;    /* panel_count */
  int32_t *owner;   /* n: the supernode of a column */
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

// the panels of one supernode, whose numbers follow each other in memory as their columns do
static float *cut(const supernode *node, float *value) {
  for (int64_t i = 0; i < node->count; i++) {
    const int64_t from = node->width * i / node->count, to = node->width * (i + 1) / node->count;
    node->panels[i] = (panel){.first = node->first + from,
                              .width = to - from,
                              .height = node->height - from,
                              .row = node->row + from,
                              .value = value};
    value += (to - from) * (node->height - from);
  }
  return value;
}

// all supernodes with their panels, and what they need
static thrum_status cut_panels(const thrum_supernodes *pattern, thrum_single_factor *f) {
  f->count = pattern->count;
  for (int64_t s = 0; s < f->count; s++)
    f->panel_count += panels_of(pattern->first[s + 1] - pattern->first[s]);

  // the panels of all supernodes follow each other in one array
  const int64_t entries = thrum_single_factor_entries(pattern);
  f->nodes = thrum_scope_allocate(&f->memory, f->count, sizeof *f->nodes);
  f->panels = thrum_scope_allocate(&f->memory, f->panel_count, sizeof *f->panels);
  f->owner = thrum_scope_allocate(&f->memory, f->size, sizeof *f->owner);
  f->scale = thrum_scope_allocate(&f->memory, f->size, sizeof *f->scale);
  f->value = thrum_scope_allocate(&f->memory, entries, sizeof *f->value);
  THRUM_TRY(f->memory.status);

  // each supernode takes its panels and values from what is left, and owns its columns
  float *value = f->value;
  panel *next = f->panels;
  for (int64_t s = 0; s < f->count; s++) {
    supernode *node = &f->nodes[s];
    *node = (supernode){.first = pattern->first[s],
                        .width = pattern->first[s + 1] - pattern->first[s],
                        .height = pattern->begin[s + 1] - pattern->begin[s],
                        .row = pattern->row + pattern->begin[s],
                        .panels = next,
                        .next = -1};
    node->count = panels_of(node->width);
    value = cut(node, value);
    next += node->count;

    f->height_max = node->height > f->height_max ? node->height : f->height_max;
    for (int64_t c = 0; c < node->width; c++)
      f->owner[node->first + c] = (int32_t)s;
  }
  return THRUM_OK;
}

// S A S in the order of L, by counting
static thrum_status permute(const thrum_sparse *matrix, thrum_single_factor *f, permuted *p,
                            thrum_scope *memory) {
  const int64_t n = f->size, entries = matrix->begin[n];
  int32_t *place = thrum_scope_allocate(memory, n, sizeof *place);
  p->begin = thrum_scope_allocate(memory, n + 2, sizeof *p->begin);
  p->row = thrum_scope_allocate(memory, entries, sizeof *p->row);
  p->value = thrum_scope_allocate(memory, entries, sizeof *p->value);
  THRUM_TRY(memory->status);

  // where each row of A stands in L, and the scale of its diagonal
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < n; i++) {
    const double diagonal = matrix->value[matrix->begin[f->order[i]]];
    place[f->order[i]] = (int32_t)i;
    f->scale[i] = (float)(1 / sqrt(diagonal));
    if (!(diagonal > 0) || !isfinite(f->scale[i]) || !(f->scale[i] > 0))
      status =
          thrum_error_set(memory->error, THRUM_SINGULAR, "the matrix is not positive definite");
  }

  // an entry goes to the column that comes first in L: count, then fill
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

  return status;
}

// product += scale times rows times the first `width` of them transposed, its lower triangle and
// what lies below; `keep`: what the product has before counts
static void multiply(const float *rows, int ld, int height, int width, int depth, float scale,
                     bool keep, float *product, int product_ld) {
  const float before = keep ? 1 : 0;
  cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, width, depth, scale, rows, ld, before,
              product, product_ld);
  if (height > width)
    cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, height - width, width, depth, scale,
                rows + width, ld, rows, ld, before, product + width, product_ld);
}

// target -= update, whose rows and columns are rows `first` and on of `from`
static void scatter(const supernode *from, int64_t first, int64_t width, const float *update,
                    const int32_t *place, supernode *target) {
  const int64_t height = from->height - first;
  panel *at = target->panels;
  for (int64_t c = 0; c < width; c++) {
    const int64_t column = from->row[first + c];
    while (column >= at->first + at->width)
      at++;
    float *numbers = at->value + (column - at->first) * at->height - (at->first - target->first);
    const float *values = update + c * height;
    for (int64_t i = c; i < height; i++)
      numbers[place[i]] -= values[i];
  }
}

// what an earlier supernode takes from this one: its rows from `done` on times the `used` ones of
// them that are columns of the target
static void subtract(const supernode *from, int64_t used, const int32_t *local, supernode *target,
                     int32_t *place, float *update) {
  for (int64_t b = 0; b < used; b += REACH) {
    const int64_t first = from->done + b, height = from->height - first;
    const int64_t width = used - b < REACH ? used - b : REACH;

    // one product of all its panels, which is brought to its place once
    for (int64_t k = 0; k < from->count; k++) {
      const panel *p = &from->panels[k];
      multiply(p->value + first - (p->first - from->first), (int)p->height, (int)height, (int)width,
               (int)p->width, 1, k > 0, update, (int)height);
    }
    for (int64_t i = 0; i < height; i++)
      place[i] = local[from->row[first + i]];
    scatter(from, first, width, update, place, target);
  }
}

// rows L^T = rows, L of `width` columns at `corner`, by halves: products are faster than STRSM
static void solve_below(const float *corner, int ld, int width, float *rows, int height) {
  if (width <= CORNER) {
    cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, height, width, 1,
                corner, ld, rows, ld);
    return;
  }
  const int left = (width / 2 + 15) / 16 * 16, right = width - left;
  float *beyond = rows + (int64_t)left * ld;
  solve_below(corner, ld, left, rows, height);
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, height, right, left, -1, rows, ld,
              corner + left, ld, 1, beyond, ld);
  solve_below(corner + (int64_t)left * (ld + 1), ld, right, beyond, height);
}

// the dense factor of a supernode from which all earlier ones have been subtracted
static thrum_status factorise(const supernode *node, thrum_error *error) {
  for (int64_t k = 0; k < node->count; k++) {
    const panel *target = &node->panels[k];
    const int w = (int)target->width, ld = (int)target->height;

    // the panels before it have the same rows
    for (int64_t j = 0; j < k; j++) {
      const panel *p = &node->panels[j];
      multiply(p->value + (target->first - p->first), (int)p->height, ld, w, (int)p->width, -1,
               true, target->value, ld);
    }

    // the diagonal block, and the rows below
    const int info = LAPACKE_spotrf_work(LAPACK_COL_MAJOR, 'L', w, target->value, ld);
    if (info != 0)
      return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
    if (ld > w)
      solve_below(target->value, ld, w, target->value + w, ld - w);
  }
  return THRUM_OK;
}

// the entries of A in a supernode; local: where the rows of the supernode stand in it
static void take_entries(const permuted *a, const int32_t *local, const supernode *node) {
  for (int64_t k = 0; k < node->count; k++) {
    const panel *p = &node->panels[k];
    float *column = p->value;
    memset(column, 0, sizeof(float) * (size_t)(p->height * p->width));
    for (int64_t c = p->first; c < p->first + p->width; c++, column += p->height)
      for (int64_t e = a->begin[c]; e < a->begin[c + 1]; e++)
        column[local[a->row[e]] - (p->first - node->first)] = a->value[e];
  }
}

// a supernode waits for that of the first row that none has used
static void wait_for_next(thrum_single_factor *f, int64_t index, int64_t *waiting) {
  supernode *node = &f->nodes[index];
  if (node->done == node->height)
    return;
  const int32_t owner = f->owner[node->row[node->done]];
  node->next = waiting[owner];
  waiting[owner] = index;
}

// room to compute a factor
typedef struct computation {
  int64_t *waiting; /* the first supernode that waits for each; -1: none */
  int32_t *local;   /* n: where a row of L stands in the supernode */
  int32_t *place;   /* where the rows of an update do */
  float *update;
} computation;

// the numbers of one supernode, from A and from the supernodes before it that wait for it
static thrum_status compute_supernode(thrum_single_factor *f, const permuted *a, int64_t index,
                                      computation *c, thrum_error *error) {
  supernode *target = &f->nodes[index];
  for (int64_t i = 0; i < target->height; i++)
    c->local[target->row[i]] = (int32_t)i;
  take_entries(a, c->local, target);

  // each supernode that has rows among these columns, and then waits for the next that it reaches
  for (int64_t d = c->waiting[index], next; d >= 0; d = next) {
    supernode *from = &f->nodes[d];
    next = from->next;
    int64_t used = 0;
    while (from->done + used < from->height &&
           from->row[from->done + used] < target->first + target->width)
      used++;
    subtract(from, used, c->local, target, c->place, c->update);
    from->done += used;
    wait_for_next(f, d, c->waiting);
  }

  THRUM_TRY(factorise(target, error));
  target->done = target->width;
  wait_for_next(f, index, c->waiting);
  return THRUM_OK;
}

static thrum_status compute(const thrum_sparse *matrix, thrum_single_factor *f,
                            thrum_error *error) {
  permuted a = {0};
  thrum_scope memory = thrum_scope_begin("the factor", error);
  computation c = {.waiting = thrum_scope_allocate(&memory, f->count, sizeof *c.waiting),
                   .local = thrum_scope_allocate(&memory, f->size, sizeof *c.local),
                   .place = thrum_scope_allocate(&memory, f->height_max, sizeof *c.place),
                   .update =
                       thrum_scope_allocate(&memory, f->height_max * REACH, sizeof *c.update)};
  thrum_status status = memory.status;
  THRUM_THEN(status, permute(matrix, f, &a, &memory));

  // supernodes in order
  for (int64_t s = 0; s < f->count && status >= 0; s++)
    c.waiting[s] = -1;
  for (int64_t s = 0; s < f->count && status >= 0; s++)
    status = compute_supernode(f, &a, s, &c, error);

  thrum_scope_free(&memory);
  return status;
}

thrum_status thrum_single_factor_create(const thrum_supernodes *pattern, const thrum_sparse *matrix,
                                        thrum_single_factor **factor, thrum_error *error) {
  thrum_single_factor *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "a sparse factor", error));
  made->memory = thrum_scope_begin("the factor", error);
  made->size = pattern->size;
  made->order = pattern->order;

  thrum_status status = cut_panels(pattern, made);
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
  f->update = NULL;
  THRUM_TRY(thrum_reserve(&f->work, f->size * columns, sizeof *f->work, "the solution", error));
  THRUM_TRY(
      thrum_reserve(&f->update, f->height_max * columns, sizeof *f->update, "the solution", error));
  f->work_columns = columns;
  return THRUM_OK;
}

// L x = b; the columns of a row stand together, so BLAS sees the transposed matrix x^T
static void forward(thrum_single_factor *f, int columns) {
  for (int64_t p = 0; p < f->panel_count; p++) {
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
  for (int64_t p = f->panel_count - 1; p >= 0; p--) {
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
  thrum_scope_free(&factor->memory);
  free(factor->work);
  free(factor->update);
  free(factor);
}
