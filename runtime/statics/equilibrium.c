/* The path of equilibria under a growing load (design 12): R(q) = factor f.
 *
 * A step goes along dq/dfactor = T^-1 f and is corrected by Newton; it is cut where the correction
 * is not small beside it, and grows where it is. The least eigenvalue of T is taken at each point.
 *   It passes zero and the path goes on: a bifurcation. Its place is found by regula falsi
 *   (Illinois); the body then falls from there to a stable equilibrium, unless it is to stay.
 *   Steps end in nothing at any length, or beyond a point the search always falls far away: the
 * path turns back, a limit point. The body falls to a stable equilibrium under a slightly larger
 * load. The linear estimate needs no path: T is quadratic in q, so its linear part along q_0 =
 * T(0)^-1 f is exactly dT = (T(q_0) - T(-q_0))/2, and the load that makes T(0) + x dT singular is
 * one over the largest eigenvalue of -T(0)^-1/2 dT T(0)^-1/2. Source: Crisfield 1991, Non-linear
 * finite element analysis of solids and structures, volume 1, chapter 9 (ISBN 978-0-471-97059-0).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/statics/equilibrium_private.h"

#include <math.h>
#include <string.h>

#include "core/base/def.h"
#include "core/base/finite.h"
#include "core/linear_algebra/symmetric.h"
#include "core/step/state_def.h"
#include "thrum/actuation.h"
#include "thrum/polynomial.h"

#define ALIGNMENT 64
#define CORRECTION 0.5   /* share of a step that Newton may change in it */
#define SHORTEST 0x1p-20 /* share of the load so far: a step this short ends at a limit point */
#define BEYOND 1e-3    /* share of the load so far by which the body is loaded past a limit point */
#define LINEAR 0.1     /* largest error of the linear estimate relative to the stiffness at rest */
#define PLACE_TRIES 40 /* iterations of regula falsi */
#define PLACE_NEAR 1e-9 /* share of the load there at which it ends */
#define EASY 0.05   /* correction over prediction below which the next load step is twice as long */
#define HARD 0.25   /* and above which it is shorter, */
#define SHORTER 0.7 /* by this factor */
#define FROM_REST 1e-30     /* of the whole load: a step this short is given up from rest too */
#define BUCKLING 1e-10      /* of the largest entry: less of an eigenvalue does not buckle a body */
#define TOLERANCE_MOST 1e-2 /* that a definition may ask for */

void thrum_equilibrium_def_init(thrum_equilibrium_def *def, size_t size) {
  const thrum_equilibrium_def defaults = {.cookie = sizeof(thrum_equilibrium_def),
                                          .factor = 1.0,
                                          .first_step = 0.125,
                                          .tolerance = 1e-10,
                                          .steps_max = 2000,
                                          .iterations_max = 500,
                                          .stay = 0,
                                          .kernel = THRUM_KERNEL_BEST};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

/* --- workspace -------------------------------------------------------------------------------- */

static size_t round_up(size_t doubles) {
  const size_t lane = ALIGNMENT / sizeof(double);
  return (doubles + lane - 1) / lane * lane;
}

/* Lays the arrays from `at` on; returns how many doubles they take. at NULL: only counts. */
static size_t lay_out(const thrum_model *model, thrum_search *s, double *at) {
  const size_t n = (size_t)model->rank;
  const size_t vector = round_up(n), spare = round_up(3 * n), matrix = round_up(n * n);
  const size_t work = round_up(thrum_work_count(model));
  const size_t levels = round_up((size_t)thrum_model_actuation_count(model));
  size_t used = 0;
#define X(name, size)                                                                              \
  if (at)                                                                                          \
    s->name = at + used;                                                                           \
  used += size;
  THRUM_EQUILIBRIUM_ARRAYS(X)
#undef X
  return used;
}

thrum_status thrum_equilibrium_size(const thrum_model *model, size_t *size, thrum_error *error) {
  THRUM_TRY(thrum_state_check_model(model, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  thrum_search none;
  *size = lay_out(model, &none, NULL) * sizeof(double);
  return THRUM_OK;
}

static thrum_status refuse(thrum_error *error, const char *name, double value, const char *range) {
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "%s of the equilibrium's def is %g; it must be %s", name, value, range);
}

static thrum_status check_def(const thrum_equilibrium_def *def, thrum_error *error) {
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_default_equilibrium_def");

  // written so that NaN is refused as well
  if (!(def->factor > 0.0) || !isfinite(def->factor))
    return refuse(error, "factor", def->factor, "finite and > 0");
  if (!(def->first_step > 0.0 && def->first_step <= 1.0))
    return refuse(error, "first_step", def->first_step, "in (0, 1]");
  if (!(def->tolerance > 0.0 && def->tolerance <= TOLERANCE_MOST))
    return refuse(error, "tolerance", def->tolerance, "in (0, 0.01]");

  if (def->steps_max < 1)
    return refuse(error, "steps_max", def->steps_max, ">= 1");
  if (def->iterations_max < 1)
    return refuse(error, "iterations_max", def->iterations_max, ">= 1");
  if (def->stay != 0 && def->stay != 1)
    return refuse(error, "stay", def->stay, "0 or 1");
  return THRUM_OK;
}

static thrum_status check_arguments(const thrum_model *model, const thrum_equilibrium_def *def,
                                    const double *load, const double *q, const void *workspace,
                                    size_t workspace_size, const thrum_equilibrium_report *report,
                                    thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_equilibrium_size(model, &size, error));
  THRUM_TRY(check_def(def, error));

  if (!load || !q || !workspace || !report)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the load, q, the workspace or the report is NULL");
  if ((uintptr_t)workspace % ALIGNMENT != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the workspace is not aligned to %d bytes",
                           ALIGNMENT);
  if (workspace_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL, "the workspace needs %zu bytes, not %zu",
                           size, workspace_size);

  // a number that is not finite would end as a failure to converge
  if (!thrum_all_finite(load, model->rank) || !thrum_all_finite(q, model->rank) ||
      (def->base && !thrum_all_finite(def->base, model->rank)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the load or q holds a number that is not finite");
  return THRUM_OK;
}

/* --- the path --------------------------------------------------------------------------------- */

/* A path that is followed; the last accepted equilibrium lies in s.q and s.rate. */
typedef struct path {
  thrum_search s;
  double factor; /* factor of the load at s.q */
  double step;   /* to be tried */
  double least;  /* eigenvalue of T at s.q */
  double energy; /* V there */
  double norm;   /* norm of the residual there */
  void (*visit)(void *context, const thrum_equilibrium_point *point);
  void *context;
} path;

/* Is this eigenvalue negative by more than rounding? */
static bool lost(const path *p, double least) {
  return least < -THRUM_STATIC_ROUNDING * p->s.scale[p->s.n - 1];
}

/* Levels that the model came with grow with the load. */
static void take_levels(thrum_search *s) {
  const thrum_model *model = s->model;
  s->actors = model->levels;
  if (!s->actors)
    return;
  memcpy(s->levels, s->actors, (size_t)thrum_model_actuation_count(model) * sizeof *s->levels);
  s->acting = *model;
  s->acting.levels = s->levels;
  s->model = &s->acting;
}

/* Sets up the path at the given q: the weights of the residual's norm, and the first step. */
static void begin(path *p, const double *q) {
  thrum_search *s = &p->s;
  const double *omega2 = s->model->omega2;
  const double floor = omega2[s->n - 1] > 0.0 ? THRUM_STATIC_ROUNDING * omega2[s->n - 1] : 1.0;
  double sum = 0.0;
  thrum_search_load(s, q, s->residual);

  // residuals are divided by omega mode by mode; a mode with omega = 0 gets a floor
  for (int32_t i = 0; i < s->n; i++) {
    s->scale[i] = fmax(omega2[i], floor);
    sum += s->residual[i] * s->residual[i] / s->scale[i];
  }
  s->load_norm = sqrt(sum);

  memcpy(s->q, q, (size_t)s->n * sizeof *q);
  memcpy(s->trial, q, (size_t)s->n * sizeof *q);
  s->amplitude = thrum_search_length(s, q, NULL);
  p->step = s->def->first_step * s->def->factor;
  s->report->critical = s->report->critical_linear = NAN;
  s->report->softest = INFINITY;
}

/* Takes s.trial for the equilibrium at `factor`. False where T is singular or overflows. */
static bool accept(path *p, double factor, double least, const thrum_search_measure *found,
                   bool jumped) {
  thrum_search *s = &p->s;
  const size_t vector = (size_t)s->n * sizeof(double);
  if (!thrum_search_rate(s, s->trial, s->rate_next))
    return false;

  memcpy(s->q, s->trial, vector);
  memcpy(s->rate, s->rate_next, vector);
  s->amplitude = fmax(s->amplitude, thrum_search_length(s, s->q, NULL));
  p->factor = factor;
  p->least = least;
  p->energy = found->energy;
  p->norm = found->norm;

  // the softest point of the path, for the report
  if (least < s->report->softest) {
    s->report->softest = least;
    s->report->softest_factor = factor;
  }
  if (p->visit) {
    const thrum_equilibrium_point point = {factor, found->energy, least, s->q, jumped};
    p->visit(p->context, &point);
  }
  return true;
}

/* The equilibrium at `factor` on the path through s.q: predicted, corrected, not far from there. */
static bool correct(path *p, double factor, thrum_search_measure *found, double *correction) {
  thrum_search *s = &p->s;
  for (int32_t i = 0; i < s->n; i++)
    s->trial[i] = s->q[i] + (factor - p->factor) * s->rate[i];
  memcpy(s->predicted, s->trial, (size_t)s->n * sizeof *s->predicted);

  // Newton from the prediction; the amplitude bounds how far it may go
  const double step = thrum_search_length(s, s->predicted, s->q);
  const double amplitude = s->amplitude;
  s->amplitude = fmax(amplitude, thrum_search_length(s, s->trial, NULL));
  const bool done = thrum_search_near(s, factor, found);
  s->amplitude = amplitude;

  // a correction that is large relative to the step may have left the path
  *correction = step > 0.0 ? thrum_search_length(s, s->trial, s->predicted) / step : 0.0;
  return done && *correction <= CORRECTION;
}

/* Reports the first loss of stability, with its mode at `at`. */
static void note_loss(path *p, double factor, thrum_instability kind, const double *at) {
  thrum_search *s = &p->s;
  if (s->report->instability != THRUM_INSTABILITY_NONE)
    return;
  s->report->instability = kind;
  s->report->critical = factor;
  thrum_search_least(s, at, true);
  memcpy(s->first_mode, s->soft, (size_t)s->n * sizeof *s->soft);
}

/* Factor at which the least eigenvalue passes zero between p->factor and `beyond`, where it is
 * `least`, by the Illinois method. */
static double locate(path *p, double beyond, double least) {
  double a = p->factor, at_a = p->least, b = beyond, at_b = least;
  int side = 0;
  for (int k = 0; k < PLACE_TRIES && b - a > PLACE_NEAR * b; k++) {
    const double middle = fmin(fmax((a * at_b - b * at_a) / (at_b - at_a), a), b);
    thrum_search_measure found;
    double correction;
    // a point that cannot be solved counts as beyond
    const bool solved = correct(p, middle, &found, &correction);
    const double at = solved ? thrum_search_least(&p->s, p->s.trial, false) : at_b;
    if (at == 0.0)
      return middle;

    // halving the value that stays keeps the other end moving
    if (at > 0.0) {
      a = middle;
      at_a = at;
      at_b *= side > 0 ? 0.5 : 1.0;
      side = 1;
    } else {
      b = middle;
      at_b = at;
      at_a *= side < 0 ? 0.5 : 1.0;
      side = -1;
    }
    if (fabs(at) <= THRUM_STATIC_ROUNDING * p->s.scale[p->s.n - 1])
      return middle;
  }
  return 0.5 * (a + b);
}

/* Goes from s.trial down to a stable equilibrium at `factor`, and lets the path go on there. */
static bool fall(path *p, double factor) {
  thrum_search_measure found;
  thrum_search *s = &p->s;
  s->amplitude = fmax(s->amplitude, thrum_search_length(s, s->trial, NULL));
  if (!thrum_search_down(s, factor, &found))
    return false;
  const double least = thrum_search_least(s, s->trial, false);
  s->report->jumps++;
  return accept(p, factor, least, &found, true);
}

/* The path goes on through `factor`, where it is unstable; s.trial is there. */
static bool buckle(path *p, double factor, double least, const thrum_search_measure *found) {
  thrum_search *s = &p->s;
  const size_t vector = (size_t)s->n * sizeof(double);
  memcpy(s->candidate, s->trial, vector);
  if (s->report->instability == THRUM_INSTABILITY_NONE) {
    const double critical = locate(p, factor, least);
    note_loss(p, critical, THRUM_INSTABILITY_BIFURCATION, s->candidate);
  }
  memcpy(s->trial, s->candidate, vector);
  return s->def->stay ? accept(p, factor, least, found, false) : fall(p, factor);
}

/* The path ends at s.q: the body is loaded a little more and falls. */
static bool snap(path *p) {
  thrum_search *s = &p->s;
  note_loss(p, p->factor, THRUM_INSTABILITY_LIMIT, s->q);
  memcpy(s->trial, s->q, (size_t)s->n * sizeof *s->q);
  const double factor = fmin((1.0 + BEYOND) * p->factor, s->def->factor);
  return !s->def->stay && fall(p, factor);
}

/* One step tried; false when the path cannot go on. */
static bool advance(path *p) {
  thrum_search *s = &p->s;
  const double whole = s->def->factor, careful = s->def->first_step * whole / 16.0;
  const double factor = p->factor + p->step < whole ? p->factor + p->step : whole;

  // one step along the path
  thrum_search_measure found = {0};
  double correction = 0.0;
  const bool solved = correct(p, factor, &found, &correction);
  const double least = solved ? thrum_search_least(s, s->trial, false) : 0.0;

  // stability is lost on the way: the path buckles
  if (solved && lost(p, least) && !lost(p, p->least)) {
    p->step = careful;
    s->report->load_steps++;
    return buckle(p, factor, least, &found);
  }

  // a step that needed little correction lets the next be longer
  if (solved && accept(p, factor, least, &found, false)) {
    s->report->load_steps++;
    p->step *= correction < EASY ? 2.0 : correction > HARD ? SHORTER : 1.0;
    p->step = fmin(p->step, 0.25 * whole);
    return true;
  }

  // a step that failed is halved; when it is too short to matter, the path turns back
  s->report->cut_steps++;
  p->step *= 0.5;
  // from rest a step that is short enough always leads on
  if (p->step >= fmax(SHORTEST * p->factor, FROM_REST * whole))
    return true;
  p->step = careful;
  return snap(p);
}

/* Relaxes the start. What counts as rounding is that of the largest displacement so far, which may
 * have been that of a start far away: then the search goes on from where it ended. */
static bool relax(path *p, thrum_search_measure *found) {
  thrum_search *s = &p->s;
  if (!thrum_search_down(s, 0.0, found))
    return false;
  const double load = s->def->tolerance * s->def->factor * s->load_norm;
  double length = thrum_search_length(s, s->trial, NULL);
  for (int32_t k = 0; length < 0.5 * s->amplitude && found->norm > load; k++) {
    s->amplitude = length;
    if (k == s->def->iterations_max || !thrum_search_down(s, 0.0, found))
      return false;
    length = thrum_search_length(s, s->trial, NULL);
  }
  s->amplitude = length < 0.5 * s->amplitude ? length : s->amplitude;
  return true;
}

/* Follows the path from the shape at rest up to the whole load. */
static bool follow(path *p) {
  thrum_search *s = &p->s;
  thrum_search_measure found;
  if (!relax(p, &found))
    return false;
  if (!accept(p, 0.0, thrum_search_least(s, s->trial, false), &found, false))
    return false;
  for (int32_t k = 0; p->factor < s->def->factor; k++) {
    if (k == s->def->steps_max || !advance(p))
      return false;
  }
  return true;
}

/* --- the linear estimate ---------------------------------------------------------------------- */

/* matrix_ij /= omega_i omega_j; returns its largest entry. */
static double divide_by_omega(const thrum_search *s, double *matrix) {
  const double *omega2 = s->model->omega2;
  const size_t n = (size_t)s->n;
  double largest = 0.0;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      matrix[i * n + j] /= sqrt(omega2[i] * omega2[j]);
      largest = fmax(largest, fabs(matrix[i * n + j]));
    }
  return largest;
}

/* Estimates the critical factor from the shape at rest (linear buckling); NaN where it would mean
 * nothing. */
static double linear_estimate(thrum_search *s) {
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++) {
    if (!(s->model->omega2[i] > 0.0))
      return NAN;
    s->trial[i] = s->load[i] / s->model->omega2[i];
    s->predicted[i] = -s->trial[i];
  }

  // the part of T that is linear in the displacement, by central difference along the linear
  // solution
  thrum_tangent_stiffness_by(s->kernel, s->model, s->trial, s->tangent, s->work);
  thrum_tangent_stiffness_by(s->kernel, s->model, s->predicted, s->factors, s->work);
  for (size_t a = 0; a < n * n; a++)
    s->tangent[a] = 0.5 * (s->tangent[a] - s->factors[a]);

  // critical where 1 + x times the least eigenvalue vanishes, in units of omega
  const double largest = divide_by_omega(s, s->tangent);
  const double least = thrum_symmetric_least(s->tangent, s->n, s->spare);
  if (!isfinite(least) || !(-least > BUCKLING * largest))
    return NAN;

  // where the body bends before it buckles, the linear estimate leaves out too much to be given
  for (size_t i = 0; i < n; i++)
    s->trial[i] /= -least;
  thrum_tangent_stiffness_by(s->kernel, s->model, s->trial, s->tangent, s->work);
  divide_by_omega(s, s->tangent);
  return fabs(thrum_symmetric_least(s->tangent, s->n, s->spare)) < LINEAR ? -1.0 / least : NAN;
}

/* --- all of it -------------------------------------------------------------------------------- */

/* Fills the report, the mode and q from the last equilibrium. */
static void finish(path *p, double *q, double *mode) {
  thrum_search *s = &p->s;
  thrum_equilibrium_report *report = s->report;
  const size_t vector = (size_t)s->n * sizeof(double);
  report->factor = p->factor;
  report->energy = p->energy;
  if (s->actors) {
    thrum_search_act(s, p->factor);
    report->load_energy += thrum_passes.act(s->kernel, s->model, s->q, NULL, NULL, 0.0);
  }
  report->least = p->least;
  report->residual = s->load_norm > 0.0 ? p->norm / (p->factor * s->load_norm) : 0.0;
  for (int32_t i = 0; i < s->n; i++)
    report->load_energy -=
        p->factor * s->load[i] * s->q[i] + (s->def->base ? s->def->base[i] * s->q[i] : 0.0);

  // a path that stayed stable reports its softest mode at the end
  if (mode && report->instability == THRUM_INSTABILITY_NONE) {
    thrum_search_least(s, s->q, true);
    memcpy(s->first_mode, s->soft, vector);
  }
  if (mode)
    memcpy(mode, s->first_mode, vector);
  memcpy(q, s->q, vector);
}

thrum_status thrum_equilibrium(const thrum_model *model, const thrum_equilibrium_def *def,
                               const double *load, double *q, void *workspace,
                               size_t workspace_size, thrum_equilibrium_report *report,
                               thrum_error *error) {
  thrum_equilibrium_def whole = thrum_default_equilibrium_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(check_arguments(model, def, load, q, workspace, workspace_size, report, error));

  // what is found stays here until it is complete: a failure leaves the outputs as they were
  thrum_equilibrium_report found = {0};
  path p = {.visit = def->visit, .context = def->context};
  p.s.model = model;
  p.s.def = def;
  p.s.load = load;
  p.s.n = (int32_t)model->rank;
  p.s.report = &found;
  p.s.kernel = thrum_kernel_get(def->kernel);
  lay_out(model, &p.s, workspace);
  take_levels(&p.s);
  begin(&p, q);
  if (!isfinite(p.s.load_norm))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the load is beyond the range of finite numbers");

  // the linear estimate, then the path itself
  found.critical_linear = def->base || p.s.actors ? NAN : linear_estimate(&p.s);
  memcpy(p.s.trial, q, (size_t)model->rank * sizeof *q);
  if (!follow(&p))
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "no equilibrium was found beyond %.6g of the load (%d steps, %d "
                           "iterations)%s",
                           p.factor, (int)found.load_steps, (int)found.iterations,
                           found.instability == THRUM_INSTABILITY_LIMIT && def->stay
                               ? ": the path turns back there, so there is none to stay on"
                               : "");

  finish(&p, q, def->mode);
  *report = found;
  return THRUM_OK;
}
