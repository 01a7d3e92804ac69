/* Statuses and error details shared by every part of Thrum.
 *
 * One list drives the enum and the texts: 0 is done, > 0 is done but notable, the smaller the more
 * so, and < 0 is failed.
 * A failed call leaves its outputs as they were.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STATUS_H
#define THRUM_STATUS_H

#include "thrum/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, value, text) */
#define THRUM_STATUS_LIST(X)                                                                       \
  X(OK, 0, "done")                                                                                 \
  X(ENERGY_GREW, 1, "done, but the energy grew beyond what start and loads explain")               \
  X(FELL_BACK, 2, "done, but a step needed a fallback beyond quasi-Newton")                        \
  X(SWITCHED, 3, "done, but by a scheme that the integrator has switched to")                      \
  X(INVALID_ARGUMENT, -1, "an argument is out of its range")                                       \
  X(UNINITIALISED_DEF, -2, "the definition was not made by its default function")                  \
  X(BUFFER_TOO_SMALL, -3, "the caller's buffer is too small")                                      \
  X(MISALIGNED, -4, "the caller's buffer is not aligned to 64 bytes")                              \
  X(OUT_OF_MEMORY, -5, "memory could not be allocated")                                            \
  X(IO, -6, "a file could not be read or written")                                                 \
  X(BAD_FORMAT, -7, "the data is not in the expected format")                                      \
  X(UNSUPPORTED, -8, "the request is understood but not supported")                                \
  X(BAD_CHECKSUM, -9, "the data does not match its checksum")                                      \
  X(MISSING, -10, "a required part is missing")                                                    \
  X(BAD_SHAPE, -11, "an array has the wrong type or shape")                                        \
  X(BAD_VALUE, -12, "a value is not finite or out of its range")                                   \
  X(NOT_CONVERGED, -13, "an iteration did not converge")                                           \
  X(NOT_FINITE, -14, "the step would leave the range of finite numbers")                           \
  X(MODEL_MISMATCH, -15, "the state belongs to another model")                                     \
  X(SINGULAR, -16, "a matrix is singular or not positive definite")                                \
  X(INTERRUPTED, -17, "the caller asked to stop")

typedef enum thrum_status {
#define X(name, value, text) THRUM_##name = value,
  THRUM_STATUS_LIST(X)
#undef X
} thrum_status;

/* Detail of a failure. Owned by the caller; every function that takes one accepts NULL.
 * `message` is one line for a person: what is wrong, where, and what to do. `field` is for
 * programs: the member of a def, or the option, that is wrong; static text, NULL where it is no
 * single one. */
typedef struct thrum_error {
  thrum_status status;
  char message[400];
  const char *field;
} thrum_error;

/* Fixed text of a status, never NULL; static storage. Any thread. */
THRUM_API const char *thrum_status_text(thrum_status status);

/* Fills `error` (if not NULL) with a printf-style line and returns `status`, so that a failure is
 * `return thrum_error_set(error, THRUM_IO, "...")`. Control characters and marks that turn
 * the direction of a text become '?'. Never allocates. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
THRUM_API thrum_status
thrum_error_set(thrum_error *error, thrum_status status, const char *format, ...);

/* The same of a failure that one field is to blame for: the line begins with its name, and the
 * format goes on: " is %g; it must be ..." or ": ...". thrum_error_set says that no field is. */
#if defined(__GNUC__)
__attribute__((format(printf, 4, 5)))
#endif
THRUM_API thrum_status
thrum_error_set_field(thrum_error *error, const char *field, thrum_status status,
                      const char *format, ...);

/* The message without the name of its field and the ": " or blank behind it. Any thread. */
THRUM_API const char *thrum_error_reason(const thrum_error *error);

/* Returns from the caller when `call` fails: one line for a call whose failure the caller passes
 * on unchanged. A status above 0 is notable but not failed, so the caller goes on. A function that
 * has something to free keeps its status in a variable and goes on with THRUM_THEN. */
#define THRUM_TRY(call)                                                                            \
  do {                                                                                             \
    const thrum_status try_status_ = (call);                                                       \
    if (try_status_ < 0)                                                                           \
      return try_status_;                                                                          \
  } while (0)

/* The next call of a chain that ends with something to free: skipped when a call before it failed,
 * and `status` is what it returned otherwise. */
#define THRUM_THEN(status, call)                                                                   \
  do {                                                                                             \
    if ((status) >= 0)                                                                             \
      (status) = (call);                                                                           \
  } while (0)

#ifdef __cplusplus
}
#endif
#endif
