/* A model as one C header: the text of body_code.h, in which the name of the file stands for
 * "body", and the numbers of the model behind it. SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/body_header.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/export/array_code.h"
#include "io/file.h"
#include "io/number_text.h"
#include "io/paths.h"
#include "platform/allocate.h"
#include "thrum/polynomial.h"

/* The bytes of body_code.h, by cmake/text_as_c.cmake. */
static const unsigned char code[] = {
#include "body_code.inc"
};

thrum_status body_header_name(const char *path, const char *ending, char name[BODY_NAME_MAX],
                              thrum_error *error) {
  const char *base = path_basename(path), *end = base + strlen(base) - strlen(ending);
  if (end <= base || strcmp(end, ending) != 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.200s' is no name for this: let it end with %s", path, ending);

  // the code has it in front of each name
  bool is_name = isalpha((unsigned char)*base) || *base == '_';
  for (const char *at = base; at < end; at++)
    is_name = is_name && (isalnum((unsigned char)*at) || *at == '_');
  if (!is_name || end - base >= BODY_NAME_MAX)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.200s' cannot begin names in C code: let the file have a name of at "
                           "most %d letters, digits and underscores, and no digit first",
                           base, BODY_NAME_MAX - 1);
  snprintf(name, BODY_NAME_MAX, "%.*s", (int)(end - base), base);
  return THRUM_OK;
}

thrum_status body_coefficients(const thrum_model *model, double **coefficients, size_t *count,
                               thrum_error *error) {
  const int64_t n = model->rank, all = thrum_c3_count(n) + thrum_c4_count(n);
  THRUM_TRY(thrum_reserve(coefficients, all, sizeof **coefficients, "the coefficients", error));
  *count = (size_t)all;

  // a row for each d >= c, in it the columns (b, a) of b <= c, the cubic term first
  double *at = *coefficients;
  for (int64_t c = 0; c < n; c++)
    for (int64_t d = n - 1; d >= c; d--)
      for (int64_t b = 0; b <= c; b++) {
        *at++ = model->c3[thrum_c3_index(n, b, c, d)];
        for (int64_t a = 0; a <= b; a++)
          *at++ = model->c4[thrum_c4_index(n, a, b, c, d)];
      }
  return THRUM_OK;
}

void body_follows(const thrum_model *model, unsigned char *follows) {
  const int64_t n = model->rank;
  const double share = 0.15, apart = 3.0; // those of runtime/guard/frequency_matching.c
  memset(follows, 0, (size_t)n);
  for (int64_t j = 0; j < n; j++) {
    const double quartic = model->c4[thrum_c4_index(n, j, j, j, j)];
    for (int64_t s = j + 1; s < n; s++) {
      const double cubic = model->c3[thrum_c3_index(n, j, j, s)];
      if (apart * apart * model->omega2[j] < model->omega2[s] &&
          cubic * cubic > 2.0 * share * model->omega2[s] * (quartic > 0.0 ? quartic : 0.0))
        follows[s] = 1;
    }
  }
}

void body_place(const thrum_model *model, const int32_t *vertices, int64_t count, double *rows) {
  const int64_t n = model->rank;
  memset(rows, 0, (size_t)(3 * n) * sizeof *rows);
  for (int64_t v = 0; v < count; v++)
    for (int64_t i = 0; i < 3 * n; i++)
      rows[i] += model->basis[3 * n * vertices[v] + i] / (double)count;
}

/* What is written, and whether that went well so far. */
typedef struct output {
  thrum_file_writer writer;
  thrum_status status;
  thrum_error *error;
  const char *name;
  char capitals[BODY_NAME_MAX];
} output;

static void put(output *out, const char *text, size_t size) {
  THRUM_THEN(out->status, thrum_file_writer_put(&out->writer, text, size, out->error));
}

/* Text, in which names that begin with body_ or BODY_ begin with the name of the file. */
static void put_code(output *out, const char *text, size_t size) {
  const char *done = text, *const end = text + size;
  for (const char *at = text; at + 5 <= end; at++) {
    const bool small = memcmp(at, "body_", 5) == 0, large = memcmp(at, "BODY_", 5) == 0;
    if ((!small && !large) || (at > text && (isalnum((unsigned char)at[-1]) || at[-1] == '_')))
      continue;
    const char *name = small ? out->name : out->capitals;
    put(out, done, (size_t)(at - done));
    put(out, name, strlen(name));
    done = at + 4;
  }
  put(out, done, (size_t)(end - done));
}

static void put_line(output *out, const char *line) {
  put_code(out, line, strlen(line));
}

/* Numbers that read back to the same bits, four in a line. */
static void put_numbers(output *out, const double *numbers, size_t count) {
  for (size_t n = 0; n < count; n++) {
    char text[THRUM_NUMBER_TEXT];
    const size_t length = thrum_number_text(numbers[n], text);
    put_line(out, n % 4 == 0 ? "\n  " : " ");
    put(out, text, length);
    put_line(out, n + 1 < count ? "," : "\n};\n");
  }
}

/* Rows of a place under a name that C has room for. */
static void put_place(output *out, const char *name, int64_t index, const double *rows,
                      int64_t rank) {
  char line[200], plain[100];
  snprintf(plain, sizeof plain, "%s", name);
  bool is_name = true;
  for (char *at = plain; *at; at++)
    is_name = is_name && (isalnum((unsigned char)*at) || *at == '_');
  if (!is_name)
    snprintf(plain, sizeof plain, "group_%lld", (long long)index);
  snprintf(line, sizeof line, "\nstatic const double body_at_%s[] = {", plain);
  put_line(out, line);
  put_numbers(out, rows, (size_t)(3 * rank));
}

static void put_places(output *out, const thrum_model *model, double *rows) {
  if (model->basis != NULL && model->group_count > 0)
    put_line(out,
             "\n/* Rows (3 x rank) of the mean displacement of the named vertices, [kg^-1/2]. */");
  for (int64_t g = 0; model->basis != NULL && g < model->group_count; g++) {
    const char *name = thrum_model_group_name(model, g);
    const int32_t *vertices = NULL;
    int64_t count = 0;
    THRUM_THEN(out->status, thrum_model_group(model, name, &vertices, &count, out->error));
    if (out->status < 0)
      return;
    body_place(model, vertices, count, rows);
    put_place(out, name, g, rows, model->rank);
  }
}

static void put_model(output *out, const thrum_model *model, const double *coefficients,
                      size_t count) {
  const int64_t n = model->rank;
  char line[200];
  snprintf(line, sizeof line,
           "\n/* --- the numbers of the model --- */\n\n#define BODY_RANK %d\n\n"
           "static const double body_omega2[] = {",
           (int)n);
  put_line(out, line);
  put_numbers(out, model->omega2, (size_t)n);
  put_line(out, "\nstatic const double body_coefficients[] = {");
  put_numbers(out, coefficients, count);

  // which coordinates follow others
  unsigned char follows[THRUM_RANK_MAX];
  body_follows(model, follows);
  put_line(out, "\nstatic const unsigned char body_follows[] = {");
  for (int64_t i = 0; i < n; i++)
    put_line(out, follows[i] ? i + 1 < n ? "1, " : "1" : i + 1 < n ? "0, " : "0");
  put_line(out, "};\n\nstatic const body_numbers body_model = {BODY_RANK, body_omega2, "
                "body_coefficients,\n  body_follows};\n");
  if (model->axis_mass != NULL) {
    put_line(out, "\n/* Rows (3 x rank) by which an acceleration pulls, [kg^1/2]. */\n"
                  "static const double body_axis_mass[] = {");
    put_numbers(out, model->axis_mass, (size_t)(3 * n));
  }
}

thrum_status body_header_write(const char *path, const thrum_model *model, thrum_error *error) {
  output out = {.status = THRUM_OK, .error = error};
  char name[BODY_NAME_MAX];
  THRUM_TRY(array_code_check(model, error));
  THRUM_TRY(body_header_name(path, ".h", name, error));
  out.name = name;
  for (size_t n = 0; n < sizeof name; n++)
    out.capitals[n] = (char)toupper((unsigned char)name[n]);

  double *coefficients = NULL, *rows = NULL;
  size_t count = 0;
  thrum_status status = body_coefficients(model, &coefficients, &count, error);
  THRUM_THEN(status, thrum_reserve(&rows, 3 * model->rank, sizeof *rows, "a place", error));
  THRUM_THEN(status, thrum_file_writer_open(path, &out.writer, error));
  if (status >= 0) {
    // the code up to the end of its guard, which comes behind the numbers
    put_line(&out, "/* Written by thrum export --header. */\n");
    put_code(&out, (const char *)code, sizeof code - strlen("#endif\n"));
    put_model(&out, model, coefficients, count);
    put_places(&out, model, rows);
    put_line(&out, "\n#endif\n");
    status = thrum_file_writer_end(&out.writer, out.status, error);
  }
  free(rows);
  free(coefficients);
  return status;
}
