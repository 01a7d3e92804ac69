/* The full order, sampled. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/full/full.h"
#include "thrum/external_load.h"
#include "validation/tradeoff/tradeoff.h"

/* What take() needs: where samples go, room for the free components of a field, and the energies at
 * the two ends of the present step. */
typedef struct taker {
  const tradeoff_problem *problem;
  tradeoff_reference *reference;
  double *free_ones; /* n: the components that may move, of a field of all */
  double energy_from, energy_to;
} taker;

static double dot(const double *x, const double *y, int64_t n) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

/* Takes one sample: a field u of all components, and v behind it, at `share` of the present step.
 */
static void take(void *context, int64_t index, double share, const double *value) {
  const taker *t = context;
  tradeoff_reference *r = t->reference;
  const int64_t all = 3 * t->problem->model->vertex_count;
  double *mass_u = r->mass_u + index * r->n, *mass_v = r->mass_v + index * r->n;

  // M u and |u|^2, then M v and |v|^2
  thrum_fem_gather(&r->body.fem, value, t->free_ones);
  thrum_sparse_product(&r->body.mass, t->free_ones, 1, mass_u);
  r->u_square[index] = dot(t->free_ones, mass_u, r->n);
  thrum_fem_gather(&r->body.fem, value + all, t->free_ones);
  thrum_sparse_product(&r->body.mass, t->free_ones, 1, mass_v);
  r->v_square[index] = dot(t->free_ones, mass_v, r->n);
  r->energy[index] = (1 - share) * t->energy_from + share * t->energy_to;
}

/* All fields of the stepping: two ends, a sample between, the forces, the free components. */
typedef struct fields {
  double *memory, *from, *to, *between, *forces, *free_ones;
} fields;

static thrum_status fields_make(int64_t all, fields *f, thrum_error *error) {
  f->memory = thrum_allocate(8 * all, sizeof *f->memory, "the full order", error);
  if (f->memory == NULL)
    return THRUM_OUT_OF_MEMORY;
  f->from = f->memory;
  f->to = f->from + 2 * all;
  f->between = f->to + 2 * all;
  f->forces = f->between + 2 * all;
  f->free_ones = f->forces + all;
  return THRUM_OK;
}

/* The mean forces of all loads in a step. */
static void load(const tradeoff_problem *problem, int64_t step, double *forces) {
  const int64_t all = 3 * problem->model->vertex_count;
  memset(forces, 0, (size_t)all * sizeof *forces);
  for (int64_t n = 0; n < problem->load_count; n++) {
    const double mean = thrum_load_mean(&problem->courses[n], step, problem->full_dt);
    for (int64_t c = 0; c < all && mean != 0; c++)
      forces[c] += mean * problem->forces[n * all + c];
  }
}

static thrum_status step_all(const tradeoff_problem *problem, thrum_full *full, fields *f,
                             tradeoff_reference *reference, thrum_error *error) {
  const int64_t all = 3 * problem->model->vertex_count;
  const int64_t steps = thrum_step_count(problem->time, problem->full_dt);
  taker t = {problem, reference, f->free_ones, 0, 0};
  double seconds = 0;
  memset(f->from, 0, 2 * (size_t)all * sizeof *f->from);

  // only the step itself is timed
  for (int64_t k = 0; k < steps; k++) {
    load(problem, k, f->forces);
    const double began = clock_thread_seconds();
    THRUM_TRY(thrum_full_set_force(full, f->forces, error));
    THRUM_TRY(thrum_full_step(full, error));
    seconds += clock_thread_seconds() - began;
    thrum_full_get(full, f->to, f->to + all);

    // samples lie between steps: cubic Hermite between the two ends
    t.energy_to = thrum_full_energy(full).total;
    tradeoff_sample(problem->time, (double)k * problem->full_dt, problem->full_dt, all, f->from,
                    f->to, take, &t, f->between);
    memcpy(f->from, f->to, 2 * (size_t)all * sizeof *f->from);
    t.energy_from = t.energy_to;
    if (problem->progress != NULL && !problem->progress(problem->progress_context, "full order",
                                                        (double)(k + 1) / (double)steps))
      return thrum_error_set(error, THRUM_INTERRUPTED, "interrupted");
  }
  reference->us_per_step = 1e6 * seconds / (double)steps;
  return THRUM_OK;
}

thrum_status tradeoff_reference_make(const tradeoff_problem *problem, tradeoff_reference *reference,
                                     thrum_error *error) {
  const int64_t all = 3 * problem->model->vertex_count;
  tradeoff_reference made = {0};
  fields f = {0};
  thrum_full *full = NULL;
  thrum_full_def def = thrum_default_full_def();

  // the reference steps with the damping of the runs that are measured against it
  def.dt = problem->full_dt;
  def.damping_alpha = problem->damping_alpha;
  def.damping_beta = problem->damping_beta;
  thrum_status status = thrum_model_fem_create(problem->model, &made.body, error);
  made.n = made.body.fem.free_count;

  // samples are kept times the mass, as errors are measured in its norm
  if (status >= 0) {
    made.mass_u = thrum_allocate(2 * TRADEOFF_SAMPLES * made.n, sizeof *made.mass_u,
                                 "the samples of the full order", error);
    made.mass_v = made.mass_u != NULL ? made.mass_u + TRADEOFF_SAMPLES * made.n : NULL;
    status = made.mass_u != NULL ? fields_make(all, &f, error) : THRUM_OUT_OF_MEMORY;
  }

  THRUM_THEN(status, thrum_full_create(problem->model, NULL, &def, &full, error));
  THRUM_THEN(status, step_all(problem, full, &f, &made, error));

  thrum_full_free(full);
  free(f.memory);
  if (status < 0)
    tradeoff_reference_free(&made);
  else
    *reference = made;
  return status;
}

void tradeoff_reference_free(tradeoff_reference *reference) {
  thrum_model_fem_free(&reference->body);
  free(reference->mass_u);
  *reference = (tradeoff_reference){0};
}
