/* Status texts and error details; see thrum/status.h. SPDX-License-Identifier: Apache-2.0 */
#include "thrum/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/base/plain_text.h"
#include "thrum/version.h"

const char *thrum_version(void) {
  return THRUM_VERSION_STRING;
}

const char *thrum_status_text(thrum_status status) {
  switch (status) {
#define X(name, value, text)                                                                       \
  case THRUM_##name:                                                                               \
    return text;
    THRUM_STATUS_LIST(X)
#undef X
  }
  return "unknown status";
}

static thrum_status fill(thrum_error *error, const char *field, thrum_status status,
                         const char *format, va_list arguments) {
  if (error == NULL)
    return status;
  const size_t room = sizeof error->message;
  size_t used = 0;
  error->status = status;
  error->field = field;

  // the line begins with the name of the field
  if (field != NULL) {
    used = (size_t)snprintf(error->message, room, "%s", field);
    used = used < room ? used : room - 1;
  }
  vsnprintf(error->message + used, room - used, format, arguments);

  // names from files and command lines may hold line ends and what directs a terminal
  thrum_plain_text(error->message);
  return status;
}

const char *thrum_error_reason(const thrum_error *error) {
  const char *behind = error->message + (error->field != NULL ? strlen(error->field) : 0);
  return error->field != NULL ? behind + strspn(behind, ": ") : behind;
}

thrum_status thrum_error_set(thrum_error *error, thrum_status status, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fill(error, NULL, status, format, arguments);
  va_end(arguments);
  return status;
}

thrum_status thrum_error_set_field(thrum_error *error, const char *field, thrum_status status,
                                   const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fill(error, field, status, format, arguments);
  va_end(arguments);
  return status;
}
