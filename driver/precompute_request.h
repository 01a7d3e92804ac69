/* What `thrum precompute` was asked for, and what it learned; shared by cmd_precompute.c (the
 * command), precompute_request.c (its options), precompute_make.c (the pipeline), model_name.c
 * (models by name) and precompute_report.c (what is printed and stored).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_PRECOMPUTE_REQUEST_H
#define THRUM_DRIVER_PRECOMPUTE_REQUEST_H

#include "config/options.h"
#include "driver/split_at.h"
#include "precompute/precompute.h"

typedef struct precompute_request {
  const char *mesh_name;
  const char *output;
  double scale;
  thrum_material material; /* a field is NaN where the mesh's own stays */
  thrum_precompute_options options;
  const char **fixes; /* fix_count specs, pointing into argv */
  int64_t fix_count;
  const char **handles; /* handle_count specs, pointing into argv */
  int64_t handle_count;
  // the lines of both in an options file; 0: from elsewhere
  int64_t fix_lines[CONFIG_FILE_ITEMS_MAX], handle_lines[CONFIG_FILE_ITEMS_MAX];
  const char *lines_file;   /* that file */
  const char *import_basis; /* a .U file in place of modes and derivatives; NULL: none */
  const char *import_cubic; /* its .cub file; NULL: the polynomial is made */
  const char *export_modes; /* a .vtu file for the linear modes; NULL: none */
  bool modes_given;         /* the options' modes and rank are the user's, not the defaults */
  bool rank_given;
  bool dry_run;      /* say what it would take, and no more */
  bool reproducible; /* meta without times */
  bool free;         /* nothing is to be held: no warning of it */
  bool json;
  bool quiet;
  config_file file; /* of --options; the texts above may point into it */
} precompute_request;

/* What is known once the model is made, for the table, the JSON line and meta. */
typedef struct precompute_outcome {
  const precompute_request *request;
  const thrum_mesh *mesh;
  const thrum_precomputed *result;
  int64_t fixed_count; /* vertices with any component held */
  bool flagged;
  double dt; /* of the split */
  split_counts split;
  double began; /* clock_seconds() when the command started */
  double seconds_mesh;
  double seconds_write;
  double seconds_total;
} precompute_outcome;

/* The command and its options. */
extern const config_command command_precompute;

/* Fills the request from argv; COMMAND_DONE, or what the command is to return. `fixes` and
 * `handles` have room for argc + CONFIG_FILE_ITEMS_MAX texts. */
int precompute_options_read(int argc, char **argv, precompute_request *request);

/* Reads the mesh, makes the model and writes it to request->output. `show`, which may be NULL, is
 * told the outcome once the file is there. *flagged: residuals are larger than they should be. */
typedef void precompute_show(const precompute_outcome *outcome);
thrum_status precompute_make(const precompute_request *request, precompute_show *show,
                             bool *flagged, thrum_error *error);

/* Prints what the model would take; *flagged: it would not fit. */
thrum_status precompute_dry_run(const precompute_outcome *outcome, const uint8_t *fixed,
                                bool *flagged, thrum_error *error);

/* The JSON text stored as meta; request->reproducible leaves the times out. */
char *precompute_meta(const precompute_request *request, const thrum_mesh *mesh,
                      const thrum_precomputed *result);
void precompute_print_json(const precompute_outcome *outcome);
void precompute_print_table(const precompute_outcome *outcome);

#endif
