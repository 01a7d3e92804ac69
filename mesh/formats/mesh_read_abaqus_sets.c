/* Sets of Abaqus decks, and the regions that sections or sets make.
 *
 * Without any *SOLID SECTION the element sets are the regions where they say which one an element
 * is of: the sets of *ELSET if each solid is in just one of them, else those among the parameters
 * of *ELEMENT, else those of *ELSET with a region more of what is in none. Sets of all solids tell
 * nothing apart.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read_abaqus.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

/* Are the sets of the present keyword those of the assembly, and not of a part? */
static bool of_assembly(const inp_reader *r) {
  return r->in_assembly && !r->in_instance;
}

/* The list of a name in the file, of the assembly or of the part; -1: there is none. */
static int64_t find_list(const inp_reader *r, thrum_word name, bool assembly) {
  for (int64_t step = 0; step < r->list_count; step++) {
    // what belongs to a set stands together
    const int64_t i = (r->builder.last_list + step) % r->list_count;
    if (r->lists[i].of_assembly == assembly && inp_same(r->lists[i].base, name))
      return i;
  }
  return -1;
}

static int64_t find_elements(const inp_reader *r, thrum_word name, bool assembly) {
  int64_t s = 0;
  while (s < r->set_count &&
         !(r->sets[s].of_assembly == assembly && inp_same(r->sets[s].base, name)))
    s++;
  return s;
}

int64_t inp_list_index(const inp_reader *r, thrum_word name) {
  const int64_t list = find_list(r, name, of_assembly(r));
  return list >= 0 ? list : find_list(r, name, !of_assembly(r));
}

int64_t inp_set_index(const inp_reader *r, thrum_word name) {
  const int64_t set = find_elements(r, name, of_assembly(r));
  return set < r->set_count ? set : find_elements(r, name, !of_assembly(r));
}

/* The name of the group of a set: where the part has one of that name and the assembly another one,
 * that of the assembly says so. */
static thrum_status group_name(inp_reader *r, thrum_word base, bool assembly, thrum_word *name) {
  static const char prefix[] = "Assembly.";
  const size_t front = sizeof prefix - 1;
  THRUM_TRY(thrum_mesh_name_check(inp_text(r), base));
  *name = base;
  if (!assembly || (find_list(r, base, false) < 0 && find_elements(r, base, false) == r->set_count))
    return THRUM_OK;
  char *text = thrum_scope_allocate(&r->files.paths, (int64_t)(front + base.length + 1), 1);
  THRUM_TRY(r->files.paths.status);
  memcpy(text, prefix, front);
  memcpy(text + front, base.text, base.length);
  *name = (thrum_word){text, front + base.length};
  return thrum_mesh_name_check(inp_text(r), *name);
}

/* Finds the list of a set of the assembly or the part; a new one is added. */
static thrum_status need_list(inp_reader *r, thrum_word base, bool assembly, int64_t *list) {
  const inp_list fresh = {base, assembly};
  thrum_word name;
  *list = find_list(r, base, assembly);
  if (*list >= 0)
    return THRUM_OK;
  THRUM_TRY(group_name(r, base, assembly, &name));
  THRUM_TRY(thrum_builder_list(&r->builder, name.text, name.length, list));

  // a list of just that name may be there, as that of the other kind of a set called Assembly.NAME
  return *list < r->list_count
             ? THRUM_OK
             : thrum_mesh_append(&r->lists, &r->list_count, &fresh, sizeof fresh, r->error);
}

thrum_status inp_node_list(inp_reader *r, thrum_word name, int64_t *list) {
  return need_list(r, name, of_assembly(r), list);
}

thrum_status inp_find_element(inp_reader *r, int64_t number, int64_t *index) {
  // the map follows the elements only where one of them is asked for
  for (; r->elements_mapped < r->element_count; r->elements_mapped++) {
    const inp_element *element = &r->elements[r->elements_mapped];
    char line[32] = "";
    if (thrum_number_map_find(&r->element_map, element->number) < 0) {
      THRUM_TRY(
          thrum_number_map_add(&r->element_map, element->number, r->elements_mapped, r->error));
      continue;
    }
    if (element->line > 0)
      snprintf(line, sizeof line, ":%lld", (long long)element->line);
    return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.200s%s: element %lld comes twice",
                           r->files.files[0].path, line, (long long)element->number);
  }
  *index = thrum_number_map_find(&r->element_map, number);
  return THRUM_OK;
}

thrum_status inp_find_set(inp_reader *r, thrum_word name, int64_t *index) {
  inp_set fresh = {.base = name, .of_assembly = of_assembly(r)};
  *index = find_elements(r, name, fresh.of_assembly);
  if (*index < r->set_count)
    return THRUM_OK;

  // a set becomes a group, so it needs a name that a group can have
  THRUM_TRY(group_name(r, name, fresh.of_assembly, &fresh.name));
  return thrum_mesh_append_few(inp_text(r), "element sets", &r->sets, &r->set_count, &fresh,
                               sizeof fresh);
}

/* Counts a member of a set; refuses more in all sets than sensible ones have, since sets that name
 * sets can double with every line. */
static thrum_status count_member(inp_reader *r) {
  const int64_t most = 16 * (r->builder.vertex_count + r->element_count) + 64 * r->files.size;
  return r->member_count++ < most ? THRUM_OK
                                  : thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                                                    "the sets name far more than the file holds");
}

thrum_status inp_add_node(inp_reader *r, int64_t list, int64_t node) {
  THRUM_TRY(count_member(r));
  return thrum_builder_add(&r->builder, list, node);
}

thrum_status inp_add_element(inp_reader *r, int64_t set, int64_t element) {
  inp_set *s = &r->sets[set];
  THRUM_TRY(count_member(r));
  return thrum_mesh_append(&s->elements, &s->count, &element, sizeof element, r->error);
}

static int compare_numbers(const void *a, const void *b) {
  const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

thrum_status inp_set_nodes(inp_reader *r, thrum_word name, int64_t **nodes, int64_t *count) {
  const int64_t list = inp_list_index(r, name);
  if (list < 0)
    return thrum_text_fail(inp_text(r), THRUM_MISSING,
                           "'%s' is no node set above this line, of which others are to be made",
                           thrum_text_excerpt(name).text);
  const thrum_named_list *l = &r->builder.lists[list];
  *count = l->count;
  THRUM_TRY(thrum_reserve(nodes, l->count + 1, sizeof **nodes, "the mesh", r->error));
  if (l->count > 0)
    memcpy(*nodes, l->numbers, (size_t)l->count * sizeof **nodes);

  // sets are in the order of numbers, each once, unless they say otherwise
  for (int64_t i = 0; i < r->unsorted_count; i++)
    if (r->unsorted[i] == list)
      return THRUM_OK;
  qsort(*nodes, (size_t)l->count, sizeof **nodes, compare_numbers);
  *count = 0;
  for (int64_t i = 0; i < l->count; i++)
    if (i == 0 || (*nodes)[i] != (*nodes)[*count - 1])
      (*nodes)[(*count)++] = (*nodes)[i];
  return THRUM_OK;
}

/* --- *NSET and *ELSET --------------------------------------------------------------------------
 */

/* Adds a member to a set. Members are numbers, first-last-step with GENERATE, or names of sets that
 * were read before. */
typedef thrum_status add_member(inp_reader *r, int64_t set, int64_t member);

static thrum_status read_range(inp_reader *r, int64_t set, add_member *add) {
  int64_t first = 0, last = 0, step = 1;
  THRUM_TRY(inp_integer(r, "the first of a range", 1, &first));
  last = first;
  THRUM_TRY(inp_integer_or(r, "the last of a range", first, &last));
  THRUM_TRY(inp_integer_or(r, "the step of a range", 1, &step));
  if ((last - first) / step >= r->builder.vertex_count + r->element_count + r->files.size)
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "a range is longer than there are nodes and elements");

  // the range must not step past the largest integer
  for (int64_t n = first; n <= last; n += step) {
    THRUM_TRY(add(r, set, n));
    if (n > last - step)
      break;
  }
  return inp_finish(r, "the range");
}

static thrum_status add_named(inp_reader *r, int64_t set, thrum_word name, bool of_part,
                              add_member *add) {
  // a node set takes over the nodes of another node set
  const int64_t list = add != inp_add_node ? -1
                       : of_part           ? find_list(r, name, false)
                                           : inp_list_index(r, name);
  if (list >= 0 && list != set) {
    for (int64_t n = 0; n < r->builder.lists[list].count; n++)
      THRUM_TRY(add(r, set, r->builder.lists[list].numbers[n]));
    return THRUM_OK;
  }

  // an element set takes over the elements of another element set
  const int64_t other = add == inp_add_node ? r->set_count
                        : of_part           ? find_elements(r, name, false)
                                            : inp_set_index(r, name);
  for (int64_t n = 0; other < r->set_count && other != set && n < r->sets[other].count; n++)
    THRUM_TRY(add(r, set, r->sets[other].elements[n]));
  if (other < r->set_count && other != set)
    return THRUM_OK;

  return thrum_text_fail(inp_text(r), THRUM_MISSING, "the set names '%s', which is no set above it",
                         thrum_text_excerpt(name).text);
}

/* Takes "INSTANCE." off the front of a member; true where it was there. */
static bool take_instance(inp_reader *r) {
  const thrum_word name = r->instance.name;
  thrum_text *text = inp_text(r);
  const size_t left = (size_t)(text->end - text->at);
  if (name.length == 0 || left <= name.length || text->at[name.length] != '.' ||
      !inp_same((thrum_word){text->at, name.length}, name))
    return false;
  text->at += name.length + 1;
  return true;
}

/* Reads a member of a set, a number or the name of a set that came before. In sets of the assembly
 * only nodes and elements of the instance are part of the body. */
static thrum_status read_member(inp_reader *r, int64_t set, add_member *add) {
  const bool of_part = take_instance(r), ours = of_part || !r->beside_body;
  const thrum_text *text = inp_text(r);
  int64_t member = 0;
  if (text->at < text->end && *text->at >= '0' && *text->at <= '9') {
    THRUM_TRY(inp_integer(r, "a member of the set", 1, &member));
    return ours ? add(r, set, member) : THRUM_OK;
  }
  const thrum_word word = inp_word(r);
  return word.length > 0 ? add_named(r, set, word, of_part, add) : THRUM_OK;
}

static thrum_status read_members(inp_reader *r, const inp_keyword *keyword, int64_t set,
                                 add_member *add) {
  const bool ranges = inp_has_parameter(keyword, "GENERATE");
  while (inp_data_line(r)) {
    if (ranges && !r->beside_body)
      THRUM_TRY(read_range(r, set, add));
    while (!ranges && inp_more(r))
      THRUM_TRY(read_member(r, set, add));
  }
  return THRUM_OK;
}

static thrum_status refuse_nameless(inp_reader *r, const char *key) {
  return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT, "the set has no name: %s=NAME", key);
}

/* Adds the nodes of the elements of a set to a node set. */
static thrum_status add_nodes_of(inp_reader *r, int64_t list, thrum_word name) {
  const int64_t set = inp_set_index(r, name);
  int64_t index = -1;
  if (set == r->set_count)
    return thrum_text_fail(inp_text(r), THRUM_MISSING,
                           "the set names '%s', which is no element set above it",
                           thrum_text_excerpt(name).text);
  for (int64_t i = 0; i < r->sets[set].count; i++) {
    THRUM_TRY(inp_find_element(r, r->sets[set].elements[i], &index));
    if (index < 0)
      return thrum_text_fail(inp_text(r), THRUM_MISSING,
                             "set '%s' names element %lld, which is not above this line",
                             thrum_text_excerpt(name).text, (long long)r->sets[set].elements[i]);
    const inp_element *element = &r->elements[index];
    for (int64_t n = 0; n < element->count; n++)
      THRUM_TRY(inp_add_node(r, list, r->nodes[element->first + n]));
  }
  return THRUM_OK;
}

thrum_status inp_read_node_set(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word name = inp_parameter_of(keyword, "NSET");
  const thrum_word elements = inp_parameter_of(keyword, "ELSET");
  int64_t list = 0;
  if (name.length == 0)
    return refuse_nameless(r, "NSET");
  THRUM_TRY(inp_node_list(r, name, &list));

  // other keywords may make nodes of the set in its own order
  if (inp_has_parameter(keyword, "UNSORTED"))
    THRUM_TRY(thrum_mesh_append(&r->unsorted, &r->unsorted_count, &list, sizeof list, r->error));
  if (elements.length > 0)
    THRUM_TRY(add_nodes_of(r, list, elements));
  return read_members(r, keyword, list, inp_add_node);
}

thrum_status inp_read_element_set(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word name = inp_parameter_of(keyword, "ELSET");
  int64_t set = 0;
  if (name.length == 0)
    return refuse_nameless(r, "ELSET");
  THRUM_TRY(inp_find_set(r, name, &set));
  r->sets[set].declared = true;
  return read_members(r, keyword, set, inp_add_element);
}

/* --- regions and groups ------------------------------------------------------------------------
 */

/* Finds the element that a member of a set names. */
static thrum_status find_member(inp_reader *r, const inp_set *set, int64_t member,
                                inp_element **element) {
  int64_t index = -1;
  THRUM_TRY(inp_find_element(r, set->elements[member], &index));
  if (index < 0)
    return thrum_error_set(r->error, THRUM_BAD_VALUE,
                           "%.150s: set '%s' names element %lld, which is not in the file",
                           r->files.files[0].path, thrum_text_excerpt(set->name).text,
                           (long long)set->elements[member]);
  *element = &r->elements[index];
  return THRUM_OK;
}

/* Gives the solids of a section its index; a later section overrides. */
static thrum_status apply_section(inp_reader *r, int64_t index) {
  const inp_section *section = &r->sections[index];
  inp_element *element = NULL;

  // the set may stand below the section; without it elements would be left without material
  const int64_t own = find_elements(r, section->set, false);
  const int64_t s = own < r->set_count ? own : find_elements(r, section->set, true);
  if (s == r->set_count)
    return thrum_error_set(r->error, THRUM_MISSING, "%.150s:%lld: there is no element set '%s'",
                           r->files.files[0].path, (long long)section->line,
                           thrum_text_excerpt(section->set).text);
  for (int64_t i = 0; i < r->sets[s].count; i++) {
    THRUM_TRY(find_member(r, &r->sets[s], i, &element));
    element->region = index;
  }
  return THRUM_OK;
}

/* What sets say of the solids: how many sets have some and not all, how many solids are in one, and
 * whether one is in several. */
typedef struct inp_cover {
  int64_t sets, solids;
  bool overlaps;
} inp_cover;

/* How many different solids a set has. */
static thrum_status count_solids(inp_reader *r, const inp_set *set, int64_t *solids) {
  inp_element *element = NULL;
  *solids = 0;
  r->stamp++;
  for (int64_t i = 0; i < set->count; i++) {
    THRUM_TRY(find_member(r, set, i, &element));
    *solids += element->solid && element->seen != r->stamp;
    element->seen = r->stamp;
  }
  return THRUM_OK;
}

static void clear_regions(inp_reader *r) {
  for (int64_t i = 0; i < r->element_count; i++)
    r->elements[i].region = -1;
}

/* Gives the solids of a set the set as region; *overlaps where one has another already. */
static thrum_status take_region(inp_reader *r, int64_t s, bool *overlaps) {
  inp_element *element = NULL;
  for (int64_t i = 0; i < r->sets[s].count; i++) {
    THRUM_TRY(find_member(r, &r->sets[s], i, &element));
    *overlaps = *overlaps || (element->region >= 0 && element->region != s);
    element->region = element->solid ? s : -1;
  }
  return THRUM_OK;
}

/* Gives the solids of the sets of one kind, declared or not, the sets as regions; sets of all or of
 * no solids are passed over. */
static thrum_status cover(inp_reader *r, bool declared, inp_cover *found) {
  *found = (inp_cover){0};
  clear_regions(r);
  for (int64_t s = 0; s < r->set_count && !found->overlaps; s++) {
    int64_t solids = 0;
    if (r->sets[s].declared != declared)
      continue;
    THRUM_TRY(count_solids(r, &r->sets[s], &solids));
    if (solids == 0 || solids == r->solid_count)
      continue;
    THRUM_TRY(take_region(r, s, &found->overlaps));
    found->sets++;
    found->solids += solids;
  }
  return THRUM_OK;
}

/* Gives all solids the first set that has them all, so that the one region has a name. */
static thrum_status name_whole(inp_reader *r) {
  bool overlaps = false;
  clear_regions(r);
  for (int declared = 1; declared >= 0; declared--)
    for (int64_t s = 0; s < r->set_count; s++) {
      int64_t solids = 0;
      if (r->sets[s].declared != (declared == 1) ||
          thrum_text_equals(r->sets[s].name, "allElements"))
        continue;
      THRUM_TRY(count_solids(r, &r->sets[s], &solids));
      if (solids == r->solid_count)
        return take_region(r, s, &overlaps);
    }
  return THRUM_OK;
}

thrum_status inp_find_regions(inp_reader *r, thrum_mesh *mesh) {
  inp_cover named = {0}, typed = {0}, last = {0};
  for (int64_t i = 0; i < r->section_count; i++)
    THRUM_TRY(apply_section(r, i));
  if (r->section_count > 0)
    return THRUM_OK;

  // sets by name come first, then those of the elements, then what is left
  r->region_sets = true;
  THRUM_TRY(cover(r, true, &named));
  if (named.sets > 0 && !named.overlaps && named.solids == r->solid_count)
    return THRUM_OK;
  THRUM_TRY(cover(r, false, &typed));
  if (typed.sets > 0 && !typed.overlaps && typed.solids == r->solid_count)
    return THRUM_OK;
  if (named.sets > 0 && !named.overlaps)
    return cover(r, true, &last);

  // where sets lie across each other nobody knows which one a material is meant for
  if (named.sets > 1 || typed.sets > 1)
    thrum_mesh_add_note(mesh, "element sets overlap, so they are groups and no regions: give "
                              "each part a *SOLID SECTION");
  return name_whole(r);
}

/* Adds the nodes of the elements of a set to a list. */
static thrum_status add_elements(inp_reader *r, const inp_set *set, int64_t list) {
  inp_element *element = NULL;
  for (int64_t i = 0; i < set->count; i++) {
    THRUM_TRY(find_member(r, set, i, &element));
    for (int64_t n = 0; n < element->count; n++)
      THRUM_TRY(thrum_builder_add(&r->builder, list, r->nodes[element->first + n]));
  }
  return THRUM_OK;
}

/* How many different nodes a list has; it is sorted. */
static int64_t count_different(thrum_named_list *list) {
  int64_t count = 0;
  if (list->count > 0)
    qsort(list->numbers, (size_t)list->count, sizeof *list->numbers, compare_numbers);
  for (int64_t i = 0; i < list->count; i++)
    count += i == 0 || list->numbers[i] != list->numbers[i - 1];
  return count;
}

thrum_status inp_set_groups(inp_reader *r, thrum_mesh *mesh) {
  for (int64_t s = 0; s < r->set_count; s++) {
    const inp_set *set = &r->sets[s];
    int64_t list = find_list(r, set->base, set->of_assembly), before = -1;

    // the set that is everything is no group, as in .veg
    if (thrum_text_equals(set->name, "allElements"))
      continue;
    if (list >= 0)
      before = count_different(&r->builder.lists[list]);
    THRUM_TRY(need_list(r, set->base, set->of_assembly, &list));
    THRUM_TRY(add_elements(r, set, list));

    // a node set of the same name may have been meant alone
    if (before > 0 && count_different(&r->builder.lists[list]) > before)
      thrum_mesh_add_note(mesh,
                          "'%s' is a node set and an element set with more nodes: the group has "
                          "those of both",
                          thrum_text_excerpt(set->name).text);
  }
  return THRUM_OK;
}
