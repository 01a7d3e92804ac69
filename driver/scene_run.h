/* A run of a scene file: what it says as a scene, its files, and the loop over the steps.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_RUN_H
#define THRUM_DRIVER_SCENE_RUN_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/condensed_check.h"
#include "driver/display_surface.h"
#include "driver/run.h"
#include "driver/scene_file_models.h"
#include "platform/thread_team.h"
#include "thrum/scene.h"
#include "thrum/thrum.h"

/* The options of `thrum simulate SCENE.json` beside the file. */
typedef struct scene_request {
  const char *path, *output;
  double time, dt; /* 0: as the file says */
  int64_t threads;
  bool json, quiet;
} scene_request;

/* Where a number of coordinates comes from that "error" or "budget" asked for. */
typedef enum scene_found {
  SCENE_NOT_ASKED = 0,
  SCENE_TRIED,  /* by trial runs of this body */
  SCENE_SHARED, /* by those of another body that is the same */
  SCENE_CACHED  /* by those of an earlier run */
} scene_found;

typedef struct scene_finding {
  scene_found by;
  int64_t masters; /* 0: all coordinates are stepped */
  double error; /* of the shape over the trial; NaN: not known, as nothing moved or the run with all
                   coordinates failed; INFINITY: no number errs as little as was asked */
} scene_finding;

/* One body of the file, beside its figures and files in the driver_body of the same number. */
typedef struct scene_body_run {
  const scene_body_spec *spec;
  const thrum_model *model;    /* at its rank, as it is in its file */
  condensed_check check;       /* of a condensed body, as it is stepped near */
  double pace;                 /* its frequencies over those of the model in the file [1] */
  thrum_scene_body_def def;    /* as it was added; it has what follows */
  double *start;               /* q and p; owned */
  const double *given;         /* the same of a scene that is made again; NULL: the file says */
  int32_t *touched;            /* the vertices that "touch" names; owned, NULL: none */
  scene_finding finding;       /* of "error" and "budget" */
  simulate_request request;    /* of a run of it alone: loads in its axes, gravity first if any */
  thrum_model shown;           /* the model scaled in stiffness and put in place, for measures */
  double *material, *vertices; /* of that, and for frames */
  char folder[RUN_PATH_MAX + 80];
  char gravity[100];     /* as a load's text */
  double diagonal;       /* of its box at rest; 0: not looked at [m] */
  double obstacle_depth; /* of its vertices in planes, spheres and rooms, the largest so far [m] */
  double least[3], most[3]; /* that box, in the mesh [m] */
  double *sphere_at; /* 3 each of the obstacles: of spheres, the centre in the axes of the mesh as
                        it was looked at last [m]; owned, NULL: none is looked at */
  double *surface;   /* scratch for that, 3 each of the vertices; owned */
  double turn_share; /* of a free body of which the file does not say whether it is coupled: its
                        spin at the start over its lowest angular frequency [1] */
  bool coupled_by_default;
  double axes_before[9], turn_square; /* its axes after the last step, and the sum of squares of its
                                         spins [rad^2/s^2] */
  int64_t turn_steps;                 /* looked at */
  int32_t passed; /* 1-based obstacle, a sphere that went into or through the body; 0: none */
} scene_body_run;

/* Rows at which the mesh of a model is asked what it lacks: of each part of the run the one of the
 * largest shape. */
#define SCENE_LOOKS 8
typedef struct scene_look {
  double size;            /* |q|^2; 0: there is none yet */
  double rate;            /* of real times over those of the model in its file [1] */
  double acceleration[3]; /* that acts on all of the mass */
  double *q, *forces;     /* rank and 3 vertex_count */
} scene_look;
typedef struct scene_looks {
  double *memory; /* of all; owned, NULL: no body of this model is judged */
  scene_look items[SCENE_LOOKS];
} scene_looks;

typedef struct scene_run {
  const scene_request *request;
  scene_spec spec;
  scene_models models;
  thrum_scene *scene;
  thrum_thread_team *team;        /* NULL: one thread */
  base_motion_spec *base_motions; /* of the spec, read */
  int64_t base_motion_count;
  scene_body_run *bodies; /* of the spec's count */
  driver_run run;         /* its bodies are of the same count */
  int64_t steps;
  double dt;
  bool failed; /* the last step was made by some bodies only */
  run_folder folder;
  FILE *probes;
  double met_time;           /* after the step in which surfaces met first; 0: none did [s] */
  int32_t met[2];            /* whose they were, as in a touch; -1: a step without contact */
  bool has_hard_obstacles;   /* that vertices touch, without a stiffness of their own */
  bool has_detail;           /* a body has a level of detail */
  scene_looks *looks;        /* of each of the models; owned */
  FILE *account;             /* where bodies touch each other */
  FILE *contact;             /* where something may touch */
  FILE *links;               /* where there are links */
  thrum_scene_account first; /* at the start */
  double began, seconds_read, seconds_find, seconds_output, seconds_total;
} scene_run;

/* scene_run_build.c: loads the models and makes the scene; the latter alone, where there are bodies
 * and models. */
thrum_status scene_run_build(scene_run *run, thrum_error *error);
thrum_status scene_run_make(scene_run *run, thrum_error *error);

/* scene_run.c: reads the file of the request, and frees what a run holds, whatever came of it. */
thrum_status scene_run_read(scene_run *run, thrum_error *error);
void scene_run_close(scene_run *run);

/* scene_run.c: the same of what scene_run_make makes and the bodies. */
void scene_run_unmake(scene_run *run);

/* scene_run_forces.c: what acts on the mesh of a body now, after so many steps, in the axes and the
 * material of its model as it is in the file: forces (3 vertex_count) [N], and what acts on all of
 * its mass. */
thrum_status scene_run_forces(const scene_run *run, int32_t number, int64_t step, double *forces,
                              double acceleration[3], thrum_error *error);

/* scene_run_judge.c: why a body on which others act cannot be judged with its scene, NULL: it can;
 * takes in a row; and makes the scene again with richer models, after the run, for the estimates of
 * its bodies. */
const char *scene_run_why_not_judged(const scene_run *run, int32_t number);
thrum_status scene_run_judge_note(scene_run *run, int64_t step, thrum_error *error);
thrum_status scene_run_judge(scene_run *run, thrum_error *error);
void scene_run_judge_close(scene_run *run);

/* scene_run_refuse.c: passes a status of the engine on; a failure becomes a message about one key
 * of a record, or about the record (key NULL). */
thrum_status scene_run_pass(const scene_run *run, const config_record *at, const char *key,
                            thrum_status status, const thrum_error *detail);
thrum_status scene_run_no_memory(thrum_error *error);

/* scene_run_world.c: what acts on all bodies, before they are added (base motions) and after. */
thrum_status scene_run_base_motions(scene_run *run, thrum_error *error);
bool scene_run_collides(const scene_run *run);
thrum_contact_pairs_def scene_run_collisions_def(const scene_run *run);

/* Does a body touch others or itself, and does any? */
bool scene_run_body_meets(const scene_run *run, const scene_body_run *body);
bool scene_run_bodies_meet(const scene_run *run);

/* Are there obstacles that are touched by their faces? */
bool scene_run_has_solids(const scene_run *run);

/* Do bodies touch each other or themselves, or obstacles by their faces? */
bool scene_run_touches(const scene_run *run);
thrum_status scene_run_collisions(const scene_run *run);

/* Refuses a body that begins inside an obstacle or another body; says what a body is in, by its
 * name where it has one. */
#define SCENE_OVERLAP_NAME 120
void scene_run_name_overlap(const scene_run *run, const thrum_scene_overlap *overlap,
                            char in[SCENE_OVERLAP_NAME]);
thrum_status scene_run_check_start(const scene_run *run, thrum_error *error);
thrum_status scene_run_wind(const scene_run *run, thrum_scene *scene);
thrum_status scene_run_obstacles(const scene_run *run, thrum_scene *scene);

/* The way of an obstacle with a path: *count times [s] and as many places, of a position [m] and a
 * rotation w, x, y, z each, with places between where it turns further than the short way. The
 * caller frees both. */
thrum_status scene_run_way(const scene_run *run, const scene_obstacle_spec *spec, double **times,
                           double **places, int64_t *count, thrum_error *error);

/* scene_run_solid.c: adds an obstacle that is touched by its faces. */
thrum_status scene_run_add_solid(const scene_run *run, const scene_obstacle_spec *spec,
                                 thrum_scene *scene);

/* scene_run_solid.c: which of the file's obstacles is the scene's solid, or other obstacle, of this
 * number. */
int32_t scene_run_obstacle_index(const scene_run *run, bool solid, int32_t number);
thrum_status scene_run_add_base_motion(const base_motion_spec *base_motion, thrum_scene *scene,
                                       thrum_error *error);
thrum_status scene_run_probes(scene_run *run);

/* scene_run_link.c: ties what the file links; opens links.npy, adds a row to it and ends it; then
 * what its links did, for scene.json, and printed as lines of the table. */
thrum_status scene_run_links(scene_run *run, thrum_error *error);
thrum_status scene_run_open_links(scene_run *run, thrum_error *error);
thrum_status scene_run_record_links(scene_run *run, thrum_error *error);
thrum_status scene_run_end_links(scene_run *run, thrum_error *error);
bool scene_run_is_linked(const scene_run *run, int32_t number);
cJSON *scene_run_links_json(const scene_run *run);
void scene_run_print_links(const scene_run *run);

/* scene_run_output.c: adds the forces at the end and the energies of the run of touches of
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

/* scene_run_account.c: energy and momentum of bodies that touch each other, and what else takes
 * energy. */
scene_run_losses scene_run_losses_get(const scene_run *run);
bool scene_run_has_account(const scene_run *run);
thrum_status scene_run_open_account(scene_run *run, thrum_error *error);
thrum_status scene_run_record_account(scene_run *run, int64_t step, double time,
                                      thrum_error *error);

/* scene_run_contact.c: the force of each body and obstacle on each other one. */
bool scene_run_has_contact(const scene_run *run);
thrum_status scene_run_open_contact(scene_run *run, thrum_error *error);
thrum_status scene_run_record_contact(scene_run *run, int64_t step, double time,
                                      thrum_error *error);

/* scene_run_account.c: what contact did, for scene.json. */
cJSON *scene_run_collisions_json(const scene_run *run);

/* Warns of the joint that was open the widest, beyond what links promise. */
void scene_run_warn_of_joints(const scene_run *run);
bool scene_run_joints_opened(const scene_run *run);

/* "done", or what flags the run: that of its bodies, else "surfaces_crossed", else "joints_open".
 */
const char *scene_run_status(const scene_run *run);

/* scene_run_crossed.c: makes a run ready to look for bodies that go through each other or through
 * obstacles; notes how deep they are after a step; and says whether any did, with warnings. */
thrum_status scene_run_look_for_crossings(scene_run *run, thrum_error *error);
void scene_run_note_depths(scene_run *run);
bool scene_run_have_crossed(const scene_run *run);
void scene_run_warn_of_depth(const scene_run *run);

/* scene_run_sphere.c: the same of spheres, which bodies touch by their vertices alone. */
thrum_status scene_run_open_spheres(scene_run *run, thrum_error *error);
void scene_run_note_spheres(scene_run *run);

/* scene_run_couple.c: is a body coupled, by the file or, where that does not say, as it begins to
 * turn so fast that it matters (needs its spin in body->def)? Looks at how fast others turn after a
 * step, with warnings of them; prints which are coupled without being asked for. */
bool scene_run_couples(const scene_run *run, scene_body_run *body);
void scene_run_note_turns(scene_run *run);
void scene_run_warn_of_turns(const scene_run *run);
void scene_run_print_coupled(const scene_run *run);

/* scene_run_idle.c: warns of what the file says and what has no effect, and of a step that is
 * coarse against what moves. */
void scene_run_warn_of_idle(const scene_run *run);

/* scene_run_detail.c: condenses the bodies that ask for an error or a budget, and sets the levels
 * of detail. */
thrum_status scene_run_find_detail(scene_run *run, thrum_error *error);

/* scene_run_detail.c: warns of condensed bodies that pass through what is there. */
void scene_run_warn_of_passing(const scene_run *run);

/* scene_run_trial.c: one body in a scene of its own, with all that acts on it but other bodies. Its
 * hash is that of all that its motion depends on. scene_trial_close frees, whatever came back. */
typedef struct scene_trial {
  const scene_run *run;
  int32_t number; /* of the body */
  thrum_scene *scene;
  int64_t steps;
  double *rows; /* shapes with all coordinates; owned */
  double size;  /* sum of their squares; 0: it stays at rest, or its run fails */
} scene_trial;
thrum_status scene_trial_open(const scene_run *run, int32_t number, scene_trial *trial,
                              thrum_error *error);
void scene_trial_close(scene_trial *trial);
uint64_t scene_trial_hash(const scene_run *run, int32_t number);

/* The time that a trial simulates [s]: the first seconds of the scene, or all of it. */
double scene_trial_seconds(const scene_run *run);

/* The error of the shape with so many masters, over the first seconds; INFINITY where the run fails
 * or errs by more than `most`, which ends it. */
thrum_status scene_trial_run(scene_trial *trial, int64_t masters, double most, double *found,
                             thrum_error *error);

/* scene_run_stepper.c: the scene as a stepper, whose bodies are those of the file. */
driver_stepper scene_run_stepper(scene_run *run);

/* scene_run_output.c: the folder, the files of the bodies and the probes; and the runs of the
 * bodies completed. */
thrum_status scene_run_open(scene_run *run, thrum_error *error);
thrum_status scene_run_record_probes(scene_run *run, int64_t step, double time, thrum_error *error);
thrum_status scene_run_end(scene_run *run, thrum_error *error);

/* scene_run_output.c: the same without the judgement of bases, which has not come back. */
thrum_status scene_run_end_unjudged(scene_run *run, thrum_error *error);

/* scene_run_report.c */
cJSON *scene_run_json(const scene_run *run);
void scene_run_table(const scene_run *run);

/* scene_run.c: a scene from its file to its folder; an exit code. */
int scene_run_request(const scene_request *request);

#endif
