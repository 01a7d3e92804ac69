/* Small random models made by hand, and reproducible random numbers, for tests. Header only.
 *
 *   random_model m;
 *   random_model_make(&m, seed, rank, omega_first, omega_last, amplitude);
 *   ... &m.model ...
 *   random_model_free(&m);
 *
 * The energy is that of a StVK body, V = 1/2 |e(q)|^2 with e = sum w_i q_i e_i + sum q_i q_j b_ij
 * and random vectors b: it is bounded from below, zero at rest, and its cubic and quartic terms are
 * as large as the quadratic one when the coordinates reach about `amplitude`. amplitude = INFINITY
 * gives a linear model.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_RANDOM_MODEL_H
#define THRUM_TESTS_SUPPORT_RANDOM_MODEL_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/model.h"
#include "thrum/polynomial.h"

/* splitmix64: the same numbers on every machine. Any seed is fine. */
typedef struct random_state {
  uint64_t s;
} random_state;

static inline uint64_t random_bits(random_state *random) {
  uint64_t z = (random->s += UINT64_C(0x9e3779b97f4a7c15));
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return z ^ (z >> 31);
}

/* Uniform in [-1, 1). */
static inline double random_uniform(random_state *random) {
  return (double)(random_bits(random) >> 11) * 0x1p-52 - 1.0;
}

/* Uniform whole number in [0, count). */
static inline int64_t random_index(random_state *random, int64_t count) {
  return (int64_t)(random_bits(random) % (uint64_t)count);
}

static inline void random_vector(random_state *random, int64_t count, double scale, double *out) {
  for (int64_t i = 0; i < count; i++)
    out[i] = scale * random_uniform(random);
}

/* malloc that ends the test program when there is no memory; zeroed. */
static inline void *random_alloc(int64_t count, size_t size) {
  void *memory = calloc(count > 0 ? (size_t)count : 1, size);
  if (!memory) {
    fprintf(stderr, "out of memory\n");
    exit(1);
  }
  return memory;
}

/* A model and the arrays it points to. */
typedef struct random_model {
  thrum_model model;
  double *omega2, *c3, *c4;
  double *vertices, *basis, *axis_mass, *material; /* NULL without a mesh */
  int32_t *tets, *tet_region;
  uint8_t *fixed;
  void *packed; /* NULL before random_model_pack */
} random_model;

/* Sorts four indices. */
static inline void random_sort(int64_t *a, int count) {
  for (int s = 1; s < count; s++)
    for (int t = s; t > 0 && a[t - 1] > a[t]; t--) {
      int64_t swap = a[t];
      a[t] = a[t - 1];
      a[t - 1] = swap;
    }
}

/* Fills c3 and c4 of V = 1/2 |e|^2; b: pair_count x rows, pairs (i, j), i <= j, i outermost. */
static inline void random_model_expand(int64_t rank, int64_t rows, const double *omega,
                                       const double *b, double *c3, double *c4) {
  const double *first = b;

  // V is a sum of squares, so that it is bounded from below
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = i; j < rank; j++, first += rows) {
      for (int64_t k = 0; k < rank; k++) {
        int64_t s[3] = {i, j, k};
        random_sort(s, 3);
        c3[thrum_c3_index(rank, s[0], s[1], s[2])] += omega[k] * first[k];
      }

      // the products of all pairs of pairs
      const double *second = b;
      for (int64_t k = 0; k < rank; k++)
        for (int64_t l = k; l < rank; l++, second += rows) {
          double product = 0;
          for (int64_t t = 0; t < rows; t++)
            product += first[t] * second[t];
          int64_t s[4] = {i, j, k, l};
          random_sort(s, 4);
          c4[thrum_c4_index(rank, s[0], s[1], s[2], s[3])] += 0.5 * product;
        }
    }
}

/* Makes a model without a mesh; the angular frequencies are evenly spaced in
 * [omega_first, omega_last]. */
static inline void random_model_make(random_model *out, uint64_t seed, int64_t rank,
                                     double omega_first, double omega_last, double amplitude) {
  memset(out, 0, sizeof *out);
  random_state random = {seed};
  int64_t rows = rank + 2, pairs = rank * (rank + 1) / 2;
  thrum_model *model = &out->model;
  model->rank = rank;
  model->c3_count = thrum_c3_count(rank);
  model->c4_count = thrum_c4_count(rank);

  // arrays of the size that the format says
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  model->format = format;
  model->omega2 = out->omega2 = random_alloc(rank, sizeof(double));
  model->c3 = out->c3 = random_alloc(model->c3_count, sizeof(double));
  model->c4 = out->c4 = random_alloc(model->c4_count, sizeof(double));

  // evenly spaced frequencies
  double *omega = random_alloc(rank, sizeof(double));
  for (int64_t i = 0; i < rank; i++) {
    double s = rank > 1 ? (double)i / (double)(rank - 1) : 0;
    omega[i] = omega_first + s * (omega_last - omega_first);
    out->omega2[i] = omega[i] * omega[i];
  }
  // many small terms add up to the size of the linear ones at |q_i| = amplitude
  double *b = random_alloc(pairs * rows, sizeof(double)), *pair = b;
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = i; j < rank; j++, pair += rows)
      random_vector(&random, rows, sqrt(omega[i] * omega[j]) / (amplitude * (double)rank), pair);
  if (amplitude < INFINITY)
    random_model_expand(rank, rows, omega, b, out->c3, out->c4);
  free(b);
  free(omega);
}

/* Makes a model whose cubic and quartic coefficients are plain random numbers in [-1, 1): no
 * structure that could hide an error, but not bounded from below. */
static inline void random_model_make_wild(random_model *out, uint64_t seed, int64_t rank) {
  random_model_make(out, seed, rank, 1, 2, INFINITY);
  random_state random = {seed ^ 77};
  random_vector(&random, out->model.c3_count, 1, out->c3);
  random_vector(&random, out->model.c4_count, 1, out->c4);
}

/* Adds a mesh of `vertex_count` >= 4 random vertices with a random basis, axis masses and one
 * material; vertex 0 is fixed and its rows of the basis are zero. */
static inline void random_model_add_mesh(random_model *out, uint64_t seed, int64_t vertex_count) {
  random_state random = {seed};
  thrum_model *model = &out->model;
  int64_t rank = model->rank;

  // sizes and arrays
  model->vertex_count = vertex_count;
  model->tet_count = vertex_count - 3;
  model->region_count = 1;
  model->vertices = out->vertices = random_alloc(3 * vertex_count, sizeof(double));
  model->basis = out->basis = random_alloc(3 * vertex_count * rank, sizeof(double));
  model->axis_mass = out->axis_mass = random_alloc(3 * rank, sizeof(double));
  model->material = out->material = random_alloc(3, sizeof(double));
  model->tets = out->tets = random_alloc(4 * model->tet_count, sizeof(int32_t));
  model->tet_region = out->tet_region = random_alloc(model->tet_count, sizeof(int32_t));
  model->fixed = out->fixed = random_alloc(vertex_count, 1);

  // the fixed vertex keeps its zero rows in the basis
  random_vector(&random, 3 * vertex_count, 1, out->vertices);
  random_vector(&random, 3 * (vertex_count - 1) * rank, 1, out->basis + 3 * rank);
  random_vector(&random, 3 * rank, 1, out->axis_mass);

  // the usual material of the tests, and one held vertex
  out->material[0] = 5e6;
  out->material[1] = 0.4;
  out->material[2] = 1000;
  out->fixed[0] = 7;

  // tetrahedra of consecutive vertices
  for (int64_t t = 0; t < model->tet_count; t++) {
    int32_t *v = out->tets + 4 * t;
    double e[3][3];
    for (int s = 0; s < 4; s++)
      v[s] = (int32_t)(t + s);
    for (int s = 0; s < 3; s++)
      for (int axis = 0; axis < 3; axis++)
        e[s][axis] = out->vertices[3 * v[s + 1] + axis] - out->vertices[3 * v[0] + axis];

    // two corners are exchanged where the volume is negative
    double volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                    e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                    e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    if (volume < 0) {
      v[2] = (int32_t)(t + 3);
      v[3] = (int32_t)(t + 2);
    }
  }
}

/* Packs the coefficients; they must not change afterwards. */
static inline void random_model_pack(random_model *m) {
  const size_t size = thrum_model_pack_size(&m->model);
  free(m->packed);
  m->packed = aligned_alloc(64, size);
  if (!m->packed || thrum_model_pack(&m->model, m->packed, size, NULL) != THRUM_OK) {
    fprintf(stderr, "out of memory\n");
    exit(1);
  }
}

static inline void random_model_free(random_model *m) {
  free(m->packed);
  free(m->omega2);
  free(m->c3);
  free(m->c4);
  free(m->vertices);
  free(m->basis);
  free(m->axis_mass);
  free(m->material);
  free(m->tets);
  free(m->tet_region);
  free(m->fixed);
  memset(m, 0, sizeof *m);
}

#endif
