/* A contact's block: planning, laying out, reports (thrum/contact.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_private.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/def.h"
#include "core/state/state_layout.h"
#include "core/step/state_private.h"

#define CONTACT_MAGIC UINT64_C(0x7468726d63743031)
#define COUNT_MAX (INT64_C(1) << 31)

void thrum_contact_def_init(thrum_contact_def *def, size_t size) {
  const thrum_contact_def defaults = {
      .cookie = sizeof(thrum_contact_def), .pull_max = 1, .sweeps_max = 20, .tolerance = 1e-4};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

thrum_contact_view thrum_contact_view_of(thrum_contact *contact) {
  const int64_t rank = contact->rank, point_count = contact->point_count;
  const int64_t touch_max = contact->touch_max, pull_max = contact->pull_max;
  const int64_t state_bytes = (int64_t)contact->state_bytes;
  unsigned char *at = (unsigned char *)contact + thrum_round_up(sizeof *contact);
  thrum_contact_view view;
#define X(type, name, count)                                                                       \
  view.name = (type *)(void *)at;                                                                  \
  at += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_CONTACT_ARRAYS(X)
#undef X
  return view;
}

static size_t bytes_of(const thrum_contact *contact) {
  const int64_t rank = contact->rank, point_count = contact->point_count;
  const int64_t touch_max = contact->touch_max, pull_max = contact->pull_max;
  const int64_t state_bytes = (int64_t)contact->state_bytes;
  size_t size = thrum_round_up(sizeof *contact);
#define X(type, name, count) size += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_CONTACT_ARRAYS(X)
#undef X
  return size;
}

static thrum_status check_counts(const thrum_contact_def *def, thrum_error *error) {
  // counts beyond 2^31 would overflow the offsets of the arrays
  if (def->vertices && (def->vertex_count < 1 || def->vertex_count > COUNT_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact is given %lld vertices; it needs 1 to 2^31",
                           (long long)def->vertex_count);
  if (def->touch_max < 0 || def->touch_max > COUNT_MAX || def->pull_max < 0 ||
      def->pull_max > COUNT_MAX || def->sweeps_max < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "touch_max and pull_max must be 0 to 2^31, sweeps_max at least 1");

  // written so that NaN is refused as well
  if (!(def->stiffness >= 0.0 && def->stiffness <= THRUM_CONTACT_STIFFNESS_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact's stiffness is %g; it must be 0 to 1e30 [N/m^3]",
                           def->stiffness);
  if (!(def->diagonal >= 0.0 && isfinite(def->diagonal)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact's diagonal is %g; it must be finite and >= 0 [m]",
                           def->diagonal);
  if (!(def->tolerance > 0.0 && def->tolerance <= THRUM_TOLERANCE_MOST))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact's tolerance is %g; it must be in (0, 1e-2]",
                           def->tolerance);
  return THRUM_OK;
}

static thrum_status check_points(const thrum_model *model, const thrum_contact_def *def,
                                 thrum_error *error) {
  const int64_t count = def->vertices ? def->vertex_count : model->vertex_count;
  for (int64_t n = 0; n < count; n++) {
    if (def->vertices && (def->vertices[n] < 0 || def->vertices[n] >= model->vertex_count))
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "vertex %lld of the contact is %lld, which is outside 0..%lld",
                             (long long)n, (long long)def->vertices[n],
                             (long long)model->vertex_count - 1);
    if (def->areas && !(def->areas[n] >= 0.0 && isfinite(def->areas[n])))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "area %lld of the contact is %g; it must be finite and >= 0 [m^2]",
                             (long long)n, def->areas[n]);
  }
  return THRUM_OK;
}

static thrum_status check_def(const thrum_model *model, const thrum_state *state,
                              const thrum_contact_def *def, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the contact's def was not made by thrum_default_contact_def");
  if (!model->basis || !model->vertices)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so it has nothing that could touch: precompute "
                           "it from a mesh");
  if (def->stiffness == 0.0 && !model->material)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no material to take a stiffness from: give one");
  const thrum_status counts = check_counts(def, error);
  return counts == THRUM_OK ? check_points(model, def, error) : counts;
}

static void fill_header(const thrum_model *model, const thrum_state *state,
                        const thrum_contact_def *def, thrum_contact *contact) {
  contact->magic = CONTACT_MAGIC;
  contact->rank = (int32_t)model->rank;
  contact->point_count = def->vertices ? def->vertex_count : model->vertex_count;
  contact->touch_max = def->touch_max > 0 ? def->touch_max : 2 * contact->point_count;
  contact->pull_max = def->pull_max;
  contact->sweeps_max = def->sweeps_max;
  contact->tolerance = def->tolerance;
  contact->state_bytes = thrum_state_kept_bytes(state);
  contact->fresh = 1;
  contact->bytes = bytes_of(contact);
}

thrum_status thrum_contact_size(const thrum_model *model, const thrum_state *state,
                                const thrum_contact_def *def, size_t *size, thrum_error *error) {
  thrum_contact_def whole = thrum_default_contact_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(check_def(model, state, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  thrum_contact header = {0};
  fill_header(model, state, def, &header);
  *size = (size_t)header.bytes;
  return THRUM_OK;
}

/* The box of the points: its middle and half sides; radius about the middle. */
static void fill_box(const thrum_model *model, thrum_contact *contact, double half[3]) {
  const thrum_contact_view view = thrum_contact_view_of(contact);
  for (int axis = 0; axis < 3; axis++) {
    double least = INFINITY, most = -INFINITY;
    for (int64_t n = 0; n < contact->point_count; n++) {
      const double x = model->vertices[3 * (int64_t)view.vertices[n] + axis];
      least = fmin(least, x);
      most = fmax(most, x);
    }
    contact->middle[axis] = 0.5 * (least + most);
    half[axis] = 0.5 * (most - least);
  }
  contact->radius = sqrt(thrum_dot3(half, half));
}

static void fill_extents(const thrum_model *model, thrum_contact *contact) {
  const thrum_contact_view view = thrum_contact_view_of(contact);
  const int64_t rank = contact->rank;
  for (int64_t n = 0; n < contact->point_count; n++) {
    const double *rows = model->basis + 3 * (int64_t)view.vertices[n] * rank;
    for (int64_t i = 0; i < rank; i++) {
      const double u[3] = {rows[i], rows[rank + i], rows[2 * rank + i]};
      view.extents[i] = fmax(view.extents[i], sqrt(thrum_dot3(u, u)));
    }
  }
}

static double default_stiffness(const thrum_model *model, double diagonal) {
  double young = 0.0;
  for (int64_t region = 0; region < model->region_count; region++)
    young = fmax(young, model->material[3 * region]);
  const double stiffness = diagonal > 0.0 ? 10.0 * young / diagonal : 10.0 * young;
  return fmin(stiffness, THRUM_CONTACT_STIFFNESS_MAX);
}

static void fill_points(const thrum_model *model, const thrum_contact_def *def,
                        thrum_contact *contact) {
  const thrum_contact_view view = thrum_contact_view_of(contact);
  for (int64_t n = 0; n < contact->point_count; n++)
    view.vertices[n] = def->vertices ? def->vertices[n] : (int32_t)n;
  double half[3];
  fill_box(model, contact, half);
  const double surface = 8.0 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]);
  for (int64_t n = 0; n < contact->point_count; n++)
    view.areas[n] = def->areas ? def->areas[n] : surface / (double)contact->point_count;
  fill_extents(model, contact);
  contact->diagonal = def->diagonal > 0.0
                          ? def->diagonal
                          : thrum_box3_diagonal(model->vertices, model->vertex_count);
  contact->springy = def->stiffness > 0.0;
  contact->stiffness =
      def->stiffness > 0.0 ? def->stiffness : default_stiffness(model, 2.0 * contact->radius);
}

thrum_status thrum_contact_init(void *memory, size_t memory_size, const thrum_model *model,
                                const thrum_state *state, const thrum_contact_def *def,
                                thrum_contact **contact, thrum_error *error) {
  thrum_contact_def whole = thrum_default_contact_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  size_t size;
  THRUM_TRY(thrum_contact_size(model, state, def, &size, error));
  if (!memory || !contact)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or contact is NULL");
  THRUM_TRY(thrum_alignment_check("contact", memory, memory_size, size, error));
  memset(memory, 0, size);
  fill_header(model, state, def, memory);
  fill_points(model, def, memory);
  *contact = memory;
  return THRUM_OK;
}

size_t thrum_contact_bytes(const thrum_contact *contact) {
  return contact ? (size_t)contact->bytes : 0;
}

double thrum_contact_stiffness(const thrum_contact *contact) {
  return contact ? contact->stiffness : 0.0;
}

thrum_status thrum_contact_check(const thrum_model *model, const thrum_state *state,
                                 const thrum_contact *contact, thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  if (!contact || contact->magic != CONTACT_MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact was not made by thrum_contact_init");
  if (contact->rank != state->rank || contact->state_bytes != thrum_state_kept_bytes(state))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the contact was made for a state of another model or def");
  return THRUM_OK;
}

void thrum_contact_reset(thrum_contact *contact) {
  if (!contact)
    return;
  const thrum_contact_view view = thrum_contact_view_of(contact);
  memset(view.pull_forces, 0, (size_t)contact->pull_max * 3 * sizeof(double));
  memset(view.pressing, 0, (size_t)contact->rank * sizeof(double));
  memset(contact->pressed, 0, sizeof contact->pressed);
  memset(contact->whirled, 0, sizeof contact->whirled);
  contact->touch_count = contact->row_count = contact->pull_count = 0;
  contact->flow = contact->stored = contact->lost = contact->impact = contact->owed = 0.0;
  contact->driven = contact->granted = contact->pulled = 0.0;
  contact->depth = contact->normal = 0.0;
  contact->steps = contact->redone = contact->declined = 0;
  contact->dropped = contact->sweeps = contact->impacts = contact->struck = 0;
  contact->begun = 0;
  contact->fresh = 1;
}

thrum_contact_report thrum_contact_report_get(const thrum_contact *contact) {
  thrum_contact_report report = {0};
  if (!contact)
    return report;

  // counters of all steps
  report.steps = contact->steps;
  report.redone = contact->redone;
  report.declined = contact->declined;
  report.dropped = contact->dropped;
  report.sweeps = contact->sweeps;
  report.impacts = contact->impacts;

  // the last step
  report.touching = (int32_t)contact->touch_count;
  report.struck = (int32_t)contact->struck;
  report.depth = contact->depth;
  report.normal = contact->normal;

  // energies since init
  report.stored = contact->stored + contact->owed;
  report.lost = contact->lost + contact->impact;
  report.driven = contact->driven;
  report.granted = contact->granted;
  report.pulled = contact->pulled;
  return report;
}

/* The stiffness of the spring of a touch, whose row is at its index or behind. */
static double stiffness_of(const thrum_contact *contact, const thrum_contact_view *view,
                           const thrum_touching *touch, int64_t index) {
  for (int64_t n = index; n < contact->row_count; n++) {
    const thrum_touching *row = &view->rows[n].touch;
    if (row->point == touch->point && row->obstacle == touch->obstacle && row->face == touch->face)
      return view->rows[n].stiffness;
  }
  return 0.0;
}

thrum_status thrum_contact_touch_get(thrum_contact *contact, int64_t index, thrum_touch *touch,
                                     thrum_error *error) {
  if (!contact || !touch || index < 0 || index >= contact->touch_count + contact->struck)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no touch %lld",
                           (long long)index);
  const thrum_contact_view view = thrum_contact_view_of(contact);
  const int64_t impact = index - contact->touch_count;
  const thrum_touching *found =
      impact < 0 ? view.touches + index : thrum_contact_impact_at(contact, &view, impact);
  *touch = (thrum_touch){
      .vertex = view.vertices[found->point], .obstacle = found->obstacle, .gap = found->gap};

  if (impact < 0)
    touch->stiffness = stiffness_of(contact, &view, found, index);

  // a touch has a force, an impact an impulse
  double *acts = impact < 0 ? touch->force : touch->impulse;
  for (int axis = 0; axis < 3; axis++) {
    acts[axis] = found->force * found->normal[axis] + found->friction[axis];
    touch->normal[axis] = found->normal[axis];
  }
  return THRUM_OK;
}

thrum_status thrum_contact_pull_force(thrum_contact *contact, int64_t index, double force[3],
                                      thrum_error *error) {
  if (!contact || !force || index < 0 || index >= contact->pull_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there was no pull %lld",
                           (long long)index);
  memcpy(force, thrum_contact_view_of(contact).pull_forces + 3 * index, 3 * sizeof(double));
  return THRUM_OK;
}
