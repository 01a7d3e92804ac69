/* Checks whether bytes from elsewhere are a contact (thrum/contact.h): the parts that no step
 * changes are those of the contact that they would replace, and what persists from step to step is
 * in range. Cost: one look at the touches. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "contact/contact_private.h"
#include "core/base/alignment_check.h"
#include "core/base/finite.h"

/* Everything that thrum_contact_init sets and no step changes. */
static bool is_same_contact(const thrum_contact *a, const thrum_contact *b) {
  return a->magic == b->magic && a->bytes == b->bytes && a->state_bytes == b->state_bytes &&
         a->point_count == b->point_count && a->touch_max == b->touch_max &&
         a->pull_max == b->pull_max && a->tolerance == b->tolerance &&
         a->stiffness == b->stiffness && memcmp(a->middle, b->middle, sizeof a->middle) == 0 &&
         a->radius == b->radius && a->diagonal == b->diagonal && a->rank == b->rank &&
         a->sweeps_max == b->sweeps_max && a->springy == b->springy;
}

static bool is_count(int64_t count, int64_t most) {
  return count >= 0 && count <= most;
}

static bool are_numbers_right(const thrum_contact *header) {
  if (!is_count(header->touch_count, header->touch_max) ||
      !is_count(header->struck, header->touch_max - header->touch_count) ||
      !is_count(header->row_count, header->touch_max) ||
      !is_count(header->pull_count, header->pull_max))
    return false;
  if (!is_count(header->steps, THRUM_COUNT_MAX) || !is_count(header->redone, THRUM_COUNT_MAX) ||
      !is_count(header->declined, THRUM_COUNT_MAX) || !is_count(header->dropped, THRUM_COUNT_MAX) ||
      !is_count(header->sweeps, THRUM_COUNT_MAX) || !is_count(header->impacts, THRUM_COUNT_MAX))
    return false;
  if (!is_count(header->fresh, 1) || header->begun != 0)
    return false;

  // energies and forces
  const double values[] = {header->flow,   header->stored,  header->lost,   header->owed,
                           header->driven, header->granted, header->pulled, header->depth,
                           header->normal, header->impact};
  return thrum_all_finite(values, sizeof values / sizeof values[0]) &&
         thrum_all_finite(header->moved, 3) && thrum_all_finite(header->force, 3) &&
         thrum_all_finite(header->turned, 3) && thrum_all_finite(header->torque, 3) &&
         thrum_all_finite(header->pressed, 3) && thrum_all_finite(header->whirled, 3);
}

static bool is_touch_right(const thrum_contact *header, const unsigned char *at) {
  thrum_touching touch;
  memcpy(&touch, at, sizeof touch);
  const double values[] = {touch.normal[0], touch.normal[1],   touch.normal[2],   touch.force,
                           touch.stored,    touch.friction[0], touch.friction[1], touch.friction[2],
                           touch.approach,  touch.gap};
  return touch.point >= 0 && touch.point < header->point_count && touch.obstacle >= 0 &&
         touch.face >= 0 && is_count(touch.towards, 1) &&
         thrum_all_finite(values, sizeof values / sizeof values[0]);
}

static bool are_forces_right(const unsigned char *bytes, size_t from, int64_t count) {
  bool right = true;
  for (int64_t n = 0; right && n < count; n++) {
    double force;
    memcpy(&force, bytes + from + (size_t)n * sizeof force, sizeof force);
    right = isfinite(force);
  }
  return right;
}

thrum_status thrum_contact_copy_check(const thrum_contact *contact, const void *copy,
                                      thrum_error *error) {
  if (!contact || !copy)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the contact or the copy of one is NULL");

  // the sizes first, as the offsets of all else follow from them
  thrum_contact header;
  memcpy(&header, copy, sizeof header);
  if (!is_same_contact(&header, contact))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is of a contact of another model or def");

  // points, areas and extents lie in a row behind the header
  const unsigned char *bytes = copy;
  const unsigned char *own = (const unsigned char *)contact;
  const thrum_contact_view view = thrum_contact_view_of((thrum_contact *)(uintptr_t)own);
  const size_t fixed = thrum_round_up(sizeof *contact);
  const size_t touches = (size_t)((const unsigned char *)view.touches - own);
  if (memcmp(bytes + fixed, own + fixed, touches - fixed) != 0)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is of a contact with other points");

  // what persists from step to step
  bool right = are_numbers_right(&header);
  for (int64_t n = 0; right && n < header.touch_max; n++)
    if (n < header.touch_count || n >= header.touch_max - header.struck)
      right = is_touch_right(&header, bytes + touches + (size_t)n * sizeof(thrum_touching));
  right = right && are_forces_right(bytes, (size_t)((const unsigned char *)view.pull_forces - own),
                                    3 * header.pull_max);
  right = right && are_forces_right(bytes, (size_t)((const unsigned char *)view.pressing - own),
                                    header.rank);
  return right ? THRUM_OK
               : thrum_error_set(error, THRUM_BAD_VALUE,
                                 "the snapshot holds a number of a contact that is out of its "
                                 "range");
}
