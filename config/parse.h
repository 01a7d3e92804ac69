/* Numbers out of texts, whatever the locale. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_PARSE_H
#define THRUM_CONFIG_PARSE_H

#include <stdbool.h>
#include <stdint.h>

/* Parse the whole of `text`, independent of the locale; false (value untouched) when it is not one
 * finite number, integer, or comma-separated vector. */
bool config_parse_number(const char *text, double *value);
bool config_parse_integer(const char *text, int64_t *value);
bool config_parse_vector3(const char *text, double value[3]);

#endif
