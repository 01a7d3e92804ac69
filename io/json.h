/* Writing JSON with cJSON: numbers with all their digits, texts that are always UTF-8.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_JSON_H
#define THRUM_IO_JSON_H

#include <cjson/cJSON.h>
#include <stdint.h>

/* Adds a number with all its digits to a cJSON object; null when it is not finite. */
void json_number(cJSON *object, const char *key, double value);
/* The number alone, for an array. */
cJSON *json_number_item(double value);
/* Adds an array of numbers, the same way. */
void json_numbers(cJSON *object, const char *key, const double *values, int64_t count);
/* Adds a text; bytes that are no UTF-8, as a file's name may hold, become '?'. */
void json_string(cJSON *object, const char *key, const char *text);
void json_strings(cJSON *object, const char *key, const char *const *texts, int64_t count);
/* What the report of a command begins with: "program", "version", "command" and "status". */
cJSON *json_report(const char *command, const char *status);
/* Prints the object on one line on standard output and deletes it. */
void json_print(cJSON *object);

/* Full-precision, compact text of an object (malloc, caller frees), for files and meta. */
char *json_text(const cJSON *object);

#endif
