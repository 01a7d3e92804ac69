/* Full-order runs in files named after a hash of all that they depend on: .npy with a row for each
 * sample (u, v, energy) and a last one that begins with the processor time of a step and the
 * checksum of all before it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/full_motion_kept.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driver/spec/load_spec.h"
#include "io/file.h"
#include "io/file_hash.h"
#include "io/folder.h"
#include "io/npy_file.h"
#include "mesh/elastic.h"
#include "platform/allocate.h"
#include "precompute/build_info.h"
#include "thrum/version.h"

static uint64_t hash_numbers(uint64_t hash, const double *values, int64_t count) {
  return hash_bytes(hash, values, (size_t)count * sizeof *values);
}

/* The hash of the body: mesh, materials and their law, what is held, mass. */
static uint64_t hash_body(const thrum_model *model, int mass) {
  const size_t tets = (size_t)model->tet_count, vertices = (size_t)model->vertex_count;
  uint64_t hash = hash_numbers(0, model->vertices, 3 * model->vertex_count);
  hash = hash_bytes(hash, model->tets, 4 * tets * sizeof *model->tets);
  if (model->midsides != NULL)
    hash = hash_bytes(hash, model->midsides, 6 * tets * sizeof *model->midsides);
  hash = hash_bytes(hash, model->tet_region, tets * sizeof *model->tet_region);
  hash = hash_numbers(hash, model->material, 3 * model->region_count);
  if (model->fixed != NULL)
    hash = hash_bytes(hash, model->fixed, vertices);

  // one law of all, or those of the regions
  if (model->point_law)
    hash = hash_bytes(hash, model->point_law, (size_t)model->law_bytes);
  if (model->region_law)
    hash = hash_bytes(hash, model->region_law, (size_t)model->law_count);
  if (model->about)
    hash = hash_numbers(hash, model->about, 3 * model->vertex_count);
  if (model->elastic)
    hash = hash_numbers(hash, model->elastic, THRUM_ELASTIC_NUMBERS * model->elastic_count);
  if (model->region_yield)
    hash = hash_numbers(hash, model->region_yield, model->law_count);
  return hash_bytes(hash, &mass, sizeof mass);
}

static uint64_t hash_course(uint64_t hash, const thrum_load *course) {
  double numbers[LOAD_COURSE_NUMBERS];
  load_course_numbers(course, numbers);
  return hash_numbers(hash, numbers, LOAD_COURSE_NUMBERS);
}

/* Adds what acts on the body beside loads, and where it starts; neither changes nothing. */
static uint64_t hash_rest(uint64_t hash, const thrum_model *model,
                          const full_motion_script *script) {
  const int64_t all = 3 * model->vertex_count;
  for (int64_t n = 0; n < script->base_motion_count; n++) {
    const base_motion_spec *base = &script->base_motions[n];
    hash = hash_course(hash, &base->course);
    hash = hash_numbers(hash, base->amplitude, 3);
    if (base->sine)
      continue;
    hash = hash_numbers(hash, base->motion.times, base->motion.count);
    hash = hash_numbers(hash, base->motion.accelerations, 3 * base->motion.count);
  }
  if (script->held_by != NULL)
    hash = hash_numbers(hash_bytes(hash, "held", 4), script->held_by, all);
  if (script->start != NULL)
    hash = hash_numbers(hash_bytes(hash, "start", 5), script->start, all);
  if (script->yield > 0)
    hash = hash_numbers(hash_bytes(hash, "yield", 5), &script->yield, 1);
  return hash;
}

static uint64_t hash_run(const thrum_model *model, int mass, const full_motion_script *script,
                         double dt, int64_t samples) {
  uint64_t hash = hash_body(model, mass);
  for (int64_t n = 0; n < script->load_count; n++) {
    hash = hash_course(hash, &script->courses[n]);
  }
  hash = hash_numbers(hash, script->forces, 3 * script->load_count * model->vertex_count);
  hash = hash_rest(hash, model, script);

  // versions and the compiler, because other code may round differently
  const double numbers[] = {script->damping_alpha, script->damping_beta, script->time, dt,
                            (double)samples};
  char text[256];
  hash = hash_numbers(hash, numbers, sizeof numbers / sizeof numbers[0]);
  const int length = snprintf(text, sizeof text, "%s|%.120s|%.60s", thrum_version(),
                              thrum_build_compiler(), thrum_build_blas_core());
  return hash_bytes(hash, text, (size_t)length);
}

/* A run in memory, and what else is told of each of its steps. */
typedef struct kept {
  int64_t all, columns;
  double *rows; /* samples + 1 x columns */
  const full_motion_observer *observer;
} kept;

static void take(void *context, int64_t index, const double *u, const double *v, double energy) {
  const kept *k = context;
  double *row = k->rows + index * k->columns;
  memcpy(row, u, (size_t)k->all * sizeof *u);
  memcpy(row + k->all, v, (size_t)k->all * sizeof *v);
  row[2 * k->all] = energy;
}

/* The checksum of the samples and the time of a step, which a double holds. */
static double checksum(const kept *k) {
  const int64_t last = k->observer->samples * k->columns;
  return (double)(hash_bytes(0, k->rows, (size_t)(last + 1) * sizeof *k->rows) >> 12);
}

/* Hands all samples on. */
static void replay(const kept *k, double *us_per_step) {
  for (int64_t n = 0; n < k->observer->samples; n++) {
    const double *row = k->rows + n * k->columns;
    k->observer->take(k->observer->context, n, row, row + k->all, row[2 * k->all]);
  }
  if (us_per_step != NULL)
    *us_per_step = k->rows[k->observer->samples * k->columns];
}

static thrum_status write_rows(const char *path, kept *k, thrum_error *error) {
  k->rows[k->observer->samples * k->columns + 1] = checksum(k);
  unsigned char header[THRUM_NPY_HEADER_MAX];
  thrum_file_writer writer = {NULL, NULL, NULL};
  const int64_t rows = k->observer->samples + 1;
  const size_t length = thrum_npy_header_f8(header, rows, k->columns);
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  thrum_status status = thrum_file_writer_put(&writer, header, length, error);
  THRUM_THEN(status, thrum_file_writer_put(&writer, k->rows,
                                           (size_t)(rows * k->columns) * sizeof(double), error));
  return thrum_file_writer_end(&writer, status, error);
}

/* The run of the file into k->rows; false: it is not there, not whole or damaged, and is made
 * anew. */
static bool read_rows(const char *path, kept *k) {
  int64_t rows = 0, columns = 0;
  if (access(path, F_OK) != 0 || thrum_npy_read_f8(path, &k->rows, &rows, &columns, NULL) < 0)
    return false;
  if (rows == k->observer->samples + 1 && columns == k->columns &&
      k->rows[(rows - 1) * columns + 1] == checksum(k))
    return true;
  free(k->rows);
  k->rows = NULL;
  return false;
}

static thrum_status make(const thrum_model *model, const full_motion_script *script, double dt,
                         const char *path, kept *k, thrum_error *error) {
  const full_motion_observer inside = {k->observer->samples, take, k, k->observer->progress,
                                       k->observer->progress_context};
  const int64_t count = (k->observer->samples + 1) * k->columns;
  THRUM_TRY(thrum_reserve(&k->rows, count, sizeof *k->rows, "the run that is kept", error));
  THRUM_TRY(full_motion_run(model, script, dt, &inside, k->rows + k->observer->samples * k->columns,
                            error));
  return write_rows(path, k, error);
}

thrum_status full_motion_kept_path(const char *folder, const thrum_model *model, int mass,
                                   const full_motion_script *script, double dt, int64_t samples,
                                   char path[FULL_MOTION_PATH_MAX], thrum_error *error) {
  const int length = snprintf(path, FULL_MOTION_PATH_MAX, "%s/full-%016" PRIx64 ".npy", folder,
                              hash_run(model, mass, script, dt, samples));
  return length < FULL_MOTION_PATH_MAX
             ? THRUM_OK
             : thrum_error_set(error, THRUM_BAD_VALUE,
                               "the name of the folder of runs that are kept is too long");
}

thrum_status full_motion_kept(const char *folder, const thrum_model *model, int mass,
                              const full_motion_script *script, double dt,
                              const full_motion_observer *observer, double *us_per_step,
                              thrum_error *error) {
  if (folder == NULL)
    return full_motion_run(model, script, dt, observer, us_per_step, error);

  char path[FULL_MOTION_PATH_MAX];
  const int64_t all = 3 * model->vertex_count;
  kept k = {.all = all, .columns = 2 * all + 1, .observer = observer};
  THRUM_TRY(full_motion_kept_path(folder, model, mass, script, dt, observer->samples, path, error));
  THRUM_TRY(folder_make(folder, error));

  const thrum_status status =
      read_rows(path, &k) ? THRUM_OK : make(model, script, dt, path, &k, error);
  if (status >= 0)
    replay(&k, us_per_step);
  free(k.rows);
  return status;
}
