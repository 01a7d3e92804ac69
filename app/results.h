/* The folder of results of an experiment: tables, a description of where they were measured, and
 * the page that validation/report.py makes of them. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_RESULTS_H
#define THRUM_APP_RESULTS_H

#include <cjson/cJSON.h>

#include "io/file.h"
#include "thrum/status.h"

/* Opens `name` in the folder for writing; thrum_file_writer_commit puts it in place. */
thrum_status results_open(const char *folder, const char *name, thrum_file_writer *writer,
                          thrum_error *error);

/* Writes an object as one line to `name` in the folder, and deletes it. */
thrum_status results_write_json(const char *folder, const char *name, cJSON *object,
                                thrum_error *error);

/* Adds where the figures are measured: the processor, the compiler and the BLAS kernels. */
void results_add_machine(cJSON *object);

/* Runs report.py for the table TABLE.csv of this kind. Without Python the tables stand alone, and a
 * warning says how to make the page. */
void results_make_page(const char *folder, const char *kind, const char *table);

#endif
