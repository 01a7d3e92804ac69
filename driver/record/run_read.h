/* The motion of a finished run, for other programs. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_READ_H
#define THRUM_DRIVER_RECORD_RUN_READ_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "driver/model/model_hash.h"
#include "driver/record/run_folder.h"
#include "driver/record/run_placement.h"
#include "thrum/thrum.h"

#define RECORDED_ERROR_MAX 160

/* The run that `thrum simulate` left in a folder. */
typedef struct recorded_run {
  const thrum_model *model;
  char *model_path; /* the file that it was read from */
  int64_t rank;     /* of q: the run's, at most the model's */
  int64_t rows;
  double *times;    /* rows, ascending [s] */
  double *q;        /* rows x rank */
  double *energies; /* rows x 2: kinetic, strain [J] */
  run_placement place;
  char stepped_by[128];           /* what stepped it, for people; "": the run does not say */
  char error[RECORDED_ERROR_MAX]; /* what the basis has wrong, for people; "": the run does not say
                                   */
  double load_work;               /* of all loads [J]; NaN: the run does not say */
  bool full;      /* the whole mesh was stepped, of which q has what the basis has */
  double *places; /* rows x RUN_PLACEMENT_COLUMNS; NULL: the body stays where it stands */
} recorded_run;

/* Is there a run.json in the folder? */
bool is_run_folder(const char *path);

/* Refuses a folder in which no run is, neither of a model nor of a scene; `or_else` is what else
 * may be named, such as ", or a model file". Paths of anything but folders pass, and so do names of
 * models that come with Thrum, whatever folder has one. */
thrum_status recorded_folder_check(const char *path, const char *or_else, thrum_error *error);

/* A path with a file in RUN or beside it. */
typedef char recorded_path[RUN_PATH_MAX + 300];

/* Finds a file that the run in `folder` was made of, perhaps by a command in another folder than
 * this one: under its name from here, else from RUN or one of the folders above it, else beside
 * RUN. With the hash of a model files of that name that are other ones are passed over, unless
 * there is no other. Returns `path`, or `name` where it is there from here or nowhere. */
const char *recorded_run_find(const char *folder, const char *name, const model_hash *hash,
                              recorded_path path);

/* Loads the model that was used in `folder`, by the name that is noted there or, where it is
 * `given`, by another. Refuses another model than that of the hash. *model and *model_path are the
 * caller's to free, also on failure. */
thrum_status recorded_model_load(const char *folder, const char *name, const model_hash *hash,
                                 bool given, const thrum_model **model, char **model_path,
                                 thrum_error *error);

/* Reads RUN/run.json, energy.csv (times), q.npy and the model: `model` when it is not NULL, else
 * the one that run.json names (recorded_run_find). Refuses another model than the one
 * that the run was made with (model_hash_matches). recorded_run_free frees, the model too. */
thrum_status recorded_run_read(const char *path, const char *model, recorded_run *run,
                               thrum_error *error);
void recorded_run_free(recorded_run *run);

/* Whether recorded_run_read would find what it reads: the files of the run, and its model, which is
 * not loaded where its bytes are those of the run. Otherwise what is missing. */
thrum_status recorded_run_check(const char *folder, thrum_error *error);

/* The file of a folder. */
void recorded_path_join(recorded_path path, const char *folder, const char *name);

/* Is `path` one of these files of the folder, by whatever name? */
bool recorded_folder_holds(const char *folder, const char *const *names, size_t count,
                           const char *path);

/* Was the run in the folder read from this file? Nothing may be written there. */
bool recorded_run_holds(const char *folder, const recorded_run *run, const char *path);

/* Is row n kept where `kept` rows before it are: is it the first at or past the next moment, or the
 * last of all? */
bool recorded_run_keeps(const recorded_run *run, int64_t n, int64_t kept, double rate);

/* Keeps the rows that are nearest to `rate` a second, none twice, and the last; 0: all. */
void recorded_run_thin(recorded_run *run, double rate);

#endif
