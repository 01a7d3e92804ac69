/* A reduced body as an FMU: see fmu_body.h. The step is that of body_code.h, which conserves the
 * energy, with forces held over it; it is halved where it cannot be solved.
 *
 *   q' = p,   p' = sum rows^T F - axis_mass^T a - R(q) - (alpha + beta omega^2) p
 *
 * Cost of a step: a few passes over the coefficients and as many solutions of rank equations.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/fmu/fmu_body.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RANK_MOST 512
#define PLACES_MOST 100000
#define ITERATIONS 20 /* of Newton's method in a step */
#define HALVINGS 8    /* of a step that they do not solve */

static bool is_finite(double x) {
  return x - x == 0.0;
}

static int kept_count(const fmu_body *body) {
  return fmu_displacements(body->rank, body->places);
}

/* --- made and freed -------------------------------------------------------------------------- */

/* The head and the numbers of an open file; false where it is no such file. */
static bool read_numbers(FILE *file, fmu_body *body) {
  fmu_head *head = &body->head;
  if (fread(head, sizeof *head, 1, file) != 1 || memcmp(head->magic, FMU_MAGIC, 8) != 0 ||
      head->rank < 1 || head->rank > RANK_MOST || head->places < 0 || head->places > PLACES_MOST)
    return false;
  body->rank = head->rank;
  body->places = head->places;
  const size_t count = fmu_numbers_count(body->rank, body->places);
  body->numbers = malloc(count * sizeof *body->numbers);
  if (body->numbers == NULL || fread(body->numbers, sizeof *body->numbers, count, file) != count ||
      fgetc(file) != EOF)
    return false;
  for (size_t n = 0; n < count; n++)
    if (!is_finite(body->numbers[n]))
      return false;

  // one behind the other
  const size_t n = (size_t)body->rank;
  body->omega2 = body->numbers + 4;
  body->axis_mass = body->omega2 + n;
  body->rows = body->axis_mass + 3 * n;
  body->coefficients = body->rows + 3 * n * (size_t)body->places + n;
  return true;
}

/* What an instance works on; false where there is no memory. */
static bool make_arrays(fmu_body *body) {
  const size_t n = (size_t)body->rank, number = sizeof(double);
  const size_t coefficients = fmu_coefficients_count(body->rank);
  body->follows = malloc(n);
  body->scaled_omega2 = malloc(n * number);
  body->scaled_coefficients = malloc(coefficients * number);
  body->values = malloc(((size_t)kept_count(body) + 1) * number);
  body->force = malloc(n * number);
  body->load = malloc(n * number);
  body->tangent = malloc(n * n * number);
  body->kept = malloc(2 * n * number);
  body->seeds = malloc(3 * n * number);
  body->memory = malloc((size_t)BODY_MEMORY(body->rank) * number);
  if (!body->follows || !body->scaled_omega2 || !body->scaled_coefficients || !body->values ||
      !body->force || !body->load || !body->tangent || !body->kept || !body->seeds || !body->memory)
    return false;

  const double *follows = body->coefficients - n;
  for (size_t i = 0; i < n; i++)
    body->follows[i] = follows[i] != 0.0;
  body->scaled =
      (body_numbers){body->rank, body->scaled_omega2, body->scaled_coefficients, body->follows};
  return true;
}

fmu_body *fmu_body_make(const char *folder, const char *token, char *message) {
  char path[4200];
  const size_t length = strlen(folder);
  const bool ends = length > 0 && folder[length - 1] == '/';
  snprintf(path, sizeof path, "%s%sbody.bin", folder, ends ? "" : "/");
  FILE *file = fopen(path, "rb");
  if (file == NULL) {
    snprintf(message, 300, "%.200s cannot be read: unpack the FMU with its resources", path);
    return NULL;
  }

  fmu_body *body = calloc(1, sizeof *body);
  const bool right = body != NULL && read_numbers(file, body);
  fclose(file);
  if (!right)
    snprintf(message, 300, "%.200s holds no body, or there is no memory for it", path);
  else if (token == NULL || strncmp(body->head.token, token, FMU_TOKEN) != 0)
    snprintf(message, 300, "the token is not that of this FMU: take it from its modelDescription");
  else if (!make_arrays(body))
    snprintf(message, 300, "there is no memory for a body of rank %d", body->rank);
  else {
    fmu_body_reset(body);
    return body;
  }
  fmu_body_free(body);
  return NULL;
}

void fmu_body_free(fmu_body *body) {
  if (body == NULL)
    return;
  double *const arrays[] = {body->numbers, body->scaled_omega2, body->scaled_coefficients,
                            body->values,  body->force,         body->load,
                            body->tangent, body->kept,          body->seeds,
                            body->memory};
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++)
    free(arrays[n]);
  free(body->follows);
  free(body);
}

static void forget(fmu_body *body) {
  body->fresh = body->tangent_fresh = false;
}

/* The polynomial with the stiffness that is set. */
static void scale(fmu_body *body) {
  const double by = body->values[FMU_STIFFNESS];
  const size_t count = fmu_coefficients_count(body->rank);
  for (int i = 0; i < body->rank; i++)
    body->scaled_omega2[i] = by * body->omega2[i];
  for (size_t n = 0; n < count; n++)
    body->scaled_coefficients[n] = by * body->coefficients[n];
  forget(body);
}

void fmu_body_reset(fmu_body *body) {
  const int kept = kept_count(body);
  for (int n = 0; n < kept; n++)
    body->values[n] = 0.0;
  memcpy(body->values + FMU_ALPHA, body->numbers, 4 * sizeof *body->numbers);
  body->values[kept] = INFINITY;
  body->phase = FMU_INSTANTIATED;
  scale(body);
}

fmu_result fmu_body_refuse(fmu_body *body, fmu_result result, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(body->message, sizeof body->message, format, arguments);
  va_end(arguments);
  return result;
}

static const char *phase_name(int phase) {
  switch (phase) {
  case FMU_INSTANTIATED:
  case FMU_SET_UP:
    return "instantiated";
  case FMU_INITIALIZING:
    return "being initialized";
  case FMU_EVENT:
    return "in event mode";
  case FMU_CONTINUOUS:
    return "in continuous-time mode";
  case FMU_STEPPING:
    return "in step mode";
  case FMU_STEP_FAILED:
    return "after a step that failed";
  case FMU_TERMINATED:
    return "terminated";
  default:
    return "in error";
  }
}

bool fmu_body_allows(fmu_body *body, int phases, const char *call) {
  if (body->phase & phases)
    return true;
  fmu_body_refuse(body, FMU_REFUSED, "%s is not allowed while the instance is %s", call,
                  phase_name(body->phase));
  body->phase = FMU_ERROR;
  return false;
}

/* --- variables ------------------------------------------------------------------------------- */

static const double *q_of(const fmu_body *body) {
  return body->values + fmu_q(body->places);
}

static const double *p_of(const fmu_body *body) {
  return q_of(body) + body->rank;
}

/* Strain energy and force at q. */
static void evaluate(fmu_body *body) {
  if (!body->fresh)
    body->strain = body_force(&body->scaled, q_of(body), body->force, body->memory);
  body->fresh = true;
}

static void evaluate_tangent(fmu_body *body) {
  if (!body->tangent_fresh)
    body_tangent(&body->scaled, q_of(body), body->tangent, body->memory);
  body->tangent_fresh = true;
}

/* The load of forces at the places and of an acceleration of the ground, one behind the other. */
static void load_of(const fmu_body *body, const double *acceleration, const double *forces,
                    double *load) {
  const double back[3] = {-acceleration[0], -acceleration[1], -acceleration[2]};
  memset(load, 0, (size_t)body->rank * sizeof *load);
  body_pull(&body->scaled, body->axis_mass, back, load);
  for (int k = 0; k < body->places; k++)
    body_pull(&body->scaled, body->rows + 3 * (size_t)body->rank * (size_t)k, forces + 3 * k, load);
}

static double damping_of(const fmu_body *body, int i) {
  return body->values[FMU_ALPHA] + body->values[FMU_BETA] * body->scaled_omega2[i];
}

void fmu_body_rates(fmu_body *body, double *rates) {
  const double *p = p_of(body);
  evaluate(body);
  load_of(body, body->values + FMU_ACCELERATION, body->values + FMU_FORCES, body->load);
  for (int i = 0; i < body->rank; i++) {
    rates[i] = p[i];
    rates[body->rank + i] = body->load[i] - body->force[i] - damping_of(body, i) * p[i];
  }
}

static double row_dot(const fmu_body *body, int row, const double *x) {
  return body_dot(body->rank, body->rows + (size_t)body->rank * (size_t)row, x);
}

static double value_of(fmu_body *body, int reference) {
  const int n = body->rank, places = body->places;
  const int velocities = fmu_velocities(n, places), energies = fmu_energies(n, places);
  if (reference < kept_count(body))
    return body->values[reference];
  if (reference < velocities)
    return row_dot(body, reference - kept_count(body), q_of(body));
  if (reference < energies)
    return row_dot(body, reference - velocities, p_of(body));
  if (reference == energies + 1)
    return 0.5 * body_dot(n, p_of(body), p_of(body));
  if (reference == energies) {
    evaluate(body);
    return body->strain;
  }
  fmu_body_rates(body, body->kept);
  return body->kept[reference - energies - 2];
}

/* Are all of them variables? */
static bool are_known(fmu_body *body, const unsigned *references, size_t count) {
  const unsigned most = (unsigned)fmu_variables(body->rank, body->places);
  for (size_t n = 0; n < count; n++)
    if (references[n] >= most) {
      fmu_body_refuse(body, FMU_REFUSED, "there is no variable %u: the last one is %u",
                      references[n], most - 1);
      return false;
    }
  return true;
}

fmu_result fmu_body_get(fmu_body *body, const unsigned *references, size_t count, double *values) {
  if (!are_known(body, references, count))
    return FMU_REFUSED;
  for (size_t n = 0; n < count; n++)
    values[n] = value_of(body, (int)references[n]);
  return FMU_OK;
}

/* May it be set now? Parameters that are tunable and inputs may always, the others at the start. */
static bool may_set(const fmu_body *body, unsigned reference) {
  const int q = fmu_q(body->places);
  if (reference == FMU_TIME || (int)reference >= kept_count(body))
    return false;
  if (body->phase & (FMU_INSTANTIATED | FMU_SET_UP | FMU_INITIALIZING))
    return true;
  if (body->phase == FMU_CONTINUOUS && reference < FMU_ACCELERATION)
    return false;
  return reference != FMU_STEP && (int)reference < q;
}

/* Is the value in the range of the variable? */
static bool is_in_range(unsigned reference, double value) {
  if (!is_finite(value))
    return false;
  if (reference == FMU_ALPHA || reference == FMU_BETA)
    return value >= 0.0;
  return (reference != FMU_STIFFNESS && reference != FMU_STEP) || value > 0.0;
}

fmu_result fmu_body_set(fmu_body *body, const unsigned *references, size_t count,
                        const double *values) {
  if (!are_known(body, references, count))
    return FMU_REFUSED;
  for (size_t n = 0; n < count; n++)
    if (!may_set(body, references[n]))
      return fmu_body_refuse(body, FMU_REFUSED,
                             "variable %u cannot be set while the instance is %s", references[n],
                             phase_name(body->phase));
  for (size_t n = 0; n < count; n++)
    if (!is_in_range(references[n], values[n]))
      return fmu_body_refuse(body, FMU_DISCARD, "variable %u cannot be %g", references[n],
                             values[n]);

  const double stiffness = body->values[FMU_STIFFNESS];
  for (size_t n = 0; n < count; n++)
    body->values[references[n]] = values[n];
  forget(body);
  if (body->values[FMU_STIFFNESS] != stiffness)
    scale(body);
  return FMU_OK;
}

const double *fmu_body_states(const fmu_body *body) {
  return q_of(body);
}

fmu_result fmu_body_set_states(fmu_body *body, const double *states) {
  for (int i = 0; i < 2 * body->rank; i++)
    if (!is_finite(states[i]))
      return fmu_body_refuse(body, FMU_DISCARD, "state %d cannot be %g", i, states[i]);
  memcpy(body->values + fmu_q(body->places), states, 2 * (size_t)body->rank * sizeof *states);
  forget(body);
  return FMU_OK;
}

/* --- time ------------------------------------------------------------------------------------ */

fmu_result fmu_body_experiment(fmu_body *body, double start, bool stops, double stop) {
  if (!is_finite(start) || (stops && !(stop > start)))
    return fmu_body_refuse(body, FMU_REFUSED, "the experiment cannot go from %g to %g s", start,
                           stop);
  body->values[FMU_TIME] = start;
  body->values[kept_count(body)] = stops ? stop : INFINITY;
  return FMU_OK;
}

fmu_result fmu_body_set_time(fmu_body *body, double time) {
  if (!is_finite(time))
    return fmu_body_refuse(body, FMU_REFUSED, "the time cannot be %g s", time);
  body->values[FMU_TIME] = time;
  return FMU_OK;
}

/* One step, or two of half its length where it cannot be solved, and so on. */
static bool advance(fmu_body *body, double h, int halvings) {
  double *q = body->values + fmu_q(body->places), *p = q + body->rank;
  if (body_step_energy(&body->scaled, q, p, body->load, h, body->values[FMU_ALPHA],
                       body->values[FMU_BETA], ITERATIONS, body->memory) > 0)
    return true;
  return halvings > 0 && advance(body, 0.5 * h, halvings - 1) &&
         advance(body, 0.5 * h, halvings - 1);
}

fmu_result fmu_body_step(fmu_body *body, double from, double length) {
  const double time = body->values[FMU_TIME], stop = body->values[kept_count(body)];
  if (!(length > 0.0) || !is_finite(length))
    return fmu_body_refuse(body, FMU_REFUSED, "a step of %g s is none: time goes forward", length);
  if (!(fabs(from - time) <= 1e-6 * length + 1e-12 * fabs(time)))
    return fmu_body_refuse(body, FMU_REFUSED,
                           "the step begins at %.9g s, and the body is at %.9g s", from, time);
  if (from + length > stop + 1e-6 * length)
    return fmu_body_refuse(body, FMU_REFUSED, "the step ends at %.9g s, past the end at %.9g s",
                           from + length, stop);
  const double pieces = ceil(length / body->values[FMU_STEP] * (1.0 - 1e-9));
  if (!(pieces < 1e9))
    return fmu_body_refuse(body, FMU_REFUSED, "%g s are too many steps of %g s", length,
                           body->values[FMU_STEP]);

  // the state as it was, for a step that fails
  const size_t states = 2 * (size_t)body->rank * sizeof *body->kept;
  memcpy(body->kept, q_of(body), states);
  load_of(body, body->values + FMU_ACCELERATION, body->values + FMU_FORCES, body->load);
  const long count = pieces < 1.0 ? 1 : (long)pieces;
  for (long n = 0; n < count; n++)
    if (!advance(body, length / (double)count, HALVINGS)) {
      memcpy(body->values + fmu_q(body->places), body->kept, states);
      forget(body);
      return fmu_body_refuse(body, FMU_DISCARD,
                             "the step from %.9g s could not be solved: take shorter ones, or less "
                             "force",
                             time);
    }
  body->values[FMU_TIME] = from + length;
  forget(body);
  return FMU_OK;
}

/* --- derivatives ----------------------------------------------------------------------------- */

/* The direction: of q, of p and of the load in `seeds`, of the parameters in `by`. */
static void gather_seeds(fmu_body *body, const unsigned *knowns, size_t count, const double *seed,
                         double by[FMU_FORCES]) {
  const int n = body->rank, q = fmu_q(body->places);
  double *load = body->seeds + 2 * n;
  memset(body->seeds, 0, 3 * (size_t)n * sizeof *body->seeds);
  memset(by, 0, FMU_FORCES * sizeof *by);
  for (size_t k = 0; k < count; k++) {
    const int at = (int)knowns[k];
    const double *row = body->rows + (size_t)n * (size_t)(at - FMU_FORCES);
    if (at < FMU_FORCES)
      by[at] += seed[k];
    else if (at >= q)
      body->seeds[at - q] += seed[k];
    for (int i = 0; at >= FMU_FORCES && at < q && i < n; i++)
      load[i] += row[i] * seed[k];
  }

  // the ground pulls the other way
  for (int axis = 0; axis < 3; axis++)
    for (int i = 0; i < n; i++)
      load[i] -= body->axis_mass[axis * n + i] * by[FMU_ACCELERATION + axis];
}

/* The derivative of one unknown along the direction. */
static double derivative_of(const fmu_body *body, int unknown, const double by[FMU_FORCES]) {
  const int n = body->rank, places = body->places, first = kept_count(body);
  const double *dq = body->seeds, *dp = dq + n, *df = dp + n, *p = p_of(body);
  const double stiffness = body->values[FMU_STIFFNESS];
  if (unknown < fmu_velocities(n, places))
    return row_dot(body, unknown - first, dq);
  if (unknown < fmu_energies(n, places))
    return row_dot(body, unknown - fmu_velocities(n, places), dp);
  if (unknown == fmu_energies(n, places))
    return body_dot(n, body->force, dq) + body->strain / stiffness * by[FMU_STIFFNESS];
  if (unknown == fmu_energies(n, places) + 1)
    return body_dot(n, p, dp);

  // the derivatives of q and of p by time
  const int i = unknown - fmu_rates(n, places);
  if (i < n)
    return dp[i];
  const int j = i - n;
  const double of_damping = by[FMU_ALPHA] + by[FMU_BETA] * body->scaled_omega2[j] +
                            by[FMU_STIFFNESS] * body->values[FMU_BETA] * body->omega2[j];
  return df[j] - body_dot(n, body->tangent + (size_t)n * (size_t)j, dq) -
         damping_of(body, j) * dp[j] - of_damping * p[j] -
         by[FMU_STIFFNESS] * body->force[j] / stiffness;
}

/* Refuses what is no variable, knowns that follow from others, and unknowns that are given. */
static bool may_derive(fmu_body *body, const unsigned *unknowns, size_t unknown_count,
                       const unsigned *knowns, size_t known_count) {
  if (!are_known(body, unknowns, unknown_count) || !are_known(body, knowns, known_count))
    return false;
  const unsigned first = (unsigned)kept_count(body);
  for (size_t n = 0; n < unknown_count; n++)
    if (unknowns[n] < first) {
      fmu_body_refuse(body, FMU_REFUSED, "variable %u is given, and no unknown", unknowns[n]);
      return false;
    }
  for (size_t n = 0; n < known_count; n++)
    if (knowns[n] >= first) {
      fmu_body_refuse(body, FMU_REFUSED, "variable %u follows from others, and is no known",
                      knowns[n]);
      return false;
    }
  evaluate(body);
  evaluate_tangent(body);
  return true;
}

fmu_result fmu_body_derivative(fmu_body *body, const unsigned *unknowns, size_t unknown_count,
                               const unsigned *knowns, size_t known_count, const double *seed,
                               double *out) {
  double by[FMU_FORCES];
  if (!may_derive(body, unknowns, unknown_count, knowns, known_count))
    return FMU_REFUSED;
  gather_seeds(body, knowns, known_count, seed, by);
  for (size_t n = 0; n < unknown_count; n++)
    out[n] = derivative_of(body, (int)unknowns[n], by);
  return FMU_OK;
}

fmu_result fmu_body_adjoint(fmu_body *body, const unsigned *unknowns, size_t unknown_count,
                            const unsigned *knowns, size_t known_count, const double *seed,
                            double *out) {
  double by[FMU_FORCES];
  if (!may_derive(body, unknowns, unknown_count, knowns, known_count))
    return FMU_REFUSED;
  for (size_t k = 0; k < known_count; k++) {
    const double one = 1.0;
    gather_seeds(body, knowns + k, 1, &one, by);
    out[k] = 0.0;
    for (size_t n = 0; n < unknown_count; n++)
      out[k] += seed[n] * derivative_of(body, (int)unknowns[n], by);
  }
  return FMU_OK;
}

/* --- the state as bytes ---------------------------------------------------------------------- */

typedef struct state_head {
  char token[FMU_TOKEN]; /* of the FMU */
  int32_t phase, exchange;
} state_head;

static size_t values_size(const fmu_body *body) {
  return ((size_t)kept_count(body) + 1) * sizeof *body->values;
}

size_t fmu_body_bytes(const fmu_body *body) {
  return sizeof(state_head) + values_size(body);
}

void fmu_body_write(const fmu_body *body, void *bytes) {
  state_head head = {.phase = body->phase, .exchange = body->exchange};
  memcpy(head.token, body->head.token, FMU_TOKEN);
  memcpy(bytes, &head, sizeof head);
  memcpy((char *)bytes + sizeof head, body->values, values_size(body));
}

fmu_result fmu_body_check(fmu_body *body, const void *bytes, size_t size) {
  state_head head;
  if (size != fmu_body_bytes(body))
    return fmu_body_refuse(body, FMU_REFUSED, "a state has %zu bytes, not %zu",
                           fmu_body_bytes(body), size);
  memcpy(&head, bytes, sizeof head);
  if (memcmp(head.token, body->head.token, FMU_TOKEN) != 0)
    return fmu_body_refuse(body, FMU_REFUSED, "these bytes are no state of this FMU");
  if (head.phase < FMU_INSTANTIATED || head.phase > FMU_ERROR ||
      (head.phase & (head.phase - 1)) != 0 || head.exchange != (int32_t)body->exchange)
    return fmu_body_refuse(body, FMU_REFUSED, "these bytes are no state of an instance as this is");

  // each value as it could have been set
  const int kept = kept_count(body);
  for (int n = 0; n <= kept; n++) {
    double value;
    memcpy(&value, (const char *)bytes + sizeof head + (size_t)n * sizeof value, sizeof value);
    if (n == kept ? value != value : !is_in_range((unsigned)n, value))
      return fmu_body_refuse(body, FMU_REFUSED, "value %d of the state cannot be %g", n, value);
  }
  return FMU_OK;
}

void fmu_body_read(fmu_body *body, const void *bytes) {
  state_head head;
  memcpy(&head, bytes, sizeof head);
  memcpy(body->values, (const char *)bytes + sizeof head, values_size(body));
  body->phase = head.phase;
  scale(body);
}
