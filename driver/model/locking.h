/* By how much the elements of a model lock, as its file says.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_LOCKING_H
#define THRUM_DRIVER_MODEL_LOCKING_H

#include <cjson/cJSON.h>

#include "thrum/model.h"

#define LOCKING_TOLD 0.01 /* error of a frequency beyond which it is told */
#define LOCKING_TEXT_MAX 128

/* The largest of the errors, 0 where there is none. */
double locking_most(const double *errors, int64_t count);

/* "71, 110, 55 %", or "0.5 %" of one; returns `text`. */
const char *locking_text(const double *errors, int64_t count, char text[LOCKING_TEXT_MAX]);

/* Warns where linear tetrahedra have the first frequencies of the body more than 1 % too high.
 * `kept` says why they stay, or is "". */
void locking_warn_of(const char *name, const double *errors, int64_t count, const char *kept);

/* The same of ten-node tetrahedra, which a finer mesh mends. */
void locking_warn_of_ten(const char *name, const double *errors, int64_t count);

/* The same of hexahedra and wedges, whose frequencies may be too low as well. */
void locking_warn_of_solids(const char *name, const double *errors, int64_t count);

/* The same of a model, by its metadata. Where they do not know it that is said of ten-node
 * tetrahedra of a Poisson's ratio of LOCKING_POISSON or more. */
#define LOCKING_POISSON 0.45
void locking_warn(const char *name, const thrum_model *model);

/* Writes what is known of the elements of a model in a line, "ten nodes, by --order auto; with four
 * ..."; "": nothing beyond their order. */
#define LOCKING_LINE_MAX 480
const char *locking_line(const thrum_model *model, char line[LOCKING_LINE_MAX]);

/* Adds the order of a model's elements, and what its metadata say of it: who chose it, and the
 * errors of linear and of ten-node tetrahedra and of other elements; null where they do not know
 * it. */
void locking_json(cJSON *object, const thrum_model *model);

#endif
