/* What is known of the error that a basis makes, and how it is told.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_BASIS_ESTIMATE_H
#define THRUM_DRIVER_MODEL_BASIS_ESTIMATE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/spec/basis_asked.h"
#include "io/report.h"
#include "precompute/model/basis_judge.h"

/* Zeroed with `why` set: nothing is known. */
typedef struct basis_estimate {
  double share;        /* rms of what is lacking over that of the motion [1]; NaN: not known */
  bool about;          /* it is no lower bound, but of about this size */
  double velocity;     /* the same of velocities; NaN: not known */
  double shape;        /* the same of the shape of a free body alone; NaN: not known, or not free */
  double until;        /* up to where the run was made again [s]; NaN: it was not */
  int64_t instants;    /* at which the mesh was asked */
  int64_t corrections; /* by which the mesh went on to its own rest; 0: it did not */
  int64_t added;       /* coordinates more that the run was made again with */
  double seconds;      /* that it took; where it was not made, about what it would take */
  bool parted;         /* a scene that was made again parted from it by the last digits */
  const char *why;     /* it is not known; NULL: it is. Static storage. */
} basis_estimate;

/* Nothing is known, for this reason. */
basis_estimate basis_estimate_none(const char *why);

/* The judge of a model, ready for so many looks; NULL, and why, where that would take longer than
 * BASIS_SECONDS_MOST and was not asked for. */
thrum_status basis_estimate_judge(const thrum_model *model, int64_t looks, const basis_asked *asked,
                                  thrum_basis_judge **judge, basis_estimate *estimate,
                                  thrum_error *error);

/* Is the error larger than what is accepted? */
bool basis_estimate_is_large(const basis_estimate *estimate, const basis_asked *asked);

/* "error_estimate" of a report of a run that ends there [s]; NaN: of no run. */
void basis_estimate_json(const basis_estimate *estimate, double end, cJSON *object);

/* The lines of it in a table of that report, or in one for each body, which have the key "name". A
 * table that is of no motion says what it is of by "judged". */
extern const report_line basis_estimate_lines[];

/* What is wrong, as a text of such a line. */
#define BASIS_ESTIMATE_WRONG                                                                       \
  "{error_estimate.kind} {error_estimate.share:%} of the {judged|motion}"                          \
  "[ and {error_estimate.shape_share:%} of the shape]"

/* And, behind it, of how much of a run that is known, where it is not known of all. */
#define BASIS_ESTIMATE_WITHIN                                                                      \
  "{error_estimate.ended?, in the first {error_estimate.until_s:.3g} of {simulated_s:.4g} s}"

/* One warning where the error is large, beginning with `who`. */
void basis_estimate_warn(const basis_estimate *estimate, const basis_asked *asked, const char *who,
                         const char *of);

#endif
