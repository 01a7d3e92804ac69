/* Published answers: what is known in closed form or published as a benchmark, beside what this
 * program computes, with the error under refinement. The tests hold the coarse rows to bounds;
 * `thrum verify` writes them all (docs/verification.md).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_PUBLISHED_PUBLISHED_H
#define THRUM_VALIDATION_PUBLISHED_PUBLISHED_H

#include <stdbool.h>
#include <stdio.h>

#include "precompute/precompute.h"
#include "thrum/thrum.h"

/* One number beside the published one. */
typedef struct published_row {
  const char *problem;  /* static text, as are all but mesh */
  const char *quantity; /* with its unit */
  char mesh[64];        /* mesh, or the setting that is refined */
  double size;          /* what an order is fitted in: cells, or 1/h; 0: no refinement */
  double published;
  double computed;
} published_row;

/* Where rows go; `level` 0 is what a test can afford, each further one refines once more. */
typedef struct published_sink {
  void (*row)(void *context, const published_row *row);
  void *context;
  int level;
} published_sink;

/* A problem: gives its rows to the sink, coarse to fine. */
typedef thrum_status published_problem(const published_sink *sink, thrum_error *error);
published_problem published_beam, published_torsion, published_cube, published_sphere,
    published_membrane, published_elastica, published_column, published_rollup,
    published_gravity_beam, published_hardening, published_fast_slow, published_fermi,
    published_tumble, published_spin, published_periodic;

/* X(name, text) */
#define VERIFY_PROBLEMS(X)                                                                         \
  X(beam, "bending and axial modes of a cantilever")                                               \
  X(torsion, "torsion of a square bar")                                                            \
  X(cube, "free cube")                                                                             \
  X(sphere, "free sphere")                                                                         \
  X(membrane, "tapered membrane")                                                                  \
  X(elastica, "elastica")                                                                          \
  X(column, "Euler's column")                                                                      \
  X(rollup, "cantilever rolled up by a moment")                                                    \
  X(gravity_beam, "beam under gravity")                                                            \
  X(hardening, "hardening of a clamped beam")                                                      \
  X(fast_slow, "coupled fast and slow oscillators")                                                \
  X(fermi, "Fermi-Pasta-Ulam chain")                                                               \
  X(tumble, "tumbling body in the full order")                                                     \
  X(spin, "body whose spin and shape act on each other")                                           \
  X(periodic, "normal form of a beam, folds and tori of a panel")

/* The problems in their order, and how many; X(name, text). */
typedef struct published_entry {
  const char *name, *text;
  published_problem *solve;
} published_entry;
extern const published_entry published_problems[];
extern const int64_t published_problem_count;

/* --- tables ----------------------------------------------------------------------------------- */

/* Rows of problems one after the other. */
typedef struct published_rows {
  const published_row *row;
  int count;
} published_rows;

/* All rows as comma-separated values; and in Markdown a heading for each problem and a line for
 * each quantity: what is published, the finest answer, and the errors from coarse to fine. */
void published_write_csv(const published_rows *all, FILE *file);
void published_write_tables(const published_rows *all, FILE *file);

/* --- bodies ----------------------------------------------------------------------------------- */

/* A body: mesh by name, at most four things fixed, material; `map` moves its vertices first. */
typedef struct published_body {
  char mesh[64];
  const char *fix[4];
  thrum_material material;
  void (*map)(double vertex[3]);
  int order;  /* 2: tetrahedra of ten nodes; 0: linear */
  bool shell; /* hexahedra stay, as solid-shells */
} published_body;

/* Free with thrum_precomputed_free. */
thrum_status published_precompute(const published_body *body, int64_t modes, int64_t rank,
                                  bool keep_modes, thrum_precomputed *result, thrum_error *error);

/* Frequency [Hz] of the modes that make up a field: the mean of f_i weighted by the squared mass
 * product of mode i with field(X), over the modes that hold more than a hundredth of it. Needs
 * kept modes. */
double published_frequency_of(const thrum_precomputed *result,
                              void (*field)(const double x[3], double u[3]));

/* Adds a row. */
void published_add(const published_sink *sink, const char *problem, const char *quantity,
                   const char *mesh, double size, double published, double computed);

/* --- known solutions -------------------------------------------------------------------------- */

/* Angular frequency n (from 1) of a clamped-free Timoshenko beam with E = rho = length = 1, square
 * or rectangular section of this thickness, nu = 0, shear factor 5/6. */
double published_timoshenko(double thickness, int n);

/* Tip of an inextensible cantilever of unit length under the dead tip load P L^2/(E I): deflection
 * and shortening (the elastica). */
void published_elastica_tip(double load, double *deflection, double *shortening);

/* Frequency of q'' + q + e q^3 = 0 at amplitude 1 over that of e = 0. */
double published_duffing(double e);

/* --- models made of polynomials --------------------------------------------------------------- */

#define VERIFY_RANK_MAX 8

typedef struct published_polynomial {
  double omega2[VERIFY_RANK_MAX];
  double c3[120], c4[330]; /* of VERIFY_RANK_MAX */
  thrum_model model;
} published_polynomial;

/* V = 1/2 sum omega2_i q_i^2, omega2 ascending. */
void published_polynomial_make(published_polynomial *p, int64_t rank, const double *omega2);

/* V += weight (a q)^4. */
void published_polynomial_add(published_polynomial *p, double weight, const double *a);

/* A state of this def at q, p; the caller destroys it. */
thrum_status published_state(const thrum_model *model, const thrum_state_def *def, const double *q,
                             const double *p, thrum_state **state, thrum_error *error);

#endif
