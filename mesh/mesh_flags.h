/* Says what of an examined mesh is probably a mistake.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_FLAGS_H
#define THRUM_MESH_MESH_FLAGS_H

#include "mesh/mesh_examine.h"

/* The list of what may be wrong, as flags that people can act on. X(name, bit) */
#define THRUM_EXAMINE_FLAGS(X)                                                                     \
  X(PIECES, 1)                                                                                     \
  X(COINCIDENT, 2)                                                                                 \
  X(HINGES, 4)                                                                                     \
  X(UNITS, 8)                                                                                      \
  X(DENSITY, 16)                                                                                   \
  X(FAR, 32)                                                                                       \
  X(LOCKING, 64)                                                                                   \
  X(THIN, 128)                                                                                     \
  X(SLIVERS, 256)                                                                                  \
  X(REPAIRED, 512)                                                                                 \
  X(MODULUS, 1024)
typedef enum thrum_examine_flag {
#define X(name, bit) THRUM_EXAMINE_##name = bit,
  THRUM_EXAMINE_FLAGS(X)
#undef X
} thrum_examine_flag;

/* Returns what is to be flagged: thrum_examine_flag, or'ed. */
unsigned thrum_mesh_flags(const thrum_mesh *mesh, const thrum_mesh_examined *examined);
/* The first region of a density that no solid has; -1: none. */
int64_t thrum_mesh_odd_density(const thrum_mesh *mesh);
/* The first region of a Young's modulus that no solid has, by itself or at its density; -1: none.
 */
int64_t thrum_mesh_odd_modulus(const thrum_mesh *mesh);
/* By how much of its length a column of the material, as long as the body's longest side, is
 * compressed at its foot by its own weight on Earth: rho g L / E, the most of all regions. */
double thrum_mesh_weight_strain(const thrum_mesh *mesh, double longest);
/* One line for a person on a flag: what, how much, and what to do. Returns `line`. The density and
 * the modulus need no `examined`. */
const char *thrum_mesh_flag_line(const thrum_mesh *mesh, const thrum_mesh_examined *examined,
                                 thrum_examine_flag flag, char line[300]);

#endif
