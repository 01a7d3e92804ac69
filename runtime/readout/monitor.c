/* Monitors: planning, laying out, looking (thrum/monitor.h, design 10).
 *
 * Reach is max_v |U_v q| / (0.1 diagonal) over one vertex a basis vector, the one that it moves
 * furthest. The load's share outside span(MU) in the norm of M^-1 is, as U^T M U = 1 and Z
 * likewise, sqrt(1 - |U^T f|^2 / (f^T M^-1 f - |Z^T f|^2)).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/monitor.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/def.h"
#include "core/base/vec3.h"
#include "runtime/material/material_law.h"
#include "runtime/readout/stress_private.h"
#include "runtime/readout/tet_strain.h"

#define MONITOR_MAGIC UINT64_C(0x7468726d6d6f3031)
#define SAMPLED 0.1     /* displacement that precompute's derivatives are scaled for, design 2 */
#define NOTHING 1e-24   /* a load of which less than this part is left moves a body as a whole */
#define SAMPLED_TETS 64 /* by default */
#define RIGID 6

/* Of the numbers in solid_form, thrum/model.h. */
enum { SOLID_SHELL_WEDGE = 6, SOLID_SHELL_HEXAHEDRON = 7 };

/* The header; behind it, each at a multiple of 64: sampled tets (count i4), tips (rank x 3 x rank),
 * mass (vertex_count), stress points. */
struct thrum_monitor {
  uint64_t magic;
  thrum_monitor_def def;
  int64_t rank;
  int64_t vertex_count;
  int64_t sampled_tet_count;
  double unit;               /* unit of reach [m] */
  bool mixed;                /* regions have laws of their own */
  size_t tips, mass, points; /* offsets */
};

const char *thrum_warning_text(thrum_warning warning) {
  switch (warning) {
#define X(name, bit, text)                                                                         \
  case THRUM_WARNING_##name:                                                                       \
    return text;
    THRUM_WARNING_LIST(X)
#undef X
  }
  return NULL;
}

void thrum_monitor_def_init(thrum_monitor_def *def, size_t size) {
  const thrum_monitor_def defaults = {.cookie = sizeof(thrum_monitor_def),
                                      .sampled_tet_count = SAMPLED_TETS,
                                      .stretch_least = 1 / sqrt(3.0),
                                      .reach_most = 3,
                                      .load_share_most = 1};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

void thrum_monitor_clear(thrum_monitor_record *record) {
  *record = (thrum_monitor_record){.stretch = 1, .stretch_least = INFINITY, .stretch_tet = -1};
}

/* A thin element turns where it is bent, and tetrahedra that are cut from it are strained by that:
 * to a stretch of 0.45 where the element has 0.985. */
static bool shape_is_cut_thin(const thrum_model *model) {
  for (int64_t e = 0; e < model->solid_count; e++)
    if (model->solid_form[e] == SOLID_SHELL_WEDGE || model->solid_form[e] == SOLID_SHELL_HEXAHEDRON)
      return true;
  return false;
}

/* The model as one of tetrahedra, whose stretches are near those of thick elements. */
static thrum_model tets_of(const thrum_model *model) {
  thrum_model tets = *model;
  tets.solid_count = 0;
  return tets;
}

static thrum_status check_def(const thrum_model *model, const thrum_monitor_def *def,
                              thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_default_monitor_def");
  if (!model->basis || !model->tets)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or no basis, so there is nothing to monitor");

  if (def->sampled_tets && shape_is_cut_thin(model))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "tetrahedra are given to sample, and the model has solid-shells, whose "
                           "strains they do not have");

  // the tetrahedra that it chooses itself are limited in number
  if (def->sampled_tet_count < 1 ||
      (!def->sampled_tets && def->sampled_tet_count > THRUM_SAMPLED_TETS_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a monitor is asked for %lld sampled tets; it chooses 1 to %d",
                           (long long)def->sampled_tet_count, THRUM_SAMPLED_TETS_MAX);

  // written so that NaN is refused as well
  if (!(def->stretch_least >= 0) || !(def->reach_most >= 0) || !(def->load_share_most >= 0) ||
      !(def->load_share_most <= 1))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a threshold is negative or no number, or the load's is above 1");
  return THRUM_OK;
}

/* Number of sampled tetrahedra of this def. */
static int64_t sampled_tets_of(const thrum_model *model, const thrum_monitor_def *def) {
  if (shape_is_cut_thin(model))
    return 0;
  return def->sampled_tets || def->sampled_tet_count < model->tet_count ? def->sampled_tet_count
                                                                        : model->tet_count;
}

/* Offsets of the parts; the stress points' is the bytes before them. */
static thrum_monitor plan(const thrum_model *model, const thrum_monitor_def *def) {
  thrum_monitor m = {.magic = MONITOR_MAGIC,
                     .def = *def,
                     .rank = model->rank,
                     .vertex_count = model->vertex_count,
                     .sampled_tet_count = sampled_tets_of(model, def)};
  m.tips = thrum_round_up(sizeof m) + thrum_round_up((size_t)m.sampled_tet_count * sizeof(int32_t));
  m.mass = m.tips + thrum_round_up((size_t)(3 * m.rank * m.rank) * sizeof(double));
  m.points = m.mass + thrum_round_up((size_t)m.vertex_count * sizeof(double));
  m.def.sampled_tets = NULL;
  return m;
}

thrum_status thrum_monitor_size(const thrum_model *model, const thrum_monitor_def *def,
                                size_t *size, thrum_error *error) {
  thrum_monitor_def whole = thrum_default_monitor_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(check_def(model, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  // stress points on chosen tets take bytes by their number alone, so those given or, before the
  // choice is made, tet 0 as often
  static const int32_t first = 0;
  const thrum_monitor m = plan(model, def);
  const thrum_model tets = tets_of(model);
  const thrum_stress_points_def points = {def->sampled_tets ? def->sampled_tets : &first,
                                          def->sampled_tets ? m.sampled_tet_count : 1};
  size_t bytes = 0;
  THRUM_TRY(thrum_stress_points_size(&tets, &points, &bytes, error));
  *size = m.points + bytes * (size_t)(def->sampled_tets ? 1 : m.sampled_tet_count);
  return THRUM_OK;
}

static const void *at(const thrum_monitor *monitor, size_t offset) {
  return (const unsigned char *)monitor + offset;
}

int64_t thrum_monitor_sampled_tets(const thrum_monitor *monitor, const int32_t **tets) {
  if (tets)
    *tets = monitor ? at(monitor, thrum_round_up(sizeof *monitor)) : NULL;
  return monitor ? monitor->sampled_tet_count : 0;
}

/* The three rows of U of the vertex that a basis vector moves furthest, for each. */
static void fill_tips(const thrum_model *model, double *tips) {
  const int64_t rank = model->rank;

  // the squared length of each vertex's movement in the mode
  for (int64_t mode = 0; mode < rank; mode++) {
    double largest = -1;
    int64_t vertex = 0;
    for (int64_t v = 0; v < model->vertex_count; v++) {
      double square = 0;
      for (int axis = 0; axis < 3; axis++) {
        const double value = model->basis[(3 * v + axis) * rank + mode];
        square += value * value;
      }
      if (square > largest) {
        largest = square;
        vertex = v;
      }
    }

    memcpy(tips + 3 * mode * rank, model->basis + 3 * vertex * rank,
           (size_t)(3 * rank) * sizeof *tips);
  }
}

/* Shares of a corner and of a middle node in a ten-node tet whose diagonal is scaled to its mass.
 */
static const double corner_share = 1.0 / 36, middle_share = 4.0 / 27;

/* rho vol / 4 of each tet to its corners; of a ten-node tet the lumped mass that its edges would
 * have if they were straight. */
static void fill_mass(const thrum_model *model, double *mass) {
  for (int64_t t = 0; t < model->tet_count; t++) {
    const int32_t *corner = model->tets + 4 * t;
    double e[3][3];
    thrum_tet_edges(model->vertices, corner, e);
    const double six = thrum_triple3(e[0], e[1], e[2]);
    const double density = model->material[3 * (int64_t)model->tet_region[t] + 2];
    for (int a = 0; a < 4; a++)
      mass[corner[a]] += model->midsides ? corner_share * density * six / 6 : density * six / 24;
    for (int n = 0; n < 6 && model->midsides; n++)
      mass[model->midsides[6 * t + n]] += middle_share * density * six / 6;
  }
}

/* Takes the given sampled tets, or chooses them. */
static thrum_status fill_sampled_tets(const thrum_model *model, const thrum_monitor_def *def,
                                      int64_t *count, int32_t *tets, thrum_error *error) {
  if (!def->sampled_tets)
    return thrum_sampled_tets_choose(model, *count, tets, count, error);
  memcpy(tets, def->sampled_tets, (size_t)*count * sizeof *tets);
  return THRUM_OK;
}

thrum_status thrum_monitor_init(void *memory, size_t memory_size, const thrum_model *model,
                                const thrum_monitor_def *def, const thrum_monitor **monitor,
                                thrum_error *error) {
  thrum_monitor_def whole = thrum_default_monitor_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  size_t size;
  THRUM_TRY(thrum_monitor_size(model, def, &size, error));
  if (!memory || !monitor)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or monitor is NULL");
  THRUM_TRY(thrum_alignment_check("monitor", memory, memory_size, size, error));

  // gaps between the parts are zero, so equal monitors have equal bytes
  memset(memory, 0, size);
  thrum_monitor made = plan(model, def);
  unsigned char *bytes = memory;
  int32_t *tets = (void *)(bytes + thrum_round_up(sizeof made));
  if (made.sampled_tet_count > 0)
    THRUM_TRY(fill_sampled_tets(model, def, &made.sampled_tet_count, tets, error));

  // the sampled tetrahedra's strain is that of stress points
  const thrum_model of_tets = tets_of(model);
  const thrum_stress_points_def points = {tets, made.sampled_tet_count};
  const thrum_stress_points *stress_points;
  if (made.sampled_tet_count > 0)
    THRUM_TRY(thrum_stress_points_init(bytes + made.points, size - made.points, &of_tets, &points,
                                       &stress_points, error));

  // the header is written last: a failure leaves no monitor behind
  fill_tips(model, (void *)(bytes + made.tips));
  fill_mass(model, (void *)(bytes + made.mass));
  if (!thrum_law_gives_way(model, thrum_law_of_model(model)))
    made.def.stretch_least = 0; // no other law gives way
  made.mixed = thrum_law_of_model(model) == THRUM_LAW_BY_REGION;
  made.unit = SAMPLED * thrum_box3_diagonal(model->vertices, model->vertex_count);
  memcpy(memory, &made, sizeof made);
  *monitor = memory;
  return THRUM_OK;
}

static thrum_status check(const thrum_monitor *monitor, const thrum_monitor_record *record,
                          thrum_error *error) {
  if (!monitor || monitor->magic != MONITOR_MAGIC || !record)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the monitor was not made by thrum_monitor_init, or record is NULL");
  return THRUM_OK;
}

/* The least principal stretch of the sampled tets, or of those whose law gives way, and the place
 * of the one that has it. */
static double least_stretch(const thrum_monitor *monitor, const double *q, bool gives_way,
                            int64_t *place) {
  const thrum_stress_points *stress_points = at(monitor, monitor->points);
  double least = INFINITY;
  for (int64_t n = 0; n < monitor->sampled_tet_count; n++) {
    double g[3][3], strain[6];
    if (gives_way && thrum_stress_points_law(stress_points, n) != THRUM_LAW_STVK)
      continue;
    thrum_stress_points_strain(stress_points, n, q, g, strain);
    const double ratio = thrum_tet_volume_ratio(g);

    // most tets are so little strained that they cannot be the least
    if (ratio > 0 && thrum_tet_stretch_bound(strain) > least)
      continue;
    const double stretch = thrum_tet_least_stretch(strain, ratio);

    // an overflow, which is no number, counts as the worst
    if (!(stretch >= least)) {
      least = isnan(stretch) ? -INFINITY : stretch;
      *place = n;
    }
  }
  return least;
}

static double reach_of(const thrum_monitor *monitor, const double *q) {
  const double *row = at(monitor, monitor->tips);
  double most = 0;
  for (int64_t tip = 0; tip < monitor->rank; tip++) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++, row += monitor->rank) {
      double u = 0;
      for (int64_t i = 0; i < monitor->rank; i++)
        u += row[i] * q[i];
      square += u * u;
    }
    most = square > most ? square : most;
  }
  return sqrt(most) / monitor->unit;
}

thrum_status thrum_monitor_look(const thrum_monitor *monitor, const double *q,
                                thrum_monitor_record *record, thrum_error *error) {
  THRUM_TRY(check(monitor, record, error));
  if (!q)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "q is NULL");
  for (int64_t i = 0; i < monitor->rank; i++)
    if (!isfinite(q[i]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "entry %lld of q is not finite", (long long)i);

  // the look itself
  int64_t place = 0, other = 0;
  record->stretch = least_stretch(monitor, q, false, &place);
  const double weak = monitor->mixed ? least_stretch(monitor, q, true, &other) : record->stretch;
  record->reach = reach_of(monitor, q);
  record->looks++;

  // extremes over all looks
  if (record->stretch < record->stretch_least) {
    const int32_t *tets;
    thrum_monitor_sampled_tets(monitor, &tets);
    record->stretch_least = record->stretch;
    record->stretch_tet = tets[place];
  }
  record->reach_most = fmax(record->reach_most, record->reach);

  // the bit of the load stays: this look says nothing about it
  const thrum_monitor_def *def = &monitor->def;
  record->warnings_now = (record->warnings_now & THRUM_WARNING_LOAD) |
                         (weak < def->stretch_least ? THRUM_WARNING_COMPRESSED : 0) |
                         (record->stretch < 0 ? THRUM_WARNING_INVERTED : 0) |
                         (record->reach > def->reach_most ? THRUM_WARNING_REACH : 0);
  record->warnings |= record->warnings_now;
  return THRUM_OK;
}

/* |A^T f|^2 over the components that may move; A: 3 vertex_count x columns. */
static double product_square(const thrum_model *model, const double *matrix, int64_t columns,
                             const double *forces) {
  double sum[THRUM_RANK_MAX] = {0}, square = 0;
  for (int64_t c = 0; c < 3 * model->vertex_count; c++) {
    if (forces[c] == 0 || (model->fixed[c / 3] >> (c % 3) & 1))
      continue;
    for (int64_t i = 0; i < columns; i++)
      sum[i] += matrix[c * columns + i] * forces[c];
  }
  for (int64_t i = 0; i < columns; i++)
    square += sum[i] * sum[i];
  return square;
}

thrum_status thrum_monitor_look_at_load(const thrum_monitor *monitor, const thrum_model *model,
                                        const double *forces, thrum_monitor_record *record,
                                        thrum_error *error) {
  THRUM_TRY(check(monitor, record, error));
  if (!model || !forces || model->rank != monitor->rank ||
      model->vertex_count != monitor->vertex_count || !model->basis)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "forces is NULL, or the monitor belongs to another model");

  // the square of the load in the norm of M^-1, over the components that may move
  const double *mass = at(monitor, monitor->mass);
  double whole = 0;
  for (int64_t c = 0; c < 3 * model->vertex_count; c++) {
    if (!isfinite(forces[c]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "entry %lld of the forces is not finite",
                             (long long)c);
    // a vertex of no tet has no mass and no rows of U either
    if (mass[c / 3] > 0 && !(model->fixed[c / 3] >> (c % 3) & 1))
      whole += forces[c] * forces[c] / mass[c / 3];
  }

  // U and Z are orthonormal in M, so their shares are sums of squares
  const double rigid = model->rigid ? product_square(model, model->rigid, RIGID, forces) : 0;
  const double rest = whole - rigid;
  const double felt = product_square(model, model->basis, model->rank, forces);
  record->load_share = rest > NOTHING * whole ? sqrt(fmax(0, 1 - felt / rest)) : 0;

  const uint32_t bit = record->load_share > monitor->def.load_share_most ? THRUM_WARNING_LOAD : 0;
  record->warnings_now = (record->warnings_now & ~(uint32_t)THRUM_WARNING_LOAD) | bit;
  record->warnings |= bit;
  return THRUM_OK;
}
