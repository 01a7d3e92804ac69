/* Status texts and error details; see thrum/status.h. SPDX-License-Identifier: Apache-2.0 */
#include "thrum/status.h"

#include <stdarg.h>
#include <stdio.h>

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

thrum_status thrum_error_set(thrum_error *error, thrum_status status, const char *format, ...) {
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    error->status = status;
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    // names from files and command lines may hold line ends and what directs a terminal
    thrum_plain_text(error->message);
  }
  return status;
}
