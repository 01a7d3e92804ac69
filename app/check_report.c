/* The report of `thrum check` on a mesh, as a table and as JSON.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/check_report.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>

#include "driver/model/mesh_warnings.h"
#include "io/json.h"
#include "io/report.h"
#include "mesh/mesh_elements.h"
#include "mesh/mesh_flags.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_thickness.h"
#include "mesh/solids.h"
#include "thrum/thrum.h"

static const unsigned ALL_FLAGS[] = {
#define X(name, bit) bit,
    THRUM_EXAMINE_FLAGS(X)
#undef X
};
static const char *const FLAG_NAMES[] = {
#define X(name, bit) #name,
    THRUM_EXAMINE_FLAGS(X)
#undef X
};
enum { FLAG_COUNT = sizeof ALL_FLAGS / sizeof *ALL_FLAGS };
#define BENDING_CELLS 4.5 /* below, linear tetrahedra are worth a word */

/* The place of a vertex in the file; -1: the file has it not. */
static int64_t file_place(const thrum_mesh *mesh, int32_t v) {
  for (int64_t i = 0; mesh->file_vertex && i < mesh->file_vertex_count; i++)
    if (mesh->file_vertex[i] == v)
      return i;
  return mesh->file_vertex || (mesh->file_vertex_count > 0 && v >= mesh->file_vertex_count) ? -1
                                                                                            : v;
}

static void add_flags(cJSON *object, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                      unsigned flags) {
  cJSON *list = cJSON_AddArrayToObject(object, "flags");
  for (int i = 0; i < FLAG_COUNT; i++) {
    char line[300], name[32];
    if (!(flags & ALL_FLAGS[i]))
      continue;
    size_t n = 0;
    for (; FLAG_NAMES[i][n] != 0 && n + 1 < sizeof name; n++)
      name[n] = (char)(FLAG_NAMES[i][n] - 'A' + 'a');
    name[n] = 0;
    cJSON *flag = json_add_row(list);
    cJSON_AddStringToObject(flag, "name", name);
    json_string(flag, "message",
                thrum_mesh_flag_line(mesh, e, (thrum_examine_flag)ALL_FLAGS[i], line));
  }
}

/* The numbers of the corners of element e in the file, of a part of one those that the file has. */
static void add_vertices(cJSON *object, const thrum_mesh *mesh, int64_t e) {
  double numbers[THRUM_SOLID_NODES_MAX];
  const thrum_mesh_element element = thrum_mesh_element_at(mesh, e);
  const int corners = thrum_solid_shapes[thrum_solid_forms[element.form].kind].corners;
  int count = 0;
  for (int k = 0; k < corners; k++) {
    const int64_t place = file_place(mesh, element.nodes[k]);
    if (place >= 0)
      numbers[count++] = (double)thrum_mesh_number(mesh, place);
  }
  json_numbers(object, "vertices", numbers, count);
}

static void add_lists(cJSON *object, const thrum_mesh *mesh, const thrum_mesh_examined *e) {
  cJSON *histogram = cJSON_AddArrayToObject(object, "quality_histogram");
  for (int b = 0; b < THRUM_EXAMINE_BINS; b++)
    cJSON_AddItemToArray(histogram, json_number_item((double)e->histogram[b]));

  // elements are those of the file, as in the table
  const bool solids = mesh->solid_count > 0;
  cJSON *worst = cJSON_AddArrayToObject(object, solids ? "worst_elements" : "worst_tets");
  for (int i = 0; i < THRUM_EXAMINE_WORST && e->worst[i] >= 0; i++) {
    cJSON *row = json_add_row(worst);
    json_number(row, solids ? "element" : "tet",
                (double)thrum_mesh_element_number(mesh, e->worst[i]));
    json_number(row, "ratio", e->worst_ratio[i]);
    add_vertices(row, mesh, e->worst[i]);
  }

  cJSON *groups = cJSON_AddArrayToObject(object, "groups");
  for (int64_t g = 0; g < mesh->group_count; g++) {
    cJSON *group = json_add_row(groups);
    json_string(group, "name", mesh->groups[g].name);
    json_number(group, "vertices", (double)mesh->groups[g].count);
  }

  // as the command line calls them
  cJSON *regions = cJSON_AddArrayToObject(object, "region_names");
  for (int64_t i = 0; i < mesh->region_count; i++)
    cJSON_AddItemToArray(regions, cJSON_CreateString(thrum_mesh_region_text(mesh, i).text));
  mesh_notes_object(object, mesh);

  // a mesh without materials gets an empty list
  cJSON *materials = cJSON_AddArrayToObject(object, "materials");
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++) {
    cJSON *material = json_add_row(materials);
    if (mesh->region_count > 1)
      json_string(material, "region", thrum_mesh_region_text(mesh, i).text);
    json_number(material, "young_pa", mesh->materials[i].young);
    json_number(material, "poisson", mesh->materials[i].poisson);
    json_number(material, "density_kg_m3", mesh->materials[i].density);
  }
}

cJSON *check_report_object(const char *name, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                           unsigned flags) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", flags != 0 ? "flagged" : "done");
  json_string(object, "mesh", name);

  // numbers that every mesh has
  const struct {
    const char *key;
    double value;
  } numbers[] = {{"vertices", (double)mesh->vertex_count},
                 {"tets", (double)mesh->tet_count},
                 {"order", mesh->midsides ? 2 : 1},
                 {"regions", (double)mesh->region_count},
                 {"pieces", (double)e->pieces},
                 {"volume_m3", e->volume},
                 {"extent_m", e->extent},
                 {"edge_min_m", e->edge_min},
                 {"edge_max_m", e->edge_max},
                 {"ratio_min", e->ratio_min},
                 {"ratio_mean", e->ratio_mean},
                 {"surface_triangles", (double)e->surface_triangles},
                 {"surfaces", (double)e->surfaces},
                 {"interior_vertices", (double)e->interior_vertices},
                 {"shallow_tets", (double)e->shallow_tets},
                 {"cells_across", e->cells_across},
                 {"bending_error", mesh->solid_count > 0 ? NAN
                                   : mesh->midsides      ? 0
                                                         : thrum_bending_error(e->cells_across)},
                 {"hinge_edges", (double)e->hinges},
                 {"coincident_vertices", (double)e->coincident_vertices},
                 {"flipped_tets", (double)mesh->flipped_tets},
                 {"dropped_vertices", (double)mesh->dropped_vertices},
                 {"cornered_tets", (double)mesh->cornered_tets}};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    json_number(object, numbers[i].key, numbers[i].value);

  // what some meshes have
  if (mesh->solid_count > 0)
    json_string(object, "elements",
                thrum_solid_count_words(mesh->solid_form, mesh->solid_count).text);
  if (mesh->has_material)
    json_number(object, "mass_kg", e->mass);
  if (e->genus >= 0)
    json_number(object, "genus", (double)e->genus);

  json_numbers(object, "box_min_m", e->box_min, 3);
  json_numbers(object, "box_max_m", e->box_max, 3);
  add_lists(object, mesh, e);
  add_flags(object, mesh, e, flags);
  return object;
}

static const report_line lines[] = {
    // what the reader has made of the file, then size and place
    REPORT_LINE("mesh", "{mesh}"),
    REPORT_LINE("read", "{}", .each = "notes", .once = true),
    REPORT_LINE("size", "{vertices} vertices ({interior_vertices} inside), {tets} tetrahedra, "
                        "{pieces} piece{pieces#|s}"),
    REPORT_LINE("elements", "{elements}, whose shape the tetrahedra are"),
    REPORT_LINE("body", "{volume_m3:.6g} m^3[, {mass_kg:.6g} kg]"),
    REPORT_LINE("box", REPORT_BOX),

    // edges, surface and shape of the elements
    REPORT_LINE("edges", "{edge_min_m:.4g} to {edge_max_m:.4g} m"),
    REPORT_LINE("surface", "{surface_triangles} triangles in {surfaces} closed surface{surfaces#|s}"
                           "[, {genus} hole{genus#|s} through the body]"),
    REPORT_LINE("quality", "{elements?scaled Jacobian|mean ratio} {ratio_mean:.3f} on average, "
                           "{ratio_min:.3f} at least"),
    REPORT_LINE("", "{from:.1f} to {to:.1f}: {tets}", .each = "bins"),
    REPORT_LINE("worst", "tet {tet}, mean ratio {ratio:.3f}, vertices {vertices:.0f}",
                .each = "worst_tets", .once = true),
    REPORT_LINE("worst", "element {element}, scaled Jacobian {ratio:.3f}, vertices {vertices:.0f}",
                .each = "worst_elements", .once = true),
    REPORT_LINE("thickness",
                "{cells_across:.2g} cell{cells_across#|s}{thick? or more} over the thickness of "
                "the thinnest quarter{bends?: bending frequencies there come out about "
                "{bending_error:.0f%} too high, by a rule of thumb that is within three times; "
                "--order 2 mends that}"),

    // the materials of the regions, with the names of those where there are several
    REPORT_LINE("groups", "{name}, {vertices} {vertices#vertex|vertices}", .each = "groups",
                .once = true),
    REPORT_LINE("regions", "{regions}, no materials in the file", .when = "!materials"),
    REPORT_LINE("", "{}", .each = "region_names", .when = "bare"),
    REPORT_LINE("materials",
                "[{region}: ]E = {young_pa:g} Pa, nu = {poisson:g}, rho = {density_kg_m3:g} kg/m^3",
                .each = "materials", .once = true),

    // what is probably a mistake, with what to do about it; and of a mesh that was made, by what
    REPORT_LINE("flagged", "{message}", .each = "flags"),
    REPORT_LINE("made by", "{tool}, from {surface}"),
    {0}};

void check_report_show(cJSON *report, bool json) {
  const cJSON *materials = cJSON_GetObjectItemCaseSensitive(report, "materials");
  const cJSON *histogram = cJSON_GetObjectItemCaseSensitive(report, "quality_histogram");
  const double cells = json_number_of(report, "cells_across");
  cJSON *more = cJSON_CreateObject();
  cJSON_AddBoolToObject(more, "thick", cells >= THRUM_THICKNESS_CELLS_MAX);
  const bool linear = json_text_of(report, "elements") == NULL;
  cJSON_AddBoolToObject(more, "bends",
                        linear && json_number_of(report, "order") == 1 && cells < BENDING_CELLS);
  cJSON_AddBoolToObject(
      more, "bare", cJSON_GetArraySize(materials) == 0 && json_number_of(report, "regions") > 1);

  // only bins with elements in them
  cJSON *bins = cJSON_AddArrayToObject(more, "bins");
  for (int b = 0; b < THRUM_EXAMINE_BINS; b++) {
    const double tets = json_value(cJSON_GetArrayItem(histogram, b));
    if (!(tets > 0))
      continue;
    cJSON *row = json_add_row(bins);
    json_number(row, "from", b / 10.0);
    json_number(row, "to", (b + 1) / 10.0);
    json_number(row, "tets", tets);
  }
  report_show(report, more, json, REPORT_LABEL_WIDE, lines);
}
