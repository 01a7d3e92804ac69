/* Where the body of a run stands in its scene. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_RUN_PLACE_H
#define THRUM_CLI_RUN_PLACE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

/* x = position + R scale (X + U q) + way. */
typedef struct cli_run_place {
  bool placed; /* false: a run of one model, x = X + U q */
  double position[3];
  double rotation[4]; /* w, x, y, z, of length 1 */
  double scale;
} cli_run_place;

/* What a run.json says (`name`: in messages); untouched where it says nothing. */
thrum_status cli_run_place_read(const char *name, const cJSON *object, cli_run_place *place,
                                thrum_error *error);

/* rows x 3, malloc, the caller frees. */
thrum_status cli_run_way_read(const char *path, int64_t rows, double **way, thrum_error *error);

/* A point X + U q in the world; way: of the row (3), or NULL. */
void cli_run_place_point(const cli_run_place *place, const double *way, const double in[3],
                         double out[3]);

#endif
