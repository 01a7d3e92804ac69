/* Bodies that touch each other (thrum/contact_pairs.h): their skins, which bodies are near in a
 * step, and the steps of those that are.
 *
 * Broad phase: bodies are held in the order of where their spheres begin along x, which changes
 * little from step to step, and only those whose intervals overlap are compared (sweep and prune:
 * Baraff 1992, Cohen et al. 1995, doi:10.1145/199404.199437). Bodies that are near, one by one,
 * make a group, which is stepped together; the others step as if they were alone.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_private.h"

#include <stdlib.h>
#include <string.h>

/* --- skins ------------------------------------------------------------------------------------ */

/* Keeps the triangles of a def, of which a skin is made when bodies are to touch each other. */
thrum_status scene_triangles_keep(const thrum_scene_body_def *def, scene_body *body,
                                  thrum_error *error) {
  const bool kept = def->triangle_count > 0 && def->model->material != NULL;
  body->collides = kept && def->collides != 0;
  body->self_contact = def->self_contact != 0;
  if (body->self_contact && (!kept || def->model->basis == NULL))
    return thrum_error_set(
        error, THRUM_MISSING,
        "a body that touches itself needs triangles, and a model with a mesh and "
        "a material");
  if (body->self_contact && body->derived->condensed)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a body that touches itself steps all of its coordinates: it cannot be "
                           "condensed");
  if (!kept)
    return THRUM_OK;
  const size_t count = 3 * (size_t)def->triangle_count;
  body->triangles = malloc(count * sizeof *body->triangles);
  if (body->triangles == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the triangles of a body");
  memcpy(body->triangles, def->triangles, count * sizeof *body->triangles);
  body->triangle_count = def->triangle_count;
  return THRUM_OK;
}

bool scene_collides(const thrum_scene *scene, const scene_body *body, const scene_model *derived) {
  const bool bodies = (scene->collides && body->collides) || body->self_contact;
  return (bodies || scene->solid_count > 0) && body->triangle_count > 0 && !derived->condensed;
}

/* The vertices of the triangles, ascending, as a model of their own; places (vertex_count) gets
 * where each lies, -1 where it does not. */
static void fill_surface(const scene_body *body, const scene_model *derived, int32_t *places,
                         thrum_model *surface, double *rest, double *rows) {
  const thrum_model *from = body->model;
  int64_t count = 0;
  for (int64_t v = 0; v < from->vertex_count; v++) {
    if (places[v] < 0)
      continue;
    places[v] = (int32_t)count;
    for (int axis = 0; axis < 3; axis++) {
      const double *row = from->basis + (3 * v + axis) * from->rank;
      rest[3 * count + axis] = derived->by.length * from->vertices[3 * v + axis];
      for (int64_t i = 0; i < derived->rank; i++)
        rows[(3 * count + axis) * derived->rank + i] = body->k * row[i];
    }
    count++;
  }
  *surface = *derived->model;
  surface->vertex_count = count;
  surface->vertices = rest;
  surface->basis = rows;
}

/* The stiffest material of the scaled body. */
static void stiffest(const scene_body *body, const scene_model *derived, double material[3]) {
  const thrum_model *from = body->model;
  for (int64_t n = 0; n < from->region_count; n++)
    if (derived->by.stiffness * from->material[3 * n] > material[0])
      material[0] = derived->by.stiffness * from->material[3 * n];
}

/* Lays the skin of these triangles. */
static thrum_status lay(const scene_body *body, const scene_model *derived, scene_skin *skin,
                        int32_t *places, int32_t *triangles, double *rest, double *rows,
                        thrum_error *error) {
  thrum_model surface;
  double material[3] = {0};
  size_t size = 0;
  for (int64_t n = 0; n < 3 * body->triangle_count; n++)
    places[body->triangles[n]] = 0;
  fill_surface(body, derived, places, &surface, rest, rows);
  for (int64_t n = 0; n < 3 * body->triangle_count; n++)
    triangles[n] = places[body->triangles[n]];
  stiffest(body, derived, material);
  surface.material = material;
  surface.region_count = 1;

  THRUM_TRY(thrum_skin_size(&surface, triangles, body->triangle_count, &size, error));
  skin->memory = scene_aligned(size);
  if (skin->memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a skin of %zu bytes", size);
  return thrum_skin_init(skin->memory, size, &surface, triangles, body->triangle_count, &skin->skin,
                         error);
}

static thrum_status make_skin(const scene_body *body, const scene_model *derived, scene_skin *skin,
                              thrum_error *error) {
  const size_t count = (size_t)body->model->vertex_count, r = (size_t)derived->rank;
  const size_t corners = 3 * (size_t)body->triangle_count;
  const size_t used = corners < count ? corners : count;
  int32_t *places = malloc(count * sizeof *places);
  int32_t *triangles = malloc(corners * sizeof *triangles);
  double *rest = malloc(3 * used * sizeof *rest), *rows = malloc(3 * used * r * sizeof *rows);
  skin->triangles = malloc(corners * sizeof *skin->triangles);
  thrum_status status =
      places && triangles && rest && rows && skin->triangles
          ? THRUM_OK
          : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the skin of a body");
  if (status >= 0) {
    memset(places, 0xff, count * sizeof *places);
    memcpy(skin->triangles, body->triangles, corners * sizeof *skin->triangles);
    status = lay(body, derived, skin, places, triangles, rest, rows, error);
  }
  free(places);
  free(triangles);
  free(rest);
  free(rows);
  return status;
}

void scene_skin_drop(thrum_scene *scene, scene_skin *skin) {
  if (skin == NULL || --skin->users > 0)
    return;
  for (scene_skin **at = &scene->skins; *at != NULL; at = &(*at)->next)
    if (*at == skin) {
      *at = skin->next;
      break;
    }
  free(skin->memory);
  free(skin->triangles);
  free(skin);
}

/* Hands a skin to a body, ready for what the body does with it. */
static thrum_status take(const scene_body *body, scene_skin *skin, scene_skin **taken) {
  if (body->self_contact)
    thrum_skin_prepare_own(skin->skin);
  *taken = skin;
  return THRUM_OK;
}

thrum_status scene_skin_take(thrum_scene *scene, const scene_body *body, const scene_model *derived,
                             scene_skin **taken, thrum_error *error) {
  const size_t bytes = 3 * (size_t)body->triangle_count * sizeof *body->triangles;
  *taken = NULL;
  if (!scene_collides(scene, body, derived))
    return THRUM_OK;

  // bodies of one model and surface share it
  for (scene_skin *skin = scene->skins; skin != NULL; skin = skin->next)
    if (skin->of == derived && skin->triangle_count == body->triangle_count &&
        memcmp(skin->triangles, body->triangles, bytes) == 0) {
      skin->users++;
      return take(body, skin, taken);
    }

  scene_skin *skin = calloc(1, sizeof *skin);
  if (skin == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the skin of a body");
  skin->of = derived;
  skin->triangle_count = body->triangle_count;
  skin->users = 1;
  const thrum_status status = make_skin(body, derived, skin, error);
  if (status < 0) {
    scene_skin_drop(scene, skin);
    return status;
  }
  skin->next = scene->skins;
  scene->skins = skin;
  return take(body, skin, taken);
}

/* --- room ------------------------------------------------------------------------------------- */

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

/* The block in which a worker steps groups; the first is that of the scene. */
static thrum_contact_pairs *block_of(const scene_pairs *pairs, int32_t worker) {
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
    status = thrum_contact_pairs_init(block_of(&made, n), made.size, def, &block, error);
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

thrum_status scene_pairs_equip(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;
  scene->pairs.def = scene->collides || scene->pairs.contact != NULL
                         ? scene->pairs.def
                         : thrum_default_contact_pairs_def();
  for (int32_t n = 0; n < scene->body_count && status >= 0; n++)
    if (scene->bodies[n]->tied > 0 ||
        scene_collides(scene, scene->bodies[n], scene->bodies[n]->derived))
      status = equip(scene, scene->bodies[n], error);
  THRUM_THEN(status, scene_pairs_room(scene, NULL, NULL, error));
  trim(scene);
  return status;
}

/* Forgets all touches between bodies. */
static void forget(thrum_scene *scene) {
  scene->collides = false;
  trim(scene);
  free(scene->pairs.contact);
  scene->pairs.contact = NULL;
}

thrum_status thrum_scene_set_collisions(thrum_scene *scene, const thrum_contact_pairs_def *def,
                                        thrum_error *error) {
  thrum_contact_pairs_def checked = def != NULL ? *def : thrum_default_contact_pairs_def();
  size_t size = 0;

  // the scene says how much room there has to be
  checked.member_max = checked.vertex_max = checked.node_max = checked.rank_max = 1;
  checked.link_max = 0;
  THRUM_TRY(thrum_contact_pairs_size(&checked, &size, error));
  forget(scene);
  scene->collides = def != NULL;
  scene->pairs.def = checked;
  const thrum_status status = scene_pairs_equip(scene, error);
  if (status < 0)
    forget(scene);
  scene->revision++;
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

/* --- who is near whom ------------------------------------------------------------------------- */

/* Body `number` as a member of a step. */
static void fill_member(const thrum_scene *scene, int32_t number, thrum_contact_member *member) {
  const scene_pairs *pairs = &scene->pairs;
  scene_body *body = scene->bodies[number];
  scene_environment(scene, body, pairs->pulls + (int64_t)number * THRUM_SCENE_PULLS,
                    pairs->environments + number);
  *member = (thrum_contact_member){.model = &body->touch->model,
                                   .state = body->state,
                                   .contact = body->touch->contact,
                                   .environment = pairs->environments + number,
                                   .skin = body->skin ? body->skin->skin : NULL,
                                   .number = number,
                                   .touches_itself = body->self_contact,
                                   .passes_bodies = !scene->collides || !body->collides};
}

/* Where the interval of a body along x begins and ends; larger than what it may touch. */
static double end_of(const thrum_skin_bound *bound, double side) {
  return bound->middle[0] + side * (1.02 * bound->radius + 4.0 * bound->motion);
}

/* The first body of the group that a body is in. */
static int32_t root(int32_t *group, int32_t n) {
  while (group[n] != n) {
    group[n] = group[group[n]];
    n = group[n];
  }
  return n;
}

/* Makes one group of those of two bodies, whose first body is the first of both. */
static void unite(int32_t *group, int32_t a, int32_t b) {
  const int32_t first = root(group, a), second = root(group, b);
  group[first > second ? first : second] = first > second ? second : first;
}

/* Puts pairs->order into the order of where the bodies begin, which few have left since the step
 * before. */
static void sort(const scene_pairs *pairs) {
  for (int32_t n = 1; n < pairs->ordered; n++) {
    const int32_t kept = pairs->order[n];
    const double begin = end_of(pairs->bounds + kept, -1.0);
    int32_t at = n;
    for (; at > 0 && end_of(pairs->bounds + pairs->order[at - 1], -1.0) > begin; at--)
      pairs->order[at] = pairs->order[at - 1];
    pairs->order[at] = kept;
  }
}

/* Joins bodies that may touch. */
static void join(const thrum_scene *scene) {
  const scene_pairs *pairs = &scene->pairs;
  for (int32_t n = 0; n < pairs->ordered && scene->collides; n++) {
    const int32_t a = pairs->order[n];
    if (pairs->group[a] < 0 || !scene->bodies[a]->collides || scene->bodies[a]->skin == NULL)
      continue;

    // the order is that of the lower ends, so no body after one that begins beyond the upper end is
    // near
    const double end = end_of(pairs->bounds + a, 1.0);
    for (int32_t m = n + 1; m < pairs->ordered; m++) {
      const int32_t b = pairs->order[m];
      if (end_of(pairs->bounds + b, -1.0) > end)
        break;
      if (pairs->group[b] < 0 || !scene->bodies[b]->collides || scene->bodies[b]->skin == NULL ||
          !thrum_contact_pairs_near(pairs->bounds + a, pairs->bounds + b))
        continue;
      unite(pairs->group, a, b);
    }
  }

  // links join also what is far apart
  for (int32_t n = 0; n < scene->link_count; n++)
    if (scene->links[n].holds && scene->links[n].other >= 0)
      unite(pairs->group, scene->links[n].body, scene->links[n].other);
}

/* Does a link of this step hold the body? */
static bool is_linked(const thrum_scene *scene, int32_t number) {
  bool any = false;
  for (int32_t n = 0; n < scene->link_count && scene->bodies[number]->tied > 0 && !any; n++)
    any = scene->links[n].holds &&
          (scene->links[n].body == number || scene->links[n].other == number);
  return any;
}

/* May body `number` touch a solid in the step to come? */
static bool is_near_solid(const thrum_scene *scene, int32_t number) {
  if (scene->bodies[number]->skin == NULL)
    return false;
  for (int32_t n = 0; n < scene->solid_count; n++)
    if (thrum_contact_pairs_near(scene->pairs.bounds + number, &scene->solids[n].bound))
      return true;
  return false;
}

void scene_pairs_find(thrum_scene *scene) {
  scene_pairs *pairs = &scene->pairs;
  pairs->group_count = 0;
  for (int32_t n = 0; n < scene->body_count; n++)
    scene->bodies[n]->group = -1;
  if (pairs->contact == NULL)
    return;
  for (int32_t n = 0; n < scene->workers; n++)
    thrum_contact_pairs_begin(block_of(pairs, n));
  scene_solids_move(scene);
  scene_links_begin(scene);

  // bodies that have come since the last step
  for (; pairs->ordered < scene->body_count; pairs->ordered++)
    pairs->order[pairs->ordered] = pairs->ordered;

  // those that go on and may touch others are in a group, each in its own at first
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    pairs->group[n] = body->status < 0 || (body->skin == NULL && body->tied == 0) ? -1 : n;
    pairs->bounds[n] = (thrum_skin_bound){0};
    if (pairs->group[n] < 0 || body->skin == NULL)
      continue;
    fill_member(scene, n, pairs->members + n);
    pairs->bounds[n] = thrum_contact_member_bound(pairs->members + n);
  }
  sort(pairs);
  join(scene);

  // a body alone has no group, unless it may touch itself, a solid is near, or the world is linked
  // to it
  for (int32_t n = 0; n < scene->body_count; n++) {
    if (pairs->group[n] < 0)
      continue;
    const int32_t first = root(pairs->group, n);
    const bool self = scene->bodies[n]->self_contact && scene->bodies[n]->skin != NULL;
    if (first != n || self || is_near_solid(scene, n) || is_linked(scene, n))
      scene->bodies[n]->group = scene->bodies[first]->group = first;
  }
  for (int32_t n = 0; n < scene->body_count; n++)
    if (scene->bodies[n]->group == n)
      pairs->firsts[pairs->group_count++] = n;
  atomic_store(&pairs->next, 0);
}

/* Adds the solids that a body of the group is near behind its `count` members. */
static int64_t add_solids(thrum_scene *scene, int32_t group, thrum_contact_member *members,
                          int64_t count) {
  const scene_pairs *pairs = &scene->pairs;
  for (int32_t s = 0; s < scene->solid_count; s++) {
    scene_solid *solid = scene->solids + s;
    bool near = false;
    for (int32_t n = group; n < scene->body_count && !near; n++)
      near = scene->bodies[n]->group == group && scene->bodies[n]->skin != NULL &&
             thrum_contact_pairs_near(pairs->bounds + n, &solid->bound);
    if (near)
      members[count++] = (thrum_contact_member){
          .skin = solid->skin, .solid = &solid->moving, .number = THRUM_SCENE_SOLID + s};
  }
  return count;
}

int32_t scene_pairs_step(thrum_scene *scene, int32_t worker, thrum_error *error) {
  scene_pairs *pairs = &scene->pairs;
  thrum_contact_member *members = pairs->members + worker * pairs->member_room;
  int64_t count = 0;

  // the next one, so that the groups of a worker ascend whatever the order of its tasks is
  const int32_t index = atomic_fetch_add(&pairs->next, 1), group = pairs->firsts[index];
  for (int32_t n = group; n < scene->body_count; n++)
    if (scene->bodies[n]->group == group) {
      fill_member(scene, n, members + count++);
      scene_lend(scene, scene->bodies[n], worker);
    }
  const int64_t bodies = count;
  count = add_solids(scene, group, members, count);

  const thrum_contact_links links =
      scene_links_gather(scene, group, members, &count, pairs->ties + worker * pairs->tie_room);

  // each body has its own status
  const thrum_status status =
      thrum_contact_pairs_step_beside(pairs->contact, block_of(pairs, worker), pairs->group_count,
                                      members, count, &links, pairs->groups + index, error);
  scene_links_keep(scene, group, &links);
  for (int64_t n = 0; n < bodies; n++) {
    scene_body *body = scene->bodies[members[n].number];
    body->stepped =
        status == THRUM_INVALID_ARGUMENT && members[n].status >= 0 ? status : members[n].status;
    if (body->stepped >= 0 && body->free)
      scene_free_place(body);
  }
  return group;
}

void scene_pairs_gather(thrum_scene *scene) {
  if (scene->pairs.contact != NULL)
    thrum_contact_pairs_gather(scene->pairs.contact, scene->pairs.groups, scene->pairs.group_count);
}

/* --- reports ---------------------------------------------------------------------------------- */

thrum_contact_pairs_report thrum_scene_collisions(const thrum_scene *scene) {
  return thrum_contact_pairs_report_get(scene->pairs.contact);
}

thrum_status thrum_scene_collision(const thrum_scene *scene, int64_t index, thrum_pair_touch *touch,
                                   thrum_error *error) {
  return thrum_contact_pairs_touch(scene->pairs.contact, index, touch, error);
}

thrum_status thrum_scene_account_get(thrum_scene *scene, thrum_scene_account *account,
                                     thrum_error *error) {
  thrum_scene_account sum = {0};
  for (int32_t n = 0; n < scene->body_count; n++) {
    const scene_body *body = scene->bodies[n];
    thrum_scene_energies of;
    THRUM_TRY(thrum_scene_body_energies(scene, n, &of, error));
    sum.kinetic += of.kinetic;
    sum.potential += of.potential;
    sum.gravity += of.gravity;
    sum.contact += of.contact;
    if (!body->free)
      continue;

    // p = m v and L = c x m v + the angular momentum about the centre
    double centre[3], p[3], orbital[3];
    scene_free_centre(body, centre);
    for (int axis = 0; axis < 3; axis++)
      p[axis] = body->way.mass * body->way.velocity[axis];
    for (int axis = 0; axis < 3; axis++) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      orbital[axis] = centre[next] * p[last] - centre[last] * p[next];
      sum.momentum[axis] += p[axis];
      sum.angular_momentum[axis] += orbital[axis] + body->rigid_frame.momentum[axis];
    }
  }
  sum.contact += thrum_scene_collisions(scene).stored;
  for (int32_t n = 0; n < scene->link_count; n++)
    sum.links += scene->links[n].tie.report.stored;
  sum.total = sum.kinetic + sum.potential + sum.gravity + sum.contact + sum.links;
  *account = sum;
  return THRUM_OK;
}
