/* A model as a Functional Mock-up Unit: an archive of its description, its numbers, the sources
 * that step them, and these sources compiled. The sources are those in driver/export/fmu, and the
 * same for all models. SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/fmu_write.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/mix_numbers.h"
#include "core/base/pi.h"
#include "driver/export/array_code.h"
#include "driver/export/body_header.h"
#include "driver/export/fmu_description.h"
#include "io/zip_write.h"
#include "platform/allocate.h"

/* The bytes of the sources, by cmake/text_as_c.cmake, and those of the library made of them. */
static const unsigned char code_body[] = {
#include "body_code.inc"
};
static const unsigned char code_fmu_header[] = {
#include "fmu_body_header.inc"
};
static const unsigned char code_fmu[] = {
#include "fmu_body.inc"
};
static const unsigned char code_fmi2[] = {
#include "fmi2.inc"
};
static const unsigned char code_fmi3[] = {
#include "fmi3.inc"
};
static const unsigned char library[] = {
#include "fmu_library.inc"
};

/* Functions of fmu_body.h, which have the prefix of FMI's where a body is linked statically. */
static const char *const inner[] = {"make",   "free",       "reset",      "allows",   "refuse",
                                    "get",    "set",        "experiment", "set_time", "step",
                                    "states", "set_states", "rates",      "bytes",    "write",
                                    "check",  "read",       "derivative", "adjoint"};

#define MEMBERS_MAX 12

/* An FMU before it is written. */
typedef struct fmu_contents {
  fmu_head *head; /* and the numbers behind it */
  size_t size;
  double *numbers; /* those behind the head */
  char **names;    /* of the places */
  int places;
  thrum_zip_source members[MEMBERS_MAX];
  char *texts[MEMBERS_MAX]; /* owned: what members are made of */
  int count;
} fmu_contents;

static void contents_free(fmu_contents *fmu) {
  for (int n = 0; n < MEMBERS_MAX; n++)
    free(fmu->texts[n]);
  for (int n = 0; fmu->names && n < fmu->places; n++)
    free(fmu->names[n]);
  free(fmu->names);
  free(fmu->head);
}

/* --- places ---------------------------------------------------------------------------------- */

/* Adds the rows of a place; false where it does not move. */
static bool add_rows(fmu_contents *fmu, const thrum_model *model, const load_vertices *at) {
  const int64_t n = model->rank;
  double *rows = fmu->numbers + 4 + 4 * n + 3 * n * fmu->places;
  body_place(model, at->list, at->count, rows);
  for (int64_t i = 0; i < 3 * n; i++)
    if (rows[i] != 0)
      return true;
  return false;
}

static thrum_status add_name(fmu_contents *fmu, const char *name, thrum_error *error) {
  for (int n = 0; n < fmu->places; n++)
    if (strcmp(fmu->names[n], name) == 0)
      return thrum_error_set(error, THRUM_BAD_VALUE, "two places have the name '%.200s'", name);
  for (const char *at = name; *at; at++)
    if ((unsigned char)*at < ' ')
      return thrum_error_set(error, THRUM_BAD_VALUE, "a place cannot have a name with line breaks");
  fmu->names[fmu->places] = strdup(name);
  if (fmu->names[fmu->places] == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the places");
  fmu->places++;
  return THRUM_OK;
}

static thrum_status add_target(fmu_contents *fmu, const thrum_model *model,
                               const fmu_target *target, thrum_error *error) {
  int32_t *list = NULL;
  load_vertices at = {0};
  THRUM_TRY(load_target_list(model, &target->target, &list, &at.count, error));
  at.list = list;
  const bool moves = add_rows(fmu, model, &at);
  free(list);
  if (!moves)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.200s' is held: name a place that moves with --at", target->name);
  return add_name(fmu, target->name, error);
}

/* The groups that move. */
static thrum_status add_groups(fmu_contents *fmu, const thrum_model *model, thrum_error *error) {
  for (int64_t g = 0; g < model->group_count; g++) {
    const char *name = thrum_model_group_name(model, g);
    load_vertices at = {0};
    THRUM_TRY(thrum_model_group(model, name, &at.list, &at.count, error));
    if (add_rows(fmu, model, &at))
      THRUM_TRY(add_name(fmu, name, error));
  }
  if (fmu->places > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "the model names no vertices that move: say with --at where forces act");
}

/* --- numbers --------------------------------------------------------------------------------- */

/* 1, 2 or 5 times a power of ten, at most x. */
static double round_down(double x) {
  const double power = pow(10.0, floor(log10(x)));
  return (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1) * power;
}

/* What tells this FMU from others: two hashes of its numbers. */
static void make_token(fmu_head *head, const double *numbers, size_t count) {
  const uint64_t a = thrum_mix_numbers(1, numbers, (int64_t)count);
  const uint64_t b = thrum_mix_numbers(a, numbers, (int64_t)count);
  snprintf(head->token, sizeof head->token,
           "{%08" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%012" PRIx64 "}", a >> 32,
           a >> 16 & 0xffff, a & 0xffff, b >> 48, b & UINT64_C(0xffffffffffff));
}

static thrum_status fill_numbers(fmu_contents *fmu, const thrum_model *model,
                                 const fmu_target *targets, int64_t count, thrum_error *error) {
  const int64_t n = model->rank;
  const int64_t most = count > 0 ? count : model->group_count;
  fmu->size = sizeof *fmu->head + fmu_numbers_count((int)n, (int)most) * sizeof *fmu->numbers;
  THRUM_TRY(thrum_reserve(&fmu->head, 1, fmu->size, "the FMU", error));
  THRUM_TRY(thrum_reserve(&fmu->names, most + 1, sizeof *fmu->names, "the FMU", error));
  fmu->numbers = (double *)(fmu->head + 1);

  // the places first, as they decide where the others lie
  for (int64_t t = 0; t < count; t++)
    THRUM_TRY(add_target(fmu, model, &targets[t], error));
  if (count == 0)
    THRUM_TRY(add_groups(fmu, model, error));

  // a hundredth of the first period, no damping, and the stiffness as it is
  const double period = 2 * THRUM_PI / sqrt(model->omega2[0]);
  const double start[] = {0, 0, 1, round_down(period / 100)};
  memcpy(fmu->numbers, start, sizeof start);
  memcpy(fmu->numbers + 4, model->omega2, (size_t)n * sizeof *fmu->numbers);
  if (model->axis_mass != NULL)
    memcpy(fmu->numbers + 4 + n, model->axis_mass, (size_t)(3 * n) * sizeof *fmu->numbers);

  double *coefficients = NULL, *at = fmu->numbers + 4 + 4 * n + 3 * n * fmu->places;
  size_t terms = 0;
  THRUM_TRY(body_coefficients(model, &coefficients, &terms, error));
  unsigned char follows[THRUM_RANK_MAX];
  body_follows(model, follows);
  for (int64_t i = 0; i < n; i++)
    *at++ = follows[i];
  memcpy(at, coefficients, terms * sizeof *at);
  free(coefficients);

  const size_t numbers = fmu_numbers_count((int)n, fmu->places);
  memcpy(fmu->head->magic, FMU_MAGIC, sizeof fmu->head->magic);
  fmu->head->rank = (int32_t)n;
  fmu->head->places = fmu->places;
  fmu->size = sizeof *fmu->head + numbers * sizeof *fmu->numbers;
  make_token(fmu->head, fmu->numbers, numbers);
  return THRUM_OK;
}

/* --- members --------------------------------------------------------------------------------- */

static void add_member(fmu_contents *fmu, const char *folder, const char *name, const void *data,
                       size_t size) {
  thrum_zip_source *member = &fmu->members[fmu->count++];
  snprintf(member->name, sizeof member->name, "%s%s", folder, name);
  member->data = data;
  member->data_size = size;
}

/* A text that the contents own. */
static void add_text(fmu_contents *fmu, const char *folder, const char *name, char *text,
                     size_t size) {
  fmu->texts[fmu->count] = text;
  add_member(fmu, folder, name, text, size);
}

/* A source file, whose includes lie beside it in the archive. */
static thrum_status add_source(fmu_contents *fmu, const char *name, const unsigned char *code,
                               size_t size, thrum_error *error) {
  static const char folder[] = "\"driver/export/fmu/";
  const size_t skipped = sizeof folder - 1;
  char *text = NULL;
  THRUM_TRY(thrum_reserve(&text, (int64_t)size, 1, "the sources of the FMU", error));
  size_t length = 0;
  for (size_t at = 0; at < size; at++) {
    text[length++] = (char)code[at];
    if (size - at > skipped && memcmp(code + at, folder, skipped) == 0)
      at += skipped - 1;
  }
  add_text(fmu, "sources/", name, text, length);
  return THRUM_OK;
}

/* What stands in front of names, where the body is linked statically. */
typedef struct fmu_prefix {
  int version;
  const char *name;
} fmu_prefix;

static void put_prefix(FILE *out, const void *of) {
  const fmu_prefix *prefix = of;
  const int version = prefix->version;
  const char *name = prefix->name;
  fprintf(out,
          "/* Names of a body that is linked statically; a shared one defines "
          "FMI%d_OVERRIDE_FUNCTION_PREFIX. */\n#ifndef FMU_PREFIX_H\n#define FMU_PREFIX_H\n\n"
          "#define FMI%d_FUNCTION_PREFIX %s_\n",
          version, version, name);
  for (size_t n = 0; n < sizeof inner / sizeof *inner; n++)
    fprintf(out, "#define fmu_body_%s %s_fmu_body_%s\n", inner[n], name, inner[n]);
  fputs("\n#endif\n", out);
}

static thrum_status add_prefix(fmu_contents *fmu, int version, const char *name,
                               thrum_error *error) {
  const fmu_prefix prefix = {version, name};
  char *text = NULL;
  size_t size = 0;
  THRUM_TRY(fmu_text(put_prefix, &prefix, &text, &size, error));
  add_text(fmu, "sources/", "fmu_prefix.h", text, size);
  return THRUM_OK;
}

static thrum_status add_sources(fmu_contents *fmu, int version, const char *name,
                                thrum_error *error) {
  THRUM_TRY(add_source(fmu, "body_code.h", code_body, sizeof code_body, error));
  THRUM_TRY(add_source(fmu, "fmu_body.h", code_fmu_header, sizeof code_fmu_header, error));
  THRUM_TRY(add_source(fmu, "fmu_body.c", code_fmu, sizeof code_fmu, error));
  THRUM_TRY(add_prefix(fmu, version, name, error));
  return version == 2 ? add_source(fmu, "fmi2.c", code_fmi2, sizeof code_fmi2, error)
                      : add_source(fmu, "fmi3.c", code_fmi3, sizeof code_fmi3, error);
}

/* The folder of the library in the archive, by the processor that Thrum was compiled for; NULL: the
 * standard has no name for it. */
static const char *library_folder(int version) {
#if defined(__linux__) && defined(__x86_64__)
  return version == 2 ? "binaries/linux64/" : "binaries/x86_64-linux/";
#elif defined(__linux__) && defined(__aarch64__)
  return version == 2 ? NULL : "binaries/aarch64-linux/";
#else
  (void)version;
  return NULL;
#endif
}

static thrum_status add_members(fmu_contents *fmu, int version, const char *name,
                                thrum_error *error) {
  const char *sources[] = {"fmu_body.c", version == 2 ? "fmi2.c" : "fmi3.c"};
  const fmu_description description = {.version = version,
                                       .name = name,
                                       .head = fmu->head,
                                       .start = fmu->numbers,
                                       .places = (const char *const *)fmu->names,
                                       .sources = sources,
                                       .source_count = 2,
                                       .stop = 1000 * fmu->numbers[3]};
  char *text = NULL;
  size_t size = 0;
  THRUM_TRY(fmu_model_description(&description, &text, &size, error));
  add_text(fmu, "", "modelDescription.xml", text, size);
  add_member(fmu, "resources/", "body.bin", fmu->head, fmu->size);
  THRUM_TRY(add_sources(fmu, version, name, error));
  if (version == 3) {
    THRUM_TRY(fmu_build_description(&description, &text, &size, error));
    add_text(fmu, "sources/", "buildDescription.xml", text, size);
  }

  char file[BODY_NAME_MAX + 8];
  snprintf(file, sizeof file, "%s.so", name);
  if (library_folder(version) != NULL)
    add_member(fmu, library_folder(version), file, library, sizeof library);
  return THRUM_OK;
}

/* Refuses what would not move as the body does. */
static thrum_status check_model(const thrum_model *model, thrum_error *error) {
  THRUM_TRY(array_code_check(model, error));
  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh, and an FMU needs places where forces act: make "
                           "it from a mesh");
  if (model->rigid != NULL || !(model->omega2[0] > 0))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the body is free, and an FMU does not move as a whole: hold it "
                           "somewhere, with --fix of precompute");
  return THRUM_OK;
}

thrum_status fmu_write(const char *path, int version, const thrum_model *model,
                       const fmu_target *targets, int64_t count, thrum_error *error) {
  char name[BODY_NAME_MAX];
  THRUM_TRY(check_model(model, error));
  THRUM_TRY(body_header_name(path, ".fmu", name, error));
  fmu_contents fmu = {0};
  thrum_status status = fill_numbers(&fmu, model, targets, count, error);
  THRUM_THEN(status, add_members(&fmu, version, name, error));
  THRUM_THEN(status, thrum_zip_plan(fmu.members, fmu.count, "an FMU", error));
  THRUM_THEN(status, thrum_zip_write(path, fmu.members, fmu.count, error));
  contents_free(&fmu);
  return status;
}
