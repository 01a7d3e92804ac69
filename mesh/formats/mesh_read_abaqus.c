/* Reads Abaqus input files (.inp), as far as they describe a body: *NODE, *ELEMENT (C3D4;
 * C3D10), *NSET, *ELSET (both with GENERATE), *MATERIAL with *ELASTIC and *DENSITY,
 * *SOLID SECTION. Keywords, parameters and names in any case; ** comments; other keywords are
 * passed over. Node sets and the nodes of element sets, those of surface elements too, are groups;
 * solid sections are the regions. The element set allElements is no group. A file holds one part.
 * Cost: linear in the file, n log n in elements that sets name.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

enum { SECTIONS_MAX = THRUM_MESH_GROUPS_MAX, PARAMETERS_MAX = 16, CORNERS = 4 };

typedef struct inp_word {
  const char *text;
  size_t length;
} inp_word;

typedef struct inp_parameter {
  inp_word key, value;
} inp_parameter;

/* A keyword line, which decides how the data lines behind it are read. */
typedef struct inp_keyword {
  inp_word name;
  int count;
  inp_parameter parameters[PARAMETERS_MAX];
} inp_keyword;

typedef struct inp_element {
  int64_t number;
  int64_t tet;          /* -1: no tet */
  int64_t first, count; /* nodes of any other element, in `surface_nodes` */
} inp_element;

/* An element set holds elements by number. Its vertices become a group at the end. */
typedef struct inp_set {
  inp_word name;
  int64_t count, capacity;
  int64_t *elements;
} inp_set;

typedef struct inp_material {
  inp_word name;
  thrum_material values;
  bool has_elastic, has_density;
} inp_material;

typedef struct inp_section {
  inp_word set, material;
  int64_t line;
} inp_section;

typedef struct inp_reader {
  thrum_text text;
  int64_t text_size;
  bool again; /* the present line is a keyword still to be read */
  thrum_mesh_builder builder;
  int64_t part_count;
  int64_t element_count, element_capacity;
  inp_element *elements;
  int64_t surface_node_count, surface_node_capacity;
  int64_t *surface_nodes;
  int64_t set_count, set_capacity;
  inp_set *sets;
  int64_t material_count, material_capacity;
  inp_material *materials;
  int64_t section_count, section_capacity;
  inp_section *sections;
  thrum_error *error;
} inp_reader;

static thrum_status fail(inp_reader *r, const char *line) {
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "%s", line);
}

static thrum_status no_memory(inp_reader *r) {
  return thrum_text_fail(&r->text, THRUM_OUT_OF_MEMORY, r->error, "not enough memory");
}

static bool same(inp_word a, inp_word b) {
  if (a.length != b.length)
    return false;
  for (size_t i = 0; i < a.length; i++) {
    const char x = a.text[i], y = b.text[i];
    const char low = x >= 'A' && x <= 'Z' ? (char)(x - 'A' + 'a') : x;
    if (low != (y >= 'A' && y <= 'Z' ? (char)(y - 'A' + 'a') : y))
      return false;
  }
  return true;
}

static bool is(inp_word word, const char *name) {
  return thrum_text_equals(word.text, word.length, name);
}

/* Returns the text without the blanks and quotes around it. */
static inp_word trim(const char *start, const char *end) {
  while (start < end && (*start == ' ' || *start == '\t'))
    start++;
  while (end > start && (end[-1] == ' ' || end[-1] == '\t'))
    end--;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }
  return (inp_word){start, (size_t)(end - start)};
}

/* Goes to the next line that is no comment. */
static bool next_line(inp_reader *r) {
  if (r->again) {
    r->again = false;
    thrum_text_rewind(&r->text);
    return true;
  }
  while (thrum_text_next_line(&r->text))
    if (r->text.end - r->text.start < 2 || r->text.start[0] != '*' || r->text.start[1] != '*')
      return true;
  return false;
}

/* Goes to the next line of data; returns false at the end or at a keyword, which is read next. */
static bool data_line(inp_reader *r) {
  if (!next_line(r))
    return false;
  r->again = *r->text.start == '*';
  return !r->again;
}

/* Splits the present line at commas into `key=value`; a comma at its end continues the list on the
 * next line. */
static void read_parameters(inp_reader *r, const char *start, inp_keyword *keyword) {
  for (;;) {
    const char *end = r->text.end, *comma = memchr(start, ',', (size_t)(end - start));
    const char *stop = comma ? comma : end;

    // a parameter without '=' is a flag such as GENERATE
    const char *equals = memchr(start, '=', (size_t)(stop - start));

    inp_word key = trim(start, equals ? equals : stop);
    if (key.length > 0 && keyword->count < PARAMETERS_MAX)
      keyword->parameters[keyword->count++] =
          (inp_parameter){key, equals ? trim(equals + 1, stop) : (inp_word){"", 0}};

    // the list ends with its last parameter
    if (!comma)
      return;
    start = comma + 1;

    // a comma at the end of a line says that the next one goes on
    if (start == end) {
      if (!next_line(r))
        return;
      start = r->text.start;
    }
  }
}

static void read_keyword(inp_reader *r, inp_keyword *keyword) {
  const char *start = r->text.start + 1, *end = r->text.end;
  const char *comma = memchr(start, ',', (size_t)(end - start));
  *keyword = (inp_keyword){.name = trim(start, comma ? comma : end)};
  if (comma)
    read_parameters(r, comma + 1 < end ? comma + 1 : end, keyword);
  r->text.at = r->text.end;
}

/* Returns the value of a parameter; its length is 0 when the parameter is not there. */
static inp_word parameter(const inp_keyword *keyword, const char *key) {
  for (int i = 0; i < keyword->count; i++)
    if (is(keyword->parameters[i].key, key))
      return keyword->parameters[i].value;
  return (inp_word){"", 0};
}

static bool has_parameter(const inp_keyword *keyword, const char *key) {
  for (int i = 0; i < keyword->count; i++)
    if (is(keyword->parameters[i].key, key))
      return true;
  return false;
}

static thrum_status integer(inp_reader *r, const char *what, int64_t low, int64_t *value) {
  return thrum_text_integer(&r->text, what, low, INT64_MAX, value, r->error);
}

/* Finds the list of the builder that stands for a node set. */
static thrum_status node_list(inp_reader *r, inp_word name, int64_t *list) {
  const char *fault = thrum_mesh_name_fault(name.text, name.length);
  if (fault)
    return fail(r, fault);
  return thrum_builder_list(&r->builder, name.text, name.length, list);
}

static thrum_status read_nodes(inp_reader *r, const inp_keyword *keyword) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  const inp_word set = parameter(keyword, "NSET");
  int64_t list = -1;
  if (set.length > 0)
    THRUM_TRY(node_list(r, set, &list));
  while (data_line(r)) {
    int64_t number = 0;
    double position[3] = {0};
    THRUM_TRY(integer(r, "the number of a node", 1, &number));

    // coordinates left out are 0
    for (int c = 0; c < 3 && thrum_text_more(&r->text); c++)
      THRUM_TRY(thrum_text_number(&r->text, axes[c], &position[c], r->error));
    THRUM_TRY(thrum_builder_vertex(&r->builder, number, position, r->text.line));
    if (list >= 0)
      THRUM_TRY(thrum_builder_add(&r->builder, list, number));
  }
  return THRUM_OK;
}

/* Finds the index of an element set, which is added when it is new. */
static thrum_status find_set(inp_reader *r, inp_word name, int64_t *index) {
  for (*index = 0; *index < r->set_count; ++*index)
    if (same(r->sets[*index].name, name))
      return THRUM_OK;

  // a set becomes a group, so it needs a name that a group can have
  const char *fault = thrum_mesh_name_fault(name.text, name.length);
  if (fault)
    return fail(r, fault);
  if (r->set_count == THRUM_MESH_GROUPS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than %d element sets",
                           THRUM_MESH_GROUPS_MAX);

  if (!thrum_mesh_grow(&r->sets, &r->set_capacity, r->set_count + 1, sizeof *r->sets))
    return no_memory(r);
  r->sets[r->set_count++] = (inp_set){.name = name};
  return THRUM_OK;
}

/* Refuses a set of a size that no sensible set reaches, since sets that name sets can double with
 * every line. */
static thrum_status check_growth(inp_reader *r, int64_t count) {
  const int64_t most = 16 * (r->builder.vertex_count + r->element_count) + r->text_size;
  return count <= most ? THRUM_OK : fail(r, "the set names far more than the file holds");
}

static thrum_status add_to_set(inp_reader *r, int64_t index, int64_t element) {
  inp_set *set = &r->sets[index];
  THRUM_TRY(check_growth(r, set->count));
  if (!thrum_mesh_grow(&set->elements, &set->capacity, set->count + 1, sizeof element))
    return no_memory(r);
  set->elements[set->count++] = element;
  return THRUM_OK;
}

static thrum_status add_element(inp_reader *r, int64_t number, int64_t tet) {
  if (!thrum_mesh_grow(&r->elements, &r->element_capacity, r->element_count + 1,
                       sizeof *r->elements))
    return no_memory(r);
  r->elements[r->element_count++] = (inp_element){number, tet, r->surface_node_count, 0};
  return THRUM_OK;
}

/* Returns the nodes of a solid element's type, 4 or 10; 0 for other elements; -1 for a solid that
 * is not supported. */
static int node_count(inp_word type) {
  if (type.length >= 5 && thrum_text_equals(type.text, 5, "C3D10"))
    return 10;
  if (type.length >= 4 && thrum_text_equals(type.text, 4, "C3D4"))
    return 4;
  const bool solid = (type.length >= 3 && thrum_text_equals(type.text, 3, "C3D")) ||
                     (type.length >= 3 && thrum_text_equals(type.text, 3, "DC3"));
  return solid ? -1 : 0;
}

/* Reads a tet's number and nodes, which may continue on further lines. */
static thrum_status read_tet(inp_reader *r, int nodes, int64_t set) {
  int64_t number = 0, vertices[10] = {0};
  const int64_t line = r->text.line;
  THRUM_TRY(integer(r, "the number of an element", 1, &number));

  // the corners come first
  for (int n = 0; n < nodes; n++) {
    int64_t node = 0;
    if (!thrum_text_more(&r->text) && !data_line(r))
      return fail(r, "an element has too few nodes");
    THRUM_TRY(integer(r, "a node of the element", 1, &node));
    vertices[n] = node;
  }
  THRUM_TRY(thrum_text_finish(&r->text, "the nodes", r->error));
  THRUM_TRY(add_element(r, number, r->builder.tet_count));
  if (set >= 0)
    THRUM_TRY(add_to_set(r, set, number));

  // ten nodes stand in the order that meshes have here
  return nodes > CORNERS ? thrum_builder_quadratic_tet(&r->builder, vertices, -1, line)
                         : thrum_builder_tet(&r->builder, vertices, -1, line);
}

/* Reads an element that is no solid; its nodes belong to the groups of its sets. */
static thrum_status read_surface(inp_reader *r, int64_t set) {
  int64_t number = 0, node = 0;
  THRUM_TRY(integer(r, "the number of an element", 1, &number));
  THRUM_TRY(add_element(r, number, -1));
  while (thrum_text_more(&r->text)) {
    THRUM_TRY(integer(r, "a node of the element", 1, &node));

    // a triangle or quadrilateral keeps its nodes, for the groups of its sets
    if (!thrum_mesh_grow(&r->surface_nodes, &r->surface_node_capacity, r->surface_node_count + 1,
                         sizeof node))
      return no_memory(r);
    r->surface_nodes[r->surface_node_count++] = node;
    r->elements[r->element_count - 1].count++;
  }
  return set < 0 ? THRUM_OK : add_to_set(r, set, number);
}

static thrum_status read_elements(inp_reader *r, const inp_keyword *keyword) {
  const inp_word type = parameter(keyword, "TYPE"), name = parameter(keyword, "ELSET");
  const int nodes = node_count(type);
  int64_t set = -1;
  if (nodes < 0)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "elements of type %s are not supported; the body must be meshed with "
                           "C3D4 alone",
                           thrum_text_excerpt(type.text, type.length).text);
  if (name.length > 0)
    THRUM_TRY(find_set(r, name, &set));
  while (data_line(r))
    THRUM_TRY(nodes == 0 ? read_surface(r, set) : read_tet(r, nodes, set));
  return THRUM_OK;
}

/* Adds a member to a set. Members are numbers, first-last-step with GENERATE, or names of sets that
 * were read before. */
typedef thrum_status add_member(inp_reader *r, int64_t set, int64_t member);

static thrum_status add_node(inp_reader *r, int64_t set, int64_t node) {
  THRUM_TRY(check_growth(r, r->builder.lists[set].count));
  return thrum_builder_add(&r->builder, set, node);
}

static thrum_status read_range(inp_reader *r, int64_t set, add_member *add) {
  int64_t first = 0, last = 0, step = 1;
  THRUM_TRY(integer(r, "the first of a range", 1, &first));
  THRUM_TRY(integer(r, "the last of a range", first, &last));
  if (thrum_text_more(&r->text))
    THRUM_TRY(integer(r, "the step of a range", 1, &step));
  if ((last - first) / step >= r->builder.vertex_count + r->element_count)
    return fail(r, "a range is longer than there are nodes and elements");

  // the range must not step past the largest integer
  for (int64_t n = first; n <= last; n += step) {
    THRUM_TRY(add(r, set, n));
    if (n > last - step)
      break;
  }
  return THRUM_OK;
}

static thrum_status add_named(inp_reader *r, int64_t set, inp_word name, add_member *add) {
  // a node set takes over the nodes of another node set
  if (add == add_node) {
    const thrum_mesh_builder *b = &r->builder;
    for (int64_t i = 0; i < b->list_count; i++) {
      const inp_word other = {b->lists[i].name, strlen(b->lists[i].name)};
      if (!same(other, name) || i == set)
        continue;
      for (int64_t n = 0; n < b->lists[i].count; n++)
        THRUM_TRY(add(r, set, b->lists[i].numbers[n]));
      return THRUM_OK;
    }
  }

  // an element set takes over the elements of another element set
  for (int64_t i = 0; add != add_node && i < r->set_count; i++) {
    if (!same(r->sets[i].name, name) || i == set)
      continue;
    for (int64_t n = 0; n < r->sets[i].count; n++)
      THRUM_TRY(add(r, set, r->sets[i].elements[n]));
    return THRUM_OK;
  }

  return thrum_text_fail(&r->text, THRUM_MISSING, r->error,
                         "the set names '%s', which is no set above it",
                         thrum_text_excerpt(name.text, name.length).text);
}

static thrum_status read_set(inp_reader *r, const inp_keyword *keyword, const char *key,
                             add_member *add) {
  const inp_word name = parameter(keyword, key);
  int64_t set = 0;
  if (name.length == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "the set has no name: %s=NAME",
                           key);

  // a set of nodes is a group; one of elements waits until all of them are known
  THRUM_TRY(add == add_node ? node_list(r, name, &set) : find_set(r, name, &set));
  while (data_line(r)) {
    if (has_parameter(keyword, "GENERATE")) {
      THRUM_TRY(read_range(r, set, add));
      continue;
    }

    // members are numbers, or names of sets that came before
    while (thrum_text_more(&r->text)) {
      int64_t member = 0;
      const char c = *r->text.at;
      if (c >= '0' && c <= '9') {
        THRUM_TRY(integer(r, "a member of the set", 1, &member));
        THRUM_TRY(add(r, set, member));
        continue;
      }

      const char *comma = memchr(r->text.at, ',', (size_t)(r->text.end - r->text.at));
      const char *end = comma ? comma : r->text.end;
      const inp_word word = trim(r->text.at, end);
      r->text.at = end;
      THRUM_TRY(add_named(r, set, word, add));
    }
  }
  return THRUM_OK;
}

static thrum_status read_material(inp_reader *r, const inp_keyword *keyword) {
  const inp_material material = {.name = parameter(keyword, "NAME")};
  if (r->material_count == SECTIONS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than %d materials",
                           SECTIONS_MAX);

  // sections name materials, so their names must be unique
  for (int64_t i = 0; i < r->material_count; i++)
    if (same(r->materials[i].name, material.name))
      return fail(r, "this material comes twice");

  if (!thrum_mesh_grow(&r->materials, &r->material_capacity, r->material_count + 1,
                       sizeof material))
    return no_memory(r);
  r->materials[r->material_count++] = material;
  return THRUM_OK;
}

/* Reads the first line of *ELASTIC or *DENSITY into the present material. */
static thrum_status read_property(inp_reader *r, const inp_keyword *keyword) {
  const bool elastic = is(keyword->name, "ELASTIC");
  if (r->material_count == 0)
    return fail(r, "a property comes before any *MATERIAL");

  // anisotropic materials have constants that the solver does not know
  const inp_word type = parameter(keyword, "TYPE");
  if (elastic && type.length > 0 && !is(type, "ISOTROPIC") && !is(type, "ISO"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "*ELASTIC of type %s is not supported, only ISOTROPIC",
                           thrum_text_excerpt(type.text, type.length).text);

  // the values belong to the last *MATERIAL
  inp_material *material = &r->materials[r->material_count - 1];
  if (!data_line(r))
    return fail(r, "the file ends, or goes on, before the values of the material");

  // both keywords give the constants at the first temperature on one line
  thrum_status status;
  if (elastic) {
    status = thrum_text_number(&r->text, "Young's modulus", &material->values.young, r->error);
    THRUM_THEN(status,
               thrum_text_number(&r->text, "Poisson's ratio", &material->values.poisson, r->error));
    material->has_elastic = true;
  } else {
    status = thrum_text_number(&r->text, "the density", &material->values.density, r->error);
    material->has_density = true;
  }

  // further lines are for other temperatures
  return status;
}

static thrum_status read_section(inp_reader *r, const inp_keyword *keyword) {
  const inp_section section = {parameter(keyword, "ELSET"), parameter(keyword, "MATERIAL"),
                               r->text.line};
  if (section.set.length == 0 || section.material.length == 0)
    return fail(r, "*SOLID SECTION needs ELSET=SET and MATERIAL=NAME");

  // the names are resolved at the end, since sets and materials may follow
  if (r->section_count == SECTIONS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than %d sections",
                           SECTIONS_MAX);

  if (!thrum_mesh_grow(&r->sections, &r->section_capacity, r->section_count + 1, sizeof section))
    return no_memory(r);
  r->sections[r->section_count++] = section;
  return THRUM_OK;
}

static thrum_status obey(inp_reader *r, const inp_keyword *keyword) {
  const inp_word name = keyword->name;

  // the keywords that describe the body
  if (is(name, "NODE"))
    return read_nodes(r, keyword);
  if (is(name, "ELEMENT"))
    return read_elements(r, keyword);
  if (is(name, "NSET"))
    return read_set(r, keyword, "NSET", add_node);
  if (is(name, "ELSET"))
    return read_set(r, keyword, "ELSET", add_to_set);

  // the keywords that describe its materials
  if (is(name, "MATERIAL"))
    return read_material(r, keyword);
  if (is(name, "ELASTIC") || is(name, "DENSITY"))
    return read_property(r, keyword);
  if (is(name, "SOLID SECTION"))
    return read_section(r, keyword);

  // an included file may hold anything, so it is not passed over silently
  if (is(name, "INCLUDE"))
    return fail(r, "*INCLUDE is not read; put the included file in its place");

  // node numbers are unique within one part only
  if ((is(name, "PART") || is(name, "INSTANCE")) && has_parameter(keyword, "NAME")) {
    r->part_count += is(name, "PART");
    if (r->part_count > 1)
      return fail(r, "there are several parts; save each as a file of its own");
  }

  return THRUM_OK;
}

static int compare_elements(const void *a, const void *b) {
  const inp_element *x = a, *y = b;
  return (x->number > y->number) - (x->number < y->number);
}

static thrum_status sort_elements(inp_reader *r) {
  if (r->element_count > 0)
    qsort(r->elements, (size_t)r->element_count, sizeof *r->elements, compare_elements);
  for (int64_t i = 1; i < r->element_count; i++)
    if (r->elements[i - 1].number == r->elements[i].number)
      return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.200s: element %lld comes twice",
                             r->text.name, (long long)r->elements[i].number);
  return THRUM_OK;
}

/* Finds the element that a member of a set names. */
static thrum_status find_member(inp_reader *r, const inp_set *set, int64_t number,
                                const inp_element **element) {
  const inp_element key = {.number = number};
  const inp_element *found = NULL;
  if (r->element_count > 0)
    found = bsearch(&key, r->elements, (size_t)r->element_count, sizeof key, compare_elements);
  if (!found)
    return thrum_error_set(
        r->error, THRUM_BAD_VALUE, "%.150s: set '%s' names element %lld, which is not in the file",
        r->text.name, thrum_text_excerpt(set->name.text, set->name.length).text, (long long)number);
  *element = found;
  return THRUM_OK;
}

/* Makes a group of the vertices of each element set. */
static thrum_status set_groups(inp_reader *r) {
  for (int64_t s = 0; s < r->set_count; s++) {
    const inp_set *set = &r->sets[s];
    const inp_element *element = NULL;
    int64_t list = 0;

    // the set that is everything is no group, as in .veg
    if (is(set->name, "allElements"))
      continue;
    THRUM_TRY(node_list(r, set->name, &list));

    for (int64_t i = 0; i < set->count; i++) {
      THRUM_TRY(find_member(r, set, set->elements[i], &element));

      // a tet gives its corners first, any other element all its nodes
      const bool tet = element->tet >= 0;
      const int64_t count = tet ? CORNERS : element->count;
      if (count == 0) // neither a tet nor a face; there may be no array of faces at all
        continue;

      // the group has the nodes of the set's tets and of its faces
      const int64_t *nodes =
          tet ? r->builder.tets + CORNERS * element->tet : r->surface_nodes + element->first;
      for (int64_t n = 0; n < count; n++)
        THRUM_TRY(thrum_builder_add(&r->builder, list, nodes[n]));

      // a file of mixed orders, which is refused later, has no middle nodes that are known
      for (int n = 0; n < 6 && tet && r->builder.middles && r->builder.odd_tet == 0; n++)
        THRUM_TRY(thrum_builder_add(&r->builder, list, r->builder.middles[6 * element->tet + n]));
    }
  }
  return THRUM_OK;
}

/* Gives the tets of a section its index as the key of their region; a later section overrides. */
static thrum_status apply_section(inp_reader *r, int64_t index) {
  const inp_section *section = &r->sections[index];
  const inp_element *element = NULL;
  int64_t s = 0;

  // the set may stand below the section, so it is searched only now
  while (s < r->set_count && !same(r->sets[s].name, section->set))
    s++;

  // a section without its set would leave tets without material
  if (s == r->set_count)
    return thrum_error_set(r->error, THRUM_MISSING, "%.150s:%lld: there is no element set '%s'",
                           r->text.name, (long long)section->line,
                           thrum_text_excerpt(section->set.text, section->set.length).text);

  // the section is the region of its tets
  for (int64_t i = 0; i < r->sets[s].count; i++) {
    THRUM_TRY(find_member(r, &r->sets[s], r->sets[s].elements[i], &element));
    if (element->tet >= 0)
      r->builder.keys[element->tet] = index;
  }
  return THRUM_OK;
}

static const inp_material *find_material(const inp_reader *r, inp_word name) {
  for (int64_t i = 0; i < r->material_count; i++)
    if (same(r->materials[i].name, name))
      return &r->materials[i];
  return NULL;
}

/* Sets the material of each region. Files for statics often have no density: if no section has a
 * complete material, the mesh has none, and the user must give it. */
static thrum_status region_materials(inp_reader *r, thrum_mesh *mesh) {
  int64_t whole = 0;
  const inp_section *partial = NULL;

  // a region's key is the index of its section, -1 for tets without one
  for (int64_t i = 0; i < mesh->region_count && r->section_count > 0; i++) {
    const int64_t key = r->builder.region_keys[i];
    if (key < 0)
      return thrum_error_set(r->error, THRUM_MISSING,
                             "%.150s: some tets are in no *SOLID SECTION, so they have no material",
                             r->text.name);

    // the section's material may stand anywhere in the file
    const inp_section *section = &r->sections[key];
    const inp_material *material = find_material(r, section->material);
    if (!material)
      return thrum_error_set(
          r->error, THRUM_MISSING, "%.150s:%lld: there is no material '%s'", r->text.name,
          (long long)section->line,
          thrum_text_excerpt(section->material.text, section->material.length).text);

    // incomplete materials are an error only beside complete ones
    mesh->materials[i] = material->values;
    if (material->has_elastic && material->has_density)
      whole++;
    else
      partial = section;
  }

  // a mixture of complete and incomplete materials is a mistake in the file
  if (whole > 0 && partial)
    return thrum_error_set(
        r->error, THRUM_MISSING, "%.150s:%lld: material '%s' needs both *ELASTIC and *DENSITY",
        r->text.name, (long long)partial->line,
        thrum_text_excerpt(partial->material.text, partial->material.length).text);

  // without any complete material the mesh has none, so half-read values are cleared
  mesh->has_material = whole > 0;
  for (int64_t i = 0; i < mesh->region_count && !mesh->has_material; i++)
    mesh->materials[i] = (thrum_material){0};
  return THRUM_OK;
}

static thrum_status read_all(inp_reader *r, thrum_mesh *mesh) {
  while (next_line(r)) {
    inp_keyword keyword;
    if (*r->text.start != '*')
      return thrum_text_fail(
          &r->text, THRUM_BAD_FORMAT, r->error,
          "expected a keyword such as *NODE, found '%s'; is it an Abaqus input file?",
          thrum_text_excerpt(r->text.start, (size_t)(r->text.end - r->text.start)).text);

    read_keyword(r, &keyword);
    THRUM_TRY(obey(r, &keyword));
    // data lines of other keywords are passed over
    while (data_line(r))
      continue;
  }

  if ((r->builder.vertex_count == 0 || r->builder.tet_count == 0))
    return thrum_text_fail(&r->text, THRUM_MISSING, r->error, "there is no %s; is the file whole?",
                           r->builder.vertex_count == 0 ? "*NODE" : "*ELEMENT of type C3D4");

  // sections and sets may name elements that came later
  THRUM_TRY(sort_elements(r));
  for (int64_t i = 0; i < r->section_count; i++)
    THRUM_TRY(apply_section(r, i));
  THRUM_TRY(set_groups(r));
  THRUM_TRY(thrum_builder_finish(&r->builder, r->text.name, mesh));
  return region_materials(r, mesh);
}

thrum_status thrum_mesh_parse_abaqus(const char *name, const void *data, size_t size,
                                     thrum_mesh *mesh, thrum_error *error) {
  inp_reader r = {.error = error, .text_size = (int64_t)size, .builder = {.error = error}};
  thrum_mesh read = {0};
  thrum_status status = thrum_text_view(name, data, size, 0, ',', &r.text, error);
  THRUM_THEN(status, read_all(&r, &read));

  // what the reader gathered on the way
  for (int64_t s = 0; s < r.set_count; s++)
    free(r.sets[s].elements);
  free(r.sets);
  free(r.elements);
  free(r.surface_nodes);
  free(r.materials);
  free(r.sections);
  thrum_builder_free(&r.builder);

  return thrum_mesh_deliver(status, &read, mesh);
}
