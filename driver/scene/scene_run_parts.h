/* What a run of a scene holds: its bodies, what the file says of them, and what was found.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_PARTS_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_PARTS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/model/display_surface.h"
#include "driver/run/condensed_check.h"
#include "driver/run/run.h"
#include "driver/scene/scene_file_models.h"
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
  double thickness;      /* its smallest extent at rest, along its own axes or the mesh's [m] */
  double obstacle_depth; /* of its vertices in planes, spheres and rooms, the largest so far [m] */
  double least[3], most[3]; /* that box, in the mesh [m] */
  double *sphere_at; /* 3 each of the obstacles: of spheres, the centre in the axes of the mesh as
                        it was looked at last [m]; owned, NULL: none is looked at */
  double *middle_at; /* of a condensed body, 3 each of the bodies: the middle of each in the axes of
                        its mesh at the last row [m]; owned, NULL: none is looked at */
  double *surface;   /* scratch for both, 3 each of the vertices; owned */
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
  double met_time;         /* after the step in which surfaces met first; 0: none did [s] */
  int32_t met[2];          /* whose they were, as in a touch; -1: a step without contact */
  double near_share;       /* of the thickness that is missing between two after the first step */
  double near_distance;    /* between them then [m] */
  int32_t near[2];         /* which these are, as in a touch */
  bool has_hard_obstacles; /* that vertices touch, without a stiffness of their own */
  bool has_passing;        /* a body touches none, as it is condensed, where it would touch */
  double through_time;     /* at which something was in it first; 0: nothing was [s] */
  thrum_scene_overlap through; /* what */
  bool has_detail;             /* a body has a level of detail */
  scene_looks *looks;          /* of each of the models; owned */
  FILE *account;               /* where bodies touch each other */
  FILE *contact;               /* where something may touch */
  FILE *links;                 /* where there are links */
  thrum_scene_account first;   /* at the start */
  double began, seconds_read, seconds_find, seconds_output, seconds_total;
} scene_run;

#endif
