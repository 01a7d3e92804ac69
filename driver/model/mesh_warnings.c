/* Warnings of the changes that reading a mesh made to it, and of its faults.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/mesh_warnings.h"

#include <math.h>
#include <string.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_flags.h"

/* The first frequencies of beams of ten nodes, 5 and 33 times as long as thick, are off from the
 * limit of 1/2 by 2e-5 and 1e-3 at 0.4999999, 2e-5 and 3e-2 at 0.49999999. */
#define ROUNDED_POISSON 0.49999

/* Solids that carry themselves are compressed by less than a hundredth by their own weight, rubber
 * buffers and gels of the kitchen by up to a tenth; those of a few metres may be seen without it.
 */
#define CRUSHED 0.1
#define LONG 10.0 /* [m] */

void mesh_warnings_print(const thrum_mesh *mesh, const char *name,
                         const thrum_mesh_read_options *reading) {
  // what the reader has made of the file
  for (int64_t n = 0; n < mesh->note_count; n++)
    config_warn("%s: %s", name, mesh->notes[n].text);
  if (mesh->cornered_tets > 0 && mesh->solid_count > 0)
    config_warn("%s: its elements were read by their corners, without their middle nodes", name);
  else if (mesh->cornered_tets > 0) {
    config_warn("%s: %lld tetrahedra of ten nodes were read by their corners", name,
                (long long)mesh->cornered_tets);
  }
  if (mesh->flipped_tets > 0) {
    config_warn("%s: %s inside out; %lld flipped", name,
                mesh->flipped_tets == mesh->tet_count ? "every tetrahedron was"
                                                      : "some tetrahedra were",
                (long long)mesh->flipped_tets);
  }
  if (mesh->dropped_vertices > 0) {
    config_warn("%s: %lld vertices that no tetrahedron uses were dropped", name,
                (long long)mesh->dropped_vertices);
  }

  // only faults that make a model fall apart are named here; `thrum check` lists all
  static const thrum_examine_flag grave[] = {THRUM_EXAMINE_PIECES, THRUM_EXAMINE_COINCIDENT,
                                             THRUM_EXAMINE_HINGES, THRUM_EXAMINE_FAR};
  thrum_mesh_examined examined;
  if (thrum_mesh_examine(mesh, &examined, NULL) < 0)
    return;
  const unsigned flags = thrum_mesh_flags(mesh, &examined);
  char question[300];
  if ((flags & THRUM_EXAMINE_UNITS) && reading != NULL && !thrum_mesh_unit_is_said(reading))
    config_warn("%s: %s", name,
                thrum_mesh_flag_line(mesh, &examined, THRUM_EXAMINE_UNITS, question));
  for (size_t i = 0; i < sizeof grave / sizeof *grave; i++) {
    char line[300];
    if (flags & grave[i])
      config_warn("%s: %s", name, thrum_mesh_flag_line(mesh, &examined, grave[i], line));
  }
}

void mesh_notes_object(cJSON *object, const thrum_mesh *mesh) {
  cJSON *notes = cJSON_AddArrayToObject(object, "notes");
  for (int64_t n = 0; n < mesh->note_count; n++)
    cJSON_AddItemToArray(notes, cJSON_CreateString(mesh->notes[n].text));
}

/* Of a file whose unit was said the options may be in it, too, which they never are. */
static void warn_material(const thrum_mesh *mesh, const char *name, const char *unit,
                          thrum_examine_flag flag) {
  char line[300];
  thrum_mesh_flag_line(mesh, NULL, flag, line);
  if (unit == NULL) {
    config_warn("%s: %s", name, line);
    return;
  }
  config_warn("%s: %.*s; options are in Pa and kg/m^3 whatever --unit says, and materials of the "
              "file were taken to be in %s",
              name, (int)strcspn(line, ";"), line, unit);
}

void mesh_warn_materials(const thrum_mesh *mesh, const char *name, const char *unit) {
  if (thrum_mesh_odd_density(mesh) >= 0)
    warn_material(mesh, name, unit, THRUM_EXAMINE_DENSITY);
  else if (thrum_mesh_odd_modulus(mesh) >= 0)
    warn_material(mesh, name, unit, THRUM_EXAMINE_MODULUS);
}

void mesh_warn_weight(const thrum_mesh *mesh, const char *name,
                      const thrum_mesh_read_options *reading) {
  const double longest = thrum_box3_longest(mesh->vertices, mesh->vertex_count);
  const double strain = thrum_mesh_weight_strain(mesh, longest);
  if (strain > CRUSHED && longest > LONG && reading->scale == 1)
    config_warn("%s: the body is %.3g m long, and a column of this material and length would be "
                "compressed by %.0f %% by its own weight: are its lengths in millimetres? --scale "
                "0.001",
                name, longest, 100 * strain);
}

void mesh_warn_poisson(const thrum_mesh *mesh, const char *name) {
  for (int64_t m = 0; m < mesh->region_count; m++) {
    const double poisson = mesh->materials[m].poisson;
    if (!(poisson < 0.5))
      continue;

    // lambda over mu: how much more a change of volume is resisted than one of shape
    if (poisson > ROUNDED_POISSON)
      config_warn("%s: Poisson's ratio %.15g of region %lld is above %g, so that the resistance to "
                  "a change of shape is lost in the rounding of %.1g times the resistance to one "
                  "of volume: frequencies may be percents off; take 0.4999 or less",
                  name, poisson, (long long)m + 1, ROUNDED_POISSON,
                  2 * poisson / (1 - 2 * poisson));
  }
}
