/* The full-order body of a model: what the model was made from. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_MODEL_MODEL_FEM_H
#define THRUM_PRECOMPUTE_MODEL_MODEL_FEM_H

#include "precompute/fem/fem_actuators.h"
#include "thrum/model.h"

typedef struct thrum_model_fem {
  thrum_mesh mesh; /* borrows the model's arrays; materials and laws are its own */
  thrum_fem fem;
  thrum_sparse stiffness, mass;    /* on the free components */
  thrum_actuator *actuators;       /* the model's, read again; NULL: none were asked for */
  struct thrum_fem_acting *acting; /* their levels, which the fem has */
  thrum_mass kind; /* the mass in which the model's basis is orthonormal; consistent without one */
} thrum_model_fem;

/* The model's mesh: its arrays are the model's, but for `materials` and `laws`, which
 * thrum_model_return_mesh frees alone. THRUM_MISSING when the model has no mesh. */
thrum_status thrum_model_borrow_mesh(const thrum_model *model, thrum_mesh *mesh,
                                     thrum_error *error);
void thrum_model_return_mesh(thrum_mesh *mesh); /* leaves it empty */

/* With the order of quadrature that the metadata of the model names. THRUM_MISSING when the model
 * has no mesh. The model must stay while the body is used. */
thrum_status thrum_model_fem_create(const thrum_model *model, thrum_model_fem *body,
                                    thrum_error *error);

/* The same without stiffness and mass, which stay empty, and with the law of the model: for forces
 * and strains alone. */
thrum_status thrum_model_fem_elements(const thrum_model *model, thrum_model_fem *body,
                                      thrum_error *error);

/* Reads the actuators of the model, which the body has at level 0 from then on: a gas acts at once.
 * Nothing where the model has none. */
thrum_status thrum_model_fem_actuate(const thrum_model *model, thrum_model_fem *body,
                                     thrum_error *error);
void thrum_model_fem_free(
    thrum_model_fem *body); /* leaves it empty; an empty (zeroed) one is fine */

#endif
