/* The account of a scene whose bodies touch or are linked to each other: energy and momentum of all
 * of them, row by row in account.csv, and what contact did in scene.json.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_ACCOUNT_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_ACCOUNT_H

#include "driver/scene/scene_run_parts.h"

/* Adds the forces at the end and the energies of the run of touches of
 * obstacles. */
void scene_run_add_touches(cJSON *object, const thrum_contact_report *of);

/* The touches and energies of obstacles, and the dissipation, of all bodies together in the run so
 * far. */
typedef struct scene_run_losses {
  thrum_contact_report obstacles; /* the sums over the bodies of their touches, forces and energies,
                                     and the largest depth; the counts of steps and sweeps stay 0 */
  double dissipated;              /* by damping [J] */
  thrum_link_report links;        /* of all links: what they lost and what drove them */
} scene_run_losses;

/* Energy and momentum of bodies that touch each other, and what else takes
 * energy. */
scene_run_losses scene_run_losses_get(const scene_run *run);
bool scene_run_has_account(const scene_run *run);
thrum_status scene_run_open_account(scene_run *run, thrum_error *error);
thrum_status scene_run_record_account(scene_run *run, int64_t step, double time,
                                      thrum_error *error);

/* What contact did, for scene.json. */
cJSON *scene_run_collisions_json(const scene_run *run);

/* "done", or what flags the run: that of its bodies, else "surfaces_crossed",
 * "contact_given_up" or "joints_open".
 */
run_outcome scene_run_outcome(const scene_run *run);

#endif
