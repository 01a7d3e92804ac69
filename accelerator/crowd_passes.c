/* The passes of a crowd over a part of its bodies, in the order of accelerator/README.md.
 * SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/crowd_private.h"

crowd_part crowd_part_at(thrum_crowd *crowd, int64_t at) {
  const int64_t left = crowd->all - at;
  return (crowd_part){.crowd = crowd,
                      .at = at,
                      .count = crowd->all,
                      .bodies = (size_t)(left < crowd->part ? left : crowd->part)};
}

#define A(x) DEVICE_ARGUMENT(x)
#define COUNT(list) (uint32_t)(sizeof(list) / sizeof *(list))

static device_argument real_of(const thrum_crowd *crowd, device_number *kept, double value) {
  return device_number_of(crowd->accelerator, kept, value);
}

/* An item for LANES bodies, or for each; and for each coordinate of them. */
static void items_of(const crowd_part *t, bool lanes, bool coordinates, size_t items[2]) {
  items[0] = lanes ? t->bodies / (size_t)t->crowd->accelerator->lanes : t->bodies;
  items[1] = coordinates ? (size_t)t->crowd->rank : 1;
}

static thrum_status run(const crowd_part *t, opencl_kernel kernel, const device_argument *arguments,
                        uint32_t count, bool lanes, bool coordinates, thrum_error *error) {
  size_t items[2];
  items_of(t, lanes, coordinates, items);
  return device_run(t->crowd->accelerator, kernel, arguments, count, items, error);
}

// A' times the first `count` rows of x from `first` on
static thrum_status multiply_rows(const crowd_part *t, int64_t first, int64_t count,
                                  opencl_buffer y, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const size_t items[2] = {t->bodies / (size_t)c->accelerator->wide, (size_t)(c->columns / GROUP)};
  const int32_t from = (int32_t)first, rows = (int32_t)count;
  const device_argument arguments[] = {A(c->matrix), A(c->x), A(from), A(rows), A(y)};
  return device_run(c->accelerator, c->pass_multiply, arguments, COUNT(arguments), items, error);
}

// q + share d, and the products of its pairs, into x
static thrum_status products(const crowd_part *t, double share, int64_t rows, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  device_number kept;
  const device_argument arguments[] = {
      A(c->q), A(c->d), real_of(c, &kept, share), A(c->pair_list), A(c->x), A(t->at), A(t->count)};
  const size_t items[2] = {t->bodies / (size_t)c->accelerator->lanes, (size_t)rows};
  return device_run(c->accelerator, c->pass_products, arguments, COUNT(arguments), items, error);
}

// T and R at q + share d of a polynomial need these two products
static thrum_status multiply(const crowd_part *t, double share, opencl_buffer y3, opencl_buffer y4,
                             thrum_error *error) {
  thrum_crowd *c = t->crowd;
  THRUM_TRY(products(t, share, c->rank + c->pairs, error));
  THRUM_TRY(multiply_rows(t, 0, c->rank, y3, error));
  return multiply_rows(t, c->rank, c->pairs, y4, error);
}

static thrum_status force(const crowd_part *t, double share, opencl_buffer y3, opencl_buffer y4,
                          opencl_buffer f, opencl_buffer along, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  device_number kept;
  const device_argument arguments[] = {
      A(c->q),  A(c->d),    real_of(c, &kept, share), A(c->omega2), A(y3), A(y4), A(f), A(along),
      A(t->at), A(t->count)};
  return run(t, c->pass_force, arguments, COUNT(arguments), true, true, error);
}

// the displacement gradients at the points of q + share d
static thrum_status gradients(const crowd_part *t, double share, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  THRUM_TRY(products(t, share, c->rank, error));
  return multiply_rows(t, 0, c->rank, c->g, error);
}

// R and T d of cubature points at q + share d
static thrum_status point_force(const crowd_part *t, double share, opencl_buffer f,
                                opencl_buffer along, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const size_t lanes = (size_t)c->accelerator->lanes;
  const device_argument increments[] = {A(c->d), A(c->x)};
  THRUM_TRY(gradients(t, share, error));
  THRUM_TRY(run(t, c->pass_increments, increments, COUNT(increments), true, true, error));
  THRUM_TRY(multiply_rows(t, 0, c->rank, c->g_along, error));

  const device_argument points[] = {A(c->g),       A(c->g_along), A(c->point_moduli),
                                    A(c->weights), A(c->pull),    A(c->pull_along)};
  const size_t items[2] = {t->bodies / lanes, (size_t)c->points};
  THRUM_TRY(device_run(c->accelerator, c->pass_points, points, COUNT(points), items, error));
  device_number kept;
  const device_argument arguments[] = {A(c->q),          A(c->d),      real_of(c, &kept, share),
                                       A(c->omega2),     A(c->matrix), A(c->pull),
                                       A(c->pull_along), A(f),         A(along),
                                       A(t->at),         A(t->count)};
  return run(t, c->pass_point_force, arguments, COUNT(arguments), true, true, error);
}

// R and T d at q + share d, and T into y3 and y4; with points T at the place of the last R
static thrum_status evaluate(const crowd_part *t, double share, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  if (c->points == 0) {
    THRUM_TRY(multiply(t, share, c->y3, c->y4, error));
    return force(t, share, c->y3, c->y4, c->now, c->along, error);
  }
  THRUM_TRY(point_force(t, share, c->now, c->along, error));
  if (c->form == THRUM_STEP_VERLET)
    return THRUM_OK;
  const device_argument arguments[] = {A(c->matrix),  A(c->g),  A(c->point_moduli),
                                       A(c->weights), A(c->y3), A(c->y4)};
  return run(t, c->pass_point_tangent, arguments, COUNT(arguments), true, true, error);
}

// the same forces where the step begins, with the increment so far
static thrum_status evaluate_start(const crowd_part *t, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  return c->points > 0 ? point_force(t, 0.0, c->before, c->along_before, error)
                       : force(t, 0.0, c->start3, c->start4, c->before, c->along_before, error);
}

static thrum_status begin(const crowd_part *t, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const device_argument arguments[] = {A(c->p), A(c->length), A(c->d), A(t->at), A(t->count)};
  return run(t, c->pass_begin, arguments, COUNT(arguments), true, true, error);
}

static thrum_status iterate(const crowd_part *t, int32_t mean, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const device_argument arguments[] = {
      A(c->q),      A(c->p),      A(c->load), A(c->length),       A(c->drag),
      A(c->omega2), A(c->before), A(c->now),  A(c->along_before), A(c->along),
      A(c->y3),     A(c->y4),     A(mean),    A(c->factor),       A(c->d),
      A(c->worst),  A(t->at),     A(t->count)};
  return run(t, c->pass_iterate, arguments, COUNT(arguments), true, false, error);
}

static thrum_status commit(const crowd_part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const float tolerance = (float)c->def.tolerance;
  const device_argument arguments[] = {A(c->q),     A(c->p),      A(c->d),       A(c->length),
                                       A(c->worst), A(tolerance), A(c->stopped), A(made),
                                       A(t->at),    A(t->count)};
  return run(t, c->pass_commit, arguments, COUNT(arguments), false, false, error);
}

static thrum_status kick(const crowd_part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  device_number kept;
  const device_argument arguments[] = {A(c->q),
                                       A(c->p),
                                       A(c->now),
                                       A(c->load),
                                       A(c->load_before),
                                       A(c->drag),
                                       real_of(c, &kept, c->def.state.dt),
                                       A(c->stopped),
                                       A(made),
                                       A(t->at),
                                       A(t->count)};
  return run(t, c->pass_kick, arguments, COUNT(arguments), false, false, error);
}

// R at q into `now`
static thrum_status force_here(const crowd_part *t, thrum_error *error) {
  THRUM_TRY(begin(t, error));
  return evaluate(t, 0.0, error);
}

/* --- steps ------------------------------------------------------------------------------------ */

thrum_status crowd_step_part(const crowd_part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  if (c->form == THRUM_STEP_VERLET) {
    THRUM_TRY(force_here(t, error));
    return kick(t, made, error);
  }
  THRUM_TRY(begin(t, error));

  // the discrete gradient takes the forces at both ends, the midpoint rule that in the middle
  const bool mean = c->form != THRUM_STEP_MIDPOINT;
  const double share = mean ? 1.0 : 0.5;
  if (mean && c->points == 0)
    THRUM_TRY(multiply(t, 0.0, c->start3, c->start4, error));
  for (int32_t k = 0; k < c->def.iterations; k++) {
    if (mean)
      THRUM_TRY(evaluate_start(t, error));
    THRUM_TRY(evaluate(t, share, error));
    THRUM_TRY(iterate(t, mean, error));
  }
  return commit(t, made, error);
}

/* --- momentum and energy ---------------------------------------------------------------------- */

// see staggered_momentum.c of the core
thrum_status crowd_shift_part(const crowd_part *t, bool back, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  device_number kept;
  const device_argument h = real_of(c, &kept, c->def.state.dt);
  const device_argument to[] = {A(c->p), A(c->now), A(c->load_before), A(c->drag),
                                h,       A(t->at),  A(t->count)};
  const device_argument from[] = {A(c->p), A(c->now),   A(c->load_before), A(c->drag),
                                  h,       A(c->timed), A(t->at),          A(t->count)};
  THRUM_TRY(force_here(t, error));
  return back ? run(t, c->pass_shift_back, to, COUNT(to), false, true, error)
              : run(t, c->pass_shift_on, from, COUNT(from), false, true, error);
}

thrum_status crowd_energies_part(const crowd_part *t, opencl_buffer p, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  THRUM_TRY(begin(t, error));
  if (c->points > 0) {
    const device_argument arguments[] = {
        A(c->q),       A(p),          A(c->omega2), A(c->g),  A(c->point_moduli),
        A(c->weights), A(c->kinetic), A(c->strain), A(t->at), A(t->count)};
    THRUM_TRY(gradients(t, 0.0, error));
    return run(t, c->pass_point_energies, arguments, COUNT(arguments), true, false, error);
  }
  const device_argument arguments[] = {A(c->q),      A(p),     A(c->omega2),
                                       A(c->y3),     A(c->y4), A(c->kinetic),
                                       A(c->strain), A(t->at), A(t->count)};
  THRUM_TRY(multiply(t, 0.0, c->y3, c->y4, error));
  return run(t, c->pass_energies, arguments, COUNT(arguments), true, false, error);
}
