/* A model as a Python file of plain array code: the text of array_code.py, whose marks @NAME@ are
 * replaced. SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/array_code.h"

#include <stdio.h>
#include <string.h>

#include "io/file.h"
#include "io/npz.h"
#include "io/paths.h"

/* The bytes of array_code.py, by cmake/text_as_c.cmake. */
static const unsigned char code[] = {
#include "array_code.inc"
};

static const struct {
  const char *name, *import;
} libraries[] = {
    [ARRAY_NUMPY] = {"numpy", "import numpy as xp"},
    [ARRAY_TORCH] = {"torch", "import torch as xp"},
    [ARRAY_JAX] = {"jax", "import jax\njax.config.update(\"jax_enable_x64\", True)\n"
                          "import jax.numpy as xp"},
};

thrum_status array_code_coefficients(const char *path, char *coefficients, size_t size,
                                     thrum_error *error) {
  const size_t length = strlen(path);
  if (length < 4 || strcmp(path + length - 3, ".py") != 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.200s' is no name for Python code: let it end with .py", path);

  // the code has the name between quotes
  const char *name = path_basename(path);
  if (strpbrk(name, "\"\\\n\r") != NULL)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.200s' cannot stand in Python code: leave quotes and backslashes out",
                           name);
  if ((size_t)snprintf(coefficients, size, "%.*s_coefficients.npz", (int)(length - 3), path) >=
      size)
    return thrum_error_set(error, THRUM_BAD_VALUE, "'%.200s' is too long", path);
  return THRUM_OK;
}

thrum_status array_code_check(const thrum_model *model, thrum_error *error) {
  if (model->point_count > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "the energy of this model is summed over %lld cubature points, and array "
        "code is made of a polynomial: precompute it without --cubature and "
        "another law",
        (long long)model->point_count);
  if (model->slave_count > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "%lld coordinates of this model follow the others at rest, and array code "
        "steps all: export the model that it was condensed from",
        (long long)model->slave_count);
  return THRUM_OK;
}

/* Writes the text up to its next mark, or to its end; returns what follows the mark, NULL at the
 * end. mark: which one it is. */
static const char *write_to_mark(thrum_file_writer *writer, const char *text, const char *end,
                                 char mark[16], thrum_status *status, thrum_error *error) {
  const char *at = memchr(text, '@', (size_t)(end - text));
  const char *last = at ? memchr(at + 1, '@', (size_t)(end - at - 1)) : NULL;
  // matrix products have the sign as well: a mark is a word of capitals
  while (at && last && strspn(at + 1, "ABCDEFGHIJKLMNOPQRSTUVWXYZ") != (size_t)(last - at - 1)) {
    at = last;
    last = memchr(at + 1, '@', (size_t)(end - at - 1));
  }
  const char *stop = at && last ? at : end;
  THRUM_THEN(*status, thrum_file_writer_put(writer, text, (size_t)(stop - text), error));
  if (stop == end)
    return NULL;
  snprintf(mark, 16, "%.*s", (int)(last - at - 1), at + 1);
  return last + 1;
}

static thrum_status write_code(thrum_file_writer *writer, array_library library,
                               const char *coefficients, thrum_error *error) {
  const struct {
    const char *mark, *text;
  } texts[] = {{"NPZ", path_basename(coefficients)},
               {"BACKEND", libraries[library].name},
               {"IMPORT", libraries[library].import}};

  // the text between marks as it is, and what stands for each
  thrum_status status = THRUM_OK;
  char mark[16];
  const char *at = (const char *)code, *const end = at + sizeof code;
  while ((at = write_to_mark(writer, at, end, mark, &status, error)) != NULL && status >= 0)
    for (size_t n = 0; n < sizeof texts / sizeof *texts; n++)
      if (strcmp(mark, texts[n].mark) == 0)
        status = thrum_file_writer_put(writer, texts[n].text, strlen(texts[n].text), error);
  return status;
}

thrum_status array_code_write(const char *path, array_library library, const thrum_model *model,
                              thrum_error *error) {
  char coefficients[4200];
  THRUM_TRY(array_code_check(model, error));
  THRUM_TRY(array_code_coefficients(path, coefficients, sizeof coefficients, error));
  THRUM_TRY(thrum_model_save(coefficients, model, error));

  thrum_file_writer writer = {0};
  thrum_status status = thrum_file_writer_open(path, &writer, error);
  THRUM_THEN(status, write_code(&writer, library, coefficients, error));
  status = thrum_file_writer_end(&writer, status, error);

  // the numbers are of no use without the code
  if (status < 0)
    remove(coefficients);
  return status;
}
