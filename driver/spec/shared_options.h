/* Options that commands and scene files share, each row once.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_SHARED_OPTIONS_H
#define THRUM_DRIVER_SPEC_SHARED_OPTIONS_H

#include "config/options.h"
#include "driver/spec/load_spec.h"
#include "driver/spec/model_names.h"
#include "runtime/material/material_law.h"

/* Tables for groups: of a thrum_mesh_read_options, of a thrum_material, and of a thrum_state_def
 * without its dt. */
extern const config_option mesh_read_rows[];
extern const config_option material_options[];
extern const config_option solver_options[];

/* The same of a thrum_plastic. */
extern const config_option plastic_options[];

/* Names in the order of their enums; NULL ends them. */
extern const char *const integrator_names[];
extern const char *const full_solver_names[];
extern const char *const full_quadrature_names[];
extern const char *const element_names[]; /* by thrum_element_choice */
extern const char *const law_names[];

/* The law of the material in a run: the one that was asked for, or the model's. */
thrum_law law_of_run(bool given, thrum_law law, const thrum_model *model);

/* The model with this law in place of its own. It borrows the arrays of `model` but has no cubature
 * points, so it serves questions about the body and not about its energy. Where the model has the
 * law already, nothing is changed. */
thrum_model model_of_law(const thrum_model *model, thrum_law law);

/* Single rows, for the fields of a request. */
#define OPTION_DT(type, member)                                                                    \
  OPTION_NUMBER("dt", "s", "0.003", "time step", CONFIG_AT(type, member), CONFIG_ABOVE(0))
#define OPTION_TIME(type, member, otherwise)                                                       \
  OPTION_NUMBER("time", "s", otherwise, "time to simulate", CONFIG_AT(type, member),               \
                CONFIG_ABOVE(0))
#define OPTION_DAMPING(place)                                                                      \
  OPTION_PAIR("damping", "0", "Rayleigh damping: A of the mass, B of the stiffness",               \
              .unit = "1/s, s", CONFIG_FROM(0), .wants = "A, or A and B, none negative", place)
#define OPTION_INTEGRATOR(type, member)                                                            \
  OPTION_CHOICE(                                                                                   \
      "integrator", integrator_names, "energy",                                                    \
      "what steps a body; three are there to be compared with: backward Euler, semi-implicit "     \
      "Euler, which is the same with a single Newton iteration (Baraff and Witkin), and "          \
      "Runge-Kutta of order 4",                                                                    \
      CONFIG_AT(type, member))
#define OPTION_FRAMES(taken)                                                                       \
  OPTION_WORD("frames", "FPS", "none",                                                             \
              "frames for ParaView, so many a second of simulated time, or every-N steps",         \
              .take = taken, .wants = "frames a second such as 60, or every-N steps",              \
              .schema = "{\"anyOf\":[{\"type\":\"number\",\"exclusiveMinimum\":0},{\"type\":"      \
                        "\"string\",\"pattern\":\"^every-[0-9]+$\"}]}")
#define OPTION_LOAD(taken, otherwise, text)                                                        \
  OPTION_TEXT("load", "LOAD", otherwise, text, .repeats = true, .take = taken)

#define OPTION_LAW(otherwise, text, ...)                                                           \
  OPTION_CHOICE("law", law_names, otherwise,                                                       \
                "the material's law, with the moduli given as those of small strains: Saint "      \
                "Venant-Kirchhoff, or corotational linear elasticity or stable neo-Hookean, "      \
                "which bear strong compression and inversion" text,                                \
                __VA_ARGS__)
/* The same of a body that is unreduced; `type` has a law and whether it was given. */
#define OPTION_FULL_LAW(type)                                                                      \
  OPTION_LAW("that of the model", "", CONFIG_AT(type, law), .given = offsetof(type, law_given))

#define OPTION_MATERIAL(taken)                                                                     \
  OPTION_TEXT(                                                                                     \
      "material", "REGION:E,NU,RHO", NULL,                                                         \
      "what one region of the mesh is made of, in Pa and kg/m^3, behind it or in its "             \
      "place LAW or LAW,YIELD, a law as of --law and the strain beyond which it flows; or "        \
      "REGION:ortho,E1,E2,E3,NU12,NU13,NU23,G12,G13,G23,RHO, or "                                  \
      "REGION:transverse,E1,E2,NU12,NU23,G12,RHO, then ,along,X,Y,Z of direction 1 and "           \
      ",layers,0/90/0 of a laminate; thrum check names the regions",                               \
      .repeats = true, .take = taken)

/* The forms of LOAD, for the notes of commands, with the keys of thrum/fields.h. */
#define LOAD_KEY(where, kind, name, unit, value, otherwise, range, about)                          \
  LOAD_KEY_##where(name, unit, about)
#define LOAD_KEY_BOTH(name, unit, about) "  " #name "=  " about " [" unit "]\n"
#define LOAD_KEY_CODE(name, unit, about)
#define LOAD_NOTES                                                                                 \
  "LOAD is KIND:X,Y,Z@TARGET[,KEY=VALUE...], a force in newtons:\n"                                \
  "  impulse   for 0.003 s, or until=        square    for 0.3 s, or until=\n"                     \
  "  constant  for ever, or until=           sine      needs f=HZ; for ever, or until=\n"          \
  "  ramp      rises evenly from 0 at the start to the force at until=S, and ends there\n"         \
  "  gravity   gravity:X,Y,Z, an acceleration in m/s^2; no TARGET\n"                               \
  "  traction  traction:X,Y,Z@GROUP, a force an area in Pa on the surface there\n"                 \
  "TARGET is a group, vertex=N (from 1, as in lists of fixed vertices), near:X,Y,Z (the vertex\n"  \
  "nearest to that point of the body at rest [m]), a predicate such as 'x>0.9&z<0', or all. The\n" \
  "force is the total: the vertices of a target share it equally, held ones included.\n"           \
  "KEY is\n" THRUM_COURSE_FIELDS(LOAD_KEY)

/* The option of how a material flows, "--creep", that is given though nothing of the model does: no
 * yield is given, and no region has one of its own; NULL where there is none. */
const char *plastic_option_without_yield(const thrum_plastic *plastic, const thrum_model *model);

/* The first option of how imexv splits the modes that differs from its default although another
 * integrator steps, as on a command line ("--split-form"); NULL where there is none. Such an option
 * would have no effect. */
const char *split_option_without_effect(const thrum_state_def *def);

/* For `take`: a number and one of these endings (NULL ends them), which scale it; no ending is the
 * first's where that is empty. Above 0. */
thrum_status scaled_option_take(const config_given *given, const char *const *endings,
                                const double *scales, double *value);
/* An error, such as 0.05 or 5%, up to 1. */
thrum_status error_option_take(const config_given *given, double *error);

/* For `take`: auto, 1 or 2, as thrum_mesh_read_options has them; the row's other fields. */
thrum_status order_option_take(const config_given *given, int *order);
#define ORDER_FORM                                                                                 \
  .wants = "auto, 1 or 2",                                                                         \
  .schema =                                                                                        \
      "{\"anyOf\":[{\"const\":\"auto\"},{\"type\":\"integer\",\"minimum\":1,\"maximum\":2}]}"

/* For `take`: parses the load given into loads[*count], which has room for it, and counts it. */
thrum_status load_option_take(const config_given *given, load_spec *loads, int64_t *count);
/* Frames a second, or steps between them; the other becomes 0. */
thrum_status frames_option_take(const config_given *given, double *rate, int64_t *every);

#endif
