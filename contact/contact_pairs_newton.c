/* All rows of a group of bodies at once, between them and on their obstacles, by Newton's method in
 * the coordinates of all, where sweeps over rows do not settle: places of two faces share a load in
 * many ways, and sweeps shift it between them for hundreds of turns; and in a stack each body waits
 * for the one below.
 *
 * With z the displacements in the step that the forces of these rows add, scaled by the roots of
 * their weights, B_i the rows of place i (3 x m, world axes), x_i = x_i0 + B_i z its displacement,
 * and pulls as they are, each row has the law that it has in a sweep (contact_law.c), with a share
 * of its own response as a compliance c about the force f_i that it had:
 *
 *   f(x): the law of the row whose displacement without force is x - c f_i.
 *
 * It is the proximal point of the law (Rockafellar 1976, doi:10.1137/0314056), and the law itself
 * where f = f_i. For given bounds of friction z minimises the convex function
 * |z|^2 / 2 + sum phi_i(x_i), which has one derivative and piecewise a second,
 *
 *   z - sum B_i^T f_i(x_i) = 0,   (1 + sum B_i^T K_i B_i) dz = -(z - sum B_i^T f_i),   K = -df/dx
 *
 * (semismooth Newton: Qi & Sun 1993, doi:10.1007/BF01581275), with a line search by the slope of
 * that function. After a whole step the rows go on from the forces and the bounds that they have
 * then. A row has columns of the one or two bodies that it pushes alone.
 * Cost: 3 w^2/2 a row whose K has changed, 6 w a row, of w columns, and m^3/6 an iteration, less
 * where bodies do not touch; m and w are 56 for two free bodies of rank 20.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_newton.h"

#include <math.h>
#include <string.h>

#include "contact/contact_law.h"
#include "contact/contact_newton.h"
#include "contact/contact_point.h"
#include "core/base/two_lanes.h"

#define SOFTNESS 0.3 /* of a row's response: the compliance about its force */
#define ALIKE 0.3    /* of the derivatives of a row: by how much the sum may be off */

/* The bodies of the group and the rows that push them. */
typedef struct newton {
  const thrum_pairs_run *run;
  thrum_newton_body *bodies; /* one a member */
  int64_t m, count;          /* coordinates and rows */
  thrum_newton_row *rows;
  double *ways;            /* of the rows, which follow each other */
  double *matrix, *factor; /* m x m: sum, and its Cholesky factor, upper triangles by rows */
  double *z, *began;       /* scaled displacements, and those at the start */
  double *gradient, *step;
  double *roots;          /* of the weights of the shapes' coordinates */
  double *pushed, *close; /* 3 and 1 times the columns of a row */
} newton;

/* --- rows ------------------------------------------------------------------------------------- */

static bool turns(const thrum_contact_run *body) {
  return body->environment->rigid_frame != NULL && body->turn_weight[0] > 0.0;
}

/* How many coordinates of a body answer to a force; none of a solid. */
static int64_t columns_of(const thrum_pairs_run *run, int64_t member) {
  const thrum_contact_run *body = run->view.runs + member;
  if (!thrum_pairs_steps(run, member))
    return 0;
  return body->contact->rank + (body->mass_weight > 0.0 ? 3 : 0) + (turns(body) ? 3 : 0);
}

/* Fills the columns of the shape of a member for one place of a row. */
static void fill_shape(const newton *of, int64_t member, const double *basis, double sign,
                       int64_t width, double *restrict out) {
  const thrum_contact_run *body = of->run->view.runs + member;
  const double *roots = of->roots + of->bodies[member].first;
  const int64_t r = body->contact->rank;
  for (int axis = 0; axis < 3; axis++) {
    const double *axes = body->axes + 3 * axis;
    for (int64_t i = 0; i < r; i++)
      out[axis * width + i] =
          sign * roots[i] *
          (axes[0] * basis[i] + axes[1] * basis[r + i] + axes[2] * basis[2 * r + i]);
  }
}

/* The same of the body as a whole. */
static void fill_whole(const newton *of, int64_t member, const double lever[3], double sign,
                       int64_t width, double *out) {
  const thrum_contact_run *body = of->run->view.runs + member;
  int64_t at = body->contact->rank;
  const double whole = sign * sqrt(body->mass_weight);
  for (int axis = 0; axis < 9 && body->mass_weight > 0.0; axis++)
    out[axis / 3 * width + at + axis % 3] = axis / 3 == axis % 3 ? whole : 0.0;
  at += body->mass_weight > 0.0 ? 3 : 0;
  if (!turns(body))
    return;
  const double *root = of->bodies[member].turn_root;
  for (int k = 0; k < 3; k++) {
    const double turn[3] = {root[k], root[3 + k], root[6 + k]};
    double moved[3];
    thrum_cross3(turn, lever, moved);
    for (int axis = 0; axis < 3; axis++)
      out[axis * width + at + k] = sign * moved[axis];
  }
}

/* The columns of a row out of a vector, which follow each other in `close` where they do not there.
 */
static double *gather(const newton *of, const thrum_newton_columns *at, double *vector) {
  if (at->count[1] == 0 || at->first[1] == at->first[0] + at->count[0])
    return vector + at->first[0];
  memcpy(of->close, vector + at->first[0], (size_t)at->count[0] * sizeof *vector);
  memcpy(of->close + at->count[0], vector + at->first[1], (size_t)at->count[1] * sizeof *vector);
  return of->close;
}

/* Puts them back. */
static void scatter(const newton *of, const thrum_newton_columns *at, double *vector) {
  if (at->count[1] == 0 || at->first[1] == at->first[0] + at->count[0])
    return;
  memcpy(vector + at->first[0], of->close, (size_t)at->count[0] * sizeof *vector);
  memcpy(vector + at->first[1], of->close + at->count[0], (size_t)at->count[1] * sizeof *vector);
}

static int64_t width_of(const thrum_newton_row *at) {
  return at->columns.count[0] + at->columns.count[1];
}

/* vector += B^T force */
static void push(const newton *of, const thrum_newton_row *at, const double force[3],
                 double *vector) {
  double *close = gather(of, &at->columns, vector);
  thrum_rows_push(width_of(at), at->ways, force, NULL, close);
  scatter(of, &at->columns, vector);
}

/* The tangential part of -df/dx. off: from the point nearest on the way that friction aims at. */
static void add_friction_rate(const thrum_contact_row *law, double most, const double at[3],
                              double rate[9]) {
  const double *n = law->touch.normal, *slide = law->slide;
  const double square = thrum_dot3(slide, slide);
  const double share = square > 0.0 ? thrum_dot3(at, slide) / square : 0.0;
  const bool follows = share > 0.0 && share < 1.0;
  const double near = fmin(fmax(share, 0.0), 1.0);
  double off[3];
  for (int axis = 0; axis < 3; axis++)
    off[axis] = at[axis] - near * slide[axis];

  // along a way that it follows there is no force, and along a force at its bound no more of it
  const double distance = sqrt(thrum_dot3(off, off));
  const bool slips = distance > law->across * most;
  const double scale = slips ? most / distance : 1.0 / law->across;
  const double along = follows ? scale / square : 0.0;
  const double bound = slips ? scale / (distance * distance) : 0.0;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      rate[3 * a + b] += scale * ((a == b ? 1.0 : 0.0) - n[a] * n[b]) -
                         along * slide[a] * slide[b] - bound * off[a] * off[b];
}

/* The force of a row at a displacement; rate: -df/dx (3 x 3), or NULL. */
static void respond(const thrum_newton_row *at, const double x[3], double force[3], double *rate) {
  thrum_contact_row *row = at->row;
  const double along = row->along, across = row->across, friction = row->friction;
  const double *n = row->touch.normal;
  double tangential[3], across_force[3] = {0.0, 0.0, 0.0};

  // its law, with a part of its response
  row->along = SOFTNESS * along;
  row->across = SOFTNESS * across;
  row->friction = 1.0;
  const double far = thrum_dot3(n, x), gap_free = row->gap + far - row->along * at->force;
  const double normal = thrum_contact_normal(row, gap_free, row->touch.stored);
  for (int axis = 0; axis < 3; axis++)
    tangential[axis] = x[axis] - far * n[axis] - row->across * at->friction[axis];
  if (at->most > 0.0)
    thrum_contact_friction(row, at->most, tangential, across_force);
  for (int axis = 0; axis < 3; axis++)
    force[axis] = normal * n[axis] + across_force[axis];

  // how it falls
  if (rate != NULL) {
    const double normal_rate = thrum_contact_normal_rate(row, gap_free, row->touch.stored, normal);
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        rate[3 * a + b] = normal_rate * n[a] * n[b];
    if (at->most > 0.0)
      add_friction_rate(row, at->most, tangential, rate);
  }

  // the row as it was
  row->along = along;
  row->across = across;
  row->friction = friction;
}

/* The normal part of a force, and what is across it. */
static double split(const thrum_contact_row *row, const double force[3], double across[3]) {
  const double normal = fmax(thrum_dot3(force, row->touch.normal), 0.0);
  for (int axis = 0; axis < 3; axis++)
    across[axis] = force[axis] - normal * row->touch.normal[axis];
  return normal;
}

/* A row goes on from a force: its bound of friction is that of the force. */
static void go_on_from(thrum_newton_row *at, const double force[3]) {
  const thrum_contact_row *row = at->row;
  at->force = split(row, force, at->friction);
  at->most = row->friction * at->force;
  const double length = sqrt(thrum_dot3(at->friction, at->friction));
  for (int axis = 0; axis < 3 && length > at->most; axis++)
    at->friction[axis] *= at->most / length;
}

/* --- an iteration ----------------------------------------------------------------------------- */

/* Forces, the gradient and the matrix at z. */
static void linearise(void *newton_of) {
  const newton *of = newton_of;
  memcpy(of->gradient, of->z, (size_t)of->m * sizeof *of->gradient);
  for (int64_t n = 0; n < of->count; n++) {
    thrum_newton_row *at = of->rows + n;
    double force[3], rate[9], change[9];
    respond(at, at->at, force, rate);
    double off = 0.0, size = 0.0;
    for (int k = 0; k < 9; k++) {
      change[k] = rate[k] - at->rate[k];
      off += change[k] * change[k];
      size += rate[k] * rate[k];
    }

    // what most rows ask for stays from one iteration to the next, or nearly so
    if (off > ALIKE * ALIKE * size) {
      memcpy(at->rate, rate, sizeof rate);
      thrum_newton_add(&at->columns, at->ways, change, of->pushed, of->m, of->matrix);
    }
    const double back[3] = {-force[0], -force[1], -force[2]};
    if (force[0] != 0.0 || force[1] != 0.0 || force[2] != 0.0)
      push(of, at, back, of->gradient);
  }
  memcpy(of->factor, of->matrix, (size_t)(of->m * of->m) * sizeof *of->factor);
}

/* How far the rows go in a whole step; returns the largest [m]. */
static double fill_ways_on(void *newton_of) {
  const newton *of = newton_of;
  double most = 0.0;
  for (int64_t n = 0; n < of->count; n++) {
    thrum_newton_row *at = of->rows + n;
    thrum_rows_times(width_of(at), at->ways, gather(of, &at->columns, of->step), at->way);
    most = fmax(most, thrum_dot3(at->way, at->way));
  }
  return sqrt(most);
}

/* The slope less what the rows do at a share of the step. */
static double fall(const void *newton_of, double share, double slope) {
  const newton *of = newton_of;
  for (int64_t n = 0; n < of->count; n++) {
    const thrum_newton_row *at = of->rows + n;
    double x[3], force[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = at->at[axis] + share * at->way[axis];
    respond(at, x, force, NULL);
    slope -= thrum_dot3(force, at->way);
  }
  return slope;
}

/* --- the solve -------------------------------------------------------------------------------- */

/* The coordinates that answer to the rows; false where they cannot be solved in. Those of a body
 * are a multiple of four. */
static bool find_columns(newton *of) {
  of->m = 0;
  for (int64_t n = 0; n < of->run->count; n++) {
    const thrum_contact_run *body = of->run->view.runs + n;
    thrum_newton_body *at = of->bodies + n;
    at->first = of->m;
    at->count = THRUM_NEWTON_STRIDE(columns_of(of->run, n));
    of->m += at->count;
    if (of->m > THRUM_NEWTON_COLUMNS)
      return false;

    // its weights need roots
    for (int64_t i = 0; at->count > 0 && i < body->contact->rank; i++)
      if (!(body->view.weights[i] >= 0.0))
        return false;
    if (at->count > 0 && turns(body) && !thrum_newton_root(body->turn_weight, at->turn_root))
      return false;
  }
  return of->m > 0;
}

/* Scratch: two matrices, of which the sum begins with 1, and vectors. */
static void lay_out(newton *of) {
  const int64_t m = of->m;
  double *room = of->run->view.newton_room;
  of->rows = of->run->view.newton_rows;
  of->ways = of->run->view.newton_ways;
  of->matrix = room;
  of->factor = room + m * m;
  of->z = room + 2 * m * m;
  of->began = of->z + m;
  of->gradient = of->began + m;
  of->step = of->gradient + m;
  of->roots = of->step + m;
  of->pushed = of->roots + m;
  of->close = of->pushed + 3 * m;
  for (int64_t n = 0; n < of->run->count; n++) {
    const thrum_contact_run *body = of->run->view.runs + n;
    for (int64_t i = 0; of->bodies[n].count > 0 && i < body->contact->rank; i++)
      of->roots[of->bodies[n].first + i] = sqrt(body->view.weights[i]);
  }

  // no force yet
  memset(of->matrix, 0, (size_t)(m * m) * sizeof *of->matrix);
  for (int64_t q = 0; q < m; q++)
    of->matrix[q * m + q] = 1.0;
  memset(of->z, 0, (size_t)m * sizeof *of->z);
  memset(of->step, 0, (size_t)m * sizeof *of->step);
}

/* A row more, with the columns of these bodies, of which the second may be none (-1); its columns
 * are 0. */
static thrum_newton_row *begin_row(newton *of, thrum_contact_row *row, int64_t a, int64_t b) {
  thrum_newton_row *at = of->rows + of->count++;
  memset(at, 0, sizeof *at);
  at->row = row;
  at->ways = of->ways;
  at->columns.first[0] = of->bodies[a].first;
  at->columns.count[0] = of->bodies[a].count;
  if (b >= 0) {
    at->columns.first[1] = of->bodies[b].first;
    at->columns.count[1] = of->bodies[b].count;
  }
  memset(at->ways, 0, (size_t)(3 * width_of(at)) * sizeof *at->ways);
  of->ways += 3 * width_of(at);
  return at;
}

/* What the row is pushed by. */
static void finish_row(newton *of, thrum_newton_row *at) {
  double force[3];
  thrum_contact_row_force(at->row, force);
  go_on_from(at, force);
  push(of, at, force, of->z);
}

/* Takes up a row between two places of one body. */
static void take_own(newton *of, thrum_pair_row *row) {
  const thrum_contact_run *body = of->run->view.runs + row->members[0];
  thrum_newton_row *at = begin_row(of, &row->row, row->members[0], -1);
  fill_shape(of, row->members[0], thrum_pairs_basis(row, 0), 1.0, width_of(at), at->ways);
  thrum_point_shape(body, thrum_pairs_basis(row, 0), body->view.moved, at->at);
  finish_row(of, at);
}

/* Takes up a row between two bodies, of which the one whose columns come first has the first. */
static void take_pair(newton *of, thrum_pair_row *row) {
  const int lower = row->members[1] < row->members[0];
  thrum_newton_row *at = begin_row(of, &row->row, row->members[lower], row->members[1 - lower]);
  double moved[2][3];

  // what each side moves by, and the columns that it adds
  for (int side = 0; side < 2; side++) {
    const int64_t member = row->members[side];
    const thrum_contact_run *body = of->run->view.runs + member;
    const double *basis = thrum_pairs_basis(row, side), sign = side == 0 ? 1.0 : -1.0;
    const double *lever = side == 0 ? row->row.lever : row->lever;
    double *ways = at->ways + (side == lower ? 0 : at->columns.count[0]);
    thrum_point_moved(body, basis, lever, body->view.moved, moved[side]);
    if (of->bodies[member].count == 0)
      continue;
    fill_shape(of, member, basis, sign, width_of(at), ways);
    fill_whole(of, member, lever, sign, width_of(at), ways);
  }
  thrum_subtract3(moved[0], moved[1], at->at);
  finish_row(of, at);
}

/* Takes up the rows of a body on its obstacles. */
static void take_obstacles(newton *of, int64_t member) {
  const thrum_contact_run *body = of->run->view.runs + member;
  for (int64_t n = 0; n < body->contact->row_count; n++) {
    thrum_contact_row *row = body->view.rows + n;
    const double *basis = thrum_point_rows(body, row->touch.point);
    thrum_newton_row *at = begin_row(of, row, member, -1);
    fill_shape(of, member, basis, 1.0, width_of(at), at->ways);
    fill_whole(of, member, row->lever, 1.0, width_of(at), at->ways);

    // against the obstacle, which may move
    thrum_point_moved(body, basis, row->lever, body->view.moved, at->at);
    memcpy(at->drift, row->drift, sizeof at->drift);
    thrum_subtract3(at->at, at->drift, at->at);
    finish_row(of, at);
  }
}

/* Takes up all rows of the group and the forces that they have. */
static void take_up(newton *of) {
  const thrum_pairs_run *run = of->run;
  for (int64_t n = 0; n < run->row_count; n++) {
    if (thrum_pairs_is_own(run->view.rows + n))
      take_own(of, run->view.rows + n);
    else
      take_pair(of, run->view.rows + n);
  }
  for (int64_t n = 0; n < run->count; n++)
    if (of->bodies[n].count > 0)
      take_obstacles(of, n);
  memcpy(of->began, of->z, (size_t)of->m * sizeof *of->began);
}

/* Moves a body by what the forces have become more than they were. */
static void move(const newton *of, int64_t member) {
  thrum_contact_run *body = of->run->view.runs + member;
  const int64_t first = of->bodies[member].first;
  const double *end = of->z + first, *start = of->began + first;
  const double *roots = of->roots + first, *root = of->bodies[member].turn_root;

  // its shape, then the body as a whole
  int64_t at = body->contact->rank;
  for (int64_t i = 0; i < at; i++)
    body->view.moved[i] += roots[i] * (end[i] - start[i]);
  for (int axis = 0; axis < 3 && body->mass_weight > 0.0; axis++, at++)
    body->moved[axis] += sqrt(body->mass_weight) * (end[at] - start[at]);
  if (!turns(body))
    return;
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 3; k++)
      body->turned[axis] += root[3 * axis + k] * (end[at + k] - start[at + k]);
}

/* The forces and displacements that were solved for become those of the step; where they are not
 * finite nothing changes, and it returns false. */
static bool give_back(const newton *of) {
  memset(of->z, 0, (size_t)of->m * sizeof *of->z);
  for (int64_t k = 0; k < of->count; k++) {
    thrum_newton_row *at = of->rows + k;
    const double *n = at->row->touch.normal;
    double force[3];
    respond(at, at->at, force, NULL);
    go_on_from(at, force);
    for (int axis = 0; axis < 3; axis++)
      force[axis] = at->force * n[axis] + at->friction[axis];
    push(of, at, force, of->z);
  }
  for (int64_t q = 0; q < of->m; q++)
    if (!isfinite(of->z[q]))
      return false;

  // forces, in place of those that z began with
  for (int64_t k = 0; k < of->count; k++) {
    const thrum_newton_row *at = of->rows + k;
    at->row->touch.force = at->force;
    memcpy(at->row->touch.friction, at->friction, sizeof at->friction);
    for (int axis = 0; axis < 3; axis++)
      at->row->seen[axis] = at->at[axis] + at->drift[axis];
  }
  for (int64_t n = 0; n < of->run->count; n++)
    if (of->bodies[n].count > 0)
      move(of, n);
  return true;
}

/* Moves the rows by a share of the step. */
static void take(void *newton_of, double share) {
  const newton *of = newton_of;
  for (int64_t k = 0; k < of->count; k++)
    for (int axis = 0; axis < 3; axis++)
      of->rows[k].at[axis] += share * of->rows[k].way[axis];
}

/* All rows go on from the forces that they have. */
static void go_on(void *newton_of) {
  const newton *of = newton_of;
  for (int64_t k = 0; k < of->count; k++) {
    double force[3];
    respond(of->rows + k, of->rows[k].at, force, NULL);
    go_on_from(of->rows + k, force);
  }
}

bool thrum_pairs_newton(thrum_pairs_run *run, double tolerance) {
  static const thrum_newton_laws laws = {linearise, fill_ways_on, fall, take, go_on};
  newton of = {.run = run, .bodies = run->view.newton_bodies};
  bool settled;
  if (!find_columns(&of))
    return false;
  lay_out(&of);
  take_up(&of);

  // the columns of a body are a multiple of four, so that the rows of the matrix are m long
  const thrum_newton_system system = {of.m, of.z, of.gradient, of.step, of.factor};
  if (!thrum_newton_minimise(&system, &laws, &of, tolerance, &settled))
    return false;
  return give_back(&of) && settled;
}
