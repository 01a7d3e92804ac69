/* The request of `thrum tradeoff` and its options. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_TRADEOFF_OPTIONS_H
#define THRUM_APP_TRADEOFF_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "driver/make/mesh_model.h"
#include "driver/spec/job_list.h"
#include "driver/spec/load_spec.h"
#include "validation/tradeoff/tradeoff.h"

/* Whether models of cubature points are tried beside those of polynomials. */
typedef enum tradeoff_cubature {
  TRADEOFF_CUBATURE_AUTO, /* where they may be cheaper; alone where no polynomial holds the law */
  TRADEOFF_CUBATURE_OFF,
  TRADEOFF_CUBATURE_ONLY
} tradeoff_cubature;

typedef struct tradeoff_request {
  const char *model_path;
  mesh_model_def mesh_def; /* where model_path is a mesh */
  const char *output;      /* folder */
  load_spec *loads;        /* room for argc, of the caller */
  int64_t load_count;
  const char **tests; /* texts of the loads of a test, each of its own; room for argc */
  int64_t test_count;
  const char *keep_runs; /* folder of full-order runs; NULL: none are kept */
  bool no_tests;         /* not those of a model by name either */
  int64_t rank_max;      /* of the search; 0: none */
  bool condense;         /* linear modes alone are tried, too */
  double time;           /* [s] */
  double full_dt;        /* [s]; 0: by --quick */
  double damping[2];
  double error;  /* NaN: not asked */
  bool by_worse; /* it is the larger of those of displacement and velocity */
  double budget; /* processor time of a frame [s]; NaN: not asked */
  double fps;
  /* 0 of a list: the default */
  int64_t rank_count, dt_count, tolerance_count;
  double ranks[TRADEOFF_LIST_MAX], dts[TRADEOFF_LIST_MAX], tolerances[TRADEOFF_LIST_MAX];
  bool integrators[EXPERIMENT_SCHEME_COUNT];
  bool precisions[2]; /* which precisions are tried: double, single */
  thrum_law law;      /* of the material, where it is given; else the model's */
  bool law_given;
  tradeoff_cubature cubature;
  int64_t cubature_count; /* of errors of the force, falling; 0: the default */
  double cubature_errors[TRADEOFF_POINTS_MAX];
  int64_t cubature_refine;
  int64_t threads;
  job_request jobs;
  bool quick;
  bool json;
  bool quiet;
} tradeoff_request;

/* Fills a zeroed request; COMMAND_DONE, or what the command is to return. */
int tradeoff_options_read(int argc, char **argv, tradeoff_request *request);

#endif
