/* Figures of the thesis. Its table of the undamped impulse repeats the undamped square load, and
 * its table of the undamped sine repeats the Newmark columns of another: neither is data.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/thesis.h"

#include <math.h>
#include <string.h>

typedef struct thesis_model {
  const char *name;
  int explicit_modes, implicit_modes;
  double square_free; /* speed-up, undamped */
  double impulse_damped, square_damped, sine_damped;
  double sine_free_lost, sine_damped_lost; /* [s]; 0: not lost */
} thesis_model;

static const thesis_model table[] = {
    {"beam", 9, 6, 1.50, 1.05, 1.35, 1.29, 6.86, 7.12},
    {"basket", 15, 5, 1.87, 1.40, 2.32, 1.96, 0, 0},
    {"bridge", 13, 2, 1.65, 3.45, 1.42, 1.67, 0, 0},
    {"horse", 9, 6, 1.58, 3.36, 1.61, 1.59, 0, 0},
    {"tower", 11, 9, 1.41, 1.51, 1.10, 1.24, 10.53, 0},
    {"heart", 27, 3, 2.37, 2.57, 1.75, 1.46, 0, 0},
};

static const thesis_model *find(const char *name) {
  for (size_t n = 0; n < sizeof table / sizeof table[0]; n++) {
    if (strcmp(table[n].name, name) == 0)
      return &table[n];
  }
  return NULL;
}

double experiment_thesis_speedup(const char *model, experiment_load load, double alpha) {
  const thesis_model *row = find(model);
  if (row == NULL)
    return NAN;
  if (alpha > 0) {
    const double damped[EXPERIMENT_LOAD_COUNT] = {row->impulse_damped, row->square_damped,
                                                  row->sine_damped};
    return damped[load];
  }
  return load == EXPERIMENT_LOAD_square ? row->square_free : NAN;
}

bool experiment_thesis_split(const char *model, int *explicit_modes, int *implicit_modes) {
  const thesis_model *row = find(model);
  if (row == NULL)
    return false;
  *explicit_modes = row->explicit_modes;
  *implicit_modes = row->implicit_modes;
  return true;
}

double experiment_thesis_lost(const char *model, experiment_load load, double alpha) {
  const thesis_model *row = find(model);
  if (row == NULL || load != EXPERIMENT_LOAD_sine)
    return NAN;
  const double lost = alpha > 0 ? row->sine_damped_lost : row->sine_free_lost;
  return lost > 0 ? lost : NAN;
}
