/* The request of `thrum experiments`, its options, and one function for each kind of experiment,
 * which runs it (validation/experiments), writes its files and prints its result.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_EXPERIMENTS_H
#define THRUM_APP_EXPERIMENTS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/make/named_model.h"
#include "driver/spec/job_list.h"
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
  EXPERIMENTS_VARIABLE = 7,
  EXPERIMENTS_KIND_COUNT
} experiments_kind;

/* One table of a kind: TABLE.csv, a list of the JSON object, and what is printed. */
typedef struct experiments_table {
  const char *name;           /* NULL: that of the kind */
  const char *key;            /* in the JSON object; NULL: there is no such table */
  const json_column *columns; /* NULL: not printed */
} experiments_table;

/* The files of a kind: its tables, and a long list that is written as it is, such as curves. */
#define EXPERIMENTS_TABLES_MAX 2
typedef struct experiments_form {
  experiments_table tables[EXPERIMENTS_TABLES_MAX];
  const char *list;    /* its file, whose first line names the columns; NULL: none */
  const char *heading; /* lines above the printed table; NULL: none */
} experiments_form;

typedef struct experiments_request {
  experiments_kind kind;
  const char *name;             /* of the kind, in files and reports */
  const experiments_form *form; /* what it writes */
  const char *output;           /* folder */
  char *list;                   /* the text of --models, cut into names; freed by the command */
  const char *models[EXPERIMENTS_MODELS_MAX];
  int64_t model_count;
  bool loads[EXPERIMENT_LOAD_COUNT];
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  bool subjects[EXPERIMENT_SUBJECT_COUNT]; /* of --extremes */
  bool starts[EXPERIMENT_START_COUNT];     /* of the sweep and what is made of it, */
  const experiment_dt *dts;                /* with its time steps */
  int64_t dt_count;
  double amplitudes[EXPERIMENTS_AMPLITUDES_MAX];
  int64_t amplitude_count;
  double time; /* [s] */
  double dt;   /* [s] */
  int64_t steps;
  int64_t threads;
  job_request jobs;
  cJSON *result; /* of one job: its rows go here, and no file is written; NULL: all at once */
  bool resume;
  bool json;
  bool quiet;
} experiments_request;

/* Fills a zeroed request; COMMAND_DONE, or what the command is to return. */
int experiments_options_read(int argc, char **argv, experiments_request *request);

/* The models asked for, ready to be pushed. */
typedef struct experiments_bodies {
  int64_t count;
  const thrum_model *models[EXPERIMENTS_MODELS_MAX]; /* NULL: not loaded, and without its body */
  experiment_body bodies[EXPERIMENTS_MODELS_MAX];
} experiments_bodies;

/* Loads the model with this number into the bodies, and makes its body. */
thrum_status experiments_body_load(const experiments_request *request, int64_t n,
                                   experiments_bodies *bodies, thrum_error *error);

void experiments_bodies_free(experiments_bodies *bodies);

/* An experiment with the bodies. *flagged: a run was lost that should not be. */
typedef thrum_status experiments_runner(const experiments_request *request,
                                        const experiments_bodies *bodies, bool *flagged,
                                        thrum_error *error);

/* The experiment that the request asks for. */
experiments_runner experiments_run;

/* One of its jobs, the list of them, or the report of their results; *flagged: also where jobs are
 * missing. argv is that of the command. */
thrum_status experiments_jobs(const experiments_request *request, char *const *argv, bool *flagged,
                              thrum_error *error);

/* The kinds. The matrix is that of --step-sizes too, and the sweep that of --work-precision and
 * --variable. */
experiments_runner experiments_matrix, experiments_long, experiments_sweep, experiments_linear,
    experiments_extremes;

extern const experiments_form experiments_matrix_form, experiments_long_form,
    experiments_sweep_form, experiments_extremes_form, experiments_linear_form;

/* Fills in the name and the form of the kind. */
void experiments_kind_fill(experiments_request *request);

/* The results of an experiment, and the names of those that are missing. */
typedef struct experiments_outcome {
  cJSON *rows[EXPERIMENTS_TABLES_MAX]; /* of the tables; deleted by experiments_publish */
  void (*write_list)(FILE *stream, const void *of);
  const void *of;
  bool flagged;
  const cJSON *missing; /* names of jobs that the rows lack; NULL: none */
} experiments_outcome;

/* Called by the kinds. Writes the rows as NAME.csv in the folder asked for, and a list. */
thrum_status experiments_write_rows(const experiments_request *request, const char *name,
                                    const cJSON *rows, thrum_error *error);
thrum_status experiments_write_list(const experiments_request *request, const char *file,
                                    const experiments_outcome *outcome, thrum_error *error);

/* The end of a kind: its files, the page of its first table, and the result on standard output, one
 * object with all rows or the tables. The files come first, so that a full disk is the last word.
 * The rows and the list of a single job go into the result of the request. */
thrum_status experiments_publish(const experiments_request *request,
                                 const experiments_outcome *outcome, thrum_error *error);

/* Progress of a pool of tasks; `context` is a config_progress. Never stops it. */
bool experiments_progress(void *context, double fraction);

#endif
