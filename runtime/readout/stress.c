/* Stress points: planning, laying out, reading (thrum/stress.h, design 1).
 * Cost of a reading: u = U q of the places, 6 r operations each, then about 200 a tet.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/readout/stress_private.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/lame.h"
#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "runtime/readout/tet_strain.h"

#define STRESS_POINTS_MAGIC UINT64_C(0x7468726d67613031)

static size_t tets_offset(void) {
  return thrum_round_up(sizeof(thrum_stress_points));
}

static size_t rows_offset(int64_t count) {
  return tets_offset() + thrum_round_up((size_t)count * sizeof(thrum_stress_point_tet));
}

static const thrum_stress_point_tet *data_of(const thrum_stress_points *stress_points) {
  return (const void *)((const unsigned char *)stress_points + tets_offset());
}

static const double *rows_of(const thrum_stress_points *stress_points) {
  return (const void *)((const unsigned char *)stress_points + rows_offset(stress_points->count));
}

static int64_t count_of(const thrum_model *model, const thrum_stress_points_def *def) {
  return def->tets ? def->tet_count : model->tet_count;
}

static int64_t places_of(const thrum_model *model, const thrum_stress_points_def *def) {
  return def->tets ? 4 * def->tet_count : model->vertex_count;
}

static thrum_status check_def(const thrum_model *model, const thrum_stress_points_def *def,
                              thrum_error *error) {
  if (!model || !def)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or the def is NULL");
  if (!model->basis || !model->tets)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or no basis, so it has no stress: precompute it "
                           "from a mesh");
  if (model->solid_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "stress points are those of tetrahedra, and the model has other "
                           "elements: thrum static says their stress, and so does thrum simulate "
                           "--stress; or precompute it with --element tet");

  // the chosen tetrahedra are ones of the model
  if (def->tets && (def->tet_count < 1 || def->tet_count > INT32_MAX / 4))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld tetrahedra are chosen; stress points need 1 to 2^29 - 1",
                           (long long)def->tet_count);
  for (int64_t n = 0; def->tets && n < def->tet_count; n++)
    if (def->tets[n] < 0 || def->tets[n] >= model->tet_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "entry %lld of the chosen tetrahedra is %lld, which is outside "
                             "0..%lld",
                             (long long)n, (long long)def->tets[n],
                             (long long)model->tet_count - 1);
  return THRUM_OK;
}

thrum_status thrum_stress_points_size(const thrum_model *model, const thrum_stress_points_def *def,
                                      size_t *size, thrum_error *error) {
  THRUM_TRY(check_def(model, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  *size = rows_offset(count_of(model, def)) +
          thrum_round_up((size_t)(3 * places_of(model, def) * model->rank) * sizeof(double));
  return THRUM_OK;
}

int thrum_stress_points_nodes(const thrum_model *model, int64_t tet, int corner, int32_t nodes[3]) {
  nodes[0] = model->tets[4 * tet + corner];
  if (!model->midsides)
    return 1;
  int count = 0;
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
    if (thrum_quadratic_edges[e][0] == corner || thrum_quadratic_edges[e][1] == corner)
      nodes[count++] = model->midsides[6 * tet + e];
  return count;
}

/* The same as below at the centre of a ten-node tet. */
static bool quadratic_shape(const thrum_model *model, int64_t tet, double shape[9]) {
  static const double centre[4] = {0.25, 0.25, 0.25, 0.25};
  double places[THRUM_QUADRATIC_NODES][3], slopes[THRUM_QUADRATIC_NODES][3];
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
    const int64_t v = a < 4 ? model->tets[4 * tet + a] : model->midsides[6 * tet + a - 4];
    memcpy(places[a], model->vertices + 3 * v, sizeof places[a]);
  }
  thrum_quadratic_slopes(centre, slopes);
  if (!(thrum_quadratic_map(places, slopes, shape) > 0))
    return false;
  for (int n = 0; n < 9; n++)
    if (!isfinite(shape[n]))
      return false;
  return true;
}

bool thrum_stress_points_shape(const thrum_model *model, int64_t tet, double shape[9]) {
  if (model->midsides)
    return quadratic_shape(model, tet, shape);

  double e[3][3];
  thrum_tet_edges(model->vertices, model->tets + 4 * tet, e);

  // the rows of the inverse of the edges' matrix are cross products over six volumes
  for (int a = 0; a < 3; a++)
    thrum_cross3(e[(a + 1) % 3], e[(a + 2) % 3], shape + 3 * a);

  // a flat tetrahedron has no inverse
  const double six = thrum_dot3(e[0], shape);
  for (int n = 0; n < 9; n++) {
    shape[n] /= six;
    if (!isfinite(shape[n]))
      return false;
  }
  return six > 0;
}

static thrum_status fill_tet(const thrum_model *model, const thrum_stress_points_def *def,
                             int64_t n, thrum_stress_point_tet *data, thrum_error *error) {
  const int64_t tet = def->tets ? def->tets[n] : n;
  const double *material = model->material + 3 * (int64_t)model->tet_region[tet];
  const thrum_lame lame = thrum_lame_of(material[0], material[1]);
  if (!thrum_stress_points_shape(model, tet, data->shape))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "tetrahedron %lld of the model has no positive volume",
                           (long long)tet + 1);
  data->lambda = lame.lambda;
  data->mu = lame.mu;
  data->tet = (int32_t)tet;
  data->law = thrum_law_of_region(model, model->tet_region[tet]);

  // chosen tetrahedra have rows of their own, in which the parts of a corner are added up
  data->parts = 1;
  for (int a = 0; a < 4; a++) {
    if (def->tets)
      data->place[a][0] = (int32_t)(4 * n + a);
    else
      data->parts = thrum_stress_points_nodes(model, tet, a, data->place[a]);
  }
  return THRUM_OK;
}

static void fill_rows(const thrum_model *model, const thrum_stress_points_def *def, double *rows) {
  const size_t row = (size_t)(3 * model->rank);
  if (!def->tets) {
    memcpy(rows, model->basis, (size_t)model->vertex_count * row * sizeof *rows);
    return;
  }
  for (int64_t n = 0; n < 4 * def->tet_count; n++) {
    int32_t nodes[3];
    double *own = rows + (size_t)n * row;
    const int parts = thrum_stress_points_nodes(model, def->tets[n / 4], (int)(n % 4), nodes);
    memcpy(own, model->basis + (size_t)nodes[0] * row, row * sizeof *rows);
    for (int part = 1; part < parts; part++)
      for (size_t i = 0; i < row; i++)
        own[i] += model->basis[(size_t)nodes[part] * row + i];
  }
}

thrum_status thrum_stress_points_init(void *memory, size_t memory_size, const thrum_model *model,
                                      const thrum_stress_points_def *def,
                                      const thrum_stress_points **stress_points,
                                      thrum_error *error) {
  // what cannot be made is refused before the memory is touched
  size_t size;
  THRUM_TRY(thrum_stress_points_size(model, def, &size, error));
  if (!memory || !stress_points)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or stress points is NULL");
  thrum_status status = thrum_alignment_check("stress points", memory, memory_size, size, error);
  if (status != THRUM_OK)
    return status;

  // a header, the tetrahedra, and the rows of the basis at their corners
  memset(memory, 0, size);
  const int64_t count = count_of(model, def);
  const thrum_stress_points header = {STRESS_POINTS_MAGIC, model->rank, count,
                                      places_of(model, def)};
  thrum_stress_point_tet *tets = (void *)((unsigned char *)memory + tets_offset());
  for (int64_t n = 0; n < count; n++) {
    THRUM_TRY(fill_tet(model, def, n, tets + n, error));
  }
  fill_rows(model, def, (void *)((unsigned char *)memory + rows_offset(count)));

  // the header comes last, so that a failed call leaves no stress points
  memcpy(memory, &header, sizeof header);
  *stress_points = memory;
  return THRUM_OK;
}

int64_t thrum_stress_points_count(const thrum_stress_points *stress_points) {
  return stress_points ? stress_points->count : 0;
}

int32_t thrum_stress_points_tet(const thrum_stress_points *stress_points, int64_t n) {
  return data_of(stress_points)[n].tet;
}

int64_t thrum_stress_points_work_count(const thrum_stress_points *stress_points) {
  return stress_points ? 3 * stress_points->places : 0;
}

/* u of one place. */
static void displace(const double *rows, int64_t rank, const double *q, double u[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const double *row = rows + axis * rank;
    double sum = 0;
    for (int64_t i = 0; i < rank; i++)
      sum += row[i] * q[i];
    u[axis] = sum;
  }
}

/* Adds the displacement of one place: that of `work`, or made here. */
static void add_place(const thrum_stress_points *stress_points, int64_t place, const double *q,
                      const double *work, double u[3]) {
  double made[3];
  if (!work)
    displace(rows_of(stress_points) + 3 * place * stress_points->rank, stress_points->rank, q,
             made);
  for (int axis = 0; axis < 3; axis++)
    u[axis] += work ? work[3 * place + axis] : made[axis];
}

/* The twelve displacements of the corners of a tet. */
static void gather(const thrum_stress_points *stress_points, const thrum_stress_point_tet *data,
                   const double *q, const double *work, double u[12]) {
  // from -0, so that one part alone keeps all its bits
  for (int n = 0; n < 12; n++)
    u[n] = -0.0;
  for (int a = 0; a < 4; a++)
    for (int part = 0; part < data->parts; part++)
      add_place(stress_points, data->place[a][part], q, work, u + 3 * a);
}

void thrum_stress_points_strain(const thrum_stress_points *stress_points, int64_t n,
                                const double *q, double gradient[3][3], double strain[6]) {
  const thrum_stress_point_tet *data = data_of(stress_points) + n;
  double u[12];
  gather(stress_points, data, q, NULL, u);
  thrum_tet_gradient(u, data->shape, gradient);
  thrum_tet_green(gradient, strain);
}

thrum_law thrum_stress_points_law(const thrum_stress_points *stress_points, int64_t n) {
  return data_of(stress_points)[n].law;
}

static void copy(const double from[6], double *to, int64_t n) {
  if (to)
    memcpy(to + 6 * n, from, 6 * sizeof *from);
}

/* Writes the requested quantities of tetrahedron n, with the displacements u of its corners. */
static void read_tet(const thrum_stress_point_tet *data, const double u[12], int64_t n,
                     const thrum_stress_points_output *output) {
  // the strain, which exists for any deformation
  double g[3][3], strain[6], stress[6];
  double cauchy[6] = {NAN, NAN, NAN, NAN, NAN, NAN};
  thrum_tet_gradient(u, data->shape, g);
  thrum_tet_green(g, strain);
  copy(strain, output->strain, n);

  // how far it is compressed
  const double ratio = thrum_tet_volume_ratio(g);
  if (output->stretch)
    output->stretch[n] = thrum_tet_least_stretch(strain, ratio);

  // the stresses take longer, so only those that are asked for are made
  if (!output->second_piola && !output->cauchy && !output->von_mises)
    return;
  thrum_tet_law_second_piola(data->law, data->lambda, data->mu, g, strain, ratio, stress);
  copy(stress, output->second_piola, n);

  // an inverted tetrahedron has no Cauchy stress
  if (ratio > 0)
    thrum_tet_cauchy(g, ratio, stress, cauchy);
  copy(cauchy, output->cauchy, n);
  if (output->von_mises)
    output->von_mises[n] = thrum_von_mises(cauchy);
}

thrum_status thrum_stress_points_read(const thrum_stress_points *stress_points, const double *q,
                                      double *work, const thrum_stress_points_output *output,
                                      thrum_error *error) {
  if (!stress_points || stress_points->magic != STRESS_POINTS_MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the stress points were not made by thrum_stress_points_init");
  if (!q || !output)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "q or output is NULL");

  // one bad coordinate would spoil every stress
  for (int64_t i = 0; i < stress_points->rank; i++)
    if (!isfinite(q[i]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "entry %lld of q is not finite", (long long)i);

  // with room for them, displacements that tetrahedra share are made once
  const double *rows = rows_of(stress_points);
  for (int64_t v = 0; work && v < stress_points->places; v++)
    displace(rows + 3 * v * stress_points->rank, stress_points->rank, q, work + 3 * v);

  const thrum_stress_point_tet *tets = data_of(stress_points);
  for (int64_t n = 0; n < stress_points->count; n++) {
    double u[12];
    gather(stress_points, tets + n, q, work, u);
    read_tet(tets + n, u, n, output);
  }
  return THRUM_OK;
}
