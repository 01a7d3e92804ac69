/* What an FMU tells of itself, by the schemas of the standard (https://fmi-standard.org, 2.0.4 and
 * 3.0.1). Variables stand in the order of their value references (driver/export/fmu/fmu_body.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/fmu_description.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/number_text.h"
#include "thrum/version.h"

/* What is said of a variable. */
typedef struct fmu_row {
  char name[600], about[200];
  const char *unit, *causality, *variability;
  const char *initial; /* NULL: none is said */
  double start;        /* where it has one */
  bool has_start;
  const char *least; /* NULL: any value will do */
  int rate_of;       /* the state whose derivative it is; -1: none */
} fmu_row;

static void put_escaped(FILE *out, const char *text) {
  for (; *text; text++) {
    const char *const entity = *text == '&'   ? "&amp;"
                               : *text == '<' ? "&lt;"
                               : *text == '>' ? "&gt;"
                               : *text == '"' ? "&quot;"
                                              : NULL;
    if (entity)
      fputs(entity, out);
    else
      fputc(*text, out);
  }
}

static void put_text(FILE *out, const char *name, const char *text) {
  if (text == NULL)
    return;
  fprintf(out, " %s=\"", name);
  put_escaped(out, text);
  fputc('"', out);
}

static void put_number(FILE *out, const char *name, double value) {
  char text[THRUM_NUMBER_TEXT];
  thrum_number_text(value, text);
  fprintf(out, " %s=\"%s\"", name, text);
}

/* --- the variables --------------------------------------------------------------------------- */

static fmu_row parameter(const char *name, const char *about, const char *unit, double start,
                         const char *variability, const char *least) {
  fmu_row row = {.unit = unit,
                 .causality = "parameter",
                 .variability = variability,
                 .initial = "exact",
                 .start = start,
                 .has_start = true,
                 .least = least,
                 .rate_of = -1};
  snprintf(row.name, sizeof row.name, "%s", name);
  snprintf(row.about, sizeof row.about, "%s", about);
  return row;
}

/* One of three components of a place, or of the ground where `place` is NULL. */
static fmu_row component(const char *place, const char *what, int axis, const char *about,
                         const char *unit, bool input) {
  fmu_row row = {.unit = unit,
                 .causality = input ? "input" : "output",
                 .variability = "continuous",
                 .initial = input ? NULL : "calculated",
                 .has_start = input,
                 .rate_of = -1};
  snprintf(row.name, sizeof row.name, "%s%s%s.%c", place ? place : "", place ? "." : "", what,
           'x' + axis);
  snprintf(row.about, sizeof row.about, "%s", about);
  return row;
}

static fmu_row coordinate(const char *name, int i, const char *about, const char *unit,
                          int rate_of) {
  fmu_row row = {.unit = unit,
                 .causality = "local",
                 .variability = "continuous",
                 .initial = rate_of < 0 ? "exact" : "calculated",
                 .has_start = rate_of < 0,
                 .rate_of = rate_of};
  snprintf(row.name, sizeof row.name, rate_of < 0 ? "%s[%d]" : "der(%s[%d])", name, i + 1);
  snprintf(row.about, sizeof row.about, "%s", about);
  return row;
}

/* Those that are no coordinate and at no place. */
static fmu_row single_row(const fmu_description *of, int reference) {
  switch (reference) {
  case FMU_TIME: {
    fmu_row row = parameter("time", "time", "s", 0, "continuous", NULL);
    row.causality = "independent";
    row.initial = NULL;
    row.has_start = false;
    return row;
  }
  case FMU_ALPHA:
    return parameter("damping.alpha", "damping in proportion to the mass", "1/s", of->start[0],
                     "tunable", "0");
  case FMU_BETA:
    return parameter("damping.beta", "damping in proportion to the stiffness", "s", of->start[1],
                     "tunable", "0");
  case FMU_STIFFNESS:
    return parameter("stiffness", "factor of Young's modulus, above 0", "1", of->start[2],
                     "tunable", "0");
  case FMU_STEP:
    return parameter("step", "longest step of the integrator inside, above 0", "s", of->start[3],
                     "fixed", "0");
  default:
    return component(NULL, "acceleration", reference - FMU_ACCELERATION,
                     "acceleration of the ground, in whose frame all displacements are; z = 9.81 "
                     "is gravity along -z",
                     "m/s2", true);
  }
}

static fmu_row row_of(const fmu_description *of, int reference) {
  const int n = of->head->rank, places = of->head->places;
  const int q = fmu_q(places), p = fmu_p(n, places), u = fmu_displacements(n, places);
  const int v = fmu_velocities(n, places), energies = fmu_energies(n, places);
  const int rates = fmu_rates(n, places);
  if (reference < FMU_FORCES)
    return single_row(of, reference);
  if (reference < q)
    return component(of->places[(reference - FMU_FORCES) / 3], "force",
                     (reference - FMU_FORCES) % 3, "force, which the vertices share evenly", "N",
                     true);
  if (reference < p)
    return coordinate("q", reference - q, "reduced coordinate", "m.kg(1/2)", -1);
  if (reference < u)
    return coordinate("p", reference - p, "its derivative by time", "m.kg(1/2)/s", -1);
  if (reference < v)
    return component(of->places[(reference - u) / 3], "displacement", (reference - u) % 3,
                     "mean displacement of the vertices", "m", false);
  if (reference < energies)
    return component(of->places[(reference - v) / 3], "velocity", (reference - v) % 3,
                     "mean velocity of the vertices", "m/s", false);
  if (reference < rates) {
    fmu_row row = component("energy", "strain", 0, "strain energy", "J", false);
    snprintf(row.name, sizeof row.name, "energy.%s", reference == energies ? "strain" : "kinetic");
    snprintf(row.about, sizeof row.about, "%s energy",
             reference == energies ? "strain" : "kinetic");
    return row;
  }
  if (reference < rates + n)
    return coordinate("q", reference - rates, "derivative of q", "m.kg(1/2)/s",
                      reference - rates + q);
  return coordinate("p", reference - rates - n, "derivative of p", "m.kg(1/2)/s2",
                    reference - rates + q);
}

static void put_variable(FILE *out, const fmu_description *of, int reference) {
  const fmu_row row = row_of(of, reference);
  const bool two = of->version == 2;
  fprintf(out, "    <%s", two ? "ScalarVariable" : "Float64");
  put_text(out, "name", row.name);
  fprintf(out, " valueReference=\"%d\"", reference);
  put_text(out, "description", row.about);
  put_text(out, "causality", row.causality);
  put_text(out, "variability", row.variability);
  put_text(out, "initial", row.initial);
  if (two)
    fputs("><Real", out);
  put_text(out, "unit", row.unit);
  put_text(out, "min", row.least);
  if (row.has_start)
    put_number(out, "start", row.start);

  // 2.0 counts variables from 1
  if (row.rate_of >= 0)
    fprintf(out, " derivative=\"%d\"", row.rate_of + two);
  fputs(two ? "/></ScalarVariable>\n" : "/>\n", out);
}

/* --- the structure --------------------------------------------------------------------------- */

/* Variables `first` to `end` as what another one depends on. */
static void put_dependencies(FILE *out, const fmu_description *of, int first, int end, int also) {
  const int from_one = of->version == 2;
  fputs(" dependencies=\"", out);
  if (also >= 0)
    fprintf(out, "%d ", also + from_one);
  for (int n = first; n < end; n++)
    fprintf(out, "%s%d", n > first ? " " : "", n + from_one);
  fputs("\"/>\n", out);
}

/* An unknown, which depends on q or p alone, or on all. `starts`: it is one of the start. */
static void put_unknown(FILE *out, const fmu_description *of, const char *element, int reference,
                        bool starts) {
  const int n = of->head->rank, places = of->head->places;
  const int q = fmu_q(places), p = fmu_p(n, places), energies = fmu_energies(n, places);
  const int rates = fmu_rates(n, places);
  fprintf(out, "      <%s %s=\"%d\"", element, of->version == 2 ? "index" : "valueReference",
          reference + (of->version == 2));
  if (reference < fmu_velocities(n, places))
    put_dependencies(out, of, q, p, -1);
  else if (reference == energies)
    put_dependencies(out, of, q, p, starts ? FMU_STIFFNESS : -1);
  else if (reference < rates)
    put_dependencies(out, of, p, p + n, -1);
  else if (reference < rates + n)
    put_dependencies(out, of, p + reference - rates, p + reference - rates + 1, -1);
  else
    fputs("/>\n", out);
}

static void put_structure(FILE *out, const fmu_description *of) {
  const int n = of->head->rank, places = of->head->places;
  const int first = fmu_displacements(n, places), rates = fmu_rates(n, places);
  const int all = fmu_variables(n, places);
  const bool two = of->version == 2;
  const char *const output = two ? "Unknown" : "Output";
  const char *const rate = two ? "Unknown" : "ContinuousStateDerivative";
  const char *const initial = two ? "Unknown" : "InitialUnknown";
  fputs(two ? "  <ModelStructure>\n    <Outputs>\n" : "  <ModelStructure>\n", out);
  for (int v = first; v < rates; v++)
    put_unknown(out, of, output, v, false);
  fputs(two ? "    </Outputs>\n    <Derivatives>\n" : "", out);
  for (int v = rates; v < all; v++)
    put_unknown(out, of, rate, v, false);
  fputs(two ? "    </Derivatives>\n    <InitialUnknowns>\n" : "", out);
  for (int v = first; v < all; v++)
    put_unknown(out, of, initial, v, true);
  fputs(two ? "    </InitialUnknowns>\n  </ModelStructure>\n" : "  </ModelStructure>\n", out);
}

/* --- the whole ------------------------------------------------------------------------------- */

static void put_kinds(FILE *out, const fmu_description *of) {
  static const char *const kinds[] = {"ModelExchange", "CoSimulation"};
  for (int k = 0; k < 2; k++) {
    fprintf(out, "  <%s modelIdentifier=\"%s\"", kinds[k], of->name);
    if (of->version == 3) {
      fputs(" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\""
            " providesDirectionalDerivatives=\"true\" providesAdjointDerivatives=\"true\"",
            out);
      fputs(k == 0 ? " needsCompletedIntegratorStep=\"false\"/>\n"
                   : " canHandleVariableCommunicationStepSize=\"true\"/>\n",
            out);
      continue;
    }
    fputs(" canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\""
          " canSerializeFMUstate=\"true\" providesDirectionalDerivative=\"true\"",
          out);
    fputs(k == 0 ? " completedIntegratorStepNotNeeded=\"true\">\n"
                 : " canHandleVariableCommunicationStepSize=\"true\">\n",
          out);
    fputs("    <SourceFiles>\n", out);
    for (int n = 0; n < of->source_count; n++)
      fprintf(out, "      <File name=\"%s\"/>\n", of->sources[n]);
    fprintf(out, "    </SourceFiles>\n  </%s>\n", kinds[k]);
  }
}

/* The units, as powers of those of the SI; m.kg(1/2) has no whole power of kg and is only named. */
static void put_units(FILE *out) {
  static const struct {
    const char *name, *powers;
  } units[] = {{"s", "s=\"1\""},
               {"1/s", "s=\"-1\""},
               {"1", ""},
               {"m", "m=\"1\""},
               {"m/s", "m=\"1\" s=\"-1\""},
               {"m/s2", "m=\"1\" s=\"-2\""},
               {"N", "kg=\"1\" m=\"1\" s=\"-2\""},
               {"J", "kg=\"1\" m=\"2\" s=\"-2\""},
               {"m.kg(1/2)", NULL},
               {"m.kg(1/2)/s", NULL},
               {"m.kg(1/2)/s2", NULL}};
  fputs("  <UnitDefinitions>\n", out);
  for (size_t n = 0; n < sizeof units / sizeof *units; n++) {
    if (units[n].powers)
      fprintf(out, "    <Unit name=\"%s\"><BaseUnit%s%s/></Unit>\n", units[n].name,
              *units[n].powers ? " " : "", units[n].powers);
    else
      fprintf(out, "    <Unit name=\"%s\"/>\n", units[n].name);
  }
  fputs("  </UnitDefinitions>\n"
        "  <LogCategories>\n"
        "    <Category name=\"logStatusError\" description=\"calls that are refused\"/>\n"
        "    <Category name=\"logStatusDiscard\" description=\"values and steps that are not "
        "taken\"/>\n"
        "  </LogCategories>\n",
        out);
}

thrum_status fmu_text(made_text_put *put, const void *of, char **text, size_t *size,
                      thrum_error *error) {
  *text = made_text(put, of, size);
  return *text != NULL
             ? THRUM_OK
             : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a text of the FMU");
}

static void put_model(FILE *out, const void *description) {
  const fmu_description *of = description;
  const bool two = of->version == 2;
  fprintf(
      out,
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<fmiModelDescription fmiVersion=\"%s\" modelName=\"%s\" %s=\"%s\"\n"
      "  description=\"A deformable body of %d coordinates with its St. Venant-Kirchhoff energy, "
      "SI units\"\n  generationTool=\"Thrum %s\" variableNamingConvention=\"flat\"%s>\n",
      two ? "2.0" : "3.0", of->name, two ? "guid" : "instantiationToken", of->head->token,
      (int)of->head->rank, THRUM_VERSION_STRING, two ? " numberOfEventIndicators=\"0\"" : "");
  put_kinds(out, of);
  put_units(out);
  fputs("  <DefaultExperiment", out);
  put_number(out, "startTime", 0);
  put_number(out, "stopTime", of->stop);
  put_number(out, "stepSize", of->start[3]);
  fputs("/>\n  <ModelVariables>\n", out);
  const int all = fmu_variables(of->head->rank, of->head->places);
  for (int v = 0; v < all; v++)
    put_variable(out, of, v);
  fputs("  </ModelVariables>\n", out);
  put_structure(out, of);
  fputs("</fmiModelDescription>\n", out);
}

static void put_build(FILE *out, const void *description) {
  const fmu_description *of = description;
  fprintf(out,
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
          "<fmiBuildDescription fmiVersion=\"3.0\">\n"
          "  <BuildConfiguration modelIdentifier=\"%s\">\n    <SourceFileSet language=\"C11\">\n",
          of->name);
  for (int n = 0; n < of->source_count; n++)
    fprintf(out, "      <SourceFile name=\"%s\"/>\n", of->sources[n]);
  fputs("    </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n", out);
}

thrum_status fmu_model_description(const fmu_description *of, char **text, size_t *size,
                                   thrum_error *error) {
  return fmu_text(put_model, of, text, size, error);
}

thrum_status fmu_build_description(const fmu_description *of, char **text, size_t *size,
                                   thrum_error *error) {
  return fmu_text(put_build, of, text, size, error);
}
