/* Rows of a run that are kept for the judgement of its basis, and the forces that acted on its mesh
 * then. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_BASIS_RECORD_H
#define THRUM_DRIVER_RUN_BASIS_RECORD_H

#include "driver/model/basis_estimate.h"
#include "driver/run/simulate_options.h"

/* A row of the run. */
typedef struct basis_row {
  int64_t step;
  double size;          /* |q|^2 */
  double *q, *p;        /* rank each; of the memory of the record */
  double placement[16]; /* of the body in its scene, as thrum_scene_body_matrix has it */
} basis_row;

#define BASIS_ROWS_MAX 256 /* even */

/* A zeroed one keeps nothing. */
typedef struct basis_record {
  const simulate_request *request;
  const thrum_model *model;
  basis_row rows[BASIS_ROWS_MAX + 1]; /* the last is the one of the largest motion */
  double *memory;
  int64_t count, stride, seen; /* rows kept; of how many one is kept; seen */
  basis_estimate estimate;
} basis_record;

/* Keeps rows of a run of this model. The request and the model must stay. */
thrum_status basis_record_open(const simulate_request *request, const thrum_model *model,
                               basis_record *record, thrum_error *error);
void basis_record_close(basis_record *record);

/* Takes in a row: q and p (rank each) after so many steps, and where the body is; NULL: it is
 * alone.
 */
void basis_record_note(basis_record *record, int64_t step, const double *q, const double *p,
                       const double *placement);

/* A load at its full strength on all components [N]; masses: of the vertices. */
thrum_status basis_record_load(const basis_record *record, const double *masses,
                               const load_spec *load, double *forces, thrum_error *error);

/* forces += what turns with --spin throws outwards, at rest in its shape [N]. */
void basis_record_add_spin(const basis_record *record, const double *masses, double *forces);

/* All forces of the request after so many steps [N]; one: scratch, both 3 vertex_count. */
thrum_status basis_record_forces(const basis_record *record, const double *masses, int64_t step,
                                 double *one, double *forces, thrum_error *error);

#endif
