/* A body that steps alone with its obstacles and pulls: a group of one (contact_pairs_step.c),
 * which has no rows between bodies and so needs no room for them. SPDX-License-Identifier:
 * Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "contact/contact_pairs_step.h"
#include "contact/contact_step.h"

/* What a group of one body needs. */
typedef struct alone {
  thrum_contact_pairs pairs;
  thrum_pairs_history history;
  thrum_contact_member member;
  thrum_contact_run body;
  thrum_contact contact;
  thrum_contact_whole whole;
  thrum_turn turn;
  int64_t firsts[2]; /* vertices and nodes of its skin: none */
  int32_t known[2];
  double impact_room[8 * (8 + 3)];
  thrum_pairs_run run;
} alone;

static void make(const thrum_model *model, thrum_state *state, thrum_contact *contact,
                 const thrum_contact_environment *environment, alone *of) {
  memset(of, 0, sizeof *of);
  of->pairs.member_max = 1;
  of->pairs.sweeps_max = contact->sweeps_max;
  of->pairs.tolerance = contact->tolerance;
  of->member = (thrum_contact_member){
      .model = model, .state = state, .contact = contact, .environment = environment};
  of->run = (thrum_pairs_run){.pairs = &of->pairs,
                              .history = &of->history,
                              .members = &of->member,
                              .count = 1,
                              .view = {.runs = &of->body,
                                       .contacts = &of->contact,
                                       .wholes = &of->whole,
                                       .turns = &of->turn,
                                       .first_vertex = of->firsts,
                                       .first_node = of->firsts,
                                       .place_known = of->known,
                                       .sphere_known = of->known,
                                       .triangle_known = of->known,
                                       .taken = of->known,
                                       .impact_room = of->impact_room}};
}

thrum_status thrum_contact_begin(const thrum_model *model, thrum_state *state,
                                 thrum_contact *contact,
                                 const thrum_contact_environment *environment, thrum_error *error) {
  alone of;
  THRUM_TRY(thrum_contact_check(model, state, contact, error));
  if (environment && environment->inertia)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "rotation and shape are stepped together by thrum_contact_step alone");
  const thrum_contact before = *contact;
  make(model, state, contact, environment, &of);
  const thrum_status status = thrum_pairs_begin_group(&of.run, error);
  contact->sweeps += of.history.sweeps;
  if (status == THRUM_OK) {
    contact->begun = 1;
    return status;
  }

  // a failure leaves the body where it was, on the way that it had
  *contact = before;
  if (of.body.contact != NULL)
    thrum_contact_put_back_whole(environment, &of.whole);
  return status;
}

thrum_status thrum_contact_step(const thrum_model *model, thrum_state *state,
                                thrum_contact *contact,
                                const thrum_contact_environment *environment, thrum_error *error) {
  alone of;
  THRUM_TRY(thrum_contact_check(model, state, contact, error));
  const thrum_contact before = *contact;
  make(model, state, contact, environment, &of);
  const thrum_status status = thrum_pairs_step_group(&of.run, NULL, error);
  if (status < 0)
    *contact = before;
  else
    contact->sweeps += of.history.sweeps;
  return status;
}
