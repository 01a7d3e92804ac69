/* The keys of a scene file: the tables that the reader, its messages, the schema and
 * docs/reference/scene_keys.md are made of. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "driver/scene/scene_spec.h"
#include "driver/spec/actuate_spec.h"
#include "driver/spec/shared_options.h"
#include "thrum/thrum.h"

/* --- what holds without a key ----------------------------------------------------------------- */

static void begin_body(void *item, const void *in) {
  const scene_spec *scene = in;
  scene_body_spec *body = item;
  *body = (scene_body_spec){
      .settings = {.def = scene->settings.def},
      .material = {.material = {NAN, NAN, NAN}, .plastic = scene->settings.def.plastic},
      THRUM_BODY_FIELDS(SCENE_VALUE).touch = "surface",
      .detail = {.condense = 2},
  };
}

static void begin_obstacle(void *item, const void *in) {
  (void)in;
  scene_obstacle_spec *obstacle = item;
  *obstacle = (scene_obstacle_spec){
      THRUM_OBSTACLE_FIELDS(SCENE_VALUE).rotation = {1, 0, 0, 0},
      .scale = 1,
      .colour = {0.5f, 0.5f, 0.5f},
  };
}

static void begin_link(void *item, const void *in) {
  (void)in;
  scene_link_spec *link = item;
  *link = (scene_link_spec){THRUM_LINK_FIELDS(SCENE_VALUE)};
}

static void begin_waypoint(void *item, const void *in) {
  (void)in;
  scene_waypoint_spec *waypoint = item;
  *waypoint = (scene_waypoint_spec){.rotation = {1, 0, 0, 0}};
}

/* --- values that are more than a number, a text or a list ------------------------------------- */

/* Rows of numbers, all of one length; they are read where the obstacle is made. */
static thrum_status take_heights(const config_given *given, void *record) {
  scene_obstacle_spec *obstacle = record;
  if (given->node->type != JSON_ARRAY || given->node->first < 0)
    return config_given_wrong(given);
  obstacle->heights = given->node;
  return THRUM_OK;
}

typedef struct rotation_spec {
  config_record at;
  double axis[3], angle;
} rotation_spec;

static const config_option rotation_keys[] = {
    OPTION_VECTOR("axis", NULL, NULL, "of the rotation", CONFIG_AT(rotation_spec, axis),
                  .needed = true),
    OPTION_NUMBER("angle", "degrees", NULL, "about it", CONFIG_AT(rotation_spec, angle),
                  .needed = true),
    OPTION_END,
};

static thrum_status take_rotation(const config_given *given, void *record) {
  double *rotation = (double *)(void *)((char *)record + given->option->field);
  double numbers[4];
  rotation_spec spec = {.at = {.node = given->node}};
  if (given->node->type == JSON_OBJECT) {
    THRUM_TRY(config_object_read(given, rotation_keys, &spec));
    return scene_axis_angle(spec.axis, spec.angle, rotation) ? THRUM_OK : config_given_wrong(given);
  }
  THRUM_TRY(config_given_numbers(given, 4, 4, numbers, NULL));
  if (!isnormal(numbers[0] * numbers[0] + numbers[1] * numbers[1] + numbers[2] * numbers[2] +
                numbers[3] * numbers[3]))
    return config_given_wrong(given);
  memcpy(rotation, numbers, sizeof numbers);
  return THRUM_OK;
}

/* The rotation of a waypoint, which keeps its angle: a quaternion does not know of whole turns. */
static thrum_status take_turn(const config_given *given, void *record) {
  scene_waypoint_spec *waypoint = record;
  rotation_spec spec = {.at = {.node = given->node}};
  THRUM_TRY(take_rotation(given, record));
  waypoint->angle = NAN;
  if (given->node->type != JSON_OBJECT)
    return THRUM_OK;
  THRUM_TRY(config_object_read(given, rotation_keys, &spec));
  memcpy(waypoint->axis, spec.axis, sizeof spec.axis);
  waypoint->angle = spec.angle;
  return THRUM_OK;
}

/* "#rrggbb"; false when it is none. */
static bool hex_colour(const char *text, float colour[3]) {
  static const char digits[] = "0123456789abcdef0123456789ABCDEF";
  unsigned values[6];
  if (text[0] != '#' || strlen(text) != 7)
    return false;
  for (int n = 0; n < 6; n++) {
    const char *digit = strchr(digits, text[n + 1]);
    if (digit == NULL)
      return false;
    values[n] = (unsigned)(digit - digits) % 16;
  }
  for (int n = 0; n < 3; n++)
    colour[n] = (float)(16 * values[2 * n] + values[2 * n + 1]) / 255.0f;
  return true;
}

static thrum_status take_colour(const config_given *given, void *record) {
  float *colour = (float *)(void *)((char *)record + given->option->field);
  double numbers[3];
  if (given->node->type == JSON_STRING && hex_colour(given->text, colour))
    return THRUM_OK;
  if (given->node->type != JSON_ARRAY)
    return config_given_wrong(given);
  THRUM_TRY(config_given_numbers(given, 3, 3, numbers, NULL));
  for (int n = 0; n < 3; n++)
    colour[n] = (float)numbers[n];
  return THRUM_OK;
}

static thrum_status take_order(const config_given *given, void *record) {
  return order_option_take(given, &((scene_body_spec *)record)->order);
}

static thrum_status take_frames(const config_given *given, void *record) {
  scene_outputs_spec *outputs = record;
  return frames_option_take(given, &outputs->frames_rate, &outputs->frames_every);
}

static thrum_status check_load(const char *text, thrum_error *error) {
  load_spec load;
  return load_spec_parse(text, &load, error);
}

static thrum_status check_actuate(const char *text, thrum_error *error) {
  actuate_spec spec;
  return actuate_spec_parse(text, &spec, error);
}

static thrum_status check_start(const char *text, thrum_error *error) {
  start_spec start;
  return start_spec_parse(text, &start, error);
}

static thrum_status check_base_motion(const char *text, thrum_error *error) {
  base_motion_spec base_motion;
  return base_motion_parse(text, &base_motion, error);
}

/* --- tables ----------------------------------------------------------------------------------- */

#define NUMBERS(count)                                                                             \
  "{\"type\":\"array\",\"items\":{\"type\":\"number\"},\"minItems\":" count ",\"maxItems\":" count \
  "}"
#define ROTATION_SCHEMA                                                                            \
  "{\"anyOf\":[" NUMBERS("4") ",{\"type\":\"object\",\"additionalProperties\":false,\"required\""  \
                              ":[\"axis\",\"angle\"],\"properties\":{\"axis\":" NUMBERS(           \
                                  "3") ",\"angle\":{\"type\":\"number\"}}}]}"
#define COLOUR_SCHEMA                                                                              \
  "{\"anyOf\":[{\"type\":\"string\",\"pattern\":\"^#[0-9a-fA-F]{6}$\"},{\"type\":\"array\","       \
  "\"items\":{\"type\":\"number\",\"minimum\":0,\"maximum\":1},\"minItems\":3,\"maxItems\":3}]}"
#define COLOUR_KEY(grey, text, record)                                                             \
  OPTION_WORD("colour", NULL, grey, text, .take = take_colour, CONFIG_AT(record, colour),          \
              CONFIG_RANGE(0, 1), .schema = COLOUR_SCHEMA,                                         \
              .wants = "\"#rrggbb\", or [red, green, blue] from 0 to 1")
#define ROTATION_KEY(text, record, take_it)                                                        \
  OPTION_WORD("rotation", NULL, "none", text, .unit = "degrees", .take = take_it,                  \
              CONFIG_AT(record, rotation), .schema = ROTATION_SCHEMA,                              \
              .wants = "{\"axis\": [X, Y, Z], \"angle\": DEGREES} or a quaternion [W, X, Y, Z], "  \
                       "not zero")

/* The rows of thrum/fields.h that are keys, as options of the RECORD. */
#define KEY(where, kind, name, unit, value, otherwise, range, about)                               \
  KEY_##where(kind, name, unit, THRUM_WORDS(kind, value, otherwise), range, about)
#define KEY_CODE(...)
#define KEY_BOTH(kind, ...) KEY_##kind(__VA_ARGS__),
#define KEY_NUMBER(name, unit, words, range, about)                                                \
  OPTION_NUMBER(#name, unit, words, about, CONFIG_AT(RECORD, name), KEYS_##range)
#define KEY_VECTOR(name, unit, words, range, about)                                                \
  OPTION_VECTOR(#name, unit, words, about, CONFIG_AT(RECORD, name), KEYS_##range)
#define KEY_SPIN(name, unit, words, range, about) KEY_VECTOR(name, "degrees/s", words, range, about)
#define KEY_COUNT(name, unit, words, range, about)                                                 \
  OPTION_COUNT(#name, words, about, CONFIG_AT(RECORD, name), KEYS_##range)
#define KEY_FLAG(name, unit, words, range, about)                                                  \
  OPTION_FLAG(#name, about, .fallback = words, CONFIG_AT(RECORD, name))
#define KEY_ROTATION(name, unit, words, range, about) ROTATION_KEY(about, RECORD, take_rotation)
#define KEY_COLOUR(name, unit, words, range, about) COLOUR_KEY(words, about, RECORD)
#define KEYS_ANY
#define KEYS_ABOVE_0 CONFIG_ABOVE(0)
#define KEYS_FROM_0 CONFIG_FROM(0)
#define KEYS_SHARE CONFIG_RANGE(0, 1)
#define KEYS_RANK CONFIG_RANGE(1, THRUM_RANK_MAX)

#define AT(member) CONFIG_AT(scene_material_spec, member)
static const config_option material_keys[] = {
    OPTION_GROUP(material_options, "", AT(material)),
    OPTION_LAW("stvk", "; the model then has cubature points", AT(law)),
    OPTION_TEXTS(
        "regions", "as the rest",
        "what regions of the mesh are made of, as --material of precompute: REGION:E,NU,RHO, "
        "REGION:LAW or REGION:LAW,YIELD",
        AT(regions)),
    OPTION_GROUP(plastic_options, "", AT(plastic)),
    OPTION_END,
};
#undef AT

#define AT(member) CONFIG_AT(scene_detail_spec, member)
static const config_option detail_keys[] = {
    OPTION_COUNT("condense", "2", "coordinates that are then stepped, the others following",
                 AT(condense), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_NUMBER("beyond", "m", "never by distance",
                  "the body is far while its middle is further than this from the eye", AT(beyond),
                  CONFIG_ABOVE(0)),
    OPTION_NUMBER("still", "m/s", "never by rest",
                  "the body is still while no vertex has moved or deformed faster than this for a "
                  "period of its lowest frequency, and nothing is about to act on it",
                  AT(still), CONFIG_ABOVE(0)),
    OPTION_NUMBER("jump", "m", NULL,
                  "no vertex jumps further than this where the number of coordinates changes; a "
                  "change that would is put off",
                  .needed = true, AT(jump), CONFIG_ABOVE(0)),
    OPTION_END,
};
#undef AT

#define AT(member) CONFIG_AT(scene_body_spec, member)
static const config_option body_keys[] = {
    OPTION_TEXT("name", NULL, "\"body\" and its number",
                "names its folder: letters, digits, '-', '_' and '.'", AT(name)),
    OPTION_TEXT(
        "model", NULL, NULL, "a model file, a mesh, or beam, basket, bridge, horse, tower or heart",
        .needed = true, .path = CONFIG_PATH_NAMED, .is_name = is_model_name_or_spec, AT(model)),
    OPTION_TEXTS("fix", "nothing", "what is held of a mesh, as --fix of precompute",
                 .path = CONFIG_PATH_IF_THERE, AT(fix)),
    OPTION_WORD("order", NULL, "auto",
                "of the tetrahedra of a mesh, as --order of precompute: 1, 2 or auto",
                .take = take_order, ORDER_FORM),
    OPTION_TEXT("surface", NULL, "the mesh's own",
                "shown in its place: a file of embed, or an .obj or .stl in metres",
                .path = CONFIG_PATH_ALWAYS, AT(surface)),
    OPTION_OBJECT("material", material_keys, NULL,
                  "of a mesh, in place of its own; of a model the plastic flow alone",
                  AT(material)),

// what a body of the library has
#define RECORD scene_body_spec
    THRUM_BODY_FIELDS(KEY)
#undef RECORD

    // how many coordinates are stepped
    OPTION_NUMBER("error", NULL, "none",
                  "condense to the least number of coordinates whose motion errs by at most so "
                  "much of it in the first 2 s",
                  AT(error), CONFIG_RANGE(1e-6, 1)),
    OPTION_NUMBER("budget", "s", "none",
                  "condense to coordinates whose step takes at most so long by the program's model "
                  "of costs: those of least error in the first 2 s, or with \"error\" the fewest",
                  AT(budget), CONFIG_ABOVE(0)),
    OPTION_OBJECT("detail", detail_keys, "none",
                  "step fewer coordinates while the body is far from the eye or still", AT(detail)),

    // how it starts, and what acts on it
    OPTION_TEXTS("start", "at rest", "as --start of simulate; several add up",
                 .path = CONFIG_PATH_NAMED, .is_name = is_model_name_or_spec, .check = check_start,
                 AT(start)),
    OPTION_TEXTS("loads", "none", "loads over time, as --load of simulate, in world axes",
                 .check = check_load, AT(loads)),
    OPTION_TEXTS("actuate", "all at 0",
                 "levels of actuators of its model file over time, as --actuate of simulate",
                 .check = check_actuate, AT(actuate)),
    OPTION_TEXT("touch", NULL, "\"surface\"",
                "what may touch obstacles: \"surface\", \"none\", or a group of vertices, "
                "vertex=N (from 1), near:X,Y,Z, a predicate or all",
                AT(touch)),

    // the keys of the scene's own solver, each of which may be replaced
    OPTION_GROUP(solver_options, "in place of what the scene says", AT(settings.def)),
    OPTION_END,
};
#undef AT

#define RECORD scene_wind_spec
static const config_option wind_keys[] = {
    OPTION_VECTOR("velocity", "m/s", NULL, "where the air goes, and how fast", .needed = true,
                  CONFIG_AT(RECORD, velocity)),
    THRUM_WIND_FIELDS(KEY) OPTION_END,
};
#undef RECORD

#define RECORD scene_collisions_spec
static const config_option collision_keys[] = {THRUM_PAIRS_FIELDS(KEY) OPTION_END};
#undef RECORD

#define AT(member) CONFIG_AT(scene_obstacle_spec, member)
const char *const scene_shape_names[] = {"plane",   "sphere",       "box",  "cylinder",
                                         "capsule", "height_field", "mesh", NULL};

#define HEIGHTS_SCHEMA                                                                             \
  "{\"type\":\"array\",\"minItems\":2,\"items\":{\"type\":\"array\",\"minItems\":2,\"items\":"     \
  "{\"type\":\"number\"}}}"

#define WAY(member) CONFIG_AT(scene_waypoint_spec, member)
static const config_option waypoint_keys[] = {
    OPTION_NUMBER("time", "s", NULL, "when the obstacle is there, after those before it",
                  .needed = true, WAY(time)),
    OPTION_VECTOR("centre", "m", NULL, "where it is then", .needed = true, WAY(centre)),
    ROTATION_KEY("how it is turned then", scene_waypoint_spec, take_turn),
    OPTION_END,
};
#undef WAY

static const config_option obstacle_keys[] = {
    OPTION_TEXT("name", NULL, NULL, "for those who look", AT(name)),
    OPTION_CHOICE("shape", scene_shape_names, NULL, "what it is", .needed = true, AT(shape)),

// what an obstacle of the library has
#define RECORD scene_obstacle_spec
    THRUM_OBSTACLE_FIELDS(KEY)
#undef RECORD

    // its place and size; each shape has its own
    OPTION_NUMBER("height", "m", NULL,
                  "of a cylinder along its z axis; of a capsule between its half spheres",
                  AT(height), CONFIG_FROM(0)),
    OPTION_VECTOR("size", "m", NULL, "of a box: its three sides", AT(size), CONFIG_ABOVE(0)),
    OPTION_TEXT("file", NULL, NULL, "of a mesh: its triangles, .obj or .stl",
                .path = CONFIG_PATH_ALWAYS, AT(path)),
    OPTION_NUMBER("scale", NULL, "1", "of a mesh: the metres of one unit of its file", AT(scale),
                  CONFIG_ABOVE(0)),
    OPTION_WORD("heights", NULL, NULL,
                "of a height field: rows along x from the least y on, the middle at the centre",
                .unit = "m", .take = take_heights, AT(heights), .schema = HEIGHTS_SCHEMA,
                .wants = "a list of two rows of numbers or more"),
    OPTION_NUMBER("spacing", "m", NULL, "of a height field: between its heights, along x and y",
                  AT(spacing), CONFIG_ABOVE(0)),
    ROTATION_KEY("about its centre; not of planes and spheres", scene_obstacle_spec, take_rotation),
    OPTION_LIST("path", waypoint_keys, scene_waypoint_spec, "none",
                "places over time, straight from one to the next; not of planes, spheres and rooms",
                .begin = begin_waypoint, AT(way)),
    COLOUR_KEY("\"#808080\"", "for those who look", scene_obstacle_spec),
    OPTION_END,
};
#undef AT

const char *const scene_link_names[] = {"spring", "ball", "hinge", "weld", NULL};

#define AT(member) CONFIG_AT(scene_link_waypoint_spec, member)
static const config_option link_waypoint_keys[] = {
    OPTION_NUMBER("time", "s", NULL, "when the end is there, after those before it", .needed = true,
                  AT(time)),
    OPTION_VECTOR("place", "m", NULL, "where it is then, of which the way from the first counts",
                  .needed = true, AT(place)),
    OPTION_END,
};
#undef AT

#define AT(member) CONFIG_AT(scene_link_spec, member)
static const config_option link_keys[] = {
    OPTION_TEXT("name", NULL, NULL, "for those who look", AT(name)),
    OPTION_CHOICE("kind", scene_link_names, NULL,
                  "a spring between two places; a ball joint, which keeps two places together; a "
                  "hinge, which also keeps an axis; a weld, which keeps all directions",
                  .needed = true, AT(kind)),

    // what is tied, and where
    OPTION_TEXT("body", NULL, NULL, "the name of a body", .needed = true, AT(body)),
    OPTION_TEXT(
        "at", NULL, "what is near \"place\"",
        "a group of it, vertex=N (from 1), near:X,Y,Z or a predicate in its own axes, or all; "
        "of several vertices their mean",
        AT(target)),
    OPTION_TEXT("other", NULL, "the world", "the name of another body", AT(other)),
    OPTION_TEXT("other_at", NULL, "what is near the place", "as \"at\", of the other body",
                AT(other_target)),

// what a link of the library has
#define RECORD scene_link_spec
    THRUM_LINK_FIELDS(KEY)
#undef RECORD

    // where its end in the world goes, and how long it holds
    OPTION_LIST("path", link_waypoint_keys, scene_link_waypoint_spec, "none",
                "places over time of the end in the world, smooth from one to the next", AT(way)),
    OPTION_TEXT("file", NULL, NULL,
                "the same from a .csv: t,x,y,z, as a motion of --base-motion of simulate",
                .path = CONFIG_PATH_ALWAYS, AT(path)),
    OPTION_END,
};
#undef AT

#define AT(member) CONFIG_AT(scene_probe_spec, member)
static const config_option probe_keys[] = {
    OPTION_TEXT("name", NULL, "\"probe\" and its number",
                "names its columns: letters, digits, '-', '_' and '.'", AT(name)),
    OPTION_TEXT("body", NULL, NULL, "the name of a body", .needed = true, AT(body)),
    OPTION_TEXT("at", NULL, NULL,
                "a group, vertex=N (from 1), near:X,Y,Z or a predicate in its own axes, or all; of "
                "several vertices their mean",
                .needed = true, AT(target)),
    OPTION_END,
};
#undef AT

static thrum_status take_accepted(const config_given *given, void *outputs) {
  return error_option_take(given, &((scene_outputs_spec *)outputs)->basis.accepted);
}

#define AT(member) CONFIG_AT(scene_outputs_spec, member)
static const config_option output_keys[] = {
    OPTION_COUNT("record_every", "1", "between rows of the series", .unit = "steps",
                 AT(record_every), CONFIG_RANGE(1, 1e12)),
    OPTION_FRAMES(take_frames),
    OPTION_FLAG("stress", "von Mises stress at nodes and centres", .fallback = "false", AT(stress)),
    OPTION_FLAG("plots", "a plot of each body's energy, where gnuplot is installed",
                .fallback = "true for up to 8 bodies", AT(plots)),
    OPTION_FLAG("monitor", "warn where a model cannot be believed", .fallback = "true",
                AT(monitor)),
    OPTION_ACCEPT_ERROR("accept_error", take_accepted),
    OPTION_JUDGE(scene_outputs_spec, basis),
    OPTION_END,
};
#undef AT

#define AT(member) CONFIG_AT(scene_spec, member)
const config_option scene_keys[] = {
    OPTION_LIST("bodies", body_keys, scene_body_spec, NULL, "what is stepped", .needed = true,
                .begin = begin_body, AT(bodies)),
    OPTION_TEXT("title", NULL, NULL, "for those who look", AT(title)),

    // how long, and what acts on all bodies
    OPTION_DT(scene_spec, settings.def.dt),
    OPTION_TIME(scene_spec, time, "10"),
    OPTION_VECTOR("gravity", "m/s^2", "[0, 0, 0]", "acceleration of all bodies", AT(gravity)),
    OPTION_VECTOR("eye", "m", "[0, 0, 0]",
                  "place that the distances of \"detail\" are from, such as the camera", AT(eye)),
    OPTION_VECTOR("eye_velocity", "m/s", "[0, 0, 0]", "with which the eye moves", AT(eye_velocity)),
    OPTION_TEXTS("base_motion", "none",
                 "motions of the ground, as --base-motion of simulate; several add up",
                 .path = CONFIG_PATH_NAMED, .is_name = is_model_name_or_spec,
                 .check = check_base_motion, AT(base_motion)),
    OPTION_OBJECT("wind", wind_keys, "none", "air that drags on all surfaces", AT(wind)),

    // what they touch, and what is written
    OPTION_FLAG("collide", "bodies touch each other", .fallback = "true where a body is free",
                AT(collide)),
    OPTION_OBJECT("collisions", collision_keys, NULL, "how bodies touch each other",
                  AT(collisions)),
    OPTION_LIST("obstacles", obstacle_keys, scene_obstacle_spec, "none", "what bodies touch",
                .begin = begin_obstacle, AT(obstacles)),
    OPTION_LIST(
        "links", link_keys, scene_link_spec, "none",
        "springs and joints between bodies or with the world, and ends that go along a path",
        .begin = begin_link, AT(links)),
    OPTION_LIST("probes", probe_keys, scene_probe_spec, "none", "points that are followed",
                AT(probes)),
    OPTION_OBJECT("outputs", output_keys, NULL, "what thrum simulate writes", AT(outputs)),
    OPTION_GROUP(solver_options, "how bodies are stepped, unless they say so themselves",
                 AT(settings.def)),
    OPTION_END,
};
