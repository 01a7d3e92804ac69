/* A model as a Python file of plain array code, for NumPy, PyTorch and JAX (docs/exchange.md).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef DRIVER_EXPORT_ARRAY_CODE_H
#define DRIVER_EXPORT_ARRAY_CODE_H

#include "thrum/model.h"
#include "thrum/status.h"

typedef enum array_library { ARRAY_NUMPY, ARRAY_TORCH, ARRAY_JAX } array_library;

/* The path of the coefficients that belong to the code at NAME.py: NAME_coefficients.npz, which is
 * no name that a model has by chance. THRUM_BAD_VALUE for another ending, a name that cannot stand
 * in a string of Python, and where `coefficients` is too short. */
thrum_status array_code_coefficients(const char *path, char *coefficients, size_t size,
                                     thrum_error *error);

/* Refuses what is no polynomial of all its coordinates: cubature points and condensed models. */
thrum_status array_code_check(const thrum_model *model, thrum_error *error);

/* Writes the coefficients as a model file, then the code that reads it from beside itself. */
thrum_status array_code_write(const char *path, array_library library, const thrum_model *model,
                              thrum_error *error);

#endif
