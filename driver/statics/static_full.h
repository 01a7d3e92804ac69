/* `thrum static --full`: the equilibrium of the whole mesh. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_FULL_H
#define THRUM_DRIVER_STATICS_STATIC_FULL_H

#include "driver/statics/static_report.h"

/* Finds the answer: the report, the coordinates nearest to it into q (rank), the mean displacements
 * and the peak; writes the frame. */
thrum_status static_full_find(static_answer *answer, double *q, thrum_error *error);

#endif
