/* The figures of the 2011 thesis that ours stand beside. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_THESIS_H
#define THRUM_VALIDATION_EXPERIMENTS_THESIS_H

#include "validation/experiments/matrix.h"

/* Seconds that its Newmark took over those of its IMEXv for the same 30 s at h = 0.003 s (Intel
 * Core i5-760); NaN where it has no such figure. */
double experiment_thesis_speedup(const char *model, experiment_load load, double alpha);

/* Its numbers of explicit and implicit modes; false for a model that it does not have. */
bool experiment_thesis_split(const char *model, int *explicit_modes, int *implicit_modes);

/* Seconds after which its IMEXv run was lost; NaN where it was not. */
double experiment_thesis_lost(const char *model, experiment_load load, double alpha);

#endif
