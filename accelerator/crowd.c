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
#include "accelerator/crowd_private.h"
#include "core/base/def.h"
#include "thrum/actuation.h"

#define TOGETHER 64           /* bodies that counts are rounded up to */
#define PART_MOST 4096        /* bodies of a part: a tile of each compute unit of a large device */
#define PART_MOST_POINTS 1024 /* whose arrays are longer */
#define RANK_MOST 128         /* whose coefficients take 273 MB as a matrix */
#define ITERATIONS_MOST 32
#define QUEUE_STEPS 64 /* that are put into the queue before the host waits */

static const char source[] = {
#include "crowd_program.inc"
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

static thrum_status check_def(const thrum_crowd_def *def, thrum_error *error) {
  if (def->count < 1 || def->count > INT32_MAX)
    return thrum_error_set_field(error, "count", THRUM_INVALID_ARGUMENT, " is not 1 to 2147483647");
  if (def->iterations < 1 || def->iterations > ITERATIONS_MOST)
    return thrum_error_set_field(error, "iterations", THRUM_INVALID_ARGUMENT, " is not 1 to 32");
  if (!(def->tolerance > 0) || !isfinite(def->tolerance))
    return thrum_error_set_field(error, "tolerance", THRUM_INVALID_ARGUMENT,
                                 " is not above 0 and finite");
  return THRUM_OK;
}

static thrum_status check_model(const thrum_model *model, const thrum_state_def *state,
                                thrum_error *error) {
  const bool points = model->point_gradients != NULL;
  if (points && (model->point_law || model->region_law || model->point_plastic))
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "a crowd steps Saint Venant-Kirchhoff material, and the cubature points of "
        "this model have another law");
  if (!points && (!model->c3 || !model->c4))
    return thrum_error_set(error, THRUM_MISSING, "the model has neither coefficients nor points");
  if (thrum_model_actuators(model) > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a crowd has no actuators, and this model has some: step it by "
                           "thrum_batch_step");
  if (model->follow && state->damping_beta > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "the model is condensed, and with damping_beta what follows drags, which "
        "a crowd does not step: take damping_alpha, or the model uncondensed");
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

// rows of bodies as columns, into the staging
static void turn(thrum_crowd *crowd, const double *rows, int64_t stride) {
  for (int64_t n = 0; n < crowd->all; n++)
    for (int64_t i = 0; i < crowd->rank; i++) {
      const double value = rows && n < crowd->def.count ? rows[n * stride + i] : 0;
      device_real_put(crowd->accelerator, crowd->staging, i * crowd->all + n, value);
    }
}

static thrum_status check_rows(const thrum_crowd *crowd, const char *name, const double *rows,
                               int64_t stride, thrum_error *error) {
  if (!rows)
    return THRUM_OK;
  if (stride != 0 && stride < crowd->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the stride %lld is below the rank %lld, and not 0", (long long)stride,
                           (long long)crowd->rank);
  const double most = device_real_most(crowd->accelerator);
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

static thrum_status beyond_single(thrum_error *error) {
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "a coefficient of the model is beyond single precision");
}

// columns beyond those that there are are zero
static thrum_status send_matrix(thrum_crowd *crowd, const float *matrix, size_t entries,
                                thrum_error *error) {
  if (!all_finite(matrix, entries))
    return beyond_single(error);
  return device_buffer(crowd->accelerator, entries * sizeof *matrix, matrix, &crowd->matrix, error);
}

// the coefficients, and which coordinates each pair has
static thrum_status send_coefficients(thrum_crowd *crowd, const thrum_model *model,
                                      thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  const size_t entries = (size_t)((crowd->rank + crowd->pairs) * crowd->columns);
  float *const matrix = calloc(entries, sizeof *matrix);
  uint16_t *const pairs = calloc((size_t)crowd->pairs, 2 * sizeof *pairs);
  thrum_status status = THRUM_OK;
  if (!matrix || !pairs)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.0f MB of coefficients",
                             (double)entries * sizeof *matrix / 1048576);

  // the matrix, and which two coordinates each of its lower rows stands for
  if (status == THRUM_OK) {
    second_derivatives(model, matrix, crowd->columns, crowd->rank);
    uint16_t *next = pairs;
    for (int64_t k = 0; k < crowd->rank; k++)
      for (int64_t l = k; l < crowd->rank; l++) {
        *next++ = (uint16_t)k;
        *next++ = (uint16_t)l;
      }
    status = send_matrix(crowd, matrix, entries, error);
  }
  if (status == THRUM_OK)
    status =
        device_buffer(a, (size_t)crowd->pairs * 2 * sizeof *pairs, pairs, &crowd->pair_list, error);
  free(matrix);
  free(pairs);
  return status;
}

// the gradients of the coordinates at the points, and what the points are
static thrum_status send_points(thrum_crowd *crowd, const thrum_model *model, thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  const int64_t count = crowd->points, rank = crowd->rank;
  const size_t entries = (size_t)(rank * crowd->columns);
  float *const matrix = calloc(entries, sizeof *matrix);
  float *const numbers = calloc((size_t)count, 3 * sizeof *numbers);
  thrum_status status = THRUM_OK;
  if (!matrix || !numbers)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %lld cubature points",
                             (long long)count);

  // the device takes a row a coordinate, and the moduli and weights one behind the other
  if (status == THRUM_OK) {
    for (int64_t row = 0; row < 9 * count; row++)
      for (int64_t i = 0; i < rank; i++)
        matrix[i * crowd->columns + row] = (float)model->point_gradients[row * rank + i];
    for (int64_t p = 0; p < count; p++) {
      numbers[p] = (float)model->point_moduli[p];
      numbers[count + p] = (float)model->point_moduli[count + p];
      numbers[2 * count + p] = (float)model->point_weights[p];
    }
    status = all_finite(numbers, 3 * (size_t)count) ? send_matrix(crowd, matrix, entries, error)
                                                    : beyond_single(error);
  }
  if (status == THRUM_OK)
    status =
        device_buffer(a, (size_t)count * 2 * sizeof *numbers, numbers, &crowd->point_moduli, error);
  if (status == THRUM_OK)
    status = device_buffer(a, (size_t)count * sizeof *numbers, numbers + 2 * count, &crowd->weights,
                           error);
  free(matrix);
  free(numbers);
  return status;
}

static thrum_status send_model(thrum_crowd *crowd, const thrum_model *model, thrum_error *error) {
  double length[RANK_MOST], drag[RANK_MOST];
  THRUM_TRY(take_equation(crowd, model, length, drag, error));
  const thrum_accelerator *a = crowd->accelerator;
  THRUM_TRY(device_reals(a, model->omega2, crowd->rank, &crowd->omega2, error));
  THRUM_TRY(device_reals(a, length, crowd->rank, &crowd->length, error));
  THRUM_TRY(device_reals(a, drag, crowd->rank, &crowd->drag, error));
  return crowd->points > 0 ? send_points(crowd, model, error)
                           : send_coefficients(crowd, model, error);
}

static int64_t round_up(int64_t count, int64_t to) {
  return (count + to - 1) / to * to;
}

static thrum_status make_passes(thrum_crowd *crowd, thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  char options[256];
  snprintf(options, sizeof options,
           "-cl-std=CL1.2 %s -DRANK=%d -DPAIRS=%d -DPART=%d -DCOLUMNS=%d -DWIDE=%d -DLANES=%d",
           a->info.single ? "" : "-DWITH_DOUBLE", (int)crowd->rank, (int)crowd->pairs,
           (int)crowd->part, (int)crowd->columns, a->wide, a->lanes);
  if (crowd->points > 0)
    snprintf(options + strlen(options), sizeof options - strlen(options), " -DPOINTS=%d",
             (int)crowd->points);
  THRUM_TRY(device_program(a, source, sizeof source, options, &crowd->program, error));
  int32_t code;
#define X(name)                                                                                    \
  crowd->pass_##name = a->cl.clCreateKernel(crowd->program, #name, &code);                         \
  if (!crowd->pass_##name)                                                                         \
    return device_failure(code, "the pass " #name " is made", error);
  PASSES(X)
  if (crowd->points > 0) {
    POINT_PASSES(X)
  }
#undef X
  return THRUM_OK;
}

static thrum_status make_arrays(thrum_crowd *crowd, thrum_error *error) {
  const thrum_accelerator *a = crowd->accelerator;
  const size_t real = device_real(a), all = (size_t)crowd->all, rank = (size_t)crowd->rank,
               part = (size_t)crowd->part, pairs = (size_t)round_up(crowd->pairs, GROUP),
               points = crowd->points > 0 ? (size_t)crowd->columns : 0;
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
      {&crowd->y3, pairs * part * sizeof(float)},
      {&crowd->y4, pairs * part * sizeof(float)},
      {&crowd->start3, pairs * part * sizeof(float)},
      {&crowd->start4, pairs * part * sizeof(float)},
      {&crowd->factor, (size_t)crowd->pairs * part * sizeof(float)},
      {&crowd->worst, part * sizeof(float)},
      {&crowd->g, points * part * sizeof(float)},
      {&crowd->g_along, points * part * sizeof(float)},
      {&crowd->pull, points * part * sizeof(float)},
      {&crowd->pull_along, points * part * sizeof(float)},
  };

  // those of points have no size without points
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
    if (arrays[i].size > 0)
      THRUM_TRY(device_buffer(a, arrays[i].size, NULL, arrays[i].buffer, error));
  crowd->staging = malloc(rank * all * real);
  crowd->flags = malloc(all * sizeof *crowd->flags);
  if (!crowd->staging || !crowd->flags)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %zu bodies", all);
  return THRUM_OK;
}

static thrum_status make_crowd(thrum_crowd *crowd, const thrum_model *model, thrum_error *error) {
  crowd->rank = model->rank;
  crowd->pairs = model->rank * (model->rank + 1) / 2;
  crowd->points = model->point_gradients ? model->point_count : 0;
  crowd->columns = round_up(crowd->points > 0 ? 9 * crowd->points : crowd->pairs, GROUP);
  crowd->all = round_up(crowd->def.count, TOGETHER);
  const int64_t most = crowd->points > 0 ? PART_MOST_POINTS : PART_MOST;
  crowd->part = crowd->all < most ? crowd->all : most;
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
  opencl_buffer *const buffers[] = {&crowd->weights, &crowd->point_moduli, &crowd->g,
                                    &crowd->g_along, &crowd->pull,         &crowd->pull_along,
                                    &crowd->timed,   &crowd->load_before,  &crowd->q,
                                    &crowd->p,       &crowd->load,         &crowd->stopped,
                                    &crowd->matrix,  &crowd->omega2,       &crowd->length,
                                    &crowd->drag,    &crowd->pair_list,    &crowd->d,
                                    &crowd->x,       &crowd->y3,           &crowd->y4,
                                    &crowd->start3,  &crowd->start4,       &crowd->before,
                                    &crowd->now,     &crowd->along,        &crowd->along_before,
                                    &crowd->factor,  &crowd->worst,        &crowd->strain,
                                    &crowd->kinetic};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
    device_release(crowd->accelerator, buffers[i]);
#define X(name)                                                                                    \
  if (crowd->pass_##name)                                                                          \
    cl->clReleaseKernel(crowd->pass_##name);
  PASSES(X)
  POINT_PASSES(X)
#undef X
  if (crowd->program)
    cl->clReleaseProgram(crowd->program);
  free(crowd->staging);
  free(crowd->flags);
  free(crowd);
}

/* --- steps ------------------------------------------------------------------------------------ */

thrum_status thrum_crowd_step(thrum_crowd *crowd, int64_t steps, int64_t *stopped,
                              thrum_error *error) {
  if (!crowd || steps < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the crowd is NULL, or steps is below 0");
  const thrum_accelerator *a = crowd->accelerator;
  for (int64_t at = 0; at < crowd->all; at += crowd->part) {
    const crowd_part t = crowd_part_at(crowd, at);
    for (int64_t k = 0; k < steps; k++) {
      THRUM_TRY(crowd_step_part(&t, crowd->made + k, error));

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

static thrum_status shift(thrum_crowd *crowd, bool back, thrum_error *error) {
  for (int64_t at = 0; at < crowd->all; at += crowd->part) {
    const crowd_part t = crowd_part_at(crowd, at);
    THRUM_TRY(crowd_shift_part(&t, back, error));
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
      rows[n * stride + i] =
          device_real_get(crowd->accelerator, crowd->staging, i * crowd->all + n);
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
    const crowd_part t = crowd_part_at(crowd, at);
    THRUM_TRY(crowd_energies_part(&t, timed, error));
  }
  double *const parts[] = {kinetic, strain};
  const opencl_buffer buffers[] = {crowd->kinetic, crowd->strain};
  for (int i = 0; i < 2; i++) {
    if (!parts[i])
      continue;
    THRUM_TRY(device_read(a, buffers[i], crowd->staging, (size_t)crowd->def.count * device_real(a),
                          error));
    for (int64_t n = 0; n < crowd->def.count; n++)
      parts[i][n] = device_real_get(crowd->accelerator, crowd->staging, n);
  }
  return THRUM_OK;
}
