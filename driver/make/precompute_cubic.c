/* A model of VegaFEM's polynomial alone. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_cubic.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/json.h"
#include "io/npz.h"
#include "io/paths.h"
#include "mesh/model_quality.h"
#include "platform/allocate.h"
#include "precompute/build_info.h"
#include "precompute/vega_model.h"
#include "thrum/thrum.h"

bool precompute_cubic_is_named(const char *name) {
  const size_t length = strlen(name);
  return length > 4 && strcmp(name + length - 4, ".cub") == 0;
}

/* Refuses options that need what the file does not have. */
static thrum_status check_options(const precompute_request *r, thrum_error *error) {
  const bool mesh =
      r->fix_count > 0 || r->handle_count > 0 || r->spring_count > 0 || r->material_count > 0 ||
      !isnan(r->material.young) || !isnan(r->material.poisson) || !isnan(r->material.density) ||
      r->reading.scale != 1 || r->reading.order > 0 || r->reading.unit || r->reading.regions;
  const bool basis = r->modes_given || r->rank_given || r->train_count > 0 || r->condense ||
                     r->dry_run || r->import_basis || r->export_modes;
  if (!mesh && !basis)
    return path_check_output(r->output, error);
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "%.200s is a polynomial without a mesh: it takes no options of %s",
                         r->mesh_name, mesh ? "a mesh" : "a basis");
}

/* The frequencies of the coordinates, as a list of an object. */
static void add_frequencies(cJSON *object, const thrum_model *model, const double *hertz) {
  cJSON *list = cJSON_AddArrayToObject(object, "basis_frequencies_hz");
  for (int64_t i = 0; i < model->rank; i++)
    cJSON_AddItemToArray(list, json_number_item(hertz[i]));
}

/* Returns the JSON text of what the model is and where it comes from; the caller frees it. */
static char *make_meta(const precompute_request *request, const thrum_vega_model *made,
                       const double *hertz) {
  cJSON *meta = cJSON_CreateObject();
  cJSON_AddStringToObject(meta, "tool", "thrum");
  cJSON_AddStringToObject(meta, "version", thrum_version());
  cJSON_AddStringToObject(meta, "compiler", thrum_build_compiler());
  cJSON_AddStringToObject(meta, "blas_core", thrum_build_blas_core());
  cJSON *import = cJSON_AddObjectToObject(meta, "import");
  json_string(import, "cubic", path_basename(request->mesh_name));
  cJSON_AddBoolToObject(import, "basis_changed", made->changed);
  json_number(import, "gradient_defect", made->defect);
  add_frequencies(meta, &made->model, hertz);
  char *text = json_text(meta);
  cJSON_Delete(meta);
  return text;
}

static void print_result(const precompute_request *request, const thrum_vega_model *made,
                         const double *hertz) {
  if (!request->json) {
    printf("%s: rank %" PRId64 ", %.6g to %.6g Hz, from %s; it has no mesh, so it shows "
           "coordinates only\n",
           request->output, made->model.rank, hertz[0], hertz[made->model.rank - 1],
           request->mesh_name);
    return;
  }
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "model", request->output);
  json_number(object, "rank", (double)made->model.rank);
  json_number(object, "gradient_defect", made->defect);
  add_frequencies(object, &made->model, hertz);
  json_print(object);
}

static thrum_status write_model(const precompute_request *request, thrum_vega_model *made,
                                thrum_error *error) {
  double *hertz = NULL;
  THRUM_TRY(thrum_reserve(&hertz, made->model.rank, sizeof *hertz, "the frequencies", error));
  thrum_frequencies(made->omega2, made->model.rank, hertz);
  char *meta = make_meta(request, made, hertz);

  thrum_status status = THRUM_OK;
  if (!meta)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory for meta");
  made->model.meta = (const uint8_t *)meta;
  made->model.meta_bytes = meta ? (int64_t)strlen(meta) : 0;
  THRUM_THEN(status, thrum_model_save(request->output, &made->model, error));
  if (status >= 0)
    print_result(request, made, hertz);
  free(hertz);
  free(meta);
  return status;
}

thrum_status precompute_cubic_make(const precompute_request *request, thrum_error *error) {
  thrum_vega_model made = {0};
  THRUM_TRY(check_options(request, error));
  THRUM_TRY(thrum_vega_model_read(request->mesh_name, &made, error));
  const thrum_status status = write_model(request, &made, error);
  thrum_vega_model_free(&made);
  return status;
}
