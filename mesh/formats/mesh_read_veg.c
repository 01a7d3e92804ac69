/* Reads Vega .veg files: *VERTICES, *ELEMENTS (TET), *MATERIAL (ENU), *REGION, *SET, *INCLUDE, #
 * comments; keywords in any case, sections in any order. Vertices and elements are numbered
 * consecutively from 0 or 1, whichever comes first in the file; sets use the numbers of the
 * elements. The set allElements is always there. A later region overrides an earlier one. *INCLUDE
 * FILE, relative to the file that it stands in, may take the place of any line; it stays in the
 * folder of that file, or below the one that the environment variable THRUM_INCLUDES names. Cost:
 * linear in the file; memory follows what the file holds, not the counts that it claims.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/included_files.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

typedef struct veg_material {
  thrum_word name;
  thrum_material values;
  bool used; /* an element is of it */
} veg_material;

typedef struct veg_set {
  thrum_word name;
  int64_t count;
  int64_t *elements; /* as in the file */
} veg_set;

/* A region keeps its place in the file for the message when a name in it cannot be resolved. */
typedef struct veg_region {
  thrum_word set, material;
  thrum_text place;
  int64_t of; /* the index of the material, once all is read */
} veg_region;

typedef struct veg_reader {
  thrum_included_files included;
  bool again; /* the present line was put back */
  bool has_vertices, has_elements;
  int64_t vertex_base, element_base;
  int64_t material_count;
  veg_material *materials;
  int64_t set_count;
  veg_set *sets;
  int64_t region_count;
  veg_region *regions;
  thrum_mesh_builder builder; /* numbers are the file's; a tet's key is its region */
  thrum_error *error;
} veg_reader;

static thrum_text *text_of(veg_reader *r) {
  return thrum_included_text(&r->included);
}

/* Opens the file that the present line, `*INCLUDE name`, names. */
static thrum_status include(veg_reader *r) {
  thrum_text *text = text_of(r);
  thrum_text_more(text);
  return thrum_included_open(&r->included, "*INCLUDE",
                             (thrum_word){text->at, (size_t)(text->end - text->at)});
}

/* Goes to the next line, through includes; *found is false at the end of the first file. */
static thrum_status next_line(veg_reader *r, bool *found) {
  *found = true;

  // a keyword that ended a set is read again as the next section
  if (r->again) {
    r->again = false;
    thrum_text_rewind(text_of(r));
    return THRUM_OK;
  }

  for (;;) {
    *found = thrum_included_next_line(&r->included);
    if (!*found)
      return THRUM_OK;

    // *INCLUDE may stand anywhere, so callers never see it
    thrum_text *text = text_of(r);
    thrum_word word = {"", 0};
    if (*text->start != '*' || !thrum_text_word(text, &word) ||
        !thrum_text_equals(word, "*INCLUDE")) {
      thrum_text_rewind(text);
      return THRUM_OK;
    }
    THRUM_TRY(include(r));
  }
}

/* Goes to the next line of a section; a line that opens another section, or the end, is refused. */
static thrum_status body_line(veg_reader *r, const char *what) {
  bool found;
  THRUM_TRY(next_line(r, &found));
  thrum_text *text = text_of(r);
  if (!found)
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "the file ends before %s; is it cut short?",
                           what);
  if (*text->at == '*')
    return thrum_text_fail(
        text, THRUM_BAD_FORMAT, "expected %s, found '%s'", what,
        thrum_text_excerpt((thrum_word){text->at, (size_t)(text->end - text->at)}).text);
  return THRUM_OK;
}

/* Takes the line up to `end` as one name. */
static thrum_status rest_name(veg_reader *r, const char *end, thrum_word *name) {
  thrum_text *text = text_of(r);
  while (text->at < end && (*text->at == ' ' || *text->at == '\t'))
    text->at++;
  while (end > text->at && (end[-1] == ' ' || end[-1] == '\t'))
    end--;
  *name = (thrum_word){.text = text->at, .length = (size_t)(end - text->at)};

  // a region divides its names at a comma, so that nothing could name it
  if (memchr(name->text, ',', name->length))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "a name holds a comma: '%s'",
                           thrum_text_excerpt(*name).text);
  return thrum_mesh_name_check(text, *name);
}

static bool same_name(thrum_word a, thrum_word b) {
  return a.length == b.length && memcmp(a.text, b.text, a.length) == 0;
}

/* Reads the header `count width attributes markers`; *extra is how many columns follow the data. */
static thrum_status header(veg_reader *r, const char *what, int64_t width, int64_t high,
                           int64_t *count, int64_t *extra) {
  thrum_text *text = text_of(r);
  THRUM_TRY(thrum_text_integer(text, what, 1, high, count));
  int64_t given = width;
  if (thrum_text_more(text))
    THRUM_TRY(thrum_text_integer(text, "numbers per line", width, width, &given));

  // attributes and markers are columns behind the data
  *extra = 0;
  for (int i = 0; i < 2 && thrum_text_more(text); i++) {
    int64_t columns = 0;
    THRUM_TRY(thrum_text_integer(text, "number of attributes", 0, 100, &columns));
    *extra += columns;
  }

  return thrum_text_finish(text, "the sizes");
}

static thrum_status finish_item(veg_reader *r, int64_t extra, const char *what) {
  thrum_text *text = text_of(r);
  thrum_word word = {"", 0};
  for (int64_t i = 0; i < extra; i++)
    thrum_text_word(text, &word);
  return text->at == text->end ? THRUM_OK : thrum_text_finish(text, what);
}

static thrum_status read_vertex(veg_reader *r, int64_t i, int64_t extra) {
  double position[3] = {0};
  THRUM_TRY(body_line(r, "the last vertex"));
  THRUM_TRY(thrum_text_item(text_of(r), "a vertex number", i, &r->vertex_base));
  THRUM_TRY(thrum_text_position(text_of(r), position));
  THRUM_TRY(finish_item(r, extra, "the three coordinates"));
  return thrum_builder_vertex(&r->builder, i + r->vertex_base, position, text_of(r)->line);
}

static thrum_status read_vertices(veg_reader *r) {
  if (r->has_vertices)
    return thrum_text_fail(text_of(r), THRUM_BAD_FORMAT, "*VERTICES comes twice");
  r->has_vertices = true;

  // sizes come before the list
  int64_t count = 0, extra = 0;
  THRUM_TRY(body_line(r, "the number of vertices"));
  THRUM_TRY(header(r, "the number of vertices", 3, INT32_MAX, &count, &extra));

  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_vertex(r, i, extra));
  return THRUM_OK;
}

/* Reads a tet. Its vertices stay as in the file until all is read, since *VERTICES may come later.
 */
static thrum_status read_tet(veg_reader *r, int64_t i, int64_t extra) {
  THRUM_TRY(body_line(r, "the last element"));
  thrum_text *text = text_of(r);
  THRUM_TRY(thrum_text_item(text, "an element number", i, &r->element_base));

  // without *VERTICES yet the range is unknown; the numbers are checked again at the end
  const int64_t first = r->has_vertices ? r->vertex_base : 0;
  const int64_t last = r->has_vertices ? r->builder.vertex_count - 1 + first : INT32_MAX;
  int64_t vertices[4] = {0};
  for (int a = 0; a < 4; a++)
    THRUM_TRY(thrum_text_integer(text, "a vertex of the tet", first, last, &vertices[a]));
  THRUM_TRY(finish_item(r, extra, "the four vertices"));

  // a line number is useful only with the name of the main file
  return thrum_builder_tet(&r->builder, vertices, -1, thrum_included_line(&r->included));
}

static thrum_status element_kind(veg_reader *r) {
  THRUM_TRY(body_line(r, "the kind of elements, TET"));
  thrum_text *text = text_of(r);
  thrum_word word = {"", 0};
  thrum_text_word(text, &word);

  // Vega has meshes of cubes too, which deserve a message of their own
  if (thrum_text_equals(word, "CUBIC"))
    return thrum_text_fail(text, THRUM_UNSUPPORTED,
                           "CUBIC elements are not supported; cut the mesh into tetrahedra (TET)");
  if (!thrum_text_equals(word, "TET") && !thrum_text_equals(word, "TETS"))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "expected the kind of elements, TET, found '%s'",
                           thrum_text_excerpt(word).text);
  return thrum_text_finish(text, "the kind of elements");
}

static thrum_status read_elements(veg_reader *r) {
  if (r->has_elements)
    return thrum_text_fail(text_of(r), THRUM_BAD_FORMAT, "*ELEMENTS comes twice");
  r->has_elements = true;

  // the kind and the sizes come before the list
  int64_t count = 0, extra = 0;
  THRUM_TRY(element_kind(r));
  THRUM_TRY(body_line(r, "the number of elements"));
  THRUM_TRY(header(r, "the number of elements", 4, INT32_MAX, &count, &extra));

  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_tet(r, i, extra));
  return THRUM_OK;
}

static thrum_status read_material(veg_reader *r) {
  veg_material material = {0};
  THRUM_TRY(rest_name(r, text_of(r)->end, &material.name));
  for (int64_t i = 0; i < r->material_count; i++)
    if (same_name(r->materials[i].name, material.name))
      THRUM_TRY(thrum_text_fail(text_of(r), THRUM_BAD_FORMAT, "this material comes twice"));
  THRUM_TRY(body_line(r, "the material's line, ENU, density, E, nu"));

  // the other materials of Vega are nonlinear and have other constants
  thrum_text *text = text_of(r);
  thrum_word word = {"", 0};
  thrum_text_word(text, &word);
  if (!thrum_text_equals(word, "ENU"))
    return thrum_text_fail(text, THRUM_UNSUPPORTED,
                           "material '%s' is not supported; write ENU, density, E, nu",
                           thrum_text_excerpt(word).text);

  THRUM_TRY(thrum_text_number(text, "the density", &material.values.density));
  THRUM_TRY(thrum_text_number(text, "Young's modulus E", &material.values.young));
  THRUM_TRY(thrum_text_number(text, "Poisson's ratio nu", &material.values.poisson));
  THRUM_TRY(thrum_text_finish(text, "the material"));

  // regions may name the material before or after this place
  return thrum_mesh_append_few(text, "materials", &r->materials, &r->material_count, &material,
                               sizeof material);
}

/* Reads `set, material`; without a comma the two are words. */
static thrum_status read_region(veg_reader *r) {
  THRUM_TRY(body_line(r, "the region's line, set, material"));
  thrum_text *text = text_of(r);
  veg_region region = {.place = *text};

  // a comma separates the two names; without one, the first blank does
  const char *split = memchr(text->at, ',', (size_t)(text->end - text->at));
  for (const char *p = text->at; !split && p < text->end; p++)
    if (*p == ' ' || *p == '\t')
      split = p;

  if (!split)
    return thrum_text_fail(text, THRUM_BAD_FORMAT,
                           "a region is a set and a material, as in allElements, BODY");
  THRUM_TRY(rest_name(r, split, &region.set));
  text->at = split + 1;
  THRUM_TRY(rest_name(r, text->end, &region.material));

  // the set and the material may follow, so their names are kept
  return thrum_mesh_append_few(text, "regions", &r->regions, &r->region_count, &region,
                               sizeof region);
}

/* Reads one line of a set, which is numbers of elements. */
static thrum_status read_set_line(veg_reader *r, veg_set *set) {
  thrum_text *text = text_of(r);
  while (thrum_text_more(text)) {
    // without *ELEMENTS yet the range is unknown; the numbers are checked again at the end
    int64_t last = r->has_elements ? r->builder.tet_count - 1 + r->element_base : INT32_MAX;
    int64_t first = r->has_elements ? r->element_base : 0, element = 0;
    THRUM_TRY(thrum_text_integer(text, "an element of the set", first, last, &element));
    THRUM_TRY(thrum_mesh_append(&set->elements, &set->count, &element, sizeof element, r->error));
  }
  return THRUM_OK;
}

static thrum_status read_set(veg_reader *r) {
  veg_set fresh = {0};
  THRUM_TRY(rest_name(r, text_of(r)->end, &fresh.name));
  for (int64_t i = 0; i < r->set_count; i++)
    if (same_name(r->sets[i].name, fresh.name))
      return thrum_text_fail(text_of(r), THRUM_BAD_FORMAT, "this set comes twice");

  // a set becomes a group, so there are at most as many
  THRUM_TRY(
      thrum_mesh_append_few(text_of(r), "sets", &r->sets, &r->set_count, &fresh, sizeof fresh));
  veg_set *set = &r->sets[r->set_count - 1];

  // only a keyword or the end of the file ends a set
  for (;;) {
    bool found;
    THRUM_TRY(next_line(r, &found));
    if (!found)
      return THRUM_OK;
    if (*text_of(r)->at == '*') {
      r->again = true;
      return THRUM_OK;
    }
    THRUM_TRY(read_set_line(r, set));
  }
}

static thrum_status read_section(veg_reader *r) {
  static const struct {
    const char *keyword;
    thrum_status (*read)(veg_reader *r);
    bool named;
  } sections[] = {{"*VERTICES", read_vertices, false},
                  {"*ELEMENTS", read_elements, false},
                  {"*MATERIAL", read_material, true},
                  {"*REGION", read_region, false},
                  {"*SET", read_set, true}};

  thrum_text *text = text_of(r);
  thrum_word word = {"", 0};
  thrum_text_word(text, &word);

  // words behind a keyword that takes no name are a mistake in the file
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (thrum_text_equals(word, sections[i].keyword)) {
      THRUM_TRY(sections[i].named ? THRUM_OK : thrum_text_finish(text, sections[i].keyword));
      return sections[i].read(r);
    }

  return thrum_text_fail(text, THRUM_BAD_FORMAT,
                         "expected *VERTICES, *ELEMENTS, *MATERIAL, *REGION, *SET or *INCLUDE, "
                         "found '%s'",
                         thrum_text_excerpt(word).text);
}

/* Turns the file's numbers of elements into 0-based ones, now that the base is known. */
static thrum_status rebase_sets(veg_reader *r, const char *path) {
  for (int64_t s = 0; s < r->set_count; s++)
    for (int64_t i = 0; i < r->sets[s].count; i++) {
      int64_t *element = &r->sets[s].elements[i];
      *element -= r->element_base;
      if (*element < 0 || *element >= r->builder.tet_count)
        return thrum_error_set(
            r->error, THRUM_BAD_VALUE, "%.150s: set '%s' names element %lld, but there are %lld",
            path, thrum_text_excerpt(r->sets[s].name).text, (long long)(*element + r->element_base),
            (long long)r->builder.tet_count);
    }
  return THRUM_OK;
}

/* Vega has the set of all elements always, and passes over another one of its name. */
static thrum_status check_all_elements(const veg_reader *r, const char *path) {
  for (int64_t s = 0; s < r->set_count; s++) {
    const veg_set *set = &r->sets[s];
    if (!thrum_text_equals(set->name, "allElements"))
      continue;

    // each element must be there; one that comes twice does no harm
    unsigned char *seen = NULL;
    int64_t count = 0;
    THRUM_TRY(thrum_reserve(&seen, r->builder.tet_count, 1, "elements", r->error));
    memset(seen, 0, (size_t)r->builder.tet_count);
    for (int64_t i = 0; i < set->count; i++) {
      count += !seen[set->elements[i]];
      seen[set->elements[i]] = 1;
    }
    free(seen);
    if (count < r->builder.tet_count)
      return thrum_error_set(r->error, THRUM_UNSUPPORTED,
                             "%.150s: the set allElements holds %lld of %lld elements, but it "
                             "stands for all; give it another name",
                             path, (long long)count, (long long)r->builder.tet_count);
  }
  return THRUM_OK;
}

/* Finds the set of a region, where NULL stands for all elements; returns false when there is none.
 */
static bool find_set(const veg_reader *r, thrum_word name, const veg_set **set) {
  *set = NULL;
  for (int64_t s = 0; s < r->set_count; s++)
    if (same_name(r->sets[s].name, name)) {
      *set = &r->sets[s];
      return true;
    }
  return thrum_text_equals(name, "allElements");
}

static thrum_status apply_region(veg_reader *r, int64_t index) {
  veg_region *region = &r->regions[index];
  const veg_set *set;
  if (!find_set(r, region->set, &set))
    return thrum_text_fail(&region->place, THRUM_MISSING,
                           "the region's set '%s' is not in the file",
                           thrum_text_excerpt(region->set).text);

  // materials are found by their names, which are unique
  int64_t material = 0;
  while (material < r->material_count && !same_name(r->materials[material].name, region->material))
    material++;
  if (material == r->material_count)
    return thrum_text_fail(&region->place, THRUM_MISSING,
                           "the region's material '%s' is not in the file",
                           thrum_text_excerpt(region->material).text);

  // a later region overrides an earlier one, as in Vega
  region->of = material;
  const int64_t count = set ? set->count : r->builder.tet_count;
  for (int64_t i = 0; i < count; i++)
    r->builder.keys[set ? set->elements[i] : i] = index;
  return THRUM_OK;
}

static thrum_status apply_regions(veg_reader *r, const char *path) {
  if (r->region_count == 0 && r->material_count > 1)
    return thrum_error_set(r->error, THRUM_MISSING,
                           "%.150s: several materials but no *REGION; add one such as "
                           "'allElements, BODY'",
                           path);

  // a tet without region would have no material, which is probably an oversight
  for (int64_t i = 0; i < r->region_count; i++)
    THRUM_TRY(apply_region(r, i));
  for (int64_t t = 0; t < r->builder.tet_count && r->region_count > 0; t++)
    if (r->builder.keys[t] < 0)
      return thrum_error_set(r->error, THRUM_MISSING,
                             "%.150s: element %lld is in no *REGION, so it has no material", path,
                             (long long)(t + r->element_base));
  return THRUM_OK;
}

/* Makes a group of the vertices of each set's elements. */
static thrum_status add_groups(veg_reader *r) {
  for (int64_t s = 0; s < r->set_count; s++) {
    const veg_set *set = &r->sets[s];
    int64_t list = 0;
    THRUM_TRY(thrum_builder_list(&r->builder, set->name.text, set->name.length, &list));
    for (int64_t i = 0; i < 4 * set->count; i++)
      THRUM_TRY(
          thrum_builder_add(&r->builder, list, r->builder.tets[4 * set->elements[i / 4] + i % 4]));
  }
  return THRUM_OK;
}

/* Sets the material of each region; without regions the whole body is one, of the one material. */
static thrum_status set_materials(veg_reader *r, thrum_mesh *mesh) {
  mesh->has_material = r->material_count > 0;
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++) {
    if (r->region_count == 0) {
      mesh->materials[i] = r->materials[0].values;
      continue;
    }

    // a region has the name of its set
    const veg_region *region = &r->regions[r->builder.region_keys[i]];
    mesh->materials[i] = r->materials[region->of].values;
    r->materials[region->of].used = true;
    THRUM_TRY(thrum_mesh_name_region(mesh, i, region->set.text, region->set.length, r->error));
  }

  // a material without elements is probably an oversight, but Vega has it too
  for (int64_t i = 0; i < r->material_count && r->region_count > 0; i++)
    if (!r->materials[i].used)
      thrum_mesh_add_note(mesh, "no element is of the material '%s'",
                          thrum_text_excerpt(r->materials[i].name).text);
  return THRUM_OK;
}

static thrum_status read_all(veg_reader *r, const char *path, thrum_mesh *mesh) {
  for (;;) {
    bool found;
    THRUM_TRY(next_line(r, &found));
    if (found)
      THRUM_TRY(read_section(r));
    if (!found)
      break;
  }

  // sections may come in any order, so names and numbers are resolved at the end
  if (!r->has_vertices || !r->has_elements)
    return thrum_error_set(r->error, THRUM_MISSING,
                           "%.150s: there is no %s; is it a Vega mesh, and is it whole?", path,
                           r->has_vertices ? "*ELEMENTS" : "*VERTICES");
  THRUM_TRY(rebase_sets(r, path));
  THRUM_TRY(check_all_elements(r, path));
  THRUM_TRY(apply_regions(r, path));
  THRUM_TRY(add_groups(r));
  THRUM_TRY(thrum_builder_finish(&r->builder, path, mesh));
  THRUM_TRY(set_materials(r, mesh));

  // messages and lists count from 1, whatever the base of the file
  free(mesh->file_number);
  mesh->file_number = NULL;
  return THRUM_OK;
}

thrum_status thrum_mesh_parse_veg(const thrum_mesh_source *source, thrum_mesh *mesh,
                                  thrum_error *error) {
  veg_reader r = {.builder = {.error = error}, .error = error};
  thrum_mesh read = {0};
  thrum_status status = thrum_included_begin(&r.included, source, '#', ',', error);
  THRUM_THEN(status, read_all(&r, source->name, &read));

  // names point into the files, so these stay open until the mesh is made
  for (int64_t s = 0; s < r.set_count; s++)
    free(r.sets[s].elements);
  free(r.sets);
  free(r.regions);
  free(r.materials);
  thrum_builder_free(&r.builder);
  thrum_included_end(&r.included);
  return thrum_mesh_deliver(status, &read, mesh);
}
