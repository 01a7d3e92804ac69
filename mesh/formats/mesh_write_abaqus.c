/* Writes Abaqus input files: *NODE, *ELEMENT of each type, an *ELSET for each region, an *NSET for
 * each group, and with materials *SOLID SECTION, *MATERIAL, *ELASTIC, *DENSITY. Cost: linear in the
 * mesh, for every region.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "io/number_text.h"
#include "mesh/elastic.h"
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

static const char BAD[] = ",\"*=";

/* Abaqus and CalculiX take the first 20 characters of a number, and nothing of what follows. */
enum { FIELD = 20 };
enum { LINE_NUMBERS = 16 };  /* of an element's first line, at most */
enum { NAME_MAX_BARE = 80 }; /* of a set, in both */

static void put_number(thrum_mesh_out *out, double value) {
  char text[THRUM_NUMBER_TEXT];
  thrum_out_bytes(out, text, thrum_number_text_within(value, FIELD, text));
}

/* A set's name behind `words`. A name that needs no quotes gets none: CalculiX takes them for a
 * part of the name, which a user's deck that includes this one has bare. */
static void put_name(thrum_mesh_out *out, const char *words, const char *name) {
  static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  const size_t length = strlen(name);
  const bool letter = (name[0] | 32) >= 'a' && (name[0] | 32) <= 'z';
  const char *quote =
      letter && length <= NAME_MAX_BARE && strspn(name, plain) == length ? "" : "\"";
  thrum_out_text(out, "%s%s%s%s", words, quote, name, quote);
}

/* The name of a group, with its number behind it where an earlier one has the same: readers pass
 * over capitals, and would take both for one set. */
static const char *distinct_name(thrum_mesh_written *w, int64_t group, char name[256]) {
  thrum_write_group_name(w, group, BAD, name);
  thrum_mesh_written uncounted = *w;
  for (int64_t g = 0; g < group; g++) {
    char other[256];
    if (strcasecmp(thrum_write_group_name(&uncounted, g, BAD, other), name) != 0)
      continue;
    const size_t length = strlen(name);
    snprintf(name + (length > 230 ? 230 : length), 24, "_%lld", (long long)group + 1);
    w->lost.names++;
    break;
  }
  return name;
}

/* Numbers on a line. */
static void put_numbers(thrum_mesh_out *out, const double *values, int count) {
  for (int n = 0; n < count; n++) {
    put_number(out, values[n]);
    thrum_out_text(out, n < count - 1 ? ", " : "\n");
  }
}

/* The constants of a region with directions in space; NULL: it has none. */
static const double *directed_row(const thrum_mesh *m, int64_t region) {
  const int64_t begin = thrum_mesh_elastic_begin(m, region);
  if (begin == thrum_mesh_elastic_begin(m, region + 1))
    return NULL;
  const double *row = m->elastic + THRUM_ELASTIC_NUMBERS * begin;
  return row[THRUM_ELASTIC_THICKNESS] > 0 ? NULL : row;
}

static void put_material(thrum_mesh_out *out, const thrum_mesh *m, int64_t region,
                         const char *name) {
  const thrum_material *material = &m->materials[region];
  const double *row = directed_row(m, region);
  if (row) {
    thrum_out_text(out, "*ORIENTATION, NAME=directions_%lld, SYSTEM=RECTANGULAR\n",
                   (long long)region + 1);
    put_numbers(out, row + THRUM_ELASTIC_FIRST, 6);
  }
  put_name(out, "*SOLID SECTION, ELSET=", name);
  thrum_out_text(out, ", MATERIAL=material_%lld", (long long)region + 1);
  if (row)
    thrum_out_text(out, ", ORIENTATION=directions_%lld", (long long)region + 1);
  thrum_out_text(out, "\n");
  thrum_out_text(out, "*MATERIAL, NAME=material_%lld\n", (long long)region + 1);

  // without a material the section still tells the region
  if (!m->has_material)
    return;

  if (row) {
    thrum_out_text(out, "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n");
    put_numbers(out, row + THRUM_ELASTIC_YOUNG, 8);
    put_numbers(out, row + THRUM_ELASTIC_YOUNG + 8, 1);
  } else {
    const double moduli[2] = {material->young, material->poisson};
    thrum_out_text(out, "*ELASTIC\n");
    put_numbers(out, moduli, 2);
  }
  thrum_out_text(out, "*DENSITY\n");
  put_number(out, material->density);
  thrum_out_text(out, ",\n");
}

static void put_region(thrum_mesh_out *out, thrum_mesh_written *w, int64_t region) {
  const thrum_mesh *m = w->mesh;
  char name[256] = "allElements";

  // one region without a name is allElements, which needs no set of its own
  if (m->region_count > 1 || w->region_group[region] >= 0) {
    if (w->region_group[region] >= 0)
      distinct_name(w, w->region_group[region], name);
    else
      thrum_write_region_name(w, region, BAD, name);
    put_name(out, "*ELSET, ELSET=", name);
    thrum_out_text(out, "\n");
    thrum_out_region_elements(out, m, region);
  }

  // several regions need sections even without materials
  if (m->has_material || m->region_count > 1)
    put_material(out, m, region, name);
}

/* A line of an element, which has 16 numbers at most. */
static void put_element(thrum_mesh_out *out, const thrum_mesh_element *element, int64_t number) {
  thrum_out_text(out, "%lld", (long long)number);
  for (int a = 0; a < element->count; a++)
    thrum_out_text(out, a == LINE_NUMBERS - 1 ? ",\n%lld" : ", %lld", element->nodes[a] + 1LL);
  thrum_out_text(out, "\n");
}

/* All elements in their order, under the keyword of each type. Hexahedra of eight nodes have
 * incompatible modes there where they have enhanced strains here. */
static void put_elements(thrum_mesh_out *out, const thrum_mesh *m) {
  static const char *const types[THRUM_FORMS] = {"C3D4",  "C3D10", "C3D6",  "C3D15", "C3D8I",
                                                 "C3D20", "C3D6",  "C3D8I", "C3D10"};
  const char *type = "";
  for (int64_t e = 0; e < thrum_mesh_element_count(m); e++) {
    const thrum_mesh_element element = thrum_mesh_element_at(m, e);
    if (strcmp(types[element.form], type) != 0)
      thrum_out_text(out, "*ELEMENT, TYPE=%s, ELSET=allElements\n", types[element.form]);
    type = types[element.form];
    put_element(out, &element, e + 1);
  }
}

void thrum_mesh_write_abaqus(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;

  // the format has no units, so the heading names them
  thrum_out_text(out, "*HEADING\n mesh written by thrum, in metres\n*NODE\n");
  for (int64_t v = 0; v < m->vertex_count; v++) {
    thrum_out_text(out, "%lld, ", (long long)v + 1);
    for (int axis = 0; axis < 3; axis++) {
      put_number(out, m->vertices[3 * v + axis]);
      thrum_out_text(out, axis < 2 ? ", " : "\n");
    }
  }

  // regions and readers refer to all elements by the set allElements
  put_elements(out, m);

  // a group that stands for a region becomes the element set of the region
  for (int64_t g = 0; g < m->group_count; g++) {
    char name[256];
    int column = 0;
    if (w->group_region[g] >= 0)
      continue;
    put_name(out, "*NSET, NSET=", distinct_name(w, g, name));
    thrum_out_text(out, "\n");
    for (int64_t i = 0; i < m->groups[g].count; i++)
      thrum_out_member(out, m->groups[g].vertices[i] + 1LL, &column);
    thrum_out_end_members(out, column);
  }

  for (int64_t i = 0; i < m->region_count; i++)
    put_region(out, w, i);
}
