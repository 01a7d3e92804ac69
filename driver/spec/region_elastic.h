/* Elasticity with directions of one region, as options say it behind REGION:
 *   ortho,E1,E2,E3,NU12,NU13,NU23,G12,G13,G23,RHO  or  transverse,E1,E2,NU12,NU23,G12,RHO,
 * direction 1 the fibre's, then  ,along,X,Y,Z  or  ,along,X,Y,Z,X,Y,Z  and  ,layers,0/90/90/0  or
 * ,layers,0@1/90@2. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_REGION_ELASTIC_H
#define THRUM_DRIVER_SPEC_REGION_ELASTIC_H

#include "mesh/elastic.h"

typedef struct region_elastic {
  int64_t count;
  double rows[THRUM_ELASTIC_LAYERS_MAX * THRUM_ELASTIC_NUMBERS];
  double density;
} region_elastic;

/* Does a text begin with one of the words? */
bool region_elastic_is(const char *at, const char *end);

/* Reads it; THRUM_BAD_FORMAT or THRUM_BAD_VALUE, with `text` in the message. */
thrum_status region_elastic_parse(const char *text, const char *at, const char *end,
                                  region_elastic *made, thrum_error *error);

#endif
