/* Lists of the places of two members that are near each other, kept from step to step (Verlet 1967,
 * doi:10.1103/PhysRev.159.98): bodies that lie on each other need not be searched again.
 *
 * A list has all places whose boxes were within a reach and a slack of each other. Let no vertex be
 * further than d_a and d_b from where it was then, but for a shift that both members share, and
 * move by no more than w_a and w_b in the step. Boxes of the step that are within the reach are
 * then in the list as long as
 *
 *   d_a + w_a + d_b + w_b <= slack.                                                          (1)
 *
 * So what is found does not depend on whether there is a list, nor on when it was made, unless
 * there are more places than room for touches (`dropped` says so): which are left out is then a
 * matter of their order. Lists are scratch, which no snapshot holds. Of what is not in a list
 * nothing is evaluated.
 * Cost: 5 r a pair of members and look.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_list.h"

#include <math.h>
#include <string.h>

#include "contact/contact_point.h"
#include "core/base/two_lanes.h"

/* Where the middle of a member's surface would be without deformation. */
static void middle_of(const thrum_pairs_run *run, int64_t member, double middle[3]) {
  const thrum_skin_view view = thrum_skin_view_of(run->members[member].skin);
  thrum_point_rest(run->view.runs + member, view.nodes[0].middle, middle);
}

/* How far any vertex is from the middle, at most. */
static double radius_of(const thrum_pairs_run *run, int64_t member) {
  const thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  double radius = view.nodes[0].radius;
  for (int64_t i = 0; i < skin->rank; i++)
    radius += view.extents[i] * fabs(body->view.q[i]);
  return radius;
}

double thrum_pairs_way_bound(const thrum_pairs_run *run, int64_t member) {
  const thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const double *d = body->view.sought, *shift = body->sought, *turn = body->sought_turn;
  double way = 0.0, middle[3], arm[3];
  for (int64_t i = 0; i < skin->rank; i++)
    way += view.extents[i] * fabs(d[i]);

  // no lever is longer than the arm
  middle_of(run, member, middle);
  thrum_subtract3(middle, body->centre, arm);
  const double longest = sqrt(thrum_dot3(arm, arm)) + radius_of(run, member);
  way += sqrt(thrum_dot3(shift, shift)) + sqrt(thrum_dot3(turn, turn)) * longest;

  // a body that was struck is as far from where its way starts, and has that to go as well
  return way +
         2.0 * (body->impact.struck ? body->impact.moved + body->impact.turned * longest : 0.0);
}

static double *q_of(const thrum_pairs_run *run, const thrum_pair_list *list, int side) {
  const int64_t index = list - run->view.lists->lists;
  return run->view.list_q + (2 * index + side) * run->pairs->rank_max;
}

/* How far any vertex of a side is from where it was as the list was made, but for a shift; the
 * shift becomes that of this side where there is none yet. */
static double moved_since(const thrum_pairs_run *run, const thrum_pair_list *list, int side,
                          int64_t member, double shift[3]) {
  const thrum_contact_run *body = run->view.runs + member;
  const thrum_skin *skin = run->members[member].skin;
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const double *q = q_of(run, list, side);
  double middle[3], way[3], square = 0.0, off = 0.0;
  middle_of(run, member, middle);
  thrum_subtract3(middle, list->middles[side], way);
  if (side == 0)
    memcpy(shift, way, sizeof way);
  thrum_subtract3(way, shift, way);

  // by rotation, way and shape
  for (int n = 0; n < 9; n++) {
    const double turned = body->axes[n] - list->axes[side][n];
    square += turned * turned;
  }
  for (int64_t i = 0; i < skin->rank; i++)
    off += view.extents[i] * fabs(body->view.q[i] - q[i]);
  return off + sqrt(thrum_dot3(way, way)) + sqrt(square) * radius_of(run, member);
}

/* The list of two members, whether it holds or not; NULL: there is none. */
static thrum_pair_list *list_of(const thrum_pairs_run *run, int64_t a, int64_t b) {
  thrum_pair_lists *lists = run->view.lists;
  for (int64_t n = 0; n < lists->count; n++)
    if (lists->lists[n].numbers[0] == run->members[a].number &&
        lists->lists[n].numbers[1] == run->members[b].number)
      return lists->lists + n;
  return NULL;
}

thrum_pair_list *thrum_pairs_list_find(const thrum_pairs_run *run, int64_t a, int64_t b,
                                       double thickness, double way, double slack) {
  run->view.lists->searches++;
  thrum_pair_list *list = list_of(run, a, b);
  if (list == NULL || !list->valid || list->thickness != thickness ||
      list->seals[0] != run->members[a].skin->seal || list->seals[1] != run->members[b].skin->seal)
    return NULL;

  // (1); false of NaN
  double shift[3];
  const double first = moved_since(run, list, 0, a, shift);
  const double second = moved_since(run, list, 1, b, shift);
  return first + second + way <= THRUM_SURE * slack ? list : NULL;
}

/* Throws all lists away, unless that was done a short while ago. */
static bool clear(thrum_pair_lists *lists) {
  if (lists->searches < THRUM_PAIR_LISTS)
    return false;
  lists->count = lists->entry_count = lists->searches = 0;
  return true;
}

thrum_pair_list *thrum_pairs_list_open(const thrum_pairs_run *run, int64_t a, int64_t b,
                                       double thickness, bool full) {
  thrum_pair_lists *lists = run->view.lists;
  const int64_t members[2] = {a, b};
  if (full && !clear(lists))
    return NULL;
  thrum_pair_list *list = list_of(run, a, b);
  if (list == NULL && lists->count == THRUM_PAIR_LISTS && !clear(lists))
    return NULL;
  if (list == NULL) {
    list = lists->lists + lists->count++;
    memset(list, 0, sizeof *list);
  }

  // its entries are gathered behind those of all others
  list->valid = 0;
  list->count = 0;
  list->thickness = thickness;
  for (int side = 0; side < 2; side++) {
    const thrum_contact_run *body = run->view.runs + members[side];
    const thrum_skin *skin = run->members[members[side]].skin;
    list->numbers[side] = run->members[members[side]].number;
    list->seals[side] = skin->seal;
    middle_of(run, members[side], list->middles[side]);
    memcpy(list->axes[side], body->axes, sizeof body->axes);
    memcpy(q_of(run, list, side), body->view.q, (size_t)skin->rank * sizeof(double));
  }
  return list;
}

bool thrum_pairs_list_add(const thrum_pairs_run *run, thrum_pair_list *list, int32_t kind,
                          int32_t first, int32_t second) {
  const int64_t index = run->view.lists->entry_count + list->count;
  if (index == run->pairs->touch_max * THRUM_PAIR_ENTRIES)
    return false;
  run->view.entries[index] = (thrum_pair_entry){kind, first, second, 1};
  list->count++;
  return true;
}

void thrum_pairs_list_close(const thrum_pairs_run *run, thrum_pair_list *list) {
  thrum_pair_lists *lists = run->view.lists;
  const int64_t made = lists->entry_count;
  list->valid = 1;

  // where the list had enough room it stays
  if (list->count <= list->room) {
    memmove(run->view.entries + list->from, run->view.entries + made,
            (size_t)list->count * sizeof *run->view.entries);
    return;
  }
  list->from = made;
  list->room = list->count;
  lists->entry_count = made + list->room;
}
