/* The order of the elements of a model: whether a mesh of linear tetrahedra is taken with ten
 * nodes. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_ELEMENT_ORDER_H
#define THRUM_DRIVER_MAKE_ELEMENT_ORDER_H

#include <cjson/cJSON.h>

#include "config/progress.h"
#include "driver/make/precompute_request.h"

/* Who chose it. */
typedef enum element_order_by {
  ELEMENT_ORDER_MESH,   /* it is that of the mesh, */
  ELEMENT_ORDER_USER,   /* the user's, */
  ELEMENT_ORDER_RECIPE, /* that of a model that comes with Thrum, */
  ELEMENT_ORDER_AUTO    /* or was found by the error of linear tetrahedra */
} element_order_by;

/* How many frequencies a finer mesh is asked for. */
enum { ELEMENT_ORDER_FINER = 2 };

typedef struct element_order {
  element_order_by by;
  /* by how much linear tetrahedra have the first frequencies too high; none where not known */
  int64_t error_count;
  double errors[THRUM_ORDER_ERRORS_MAX];
  /* and by how much ten-node ones do, of a model that has them */
  int64_t cubic_count;
  double cubic_errors[THRUM_CUBIC_ERRORS_MAX];
  /* and hexahedra and wedges, by a finer mesh; none where it would take long */
  int64_t finer_count;
  double finer_errors[ELEMENT_ORDER_FINER];
  char kept[200]; /* why linear ones stay although they lock; "": they do not, or were wanted */
} element_order;

/* Marks what is held of a mesh, of which the array is made: vertex_count bytes. */
typedef thrum_status element_order_hold(const precompute_request *request, const thrum_mesh *mesh,
                                        uint8_t **fixed, thrum_error *error);

/* Chooses the order: where it is left to auto and the mesh is linear, its error is estimated, and
 * beyond 1 % of a frequency the mesh gets its middle nodes and `hold` is called again, if a model
 * of them fits into the memory and does not take too long; the bar shows that it goes on. `read`:
 * it was read from a file, and is not that of a model. */
thrum_status element_order_choose(const precompute_request *request, bool read,
                                  element_order_hold *hold, config_progress *bar, thrum_mesh *mesh,
                                  uint8_t **fixed, element_order *order, thrum_error *error);

/* By how much the first frequencies are too high, omega2 of `modes` of them, by those of a mesh
 * four times as fine, or twice where that has more than 8,000 vertices: the error falls with the
 * square of the elements' size, or faster. Of hexahedra, wedges and solid-shells; not known of
 * larger meshes and of bodies on springs. */
thrum_status element_order_refine(const precompute_request *request, const thrum_mesh *mesh,
                                  const uint8_t *fixed, int64_t modes, const double *omega2,
                                  element_order *order, thrum_error *error);

/* Prints the line that says what was chosen, where ten nodes were. */
void element_order_say(const element_order *order, const thrum_mesh *mesh, const char *name);

/* Adds the order, who chose it, and the errors of linear and of ten-node tetrahedra. */
void element_order_json(cJSON *object, const element_order *order, const thrum_mesh *mesh);

/* Adds "solids", the elements of a mesh that are no plain tetrahedra, in words; none: no key. */
void element_solids_json(cJSON *object, const thrum_mesh *mesh);

#endif
