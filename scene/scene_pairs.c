/* Bodies that touch each other (thrum/contact_pairs.h): which are near in a step, and the steps of
 * those that are.
 *
 * Broad phase: bodies are held in the order of where their spheres begin along x, which changes
 * little from step to step, and only those whose intervals overlap are compared (sweep and prune:
 * Baraff 1992, Cohen et al. 1995, doi:10.1145/199404.199437). Bodies that are near, one by one,
 * make a group, which is stepped together; the others step as if they were alone.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_pairs.h"

#include <math.h>

#include "scene/scene_contact.h"
#include "scene/scene_free_body.h"
#include "scene/scene_link.h"
#include "scene/scene_pairs_room.h"
#include "scene/scene_solid.h"
#include "scene/scene_state.h"

#define WIDER 1.02 /* of the radius of a body: what touches it begins within it */

/* --- skins ------------------------------------------------------------------------------------ */

/* Keeps the triangles of a def, of which a skin is made when bodies are to touch each other. */
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
  return bound->middle[0] + side * (WIDER * bound->radius + 4.0 * bound->motion);
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

/* What is struck goes on as fast as what strikes it: a body moves as far as a solid that is near;
 * true where that is further than it was. */
static bool hurry_by_solids(const thrum_scene *scene) {
  bool further = false;
  for (int32_t n = 0; n < scene->body_count; n++)
    for (int32_t s = 0; s < scene->solid_count && scene->bodies[n]->skin != NULL; s++) {
      const thrum_skin_bound *solid = &scene->solids[s].bound;
      double *motion = &scene->pairs.bounds[n].motion;
      if (scene->pairs.group[n] < 0 || !(solid->motion > *motion) ||
          !thrum_contact_pairs_near(scene->pairs.bounds + n, solid))
        continue;
      *motion = solid->motion;
      further = true;
    }
  return further;
}

/* And all bodies of a group move as far as the fastest of them may; true likewise. */
static bool hurry(const thrum_scene *scene) {
  const scene_pairs *pairs = &scene->pairs;
  bool further = hurry_by_solids(scene);
  for (int pass = 0; pass < 2; pass++)
    for (int32_t n = 0; n < scene->body_count; n++) {
      if (pairs->group[n] < 0)
        continue;
      const int32_t first = root(pairs->group, n);
      double *of = &pairs->bounds[pass == 0 ? first : n].motion;
      const double other = pairs->bounds[pass == 0 ? n : first].motion;
      further = further || other > *of;
      *of = fmax(*of, other);
    }
  return further;
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
    thrum_contact_pairs_begin(scene_pairs_block(pairs, n));
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
    pairs->bounds[n].motion += pairs->def.thickness;
  }
  do {
    sort(pairs);
    join(scene);
  } while (hurry(scene));

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
          .skin = solid->skin, .solid = &solid->moving, .number = SOLID_MEMBERS + s};
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
  const thrum_status status = thrum_contact_pairs_step_beside(
      pairs->contact, scene_pairs_block(pairs, worker), pairs->group_count, members, count, &links,
      pairs->groups + index, error);
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

thrum_status thrum_scene_collision_get(const thrum_scene *scene, int64_t index,
                                       thrum_pair_touch *touch, thrum_error *error) {
  return thrum_contact_pairs_touch_get(scene->pairs.contact, index, touch, error);
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
