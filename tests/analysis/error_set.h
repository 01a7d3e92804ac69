/* Shows gcc -fanalyzer what thrum_error_set returns: the status that it is given.
 * Without this every function that refuses by it seems to succeed. Included before each source.
 * SPDX-License-Identifier: Apache-2.0 */
#include "thrum/status.h"

#define thrum_error_set(error, status, ...)                                                        \
  ((thrum_error_set)(error, status, __VA_ARGS__), (status))
