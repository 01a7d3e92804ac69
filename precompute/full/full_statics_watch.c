/* The branch of equilibria that a full-order body is on (design 12). Steps of the load are small
 * enough to stay on it: each goes along du/dfactor = K^-1 d(load)/dfactor, is corrected by Newton
 * without a shift of the tangent, and is cut where the tangent is not positive definite on the way,
 * where the mean of the rates at both of its ends does not explain how far the body has gone, or
 * where the body is much stiffer at its end.
 * The least eigenvalue of K x = lambda M x is taken at each equilibrium. Where steps end in nothing
 * and the eigenvalue goes to zero, stability is lost: between the last stable equilibrium and the
 * least load that led nowhere. At a limit point the rate is all in the softest mode, and the square
 * of the eigenvalue is linear in the load; at a bifurcation the mode has no part in the rate, and
 * the eigenvalue itself is linear. The place is extrapolated by that and closed in from both sides.
 * The body then falls: it is loaded a little more and pushed along the mode.
 *
 * Cost: what the steps take, and for a critical load about ten factorisations more.
 * Source: Crisfield 1991, Non-linear finite element analysis of solids and structures, volume 1,
 * chapter 9 (ISBN 978-0-471-97059-0).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/full/full_statics.h"

#define STEPS_MAX 2000
#define FIRST_STEP 0.25
#define UNEXPLAINED 0.5    /* share of a step that the rates at its ends may leave unexplained */
#define EASY 0.1           /* and below which the next one is longer */
#define STIFFER 0.5        /* share of the rate at its start that a step may leave at its end */
#define CRITICAL_NEAR 1e-6 /* width of the bracket of a critical load, of that load */
#define LATER_NEAR 1e-5    /* the same after the first, whose place is not reported */
#define SOFT 0.2           /* of the stiffness at rest, below which a branch may end */
#define ENDS 1e-2          /* of the load: how far its end may then be, by extrapolation */
#define BEYOND 1e-1        /* share of the load by which the body is loaded past its end */
#define PUSH 1e-3          /* of the displacement, along the softest mode */
#define PUSHES 5
#define STRICT_MOST 15  /* iterations of a step that must not leave its branch */
#define SETTLE_MOST 250 /* iterations of a fall */
#define SHIFT_FIRST 1e-4
#define SHORT 0.25 /* length of a step that is called short */
#define SHORT_MOST 8
#define LEAP_STEPS 6
#define RATE_STEP 1e-4 /* of the factor, in the difference that gives the rate of the load */
#define ROUGH 1e-2     /* of the eigenvalue, on the way */
#define EXACT 1e-6     /* and where it is reported */

typedef struct branch {
  full_search *s;
  full_soft soft;
  double *memory;
  double *rate;                /* du/dfactor at s->factor, where u is s->kept */
  double *rate_next;           /* at the end of the step */
  double *drive;               /* d(load)/dfactor on the free components */
  double least, least_scale;   /* eigenvalue at s->factor and at the start */
  double share;                /* of the rate's energy that is in the softest mode */
  double before, before_least; /* the equilibrium before that one */
  double beyond;               /* the least factor at which a step came to nothing */
  bool ended;                  /* the branch did, and no way down from there was found */
  double left;                 /* share of the last step that is unexplained */
} branch;

/* d(load)/dfactor at the present displacement: exact for dead loads, else by a central difference
 * that feels held components move. */
static void take_drive(branch *b) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  if (s->loading->moves == NULL && s->hold == NULL && s->loading->turn_count == 0 &&
      full->body.acting == NULL) {
    memcpy(b->drive, full->f, (size_t)n * sizeof *b->drive);
    return;
  }
  const double factor = s->factor;
  full_statics_evaluate(s, factor + RATE_STEP);
  memcpy(b->drive, full->r, (size_t)n * sizeof *b->drive);
  full_statics_evaluate(s, factor - RATE_STEP);
  for (int64_t i = 0; i < n; i++)
    b->drive[i] = (b->drive[i] - full->r[i]) / (2 * RATE_STEP);
  full_statics_evaluate(s, factor);
}

/* The eigenvalue to `tolerance` and the rate at an equilibrium, with the tangent's factors. False
 * where it is not stable. */
static bool look(branch *b, double tolerance, double *rate, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  thrum_status status = full_soft_look(full, &b->soft, true, tolerance, error);
  if (status < 0 || !(b->soft.least > 0)) {
    s->failure = status == THRUM_OUT_OF_MEMORY ? status : s->failure;
    return false;
  }
  take_drive(b);
  status = full_linear_solve(&full->linear, b->drive, rate, error);
  s->failure = status == THRUM_OUT_OF_MEMORY ? status : s->failure;
  return status >= 0;
}

/* The share of the rate's energy that the softest modes have, where the rate itself has much. */
static double soft_share(const branch *b, const double *rate) {
  const double whole = full_dot(b->s->full, b->drive, rate);
  const double along = full_dot(b->s->full, b->drive, b->soft.vectors);
  return whole > 0 ? along * along / (b->soft.least * whole) : 0;
}

/* How much of the way from kept to u the rates at both ends leave unexplained. */
static double unexplained(const branch *b, double step) {
  const thrum_full *full = b->s->full;
  double left = 0, way = 0;
  for (int64_t i = 0; i < full->body.fem.free_count; i++) {
    const double gone = full->u[i] - b->s->kept[i];
    const double rest = gone - step * (b->rate[i] + b->rate_next[i]) / 2;
    left += rest * rest;
    way += gone * gone;
  }
  return way > 0 ? sqrt(left / way) : 0;
}

/* Does the body yield far less at the end of a step than at its start? Beyond a snap it is stiff
 * again, and one long step may land there. */
static bool stiffened(const branch *b) {
  const int64_t n = b->s->full->body.fem.free_count;
  double before = 0, after = 0;
  for (int64_t i = 0; i < n; i++) {
    before += b->rate[i] * b->rate[i];
    after += b->rate_next[i] * b->rate_next[i];
  }
  return after < STIFFER * STIFFER * before;
}

/* Takes u at this factor for the last equilibrium of the path. */
static void accept(branch *b, double factor, bool jumped) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const size_t vector = (size_t)full->body.fem.free_count * sizeof(double);
  double *rate = b->rate;
  b->rate = b->rate_next;
  b->rate_next = rate;
  b->before = jumped ? factor : s->factor;
  b->before_least = jumped ? INFINITY : b->least;

  b->least = b->soft.least;
  b->share = soft_share(b, b->rate);
  memcpy(s->before, s->kept, vector);
  memcpy(s->kept, full->u, vector);
  s->factor = factor;

  // the softest equilibrium of the way is reported
  if (b->least < s->found->softest) {
    s->found->softest = b->least;
    s->found->softest_factor = factor;
  }
  if (factor >= b->beyond)
    b->beyond = INFINITY;
  full_statics_visit(s, b->least, jumped);
}

/* Newton's own method, which ends near or not at all. */
static bool full_steps(full_search *s, double factor, thrum_error *error) {
  s->strict = true;
  s->most = STRICT_MOST;
  const bool done = full_statics_newton(s, factor, error);
  s->strict = false;
  s->most = 0;
  return done;
}

/* Full steps of Newton in which the energy may rise, kept where it is lower after them. Else the
 * body is back where it was, and so is the correction. */
static bool leap(branch *b, double factor, double *slope, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  const double enough = s->merit - 1e-4 * *slope;
  memcpy(b->rate_next, full->u, (size_t)n * sizeof *full->u);
  for (int k = 0; k<LEAP_STEPS && * slope> 0 && isfinite(*slope); k++) {
    for (int64_t i = 0; i < n; i++)
      full->u[i] += full->delta[i];
    full_statics_evaluate(s, factor);
    if (!isfinite(s->merit))
      break;
    *slope = full_statics_descend(s, error);
    if (s->merit < enough)
      return true;
  }

  memcpy(full->u, b->rate_next, (size_t)n * sizeof *full->u);
  full_statics_evaluate(s, factor);
  *slope = full_statics_descend(s, error);
  return false;
}

/* Downhill to an equilibrium, which may be far. Along a curved valley, where straight steps are
 * short, full ones are tried now and then: the watchdog of Chamberlain, Powell, Lemarechal and
 * Pedersen 1982, doi:10.1007/BFb0120945. */
static bool settle(branch *b, double factor, thrum_error *error) {
  full_search *s = b->s;
  int short_steps = 0;
  s->shift = SHIFT_FIRST;
  full_statics_evaluate(s, factor);
  double slope = full_statics_descend(s, error), length = 0;
  bool done = false;
  for (int k = 0; k < SETTLE_MOST && slope >= 0 && isfinite(slope) && !done; k++) {
    const double size = sqrt(slope);
    s->largest = fmax(s->largest, size);
    s->found->residual = s->largest > 0 ? size / s->largest : 0;
    done = size <= fmax(s->full->def.tolerance, 64 * DBL_EPSILON) * s->largest;
    if (done || (short_steps >= SHORT_MOST && leap(b, factor, &slope, error)))
      continue;

    // rounding may end it as well; a leap that came to nothing waits for as many short steps again
    if (!full_statics_shorten(s, factor, slope, &length)) {
      done = size <= 1e-7 * s->largest;
      break;
    }
    short_steps = short_steps >= SHORT_MOST || length >= SHORT ? 0 : short_steps + 1;
    slope = full_statics_descend(s, error);
  }
  s->shift = 0;
  return done;
}

/* One step along the branch to `factor`; false, and back where it was, where it does not lead
 * there. */
static bool step_to(branch *b, double factor, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  const double step = factor - s->factor, largest = s->largest, was = s->factor;
  for (int64_t i = 0; i < n; i++)
    full->u[i] = s->kept[i] + step * b->rate[i];

  // what the step goes is a measure of the corrections, in the norm of the tangent
  s->largest = fmax(largest, step * sqrt(fmax(full_dot(full, b->drive, b->rate), 0)));

  // Newton without a shift leads nowhere beyond a loss of stability
  bool done = full_steps(s, factor, error);
  s->factor = factor;
  done = done && look(b, ROUGH, b->rate_next, error);
  s->factor = was;
  b->left = done && !stiffened(b) ? unexplained(b, step) : INFINITY;
  if (b->left <= UNEXPLAINED) {
    accept(b, factor, false);
    s->found->load_steps++;
    return true;
  }

  memcpy(full->u, s->kept, (size_t)n * sizeof *full->u);
  s->largest = largest;
  s->found->cut_steps++;
  b->beyond = fmin(b->beyond, factor);
  return false;
}

/* Where the eigenvalue will be zero, by the last two equilibria; NaN where it does not fall. */
static double extrapolate(const branch *b) {
  const double factor = b->s->factor;
  double here = b->least, there = b->before_least;
  if (b->share > 0.5) {
    here *= here;
    there *= there;
  }
  return isfinite(there) && there > here ? factor + here * (factor - b->before) / (there - here)
                                         : NAN;
}

/* The next factor to try below one that led nowhere, with the end of the branch between. */
static double close_in(const branch *b, bool failed) {
  const double factor = b->s->factor, width = b->beyond - factor;
  const double gap = extrapolate(b) - factor, near = 0.25 * CRITICAL_NEAR * b->beyond;
  if (failed || !(gap > 0 && gap < width))
    return factor + 0.25 * (gap > 0 && gap < width ? gap : width);

  // from below nine tenths of the way at a time, and in the end from above
  return gap > near ? factor + 0.9 * gap : factor + fmin(gap + near, 0.5 * width);
}

/* Does the branch end before the factor that led nowhere, by what the stiffness says? */
static bool ends_before(const branch *b) {
  return extrapolate(b) < b->beyond;
}

/* Is the bracket of its end as close as is wanted? */
static bool has_closed(const branch *b) {
  const double near =
      b->s->found->instability == THRUM_INSTABILITY_NONE ? CRITICAL_NEAR : LATER_NEAR;
  return b->beyond - b->s->factor <= near * b->beyond;
}

/* Has the stiffness gone so far that the branch ends there, and was not only lost? */
static bool has_ended(const branch *b) {
  return b->least <= SOFT * b->least_scale && extrapolate(b) <= (1 + ENDS) * b->beyond;
}

/* Reports the first loss of stability, between the last equilibrium and `beyond`. */
static void note_loss(const branch *b) {
  thrum_full_equilibrium *found = b->s->found;
  if (found->instability != THRUM_INSTABILITY_NONE)
    return;
  const double factor = b->s->factor, guess = extrapolate(b);
  found->instability = b->share > 0.5 ? THRUM_INSTABILITY_LIMIT : THRUM_INSTABILITY_BIFURCATION;
  found->critical_from = factor;
  found->critical_to = b->beyond;
  found->critical = guess > factor && guess < b->beyond ? guess : (factor + b->beyond) / 2;
  found->critical_least = b->least;
}

/* Moves u along the softest mode, to the side where the energy is lower. */
static void push(branch *b, double factor) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  const double *mode = b->soft.vectors;
  const double size = sqrt(full_dot(full, full->u, full->u) / full_dot(full, mode, mode));
  double merit[2];
  for (int way = 0; way < 2; way++) {
    for (int64_t i = 0; i < n; i++)
      full->u[i] += (way == 0 ? PUSH : -2 * PUSH) * size * mode[i];
    full_statics_evaluate(s, factor);
    merit[way] = s->merit;
  }
  for (int64_t i = 0; i < n && merit[0] < merit[1]; i++)
    full->u[i] += 2 * PUSH * size * mode[i];
}

/* Down from the end of the branch to a stable equilibrium under `factor`. */
static bool fall_to(branch *b, double factor, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const double was = s->factor;
  for (int k = 0; k < PUSHES && s->failure >= 0; k++) {
    push(b, factor);
    if (!settle(b, factor, error))
      return false;
    s->factor = factor;
    if (s->found->stable && look(b, ROUGH, b->rate_next, error)) {
      b->beyond = INFINITY;
      accept(b, factor, true);
      return true;
    }

    // a saddle is left along its own softest mode
    s->factor = was;
    if (full_soft_look(full, &b->soft, false, ROUGH, error) < 0)
      return false;
  }
  return false;
}

/* From a branch that ends to another one, which may be far. Just beyond a bifurcation there is
 * hardly a way down, so the load grows where none is found. */
static bool fall(branch *b, thrum_error *error) {
  full_search *s = b->s;
  const size_t vector = (size_t)s->full->body.fem.free_count * sizeof(double);
  const double from = fmax(b->beyond, s->factor), largest = s->largest;
  for (double more = BEYOND; s->failure >= 0; more *= 16) {
    const double factor = fmin(1, (1 + more) * from);
    if (fall_to(b, factor, error)) {
      s->found->jumps++;
      return true;
    }
    memcpy(s->full->u, s->kept, vector);
    s->largest = largest;
    if (factor == 1)
      break;
  }
  return false;
}

static thrum_status begin(branch *b, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  THRUM_TRY(thrum_reserve(&b->memory, 3 * n, sizeof *b->memory, "the branch", error));
  THRUM_TRY(full_soft_make(full, &b->soft, error));
  b->rate = b->memory;
  b->rate_next = b->rate + n;
  b->drive = b->rate_next + n;
  b->beyond = INFINITY;
  b->before_least = INFINITY;
  memcpy(s->kept, full->u, (size_t)n * sizeof *full->u);
  memcpy(s->before, full->u, (size_t)n * sizeof *full->u);

  // the tangent at the start is factorised for its eigenvalue and for the first rate
  full_statics_evaluate(s, 0);
  THRUM_TRY(full_assemble(full, full->place, 1, 0, 0, error));
  THRUM_TRY(full_linear_prepare(&full->linear, error));
  if (!look(b, EXACT, b->rate, error))
    return s->failure < 0 ? s->failure : THRUM_SINGULAR;
  b->least = b->least_scale = s->found->softest = b->soft.least;
  b->share = soft_share(b, b->rate);
  s->found->softest_factor = 0;
  s->found->least_start = b->least;
  full_statics_visit(s, b->least, false);
  return THRUM_OK;
}

/* Along the branch to the whole load. False where that cannot be told from what was found: the body
 * is at s->factor then. */
static bool follow(branch *b, thrum_error *error) {
  full_search *s = b->s;
  double step = FIRST_STEP;
  bool failed = false;
  for (int k = 0; s->factor < 1; k++) {
    if (k == STEPS_MAX || s->failure < 0)
      return false;

    // a branch that softened ends here; one that did not has only been lost
    if (isfinite(b->beyond) && has_closed(b)) {
      if (!has_ended(b))
        return false;
      note_loss(b);
      b->ended = !fall(b, error);
      if (b->ended)
        return false;
      step = FIRST_STEP / 4;
      failed = false;
      continue;
    }

    // nothing is known of the load beyond a step that led on, unless the stiffness goes before it
    const double was = s->factor;
    if (isfinite(b->beyond) && !failed && !ends_before(b))
      b->beyond = INFINITY;
    const double to = isfinite(b->beyond) ? close_in(b, failed) : fmin(was + step, 1);
    failed = !step_to(b, to, error);
    if (!failed)
      step = (to - was) * (b->left < EASY ? 2 : 1);
  }
  return true;
}

/* Where the body is, looked at closely for the report. */
static void finish(branch *b, bool followed, thrum_error *error) {
  full_search *s = b->s;
  thrum_full *full = s->full;
  full_statics_evaluate(s, s->factor);
  const thrum_status status =
      full_soft_look(full, &b->soft, followed || s->found->stable, EXACT, error);
  s->failure = status == THRUM_OUT_OF_MEMORY ? status : s->failure;
  s->found->least = status >= 0 ? b->soft.least : NAN;
  if (status >= 0)
    s->found->stable = b->soft.least > 0;
  if (status >= 0 && b->soft.least < s->found->softest) {
    s->found->softest = b->soft.least;
    s->found->softest_factor = s->factor;
  }
}

bool full_statics_watch(full_search *s, thrum_error *error) {
  branch b = {.s = s};
  const thrum_status begun = begin(&b, error);
  if (begun == THRUM_OUT_OF_MEMORY)
    s->failure = begun;
  bool done = begun >= 0 && follow(&b, error);
  const bool followed = done;

  // the search that takes any equilibrium falls further than that along a mode, and goes on where a
  // branch was lost without a reason
  if (!done && s->failure >= 0) {
    s->found->lost_at = b.ended ? NAN : s->factor;
    s->found->lost = !b.ended;
    s->found->jumps += b.ended;
    done = full_statics_steps(s, error);
  }
  if (done && b.soft.memory != NULL)
    finish(&b, followed, error);

  full_soft_free(&b.soft);
  free(b.memory);
  return done && s->failure >= 0;
}
