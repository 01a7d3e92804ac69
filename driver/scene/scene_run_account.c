/* The account of a scene whose bodies touch or are linked to each other: energy and momentum of all
 * of them, row by row in account.csv, and what contact did in scene.json. SPDX-License-Identifier:
 * Apache-2.0 */
#include "driver/scene/scene_run_account.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>

#include "config/message.h"
#include "driver/record/run_entries.h"
#include "driver/scene/scene_run_crossed.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"

bool scene_run_has_account(const scene_run *run) {
  return scene_run_touches(run) || run->spec.links.count > 0;
}

thrum_status scene_run_open_account(scene_run *run, thrum_error *error) {
  THRUM_TRY(thrum_scene_account_get(run->scene, &run->first, error));
  if (!scene_run_has_account(run))
    return THRUM_OK;
  errno = 0;
  run->account = run_folder_create(&run->folder, SCENE_ACCOUNT);
  const bool done =
      run->account != NULL &&
      fputs("step,time_s,kinetic_j,potential_j,gravity_j,contact_j,total_j,lost_j,"
            "px_kg_m_s,py_kg_m_s,pz_kg_m_s,lx_kg_m2_s,ly_kg_m2_s,lz_kg_m2_s,touching,distance_m,"
            "depth_m,obstacles_lost_j,dissipated_j,links_j,links_lost_j,links_driven_j\n",
            run->account) >= 0;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_ACCOUNT, error);
}

scene_run_losses scene_run_losses_get(const scene_run *run) {
  scene_run_losses sum = {0};
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    thrum_scene_body_info of;
    if (thrum_scene_body(run->scene, n, &of, NULL) < 0)
      continue;

    // forces and energies of obstacles on this body, then what its damping took
    sum.obstacles.touching += of.contact.touching;
    sum.obstacles.impacts += of.contact.impacts;
    sum.obstacles.normal += of.contact.normal;
    sum.obstacles.depth = fmax(sum.obstacles.depth, of.contact.depth);
    sum.obstacles.stored += of.contact.stored;
    sum.obstacles.lost += of.contact.lost;
    sum.obstacles.driven += of.contact.driven;
    sum.obstacles.granted += of.contact.granted;
    sum.dissipated += of.dissipated;
  }

  // what links took, and what their ends in the world did
  for (int32_t n = 0; n < thrum_scene_link_count(run->scene); n++) {
    thrum_scene_link of;
    if (thrum_scene_link_get(run->scene, n, &of, NULL) < 0)
      continue;
    sum.links.lost += of.report.lost;
    sum.links.driven += of.report.driven;
  }
  return sum;
}

thrum_status scene_run_record_account(scene_run *run, int64_t step, double time,
                                      thrum_error *error) {
  thrum_scene_account a;
  if (run->account == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_scene_account_get(run->scene, &a, error));
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  const scene_run_losses losses = scene_run_losses_get(run);
  errno = 0;
  const bool done =
      fprintf(run->account,
              "%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,"
              "%.17g,%.17g,%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n",
              step, time, a.kinetic, a.potential, a.gravity, a.contact, a.total, of.lost,
              a.momentum[0], a.momentum[1], a.momentum[2], a.angular_momentum[0],
              a.angular_momentum[1], a.angular_momentum[2], of.touching, of.distance, of.depth,
              losses.obstacles.lost, losses.dissipated, a.links, losses.links.lost,
              losses.links.driven) > 0;
  return done ? THRUM_OK : run_folder_write_failed(&run->folder, SCENE_ACCOUNT, error);
}

static void add_account(cJSON *object, const char *name, const thrum_scene_account *account) {
  cJSON *made = cJSON_AddObjectToObject(object, name);
  json_number(made, "kinetic_j", account->kinetic);
  json_number(made, "potential_j", account->potential);
  json_number(made, "gravity_j", account->gravity);
  json_number(made, "contact_j", account->contact);
  json_number(made, "links_j", account->links);
  json_number(made, "total_j", account->total);
  json_numbers(made, "momentum_kg_m_s", account->momentum, 3);
  json_numbers(made, "angular_momentum_kg_m2_s", account->angular_momentum, 3);
}

void scene_run_add_touches(cJSON *object, const thrum_contact_report *of) {
  json_number(object, "touching", of->touching);
  json_number(object, "impacts", (double)of->impacts);
  json_number(object, "normal_n", of->normal);
  json_number(object, "depth_m", of->depth);
  json_number(object, "stored_j", of->stored);
  json_number(object, "lost_j", of->lost);
  json_number(object, "driven_j", of->driven);
  json_number(object, "granted_j", of->granted);
}

cJSON *scene_run_collisions_json(const scene_run *run) {
  thrum_scene_account last;
  if (!scene_run_touches(run))
    return cJSON_CreateNull();
  const thrum_contact_pairs_report of = thrum_scene_collisions(run->scene);
  cJSON *object = cJSON_CreateObject();

  // how near bodies are at the end, and how deep they ever were below the thickness
  json_number(object, "touching", (double)of.touching);
  json_number(object, "impacts", (double)of.impacts);
  json_number(object, "normal_n", of.normal);
  json_number(object, "distance_m", of.distance);
  json_number(object, "depth_m", of.depth);
  json_number(object, "deepest_m", of.deepest);
  json_number(object, "deepest_of_thickness", of.deepest_share);

  // energies, and steps that contact made difficult
  json_number(object, "stored_j", of.stored);
  json_number(object, "lost_j", of.lost);
  json_number(object, "driven_j", of.driven);
  json_number(object, "redone_steps", (double)of.redone);
  json_number(object, "declined_steps", (double)of.declined);
  json_number(object, "dropped_touches", (double)of.dropped);
  json_number(object, "sweeps", (double)of.sweeps);

  // what else changes the total: obstacles and damping
  const scene_run_losses losses = scene_run_losses_get(run);
  scene_run_add_touches(cJSON_AddObjectToObject(object, "obstacles"), &losses.obstacles);
  json_number(object, "dissipated_j", losses.dissipated);

  // all bodies together at both ends of the run
  add_account(object, "first", &run->first);
  if (thrum_scene_account_get(run->scene, &last, NULL) >= 0)
    add_account(object, "last", &last);
  return object;
}

run_outcome scene_run_outcome(const scene_run *run) {
  const run_outcome outcome = driver_run_outcome(&run->run);
  if (outcome != RUN_DONE)
    return outcome;
  return scene_run_have_crossed(run)    ? RUN_SURFACES_CROSSED
         : scene_run_has_declined(run)  ? RUN_CONTACT_GIVEN_UP
         : scene_run_joints_opened(run) ? RUN_JOINTS_OPEN
                                        : outcome;
}
