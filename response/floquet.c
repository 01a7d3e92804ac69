/* Floquet multipliers: the perturbations of a periodic motion over a period, docs/mathematics/21
 * (7) and (14).
 *
 * In tau = Omega t a perturbation y obeys y'' + (D / Omega) y' + (T(q) / Omega^2) y = 0. A step of
 * Gauss's method of two stages with h = 2 pi / steps solves
 *
 *   (1 + h A (x) D / Omega + h^2 A^2 (x) T_i / Omega^2) w = -T_i / Omega^2 (y + c_i h y') - D /
 * Omega y'
 *
 * for the accelerations w of both stages, of all 2 r perturbations at once. It is of order 4 and
 * symplectic: without damping what is stable stays on the unit circle at any step. The monodromy
 * matrix is what they are after a period, and its eigenvalues are the multipliers.
 *
 * Where no slave has inertia and h^2 T / Omega^2 is small, Numerov's method of order 4 takes one
 * matrix a step. In exp(D tau / 2 Omega) y there is no damping; with N = 1 + h^2 (T / Omega^2 - D^2
 * / 4 Omega^2) / 12, w = N y and E = exp(D h / 2 Omega)
 *
 *   E w_n+1 = 12 N^-1 w_n - 10 w_n - E^-1 w_n-1,
 *
 * and what two w that follow each other become in a period has the multipliers too. Cost: steps (43
 * r^3 / 3 + 4 H r^2), or steps (7 r^3 / 3 + 2 H r^2), and 80 r^3. Sources: Hairer, Lubich and
 * Wanner 2006, doi:10.1007/3-540-30666-8, section II.1; Hairer, Norsett and Wanner 1993, section
 * III.10.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/floquet.h"

#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "response/eigenvalues.h"
#include "response/square_system.h"
#include "response/wide.h"
#include "runtime/material/elementary.h"
#include "thrum/polynomial.h"

#define OUTSIDE                                                                                    \
  1e-6 /* a multiplier further out than so much is unstable: rounding moves pairs of them */

#define TABLED_MOST 512 /* steps of which all matrices are kept at once */
#define DOUBLINGS 6     /* of the steps, at finding whether what is unstable stays so */
#define AGREE 0.1       /* of its growth: so near are two that agree */
#define SHORT 1.5 /* of h^2 T / Omega^2, at the most: from 6 on Numerov's steps are unstable */

/* Places c and weights a of the method, and what follows of them. */
static const double root = 0.28867513459481288225; /* sqrt(3) / 6 */
#define C1 (0.5 - root)
#define C2 (0.5 + root)
static double stage_weight(int i, int j) {
  return i == j ? 0.25 : i == 0 ? 0.25 - root : 0.25 + root;
}
static double stage_square(int i, int j) {
  return stage_weight(i, 0) * stage_weight(0, j) + stage_weight(i, 1) * stage_weight(1, j);
}

void thrum_floquet_lay(thrum_floquet *f, thrum_room *room) {
  const int64_t r = f->balance->rank, h = f->balance->harmonics;
  f->cosines = thrum_room_take(room, 2 * h + 1);
  f->sines = thrum_room_take(room, 2 * h + 1);
  f->residual = thrum_room_take(room, f->balance->unknowns);
  f->motion = thrum_room_take(room, 4 * r * r);
  f->width = thrum_square_width(2 * r, 2 * r);
  f->system = thrum_room_take(room, 2 * r * f->width);
  f->columns = (int32_t *)(void *)thrum_room_take(room, r);
  f->steps_tabled = f->steps_least < TABLED_MOST ? f->steps_least : TABLED_MOST;
  const int64_t places = f->steps_tabled > 2 ? 2 * f->steps_tabled : 5;
  const int64_t table = f->balance->model->point_count > 0 ? 2 * r * r : places * r * r;
  f->tangents = thrum_room_take(room, table);
  f->drag = thrum_room_take(room, f->balance->slaves.count > 0 ? table : 0);
  f->inertia = thrum_room_take(room, f->balance->slaves.count > 0 ? table : 0);
  f->product = thrum_room_take(room, 2 * r * r);
  f->values = thrum_room_take(room, 4 * r);
  f->kept = thrum_room_take(room, 4 * r);
  f->q = thrum_room_take(room, r);
}

/* How many steps a place of Gauss is from the beginning. */
static double steps_to(int64_t place) {
  return (double)(place / 2) + (place % 2 == 0 ? C1 : C2);
}

/* The harmonics 0 to 2 H so many steps from the beginning. */
static void put_waves(thrum_floquet *f, double at) {
  const double angle = THRUM_TWO_PI * at / (double)f->steps, c = cos(angle), s = sin(angle);
  f->cosines[0] = 1;
  f->sines[0] = 0;

  // each turns the one before by that angle
  for (int64_t k = 0; k < 2 * f->balance->harmonics; k++) {
    f->cosines[k + 1] = c * f->cosines[k] - s * f->sines[k];
    f->sines[k + 1] = s * f->cosines[k] + c * f->sines[k];
  }
}

/* The place at these harmonics, in f->q. */
static void motion_at(thrum_floquet *f, const thrum_place *of) {
  const thrum_balance *b = f->balance;
  const int64_t r = b->rank;
  memcpy(f->q, of->x, (size_t)r * sizeof *f->q);
  for (int64_t block = 1; block < b->blocks; block++) {
    const int64_t k = thrum_block_harmonic(b, block);
    const double value = thrum_block_sine(b, block) ? f->sines[k] : f->cosines[k];
    for (int64_t i = 0; i < r; i++)
      f->q[i] += value * of->x[block * r + i];
  }
}

/* The tangent of a sum over points, which no finite series holds, at the harmonics of a place. */
static void tangent_of_points(thrum_floquet *f, const thrum_place *of, double *tangent) {
  thrum_balance *b = f->balance;
  const int64_t square = b->rank * b->rank;
  motion_at(f, of);
  thrum_tangent_stiffness(b->model, f->q, tangent, b->work);
  const double parts[LOAD_PARTS] = {1, f->cosines[b->periods], f->sines[b->periods]};
  for (int part = 0; part < LOAD_PARTS; part++)
    for (int64_t e = 0; b->pulls[part] && e < square; e++)
      tangent[e] -= parts[part] * b->pull[part * square + e];
}

/* The matrices of (21.7) at four places that lie symmetrically in the period, the first so many
 * steps from its beginning: by the place, over Omega^2, with what of the load changes with q; and
 * by velocity, over Omega, and acceleration, where slaves have inertia. They are quadratic in the
 * motion, so their series of 2 H harmonics, which the balance has made, is exact. at: four matrices
 * of each table are filled, those of these places. */
static void sum_matrices(thrum_floquet *f, const thrum_place *of, double steps,
                         const int64_t at[4]) {
  thrum_balance *b = f->balance;
  const int64_t square = b->rank * b->rank, count = 2 * b->harmonics + 1;
  const thrum_spectrum *const spectra[3] = {&b->stiffness, &b->drag, &b->inertia};
  double *const tables[3] = {f->tangents, f->drag, f->inertia};
  const double scales[3] = {1 / (of->omega * of->omega), 1 / of->omega, 1};
  put_waves(f, steps);

  // means with cosines and sines are halves of the coefficients, but for the first
  for (int64_t k = 1; k < count; k++) {
    f->cosines[k] *= 2;
    f->sines[k] *= 2;
  }
  for (int kind = 0; kind < (b->slaves.count > 0 ? 3 : 1); kind++) {
    double *const out[4] = {tables[kind] + at[0] * square, tables[kind] + at[1] * square,
                            tables[kind] + at[2] * square, tables[kind] + at[3] * square};
    thrum_wide_waves(count, square, spectra[kind]->even, spectra[kind]->odd, f->cosines, f->sines,
                     scales[kind], out);
  }
}

/* Fills the tables of all places, four at once: tau, pi + tau, -tau and pi - tau, where the two
 * stages change places. */
static void fill_tables(thrum_floquet *f, const thrum_place *of) {
  const int64_t n = f->steps, half = n / 2;
  for (int64_t i = 0; i < half; i++) {
    const int64_t at[4] = {2 * i, 2 * (i + half), 2 * (n - 1 - i) + 1, 2 * (half - 1 - i) + 1};
    sum_matrices(f, of, steps_to(2 * i), at);
  }
}

/* Finds where the matrices of both stages of a step lie in the tables. Steps that have no room
 * there use the first five places. */
static void find_matrices(thrum_floquet *f, const thrum_place *of, int64_t index) {
  thrum_balance *b = f->balance;
  if (f->tabled) {
    f->at = 2 * index;
    return;
  }
  f->at = 0;
  for (int64_t stage = 0; stage < 2; stage++)
    if (b->model->point_count > 0) {
      put_waves(f, steps_to(2 * index + stage));
      double *tangent = f->tangents + stage * b->rank * b->rank;
      tangent_of_points(f, of, tangent);
      for (int64_t e = 0; e < b->rank * b->rank; e++)
        tangent[e] /= of->omega * of->omega;
    } else {
      const int64_t at[4] = {stage, 2, 3, 4};
      sum_matrices(f, of, steps_to(2 * index + stage), at);
    }
}

/* One block of the system of a step. */
WIDE static void fill_block(thrum_floquet *f, double omega, double h, int i, int j) {
  const thrum_balance *b = f->balance;
  const int64_t r = b->rank;
  const double weight = h * h * stage_square(i, j), once = h * stage_weight(i, j);
  for (int64_t row = 0; row < r; row++) {
    const int64_t at = ((f->at + i) * r + row) * r;
    double *out = f->system + (i * r + row) * f->width + j * r;
    for (int64_t column = 0; column < r; column++)
      out[column] = weight * f->tangents[at + column];
    for (int64_t column = 0; b->slaves.count > 0 && column < r; column++)
      out[column] += once * f->drag[at + column] + (i == j ? f->inertia[at + column] : 0);
    out[row] += i == j;
    if (b->damping != NULL)
      out[row] += once * b->damping[row] / omega;
  }
}

/* The right-hand sides of a stage. */
WIDE static void fill_rates(thrum_floquet *f, double omega, double h, int stage) {
  const thrum_balance *b = f->balance;
  const int64_t r = b->rank, count = 2 * r;
  const double *y = f->motion, *speed = f->motion + r * count;
  const double ahead = h * (stage == 0 ? C1 : C2);
  for (int64_t e = 0; e < r * count; e++)
    f->product[e] = -(y[e] + ahead * speed[e]);
  for (int64_t row = 0; row < r; row++) {
    const double damping = b->damping != NULL ? b->damping[row] / omega : 0;
    double *rates = f->system + (stage * r + row) * f->width + count;
    for (int64_t c = 0; c < count; c++)
      rates[c] = -damping * speed[row * count + c];
    thrum_wide_product(r, count, f->product, f->tangents + ((f->at + stage) * r + row) * r, rates);
  }

  // what the velocity does through the slaves
  if (b->slaves.count == 0)
    return;
  for (int64_t e = 0; e < r * count; e++)
    f->product[e] = -speed[e];
  for (int64_t row = 0; row < r; row++)
    thrum_wide_product(r, count, f->product, f->drag + ((f->at + stage) * r + row) * r,
                       f->system + (stage * r + row) * f->width + count);
}

/* The motion a step on, by the accelerations at both stages. */
WIDE static void move(thrum_floquet *f, double h) {
  const int64_t r = f->balance->rank, count = 2 * r;
  const double first = h * h * (0.25 + 0.5 * root), second = h * h * (0.25 - 0.5 * root);
  for (int64_t row = 0; row < r; row++) {
    double *y = f->motion + row * count, *speed = y + r * count;
    const double *w = f->system + row * f->width + count, *v = w + r * f->width;

    // y first, for it takes the speed at the beginning
    for (int64_t c = 0; c < count; c++) {
      y[c] += h * speed[c] + first * w[c] + second * v[c];
      speed[c] += 0.5 * h * (w[c] + v[c]);
    }
  }
}

static bool step(thrum_floquet *f, const thrum_place *of, int64_t index) {
  const int64_t r = f->balance->rank, count = 2 * r;
  const double h = THRUM_TWO_PI / (double)f->steps;
  find_matrices(f, of, index);
  for (int stage = 0; stage < 2; stage++) {
    fill_rates(f, of->omega, h, stage);
    fill_block(f, of->omega, h, stage, 0);
    fill_block(f, of->omega, h, stage, 1);
  }
  if (!thrum_square_eliminate(f->system, count, count, f->columns))
    return false;
  move(f, h);
  return true;
}

/* Distance of a multiplier from 1. */
static double from_one(const double *value) {
  return thrum_magnitude(value[0] - 1, value[1]);
}

/* The two multipliers of a free motion that are 1 for its phase and its energy; -1: none. */
static void find_own(const thrum_floquet *f, int64_t own[2]) {
  own[0] = own[1] = -1;
  if (f->balance->blocks > f->balance->harmonics + 1)
    return;
  for (int which = 0; which < 2; which++)
    for (int64_t i = 0; i < 2 * f->balance->rank; i++)
      if (i != own[0] &&
          (own[which] < 0 || from_one(f->values + 2 * i) < from_one(f->values + 2 * own[which])))
        own[which] = i;
}

int32_t thrum_floquet_unstable(const thrum_floquet *f) {
  int64_t own[2];
  int32_t count = 0;
  find_own(f, own);
  for (int64_t i = 0; i < 2 * f->balance->rank; i++)
    count += i != own[0] && i != own[1] &&
             thrum_magnitude(f->values[2 * i], f->values[2 * i + 1]) > 1 + OUTSIDE;
  return count;
}

thrum_response_kind thrum_floquet_crossing(const thrum_floquet *f) {
  int64_t own[2];
  double nearest = INFINITY;
  thrum_response_kind kind = THRUM_RESPONSE_REGULAR;
  find_own(f, own);
  for (int64_t i = 0; i < 2 * f->balance->rank; i++) {
    const double *value = f->values + 2 * i, size = thrum_magnitude(value[0], value[1]);
    if (i == own[0] || i == own[1] || size <= 1 + OUTSIDE || size >= nearest)
      continue;
    nearest = size;
    kind = value[1] != 0  ? THRUM_RESPONSE_NEIMARK_SACKER
           : value[0] > 0 ? THRUM_RESPONSE_BRANCH
                          : THRUM_RESPONSE_PERIOD_DOUBLING;
  }
  return kind;
}

/* Fills the table with the matrices where steps begin, and says whether these are short. */
static bool fill_beginnings(thrum_floquet *f, const thrum_place *of, double h) {
  const int64_t n = f->steps, half = n / 2, r = f->balance->rank;
  for (int64_t i = 0; i <= half / 2; i++) {
    // places that mirror themselves are found twice, once behind the table
    const bool twice = i == 0 || 2 * i == half;
    const int64_t at[4] = {i, i + half, twice ? n : n - i, twice ? n + 1 : half - i};
    sum_matrices(f, of, (double)i, at);
  }
  double largest = 0;
  for (int64_t row = 0; row < n * r; row++) {
    double sum = 0;
    for (int64_t column = 0; column < r; column++)
      sum += fabs(f->tangents[row * r + column]);
    largest = fmax(largest, sum);
  }
  return h * h * largest < SHORT;
}

/* A step of Numerov's method: w is the first half of the motion, and w of the step before the
 * other.
 */
WIDE static bool step_numerov(thrum_floquet *f, const double *shrink, double omega, double h,
                              int64_t index) {
  const thrum_balance *b = f->balance;
  const int64_t r = b->rank, count = 2 * r, width = thrum_square_width(r, count);
  const double share = h * h / 12, *tangent = f->tangents + index * r * r;
  double *now = f->motion, *before = f->motion + r * count;
  for (int64_t i = 0; i < r; i++) {
    double *row = f->system + i * width;
    const double damping = b->damping != NULL ? b->damping[i] / omega : 0;
    for (int64_t j = 0; j < r; j++)
      row[j] = share * tangent[i * r + j];
    row[i] += 1 - 0.25 * share * damping * damping;
    for (int64_t c = 0; c < count; c++)
      row[r + c] = 12 * now[i * count + c];
  }
  if (!thrum_square_eliminate(f->system, r, count, f->columns))
    return false;
  for (int64_t i = 0; i < r; i++) {
    const double *row = f->system + i * width + r;
    for (int64_t c = i * count; c < (i + 1) * count; c++) {
      const double next = shrink[i] * (row[c - i * count] - 10 * now[c] - shrink[i] * before[c]);
      before[c] = now[c];
      now[c] = next;
    }
  }
  return true;
}

/* The motion by Numerov's method, where that will do. */
static bool move_numerov(thrum_floquet *f, const thrum_place *place) {
  const thrum_balance *b = f->balance;
  const double h = THRUM_TWO_PI / (double)f->steps;
  double *shrink = f->q;
  if (b->slaves.count > 0 || !fill_beginnings(f, place, h))
    return false;
  for (int64_t i = 0; i < b->rank; i++)
    shrink[i] = b->damping != NULL
                    ? 1 + thrum_exponential_growth(-0.5 * h * b->damping[i] / place->omega)
                    : 1;
  for (int64_t index = 0; index < f->steps; index++)
    if (!step_numerov(f, shrink, place->omega, h, index))
      return false;
  return true;
}

static void begin_with_units(thrum_floquet *f) {
  const int64_t n = 2 * f->balance->rank;
  memset(f->motion, 0, (size_t)(n * n) * sizeof *f->motion);
  for (int64_t i = 0; i < n; i++)
    f->motion[i * n + i] = 1;
}

/* Multipliers by f->steps steps. */
static bool solve_by_steps(thrum_floquet *f, const thrum_place *place) {
  const int64_t n = 2 * f->balance->rank;
  begin_with_units(f);
  f->tabled =
      f->balance->model->point_count == 0 && f->steps <= f->steps_tabled && f->steps % 2 == 0;
  if (f->tabled && move_numerov(f, place))
    return thrum_eigenvalues(f->motion, n, f->values);
  begin_with_units(f);
  if (f->tabled)
    fill_tables(f, place);
  for (int64_t index = 0; index < f->steps; index++)
    if (!step(f, place, index))
      return false;
  return thrum_eigenvalues(f->motion, n, f->values);
}

/* How fast what is unstable grows: the sum of the logarithms of its multipliers. */
static double growth(const thrum_floquet *f) {
  int64_t own[2];
  double sum = 0;
  find_own(f, own);
  for (int64_t i = 0; i < 2 * f->balance->rank; i++) {
    const double more = thrum_magnitude(f->values[2 * i], f->values[2 * i + 1]) - 1;
    if (i != own[0] && i != own[1] && more > 0)
      sum += more - thrum_beyond_logarithm(more);
  }
  return sum;
}

/* Whether half of the steps find the same, of which most is believed at the least cost; the values
 * of all steps stay. */
static bool agrees_with_half(thrum_floquet *f, const thrum_place *place) {
  const int32_t unstable = thrum_floquet_unstable(f);
  const double fast = growth(f);
  const int64_t steps = f->steps;
  const size_t size = (size_t)(4 * f->balance->rank) * sizeof *f->values;
  memcpy(f->kept, f->values, size);
  f->steps = steps / 2;
  const bool same = f->steps > 0 && solve_by_steps(f, place) &&
                    thrum_floquet_unstable(f) == unstable &&
                    fabs(growth(f) - fast) < AGREE * fast + OUTSIDE;
  f->steps = steps;
  memcpy(f->values, f->kept, size);
  return same;
}

/* Steps in which a high mode turns far pump it, where their frequency meets that of the motion. So
 * what is unstable is believed where half or twice the steps find it as fast. */
bool thrum_floquet_solve(thrum_floquet *f, const thrum_place *place) {
  f->steps = f->steps_least;

  // the series of the matrices at this motion
  if (f->balance->model->point_count == 0) {
    thrum_balance_residual(f->balance, place->x, place->omega, f->residual);
    thrum_balance_linearise(f->balance, place->omega);
  }
  if (!solve_by_steps(f, place))
    return false;
  int32_t unstable = thrum_floquet_unstable(f);
  if (unstable > 0 && agrees_with_half(f, place))
    return true;
  for (int n = 0; n < DOUBLINGS && unstable > 0; n++) {
    const int32_t before = unstable;
    const double fast = growth(f);
    f->steps *= 2;
    if (!solve_by_steps(f, place))
      return false;
    unstable = thrum_floquet_unstable(f);
    if (unstable == before && fabs(growth(f) - fast) < AGREE * fast + OUTSIDE)
      return true;
  }
  return unstable == 0;
}
