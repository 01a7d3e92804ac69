/* A run that is made again with a richer model. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_BASIS_RERUN_H
#define THRUM_DRIVER_BASIS_RERUN_H

#include "driver/basis_record.h"
#include "precompute/model/basis_judge.h"

/* Makes the run again with directions that the judge found, and puts what differs into the
 * record's estimate. Where that takes too long, or cannot be done, the estimate stays. */
thrum_status basis_rerun(basis_record *record, const thrum_basis_judge *judge, thrum_error *error);

#endif
