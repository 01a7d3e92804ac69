/* The fields of bodies, obstacles, solids, links, loads, wind and of touches between bodies: one
 * row each.
 *
 * A member of a def, its default, its range, the key of scene files, the JSON schema, the pages of
 * docs/reference, and the options in Python, JavaScript and the viewer all follow from the row, so
 * a new field is a row and its use. thrum_scene_fields has the rows at run time.
 *
 *   ROW(where, kind, name, unit, value, otherwise, range, about)
 *
 * where      BOTH: a member of the def and a key of scene files; CODE: a member alone.
 * kind       what the member holds; see THRUM_MEMBER below.
 * unit       "m"; NULL: none.
 * value      the default; of arrays, which are NULL by default, the member that counts their rows,
 *            and the numbers in a row.
 * otherwise  what holds without it, for readers: ITSELF: the value; SAY("..."): these words;
 * NOTHING. range      of each number that is not the default: ANY, ABOVE_0, FROM_0, SHARE (0 to 1),
 * RANK (1 to THRUM_RANK_MAX), SIDES (3 to 1024), SMALL (above 0, at most 0.01). All are finite.
 * about      what it is; and what more of it does.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_FIELDS_H
#define THRUM_FIELDS_H

#include <stddef.h>
#include <stdint.h>

/* How surfaces touch, whatever they are of. */
#define THRUM_TOUCH_FIELDS(ROW)                                                                    \
  ROW(BOTH, NUMBER, friction, NULL, 0.5, ITSELF, FROM_0,                                           \
      "Coulomb's coefficient; larger: bodies slide less")                                          \
  ROW(BOTH, NUMBER, restitution, NULL, 0.5, ITSELF, SHARE,                                         \
      "speed away over speed towards; larger: bodies bounce more")

/* Of thrum_scene_body_def. */
#define THRUM_BODY_FIELDS(ROW)                                                                     \
  ROW(BOTH, VECTOR, position, "m", (0, 0, 0), ITSELF, ANY, "where the model's origin is")          \
  ROW(BOTH, ROTATION, rotation, NULL, (1, 0, 0, 0), SAY("none"), ANY, "about the model's origin")  \
  ROW(BOTH, NUMBER, scale, NULL, 1, ITSELF, ABOVE_0,                                               \
      "factor of all lengths, exact; larger: it vibrates more slowly")                             \
  ROW(BOTH, NUMBER, stiffness, NULL, 1, ITSELF, ABOVE_0,                                           \
      "factor of Young's modulus and of springs to the ground, exact; larger: it vibrates faster") \
  ROW(BOTH, NUMBER, density, NULL, 1, ITSELF, ABOVE_0,                                             \
      "factor of the density, exact; larger: it is heavier and vibrates more slowly")              \
  ROW(BOTH, COUNT, rank, NULL, 0, SAY("all of the model"), RANK,                                   \
      "step the lowest so many coordinates and let the others follow, as condense does")           \
  ROW(BOTH, COUNT, condense, NULL, 0, SAY("none"), RANK,                                           \
      "step the lowest so many coordinates and let the others follow; larger: more vibration, "    \
      "and slower")                                                                                \
  ROW(BOTH, COLOUR, colour, NULL, (0.75f, 0.75f, 0.75f), SAY("\"#bfbfbf\""), SHARE,                \
      "for those who look")                                                                        \
  ROW(CODE, COUNT, start_mode, NULL, 0, SAY("none"), RANK,                                         \
      "basis vector that is added to the start, from 1; larger: a shape that vibrates faster")     \
  ROW(CODE, NUMBER, start_amplitude, "m", 0, ITSELF, ANY,                                          \
      "displacement by it of the vertex that moves furthest; negative: in the other direction")    \
  ROW(BOTH, FLAG, free, NULL, 0, ITSELF, ANY,                                                      \
      "the body may move and turn as a whole; of a model that nothing holds")                      \
  ROW(BOTH, VECTOR, velocity, "m/s", (0, 0, 0), ITSELF, ANY, "of a free body at the start")        \
  ROW(BOTH, SPIN, spin, "rad/s", (0, 0, 0), ITSELF, ANY,                                           \
      "angular velocity of a free body at the start, in world axes")                               \
  ROW(BOTH, FLAG, coupled, NULL, 0,                                                                \
      SAY("false; in scene files where the body begins to turn at a 50th of "                      \
          "its lowest frequency or faster"),                                                       \
      ANY,                                                                                         \
      "spin and shape of a free body act on each other, by centrifugal and Coriolis "              \
      "forces and the inertia of the deformed shape")                                              \
  ROW(CODE, INTS, triangles, NULL, (triangle_count, 3), SAY("none"), ANY,                          \
      "vertices of the outer triangles, counter-clockwise from outside, for wind and contact")     \
  ROW(CODE, INTS, touch, NULL, (touch_count, 1), SAY("none"), ANY,                                 \
      "vertices that may touch obstacles; held ones are left out; more: finer contact, and "       \
      "slower")                                                                                    \
  ROW(BOTH, NUMBER, touch_stiffness, "N/m^3", 0, SAY("of the material"), ABOVE_0,                  \
      "pressure per depth where obstacles say nothing; larger: the body sinks in less")            \
  ROW(BOTH, FLAG, collide, NULL, 1, ITSELF, ANY, "false: the body passes through other bodies")    \
  ROW(BOTH, FLAG, self_contact, NULL, 0, ITSELF, ANY,                                              \
      "the surface of the body touches itself too; makes its step slower")

/* Of thrum_obstacle: planes, spheres, boxes and rooms, which vertices of bodies touch. */
#define THRUM_OBSTACLE_FIELDS(ROW)                                                                 \
  ROW(CODE, OBSTACLE_SHAPE, shape, NULL, THRUM_OBSTACLE_PLANE, SAY("plane"), ANY, "what it is")    \
  ROW(BOTH, VECTOR, centre, "m", (0, 0, 0), ITSELF, ANY,                                           \
      "its middle, of a mesh its origin; a point of a plane")                                      \
  ROW(BOTH, VECTOR, normal, NULL, (0, 0, 1), ITSELF, ANY,                                          \
      "of a plane, to its free side; of any length")                                               \
  ROW(BOTH, NUMBER, radius, "m", 1, NOTHING, ABOVE_0, "of a sphere, cylinder or capsule")          \
  ROW(CODE, VECTOR, half, "m", (1, 1, 1), ITSELF, ABOVE_0, "of a box: half of its three sides")    \
  ROW(CODE, AXES, rotation, NULL, (1, 0, 0, 0, 1, 0, 0, 0, 1), SAY("none"), ANY,                   \
      "of a box: its axes as columns, 3 x 3 row-major, a rotation to 1e-6")                        \
  ROW(BOTH, FLAG, inside, NULL, 0, ITSELF, ANY,                                                    \
      "of a sphere or box: the inside is free, a bowl or a room")                                  \
  ROW(BOTH, VECTOR, velocity, "m/s", (0, 0, 0), ITSELF, ANY, "with which the obstacle moves")      \
  THRUM_TOUCH_FIELDS(ROW)                                                                          \
  ROW(BOTH, NUMBER, stiffness, "N/m^3", 0, SAY("the body's touch_stiffness"), ABOVE_0,             \
      "pressure per depth; larger: bodies sink in less")                                           \
  ROW(BOTH, NUMBER, damping, "N s/m^3", 0, ITSELF, FROM_0,                                         \
      "pressure per speed of depth; larger: an impact loses more")

/* Of thrum_scene_solid_def: obstacles that are touched by their faces, edges and corners. */
#define THRUM_SOLID_FIELDS(ROW)                                                                    \
  ROW(CODE, SOLID_SHAPE, shape, NULL, THRUM_SOLID_BOX, SAY("box"), ANY, "what it is")              \
  ROW(CODE, VECTOR, half, "m", (0.5, 0.5, 0.5), ITSELF, ABOVE_0,                                   \
      "of a box: half of its three sides")                                                         \
  ROW(CODE, NUMBER, radius, "m", 0.5, ITSELF, ABOVE_0, "of a cylinder or capsule")                 \
  ROW(CODE, NUMBER, height, "m", 1, ITSELF, FROM_0,                                                \
      "of a cylinder along its z axis; of a capsule between its half spheres")                     \
  ROW(CODE, WHOLE, segments, NULL, 48, ITSELF, SIDES,                                              \
      "flat faces around a cylinder or capsule; more: rounder, and more to search")                \
  ROW(CODE, DOUBLES, vertices, "m", (vertex_count, 3), SAY("none"), ANY, "of a mesh")              \
  ROW(CODE, INTS, triangles, NULL, (triangle_count, 3), SAY("none"), ANY,                          \
      "of a mesh: vertices of its triangles, counter-clockwise from outside")                      \
  ROW(CODE, GRID, heights, "m", (rows, columns), SAY("none"), ANY,                                 \
      "of a height field: rows along x from the least y on, the middle at the origin; 2 to 2^15 "  \
      "of either")                                                                                 \
  ROW(CODE, PAIR, spacing, "m", (1, 1), ITSELF, ABOVE_0,                                           \
      "of a height field: between its heights, along x and y")                                     \
  ROW(CODE, VECTOR, position, "m", (0, 0, 0), ITSELF, ANY, "where its origin is at time 0")        \
  ROW(CODE, ROTATION, rotation, NULL, (1, 0, 0, 0), SAY("none"), ANY,                              \
      "about its origin at time 0")                                                                \
  ROW(CODE, VECTOR, velocity, "m/s", (0, 0, 0), ITSELF, ANY, "where there is no path")             \
  ROW(CODE, DOUBLES, path_times, "s", (path_count, 1), SAY("none"), ANY,                           \
      "times of a path, ascending")                                                                \
  ROW(CODE, PLACES, path_places, NULL, (path_count, 7), SAY("none"), ANY,                          \
      "places of the path, in place of position, rotation and velocity: position [m] and "         \
      "quaternion; "                                                                               \
      "straight from one to the next, turning about one axis")                                     \
  THRUM_TOUCH_FIELDS(ROW)

/* Of thrum_scene_link_def. */
#define THRUM_LINK_FIELDS(ROW)                                                                     \
  ROW(CODE, LINK_KIND, kind, NULL, THRUM_LINK_BALL, SAY("ball"), ANY,                              \
      "a joint keeps two places together, a hinge also an axis, a weld all directions")            \
  ROW(CODE, INTS, vertices, NULL, (count, 1), SAY("all, or those near the place"), ANY,            \
      "vertices of the body whose mean is the place")                                              \
  ROW(BOTH, VECTOR, place, "m", (NAN, NAN, NAN), SAY("the mean of its vertices"), ANY,             \
      "where the link is at the start")                                                            \
  ROW(CODE, INTS, other_vertices, NULL, (other_count, 1), SAY("those near the place"), ANY,        \
      "vertices of the other body")                                                                \
  ROW(BOTH, VECTOR, other_place, "m", (NAN, NAN, NAN),                                             \
      SAY("the mean of the other vertices, or the place"), ANY,                                    \
      "of a spring: where its other end is at the start")                                          \
  ROW(BOTH, VECTOR, axis, NULL, (0, 0, 1), ITSELF, ANY, "of a hinge; of any length")               \
  ROW(BOTH, NUMBER, stiffness, "N/m", 0, ITSELF, FROM_0, "of a spring; no value is too large")     \
  ROW(BOTH, NUMBER, damping, "N s/m", 0, ITSELF, FROM_0,                                           \
      "of a spring; larger: it moves more slowly")                                                 \
  ROW(BOTH, NUMBER, length, "m", NAN, SAY("as it is at the start"), FROM_0,                        \
      "of a spring without force; larger: it pushes more")                                         \
  ROW(CODE, DOUBLES, path_times, "s", (path_count, 1), SAY("none"), ANY,                           \
      "times of a path of the end in the world, ascending")                                        \
  ROW(CODE, PLACES, path_places, "m", (path_count, 3), SAY("none"), ANY,                           \
      "places of the path, of which the way from the first counts, smooth from one to the next")   \
  ROW(BOTH, NUMBER, until, "s", INFINITY, SAY("the end"), FROM_0, "when it lets go")

/* Of thrum_load: the course of a load over time. The keys are those of texts such as
 * sine:0,0,1,frequency=2. */
#define THRUM_COURSE_FIELDS(ROW)                                                                   \
  ROW(CODE, LOAD_SHAPE, shape, NULL, THRUM_LOAD_CONSTANT, SAY("constant"), ANY,                    \
      "as it is; times sin(2 pi frequency (t - from)); or times (t - from) / (until - from)")      \
  ROW(BOTH, NUMBER, from, "s", 0, ITSELF, ANY, "when it begins; larger: later")                    \
  ROW(BOTH, NUMBER, until, "s", INFINITY, SAY("the end"), FROM_0,                                  \
      "when it ends; larger: it lasts longer, and a ramp rises more slowly")                       \
  ROW(BOTH, NUMBER, frequency, "Hz", 0, ITSELF, ANY, "of a sine; larger: more cycles")

/* Of thrum_scene_load_def, which has a course as well. */
#define THRUM_LOAD_FIELDS(ROW)                                                                     \
  ROW(CODE, LOAD_KIND, kind, NULL, THRUM_SCENE_FORCE, SAY("force"), ANY, "how it acts")            \
  ROW(CODE, VECTOR, vector, NULL, (0, 0, 0), ITSELF, ANY,                                          \
      "force [N] or acceleration [m/s^2]; larger: the body is moved further")                      \
  ROW(CODE, INTS, vertices, NULL, (count, 1), SAY("all of the body"), ANY,                         \
      "of a force: vertices that share it equally")                                                \
  ROW(CODE, DOUBLES, field, "N", (field_count, 3), SAY("none"), ANY,                               \
      "of a field: the force on each vertex of the model")                                         \
  ROW(CODE, DOUBLES, reduced, "kg^1/2 m/s^2", (rank, 1), SAY("none"), ANY,                         \
      "of a reduced load: on the coordinates of the scaled body")                                  \
  ROW(CODE, PLACES, parts, "kg^1/2 m/s^2", (rank, 9), SAY("none"), ANY,                            \
      "of a reduced load on a free body, 3 x 3 x rank: row [a, b] is the part of the load's "      \
      "component b in the world along the body's axis a")                                          \
  ROW(CODE, AXES, moments, "N m", (0, 0, 0, 0, 0, 0, 0, 0, 0), ITSELF, ANY,                        \
      "of the same: [a, b] is the sum of arm along a times force along b, at rest")                \
  ROW(CODE, VECTOR, resultant, "N", (0, 0, 0), ITSELF, ANY,                                        \
      "of the same: the sum of all forces in the world")

/* Of thrum_contact_pairs_def: how bodies touch each other. */
#define THRUM_PAIRS_FIELDS(ROW)                                                                    \
  ROW(CODE, COUNT, touch_max, NULL, 4096, ITSELF, ABOVE_0,                                         \
      "points that touch at once, up to 2^24; larger: more memory, and fewer are dropped")         \
  ROW(BOTH, NUMBER, thickness, "m", 0, SAY("1/250 of the smaller body"), ABOVE_0,                  \
      "distance that contact keeps between surfaces; larger: bodies rest further apart")           \
  THRUM_TOUCH_FIELDS(ROW)                                                                          \
  ROW(CODE, WHOLE, sweeps_max, NULL, 60, ITSELF, ABOVE_0,                                          \
      "sweeps of the solver over the rows of a group, six times as many in a second try; "         \
      "larger: "                                                                                   \
      "more exact forces in stacks, and slower")                                                   \
  ROW(CODE, NUMBER, tolerance, NULL, 1e-4, ITSELF, SMALL,                                          \
      "change of the displacement at which the solver ends, relative to that of a step; larger: "  \
      "faster and "                                                                                \
      "less exact")

/* Of thrum_scene_wind_def. */
#define THRUM_WIND_FIELDS(ROW)                                                                     \
  ROW(CODE, VECTOR, velocity, "m/s", (0, 0, 0), ITSELF, ANY,                                       \
      "where the air goes, and how fast; larger: the drag grows with its square")                  \
  ROW(BOTH, NUMBER, density, "kg/m^3", 1.2, ITSELF, FROM_0,                                        \
      "of the air; larger: more drag and more damping; 0: no wind")                                \
  ROW(BOTH, NUMBER, drag, NULL, 1, ITSELF, FROM_0,                                                 \
      "drag coefficient C_d of the windward surface; larger: more drag and more damping")

/* The kinds, as members of a def. */
#define THRUM_LIST(...) __VA_ARGS__
#define THRUM_FIRST(first, second) first
#define THRUM_SECOND(first, second) second
#define THRUM_MEMBER(where, kind, name, unit, value, otherwise, range, about)                      \
  THRUM_MEMBER_##kind(name, value)
#define THRUM_MEMBER_NUMBER(name, value) double name;
#define THRUM_MEMBER_PAIR(name, value) double name[2];
#define THRUM_MEMBER_VECTOR(name, value) double name[3];
#define THRUM_MEMBER_SPIN(name, value) double name[3]; /* degrees/s in scene files */
#define THRUM_MEMBER_ROTATION(name, value)                                                         \
  double name[4]; /* a quaternion w, x, y, z of any length > 0 */
#define THRUM_MEMBER_AXES(name, value) double name[9];
#define THRUM_MEMBER_COLOUR(name, value) float name[3]; /* red, green, blue */
#define THRUM_MEMBER_COUNT(name, value) int64_t name;
#define THRUM_MEMBER_WHOLE(name, value) int32_t name;
#define THRUM_MEMBER_FLAG(name, value) int32_t name; /* 0 or 1 */
#define THRUM_MEMBER_OBSTACLE_SHAPE(name, value) thrum_obstacle_shape name;
#define THRUM_MEMBER_SOLID_SHAPE(name, value) thrum_solid_shape name;
#define THRUM_MEMBER_LINK_KIND(name, value) thrum_link_kind name;
#define THRUM_MEMBER_LOAD_SHAPE(name, value) thrum_load_shape name;
#define THRUM_MEMBER_LOAD_KIND(name, value) thrum_scene_load_kind name;
#define THRUM_MEMBER_DOUBLES(name, value)                                                          \
  const double *name;                                                                              \
  int64_t THRUM_FIRST value;
#define THRUM_MEMBER_PLACES(name, value) const double *name; /* counted by the array before it */
#define THRUM_MEMBER_GRID(name, value)                                                             \
  const double *name;                                                                              \
  int64_t THRUM_FIRST value, THRUM_SECOND value;
#define THRUM_MEMBER_INTS(name, value)                                                             \
  const int32_t *name;                                                                             \
  int64_t THRUM_FIRST value;

/* The names of the choices, from 0 on. */
#define THRUM_NAMES_OBSTACLE_SHAPE "plane sphere box"
#define THRUM_NAMES_SOLID_SHAPE "mesh box cylinder capsule height_field"
#define THRUM_NAMES_LINK_KIND "spring ball hinge weld"
#define THRUM_NAMES_LOAD_SHAPE "constant sine ramp"
#define THRUM_NAMES_LOAD_KIND "force field acceleration reduced"

/* Their defaults, as designated initialisers of C. */
#define THRUM_VALUE(where, kind, name, unit, value, otherwise, range, about)                       \
  .name = THRUM_VALUE_##kind(value),
#define THRUM_VALUE_NUMBER(value) value
#define THRUM_VALUE_PAIR(value)                                                                    \
  { THRUM_LIST value }
#define THRUM_VALUE_VECTOR(value)                                                                  \
  { THRUM_LIST value }
#define THRUM_VALUE_SPIN(value)                                                                    \
  { THRUM_LIST value }
#define THRUM_VALUE_ROTATION(value)                                                                \
  { THRUM_LIST value }
#define THRUM_VALUE_AXES(value)                                                                    \
  { THRUM_LIST value }
#define THRUM_VALUE_COLOUR(value)                                                                  \
  { THRUM_LIST value }
#define THRUM_VALUE_COUNT(value) value
#define THRUM_VALUE_WHOLE(value) value
#define THRUM_VALUE_FLAG(value) value
#define THRUM_VALUE_OBSTACLE_SHAPE(value) value
#define THRUM_VALUE_SOLID_SHAPE(value) value
#define THRUM_VALUE_LINK_KIND(value) value
#define THRUM_VALUE_LOAD_SHAPE(value) value
#define THRUM_VALUE_LOAD_KIND(value) value
#define THRUM_VALUE_DOUBLES(value) NULL
#define THRUM_VALUE_PLACES(value) NULL
#define THRUM_VALUE_GRID(value) NULL
#define THRUM_VALUE_INTS(value) NULL

/* What holds without a field, as a text or NULL. */
#define THRUM_WORDS(kind, value, otherwise) THRUM_WORDS_##otherwise(kind, value)
#define THRUM_WORDS_NOTHING(kind, value) NULL
#define THRUM_WORDS_SAY(text) text THRUM_WORDS_SAID
#define THRUM_WORDS_SAID(kind, value)
#define THRUM_WORDS_ITSELF(kind, value) THRUM_TEXT_##kind(value)
#define THRUM_TEXT_NUMBER(value) #value
#define THRUM_TEXT_COUNT(value) #value
#define THRUM_TEXT_WHOLE(value) #value
#define THRUM_TEXT_PAIR(value) THRUM_TEXT_LIST value
#define THRUM_TEXT_VECTOR(value) THRUM_TEXT_LIST value
#define THRUM_TEXT_SPIN(value) THRUM_TEXT_LIST value
#define THRUM_TEXT_AXES(value) THRUM_TEXT_LIST value
#define THRUM_TEXT_LIST(...) "[" #__VA_ARGS__ "]"
#define THRUM_TEXT_FLAG(value) THRUM_TEXT_FLAG_##value
#define THRUM_TEXT_FLAG_0 "false"
#define THRUM_TEXT_FLAG_1 "true"

#endif
