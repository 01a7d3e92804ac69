/* The material of one region of a mesh, as options say it: REGION:E,NU,RHO.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_REGION_MATERIAL_H
#define THRUM_DRIVER_REGION_MATERIAL_H

#include "config/options.h"
#include "mesh/mesh.h"

typedef struct region_material {
  const char *region; /* `length` bytes of the text */
  size_t length;
  thrum_material values;
} region_material;

/* For the `take` of an option: refuses a text that is no material. */
thrum_status region_material_option_check(const config_given *given);

/* Gives the regions that the texts name their materials; each must be a region of the mesh, named
 * once. *lacking is the first region that no text names; -1: none. */
thrum_status region_materials_apply(const char *const *texts, int64_t count, thrum_mesh *mesh,
                                    int64_t *lacking, thrum_error *error);

#endif
