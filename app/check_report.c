/* The report of `thrum check` on a mesh, as a table and as JSON.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/check_report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>

#include "driver/model/mesh_warnings.h"
#include "io/json.h"
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

/* The number of a vertex in the file. */
static int64_t file_number(const thrum_mesh *mesh, int32_t v) {
  int64_t place = v;
  for (int64_t i = 0; mesh->file_vertex && i < mesh->file_vertex_count; i++)
    if (mesh->file_vertex[i] == v)
      place = i;
  return mesh->file_number ? mesh->file_number[place] : place + 1;
}

static void print_worst(const thrum_mesh *mesh, const thrum_mesh_examined *e) {
  for (int i = 0; i < THRUM_EXAMINE_WORST && e->worst[i] >= 0; i++) {
    const int32_t *v = mesh->tets + 4 * e->worst[i];
    printf("%-18stet %" PRId64 ", mean ratio %.3f, vertices %" PRId64 " %" PRId64 " %" PRId64
           " %" PRId64 "\n",
           i == 0 ? "worst" : "", e->worst[i] + 1, e->worst_ratio[i], file_number(mesh, v[0]),
           file_number(mesh, v[1]), file_number(mesh, v[2]), file_number(mesh, v[3]));
  }
}

static void print_surface(const thrum_mesh_examined *e) {
  printf("%-18s%" PRId64 " triangles in %" PRId64 " closed surface%s", "surface",
         e->surface_triangles, e->surfaces, e->surfaces == 1 ? "" : "s");
  if (e->genus >= 0)
    printf(", %" PRId64 " hole%s through the body", e->genus, e->genus == 1 ? "" : "s");
  puts("");
}

/* The materials of the regions, with the names of those where there are several. */
static void print_regions(const thrum_mesh *mesh) {
  if (!mesh->has_material)
    printf("%-18s%" PRId64 ", no materials in the file\n", "regions", mesh->region_count);
  for (int64_t i = 0; i < mesh->region_count; i++) {
    if (!mesh->has_material && mesh->region_count == 1)
      return;
    printf("%-18s", i == 0 && mesh->has_material ? "materials" : "");
    if (mesh->region_count > 1)
      printf("%s%s", thrum_mesh_region_text(mesh, i).text, mesh->has_material ? ": " : "\n");
    if (mesh->has_material)
      printf("E = %g Pa, nu = %g, rho = %g kg/m^3\n", mesh->materials[i].young,
             mesh->materials[i].poisson, mesh->materials[i].density);
  }
}

static void print_groups(const thrum_mesh *mesh) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    printf("%-18s%s, %" PRId64 " %s\n", g == 0 ? "groups" : "", mesh->groups[g].name,
           mesh->groups[g].count, mesh->groups[g].count == 1 ? "vertex" : "vertices");
  print_regions(mesh);
}

/* Says how much too stiff linear tetrahedra make a thickness in bending. */
static void print_thickness(const thrum_mesh *mesh, const thrum_mesh_examined *e) {
  const bool most = e->cells_across >= THRUM_THICKNESS_CELLS_MAX;
  printf("%-18s%.2g cell%s%s over the thickness of the thinnest quarter", "thickness",
         e->cells_across, e->cells_across == 1 ? "" : "s", most ? " or more" : "");
  if (mesh->solid_count == 0 && !mesh->midsides && e->cells_across < BENDING_CELLS)
    printf(
        ": bending frequencies there come out about %.0f %% too high, by a rule of thumb that is "
        "within three times; --order 2 mends that",
        100 * thrum_bending_error(e->cells_across));
  printf("\n");
}

void check_report_print(const char *name, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                        unsigned flags) {
  // what the reader has made of the file, then size and place
  printf("%-18s%s\n", "mesh", name);
  for (int64_t n = 0; n < mesh->note_count; n++)
    printf("%-18s%s\n", n == 0 ? "read" : "", mesh->notes[n].text);
  printf("%-18s%" PRId64 " vertices (%" PRId64 " inside), %" PRId64 " tetrahedra, %" PRId64
         " piece%s\n",
         "size", mesh->vertex_count, e->interior_vertices, mesh->tet_count, e->pieces,
         e->pieces == 1 ? "" : "s");
  if (mesh->solid_count > 0)
    printf("%-18s%s, whose shape the tetrahedra are\n", "elements",
           thrum_solid_count_words(mesh->solid_form, mesh->solid_count).text);
  printf("%-18s%.6g m^3", "body", e->volume);
  if (mesh->has_material)
    printf(", %.6g kg", e->mass);
  printf("\n%-18s[%.4g, %.4g] x [%.4g, %.4g] x [%.4g, %.4g] m\n", "box", e->box_min[0],
         e->box_max[0], e->box_min[1], e->box_max[1], e->box_min[2], e->box_max[2]);

  // edges, surface and shape of the elements
  printf("%-18s%.4g to %.4g m\n", "edges", e->edge_min, e->edge_max);
  print_surface(e);
  printf("%-18smean ratio %.3f on average, %.3f at least\n", "quality", e->ratio_mean,
         e->ratio_min);

  // only bins with elements in them
  for (int b = 0; b < THRUM_EXAMINE_BINS; b++)
    if (e->histogram[b] > 0)
      printf("%-18s%.1f to %.1f: %" PRId64 "\n", "", b / 10.0, (b + 1) / 10.0, e->histogram[b]);
  print_worst(mesh, e);
  print_thickness(mesh, e);
  print_groups(mesh);

  // what is probably a mistake, with what to do about it
  for (int i = 0; i < FLAG_COUNT; i++) {
    char line[300];
    if (flags & ALL_FLAGS[i])
      printf("%-18s%s\n", "flagged",
             thrum_mesh_flag_line(mesh, e, (thrum_examine_flag)ALL_FLAGS[i], line));
  }
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

static void add_lists(cJSON *object, const thrum_mesh *mesh, const thrum_mesh_examined *e) {
  cJSON *histogram = cJSON_AddArrayToObject(object, "quality_histogram");
  for (int b = 0; b < THRUM_EXAMINE_BINS; b++)
    cJSON_AddItemToArray(histogram, json_number_item((double)e->histogram[b]));

  // tets are counted from 1, as in the table
  cJSON *worst = cJSON_AddArrayToObject(object, "worst_tets");
  for (int i = 0; i < THRUM_EXAMINE_WORST && e->worst[i] >= 0; i++) {
    cJSON *tet = json_add_row(worst);
    json_number(tet, "tet", (double)(e->worst[i] + 1));
    json_number(tet, "ratio", e->worst_ratio[i]);
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
                 {"bending_error", mesh->midsides || mesh->solid_count > 0
                                       ? 0
                                       : thrum_bending_error(e->cells_across)},
                 {"hinge_edges", (double)e->hinges},
                 {"coincident_vertices", (double)e->coincident_vertices},
                 {"flipped_tets", (double)mesh->flipped_tets},
                 {"dropped_vertices", (double)mesh->dropped_vertices},
                 {"cornered_tets", (double)mesh->cornered_tets}};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    json_number(object, numbers[i].key, numbers[i].value);

  // numbers that some meshes have
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
