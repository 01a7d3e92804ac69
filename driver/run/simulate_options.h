/* Options of `thrum simulate`, parsed. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_SIMULATE_OPTIONS_H
#define THRUM_DRIVER_RUN_SIMULATE_OPTIONS_H

#include "config/options.h"
#include "driver/make/mesh_model.h"
#include "driver/spec/actuate_spec.h"
#include "driver/spec/base_motion_spec.h"
#include "driver/spec/basis_asked.h"
#include "driver/spec/damping_spec.h"
#include "driver/spec/load_spec.h"
#include "driver/spec/start_spec.h"
#include "precompute/full/full.h"

/* A --probe: its text and what that names. */
typedef struct probe_spec {
  const char *name;
  load_target target;
} probe_spec;

typedef struct simulate_request {
  const char *model_path;
  mesh_model_def mesh_def; /* where model_path is a mesh, of the full order */
  const char *run_path;
  thrum_state_def def;
  damping_spec modal;   /* the ratios of modes; its Rayleigh part is in def */
  double time;          /* to simulate [s] */
  int64_t steps;        /* the same in steps */
  int64_t rank;         /* coordinates to step, the lowest; 0: all */
  int64_t condense;     /* the same where the others follow at rest; 0: see model_cut.h */
  int64_t record_every; /* steps between rows of energy.csv and q.npy */
  double frames_rate;   /* frames a second of simulated time; 0: see frames_every */
  int64_t frames_every; /* steps between frames; 0 with rate 0: no frames */
  int64_t load_count;
  load_spec *loads; /* owned by the caller of simulate_options_read */
  int64_t actuate_count;
  actuate_spec *actuates; /* as loads: levels of actuators */
  int64_t base_motion_count;
  base_motion_spec *base_motions; /* the same; read and closed by the run */
  bool full;                      /* the full order in place of the model */
  thrum_full_solver solver;
  thrum_full_quadrature quadrature;
  const thrum_full_shared *shared; /* processes that share its factor; NULL: this one alone */
  thrum_law law;                   /* of the full order, where */
  bool law_given;                  /* and not the model's */
  bool ground;                     /* frames as seen from the ground, not from the base */
  int64_t probe_count;
  probe_spec *probes; /* as loads; none: where the loads act */
  int64_t start_count;
  start_spec *starts; /* the same */
  double spin[3];     /* of a free body at the start [degrees/s]; 0: its frame stays */
  bool stress;        /* von Mises at all nodes and centres */
  bool monitor;       /* default: where there is a mesh */
  bool monitor_given;
  basis_asked basis;   /* of a reduced model that is monitored */
  double against_mesh; /* how long the mesh is stepped beside the model [s]; 0: not at all */
  int64_t threads;     /* of a scene */
  bool json;
  bool quiet;
  config_file file; /* of --options; the texts above may point into it */
} simulate_request;

/* The command and its options. */
extern const config_command command_simulate;

/* Puts the defaults of all options into a zeroed request. */
void simulate_request_begin(simulate_request *request);

/* Fills a zeroed request whose loads, base motions and starts have room for argc +
 * CONFIG_FILE_ITEMS_MAX each. COMMAND_DONE, or what the command is to return. */
int simulate_options_read(int argc, char **argv, simulate_request *request);

#define SIMULATE_STEPS_MAX 1e12 /* years of computing; beyond that an option is a slip */

/* Whether spin and shape of the body are stepped together. */
bool simulate_spins(const simulate_request *request);

/* Steps of a time, 1 or more; 0: more than that. */
int64_t simulate_step_count(double time, double dt);

/* Is one step longer than the run, by more than rounding? It is refused: the run would simulate
 * more than was asked for. */
bool simulate_step_is_longer(double time, double dt);

/* The step of frame `index` (0-based), ascending; INT64_MAX past the end of the run. Only where
 * frames are asked for. */
int64_t simulate_frame_step(const simulate_request *request, int64_t index);

#endif
