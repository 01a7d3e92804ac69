/* The list of extremes, and the systems of units. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/pi.h"
#include "validation/experiments/extremes.h"

const char *const experiment_subject_names[EXPERIMENT_SUBJECT_COUNT] = {
#define X(name) #name,
    EXPERIMENT_SUBJECT_LIST(X)
#undef X
};

// what every entry is but for what it says
#define RUBBER                                                                                     \
  { 5e6, 0.4, 1000 }
#define COMMON(subject_, name_)                                                                    \
  .subject = EXPERIMENT_SUBJECT_##subject_, .name = name_, .modes = 8, .rank = 15, .load = 0.1
#define BEAM .shape = EXPERIMENT_SHAPE_BEAM, .cells = {8, 2, 2}, .size = {1, 0.2, 0.2}
#define MATERIAL(E, nu, rho) .material = {E, nu, rho}

#define STIFFNESS(text, E)                                                                         \
  { COMMON(stiffness, text), BEAM, MATERIAL(E, 0.4, 1000), .dt = 0.003 }
#define POISSON(text, nu)                                                                          \
  { COMMON(poisson, text), BEAM, MATERIAL(5e6, nu, 1000), .dt = 0.003 }
#define SIZE(text, length)                                                                         \
  {                                                                                                \
    COMMON(size, text), .cells = {8, 2, 2}, .size = {length, 0.2 * length, 0.2 * length},          \
                        .material = RUBBER, .dt = 0.003                                            \
  }
#define DENSITY(text, rho)                                                                         \
  { COMMON(density, text), BEAM, MATERIAL(5e6, 0.4, rho), .dt = 0.003 }
#define LOAD(text, times)                                                                          \
  {                                                                                                \
    .subject = EXPERIMENT_SUBJECT_load, .name = text, .modes = 8, .rank = 15, .load = times, BEAM, \
    .material = RUBBER, .dt = 0.003                                                                \
  }
#define SNAP(text, times)                                                                          \
  {                                                                                                \
    .subject = EXPERIMENT_SUBJECT_snap, .name = text, .modes = 10, .rank = 25, .load = times,      \
    .shape = EXPERIMENT_SHAPE_ARCH, .cells = {20, 2, 2}, .size = {1, 0.04, 0.02},                  \
    .material = RUBBER, .dt = 0.003                                                                \
  }
#define TET(text, loose, count, all)                                                               \
  {                                                                                                \
    .subject = EXPERIMENT_SUBJECT_tet, .name = text, .modes = count, .rank = all, .load = 0.1,     \
    .shape = EXPERIMENT_SHAPE_TET, .size = {0.1, 0, 0}, .free = loose, .material = RUBBER,         \
    .dt = 0.003                                                                                    \
  }
#define SQUARE(text, times)                                                                        \
  {                                                                                                \
    .subject = EXPERIMENT_SUBJECT_square, .name = text, .modes = 8, .rank = 15, .load = times,     \
    .shape = EXPERIMENT_SHAPE_SQUARE, .cells = {8, 2, 2}, .size = {1, 0.2, 0.2},                   \
    .material = RUBBER, .dt = 0.003                                                                \
  }
#define RANK(text, count, all, ny, share)                                                          \
  {                                                                                                \
    .subject = EXPERIMENT_SUBJECT_rank, .name = text, .modes = count, .rank = all, .load = 0.1,    \
    .cells = {12, ny, ny}, .size = {1, 0.2, 0.2}, .material = RUBBER, .dt = 0.003,                 \
    .steps_share = share                                                                           \
  }
#define RESONANCE(text, which, product, safety)                                                    \
  {                                                                                                \
    COMMON(resonance, text), BEAM, .material = RUBBER, .mode = which, .angle = product,            \
                                   .split_safety = safety                                          \
  }
#define RATE(text, length, E, nu, rho, step)                                                       \
  {                                                                                                \
    COMMON(rate, text), .cells = {8, 2, 2}, .size = {length, 0.1 * length, 0.1 * length},          \
                        MATERIAL(E, nu, rho), .dt = step                                           \
  }

const experiment_extreme experiment_extreme_list[] = {
    STIFFNESS("E = 1e3 Pa", 1e3),
    STIFFNESS("E = 1e6 Pa", 1e6),
    STIFFNESS("E = 1e9 Pa", 1e9),
    STIFFNESS("E = 1e12 Pa", 1e12),
    STIFFNESS("E = 0", 0),

    POISSON("nu = -1", -1),
    POISSON("nu = -0.5", -0.5),
    POISSON("nu = 0", 0),
    POISSON("nu = 0.49", 0.49),
    POISSON("nu = 0.499", 0.499),
    POISSON("nu = 0.5", 0.5),

    SIZE("1 mm", 1e-3),
    SIZE("1 m", 1),
    SIZE("1 km", 1e3),

    DENSITY("1e-3 kg/m3", 1e-3),
    DENSITY("1 kg/m3", 1),
    DENSITY("2e4 kg/m3", 2e4),
    DENSITY("0", 0),

    LOAD("none", 0),
    LOAD("1e-6 times", 1e-6),
    LOAD("1 times", 1),
    LOAD("10 times", 10),
    LOAD("100 times", 100),
    LOAD("1000 times", 1000),

    SNAP("before it snaps", 0.002),
    SNAP("snaps through", 0.1),

    // bodies of few or many coordinates
    TET("three corners held", false, 2, 3),
    TET("as many modes as it can move", false, 3, 3),
    TET("free", true, 5, 6),
    SQUARE("square section", 0.1),
    SQUARE("square section, 1 times", 1),
    RANK("r = 1", 1, 1, 2, 0),
    RANK("r = 100", 20, 100, 3, 20),

    // steps at which a mode turns by an angle that some scheme cannot follow
    RESONANCE("h w1 = 1, the bound of the split", 1, 1, 0),
    RESONANCE("h w6 = 1, the bound of the split", 6, 1, 0),
    RESONANCE("h w1 = 2", 1, 2, 0),
    RESONANCE("h w1 = 3", 1, 3, 0),
    RESONANCE("h w1 = pi", 1, THRUM_PI, 0),
    RESONANCE("h w1 = 2 pi", 1, THRUM_TWO_PI, 0),
    RESONANCE("h w1 = 2, split at the limit", 1, 2, 1),
    RESONANCE("h w6 = 2, split at the limit", 6, 2, 1),

    // rates of haptics and of sound
    RATE("1 kHz, soft tissue", 0.1, 1e4, 0.45, 1000, 1e-3),
    RATE("44.1 kHz, steel bar", 0.3, 2e11, 0.3, 7850, 1.0 / 44100),
};

int64_t experiment_extreme_count(void) {
  return (int64_t)(sizeof experiment_extreme_list / sizeof experiment_extreme_list[0]);
}

const experiment_units experiment_unit_systems[] = {
    {"m, kg, s", 1, 1, 1},          {"mm, kg, ms", 1e-3, 1, 1e-3}, {"mm, t, s", 1e-3, 1e3, 1},
    {"cm, g, s", 1e-2, 1e-3, 1},    {"km, t, h", 1e3, 1e3, 3600},  {"um, ug, us", 1e-6, 1e-9, 1e-6},
    {"Mm, Tg, d", 1e6, 1e9, 86400},
};

int64_t experiment_unit_count(void) {
  return (int64_t)(sizeof experiment_unit_systems / sizeof experiment_unit_systems[0]);
}

const experiment_extreme experiment_unit_extremes[EXPERIMENT_UNIT_EXTREMES] = {
    LOAD("1 times", 1),
    SNAP("snaps through", 0.1),
};
