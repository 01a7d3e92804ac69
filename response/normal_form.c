/* Normal forms of one mode, or of two that are near 1:1, 1:2 or 1:3; see thrum/response.h and
 * docs/mathematics/21 (21.9)-(21.13).
 *
 * All coordinates are sums of psi_p z^p over monomials z^p of z_1, zbar_1, z_2 and zbar_2, with
 * zdot_j = i (omega_j z_j + sum of f_jp z^p) over the monomials that turn as z_j does. Without
 * damping all psi are real, those of conjugate monomials are equal, and the velocity is i sum of
 * y_p z^p. With sigma = sum omega_j (a_j - b_j) a monomial obeys
 *
 *   (omega_i^2 - sigma^2) psi = -G + sigma S + T,   y = sigma psi + S,
 *
 * where S and T are what psi and y of lower orders become by f, and G is what the quadratic and
 * cubic forces have in the monomial of lower orders. With the tangent T(q) = omega^2 + A(q) + B(q,
 * q)
 *
 *   G_p = sum over z^s z^w = z^p of M_s psi_w,   M_s = A(psi_s) / 2 + sum over z^u z^v = z^s of
 *   B(psi_u, psi_v) / 3,
 *
 * and that of -q tells A from B. Where z^p turns as z_j the orthogonality to the left eigenvector,
 * y
 * + omega_j psi = 0, closes the row of mode j: f = (G - omega_j S - T) / (2 omega_j). Cost: 4
 * tangents for each pair of monomials, some 400 for one mode and 6,000 for two to order 7. Source:
 * Vizzaccaro, Opreni, Salles, Frangi and Touze 2022, High order direct parametrisation of invariant
 * manifolds, doi:10.1007/s11071-022-07651-9.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "response/room.h"
#include "thrum/condensed_model.h"
#include "thrum/polynomial.h"
#include "thrum/response.h"

#define NEAR 1e-3 /* of squared frequencies: a mode so near to a multiple is a resonance */

/* Monomials of four variables to order 7; those to order 6 but for conjugates; powers of each. */
enum { MONOMIALS = 329, MATRICES = 109, VARIABLES = 4, POWERS = 8 };

typedef struct monomial {
  int power[VARIABLES]; /* of z_1, zbar_1, z_2, zbar_2 */
  int order;
} monomial;

typedef struct form {
  const thrum_model *model;
  int64_t rank;
  int count, modes, order; /* monomials, modes, highest order */
  int64_t mode[2];
  int ratio[2]; /* turns of each mode in one of the first */
  double omega[2];
  double scale;
  monomial of[MONOMIALS];
  int place[POWERS][POWERS][POWERS][POWERS]; /* where a monomial is */
  bool known[MONOMIALS];
  double f[2][MONOMIALS]; /* 0: the monomial does not turn as the mode */
  int matrix[MONOMIALS];  /* which matrix M is a monomial's, as its conjugate has the same */
  int matrices;           /* so many are made */
  double *psi, *y;        /* MONOMIALS x rank */
  double *m;              /* MATRICES x rank x rank */
  double *plus, *minus;   /* tangents, rank x rank */
  double *force, *at;     /* G, and where a tangent is taken; rank each */
  double *before, *rates; /* S and T, rank each */
  double *work;
} form;

/* --- monomials -------------------------------------------------------------------------------- */

static monomial make(const int power[VARIABLES]) {
  monomial made = {{power[0], power[1], power[2], power[3]}, 0};
  for (int v = 0; v < VARIABLES; v++)
    made.order += power[v];
  return made;
}

static monomial conjugate(const monomial *of) {
  return make((const int[VARIABLES]){of->power[1], of->power[0], of->power[3], of->power[2]});
}

static int place_of(const form *s, const monomial *of) {
  return s->place[of->power[0]][of->power[1]][of->power[2]][of->power[3]];
}

/* left = whole - part; false where it is none. */
static bool divide(const monomial *whole, const monomial *part, monomial *left) {
  int power[VARIABLES];
  for (int v = 0; v < VARIABLES; v++) {
    power[v] = whole->power[v] - part->power[v];
    if (power[v] < 0)
      return false;
  }
  *left = make(power);
  return true;
}

/* All monomials, by rising order. */
static void list_monomials(form *s) {
  const int most = s->modes > 1 ? s->order : 0;
  for (int order = 1; order <= s->order; order++)
    for (int a = order; a >= 0; a--)
      for (int b = order - a; b >= 0; b--)
        for (int c = order - a - b; c >= 0; c--) {
          const int power[VARIABLES] = {a, b, c, order - a - b - c};
          if (power[2] > most || power[3] > most)
            continue;
          s->place[a][b][c][power[3]] = s->count;
          s->of[s->count++] = make(power);
        }
}

/* How often a monomial turns in one turn of the first mode, if the ratio were exact. */
static int turns(const form *s, const monomial *of) {
  return s->ratio[0] * (of->power[0] - of->power[1]) + s->ratio[1] * (of->power[2] - of->power[3]);
}

/* --- forces ----------------------------------------------------------------------------------- */

static double *psi_of(const form *s, int at) {
  return s->psi + at * s->rank;
}
static double *y_of(const form *s, int at) {
  return s->y + at * s->rank;
}

/* s->plus = T(at) and s->minus = T(-at). */
static void take_tangents(form *s) {
  thrum_tangent_stiffness(s->model, s->at, s->plus, s->work);
  for (int64_t i = 0; i < s->rank; i++)
    s->at[i] = -s->at[i];
  thrum_tangent_stiffness(s->model, s->at, s->minus, s->work);
}

/* m += A(psi) / 2. */
static void add_linear(form *s, const double *psi, double *m) {
  memcpy(s->at, psi, (size_t)s->rank * sizeof *psi);
  take_tangents(s);
  for (int64_t e = 0; e < s->rank * s->rank; e++)
    m[e] += 0.25 * (s->plus[e] - s->minus[e]);
}

static double norm_of(const form *s, const double *psi) {
  double square = 0;
  for (int64_t i = 0; i < s->rank; i++)
    square += psi[i] * psi[i];
  return sqrt(square);
}

/* m += weight B(u, v) / 3, found of both as long as `scale`, where none is lost beside the other.
 */
static void add_square(form *s, double weight, const double *u, const double *v, double *m) {
  const double length = norm_of(s, u) / s->scale, other = norm_of(s, v) / s->scale;
  if (!(length > 0 && other > 0))
    return;
  for (int sign = 1; sign >= -1; sign -= 2) {
    const double share = sign * weight * length * other / 24;
    for (int64_t i = 0; i < s->rank; i++)
      s->at[i] = u[i] / length + sign * v[i] / other;
    take_tangents(s);
    for (int64_t e = 0; e < s->rank * s->rank; e++)
      m[e] += share * (s->plus[e] + s->minus[e]);
  }
}

/* The matrix M of a monomial that is known, with all below it. */
static void make_matrix(form *s, int at) {
  const monomial other = conjugate(&s->of[at]);
  const int twin = place_of(s, &other);
  if (twin < at) {
    s->matrix[at] = s->matrix[twin];
    return;
  }
  s->matrix[at] = s->matrices++;
  double *m = s->m + s->matrix[at] * s->rank * s->rank;
  memset(m, 0, (size_t)(s->rank * s->rank) * sizeof *m);
  add_linear(s, psi_of(s, at), m);
  for (int i = 0; i < at; i++) {
    monomial rest;
    if (!divide(&s->of[at], &s->of[i], &rest))
      continue;
    const int j = place_of(s, &rest);
    if (i <= j)
      add_square(s, i == j ? 1 : 2, psi_of(s, i), psi_of(s, j), m);
  }
}

/* s->force = G, what forces of lower orders have in a monomial. */
static void gather(form *s, const monomial *of) {
  const int64_t r = s->rank;
  memset(s->force, 0, (size_t)r * sizeof *s->force);
  for (int n = 0; n < s->count && s->of[n].order < of->order; n++) {
    monomial rest;
    if (!divide(of, &s->of[n], &rest))
      continue;
    const double *m = s->m + s->matrix[n] * r * r, *psi = psi_of(s, place_of(s, &rest));
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++)
        s->force[i] += m[i * r + j] * psi[j];
  }
}

/* s->before and s->rates = S and T of a monomial: what lower ones become by the coefficients so
 * far. A factor z_j of one becomes f z^p, and zbar_j its conjugate with the other sign. */
static void carry(form *s, const monomial *of) {
  memset(s->before, 0, (size_t)s->rank * sizeof *s->before);
  memset(s->rates, 0, (size_t)s->rank * sizeof *s->rates);
  for (int j = 0; j < s->modes; j++)
    for (int p = 0; p < s->count && s->of[p].order < of->order; p++)
      for (int conjugated = 0; conjugated < 2 && s->f[j][p] != 0; conjugated++) {
        const monomial by = conjugated ? conjugate(&s->of[p]) : s->of[p];
        monomial from;
        if (!divide(of, &by, &from))
          continue;
        const int factor = 2 * j + conjugated;
        from.power[factor]++;
        const int at = place_of(s, &from);
        const double weight = (conjugated ? -1 : 1) * from.power[factor] * s->f[j][p];
        for (int64_t i = 0; i < s->rank; i++) {
          s->before[i] += weight * psi_of(s, at)[i];
          s->rates[i] += weight * y_of(s, at)[i];
        }
      }
}

/* --- solving ---------------------------------------------------------------------------------- */

/* One monomial, and its conjugate. False where another mode is in resonance with it. */
static bool solve(form *s, int at, int64_t *with) {
  const monomial *of = &s->of[at], other = conjugate(of);
  const double *omega2 = s->model->omega2;
  double *psi = psi_of(s, at), *y = y_of(s, at), sigma = 0;
  for (int j = 0; j < s->modes; j++)
    sigma += s->omega[j] * (of->power[2 * j] - of->power[2 * j + 1]);
  gather(s, of);
  carry(s, of);
  for (int64_t i = 0; i < s->rank; i++) {
    const int j = i == s->mode[0] ? 0 : s->modes > 1 && i == s->mode[1] ? 1 : -1;
    if (j >= 0 && turns(s, of) == s->ratio[j]) {
      // the coefficient, and what the left eigenvector leaves of psi
      const double f = (s->force[i] - s->omega[j] * s->before[i] - s->rates[i]) / (2 * s->omega[j]);
      s->f[j][at] = f / s->scale;
      psi[i] = -(s->before[i] + f) / (sigma + s->omega[j]);
      y[i] = sigma * psi[i] + s->before[i] + f;
      continue;
    }
    const double left = omega2[i] - sigma * sigma;
    *with = i;
    if (fabs(left) < NEAR * s->omega[0] * s->omega[0])
      return false;
    psi[i] = (-s->force[i] + sigma * s->before[i] + s->rates[i]) / left;
    y[i] = sigma * psi[i] + s->before[i];
  }

  // the velocity of the conjugate has the other sign
  const int twin = place_of(s, &other);
  for (int64_t i = 0; i < s->rank && twin != at; i++) {
    psi_of(s, twin)[i] = psi[i];
    y_of(s, twin)[i] = -y[i];
  }
  s->known[at] = s->known[twin] = true;
  return true;
}

/* All monomials by rising order; those that turn forward first, as their conjugates follow, and
 * then the matrices of the order. False as of one, with the monomial in *at. */
static bool solve_all(form *s, int *at, int64_t *with) {
  for (int n = 0; n < s->count; n++)
    if (s->of[n].order == 1)
      s->known[n] = true;
  for (int order = 1; order <= s->order; order++) {
    for (int forward = 1; forward >= 0; forward--)
      for (int n = 0; n < s->count; n++) {
        *at = n;
        if (s->of[n].order != order || s->known[n] || (forward > 0 && turns(s, &s->of[n]) <= 0))
          continue;
        if (!solve(s, n, with))
          return false;
      }
    for (int n = 0; n < s->count && order < s->order; n++)
      if (s->of[n].order == order)
        make_matrix(s, n);
  }
  return true;
}

/* --- memory and checks ------------------------------------------------------------------------ */

static void lay(form *s, const thrum_model *model, thrum_room *room) {
  const int64_t r = model->rank;
  s->model = model;
  s->rank = r;
  s->work = thrum_room_take(room, (int64_t)thrum_work_count(model));
  s->psi = thrum_room_take(room, MONOMIALS * r);
  s->y = thrum_room_take(room, MONOMIALS * r);
  s->m = thrum_room_take(room, MATRICES * r * r);
  s->plus = thrum_room_take(room, r * r);
  s->minus = thrum_room_take(room, r * r);
  double **const arrays[] = {&s->force, &s->at, &s->before, &s->rates};
  for (size_t n = 0; n < sizeof arrays / sizeof arrays[0]; n++)
    *arrays[n] = thrum_room_take(room, r);
}

static size_t head_bytes(void) {
  return (sizeof(form) + 63) / 64 * 64;
}

static thrum_status check(const thrum_model *model, int64_t mode, thrum_error *error) {
  if (model == NULL || model->omega2 == NULL || model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL or has no valid rank");
  if (model->c3 == NULL || model->c4 == NULL || thrum_condensed_shape_model(model) != model)
    return thrum_error_set(error, THRUM_MISSING,
                           "a normal form is of a polynomial of all coordinates: the model has "
                           "cubature points, or is condensed");
  if (mode < 0 || mode >= model->rank || !(model->omega2[mode] > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "mode is %lld; the model has 0 to %lld, and it needs a stiffness",
                           (long long)mode, (long long)model->rank - 1);
  return THRUM_OK;
}

thrum_status thrum_normal_form_size(const thrum_model *model, int64_t mode, size_t *size,
                                    thrum_error *error) {
  form counted = {0};
  thrum_room room = {NULL, 0};
  THRUM_TRY(check(model, mode, error));
  if (model->levels != NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a body under the levels of actuators has no normal form here");
  if (size == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  lay(&counted, model, &room);
  *size = head_bytes() + (size_t)room.used * sizeof(double);
  return THRUM_OK;
}

/* Lays a form of these modes into the workspace and solves it. */
static thrum_status find(form **found, const thrum_model *model, int modes, const int64_t mode[2],
                         int ratio, int order, double scale, void *workspace, size_t workspace_size,
                         thrum_error *error) {
  size_t size = 0;
  for (int j = 0; j < modes; j++)
    THRUM_TRY(thrum_normal_form_size(model, mode[j], &size, error));
  if (workspace == NULL || !(scale > 0 && scale < THRUM_RESPONSE_MOST))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "found or workspace is NULL, or scale is not above 0");
  if ((uintptr_t)workspace % 64 != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the workspace is not aligned to 64");
  if (workspace_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the workspace has %zu bytes, and %zu are needed", workspace_size, size);
  form *s = workspace;
  *s = (form){.modes = modes, .order = order, .ratio = {1, ratio}, .scale = scale};
  thrum_room room = {(double *)(void *)((char *)workspace + head_bytes()), 0};
  lay(s, model, &room);
  list_monomials(s);
  memset(s->psi, 0, (size_t)(MONOMIALS * s->rank) * sizeof *s->psi);
  memset(s->y, 0, (size_t)(MONOMIALS * s->rank) * sizeof *s->y);

  // z in units in which all orders are of one size
  for (int j = 0; j < modes; j++) {
    int power[VARIABLES] = {0};
    s->mode[j] = mode[j];
    s->omega[j] = sqrt(model->omega2[mode[j]]);
    for (int conjugated = 0; conjugated < 2; conjugated++) {
      power[2 * j + conjugated] = 1;
      const monomial first = make(power);
      const int at = place_of(s, &first);
      psi_of(s, at)[mode[j]] = scale;
      y_of(s, at)[mode[j]] = (conjugated ? -1 : 1) * s->omega[j] * scale;
      power[2 * j + conjugated] = 0;
    }
  }
  int at = 0;
  int64_t with = 0;
  if (!solve_all(s, &at, &with))
    return thrum_error_set(error, THRUM_SINGULAR,
                           "mode %lld has %d times the frequency of mode %lld: its motion cannot "
                           "follow that of %s",
                           (long long)with + 1, abs(turns(s, &s->of[at])), (long long)mode[0] + 1,
                           modes > 1 ? "the two" : "one mode");
  *found = s;
  return THRUM_OK;
}

/* The scale to the order less one. */
static double power_of(double scale, int order) {
  double power = 1; // pow of newer C libraries would ask wheels for them
  for (int k = 1; k < order; k++)
    power *= scale;
  return power;
}

static thrum_status far_off(double scale, thrum_error *error) {
  return thrum_error_set(error, THRUM_NOT_FINITE,
                         "scale %g is far from the amplitude at which the nonlinear forces are as "
                         "large as the linear one",
                         scale);
}

thrum_status thrum_normal_form_find(const thrum_model *model, int64_t mode, double scale,
                                    void *workspace, size_t workspace_size,
                                    thrum_normal_form *found, thrum_error *error) {
  form *s = NULL;
  const int64_t modes[2] = {mode, -1};
  if (found == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "found is NULL");
  THRUM_TRY(find(&s, model, 1, modes, 0, THRUM_NORMAL_FORM_ORDER, scale, workspace, workspace_size,
                 error));
  thrum_normal_form answer = {.omega = s->omega[0]};
  for (int k = 1; k <= THRUM_NORMAL_FORM_ORDER / 2; k++) {
    answer.coefficients[k - 1] = s->f[0][s->place[k + 1][k][0][0]] / power_of(scale, 2 * k + 1);
    if (!isfinite(answer.coefficients[k - 1]))
      return far_off(scale, error);
  }
  *found = answer;
  return THRUM_OK;
}

thrum_status thrum_normal_form_pair_find(const thrum_model *model, const int64_t modes[2],
                                         int32_t ratio, int32_t order, double scale,
                                         void *workspace, size_t workspace_size,
                                         thrum_normal_form_pair *found, thrum_error *error) {
  form *s = NULL;
  if (found == NULL || modes == NULL || modes[0] == modes[1] || ratio < 1 || ratio > 3 ||
      order < 2 || order > THRUM_NORMAL_FORM_ORDER)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "found is NULL, both modes are one, ratio is not 1 to 3 or order not 2 "
                           "to %d",
                           THRUM_NORMAL_FORM_ORDER);
  THRUM_TRY(find(&s, model, 2, modes, ratio, order, scale, workspace, workspace_size, error));
  thrum_normal_form_pair answer = {.omega = {s->omega[0], s->omega[1]}};
  for (int j = 0; j < 2; j++)
    for (int n = 0; n < s->count; n++) {
      const monomial *of = &s->of[n];
      if (of->order < 2 || turns(s, of) != s->ratio[j])
        continue;
      thrum_normal_form_term *term = &answer.terms[answer.count++];
      *term =
          (thrum_normal_form_term){.of = j, .coefficient = s->f[j][n] / power_of(scale, of->order)};
      for (int v = 0; v < VARIABLES; v++)
        term->powers[v] = of->power[v];
      if (!isfinite(term->coefficient))
        return far_off(scale, error);
    }
  *found = answer;
  return THRUM_OK;
}
