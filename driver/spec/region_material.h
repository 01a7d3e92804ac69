/* The material of one region of a mesh, as options say it: REGION:E,NU,RHO, REGION:LAW or
 * REGION:LAW,YIELD, or both, REGION:E,NU,RHO,LAW,YIELD; or with directions, region_elastic.h.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_REGION_MATERIAL_H
#define THRUM_DRIVER_SPEC_REGION_MATERIAL_H

#include "config/options.h"
#include "mesh/mesh.h"

typedef struct region_material {
  const char *region; /* `length` bytes of the text */
  size_t length;
  thrum_material values; /* of which E is 0 where the text has none */
  const char *elastic;   /* what region_elastic.h reads, to the end of the text; NULL: none */
  bool has_law;
  thrum_region_law law;
} region_material;

/* For the `take` of an option: refuses a text that is no material. */
thrum_status region_material_option_check(const config_given *given);

/* The same of a text that comes from elsewhere; THRUM_BAD_FORMAT or THRUM_BAD_VALUE. */
thrum_status region_material_check(const char *text, thrum_error *error);

/* Whether one of the texts, which were checked, has a law; or one that a polynomial cannot hold. */
bool region_materials_have_laws(const char *const *texts, int64_t count);
bool region_materials_need_points(const char *const *texts, int64_t count);

/* Whether one of them has a yield. */
bool region_materials_flow(const char *const *texts, int64_t count);

/* Gives the regions that the texts name their materials and laws; each must be a region of the
 * mesh, named once. *law is that of regions whose text has none, and becomes THRUM_LAW_BY_REGION
 * where the mesh has laws afterwards: it has none where all regions have one law and no yield.
 * *lacking is the first region whose moduli no text has; -1: none. */
thrum_status region_materials_apply(const char *const *texts, int64_t count, thrum_mesh *mesh,
                                    thrum_law *law, int64_t *lacking, thrum_error *error);

#endif
