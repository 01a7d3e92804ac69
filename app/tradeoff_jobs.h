/* `thrum tradeoff` in independent jobs: one for each recipe of a basis with all of its settings,
 * those included that the search may go on with, and one for the full order of each test.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_TRADEOFF_JOBS_H
#define THRUM_APP_TRADEOFF_JOBS_H

#include <cjson/cJSON.h>

#include "app/tradeoff_options.h"
#include "driver/make/full_motion_kept.h"

/* The jobs of one call, and the results that are collected. */
typedef struct tradeoff_jobs {
  const tradeoff_request *request;
  tradeoff_problem *problem;
  char kept[FULL_MOTION_PATH_MAX]; /* folder of full-order runs, where the problem names none */
  int64_t recipe_count;
  tradeoff_recipe recipes[TRADEOFF_BASES_MAX];             /* then come the tests */
  cJSON *results[TRADEOFF_BASES_MAX + TRADEOFF_TESTS_MAX]; /* NULL: not there; owned */
  bool missed[TRADEOFF_BASES_MAX + TRADEOFF_TESTS_MAX];    /* asked for, and not there */
} tradeoff_jobs;

/* Prints the jobs or runs one, as the request says. Full-order runs are kept in the folder of the
 * results where the problem names no other. argv is that of the command. */
thrum_status tradeoff_jobs_run(const tradeoff_request *request, tradeoff_problem *problem,
                               char *const *argv, thrum_error *error);

/* Reads the results that are there, and lets the problem take them, until tradeoff_jobs_close. */
thrum_status tradeoff_jobs_open(const tradeoff_request *request, tradeoff_problem *problem,
                                tradeoff_jobs *jobs, thrum_error *error);
void tradeoff_jobs_close(tradeoff_jobs *jobs);

/* Once it is solved: the names of the jobs that were asked for and are not there, in an array that
 * the caller deletes; warns of them. */
cJSON *tradeoff_jobs_missing(tradeoff_jobs *jobs);

#endif
