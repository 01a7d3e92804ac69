/* The functions of FMI 2.0 for co-simulation and model exchange, over fmu_body.h. Declared as the
 * standard has them: Functional Mock-up Interface 2.0.4, https://fmi-standard.org. A call that the
 * standard does not allow at its place is refused with one line to the logger, and the instance is
 * in error until it is reset. SPDX-License-Identifier: Apache-2.0 */
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
#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define PASTE_NAMES(prefix, name) prefix##name
#define PASTE(prefix, name) PASTE_NAMES(prefix, name)
#define NAME(name) PASTE(FMI2_FUNCTION_PREFIX, fmi2##name)
#else
#define NAME(name) fmi2##name
#endif
#define FUNCTION(type, name, ...)                                                                  \
  EXPORT type NAME(name)(__VA_ARGS__);                                                             \
  EXPORT type NAME(name)(__VA_ARGS__)

typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } fmi2_status;
typedef enum { MODEL_EXCHANGE, CO_SIMULATION } fmi2_type;
typedef enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, IS_TERMINATED } fmi2_kind;
typedef int fmi2_boolean;
typedef unsigned fmi2_reference;
typedef const char *fmi2_string;

typedef struct fmi2_callbacks {
  void (*logger)(void *environment, fmi2_string instance, fmi2_status status, fmi2_string category,
                 fmi2_string message, ...);
  void *(*allocate)(size_t count, size_t size);
  void (*free)(void *memory);
  void (*step_finished)(void *environment, fmi2_status status);
  void *environment;
} fmi2_callbacks;

typedef struct fmi2_event_info {
  fmi2_boolean again, terminate, nominals_changed, states_changed, next_time_defined;
  double next_time;
} fmi2_event_info;

typedef struct instance {
  fmu_body *body;
  const fmi2_callbacks *callbacks;
  char *name;
} instance;

/* --- messages -------------------------------------------------------------------------------- */

static void say(const fmi2_callbacks *callbacks, const char *name, fmi2_status status,
                const char *message) {
  if (callbacks != NULL && callbacks->logger != NULL)
    callbacks->logger(callbacks->environment, name, status,
                      status == STATUS_DISCARD ? "logStatusDiscard" : "logStatusError", "%s",
                      message);
}

static fmi2_status refuse(instance *m) {
  m->body->phase = FMU_ERROR;
  say(m->callbacks, m->name, STATUS_ERROR, m->body->message);
  return STATUS_ERROR;
}

static fmi2_status status_of(instance *m, fmu_result result) {
  if (result == FMU_REFUSED)
    return refuse(m);
  if (result == FMU_DISCARD)
    say(m->callbacks, m->name, STATUS_DISCARD, m->body->message);
  return result == FMU_DISCARD ? STATUS_DISCARD : STATUS_OK;
}

static fmi2_status refuse_with(instance *m, const char *message) {
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

enum {
  BEGUN = FMU_INSTANTIATED | FMU_SET_UP,
  AFTER = FMU_TERMINATED | FMU_ERROR,
  RUNNING = FMU_EVENT | FMU_CONTINUOUS | FMU_STEPPING,
  READABLE = FMU_INITIALIZING | RUNNING | FMU_STEP_FAILED | AFTER,
  ANY = BEGUN | READABLE
};

/* --- life ------------------------------------------------------------------------------------ */

FUNCTION(const char *, GetTypesPlatform, void) {
  return "default";
}

FUNCTION(const char *, GetVersion, void) {
  return "2.0";
}

static int hex_digit(char c) {
  if (c >= '0' && c <= '9')
    return c - '0';
  if (c >= 'a' && c <= 'f')
    return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The folder that a URI of a file names, into `path`; false where it names none, or is too long. */
static bool folder_of(const char *uri, char *path, size_t size) {
  if (uri == NULL || strncmp(uri, "file:", 5) != 0)
    return false;
  uri += 5;
  if (strncmp(uri, "//", 2) == 0)
    uri = strchr(uri + 2, '/');
  for (; uri != NULL && *uri != '\0' && size > 1; size--) {
    const int high = *uri == '%' ? hex_digit(uri[1]) : -1;
    const int low = high < 0 ? -1 : hex_digit(uri[2]);
    *path++ = low < 0 ? *uri : (char)(16 * high + low);
    uri += low < 0 ? 1 : 3;
  }
  *path = '\0';
  return uri != NULL && *uri == '\0';
}

FUNCTION(void *, Instantiate, fmi2_string name, fmi2_type type, fmi2_string guid, fmi2_string uri,
         const fmi2_callbacks *callbacks, fmi2_boolean visible, fmi2_boolean logging) {
  char folder[4200], message[300] = "there is no memory for an instance";
  (void)visible;
  (void)logging; // what is logged are refusals alone
  if (name == NULL || *name == '\0') {
    say(callbacks, "", STATUS_ERROR, "an instance needs a name");
    return NULL;
  }
  if (!folder_of(uri, folder, sizeof folder)) {
    say(callbacks, name, STATUS_ERROR, "the resources are to be named by a URI, file:///FOLDER");
    return NULL;
  }

  instance *m = calloc(1, sizeof *m);
  const size_t size = strlen(name) + 1;
  if (m != NULL && (m->name = malloc(size)) != NULL &&
      (m->body = fmu_body_make(folder, guid, message)) != NULL) {
    memcpy(m->name, name, size);
    m->callbacks = callbacks;
    m->body->exchange = type == MODEL_EXCHANGE;
    return m;
  }
  say(callbacks, name, STATUS_ERROR, message);
  if (m != NULL)
    free(m->name);
  free(m);
  return NULL;
}

FUNCTION(void, FreeInstance, instance *m) {
  if (m == NULL)
    return;
  fmu_body_free(m->body);
  free(m->name);
  free(m);
}

FUNCTION(fmi2_status, SetDebugLogging, instance *m, fmi2_boolean on, size_t count,
         const fmi2_string categories[]) {
  (void)on;
  (void)count;
  (void)categories;
  ALLOW(m, ANY, "fmi2SetDebugLogging");
  return STATUS_OK;
}

FUNCTION(fmi2_status, SetupExperiment, instance *m, fmi2_boolean tolerant, double tolerance,
         double start, fmi2_boolean stops, double stop) {
  (void)tolerant;
  (void)tolerance; // steps are solved to rounding
  ALLOW(m, BEGUN, "fmi2SetupExperiment");
  const fmu_result result = fmu_body_experiment(m->body, start, stops != 0, stop);
  if (result == FMU_OK)
    m->body->phase = FMU_SET_UP;
  return status_of(m, result);
}

FUNCTION(fmi2_status, EnterInitializationMode, instance *m) {
  ALLOW(m, BEGUN, "fmi2EnterInitializationMode");
  if (m->body->phase != FMU_SET_UP)
    return refuse_with(m, "fmi2SetupExperiment comes before fmi2EnterInitializationMode");
  m->body->phase = FMU_INITIALIZING;
  return STATUS_OK;
}

FUNCTION(fmi2_status, ExitInitializationMode, instance *m) {
  ALLOW(m, FMU_INITIALIZING, "fmi2ExitInitializationMode");
  m->body->phase = m->body->exchange ? FMU_EVENT : FMU_STEPPING;
  return STATUS_OK;
}

FUNCTION(fmi2_status, Terminate, instance *m) {
  ALLOW(m, RUNNING | FMU_STEP_FAILED, "fmi2Terminate");
  m->body->phase = FMU_TERMINATED;
  return STATUS_OK;
}

FUNCTION(fmi2_status, Reset, instance *m) {
  ALLOW(m, ANY, "fmi2Reset");
  fmu_body_reset(m->body);
  return STATUS_OK;
}

/* --- variables ------------------------------------------------------------------------------- */

FUNCTION(fmi2_status, GetReal, instance *m, const fmi2_reference references[], size_t count,
         double values[]) {
  ALLOW(m, READABLE, "fmi2GetReal");
  return status_of(m, fmu_body_get(m->body, references, count, values));
}

FUNCTION(fmi2_status, SetReal, instance *m, const fmi2_reference references[], size_t count,
         const double values[]) {
  ALLOW(m, BEGUN | FMU_INITIALIZING | RUNNING, "fmi2SetReal");
  return status_of(m, fmu_body_set(m->body, references, count, values));
}

/* All variables are real: of another type there are none. */
static fmi2_status none_of(instance *m, int phases, size_t count, const char *call) {
  ALLOW(m, phases, call);
  return count == 0 ? STATUS_OK : refuse_with(m, "all variables of this FMU are real numbers");
}

#define OTHER_TYPE(Type, type)                                                                     \
  FUNCTION(fmi2_status, Get##Type, instance *m, const fmi2_reference references[], size_t count,   \
           type values[]) {                                                                        \
    (void)references;                                                                              \
    (void)values;                                                                                  \
    return none_of(m, READABLE, count, "fmi2Get" #Type);                                           \
  }                                                                                                \
  FUNCTION(fmi2_status, Set##Type, instance *m, const fmi2_reference references[], size_t count,   \
           const type values[]) {                                                                  \
    (void)references;                                                                              \
    (void)values;                                                                                  \
    return none_of(m, BEGUN | FMU_INITIALIZING | RUNNING, count, "fmi2Set" #Type);                 \
  }

OTHER_TYPE(Integer, int)
OTHER_TYPE(Boolean, fmi2_boolean)
OTHER_TYPE(String, fmi2_string)

/* --- the whole state ------------------------------------------------------------------------- */

FUNCTION(fmi2_status, GetFMUstate, instance *m, void **state) {
  ALLOW(m, ANY, "fmi2GetFMUstate");
  if (*state == NULL)
    *state = malloc(fmu_body_bytes(m->body));
  if (*state == NULL)
    return refuse_with(m, "there is no memory for a state");
  fmu_body_write(m->body, *state);
  return STATUS_OK;
}

FUNCTION(fmi2_status, SetFMUstate, instance *m, void *state) {
  ALLOW(m, ANY, "fmi2SetFMUstate");
  if (state == NULL)
    return refuse_with(m, "fmi2SetFMUstate needs a state");
  const fmu_result result = fmu_body_check(m->body, state, fmu_body_bytes(m->body));
  if (result == FMU_OK)
    fmu_body_read(m->body, state);
  return status_of(m, result);
}

FUNCTION(fmi2_status, FreeFMUstate, instance *m, void **state) {
  ALLOW(m, ANY, "fmi2FreeFMUstate");
  if (state != NULL) {
    free(*state);
    *state = NULL;
  }
  return STATUS_OK;
}

FUNCTION(fmi2_status, SerializedFMUstateSize, instance *m, void *state, size_t *size) {
  ALLOW(m, ANY, "fmi2SerializedFMUstateSize");
  if (state == NULL)
    return refuse_with(m, "fmi2SerializedFMUstateSize needs a state");
  *size = fmu_body_bytes(m->body);
  return STATUS_OK;
}

FUNCTION(fmi2_status, SerializeFMUstate, instance *m, void *state, char bytes[], size_t size) {
  ALLOW(m, ANY, "fmi2SerializeFMUstate");
  if (state == NULL || size < fmu_body_bytes(m->body))
    return refuse_with(m, "fmi2SerializeFMUstate needs a state, and room for its bytes");
  memcpy(bytes, state, fmu_body_bytes(m->body));
  return STATUS_OK;
}

FUNCTION(fmi2_status, DeSerializeFMUstate, instance *m, const char bytes[], size_t size,
         void **state) {
  ALLOW(m, ANY, "fmi2DeSerializeFMUstate");
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

FUNCTION(fmi2_status, GetDirectionalDerivative, instance *m, const fmi2_reference unknowns[],
         size_t unknown_count, const fmi2_reference knowns[], size_t known_count,
         const double seed[], double out[]) {
  ALLOW(m, READABLE, "fmi2GetDirectionalDerivative");
  return status_of(
      m, fmu_body_derivative(m->body, unknowns, unknown_count, knowns, known_count, seed, out));
}

/* --- co-simulation --------------------------------------------------------------------------- */

/* Goes on where the instance is one of co-simulation. */
#define ALLOW_SLAVE(m, phases, call)                                                               \
  do {                                                                                             \
    ALLOW(m, phases, call);                                                                        \
    if ((m)->body->exchange)                                                                       \
      return refuse_with(m, call " is for co-simulation");                                         \
  } while (0)

FUNCTION(fmi2_status, SetRealInputDerivatives, instance *m, const fmi2_reference references[],
         size_t count, const int orders[], const double values[]) {
  (void)references;
  (void)orders;
  (void)values;
  ALLOW_SLAVE(m, BEGUN | FMU_INITIALIZING | FMU_STEPPING, "fmi2SetRealInputDerivatives");
  return count == 0 ? STATUS_OK : refuse_with(m, "inputs are held over a step, not interpolated");
}

FUNCTION(fmi2_status, GetRealOutputDerivatives, instance *m, const fmi2_reference references[],
         size_t count, const int orders[], double values[]) {
  (void)references;
  (void)orders;
  (void)values;
  ALLOW_SLAVE(m, FMU_STEPPING | FMU_STEP_FAILED | AFTER, "fmi2GetRealOutputDerivatives");
  return count == 0 ? STATUS_OK : refuse_with(m, "no derivatives of outputs by time are given");
}

FUNCTION(fmi2_status, DoStep, instance *m, double from, double length, fmi2_boolean no_state) {
  (void)no_state;
  ALLOW_SLAVE(m, FMU_STEPPING, "fmi2DoStep");
  const fmu_result result = fmu_body_step(m->body, from, length);
  if (result == FMU_DISCARD)
    m->body->phase = FMU_STEP_FAILED;
  return status_of(m, result);
}

FUNCTION(fmi2_status, CancelStep, instance *m) {
  if (m == NULL)
    return STATUS_ERROR;
  return refuse_with(m, "fmi2CancelStep: a step is never in progress, as fmi2DoStep ends it");
}

FUNCTION(fmi2_status, GetRealStatus, instance *m, fmi2_kind kind, double *value) {
  ALLOW_SLAVE(m, FMU_STEPPING | FMU_STEP_FAILED | FMU_TERMINATED, "fmi2GetRealStatus");
  if (kind != LAST_SUCCESSFUL_TIME)
    return STATUS_DISCARD;
  *value = m->body->values[FMU_TIME];
  return STATUS_OK;
}

FUNCTION(fmi2_status, GetBooleanStatus, instance *m, fmi2_kind kind, fmi2_boolean *value) {
  ALLOW_SLAVE(m, FMU_STEPPING | FMU_STEP_FAILED | FMU_TERMINATED, "fmi2GetBooleanStatus");
  if (kind != IS_TERMINATED)
    return STATUS_DISCARD;
  *value = 0;
  return STATUS_OK;
}

/* Of steps that are in progress, and there are none. */
#define NO_STATUS(Type, type)                                                                      \
  FUNCTION(fmi2_status, Get##Type, instance *m, fmi2_kind kind, type *value) {                     \
    (void)kind;                                                                                    \
    (void)value;                                                                                   \
    ALLOW_SLAVE(m, FMU_STEPPING | FMU_STEP_FAILED | FMU_TERMINATED, "fmi2Get" #Type);              \
    return STATUS_DISCARD;                                                                         \
  }

NO_STATUS(Status, fmi2_status)
NO_STATUS(IntegerStatus, int)
NO_STATUS(StringStatus, fmi2_string)

/* --- model exchange -------------------------------------------------------------------------- */

/* Goes on where the instance is one of model exchange. */
#define ALLOW_MODEL(m, phases, call)                                                               \
  do {                                                                                             \
    ALLOW(m, phases, call);                                                                        \
    if (!(m)->body->exchange)                                                                      \
      return refuse_with(m, call " is for model exchange");                                        \
  } while (0)

FUNCTION(fmi2_status, EnterEventMode, instance *m) {
  ALLOW_MODEL(m, FMU_CONTINUOUS, "fmi2EnterEventMode");
  m->body->phase = FMU_EVENT;
  return STATUS_OK;
}

FUNCTION(fmi2_status, NewDiscreteStates, instance *m, fmi2_event_info *info) {
  ALLOW_MODEL(m, FMU_EVENT, "fmi2NewDiscreteStates");
  *info = (fmi2_event_info){0}; // a body has no events
  return STATUS_OK;
}

FUNCTION(fmi2_status, EnterContinuousTimeMode, instance *m) {
  ALLOW_MODEL(m, FMU_EVENT, "fmi2EnterContinuousTimeMode");
  m->body->phase = FMU_CONTINUOUS;
  return STATUS_OK;
}

FUNCTION(fmi2_status, CompletedIntegratorStep, instance *m, fmi2_boolean no_state,
         fmi2_boolean *enter_event_mode, fmi2_boolean *terminate) {
  (void)no_state;
  ALLOW_MODEL(m, FMU_CONTINUOUS, "fmi2CompletedIntegratorStep");
  *enter_event_mode = *terminate = 0;
  return STATUS_OK;
}

FUNCTION(fmi2_status, SetTime, instance *m, double time) {
  ALLOW_MODEL(m, FMU_EVENT | FMU_CONTINUOUS, "fmi2SetTime");
  return status_of(m, fmu_body_set_time(m->body, time));
}

FUNCTION(fmi2_status, SetContinuousStates, instance *m, const double states[], size_t count) {
  ALLOW_MODEL(m, FMU_CONTINUOUS, "fmi2SetContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi2SetContinuousStates: there are not so many states");
  return status_of(m, fmu_body_set_states(m->body, states));
}

FUNCTION(fmi2_status, GetDerivatives, instance *m, double rates[], size_t count) {
  ALLOW_MODEL(m, READABLE, "fmi2GetDerivatives");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi2GetDerivatives: there are not so many states");
  fmu_body_rates(m->body, rates);
  return STATUS_OK;
}

FUNCTION(fmi2_status, GetEventIndicators, instance *m, double indicators[], size_t count) {
  (void)indicators;
  ALLOW_MODEL(m, READABLE, "fmi2GetEventIndicators");
  return count == 0 ? STATUS_OK : refuse_with(m, "a body has no event indicators");
}

FUNCTION(fmi2_status, GetContinuousStates, instance *m, double states[], size_t count) {
  ALLOW_MODEL(m, READABLE, "fmi2GetContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi2GetContinuousStates: there are not so many states");
  memcpy(states, fmu_body_states(m->body), count * sizeof *states);
  return STATUS_OK;
}

FUNCTION(fmi2_status, GetNominalsOfContinuousStates, instance *m, double nominals[], size_t count) {
  ALLOW_MODEL(m, ANY, "fmi2GetNominalsOfContinuousStates");
  if (count != 2 * (size_t)m->body->rank)
    return refuse_with(m, "fmi2GetNominalsOfContinuousStates: there are not so many states");
  for (size_t n = 0; n < count; n++)
    nominals[n] = 1.0;
  return STATUS_OK;
}
