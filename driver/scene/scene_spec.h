/* The contents of a scene file (docs/scenes.md), before any model is loaded.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_SPEC_H
#define THRUM_DRIVER_SCENE_SCENE_SPEC_H

#include "config/options.h"
#include "driver/make/mesh_model.h"
#include "driver/spec/base_motion_spec.h"
#include "driver/spec/basis_asked.h"
#include "driver/spec/load_spec.h"
#include "driver/spec/start_spec.h"
#include "thrum/fields.h"
#include "thrum/thrum.h"

#define SCENE_DEGREE 0.017453292519943295 /* [rad] */

/* The rows of thrum/fields.h that are keys of scene files: members of a spec, their defaults, and
 * what copies them from `spec` to `def`. */
#define SCENE_MEMBER(where, ...) SCENE_MEMBER_##where(where, __VA_ARGS__)
#define SCENE_MEMBER_BOTH(...) THRUM_MEMBER(__VA_ARGS__)
#define SCENE_MEMBER_CODE(...)
#define SCENE_VALUE(where, ...) SCENE_VALUE_##where(where, __VA_ARGS__)
#define SCENE_VALUE_BOTH(...) THRUM_VALUE(__VA_ARGS__)
#define SCENE_VALUE_CODE(...)
#define SCENE_COPY(where, kind, name, ...) SCENE_COPY_##where(name)
#define SCENE_COPY_BOTH(name) memcpy(&def->name, &spec->name, sizeof def->name);
#define SCENE_COPY_CODE(name)

/* Settings that a scene and each of its bodies have; those of the scene are the bodies' defaults.
 */
typedef struct scene_settings {
  config_record at;
  thrum_state_def def; /* its dt is the scene's */
} scene_settings;

typedef struct scene_material_spec {
  config_record at;
  thrum_material material; /* NaN where the mesh's own stays */
  thrum_law law;
  config_texts regions;  /* texts of region_material.h */
  thrum_plastic plastic; /* of a model of points as well */
} scene_material_spec;

/* The level of detail of a body: how few coordinates are stepped while it is far or still. */
typedef struct scene_detail_spec {
  config_record at;
  int64_t condense;
  double beyond, still, jump; /* [m], [m/s], [m]; 0: not said */
} scene_detail_spec;

typedef struct scene_body_spec {
  scene_settings settings;
  const char *name;  /* "body" and its number where none is given, in */
  char *kept_name;   /* owned */
  const char *model; /* a file, a mesh or a name */
  config_texts fix;  /* of a mesh, */
  int order;         /* and of its tets, as of thrum_mesh_read_options */
  const char
      *surface; /* shown in place of the mesh's own (driver/export/render_mesh.h); NULL: that */
  scene_material_spec material;
  THRUM_BODY_FIELDS(SCENE_MEMBER)
  double error;  /* that finds `condense`; 0: none asked for */
  double budget; /* of a step, that finds `condense` [s]; 0: none asked for */
  scene_detail_spec detail;
  config_texts start, loads, actuate;
  const char *touch; /* "surface", "none", or a group */
} scene_body_spec;

/* How bodies touch each other. */
typedef struct scene_collisions_spec {
  config_record at;
  THRUM_PAIRS_FIELDS(SCENE_MEMBER)
} scene_collisions_spec;

typedef struct scene_wind_spec {
  config_record at;
  double velocity[3]; /* [m/s] */
  THRUM_WIND_FIELDS(SCENE_MEMBER)
} scene_wind_spec;

typedef enum scene_shape {
  SCENE_PLANE = 0,
  SCENE_SPHERE = 1,
  SCENE_BOX = 2,
  SCENE_CYLINDER = 3,
  SCENE_CAPSULE = 4,
  SCENE_HEIGHT_FIELD = 5,
  SCENE_MESH = 6
} scene_shape;

/* The names of the shapes, in this order; ends with NULL. */
extern const char *const scene_shape_names[];

/* Where an obstacle is at a time. */
typedef struct scene_waypoint_spec {
  config_record at;
  double time, centre[3], rotation[4];
  double axis[3], angle; /* of the rotation [degrees]; angle NaN: it was given as a quaternion */
} scene_waypoint_spec;

/* The quaternion of the rotation by `angle` [degrees] about `axis`; false for an axis of no length.
 */
bool scene_axis_angle(const double axis[3], double angle, double rotation[4]);

typedef struct scene_obstacle_spec {
  config_record at;
  const char *name;
  scene_shape shape;
  THRUM_OBSTACLE_FIELDS(SCENE_MEMBER)
  double size[3], rotation[4], height;
  const char *path;         /* of a mesh's file */
  double scale;             /* of the lengths in it */
  const json_node *heights; /* rows of numbers */
  double spacing;
  config_list way; /* scene_waypoint_spec */
  float colour[3];
} scene_obstacle_spec;

/* Where the end of a link is at a time. */
typedef struct scene_link_waypoint_spec {
  config_record at;
  double time, place[3]; /* [s], [m] */
} scene_link_waypoint_spec;

/* Two places that are tied (thrum_scene_link_def). */
typedef struct scene_link_spec {
  config_record at;
  const char *name;
  int kind; /* thrum_link_kind */
  const char *body, *target;
  const char *other, *other_target; /* NULL: the world */
  THRUM_LINK_FIELDS(SCENE_MEMBER)
  config_list way;  /* scene_link_waypoint_spec */
  const char *path; /* of a file with the same */
} scene_link_spec;

/* The names of the kinds, in the order of thrum_link_kind; ends with NULL. */
extern const char *const scene_link_names[];

typedef struct scene_probe_spec {
  config_record at;
  const char *name; /* as of a body */
  char *kept_name;
  const char *body;
  const char *target;
} scene_probe_spec;

#define SCENE_PLOTS_MAX 8

typedef struct scene_outputs_spec {
  config_record at;
  int64_t record_every;
  double frames_rate;   /* a second of simulated time; 0: see frames_every */
  int64_t frames_every; /* steps; 0 with rate 0: no frames */
  bool stress, monitor;
  basis_asked basis; /* how bodies are judged, of those that are monitored */
  bool plots;        /* unless it is not said, and there are more than SCENE_PLOTS_MAX bodies */
} scene_outputs_spec;

typedef struct scene_spec {
  scene_settings settings;
  const char *title; /* NULL: none */
  double time;       /* [s] */
  double gravity[3]; /* [m/s^2] */
  double eye[3];     /* that distances are from at the start [m] */
  double eye_velocity[3];
  config_texts base_motion;
  scene_wind_spec wind; /* at.node NULL: none */
  bool collide;         /* bodies touch each other; unless it is said, where one is free */
  scene_collisions_spec collisions;
  config_list bodies;    /* scene_body_spec */
  config_list obstacles; /* scene_obstacle_spec */
  config_list probes;    /* scene_probe_spec */
  config_list links;     /* scene_link_spec */
  scene_outputs_spec outputs;
  config_file file;
} scene_spec;

/* The keys of a scene file; ends with a nameless one. */
extern const config_option scene_keys[];

/* Where a body stands, for warnings of it: "scene.json:7: body 'block'". Returns `place`. */
#define SCENE_PLACE_MAX 300
const char *scene_body_place(const scene_spec *spec, const scene_body_spec *body,
                             char place[SCENE_PLACE_MAX]);

/* Can this be the name of a body's folder or of a column? Letters, digits, '-', '_' and '.', so
 * that it leads nowhere else. */
bool scene_spec_is_name(const char *text);

/* Reads the file at `path` (scene_read_text: these bytes, `name` in messages) and checks what can
 * be checked without models. `path` and `error` must stay as long as the spec. scene_spec_free
 * frees, whatever came back. */
thrum_status scene_spec_read(const char *path, scene_spec *spec, thrum_error *error);
thrum_status scene_spec_read_text(const char *name, const char *bytes, size_t length,
                                  scene_spec *spec, thrum_error *error);
void scene_spec_free(scene_spec *spec);

/* Items of the lists. */
static inline scene_body_spec *scene_bodies(const scene_spec *spec) {
  return spec->bodies.items;
}
static inline scene_obstacle_spec *scene_obstacles(const scene_spec *spec) {
  return spec->obstacles.items;
}
/* Is the obstacle touched by its faces, edges and corners (thrum_scene_solid_def)? Planes, spheres
 * and rooms are touched by vertices of bodies alone. */
static inline bool scene_obstacle_is_solid(const scene_obstacle_spec *obstacle) {
  return obstacle->shape > SCENE_BOX || (obstacle->shape == SCENE_BOX && !obstacle->inside);
}
static inline scene_link_spec *scene_links(const scene_spec *spec) {
  return spec->links.items;
}
static inline scene_probe_spec *scene_probes(const scene_spec *spec) {
  return spec->probes.items;
}

#endif
