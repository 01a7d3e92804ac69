/* Writes JSON with cJSON: numbers have all their digits, and texts are always UTF-8.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_JSON_H
#define THRUM_IO_JSON_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

/* From now on failures of cJSON's allocations are noted: cJSON leaves out what it has no memory
 * for, so after a failure json_text returns NULL, and the program must not end as if it were done.
 * A setting of the process, for programs; before any other use of cJSON. */
void json_watch_memory(void);
/* Whether any of those allocations has failed since. */
bool json_memory_failed(void);

/* Adds a number with all its digits to a cJSON object; null when it is not finite. */
void json_number(cJSON *object, const char *key, double value);
/* A number of an object, as it was added here or read from a file; NaN where it is null or is not
 * there. */
double json_number_of(const cJSON *object, const char *key);
/* The same of an item, which may be NULL. */
double json_value(const cJSON *item);
/* Such a text; NULL where there is none. */
const char *json_text_of(const cJSON *object, const char *key);
/* Makes the item of a number, for an array. */
cJSON *json_number_item(double value);
/* Adds an array of numbers, the same way. */
void json_numbers(cJSON *object, const char *key, const double *values, int64_t count);
/* Adds an object and returns it; null, and NULL is returned, where `present` says that there is
 * none. */
cJSON *json_section(cJSON *object, const char *key, bool present);
/* Adds a text, null where it is NULL; json_text makes '?' of bytes that are no UTF-8, as a file's
 * name may hold. */
void json_string(cJSON *object, const char *key, const char *text);
void json_add_string(cJSON *array, const char *text);
void json_strings(cJSON *object, const char *key, const char *const *texts, int64_t count);
/* Appends an object to an array and returns it. */
cJSON *json_add_row(cJSON *array);
/* Moves all items of an array, which may be NULL, to the end of another. */
void json_append(cJSON *to, cJSON *from);
/* Begins the report of a command with "program", "version", "command" and "status". */
cJSON *json_report(const char *command, const char *status);
/* Prints the object on one line on standard output and deletes it; without memory for the text
 * nothing is printed, and json_memory_failed says so. */
void json_print(cJSON *object);

/* Returns the compact text of an object with all digits, for files and metadata; the caller frees
 * it. NULL without memory for the text, or where some was missing for any object before. */
char *json_text(const cJSON *object);

/* Reads a file as JSON into *object, which the caller deletes; NULL where it is no JSON. */
thrum_status json_file_read(const char *path, cJSON **object, thrum_error *error);

/* Reads what json_text wrote, with its numbers as json_number adds them: the text of what comes
 * back is that text. The caller deletes it; NULL where it is no JSON, or without memory. */
cJSON *json_read_back(const char *text, size_t length);

#endif
