/* A reduced body as an FMU, without what tells the versions of FMI apart: its numbers, its
 * variables, its step, its derivatives and its state as bytes. Every function works on one
 * instance, which one thread at a time may call. SPDX-License-Identifier: Apache-2.0 */
#ifndef FMU_BODY_H
#define FMU_BODY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "driver/export/fmu/body_code.h"
#include "driver/export/fmu/fmu_prefix.h"

#define FMU_TOKEN 40 /* bytes of the token that tells one FMU from others, its end included */
#define FMU_MAGIC "thrumfm1" /* the first 8 bytes of resources/body.bin */

/* The head of resources/body.bin; the doubles of fmu_numbers_count follow: alpha, beta, stiffness
 * and step at the start, omega2 (rank), axis_mass (3 rank), the rows of the places (3 rank each),
 * follows (rank), and the coefficients. */
typedef struct fmu_head {
  char magic[8];
  char token[FMU_TOKEN];
  int32_t rank, places;
} fmu_head;

/* The variables by their value references: those that are set first, then those that follow from
 * them. */
enum fmu_variable {
  FMU_TIME,
  FMU_ALPHA,
  FMU_BETA,
  FMU_STIFFNESS,
  FMU_STEP,
  FMU_ACCELERATION, /* x, y, z of the ground */
  FMU_FORCES = 8    /* x, y, z at each place; then q and p */
};

static inline int fmu_q(int places) {
  return FMU_FORCES + 3 * places;
}

static inline int fmu_p(int rank, int places) {
  return fmu_q(places) + rank;
}

/* Displacements, x, y, z at each place; behind them velocities, strain energy, kinetic energy, and
 * the derivatives of q and of p. */
static inline int fmu_displacements(int rank, int places) {
  return fmu_p(rank, places) + rank;
}

static inline int fmu_velocities(int rank, int places) {
  return fmu_displacements(rank, places) + 3 * places;
}

static inline int fmu_energies(int rank, int places) {
  return fmu_velocities(rank, places) + 3 * places;
}

static inline int fmu_rates(int rank, int places) {
  return fmu_energies(rank, places) + 2;
}

static inline int fmu_variables(int rank, int places) {
  return fmu_rates(rank, places) + 2 * rank;
}

/* Coefficients of degree 3 and 4, and all doubles behind the head. */
static inline size_t fmu_coefficients_count(int rank) {
  const size_t n = (size_t)rank;
  return n * (n + 1) * (n + 2) / 6 + n * (n + 1) / 2 * (n + 2) / 3 * (n + 3) / 4;
}

static inline size_t fmu_numbers_count(int rank, int places) {
  return 4 + (5 + 3 * (size_t)places) * (size_t)rank + fmu_coefficients_count(rank);
}

/* Where an instance is in its life; a set of them says where a call is allowed. */
enum fmu_phase {
  FMU_INSTANTIATED = 1,
  FMU_SET_UP = 2, /* of FMI 2: and the experiment is known */
  FMU_INITIALIZING = 4,
  FMU_EVENT = 8,
  FMU_CONTINUOUS = 16,
  FMU_STEPPING = 32,
  FMU_STEP_FAILED = 64,
  FMU_TERMINATED = 128,
  FMU_ERROR = 256
};

typedef enum fmu_result { FMU_OK, FMU_DISCARD, FMU_REFUSED } fmu_result;

typedef struct fmu_body {
  fmu_head head;
  int rank, places;
  double *numbers; /* behind the head; owned, as all that follow */
  const double *omega2, *axis_mass, *rows, *coefficients;
  unsigned char *follows;
  double *scaled_omega2, *scaled_coefficients; /* times the stiffness */
  body_numbers scaled;
  double *values; /* those that are set, and the end of the experiment behind them */
  double *force, *load, *tangent, *kept, *seeds, *memory;
  double strain; /* and force: at q, where `fresh` */
  bool fresh, tangent_fresh;
  int phase;
  bool exchange;     /* model exchange, not co-simulation */
  char message[300]; /* the last refusal, one line */
} fmu_body;

/* Reads `folder`/body.bin, whose token must be the one given. NULL: `message` (300) says why. */
fmu_body *fmu_body_make(const char *folder, const char *token, char *message);
void fmu_body_free(fmu_body *body);

/* The values of the start. */
void fmu_body_reset(fmu_body *body);

/* false where the phase is none of `phases`: the message then names the call. */
bool fmu_body_allows(fmu_body *body, int phases, const char *call);

/* Writes the message, and returns `result`. */
fmu_result fmu_body_refuse(fmu_body *body, fmu_result result, const char *format, ...);

/* Value references and values, `count` of each. A set is refused before anything is changed. */
fmu_result fmu_body_get(fmu_body *body, const unsigned *references, size_t count, double *values);
fmu_result fmu_body_set(fmu_body *body, const unsigned *references, size_t count,
                        const double *values);

/* Lays the interval of the experiment down. */
fmu_result fmu_body_experiment(fmu_body *body, double start, bool stops, double stop);

/* For model exchange, whose importer steps. */
fmu_result fmu_body_set_time(fmu_body *body, double time);

/* From `from`, which must be the instance's time, over `length`, in equal steps of `step` at most.
 * FMU_DISCARD: they could not be solved, and the state is as before. */
fmu_result fmu_body_step(fmu_body *body, double from, double length);

/* q and p one behind the other (2 rank), and their derivatives by time. */
const double *fmu_body_states(const fmu_body *body);
fmu_result fmu_body_set_states(fmu_body *body, const double *states);
void fmu_body_rates(fmu_body *body, double *rates);

/* The derivatives of `unknowns` along `seed` of `knowns`, and their transpose. */
fmu_result fmu_body_derivative(fmu_body *body, const unsigned *unknowns, size_t unknown_count,
                               const unsigned *knowns, size_t known_count, const double *seed,
                               double *out);
fmu_result fmu_body_adjoint(fmu_body *body, const unsigned *unknowns, size_t unknown_count,
                            const unsigned *knowns, size_t known_count, const double *seed,
                            double *out);

/* The whole state as bytes, which another instance of the same FMU takes. */
size_t fmu_body_bytes(const fmu_body *body);
void fmu_body_write(const fmu_body *body, void *bytes);
fmu_result fmu_body_check(fmu_body *body, const void *bytes, size_t size);
void fmu_body_read(fmu_body *body, const void *bytes); /* that passed the check */

#endif
