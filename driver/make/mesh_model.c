/* A mesh where a model is expected. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/mesh_model.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "config/message.h"
#include "driver/make/precompute_make.h"
#include "driver/model/cache_trim.h"
#include "driver/spec/region_material.h"
#include "driver/spec/shared_options.h"
#include "io/file_hash.h"
#include "mesh/formats/mesh_read.h"

/* Models of meshes in the cache: together, and how long a new one stays in any case. */
#define KEPT_BYTES (INT64_C(1) << 30)
#define KEPT_SECONDS 3600

mesh_model_def mesh_model_def_default(void) {
  return (mesh_model_def){.material = {NAN, NAN, NAN}, .reading = {.scale = 1}};
}

static thrum_status take_fix(const config_given *given, void *record) {
  mesh_model_def *def = record;
  if (def->fix_count == MESH_MODEL_FIXES_MAX)
    return config_given_refuse(given, "given more than %d times", MESH_MODEL_FIXES_MAX);
  def->fixes[def->fix_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_material(const config_given *given, void *record) {
  mesh_model_def *def = record;
  THRUM_TRY(region_material_option_check(given));
  if (def->material_count == MESH_MODEL_MATERIALS_MAX)
    return config_given_refuse(given, "given more than %d times", MESH_MODEL_MATERIALS_MAX);
  def->materials[def->material_count++] = given->text;
  return THRUM_OK;
}

const config_option mesh_options[] = {
    OPTION_TEXT("fix", "SPEC", "nothing", "hold vertices, as of precompute",
                .path = CONFIG_PATH_IF_THERE, .repeats = true, .take = take_fix),
    OPTION_GROUP(material_options, "", CONFIG_AT(mesh_model_def, material)),
    OPTION_MATERIAL(take_material),
    OPTION_GROUP(mesh_read_rows, "", CONFIG_AT(mesh_model_def, reading)),
    OPTION_END,
};

int mesh_model_def_check(const char *command, const mesh_model_def *def, bool mesh,
                         bool law_given) {
  const thrum_material *material = &def->material;
  const thrum_mesh_read_options *reading = &def->reading;
  const bool given = def->fix_count > 0 || def->material_count > 0 || !isnan(material->young) ||
                     !isnan(material->poisson) || !isnan(material->density) ||
                     reading->scale != 1 || reading->order != 0 || reading->unit ||
                     reading->regions || reading->element != THRUM_ELEMENT_AUTO;
  if (law_given && region_materials_have_laws(def->materials, def->material_count))
    return config_usage(command, "--law is that of the whole body, and --material gives a region "
                                 "one of its own: leave one out");
  if (!given || mesh)
    return COMMAND_DONE;
  return config_usage(command,
                      "--fix, --young, --poisson, --density, --material, --scale, --unit, "
                      "--regions, --order and --element are of a mesh; a model has its own");
}

int mesh_model_full_check(const char *command, const char *path, const mesh_model_def *def,
                          bool full, bool law_given) {
  const bool mesh = thrum_mesh_is_named(path);
  if (mesh && !full)
    return config_usage(
        command,
        "%.200s is a mesh: make a model of it with thrum precompute, or take it whole "
        "with --full",
        path);
  return mesh_model_def_check(command, def, mesh, law_given);
}

/* Whether a polynomial cannot hold the laws. */
static bool needs_points(const mesh_model_def *def) {
  return def->law != THRUM_LAW_STVK ||
         region_materials_need_points(def->materials, def->material_count);
}

const char *mesh_model_tets_for(thrum_law law, const thrum_plastic *plastic,
                                thrum_full_quadrature quadrature) {
  if (law != THRUM_LAW_STVK)
    return "laws other than Saint Venant-Kirchhoff's take";
  if (plastic != NULL && !isinf(plastic->yield))
    return "plastic flow takes";
  return quadrature != THRUM_FULL_EXACT ? "four points take" : NULL;
}

/* One file for each mesh and what is asked of it, so that runs of others keep theirs. */
static thrum_status kept_path(const char *text, const mesh_model_def *def,
                              char path[NAMED_MODEL_PATH_MAX], thrum_error *error) {
  char numbers[128], folder[NAMED_MODEL_PATH_MAX];
  THRUM_TRY(named_model_cache_folder(folder, error));

  // a relative name means another file in another folder
  uint64_t hash = hash_bytes(0, text, strlen(text) + 1);
  char here[NAMED_MODEL_PATH_MAX];
  if (getcwd(here, sizeof here) != NULL)
    hash = hash_bytes(hash, here, strlen(here));

  // the material and the fixed vertices change the model too
  snprintf(numbers, sizeof numbers, "%.17g|%.17g|%.17g", def->material.young, def->material.poisson,
           def->material.density);
  hash = hash_bytes(hash, numbers, strlen(numbers));
  for (int64_t n = 0; n < def->fix_count; n++)
    hash = hash_bytes(hash, def->fixes[n], strlen(def->fixes[n]) + 1);
  for (int64_t n = 0; n < def->material_count; n++)
    hash = hash_bytes(hash, def->materials[n], strlen(def->materials[n]) + 1);

  // and so does how it is read; a file read as it is keeps its name in the cache
  const thrum_mesh_read_options *reading = &def->reading;
  if (reading->element != THRUM_ELEMENT_AUTO)
    hash = hash_bytes(hash, &reading->element, sizeof reading->element);
  if (reading->tets_for != NULL)
    hash = hash_bytes(hash, reading->tets_for, strlen(reading->tets_for));
  if (reading->scale != 1 || reading->order != 0 || reading->unit || reading->regions) {
    snprintf(numbers, sizeof numbers, "%.17g|%d|", reading->scale, reading->order);
    hash = hash_bytes(hash, numbers, strlen(numbers));
    const char *texts[] = {reading->unit, reading->regions};
    for (int n = 0; n < 2; n++)
      hash = hash_bytes(hash, texts[n] ? texts[n] : "", texts[n] ? strlen(texts[n]) + 1 : 1);
  }

  if (def->law != THRUM_LAW_STVK) {
    const char *law = thrum_law_name(def->law);
    hash = hash_bytes(hash, law, strlen(law) + 1);
  }
  if (needs_points(def) && def->yield > 0)
    hash = hash_bytes(hash, &def->yield, sizeof def->yield);
  if (def->whole)
    hash = hash_bytes(hash, "whole", sizeof "whole");

  // those of old runs make room
  cache_trim(folder, "mesh-", KEPT_BYTES, KEPT_SECONDS);
  snprintf(path, NAMED_MODEL_PATH_MAX, "%.*s/mesh-%016" PRIx64 ".npz", NAMED_MODEL_PATH_MAX - 64,
           folder, hash);
  return THRUM_OK;
}

thrum_status mesh_model_load(const char *text, const mesh_model_def *def, bool quiet,
                             const thrum_model **model, named_model_file *file,
                             thrum_error *error) {
  named_model_file own;
  if (file == NULL)
    file = &own;
  if (!thrum_mesh_is_named(text))
    return named_model_load(text, quiet, model, file, error);

  // the definition becomes a request of precompute, which writes to the cache
  const char *fixes[MESH_MODEL_FIXES_MAX];
  const char *materials[MESH_MODEL_MATERIALS_MAX];
  memcpy(fixes, def->fixes, sizeof fixes);
  memcpy(materials, def->materials, sizeof materials);
  bool flagged = false;
  thrum_status status = kept_path(text, def, file->cached, error);
  precompute_request request = {
      .mesh_name = text,
      .output = file->cached,
      .reading = def->reading,
      .material = def->material,
      .materials = materials,
      .material_count = def->material_count,
      .options = thrum_default_precompute_options(),
      .fixes = fixes,
      .fix_count = def->fix_count,
      .reproducible = true,
      .free = def->free,
      .quiet = quiet,
  };

  file->path = file->cached;
  request.options.fit = true;
  request.options.law = def->law;
  request.options.cubature = needs_points(def);
  request.options.shared = request.options.cubature ? NULL : def->shared;
  if (def->yield > 0)
    request.options.cubature_yield = def->yield;
  if (def->whole) {
    request.options.modes = 2;
    request.options.rank = 4;
  } else if (status >= 0 && !quiet)
    fprintf(
        stderr,
        "thrum: precomputing %s, as every run of a mesh does (thrum precompute writes a model to "
        "keep); that of this run stays in the cache for now: %s\n",
        text, file->cached);
  THRUM_THEN(status, precompute_make(&request, NULL, &flagged, error));
  if (status >= 0)
    named_model_keep_private(file->cached);
  return status >= 0 ? thrum_model_load(file->cached, model, error) : status;
}
