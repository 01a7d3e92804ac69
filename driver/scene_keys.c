/* The keys of a scene file: one table for the reader, the messages and the schema.
 *
 * A new key is one line here and one in docs/scenes.md. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "driver/scene_spec.h"
#include "driver/scene_values.h"
#include "driver/simulate_options.h"
#include "thrum/thrum.h"

/* --- what holds without a key ------------------------------------------------------------------
 */

static void begin_body(void *item, const void *in) {
  const scene_spec *scene = in;
  scene_body_spec *body = item;
  *body = (scene_body_spec){
      .settings = {.def = scene->settings.def},
      .material = {.material = {NAN, NAN, NAN}},
      .rotation = {1, 0, 0, 0},
      .scale = 1,
      .stiffness = 1,
      .density = 1,
      .colour = {0.75f, 0.75f, 0.75f},
      .touch = "surface",
  };
}

static void begin_obstacle(void *item, const void *in) {
  (void)in;
  scene_obstacle_spec *obstacle = item;
  *obstacle = (scene_obstacle_spec){
      .normal = {0, 0, 1},
      .rotation = {1, 0, 0, 0},
      .friction = 0.5,
      .restitution = 0.5,
      .colour = {0.5f, 0.5f, 0.5f},
  };
}

/* --- choices -----------------------------------------------------------------------------------
 */

static void choose_integrator(void *to, int index) {
  ((scene_settings *)to)->def.integrator = (thrum_integrator)index;
}

static void choose_damping_form(void *to, int index) {
  ((scene_settings *)to)->def.damping_form = (thrum_damping_form)index;
}

static void choose_split_form(void *to, int index) {
  ((scene_settings *)to)->def.split_form = (thrum_split_form)index;
}

static void choose_shape(void *to, int index) {
  ((scene_obstacle_spec *)to)->shape = (scene_shape)index;
}

static const char *const shapes[] = {"plane", "sphere", "box", NULL};

/* --- tables ------------------------------------------------------------------------------------
 */

#define AT(record, member) .field = offsetof(record, member)
#define POSITIVE .above = true, .most = INFINITY
#define NOT_NEGATIVE .most = INFINITY

#define NUMBER_SCHEMA "{\"type\":\"number\"}"
#define PAIR_SCHEMA "{\"type\":\"array\",\"items\":" NUMBER_SCHEMA ",\"minItems\":2,\"maxItems\":2}"
#define ROTATION_SCHEMA                                                                            \
  "{\"anyOf\":[{\"type\":\"array\",\"items\":" NUMBER_SCHEMA ",\"minItems\":4,\"maxItems\":4},"    \
  "{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"axis\",\"angle\"],"         \
  "\"properties\":{\"axis\":{\"type\":\"array\",\"items\":" NUMBER_SCHEMA                          \
  ",\"minItems\":3,\"maxItems\":3},\"angle\":" NUMBER_SCHEMA "}}]}"
#define COLOUR_SCHEMA                                                                              \
  "{\"anyOf\":[{\"type\":\"string\",\"pattern\":\"^#[0-9a-fA-F]{6}$\"},{\"type\":\"array\","       \
  "\"items\":{\"type\":\"number\",\"minimum\":0,\"maximum\":1},\"minItems\":3,\"maxItems\":3}]}"

/* Of the scene and of each body. */
#define SETTINGS_KEYS                                                                              \
  {.name = "integrator",                                                                           \
   .kind = CONFIG_KEY_CHOICE,                                                                      \
   .names = simulate_integrators,                                                                  \
   .choose = choose_integrator,                                                                    \
   .fallback = "imexv",                                                                            \
   .about = "what steps a body"},                                                                  \
      {.name = "damping",                                                                          \
       .kind = CONFIG_KEY_OWN,                                                                     \
       .take = scene_take_damping,                                                                 \
       .schema = "{\"anyOf\":[" NUMBER_SCHEMA "," PAIR_SCHEMA "]}",                                \
       .unit = "1/s, s",                                                                           \
       .fallback = "0",                                                                            \
       .about = "Rayleigh damping: A of the mass, or [A, B], B of the stiffness"},                 \
      {.name = "damping_form",                                                                     \
       .kind = CONFIG_KEY_CHOICE,                                                                  \
       .names = simulate_damping_forms,                                                            \
       .choose = choose_damping_form,                                                              \
       .fallback = "rest",                                                                         \
       .about = "of the stiffness at rest or of the present one"},                                 \
      {.name = "split",                                                                            \
       .kind = CONFIG_KEY_OWN,                                                                     \
       .take = scene_take_split,                                                                   \
       .schema = "{\"anyOf\":[{\"enum\":[\"cfl\",\"sampling\"]},{\"type\":\"integer\","            \
                 "\"minimum\":0}]}",                                                               \
       .fallback = "cfl",                                                                          \
       .about = "imexv: which modes are explicit; a number: the lowest so many"},                  \
      {.name = "safety",                                                                           \
       .kind = CONFIG_KEY_NUMBER,                                                                  \
       AT(scene_settings, def.split_safety),                                                       \
       .above = true,                                                                              \
       .most = 1,                                                                                  \
       .fallback = "0.5",                                                                          \
       .about = "imexv: c of cfl, dt omega <= 2 c"},                                               \
      {.name = "split_form",                                                                       \
       .kind = CONFIG_KEY_CHOICE,                                                                  \
       .names = simulate_split_forms,                                                              \
       .choose = choose_split_form,                                                                \
       .fallback = "component",                                                                    \
       .about = "imexv: how the energy is split"},                                                 \
      {.name = "adaptive",                                                                         \
       .kind = CONFIG_KEY_OWN,                                                                     \
       .take = scene_take_adaptive,                                                                \
       .schema = "{\"type\":\"boolean\"}",                                                         \
       .fallback = "true",                                                                         \
       .about = "imexv: watch stability and energy, and adapt to them"},                           \
      {.name = "fallback",                                                                         \
       .kind = CONFIG_KEY_OWN,                                                                     \
       .take = scene_take_fallback,                                                                \
       .schema = "{\"type\":\"boolean\"}",                                                         \
       .fallback = "true",                                                                         \
       .about = "what follows when a step cannot be solved; false: the run ends"},                 \
      {.name = "newmark",                                                                          \
       .kind = CONFIG_KEY_OWN,                                                                     \
       .take = scene_take_newmark,                                                                 \
       .schema = PAIR_SCHEMA,                                                                      \
       .fallback = "[0.25, 0.5]",                                                                  \
       .about = "newmark: beta >= 0 and gamma in [0, 1]"},                                         \
      {.name = "tolerance",                                                                        \
       .kind = CONFIG_KEY_NUMBER,                                                                  \
       AT(scene_settings, def.tolerance),                                                          \
       .above = true,                                                                              \
       .most = 0.01,                                                                               \
       .fallback = "1e-10",                                                                        \
       .about = "of implicit solves, relative"},                                                   \
  {                                                                                                \
    .name = "iterations", .kind = CONFIG_KEY_OWN, .take = scene_take_iterations,                   \
    .schema = "{\"type\":\"integer\",\"minimum\":1,\"maximum\":1000000}", .fallback = "50",        \
    .about = "of one implicit solve, at most"                                                      \
  }

#define COLOUR_KEY(record, grey)                                                                   \
  {                                                                                                \
    .name = "colour", .kind = CONFIG_KEY_OWN, .take = scene_take_colour, AT(record, colour),       \
    .schema = COLOUR_SCHEMA, .fallback = grey,                                                     \
    .about = "for those who look: \"#rrggbb\", or red, green, blue in [0, 1]"                      \
  }

#define ROTATION_KEY(record, what)                                                                 \
  {                                                                                                \
    .name = "rotation", .kind = CONFIG_KEY_OWN, .take = scene_take_rotation, AT(record, rotation), \
    .schema = ROTATION_SCHEMA, .unit = "degrees", .fallback = "none",                              \
    .about = what ": {\"axis\": [X,Y,Z], \"angle\": DEGREES}, or a quaternion [W,X,Y,Z]"           \
  }

#define OF_MATTER .least = 1e-30, .most = 1e30 /* as of precompute */

static const config_key material_keys[] = {
    {.name = "young",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_material_spec, material.young),
     OF_MATTER,
     .unit = "Pa",
     .fallback = "the mesh's",
     .about = "Young's modulus"},
    {.name = "poisson",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_material_spec, material.poisson),
     .least = -1,
     .most = 0.5,
     .above = true,
     .below = true,
     .fallback = "the mesh's",
     .about = "Poisson's ratio"},
    {.name = "density",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_material_spec, material.density),
     OF_MATTER,
     .unit = "kg/m^3",
     .fallback = "the mesh's",
     .about = "density"},
    {.name = NULL},
};

static const config_key body_keys[] = {
    {.name = "name",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_body_spec, name),
     .fallback = "\"body\" and its number",
     .about = "names its folder: letters, digits, '-', '_' and '.'"},
    {.name = "model",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_body_spec, model),
     .needed = true,
     .about = "a model file, a mesh, or beam, basket, bridge, horse, tower or heart"},
    {.name = "fix",
     .kind = CONFIG_KEY_TEXTS,
     AT(scene_body_spec, fix),
     .fallback = "nothing",
     .about = "what is held of a mesh, as --fix of precompute"},
    {.name = "surface",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_body_spec, surface),
     .fallback = "the mesh's own",
     .about = "shown in its place: a file of embed, or an .obj or .stl in metres"},
    {.name = "material",
     .kind = CONFIG_KEY_OBJECT,
     AT(scene_body_spec, material),
     .keys = material_keys,
     .about = "of a mesh, in place of its own"},
    {.name = "position",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_body_spec, position),
     .unit = "m",
     .fallback = "[0, 0, 0]",
     .about = "where the model's origin is"},
    ROTATION_KEY(scene_body_spec, "about the model's origin"),
    {.name = "scale",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_body_spec, scale),
     POSITIVE,
     .fallback = "1",
     .about = "factor of all lengths, exact"},
    {.name = "stiffness",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_body_spec, stiffness),
     POSITIVE,
     .fallback = "1",
     .about = "factor of Young's modulus, exact"},
    {.name = "density",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_body_spec, density),
     POSITIVE,
     .fallback = "1",
     .about = "factor of the density, exact"},
    {.name = "rank",
     .kind = CONFIG_KEY_COUNT,
     AT(scene_body_spec, rank),
     .least = 1,
     .most = THRUM_RANK_MAX,
     .fallback = "all of the model",
     .about = "step the lowest so many coordinates only"},
    COLOUR_KEY(scene_body_spec, "\"#bfbfbf\""),
    {.name = "free",
     .kind = CONFIG_KEY_BOOL,
     AT(scene_body_spec, free),
     .fallback = "false",
     .about = "the body may move and turn as a whole; of a model that nothing holds"},
    {.name = "velocity",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_body_spec, velocity),
     .unit = "m/s",
     .fallback = "[0, 0, 0]",
     .about = "of a free body at the start"},
    {.name = "spin",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_body_spec, spin),
     .unit = "degrees/s",
     .fallback = "[0, 0, 0]",
     .about = "angular velocity of a free body at the start, in world axes"},
    {.name = "start",
     .kind = CONFIG_KEY_TEXTS,
     AT(scene_body_spec, start),
     .fallback = "at rest",
     .about = "as --start of simulate; several add up"},
    {.name = "loads",
     .kind = CONFIG_KEY_TEXTS,
     AT(scene_body_spec, loads),
     .fallback = "none",
     .about = "loads over time, as --load of simulate, in world axes"},
    {.name = "touch",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_body_spec, touch),
     .fallback = "\"surface\"",
     .about = "what may touch obstacles: \"surface\", \"none\", or a group of vertices"},
    {.name = "touch_stiffness",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_body_spec, touch_stiffness),
     POSITIVE,
     .unit = "N/m^3",
     .fallback = "of the material",
     .about = "pressure per depth where obstacles say nothing"},
    SETTINGS_KEYS,
    {.name = NULL},
};

static const config_key wind_keys[] = {
    {.name = "velocity",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_wind_spec, velocity),
     .needed = true,
     .unit = "m/s",
     .about = "where the air goes, and how fast"},
    {.name = "density",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_wind_spec, density),
     POSITIVE,
     .unit = "kg/m^3",
     .fallback = "1.2",
     .about = "of the air"},
    {.name = "drag",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_wind_spec, drag),
     NOT_NEGATIVE,
     .fallback = "1",
     .about = "drag coefficient C_d of the windward surface"},
    {.name = NULL},
};

static const config_key obstacle_keys[] = {
    {.name = "name",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_obstacle_spec, name),
     .about = "for those who look"},
    {.name = "shape",
     .kind = CONFIG_KEY_CHOICE,
     .names = shapes,
     .choose = choose_shape,
     .needed = true,
     .about = "plane, sphere or box"},
    {.name = "centre",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_obstacle_spec, centre),
     .unit = "m",
     .fallback = "[0, 0, 0]",
     .about = "of a sphere or box; a point of a plane"},
    {.name = "normal",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_obstacle_spec, normal),
     .fallback = "[0, 0, 1]",
     .about = "of a plane, to its free side; of any length"},
    {.name = "radius",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_obstacle_spec, radius),
     POSITIVE,
     .unit = "m",
     .about = "of a sphere"},
    {.name = "size",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_obstacle_spec, size),
     POSITIVE,
     .unit = "m",
     .about = "of a box: its three sides"},
    ROTATION_KEY(scene_obstacle_spec, "of a box about its centre"),
    {.name = "inside",
     .kind = CONFIG_KEY_BOOL,
     AT(scene_obstacle_spec, inside),
     .fallback = "false",
     .about = "of a sphere or box: the inside is free, a bowl or a room"},
    {.name = "velocity",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_obstacle_spec, velocity),
     .unit = "m/s",
     .fallback = "[0, 0, 0]",
     .about = "with which the obstacle moves"},
    {.name = "friction",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_obstacle_spec, friction),
     NOT_NEGATIVE,
     .fallback = "0.5",
     .about = "Coulomb's coefficient"},
    {.name = "restitution",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_obstacle_spec, restitution),
     .most = 1,
     .fallback = "0.5",
     .about = "speed away over speed towards"},
    {.name = "stiffness",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_obstacle_spec, stiffness),
     POSITIVE,
     .unit = "N/m^3",
     .fallback = "the body's touch_stiffness",
     .about = "pressure per depth"},
    {.name = "damping",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_obstacle_spec, damping),
     NOT_NEGATIVE,
     .unit = "N s/m^3",
     .fallback = "0",
     .about = "pressure per speed of depth"},
    COLOUR_KEY(scene_obstacle_spec, "\"#808080\""),
    {.name = NULL},
};

static const config_key probe_keys[] = {
    {.name = "name",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_probe_spec, name),
     .fallback = "\"probe\" and its number",
     .about = "names its columns: letters, digits, '-', '_' and '.'"},
    {.name = "body",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_probe_spec, body),
     .needed = true,
     .about = "the name of a body"},
    {.name = "at",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_probe_spec, target),
     .needed = true,
     .about = "a group, vertex=N (from 1) or all; of several vertices their mean"},
    {.name = NULL},
};

static const config_key output_keys[] = {
    {.name = "record_every",
     .kind = CONFIG_KEY_COUNT,
     AT(scene_outputs_spec, record_every),
     .least = 1,
     .most = 1e12,
     .unit = "steps",
     .fallback = "1",
     .about = "between rows of the series"},
    {.name = "frames",
     .kind = CONFIG_KEY_OWN,
     .take = scene_take_frames,
     .schema = "{\"anyOf\":[{\"type\":\"number\",\"exclusiveMinimum\":0},{\"type\":\"string\","
               "\"pattern\":\"^every-[0-9]+$\"}]}",
     .unit = "1/s",
     .fallback = "none",
     .about = "frames for ParaView a second of simulated time, or \"every-N\" steps"},
    {.name = "stress",
     .kind = CONFIG_KEY_BOOL,
     AT(scene_outputs_spec, stress),
     .fallback = "false",
     .about = "von Mises stress in all tetrahedra"},
    {.name = "plots",
     .kind = CONFIG_KEY_BOOL,
     AT(scene_outputs_spec, plots),
     .fallback = "true for up to 8 bodies",
     .about = "a plot of each body's energy, where gnuplot is installed"},
    {.name = "monitor",
     .kind = CONFIG_KEY_BOOL,
     AT(scene_outputs_spec, monitor),
     .fallback = "true",
     .about = "warn where a model cannot be believed"},
    {.name = NULL},
};

const config_key scene_keys[] = {
    {.name = "bodies",
     .kind = CONFIG_KEY_LIST,
     AT(scene_spec, bodies),
     .keys = body_keys,
     .size = sizeof(scene_body_spec),
     .begin = begin_body,
     .needed = true,
     .about = "what is stepped"},
    {.name = "title",
     .kind = CONFIG_KEY_TEXT,
     AT(scene_spec, title),
     .about = "for those who look"},
    {.name = "dt",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_spec, settings.def.dt),
     POSITIVE,
     .unit = "s",
     .fallback = "0.003",
     .about = "time step"},
    {.name = "time",
     .kind = CONFIG_KEY_NUMBER,
     AT(scene_spec, time),
     POSITIVE,
     .unit = "s",
     .fallback = "10",
     .about = "time to simulate"},
    {.name = "gravity",
     .kind = CONFIG_KEY_VECTOR,
     AT(scene_spec, gravity),
     .unit = "m/s^2",
     .fallback = "[0, 0, 0]",
     .about = "acceleration of all bodies"},
    {.name = "base_motion",
     .kind = CONFIG_KEY_TEXTS,
     AT(scene_spec, base_motion),
     .fallback = "none",
     .about = "motions of the ground, as --base-motion of simulate; several add up"},
    {.name = "wind",
     .kind = CONFIG_KEY_OBJECT,
     AT(scene_spec, wind),
     .keys = wind_keys,
     .fallback = "none",
     .about = "air that drags on all surfaces"},
    {.name = "obstacles",
     .kind = CONFIG_KEY_LIST,
     AT(scene_spec, obstacles),
     .keys = obstacle_keys,
     .size = sizeof(scene_obstacle_spec),
     .begin = begin_obstacle,
     .fallback = "none",
     .about = "what bodies touch"},
    {.name = "probes",
     .kind = CONFIG_KEY_LIST,
     AT(scene_spec, probes),
     .keys = probe_keys,
     .size = sizeof(scene_probe_spec),
     .fallback = "none",
     .about = "points that are followed"},
    {.name = "outputs",
     .kind = CONFIG_KEY_OBJECT,
     AT(scene_spec, outputs),
     .keys = output_keys,
     .about = "what thrum simulate writes"},
    SETTINGS_KEYS,
    {.name = NULL},
};
