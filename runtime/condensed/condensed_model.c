/* Condensed models (thrum/condensed_model.h, design 16).
 *
 * V_3 holds each monomial once, so a_h(x) = sum_{i<=j} c3_ijh x_i x_j: the coefficients of the
 * slaves in block order are read once into `follow`, slaves x pairs, -c3_ijh / w_h^2. Then
 *   y_h = sum_{i<=j} follow_h,ij x_i x_j,   c4'_ijkl = c4_ijkl - 1/2 sum_h w_h^2 follow_h,ij
 * follow_h,kl over all ordered pairs of pairs. A model that was precomputed condensed has `follow`
 * and c4' for all of its masters, so fewer masters of it are condensed in the same way.
 *
 * Orders: where the body moves by eps, a master that stretches it moves by eps^2, as the slaves do,
 * for bending drags it along. V_c is right to eps^4 only, so what it has beyond that is part of a
 * sum whose rest is missing, and is left out: monomials whose orders add up to more than 4, and
 * slaves that follow pairs of more than 2. The slaves' answer to a product of stretching and
 * bending is such a part, and it lowers V_c without bound.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/condensed_model.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/model/model_layout.h"
#include "core/polynomial/packed.h"
#include "core/polynomial/points.h"
#include "core/polynomial/polynomial_private.h"

#define STRETCHING 0.05 /* energy at which a mode stiffens over that of strains of 1 */

/* --- making ------------------------------------------------------------------------------------
 */

/* The polynomial that a model is condensed from, in `rank` coordinates. */
typedef struct source {
  int64_t rank;
  const double *c3, *c4;
} source;

static source source_of(const thrum_model *model) {
  const int64_t masters = thrum_model_masters(model);
  return masters > 0 ? (source){masters, model->condensed_c3, model->condensed_c4}
                     : (source){model->rank, model->c3, model->c4};
}

/* Doubles of the arrays of a stepped model. */
typedef struct parts {
  size_t omega2, c3, c4, follow;
} parts;

static parts parts_of(const thrum_model *model, int64_t masters) {
  return (parts){(size_t)masters, (size_t)thrum_c3_count(masters), (size_t)thrum_c4_count(masters),
                 (size_t)((model->rank - masters) * thrum_pair_count(masters))};
}

static thrum_status check(const thrum_model *model, int64_t masters, thrum_error *error) {
  if (!model || !model->omega2)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL or has no omega2");
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  const source from = source_of(model);
  if (thrum_has_points(model))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has cubature points and no polynomial to condense: make it "
                           "without --cubature");
  for (int64_t k = 0; model->actuator_kind && k < model->actuator_count; k++)
    if (model->actuator_kind[k] == THRUM_ACTUATOR_GAS)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "the model has a gas, whose stiffness a condensed one would leave "
                             "out: make it without, or step all of its coordinates");
  if (!from.c3 || !from.c4)
    return thrum_error_set(error, THRUM_MISSING, "the model has no polynomial to condense");
  if (model->shape)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model is condensed already: condense its shape model");

  // at least one coordinate follows
  const int64_t most = from.rank < model->rank ? from.rank : model->rank - 1;
  if (masters < 1 || masters > most)
    return thrum_error_set_field(error, "condense", THRUM_INVALID_ARGUMENT,
                                 " is %lld; the model can be condensed to 1 to %lld coordinates",
                                 (long long)masters, (long long)most);
  for (int64_t h = masters; h < model->rank; h++)
    if (!(model->omega2[h] > 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "coordinate %lld has no stiffness, so it cannot follow at rest",
                             (long long)h + 1);
  return THRUM_OK;
}

thrum_status thrum_model_condense_size(const thrum_model *model, int64_t masters, size_t *size,
                                       thrum_error *error) {
  THRUM_TRY(check(model, masters, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  const parts p = parts_of(model, masters);
  *size = thrum_round_up(sizeof(thrum_model)) + thrum_round_up(p.omega2 * sizeof(double)) +
          thrum_round_up(p.c3 * sizeof(double)) + thrum_round_up(p.c4 * sizeof(double)) +
          2 * thrum_round_up(p.follow * sizeof(double)) +
          (size_t)thrum_pack_all(masters) * sizeof(double);
  return THRUM_OK;
}

double thrum_model_unit_energy(const thrum_model *model) {
  double sum = 0;
  if (!model)
    return 0;
  if (!model->vertices || !model->tets || !model->tet_region || !model->material)
    return model->unit_energy;

  // a tetrahedron's volume is a sixth of the determinant of its edges
  for (int64_t t = 0; t < model->tet_count; t++) {
    const int32_t *corner = model->tets + 4 * t;
    double edge[3][3];
    for (int e = 0; e < 3; e++)
      for (int axis = 0; axis < 3; axis++)
        edge[e][axis] = model->vertices[3 * (int64_t)corner[e + 1] + axis] -
                        model->vertices[3 * (int64_t)corner[0] + axis];
    const double volume = (edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) +
                           edge[0][1] * (edge[1][2] * edge[2][0] - edge[1][0] * edge[2][2]) +
                           edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0])) /
                          6;
    sum += 0.5 * model->material[3 * (int64_t)model->tet_region[t]] * fabs(volume);
  }
  return sum;
}

/* order (masters): 2 of a master that stretches the body, 1 of one that bends or turns it. Alone, a
 * mode has as much quartic energy as quadratic at w^4 / (4 c4_iiii): rotations of order 1 without
 * strain do that early, by the fourth power of rotation over strain, and stretching only at strains
 * of order 1, which take the energy of thrum_model_unit_energy. */
static void fill_orders(const thrum_model *model, const source *from, int64_t masters,
                        uint8_t *order) {
  // a model that was precomputed condensed has left out what is to be left out
  const double whole = thrum_model_masters(model) > 0 ? 0 : thrum_model_unit_energy(model);
  for (int64_t i = 0; i < masters; i++) {
    const double c4 = from->c4[thrum_c4_index(from->rank, i, i, i, i)], w2 = model->omega2[i];
    const bool stretches = whole > 0 && c4 >= 0 && w2 * w2 >= 4 * STRETCHING * whole * c4;
    order[i] = stretches ? 2 : 1;
  }
}

/* follow: (rank - masters) x pairs. */
static void fill_follow(const thrum_model *model, const source *from, const uint8_t *order,
                        int64_t masters, double *follow) {
  const int64_t kept = thrum_model_masters(model);
  for (int64_t h = masters; h < model->rank; h++) {
    // slaves beyond the masters of the file are known as they follow, pairs i <= j, i outermost
    const double *known =
        kept > 0 && h >= kept ? model->slave_map + (h - kept) * thrum_pair_count(kept) : NULL;
    for (int64_t i = 0; i < masters; i++)
      for (int64_t j = i; j < masters; j++)
        if (order[i] + order[j] > 2)
          *follow++ = 0;
        else
          *follow++ = known ? known[thrum_pair_count(kept) - thrum_pair_count(kept - i) + j - i]
                            : -from->c3[thrum_c3_index(from->rank, i, j, h)] / model->omega2[h];
  }
}

/* Does anything follow the masters? Slaves that answer to loads alone (touch modes) have no row. */
static bool follows_masters(const double *follow, size_t count) {
  for (size_t n = 0; n < count; n++)
    if (follow[n] != 0)
      return true;
  return false;
}

static void transpose(const double *from, int64_t rows, int64_t columns, double *to) {
  for (int64_t i = 0; i < rows; i++)
    for (int64_t j = 0; j < columns; j++)
      to[j * rows + i] = from[i * columns + j];
}

/* The coefficients of the masters alone, as far as their orders allow. */
static void copy_masters(const source *from, const uint8_t *order, int64_t masters, double *c3,
                         double *c4) {
  for (int64_t i = 0; i < masters; i++)
    for (int64_t j = i; j < masters; j++)
      for (int64_t k = j; k < masters; k++) {
        const int three = order[i] + order[j] + order[k];
        c3[thrum_c3_index(masters, i, j, k)] =
            three > 4 ? 0 : from->c3[thrum_c3_index(from->rank, i, j, k)];
        for (int64_t l = k; l < masters; l++)
          c4[thrum_c4_index(masters, i, j, k, l)] =
              three + order[l] > 4 ? 0 : from->c4[thrum_c4_index(from->rank, i, j, k, l)];
      }
}

static void sort_two(int64_t *a, int64_t *b) {
  if (*a > *b) {
    const int64_t kept = *a;
    *a = *b;
    *b = kept;
  }
}

static int64_t c4_index_of(int64_t rank, int64_t i, int64_t j, int64_t k, int64_t l) {
  // a network of five exchanges sorts four numbers; i <= j and k <= l come sorted
  sort_two(&i, &k);
  sort_two(&j, &l);
  sort_two(&j, &k);
  return thrum_c4_index(rank, i, j, k, l);
}

/* c4 -= 1/2 sum_h w_h^2 y_h(x)^2, of the slaves that the source's c4 does not yet know. */
static void relax(const thrum_model *model, int64_t masters, const double *follow, double *c4) {
  const int64_t pairs = thrum_pair_count(masters), kept = thrum_model_masters(model);
  const int64_t end = kept > 0 ? kept : model->rank;

  // all pairs of pairs of masters, whose product is a monomial of degree 4
  int64_t first = 0;
  for (int64_t i = 0; i < masters; i++)
    for (int64_t j = i; j < masters; j++, first++) {
      int64_t second = 0;
      for (int64_t k = 0; k < masters; k++)
        for (int64_t l = k; l < masters; l++, second++) {
          double sum = 0;
          for (int64_t h = masters; h < end; h++) {
            const double *row = follow + (h - masters) * pairs;
            sum += model->omega2[h] * row[first] * row[second];
          }
          c4[c4_index_of(masters, i, j, k, l)] -= 0.5 * sum;
        }
    }
}

/* The rank, the frequencies and the shape of the stepped model; the mesh stays with the shape. */
static thrum_model header_of(const thrum_model *model, int64_t masters) {
  thrum_model stepped = {.rank = masters,
                         .c3_count = thrum_c3_count(masters),
                         .c4_count = thrum_c4_count(masters),
                         .format = model->format,
                         .shape = model};
  return stepped;
}

thrum_status thrum_model_condense(void *memory, size_t memory_size, const thrum_model *model,
                                  int64_t masters, const thrum_model **condensed,
                                  thrum_error *error) {
  // the memory is checked before it is touched
  size_t size = 0;
  THRUM_TRY(thrum_model_condense_size(model, masters, &size, error));
  if (!memory || !condensed)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or condensed is NULL");
  THRUM_TRY(thrum_alignment_check("model", memory, memory_size, size, error));

  // where each array stands
  const source from = source_of(model);
  const parts p = parts_of(model, masters);
  unsigned char *at = (unsigned char *)memory + thrum_round_up(sizeof(thrum_model));
  double *omega2 = thrum_cut_doubles(&at, p.omega2), *c3 = thrum_cut_doubles(&at, p.c3),
         *c4 = thrum_cut_doubles(&at, p.c4);
  double *follow = thrum_cut_doubles(&at, p.follow), *by_pair = thrum_cut_doubles(&at, p.follow);

  // the masters' own polynomial, less the energy that the slaves give up
  uint8_t order[THRUM_RANK_MAX];
  fill_orders(model, &from, masters, order);
  memcpy(omega2, model->omega2, p.omega2 * sizeof *omega2);
  fill_follow(model, &from, order, masters, follow);
  transpose(follow, model->rank - masters, thrum_pair_count(masters), by_pair);
  copy_masters(&from, order, masters, c3, c4);
  relax(model, masters, follow, c4);
  for (size_t n = 0; n < p.c4; n++)
    if (!isfinite(c4[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the condensed model leaves the range of numbers");

  // the struct, with the packed coefficients behind the arrays
  thrum_model stepped = header_of(model, masters);
  stepped.omega2 = omega2;
  stepped.c3 = c3;
  stepped.c4 = c4;
  stepped.follow = follows_masters(follow, p.follow) ? follow : NULL;
  stepped.follow_by_pair = stepped.follow ? by_pair : NULL;
  stepped.follow_scale = 1.0;
  THRUM_TRY(thrum_model_pack(&stepped, at, size - (size_t)(at - (unsigned char *)memory), error));
  stepped.identity = thrum_model_identity(&stepped);
  memcpy(memory, &stepped, sizeof stepped);
  *condensed = memory;
  return THRUM_OK;
}

/* --- showing -----------------------------------------------------------------------------------
 */

const thrum_model *thrum_condensed_shape_model(const thrum_model *model) {
  return model && model->shape ? model->shape : model;
}

/* Number of slaves of a stepped model. */
static int64_t slaves_of(const thrum_model *model) {
  return model->shape ? model->shape->rank - model->rank : 0;
}

void thrum_condensed_shape(const thrum_model *model, const double *x, const double *load,
                           double *q) {
  const int64_t masters = model->rank, slaves = slaves_of(model);
  const double *row = model->follow;
  memcpy(q, x, (size_t)masters * sizeof *q);
  for (int64_t s = 0; s < slaves; s++) {
    // the pairs of one i share a factor
    double sum = load ? load[masters + s] / model->shape->omega2[masters + s] : 0;
    for (int64_t i = 0; row && i < masters; i++) {
      double part = 0;
      for (int64_t j = i; j < masters; j++)
        part += *row++ * x[j];
      sum += x[i] * part;
    }
    q[masters + s] = sum;
  }
}

/* dy/dt of one slave, whose row is taken; *row moves on to the next slave's. */
static double slave_speed(const double **row, int64_t masters, const double *x, const double *v) {
  double speed = 0;
  for (int64_t i = 0; i < masters; i++)
    for (int64_t j = i; j < masters; j++)
      speed += *(*row)++ * (v[i] * x[j] + x[i] * v[j]);
  return speed;
}

void thrum_condensed_velocity(const thrum_model *model, const double *x, const double *v,
                              double *p) {
  const int64_t masters = model->rank, slaves = slaves_of(model);
  const double *row = model->follow;
  memcpy(p, v, (size_t)masters * sizeof *p);
  for (int64_t s = 0; s < slaves; s++)
    p[masters + s] = row ? slave_speed(&row, masters, x, v) : 0;
}

void thrum_condensed_load(const thrum_model *model, const double *x, const double *load,
                          double *reduced) {
  const int64_t masters = model->rank, slaves = slaves_of(model);
  const double *row = model->follow;
  memcpy(reduced, load, (size_t)masters * sizeof *reduced);
  for (int64_t s = 0; row && s < slaves; s++) {
    const double force = load[masters + s];
    for (int64_t i = 0; i < masters; i++)
      for (int64_t j = i; j < masters; j++, row++) {
        reduced[i] += force * *row * x[j];
        reduced[j] += force * *row * x[i];
      }
  }
}

double thrum_condensed_inertia_share(const thrum_model *model, const double *x, const double *v) {
  // the velocities of the slaves, one after the other
  const int64_t masters = model->rank, slaves = slaves_of(model);
  const double *row = model->follow;
  double whole = 0, left_out = 0;
  for (int64_t i = 0; i < masters; i++)
    whole += v[i] * v[i];
  for (int64_t s = 0; row && s < slaves; s++) {
    const double speed = slave_speed(&row, masters, x, v);
    left_out += speed * speed;
  }
  return left_out > 0 ? left_out / (whole + left_out) : 0;
}
