/* A mesh where a model is expected by what needs the full order: its model is made first, and kept.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_MESH_MODEL_H
#define THRUM_DRIVER_MAKE_MESH_MODEL_H

#include "config/options.h"
#include "driver/make/named_model.h"
#include "mesh/formats/mesh_read.h"
#include "precompute/full/full_solver.h"
#include "precompute/precompute.h"
#include "runtime/material/plastic_flow.h"

#define MESH_MODEL_FIXES_MAX 32
#define MESH_MODEL_MATERIALS_MAX 64

/* The options that a mesh needs to become a model, as those of precompute. */
typedef struct mesh_model_def {
  const char *fixes[MESH_MODEL_FIXES_MAX];
  int64_t fix_count;
  bool free;  /* nothing is to be held: no warning of it */
  bool whole; /* only the mesh is wanted: two modes alone, so that making it costs little */
  thrum_material material;                         /* a field is NaN where the mesh's own stays */
  const char *materials[MESH_MODEL_MATERIALS_MAX]; /* texts of region_material.h */
  int64_t material_count;
  thrum_law law; /* another than Saint Venant-Kirchhoff's is that of cubature points, */
  double yield;  /* which are trained on flow beyond it; 0: on none */
  thrum_mesh_read_options reading;
  const thrum_precompute_shared *shared; /* processes that make the model; NULL: this one alone */
} mesh_model_def;

/* Nothing held, the mesh's own material, read as it is. */
mesh_model_def mesh_model_def_default(void);

/* Options of a mesh_model_def, for the group of a table. */
extern const config_option mesh_options[];

/* COMMAND_DONE, or COMMAND_USAGE after a line where options of a mesh come without one, or a law of
 * the whole body, law_given, beside those of regions; `mesh`: the path is taken as a mesh. */
int mesh_model_def_check(const char *command, const mesh_model_def *def, bool mesh, bool law_given);

/* The same for a command that takes a mesh with --full only. */
int mesh_model_full_check(const char *command, const char *path, const mesh_model_def *def,
                          bool full, bool law_given);

/* What of a run of the whole mesh is of tetrahedra alone, as `tets_for` of the options of reading;
 * NULL: nothing. `plastic` may be NULL. */
const char *mesh_model_tets_for(thrum_law law, const thrum_plastic *plastic,
                                thrum_full_quadrature quadrature);

/* Loads the model of the mesh at `text`: made with precompute's defaults, in the cache of models
 * and anew each time, since a mesh may be of several files that change. Where `text` is no mesh,
 * as named_model_load. */
thrum_status mesh_model_load(const char *text, const mesh_model_def *def, bool quiet,
                             const thrum_model **model, named_model_file *file, thrum_error *error);

#endif
