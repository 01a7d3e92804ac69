/* Options of `thrum static`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_OPTIONS_H
#define THRUM_DRIVER_STATICS_STATIC_OPTIONS_H

#include "config/options.h"
#include "driver/make/mesh_model.h"
#include "driver/spec/actuate_spec.h"
#include "driver/spec/basis_asked.h"
#include "driver/spec/load_spec.h"
#include "precompute/full/full.h"

typedef enum static_move_kind {
  STATIC_MOVE,   /* a displacement that a target is brought to [m] */
  STATIC_ROTATE, /* axis times angle that it is turned by [degrees] */
  STATIC_FOLLOW, /* a force that turns with it [N] */
  STATIC_MOMENT  /* a moment that turns with it [N m] */
} static_move_kind;

enum { STATIC_MOVE_KINDS = STATIC_MOMENT + 1 };

/* Names of the options that give them, without dashes. */
extern const char *const static_move_names[STATIC_MOVE_KINDS];

/* A motion, force or moment of a target, which only the full order takes. */
typedef struct static_move {
  static_move_kind kind;
  const char *text;
  double by[3];
  load_target target;
} static_move;

typedef struct static_request {
  const char *model_path;
  mesh_model_def mesh_def; /* where model_path is a mesh, of --full */
  const char *output;      /* q as .npy; NULL: none */
  const char *frame;       /* .vtu; NULL: none */
  const char *path;        /* .csv of the path; NULL: none */
  const char *reactions;   /* .csv of the forces that hold the body; NULL: none */
  const char *from;        /* .npy where the path starts; NULL: at rest */
  const char *field;       /* .npy of the displacements; NULL: none */
  const char **at;         /* targets whose displacement is shown, as given */
  load_target *targets;    /* the same, parsed */
  int64_t target_count;
  load_spec *loads;
  int64_t load_count;
  actuate_spec *actuates; /* at their full strength */
  int64_t actuate_count;
  bool full;          /* the whole mesh in place of the model */
  static_move *moves; /* of --full */
  int64_t move_count;
  thrum_full_solver solver;
  const thrum_full_shared *shared; /* processes that share its factor; NULL: this one alone */
  thrum_full_quadrature quadrature;
  thrum_law law;  /* of the full order, where */
  bool law_given; /* and not the model's */
  thrum_equilibrium_def def;
  int64_t rank;      /* 0: all */
  bool monitor;      /* warn of what the answer of a model can be believed for */
  basis_asked basis; /* the same of its basis */
  bool json, quiet;
  config_file file; /* of --options; the texts above may point into it */
} static_request;

/* The command and its options. */
extern const config_command command_static;

/* Fills a zeroed request whose lists have room for argc + CONFIG_FILE_ITEMS_MAX. COMMAND_DONE, or
 * what the command is to return. */
int static_options_read(int argc, char **argv, static_request *request);

#endif
