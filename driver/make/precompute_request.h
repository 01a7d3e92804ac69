/* The request that the options of `thrum precompute` fill in; a model that is asked for by name is
 * made from one too. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_REQUEST_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_REQUEST_H

#include "config/options.h"
#include "driver/spec/job_list.h"
#include "mesh/formats/mesh_read.h"
#include "precompute/precompute.h"

typedef struct precompute_request {
  const char *mesh_name;
  const char *output;
  thrum_mesh_read_options reading;
  bool order_of_recipe;    /* its order was not asked for, but is that of a model of ours */
  thrum_material material; /* a field is NaN where the mesh's own stays */
  const char **materials;  /* material_count texts of region_material.h, as handles */
  int64_t material_count;
  thrum_precompute_options options;
  const char **fixes; /* fix_count specs, pointing into argv */
  int64_t fix_count;
  const char **springs; /* spring_count specs, as fixes */
  int64_t spring_count;
  bool mean_dilatation;   /* of tetrahedra of ten nodes */
  const char *about;      /* the state about which the model is made; NULL: none */
  const char **actuators; /* actuator_count texts NAME=SPEC, as fixes */
  int64_t actuator_count;
  const char **handles; /* handle_count specs, pointing into argv */
  int64_t handle_count;
  const char **train, **tests; /* texts of loads: of the training, and to test it; as handles */
  int64_t train_count, test_count;
  bool by_share;      /* modes and derivatives are weighed by their share in the training */
  double error;       /* wanted under all of them; NaN: the rank is as it is given */
  bool touch;         /* touch modes come beside the rank, */
  bool touch_stepped; /* and are stepped as what is of the rank */
  int64_t rank_max;   /* up to which it grows for that error or these modes; 0: the usual limit */
  double train_time;  /* of each run [s] */
  double train_dt;    /* of the full order and of what is measured against it [s] */
  double train_damping[2];
  const char *keep_runs; /* folder of full-order runs; NULL: none are kept */
  job_request jobs;      /* of a training: one for each of these runs */
  bool condense; /* the file holds the polynomial of the linear modes, the others following */
  // the lines of both in an options file; 0: from elsewhere
  int64_t fix_lines[CONFIG_FILE_ITEMS_MAX], handle_lines[CONFIG_FILE_ITEMS_MAX];
  const char *lines_file;   /* that file */
  const char *import_basis; /* a .U file in place of modes and derivatives; NULL: none */
  const char *import_cubic; /* its .cub file; NULL: the polynomial is made */
  const char *export_modes; /* a .vtu file for the linear modes; NULL: none */
  bool modes_given;         /* the options' modes and rank are the user's, not the defaults */
  bool rank_given;
  bool law_given;
  bool cubature_given; /* one of the options that go with cubature */
  bool dry_run;        /* say what it would take, and no more */
  bool elsewhere;      /* where the factor does not fit, thrum-mpi goes on: refuse, print nothing */
  bool reproducible;   /* meta without times */
  bool free;           /* nothing is to be held: no warning of it */
  bool json;
  bool quiet;
  config_file file; /* of --options; the texts above may point into it */
} precompute_request;

/* The command and its options. */
extern const config_command command_precompute;

/* Fills the request from argv; COMMAND_DONE, or what the command is to return. `fixes`,
 * `springs`, `actuators`, `handles` and `materials` have room for argc + CONFIG_FILE_ITEMS_MAX
 * texts. */
int precompute_options_read(int argc, char **argv, precompute_request *request);

/* The option among those given that one process has and thrum-mpi has not; NULL: there is none. */
const char *precompute_request_alone(const precompute_request *request);

#endif
