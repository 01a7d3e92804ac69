/* Two runs side by side: where their rows have the same time, and where their vertices are then.
 *
 * A vertex X is at A (X + U q), A the placement of the body in that row. With the error of a run
 * against the exact motion a C h^2, the runs with h and with h/2 are 3/4 of it apart, so what is
 * found of these two is three times the error of the finer one.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_compare.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "thrum/displacement.h"

#define SAME_TIME 1e-6  /* of the mean time between two rows */
#define SAME_PLACE 1e-6 /* of the diagonal of the body, for vertices at rest */

/* One of the two runs, and its vertices at one moment. */
typedef struct side {
  const recorded_run *run;
  double *q;         /* rank of the model, zero beyond that of the run */
  double *shape;     /* vertices x 3: U q [m] */
  double *positions; /* vertices x 3, in the world [m] */
  double *first;     /* those of the first moment */
} side;

/* The rows that belong together: count pairs of (row of one, row of the other). */
typedef struct row_pairs {
  int64_t (*rows)[2];
  int64_t count;
} row_pairs;

/* The mean time between two rows; 0 where there is one row alone. */
static double mean_step(const recorded_run *run) {
  return run->rows > 1 ? (run->times[run->rows - 1] - run->times[0]) / (double)(run->rows - 1) : 0;
}

/* Finds the rows of the same time; both runs' times ascend. */
static thrum_status pair_rows(const recorded_run *run, const recorded_run *other, row_pairs *pairs,
                              thrum_error *error) {
  const double near = SAME_TIME * fmin(mean_step(run), mean_step(other));
  const int64_t most = run->rows < other->rows ? run->rows : other->rows;
  THRUM_TRY(thrum_reserve(&pairs->rows, most, sizeof *pairs->rows, "the rows", error));

  for (int64_t n = 0, m = 0; n < run->rows && m < other->rows;) {
    const double ahead = run->times[n] - other->times[m];
    if (fabs(ahead) <= near) {
      pairs->rows[pairs->count][0] = n;
      pairs->rows[pairs->count++][1] = m;
    }

    // the one that is behind goes on; both where they are together
    n += ahead <= near;
    m += ahead >= -near;
  }

  if (pairs->count > 1)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "the runs have rows at %" PRId64 " common time%s: record both at the same "
                         "times (--record-every)",
                         pairs->count, pairs->count == 1 ? "" : "s");
}

/* Are these the same vertices at rest? */
static bool same_vertices(const thrum_model *left, const thrum_model *right) {
  if (left->vertex_count != right->vertex_count || left->vertices == NULL ||
      right->vertices == NULL)
    return false;
  const double size = thrum_box3_diagonal(left->vertices, left->vertex_count);
  for (int64_t c = 0; c < 3 * left->vertex_count; c++)
    if (!(fabs(left->vertices[c] - right->vertices[c]) <= SAME_PLACE * size))
      return false;
  return true;
}

static thrum_status open_side(const recorded_run *run, side *of, thrum_error *error) {
  const int64_t numbers = 3 * run->model->vertex_count;
  of->run = run;
  THRUM_TRY(thrum_reserve(&of->q, run->model->rank, sizeof *of->q, "a run", error));
  THRUM_TRY(thrum_reserve(&of->shape, numbers, sizeof *of->shape, "a run", error));
  THRUM_TRY(thrum_reserve(&of->positions, numbers, sizeof *of->positions, "a run", error));
  return thrum_reserve(&of->first, numbers, sizeof *of->first, "a run", error);
}

static void close_side(side *of) {
  free(of->q);
  free(of->shape);
  free(of->positions);
  free(of->first);
}

/* Where a body stands in a row; NULL: where it stood at first. */
static const double *place_of(const recorded_run *run, int64_t row) {
  return run->places != NULL ? run->places + RUN_PLACEMENT_COLUMNS * row : NULL;
}

/* Puts the vertices where they are in a row. */
static thrum_status place_vertices(side *of, int64_t row, thrum_error *error) {
  const recorded_run *run = of->run;
  const thrum_model *model = run->model;
  double matrix[16];
  memcpy(of->q, run->q + row * run->rank, (size_t)run->rank * sizeof *of->q);
  THRUM_TRY(thrum_displacement(model, of->q, 0, model->vertex_count, of->shape, error));
  run_placement_matrix(&run->place, place_of(run, row), matrix);

  for (int64_t v = 0; v < model->vertex_count; v++) {
    double point[3];
    for (int axis = 0; axis < 3; axis++)
      point[axis] = model->vertices[3 * v + axis] + of->shape[3 * v + axis];
    run_placement_point(matrix, point, of->positions + 3 * v);
  }
  return THRUM_OK;
}

/* The rotation of a body in a row, w, x, y, z. */
static void rotation_of(const recorded_run *run, int64_t row, double rotation[4]) {
  const double *place = place_of(run, row);
  static const double none[4] = {1, 0, 0, 0};
  const double *from = place != NULL ? place + 3 : run->place.placed ? run->place.rotation : none;
  memcpy(rotation, from, 4 * sizeof *rotation);
}

/* The angle between two rotations [rad]: that of the quaternion conj(a) b. */
static double angle_between(const double a[4], const double b[4]) {
  const double along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  double across = 0;
  for (int n = 1; n < 4; n++) {
    const int m = n % 3 + 1, k = m % 3 + 1;
    across = hypot(across, a[0] * b[n] - b[0] * a[n] - a[m] * b[k] + a[k] * b[m]);
  }
  return 2 * atan2(across, fabs(along));
}

/* The sum of squares of the differences of two lists of numbers. */
static double square_between(const double *left, const double *right, int64_t count) {
  double sum = 0;
  for (int64_t n = 0; n < count; n++)
    sum += (left[n] - right[n]) * (left[n] - right[n]);
  return sum;
}

/* Keeps the vertex that is the furthest apart so far. */
static void raise_largest(const side sides[2], double time, run_difference *found) {
  for (int64_t v = 0; v < sides[0].run->model->vertex_count; v++) {
    const double square = square_between(sides[0].positions + 3 * v, sides[1].positions + 3 * v, 3);
    if (square <= found->largest * found->largest)
      continue;
    found->largest = sqrt(square);
    found->vertex = v;
    found->time = time;
  }
}

/* Adds the vertices of one moment: squares are summed where root mean squares come of them. */
static thrum_status add_moment(side sides[2], const int64_t rows[2], run_difference *found,
                               thrum_error *error) {
  const int64_t numbers = 3 * sides[0].run->model->vertex_count;
  double rotations[2][4];
  for (int n = 0; n < 2; n++) {
    THRUM_TRY(place_vertices(&sides[n], rows[n], error));
    rotation_of(sides[n].run, rows[n], rotations[n]);
    if (found->moments == 0)
      memcpy(sides[n].first, sides[n].positions, (size_t)numbers * sizeof(double));
  }

  // in the world, of the shape alone, and of the motion that they are measured by
  const double scale = sides[1].run->place.placed ? sides[1].run->place.scale : 1;
  found->at_end = square_between(sides[0].positions, sides[1].positions, numbers);
  found->apart += found->at_end;
  found->shape += scale * scale * square_between(sides[0].shape, sides[1].shape, numbers);
  found->moved += square_between(sides[1].positions, sides[1].first, numbers);
  found->turn = fmax(found->turn, angle_between(rotations[0], rotations[1]));
  found->last = sides[0].run->times[rows[0]];
  if (found->moments++ == 0)
    found->first = found->last;
  raise_largest(sides, found->last, found);
  return THRUM_OK;
}

/* Compares the energies of all common rows, which cost nothing. */
static void compare_energies(const recorded_run *run, const recorded_run *other,
                             const row_pairs *pairs, run_difference *found) {
  for (int64_t n = 0; n < pairs->count; n++) {
    const double *left = run->energies + 2 * pairs->rows[n][0];
    const double *right = other->energies + 2 * pairs->rows[n][1];
    found->energy = fmax(found->energy, fabs(left[0] - right[0] + (left[1] - right[1])));
    found->energy_most = fmax(found->energy_most, right[0] + right[1]);
  }
}

thrum_status run_compare(const recorded_run *run, const recorded_run *other, run_difference *found,
                         thrum_error *error) {
  if (!same_vertices(run->model, other->model))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "the runs are of bodies with other vertices (%" PRId64 " and %" PRId64
                           "): only runs of one mesh can be compared",
                           run->model->vertex_count, other->model->vertex_count);
  row_pairs pairs = {0};
  side sides[2] = {{0}};
  run_difference sum = {.vertex = -1};
  thrum_status status = pair_rows(run, other, &pairs, error);
  THRUM_THEN(status, open_side(run, &sides[0], error));
  THRUM_THEN(status, open_side(other, &sides[1], error));

  // moments spread evenly over the common rows, the first and the last among them
  const int64_t moments = pairs.count < RUN_COMPARE_MOMENTS ? pairs.count : RUN_COMPARE_MOMENTS;
  for (int64_t n = 0; n < moments && status >= 0; n++)
    status = add_moment(sides, pairs.rows[n * (pairs.count - 1) / (moments - 1)], &sum, error);

  // sums of squares become root mean squares, over vertices or over vertices and moments
  if (status >= 0) {
    const double vertices = (double)run->model->vertex_count;
    compare_energies(run, other, &pairs, &sum);
    sum.at_end = sqrt(sum.at_end / vertices);
    sum.apart = sqrt(sum.apart / (vertices * (double)moments));
    sum.shape = sqrt(sum.shape / (vertices * (double)moments));
    sum.moved = sqrt(sum.moved / (vertices * (double)moments));
    *found = sum;
  }
  close_side(&sides[0]);
  close_side(&sides[1]);
  free(pairs.rows);
  return status;
}
