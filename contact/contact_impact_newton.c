/* All impulses of an impact at once, by Newton's method in the velocities of the bodies as a whole,
 * where sweeps over its rows do not settle: places of two faces share an impulse in many ways, and
 * those of a stack pass it on from body to body.
 *
 * With z the velocities that the impulses add, scaled by the roots of masses and inertias, B_i the
 * rows of place i (3 x 12, of two bodies) and x_i = x_i0 + B_i z its velocity, each row has its
 * laws with a compliance c about the impulse that it had, P_i along the normal and T_i across it:
 *
 *   P = max(P_i + (away - n x) / c, 0),   T = T_i - x_t / c', of no more than mu P_i
 *
 * These are proximal points of the laws (Rockafellar 1976, doi:10.1137/0314056), and the laws
 * themselves where the impulses stay. z minimises a convex function with one derivative, by
 * Newton's method and a search along its steps (contact_pairs_newton.c). After a whole step the
 * rows go on from the impulses that they have then, which is the method of multipliers. Cost: 400
 * operations a row, m^3/6 at most, an iteration; m is 6 for each body.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "contact/contact_impact_private.h"
#include "contact/contact_newton.h"

#define SOFTNESS 0.01 /* of the response of a row: the compliance about its impulse */

/* An impact of bodies that have m velocities. */
typedef struct newton {
  const thrum_impact_rows *rows;
  int64_t m, stride; /* stride: of the rows of the matrix */
  double *matrix;    /* m x m, upper triangle by rows */
  double *z;         /* scaled velocities that the impulses add */
  double *gradient, *step;
} newton;

/* --- bodies ----------------------------------------------------------------------------------- */

/* Root of the inverse inertia; 0 for a body that does not turn. False where it has none. */
static bool root_of(const double inverse[9], double root[9]) {
  if (inverse[0] > 0.0)
    return thrum_newton_root(inverse, root);
  memset(root, 0, 9 * sizeof *root);
  return inverse[0] == 0.0 && inverse[4] == 0.0 && inverse[8] == 0.0;
}

/* Gives each body that is struck and not driven its columns; false where there are too many. */
static bool find_columns(newton *of, int64_t most) {
  for (int64_t n = 0; n < of->rows->count; n++) {
    thrum_impact_body *body = &of->rows->runs[n].impact;
    body->column = -1;
    if (!body->taken || !(body->inverse_mass > 0.0))
      continue;
    if (of->m + 6 > most || !root_of(body->inverse, body->root))
      return false;
    body->column = of->m;
    of->m += 6;
  }
  return of->m > 0;
}

/* --- rows ------------------------------------------------------------------------------------- */

/* The columns of a side of a row, B: 3 x 6. */
static void fill_side(const thrum_impact_place *at, int side, double ways[3][6]) {
  const thrum_impact_body *body = &at->bodies[side]->impact;
  const double sign = side == 0 ? 1.0 : -1.0, whole = sign * sqrt(body->inverse_mass);
  for (int k = 0; k < 3; k++) {
    const double turn[3] = {body->root[k], body->root[3 + k], body->root[6 + k]};
    double moved[3];
    thrum_cross3(turn, at->arms[side], moved);
    for (int axis = 0; axis < 3; axis++) {
      ways[axis][k] = axis == k ? whole : 0.0;
      ways[axis][3 + k] = sign * moved[axis];
    }
  }
}

/* The sides of a row that have columns, the lower ones first; returns how many. */
static int sides_of(const thrum_impact_place *at, int sides[2]) {
  int count = 0;
  for (int side = 0; side < 2 && at->bodies[side] != NULL; side++)
    if (at->bodies[side]->impact.column >= 0)
      sides[count++] = side;
  if (count == 2 && at->bodies[1]->impact.column < at->bodies[0]->impact.column) {
    sides[0] = 1;
    sides[1] = 0;
  }
  return count;
}

/* z += B^T impulse */
static void add_impulse(const thrum_impact_place *at, const double impulse[3], double *z) {
  int sides[2];
  const int count = sides_of(at, sides);
  for (int n = 0; n < count; n++) {
    double ways[3][6];
    fill_side(at, sides[n], ways);
    double *to = z + at->bodies[sides[n]]->impact.column;
    for (int k = 0; k < 6; k++)
      to[k] += impulse[0] * ways[0][k] + impulse[1] * ways[1][k] + impulse[2] * ways[2][k];
  }
}

/* out = B z */
static void way_of(const thrum_impact_place *at, const double *z, double out[3]) {
  int sides[2];
  const int count = sides_of(at, sides);
  memset(out, 0, 3 * sizeof *out);
  for (int n = 0; n < count; n++) {
    double ways[3][6];
    fill_side(at, sides[n], ways);
    const double *of = z + at->bodies[sides[n]]->impact.column;
    for (int axis = 0; axis < 3; axis++)
      for (int k = 0; k < 6; k++)
        out[axis] += ways[axis][k] * of[k];
  }
}

/* matrix += B^T rate B, its upper triangle. */
static void add_to_matrix(const newton *of, const thrum_impact_place *at, const double rate[9]) {
  int sides[2];
  const int count = sides_of(at, sides);
  double ways[2][3][6], pushed[3][6];
  for (int n = 0; n < count; n++)
    fill_side(at, sides[n], ways[n]);

  // one block of the matrix after the other
  for (int n = 0; n < count; n++) {
    for (int axis = 0; axis < 3; axis++)
      for (int k = 0; k < 6; k++)
        pushed[axis][k] = rate[3 * axis] * ways[n][0][k] + rate[3 * axis + 1] * ways[n][1][k] +
                          rate[3 * axis + 2] * ways[n][2][k];
    for (int other = n; other < count; other++) {
      const int64_t from = at->bodies[sides[n]]->impact.column;
      double *to = of->matrix + from * of->stride + at->bodies[sides[other]]->impact.column;
      for (int k = 0; k < 6; k++, to += of->stride)
        for (int j = 0; j < 6; j++)
          to[j] += pushed[0][k] * ways[other][0][j] + pushed[1][k] * ways[other][1][j] +
                   pushed[2][k] * ways[other][2][j];
    }
  }
}

/* The impulse of a row at a velocity; rate: by which it falls with the velocity (3 x 3), or NULL.
 */
static void respond(const thrum_contact_row *row, const double x[3], double impulse[3],
                    double *rate) {
  const thrum_row_strike *strike = &row->strike;
  const double *n = row->touch.normal, along = thrum_dot3(n, x);
  const double scale = 1.0 / (SOFTNESS * strike->along);
  const double across_scale = 1.0 / (SOFTNESS * strike->across);
  const double force = fmax(strike->force + scale * (strike->away - along), 0.0);
  for (int axis = 0; axis < 3; axis++)
    impulse[axis] = force * n[axis];

  // across the normal, within the bound
  double tangential[3] = {0.0, 0.0, 0.0}, share = 0.0;
  const bool rubs = strike->most > 0.0;
  for (int axis = 0; axis < 3 && rubs; axis++)
    tangential[axis] = strike->tangential[axis] - across_scale * (x[axis] - along * n[axis]);
  const double square = thrum_dot3(tangential, tangential);
  const bool slips = square > strike->most * strike->most;
  if (rubs)
    share = slips ? strike->most / sqrt(square) : 1.0;
  for (int axis = 0; axis < 3; axis++)
    impulse[axis] += share * tangential[axis];
  if (rate == NULL)
    return;

  // at its bound an impulse turns with the velocity alone
  const double pressed = force > 0.0 ? scale : 0.0, held = share * across_scale;
  const double turns = slips && rubs ? held / square : 0.0;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      rate[3 * a + b] = (pressed - held) * n[a] * n[b] + (a == b ? held : 0.0) -
                        turns * tangential[a] * tangential[b];
}

/* A row goes on from an impulse: its bound of friction is that of the impulse. */
static void go_on_from(thrum_contact_row *row, const double impulse[3]) {
  thrum_row_strike *strike = &row->strike;
  strike->force = fmax(thrum_dot3(impulse, row->touch.normal), 0.0);
  strike->most = strike->friction * strike->force;
  for (int axis = 0; axis < 3; axis++)
    strike->tangential[axis] = impulse[axis] - strike->force * row->touch.normal[axis];
}

/* --- an iteration ----------------------------------------------------------------------------- */

/* The next row of the impact. */
static bool next_part(const newton *of, thrum_impact_cursor *at, thrum_impact_place *found) {
  while (thrum_impact_next(of->rows, at, found))
    if (found->row->strike.part != THRUM_NO_PART)
      return true;
  return false;
}

/* Takes up the impulses that the rows have. */
static void take_up(const newton *of) {
  thrum_impact_place at;
  memset(of->z, 0, (size_t)of->m * sizeof *of->z);
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    go_on_from(at.row, at.row->strike.impulse);
    thrum_impact_velocity(&at, at.row->strike.at);
    add_impulse(&at, at.row->strike.impulse, of->z);
  }
}

/* The gradient and the matrix at z. */
static void linearise(void *newton_of) {
  const newton *of = newton_of;
  thrum_impact_place at;
  memcpy(of->gradient, of->z, (size_t)of->m * sizeof *of->gradient);
  memset(of->matrix, 0, (size_t)(of->m * of->stride) * sizeof *of->matrix);
  for (int64_t q = 0; q < of->m; q++)
    of->matrix[q * of->stride + q] = 1.0;
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    double impulse[3], rate[9];
    respond(at.row, at.row->strike.at, impulse, rate);
    const double back[3] = {-impulse[0], -impulse[1], -impulse[2]};
    if (!(rate[0] + rate[4] + rate[8] > 0.0))
      continue;
    add_impulse(&at, back, of->gradient);
    add_to_matrix(of, &at, rate);
  }
}

/* By how much the velocities of the rows change in a whole step; returns the largest [m/s]. */
static double fill_ways(void *newton_of) {
  const newton *of = newton_of;
  thrum_impact_place at;
  double most = 0.0;
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    way_of(&at, of->step, at.row->strike.way);
    most = fmax(most, thrum_dot3(at.row->strike.way, at.row->strike.way));
  }
  return sqrt(most);
}

/* The slope less what the rows do at a share of the step. */
static double fall(const void *newton_of, double share, double slope) {
  const newton *of = newton_of;
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    const thrum_row_strike *strike = &at.row->strike;
    double x[3], impulse[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = strike->at[axis] + share * strike->way[axis];
    respond(at.row, x, impulse, NULL);
    slope -= thrum_dot3(impulse, strike->way);
  }
  return slope;
}

/* Moves the rows by a share of the step. */
static void take(void *newton_of, double share) {
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; next_part(newton_of, &n, &at);)
    for (int axis = 0; axis < 3; axis++)
      at.row->strike.at[axis] += share * at.row->strike.way[axis];
}

/* All rows go on from the impulses that they have. */
static void go_on(void *newton_of) {
  thrum_impact_place at;
  for (thrum_impact_cursor n = {0, 0}; next_part(newton_of, &n, &at);) {
    double impulse[3];
    respond(at.row, at.row->strike.at, impulse, NULL);
    go_on_from(at.row, impulse);
  }
}

/* The impulses that were solved for become those of the rows and the bodies; where they are not
 * finite nothing changes, and it returns false. */
static bool give_back(const newton *of) {
  thrum_impact_place at;
  double sum = 0.0;
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    double impulse[3];
    respond(at.row, at.row->strike.at, impulse, NULL);
    go_on_from(at.row, impulse);
    sum += thrum_dot3(impulse, impulse);
  }
  if (!isfinite(sum))
    return false;

  // what each row has more than it had
  for (thrum_impact_cursor n = {0, 0}; next_part(of, &n, &at);) {
    thrum_row_strike *strike = &at.row->strike;
    double more[3];
    for (int axis = 0; axis < 3; axis++)
      more[axis] = strike->force * at.row->touch.normal[axis] + strike->tangential[axis] -
                   strike->impulse[axis];
    thrum_impact_push(&at, more);
  }
  return true;
}

bool thrum_impact_newton(const thrum_impact_rows *rows, double tolerance) {
  static const thrum_newton_laws laws = {linearise, fill_ways, fall, take, go_on};
  double own[8 * (8 + 3)];
  bool settled;
  newton of = {.rows = rows, .matrix = rows->pairs ? rows->pairs->view.impact_room : own};
  const int64_t most = rows->pairs ? THRUM_IMPACT_WIDTH(rows->pairs->pairs->member_max) : 6;
  if (!find_columns(&of, most))
    return false;

  // the room of the step
  of.stride = THRUM_NEWTON_STRIDE(of.m);
  of.z = of.matrix + of.m * of.stride;
  of.gradient = of.z + of.m;
  of.step = of.gradient + of.m;
  take_up(&of);
  const thrum_newton_system system = {of.m, of.z, of.gradient, of.step, of.matrix};
  if (!thrum_newton_minimise(&system, &laws, &of, tolerance, &settled))
    return false;
  return give_back(&of);
}
