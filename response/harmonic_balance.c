/* Harmonic balance: the coefficients of a periodic motion for which the residual has no component
 * in its own functions, docs/mathematics/21 (2)-(5).
 *
 * With tau_s = 2 pi s / N, N >= 4 H + 1, sums over the samples are the integrals of what has degree
 * 4 H and less: R(q) is cubic in q, of degree 3 H, and is multiplied by functions of degree H; T(q)
 * has degree 2 H, and its products with two functions have 4 H. So the projection and its Jacobian
 * are exact. The latter consists of sums and differences of the Fourier coefficients of T. Cost of
 * a residual: N forces and 4 N (2 H + 1) r operations; of a Jacobian N tangents and 4 N (2 H + 1)
 * r^2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/harmonic_balance.h"

#include <math.h>
#include <string.h>

#include "core/base/matrix_product.h"
#include "core/base/pi.h"
#include "thrum/polynomial.h"

void thrum_balance_lay(thrum_balance *b, bool pulls, thrum_room *room) {
  const int64_t r = b->rank, n = b->samples, table = (2 * b->harmonics + 1) * n;
  const int64_t spectrum = (2 * b->harmonics + 1) * r * r;
  b->work = thrum_room_take(room, (int64_t)thrum_work_count(b->model));
  b->load = thrum_room_take(room, LOAD_PARTS * r);
  b->pull = pulls ? thrum_room_take(room, LOAD_PARTS * r * r) : NULL;
  b->cosines = thrum_room_take(room, table);
  b->sines = thrum_room_take(room, table);
  b->q = thrum_room_take(room, n * r);
  b->force = thrum_room_take(room, n * r);
  b->tangents = thrum_room_take(room, n * r * r);
  b->even = thrum_room_take(room, spectrum);
  b->odd = thrum_room_take(room, spectrum);
}

void thrum_balance_fill(thrum_balance *b) {
  // the angle is reduced first, so that the tables are as exact at high harmonics
  for (int64_t m = 0; m <= 2 * b->harmonics; m++)
    for (int64_t s = 0; s < b->samples; s++) {
      const double angle = THRUM_TWO_PI * (double)(m * s % b->samples) / (double)b->samples;
      b->cosines[m * b->samples + s] = cos(angle);
      b->sines[m * b->samples + s] = sin(angle);
    }
}

/* The function of a block at the samples. */
static const double *function_of(const thrum_balance *b, int64_t block) {
  return (thrum_block_sine(b, block) ? b->sines : b->cosines) +
         thrum_block_harmonic(b, block) * b->samples;
}

/* What of cos and sin the load has at a sample. */
static void load_parts(const thrum_balance *b, int64_t s, double parts[LOAD_PARTS]) {
  parts[LOAD_MEAN] = 1;
  parts[LOAD_COSINE] = b->cosines[b->samples + s];
  parts[LOAD_SINE] = b->sines[b->samples + s];
}

void thrum_balance_subtract_load(const thrum_balance *b, int64_t s, const double *q,
                                 double *force) {
  const int64_t r = b->rank;
  double parts[LOAD_PARTS];
  load_parts(b, s, parts);
  for (int part = 0; part < LOAD_PARTS; part++) {
    for (int64_t i = 0; i < r; i++)
      force[i] -= parts[part] * b->load[part * r + i];

    // a load on what follows pulls at what it follows
    for (int64_t i = 0; b->pull != NULL && i < r; i++)
      for (int64_t j = 0; j < r; j++)
        force[i] -= parts[part] * b->pull[(part * r + i) * r + j] * q[j];
  }
}

void thrum_balance_residual(thrum_balance *b, const double *x, double omega, double *residual) {
  const int64_t r = b->rank, n = b->samples;
  const double share = 1.0 / (double)n;
  b->strain_energy = 0;
  for (int64_t s = 0; s < n; s++) {
    // the motion at the sample
    double *q = b->q + s * r, *force = b->force + s * r;
    memcpy(q, x, (size_t)r * sizeof *q);
    for (int64_t block = 1; block < b->blocks; block++) {
      const double value = function_of(b, block)[s];
      for (int64_t i = 0; i < r; i++)
        q[i] += value * x[block * r + i];
    }
    b->strain_energy += share * thrum_internal_force(b->model, q, force, b->work);
    thrum_balance_subtract_load(b, s, q, force);
  }

  // forces in the functions, and what inertia and damping have in them
  memset(residual, 0, (size_t)b->unknowns * sizeof *residual);
  for (int64_t block = 0; block < b->blocks; block++) {
    thrum_matrix_product_transposed(n, r, b->force, function_of(b, block), residual + block * r);
    const double k = omega * (double)thrum_block_harmonic(b, block);
    const bool sine = thrum_block_sine(b, block);
    const int64_t other = sine ? block - b->harmonics : block + b->harmonics;
    for (int64_t i = 0; i < r; i++) {
      double *own = residual + block * r + i;
      *own = (block > 0 ? 2 : 1) * share * *own - k * k * x[block * r + i];
      if (b->damping != NULL && block > 0 && other < b->blocks)
        *own += (sine ? -k : k) * b->damping[i] * x[other * r + i];
    }
  }
}

void thrum_balance_linearise(thrum_balance *b) {
  const int64_t r = b->rank, n = b->samples, square = r * r;
  for (int64_t s = 0; s < n; s++) {
    double *tangent = b->tangents + s * square, parts[LOAD_PARTS];
    thrum_tangent_stiffness(b->model, b->q + s * r, tangent, b->work);
    load_parts(b, s, parts);
    for (int part = 0; b->pull != NULL && part < LOAD_PARTS; part++)
      for (int64_t e = 0; e < square; e++)
        tangent[e] -= parts[part] * b->pull[part * square + e];
    for (int64_t e = 0; e < square; e++)
      tangent[e] /= (double)n;
  }

  // of an even motion the odd means are zero and not asked for
  const int64_t count = 2 * b->harmonics + 1;
  memset(b->even, 0, (size_t)(count * square) * sizeof *b->even);
  memset(b->odd, 0, (size_t)(count * square) * sizeof *b->odd);
  for (int64_t m = 0; m < count; m++) {
    thrum_matrix_product_transposed(n, square, b->tangents, b->cosines + m * n,
                                    b->even + m * square);
    if (b->blocks > b->harmonics + 1)
      thrum_matrix_product_transposed(n, square, b->tangents, b->sines + m * n,
                                      b->odd + m * square);
  }
}

/* One row of the block of a Jacobian: two means, each with its sign, or one. */
typedef struct mean_pair {
  const double *first, *second;
  double sign_first, sign_second;
} mean_pair;

/* Products of two functions are sums of two: cos j cos k = (cos(j - k) + cos(j + k))/2, and so on.
 */
static mean_pair pair_of(const thrum_balance *b, int64_t j, int64_t k) {
  const int64_t square = b->rank * b->rank;
  const int64_t a = thrum_block_harmonic(b, j), c = thrum_block_harmonic(b, k);
  const bool sine_j = thrum_block_sine(b, j), sine_k = thrum_block_sine(b, k);
  const double *means = sine_j == sine_k ? b->even : b->odd;
  mean_pair pair = {means + (a > c ? a - c : c - a) * square, means + (a + c) * square, 1, 1};
  if (sine_j && sine_k)
    pair.sign_second = -1;
  else if (sine_j != sine_k)
    pair.sign_first = sine_j == (a > c) ? 1 : -1;

  // the mean is taken once where the others are taken twice
  if (j == 0) {
    pair.sign_first *= 0.5;
    pair.sign_second *= 0.5;
  }
  return pair;
}

double thrum_balance_row(const thrum_balance *b, const double *x, double omega, int64_t row,
                         double scale, double *out) {
  const int64_t r = b->rank, block = row / r, i = row % r;
  for (int64_t k = 0; k < b->blocks; k++) {
    const mean_pair pair = pair_of(b, block, k);
    const double *first = pair.first + i * r, *second = pair.second + i * r;
    const double w = scale * pair.sign_first, v = scale * pair.sign_second;
    for (int64_t j = 0; j < r; j++)
      out[k * r + j] = w * first[j] + v * second[j];
  }

  // inertia and damping, and what both change with the frequency
  const double harmonic = (double)thrum_block_harmonic(b, block), k = omega * harmonic;
  out[row] -= scale * k * k;
  double by_omega = -2 * harmonic * k * x[row];
  const bool sine = thrum_block_sine(b, block);
  const int64_t other = sine ? block - b->harmonics : block + b->harmonics;
  if (b->damping != NULL && block > 0 && other < b->blocks) {
    const double damping = (sine ? -1 : 1) * b->damping[i];
    out[other * r + i] += scale * k * damping;
    by_omega += harmonic * damping * x[other * r + i];
  }
  return by_omega;
}

double thrum_balance_weight(const thrum_balance *b, double omega, int64_t row) {
  const double k = omega * (double)thrum_block_harmonic(b, row / b->rank);
  const double weight = b->model->omega2[row % b->rank] + k * k;
  return weight > 0 ? weight : omega * omega;
}
