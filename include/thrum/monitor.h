/* Validity of a state: checks of q and of a load that tell whether the reduced model still holds
 * there. They are cheap and optional; they raise typed warnings and never print, stop or change
 * anything.
 *
 * - Compression: the StVK material loses stiffness in compression; the force of a bar peaks at the
 *   stretch 1/sqrt(3) = 0.577, below which it collapses and finally inverts (design 10). The
 *   monitor takes the least principal stretch of some sampled tetrahedra. In a model of
 *   solid-shells it samples none, as the tetrahedra that show one are strained where it bends.
 * - Reach: precompute makes its basis of modes and their derivatives for displacements of about a
 *   tenth of the body's diagonal (design 2). Reach is the largest displacement of some sampled
 *   vertices in that unit.
 * - Load: the part of a load outside span(MU) has no effect on the reduced body. Its share is taken
 *   in the norm of M^-1, of the lumped mass here, after removal of the part that moves a free body
 *   as a whole.
 *
 * Memory: a monitor is planned (thrum_monitor_size), then laid into the caller's memory
 * (thrum_monitor_init); it copies the model's data that it needs and holds no pointer. Its results
 * for one state are in a thrum_monitor_record, a plain struct that may be copied and compared. No
 * function here allocates.
 *
 * Threads: a monitor is immutable and may be shared by any number of threads; a record belongs to
 * one thread at a time.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MONITOR_H
#define THRUM_MONITOR_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, bit, text) */
#define THRUM_WARNING_LIST(X)                                                                      \
  X(COMPRESSED, 1, "compressed to where the material loses stiffness")                             \
  X(INVERTED, 2, "a tetrahedron is turned inside out")                                             \
  X(REACH, 4, "displaced further than the basis was made for")                                     \
  X(LOAD, 8, "loaded in a way that the basis hardly feels")

typedef enum thrum_warning {
#define X(name, bit, text) THRUM_WARNING_##name = bit,
  THRUM_WARNING_LIST(X)
#undef X
} thrum_warning;

/* Text of one bit; NULL for a number that is no warning. Static storage. Any thread. */
THRUM_API const char *thrum_warning_text(thrum_warning warning);

/* How a monitor is made. Start from thrum_default_monitor_def and change fields. The array is only
 * read while the monitor is planned and made. */
typedef struct thrum_monitor_def {
  /* Set by thrum_default_monitor_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* sampled_tet_count: 0-based tetrahedra of the model. Default NULL: thrum_sampled_tets_choose
   * chooses them. */
  const int32_t *sampled_tets;

  /* Number of sampled tetrahedra; >= 1, at most THRUM_SAMPLED_TETS_MAX where they are chosen;
   * default 64. Larger: local compression is found earlier, and a look costs more. */
  int64_t sampled_tet_count;

  /* Principal stretch below which COMPRESSED is raised [1]; >= 0, default 1/sqrt(3). Larger: the
   * warning comes at a smaller compression. A model with a point_law has 0 in its place, as no
   * other law gives way; of regions with laws of their own those of Saint Venant-Kirchhoff's
   * material are looked at. */
  double stretch_least;

  /* Reach above which REACH is raised, in tenths of the body's diagonal; >= 0, default 3. Larger:
   * the warning comes at larger displacements. */
  double reach_most;

  /* Share of a load without effect above which LOAD is raised [1]; in [0, 1], default 1: never.
   * Larger: fewer loads raise it. */
  double load_share_most;
} thrum_monitor_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_monitor_def_init(thrum_monitor_def *def, size_t size);

/* The same as a value. */
static inline thrum_monitor_def thrum_default_monitor_def(void) {
  thrum_monitor_def def;
  thrum_monitor_def_init(&def, sizeof def);
  return def;
}

/* Results of the looks at one state. The caller owns it and starts it with thrum_monitor_clear. */
typedef struct thrum_monitor_record {
  uint32_t warnings;     /* bits of thrum_warning raised since the record was cleared */
  uint32_t warnings_now; /* bits that the last look raised */
  int64_t looks;         /* looks at q since the record was cleared */
  double stretch;        /* least principal stretch of the sampled tetrahedra in the last look,
                            infinite where there are none */
  double stretch_least;  /* least stretch of all looks; below 0: inverted */
  int32_t stretch_tet;   /* 0-based tetrahedron of stretch_least; -1: none yet */
  int32_t pad;           /* unused, keeps the layout without gaps */
  double reach;          /* reach in the last look [tenths of the diagonal] */
  double reach_most;     /* largest reach of all looks */
  double load_share;     /* share of the last load without effect, in [0, 1]; 0: no load yet */
} thrum_monitor_record;

/* Clears a record: no look, no warning. */
THRUM_API void thrum_monitor_clear(thrum_monitor_record *record);

/* Opaque: lives at the start of the memory given to thrum_monitor_init. */
typedef struct thrum_monitor thrum_monitor;

/* Largest number of tetrahedra that thrum_sampled_tets_choose chooses. */
#define THRUM_SAMPLED_TETS_MAX 256

/* Chooses the tetrahedra that a body's modes strain most, for the modes in turn from the lowest:
 * count / rank each, at least one; count is 1 to THRUM_SAMPLED_TETS_MAX. `tets` (count) gets their
 * 0-based numbers and *chosen how many there are. Costs 100 operations a tetrahedron and mode.
 * THRUM_INVALID_ARGUMENT for NULL or a count out of its range, THRUM_MISSING for a model without a
 * mesh and a basis. Any thread. */
THRUM_API thrum_status thrum_sampled_tets_choose(const thrum_model *model, int64_t count,
                                                 int32_t *tets, int64_t *chosen,
                                                 thrum_error *error);

/* Bytes of a monitor of this model, into *size. Checks the def: THRUM_UNINITIALISED_DEF, or
 * THRUM_INVALID_ARGUMENT with the field; THRUM_MISSING for a model without a mesh and a basis,
 * THRUM_UNSUPPORTED for tetrahedra to sample in one of solid-shells. */
THRUM_API thrum_status thrum_monitor_size(const thrum_model *model, const thrum_monitor_def *def,
                                          size_t *size, thrum_error *error);

/* Lays a monitor into `memory`, aligned to 64 bytes and of at least thrum_monitor_size bytes. The
 * caller owns the memory and frees it when done; *monitor points into it, and the model may go.
 * THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, THRUM_BAD_VALUE for a sampled tetrahedron without a
 * positive volume, or the failures of thrum_monitor_size. */
THRUM_API thrum_status thrum_monitor_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_monitor_def *def,
                                          const thrum_monitor **monitor, thrum_error *error);

/* Returns the number of sampled tetrahedra; *tets (may be NULL) points to their 0-based numbers
 * inside the monitor. 0 and NULL for a monitor that is NULL. */
THRUM_API int64_t thrum_monitor_sampled_tets(const thrum_monitor *monitor, const int32_t **tets);

/* Evaluates stretch and reach at q (rank) and adds them to the record. Costs about 24 r operations
 * a sampled tetrahedron and 6 r^2; an eigenvalue is found only for tetrahedra that may be the most
 * compressed one in this look. THRUM_BAD_VALUE where q is not finite, THRUM_INVALID_ARGUMENT for
 * NULL or a monitor that init did not make. */
THRUM_API thrum_status thrum_monitor_look(const thrum_monitor *monitor, const double *q,
                                          thrum_monitor_record *record, thrum_error *error);

/* Evaluates the share of a load that has no effect, sqrt(1 - |U^T f|^2 / |f|^2), and adds it to the
 * record; forces f: vertex_count x 3 [N]; `model` is the monitor's. A load that deforms nothing has
 * the share 0. Costs 6 n r operations for n vertices. THRUM_BAD_VALUE where a force is not finite,
 * THRUM_INVALID_ARGUMENT for NULL or a model of another shape. */
THRUM_API thrum_status thrum_monitor_look_at_load(const thrum_monitor *monitor,
                                                  const thrum_model *model, const double *forces,
                                                  thrum_monitor_record *record, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
