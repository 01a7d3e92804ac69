/* The parts of a scene, and what its files offer each other; private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PRIVATE_H
#define THRUM_SCENE_SCENE_PRIVATE_H

#include <stdatomic.h>
#include <stdbool.h>

#include "thrum/floating_frame.h"
#include "thrum/scene.h"

/* A model as bodies step it: scaled, cut down, without a mesh. Shared by all bodies that want the
 * same; freed with the last of them. */
typedef struct scene_model {
  const thrum_model *from, *model; /* the same where nothing had to be changed */
  void *memory;                    /* of the latter; NULL then */
  void *unscaled;                  /* where a scaled condensed model has how its slaves follow */
  int64_t rank;
  bool condensed; /* the other coordinates follow */
  thrum_model_scaling by;
  thrum_inertia *inertia; /* of bodies whose rotation is coupled to their shape; NULL: none yet */
  int32_t users;
  struct scene_model *next;
} scene_model;

/* The part of a body that touches or is pulled: the rows of U' of these points, and the contact
 * that reads them. The points that touch come first, then a slot for each pull. */
typedef struct scene_touch {
  thrum_model model;   /* that the body steps, with these points as its mesh */
  double *rest, *rows; /* count x 3 [m], count x 3 x rank; in model */
  int64_t *vertices;   /* count: of the body's model; -1: a pull's place that is not in use */
  int32_t *places;     /* of the points that touch, one at least: 0, 1, ... */
  int64_t count;
  double material[3];
  bool idle;              /* no point touches: there are pulls alone */
  thrum_contact *contact; /* its own aligned block */
  size_t bytes;
} scene_touch;

/* The surface of a model as bodies touch each other with it; shared by all bodies that want the
 * same; freed with the last of them. */
typedef struct scene_skin {
  const scene_model *of;
  int32_t *triangles; /* triangle_count x 3 vertices of the model as it was given */
  int64_t triangle_count;
  void *memory;
  thrum_skin *skin; /* in memory */
  int32_t users;
  struct scene_skin *next;
} scene_skin;

/* An obstacle with a surface. */
typedef struct scene_solid {
  double *vertices;
  int32_t *triangles;
  int64_t vertex_count, triangle_count;
  double position[3], rotation[4], velocity[3];
  double *times, *places; /* path_count, path_count x 7; NULL: it goes by its velocity */
  int64_t path_count;
  double friction, restitution;
  bool open; /* it has no inside */
  void *memory;
  thrum_skin *skin; /* in memory */
  thrum_contact_solid moving;
  thrum_skin_bound bound; /* in the step to come */
} scene_solid;

typedef struct scene_link {
  int32_t body, other;          /* other -1: the world */
  thrum_scene_link_side *sides; /* 2; owned, so that they stay where they are */
  double *rows[2];              /* those of the sides; owned, NULL of the world */
  double place[3];              /* of the first side as it was added [m] */
  double end[3];                /* of the second, the world's where its path begins [m] */
  double *times, *path;         /* path_count, path_count x 3 */
  int64_t path_count;
  double until;  /* [s] */
  int64_t since; /* step before which it was added */
  double began;  /* energy in the spring as it was added [J] */
  bool released;
  bool holds;                 /* in this step */
  thrum_contact_solid moving; /* the world's end in this step */
  thrum_link tie;
} scene_link;

/* Contact between bodies: its block, and lists with a place for each body of the scene. */
typedef struct scene_pairs {
  thrum_contact_pairs *contact; /* `workers` aligned blocks; NULL: none may touch */
  thrum_contact_pairs_def def;
  size_t size;                   /* of a block; the first holds the touches of all */
  thrum_contact_member *members; /* member_room a worker */
  int64_t member_room;
  int32_t *firsts;             /* the first body of each group */
  thrum_contact_group *groups; /* what their steps did */
  int32_t group_count;
  atomic_int next; /* the group that is stepped next */
  thrum_contact_environment *environments;
  thrum_pull *pulls; /* THRUM_SCENE_PULLS a body */
  thrum_link *ties;  /* tie_room a worker */
  int64_t tie_room;
  thrum_skin_bound *bounds;
  int32_t *order, *group;
  int32_t ordered; /* bodies in `order`, which keeps that of the step before */
} scene_pairs;

/* A pull in one of a body's slots. */
typedef struct scene_pull {
  bool used;
  int64_t vertex;
  double target[3], stiffness, damping;
} scene_pull;

/* Force and torque on a free body as a whole, in the world. */
typedef struct scene_wrench {
  double force[3];  /* [N] */
  double torque[3]; /* about the centre of mass [N m] */
} scene_wrench;

/* The counts of a state's report, which a scene keeps for as long as the body lives. */
typedef struct scene_counts {
  int64_t fallback_steps;
  double dissipated, plastic_work;
} scene_counts;

/* A body with a level of detail, as its updates have seen it. */
typedef struct scene_seen {
  double last_time;   /* of the last update [s]; negative: there was none */
  double quiet_since; /* when it moved too fast, or something acted on it, last [s] */
  int64_t last_steps; /* of the scene at the last update */
  uint64_t stirred;   /* of the scene at the last update */
  int64_t far;        /* 1: it was far */
  thrum_scene_detail_report report;
} scene_seen;

/* The level of detail of a body. */
typedef struct scene_detail {
  thrum_scene_detail def;
  int64_t near;          /* masters of the body as it is stepped near; 0: none, all are stepped */
  double *peaks;         /* model's rank: largest length of a basis vector at a vertex; owned */
  double *last;          /* model's rank: coordinates at the last update; owned by peaks */
  double middle[3];      /* of the box around the body, in the axes and lengths of its model, */
  double half[3];        /* and half its sides */
  scene_model *followed; /* as it is stepped far, kept from one change to the next */
  scene_model *whole;    /* as it is stepped near */
  scene_seen seen;       /* what snapshots keep of it, with `last` */
} scene_detail;

/* One body. Vectors are of its model's full rank r, the first `rank` entries are in use. */
typedef struct scene_body {
  char name[THRUM_SCENE_NAME_MAX];
  const thrum_model *model;
  scene_model *derived;
  thrum_placement placement, here; /* at the start, and now */
  double k, g, mass;               /* U' = k U, q of the model = g q', U'^T M' = mass U^T M */
  float colour[3];
  thrum_state_def def;
  thrum_state *state; /* its own aligned block */
  double *vectors;    /* of all that follow, each r long */
  double *start_q, *start_p, *force, *inertia, *before, *q, *p;
  double *answered;      /* of a condensed body: the load that its slaves answer to, */
  double *pulled;        /* that of the pulls of the last step, which they answer to as well, */
  double *middle;        /* masters in the middle of the step to come, extrapolated, */
  double *slopes;        /* and slaves x masters, how they follow; room for any number of masters */
  bool q_known, p_known; /* q, p are those of the present step */
  thrum_load *courses;   /* load_count; the first is gravity. As given, */
  thrum_load *now;       /* and counted from the scene's origin */
  double *directions;    /* load_count x r */
  int64_t load_count;
  bool free;
  double *parts; /* of a free body, load_count x 9 x r: world axis b of a load along body axis a */
  double *moments;    /* load_count x 9: arm along a times force along b [N m] */
  double *resultants; /* load_count x 3 [N] */
  thrum_translation way;
  thrum_rigid_frame rigid_frame;
  double *inertia_work; /* of a free body whose rotation is coupled to its shape; NULL: it is not */
  double start_momentum[3]; /* [kg m^2/s] */
  double start_velocity[3];
  int32_t *surface; /* surface_count vertices of the triangles, ascending */
  double *areas;    /* surface_count x 3, outward, of the scaled body [m^2] */
  double *stretch;  /* surface_count, |rows of U|^2 */
  int64_t surface_count;
  int32_t *touching;   /* touch_count vertices that may touch, */
  double *touch_areas; /* and what each stands for [m^2] */
  bool areas_known;    /* false: they are shared evenly */
  int64_t touch_count;
  double touch_stiffness;
  scene_touch *touch;      /* NULL: nothing to touch and no pull */
  scene_touch *touch_next; /* while obstacles are added */
  bool collides;           /* it may touch other bodies, where the scene has them touch */
  bool self_contact;       /* it may touch itself */
  int32_t *triangles;      /* triangle_count x 3, of a body that may; else NULL */
  int64_t triangle_count;
  scene_skin *skin;     /* NULL: it touches no body */
  int32_t tied;         /* links that it has or had */
  int32_t group;        /* of bodies that are near each other in this step; -1: none */
  thrum_status stepped; /* of the step of its group */
  scene_pull pulls[THRUM_SCENE_PULLS];
  scene_wrench wrench; /* of the step to come */
  thrum_status status; /* < 0: stopped */
  double work_load, work_base;
  scene_detail *detail;      /* NULL: none */
  scene_counts before_state; /* of states that changes of parameters have replaced */
} scene_body;

typedef struct scene_base_motion {
  const thrum_base_motion *motion; /* or NULL, and */
  double amplitude[3];
  thrum_load course, now;
} scene_base_motion;

typedef struct scene_probe {
  char name[THRUM_SCENE_NAME_MAX];
  int32_t body;
  double rest[3];
  double *rows; /* 3 x r, the mean of its vertices' rows of U */
} scene_probe;

/* Bodies of one model that step side by side on one worker, in thrum_scene's `side`. */
typedef struct scene_chunk {
  const scene_model *model;
  int32_t from, count;
  thrum_error error;
} scene_chunk;

struct thrum_scene {
  double dt, origin; /* time at step origin_step, from which loads are counted [s] */
  int64_t steps, origin_step;
  double gravity[3];
  double eye[3];       /* that distances of bodies are from [m] */
  double wind[3], air; /* air: 1/2 density drag [kg/m^3], 0: none */
  thrum_obstacle *obstacles, *obstacle_starts;
  int32_t obstacle_count;
  bool collides; /* bodies touch each other; solids are touched whatever this is */
  scene_pairs pairs;
  scene_skin *skins;
  scene_solid *solids;
  int32_t solid_count;
  scene_link *links;
  int32_t link_count;
  uint64_t revision; /* of all but what steps change */
  uint64_t stirred;  /* counts calls that change what acts on bodies */
  scene_body **bodies;
  int32_t body_count;
  scene_model *models;
  scene_base_motion *base_motions;
  int32_t base_motion_count;
  scene_probe *probes;
  int32_t probe_count;
  thrum_state **side; /* body_count: states of one model, for the step */
  thrum_status *side_status;
  int32_t *side_body;
  thrum_error *side_error; /* body_count: of a body's own part of a step */
  scene_chunk *chunks;     /* body_count */
  int32_t workers;         /* at least 1 */
  thrum_scene_run run;     /* NULL: one worker */
  void *run_context;
  void *workspace; /* workers blocks, of thrum_batch_step, for the largest model of two bodies */
  size_t workspace_size;
  void *scratch; /* workers blocks, which the states borrow */
  size_t scratch_size;
};

/* scene_memory.c: memory of a scene. */

/* Where models, states and the blocks of workers begin. */
#define SCENE_ALIGNMENT 64

static inline size_t scene_round_up(size_t size) {
  return (size + SCENE_ALIGNMENT - 1) / SCENE_ALIGNMENT * SCENE_ALIGNMENT;
}

/* A block on a boundary that models and states want; NULL without memory. free() frees. */
void *scene_aligned(size_t size);

/* Room for `count` items of `size` in the array that the pointer at `array` points to; false
 * without memory, the array as it was. */
bool scene_grow(void *array, int64_t count, size_t size);

/* scene_access.c: bodies of a scene by their numbers. */

/* THRUM_INVALID_ARGUMENT for a number that names no body. */
thrum_status scene_body_at(const thrum_scene *scene, int32_t number, scene_body **body,
                           thrum_error *error);

/* THRUM_MISSING for a body without a basis, THRUM_INVALID_ARGUMENT for a vertex that it has not. */
thrum_status scene_vertex_check(const scene_body *body, int64_t vertex, thrum_error *error);

/* scene_condensed.c: bodies whose stiff coordinates follow the others. */

/* Coordinates of a body that show it, the first entries of q and p: those stepped, or all. */
static inline int64_t scene_shown(const scene_body *body) {
  return body->derived->condensed ? body->model->rank : body->derived->rank;
}

/* w'^2 over w^2 of the scaled body. */
double scene_stiffening(const scene_body *body);

/* The slaves of body->q, and of body->p if `p`, from the masters there. THRUM_NOT_FINITE where one
 * overflows. */
thrum_status scene_condensed_read(scene_body *body, bool p, thrum_error *error);

/* body->force, on all coordinates, becomes that on the masters; body->inertia too if `base`.
 * THRUM_BAD_VALUE, and nothing changes, where the force is not finite. */
thrum_status scene_condensed_load(const scene_body *body, bool base, thrum_error *error);

/* body->middle from the masters before and after the last step. */
void scene_condensed_extrapolate(const scene_body *body);

/* The points that touch as they follow now, pulls apart. */
thrum_status scene_condensed_touch(scene_body *body, thrum_error *error);

/* The body's slaves answer to the pulls of the step that was made. */
void scene_condensed_answer_pulls(scene_body *body);

/* pull->give: how far the slaves of a condensed body give way at a vertex. */
void scene_condensed_pull(const scene_body *body, int64_t vertex, thrum_pull *pull);

/* scene_detail.c: bodies that are stepped with fewer coordinates while they are far or still. */

void scene_detail_free(thrum_scene *scene, scene_body *body);

/* A body that starts again has not been looked at. */
void scene_detail_restart(scene_body *body);

/* A body that steps fewer coordinates steps all of them again, for a start; it may jump. */
thrum_status scene_detail_wake(thrum_scene *scene, int32_t number, thrum_error *error);

/* Bound of the displacement of any vertex by coordinates from `first` on of the scaled body, less
 * `other` (NULL: none) [m]; of its speed for velocities. */
double scene_detail_bound(const scene_body *body, int64_t first, const double *q,
                          const double *other);

/* scene_still.c: whether a body is still, for its level of detail. */

/* Bound of the speed of a free body's vertices by its motion as a whole [m/s]; 0 of others. */
double scene_rigid_speed(const scene_body *body);

/* Bound of the speed that what acts on the body in the `steps` to come will give to a vertex, over
 * the load that it stands under [m/s]; INFINITY where it is pulled or something that moves may
 * touch it. q: its shape. body->force and body->inertia are used up. */
double scene_coming_speed(const thrum_scene *scene, scene_body *body, const double *q,
                          int64_t steps);

/* scene_change.c: changes between two steps. */

/* thrum_scene_set_condensed of a body that may have a level of detail. */
thrum_status scene_condense(thrum_scene *scene, int32_t number, int64_t masters,
                            thrum_error *error);

/* scene_placement.c: between the axes of a body and the world. */

thrum_status scene_placement_make(const double position[3], const double rotation[4],
                                  thrum_placement *placement, thrum_error *error);
void scene_to_world(const thrum_placement *placement, const double in_body[3], double out[3]);
void scene_to_body(const thrum_placement *placement, const double in_world[3], double out[3]);

/* scene_model.c: the models that bodies step, each shared by all bodies that want the same. */

/* Finds or makes the model of a body; scene_model_drop undoes. */
thrum_status scene_model_take(thrum_scene *scene, const thrum_model *from, int64_t rank,
                              bool condensed, const thrum_model_scaling *by, scene_model **taken,
                              thrum_error *error);
void scene_model_drop(thrum_scene *scene, scene_model *model);

/* Finds or makes the inertia of a model. */
thrum_status scene_model_inertia(scene_model *model, thrum_error *error);

/* Room for stepping bodies side by side, after bodies or models have changed. */
thrum_status scene_make_room(thrum_scene *scene, int32_t bodies, thrum_error *error);

/* scene_body.c: bodies of a scene as they are made. */

/* A state of a def, which borrows scratch, at a model, with q and p (rank) in it;
 * thrum_state_destroy frees. */
thrum_status scene_state_make(thrum_scene *scene, const thrum_model *model,
                              const thrum_state_def *def, const double *q, const double *p,
                              thrum_state **state, thrum_error *error);

/* Scratch and workspace of a worker; the scratch is lent to a body's state. */
void scene_lend(const thrum_scene *scene, const scene_body *body, int32_t worker);
void *scene_workspace(const thrum_scene *scene, int32_t worker);

/* Room for the slopes of a condensed body, where there is none yet. */
thrum_status scene_slopes_make(scene_body *body, thrum_error *error);

/* scene_base_motion.c: base motions under the bodies of a scene. */

/* THRUM_MISSING for a body that base motions cannot accelerate. */
thrum_status scene_base_motion_check(const scene_body *body, thrum_error *error);

/* scene_loads.c: loads of bodies over time. */

/* Reduces gravity, the first load of every body. */
thrum_status scene_gravity_reduce(scene_body *body, const double gravity[3], thrum_error *error);

/* Counts all time courses from the scene's origin, after one was added or dt has changed. */
void scene_loads_retime(thrum_scene *scene);

/* The mean load of the step that lies `ahead` of the one to come into body->force, by the
 * directions of the last step; mean acceleration of the base, set where there are base motions. */
void scene_loads_ahead(const thrum_scene *scene, scene_body *body, int64_t ahead, double mean[3]);

/* The mean load of the step to come into body->force; what it does to a free body as a whole. */
void scene_loads_sum(const thrum_scene *scene, scene_body *body, scene_wrench *wrench);

/* scene_reduced_load.c: loads that are given on the coordinates of a body. */

/* Whether this reduced load may be added to the body. */
thrum_status scene_reduced_check(const scene_body *body, const thrum_scene_load *load,
                                 thrum_error *error);

/* scene_parts.c: loads on a body that rotates. */

/* Reduces load `index` of a free body in every direction that the body may rotate to. */
thrum_status scene_parts_make(scene_body *body, const thrum_scene_load *load, int64_t index,
                              thrum_error *error);

/* The directions of its loads as it stands now, and what they do to it as a whole. */
void scene_parts_sum(const thrum_scene *scene, scene_body *body, int64_t step,
                     scene_wrench *wrench);

/* scene_surface.c: the surface of a body, for wind and contact. */

/* Areas of the def's triangles, and the vertices that may touch. */
thrum_status scene_surface_make(const thrum_scene_body_def *def, scene_body *body,
                                thrum_error *error);

/* scene_free_body.c: how a free body moves as a whole. */

/* Makes a body free where its def says so, with the mass and inertia of its model. */
thrum_status scene_free_make(const thrum_scene_body_def *def, scene_body *body, thrum_error *error);

/* One step as a whole, or of its translation alone: THRUM_NOT_FINITE, and nothing moves, where it
 * would leave the finite numbers. */
thrum_status scene_free_step(scene_body *body, const scene_wrench *wrench, double dt,
                             thrum_error *error);
thrum_status scene_free_move(scene_body *body, const double force[3], double dt,
                             thrum_error *error);

/* Where a free body is now; back to its start. */
void scene_free_place(scene_body *body);
void scene_free_reset(scene_body *body);

/* scene_coupled.c: free bodies whose rotation and shape act on each other. */

/* Makes ready what a body needs to step a model by a def as a coupled one. */
thrum_status scene_coupled_fit(scene_body *body, scene_model *derived, const thrum_state_def *def,
                               thrum_error *error);

/* The frame's inertia and internal momentum at the start of the body. */
thrum_status scene_coupled_start(scene_body *body, thrum_error *error);

/* One step of state, frame and centre of mass. */
thrum_status scene_coupled_step(scene_body *body, thrum_error *error);

/* Adds to the moments of the loads on the body at rest those on the shape in body->q. */
void scene_coupled_moments(const thrum_scene *scene, const scene_body *body, int64_t step,
                           double moments[9]);

/* scene_free_body.c: velocity of the frame at an arm from the centre, both in the world. */
void scene_free_velocity(const scene_body *body, const double arm[3], double velocity[3]);

/* The centre of mass in the world. */
void scene_free_centre(const scene_body *body, double centre[3]);

/* scene_contact.c: contact and pulls of a body. */

/* Makes the data with which a body touches obstacles and is pulled, for `state` of `derived`; NULL
 * where there is neither. */
thrum_status scene_touch_make(const thrum_scene *scene, const scene_body *body,
                              const scene_model *derived, const thrum_state *state,
                              scene_touch **touch, thrum_error *error);
void scene_touch_free(scene_touch *touch);

/* Frees the contact of a body that nothing touches and nothing pulls. */
void scene_touch_trim(const thrum_scene *scene, scene_body *body);

/* Does the body step with its contact, and not side by side with others of its model? */
bool scene_steps_alone(const scene_body *body);

/* Fills in what surrounds a body in the step to come; `pulls` is room for those in use. */
void scene_environment(const thrum_scene *scene, scene_body *body,
                       thrum_pull pulls[THRUM_SCENE_PULLS], thrum_contact_environment *environment);

/* A step of a body with contact and pulls. */
thrum_status scene_touch_step(const thrum_scene *scene, scene_body *body, thrum_error *error);

/* scene_obstacle.c: obstacles of a scene as they move. */

/* After a step, and back to the start. */
void scene_obstacles_move(thrum_scene *scene);
void scene_obstacles_reset(thrum_scene *scene);

/* scene_solid.c: obstacles with a surface. */

/* Where all solids go in the step to come. */
void scene_solids_move(thrum_scene *scene);

void scene_solids_free(thrum_scene *scene);

/* scene_solid_shape.c: the surface of a def, into vertices and triangles that the caller frees. */
thrum_status scene_solid_surface(const thrum_scene_solid_def *def, scene_solid *solid,
                                 thrum_error *error);

/* scene_pairs.c: bodies that touch each other. */

/* Equips the bodies for the touches that there are now, and takes what none of them needs. */
thrum_status scene_pairs_equip(thrum_scene *scene, thrum_error *error);

/* Keeps the triangles of a def for the body's skin. */
thrum_status scene_triangles_keep(const thrum_scene_body_def *def, scene_body *body,
                                  thrum_error *error);

/* May the body, as a body of `derived`, touch others? */
bool scene_collides(const thrum_scene *scene, const scene_body *body, const scene_model *derived);

/* Finds or makes the skin of a body of `derived`, NULL where it touches none; scene_skin_drop
 * undoes (NULL does nothing). */
thrum_status scene_skin_take(thrum_scene *scene, const scene_body *body, const scene_model *derived,
                             scene_skin **taken, thrum_error *error);
void scene_skin_drop(thrum_scene *scene, scene_skin *skin);

/* Room for all bodies; `extra` (may be NULL) comes with extra_skin, or gets it. */
thrum_status scene_pairs_room(thrum_scene *scene, const scene_body *extra,
                              const scene_skin *extra_skin, thrum_error *error);
void scene_pairs_free(thrum_scene *scene);

/* Groups the bodies that are near each other; loads are known. */
void scene_pairs_find(thrum_scene *scene);

/* Room for `workers` that step groups at once. */
thrum_status scene_pairs_share(thrum_scene *scene, int32_t workers, thrum_error *error);

/* Steps the bodies of the next group on a worker; each has its own status in `stepped`. Returns the
 * first of them. */
int32_t scene_pairs_step(thrum_scene *scene, int32_t worker, thrum_error *error);

/* Books what the groups did, after all of them have stepped. */
void scene_pairs_gather(thrum_scene *scene);

/* scene_link.c: links between bodies and with the world. */

/* Finds which links hold in the step to come, and where their ends in the world go. */
void scene_links_begin(thrum_scene *scene);

/* Puts the links of a group into `room`, and their ends in the world behind its `count` members.
 * After the step scene_links_keep takes back what it did. */
thrum_contact_links scene_links_gather(thrum_scene *scene, int32_t group,
                                       thrum_contact_member *members, int64_t *count,
                                       thrum_link *room);
void scene_links_keep(thrum_scene *scene, int32_t group, const thrum_contact_links *links);

/* Does a joint hold the two bodies together? They do not touch then. */
bool scene_links_join(const thrum_scene *scene, int32_t a, int32_t b);

void scene_links_reset(thrum_scene *scene);
void scene_links_free(thrum_scene *scene);

/* scene_wind.c: drag of the air on a body. */

/* Adds the drag of the step to come to body->force, and to the wrench. */
thrum_status scene_wind_add(const thrum_scene *scene, scene_body *body, scene_wrench *wrench,
                            thrum_error *error);

/* scene_query.c: the present coordinates and points of a body. */

/* Makes body->q, and body->p if `p`, those of the present step. */
thrum_status scene_body_read(scene_body *body, bool p, thrum_error *error);

/* The counts of the body since its start, over all its states. */
scene_counts scene_body_counts(const scene_body *body);

/* A point of a body, rest position and three rows of U, in the world; body->q and, for a velocity
 * (which may be NULL), body->p are read. */
void scene_point(const scene_body *body, const double rest[3], const double *rows,
                 double position[3], double velocity[3]);

#endif
