/* What a curve is worth for the mesh; see response_worth.h. Both bodies take the same steps of the
 * energy integrator, so what these err by is in both numbers. Ratios of damping are those of modes,
 * which the mesh has not: it is damped by its mass, at the rate at which the orbit loses energy. A
 * free mesh feels what its loads leave when they move it as a whole, as the curve does.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_worth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/progress.h"
#include "core/base/model_law.h"
#include "core/base/pi.h"
#include "driver/response/response_orbit.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/stop_request.h"
#include "precompute/fem/rigid_modes.h"
#include "precompute/full/full.h"
#include "precompute/model/model_fem.h"
#include "thrum/thrum.h"

#define STEPS RESPONSE_ORBIT_STEPS
#define USUAL 3        /* motions where the request leaves it open, */
#define USUAL_WORK 6e3 /* while they have so many points of tetrahedra together, or one has, */
#define USUAL_SECONDS                                                                              \
  20.0 /* and until so much time has gone: stiff steps of slender parts are dear */

typedef struct mesh_run {
  const response_curve *curve;
  int64_t size;                   /* components of a field */
  double *u, *v, *start, *forces; /* fields */
  double *cosine, *sine, *mean;   /* fields of the loads */
  double *memory;
  double largest;                           /* displacement of the model */
  double last[THRUM_RANK_MAX], moved, lost; /* of the model: q, and sums of dq^2 and of D dq^2 */
  double until; /* of clock_seconds; no step of the mesh begins after it */
  bool late;    /* it has come to that, or to a stop */
} mesh_run;

static double rms(int64_t size, const double *field, const double *less) {
  double sum = 0;
  for (int64_t c = 0; c < size; c++) {
    const double part = field[c] - (less != NULL ? less[c] : 0);
    sum += part * part;
  }
  return sqrt(sum / (double)size);
}

/* Takes off the loads of a free body what moves it as a whole, f less M Z Z^T f. */
static thrum_status take_off_rigid(mesh_run *run, thrum_error *error) {
  thrum_model_fem body = {0};
  double *modes = NULL;
  const int64_t count = THRUM_RIGID_COUNT * run->size;
  if (run->curve->shape->rigid == NULL)
    return THRUM_OK;
  thrum_status status = thrum_model_fem_create(run->curve->shape, &body, error);
  THRUM_THEN(status, thrum_reserve(&modes, 2 * count, sizeof *modes, "the rigid modes", error));
  THRUM_THEN(status, thrum_rigid_modes(&body.fem, &body.mass, modes, modes + count, error));
  double *const fields[] = {run->cosine, run->sine, run->mean};
  for (int n = 0; n < 3 * THRUM_RIGID_COUNT && status >= 0; n++) {
    const double *mode = modes + n % THRUM_RIGID_COUNT * run->size, *dual = mode + count;
    double *field = fields[n / THRUM_RIGID_COUNT], share = 0;
    for (int64_t i = 0; i < run->size; i++)
      share += mode[i] * field[i];
    for (int64_t i = 0; i < run->size; i++)
      field[i] -= share * dual[i];
  }
  free(modes);
  thrum_model_fem_free(&body);
  return status;
}

/* The loads as fields, in what swings with cosine and sine and what stays. */
static thrum_status fill_loads(mesh_run *run, thrum_full *body, thrum_error *error) {
  const response_curve *c = run->curve;
  memset(run->cosine, 0, (size_t)(3 * run->size) * sizeof *run->cosine);
  for (int64_t n = 0; n < c->request->load_count; n++) {
    const response_load *load = &c->request->loads[n];
    const double pushed[3] = {-load->vector[0], -load->vector[1], -load->vector[2]};
    memset(run->forces, 0, (size_t)run->size * sizeof *run->forces);
    if (load->base || load->spec.gravity)
      thrum_full_add_gravity(body, load->base ? pushed : load->spec.vector, run->forces);
    else
      THRUM_TRY(load_spec_fill(c->shape, &load->spec, run->forces, error));
    for (int64_t i = 0; i < run->size; i++) {
      run->cosine[i] += load->swings ? sin(load->phase) * run->forces[i] : 0;
      run->sine[i] += load->swings ? cos(load->phase) * run->forces[i] : 0;
      run->mean[i] += load->swings ? 0 : run->forces[i];
    }
  }
  return take_off_rigid(run, error);
}

static thrum_status step_mesh(mesh_run *run, thrum_full *body, const double *p, double *missed,
                              double *gained, thrum_error *error) {
  const thrum_model *shape = run->curve->shape;
  double largest = 0;
  THRUM_TRY(fill_loads(run, body, error));
  THRUM_TRY(thrum_displacement(shape, p, 0, shape->vertex_count, run->v, error));
  THRUM_TRY(thrum_full_set(body, run->start, run->v, error));
  const double before = thrum_full_energy(body).total;
  for (int64_t step = 0; step < STEPS * run->curve->request->periods; step++) {
    run->late = thrum_stop_requested() || clock_seconds() > run->until;
    if (run->late)
      return THRUM_OK;
    double cosine = 0, sine = 0;
    response_orbit_means(step, &cosine, &sine);
    for (int64_t i = 0; i < run->size; i++)
      run->forces[i] = run->mean[i] + cosine * run->cosine[i] + sine * run->sine[i];
    THRUM_TRY(thrum_full_set_force(body, run->forces, error));
    const thrum_status stepped = thrum_full_step(body, error);
    THRUM_TRY(stepped);
    thrum_full_get(body, run->u, NULL);
    largest = fmax(largest, rms(run->size, run->u, NULL));
  }
  *missed = rms(run->size, run->u, run->start) / largest;

  // what is steady has a potential
  *gained = thrum_full_energy(body).total - before;
  for (int64_t i = 0; i < run->size; i++)
    *gained -= run->mean[i] * (run->u[i] - run->start[i]);
  return THRUM_OK;
}

/* How far and how fast the model has moved; of the last step the displacement stays. */
static thrum_status show_step(void *context, int64_t step, const double *q, thrum_error *error) {
  mesh_run *run = context;
  const thrum_model *shape = run->curve->shape;
  (void)step;
  THRUM_TRY(thrum_displacement(shape, q, 0, shape->vertex_count, run->u, error));
  run->largest = fmax(run->largest, rms(run->size, run->u, NULL));
  for (int64_t i = 0; i < shape->rank; i++) {
    const double moved = q[i] - run->last[i];
    run->moved += moved * moved;
    run->lost += run->curve->rates[i] * moved * moved;
    run->last[i] = q[i];
  }
  return THRUM_OK;
}

/* The same of all coordinates of the model. */
static thrum_status step_model(mesh_run *run, double omega, const double *q, const double *p,
                               double *missed, thrum_error *error) {
  const response_curve *c = run->curve;
  const double *const loads[3] = {c->loads[0], c->loads[1], c->loads[2]};
  const response_orbit orbit = {c->shape, c->rates, loads, omega, c->request->periods};
  run->largest = run->moved = run->lost = 0;
  memcpy(run->last, q, (size_t)c->shape->rank * sizeof *q);
  THRUM_TRY(response_orbit_run(&orbit, q, p, show_step, run, error));
  *missed = rms(run->size, run->u, run->start) / run->largest;
  return THRUM_OK;
}

static thrum_status look_at(mesh_run *run, int64_t row, response_worth_point *point,
                            thrum_error *error) {
  const response_curve *c = run->curve;
  const damping_spec *damping = &c->request->damping;
  const bool by_mode = c->request->mode == 0 && damping->ratio_count > 0;
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  const double dt = THRUM_TWO_PI / c->rows[row].point.omega / STEPS;
  response_curve_state(c, row, q, p);
  *point = (response_worth_point){.row = row};
  THRUM_TRY(thrum_displacement(c->shape, q, 0, c->shape->vertex_count, run->start, error));
  THRUM_TRY(step_model(run, c->rows[row].point.omega, q, p, &point->model, error));
  thrum_full_def full = thrum_default_full_def();
  full.dt = dt;
  full.law = thrum_law_of_model(c->shape);
  full.damping_alpha = by_mode && run->moved > 0 ? run->lost / run->moved : damping->alpha;
  full.damping_beta = by_mode ? 0 : damping->beta;
  thrum_full *body = NULL;
  thrum_status status = thrum_full_create(c->shape, NULL, &full, &body, error);
  THRUM_THEN(status, step_mesh(run, body, p, &point->mesh, &point->gain, error));
  const double lost = c->rows[row].point.dissipated;
  point->gain = lost > 0 ? point->gain / lost : NAN;
  thrum_full_free(body);
  return status;
}

/* The next stable row from `row` on; -1: there is none. */
static int64_t stable_from(const response_curve *c, int64_t row) {
  while (row < c->count && c->rows[row].point.unstable > 0)
    row++;
  return row < c->count ? row : -1;
}

/* Rows that are worth a look, each once. */
static int64_t choose_rows(const response_curve *c, int64_t wanted, int64_t *rows) {
  int64_t count = 0, best = -1;
  for (int64_t n = 0; n < c->count && c->target_count > 0; n++)
    if (c->rows[n].point.unstable <= 0 &&
        (best < 0 || c->peak[n * c->target_count] > c->peak[best * c->target_count]))
      best = n;
  if (best >= 0)
    rows[count++] = best;
  for (int64_t k = 1; k < wanted && count < wanted; k++) {
    const int64_t row = stable_from(c, k * c->count / wanted);
    bool seen = row < 0;
    for (int64_t n = 0; n < count; n++)
      seen = seen || rows[n] == row;
    if (!seen)
      rows[count++] = row;
  }
  return count;
}

/* Points at which the mesh sums its forces, about: 14 a tetrahedron of ten nodes weigh as one. */
static double work_of(const thrum_model *shape) {
  const double linear = 1.0 / 14;
  return (double)shape->tet_count * (shape->midsides != NULL ? 1 : linear);
}

/* Motions that are looked at; where the request leaves it open, as many as take some seconds. */
static int64_t wanted_of(const response_curve *curve) {
  const thrum_model *shape = curve->shape;
  const int64_t wanted = curve->request->check;
  if (wanted >= 0)
    return wanted;
  if (shape->basis == NULL || shape->vertices == NULL || curve->count == 0)
    return 0;
  const double most = USUAL_WORK / fmax(1, work_of(shape));
  return most >= USUAL ? USUAL : (int64_t)most;
}

thrum_status response_worth_find(const response_curve *curve, response_worth *worth,
                                 thrum_error *error) {
  *worth = (response_worth){0};
  const int64_t wanted = wanted_of(curve);
  worth->left_out = wanted == 0 && curve->request->check < 0 && curve->shape->basis != NULL;
  if (wanted == 0)
    return THRUM_OK;
  if (curve->shape->basis == NULL || curve->shape->vertices == NULL)
    return thrum_error_set(error, THRUM_MISSING, "--check: the model has no mesh");
  mesh_run run = {.curve = curve, .size = 3 * curve->shape->vertex_count};
  THRUM_TRY(thrum_reserve(&run.memory, 7 * run.size, sizeof *run.memory, "the mesh", error));
  double **const fields[] = {&run.u,      &run.v,    &run.start, &run.forces,
                             &run.cosine, &run.sine, &run.mean};
  for (int n = 0; n < 7; n++)
    *fields[n] = run.memory + n * run.size;

  // one orbit after the other
  int64_t rows[RESPONSE_WORTH_MOST];
  const int64_t count = choose_rows(curve, wanted, rows);
  config_progress progress = config_progress_make(curve->request->quiet);
  const double began = clock_seconds();
  run.until = curve->request->check < 0 ? began + USUAL_SECONDS : INFINITY;
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0 && !thrum_stop_requested(); n++) {
    config_progress_update(&progress, "orbits of the mesh", (double)n / (double)count);
    status = look_at(&run, rows[n], &worth->points[worth->count], error);

    // a mesh that cannot take the steps does not follow the orbit
    if (status == THRUM_NOT_CONVERGED) {
      worth->points[worth->count].mesh = INFINITY;
      status = THRUM_OK;
    }
    if (status < 0 || run.late)
      break;
    worth->largest = fmax(worth->largest, worth->points[worth->count++].mesh);
  }
  config_progress_end(&progress, status >= 0);
  worth->stopped = thrum_stop_requested() && worth->count < count;
  worth->left_out = run.late && worth->count == 0 && !worth->stopped;
  worth->seconds = clock_seconds() - began;
  free(run.memory);
  return status;
}
