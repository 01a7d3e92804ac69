/* Reads $PhysicalNames and $Entities of a Gmsh file, which define its physical groups; see
 * mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read_msh.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

thrum_status thrum_msh_find_physical(msh_reader *r, int dimension, int64_t tag, int64_t *index) {
  for (int64_t step = 0; step < r->physical_count; step++) {
    // the last one found is tried first, since elements of a group stand together
    int64_t i = (r->last_physical + step) % r->physical_count;
    if (r->physicals[i].tag == tag && r->physicals[i].dimension == dimension) {
      *index = r->last_physical = i;
      return THRUM_OK;
    }
  }

  if (r->physical_count == THRUM_MESH_GROUPS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, "more than %d physical groups",
                           THRUM_MESH_GROUPS_MAX);

  // its vertices become a group, under this name unless the file has another
  char name[64];
  msh_physical physical = {.dimension = dimension, .tag = tag};
  snprintf(name, sizeof name, "physical_%d_%lld", dimension, (long long)tag);
  THRUM_TRY(thrum_builder_list(&r->builder, name, strlen(name), &physical.list));
  *index = r->last_physical = r->physical_count;
  return thrum_mesh_append(&r->physicals, &r->physical_count, &physical, sizeof physical,
                           r->text.error);
}

/* Reads `dimension tag "name"`. */
static thrum_status read_physical_name(msh_reader *r) {
  int64_t dimension = 0, tag = 0, index = 0;
  THRUM_TRY(thrum_msh_text_line(r, "the last physical name"));
  THRUM_TRY(thrum_text_integer(&r->text, "the dimension", 0, 3, &dimension));
  THRUM_TRY(thrum_text_integer(&r->text, "the tag of the physical group", 1, INT64_MAX, &tag));
  THRUM_TRY(thrum_msh_find_physical(r, (int)dimension, tag, &index));

  // the name may hold blanks, so it is the rest of the line, usually in quotes
  thrum_text_more(&r->text);
  const char *start = r->text.at, *end = r->text.end;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }

  // the name becomes the name of a vertex group
  const thrum_word name = {start, (size_t)(end - start)};
  THRUM_TRY(thrum_mesh_name_check(&r->text, name));

  // two names for one group would make its name depend on their order
  if (r->physicals[index].named)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "physical group %lld of dimension %d is named twice", (long long)tag,
                           (int)dimension);
  r->physicals[index].named = true;
  return thrum_builder_rename(&r->builder, r->physicals[index].list, name.text, name.length);
}

thrum_status thrum_msh_physical_names(msh_reader *r) {
  int64_t count = 0;
  THRUM_TRY(thrum_msh_count(r, "the number of physical names", &count));
  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_physical_name(r));
  return THRUM_OK;
}

static thrum_status add_entity_physical(msh_reader *r, int dimension, int64_t tag) {
  int64_t index = 0;

  // a negative tag only reverses the orientation
  THRUM_TRY(thrum_msh_find_physical(r, dimension, tag < 0 ? -tag : tag, &index));
  return thrum_mesh_append(&r->entity_physicals, &r->entity_physical_count, &index, sizeof index,
                           r->text.error);
}

/* Reads `tag box physicals...`, where the box is three numbers for points and six for others. */
static thrum_status read_entity(msh_reader *r, int dimension) {
  msh_entity entity = {.dimension = dimension, .first = r->entity_physical_count};
  int64_t tag = 0, bounding = 0;
  double box = 0;
  THRUM_TRY(thrum_msh_line(r, "the last entity"));
  THRUM_TRY(thrum_msh_whole(r, "the tag of the entity", 4, INT64_MIN, INT64_MAX, &entity.tag));

  // the box serves only the display
  for (int i = 0; i < (dimension == 0 ? 3 : 6); i++)
    THRUM_TRY(thrum_msh_real(r, "the entity's box", &box));
  THRUM_TRY(thrum_msh_whole(r, "the number of physical groups", 8, 0, INT64_MAX, &entity.count));

  // an element inherits the physical groups of its entity
  for (int64_t i = 0; i < entity.count; i++) {
    THRUM_TRY(thrum_msh_whole(r, "a physical group", 4, -INT64_MAX, INT64_MAX, &tag));
    THRUM_TRY(add_entity_physical(r, dimension, tag));
  }

  // the bounding entities serve only the geometry; in text they are the rest of the line
  if (r->binary && dimension > 0)
    THRUM_TRY(thrum_msh_whole(r, "the number of bounding entities", 8, 0, INT64_MAX, &bounding));
  for (int64_t i = 0; i < bounding; i++)
    THRUM_TRY(thrum_msh_whole(r, "a bounding entity", 4, INT64_MIN, INT64_MAX, &tag));

  return thrum_mesh_append(&r->entities, &r->entity_count, &entity, sizeof entity, r->text.error);
}

static int compare_entities(const void *a, const void *b) {
  const msh_entity *x = a, *y = b;
  if (x->dimension != y->dimension)
    return x->dimension < y->dimension ? -1 : 1;
  return (x->tag > y->tag) - (x->tag < y->tag);
}

thrum_status thrum_msh_entities(msh_reader *r) {
  int64_t counts[4] = {0, 0, 0, 0};
  THRUM_TRY(thrum_msh_line(r, "the numbers of entities"));
  for (int d = 0; d < 4; d++)
    THRUM_TRY(thrum_msh_whole(r, "the number of entities", 8, 0, INT64_MAX, &counts[d]));

  // points first, then curves, surfaces and volumes
  for (int d = 0; d < 4; d++)
    for (int64_t i = 0; i < counts[d]; i++)
      THRUM_TRY(read_entity(r, d));
  if (r->entity_count > 0)
    qsort(r->entities, (size_t)r->entity_count, sizeof *r->entities, compare_entities);
  return THRUM_OK;
}

const int64_t *thrum_msh_entity_physicals(const msh_reader *r, int dimension, int64_t tag,
                                          int64_t *count) {
  const msh_entity key = {.dimension = dimension, .tag = tag};
  const msh_entity *entity = NULL;
  if (r->entity_count > 0)
    entity = bsearch(&key, r->entities, (size_t)r->entity_count, sizeof key, compare_entities);
  *count = entity ? entity->count : 0;
  return *count > 0 ? r->entity_physicals + entity->first : NULL;
}
