/* Reads Abaqus input files (.inp), as far as they describe a body: *NODE, *ELEMENT (C3D4, C3D10,
 * and C3D5, C3D6, C3D8, C3D15, C3D20, which are cut into tets), *NSET, *ELSET (both with GENERATE),
 * *MATERIAL with *ELASTIC and *DENSITY, *SOLID SECTION. Keywords, parameters and names in any case;
 * ** comments; other keywords are passed over. Node sets and the nodes of element sets, those of
 * surface elements too, are groups; solid sections are the regions. The element set allElements is
 * no group. A file holds one part, and one *INSTANCE of it, which is put where that says; nodes and
 * sets of an *ASSEMBLY that belong to no instance, such as reference points, are passed over.
 * Cost: linear in the file, n log n in elements that sets name.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "runtime/base/vec3.h"

enum { PARAMETERS_MAX = 16 };

typedef struct inp_parameter {
  thrum_word key, value;
} inp_parameter;

/* A keyword line, which decides how the data lines behind it are read. */
typedef struct inp_keyword {
  thrum_word name;
  int count;
  inp_parameter parameters[PARAMETERS_MAX];
} inp_keyword;

typedef struct inp_element {
  int64_t number;
  int64_t tet, tets;    /* the first of its tets, and how many; 0: no solid */
  int64_t first, count; /* nodes of any other element, in `surface_nodes` */
} inp_element;

/* An element set holds elements by number. Its vertices become a group at the end. */
typedef struct inp_set {
  thrum_word name;
  int64_t count;
  int64_t *elements;
} inp_set;

typedef struct inp_material {
  thrum_word name;
  thrum_material values;
  bool has_elastic, has_density;
} inp_material;

typedef struct inp_section {
  thrum_word set, material;
  int64_t line;
} inp_section;

/* Where an instance of a part is put: moved first, then turned about an axis through two points. */
typedef struct inp_instance {
  thrum_word name;
  double move[3];
  double axis[2][3];
  double degrees;
} inp_instance;

typedef struct inp_reader {
  thrum_text text;
  int64_t text_size;
  bool again; /* the present line is a keyword still to be read */
  thrum_mesh_builder builder;
  int64_t part_count, instance_count;
  bool in_assembly, in_instance;
  bool beside_body;      /* the present keyword is of the assembly and of no instance */
  inp_instance instance; /* the one that there is */
  int64_t modified_tets; /* elements of type C3D10M */
  int64_t element_count;
  inp_element *elements;
  int64_t surface_node_count;
  int64_t *surface_nodes;
  int64_t set_count;
  inp_set *sets;
  int64_t material_count;
  inp_material *materials;
  int64_t section_count;
  inp_section *sections;
} inp_reader;

static bool same(thrum_word a, thrum_word b) {
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

/* Returns the text without the blanks and quotes around it. */
static thrum_word trim(const char *start, const char *end) {
  while (start < end && (*start == ' ' || *start == '\t'))
    start++;
  while (end > start && (end[-1] == ' ' || end[-1] == '\t'))
    end--;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }
  return (thrum_word){start, (size_t)(end - start)};
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

    thrum_word key = trim(start, equals ? equals : stop);
    if (key.length > 0 && keyword->count < PARAMETERS_MAX)
      keyword->parameters[keyword->count++] =
          (inp_parameter){key, equals ? trim(equals + 1, stop) : (thrum_word){"", 0}};

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

/* Returns the value of a parameter, whose text is NULL when the parameter is not there. */
static thrum_word parameter(const inp_keyword *keyword, const char *key) {
  for (int i = 0; i < keyword->count; i++)
    if (thrum_text_equals(keyword->parameters[i].key, key))
      return keyword->parameters[i].value;
  return (thrum_word){NULL, 0};
}

static bool has_parameter(const inp_keyword *keyword, const char *key) {
  return parameter(keyword, key).text != NULL;
}

static thrum_status integer(inp_reader *r, const char *what, int64_t low, int64_t *value) {
  return thrum_text_integer(&r->text, what, low, INT64_MAX, value);
}

/* Finds the list of the builder that stands for a node set. */
static thrum_status node_list(inp_reader *r, thrum_word name, int64_t *list) {
  THRUM_TRY(thrum_mesh_name_check(&r->text, name));
  return thrum_builder_list(&r->builder, name.text, name.length, list);
}

static thrum_status read_nodes(inp_reader *r, const inp_keyword *keyword) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  const thrum_word set = parameter(keyword, "NSET");
  int64_t list = -1;
  if (set.length > 0)
    THRUM_TRY(node_list(r, set, &list));
  while (data_line(r)) {
    int64_t number = 0;
    double position[3] = {0};
    THRUM_TRY(integer(r, "the number of a node", 1, &number));

    // coordinates left out are 0
    for (int c = 0; c < 3 && thrum_text_more(&r->text); c++)
      THRUM_TRY(thrum_text_number(&r->text, axes[c], &position[c]));
    THRUM_TRY(thrum_builder_vertex(&r->builder, number, position, r->text.line));
    if (list >= 0)
      THRUM_TRY(thrum_builder_add(&r->builder, list, number));
  }
  return THRUM_OK;
}

/* The index of the element set of that name, or set_count where there is none. */
static int64_t set_index(const inp_reader *r, thrum_word name) {
  int64_t s = 0;
  while (s < r->set_count && !same(r->sets[s].name, name))
    s++;
  return s;
}

/* Finds the index of an element set, which is added when it is new. */
static thrum_status find_set(inp_reader *r, thrum_word name, int64_t *index) {
  *index = set_index(r, name);
  if (*index < r->set_count)
    return THRUM_OK;

  // a set becomes a group, so it needs a name that a group can have
  THRUM_TRY(thrum_mesh_name_check(&r->text, name));
  const inp_set fresh = {.name = name};
  return thrum_mesh_append_few(&r->text, "element sets", &r->sets, &r->set_count, &fresh,
                               sizeof fresh);
}

/* Refuses a set of a size that no sensible set reaches, since sets that name sets can double with
 * every line. */
static thrum_status check_growth(inp_reader *r, int64_t count) {
  const int64_t most = 16 * (r->builder.vertex_count + r->element_count) + r->text_size;
  return count <= most ? THRUM_OK
                       : thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                                         "the set names far more than the file holds");
}

static thrum_status add_to_set(inp_reader *r, int64_t index, int64_t element) {
  inp_set *set = &r->sets[index];
  THRUM_TRY(check_growth(r, set->count));
  return thrum_mesh_append(&set->elements, &set->count, &element, sizeof element, r->text.error);
}

static thrum_status add_element(inp_reader *r, inp_element element) {
  return thrum_mesh_append(&r->elements, &r->element_count, &element, sizeof element,
                           r->text.error);
}

/* A solid by the beginning of its type; letters behind it, as in C3D8R, are kinds of integration.
 */
typedef struct inp_solid {
  const char *type;
  int nodes;
  thrum_solid solid;
  bool quadratic;
} inp_solid;

static const inp_solid SOLIDS[] = {
    {"C3D4", 4, THRUM_SOLID_TET, false},        {"C3D10", 10, THRUM_SOLID_TET, true},
    {"C3D5", 5, THRUM_SOLID_PYRAMID, false},    {"C3D6", 6, THRUM_SOLID_WEDGE, false},
    {"C3D15", 15, THRUM_SOLID_WEDGE, true},     {"C3D8", 8, THRUM_SOLID_HEXAHEDRON, false},
    {"C3D20", 20, THRUM_SOLID_HEXAHEDRON, true}};

/* Finds the solid that a type is; *unknown tells a solid that is not read. */
static const inp_solid *find_solid(thrum_word type, bool *unknown) {
  *unknown = false;
  for (size_t i = 0; i < sizeof SOLIDS / sizeof *SOLIDS; i++) {
    const size_t length = strlen(SOLIDS[i].type);

    // C3D15V has three nodes more than C3D15
    if (type.length >= length &&
        thrum_text_equals((thrum_word){type.text, length}, SOLIDS[i].type) &&
        (type.length == length || (type.text[length] != 'V' && type.text[length] != 'v')))
      return &SOLIDS[i];
  }
  *unknown = type.length >= 3 && (thrum_text_equals((thrum_word){type.text, 3}, "C3D") ||
                                  thrum_text_equals((thrum_word){type.text, 3}, "DC3"));
  return NULL;
}

/* Hexahedra of incompatible modes may name three nodes more, which hold those and lie nowhere. */
static int inner_nodes(thrum_word type) {
  return type.length == 5 && thrum_text_equals((thrum_word){type.text, 5}, "C3D8I") ? 3 : 0;
}

/* Ends a solid that began on `line`. An element with too few nodes takes those of the next one, so
 * it is named where a line of numbers is too long. */
static thrum_status end_solid(inp_reader *r, int64_t line, int64_t number, int nodes) {
  if (r->text.line > line && thrum_text_more(&r->text))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "element %lld, which begins on line %lld, has more than %d nodes with "
                           "this line: it lacks some, or a line between them is broken",
                           (long long)number, (long long)line, nodes);
  return thrum_text_finish(&r->text, "the nodes");
}

/* Reads a solid's number and nodes, which may continue on further lines; `inner` more may follow on
 * the last one. */
static thrum_status read_solid(inp_reader *r, const inp_solid *solid, int inner, int64_t set) {
  int64_t number = 0, nodes[THRUM_SOLID_NODES_MAX] = {0};
  const int64_t line = r->text.line, first = r->builder.tet_count;
  THRUM_TRY(integer(r, "the number of an element", 1, &number));

  for (int n = 0; n < solid->nodes; n++) {
    if (!thrum_text_more(&r->text) && !data_line(r))
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                             "element %lld has too few nodes: %d, not %d", (long long)number, n,
                             solid->nodes);
    THRUM_TRY(integer(r, "a node of the element", 1, &nodes[n]));
  }
  int64_t ignored;
  for (int n = 0; n < inner && thrum_text_more(&r->text); n++)
    THRUM_TRY(integer(r, "a node of the element", 1, &ignored));
  THRUM_TRY(end_solid(r, line, number, solid->nodes));

  // nodes stand in the order that elements have here
  THRUM_TRY(thrum_builder_element(&r->builder, &(thrum_element){.kind = solid->solid,
                                                                .quadratic = solid->quadratic,
                                                                .nodes = nodes,
                                                                .number = number,
                                                                .key = -1,
                                                                .line = line}));
  THRUM_TRY(add_element(
      r, (inp_element){.number = number, .tet = first, .tets = r->builder.tet_count - first}));
  return set < 0 ? THRUM_OK : add_to_set(r, set, number);
}

/* Reads an element that is no solid; its nodes belong to the groups of its sets. */
static thrum_status read_surface(inp_reader *r, int64_t set) {
  int64_t number = 0, node = 0;
  THRUM_TRY(integer(r, "the number of an element", 1, &number));
  THRUM_TRY(add_element(r, (inp_element){.number = number, .first = r->surface_node_count}));
  while (thrum_text_more(&r->text)) {
    THRUM_TRY(integer(r, "a node of the element", 0, &node));

    // elements of networks say by 0 that they have no node at an end
    if (node == 0)
      continue;

    // a triangle or quadrilateral keeps its nodes, for the groups of its sets
    THRUM_TRY(thrum_mesh_append(&r->surface_nodes, &r->surface_node_count, &node, sizeof node,
                                r->text.error));
    r->elements[r->element_count - 1].count++;
  }
  return set < 0 ? THRUM_OK : add_to_set(r, set, number);
}

static thrum_status read_elements(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word type = parameter(keyword, "TYPE"), name = parameter(keyword, "ELSET");
  bool unknown;
  const inp_solid *solid = find_solid(type, &unknown);
  const int64_t before = r->element_count;
  int64_t set = -1;
  if (unknown)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "elements of type %s are not supported; the body must be meshed with "
                           "C3D4, C3D10, C3D6, C3D8, C3D15 or C3D20",
                           thrum_text_excerpt(type).text);
  if (name.length > 0)
    THRUM_TRY(find_set(r, name, &set));
  while (data_line(r))
    THRUM_TRY(solid ? read_solid(r, solid, inner_nodes(type), set) : read_surface(r, set));

  // modified elements lump their mass and share forces in another way
  if (type.length >= 6 && thrum_text_equals((thrum_word){type.text, 6}, "C3D10M"))
    r->modified_tets += r->element_count - before;
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
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "a range is longer than there are nodes and elements");

  // the range must not step past the largest integer
  for (int64_t n = first; n <= last; n += step) {
    THRUM_TRY(add(r, set, n));
    if (n > last - step)
      break;
  }
  return THRUM_OK;
}

static thrum_status add_named(inp_reader *r, int64_t set, thrum_word name, add_member *add) {
  // a node set takes over the nodes of another node set
  if (add == add_node) {
    const thrum_mesh_builder *b = &r->builder;
    for (int64_t i = 0; i < b->list_count; i++) {
      const thrum_word other = {b->lists[i].name, strlen(b->lists[i].name)};
      if (!same(other, name) || i == set)
        continue;
      for (int64_t n = 0; n < b->lists[i].count; n++)
        THRUM_TRY(add(r, set, b->lists[i].numbers[n]));
      return THRUM_OK;
    }
  }

  // an element set takes over the elements of another element set
  const int64_t other = add == add_node ? r->set_count : set_index(r, name);
  for (int64_t n = 0; other < r->set_count && other != set && n < r->sets[other].count; n++)
    THRUM_TRY(add(r, set, r->sets[other].elements[n]));
  if (other < r->set_count && other != set)
    return THRUM_OK;

  return thrum_text_fail(&r->text, THRUM_MISSING, "the set names '%s', which is no set above it",
                         thrum_text_excerpt(name).text);
}

/* Takes "INSTANCE." off the front of a member; true where it was there. */
static bool take_instance(inp_reader *r) {
  const thrum_word name = r->instance.name;
  const size_t left = (size_t)(r->text.end - r->text.at);
  if (name.length == 0 || left <= name.length || r->text.at[name.length] != '.' ||
      !same((thrum_word){r->text.at, name.length}, name))
    return false;
  r->text.at += name.length + 1;
  return true;
}

/* Reads a member of a set, a number or the name of a set that came before. In sets of the assembly
 * only members of the instance are part of the body. */
static thrum_status read_member(inp_reader *r, int64_t set, add_member *add) {
  const bool ours = take_instance(r) || !r->beside_body;
  int64_t member = 0;
  if (r->text.at < r->text.end && *r->text.at >= '0' && *r->text.at <= '9') {
    THRUM_TRY(integer(r, "a member of the set", 1, &member));
    return ours ? add(r, set, member) : THRUM_OK;
  }

  const char *end = r->text.at;
  while (end < r->text.end && *end != ',')
    end++;
  const thrum_word word = trim(r->text.at, end);
  r->text.at = end;
  return ours ? add_named(r, set, word, add) : THRUM_OK;
}

static thrum_status read_set(inp_reader *r, const inp_keyword *keyword, const char *key,
                             add_member *add) {
  const thrum_word name = parameter(keyword, key);
  int64_t set = 0;
  if (name.length == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "the set has no name: %s=NAME", key);

  // a set of nodes is a group; one of elements waits until all of them are known
  THRUM_TRY(add == add_node ? node_list(r, name, &set) : find_set(r, name, &set));
  const bool ranges = has_parameter(keyword, "GENERATE");
  while (data_line(r)) {
    if (ranges && !r->beside_body)
      THRUM_TRY(read_range(r, set, add));
    while (!ranges && thrum_text_more(&r->text))
      THRUM_TRY(read_member(r, set, add));
  }
  return THRUM_OK;
}

static const inp_material *find_material(const inp_reader *r, thrum_word name) {
  for (int64_t i = 0; i < r->material_count; i++)
    if (same(r->materials[i].name, name))
      return &r->materials[i];
  return NULL;
}

static thrum_status read_node_set(inp_reader *r, const inp_keyword *keyword) {
  return read_set(r, keyword, "NSET", add_node);
}

static thrum_status read_element_set(inp_reader *r, const inp_keyword *keyword) {
  return read_set(r, keyword, "ELSET", add_to_set);
}

static thrum_status read_material(inp_reader *r, const inp_keyword *keyword) {
  const inp_material material = {.name = parameter(keyword, "NAME")};

  // sections name materials, so their names must be unique
  if (find_material(r, material.name))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "this material comes twice");
  return thrum_mesh_append_few(&r->text, "materials", &r->materials, &r->material_count, &material,
                               sizeof material);
}

/* Refuses a property that changes with temperature or a field: there is one stiffness of a body. */
static thrum_status refuse_dependent(inp_reader *r, const inp_keyword *keyword) {
  return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                         "*%s changes with temperature or a field; leave the one line that is to "
                         "hold",
                         thrum_text_excerpt(keyword->name).text);
}

/* Reads *ELASTIC or *DENSITY into the present material. */
static thrum_status read_property(inp_reader *r, const inp_keyword *keyword) {
  const bool elastic = thrum_text_equals(keyword->name, "ELASTIC");
  if (r->material_count == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "a property comes before any *MATERIAL");

  // anisotropic materials have constants that the solver does not know
  const thrum_word type = parameter(keyword, "TYPE");
  if (elastic && type.length > 0 && !thrum_text_equals(type, "ISOTROPIC") &&
      !thrum_text_equals(type, "ISO"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "*ELASTIC of type %s is not supported, only ISOTROPIC",
                           thrum_text_excerpt(type).text);

  // the values belong to the last *MATERIAL
  inp_material *material = &r->materials[r->material_count - 1];
  if (!data_line(r))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "the file ends, or goes on, before the values of the material");

  // a temperature may stand behind the constants; with one line it changes nothing
  thrum_status status;
  if (elastic) {
    status = thrum_text_number(&r->text, "Young's modulus", &material->values.young);
    THRUM_THEN(status, thrum_text_number(&r->text, "Poisson's ratio", &material->values.poisson));
    material->has_elastic = true;
  } else {
    status = thrum_text_number(&r->text, "the density", &material->values.density);
    material->has_density = true;
  }

  if (status >= 0 && data_line(r))
    return refuse_dependent(r, keyword);
  return status;
}

static thrum_status read_section(inp_reader *r, const inp_keyword *keyword) {
  const inp_section section = {parameter(keyword, "ELSET"), parameter(keyword, "MATERIAL"),
                               r->text.line};
  if (section.set.length == 0 || section.material.length == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "*SOLID SECTION needs ELSET=SET and MATERIAL=NAME");

  // the names are resolved at the end, since sets and materials may follow
  return thrum_mesh_append_few(&r->text, "sections", &r->sections, &r->section_count, &section,
                               sizeof section);
}

/* Reads where an instance is put: a line of its translation, and one of two points of an axis and
 * an angle in degrees. */
static thrum_status read_instance(inp_reader *r, const inp_keyword *keyword) {
  inp_instance *instance = &r->instance;
  const thrum_word name = parameter(keyword, "NAME");
  double values[7] = {0};
  if (++r->instance_count > 1)
    return thrum_text_fail(
        &r->text, THRUM_UNSUPPORTED,
        "'%s' is a second instance beside '%s': a mesh is one body, so save each instance as a "
        "file of its own",
        thrum_text_excerpt(name).text, thrum_text_excerpt(instance->name).text);
  instance->name = name;
  r->in_instance = true;

  // both lines may be missing, and numbers at their ends
  for (int line = 0; line < 2 && data_line(r); line++) {
    int count = 0;
    for (; count < (line == 0 ? 3 : 7) && thrum_text_more(&r->text); count++)
      THRUM_TRY(thrum_text_number(&r->text, "a number of the instance's place", &values[count]));
    THRUM_TRY(thrum_text_finish(&r->text, "the instance's place"));
    if (line == 1 && count < 7)
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                             "a rotation is two points of its axis and an angle, seven numbers");
    memcpy(line == 0 ? instance->move : instance->axis[0], values,
           (line == 0 ? 3 : 6) * sizeof *values);
  }
  instance->degrees = values[6];
  return THRUM_OK;
}

/* Parts, instances and the assembly, whose numbers of nodes are each its own. */
static thrum_status enter_or_leave(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word name = keyword->name;
  if (thrum_text_equals(name, "PART") && ++r->part_count > 1)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "there are several parts; save each as a file of its own");
  if (thrum_text_equals(name, "ASSEMBLY") || thrum_text_equals(name, "END ASSEMBLY"))
    r->in_assembly = thrum_text_equals(name, "ASSEMBLY");
  if (thrum_text_equals(name, "END INSTANCE"))
    r->in_instance = false;
  return thrum_text_equals(name, "INSTANCE") ? read_instance(r, keyword) : THRUM_OK;
}

static thrum_status refuse_include(inp_reader *r, const inp_keyword *keyword) {
  (void)keyword; // an included file may hold anything, so it is not passed over silently
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                         "*INCLUDE is not read; put the included file in its place");
}

static thrum_status obey(inp_reader *r, const inp_keyword *keyword) {
  static const struct {
    const char *name;
    thrum_status (*read)(inp_reader *r, const inp_keyword *keyword);
  } keywords[] = {
      {"NODE", read_nodes},        {"ELEMENT", read_elements},      {"NSET", read_node_set},
      {"ELSET", read_element_set}, {"MATERIAL", read_material},     {"ELASTIC", read_property},
      {"DENSITY", read_property},  {"SOLID SECTION", read_section}, {"INCLUDE", refuse_include}};

  // nodes and elements of the assembly alone are reference points and the like
  r->beside_body = r->in_assembly && !r->in_instance && !has_parameter(keyword, "INSTANCE");
  for (size_t i = r->beside_body ? 2 : 0; i < sizeof keywords / sizeof *keywords; i++)
    if (thrum_text_equals(keyword->name, keywords[i].name))
      return keywords[i].read(r, keyword);
  return enter_or_leave(r, keyword);
}

/* Puts the vertices where the instance is: x' = a + R (x + move - a), by Rodrigues' formula for the
 * turn R about the axis from a. */
static thrum_status place_instance(inp_reader *r) {
  const inp_instance *at = &r->instance;
  const double radians = at->degrees * (3.14159265358979323846 / 180);
  double along[3];
  for (int c = 0; c < 3; c++)
    along[c] = at->axis[1][c] - at->axis[0][c];

  // an angle needs an axis
  const double length = sqrt(thrum_dot3(along, along));
  if (at->degrees != 0 && !(length > 0))
    return thrum_error_set(r->text.error, THRUM_BAD_VALUE,
                           "%.200s: the instance turns about an axis between equal points",
                           r->text.name);

  // Abaqus moves first and turns then, about an axis that does not move
  for (int64_t v = 0; v < r->builder.vertex_count; v++) {
    double *x = r->builder.positions + 3 * v, arm[3], across[3];
    for (int c = 0; c < 3; c++)
      x[c] += at->move[c];
    if (at->degrees == 0)
      continue;

    for (int c = 0; c < 3; c++) {
      arm[c] = x[c] - at->axis[0][c];
      along[c] = (at->axis[1][c] - at->axis[0][c]) / length;
    }
    thrum_cross3(along, arm, across);
    const double share = thrum_dot3(along, arm) * (1 - cos(radians));
    for (int c = 0; c < 3; c++)
      x[c] = at->axis[0][c] + cos(radians) * arm[c] + sin(radians) * across[c] + share * along[c];
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
      return thrum_error_set(r->text.error, THRUM_BAD_FORMAT, "%.200s: element %lld comes twice",
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
    return thrum_error_set(r->text.error, THRUM_BAD_VALUE,
                           "%.150s: set '%s' names element %lld, which is not in the file",
                           r->text.name, thrum_text_excerpt(set->name).text, (long long)number);
  *element = found;
  return THRUM_OK;
}

static thrum_status add_tet_nodes(inp_reader *r, int64_t list, int64_t t) {
  for (int n = 0; n < 4; n++)
    THRUM_TRY(thrum_builder_add(&r->builder, list, r->builder.tets[4 * t + n]));

  // a file of mixed orders, which is refused later, has no middle nodes that are known
  for (int n = 0; n < 6 && r->builder.middles && r->builder.odd_tet == 0; n++)
    if (r->builder.middles[6 * t + n] >= 0)
      THRUM_TRY(thrum_builder_add(&r->builder, list, r->builder.middles[6 * t + n]));
  return THRUM_OK;
}

/* Makes a group of the vertices of each element set. */
static thrum_status set_groups(inp_reader *r) {
  for (int64_t s = 0; s < r->set_count; s++) {
    const inp_set *set = &r->sets[s];
    const inp_element *element = NULL;
    int64_t list = 0;

    // the set that is everything is no group, as in .veg
    if (thrum_text_equals(set->name, "allElements"))
      continue;
    THRUM_TRY(node_list(r, set->name, &list));

    for (int64_t i = 0; i < set->count; i++) {
      THRUM_TRY(find_member(r, set, set->elements[i], &element));

      // a face or an edge gives all its nodes
      for (int64_t n = 0; n < element->count; n++)
        THRUM_TRY(thrum_builder_add(&r->builder, list, r->surface_nodes[element->first + n]));

      // and a solid those of its tets; nodes that a cut has made join groups later
      for (int64_t t = element->tet; t < element->tet + element->tets; t++)
        THRUM_TRY(add_tet_nodes(r, list, t));
    }
  }
  return THRUM_OK;
}

/* Gives the tets of a section its index as the key of their region; a later section overrides. */
static thrum_status apply_section(inp_reader *r, int64_t index) {
  const inp_section *section = &r->sections[index];
  const inp_element *element = NULL;

  // the set may stand below the section; without it tets would be left without material
  const int64_t s = set_index(r, section->set);
  if (s == r->set_count)
    return thrum_error_set(r->text.error, THRUM_MISSING,
                           "%.150s:%lld: there is no element set '%s'", r->text.name,
                           (long long)section->line, thrum_text_excerpt(section->set).text);

  // the section is the region of its tets
  for (int64_t i = 0; i < r->sets[s].count; i++) {
    THRUM_TRY(find_member(r, &r->sets[s], r->sets[s].elements[i], &element));
    for (int64_t t = element->tet; t < element->tet + element->tets; t++)
      r->builder.keys[t] = index;
  }
  return THRUM_OK;
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
      return thrum_error_set(r->text.error, THRUM_MISSING,
                             "%.150s: some tets are in no *SOLID SECTION, so they have no material",
                             r->text.name);

    // the section's material may stand anywhere in the file
    const inp_section *section = &r->sections[key];
    const inp_material *material = find_material(r, section->material);
    if (!material)
      return thrum_error_set(r->text.error, THRUM_MISSING, "%.150s:%lld: there is no material '%s'",
                             r->text.name, (long long)section->line,
                             thrum_text_excerpt(section->material).text);

    // a region has the name of its set
    THRUM_TRY(
        thrum_mesh_name_region(mesh, i, section->set.text, section->set.length, r->text.error));

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
        r->text.error, THRUM_MISSING, "%.150s:%lld: material '%s' needs both *ELASTIC and *DENSITY",
        r->text.name, (long long)partial->line, thrum_text_excerpt(partial->material).text);

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
          &r->text, THRUM_BAD_FORMAT,
          "expected a keyword such as *NODE, found '%s'; is it an Abaqus input file?",
          thrum_text_excerpt(thrum_text_line(&r->text)).text);

    read_keyword(r, &keyword);
    THRUM_TRY(obey(r, &keyword));
    // data lines of other keywords are passed over
    while (data_line(r))
      continue;
  }

  if (r->builder.vertex_count == 0 || r->builder.element_count == 0)
    return thrum_text_fail(&r->text, THRUM_MISSING, "there is no %s; is the file whole?",
                           r->builder.vertex_count == 0 ? "*NODE" : "*ELEMENT of type C3D4");

  // sections and sets may name elements that came later
  THRUM_TRY(sort_elements(r));
  for (int64_t i = 0; i < r->section_count; i++)
    THRUM_TRY(apply_section(r, i));
  THRUM_TRY(set_groups(r));
  THRUM_TRY(place_instance(r));
  THRUM_TRY(thrum_builder_finish(&r->builder, r->text.name, mesh));
  if (r->modified_tets > 0)
    thrum_mesh_add_note(mesh,
                        "%lld elements C3D10M were read as C3D10: their modified formulation "
                        "is Abaqus' own",
                        (long long)r->modified_tets);
  return region_materials(r, mesh);
}

thrum_status thrum_mesh_parse_abaqus(const thrum_mesh_source *source, thrum_mesh *mesh,
                                     thrum_error *error) {
  inp_reader r = {.text_size = (int64_t)source->size, .builder = {.error = error}};
  thrum_mesh read = {0};
  thrum_status status =
      thrum_text_view(source->name, source->data, source->size, 0, ',', &r.text, error);
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
