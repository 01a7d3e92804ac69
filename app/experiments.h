/* The request of `thrum experiments`, its options, and one function for each kind of experiment,
 * which runs it (validation/experiments), writes its files and prints its result.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_EXPERIMENTS_H
#define THRUM_APP_EXPERIMENTS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/named_model.h"
#include "io/json_table.h"
#include "thrum/thrum.h"
#include "validation/experiments/extremes.h"
#include "validation/experiments/matrix.h"
#include "validation/experiments/sweep.h"

#define EXPERIMENTS_MODELS_MAX 32
#define EXPERIMENTS_AMPLITUDES_MAX 16

typedef enum experiments_kind {
  EXPERIMENTS_MATRIX = 0,
  EXPERIMENTS_LONG = 1,
  EXPERIMENTS_SWEEP = 2,
  EXPERIMENTS_EXTREMES = 3,
  EXPERIMENTS_LINEAR = 4,
  EXPERIMENTS_STEP_SIZES = 5,
  EXPERIMENTS_WORK_PRECISION = 6,
  EXPERIMENTS_VARIABLE = 7
} experiments_kind;

typedef struct experiments_request {
  experiments_kind kind;
  const char *output; /* folder */
  char *list;         /* the text of --models, cut into names; freed by the command */
  const char *models[EXPERIMENTS_MODELS_MAX];
  int64_t model_count;
  bool loads[EXPERIMENT_LOAD_COUNT];
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  bool subjects[EXPERIMENT_SUBJECT_COUNT]; /* of --extremes */
  double amplitudes[EXPERIMENTS_AMPLITUDES_MAX];
  int64_t amplitude_count;
  double time; /* [s] */
  double dt;   /* [s] */
  int64_t steps;
  int64_t threads;
  bool resume;
  bool json;
  bool quiet;
} experiments_request;

/* Fills a zeroed request; COMMAND_DONE, or what the command is to return. */
int experiments_options_read(int argc, char **argv, experiments_request *request);

/* The models asked for, ready to be pushed. */
typedef struct experiments_bodies {
  int64_t count;
  const thrum_model *models[EXPERIMENTS_MODELS_MAX];
  experiment_body bodies[EXPERIMENTS_MODELS_MAX];
} experiments_bodies;

/* *flagged: a run was lost that should not be. The matrix is that of --step-sizes too, and the
 * sweep that of --work-precision and --variable. */
thrum_status experiments_matrix(const experiments_request *request,
                                const experiments_bodies *bodies, bool *flagged,
                                thrum_error *error);
thrum_status experiments_long(const experiments_request *request, const experiments_bodies *bodies,
                              bool *flagged, thrum_error *error);
thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error);
thrum_status experiments_linear(const experiments_request *request,
                                const experiments_bodies *bodies, thrum_error *error);
thrum_status experiments_extremes(const experiments_request *request, bool *flagged,
                                  thrum_error *error);

/* One table of a kind: TABLE.csv, a list of the JSON object, and what is printed. */
typedef struct experiments_table {
  const char *name, *key;
  cJSON *rows;                /* deleted by experiments_publish */
  const json_column *columns; /* NULL: not printed */
} experiments_table;

/* Name of a kind in files and reports; static storage. */
const char *experiments_kind_name(experiments_kind kind);

/* Called by the kinds. Writes the rows as NAME.csv in the folder asked for. */
thrum_status experiments_write_rows(const experiments_request *request, const char *name,
                                    const cJSON *rows, thrum_error *error);

/* The end of a kind: its tables, the page of the first of them, and the result on standard output,
 * one object with all rows or the tables. The files come first, so that a full disk is the last
 * word. */
thrum_status experiments_publish(const experiments_request *request,
                                 const experiments_table *tables, int count, bool flagged,
                                 thrum_error *error);

/* Progress of a pool of tasks; `context` is a config_progress. Never stops it. */
bool experiments_progress(void *context, double fraction);

#endif
