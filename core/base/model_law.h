/* Which law of elasticity a model names, for each region of it, and the yield of each (design 19);
 * the laws themselves are runtime/material/. Private to Thrum's libraries, see model_law.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_MODEL_LAW_H
#define THRUM_CORE_BASE_MODEL_LAW_H

#include <stdbool.h>
#include <stddef.h>

#include "thrum/model.h"

/* X(name, value, text) */
#define THRUM_LAW_LIST(X)                                                                          \
  X(STVK, 0, "stvk")                 /* Saint Venant-Kirchhoff */                                  \
  X(COROTATIONAL, 1, "corotational") /* linear elasticity of F without its rotation */             \
  X(NEO_HOOKEAN, 2, "neo-hookean")   /* stable neo-Hookean: Smith, De Goes & Kim 2018 */

typedef enum thrum_law {
#define X(name, value, text) THRUM_LAW_##name = value,
  THRUM_LAW_LIST(X)
#undef X
      THRUM_LAW_BY_REGION =
          3 /* no law of its own: each region of the body has one of those above */
} thrum_law;

/* The law called `name`, of `length` characters, into *law; false where there is none. */
bool thrum_law_find(const char *name, size_t length, thrum_law *law);

/* The name of a law; THRUM_LAW_BY_REGION has words for messages, which are no name. */
const char *thrum_law_name(thrum_law law);

/* The law of a model's material: that of its cubature points, whose name was checked. */
thrum_law thrum_law_of_model(const thrum_model *model);

/* The same of one region of it, never THRUM_LAW_BY_REGION. */
thrum_law thrum_law_of_region(const thrum_model *model, int64_t region);

/* Whether `law`, or that of a region where it is THRUM_LAW_BY_REGION, is Saint Venant-Kirchhoff's,
 * which gives way under compression. */
bool thrum_law_gives_way(const thrum_model *model, thrum_law law);

/* The strain beyond which region `region` flows, where `yield` is that of regions that have none of
 * their own; infinite for Saint Venant-Kirchhoff material among other laws. */
double thrum_law_yield(const thrum_model *model, int64_t region, double yield);

/* Whether a region has a yield of its own. */
bool thrum_law_has_yield(const thrum_model *model);

#endif
