/* Crowds: many states of one model on a device (thrum/accelerator.h).
 *
 * Bodies are stepped in parts of at most PART_MOST, each for all steps asked for, in scratch that
 * all parts use in turn. The host puts the passes of crowd.cl into the queue and waits at the end.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accelerator/coefficients.h"
#include "accelerator/device.h"
#include "core/base/def.h"
#include "thrum/actuation.h"
#include "thrum/step_equation.h"

#define GROUP 8        /* columns of a work-item of the product, as in crowd.cl */
#define TOGETHER 64    /* bodies that counts are rounded up to */
#define PART_MOST 4096 /* bodies of a part: a tile of each compute unit of a large device */
#define RANK_MOST 128  /* whose coefficients take 273 MB as a matrix */
#define ITERATIONS_MOST 32
#define QUEUE_STEPS 64 /* that are put into the queue before the host waits */

static const char source[] = {
#include "crowd_program.inc"
};

/* X(name): the passes, by their names in crowd.cl. */
#define PASSES(X)                                                                                  \
  X(products)                                                                                      \
  X(shift_back) X(shift_on) X(multiply) X(force) X(begin) X(iterate) X(commit) X(kick) X(energies)

struct thrum_crowd {
  thrum_accelerator *accelerator;
  thrum_crowd_def def;
  int64_t rank, pairs, columns;
  int64_t all, part; /* bodies with those that fill up, which rest; bodies of a part */
  thrum_step_form form;
  opencl_program program;
#define X(name) opencl_kernel name;
  PASSES(X)
#undef X
  /* of all bodies; of the model; of a part */
  opencl_buffer q, p, timed, load, load_before, stopped;
  opencl_buffer matrix, pair_list, omega2, length, drag;
  opencl_buffer d, x, y3, y4, start3, start4, before, along_before, now, along, factor, worst;
  opencl_buffer kinetic, strain;
  void *staging;  /* rank x all numbers of the device's precision, or as many counts */
  int64_t *flags; /* all */
  int64_t made;   /* steps since the bodies were set */
};

void thrum_crowd_def_init(thrum_crowd_def *def, size_t size) {
  thrum_crowd_def defaults = {.cookie = sizeof(thrum_crowd_def),
                              .iterations = 4,
                              .count = 1,
                              .tolerance = 1e-4,
                              .state = thrum_default_state_def()};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

/* --- what is asked for ------------------------------------------------------------------------ */

static thrum_status refuse(thrum_error *error, const char *field, const char *what) {
  thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s %s", field, what);
  if (error)
    error->field = field;
  return THRUM_INVALID_ARGUMENT;
}

static thrum_status check_def(const thrum_crowd_def *def, thrum_error *error) {
  if (def->count < 1 || def->count > INT32_MAX)
    return refuse(error, "count", "is not 1 to 2147483647");
  if (def->iterations < 1 || def->iterations > ITERATIONS_MOST)
    return refuse(error, "iterations", "is not 1 to 32");
  if (!(def->tolerance > 0) || !isfinite(def->tolerance))
    return refuse(error, "tolerance", "is not above 0 and finite");
  return THRUM_OK;
}

static thrum_status check_model(const thrum_model *model, const thrum_state_def *state,
                                thrum_error *error) {
  if (!model->c3 || !model->c4)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a crowd steps polynomials, and this model has none: make it without "
                           "--cubature, or condense it");
  if (thrum_model_actuators(model) > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a crowd has no actuators, and this model has some: step it by "
                           "thrum_batch_step");
  if (model->rank > RANK_MOST)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has rank %lld, and a crowd takes up to %d: condense it",
                           (long long)model->rank, RANK_MOST);
  if (state->integrator != THRUM_INTEGRATOR_VERLET &&
      state->integrator != THRUM_INTEGRATOR_MIDPOINT &&
      state->integrator != THRUM_INTEGRATOR_ENERGY)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a crowd is stepped by energy, midpoint or verlet, not by %s",
                           thrum_integrator_name(state->integrator));
  return THRUM_OK;
}

/* --- numbers of the device -------------------------------------------------------------------- */

// `from` (count) in the precision of the device, into `to`
static void narrow(const thrum_crowd *crowd, const double *from, int64_t count, void *to) {
  if (!crowd->accelerator->info.single) {
    memcpy(to, from, (size_t)count * sizeof *from);
    return;
  }
  for (int64_t i = 0; i < count; i++)
    ((float *)to)[i] = (float)from[i];
}

// rows of bodies as columns, into the staging
static void turn(thrum_crowd *crowd, const double *rows, int64_t stride) {
  for (int64_t n = 0; n < crowd->all; n++)
    for (int64_t i = 0; i < crowd->rank; i++) {
      const double value = rows && n < crowd->def.count ? rows[n * stride + i] : 0;
      if (crowd->accelerator->info.single)
        ((float *)crowd->staging)[i * crowd->all + n] = (float)value;
      else
        ((double *)crowd->staging)[i * crowd->all + n] = value;
    }
}

static double staged(const thrum_crowd *crowd, int64_t at) {
  return crowd->accelerator->info.single ? (double)((const float *)crowd->staging)[at]
                                         : ((const double *)crowd->staging)[at];
}

static thrum_status check_rows(const thrum_crowd *crowd, const char *name, const double *rows,
                               int64_t stride, thrum_error *error) {
  if (!rows)
    return THRUM_OK;
  if (stride != 0 && stride < crowd->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the stride %lld is below the rank %lld, and not 0", (long long)stride,
                           (long long)crowd->rank);
  const double most = crowd->accelerator->info.single ? 1e30 : 1e300;
  for (int64_t n = 0; n < (stride == 0 ? 1 : crowd->def.count); n++)
    for (int64_t i = 0; i < crowd->rank; i++)
      if (!(fabs(rows[n * stride + i]) <= most))
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "%s of body %lld holds %g: it is not finite or beyond %g", name,
                               (long long)n, rows[n * stride + i], most);
  return THRUM_OK;
}

/* --- a crowd's life --------------------------------------------------------------------------- */

// time steps of the modes and their damping over an increment, as thrum_step has them
static thrum_status take_equation(thrum_crowd *crowd, const thrum_model *model, double *length,
                                  double *drag, thrum_error *error) {
  thrum_state *state;
  THRUM_TRY(thrum_state_create(model, &crowd->def.state, &state, error));
  thrum_step_equation equation;
  double kappa[RANK_MOST], nu[RANK_MOST], damping[RANK_MOST];
  const thrum_status status =
      thrum_step_equation_get(model, state, &equation, kappa, nu, damping, error);
  thrum_state_destroy(state);
  if (status != THRUM_OK)
    return status;
  crowd->form = equation.form;
  for (int64_t i = 0; i < crowd->rank; i++) {
    length[i] = equation.dt / kappa[i];
    drag[i] = damping[i] * nu[i] * nu[i] / equation.dt;
  }
  return THRUM_OK;
}

static bool all_finite(const float *numbers, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!isfinite(numbers[i]))
      return false;
  return true;
}

// the coefficients, and which coordinates each pair has
static thrum_status send_model(thrum_crowd *crowd, const thrum_model *model, thrum_error *error) {
  double length[RANK_MOST], drag[RANK_MOST], numbers[RANK_MOST];
  THRUM_TRY(take_equation(crowd, model, length, drag, error));
  const thrum_accelerator *a = crowd->accelerator;
  const size_t vector = (size_t)crowd->rank * device_real(a);
  narrow(crowd, model->omega2, crowd->rank, numbers);
  THRUM_TRY(device_buffer(a, vector, numbers, &crowd->omega2, error));
  narrow(crowd, length, crowd->rank, numbers);
  THRUM_TRY(device_buffer(a, vector, numbers, &crowd->length, error));
  narrow(crowd, drag, crowd->rank, numbers);
  THRUM_TRY(device_buffer(a, vector, numbers, &crowd->drag, error));

  // columns beyond those that there are stay zero
  const size_t entries = (size_t)((crowd->rank + crowd->pairs) * crowd->columns);
  float *const matrix = calloc(entries, sizeof *matrix);
  uint16_t *const pairs = calloc((size_t)crowd->pairs, 2 * sizeof *pairs);
  thrum_status status = THRUM_OK;
  if (!matrix || !pairs)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.0f MB of coefficients",
                             (double)entries * sizeof *matrix / 1048576);
  if (status == THRUM_OK) {
    second_derivatives(model, matrix, crowd->columns, crowd->rank);
    uint16_t *next = pairs;
    for (int64_t k = 0; k < crowd->rank; k++)
      for (int64_t l = k; l < crowd->rank; l++) {
        *next++ = (uint16_t)k;
        *next++ = (uint16_t)l;
      }
    if (!all_finite(matrix, entries))
      status = thrum_error_set(error, THRUM_BAD_VALUE,
                               "a coefficient of the model is beyond single precision");
  }
  if (status == THRUM_OK)
    status = device_buffer(a, entries * sizeof *matrix, matrix, &crowd->matrix, error);
  if (status == THRUM_OK)
    status =
        device_buffer(a, (size_t)crowd->pairs * 2 * sizeof *pairs, pairs, &crowd->pair_list, error);
  free(matrix);
  free(pairs);
  return status;
}

static thrum_status make_passes(thrum_crowd *crowd, thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  char options[256];
  snprintf(options, sizeof options,
           "-cl-std=CL1.2 %s -DRANK=%d -DPAIRS=%d -DPART=%d -DCOLUMNS=%d -DWIDE=%d -DLANES=%d",
           a->info.single ? "" : "-DWITH_DOUBLE", (int)crowd->rank, (int)crowd->pairs,
           (int)crowd->part, (int)crowd->columns, a->wide, a->lanes);
  THRUM_TRY(device_program(a, source, sizeof source, options, &crowd->program, error));
  int32_t code;
#define X(name)                                                                                    \
  crowd->name = a->cl.clCreateKernel(crowd->program, #name, &code);                                \
  if (!crowd->name)                                                                                \
    return device_failure(code, "the pass " #name " is made", error);
  PASSES(X)
#undef X
  return THRUM_OK;
}

static thrum_status make_arrays(thrum_crowd *crowd, thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  const size_t real = device_real(a), all = (size_t)crowd->all, rank = (size_t)crowd->rank,
               part = (size_t)crowd->part, columns = (size_t)crowd->columns;
  const struct {
    opencl_buffer *buffer;
    size_t size;
  } arrays[] = {
      {&crowd->q, rank * all * real},
      {&crowd->p, rank * all * real},
      {&crowd->load, rank * all * real},
      {&crowd->load_before, rank * all * real},
      {&crowd->timed, rank * all * real},
      {&crowd->stopped, all * sizeof(int64_t)},
      {&crowd->kinetic, all * real},
      {&crowd->strain, all * real},
      {&crowd->d, rank * part * real},
      {&crowd->before, rank * part * real},
      {&crowd->along_before, rank * part * real},
      {&crowd->now, rank * part * real},
      {&crowd->along, rank * part * real},
      {&crowd->x, (size_t)(crowd->rank + crowd->pairs) * part * sizeof(float)},
      {&crowd->y3, columns * part * sizeof(float)},
      {&crowd->y4, columns * part * sizeof(float)},
      {&crowd->start3, columns * part * sizeof(float)},
      {&crowd->start4, columns * part * sizeof(float)},
      {&crowd->factor, (size_t)crowd->pairs * part * sizeof(float)},
      {&crowd->worst, part * sizeof(float)},
  };
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
    THRUM_TRY(device_buffer(a, arrays[i].size, NULL, arrays[i].buffer, error));
  crowd->staging = malloc(rank * all * real);
  crowd->flags = malloc(all * sizeof *crowd->flags);
  if (!crowd->staging || !crowd->flags)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %zu bodies", all);
  return THRUM_OK;
}

static int64_t round_up(int64_t count, int64_t to) {
  return (count + to - 1) / to * to;
}

static thrum_status make_crowd(thrum_crowd *crowd, const thrum_model *model, thrum_error *error) {
  crowd->rank = model->rank;
  crowd->pairs = model->rank * (model->rank + 1) / 2;
  crowd->columns = round_up(crowd->pairs, GROUP);
  crowd->all = round_up(crowd->def.count, TOGETHER);
  crowd->part = crowd->all < PART_MOST ? crowd->all : PART_MOST;
  THRUM_TRY(send_model(crowd, model, error));
  THRUM_TRY(make_passes(crowd, error));
  THRUM_TRY(make_arrays(crowd, error));
  THRUM_TRY(thrum_crowd_set_forces(crowd, NULL, 0, error));
  return thrum_crowd_set(crowd, NULL, NULL, 0, error);
}

thrum_status thrum_crowd_create(thrum_accelerator *accelerator, const thrum_model *model,
                                const thrum_crowd_def *def, thrum_crowd **crowd,
                                thrum_error *error) {
  if (!accelerator || !model || !crowd)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the accelerator, the model or crowd is NULL");
  thrum_crowd_def defaults = thrum_default_crowd_def();
  def = thrum_def_whole(def, &defaults, sizeof defaults);
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_crowd_def_init");
  THRUM_TRY(check_def(def, error));
  THRUM_TRY(check_model(model, &def->state, error));

  thrum_crowd *const made = calloc(1, sizeof *made);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a crowd");
  made->accelerator = accelerator;
  made->def = *def;
  const thrum_status status = make_crowd(made, model, error);
  if (status != THRUM_OK) {
    thrum_crowd_destroy(made);
    return status;
  }
  *crowd = made;
  return THRUM_OK;
}

void thrum_crowd_destroy(thrum_crowd *crowd) {
  if (!crowd)
    return;
  const opencl_library *cl = &crowd->accelerator->cl;
  opencl_buffer *const buffers[] = {
      &crowd->timed,        &crowd->load_before, &crowd->q,      &crowd->p,      &crowd->load,
      &crowd->stopped,      &crowd->matrix,      &crowd->omega2, &crowd->length, &crowd->drag,
      &crowd->pair_list,    &crowd->d,           &crowd->x,      &crowd->y3,     &crowd->y4,
      &crowd->start3,       &crowd->start4,      &crowd->before, &crowd->now,    &crowd->along,
      &crowd->along_before, &crowd->factor,      &crowd->worst,  &crowd->strain, &crowd->kinetic};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
    device_release(crowd->accelerator, buffers[i]);
#define X(name)                                                                                    \
  if (crowd->name)                                                                                 \
    cl->clReleaseKernel(crowd->name);
  PASSES(X)
#undef X
  if (crowd->program)
    cl->clReleaseProgram(crowd->program);
  free(crowd->staging);
  free(crowd->flags);
  free(crowd);
}

/* --- passes ----------------------------------------------------------------------------------- */

/* A part of the bodies, from `at` on, and what its passes take besides: `count` is the distance of
 * the rows of all bodies. */
typedef struct part {
  thrum_crowd *crowd;
  int64_t at, count;
  size_t bodies; /* of it */
} part;

static part part_at(thrum_crowd *crowd, int64_t at) {
  const int64_t left = crowd->all - at;
  return (part){.crowd = crowd,
                .at = at,
                .count = crowd->all,
                .bodies = (size_t)(left < crowd->part ? left : crowd->part)};
}

#define A(x) DEVICE_ARGUMENT(x)
#define COUNT(list) (uint32_t)(sizeof(list) / sizeof *(list))

// a real argument takes the precision of the device
typedef struct real_argument {
  double wide;
  float narrow;
} real_argument;

static device_argument real_of(const thrum_crowd *crowd, real_argument *kept, double value) {
  *kept = (real_argument){value, (float)value};
  if (crowd->accelerator->info.single)
    return (device_argument)A(kept->narrow);
  return (device_argument)A(kept->wide);
}

// T and R at q + share d need these two products
static thrum_status multiply(const part *t, double share, opencl_buffer y3, opencl_buffer y4,
                             thrum_error *error) {
  thrum_crowd *c = t->crowd;
  real_argument kept;
  const device_argument products[] = {
      A(c->q), A(c->d), real_of(c, &kept, share), A(c->pair_list), A(c->x), A(t->at), A(t->count)};
  const size_t lanes = (size_t)c->accelerator->lanes, wide = (size_t)c->accelerator->wide;
  const size_t rows[2] = {t->bodies / lanes, (size_t)(c->rank + c->pairs)};
  THRUM_TRY(device_run(c->accelerator, c->products, products, COUNT(products), rows, NULL, error));

  const size_t items[2] = {t->bodies / wide, (size_t)(c->columns / GROUP)};
  const int32_t zero = 0, rank = (int32_t)c->rank, pairs = (int32_t)c->pairs;
  const device_argument cubic[] = {A(c->matrix), A(c->x), A(zero), A(rank), A(y3)};
  const device_argument quartic[] = {A(c->matrix), A(c->x), A(rank), A(pairs), A(y4)};
  THRUM_TRY(device_run(c->accelerator, c->multiply, cubic, COUNT(cubic), items, NULL, error));
  return device_run(c->accelerator, c->multiply, quartic, COUNT(quartic), items, NULL, error);
}

/* An item for LANES bodies, or for each; and for each coordinate of them. */
static void items_of(const part *t, bool lanes, bool coordinates, size_t items[2]) {
  items[0] = lanes ? t->bodies / (size_t)t->crowd->accelerator->lanes : t->bodies;
  items[1] = coordinates ? (size_t)t->crowd->rank : 1;
}

static thrum_status run(const part *t, opencl_kernel kernel, const device_argument *arguments,
                        uint32_t count, bool lanes, bool coordinates, thrum_error *error) {
  size_t items[2];
  items_of(t, lanes, coordinates, items);
  return device_run(t->crowd->accelerator, kernel, arguments, count, items, NULL, error);
}

static thrum_status force(const part *t, double share, opencl_buffer y3, opencl_buffer y4,
                          opencl_buffer f, opencl_buffer along, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  real_argument kept;
  const device_argument arguments[] = {
      A(c->q),  A(c->d),    real_of(c, &kept, share), A(c->omega2), A(y3), A(y4), A(f), A(along),
      A(t->at), A(t->count)};
  return run(t, c->force, arguments, COUNT(arguments), true, true, error);
}

static thrum_status begin(const part *t, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const device_argument arguments[] = {A(c->p), A(c->length), A(c->d), A(t->at), A(t->count)};
  return run(t, c->begin, arguments, COUNT(arguments), true, true, error);
}

static thrum_status iterate(const part *t, int32_t mean, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const device_argument arguments[] = {A(c->p),      A(c->load),   A(c->length), A(c->drag),
                                       A(c->omega2), A(c->before), A(c->now),    A(c->along_before),
                                       A(c->along),  A(c->y3),     A(c->y4),     A(mean),
                                       A(c->factor), A(c->d),      A(c->worst),  A(t->at),
                                       A(t->count)};
  return run(t, c->iterate, arguments, COUNT(arguments), true, false, error);
}

static thrum_status commit(const part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  const float tolerance = (float)c->def.tolerance;
  const device_argument arguments[] = {A(c->q),     A(c->p),      A(c->d),       A(c->length),
                                       A(c->worst), A(tolerance), A(c->stopped), A(made),
                                       A(t->at),    A(t->count)};
  return run(t, c->commit, arguments, COUNT(arguments), false, false, error);
}

static thrum_status kick(const part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  real_argument kept;
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
  return run(t, c->kick, arguments, COUNT(arguments), false, false, error);
}

// R at q into `now`
static thrum_status force_here(const part *t, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  THRUM_TRY(begin(t, error));
  THRUM_TRY(multiply(t, 0.0, c->y3, c->y4, error));
  return force(t, 0.0, c->y3, c->y4, c->now, c->along, error);
}

/* --- steps ------------------------------------------------------------------------------------ */

static thrum_status step_part(const part *t, int64_t made, thrum_error *error) {
  thrum_crowd *c = t->crowd;
  if (c->form == THRUM_STEP_VERLET) {
    THRUM_TRY(force_here(t, error));
    return kick(t, made, error);
  }
  THRUM_TRY(begin(t, error));

  // the discrete gradient takes the forces at both ends, the midpoint rule that in the middle
  const bool mean = c->form != THRUM_STEP_MIDPOINT;
  const double share = mean ? 1.0 : 0.5;
  if (mean)
    THRUM_TRY(multiply(t, 0.0, c->start3, c->start4, error));
  for (int32_t k = 0; k < c->def.iterations; k++) {
    if (mean)
      THRUM_TRY(force(t, 0.0, c->start3, c->start4, c->before, c->along_before, error));
    THRUM_TRY(multiply(t, share, c->y3, c->y4, error));
    THRUM_TRY(force(t, share, c->y3, c->y4, c->now, c->along, error));
    THRUM_TRY(iterate(t, mean, error));
  }
  return commit(t, made, error);
}

thrum_status thrum_crowd_step(thrum_crowd *crowd, int64_t steps, int64_t *stopped,
                              thrum_error *error) {
  if (!crowd || steps < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the crowd is NULL, or steps is below 0");
  const thrum_accelerator *a = crowd->accelerator;
  for (int64_t at = 0; at < crowd->all; at += crowd->part) {
    const part t = part_at(crowd, at);
    for (int64_t k = 0; k < steps; k++) {
      THRUM_TRY(step_part(&t, crowd->made + k, error));

      // a queue without an end takes the memory of the host
      if (k % QUEUE_STEPS == QUEUE_STEPS - 1)
        THRUM_TRY(device_wait(a, error));
    }
  }
  crowd->made += steps;
  THRUM_TRY(device_read(a, crowd->stopped, crowd->flags, (size_t)crowd->all * sizeof *crowd->flags,
                        error));

  // which have stopped
  int64_t first = -1, all = 0;
  for (int64_t n = 0; n < crowd->def.count; n++) {
    if (stopped)
      stopped[n] = crowd->flags[n];
    if (crowd->flags[n] < 0)
      continue;
    first = first < 0 ? n : first;
    all++;
  }
  if (first < 0)
    return THRUM_OK;
  return thrum_error_set(
      error, THRUM_NOT_CONVERGED,
      "%lld of %lld bodies have stopped, the first, body %lld, after %lld steps: "
      "take a smaller dt%s, or set them anew",
      (long long)all, (long long)crowd->def.count, (long long)first, (long long)crowd->flags[first],
      crowd->form == THRUM_STEP_VERLET ? "" : " or more iterations");
}

/* --- in and out ------------------------------------------------------------------------------- */

// p of the time of q, and p half a step before it (staggered_momentum.c of the core)
static thrum_status shift(thrum_crowd *c, bool back, thrum_error *error) {
  real_argument kept;
  const device_argument h = real_of(c, &kept, c->def.state.dt);
  for (int64_t at = 0; at < c->all; at += c->part) {
    const part t = part_at(c, at);
    THRUM_TRY(force_here(&t, error));
    const device_argument to[] = {A(c->p), A(c->now), A(c->load_before), A(c->drag),
                                  h,       A(t.at),   A(t.count)};
    const device_argument from[] = {A(c->p), A(c->now),   A(c->load_before), A(c->drag),
                                    h,       A(c->timed), A(t.at),           A(t.count)};
    THRUM_TRY(run(&t, back ? c->shift_back : c->shift_on, back ? to : from,
                  back ? COUNT(to) : COUNT(from), false, true, error));
  }
  return THRUM_OK;
}

// p of the time of q
static thrum_status take_timed(thrum_crowd *crowd, opencl_buffer *p, thrum_error *error) {
  const bool staggered = crowd->form == THRUM_STEP_VERLET;
  *p = staggered ? crowd->timed : crowd->p;
  return staggered ? shift(crowd, false, error) : THRUM_OK;
}

thrum_status thrum_crowd_set(thrum_crowd *crowd, const double *q, const double *p, int64_t stride,
                             thrum_error *error) {
  if (!crowd)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the crowd is NULL");
  THRUM_TRY(check_rows(crowd, "q", q, stride, error));
  THRUM_TRY(check_rows(crowd, "p", p, stride, error));
  const thrum_accelerator *a = crowd->accelerator;
  const size_t count = (size_t)crowd->all;
  const size_t size = (size_t)crowd->rank * count * device_real(a);
  turn(crowd, NULL, 0);
  THRUM_TRY(device_write(a, crowd->load_before, crowd->staging, size, error));
  turn(crowd, q, stride);
  THRUM_TRY(device_write(a, crowd->q, crowd->staging, size, error));
  turn(crowd, p, stride);
  THRUM_TRY(device_write(a, crowd->p, crowd->staging, size, error));
  for (size_t n = 0; n < count; n++)
    crowd->flags[n] = -1;
  crowd->made = 0;
  THRUM_TRY(device_write(a, crowd->stopped, crowd->flags, count * sizeof *crowd->flags, error));
  return crowd->form == THRUM_STEP_VERLET ? shift(crowd, true, error) : THRUM_OK;
}

thrum_status thrum_crowd_set_forces(thrum_crowd *crowd, const double *forces, int64_t stride,
                                    thrum_error *error) {
  if (!crowd)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the crowd is NULL");
  THRUM_TRY(check_rows(crowd, "the load", forces, stride, error));
  turn(crowd, forces, stride);
  return device_write(crowd->accelerator, crowd->load, crowd->staging,
                      (size_t)(crowd->rank * crowd->all) * device_real(crowd->accelerator), error);
}

// one array of rank x count numbers
static thrum_status get_rows(thrum_crowd *crowd, opencl_buffer buffer, double *rows, int64_t stride,
                             thrum_error *error) {
  if (!rows)
    return THRUM_OK;
  THRUM_TRY(device_read(crowd->accelerator, buffer, crowd->staging,
                        (size_t)(crowd->rank * crowd->all) * device_real(crowd->accelerator),
                        error));
  for (int64_t n = 0; n < crowd->def.count; n++)
    for (int64_t i = 0; i < crowd->rank; i++)
      rows[n * stride + i] = staged(crowd, i * crowd->all + n);
  return THRUM_OK;
}

thrum_status thrum_crowd_get(thrum_crowd *crowd, double *q, double *p, int64_t stride,
                             thrum_error *error) {
  if (!crowd || stride < crowd->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the crowd is NULL, or the stride is below the rank");
  opencl_buffer timed;
  THRUM_TRY(take_timed(crowd, &timed, error));
  THRUM_TRY(get_rows(crowd, crowd->q, q, stride, error));
  return get_rows(crowd, timed, p, stride, error);
}

thrum_status thrum_crowd_energies(thrum_crowd *crowd, double *kinetic, double *strain,
                                  thrum_error *error) {
  if (!crowd)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the crowd is NULL");
  const thrum_accelerator *a = crowd->accelerator;
  opencl_buffer timed;
  THRUM_TRY(take_timed(crowd, &timed, error));
  for (int64_t at = 0; at < crowd->all; at += crowd->part) {
    const part t = part_at(crowd, at);
    THRUM_TRY(begin(&t, error));
    THRUM_TRY(multiply(&t, 0.0, crowd->y3, crowd->y4, error));
    const device_argument arguments[] = {A(crowd->q),      A(timed),     A(crowd->omega2),
                                         A(crowd->y3),     A(crowd->y4), A(crowd->kinetic),
                                         A(crowd->strain), A(t.at),      A(t.count)};
    THRUM_TRY(run(&t, crowd->energies, arguments, COUNT(arguments), true, false, error));
  }
  double *const parts[] = {kinetic, strain};
  const opencl_buffer buffers[] = {crowd->kinetic, crowd->strain};
  for (int i = 0; i < 2; i++) {
    if (!parts[i])
      continue;
    THRUM_TRY(device_read(a, buffers[i], crowd->staging, (size_t)crowd->def.count * device_real(a),
                          error));
    for (int64_t n = 0; n < crowd->def.count; n++)
      parts[i][n] = staged(crowd, n);
  }
  return THRUM_OK;
}
