/* All rows between two bodies at once, by Newton's method in the coordinates of both, where sweeps
 * over rows do not settle: places of two faces share a load in many ways, and sweeps shift it
 * between them for hundreds of turns.
 *
 * With z the displacements in the step that the forces of these rows add, scaled by the roots of
 * their weights, B_i the rows of place i (3 x m, world axes), x_i = x_i0 + B_i z its displacement,
 * and the other forces held, each row has the law that it has in a sweep (contact_law.c), with a
 * share of its own response as a compliance c about the force f_i that it had:
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
 * then.
 * Cost: 3 m^2/2 a row whose K has changed, 6 m a row, m^3/6, an iteration; m is 52 for two free
 * bodies of rank 20.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/base/two_lanes.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_newton.h"
#include "runtime/contact/contact_pairs_private.h"
#include "runtime/contact/contact_point.h"

#define SOFTNESS 0.3      /* of a row's response: the compliance about its force */
#define ITERATIONS_MAX 16 /* of a solve */
#define ALIKE 0.3         /* of the derivatives of a row: by how much the sum may be off */

/* Two bodies and the rows between them. */
typedef struct newton {
  const thrum_pairs_run *run;
  int64_t members[2];
  int64_t columns[2];       /* of either body */
  double turn_roots[2][9];  /* of the weights of their rotations */
  int64_t m, stride, count; /* stride: of the rows of B and of matrices */
  thrum_newton_row *rows;
  double *matrix, *factor; /* m x m: sum, and its Cholesky factor, upper triangles by rows */
  double *z, *began;       /* scaled displacements, and those at the start */
  double *gradient, *step;
  double *pushed; /* 3 x m */
  double *roots;  /* m: of the weights of the shapes' coordinates */
} newton;

/* --- rows ------------------------------------------------------------------------------------- */

static bool turns(const thrum_contact_run *body) {
  return body->environment->rigid_frame != NULL && body->turn_weight[0] > 0.0;
}

/* How many coordinates of a body answer to a force. */
static int64_t columns_of(const thrum_contact_run *body) {
  return body->contact->rank + (body->mass_weight > 0.0 ? 3 : 0) + (turns(body) ? 3 : 0);
}

/* Which of the two bodies a side of a row is, and where its columns are. */
static int body_of(const newton *of, const thrum_pair_row *row, int side) {
  return row->members[side] != of->members[0];
}

static int64_t first_column(const newton *of, int body) {
  return body == 0 ? 0 : of->columns[0];
}

/* The columns of one side of a row, in three rows. */
static void fill_side(const newton *of, const thrum_pair_row *row, int side, double *ways) {
  const thrum_contact_run *body = of->run->view.runs + row->members[side];
  const double *basis = thrum_pairs_basis(row, side), sign = side == 0 ? 1.0 : -1.0;
  const double *lever = side == 0 ? row->row.lever : row->lever;
  const int64_t r = body->contact->rank, stride = of->stride;
  const int which = body_of(of, row, side);
  double *restrict out = ways + first_column(of, which);
  const double *roots = of->roots + first_column(of, which);

  // the shape, turned into the world
  for (int axis = 0; axis < 3; axis++) {
    const double *axes = body->axes + 3 * axis;
    for (int64_t i = 0; i < r; i++)
      out[axis * stride + i] =
          sign * roots[i] *
          (axes[0] * basis[i] + axes[1] * basis[r + i] + axes[2] * basis[2 * r + i]);
  }

  // the body as a whole
  int64_t at = r;
  const double whole = sign * sqrt(body->mass_weight);
  for (int axis = 0; axis < 9 && body->mass_weight > 0.0; axis++)
    out[axis / 3 * stride + at + axis % 3] = axis / 3 == axis % 3 ? whole : 0.0;
  at += body->mass_weight > 0.0 ? 3 : 0;
  if (!turns(body))
    return;
  const double *root = of->turn_roots[which];
  for (int k = 0; k < 3; k++) {
    const double turn[3] = {root[k], root[3 + k], root[6 + k]};
    double moved[3];
    thrum_cross3(turn, lever, moved);
    for (int axis = 0; axis < 3; axis++)
      out[axis * stride + at + k] = sign * moved[axis];
  }
}

/* How a row moves as the solve has it. */
static void moved_of(const newton *of, const thrum_pair_row *row, double out[3]) {
  double other[3];
  const thrum_contact_run *a = of->run->view.runs + row->members[0];
  const thrum_contact_run *b = of->run->view.runs + row->members[1];
  thrum_point_moved(a, thrum_pairs_basis(row, 0), row->row.lever, a->view.moved, out);
  thrum_point_moved(b, thrum_pairs_basis(row, 1), row->lever, b->view.moved, other);
  for (int axis = 0; axis < 3; axis++)
    out[axis] -= other[axis];
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
static void respond(const newton *of, const thrum_newton_row *at, const double x[3],
                    double force[3], double *rate) {
  thrum_contact_row *row = &of->run->view.rows[at->row].row;
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
static void go_on_from(const newton *of, thrum_newton_row *at, const double force[3]) {
  const thrum_contact_row *row = &of->run->view.rows[at->row].row;
  at->force = split(row, force, at->friction);
  at->most = row->friction * at->force;
  const double length = sqrt(thrum_dot3(at->friction, at->friction));
  for (int axis = 0; axis < 3 && length > at->most; axis++)
    at->friction[axis] *= at->most / length;
}

/* --- an iteration ----------------------------------------------------------------------------- */

/* Forces, the gradient and the matrix at z. */
static void linearise(const newton *of) {
  memcpy(of->gradient, of->z, (size_t)of->stride * sizeof *of->gradient);
  for (int64_t n = 0; n < of->count; n++) {
    thrum_newton_row *at = of->rows + n;
    double force[3], rate[9], change[9];
    respond(of, at, at->at, force, rate);
    double off = 0.0, size = 0.0;
    for (int k = 0; k < 9; k++) {
      change[k] = rate[k] - at->rate[k];
      off += change[k] * change[k];
      size += rate[k] * rate[k];
    }

    // what most rows ask for stays from one iteration to the next, or nearly so
    if (off > ALIKE * ALIKE * size) {
      memcpy(at->rate, rate, sizeof rate);
      thrum_newton_add(of->m, at->ways, change, of->pushed, of->matrix);
    }
    const double back[3] = {-force[0], -force[1], -force[2]};
    if (force[0] != 0.0 || force[1] != 0.0 || force[2] != 0.0)
      thrum_rows_push(of->stride, at->ways, back, NULL, of->gradient);
  }
}

static double dot(const double *a, const double *b, int64_t count) {
  double sum = 0.0;
  for (int64_t i = 0; i < count; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Solves for the step; false where the matrix has no factor. */
static bool solve_step(const newton *of) {
  memcpy(of->factor, of->matrix, (size_t)(of->m * of->stride) * sizeof *of->factor);
  return thrum_newton_step(of->m, of->factor, of->gradient, of->step);
}

/* How far the rows go in a whole step; returns the largest [m]. */
static double fill_ways_on(const newton *of) {
  double most = 0.0;
  for (int64_t n = 0; n < of->count; n++) {
    thrum_newton_row *at = of->rows + n;
    thrum_rows_times(of->stride, at->ways, of->step, at->way);
    most = fmax(most, thrum_dot3(at->way, at->way));
  }
  return sqrt(most);
}

/* The slope of the function at a share of the step. */
static double slope_at(const void *newton_of, double share) {
  const newton *of = newton_of;
  double slope = dot(of->z, of->step, of->m) + share * dot(of->step, of->step, of->m);
  for (int64_t n = 0; n < of->count; n++) {
    const thrum_newton_row *at = of->rows + n;
    double x[3], force[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = at->at[axis] + share * at->way[axis];
    respond(of, at, x, force, NULL);
    slope -= thrum_dot3(force, at->way);
  }
  return slope;
}

/* The share of the step that is taken. */
static double search(const newton *of) {
  return thrum_newton_search(slope_at, of, dot(of->gradient, of->step, of->m));
}

/* --- the solve -------------------------------------------------------------------------------- */

/* The coordinates that answer to the rows; false where they cannot be solved in. */
static bool find_columns(newton *of) {
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = of->run->view.runs + of->members[side];
    of->columns[side] = columns_of(body);
    for (int64_t i = 0; i < body->contact->rank; i++)
      if (!(body->view.weights[i] >= 0.0))
        return false;
    if (turns(body) && !thrum_newton_root(body->turn_weight, of->turn_roots[side]))
      return false;
  }
  of->m = of->columns[0] + of->columns[1];
  of->stride = THRUM_NEWTON_STRIDE(of->m);
  return of->m <= THRUM_NEWTON_COLUMNS;
}

/* Scratch: two matrices, of which the sum begins with 1, and vectors. */
static void lay_out(newton *of) {
  const int64_t m = of->m, stride = of->stride;
  double *room = of->run->view.newton_room;
  of->rows = of->run->view.newton_rows;
  of->matrix = room;
  of->factor = room + m * stride;
  of->z = room + 2 * m * stride;
  of->began = of->z + stride;
  of->gradient = of->began + stride;
  of->step = of->gradient + stride;
  of->pushed = of->step + stride;
  of->roots = of->pushed + 3 * stride;
  for (int which = 0; which < 2; which++) {
    const thrum_contact_run *body = of->run->view.runs + of->members[which];
    for (int64_t i = 0; i < body->contact->rank; i++)
      of->roots[first_column(of, which) + i] = sqrt(body->view.weights[i]);
  }

  // no force yet
  memset(of->matrix, 0, (size_t)(m * stride) * sizeof *of->matrix);
  for (int64_t q = 0; q < m; q++)
    of->matrix[q * stride + q] = 1.0;
  memset(of->z, 0, (size_t)stride * sizeof *of->z);
  memset(of->step, 0, (size_t)stride * sizeof *of->step);
}

/* Takes up the rows between the two bodies and the forces that they have. */
static void take_up(newton *of) {
  const thrum_pairs_run *run = of->run;
  double *ways = run->view.newton_ways;
  for (int64_t n = 0; n < run->row_count; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    if (!thrum_pairs_joins(row, of->members[0], of->members[1]))
      continue;
    thrum_newton_row *at = of->rows + of->count++;
    double force[3];
    memset(at, 0, sizeof *at);
    at->row = n;
    at->ways = ways;
    ways += 3 * of->stride;

    // how it moves, and what it is pushed by
    for (int axis = 0; axis < 3; axis++)
      memset(at->ways + axis * of->stride + of->m, 0,
             (size_t)(of->stride - of->m) * sizeof *at->ways);
    fill_side(of, row, 0, at->ways);
    fill_side(of, row, 1, at->ways);
    moved_of(of, row, at->at);
    thrum_contact_row_force(&row->row, force);
    go_on_from(of, at, force);
    thrum_rows_push(of->stride, at->ways, force, NULL, of->z);
  }
  memcpy(of->began, of->z, (size_t)of->stride * sizeof *of->began);
}

/* Moves a body by what the forces have become more than they were. */
static void move(const newton *of, int side) {
  thrum_contact_run *body = of->run->view.runs + of->members[side];
  const int64_t first = first_column(of, side);
  const double *end = of->z + first, *start = of->began + first;
  const double *roots = of->roots + first, *root = of->turn_roots[side];

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
  const thrum_pairs_run *run = of->run;
  memset(of->z, 0, (size_t)of->stride * sizeof *of->z);
  for (int64_t k = 0; k < of->count; k++) {
    thrum_newton_row *at = of->rows + k;
    const double *n = run->view.rows[at->row].row.touch.normal;
    double force[3];
    respond(of, at, at->at, force, NULL);
    go_on_from(of, at, force);
    for (int axis = 0; axis < 3; axis++)
      force[axis] = at->force * n[axis] + at->friction[axis];
    thrum_rows_push(of->stride, at->ways, force, NULL, of->z);
  }
  for (int64_t q = 0; q < of->m; q++)
    if (!isfinite(of->z[q]))
      return false;

  // forces, in place of those that z began with
  for (int64_t k = 0; k < of->count; k++) {
    const thrum_newton_row *at = of->rows + k;
    thrum_pair_row *pair = run->view.rows + at->row;
    pair->row.touch.force = at->force;
    memcpy(pair->row.touch.friction, at->friction, sizeof at->friction);
    memcpy(pair->row.seen, at->at, sizeof at->at);
  }
  for (int side = 0; side < 2; side++)
    move(of, side);
  return true;
}

/* Takes a share of the step. */
static void take(const newton *of, double share) {
  for (int64_t q = 0; q < of->m; q++)
    of->z[q] += share * of->step[q];
  for (int64_t k = 0; k < of->count; k++)
    for (int axis = 0; axis < 3; axis++)
      of->rows[k].at[axis] += share * of->rows[k].way[axis];
}

bool thrum_pairs_newton(thrum_pairs_run *run, const int32_t members[2], double tolerance) {
  newton of = {.run = run, .members = {members[0], members[1]}};
  bool fresh = true, settled = false;
  if (!find_columns(&of))
    return false;
  lay_out(&of);
  take_up(&of);

  // steps of Newton's method, each as far as the function falls
  for (int n = 0; n < ITERATIONS_MAX && !settled; n++) {
    linearise(&of);
    if (!solve_step(&of))
      return false;
    const double most = fill_ways_on(&of), share = search(&of);
    take(&of, share);

    // it settles where rows that have just gone on from their forces move no more
    settled = fresh && share == 1.0 && most <= tolerance;
    fresh = share == 1.0;
    for (int64_t k = 0; k < of.count && fresh && !settled; k++) {
      double force[3];
      respond(&of, of.rows + k, of.rows[k].at, force, NULL);
      go_on_from(&of, of.rows + k, force);
    }
  }
  return give_back(&of) && settled;
}
