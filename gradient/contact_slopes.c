/* Contact with planes to first order (docs/contact.md; design 22): what a step's touches are
 * predicted from is linear, with c the share of the stiffness that the scheme has at the end,
 *
 *   e d = h kappa p + h^2/2 (f + sum b F - R(q)),   e = kappa^2 + h/2 nu^2 D + c h^2 omega^2
 *
 * and each touch has one of the laws, as it had in the step that was made:
 *
 *   spring   F = -(phi(g') - phi(g))/(g' - g) + damping,   g = a q,  g' = g + a d
 *   stored   F (g' - g) stays
 *   held     a d = h/2 (1 - e) a p, of a place that rests or is thrown back with e
 *   stick    the same across, with e = 0;  slide: F across is mu F, in a direction that stays
 *
 * A law that holds a place is a spring of HELD times what the place gives way by. With all F gone,
 * (1 + W sum b rate a^T) dd = ... is a system of the size of the model, whatever touches.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "gradient/contact_slopes.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "gradient/linear_system.h"
#include "thrum/polynomial.h"

#define HELD 1e7        /* rate of what is held, times the stiffness of its place */
#define LAW_OFF 1e-2    /* of a force: it is that of the spring */
#define STUCK 1e-6      /* of the bound of friction: less is stuck; of the force: it is none */
#define GIVEN_MOST 1e-3 /* share of the momentum that went back: more is not smooth */
#define SLOW 1e-9       /* of a speed: it is rest */

/* --- the prediction --------------------------------------------------------------------------- */

/* c of the scheme. */
static double share_at_end(const thrum_linear_step *step) {
  if (step->equation.form == THRUM_STEP_NEWMARK)
    return step->equation.newmark_beta;
  return step->equation.form == THRUM_STEP_VERLET ? 0.0 : 0.25;
}

/* e of a mode. */
static double give_of(const thrum_linear_step *step, int64_t i) {
  const double h = step->equation.dt, kappa = step->kappa[i], nu = step->nu[i];
  return kappa * kappa + 0.5 * h * nu * nu * step->damping[i] +
         share_at_end(step) * h * h * step->model->omega2[i];
}

/* W of a mode. */
static double weight_of(const thrum_linear_step *step, int64_t i) {
  return 0.5 * step->equation.dt * step->equation.dt / give_of(step, i);
}

/* R(q) at the start into part_start, and d into part_middle, under the whole force. */
static void predict(thrum_linear_step *step, const thrum_made_step *made, const double *force) {
  const double h = step->equation.dt;
  thrum_internal_force(step->model, made->q, step->part_start, step->work);
  for (int64_t i = 0; i < step->rank; i++)
    step->part_middle[i] =
        (h * step->kappa[i] * made->p[i] + 0.5 * h * h * (force[i] - step->part_start[i])) /
        give_of(step, i);
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Entry i of the row of a place along a direction. */
static double entry(const thrum_linear_step *step, int32_t vertex, const double direction[3],
                    int64_t i) {
  const int64_t n = step->rank;
  const double *rows = step->model->basis + 3 * (int64_t)vertex * n;
  return direction[0] * rows[i] + direction[1] * rows[n + i] + direction[2] * rows[2 * n + i];
}

/* That row times v. */
static double row_dot(const thrum_linear_step *step, const thrum_contact_slope *slope,
                      const double direction[3], const double *v) {
  double sum = 0.0;
  for (int64_t i = 0; i < step->rank; i++)
    sum += entry(step, slope->vertex, direction, i) * v[i];
  return sum;
}

/* to += by times that row */
static void add_row(const thrum_linear_step *step, const thrum_contact_slope *slope,
                    const double direction[3], double by, double *to) {
  for (int64_t i = 0; i < step->rank; i++)
    to[i] += by * entry(step, slope->vertex, direction, i);
}

/* --- laws ------------------------------------------------------------------------------------- */

/* A touch as it was made. */
typedef struct touching {
  thrum_touch touch;
  const thrum_obstacle *obstacle;
  double force, across[3];     /* N, along the normal and across it */
  double gap, reached;         /* at the start, and predicted */
  double speed;                /* along the normal at the start */
  double normal[3];            /* in the axes of the mesh, as what follows: */
  double rubs[3];              /* friction [N] */
  double crossed[3], slide[3]; /* across the normal: predicted, and where friction ends it [m] */
  double damping;              /* c/h [N/m] */
} touching;

/* The spring's force, and its slopes by g' and by g; false where the way is too short for them. */
static bool spring_of(const touching *t, double *force, double *by_end, double *by_start) {
  const double k = t->touch.stiffness, g = t->gap, e = t->reached;
  const double depth = fmax(-g, 0.0), end = fmax(-e, 0.0), way = e - g;
  const double damped = t->damping * (end - depth);
  if (g <= 0.0 && e <= 0.0) {
    *force = -0.5 * k * (g + e) + damped;
    *by_end = -0.5 * k - t->damping;
    *by_start = -0.5 * k + t->damping;
    return true;
  }
  if (way == 0.0)
    return false;
  const double fall = -0.5 * k * (end * end - depth * depth) / way;
  *force = fall + damped;
  *by_end = ((e < 0.0 ? k * end : 0.0) - fall) / way - (e < 0.0 ? t->damping : 0.0);
  *by_start = ((g < 0.0 ? -k * depth : 0.0) + fall) / way + (g < 0.0 ? t->damping : 0.0);
  return true;
}

/* What holds a place along a direction, from which it leaves with `bounce` times its speed. */
static thrum_contact_slope hold(const thrum_linear_step *step, int32_t vertex,
                                const double direction[3], double bounce) {
  thrum_contact_slope slope = {.vertex = vertex};
  memcpy(slope.along, direction, sizeof slope.along);
  memcpy(slope.push, direction, sizeof slope.push);
  double gives = 0.0;
  for (int64_t i = 0; i < step->rank; i++)
    gives += weight_of(step, i) * pow(entry(step, vertex, direction, i), 2);
  slope.rate = gives > 0.0 ? HELD / gives : 0.0;
  slope.by_p = 0.5 * step->equation.dt * (1.0 - bounce) * slope.rate;
  return slope;
}

/* The slope along the normal; what is not smooth in it. */
static thrum_rough_kind slope_normal(const thrum_linear_step *step, const touching *t,
                                     thrum_contact_slope *slope) {
  double force = 0.0, by_end = 0.0, by_start = 0.0;
  const double h = step->equation.dt, way = t->reached - t->gap;
  *slope = (thrum_contact_slope){.vertex = t->touch.vertex};
  memcpy(slope->along, t->normal, sizeof slope->along);
  memcpy(slope->push, t->normal, sizeof slope->push);
  if (spring_of(t, &force, &by_end, &by_start) && fabs(force - t->force) <= LAW_OFF * t->force) {
    slope->rate = -by_end;
    slope->by_q = by_end + by_start;
    return THRUM_ROUGH_NONE;
  }

  // a spring that gives back what it has stored
  const double away = 2.0 * way / h - t->speed;
  if (!(t->obstacle->restitution < 1.0) && way > 0.0) {
    slope->rate = t->force / way;
    return THRUM_ROUGH_STORED;
  }
  const bool strikes = t->speed < 0.0 && away > SLOW * fabs(t->speed);
  *slope = hold(step, t->touch.vertex, t->normal, strikes ? away / -t->speed : 0.0);

  // out of a depth it comes by a share of it
  if (!strikes && t->gap < 0.0 && away > 0.0)
    slope->by_q = 0.5 * h * slope->rate * (away / t->gap);
  return strikes ? THRUM_ROUGH_IMPACT : THRUM_ROUGH_REST;
}

/* Two directions across the normal. */
static void across_of(const double normal[3], double side[2][3]) {
  const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
  thrum_cross3(normal, fabs(normal[0]) < 0.5 ? x : y, side[0]);
  const double length = sqrt(thrum_dot3(side[0], side[0]));
  for (int axis = 0; axis < 3; axis++)
    side[0][axis] /= length;
  thrum_cross3(normal, side[0], side[1]);
}

static void note(const touching *t, thrum_rough_kind kind, thrum_contact_step_slopes *of) {
  if (kind == THRUM_ROUGH_NONE || of->kind != THRUM_ROUGH_NONE)
    return;
  of->kind = kind;
  of->vertex = t->touch.vertex;
  of->obstacle = t->touch.obstacle;
}

/* How the direction of friction turns, F = -mu N u with u along t - P and P the point nearest to t
 * on the way from 0 to h/2 v across the normal: `side` is across u in the plane. */
static thrum_contact_slope slope_turn(const thrum_linear_step *step, const touching *t,
                                      double size) {
  double u[3], off[3], along_way = 0.0, length = 0.0;
  thrum_contact_slope slope = {.vertex = t->touch.vertex};
  for (int axis = 0; axis < 3; axis++) {
    u[axis] = -t->rubs[axis] / size;
    along_way += t->slide[axis] * t->crossed[axis];
    length += t->slide[axis] * t->slide[axis];
  }
  const double at = length > 0.0 ? fmin(fmax(along_way / length, 0.0), 1.0) : 0.0;
  for (int axis = 0; axis < 3; axis++)
    off[axis] = t->crossed[axis] - at * t->slide[axis];
  const double distance = sqrt(thrum_dot3(off, off)), half = 0.5 * step->equation.dt;
  if (!(distance > 0.0))
    return slope;
  thrum_cross3(t->normal, u, slope.push);
  memcpy(slope.along, slope.push, sizeof slope.along);
  if (at > 0.0 && at < 1.0) {
    // P moves along the way with t, and u turns with the way alone
    memcpy(slope.along, u, sizeof u);
    slope.by_p = half * size * thrum_dot3(slope.push, t->slide) / length;
    return slope;
  }
  slope.rate = size / distance;
  slope.by_p = at * half * slope.rate;
  return slope;
}

/* The slopes of one touch, 1 to 3, into `slopes`; returns how many. */
static int64_t slopes_of(const thrum_linear_step *step, const touching *t,
                         const thrum_placement *placement, thrum_contact_slope slopes[3],
                         thrum_contact_step_slopes *of) {
  const double most = t->obstacle->friction * t->force;
  const double size = sqrt(thrum_dot3(t->across, t->across));
  note(t, slope_normal(step, t, slopes), of);
  if (!(size > STUCK * t->force))
    return 1;

  // friction at its bound follows the normal force
  if (size >= most * (1.0 - STUCK)) {
    double push[3], turned[3];
    for (int axis = 0; axis < 3; axis++)
      push[axis] = t->touch.force[axis] / t->force;
    memcpy(turned, push, sizeof turned);
    if (placement)
      thrum_apply3_transposed(placement->axes, push, turned);
    memcpy(slopes[0].push, turned, sizeof turned);
    slopes[1] = slope_turn(step, t, size);
    return 2;
  }
  double side[2][3];
  across_of(t->normal, side);
  for (int n = 0; n < 2; n++)
    slopes[1 + n] = hold(step, t->touch.vertex, side[n], 0.0);
  note(t, THRUM_ROUGH_STICK, of);
  return 3;
}

/* --- reading ---------------------------------------------------------------------------------- */

/* The way of a vertex with v in the mesh, along a direction there. */
static double moved(const thrum_linear_step *step, int32_t vertex, const double direction[3],
                    const double *v) {
  double sum = 0.0;
  for (int64_t i = 0; i < step->rank; i++)
    sum += entry(step, vertex, direction, i) * v[i];
  return sum;
}

/* Adds the forces of contact. */
static void add_forces(const thrum_linear_step *step, thrum_contact *contact,
                       const thrum_placement *placement, double *force) {
  thrum_touch touch;
  const int64_t count = thrum_contact_report_get(contact).touching;
  for (int64_t n = 0; n < count; n++) {
    double own[3];
    if (thrum_contact_touch_get(contact, n, &touch, NULL) < 0)
      continue;
    memcpy(own, touch.force, sizeof own);
    if (placement)
      thrum_apply3_transposed(placement->axes, touch.force, own);
    for (int64_t i = 0; i < step->rank; i++)
      force[i] += entry(step, touch.vertex, own, i);
  }
}

/* What a touch was. step->part_end has q' - q, part_middle the prediction. */
static touching read_touch(const thrum_linear_step *step, const thrum_made_step *made,
                           const thrum_touch *touch, const thrum_contact *contact,
                           const thrum_contact_environment *environment) {
  const double h = step->equation.dt;
  touching t = {.touch = *touch, .obstacle = environment->obstacles + touch->obstacle};
  t.force = thrum_dot3(touch->force, touch->normal);
  for (int axis = 0; axis < 3; axis++)
    t.across[axis] = touch->force[axis] - t.force * touch->normal[axis];
  memcpy(t.normal, touch->normal, sizeof t.normal);
  if (environment->placement)
    thrum_apply3_transposed(environment->placement->axes, touch->normal, t.normal);
  const double drift = thrum_dot3(touch->normal, t.obstacle->velocity);
  t.gap = touch->gap - moved(step, touch->vertex, t.normal, step->part_end) + h * drift;
  t.reached = t.gap + moved(step, touch->vertex, t.normal, step->part_middle) - h * drift;
  t.speed = moved(step, touch->vertex, t.normal, made->p) - drift;

  // what moves across the normal, against the obstacle
  double drifts[3];
  memcpy(drifts, t.obstacle->velocity, sizeof drifts);
  memcpy(t.rubs, t.across, sizeof t.rubs);
  if (environment->placement) {
    thrum_apply3_transposed(environment->placement->axes, t.obstacle->velocity, drifts);
    thrum_apply3_transposed(environment->placement->axes, t.across, t.rubs);
  }
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    t.crossed[axis] = moved(step, touch->vertex, unit, step->part_middle) - h * drifts[axis] -
                      (t.reached - t.gap) * t.normal[axis];
    t.slide[axis] =
        0.5 * h *
        (moved(step, touch->vertex, unit, made->p) - drifts[axis] - t.speed * t.normal[axis]);
  }
  const double pressure =
      t.obstacle->stiffness > 0.0 ? t.obstacle->stiffness : thrum_contact_stiffness(contact);
  t.damping = t.obstacle->damping * (touch->stiffness / pressure) / h;
  return t;
}

/* What went back along the impulses of contact after the step (docs/contact.md (16)); how that
 * changes is of the order of what it is, and left out. */
static void find_given(const thrum_linear_step *step, const thrum_made_step *made,
                       const double *forces, thrum_contact_step_slopes *of) {
  const double h = step->equation.dt;
  double sum = 0.0, square = 0.0, momentum = 0.0;
  for (int64_t i = 0; i < step->rank; i++) {
    const double p = 2.0 / h * step->kappa[i] * (made->q_next[i] - made->q[i]) - made->p[i];
    sum += (made->p_next[i] - p) * forces[i];
    square += forces[i] * forces[i];
    momentum += p * p;
  }
  if (fabs(sum) > GIVEN_MOST * sqrt(square * momentum) && of->kind == THRUM_ROUGH_NONE)
    of->kind = THRUM_ROUGH_GIVEN;
  of->given = square > 0.0 ? sum / square : 0.0;
}

/* Does all contact give back what it takes? */
static bool is_elastic(const thrum_contact_environment *environment) {
  for (int64_t n = 0; n < environment->obstacle_count; n++)
    if (environment->obstacles[n].restitution < 1.0 || environment->obstacles[n].friction > 0.0)
      return false;
  return true;
}

bool thrum_contact_slopes_read(thrum_linear_step *step, const thrum_made_step *made, double *force,
                               thrum_contact *contact, const thrum_contact_environment *environment,
                               thrum_contact_slope *slopes, int64_t most,
                               thrum_contact_step_slopes *of) {
  const int64_t n = step->rank, count = thrum_contact_report_get(contact).touching;
  for (int64_t i = 0; i < n; i++)
    step->part_y[i] = force[i];
  add_forces(step, contact, environment->placement, force);
  predict(step, made, force);
  for (int64_t i = 0; i < n; i++)
    step->part_end[i] = made->q_next[i] - made->q[i];
  const bool energy =
      step->equation.form == THRUM_STEP_TRAPEZOID || step->equation.form == THRUM_STEP_AVERAGE;
  const bool elastic = is_elastic(environment);

  for (int64_t k = 0; k < count; k++) {
    thrum_touch touch;
    thrum_contact_slope found[3];
    if (thrum_contact_touch_get(contact, k, &touch, NULL) < 0)
      continue;
    const touching t = read_touch(step, made, &touch, contact, environment);
    if (!(t.force > 0.0))
      continue;
    const int64_t more = slopes_of(step, &t, environment->placement, found, of);
    if (of->count + more > most)
      return false;
    memcpy(slopes + of->count, found, (size_t)more * sizeof *found);
    of->count += more;
    of->calmed = of->calmed || t.obstacle->restitution < 1.0 || t.obstacle->friction > 0.0;
  }
  of->calmed = of->calmed && step->equation.form != THRUM_STEP_VERLET;
  for (int64_t i = 0; i < n; i++)
    step->part_y[i] = force[i] - step->part_y[i];
  if (energy && elastic && of->count > 0)
    find_given(step, made, step->part_y, of);
  return true;
}

/* --- passes ----------------------------------------------------------------------------------- */

void thrum_contact_slopes_end(const thrum_linear_step *step, const thrum_contact_step_slopes *of,
                              double *p) {
  for (int64_t i = 0; of->calmed && i < step->rank; i++)
    p[i] *= thrum_contact_calm_factor(step->equation.dt, step->model->omega2[i]);
}

/* 1 + W sum b rate a^T, factored. */
static bool factor(thrum_linear_step *step, const thrum_contact_step_slopes *of,
                   const thrum_contact_slope *slopes) {
  const int64_t n = step->rank;
  double *matrix = step->jacobian;
  for (int64_t a = 0; a < n * n; a++)
    matrix[a] = a % (n + 1) == 0 ? 1.0 : 0.0;
  for (int64_t k = 0; k < of->count; k++) {
    const thrum_contact_slope *s = slopes + k;
    for (int64_t i = 0; i < n; i++) {
      const double by = weight_of(step, i) * entry(step, s->vertex, s->push, i) * s->rate;
      for (int64_t j = 0; j < n && by != 0.0; j++)
        matrix[i * n + j] += by * entry(step, s->vertex, s->along, j);
    }
  }
  return thrum_linear_factor(matrix, n, step->rows);
}

/* What the right side of the prediction changes by with a factor of the stiffness. */
static double stiffer(const thrum_linear_step *step, const thrum_made_step *made, int64_t i) {
  const double h = step->equation.dt, d = step->part_middle[i];
  const double kappa = thrum_linear_step_kappa(step, i), square = thrum_linear_step_nu(step, i);
  return kappa * (h * made->p[i] - 2.0 * step->kappa[i] * d) -
         d * (0.5 * h * step->damping[i] * square +
              share_at_end(step) * h * h * step->model->omega2[i]) -
         0.5 * h * h * step->part_start[i];
}

void thrum_contact_slopes_pull(thrum_linear_step *step, const thrum_made_step *made,
                               const thrum_contact_step_slopes *of,
                               const thrum_contact_slope *slopes, const double *p_end,
                               thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt;
  double *bar = step->x, *y = step->y, *answer = step->part_kappa;
  predict(step, made, made->force);
  for (int64_t i = 0; i < n; i++) {
    bar[i] = change->force[i] + of->given * p_end[i];
    y[i] = 0.0;
  }

  // from the forces to the displacement that they were predicted from
  for (int64_t k = 0; k < of->count; k++)
    add_row(step, slopes + k, slopes[k].along,
            -slopes[k].rate * row_dot(step, slopes + k, slopes[k].push, bar), y);
  if (!factor(step, of, slopes)) {
    for (int64_t i = 0; i < n; i++)
      change->q[i] = NAN;
    return;
  }
  thrum_linear_solve_transposed(step->jacobian, n, step->rows, y);
  for (int64_t i = 0; i < n; i++)
    answer[i] = weight_of(step, i) * y[i];
  for (int64_t k = 0; k < of->count; k++) {
    const double by = row_dot(step, slopes + k, slopes[k].push, bar) +
                      row_dot(step, slopes + k, slopes[k].push, answer);
    add_row(step, slopes + k, slopes[k].along, slopes[k].by_q * by, change->q);
    add_row(step, slopes + k, slopes[k].along, slopes[k].by_p * by, change->p);
  }

  // and on to what the prediction is made of
  thrum_tangent_product(step->model, made->q, answer, step->w, step->work);
  for (int64_t i = 0; i < n; i++) {
    const double z = y[i] / give_of(step, i);
    change->q[i] -= step->w[i];
    change->p[i] += step->kappa[i] * h * z;
    change->force[i] += answer[i];
    change->damping[i] -= 0.5 * h * step->nu[i] * step->nu[i] * step->part_middle[i] * z;
    change->stiffness += stiffer(step, made, i) * z;
  }
}

void thrum_contact_slopes_push(thrum_linear_step *step, const thrum_made_step *made,
                               const thrum_contact_slope *slopes,
                               const thrum_contact_step_slopes *of, thrum_step_change *change,
                               double *forces) {
  const int64_t n = step->rank;
  const double h = step->equation.dt;
  double *d = step->x, *product = step->w;
  predict(step, made, made->force);
  thrum_tangent_product(step->model, made->q, change->q, product, step->work);
  memset(forces, 0, (size_t)n * sizeof *forces);
  for (int64_t k = 0; k < of->count; k++)
    add_row(step, slopes + k, slopes[k].push,
            slopes[k].by_q * row_dot(step, slopes + k, slopes[k].along, change->q) +
                slopes[k].by_p * row_dot(step, slopes + k, slopes[k].along, change->p),
            forces);
  for (int64_t i = 0; i < n; i++) {
    const double right =
        step->kappa[i] * h * change->p[i] +
        0.5 * h * h * (change->force[i] - product[i] + forces[i]) +
        change->stiffness * stiffer(step, made, i) -
        0.5 * h * step->nu[i] * step->nu[i] * step->part_middle[i] * change->damping[i];
    d[i] = right / give_of(step, i);
  }
  if (factor(step, of, slopes))
    thrum_linear_solve(step->jacobian, n, step->rows, d);
  else
    d[0] = NAN;
  for (int64_t k = 0; k < of->count; k++)
    add_row(step, slopes + k, slopes[k].push,
            -slopes[k].rate * row_dot(step, slopes + k, slopes[k].along, d), forces);
  for (int64_t i = 0; i < n; i++)
    change->force[i] += forces[i];
}
