/* A run that is made again with a richer model. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_BASIS_RERUN_H
#define THRUM_DRIVER_RUN_BASIS_RERUN_H

#include "driver/run/basis_record.h"
#include "precompute/richer_model.h"

/* Makes the run again with directions that the judge found, and puts what differs into the
 * record's estimate. Where that takes too long, or cannot be done, the estimate stays. seconds:
 * that the steps of the run took, by which those again are bounded. */
thrum_status basis_rerun(basis_record *record, const thrum_basis_judge *judge, double seconds,
                         thrum_error *error);

/* The time that the steps of a run may take that is made again, beside those of the run [s];
 * INFINITY where --judge on asks for it. */
double basis_rerun_seconds(const basis_asked *asked, double seconds);

/* Why a model cannot be made richer and stepped by this integrator; NULL: it can. */
const char *basis_rerun_why_not(const thrum_model *model, thrum_integrator integrator);

/* How many coordinates may be added so that the polynomial takes no more than *flops, which becomes
 * what is left; 0: too few to be worth it. */
int64_t basis_rerun_added(const thrum_model_statics *statics, const thrum_model *model,
                          double *flops);

/* q and p of the richer model at the start: those of the run, but for an equilibrium its own. */
thrum_status basis_rerun_start(const basis_record *record, const thrum_richer_model *richer,
                               double *q, double *p, thrum_error *error);

#endif
