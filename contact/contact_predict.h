/* Prediction of the end of a step without contact (docs/contact.md): the integrators of design 5 to
 * 7, linear about the present state with the stiffness at rest, dq_i = s_i [h p_i + h^2/2 (f_i -
 * R_i(q))], s_i = 1 / (1 + h/2 d_i + h^2/4 w_i^2), without the last term for explicit modes and
 * with beta_N for 1/4 with Newmark, with beta_i and its stored momentum with Fox-Goodwin, with
 * lambda_i and nu_i with energy. Private to contact.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PREDICT_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PREDICT_H

#include "contact/contact_private.h"

/* Fills q, p, weights and unloaded of the step under environment->load. */
thrum_status thrum_contact_predict(thrum_contact_run *run, thrum_error *error);

#endif
