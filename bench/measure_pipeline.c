/* Times of the pipeline, each in a process of its own (bench/measure_pipeline.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "bench/measure_pipeline.h"

#include <cblas.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_fix.h"
#include "platform/allocate.h"
#include "platform/clock.h"

// a beam of about `wanted` tets, six a cell
static thrum_status make_beam(int64_t wanted, thrum_mesh *mesh, uint8_t **fixed,
                              thrum_error *error) {
  const double side = cbrt((double)wanted / 6 / 3.5);
  const int across = side < 1.5 ? 1 : (int)(side + 0.5);
  int along = (int)((double)wanted / 6 / across / across + 0.5);
  along = along < 1 ? 1 : along;
  char name[128];
  snprintf(name, sizeof name, "beam:%dx%dx%d@%gx1x1", along, across, across,
           (double)along / across);
  THRUM_TRY(thrum_mesh_read(name, 1, mesh, error));
  int64_t held = 0;
  THRUM_TRY(thrum_reserve(fixed, mesh->vertex_count, 1, "the bench", error));
  return thrum_mesh_fix(mesh, "left", *fixed, &held, error);
}

static thrum_status time_pipeline(bench_pipeline *bench, thrum_error *error) {
  thrum_mesh mesh = {0};
  uint8_t *fixed = NULL;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = bench->modes;
  options.rank = bench->rank;
  options.threads = bench->threads;

  thrum_precomputed result = {0};
  thrum_status status = make_beam(bench->wanted, &mesh, &fixed, error);
  THRUM_THEN(status, thrum_precompute(&mesh, fixed, &options, &result, error));

  // the figures of the stages, which the pipeline measures itself
  if (status >= 0) {
    bench->tets = mesh.tet_count;
    bench->free_dofs = result.free_dofs;
    bench->factor_nonzeros = result.factor_nonzeros;
    bench->total = bench->cpu_total = 0;
    for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
      bench->total += bench->seconds[stage] = result.seconds[stage];
      bench->cpu_total += bench->cpu_seconds[stage] = result.cpu_seconds[stage];
      bench->flops[stage] = result.flops[stage];
    }
    bench->peak_mb = result.peak_mb[THRUM_STAGE_COUNT - 1];
  }
  thrum_precomputed_free(&result);
  thrum_mesh_free(&mesh);
  free(fixed);
  return status;
}

// A^T A of one tall panel, by one call
static thrum_status time_syrk(bench_pipeline *bench, thrum_error *error) {
  const int64_t m = bench->rank + bench->rank * (bench->rank + 1) / 2, rows = 6 * bench->tets;
  double *panel = malloc((size_t)(m * rows) * sizeof *panel);
  double *gram = calloc((size_t)(m * m), sizeof *gram);
  thrum_status status = THRUM_OK;

  // the size of the Gram product of the polynomial
  if (panel && gram) {
    for (int64_t i = 0; i < m * rows; i++)
      panel[i] = (double)(i % 1021) / 1021 - 0.5;
    openblas_set_num_threads(bench->threads);
    const double began = clock_seconds(), worked = clock_process_seconds();
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, (int)m, (int)rows, 1, panel, (int)rows, 0,
                gram, (int)m);
    bench->syrk_seconds = clock_seconds() - began;
    bench->syrk_cpu_seconds = clock_process_seconds() - worked;
  } else {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a DSYRK of %lld x %lld",
                             (long long)m, (long long)rows);
  }

  free(panel);
  free(gram);
  return status;
}

typedef struct answer {
  thrum_status status;
  thrum_error error;
  bench_pipeline bench;
} answer;

// the work runs in a child process, which sends its answer through a pipe
static thrum_status run_apart(thrum_status (*work)(bench_pipeline *, thrum_error *),
                              bench_pipeline *bench, thrum_error *error) {
  int ends[2];
  if (pipe(ends) != 0)
    return thrum_error_set(error, THRUM_IO, "no pipe for the bench");
  fflush(NULL);
  const pid_t child = fork();

  // the child works, and writes its answer
  if (child == 0) {
    answer told = {.bench = *bench};
    told.status = work(&told.bench, &told.error);
    const bool whole = write(ends[1], &told, sizeof told) == (ssize_t)sizeof told;
    _exit(whole ? 0 : 1);
  }

  // the parent reads it; a child that died has written none
  close(ends[1]);
  answer told;
  const bool whole = child > 0 && read(ends[0], &told, sizeof told) == (ssize_t)sizeof told;
  close(ends[0]);
  int ended = 0;
  if (child > 0)
    waitpid(child, &ended, 0);

  // its failure is this one's
  if (!whole)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "a run of the bench ended early: not enough memory?");
  if (told.status < 0) {
    if (error)
      *error = told.error;
    return told.status;
  }

  *bench = told.bench;
  return THRUM_OK;
}

thrum_status bench_pipeline_run(bench_pipeline *bench, thrum_error *error) {
  bench->syrk_seconds = bench->syrk_cpu_seconds = NAN;
  thrum_status status = run_apart(time_pipeline, bench, error);
  if (status >= 0 && bench->syrk)
    status = run_apart(time_syrk, bench, error);
  return status;
}

double bench_exponent(const double *x, const double *y, int64_t count) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  for (int64_t i = 0; i < count; i++) {
    mean_x += log(x[i]) / (double)count;
    mean_y += log(y[i]) / (double)count;
  }
  for (int64_t i = 0; i < count; i++) {
    xx += (log(x[i]) - mean_x) * (log(x[i]) - mean_x);
    xy += (log(x[i]) - mean_x) * (log(y[i]) - mean_y);
  }
  return count >= 2 && xx > 0 ? xy / xx : NAN;
}
