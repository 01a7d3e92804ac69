/* Looks at how far the answer of a reduced model can be believed.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_MONITOR_H
#define THRUM_DRIVER_STATICS_STATIC_MONITOR_H

#include "driver/statics/static_report.h"

/* Looks at answer->q: compression, and how far the whole mesh would go on. What cannot be looked
 * at is NaN, or told with the reason. */
thrum_status static_monitor_look(const static_answer *answer, static_belief *belief,
                                 thrum_error *error);

/* One warning for each thing that is not to be believed. */
void static_monitor_warn(const static_answer *answer);

#endif
