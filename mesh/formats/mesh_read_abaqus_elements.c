/* Elements of Abaqus decks: *ELEMENT, and *ELGEN and *ELCOPY, which make some of others. Solids go
 * to the builder at the end, when their regions are known.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "mesh/formats/mesh_read_abaqus.h"
#include "mesh/mesh_grow.h"

enum { LINE_FIELDS_MAX = 16 /* of a data line, by the format */ };

static const inp_solid SOLIDS[] = {
    {"C3D4", 4, THRUM_SOLID_TET, false},        {"C3D10", 10, THRUM_SOLID_TET, true},
    {"C3D5", 5, THRUM_SOLID_PYRAMID, false},    {"C3D6", 6, THRUM_SOLID_WEDGE, false},
    {"C3D15", 15, THRUM_SOLID_WEDGE, true},     {"C3D8", 8, THRUM_SOLID_HEXAHEDRON, false},
    {"C3D20", 20, THRUM_SOLID_HEXAHEDRON, true}};

/* Beginnings of types that fill a volume and are not read. */
static const char *const OTHER_SOLIDS[] = {"C3D",  "DC3D", "DCC3D", "AC3D",  "SC6",
                                           "SC8",  "CSS8", "COH3D", "CIN3D", "EC3D",
                                           "F3D8", "F3D6", "F3D4",  "CCL"};

static bool begins(thrum_word type, const char *with) {
  const size_t length = strlen(with);
  return type.length >= length && thrum_text_equals((thrum_word){type.text, length}, with);
}

/* Finds the solid that a type is; *unknown tells a solid that is not read. */
static const inp_solid *find_solid(thrum_word type, bool *unknown) {
  *unknown = false;
  for (size_t i = 0; i < sizeof SOLIDS / sizeof *SOLIDS; i++) {
    const size_t length = strlen(SOLIDS[i].type);

    // C3D15V has three nodes more than C3D15
    if (begins(type, SOLIDS[i].type) &&
        (type.length == length || (type.text[length] != 'V' && type.text[length] != 'v')))
      return &SOLIDS[i];
  }
  for (size_t i = 0; i < sizeof OTHER_SOLIDS / sizeof *OTHER_SOLIDS; i++)
    *unknown = *unknown || begins(type, OTHER_SOLIDS[i]);
  return NULL;
}

/* Hexahedra of incompatible modes may name three nodes more, which hold those and lie nowhere. */
static int inner_nodes(thrum_word type) {
  return type.length == 5 && thrum_text_equals(type, "C3D8I") ? 3 : 0;
}

/* Adds an element whose nodes are the last `count` ones of all. */
static thrum_status add_element(inp_reader *r, int64_t number, const inp_solid *solid,
                                int64_t count, int64_t line) {
  const inp_element element = {.number = number,
                               .line = line,
                               .solid = solid,
                               .first = r->node_count - count,
                               .count = count,
                               .region = -1};
  r->solid_count += solid != NULL;
  return thrum_mesh_append(&r->elements, &r->element_count, &element, sizeof element, r->error);
}

static thrum_status add_element_node(inp_reader *r, int64_t node) {
  return thrum_mesh_append(&r->nodes, &r->node_count, &node, sizeof node, r->error);
}

/* Ends a solid that began on `line`. An element with too few nodes takes those of the next one, so
 * it is named where a line of numbers is too long. */
static thrum_status end_solid(inp_reader *r, int64_t line, int64_t number, int nodes) {
  if (inp_text(r)->line > line && inp_more(r))
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "element %lld, which begins on line %lld, has more than %d nodes with "
                           "this line: it lacks some, or a line between them is broken",
                           (long long)number, (long long)line, nodes);
  return inp_finish(r, "the nodes");
}

/* Reads a solid's number and nodes, which may continue on further lines; `inner` more may follow on
 * the last one. */
static thrum_status read_solid(inp_reader *r, const inp_solid *solid, int inner, int64_t *number) {
  const int64_t line = inp_text(r)->line, place = thrum_included_line(&r->files);
  int64_t node = 0;
  THRUM_TRY(inp_integer(r, "the number of an element", 1, number));
  for (int n = 0; n < solid->nodes; n++) {
    if (!inp_more(r) && !inp_data_line(r))
      return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                             "element %lld has too few nodes: %d, not %d", (long long)*number, n,
                             solid->nodes);
    THRUM_TRY(inp_integer(r, "a node of the element", 1, &node));
    THRUM_TRY(add_element_node(r, node));
  }
  for (int n = 0; n < inner && inp_more(r); n++)
    THRUM_TRY(inp_integer(r, "a node of the element", 1, &node));
  THRUM_TRY(end_solid(r, line, *number, solid->nodes));
  return add_element(r, *number, solid, solid->nodes, place);
}

/* Reads an element that is no solid; its nodes belong to the groups of its sets. A line that is
 * full and ends in a comma goes on below. */
static thrum_status read_other(inp_reader *r, int64_t *number) {
  const int64_t place = thrum_included_line(&r->files);
  int64_t node = 0, count = 0;
  THRUM_TRY(inp_integer(r, "the number of an element", 1, number));
  for (int fields = 1; inp_more(r); fields++) {
    node = 0;
    THRUM_TRY(inp_integer_or(r, "a node of the element", 0, &node));

    // elements of networks say by 0 that they have no node at an end
    if (node > 0) {
      THRUM_TRY(add_element_node(r, node));
      count++;
    }
    if (fields + 1 == LINE_FIELDS_MAX && !inp_more(r) && inp_text(r)->end[-1] == ',' &&
        inp_data_line(r))
      fields = -1;
  }
  return add_element(r, *number, NULL, count, place);
}

thrum_status inp_read_elements(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word type = inp_parameter_of(keyword, "TYPE");
  const thrum_word name = inp_parameter_of(keyword, "ELSET");
  bool unknown;
  const inp_solid *solid = find_solid(type, &unknown);
  const int64_t before = r->element_count;
  int64_t set = -1, number = 0;
  if (type.length == 0)
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT, "*ELEMENT needs TYPE=, such as C3D4");
  if (unknown)
    return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                           "elements of type %s are not supported; the body must be meshed with "
                           "C3D4, C3D10, C3D6, C3D8, C3D15 or C3D20",
                           thrum_text_excerpt(type).text);
  if (name.length > 0)
    THRUM_TRY(inp_find_set(r, name, &set));
  while (inp_data_line(r)) {
    THRUM_TRY(solid ? read_solid(r, solid, inner_nodes(type), &number) : read_other(r, &number));
    if (set >= 0)
      THRUM_TRY(inp_add_element(r, set, number));
  }

  // modified elements lump their mass and share forces in another way
  if (begins(type, "C3D10M"))
    r->modified_tets += r->element_count - before;
  return THRUM_OK;
}

/* --- elements from others ----------------------------------------------------------------------
 */

/* The number of a node or an element that is made. */
static thrum_status shifted(inp_reader *r, int64_t number, int64_t shift, int64_t *result) {
  if (number > INT64_MAX / 4 || shift > INT64_MAX / 4 || shift < -(INT64_MAX / 4) ||
      number + shift < 1)
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                           "the number %lld, with a step of %lld, is none that can be made",
                           (long long)number, (long long)shift);
  *result = number + shift;
  return THRUM_OK;
}

/* Adds an element like another one, its number and its nodes' numbers shifted. */
static thrum_status copy_element(inp_reader *r, int64_t from, int64_t shift, int64_t node_shift,
                                 bool reflect, int64_t set) {
  const inp_element element = r->elements[from];
  int64_t number = 0, node = 0;
  THRUM_TRY(inp_check_generated(r, 1));
  THRUM_TRY(shifted(r, element.number, shift, &number));
  for (int64_t n = 0; n < element.count; n++) {
    const int64_t at =
        reflect && element.solid ? thrum_solid_mirrored(element.solid->solid, (int)n) : n;
    THRUM_TRY(shifted(r, r->nodes[element.first + at], node_shift, &node));
    THRUM_TRY(add_element_node(r, node));
  }
  THRUM_TRY(add_element(r, number, element.solid, element.count, thrum_included_line(&r->files)));
  return set >= 0 ? inp_add_element(r, set, number) : THRUM_OK;
}

/* Reads a line of *ELGEN: a master element, then the number, the step of nodes and that of elements
 * of a row, of rows, and of layers, the master counted among each. */
static thrum_status generate_line(inp_reader *r, int64_t set) {
  int64_t master = 0, index = -1, counts[3] = {1, 1, 1};
  int64_t node_steps[3] = {1, 0, 0}, steps[3] = {1, 0, 0};
  THRUM_TRY(inp_integer(r, "the number of the master element", 1, &master));
  THRUM_TRY(inp_find_element(r, master, &index));
  if (index < 0)
    return thrum_text_fail(inp_text(r), THRUM_MISSING, "element %lld is not above this line",
                           (long long)master);
  for (int d = 0; d < 3; d++) {
    THRUM_TRY(inp_integer_or(r, "a number of elements", 1, &counts[d]));
    THRUM_TRY(inp_integer_or(r, "a step of nodes", -INT32_MAX, &node_steps[d]));
    THRUM_TRY(inp_integer_or(r, "a step of elements", -INT32_MAX, &steps[d]));
    if (counts[d] > INP_GENERATED_MAX || node_steps[d] > INT32_MAX || steps[d] > INT32_MAX ||
        (counts[d] > 1 && steps[d] == 0))
      return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                             "%lld elements in steps of %lld, and %lld of nodes, cannot be made",
                             (long long)counts[d], (long long)steps[d], (long long)node_steps[d]);
  }
  THRUM_TRY(inp_finish(r, "the layers"));

  // too many are refused before they are made
  if ((double)counts[0] * (double)counts[1] * (double)counts[2] > INP_GENERATED_MAX)
    THRUM_TRY(inp_check_generated(r, INP_GENERATED_MAX + 1));
  for (int64_t layer = 0; layer < counts[2]; layer++)
    for (int64_t row = 0; row < counts[1]; row++)
      for (int64_t i = layer + row == 0; i < counts[0]; i++)
        THRUM_TRY(copy_element(r, index, i * steps[0] + row * steps[1] + layer * steps[2],
                               i * node_steps[0] + row * node_steps[1] + layer * node_steps[2],
                               false, set));
  return set >= 0 ? inp_add_element(r, set, master) : THRUM_OK;
}

thrum_status inp_generate_elements(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word name = inp_parameter_of(keyword, "ELSET");
  int64_t set = -1;
  if (name.length > 0)
    THRUM_TRY(inp_find_set(r, name, &set));
  while (inp_data_line(r))
    THRUM_TRY(generate_line(r, set));
  return THRUM_OK;
}

/* A step of numbers that *ELCOPY needs. */
static thrum_status copy_step(inp_reader *r, const inp_keyword *keyword, const char *key,
                              int64_t *step) {
  const thrum_word word = inp_parameter_of(keyword, key);
  thrum_text one = *inp_text(r);
  if (word.length == 0)
    return thrum_text_fail(&one, THRUM_BAD_FORMAT, "*ELCOPY needs %s=N", key);
  one.at = word.text;
  one.end = word.text + word.length;
  return thrum_text_integer(&one, key, -INT32_MAX, INT32_MAX, step);
}

thrum_status inp_copy_elements(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word old_name = inp_parameter_of(keyword, "OLD SET");
  const thrum_word new_name = inp_parameter_of(keyword, "NEW SET");
  int64_t step = 0, node_step = 0, set = -1, index = -1;
  THRUM_TRY(copy_step(r, keyword, "ELEMENT SHIFT", &step));
  THRUM_TRY(copy_step(r, keyword, "SHIFT NODES", &node_step));
  const int64_t old = inp_set_index(r, old_name);
  if (old == r->set_count)
    return thrum_text_fail(inp_text(r), THRUM_MISSING,
                           "*ELCOPY names the set '%s', which is no element set above it",
                           thrum_text_excerpt(old_name).text);
  if (new_name.length > 0)
    THRUM_TRY(inp_find_set(r, new_name, &set));

  // the new elements may join the set that they come from, whose count is kept
  const int64_t count = r->sets[old].count;
  for (int64_t i = 0; i < count; i++) {
    THRUM_TRY(inp_find_element(r, r->sets[old].elements[i], &index));
    if (index < 0)
      return thrum_text_fail(
          inp_text(r), THRUM_MISSING, "set '%s' names element %lld, which is not above this line",
          thrum_text_excerpt(old_name).text, (long long)r->sets[old].elements[i]);
    THRUM_TRY(copy_element(r, index, step, node_step, inp_has_parameter(keyword, "REFLECT"), set));
  }
  return THRUM_OK;
}

thrum_status inp_build_elements(inp_reader *r) {
  for (int64_t i = 0; i < r->element_count; i++) {
    const inp_element *element = &r->elements[i];
    if (!element->solid)
      continue;
    THRUM_TRY(
        thrum_builder_element(&r->builder, &(thrum_element){.kind = element->solid->solid,
                                                            .quadratic = element->solid->quadratic,
                                                            .nodes = r->nodes + element->first,
                                                            .number = element->number,
                                                            .key = element->region,
                                                            .line = element->line}));
  }
  return THRUM_OK;
}
