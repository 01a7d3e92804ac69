/* Normal forms of one mode, or of two that are near 1:1, 1:2 or 1:3; see thrum/response.h and
 * docs/mathematics/21 (21.9)-(21.12).
 *
 * All coordinates are sums of psi_p z^p over monomials z^p of z_1, zbar_1, z_2 and zbar_2, with
 * zdot_j = i (omega_j z_j + sum of f_jp z^p) over the monomials that turn as z_j does. Without
 * damping all psi are real, those of conjugate monomials are equal, and the velocity is i sum of
 * y_p z^p. With sigma = sum omega_j (a_j - b_j) a monomial obeys
 *
 *   (omega_i^2 - sigma^2) psi = -G + sigma S + T,   y = sigma psi + S,
 *
 * where S and T are what psi and y of lower orders become by f, and G is what the quadratic and
 * cubic forces have in the monomial of lower orders. They are taken apart by evaluations of R: that
 * of -q tells quadratic from cubic, and sums and differences tell the forces of pairs and triples.
 * Where z^p turns as z_j the orthogonality to the left eigenvector, y + omega_j psi = 0, closes the
 * row of mode j: f = (G - omega_j S - T) / (2 omega_j). Cost: some 800 forces for one mode, 200 for
 * two to order 3. Source: Vizzaccaro, Opreni, Salles, Frangi and Touze 2022, High order direct
 * parametrisation of invariant manifolds, doi:10.1007/s11071-022-07651-9.
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

/* Monomials of two variables to order 7, or of four to order 5, and the powers of each. */
enum { MONOMIALS = 125, VARIABLES = 4, POWERS = 8 };

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
  double f[2][MONOMIALS];                    /* 0: the monomial does not turn as the mode */
  double *psi, *y;                           /* MONOMIALS x rank */
  double *force, *sum, *plus, *minus, *part; /* rank each */
  double *before, *rates;                    /* S and T, rank each */
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

/* Quadratic (odd: cubic) part of the force at s->sum, times scale, added to s->force. */
static void add_part(form *s, bool odd, double scale) {
  const int64_t r = s->rank;
  thrum_internal_force(s->model, s->sum, s->plus, s->work);
  for (int64_t i = 0; i < r; i++)
    s->part[i] = -s->sum[i];
  thrum_internal_force(s->model, s->part, s->minus, s->work);
  for (int64_t i = 0; i < r; i++) {
    const double even = 0.5 * (s->plus[i] + s->minus[i]), uneven = 0.5 * (s->plus[i] - s->minus[i]);
    s->force[i] += scale * (odd ? uneven - s->model->omega2[i] * s->sum[i] : even);
  }
}

/* `weight` times the bilinear force of u and v, of which the quadratic one is that of u and u. */
static void add_pair(form *s, double weight, const double *u, const double *v) {
  for (int sign = 1; sign >= -1; sign -= 2) {
    for (int64_t i = 0; i < s->rank; i++)
      s->sum[i] = u[i] + sign * v[i];
    add_part(s, false, 0.25 * weight * sign);
  }
}

/* The same of the trilinear force of u, v and w. */
static void add_triple(form *s, double weight, const double *u, const double *v, const double *w) {
  for (int n = 0; n < 4; n++) {
    const int second = n & 1 ? -1 : 1, third = n & 2 ? -1 : 1;
    for (int64_t i = 0; i < s->rank; i++)
      s->sum[i] = u[i] + second * v[i] + third * w[i];
    add_part(s, true, weight * second * third / 24.0);
  }
}

/* s->force = what forces of lower orders have in a monomial: each pair and triple of factors once,
 * with the number of its orders. */
static void gather(form *s, const monomial *of) {
  memset(s->force, 0, (size_t)s->rank * sizeof *s->force);
  for (int i = 0; i < s->count && s->of[i].order < of->order; i++) {
    monomial rest, last;
    if (!divide(of, &s->of[i], &rest))
      continue;
    const int j = place_of(s, &rest);
    if (i <= j)
      add_pair(s, i == j ? 1 : 2, psi_of(s, i), psi_of(s, j));
    for (int k = i; k < s->count && s->of[k].order < rest.order; k++) {
      if (!divide(&rest, &s->of[k], &last))
        continue;
      const int l = place_of(s, &last);
      if (k <= l)
        add_triple(s,
                   i == k && k == l   ? 1
                   : i == k || k == l ? 3
                                      : 6,
                   psi_of(s, i), psi_of(s, k), psi_of(s, l));
    }
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

/* All monomials by rising order; those that turn forward first, as their conjugates follow. False
 * as of one, with the monomial in *at. */
static bool solve_all(form *s, int *at, int64_t *with) {
  for (int n = 0; n < s->count; n++)
    if (s->of[n].order == 1)
      s->known[n] = true;
  for (int order = 2; order <= s->order; order++)
    for (int forward = 1; forward >= 0; forward--)
      for (int n = 0; n < s->count; n++) {
        *at = n;
        if (s->of[n].order != order || s->known[n] || (forward > 0 && turns(s, &s->of[n]) <= 0))
          continue;
        if (!solve(s, n, with))
          return false;
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
  double **const arrays[] = {&s->force, &s->sum,    &s->plus, &s->minus,
                             &s->part,  &s->before, &s->rates};
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
      order < 2 || order > THRUM_NORMAL_FORM_PAIR_ORDER)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "found is NULL, both modes are one, ratio is not 1 to 3 or order not 2 "
                           "to %d",
                           THRUM_NORMAL_FORM_PAIR_ORDER);
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
