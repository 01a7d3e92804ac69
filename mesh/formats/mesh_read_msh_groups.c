/* Reads $PhysicalNames and $Entities of a Gmsh file, which define its physical groups; see
 * mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read_msh.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

/* Finds the index of a physical group, which is added when it is new. */
thrum_status thrum_msh_find_physical(msh_reader *r, int dimension, int64_t tag, int64_t *index) {
  for (int64_t step = 0; step < r->physical_count; step++) {
    // the last one found is tried first, since elements of a group stand together
    int64_t i = (r->last_physical + step) % r->physical_count;
    if (r->physicals[i].tag == tag && r->physicals[i].dimension == dimension) {
      *index = r->last_physical = i;
      return THRUM_OK;
    }
  }

  // the array has a fixed size, so that groups found earlier stay where they are
  if (r->physical_count == THRUM_MESH_GROUPS_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error, "more than %d physical groups",
                           THRUM_MESH_GROUPS_MAX);
  *index = r->last_physical = r->physical_count++;
  r->physicals[*index] = (msh_physical){.dimension = dimension, .tag = tag};
  return THRUM_OK;
}

thrum_status thrum_msh_add_to_physical(msh_reader *r, int64_t index, const int32_t *vertices,
                                       int count) {
  msh_physical *p = &r->physicals[index];
  int32_t *grown = thrum_mesh_grow(p->vertices, &p->capacity, p->count + count, sizeof *grown);
  if (!grown)
    return thrum_msh_no_memory(r);
  p->vertices = grown;
  for (int i = 0; i < count; i++)
    grown[p->count++] = vertices[i];
  return THRUM_OK;
}

/* Reads `dimension tag "name"`. */
static thrum_status read_physical_name(msh_reader *r) {
  int64_t dimension = 0, tag = 0, index = 0;
  THRUM_TRY(thrum_msh_line(r, "the last physical name"));
  THRUM_TRY(thrum_text_integer(&r->text, "the dimension", 0, 3, &dimension, r->error));
  THRUM_TRY(thrum_msh_integer(r, "the tag of the physical group", 1, &tag));
  THRUM_TRY(thrum_msh_find_physical(r, (int)dimension, tag, &index));

  // the name may hold blanks, so it is the rest of the line, usually in quotes
  thrum_text_more(&r->text);
  const char *start = r->text.at, *end = r->text.end;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }

  // the name becomes the name of a vertex group
  size_t length = (size_t)(end - start);
  const char *fault = thrum_mesh_name_fault(start, length);
  if (fault)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "%s", fault);

  // two names for one group would make its name depend on their order
  if (r->physicals[index].name)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "physical group %lld of dimension %d is named twice", (long long)tag,
                           (int)dimension);

  char *name = malloc(length + 1);
  if (!name)
    return thrum_msh_no_memory(r);
  memcpy(name, start, length);
  name[length] = '\0';
  r->physicals[index].name = name;
  return THRUM_OK;
}

thrum_status thrum_msh_physical_names(msh_reader *r) {
  int64_t count = 0;
  THRUM_TRY(thrum_msh_line(r, "the number of physical names"));
  THRUM_TRY(thrum_msh_integer(r, "the number of physical names", 0, &count));
  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(read_physical_name(r));
  return THRUM_OK;
}

thrum_status thrum_msh_add_entity_physical(msh_reader *r, int dimension, int64_t tag) {
  int64_t index = 0;

  // a negative tag only reverses the orientation
  THRUM_TRY(thrum_msh_find_physical(r, dimension, tag < 0 ? -tag : tag, &index));

  int32_t *grown = thrum_mesh_grow(r->entity_physicals, &r->entity_physical_capacity,
                                   r->entity_physical_count + 1, sizeof *grown);
  if (!grown)
    return thrum_msh_no_memory(r);
  r->entity_physicals = grown;
  grown[r->entity_physical_count++] = (int32_t)index;
  return THRUM_OK;
}

thrum_status thrum_msh_add_entity(msh_reader *r, const msh_entity *entity) {
  msh_entity *grown =
      thrum_mesh_grow(r->entities, &r->entity_capacity, r->entity_count + 1, sizeof *grown);
  if (!grown)
    return thrum_msh_no_memory(r);
  r->entities = grown;
  grown[r->entity_count++] = *entity;
  return THRUM_OK;
}

/* Reads `tag box physicals...`, where the box is three numbers for points and six for others. */
static thrum_status read_entity(msh_reader *r, int dimension) {
  msh_entity entity = {.dimension = dimension, .first = r->entity_physical_count};
  double box = 0;
  THRUM_TRY(thrum_msh_line(r, "the last entity"));
  THRUM_TRY(thrum_msh_integer(r, "the tag of the entity", INT64_MIN, &entity.tag));

  // the box serves only the display
  for (int i = 0; i < (dimension == 0 ? 3 : 6); i++)
    THRUM_TRY(thrum_text_number(&r->text, "the entity's box", &box, r->error));
  THRUM_TRY(thrum_msh_integer(r, "the number of physical groups", 0, &entity.count));

  // an element inherits the physical groups of its entity
  for (int64_t i = 0; i < entity.count; i++) {
    int64_t tag = 0;
    THRUM_TRY(
        thrum_text_integer(&r->text, "a physical group", -INT64_MAX, INT64_MAX, &tag, r->error));
    THRUM_TRY(thrum_msh_add_entity_physical(r, dimension, tag));
  }
  return thrum_msh_add_entity(r, &entity);
}

static int compare_entities(const void *a, const void *b) {
  const msh_entity *x = a, *y = b;
  if (x->dimension != y->dimension)
    return x->dimension < y->dimension ? -1 : 1;
  return (x->tag > y->tag) - (x->tag < y->tag);
}

void thrum_msh_sort_entities(msh_reader *r) {
  if (r->entity_count > 0)
    qsort(r->entities, (size_t)r->entity_count, sizeof *r->entities, compare_entities);
}

const int32_t *thrum_msh_entity_physicals(const msh_reader *r, int dimension, int64_t tag,
                                          int64_t *count) {
  const msh_entity key = {.dimension = dimension, .tag = tag};
  const msh_entity *entity = NULL;
  if (r->entity_count > 0)
    entity = bsearch(&key, r->entities, (size_t)r->entity_count, sizeof key, compare_entities);
  *count = entity ? entity->count : 0;
  return *count > 0 ? r->entity_physicals + entity->first : NULL;
}

thrum_status thrum_msh_text_entities(msh_reader *r) {
  int64_t counts[4] = {0, 0, 0, 0};
  THRUM_TRY(thrum_msh_line(r, "the numbers of entities"));
  for (int d = 0; d < 4; d++)
    THRUM_TRY(thrum_msh_integer(r, "the number of entities", 0, &counts[d]));

  // points first, then curves, surfaces and volumes
  for (int d = 0; d < 4; d++)
    for (int64_t i = 0; i < counts[d]; i++)
      THRUM_TRY(read_entity(r, d));
  thrum_msh_sort_entities(r);
  return THRUM_OK;
}
