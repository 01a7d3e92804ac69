/* The models that come with Thrum, by name: a mesh where a mesh is expected, a reduced model,
 * precomputed once and cached, where a model is expected.
 *
 * Their meshes and recipes (NAME.json) lie in the folder named by THRUM_MODELS, else in
 * share/thrum/models beside the installed program, else in the source tree. A file that bears the
 * name goes before the name. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_NAMED_MODEL_H
#define THRUM_DRIVER_MAKE_NAMED_MODEL_H

#include "driver/make/precompute_request.h"
#include "driver/spec/model_names.h"

#define NAMED_MODEL_PATH_MAX 1024
#define MODEL_RECIPE_FIXES_MAX 8
#define MODEL_RECIPE_TESTS_MAX 8
#define MODEL_RECIPE_TEXT_MAX 64

/* The contents of NAME.json. */
typedef struct model_recipe {
  bool found; /* false: the text asked for is not one of our names, or a file bears it */
  const char *name;
  char mesh[NAMED_MODEL_PATH_MAX];
  int order; /* of the tets, as of thrum_mesh_read_options; 0: as the mesh has them */
  thrum_material material;
  char fixes[MODEL_RECIPE_FIXES_MAX][MODEL_RECIPE_TEXT_MAX];
  int64_t fix_count;
  int64_t modes;
  int64_t rank;
  int64_t thesis_rank; /* that of the thesis, whose split it has with a basis chosen by mass */
  bool thesis;         /* with that rank and such a basis; no recipe says so */
  bool touch;          /* with touch modes, as precompute --touch makes them; no recipe says so */
  char load_group[MODEL_RECIPE_TEXT_MAX];                    /* where loads act; default "load" */
  double load_direction[3];                                  /* zero: not said */
  double load_force;                                         /* [N]; zero: not said */
  char tests[MODEL_RECIPE_TESTS_MAX][MODEL_RECIPE_TEXT_MAX]; /* loads, as --load takes them */
  int64_t test_count;
} model_recipe;

/* Looks the text up; fails when it is one of our names and its recipe cannot be read. */
thrum_status model_recipe_find(const char *text, model_recipe *recipe, thrum_error *error);

/* The recipe's order of the tets, where the options leave it open. */
void model_recipe_read(const model_recipe *recipe, thrum_mesh_read_options *reading);

/* The recipe's mesh in place of the name, and what the request leaves open filled in. The request's
 * fixes have room for MODEL_RECIPE_FIXES_MAX more and point into the recipe afterwards. */
void model_recipe_apply(const model_recipe *recipe, precompute_request *request);

/* A model's file. */
typedef struct named_model_file {
  const char *path; /* the text asked for, or `cached` */
  char cached[NAMED_MODEL_PATH_MAX];
} named_model_file;

/* The folder of cached models, made where it is not there, for the user alone. */
thrum_status named_model_cache_folder(char path[NAMED_MODEL_PATH_MAX], thrum_error *error);

/* Leaves a file of that folder to the user alone, whatever the umask. */
void named_model_keep_private(const char *path);

/* Loads the model file at `text`, or the one that `text` names: from the cache (XDG_CACHE_HOME or
 * ~/.cache, folder thrum), where it is made first if it is not there or not whole. `file` may be
 * NULL. */
thrum_status named_model_load(const char *text, bool quiet, const thrum_model **model,
                              named_model_file *file, thrum_error *error);

/* The same of a model that is to be pulled anywhere: one that `text` names has touch modes, which
 * its steps do not cost (docs/precompute.md). */
thrum_status named_model_load_touch(const char *text, bool quiet, const thrum_model **model,
                                    thrum_error *error);

/* The same for the experiments of the thesis: one that `text` names has the rank and the selection
 * of a basis with which it splits as there. */
thrum_status named_model_load_thesis(const char *text, bool quiet, const thrum_model **model,
                                     thrum_error *error);

#endif
