/* Errors that say what of the input they are about (message.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>
#include <stdio.h>

#include "config/message.h"

thrum_status config_error_in(thrum_error *error, thrum_status status, const char *format, ...) {
  if (status >= 0 || error == NULL)
    return status;
  const thrum_error told = *error;
  char words[sizeof told.message];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(words, sizeof words, format, arguments);
  va_end(arguments);
  return thrum_error_set(error, status, "%s: %s", words, told.message);
}

thrum_status config_error_of(thrum_error *error, thrum_status status, const char *field) {
  if (status >= 0 || error == NULL)
    return status;
  const thrum_error told = *error;
  return thrum_error_set_field(error, field, status, ": %s", told.message);
}
