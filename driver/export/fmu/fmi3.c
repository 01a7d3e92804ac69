/* The functions of FMI 3.0 for co-simulation and model exchange, over fmu_body.h. Declared as the
 * standard has them: Functional Mock-up Interface 3.0.1, https://fmi-standard.org. A call that the
 * standard does not allow at its place is refused with one line to the logger, and the instance is
 * in error until it is reset. There are no events, clocks, structural parameters or variables that
 * are not Float64. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/export/fmu/fmu_body.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

/* Declares a function and begins its definition. The names of a static library have a prefix. */
#if defined(FMI3_FUNCTION_PREFIX) && !defined(FMI3_OVERRIDE_FUNCTION_PREFIX)
#define PASTE_NAMES(prefix, name) prefix##name
#define PASTE(prefix, name) PASTE_NAMES(prefix, name)
#define NAME(name) PASTE(FMI3_FUNCTION_PREFIX, fmi3##name)
#else
#define NAME(name) fmi3##name
#endif
#define FUNCTION(type, name, ...)                                                                  \
  EXPORT type NAME(name)(__VA_ARGS__);                                                             \
  EXPORT type NAME(name)(__VA_ARGS__)

typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } fmi3_status;
typedef uint32_t fmi3_reference;
typedef const char *fmi3_string;
typedef const uint8_t *fmi3_binary;
typedef void (*fmi3_log)(void *environment, fmi3_status status, fmi3_string category,
                         fmi3_string message);
typedef void (*fmi3_callback)(void); /* one that is never called */

typedef struct instance {
  fmu_body *body;
  void *environment;
  fmi3_log log;
} instance;

/* --- messages -------------------------------------------------------------------------------- */

static void say(fmi3_log log, void *environment, fmi3_status status, const char *message) {
  if (log != NULL)
    log(environment, status, status == STATUS_DISCARD ? "logStatusDiscard" : "logStatusError",
        message);
}

static fmi3_status refuse(instance *m) {
  m->body->phase = FMU_ERROR;
  say(m->log, m->environment, STATUS_ERROR, m->body->message);
  return STATUS_ERROR;
}

static fmi3_status status_of(instance *m, fmu_result result) {
  if (result == FMU_REFUSED)
    return refuse(m);
  if (result == FMU_DISCARD)
    say(m->log, m->environment, STATUS_DISCARD, m->body->message);
  return result == FMU_DISCARD ? STATUS_DISCARD : STATUS_OK;
}

static fmi3_status refuse_with(instance *m, const char *message) {
  fmu_body_refuse(m->body, FMU_REFUSED, "%s", message);
  return refuse(m);
}

/* Goes on where the instance is in one of these phases. */
#define ALLOW(m, phases, call)                                                                     \
  do {                                                                                             \
    if ((m) == NULL)                                                                               \
      return STATUS_ERROR;                                                                         \
    if (!fmu_body_allows((m)->body, (phases), (call)))                                             \
      return refuse(m);                                                                            \
  } while (0)

/* And where it is one of this kind. */
#define ALLOW_KIND(m, of_exchange, phases, call)                                                   \
  do {                                                                                             \
    ALLOW(m, phases, call);                                                                        \
    if ((m)->body->exchange != (of_exchange))                                                      \
      return refuse_with(m, (of_exchange) ? call " is for model exchange"                          \
                                          : call " is for co-simulation");                         \
  } while (0)

enum {
  AFTER = FMU_TERMINATED | FMU_ERROR,
  RUNNING = FMU_EVENT | FMU_CONTINUOUS | FMU_STEPPING,
  READABLE = FMU_INITIALIZING | RUNNING | AFTER,
  SETTABLE = FMU_INSTANTIATED | FMU_INITIALIZING | RUNNING,
  ANY = FMU_INSTANTIATED | READABLE
};

/* --- life ------------------------------------------------------------------------------------ */

FUNCTION(const char *, GetVersion, void) {
  return "3.0";
}

static instance *instance_make(fmi3_string name, fmi3_string token, fmi3_string resources,
                               bool exchange, void *environment, fmi3_log log) {
  char message[300] = "there is no memory for an instance";
  if (name == NULL || *name == '\0' || resources == NULL) {
    say(log, environment, STATUS_ERROR, "an instance needs a name and the path of its resources");
    return NULL;
  }
  instance *m = calloc(1, sizeof *m);
  if (m != NULL && (m->body = fmu_body_make(resources, token, message)) != NULL) {
    m->environment = environment;
    m->log = log;
    m->body->exchange = exchange;
    return m;
  }
  say(log, environment, STATUS_ERROR, message);
  free(m);
  return NULL;
}

FUNCTION(void *, InstantiateModelExchange, fmi3_string name, fmi3_string token,
         fmi3_string resources, bool visible, bool logging, void *environment, fmi3_log log) {
  (void)visible;
  (void)logging; // what is logged are refusals alone
  return instance_make(name, token, resources, true, environment, log);
}

FUNCTION(void *, InstantiateCoSimulation, fmi3_string name, fmi3_string token,
         fmi3_string resources, bool visible, bool logging, bool events, bool early_return,
         const fmi3_reference required[], size_t required_count, void *environment, fmi3_log log,
         fmi3_callback update) {
  (void)visible;
  (void)logging;
  (void)early_return;
  (void)required;
  (void)update;
  if (!events && required_count == 0)
    return instance_make(name, token, resources, false, environment, log);
  say(log, environment, STATUS_ERROR, "this FMU has neither an event mode nor intermediate values");
  return NULL;
}

FUNCTION(void *, InstantiateScheduledExecution, fmi3_string name, fmi3_string token,
         fmi3_string resources, bool visible, bool logging, void *environment, fmi3_log log,
         fmi3_callback update, fmi3_callback lock, fmi3_callback unlock) {
  (void)name;
  (void)token;
  (void)resources;
  (void)visible;
  (void)logging;
  (void)update;
  (void)lock;
  (void)unlock;
  say(log, environment, STATUS_ERROR, "this FMU has no scheduled execution");
  return NULL;
}

FUNCTION(void, FreeInstance, instance *m) {
  if (m == NULL)
    return;
  fmu_body_free(m->body);
  free(m);
}

FUNCTION(fmi3_status, SetDebugLogging, instance *m, bool on, size_t count,
         const fmi3_string categories[]) {
  (void)on;
  (void)count;
  (void)categories;
  ALLOW(m, ANY, "fmi3SetDebugLogging");
  return STATUS_OK;
}

FUNCTION(fmi3_status, EnterInitializationMode, instance *m, bool tolerant, double tolerance,
         double start, bool stops, double stop) {
  (void)tolerant;
  (void)tolerance; // steps are solved to rounding
  ALLOW(m, FMU_INSTANTIATED, "fmi3EnterInitializationMode");
  const fmu_result result = fmu_body_experiment(m->body, start, stops, stop);
  if (result == FMU_OK)
    m->body->phase = FMU_INITIALIZING;
  return status_of(m, result);
}

FUNCTION(fmi3_status, ExitInitializationMode, instance *m) {
  ALLOW(m, FMU_INITIALIZING, "fmi3ExitInitializationMode");
  m->body->phase = m->body->exchange ? FMU_EVENT : FMU_STEPPING;
  return STATUS_OK;
}

FUNCTION(fmi3_status, Terminate, instance *m) {
  ALLOW(m, RUNNING, "fmi3Terminate");
  m->body->phase = FMU_TERMINATED;
  return STATUS_OK;
}

FUNCTION(fmi3_status, Reset, instance *m) {
  ALLOW(m, ANY, "fmi3Reset");
  fmu_body_reset(m->body);
  return STATUS_OK;
}

/* --- variables ------------------------------------------------------------------------------- */

FUNCTION(fmi3_status, GetFloat64, instance *m, const fmi3_reference references[], size_t count,
         double values[], size_t value_count) {
  ALLOW(m, READABLE, "fmi3GetFloat64");
  if (value_count != count)
    return refuse_with(m, "fmi3GetFloat64: each variable has one value");
  return status_of(m, fmu_body_get(m->body, references, count, values));
}

FUNCTION(fmi3_status, SetFloat64, instance *m, const fmi3_reference references[], size_t count,
         const double values[], size_t value_count) {
  ALLOW(m, SETTABLE, "fmi3SetFloat64");
  if (value_count != count)
    return refuse_with(m, "fmi3SetFloat64: each variable has one value");
  return status_of(m, fmu_body_set(m->body, references, count, values));
}

/* Of another type there are no variables. */
static fmi3_status none_of(instance *m, int phases, size_t count, const char *call) {
  ALLOW(m, phases, call);
  return count == 0 ? STATUS_OK : refuse_with(m, "all variables of this FMU are Float64");
}

#define OTHER_TYPE(Type, type)                                                                     \
  FUNCTION(fmi3_status, Get##Type, instance *m, const fmi3_reference references[], size_t count,   \
           type values[], size_t value_count) {                                                    \
    (void)references;                                                                              \
    (void)values;                                                                                  \
    return none_of(m, READABLE, count + value_count, "fmi3Get" #Type);                             \
  }                                                                                                \
  FUNCTION(fmi3_status, Set##Type, instance *m, const fmi3_reference references[], size_t count,   \
           const type values[], size_t value_count) {                                              \
    (void)references;                                                                              \
    (void)values;                                                                                  \
    return none_of(m, SETTABLE, count + value_count, "fmi3Set" #Type);                             \
  }

OTHER_TYPE(Float32, float)
OTHER_TYPE(Int8, int8_t)
OTHER_TYPE(UInt8, uint8_t)
OTHER_TYPE(Int16, int16_t)
OTHER_TYPE(UInt16, uint16_t)
OTHER_TYPE(Int32, int32_t)
OTHER_TYPE(UInt32, uint32_t)
OTHER_TYPE(Int64, int64_t)
OTHER_TYPE(UInt64, uint64_t)
OTHER_TYPE(Boolean, bool)
OTHER_TYPE(String, fmi3_string)

FUNCTION(fmi3_status, GetBinary, instance *m, const fmi3_reference references[], size_t count,
         size_t sizes[], fmi3_binary values[], size_t value_count) {
  (void)references;
  (void)sizes;
  (void)values;
  return none_of(m, READABLE, count + value_count, "fmi3GetBinary");
}

FUNCTION(fmi3_status, SetBinary, instance *m, const fmi3_reference references[], size_t count,
         const size_t sizes[], const fmi3_binary values[], size_t value_count) {
  (void)references;
  (void)sizes;
  (void)values;
  return none_of(m, SETTABLE, count + value_count, "fmi3SetBinary");
}

/* --- clocks and structural parameters: there are none ------------------------------------------
 */

FUNCTION(fmi3_status, GetClock, instance *m, const fmi3_reference clocks[], size_t count,
         bool values[]) {
  (void)clocks;
  (void)values;
  return none_of(m, READABLE, count, "fmi3GetClock");
}

FUNCTION(fmi3_status, SetClock, instance *m, const fmi3_reference clocks[], size_t count,
         const bool values[]) {
  (void)clocks;
  (void)values;
  return none_of(m, RUNNING, count, "fmi3SetClock");
}

FUNCTION(fmi3_status, GetIntervalDecimal, instance *m, const fmi3_reference clocks[], size_t count,
         double intervals[], int qualifiers[]) {
  (void)clocks;
  (void)intervals;
  (void)qualifiers;
  return none_of(m, ANY, count, "fmi3GetIntervalDecimal");
}

FUNCTION(fmi3_status, GetIntervalFraction, instance *m, const fmi3_reference clocks[], size_t count,
         uint64_t counters[], uint64_t resolutions[], int qualifiers[]) {
  (void)clocks;
  (void)counters;
  (void)resolutions;
  (void)qualifiers;
  return none_of(m, ANY, count, "fmi3GetIntervalFraction");
}

FUNCTION(fmi3_status, GetShiftDecimal, instance *m, const fmi3_reference clocks[], size_t count,
         double shifts[]) {
  (void)clocks;
  (void)shifts;
  return none_of(m, ANY, count, "fmi3GetShiftDecimal");
}

FUNCTION(fmi3_status, GetShiftFraction, instance *m, const fmi3_reference clocks[], size_t count,
         uint64_t counters[], uint64_t resolutions[]) {
  (void)clocks;
  (void)counters;
  (void)resolutions;
  return none_of(m, ANY, count, "fmi3GetShiftFraction");
}

FUNCTION(fmi3_status, SetIntervalDecimal, instance *m, const fmi3_reference clocks[], size_t count,
         const double intervals[]) {
  (void)clocks;
  (void)intervals;
  return none_of(m, ANY, count, "fmi3SetIntervalDecimal");
}

FUNCTION(fmi3_status, SetIntervalFraction, instance *m, const fmi3_reference clocks[], size_t count,
         const uint64_t counters[], const uint64_t resolutions[]) {
  (void)clocks;
  (void)counters;
  (void)resolutions;
  return none_of(m, ANY, count, "fmi3SetIntervalFraction");
}

FUNCTION(fmi3_status, SetShiftDecimal, instance *m, const fmi3_reference clocks[], size_t count,
         const double shifts[]) {
  (void)clocks;
  (void)shifts;
  return none_of(m, ANY, count, "fmi3SetShiftDecimal");
}

FUNCTION(fmi3_status, SetShiftFraction, instance *m, const fmi3_reference clocks[], size_t count,
         const uint64_t counters[], const uint64_t resolutions[]) {
  (void)clocks;
  (void)counters;
  (void)resolutions;
  return none_of(m, ANY, count, "fmi3SetShiftFraction");
}

FUNCTION(fmi3_status, EnterConfigurationMode, instance *m) {
  return m == NULL
             ? STATUS_ERROR
             : refuse_with(m, "fmi3EnterConfigurationMode: a body has no structural parameters");
}

FUNCTION(fmi3_status, ExitConfigurationMode, instance *m) {
  return m == NULL
             ? STATUS_ERROR
             : refuse_with(m, "fmi3ExitConfigurationMode: a body has no structural parameters");
}

FUNCTION(fmi3_status, ActivateModelPartition, instance *m, fmi3_reference clock, double time) {
  (void)clock;
  (void)time;
  return m == NULL ? STATUS_ERROR
                   : refuse_with(m, "fmi3ActivateModelPartition: a body has no partitions");
}

FUNCTION(fmi3_status, EvaluateDiscreteStates, instance *m) {
  return m == NULL ? STATUS_ERROR
                   : refuse_with(m, "fmi3EvaluateDiscreteStates: a body has no discrete states");
}

FUNCTION(fmi3_status, GetNumberOfVariableDependencies, instance *m, fmi3_reference reference,
         size_t *count) {
  (void)reference;
  (void)count;
  return m == NULL
             ? STATUS_ERROR
             : refuse_with(m,
                           "fmi3GetNumberOfVariableDependencies: they are in the modelDescription");
}

FUNCTION(fmi3_status, GetVariableDependencies, instance *m, fmi3_reference reference,
         size_t elements[], fmi3_reference independents[], size_t independent_elements[],
         int kinds[], size_t count) {
  (void)reference;
  (void)elements;
  (void)independents;
  (void)independent_elements;
  (void)kinds;
  (void)count;
  return m == NULL
             ? STATUS_ERROR
             : refuse_with(m, "fmi3GetVariableDependencies: they are in the modelDescription");
}

/* --- the whole state ------------------------------------------------------------------------- */

FUNCTION(fmi3_status, GetFMUState, instance *m, void **state) {
  ALLOW(m, ANY, "fmi3GetFMUState");
  if (*state == NULL)
    *state = malloc(fmu_body_bytes(m->body));
  if (*state == NULL)
    return refuse_with(m, "there is no memory for a state");
  fmu_body_write(m->body, *state);
  return STATUS_OK;
}

FUNCTION(fmi3_status, SetFMUState, instance *m, void *state) {
  ALLOW(m, ANY, "fmi3SetFMUState");
  if (state == NULL)
    return refuse_with(m, "fmi3SetFMUState needs a state");
  const fmu_result result = fmu_body_check(m->body, state, fmu_body_bytes(m->body));
  if (result == FMU_OK)
    fmu_body_read(m->body, state);
  return status_of(m, result);
}

FUNCTION(fmi3_status, FreeFMUState, instance *m, void **state) {
  ALLOW(m, ANY, "fmi3FreeFMUState");
  if (state != NULL) {
    free(*state);
    *state = NULL;
  }
  return STATUS_OK;
}

FUNCTION(fmi3_status, SerializedFMUStateSize, instance *m, void *state, size_t *size) {
  ALLOW(m, ANY, "fmi3SerializedFMUStateSize");
  if (state == NULL)
    return refuse_with(m, "fmi3SerializedFMUStateSize needs a state");
  *size = fmu_body_bytes(m->body);
  return STATUS_OK;
}

FUNCTION(fmi3_status, SerializeFMUState, instance *m, void *state, uint8_t bytes[], size_t size) {
  ALLOW(m, ANY, "fmi3SerializeFMUState");
  if (state == NULL || size < fmu_body_bytes(m->body))
    return refuse_with(m, "fmi3SerializeFMUState needs a state, and room for its bytes");
  memcpy(bytes, state, fmu_body_bytes(m->body));
  return STATUS_OK;
}

FUNCTION(fmi3_status, DeserializeFMUState, instance *m, const uint8_t bytes[], size_t size,
         void **state) {
  ALLOW(m, ANY, "fmi3DeserializeFMUState");
  const fmu_result result = fmu_body_check(m->body, bytes, size);
  if (result != FMU_OK)
    return status_of(m, result);
  if (*state == NULL)
    *state = malloc(size);
  if (*state == NULL)
    return refuse_with(m, "there is no memory for a state");
  memcpy(*state, bytes, size);
  return STATUS_OK;
}

/* --- derivatives ----------------------------------------------------------------------------- */

FUNCTION(fmi3_status, GetDirectionalDerivative, instance *m, const fmi3_reference unknowns[],
         size_t unknown_count, const fmi3_reference knowns[], size_t known_count,
         const double seed[], size_t seed_count, double out[], size_t out_count) {
  ALLOW(m, READABLE, "fmi3GetDirectionalDerivative");
  if (seed_count != known_count || out_count != unknown_count)
    return refuse_with(m, "fmi3GetDirectionalDerivative: each variable has one value");
  return status_of(
      m, fmu_body_derivative(m->body, unknowns, unknown_count, knowns, known_count, seed, out));
}

FUNCTION(fmi3_status, GetAdjointDerivative, instance *m, const fmi3_reference unknowns[],
         size_t unknown_count, const fmi3_reference knowns[], size_t known_count,
         const double seed[], size_t seed_count, double out[], size_t out_count) {
  ALLOW(m, READABLE, "fmi3GetAdjointDerivative");
  if (seed_count != unknown_count || out_count != known_count)
    return refuse_with(m, "fmi3GetAdjointDerivative: each variable has one value");
  return status_of(
      m, fmu_body_adjoint(m->body, unknowns, unknown_count, knowns, known_count, seed, out));
}

/* --- co-simulation --------------------------------------------------------------------------- */

FUNCTION(fmi3_status, EnterStepMode, instance *m) {
  return m == NULL ? STATUS_ERROR : refuse_with(m, "fmi3EnterStepMode: a body has no event mode");
}

FUNCTION(fmi3_status, GetOutputDerivatives, instance *m, const fmi3_reference references[],
         size_t count, const int32_t orders[], double values[], size_t value_count) {
  (void)references;
  (void)orders;
  (void)values;
  ALLOW_KIND(m, false, FMU_STEPPING | AFTER, "fmi3GetOutputDerivatives");
  return count + value_count == 0 ? STATUS_OK
                                  : refuse_with(m, "no derivatives of outputs by time are given");
}

FUNCTION(fmi3_status, DoStep, instance *m, double from, double length, bool no_state,
         bool *event_needed, bool *terminate, bool *early_return, double *last_time) {
  (void)no_state;
  ALLOW_KIND(m, false, FMU_STEPPING, "fmi3DoStep");
  const fmu_result result = fmu_body_step(m->body, from, length);
  *event_needed = *terminate = *early_return = false;
  *last_time = m->body->values[FMU_TIME];
  return status_of(m, result);
}

/* --- model exchange -------------------------------------------------------------------------- */

FUNCTION(fmi3_status, EnterEventMode, instance *m) {
  ALLOW_KIND(m, true, FMU_CONTINUOUS, "fmi3EnterEventMode");
  m->body->phase = FMU_EVENT;
  return STATUS_OK;
}

FUNCTION(fmi3_status, UpdateDiscreteStates, instance *m, bool *again, bool *terminate,
         bool *nominals_changed, bool *states_changed, bool *next_time_defined, double *next_time) {
  ALLOW_KIND(m, true, FMU_EVENT, "fmi3UpdateDiscreteStates");
  *again = *terminate = *nominals_changed = *states_changed = *next_time_defined = false;
  *next_time = 0.0;
  return STATUS_OK;
}

FUNCTION(fmi3_status, EnterContinuousTimeMode, instance *m) {
  ALLOW_KIND(m, true, FMU_EVENT, "fmi3EnterContinuousTimeMode");
  m->body->phase = FMU_CONTINUOUS;
  return STATUS_OK;
}

FUNCTION(fmi3_status, CompletedIntegratorStep, instance *m, bool no_state, bool *enter_event_mode,
         bool *terminate) {
  (void)no_state;
  ALLOW_KIND(m, true, FMU_CONTINUOUS, "fmi3CompletedIntegratorStep");
  *enter_event_mode = *terminate = false;
  return STATUS_OK;
}

FUNCTION(fmi3_status, SetTime, instance *m, double time) {
  ALLOW_KIND(m, true, FMU_EVENT | FMU_CONTINUOUS, "fmi3SetTime");
  return status_of(m, fmu_body_set_time(m->body, time));
}

FUNCTION(fmi3_status, SetContinuousStates, instance *m, const double states[], size_t count) {
  ALLOW_KIND(m, true, FMU_CONTINUOUS, "fmi3SetContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi3SetContinuousStates: there are not so many states");
  return status_of(m, fmu_body_set_states(m->body, states));
}

FUNCTION(fmi3_status, GetContinuousStateDerivatives, instance *m, double rates[], size_t count) {
  ALLOW_KIND(m, true, READABLE, "fmi3GetContinuousStateDerivatives");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi3GetContinuousStateDerivatives: there are not so many states");
  fmu_body_rates(m->body, rates);
  return STATUS_OK;
}

FUNCTION(fmi3_status, GetEventIndicators, instance *m, double indicators[], size_t count) {
  (void)indicators;
  ALLOW_KIND(m, true, READABLE, "fmi3GetEventIndicators");
  return count == 0 ? STATUS_OK : refuse_with(m, "a body has no event indicators");
}

FUNCTION(fmi3_status, GetContinuousStates, instance *m, double states[], size_t count) {
  ALLOW_KIND(m, true, READABLE, "fmi3GetContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi3GetContinuousStates: there are not so many states");
  memcpy(states, fmu_body_states(m->body), count * sizeof *states);
  return STATUS_OK;
}

FUNCTION(fmi3_status, GetNominalsOfContinuousStates, instance *m, double nominals[], size_t count) {
  ALLOW_KIND(m, true, READABLE, "fmi3GetNominalsOfContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi3GetNominalsOfContinuousStates: there are not so many states");
  for (size_t n = 0; n < count; n++)
    nominals[n] = 1.0;
  return STATUS_OK;
}

FUNCTION(fmi3_status, GetNumberOfEventIndicators, instance *m, size_t *count) {
  ALLOW_KIND(m, true, ANY, "fmi3GetNumberOfEventIndicators");
  *count = 0;
  return STATUS_OK;
}

FUNCTION(fmi3_status, GetNumberOfContinuousStates, instance *m, size_t *count) {
  ALLOW_KIND(m, true, ANY, "fmi3GetNumberOfContinuousStates");
  *count = 2 * (size_t)m->body->rank;
  return STATUS_OK;
}
