/* Steps of bodies that may touch each other: predict each, find what touches, solve all together,
 * step each, look at what they really did (contact_step.c). A body alone is a group of one.
 *
 * The account knows the work of contact exactly after the step. Where it would have given back more
 * than it took, the whole group is stepped again: with the prediction shifted by what the attempt
 * showed, then without restitution and release, at last without contact, whose work is nothing.
 *
 * After a solve the displacements are those with contact. Where they differ from those that the
 * search was made with by more than a part of the thickness, the search is repeated with them, so
 * that a body which was struck within the step meets the next one in it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "contact/contact_elastic.h"
#include "contact/contact_energy.h"
#include "contact/contact_impact.h"
#include "contact/contact_pairs_energy.h"
#include "contact/contact_pairs_link.h"
#include "contact/contact_pairs_private.h"
#include "contact/contact_pairs_rows.h"
#include "contact/contact_pairs_search.h"
#include "contact/contact_pairs_solid.h"
#include "contact/contact_pairs_solve.h"
#include "contact/contact_pairs_sort.h"
#include "contact/contact_pairs_step.h"
#include "contact/contact_rows.h"
#include "contact/contact_step.h"
#include "core/state/state_layout.h"

#define REPEATS_MAX 4 /* searches, solves for rotations, and solves for what waits, of a step */
#define SPUN 3.0      /* radians by which forces turn a body in a step at most: half a turn */
#define CLOSED 1e-14  /* of the bodies' size: links that a step leaves so far open are closed */
#define LINKED                                                                                     \
  1e-10 /* tolerance of the steps of linked bodies, at most; open so far, they go on               \
         */
#define CLOSINGS_MAX 12 /* steps to close the links of one */
#define CLOSING 0.5     /* share that a correction leaves at most; else the steps are not exact */
#define MISSED 0.1 /* thicknesses by which bodies may go otherwise than rows and levers have it */
#define REACH 1.01 /* of two radii within which bodies meet: what is left is for the thickness */

/* The first attempt, shifted ones, one without release, one without contact. */
enum { ATTEMPT_FIRST = 0, ATTEMPT_RELEASED = 4, ATTEMPT_WITHOUT = 5 };

void thrum_contact_pairs_begin(thrum_contact_pairs *pairs) {
  if (!pairs)
    return;
  const thrum_pairs_view view = thrum_pairs_view_of(pairs);
  thrum_pairs_sort(view.touches, sizeof *view.touches, pairs->history.touch_count, view.order,
                   view.sorting);
  for (int64_t n = 0; n < pairs->history.touch_count; n++)
    view.before[n] = view.touches[view.order[n]];

  // what the springs hold is booked again by the groups that have them
  pairs->history.before_count = pairs->history.touch_count;
  pairs->history.touch_count = 0;
  pairs->history.budget = pairs->history.lost;
  pairs->history.lost += pairs->history.stored;
  pairs->history.stored = pairs->history.depth = pairs->history.distance = pairs->history.normal =
      0.0;
  pairs->history.steps++;
  pairs->history.struck = pairs->filled = pairs->listed = 0;
}

/* --- bounds ----------------------------------------------------------------------------------- */

thrum_skin_bound thrum_contact_member_bound(const thrum_contact_member *member) {
  if (member->solid != NULL)
    return thrum_pairs_solid_bound(member);
  const thrum_skin_view view = thrum_skin_view_of(member->skin);
  const thrum_contact_environment *environment = member->environment;
  const thrum_translation *translation = environment->translation;
  const thrum_state_view state = thrum_state_view_of(member->state);
  const thrum_placement now = thrum_placement_now(environment->placement, environment->rigid_frame,
                                                  translation ? translation->position : NULL);
  thrum_skin_bound bound = {.radius = view.nodes[0].radius};
  const double h = member->state->def.dt;
  memcpy(bound.axes, now.axes, sizeof bound.axes);
  memcpy(bound.half, member->skin->half, sizeof bound.half);
  thrum_apply3(now.axes, view.nodes[0].middle, bound.middle);
  for (int axis = 0; axis < 3; axis++)
    bound.middle[axis] += now.origin[axis];

  // the deformation, and how far it can go: as far back as it is, and what speed and load add
  for (int64_t i = 0; i < member->skin->rank; i++) {
    const double load = environment->load ? fabs(environment->load[i]) : 0.0;
    bound.deformed += view.extents[i] * fabs(state.q[i]);
    bound.motion += view.extents[i] * (2.0 * fabs(state.q[i]) + h * (fabs(state.p[i]) + h * load));
  }

  bound.radius += bound.deformed;

  // the body as a whole
  if (translation) {
    double way[3];
    for (int axis = 0; axis < 3; axis++)
      way[axis] =
          h * (translation->velocity[axis] + h * environment->force[axis] / translation->mass);
    bound.motion += sqrt(thrum_dot3(way, way));
  }
  if (environment->rigid_frame) {
    double spin[3], arm[3];
    thrum_rigid_frame_velocity(environment->rigid_frame, environment->placement, spin);
    thrum_subtract3(view.nodes[0].middle, environment->rigid_frame->centre, arm);
    bound.motion += h * sqrt(thrum_dot3(spin, spin)) * (bound.radius + sqrt(thrum_dot3(arm, arm)));
  }
  return bound;
}

/* How far a body reaches from its middle along a direction [m], where it is not deformed. */
static double reach_along(const thrum_skin_bound *bound, const double direction[3]) {
  double reach = 0.0, along[3];
  thrum_apply3_transposed(bound->axes, direction, along);
  for (int axis = 0; axis < 3; axis++)
    reach += bound->half[axis] * fabs(along[axis]);
  return reach;
}

/* Are the boxes further apart than `reach` along one of the axes of the first? */
static bool are_apart(const thrum_skin_bound *a, const thrum_skin_bound *b, const double apart[3],
                      double reach) {
  for (int axis = 0; axis < 3; axis++) {
    const double along[3] = {a->axes[axis], a->axes[3 + axis], a->axes[6 + axis]};
    const double length = sqrt(thrum_dot3(along, along));
    if (fabs(thrum_dot3(apart, along)) >
        reach_along(a, along) + reach_along(b, along) + reach * length)
      return true;
  }
  return false;
}

int32_t thrum_contact_pairs_near(const thrum_skin_bound *a, const thrum_skin_bound *b) {
  double apart[3];
  thrum_subtract3(a->middle, b->middle, apart);
  // a body that is struck moves at up to twice the speed of what strikes it
  const double motion = a->motion + b->motion + 2.0 * fmax(a->motion, b->motion);
  const double radii = a->radius + b->radius, reach = REACH * radii + motion;
  if (!(thrum_dot3(apart, apart) <= reach * reach))
    return 0;

  // what lies side by side
  const double beyond = (REACH - 1.0) * radii + motion + a->deformed + b->deformed;
  return !are_apart(a, b, apart, beyond) && !are_apart(b, a, apart, beyond);
}

/* --- opening ---------------------------------------------------------------------------------- */

/* Counts the vertices of the skin; a member without a skin has none. */
static int64_t vertices_of(const thrum_contact_member *member) {
  return member->skin ? member->skin->vertex_count : 0;
}

static int64_t nodes_of(const thrum_contact_member *member) {
  return member->skin ? member->skin->node_count : 0;
}

/* Refuses links of members that are none. */
static thrum_status check_links(const thrum_contact_pairs *pairs, int64_t count,
                                const thrum_contact_links *links, thrum_error *error) {
  if (links->count < 0 || links->count > pairs->link_max ||
      (links->links == NULL && links->count > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld links are to step together; there is room for 0 to %lld",
                           (long long)links->count, (long long)pairs->link_max);
  for (int64_t n = 0; n < 2 * links->count; n++) {
    const thrum_link *link = links->links + n / 2;
    const thrum_link_side *side = link->sides + n % 2;
    if (side->member < 0 || side->member >= count || side->rest == NULL ||
        link->sides[0].member == link->sides[1].member)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "link %lld is not of two of the members, or lacks a part",
                             (long long)n / 2);
  }
  return THRUM_OK;
}

static thrum_status check(const thrum_contact_pairs *pairs, const thrum_contact_member *members,
                          int64_t count, const thrum_contact_links *links, thrum_error *error) {
  int64_t vertices = 0, nodes = 0;
  if (!pairs || !members || count < 1 || count > pairs->member_max)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld bodies are to step together; there is room for 1 to %lld",
                           (long long)count, pairs ? (long long)pairs->member_max : 0LL);
  for (int64_t n = 0; n < count; n++) {
    const thrum_contact_member *member = members + n;
    const bool whole = member->model && member->state && member->contact && member->environment;
    if ((!member->skin && !links) || (!whole && !member->solid))
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "member %lld lacks a part",
                             (long long)n);
    const int64_t rank = member->solid ? 0 : member->model->rank;
    if ((member->skin && member->skin->rank != rank) || rank > pairs->rank_max)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "the skin of member %lld is of another rank, or beyond rank_max",
                             (long long)n);
    if (member->number < 0 || (n > 0 && member->number <= members[n - 1].number))
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "the numbers of the members must ascend from 0");
    vertices += vertices_of(member);
    nodes += nodes_of(member);
  }
  if (vertices > pairs->vertex_max || nodes > pairs->node_max)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the skins of the members have %lld vertices and %lld nodes; there is "
                           "room for %lld and %lld",
                           (long long)vertices, (long long)nodes, (long long)pairs->vertex_max,
                           (long long)pairs->node_max);
  return links ? check_links(pairs, count, links, error) : THRUM_OK;
}

/* A member fails: it keeps what it had, and the others go on without it. */
static void fail(thrum_contact_member *member, thrum_status status, const thrum_error *detail,
                 thrum_status *first, thrum_error *error) {
  member->status = status;
  if (*first < 0)
    return;
  *first = status;
  if (error)
    *error = *detail;
}

/* Opens the runs of all members at the start of the step, with what they had before. */
static void open_all(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  double dt = 0.0;
  run->view.first_vertex[0] = run->view.first_node[0] = 0;
  for (int64_t n = 0; n < run->count; n++) {
    thrum_contact_member *member = run->members + n;
    thrum_error detail = {0};

    // members that fail keep their numbers, so that those of the others stay
    run->view.first_vertex[n + 1] = run->view.first_vertex[n] + vertices_of(member);
    run->view.first_node[n + 1] = run->view.first_node[n] + nodes_of(member);
    member->status = THRUM_OK;
    run->view.runs[n].contact = NULL;
    if (member->solid != NULL)
      continue;
    dt = member->state->def.dt;
    const thrum_status opened =
        thrum_contact_open(member->model, member->state, member->contact, member->environment,
                           run->view.runs + n, &detail);
    if (opened < 0)
      fail(member, opened, &detail, first, error);
    if (opened < 0)
      continue;

    // what another attempt goes back to
    member->contact->struck = 0;
    run->view.contacts[n] = *member->contact;
    run->view.wholes[n] = thrum_contact_keep_whole(member->environment);
    memcpy(run->view.runs[n].view.snapshot, member->state, (size_t)member->contact->state_bytes);
  }

  // solids move through the step of the bodies
  for (int64_t n = 0; n < run->count; n++)
    if (run->members[n].solid != NULL)
      thrum_pairs_open_solid(run, n, dt);
}

/* Puts a member back to the start of the step. */
static void put_back(thrum_pairs_run *run, int64_t n) {
  thrum_contact_member *member = run->members + n;
  memcpy(member->state, run->view.runs[n].view.snapshot, (size_t)member->contact->state_bytes);
  *member->contact = run->view.contacts[n];

  // the body as a whole, with what impacts have changed of it
  thrum_contact_put_back_whole(member->environment, run->view.wholes + n);
  if (run->view.runs[n].impact.struck)
    thrum_contact_place(run->view.runs + n);
  run->view.runs[n].impact = (thrum_impact_body){0};
}

static void prepare_all(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  for (int64_t n = 0; n < run->count; n++) {
    thrum_contact_member *member = run->members + n;
    thrum_error detail = {0};
    if (!thrum_pairs_steps(run, n))
      continue;
    const thrum_status prepared = thrum_contact_prepare(run->view.runs + n, &detail);
    if (prepared >= 0)
      continue;
    put_back(run, n);
    fail(member, prepared, &detail, first, error);
  }
}

/* --- the step --------------------------------------------------------------------------------- */

/* The thickness that a member keeps from others like it [m]. */
static double thickness_of(const thrum_pairs_run *run, int64_t member) {
  const thrum_skin *skin = run->members[member].skin;
  return thrum_pairs_thickness(run->pairs, skin, skin);
}

/* Searches of a member that moves go by its way without contact: what it has left does not hold it
 * any more. */
static void seek_what_moves(const thrum_pairs_run *run, int64_t member) {
  thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_translation *way = body->environment->translation;
  if (skin == NULL)
    return;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  double speed = way ? sqrt(thrum_dot3(way->velocity, way->velocity)) : 0.0;
  speed += sqrt(thrum_dot3(body->spin, body->spin)) * skin->diagonal;
  for (int64_t i = 0; i < skin->rank; i++)
    speed += view.extents[i] * fabs(body->view.p[i]);
  if (!(body->dt * speed <= MISSED * thickness_of(run, member)))
    thrum_contact_seek(body);
}

/* True where a solve has moved a body so much further than the search had it that it may meet what
 * was not found. */
static bool has_missed(const thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->count; n++) {
    const thrum_contact_run *body = run->view.runs + n;
    if (run->members[n].status < 0 || run->members[n].skin == NULL)
      continue;
    const thrum_skin *skin = run->members[n].skin;
    const thrum_skin_view view = thrum_skin_view_of(skin);
    double off = 0.0, way[3], turn[3];

    // a bound on how far any vertex is from where the search had it: by shape, way and rotation
    for (int64_t i = 0; i < skin->rank; i++)
      off += view.extents[i] * fabs(body->view.moved[i] - body->view.sought[i]);
    thrum_subtract3(body->moved, body->sought, way);
    thrum_subtract3(body->turned, body->sought_turn, turn);
    off += sqrt(thrum_dot3(way, way)) + sqrt(thrum_dot3(turn, turn)) * skin->diagonal;

    if (off > MISSED * thickness_of(run, n))
      return true;
  }
  return false;
}

/* How far the rotations of the last solve are from those that the levers were made for [m]. */
static double turned_since(const thrum_pairs_run *run, double (*before)[3]) {
  double most = 0.0;
  for (int64_t n = 0; n < run->count; n++) {
    const thrum_contact_run *body = run->view.runs + n;
    double off[3];
    if (run->members[n].status < 0 || run->members[n].skin == NULL)
      continue;
    thrum_subtract3(body->turned, before[n], off);
    most = fmax(most,
                sqrt(thrum_dot3(off, off)) * run->members[n].skin->diagonal /
                    thrum_pairs_thickness(run->pairs, run->members[n].skin, run->members[n].skin));
    memcpy(before[n], body->turned, sizeof before[n]);
  }
  return most;
}

/* Solves until the levers are those of the rotations that come out. */
static void solve_rows(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->count; n++)
    memcpy(run->view.turns[n],
           run->solved ? run->view.runs[n].turned : run->view.runs[n].unloaded_turn,
           sizeof run->view.turns[n]);
  for (int n = 0; n < REPEATS_MAX; n++) {
    thrum_pairs_solve(run);
    run->solved = true;
    if (run->row_count == 0 || turned_since(run, run->view.turns) < MISSED)
      break;

    // what is booked is the work of the levers that were solved with, so the last ones stay
    if (n + 1 < REPEATS_MAX)
      thrum_pairs_refresh(run);
  }
}

/* The same, until nothing closes that has no row: at last all have one. */
static void solve(thrum_pairs_run *run) {
  solve_rows(run);
  for (int n = 1; !run->closing && thrum_pairs_wake_all(run, n == REPEATS_MAX); n++)
    solve_rows(run);
}

/* Finds what touches as the bodies go without contact. */
static void find(thrum_pairs_run *run) {
  run->row_count = 0;
  run->moved = run->solved = false;
  memset(run->view.taken, 0, (size_t)run->history->before_count * sizeof *run->view.taken);
  for (int64_t n = 0; n < run->count; n++)
    if (thrum_pairs_steps(run, n))
      seek_what_moves(run, n);
  thrum_pairs_search(run);
  thrum_pairs_add_rows(run);
}

/* Finds what touches, and makes the impacts of the step one after the other. */
static void strike_all(thrum_pairs_run *run, const thrum_impact_rows *rows, thrum_status *first,
                       thrum_error *error) {
  run->taken = run->driven = run->flow = 0.0;
  run->impacts = run->struck = 0;
  find(run);
  for (int n = 0; n < THRUM_IMPACTS_MAX && thrum_contact_strike(rows); n++) {
    for (int64_t m = 0; m < run->count; m++)
      if (thrum_pairs_steps(run, m))
        thrum_contact_place(run->view.runs + m);
    prepare_all(run, first, error);
    find(run);
  }
}

/* The same, at the times of the impacts or else at the start of the step. */
static void find_with_impacts(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  thrum_impact_rows rows = {.runs = run->view.runs, .count = run->count, .pairs = run};
  strike_all(run, &rows, first, error);
  if (!thrum_contact_strays(&rows))
    return;

  // back to the start
  for (int64_t n = 0; n < run->count; n++)
    if (thrum_pairs_steps(run, n))
      put_back(run, n);
  prepare_all(run, first, error);
  rows.early = true;
  strike_all(run, &rows, first, error);
}

/* All members of links fail whose conditions cannot be solved for. */
static void fail_linked(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  thrum_error detail = {0};
  const thrum_status status =
      thrum_error_set(&detail, THRUM_SINGULAR,
                      "the links of a group of bodies cannot be solved for together: they ask for "
                      "what no force brings about, or what they tie is too different in size");
  for (int64_t n = 0; n < run->count; n++)
    if (thrum_pairs_steps(run, n) && thrum_links_tie(run, n))
      fail(run->members + n, status, &detail, first, error);
}

/* Finds what touches and solves, until no solve leads to new touches. */
static void find_and_solve(thrum_pairs_run *run) {
  solve(run);
  for (int n = 1; n < REPEATS_MAX && has_missed(run); n++) {
    run->moved = true;
    for (int64_t m = 0; m < run->count; m++)
      if (thrum_pairs_steps(run, m))
        thrum_contact_seek(run->view.runs + m);
    thrum_pairs_search(run);
    if (thrum_pairs_add_rows(run) == 0)
      return;
    solve(run);
  }
}

/* Steps a member. What is linked is solved for to a tolerance that a joint can be closed with, as
 * the same forces have to lead to the same end. */
static thrum_status step_member(const thrum_pairs_run *run, int64_t n, thrum_error *error) {
  const thrum_contact_member *member = run->members + n;
  thrum_state_def *def = &member->state->def;
  const double own = def->tolerance;
  if (run->view.runs[n].linked && !(own > 0.0 && own < LINKED))
    def->tolerance = LINKED;
  const thrum_status status = thrum_contact_advance(run->view.runs + n, error);
  def->tolerance = own;
  return status;
}

/* Steps all members under the loads that were solved for; false where one failed. */
static bool step_all(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  bool done = true;

  // all are stepped, also after a failure: what failed says so for each body
  for (int64_t n = 0; n < run->count; n++) {
    thrum_contact_member *member = run->members + n;
    thrum_error detail = {0};
    if (!thrum_pairs_steps(run, n))
      continue;
    thrum_status status = thrum_contact_apply(run->view.runs + n, &detail);
    THRUM_THEN(status, step_member(run, n, &detail));
    member->status = status;
    if (status >= 0)
      continue;
    done = false;
    fail(member, status, &detail, first, error);
  }
  return done;
}

/* Steps all members until the links are closed as far as the steps themselves are exact: each time
 * the forces are corrected by how the step before ended. */
static bool step_closed(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  double before = INFINITY;
  for (int n = 1;; n++) {
    if (!step_all(run, first, error))
      return false;
    if (run->link_count == 0)
      return true;
    const double open = thrum_links_look(run);
    if (open <= CLOSED || n == CLOSINGS_MAX || (open <= LINKED && !(open < CLOSING * before)))
      return true;

    // back to the start
    before = open;
    for (int64_t m = 0; m < run->count; m++)
      if (thrum_pairs_steps(run, m))
        thrum_contact_return(run->view.runs + m);

    // after the first time touches have their forces: sweeps end within a tolerance, which would
    // leave the links open
    run->closing = n > 1;
    solve(run);
    run->closing = false;
  }
}

static bool is_allowed(thrum_pairs_run *run) {
  bool allowed = true;
  for (int64_t n = 0; n < run->count; n++)
    if (thrum_pairs_steps(run, n))
      allowed = thrum_contact_allowed(run->view.runs + n) && allowed;
  return thrum_pairs_allowed(run) && allowed;
}

/* Did the forces of an attempt turn a body by more than half a turn, or out of the numbers? Levers
 * of places that were far apart at the start have then followed rotations which no body makes. */
static bool has_spun(const thrum_pairs_run *run) {
  bool spun = false;
  for (int64_t n = 0; n < run->count; n++) {
    const thrum_contact_run *body = run->view.runs + n;
    double off[3];
    if (!thrum_pairs_steps(run, n))
      continue;
    thrum_subtract3(body->turned, body->unloaded_turn, off);
    spun = spun || !(thrum_dot3(off, off) <= SPUN * SPUN);
  }
  return spun;
}

/* Has the rows begin without forces, with the levers of the step without contact: an attempt that
 * has spun leaves nothing that the next one could go on from. */
static void begin_anew(thrum_pairs_run *run) {
  for (int64_t n = 0; n < run->row_count; n++) {
    thrum_touching *touch = &run->view.rows[n].row.touch;
    touch->force = 0.0;
    memset(touch->friction, 0, sizeof touch->friction);
  }

  // as if nothing had been solved yet
  run->solved = run->again = false;
  thrum_pairs_refresh(run);
  run->again = true;
}

/* Back to the start of the step for the next attempt, each of which asks for less. */
static void again(thrum_pairs_run *run, int attempt) {
  const bool spun = has_spun(run);
  run->history->redone++;
  run->again = true;
  thrum_pairs_wake_all(run, true);

  // each body goes back, and its own touches ask for as much less as the pairs do
  for (int64_t n = 0; n < run->count; n++) {
    thrum_contact_run *body = run->view.runs + n;
    if (!thrum_pairs_steps(run, n))
      continue;
    thrum_contact_again(body);
    if (attempt == ATTEMPT_WITHOUT) {
      body->contact->declined++;
      body->contact->row_count = 0;
    }
    if (attempt == ATTEMPT_RELEASED)
      thrum_contact_release(body);
  }

  // the pairs, then all together
  if (spun && attempt != ATTEMPT_WITHOUT)
    begin_anew(run);
  if (attempt == ATTEMPT_RELEASED)
    thrum_pairs_release(run);
  if (attempt == ATTEMPT_WITHOUT) {
    run->history->declined++;
    run->row_count = 0;
  }
  solve(run);
}

static void fail_beyond(thrum_pairs_run *run, int64_t n, thrum_status *first, thrum_error *error) {
  thrum_error detail = {0};
  const thrum_status status = thrum_contact_beyond(&detail);
  fail(run->members + n, status, &detail, first, error);
}

/* Can the energies of the step that was made be booked? A member of which they cannot fails. */
static bool is_countable(thrum_pairs_run *run, thrum_status *first, thrum_error *error) {
  bool all = true;

  // its own touches and pulls
  for (int64_t n = 0; n < run->count; n++) {
    if (!thrum_pairs_steps(run, n) || thrum_contact_counts(run->view.runs + n))
      continue;
    fail_beyond(run, n, first, error);
    all = false;
  }

  // what is between members: one at a time, as the others may be well without it
  const int64_t touching = thrum_pairs_beyond(run), linked = thrum_links_beyond(run);
  const int64_t beyond = touching >= 0 ? touching : linked;
  if (all && beyond >= 0)
    fail_beyond(run, beyond, first, error);
  return all && beyond < 0;
}

/* All members that have not failed, from the start of the step; false where one fails. *given_up
 * gets how many rows the step was made without at last. */
static bool try_all(thrum_pairs_run *run, int64_t *given_up, thrum_status *first,
                    thrum_error *error) {
  run->again = false;
  *given_up = 0;
  prepare_all(run, first, error);
  find_with_impacts(run, first, error);

  // what links tie cannot go on without them
  if (!thrum_links_aim(run)) {
    fail_linked(run, first, error);
    return false;
  }
  find_and_solve(run);
  for (int attempt = ATTEMPT_FIRST;; attempt++) {
    if (attempt == ATTEMPT_WITHOUT)
      *given_up = run->row_count;
    if (attempt != ATTEMPT_FIRST)
      again(run, attempt);
    if (!step_closed(run, first, error))
      return false;
    const bool allowed =
        is_allowed(run) && (attempt >= ATTEMPT_RELEASED - 1 || thrum_pairs_apart(run));
    if (allowed || attempt == ATTEMPT_WITHOUT)
      return is_countable(run, first, error);
  }
}

/* Notes how deep the places of `count` rows ended that the step was made without: surfaces that
 * passed each other in it are far apart again, and no later search finds them. */
static void note_given_up(thrum_pairs_run *run, int64_t count) {
  thrum_pairs_history *history = run->history;

  // their forces and levers are those of attempts that failed: the levers are made anew for the
  // rotations of the step, and of what is measured the gaps alone are read
  run->row_count = count;
  run->again = false;
  thrum_pairs_refresh(run);
  thrum_pairs_allowed(run);
  for (int64_t n = 0; n < count; n++) {
    const double depth = -run->view.rows[n].row.touch.gap;
    if (!isfinite(depth) || !(depth > 0.0))
      continue;
    history->deepest = fmax(history->deepest, depth);
    history->deepest_share =
        fmax(history->deepest_share, thrum_pairs_share(depth, run->view.rows[n].thickness));
  }
  run->row_count = 0;
}

/* Does a member touch another one by a row that takes energy? */
static bool rests_on_another(const thrum_pairs_run *run, int64_t member) {
  bool rests = false;
  for (int64_t n = 0; n < run->row_count && !rests; n++) {
    const thrum_pair_row *row = run->view.rows + n;
    rests = (row->members[0] == member || row->members[1] == member) &&
            thrum_contact_row_takes(&row->row);
  }
  return rests;
}

/* Where bodies take no energy from each other, what the step lost in spite of it [J] goes back, or
 * is owed until they touch again. */
static void give_back(thrum_pairs_run *run, double lost) {
  if (!thrum_pairs_is_elastic(run))
    return;
  thrum_pairs_history *history = run->history;
  double driven = 0.0;
  history->lost -= lost;
  history->budget -= lost;
  history->owed += lost;
  history->owed -= thrum_pairs_give(run, history->owed, &driven);
  history->driven += driven;
}

thrum_status thrum_pairs_begin_group(thrum_pairs_run *run, thrum_error *error) {
  thrum_status status = THRUM_OK;
  open_all(run, &status, error);
  prepare_all(run, &status, error);
  find_with_impacts(run, &status, error);
  find_and_solve(run);
  for (int64_t n = 0; n < run->count && status >= 0; n++)
    status = thrum_contact_apply(run->view.runs + n, error);
  return status;
}

thrum_status thrum_pairs_step_group(thrum_pairs_run *run, const thrum_contact_links *links,
                                    thrum_error *error) {
  thrum_status status = THRUM_OK;
  int64_t given_up = 0;
  open_all(run, &status, error);
  if (links != NULL)
    thrum_links_open(run, links->links, links->count);

  // a member that fails leaves the group, and the others start again
  while (!try_all(run, &given_up, &status, error))
    for (int64_t n = 0; n < run->count; n++)
      if (run->view.runs[n].contact != NULL && run->members[n].solid == NULL)
        put_back(run, n);
  if (given_up > 0)
    note_given_up(run, given_up);

  // books the energies, then moves each body as a whole
  const double missing = thrum_pairs_settle(run);
  thrum_links_settle(run);
  run->history->impacts += run->impacts;
  for (int64_t n = 0; n < run->count; n++) {
    const thrum_status of = run->members[n].status;
    if (!thrum_pairs_steps(run, n))
      continue;
    const bool calmed = thrum_contact_finish(run->view.runs + n);
    if (!calmed && rests_on_another(run, n))
      run->history->lost += thrum_contact_calm(run->view.runs + n);
    if (!thrum_contact_whole_is_finite(run->members[n].environment)) {
      put_back(run, n);
      fail_beyond(run, n, &status, error);
    }
    if (status == THRUM_OK || (status > 0 && of > 0 && of < status))
      status = of;
  }
  give_back(run, missing);
  return status;
}

thrum_status thrum_contact_pairs_step(thrum_contact_pairs *pairs, thrum_contact_member *members,
                                      int64_t count, thrum_error *error) {
  THRUM_TRY(check(pairs, members, count, NULL, error));
  thrum_pairs_run run = {.pairs = pairs,
                         .history = &pairs->history,
                         .members = members,
                         .count = count,
                         .view = thrum_pairs_view_of(pairs)};
  const thrum_status status = thrum_pairs_step_group(&run, NULL, error);
  thrum_pairs_list_impacts(pairs, run.view.struck, run.struck);
  return status;
}

/* --- groups that step at once ----------------------------------------------------------------- */

/* Reports what a group did, from its history, which began with `began`. */
static void fill_group(const thrum_pairs_run *run, const thrum_pairs_history *began,
                       thrum_contact_group *group) {
  const thrum_pairs_history *did = run->history;
  *group = (thrum_contact_group){.room = run->pairs,
                                 .first_touch = run->first_touch,
                                 .first_struck = run->first_struck,
                                 .budget = did->budget - began->budget,
                                 .flow = did->flow - began->flow,
                                 .owed = did->owed,
                                 .report = thrum_pairs_report_of(did)};
  group->report.struck = run->struck;
}

thrum_status thrum_contact_pairs_step_beside(const thrum_contact_pairs *pairs,
                                             thrum_contact_pairs *room, int64_t group_count,
                                             thrum_contact_member *members, int64_t count,
                                             const thrum_contact_links *links,
                                             thrum_contact_group *group, thrum_error *error) {
  if (!pairs || !group || group_count < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a group that steps beside others needs pairs, a place for what it did, "
                           "and at least 1 group");
  *group = (thrum_contact_group){.room = NULL};
  THRUM_TRY(check(room, members, count, links, error));
  if (!thrum_pairs_is_same_def(pairs, room))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the room of a group is of contact between bodies of another def");

  // the lost energy that rounding may draw on is shared, so that no order of groups matters
  const thrum_pairs_history began = {.before_count = pairs->history.before_count,
                                     .budget = pairs->history.budget / (double)group_count,
                                     .owed = pairs->history.owed / (double)group_count,
                                     .flow = pairs->history.flow};
  thrum_pairs_history history = began;
  thrum_pairs_run run = {.pairs = room,
                         .history = &history,
                         .first_touch = room->filled,
                         .first_struck = room->listed,
                         .members = members,
                         .count = count,
                         .view = thrum_pairs_view_of(room)};

  // touches go on from those of all groups, and are kept behind those of this room's other groups
  run.view.before = thrum_pairs_view_of(pairs).before;
  const thrum_status status = thrum_pairs_step_group(&run, links, error);
  room->filled += history.touch_count;
  room->listed += run.struck;
  fill_group(&run, &began, group);
  return status;
}

/* Adds what a group did to a history. */
static void add_group(thrum_pairs_history *history, const thrum_contact_group *group) {
  const thrum_contact_pairs_report *did = &group->report;
  history->redone += did->redone;
  history->declined += did->declined;
  history->dropped += did->dropped;
  history->sweeps += did->sweeps;
  history->impacts += did->impacts;

  // energies
  history->stored += did->stored - group->owed;
  history->owed += group->owed;
  history->lost += did->lost;
  history->driven += did->driven;
  history->budget += group->budget;
  history->flow += group->flow;

  // its touches
  if (did->touching > 0)
    history->distance =
        history->touch_count > 0 ? fmin(history->distance, did->distance) : did->distance;
  history->depth = fmax(history->depth, did->depth);
  history->deepest = fmax(history->deepest, did->deepest);
  history->deepest_share = fmax(history->deepest_share, did->deepest_share);
  history->normal += did->normal;
}

void thrum_contact_pairs_gather(thrum_contact_pairs *pairs, const thrum_contact_group *groups,
                                int64_t count) {
  if (!pairs || !groups)
    return;
  const thrum_pairs_view view = thrum_pairs_view_of(pairs);
  thrum_pairs_history *history = &pairs->history;

  // what is owed has gone to the groups
  if (count > 0)
    history->owed = 0.0;

  // in the order of the groups, by way of the touches before, which the step has used: a room
  // may be that of the pairs themselves
  for (int64_t n = 0; n < count; n++) {
    if (groups[n].room == NULL)
      continue;
    add_group(history, groups + n);
    const int64_t left = pairs->touch_max - history->touch_count;
    const int64_t touching = groups[n].report.touching, kept = touching < left ? touching : left;
    memcpy(view.before + history->touch_count,
           thrum_pairs_view_of(groups[n].room).touches + groups[n].first_touch,
           (size_t)kept * sizeof *view.before);
    history->touch_count += kept;
    history->dropped += touching - kept;
  }
  memcpy(view.touches, view.before, (size_t)history->touch_count * sizeof *view.touches);

  // impacts behind them
  for (int64_t n = 0; n < count; n++)
    if (groups[n].room != NULL)
      thrum_pairs_list_impacts(pairs,
                               thrum_pairs_view_of(groups[n].room).struck + groups[n].first_struck,
                               groups[n].report.struck);
  pairs->filled = pairs->listed = 0;
}
