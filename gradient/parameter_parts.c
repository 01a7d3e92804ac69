/* The parts of the energy that moduli and densities of regions add (thrum/gradient.h), packed for
 * the passes over a tape. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <stdlib.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "thrum/gradient.h"
#include "thrum/parameters.h"
#include "thrum/polynomial.h"

struct thrum_parameter_parts {
  int64_t count;
  thrum_energy_part *parts; /* count */
  thrum_model *forms;       /* count */
  double *numbers;          /* rank zeros; then L, c3, c4 and M of each */
  void *packed;
};

/* Lays out the form of one part, whose frequencies are zero. */
static thrum_status pack(const thrum_model *model, const double *none, const double *c3,
                         unsigned char **at, thrum_model *form, thrum_error *error) {
  *form = (thrum_model){.rank = model->rank,
                        .c3_count = model->c3_count,
                        .c4_count = model->c4_count,
                        .format = model->format,
                        .omega2 = none,
                        .c3 = c3,
                        .c4 = c3 + model->c3_count};
  const size_t size = thrum_round_up(thrum_model_pack_size(form));
  unsigned char *memory = *at;
  *at += size;
  return thrum_model_pack(form, memory, size, error);
}

/* All parts, into memory that is there. */
static thrum_status fill(const thrum_model *model, thrum_parameter_parts *parts, double *work,
                         thrum_error *error) {
  const int64_t r = model->rank, square = r * r;
  unsigned char *at = parts->packed;
  double *next = parts->numbers + r;
  for (int64_t n = 0; n < parts->count; n++) {
    double *linear = next, *c3 = linear + square, *c4 = c3 + model->c3_count;
    double *mass = c4 + model->c4_count;
    next = mass + square;
    THRUM_TRY(thrum_model_parameter_slope(model, n, linear, c3, c4, mass, work, error));
    THRUM_TRY(pack(model, parts->numbers, c3, &at, &parts->forms[n], error));
    parts->parts[n] = (thrum_energy_part){
        .linear = linear, .form = &parts->forms[n], .mass = n % 3 == 2 ? mass : NULL};
  }
  return THRUM_OK;
}

static thrum_status lay(const thrum_model *model, size_t work_count, thrum_parameter_parts *parts,
                        thrum_error *error) {
  const size_t count = (size_t)parts->count, r = (size_t)model->rank;
  const size_t part = 2 * r * r + (size_t)(model->c3_count + model->c4_count);
  double *work = calloc(work_count, sizeof *work);
  parts->parts = calloc(count, sizeof *parts->parts);
  parts->forms = calloc(count, sizeof *parts->forms);
  parts->numbers = calloc(r + count * part, sizeof *parts->numbers);
  parts->packed =
      aligned_alloc(THRUM_ALIGNMENT, count * thrum_round_up(thrum_model_pack_size(model)));
  thrum_status status = THRUM_OK;
  if (!work || !parts->parts || !parts->forms || !parts->numbers || !parts->packed)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory for the parameters");
  if (status >= 0)
    status = fill(model, parts, work, error);
  free(work);
  return status;
}

thrum_status thrum_parameter_parts_create(const thrum_model *model, thrum_parameter_parts **parts,
                                          thrum_error *error) {
  size_t work = 0;
  THRUM_TRY(thrum_model_parameters_size(model, NULL, &work, error));
  if (!parts)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "parts is NULL");
  thrum_parameter_parts *made = calloc(1, sizeof *made);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory for the parameters");
  made->count = thrum_model_parameter_count(model);
  const thrum_status status = lay(model, work, made, error);
  if (status >= 0)
    *parts = made;
  else
    thrum_parameter_parts_destroy(made);
  return status;
}

void thrum_parameter_parts_destroy(thrum_parameter_parts *parts) {
  if (!parts)
    return;
  free(parts->parts);
  free(parts->forms);
  free(parts->numbers);
  free(parts->packed);
  free(parts);
}

const thrum_energy_part *thrum_parameter_parts_list(const thrum_parameter_parts *parts) {
  return parts ? parts->parts : NULL;
}

int64_t thrum_parameter_parts_count(const thrum_parameter_parts *parts) {
  return parts ? parts->count : 0;
}
