/* Vertex caches, which Blender and others play on an .obj with the same vertices: PC2
 * ("POINTCACHE2", little-endian) and MDD (LightWave, big-endian). Positions in single precision,
 * the axes as they are. SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/vertex_cache.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "io/file.h"

/* Four bytes, in the machine's order (little-endian) or the other way round. */
static void put4(FILE *file, const void *value, bool swapped) {
  unsigned char bytes[4];
  memcpy(bytes, value, 4);
  if (swapped) {
    const unsigned char back[4] = {bytes[3], bytes[2], bytes[1], bytes[0]};
    memcpy(bytes, back, 4);
  }
  fwrite(bytes, 1, 4, file); // an error leaves its mark on the stream
}

static void put_integer(FILE *file, int64_t value, bool swapped) {
  const int32_t number = (int32_t)value;
  put4(file, &number, swapped);
}

static void put_float(FILE *file, double value, bool swapped) {
  const float number = (float)value;
  put4(file, &number, swapped);
}

/* X + U q of one row, in place. */
static void put_row(FILE *file, const recorded_run *run, const render_mesh *shown, int64_t row,
                    bool swapped) {
  // where the body is in this row
  const double *q = run->q + row * run->rank;
  double matrix[16];
  run_placement_matrix(&run->place, run->places ? run->places + RUN_PLACEMENT_COLUMNS * row : NULL,
                       matrix);

  // each vertex, displaced and placed
  for (int64_t v = 0; v < shown->vertex_count; v++) {
    double x[3];
    for (int axis = 0; axis < 3; axis++) {
      const int64_t n = 3 * v + axis;
      x[axis] = shown->positions[n];
      for (int64_t i = 0; i < run->rank; i++)
        x[axis] += (double)shown->basis[n * shown->rank + i] * q[i];
    }
    run_placement_point(matrix, x, x);
    for (int axis = 0; axis < 3; axis++)
      put_float(file, x[axis], swapped);
  }
}

static thrum_status check_count(const char *path, const recorded_run *run, thrum_error *error) {
  if (run->rows > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: %" PRId64 " rows are too many: write fewer (--fps)", path,
                           run->rows);
  return THRUM_OK;
}

thrum_status pc2_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(check_count(path, run, error));
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *file = writer.stream;
  fwrite("POINTCACHE2", 1, 12, file);
  put_integer(file, 1, false);
  put_integer(file, shown->vertex_count, false);
  put_float(file, 0, false); // the first frame
  put_float(file, 1, false); // one frame a row
  put_integer(file, run->rows, false);
  for (int64_t row = 0; row < run->rows; row++)
    put_row(file, run, shown, row, false);
  return thrum_file_writer_commit(&writer, error);
}

thrum_status mdd_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(check_count(path, run, error));
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *file = writer.stream;
  put_integer(file, run->rows, true);
  put_integer(file, shown->vertex_count, true);
  for (int64_t row = 0; row < run->rows; row++)
    put_float(file, run->times[row], true);
  for (int64_t row = 0; row < run->rows; row++)
    put_row(file, run, shown, row, true);
  return thrum_file_writer_commit(&writer, error);
}

thrum_status obj_write(const char *path, const run_placement *place, const render_mesh *shown,
                       thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *file = writer.stream;
  double matrix[16];
  run_placement_matrix(place, NULL, matrix);

  // vertices, then triangles, whose corners count from 1
  fputs("# the surface at rest [m]\n", file);
  for (int64_t v = 0; v < shown->vertex_count; v++) {
    double x[3];
    run_placement_point(matrix, shown->positions + 3 * v, x);
    fprintf(file, "v %.17g %.17g %.17g\n", x[0], x[1], x[2]);
  }
  for (int64_t n = 0; n < shown->triangle_count; n++) {
    const int32_t *corners = shown->triangles + 3 * n;
    fprintf(file, "f %d %d %d\n", corners[0] + 1, corners[1] + 1, corners[2] + 1);
  }
  return thrum_file_writer_commit(&writer, error);
}
