/* Options that commands and scene files share. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/shared_options.h"

#include <string.h>

#include "config/parse.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_units.h"
#include "runtime/material/material_law.h"
#include "runtime/material/plastic_flow.h"
#include "thrum/thrum.h"

#define X(name, value, text) text,
const char *const integrator_names[] = {THRUM_INTEGRATOR_LIST(X) NULL};
static const char *const damping_forms[] = {THRUM_DAMPING_FORM_LIST(X) NULL};
static const char *const implicit_solvers[] = {THRUM_IMPLICIT_SOLVER_LIST(X) NULL};
static const char *const split_forms[] = {THRUM_SPLIT_FORM_LIST(X) NULL};
const char *const law_names[] = {THRUM_LAW_LIST(X) NULL};
#undef X

thrum_law law_of_run(bool given, thrum_law law, const thrum_model *model) {
  return given ? law : thrum_law_of_model(model);
}

thrum_model model_of_law(const thrum_model *model, thrum_law law) {
  thrum_model made = *model;
  if (law == thrum_law_of_model(model))
    return made;
  const char *name = law == THRUM_LAW_STVK ? NULL : thrum_law_name(law);
  made.point_region = NULL;
  made.region_law = NULL;
  made.region_yield = NULL;
  made.law_count = 0;
  made.point_law = (const thrum_u1 *)name;
  made.law_bytes = name != NULL ? (int64_t)strlen(name) + 1 : 0;
  made.point_count = 0;
  return made;
}

const char *const full_solver_names[] = {"cholesky", "cg", NULL};
const char *const full_quadrature_names[] = {"exact", "four", NULL};

const char *split_option_without_effect(const thrum_state_def *def) {
  const thrum_state_def usual = thrum_default_state_def();
  if (def->integrator == THRUM_INTEGRATOR_IMEXV)
    return NULL;
  if (def->split_form != usual.split_form)
    return "--split-form";
  if (def->split_rule != usual.split_rule)
    return "--split";
  return def->split_safety != usual.split_safety ? "--safety" : NULL;
}

const char *plastic_option_without_yield(const thrum_plastic *plastic, const thrum_model *model) {
  if (!isinf(plastic->yield) || thrum_law_has_yield(model))
    return NULL;
  if (!isinf(plastic->creep))
    return "--creep";
  return isinf(plastic->largest) ? NULL : "--largest-plastic-strain";
}

thrum_status load_option_take(const config_given *given, load_spec *loads, int64_t *count) {
  thrum_error error = {0};
  if (load_spec_parse(given->text, &loads[*count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  ++*count;
  return THRUM_OK;
}

thrum_status frames_option_take(const config_given *given, double *rate, int64_t *every) {
  static const char prefix[] = "every-";
  *rate = 0;
  *every = 0;
  const char *text = given->text != NULL ? given->text : "";
  const bool steps = strncmp(text, prefix, sizeof prefix - 1) == 0;
  if (steps ? config_parse_integer(text + sizeof prefix - 1, every) && *every > 0
            : config_parse_number(text, rate) && *rate > 0)
    return THRUM_OK;
  return config_given_wrong(given);
}

static thrum_status take_damping(const config_given *given, void *record) {
  thrum_state_def *def = record;
  double pair[2] = {0, 0};
  THRUM_TRY(config_given_numbers(given, 1, 2, pair, NULL));
  def->damping_alpha = pair[0];
  def->damping_beta = pair[1];
  return THRUM_OK;
}

static thrum_status take_newmark(const config_given *given, void *record) {
  thrum_state_def *def = record;
  double pair[2];
  THRUM_TRY(config_given_numbers(given, 2, 2, pair, NULL));
  if (pair[1] > 1)
    return config_given_wrong(given);
  def->newmark_beta = pair[0];
  def->newmark_gamma = pair[1];
  return THRUM_OK;
}

static thrum_status take_split(const config_given *given, void *record) {
  thrum_state_def *def = record;
  const char *text = given->text != NULL ? given->text : "";
  double count = 0;

  // a word is a rule; a number is the count of explicit modes
  if (strcmp(text, "cfl") == 0) {
    def->split_rule = THRUM_SPLIT_CFL;
  } else if (strcmp(text, "sampling") == 0) {
    def->split_rule = THRUM_SPLIT_SAMPLING;
  } else if (config_parse_number(text, &count) && count >= 0 && count <= THRUM_RANK_MAX &&
             count == floor(count)) {
    def->split_rule = THRUM_SPLIT_COUNT;
    def->explicit_count = (int32_t)count;
  } else {
    return config_given_wrong(given);
  }
  return THRUM_OK;
}

thrum_status order_option_take(const config_given *given, int *order) {
  double number = 0;
  const char *text = given->text != NULL ? given->text : "";
  if (strcmp(text, "auto") == 0)
    *order = THRUM_ORDER_AUTO;
  else if (config_parse_number(text, &number) && (number == 1 || number == 2))
    *order = (int)number;
  else
    return config_given_wrong(given);
  return THRUM_OK;
}

static thrum_status take_order(const config_given *given, void *record) {
  return order_option_take(given, &((thrum_mesh_read_options *)record)->order);
}

const char *const element_names[] = {"auto", "tet", "solid", "shell", NULL};

#define AT(member) CONFIG_AT(thrum_mesh_read_options, member)

static thrum_status check_unit(const char *text, thrum_error *error) {
  thrum_mesh_unit unit;
  return thrum_mesh_unit_read(text, &unit, error);
}

const config_option mesh_read_rows[] = {
    OPTION_NUMBER("scale", NULL, "1", "lengths of the mesh times this are metres, such as 1e-3",
                  AT(scale), CONFIG_ABOVE(0)),
    OPTION_TEXT("unit", "UNIT", "m-kg-s",
                "of the lengths and materials in the file, LENGTH-MASS-TIME: mm-t-s has "
                "millimetres, MPa and t/mm^3",
                AT(unit), .check = check_unit),
    OPTION_TEXT("regions", "NAME", "known names, such as region, MaterialIds, mat_id",
                ".vtk, .vtu: the cell data of whole numbers that tells regions", AT(regions)),
    OPTION_WORD("order", "ORDER", "auto",
                "of the tetrahedra: 2, ten nodes, with nodes in the middle of the edges of a "
                "linear mesh; 1, four nodes, ten-node tetrahedra by their corners; auto, as the "
                "mesh has them, but for a model ten nodes where linear ones would be more than "
                "1 % too stiff, and memory and time allow",
                .take = take_order, ORDER_FORM),
    OPTION_CHOICE(
        "element", element_names, "auto",
        "hexahedra and wedges stay what they are, thin ones as solid-shells, but wedges of six "
        "nodes are divided or cut; solid: none "
        "is a solid-shell; shell: all of order 1 are; tet: they are cut into tetrahedra",
        AT(element)),
    OPTION_END,
};

#undef AT
#define AT(member) CONFIG_AT(thrum_material, member)
#define PAIR_SCHEMA                                                                                \
  "{\"type\":\"array\",\"items\":{\"type\":\"number\"},\"minItems\":2,\"maxItems\":2}"

const config_option material_options[] = {
    OPTION_NUMBER("young", "Pa", "the mesh's own", "Young's modulus", AT(young),
                  CONFIG_RANGE(1e-30, 1e30)),
    OPTION_NUMBER("poisson", NULL, "the mesh's own", "Poisson's ratio", AT(poisson),
                  CONFIG_RANGE(-1, 0.5), .above = true, .below = true),
    OPTION_NUMBER("density", "kg/m^3", "the mesh's own", "density", AT(density),
                  CONFIG_RANGE(1e-30, 1e30)),
    OPTION_END,
};

#undef AT
#define AT(member) CONFIG_AT(thrum_plastic, member)

const config_option plastic_options[] = {
    OPTION_NUMBER("yield", NULL, "never",
                  "elastic strain beyond which the material flows and stays deformed: the norm of "
                  "the principal strains without their mean",
                  AT(yield), CONFIG_ABOVE(0)),
    OPTION_NUMBER("creep", "1/s", "at once",
                  "rate at which the strain beyond the yield flows, in regions with a yield of "
                  "their own too; a tenth is left after 2.3/RATE seconds",
                  AT(creep), CONFIG_ABOVE(0)),
    OPTION_NUMBER("largest-plastic-strain", NULL, "no bound",
                  "norm of the logarithms of the plastic stretches beyond which nothing flows, of "
                  "such regions too",
                  AT(largest), CONFIG_ABOVE(0)),
    OPTION_END,
};

#undef AT
#define AT(member) CONFIG_AT(thrum_state_def, member)

const config_option solver_options[] = {
    OPTION_INTEGRATOR(thrum_state_def, integrator),
    OPTION_DAMPING(.take = take_damping),
    OPTION_CHOICE("damping-form", damping_forms, "rest",
                  "whether B damps by the stiffness at rest or by the present one",
                  AT(damping_form)),

    // what only imexv has
    OPTION_WORD("split", "RULE", "cfl",
                "imexv: cfl, explicit where dt omega <= 2 c; sampling, where dt f < 1; or the "
                "number of explicit modes, the lowest",
                .take = take_split, .wants = "cfl, sampling or the number of explicit modes",
                .schema = "{\"anyOf\":[{\"enum\":[\"cfl\",\"sampling\"]},{\"type\":\"integer\","
                          "\"minimum\":0}]}"),
    OPTION_NUMBER("safety", NULL, "0.5", "imexv: c of cfl", AT(split_safety), CONFIG_RANGE(0, 1),
                  .above = true),
    OPTION_CHOICE("split-form", split_forms, "position",
                  "how imexv splits the energy; position is symplectic; quadratic needs no "
                  "iterations, for small steps or amplitudes",
                  AT(split_form)),
    OPTION_SWITCH(
        "adaptive", "on",
        "imexv, fox-goodwin: monitor stability and energy, and adapt to them or switch to "
        "energy",
        AT(adaptive)),

    // what happens where a step cannot be solved
    OPTION_SWITCH("fallback", "on",
                  "imexv, newmark, energy, fox-goodwin: when a step cannot be solved, take one "
                  "that conserves "
                  "energy, then shorter ones; off: the run ends",
                  AT(fallback)),

    OPTION_SWITCH(
        "untrained-flow", "off",
        "energy: step plastic flow at cubature points that were not trained on it, though "
        "strain and work of what flows may be several times too small; off: refuse it",
        AT(untrained_flow)),

    // what only energy and newmark have
    OPTION_SWITCH("frequency-matching", "on",
                  "energy: turn modes with dt omega <= 1 at their own frequency; off: by the "
                  "trapezoidal rule, which is late by (dt omega)^2/12",
                  AT(frequency_matched)),
    OPTION_PAIR("newmark", "0.25,0.5", "newmark: beta and gamma", .value = "BETA,GAMMA",
                .take = take_newmark, CONFIG_FROM(0), .schema = PAIR_SCHEMA,
                .wants = "BETA and GAMMA, BETA >= 0 and GAMMA in [0, 1]"),

    // the implicit solve
    OPTION_CHOICE("solver", implicit_solvers, "quasi-newton",
                  "of implicit steps; newton makes a Jacobian in each iteration and costs more",
                  AT(solver)),
    OPTION_NUMBER("tolerance", NULL, "0",
                  "of implicit solves, relative; 0 is the integrator's own: 1e-5 for energy, which "
                  "keeps the energy at any tolerance, 1e-6 for manifold and 1e-10 for the others, "
                  "which do not",
                  AT(tolerance), CONFIG_RANGE(0, 0.01)),
    OPTION_COUNT("iterations", "50", "of one implicit solve, at most", AT(iterations_max),
                 CONFIG_RANGE(1, 1e6)),
    OPTION_END,
};

/* A number and one of these endings, which scale it; no ending is the first's where that is empty.
 */
static bool scaled(const char *text, const char *const *endings, const double *scales,
                   double *value) {
  // the longest ending that fits cuts the text
  const size_t length = strlen(text);
  char number[64];
  double scale = endings[0][0] == 0 ? scales[0] : 0.0;
  size_t cut = length;
  for (int n = 0; endings[n] != NULL; n++) {
    const size_t size = strlen(endings[n]);
    if (size < length && strcmp(text + length - size, endings[n]) == 0 && length - size < cut) {
      cut = length - size;
      scale = scales[n];
    }
  }

  // the number before it, which must be positive
  if (cut >= sizeof number || !(scale > 0))
    return false;
  memcpy(number, text, cut);
  number[cut] = 0;
  double parsed;
  if (!config_parse_number(number, &parsed) || !(parsed > 0))
    return false;
  *value = scale * parsed;
  return true;
}

thrum_status scaled_option_take(const config_given *given, const char *const *endings,
                                const double *scales, double *value) {
  // what is no text in a file has none
  return given->text != NULL && scaled(given->text, endings, scales, value)
             ? THRUM_OK
             : config_given_wrong(given);
}

thrum_status error_option_take(const config_given *given, double *error) {
  static const char *const endings[] = {"", "%", NULL};
  static const double scales[] = {1, 0.01};
  double share = 0;
  if (scaled_option_take(given, endings, scales, &share) < 0 || share > 1)
    return config_given_wrong(given);
  *error = share;
  return THRUM_OK;
}
