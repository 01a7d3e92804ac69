/* A model as one C header without heap, for controllers (docs/exchange.md).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef DRIVER_EXPORT_BODY_HEADER_H
#define DRIVER_EXPORT_BODY_HEADER_H

#include "thrum/model.h"
#include "thrum/status.h"

#define BODY_NAME_MAX 64 /* bytes of a name in C code, its end included */

/* The name that begins all names in the code of NAME.h, where `ending` is ".h". THRUM_BAD_VALUE for
 * another ending, and for what is no name in C. */
thrum_status body_header_name(const char *path, const char *ending, char name[BODY_NAME_MAX],
                              thrum_error *error);

/* The cubic and quartic coefficients in the order of body_code.h, into *coefficients (malloc, the
 * caller frees); returns how many in *count. The model has passed array_code_check. */
thrum_status body_coefficients(const thrum_model *model, double **coefficients, size_t *count,
                               thrum_error *error);

/* follows[i] (rank), 1: coordinate i follows the square of a much softer one, and energy steps do
 * not match its frequency (design 7). */
void body_follows(const thrum_model *model, unsigned char *follows);

/* Rows (3 x rank) of the mean displacement of `count` vertices. The model has a basis. */
void body_place(const thrum_model *model, const int32_t *vertices, int64_t count, double *rows);

/* Writes the header. Refuses what array_code_check refuses. */
thrum_status body_header_write(const char *path, const thrum_model *model, thrum_error *error);

#endif
