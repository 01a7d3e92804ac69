/* Room for bodies that touch each other, and what each of them needs for it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_pairs_room.h"

#include "scene/scene_contact.h"
#include "scene/scene_fields.h"
#include "scene/scene_memory.h"
#include "scene/scene_skin.h"

#include <stdlib.h>

#include "core/base/def.h"

/* The next power of two, so that bodies which are added one by one seldom need new room. */
static int64_t round_up(int64_t count) {
  int64_t room = 1;
  while (room < count)
    room *= 2;
  return room;
}

/* Lists of the bodies of a step, and of the members that each worker steps. */
static bool make_lists(scene_pairs *pairs, int64_t count, int64_t links, int32_t workers) {
  const bool made = scene_grow(&pairs->members, workers * count, sizeof *pairs->members) &&
                    scene_grow(&pairs->environments, count, sizeof *pairs->environments) &&
                    scene_grow(&pairs->pulls, count * THRUM_SCENE_PULLS, sizeof *pairs->pulls) &&
                    scene_grow(&pairs->bounds, count, sizeof *pairs->bounds) &&
                    scene_grow(&pairs->order, count, sizeof *pairs->order) &&
                    scene_grow(&pairs->group, count, sizeof *pairs->group) &&
                    scene_grow(&pairs->firsts, count, sizeof *pairs->firsts) &&
                    scene_grow(&pairs->groups, count, sizeof *pairs->groups) &&
                    scene_grow(&pairs->ties, workers * (links + 1), sizeof *pairs->ties);
  if (made) {
    pairs->member_room = count;
    pairs->tie_room = links;
  }
  return made;
}

thrum_contact_pairs *scene_pairs_block(const scene_pairs *pairs, int32_t worker) {
  void *first = pairs->contact;
  return (void *)((unsigned char *)first + (size_t)worker * pairs->size);
}

/* Makes a block of this def for each of the workers, in place of those that there are; the first
 * goes on from their touches and energies. */
static thrum_status make_blocks(scene_pairs *pairs, const thrum_contact_pairs_def *def,
                                int32_t workers, thrum_error *error) {
  scene_pairs made = *pairs;
  made.def = *def;
  THRUM_TRY(thrum_contact_pairs_size(def, &made.size, error));
  made.size = scene_round_up(made.size);
  made.contact = scene_aligned((size_t)workers * made.size);
  if (made.contact == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "no memory for contact between bodies of %d times %zu bytes",
                           (int)workers, made.size);

  // all of them are of one def
  thrum_status status = THRUM_OK;
  for (int32_t n = 0; n < workers && status >= 0; n++) {
    thrum_contact_pairs *block = NULL;
    status = thrum_contact_pairs_init(scene_pairs_block(&made, n), made.size, def, &block, error);
  }
  if (status < 0) {
    free(made.contact);
    return status;
  }
  thrum_contact_pairs_continue(made.contact, pairs->contact);
  free(pairs->contact);
  *pairs = made;
  return THRUM_OK;
}

thrum_status scene_pairs_share(thrum_scene *scene, int32_t workers, thrum_error *error) {
  scene_pairs *pairs = &scene->pairs;
  if (pairs->contact == NULL)
    return THRUM_OK;
  if (!make_lists(pairs, pairs->member_room, pairs->tie_room, workers))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for bodies that touch");
  return make_blocks(pairs, &pairs->def, workers, error);
}

thrum_status scene_pairs_room(thrum_scene *scene, const scene_body *extra,
                              const scene_skin *extra_skin, thrum_error *error) {
  scene_pairs *pairs = &scene->pairs;
  int64_t count = 0, vertices = 0, nodes = 0, rank = 1;
  if (!scene->collides && scene->skins == NULL && scene->solid_count == 0 && scene->link_count == 0)
    return THRUM_OK;

  // what all solids and bodies need together, with the body that comes or changes
  for (int32_t n = 0; n < scene->solid_count; n++) {
    vertices += thrum_skin_vertex_count(scene->solids[n].skin);
    nodes += thrum_skin_node_count(scene->solids[n].skin);
  }
  for (int32_t n = 0; n <= scene->body_count; n++) {
    const bool last = n == scene->body_count;
    const scene_body *body = last ? extra : scene->bodies[n];
    const scene_skin *skin = last ? extra_skin : body == extra ? NULL : body->skin;
    if (skin == NULL && (last || body->tied == 0))
      continue;

    // a body that is linked has a place also where it touches nothing
    const int64_t own = skin ? skin->of->rank : body->derived->rank;
    count++;
    vertices += skin ? thrum_skin_vertex_count(skin->skin) : 0;
    nodes += skin ? thrum_skin_node_count(skin->skin) : 0;
    rank = own > rank ? own : rank;
  }
  const int64_t ends = scene->solid_count + scene->link_count;
  if (!make_lists(pairs, scene->body_count + 1 + ends, scene->link_count, scene->workers))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for bodies that touch");
  if (count < 1)
    return THRUM_OK;
  count += ends;
  if ((pairs->contact != NULL && count <= pairs->def.member_max &&
       vertices <= pairs->def.vertex_max && nodes <= pairs->def.node_max &&
       rank <= pairs->def.rank_max && scene->link_count <= pairs->def.link_max))
    return THRUM_OK;

  // larger room goes on from the touches and energies that there are
  thrum_contact_pairs_def def = pairs->def;
  def.member_max = round_up(count);
  def.vertex_max = round_up(vertices);
  def.node_max = round_up(nodes);
  def.link_max = scene->link_count > 0 ? round_up(scene->link_count) : 0;
  def.rank_max = rank;
  return make_blocks(pairs, &def, scene->workers, error);
}

/* The contact of a body that could touch nothing before, and its skin. */
static thrum_status equip(thrum_scene *scene, scene_body *body, thrum_error *error) {
  if (body->skin == NULL)
    THRUM_TRY(scene_skin_take(scene, body, body->derived, &body->skin, error));
  if (body->touch == NULL)
    THRUM_TRY(scene_touch_make(scene, body, body->derived, body->state, &body->touch, error));
  return THRUM_OK;
}

/* Takes what contact between bodies has made and nothing needs any more. */
static void trim(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    if (scene_collides(scene, body, body->derived))
      continue;
    scene_skin_drop(scene, body->skin);
    body->skin = NULL;
    scene_touch_trim(scene, body);
  }
}

/* Contacts, skins and room for all that touches or is linked. */
static thrum_status equip_all(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;
  scene->pairs.def = scene->collides || scene->pairs.contact != NULL
                         ? scene->pairs.def
                         : thrum_default_contact_pairs_def();
  for (int32_t n = 0; n < scene->body_count && status >= 0; n++)
    if (scene->bodies[n]->tied > 0 ||
        scene_collides(scene, scene->bodies[n], scene->bodies[n]->derived))
      status = equip(scene, scene->bodies[n], error);
  THRUM_THEN(status, scene_pairs_room(scene, NULL, NULL, error));
  return status;
}

thrum_status scene_pairs_equip(thrum_scene *scene, thrum_error *error) {
  const thrum_status status = equip_all(scene, error);
  trim(scene);
  return status;
}

thrum_status thrum_scene_set_collisions(thrum_scene *scene, const thrum_contact_pairs_def *def,
                                        thrum_error *error) {
  thrum_contact_pairs_def checked = thrum_default_contact_pairs_def();
  size_t size = 0;
  const thrum_contact_pairs_def *given = thrum_def_whole(def, &checked, sizeof checked);
  if (def != NULL) {
    THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_PAIRS, given, error));
    checked = *given;
  }

  // the scene says how much room there has to be
  checked.member_max = checked.vertex_max = checked.node_max = checked.rank_max = 1;
  checked.link_max = 0;
  THRUM_TRY(thrum_contact_pairs_size(&checked, &size, error));

  // the touches that there are come back where there is no memory for new ones
  scene_pairs *pairs = &scene->pairs;
  const thrum_contact_pairs_def def_before = pairs->def;
  thrum_contact_pairs *const contact_before = pairs->contact;
  const size_t size_before = pairs->size;
  const bool collided = scene->collides;
  scene->collides = def != NULL;
  pairs->contact = NULL;
  pairs->def = checked;
  const thrum_status status = equip_all(scene, error);
  free(status < 0 ? pairs->contact : contact_before);
  if (status < 0) {
    scene->collides = collided;
    pairs->contact = contact_before;
    pairs->def = def_before;
    pairs->size = size_before;
  } else
    scene->revision++;
  trim(scene);
  return status;
}

void scene_pairs_free(thrum_scene *scene) {
  scene_pairs *pairs = &scene->pairs;
  free(pairs->contact);
  free(pairs->members);
  free(pairs->environments);
  free(pairs->pulls);
  free(pairs->ties);
  free(pairs->bounds);
  free(pairs->order);
  free(pairs->group);
  free(pairs->firsts);
  free(pairs->groups);
}
