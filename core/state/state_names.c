/* Names of the choices in a state's def, from the lists of thrum/state.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "thrum/state.h"

#define NAME_CASE(name, value, text)                                                               \
  case value:                                                                                      \
    return text;

#define NAME_OF(value, LIST)                                                                       \
  switch ((int)(value)) {                                                                          \
    LIST(NAME_CASE)                                                                                \
  default:                                                                                         \
    return NULL;                                                                                   \
  }

const char *thrum_integrator_name(thrum_integrator integrator) {
  NAME_OF(integrator, THRUM_INTEGRATOR_LIST)
}

const char *thrum_damping_form_name(thrum_damping_form form) {
  NAME_OF(form, THRUM_DAMPING_FORM_LIST)
}

const char *thrum_split_rule_name(thrum_split_rule rule) {
  NAME_OF(rule, THRUM_SPLIT_RULE_LIST)
}

const char *thrum_split_form_name(thrum_split_form form) {
  NAME_OF(form, THRUM_SPLIT_FORM_LIST)
}

const char *thrum_implicit_solver_name(thrum_implicit_solver solver) {
  NAME_OF(solver, THRUM_IMPLICIT_SOLVER_LIST)
}

const char *thrum_scheme_name(thrum_scheme scheme) {
  NAME_OF(scheme, THRUM_SCHEME_LIST)
}

/* Value of `name` among `count` names, -1: it is none of them. */
static int find(const char *name, const char *const *names, int count) {
  for (int n = 0; name && n < count; n++)
    if (strcmp(name, names[n]) == 0)
      return n;
  return -1;
}

static thrum_status refuse(thrum_error *error, const char *what, const char *name,
                           const char *choices) {
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "'%.40s' is no %s; there are%s",
                         name ? name : "", what, choices);
}

// the values of each list count from 0 in its order
#define NAME_TEXT(name, value, text) text,
#define NAME_JOINED(name, value, text) " " text
#define FROM_NAME(name, to, type, what, LIST)                                                      \
  do {                                                                                             \
    static const char *const names[] = {LIST(NAME_TEXT)};                                          \
    const int found = find(name, names, (int)(sizeof names / sizeof names[0]));                    \
    if (found < 0)                                                                                 \
      return refuse(error, what, name, LIST(NAME_JOINED));                                         \
    if (to)                                                                                        \
      *to = (type)found;                                                                           \
    return THRUM_OK;                                                                               \
  } while (0)

thrum_status thrum_integrator_from_name(const char *name, thrum_integrator *integrator,
                                        thrum_error *error) {
  FROM_NAME(name, integrator, thrum_integrator, "integrator", THRUM_INTEGRATOR_LIST);
}

thrum_status thrum_damping_form_from_name(const char *name, thrum_damping_form *form,
                                          thrum_error *error) {
  FROM_NAME(name, form, thrum_damping_form, "form of damping", THRUM_DAMPING_FORM_LIST);
}

thrum_status thrum_split_form_from_name(const char *name, thrum_split_form *form,
                                        thrum_error *error) {
  FROM_NAME(name, form, thrum_split_form, "form of the split", THRUM_SPLIT_FORM_LIST);
}

thrum_status thrum_implicit_solver_from_name(const char *name, thrum_implicit_solver *solver,
                                             thrum_error *error) {
  FROM_NAME(name, solver, thrum_implicit_solver, "solver", THRUM_IMPLICIT_SOLVER_LIST);
}
