/* The normal form of one mode; see thrum/response.h and docs/mathematics/21 (21.9)-(21.11).
 *
 * The motions of the mode are q = sum of psi_ab z^a zbar^b with zdot = i (omega + f_1 |z|^2 + f_2
 * |z|^4 + f_3 |z|^6) z. Without damping all psi are real, psi_ab = psi_ba, and the velocity is i
 * sum of y_ab z^a zbar^b. With m = a - b a monomial obeys
 *
 *   (omega_i^2 - m^2 omega^2) psi = -G + m^2 omega s + m t,   y = m (omega psi + s),
 *   s = sum f_k psi_{a-k,b-k},   t = sum f_k y_{a-k,b-k},
 *
 * where G is what the quadratic and cubic forces have in it of lower orders. They are taken apart
 * by evaluations of R: that of -q tells quadratic from cubic, and sums and differences tell the
 * forces of pairs and triples. For m = 1 the equation of the mode itself has no psi and gives f;
 * psi then follows from the orthogonality to the left eigenvector, y + omega psi = 0. Cost: some
 * 2,000 forces. Source: Vizzaccaro, Opreni, Salles, Frangi and Touze 2022, High order direct
 * parametrisation of invariant manifolds, doi:10.1007/s11071-022-07651-9.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "response/room.h"
#include "thrum/condensed_model.h"
#include "thrum/polynomial.h"
#include "thrum/response.h"

#define ORDER THRUM_NORMAL_FORM_ORDER
#define NEAR 1e-3 /* of squared frequencies: a mode so near to a multiple is a resonance */

enum { MONOMIALS = 20 }; /* a >= b, a + b from 1 to 7 */

typedef struct form {
  const thrum_model *model;
  int64_t rank, mode;
  double omega, f[ORDER / 2 + 1];
  double *psi, *y;                           /* MONOMIALS x rank */
  double *force, *sum, *plus, *minus, *part; /* rank each */
  double *work;
} form;

/* Where the monomial a, b lies; those of an order follow each other by falling a. */
static int place_of(int a, int b) {
  const int high = a > b ? a : b, low = a + b - high, order = a + b;
  int before = 0;
  for (int n = 1; n < order; n++)
    before += n / 2 + 1;
  return before + low;
}

static double *psi_of(const form *s, int a, int b) {
  return s->psi + place_of(a, b) * s->rank;
}
static double *y_of(const form *s, int a, int b) {
  return s->y + place_of(a, b) * s->rank;
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

/* The bilinear force of u and v, of which the quadratic one is that of u and u. */
static void add_pair(form *s, const double *u, const double *v) {
  for (int sign = 1; sign >= -1; sign -= 2) {
    for (int64_t i = 0; i < s->rank; i++)
      s->sum[i] = u[i] + sign * v[i];
    add_part(s, false, 0.25 * sign);
  }
}

/* The trilinear force of u, v and w. */
static void add_triple(form *s, const double *u, const double *v, const double *w) {
  for (int n = 0; n < 4; n++) {
    const int second = n & 1 ? -1 : 1, third = n & 2 ? -1 : 1;
    for (int64_t i = 0; i < s->rank; i++)
      s->sum[i] = u[i] + second * v[i] + third * w[i];
    add_part(s, true, second * third / 24.0);
  }
}

/* s->force = what forces of lower orders have in z^a zbar^b. */
static void gather(form *s, int a, int b) {
  memset(s->force, 0, (size_t)s->rank * sizeof *s->force);
  for (int a1 = 0; a1 <= a; a1++)
    for (int b1 = 0; b1 <= b; b1++) {
      const int order1 = a1 + b1, rest = a + b - order1;
      if (order1 == 0 || rest == 0)
        continue;
      add_pair(s, psi_of(s, a1, b1), psi_of(s, a - a1, b - b1));
      for (int a2 = 0; a2 <= a - a1; a2++)
        for (int b2 = 0; b2 <= b - b1; b2++)
          if (a2 + b2 > 0 && a2 + b2 < rest)
            add_triple(s, psi_of(s, a1, b1), psi_of(s, a2, b2),
                       psi_of(s, a - a1 - a2, b - b1 - b2));
    }
}

/* One monomial, a >= b. False where another mode is in resonance with it. */
static bool solve(form *s, int a, int b, int64_t *with) {
  const int64_t r = s->rank, mode = s->mode;
  const double *omega2 = s->model->omega2, m = a - b, omega = s->omega;
  double *psi = psi_of(s, a, b), *y = y_of(s, a, b);
  gather(s, a, b);
  const bool own = a == b + 1;

  // the unknown coefficient comes from the mode's own equation
  for (int pass = own ? 0 : 1; pass < 2; pass++)
    for (int64_t i = 0; i < r; i++) {
      double before = 0, rates = 0;
      for (int k = 1; k <= b; k++) {
        before += s->f[k] * psi_of(s, a - k, b - k)[i];
        rates += s->f[k] * y_of(s, a - k, b - k)[i];
      }
      const double right = -s->force[i] + m * m * omega * before + m * rates;
      const double left = omega2[i] - m * m * omega * omega;
      if (pass == 0 && i == mode) {
        // f_b stands in both sums, with psi_10 and y_10 = omega psi_10
        s->f[b] -= right / (2 * omega * psi_of(s, 1, 0)[i]);
      } else if (pass == 1 && own && i == mode) {
        psi[i] = -before / (2 * omega);
        y[i] = m * (omega * psi[i] + before);
      } else if (pass == 1) {
        if (fabs(left) < NEAR * omega * omega) {
          *with = i;
          return false;
        }
        psi[i] = right / left;
        y[i] = m * (omega * psi[i] + before);
      }
    }
  return true;
}

static void lay(form *s, const thrum_model *model, int64_t mode, thrum_room *room) {
  const int64_t r = model->rank;
  *s = (form){.model = model, .rank = r, .mode = mode, .omega = sqrt(model->omega2[mode])};
  s->work = thrum_room_take(room, (int64_t)thrum_work_count(model));
  s->psi = thrum_room_take(room, MONOMIALS * r);
  s->y = thrum_room_take(room, MONOMIALS * r);
  double **const arrays[] = {&s->force, &s->sum, &s->plus, &s->minus, &s->part};
  for (size_t n = 0; n < sizeof arrays / sizeof arrays[0]; n++)
    *arrays[n] = thrum_room_take(room, r);
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
  form counted;
  thrum_room room = {NULL, 0};
  THRUM_TRY(check(model, mode, error));
  if (size == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  lay(&counted, model, mode, &room);
  *size = (size_t)room.used * sizeof(double);
  return THRUM_OK;
}

thrum_status thrum_normal_form_find(const thrum_model *model, int64_t mode, double scale,
                                    void *workspace, size_t workspace_size,
                                    thrum_normal_form *found, thrum_error *error) {
  size_t size = 0;
  form s;
  THRUM_TRY(thrum_normal_form_size(model, mode, &size, error));
  if (found == NULL || workspace == NULL || !(scale > 0 && scale < THRUM_RESPONSE_MOST))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "found or workspace is NULL, or scale is not above 0");
  if ((uintptr_t)workspace % 64 != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the workspace is not aligned to 64");
  if (workspace_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the workspace has %zu bytes, and %zu are needed", workspace_size, size);
  thrum_room room = {workspace, 0};
  lay(&s, model, mode, &room);
  memset(s.psi, 0, (size_t)(MONOMIALS * s.rank) * sizeof *s.psi);
  memset(s.y, 0, (size_t)(MONOMIALS * s.rank) * sizeof *s.y);

  // z in units in which all orders are of one size
  psi_of(&s, 1, 0)[mode] = scale;
  y_of(&s, 1, 0)[mode] = s.omega * scale;
  for (int order = 2; order <= ORDER; order++)
    for (int b = 0; b <= order / 2; b++) {
      int64_t with = 0;
      if (!solve(&s, order - b, b, &with))
        return thrum_error_set(error, THRUM_SINGULAR,
                               "mode %lld has %d times the frequency of mode %lld: its motion "
                               "cannot follow that of one mode",
                               (long long)with + 1, order - 2 * b, (long long)mode + 1);
    }
  thrum_normal_form answer = {.omega = s.omega};
  double power = 1; // of the scale: pow of newer C libraries would ask wheels for them
  for (int k = 1; k <= ORDER / 2; k++) {
    power *= scale * scale;
    answer.coefficients[k - 1] = s.f[k] / power;
    if (!isfinite(answer.coefficients[k - 1]))
      return thrum_error_set(error, THRUM_NOT_FINITE,
                             "scale %g is far from the amplitude at which the nonlinear forces are "
                             "as large as the linear one",
                             scale);
  }
  *found = answer;
  return THRUM_OK;
}
