/* Systems of units of mesh files, such as mm-t-s: millimetres, tonnes and seconds, in which decks
 * of parts are often written, with stresses in MPa and densities in t/mm^3.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_UNITS_H
#define THRUM_MESH_MESH_UNITS_H

#include "mesh/mesh.h"

/* The units of a file, in SI. */
typedef struct thrum_mesh_unit {
  double length;  /* [m] */
  double stress;  /* [Pa] */
  double density; /* [kg/m^3] */
} thrum_mesh_unit;

/* Reads LENGTH-MASS-TIME: m, cm, mm or um; kg, g or t; s or ms. */
thrum_status thrum_mesh_unit_read(const char *text, thrum_mesh_unit *unit, thrum_error *error);

/* Turns the materials of a mesh into SI; its lengths stay. */
void thrum_mesh_unit_materials(const thrum_mesh_unit *unit, thrum_mesh *mesh);

#endif
