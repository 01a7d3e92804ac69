/* Is a state still where its model can be believed? Cheap, optional looks at q and at a load, which
 * raise typed warnings and never print, stop or change anything.
 *
 * - Compression: StVK loses stiffness when squeezed; the force of a bar peaks at stretch 1/sqrt(3),
 *   0.577, beyond which it gives way and finally inverts (design 10). The least principal stretch
 *   of some sampled tetrahedra is watched.
 * - Reach: precompute makes its basis of modes and their derivatives for displacements of about a
 *   tenth of the body's diagonal (design 2). Reach is the largest displacement of some sampled
 *   vertices in that unit.
 * - Load: the share of a load that lies outside span(MU) is not felt at all. It is taken in the
 *   norm of M^-1, of the lumped mass here, after removal of what moves a free body as a whole.
 *
 * A monitor is immutable, holds no pointer but to its model's data copied, and may be shared by any
 * number of threads; what was seen of one state stands in a thrum_monitor_record, a plain struct
 * that is copied and compared like any other.
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

/* Text of one bit; NULL for what is none. Static storage. */
THRUM_API const char *thrum_warning_text(thrum_warning warning);

typedef struct thrum_monitor_def {
  uint32_t cookie;             /* set by thrum_default_monitor_def */
  const int32_t *sampled_tets; /* 0-based tetrahedra; NULL: chosen, see thrum_sampled_tets_choose */
  int64_t sampled_tet_count;   /* default 64; of chosen ones at most 256 and all of the mesh */
  double stretch_least;        /* COMPRESSED below it; default 1/sqrt(3) */
  double reach_most;           /* REACH above it; default 3 */
  double load_share_most;      /* LOAD above it, in [0, 1]; default 1: never */
} thrum_monitor_def;

THRUM_API thrum_monitor_def thrum_default_monitor_def(void);

/* What was seen of one state; zero it with thrum_monitor_clear. */
typedef struct thrum_monitor_record {
  uint32_t warnings;     /* bits of thrum_warning raised since it was cleared */
  uint32_t warnings_now; /* by the last look */
  int64_t looks;
  double stretch;       /* least principal stretch of the sampled tets, last look */
  double stretch_least; /* of all looks; below 0: inverted */
  int32_t stretch_tet;  /* 0-based, where that was; -1: no look yet */
  int32_t pad;
  double reach;      /* last look */
  double reach_most; /* of all looks */
  double load_share; /* of the last load; 0: none was shown */
} thrum_monitor_record;

THRUM_API void thrum_monitor_clear(thrum_monitor_record *record);

/* Opaque: lives at the start of the memory given to thrum_monitor_init. */
typedef struct thrum_monitor thrum_monitor;

#define THRUM_SAMPLED_TETS_MAX 256 /* of those that are chosen */

/* Chooses `count` (1..256) tetrahedra that a body's modes strain most, for the modes in turn from
 * the lowest: (count / rank) each, at least one. *chosen of them, at most `count`, go to `tets`
 * (0-based). Costs 100 operations a tet and mode. */
THRUM_API thrum_status thrum_sampled_tets_choose(const thrum_model *model, int64_t count,
                                                 int32_t *tets, int64_t *chosen,
                                                 thrum_error *error);

/* Bytes of a monitor. Needs a model with a mesh and a basis (THRUM_MISSING otherwise); checks the
 * def. */
THRUM_API thrum_status thrum_monitor_size(const thrum_model *model, const thrum_monitor_def *def,
                                          size_t *size, thrum_error *error);

/* Lays a monitor into `memory`, aligned to 64, at least thrum_monitor_size bytes, which the caller
 * owns. */
THRUM_API thrum_status thrum_monitor_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_monitor_def *def,
                                          const thrum_monitor **monitor, thrum_error *error);

/* Sampled tets of a monitor, 0-based tetrahedra in *tets (valid as long as the monitor); their
 * number.
 */
THRUM_API int64_t thrum_monitor_sampled_tets(const thrum_monitor *monitor, const int32_t **tets);

/* Looks at q (rank) and adds what it sees to the record. Costs about 24 r operations a sampled and
 * 6 r^2; an eigenvalue only for sampled tets that may be the most compressed one so far in this
 * look. THRUM_BAD_VALUE when q is not finite. */
THRUM_API thrum_status thrum_monitor_look(const thrum_monitor *monitor, const double *q,
                                          thrum_monitor_record *record, thrum_error *error);

/* Looks at a load: forces, vertex_count x 3 [N], of the monitor's model. Costs 6 n r. A load that
 * moves nothing has the share 0. */
THRUM_API thrum_status thrum_monitor_look_at_load(const thrum_monitor *monitor,
                                                  const thrum_model *model, const double *forces,
                                                  thrum_monitor_record *record, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
