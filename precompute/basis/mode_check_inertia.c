/* Counting eigenvalues below a shift, see mode_check.h. MUMPS (Amestoy, Duff, L'Excellent, Koster
 * 2001, doi:10.1137/S0895479899358194) factorises K - shift M as L D L^T with pivots of one and
 * two rows and counts the negative ones; it is optional, because its factor serves nothing else
 * here. SPDX-License-Identifier: Apache-2.0 */
#include "platform/allocate.h"
#include "precompute/basis/mode_check.h"

#if defined(THRUM_HAVE_MUMPS)

#include <dmumps_c.h>

#define USE_COMM_WORLD (-987654)
enum { JOB_START = -1, JOB_END = -2, JOB_FACTOR = 4, JOB_FACTOR_AGAIN = 2 };

/* Room for delayed pivots, in percent of what MUMPS expects: thin bodies delay many. */
enum { ROOM_LEAST = 50, ROOM_MOST = 10000 };

static bool lacks_room(const DMUMPS_STRUC_C *mumps) {
  return mumps->infog[0] == -8 || mumps->infog[0] == -9;
}

typedef struct triplets {
  MUMPS_INT *row, *column; /* from 1 */
  double *value;
} triplets;

// both matrices have one pattern, except that a lumped mass has its diagonal alone
static thrum_status triplets_make(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                  double shift, triplets *t, thrum_scope *memory) {
  const int64_t entries = stiffness->begin[stiffness->size];
  t->row = thrum_scope_allocate(memory, entries, sizeof *t->row);
  t->column = thrum_scope_allocate(memory, entries, sizeof *t->column);
  t->value = thrum_scope_allocate(memory, entries, sizeof *t->value);
  THRUM_TRY(memory->status);

  // K - shift M in MUMPS's coordinates, which count from 1
  for (int64_t j = 0; j < stiffness->size; j++) {
    int64_t other = mass->begin[j];
    for (int64_t e = stiffness->begin[j]; e < stiffness->begin[j + 1]; e++) {
      t->row[e] = (MUMPS_INT)(stiffness->row[e] + 1);
      t->column[e] = (MUMPS_INT)(j + 1);
      t->value[e] = stiffness->value[e];
      if (other < mass->begin[j + 1] && mass->row[other] == stiffness->row[e])
        t->value[e] -= shift * mass->value[other++];
    }
  }
  return THRUM_OK;
}

// sets MUMPS up; its manual numbers the settings from 1
static void settings(DMUMPS_STRUC_C *mumps) {
  for (int stream = 0; stream < 4; stream++)
    mumps->icntl[stream] = 0;
  mumps->icntl[6] = 5;  // METIS
  mumps->icntl[12] = 1; // the last pivots are counted too
  mumps->icntl[13] = ROOM_LEAST;
  mumps->icntl[30] = 1; // no factor is kept
}

bool thrum_inertia_available(void) {
  return true;
}

thrum_status thrum_inertia_count(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                 double shift, int64_t *count, thrum_error *error) {
  triplets t = {0};
  thrum_scope memory = thrum_scope_begin("the inertia count", error);
  thrum_status status = triplets_make(stiffness, mass, shift, &t, &memory);

  // a fresh instance of MUMPS for symmetric indefinite matrices
  if (status >= 0) {
    DMUMPS_STRUC_C mumps = {.job = JOB_START, .par = 1, .sym = 2, .comm_fortran = USE_COMM_WORLD};
    dmumps_c(&mumps);

    // its factorisation counts the negative pivots
    if (mumps.infog[0] >= 0) {
      settings(&mumps);
      mumps.n = (MUMPS_INT)stiffness->size;
      mumps.nnz = stiffness->begin[stiffness->size];
      mumps.irn = t.row;
      mumps.jcn = t.column;
      mumps.a = t.value;
      mumps.job = JOB_FACTOR;
      dmumps_c(&mumps);
    }

    // with more room where it was short
    while (lacks_room(&mumps) && mumps.icntl[13] < ROOM_MOST) {
      mumps.icntl[13] *= 4;
      mumps.job = JOB_FACTOR_AGAIN;
      dmumps_c(&mumps);
    }

    if (mumps.infog[0] < 0)
      status = thrum_error_set(error, THRUM_NOT_CONVERGED,
                               "the inertia count failed (MUMPS code %d, %d): check the modes by "
                               "search alone, --check search",
                               (int)mumps.infog[0], (int)mumps.infog[1]);
    else
      *count = mumps.infog[11];

    // the instance is ended in either case
    mumps.job = JOB_END;
    dmumps_c(&mumps);
  }

  thrum_scope_free(&memory);
  return status;
}

#else

bool thrum_inertia_available(void) {
  return false;
}

thrum_status thrum_inertia_count(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                 double shift, int64_t *count, thrum_error *error) {
  (void)stiffness, (void)mass, (void)shift, (void)count;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "this thrum was built without MUMPS, which counts modes: build it with "
                         "libmumps-seq-dev, or check by search");
}

#endif
