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

#include "core/base/pi.h"
#include "response/wide.h"
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
  thrum_spectrum *const spectra[] = {&b->stiffness, &b->drag, &b->inertia};
  for (int kind = 0; kind < (b->slaves.count > 0 ? 3 : 1); kind++) {
    spectra[kind]->samples = thrum_room_take(room, n * r * r);
    spectra[kind]->even = thrum_room_take(room, spectrum);
    spectra[kind]->odd = thrum_room_take(room, spectrum);
  }
  if (b->slaves.count == 0)
    return;
  b->slaves.samples = n;
  thrum_slave_inertia_lay(&b->slaves, room);
  b->velocity = thrum_room_take(room, n * r);
  b->bend = thrum_room_take(room, n * r);
  b->turn = thrum_room_take(room, b->unknowns);
}

void thrum_balance_fill(thrum_balance *b) {
  // no load, as of a backbone; a forced curve puts its own over it
  memset(b->load, 0, (size_t)(LOAD_PARTS * b->rank) * sizeof *b->load);
  if (b->pull != NULL)
    memset(b->pull, 0, (size_t)(LOAD_PARTS * b->rank * b->rank) * sizeof *b->pull);

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
  parts[LOAD_COSINE] = b->cosines[b->periods * b->samples + s];
  parts[LOAD_SINE] = b->sines[b->periods * b->samples + s];
}

void thrum_balance_subtract_load(const thrum_balance *b, int64_t s, const double *q,
                                 double *force) {
  const int64_t r = b->rank;
  double parts[LOAD_PARTS];
  load_parts(b, s, parts);
  for (int part = 0; part < LOAD_PARTS; part++) {
    for (int64_t i = 0; i < r; i++)
      force[i] -= parts[part] * b->load[part * r + i];

    // a load on what follows pulls at what it follows, by a symmetric matrix
    for (int64_t j = 0; b->pulls[part] && j < r; j++) {
      const double by = parts[part] * q[j], *pull = b->pull + (part * r + j) * r;
      for (int64_t i = 0; i < r; i++)
        force[i] -= by * pull[i];
    }
  }
}

void thrum_balance_rates(const thrum_balance *b, const double *x, double omega, int64_t s,
                         double *velocity, double *bend) {
  const int64_t r = b->rank;
  memset(velocity, 0, (size_t)r * sizeof *velocity);
  memset(bend, 0, (size_t)r * sizeof *bend);
  for (int64_t block = 1; block < b->blocks; block++) {
    const int64_t at = thrum_block_harmonic(b, block) * b->samples + s;
    const double k = omega * (double)thrum_block_harmonic(b, block);
    const bool sine = thrum_block_sine(b, block);
    const double rate = k * (sine ? b->cosines[at] : -b->sines[at]);
    const double second = -k * k * (sine ? b->sines[at] : b->cosines[at]);
    for (int64_t i = 0; i < r; i++) {
      velocity[i] += rate * x[block * r + i];
      bend[i] += second * x[block * r + i];
    }
  }
}

/* The projections of N x rank numbers on the functions, 1 / N and 2 / N of their sums, in out. */
static void project(const thrum_balance *b, const double *numbers, double *out) {
  const double share = 1.0 / (double)b->samples;
  memset(out, 0, (size_t)b->unknowns * sizeof *out);
  for (int64_t block = 0; block < b->blocks; block++) {
    double *own = out + block * b->rank;
    thrum_wide_product(b->samples, b->rank, numbers, function_of(b, block), own);
    for (int64_t i = 0; i < b->rank; i++)
      own[i] *= block > 0 ? 2 * share : share;
  }
}

/* The forces at a sample, where the motion is known. */
static void force_at(thrum_balance *b, const double *x, double omega, int64_t s) {
  const int64_t r = b->rank;
  const double share = 1.0 / (double)b->samples;
  double *q = b->q + s * r, *force = b->force + s * r, loss = 0;
  b->energy += share * thrum_internal_force(b->model, q, force, b->work);
  thrum_balance_subtract_load(b, s, q, force);
  if (b->slaves.count == 0)
    return;
  double *velocity = b->velocity + s * r, *bend = b->bend + s * r;
  thrum_balance_rates(b, x, omega, s, velocity, bend);
  b->energy += share * thrum_slave_inertia_force(&b->slaves, s, q, velocity, bend, force, &loss);
  b->loss += share * loss;
}

void thrum_balance_residual(thrum_balance *b, const double *x, double omega, double *residual) {
  const int64_t r = b->rank, n = b->samples;
  b->energy = b->loss = 0;
  for (int64_t s = 0; s < n; s++) {
    // the motion at the sample
    double *q = b->q + s * r;
    memcpy(q, x, (size_t)r * sizeof *q);
    for (int64_t block = 1; block < b->blocks; block++) {
      const double value = function_of(b, block)[s];
      for (int64_t i = 0; i < r; i++)
        q[i] += value * x[block * r + i];
    }
    force_at(b, x, omega, s);
  }

  // forces in the functions, and what inertia and damping have in them
  project(b, b->force, residual);
  for (int64_t block = 0; block < b->blocks; block++) {
    const double k = omega * (double)thrum_block_harmonic(b, block);
    const bool sine = thrum_block_sine(b, block);
    const int64_t other = sine ? block - b->harmonics : block + b->harmonics;
    for (int64_t i = 0; i < r; i++) {
      double *own = residual + block * r + i;
      *own -= k * k * x[block * r + i];
      if (b->damping != NULL && block > 0 && other < b->blocks)
        *own += (sine ? -k : k) * b->damping[i] * x[other * r + i];
    }
  }
}

/* The means of a matrix over the samples; those with sines where they are asked for. */
static void transform(const thrum_balance *b, const thrum_spectrum *of, bool odd) {
  const int64_t square = b->rank * b->rank, count = 2 * b->harmonics + 1, n = b->samples;
  for (int64_t e = 0; e < n * square; e++)
    of->samples[e] /= (double)n;
  memset(of->even, 0, (size_t)(count * square) * sizeof *of->even);
  memset(of->odd, 0, (size_t)(count * square) * sizeof *of->odd);
  for (int64_t m = 0; m < count; m++) {
    thrum_wide_product(n, square, of->samples, b->cosines + m * n, of->even + m * square);
    if (odd)
      thrum_wide_product(n, square, of->samples, b->sines + m * n, of->odd + m * square);
  }
}

/* What the slaves have of the Jacobian at a sample. */
static void linearise_slaves(thrum_balance *b, double omega, int64_t s) {
  const int64_t r = b->rank, square = r * r;
  double *turn = b->force + s * r;
  thrum_slave_inertia_matrices(&b->slaves, s, b->bend + s * r, b->stiffness.samples + s * square,
                               b->drag.samples + s * square, b->inertia.samples + s * square);
  memset(turn, 0, (size_t)r * sizeof *turn);
  thrum_slave_inertia_turn(&b->slaves, s, turn);
  for (int64_t i = 0; i < r; i++)
    turn[i] /= omega;
}

void thrum_balance_linearise(thrum_balance *b, double omega) {
  const int64_t r = b->rank, square = r * r;
  const bool slaves = b->slaves.count > 0, even_motion = b->blocks == b->harmonics + 1;
  for (int64_t s = 0; s < b->samples; s++) {
    double *tangent = b->stiffness.samples + s * square, parts[LOAD_PARTS];
    thrum_tangent_stiffness(b->model, b->q + s * r, tangent, b->work);
    load_parts(b, s, parts);
    for (int part = 0; part < LOAD_PARTS; part++)
      for (int64_t e = 0; b->pulls[part] && e < square; e++)
        tangent[e] -= parts[part] * b->pull[part * square + e];
    if (slaves)
      linearise_slaves(b, omega, s);
  }

  // in an even motion only what goes with the velocity has odd means
  transform(b, &b->stiffness, !even_motion);
  if (!slaves)
    return;
  transform(b, &b->drag, true);
  transform(b, &b->inertia, !even_motion);
  project(b, b->force, b->turn);
}

/* out (rank) += scale times row i of the mean of a matrix with the functions of two blocks:
 * products of functions are sums of two, cos j cos k = (cos(j - k) + cos(j + k))/2, and so on. The
 * second is of the harmonic k, of sines or not. */
static void add_mean(const thrum_balance *b, const thrum_spectrum *of, int64_t block, int64_t i,
                     int64_t k, bool sine_k, double scale, double *out) {
  const int64_t r = b->rank, square = r * r, j = thrum_block_harmonic(b, block);
  const bool sine_j = thrum_block_sine(b, block);
  const double *means = (sine_j == sine_k ? of->even : of->odd) + i * r;
  const double *first = means + (j > k ? j - k : k - j) * square,
               *second = means + (j + k) * square;

  // the mean is taken once where the others are taken twice
  const double whole = block == 0 ? 0.5 * scale : scale;
  const double w = sine_j != sine_k && sine_j != (j > k) ? -whole : whole;
  const double v = sine_j && sine_k ? -whole : whole;
  for (int64_t column = 0; column < r; column++)
    out[column] += w * first[column] + v * second[column];
}

double thrum_balance_row(const thrum_balance *b, const double *x, double omega, int64_t row,
                         double scale, double *out) {
  const int64_t r = b->rank, block = row / r, i = row % r;
  memset(out, 0, (size_t)b->unknowns * sizeof *out);
  for (int64_t other = 0; other < b->blocks; other++) {
    const int64_t k = thrum_block_harmonic(b, other);
    const bool sine = thrum_block_sine(b, other);
    double *own = out + other * r;
    add_mean(b, &b->stiffness, block, i, k, sine, scale, own);
    if (b->slaves.count == 0 || k == 0)
      continue;

    // the velocity of a cosine is a sine
    const double rate = omega * (double)k;
    add_mean(b, &b->drag, block, i, k, !sine, scale * (sine ? rate : -rate), own);
    add_mean(b, &b->inertia, block, i, k, sine, -scale * rate * rate, own);
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
  return b->slaves.count > 0 ? by_omega + b->turn[row] : by_omega;
}

double thrum_balance_weight(const thrum_balance *b, double omega, int64_t row) {
  const double k = omega * (double)thrum_block_harmonic(b, row / b->rank);
  const double weight = b->model->omega2[row % b->rank] + k * k;
  return weight > 0 ? weight : omega * omega;
}
