/* The table of a command for people, made from its report: the object that --json prints, so that
 * both say the same. A table is a list of lines, and a line is a text in which braces hold values
 * of the report:
 *
 *   {key}            a text, or a number with its digits; "a.b" is b of the object a, and "a.0" the
 *                    first of the array a; an array is all of them with commas
 *   {key:.6g}        a number as printf has it, or a text as by "-12s"
 *   {}               the item itself, in a line for each item of an array
 *   {key:.3g%}       a share in per cent, with the sign; {key:%} with two digits and no exponent
 *   {key:.3g|-}      the same, and what stands there where there is no value
 *   {key?one|other}  the one text where a condition holds, the other, or none, where it does not
 *   {key#one|other}  the one text where a number is 1: "{n} bod{n#y|ies}"
 *   [...]            left out where a value in it is missing; [[ and ]] are brackets
 *
 * Texts in braces may have braces. A condition is a key that is neither missing nor false, 0 or
 * empty; "key=text", or "key=null" where it is missing; or either of these behind a "!". A value is
 * missing that is null or not there, and a line is left out where one outside of brackets is.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_REPORT_H
#define THRUM_IO_REPORT_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

#define REPORT_LABEL 13      /* width of the labels of runs and equilibria, */
#define REPORT_LABEL_WIDE 18 /* and of models and meshes */

/* The box of a body or a surface. */
#define REPORT_BOX                                                                                 \
  "[[{box_min_m.0:.4g}, {box_max_m.0:.4g}]] x [[{box_min_m.1:.4g}, {box_max_m.1:.4g}]] x "         \
  "[[{box_min_m.2:.4g}, {box_max_m.2:.4g}]] m"

/* A line; one without a text ends a table. */
typedef struct report_line {
  const char *label; /* may have values as well */
  const char *text;
  const char *when; /* a condition; NULL: always */
  const char *each; /* an array, whose items each give a line with their keys first; NULL: none */
  bool once;        /* the label stands in the first of these alone */
} report_line;

/* A row of a table: its label, its text and what else of a line it has, by name. */
#define REPORT_LINE(called, ...)                                                                   \
  { .label = (called), .text = __VA_ARGS__ }

/* Prints the lines, each with its label, `width` wide. more: values that the table has alone, which
 * go before those of the report; NULL: none. */
void report_print(const cJSON *report, const cJSON *more, int width, const report_line *lines);

/* All lines of the first item of an array, then those of the next; none has an array of its own. */
void report_print_each(const cJSON *report, const cJSON *more, const char *each, int width,
                       const report_line *lines);

/* The same of the last lines, or of all: deletes the report and `more`. */
void report_end(cJSON *report, cJSON *more, int width, const report_line *lines);

/* Prints the report on one line where `json`, else its table, and deletes both. */
void report_show(cJSON *report, cJSON *more, bool json, int width, const report_line *lines);

/* The text of one line into `into`, cut to its size; false where a value is missing. */
bool report_text(const cJSON *report, const cJSON *more, const char *text, char *into, size_t size);

#endif
