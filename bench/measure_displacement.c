/* u = U q for a mesh that is shown: thrum_surface against a double-precision matrix-vector product
 * with the same U. All take turns, so that each finds the caches as the others left them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <cblas.h>
#include <math.h>
#include <string.h>

#include "bench/measure.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/threads.h"
#include "thrum/displacement.h"

enum { RUNS = 5 };

/* The random body of a run; all members are heap blocks. */
typedef struct body {
  thrum_model model;
  double *basis, *columns, *vertices, *q, *u, *samples;
  int32_t *triangles;
  float *shown, *normals;
  thrum_scope memory;
  const thrum_surface *surface;
  int64_t triangle_count;
} body;

/* The same numbers in [-1, 1) in every run. */
static void fill(double *values, int64_t count) {
  uint32_t bits = 1;
  for (int64_t n = 0; n < count; n++) {
    bits = bits * 1664525u + 1013904223u;
    values[n] = (double)bits * 0x1p-31 - 1.0;
  }
}

/* A strip of triangles over neighbouring vertices: two for each. */
static void fill_triangles(body *b) {
  const int64_t count = b->model.vertex_count;
  for (int64_t t = 0; t < b->triangle_count; t++) {
    const int64_t v = t / 2;
    b->triangles[3 * t] = (int32_t)v;
    b->triangles[3 * t + 1] = (int32_t)((v + 1 + t % 2) % count);
    b->triangles[3 * t + 2] = (int32_t)((v + 2 - t % 2) % count);
  }
}

static thrum_status body_make(const bench_displacement *bench, body *b, thrum_error *error) {
  const size_t rows = 3 * (size_t)bench->vertices, rank = (size_t)bench->rank;
  b->triangle_count = 2 * bench->vertices;
  b->model.rank = bench->rank;
  b->model.vertex_count = bench->vertices;

  b->memory = thrum_scope_begin("the vertices", error);
  b->basis = thrum_scope_allocate(&b->memory, (int64_t)(rows * rank), sizeof(double));
  b->columns = thrum_scope_allocate(&b->memory, (int64_t)(rows * rank), sizeof(double));
  b->vertices = thrum_scope_allocate(&b->memory, (int64_t)(rows), sizeof(double));
  b->q = thrum_scope_allocate(&b->memory, (int64_t)(rank), sizeof(double));
  b->u = thrum_scope_allocate(&b->memory, (int64_t)(rows), sizeof(double));
  b->samples = thrum_scope_allocate(&b->memory, (int64_t)(RUNS * (size_t)bench->repetitions),
                                    sizeof(double));
  b->triangles =
      thrum_scope_allocate(&b->memory, (int64_t)(3 * (size_t)b->triangle_count), sizeof(int32_t));
  b->shown = thrum_scope_allocate(&b->memory, (int64_t)(rows), sizeof(float));
  b->normals = thrum_scope_allocate(&b->memory, (int64_t)(rows), sizeof(float));
  THRUM_TRY(b->memory.status);

  // random numbers, and the same basis stored by columns
  b->model.basis = b->basis;
  b->model.vertices = b->vertices;
  fill(b->basis, (int64_t)(rows * rank));
  for (size_t n = 0; n < rows; n++)
    for (size_t i = 0; i < rank; i++)
      b->columns[i * rows + n] = b->basis[n * rank + i];
  fill(b->vertices, (int64_t)rows);
  fill(b->q, bench->rank);
  fill_triangles(b);

  const thrum_surface_def def = {.triangles = b->triangles, .triangle_count = b->triangle_count};
  size_t size = 0;
  THRUM_TRY(thrum_surface_size(&b->model, &def, &size, error));
  void *memory = thrum_scope_allocate_aligned(&b->memory, size);
  THRUM_TRY(b->memory.status);
  return thrum_surface_init(memory, size, &b->model, &def, &b->surface, error);
}

static void run_dgemv(body *b) {
  cblas_dgemv(CblasRowMajor, CblasNoTrans, (int)(3 * b->model.vertex_count), (int)b->model.rank,
              1.0, b->basis, (int)b->model.rank, b->q, 1, 0.0, b->u, 1);
}

static void run_dgemv_columns(body *b) {
  cblas_dgemv(CblasColMajor, CblasNoTrans, (int)(3 * b->model.vertex_count), (int)b->model.rank,
              1.0, b->columns, (int)(3 * b->model.vertex_count), b->q, 1, 0.0, b->u, 1);
}

static void run_plain(body *b) {
  thrum_displacement(&b->model, b->q, 0, b->model.vertex_count, b->u, NULL);
}

static void run_surface(body *b) {
  thrum_surface_positions(b->surface, THRUM_SURFACE_POSITIONS, b->q, 0, b->model.vertex_count,
                          b->shown, 3, NULL);
}

static void run_normals(body *b) {
  thrum_surface_normals(b->surface, b->shown, 3, b->normals, 3, NULL);
}

/* Largest |surface - dgemv| over the largest displacement. */
static double difference(body *b) {
  double largest = 0, worst = 0;
  run_dgemv(b);
  thrum_surface_positions(b->surface, THRUM_SURFACE_DISPLACEMENTS, b->q, 0, b->model.vertex_count,
                          b->shown, 3, NULL);
  for (int64_t n = 0; n < 3 * b->model.vertex_count; n++) {
    largest = fmax(largest, fabs(b->u[n]));
    worst = fmax(worst, fabs(b->u[n] - (double)b->shown[n]));
  }
  return largest > 0 ? worst / largest : worst;
}

thrum_status bench_displacement_run(bench_displacement *bench, thrum_error *error) {
  static void (*const runs[RUNS])(body *) = {run_dgemv, run_dgemv_columns, run_plain, run_surface,
                                             run_normals};
  body b;
  memset(&b, 0, sizeof b);
  const thrum_status status = body_make(bench, &b, error);
  if (status == THRUM_OK) {
    const thrum_threads before = thrum_threads_set(1);
    const int64_t count = bench->repetitions;

    // the first round warms up
    for (int64_t k = -1; k < count; k++)
      for (int64_t n = 0; n < RUNS; n++) {
        const double began = clock_thread_seconds();
        runs[n](&b);
        if (k >= 0)
          b.samples[n * count + k] = 1e6 * (clock_thread_seconds() - began);
      }

    bench->dgemv = bench_summary(b.samples, count);
    bench->dgemv_columns = bench_summary(b.samples + count, count);
    bench->plain = bench_summary(b.samples + 2 * count, count);
    bench->surface = bench_summary(b.samples + 3 * count, count);
    bench->normals = bench_summary(b.samples + 4 * count, count);
    bench->ratio = bench->surface.minimum / bench->dgemv.minimum;
    bench->ratio_median = bench->surface.median / bench->dgemv.median;
    bench->ratio_columns = bench->surface.minimum / bench->dgemv_columns.minimum;
    bench->bytes_surface = 12.0 * (double)bench->vertices * (double)bench->rank;
    bench->difference = difference(&b);
    thrum_threads_restore(before);
  }
  thrum_scope_free(&b.memory);
  return status;
}
