/* `thrum info`: what a model file holds. Sizes, frequencies and the split come from the arrays and
 * the runtime; linear frequencies and residuals from meta, which only precompute writes, so a model
 * made by hand has none. SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/cmd.h"
#include "app/info_run.h"
#include "app/info_surface.h"
#include "config/message.h"
#include "config/options.h"
#include "core/base/vec3.h"
#include "driver/make/model_coordinates.h"
#include "driver/make/named_model.h"
#include "driver/make/precompute_touch.h"
#include "driver/model/frequency_gradient.h"
#include "driver/model/locking.h"
#include "driver/model/model_cut.h"
#include "driver/model/model_meta.h"
#include "driver/model/shape_gradient.h"
#include "driver/model/split_at.h"
#include "driver/record/run_read.h"
#include "driver/spec/elastic_report.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/npy_file.h"
#include "io/report.h"
#include "mesh/model_quality.h"
#include "mesh/solids.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/model/load_share.h"
#include "precompute/model/model_fem.h"

#define NAMES_SHOWN 8
#define LOADS_MAX 16
#define FREQUENCIES_A_LINE 6

typedef struct info {
  const char *path;
  const thrum_model *model;
  const thrum_model *steps; /* that is stepped: another where the file is condensed */
  void *steps_memory;       /* of that */
  bool has_mesh;
  thrum_quality quality;
  cJSON *meta;         /* NULL when the model has none or it is no JSON object */
  thrum_state_def def; /* whose steps are meant */
  bool steps_named;    /* by --dt or --integrator */
  bool touch_asked, gradient_asked;
  frequency_gradient gradient; /* where it was asked for */
  const char *shape_gradient;  /* the file; NULL: not asked for */
  split_counts split;
  thrum_stepped_mode *stepped; /* rank */
  double file_bytes;
  double *hertz;          /* rank */
  const load_spec *loads; /* load_count */
  thrum_load_share *shares;
  int64_t load_count;
  touch_outcome touch; /* of the model as it is, where it was measured */
  double began;        /* clock_seconds() */
  double read;         /* the same, once the model was loaded */
} info;

typedef struct info_request {
  const char *path;
  double dt;                   /* 0: not given */
  thrum_integrator integrator; /* -1: not given */
  load_spec loads[LOADS_MAX];
  int64_t load_count;
  bool touch, gradient;
  const char *shape_gradient;
  bool json;
} info_request;

static thrum_status take_load(const config_given *given, void *request) {
  info_request *r = request;
  if (r->load_count == LOADS_MAX)
    return config_given_refuse(given, "at most %d loads at a time", LOADS_MAX);
  return load_option_take(given, r->loads, &r->load_count);
}

static const config_option options[] = {
    OPTION_NUMBER("dt", "s", "0.003",
                  "time step of the split, and of a table of the frequencies as they are stepped",
                  CONFIG_AT(info_request, dt), CONFIG_ABOVE(0)),
    OPTION_INTEGRATOR(info_request, integrator),

    // how much of a load or of a pull the basis shows
    OPTION_LOAD(take_load, NULL,
                "what of a load, as thrum simulate --load takes it, the basis does not show: of "
                "the static answer (energy norm) and of the load itself (outside span(M U), mass "
                "norm)"),
    OPTION_FLAG("touch",
                "measure by how much of what the mesh gives (linear) the model follows pulls all "
                "over its surface; a model of thrum precompute --touch says it unasked",
                CONFIG_AT(info_request, touch)),
    OPTION_FLAG("gradient",
                "by how much the frequencies of the linear modes change with Young's modulus, "
                "Poisson's ratio and density of each region, in the whole mesh",
                CONFIG_AT(info_request, gradient)),
    OPTION_TEXT(
        "shape-gradient", "FILE.npy", NULL,
        "write the same by the place of each vertex, a row a mode: x, y, z of each vertex [1/m]",
        .path = CONFIG_PATH_ALWAYS, CONFIG_AT(info_request, shape_gradient)),

    OPTION_JSON(info_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_info = {
    .name = "info",
    .summary = "say what a model file or a run holds",
    .usage = "MODEL|RUN|SURFACE [OPTIONS]",
    .about =
        "Says what a model file holds: sizes, mass, volume, element quality, bounding box, "
        "frequencies, the split into explicit and implicit modes, residuals, memory, groups; with "
        "--dt or --integrator also the frequency of each mode as it is stepped. Of a surface that "
        "thrum embed wrote it says what that holds, and of the folder of a run what was stepped, "
        "with which options, how long, how it ended, and what plays it or what is missing for "
        "that. What is named and is not there, holds no run or is damaged is refused (1).\n\n"
        "MODEL is a model file or a name (beam, basket, bridge, horse, tower, heart) of a model "
        "that is precomputed once and cached, RUN the folder of a run, and SURFACE a file that "
        "thrum embed wrote. All options but --json go with a model.",
    .options = options,
    .examples = "info beam.npz\n"
                "info horse\n"
                "info beam.npz --load 'constant:0,0,-1@tip'\n"
                "info horse --touch\n"
                "info beam.npz --gradient --shape-gradient shape.npy\n"
                "info horse --dt 0.003 --integrator energy\n"
                "info beam.npz --dt 0.001 --json\n"
                "info run\n"
                "info shown.npz",
};

/* Kinds of actuators, and what they measure at rest. */
static const struct {
  const char *kind, *unit;
} actuator_words[] = {{"pressure", "m^3"}, {"strain", ""}, {"tendon", "m"}, {"gas", "m^3"}};

static double meta_number(const info *about, const char *object, const char *key) {
  const cJSON *item = model_meta_find(about->meta, object, key);
  return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static bool is_single(const info *about) {
  const cJSON *item = model_meta_find(about->meta, "options", "precision");
  return cJSON_IsString(item) && strcmp(item->valuestring, "single") == 0;
}

/* Largest residual of the linear modes; NaN when meta has none. */
static double meta_worst_residual(const info *about) {
  const cJSON *item = NULL;
  double worst = NAN;
  cJSON_ArrayForEach(item, model_meta_find(about->meta, "residuals", "modes")) {
    if (cJSON_IsNumber(item))
      worst = fmax(worst, item->valuedouble);
  }
  return worst;
}

static void add_frequencies(cJSON *object, const info *about) {
  cJSON *array = cJSON_AddArrayToObject(object, "frequencies_hz");
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, model_meta_find(about->meta, NULL, "frequencies_hz")) {
    if (cJSON_IsNumber(item))
      cJSON_AddItemToArray(array, json_number_item(item->valuedouble));
  }
  json_number(object, "modes", cJSON_GetArraySize(array));
  json_numbers(object, "basis_frequencies_hz", about->hertz, about->model->rank);
  const cJSON *coordinates = model_meta_find(about->meta, NULL, "coordinates");
  if (cJSON_GetArraySize(coordinates) == about->model->rank)
    cJSON_AddItemToObject(object, "coordinates", cJSON_Duplicate(coordinates, true));
}

/* The frequencies as they are stepped, null where a mode does not vibrate. */
static void add_stepped(cJSON *object, const info *about) {
  json_string(object, "integrator", thrum_integrator_name(about->def.integrator));
  cJSON *hertz = cJSON_AddArrayToObject(object, "stepped_frequencies_hz");
  cJSON *factors = cJSON_AddArrayToObject(object, "stepped_amplitude_factors");
  for (int64_t i = 0; i < about->steps->rank; i++) {
    cJSON_AddItemToArray(hertz, json_number_item(about->stepped[i].stepped_hertz));
    cJSON_AddItemToArray(factors, json_number_item(about->stepped[i].factor));
  }
}

/* Adds the name of a region; null where it has none. */
static void add_region(cJSON *row, const info *about, int64_t region) {
  json_number(row, "region", (double)region + 1);
  json_string(row, "name", model_meta_region(about->meta, region));
}

/* Adds what each region is made of. */
static void add_materials(cJSON *object, const info *about) {
  cJSON *materials = cJSON_AddArrayToObject(object, "materials");
  for (int64_t m = 0; m < about->model->region_count; m++) {
    const double *values = about->model->material + 3 * m;
    cJSON *material = json_add_row(materials);
    add_region(material, about, m);
    json_number(material, "young_pa", values[0]);
    json_number(material, "poisson", values[1]);
    json_number(material, "density_kg_m3", values[2]);
    elastic_json(material, about->model->elastic, about->model->elastic_count, m);
  }
}

/* How many vertices are on springs to the ground, and how stiff they are together. */
static void add_springs(cJSON *object, const thrum_model *model) {
  double sum[3] = {0, 0, 0}, count = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *k = model->springs + 3 * v;
    count += k[0] + k[1] + k[2] > 0;
    for (int axis = 0; axis < 3; axis++)
      sum[axis] += k[axis];
  }
  json_number(object, "spring_vertices", count);
  json_numbers(object, "spring_stiffness_n_per_m", sum, 3);
}

/* The largest displacement of the state about which a model is. */
static double state_size(const thrum_model *model) {
  double most = 0;
  for (int64_t v = 0; v < model->vertex_count; v++)
    most = fmax(most, thrum_dot3(model->about + 3 * v, model->about + 3 * v));
  return sqrt(most);
}

static void add_mesh(cJSON *object, const info *about) {
  const thrum_quality *quality = &about->quality;
  const double missing = NAN;
  json_number(object, "vertices", (double)about->model->vertex_count);
  json_number(object, "tets", (double)about->model->tet_count);
  if (about->model->solid_count > 0)
    cJSON_AddStringToObject(
        object, "solids",
        thrum_solid_count_words(about->model->solid_form, about->model->solid_count).text);
  locking_json(object, about->model);
  if (about->model->about)
    json_number(object, "about_m", state_size(about->model));

  // counts, then what only a mesh has; null without one
  json_number(object, "regions", (double)about->model->region_count);
  add_materials(object, about);
  if (about->model->springs != NULL)
    add_springs(object, about->model);
  json_number(object, "fixed", about->has_mesh ? (double)quality->fixed_count : missing);
  json_number(object, "mass_kg", about->has_mesh ? quality->mass : missing);
  json_number(object, "volume_m3", about->has_mesh ? quality->volume : missing);
  json_number(object, "quality_min", about->has_mesh ? quality->ratio_min : missing);
  json_number(object, "quality_mean", about->has_mesh ? quality->ratio_mean : missing);

  // 1-based, as in the mesh file
  json_number(object, "worst_tet", about->has_mesh ? (double)quality->worst_tet + 1 : missing);
  json_numbers(object, "box_min_m", quality->box_min, about->has_mesh ? 3 : 0);
  json_numbers(object, "box_max_m", quality->box_max, about->has_mesh ? 3 : 0);
}

static void add_groups(cJSON *object, const thrum_model *model) {
  cJSON *groups = cJSON_AddArrayToObject(object, "groups");
  for (int64_t g = 0; g < model->group_count; g++) {
    cJSON *group = json_add_row(groups);
    const int32_t begin = g > 0 ? model->group_ends[g - 1] : 0;
    json_string(group, "name", thrum_model_group_name(model, g));
    json_number(group, "vertices", model->group_ends[g] - begin);
  }
}

/* Adds the laws and yields of the regions, where they have their own. */
static void add_laws(cJSON *object, const info *about) {
  const thrum_model *model = about->model;
  if (model->law_count == 0)
    return;
  cJSON *laws = cJSON_AddArrayToObject(object, "region_laws");
  for (int64_t m = 0; m < model->law_count; m++) {
    cJSON *law = json_add_row(laws);
    add_region(law, about, m);
    cJSON_AddStringToObject(law, "law", thrum_law_name(thrum_law_of_region(model, m)));
    json_number(law, "yield", thrum_law_yield(model, m, INFINITY));
  }
}

/* Relative changes, a row for each mode, with a number for each region. */
static void add_gradient(cJSON *object, const info *about) {
  const frequency_gradient *g = &about->gradient;
  if (!about->gradient_asked)
    return;
  cJSON *list = cJSON_AddArrayToObject(object, "frequency_gradient");
  for (int64_t i = 0; i < g->modes; i++) {
    cJSON *row = json_add_row(list);
    json_number(row, "mode", (double)i + 1);
    json_number(row, "frequency_hz", about->hertz[i]);
    json_numbers(row, "young", g->young + i * g->regions, g->regions);
    json_numbers(row, "poisson", g->poisson + i * g->regions, g->regions);
    json_numbers(row, "density", g->density + i * g->regions, g->regions);
  }
}

/* Adds what the cubature points were trained on, null where the file does not say it. */
static void add_training(cJSON *object, const thrum_model *model) {
  const double *training = model->point_training;
  if (model->point_count == 0)
    return;
  if (!training) {
    cJSON_AddNullToObject(object, "trained_on");
    return;
  }
  cJSON *on = cJSON_AddObjectToObject(object, "trained_on");
  const double yield = training[THRUM_TRAINING_YIELD];
  json_number(on, "strain", training[THRUM_TRAINING_STRAIN]);
  json_number(on, "yield", yield > 0 ? yield : NAN);
  json_number(on, "plastic_strain", training[THRUM_TRAINING_PLASTIC]);
  cJSON_AddBoolToObject(on, "learned", training[THRUM_TRAINING_LEARNED] > 0);
}

static cJSON *make_report(const info *about) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "model", about->path);
  json_number(object, "format_major", about->model->format[0]);
  json_number(object, "format_minor", about->model->format[1]);
  json_number(object, "rank", (double)about->model->rank);
  json_number(object, "masters", (double)about->steps->rank);
  json_number(object, "cubic_coefficients", (double)about->steps->c3_count);
  json_number(object, "quartic_coefficients", (double)about->steps->c4_count);
  if (about->model->point_count > 0)
    json_number(object, "cubature_points", (double)about->model->point_count);
  add_training(object, about->model);
  if (thrum_law_of_model(about->model) != THRUM_LAW_STVK)
    cJSON_AddStringToObject(object, "law", thrum_law_name(thrum_law_of_model(about->model)));
  add_laws(object, about);

  add_mesh(object, about);
  add_frequencies(object, about);
  json_number(object, "rigid_modes", about->model->rigid != NULL ? 6 : 0);
  json_number(object, "dt", about->def.dt);
  json_number(object, "explicit_modes", (double)about->split.explicit_modes);
  json_number(object, "implicit_modes", (double)about->split.implicit_modes);
  add_stepped(object, about);
  add_gradient(object, about);

  // the metadata of the precompute, where the file has it
  cJSON *residuals = cJSON_AddObjectToObject(object, "residuals");
  json_number(residuals, "modes_max", meta_worst_residual(about));
  json_number(residuals, "orthonormality", meta_number(about, "residuals", "orthonormality"));
  json_number(residuals, "diagonality", meta_number(about, "residuals", "diagonality"));
  json_string(object, "precision", is_single(about) ? "single" : "double");
  json_number(residuals, "single_precision", meta_number(about, "residuals", "single_precision"));
  const cJSON *check = model_meta_find(about->meta, NULL, "mode_check");
  if (check != NULL)
    cJSON_AddItemToObject(object, "mode_check", cJSON_Duplicate(check, true));
  const cJSON *import = model_meta_find(about->meta, NULL, "import");
  if (import != NULL)
    cJSON_AddItemToObject(object, "import", cJSON_Duplicate(import, true));
  const cJSON *handles = model_meta_find(about->meta, "options", "handles");
  if (cJSON_IsArray(handles))
    cJSON_AddItemToObject(object, "handles", cJSON_Duplicate(handles, true));

  const thrum_model *model = about->model;
  cJSON *actuators =
      thrum_model_actuators(model) > 0 ? cJSON_AddArrayToObject(object, "actuators") : NULL;
  for (int64_t k = 0; k < thrum_model_actuators(model); k++) {
    cJSON *actuator = json_add_row(actuators);
    json_string(actuator, "actuator", thrum_model_actuator_text(model, k));
    json_string(actuator, "kind", actuator_words[model->actuator_kind[k]].kind);
    json_number(actuator, "at_rest", model->actuator_rest[3 * k]);
    json_number(actuator, "static_share", model->actuator_rest[3 * k + 2]);
  }

  cJSON *loads = about->load_count > 0 ? cJSON_AddArrayToObject(object, "loads") : NULL;
  for (int n = 0; n < about->load_count; n++) {
    cJSON *load = json_add_row(loads);
    json_string(load, "load", about->loads[n].text);
    json_number(load, "static_share_outside", about->shares[n].statics);
    json_number(load, "load_share_outside", about->shares[n].load);
  }

  const cJSON *touch = model_meta_find(about->meta, "touch", "after");
  if (about->touch.judged)
    touch_coverage_json(object, "touch", &about->touch.after, about->touch.at);
  else if (cJSON_IsObject(touch))
    cJSON_AddItemToObject(object, "touch", cJSON_Duplicate(touch, true));

  json_number(object, "model_bytes", about->file_bytes);
  json_number(object, "state_bytes", (double)about->split.state_bytes);
  add_groups(object, about->model);
  const cJSON *hash = model_meta_find(about->meta, "mesh", "hash");
  if (cJSON_IsString(hash))
    json_string(object, "mesh_hash", hash->valuestring);

  // stages that do not overlap
  cJSON *seconds = cJSON_AddObjectToObject(object, "seconds");
  const double now = clock_seconds();
  json_number(seconds, "read", about->read - about->began);
  json_number(seconds, "measure", now - about->read);
  json_number(seconds, "total", now - about->began);
  json_number(object, "peak_mb", clock_peak_mb());
  return object;
}

static void print_label(const char *label) {
  printf("%-18s", label);
}

/* The label, and what stands behind it. */
__attribute__((format(printf, 2, 3))) static void print_line(const char *label, const char *format,
                                                             ...) {
  va_list arguments;
  print_label(label);
  va_start(arguments, format);
  vprintf(format, arguments);
  va_end(arguments);
}

/* Prints the n-th of `count` frequencies, a few in each line and the label before the first. */
static void print_frequency(const char *label, double hertz, int64_t n, int64_t count) {
  if (n % FREQUENCIES_A_LINE == 0)
    print_label(n == 0 ? label : "");
  printf("%-11.5g", hertz);
  if (n % FREQUENCIES_A_LINE == FREQUENCIES_A_LINE - 1 || n == count - 1)
    puts("Hz");
}

static void print_actuators(const info *about) {
  const thrum_model *model = about->model;
  for (int64_t k = 0; k < thrum_model_actuators(model); k++) {
    const int32_t kind = model->actuator_kind[k];
    const double *rest = model->actuator_rest + 3 * k;
    print_line(k == 0 ? "actuators" : "", "%.60s", thrum_model_actuator_text(model, k));
    if (kind != THRUM_ACTUATOR_STRAIN)
      printf(", %.6g %s at rest", rest[0], actuator_words[kind].unit);
    printf("; the basis holds %.4g %% of its static answer\n", 100 * rest[2]);
  }
}

static void print_linear_frequencies(const info *about) {
  const cJSON *list = model_meta_find(about->meta, NULL, "frequencies_hz");
  const cJSON *item = NULL;
  int64_t count = 0, n = 0;
  cJSON_ArrayForEach(item, list) {
    count += cJSON_IsNumber(item);
  }
  cJSON_ArrayForEach(item, list) {
    if (cJSON_IsNumber(item))
      print_frequency("linear modes", item->valuedouble, n++, count);
  }
}

/* How many of the basis vectors are modes of the mesh; all, where the model does not say. */
static int64_t linear_modes(const info *about) {
  const int count = cJSON_GetArraySize(model_meta_find(about->meta, NULL, "frequencies_hz"));
  return count > 0 && count < about->model->rank ? count : about->model->rank;
}

/* By how much of itself a frequency changes, a line for each mode and region. */
static void print_gradient(const info *about) {
  const frequency_gradient *g = &about->gradient;
  print_line("gradient", "change of a frequency, relative\n");
  print_line("",
             "mode      f [Hz]   region   for 1 %% of E   for 0.01 of nu   for 1 %% of density\n");
  for (int64_t i = 0; i < g->modes; i++)
    for (int64_t m = 0; m < g->regions; m++) {
      const int64_t at = i * g->regions + m;
      print_line("", "%4" PRId64 "  %10.5g   %6" PRId64 "   %+11.4f %%   %+12.4f %%   %+16.4f %%\n",
                 i + 1, about->hertz[i], m + 1, g->young[at], g->poisson[at], g->density[at]);
    }
}

/* Each mode beside the frequency that a step gives it, and what a second leaves of its amplitude
 * where that is not all. */
static void print_stepped(const info *about) {
  print_line("as stepped", "by %s at dt = %g s, at rest and without damping\n",
             thrum_integrator_name(about->def.integrator), about->def.dt);
  print_line("", "mode      f [Hz]   stepped [Hz]    error   amplitude after 1 s\n");
  for (int64_t i = 0; i < about->steps->rank; i++) {
    const thrum_stepped_mode *mode = &about->stepped[i];
    print_line("", "%4" PRId64 "  %10.5g", i + 1, mode->hertz);
    if (isnan(mode->stepped_hertz)) {
      puts("      beyond the limit of stability");
      continue;
    }

    // a factor of 1 is exact up to rounding
    const double error = mode->hertz > 0 ? mode->stepped_hertz / mode->hertz - 1 : 0;
    printf("     %10.5g  %+6.2f %%", mode->stepped_hertz, 100 * error);
    if (mode->factor > 1 + 1e-12)
      puts("   grows");
    else
      printf("   %.3g\n", mode->factor < 1 - 1e-12 ? pow(mode->factor, 1 / about->def.dt) : 1.0);
  }
}

/* Ends a line about the material of a region: its law and its yield. */
static void print_region_law(const thrum_model *model, int64_t region) {
  const double yield = thrum_law_yield(model, region, INFINITY);
  if (model->region_law)
    printf(", %s", thrum_law_name(thrum_law_of_region(model, region)));
  if (model->region_law && !isinf(yield))
    printf(", flows beyond a strain of %g", yield);
  puts("");
}

/* Prints the material of a region, by its number and its name where there are several. */
static void print_material(const info *about, int64_t region) {
  const double *material = about->model->material + 3 * region;
  const char *name = model_meta_region(about->meta, region);
  print_label(region == 0 ? "material" : "");
  if (about->model->region_count > 1)
    printf("region %" PRId64 "%s%s: ", region + 1, name != NULL ? ", " : "",
           name != NULL ? name : "");
  if (elastic_print(about->model->elastic, about->model->elastic_count, region))
    printf(", rho = %g kg/m^3", material[2]);
  else
    printf("E = %g Pa, nu = %g, rho = %g kg/m^3", material[0], material[1], material[2]);
  print_region_law(about->model, region);
}

static void print_materials(const info *about) {
  for (int64_t m = 0; m < about->model->region_count && m < NAMES_SHOWN; m++)
    print_material(about, m);
  if (about->model->region_count > NAMES_SHOWN)
    print_line("", "and %" PRId64 " more\n", about->model->region_count - NAMES_SHOWN);
}

static const report_line head[] = {
    REPORT_LINE("model", "{model}, format {format_major}.{format_minor}"),
    REPORT_LINE("mesh", "{has_mesh?{vertices} vertices ({fixed} held), {solids?{solids}|{tets} "
                        "tetrahedra{ten_nodes? of ten nodes}}, "
                        "{regions} material{regions#|s}|none: a polynomial alone}"),
    REPORT_LINE("elements", "{elements}"),
    REPORT_LINE("state",
                "the model is about one, up to {about_m:.3g} m from the shape without stress",
                .when = "about_m"),
    {0}};

static const report_line body[] = {
    // measures of the whole body and of its worst element
    REPORT_LINE("springs",
                "{spring_vertices} vertices to the ground, {spring_stiffness_n_per_m:.6g} "
                "N/m along x, y, z together",
                .when = "spring_vertices"),
    REPORT_LINE("body", "{mass_kg:.6g} kg, {volume_m3:.6g} m^3"),
    REPORT_LINE("box",
                "[[{box_min_m.0:g}, {box_max_m.0:g}]] x [[{box_min_m.1:g}, {box_max_m.1:g}]] x "
                "[[{box_min_m.2:g}, {box_max_m.2:g}]] m"),
    REPORT_LINE("element quality", "{solids?scaled Jacobian|mean ratio} {quality_min:.3f} at least "
                                   "({solids?element|tetrahedron} {worst_tet} of the model), "
                                   "{quality_mean:.3f} on average; 1 is regular"),
    REPORT_LINE("groups", "{groups_shown}", .when = "groups"),

    // what the strain energy is summed from: coefficients, or points and what they were trained on
    REPORT_LINE(
        "polynomial",
        "rank {rank}, {cubic_coefficients} cubic and {quartic_coefficients} quartic coefficients",
        .when = "!cubature_points"),
    REPORT_LINE("cubature",
                "rank {rank}, {cubature_points} points in place of the polynomial[, force wrong by "
                "{meta.cubature.test_error:.2g%} (rms)]"),
    REPORT_LINE("motion",
                "by these points wrong by {meta.cubature.motion_error:.2g%} within the range of "
                "{meta.cubature.range:.2g} of the diagonal that they were trained on, by "
                "{meta.cubature.motion_error_beyond:.2g%} at half as far again"),
    REPORT_LINE("trained on",
                "{trained_on=null?not known: the file is of an earlier format|strains up to "
                "{trained_on.strain:.2g}, {trained_on.yield=null?no plastic flow|flow beyond "
                "{trained_on.yield:.3g}, plastic strains up to {trained_on.plastic_strain:.2g}}}",
                .when = "cubature_points"),
    REPORT_LINE("gradients", "learned in {meta.cubature.refine:.0f} steps",
                .when = "meta.cubature.refine"),
    REPORT_LINE("law", "{law}", .when = "cubature_points"),
    REPORT_LINE("condensed", "{masters} coordinates are stepped, the others follow at rest",
                .when = "condensed"),
    REPORT_LINE(
        "precision",
        "single, force wrong by {residuals.single_precision:.1e} of itself at most, of 16 samples",
        .when = "precision=single"),
    REPORT_LINE("free body", "elastic part alone; 6 rigid modes kept apart in the array 'rigid'",
                .when = "rigid_modes"),

    // where the basis comes from when not from modes alone
    REPORT_LINE("imported", "from {import.basis}, |U^T M U - 1| was {import.orthonormality:.1e}, "
                            "{import.basis_changed?its basis was changed|taken as it is}"),
    REPORT_LINE("handles", "{handles}", .when = "handles"),
    {0}};

static const report_line split[] = {
    REPORT_LINE("split",
                "{explicit_modes} explicit, {implicit_modes} implicit by imexv at dt = {dt:g} s"),
    {0}};

static const report_line tail[] = {
    REPORT_LINE("none missed", "{mode_check.complete?yes|NO} by {mode_check.method=inertia?inertia "
                               "count|search}, next mode "
                               "at {mode_check.next_hz:.5g} Hz"),
    REPORT_LINE("residuals", "[modes {residuals.modes_max:.1e}, ]orthonormality "
                             "{residuals.orthonormality:.1e}, diagonality "
                             "{residuals.diagonality:.1e}"),
    REPORT_LINE(
        "load",
        "{load}: {static_share_outside=null?acts on nothing that can deform|the basis lacks "
        "{static_share_outside:.3g%} of its static answer (which counts for slow pulls), and "
        "{load_share_outside:.3g%} of the load itself}",
        .each = "loads"),

    // how pulls at the surface are followed: as measured now, or as precompute --touch found it
    REPORT_LINE("touch",
                "pulls are followed by {touch.worst:.0f%} at least (vertex {touch.vertex}, at "
                "{touch.at_m:.3g} m), "
                "{touch.mean:.0f%} in the mean of {touch.places} places",
                .when = "touch_judged"),
    REPORT_LINE("touch modes",
                "{meta.touch.modes:.0f}: in the mean over directions pulls are followed by "
                "{meta.touch.after.worst:.0f%} at least, {meta.touch.after.mean:.0f%} in the mean "
                "of places; "
                "without them by {meta.touch.before.worst:.0f%} and {meta.touch.before.mean:.0f%}"),
    REPORT_LINE("memory", "model {model_bytes} bytes, state {state_bytes} bytes"),
    {0}};

/* The first groups with their sizes, and how many more there are. */
static void add_groups_shown(cJSON *more, const cJSON *groups) {
  char text[2000] = "", one[200];
  const int count = cJSON_GetArraySize(groups);
  for (int g = 0; g < count && g < NAMES_SHOWN; g++) {
    report_text(cJSON_GetArrayItem(groups, g), NULL, "{name} ({vertices})", one, sizeof one);
    snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", g > 0 ? ", " : "", one);
  }
  if (count > NAMES_SHOWN)
    snprintf(text + strlen(text), sizeof text - strlen(text), " and %d more", count - NAMES_SHOWN);
  cJSON_AddStringToObject(more, "groups_shown", text);
}

static void print_table(const info *about, cJSON *report) {
  const thrum_model *model = about->model;
  char elements[LOCKING_LINE_MAX];
  cJSON *more = cJSON_CreateObject();
  if (about->meta != NULL)
    cJSON_AddItemReferenceToObject(more, "meta", about->meta);
  cJSON_AddBoolToObject(more, "has_mesh", about->has_mesh);
  cJSON_AddBoolToObject(more, "ten_nodes", model->midsides != NULL);
  cJSON_AddBoolToObject(more, "condensed", about->steps != model);
  cJSON_AddBoolToObject(more, "touch_judged", about->touch.judged);
  const bool told = about->has_mesh && locking_line(model, elements)[0] != 0;
  json_string(more, "elements", told ? elements : NULL);
  add_groups_shown(more, cJSON_GetObjectItemCaseSensitive(report, "groups"));

  // lists of which not all is shown stand between
  report_print(report, more, REPORT_LABEL_WIDE, head);
  if (about->has_mesh)
    print_materials(about);
  report_print(report, more, REPORT_LABEL_WIDE, body);
  print_linear_frequencies(about);
  for (int64_t n = 0; n < model->rank; n++)
    print_frequency("basis", about->hertz[n], n, model->rank);
  model_coordinates_print(about->meta, about->hertz, model->rank);
  print_actuators(about);
  report_print(report, more, REPORT_LABEL_WIDE, split);
  if (about->steps_named)
    print_stepped(about);
  if (about->gradient_asked)
    print_gradient(about);
  report_end(report, more, REPORT_LABEL_WIDE, tail);
}

/* Measures the share of each load that the basis lacks. */
static thrum_status measure_loads(info *about, thrum_error *error) {
  const thrum_model *model = about->model;
  const size_t size = 3 * (size_t)model->vertex_count;
  double *forces = calloc(size * (size_t)about->load_count + 1, sizeof *forces);
  thrum_status status = forces == NULL ? THRUM_OUT_OF_MEMORY : THRUM_OK;
  if (status < 0)
    thrum_error_set(error, status, "no memory for the loads");
  for (int n = 0; n < about->load_count && status >= 0; n++)
    status = load_spec_fill(model, &about->loads[n], forces + (size_t)n * size, error);
  THRUM_THEN(status,
             thrum_load_share_measure(model, about->load_count, forces, about->shares, error));
  free(forces);
  return status;
}

/* Measures how the model follows pulls all over its surface. */
static thrum_status measure_touch(info *about, thrum_error *error) {
  thrum_touch *touch = NULL;
  THRUM_TRY(thrum_touch_create(about->model, &touch, error));
  thrum_touch_measure(touch, about->model, &about->touch.after);
  thrum_touch_free(touch);
  memcpy(about->touch.at, about->model->vertices + 3 * (int64_t)about->touch.after.vertex,
         sizeof about->touch.at);
  about->touch.judged = true;
  return THRUM_OK;
}

/* Derivatives by places, a row of 3 vertices for each linear mode. */
static thrum_status write_shape_gradient(const info *about, thrum_error *error) {
  const int64_t modes = linear_modes(about);
  double *rows = NULL;
  THRUM_TRY(shape_gradient_find(about->model, modes, &rows, error));
  const thrum_status status =
      thrum_npy_write_f8(about->shape_gradient, rows, modes, 3 * about->model->vertex_count, error);
  free(rows);
  return status;
}

/* Volume and mass of hexahedra and wedges, whose tetrahedra have others where faces are bent. */
static thrum_status weigh(const thrum_model *model, thrum_quality *quality, thrum_error *error) {
  thrum_model_fem whole = {0};
  THRUM_TRY(thrum_model_fem_elements(model, &whole, error));
  thrum_fem_weigh(&whole.fem, &quality->volume, &quality->mass);
  thrum_model_fem_free(&whole);
  return THRUM_OK;
}

/* Everything that is printed, or the reason why not. */
static thrum_status gather(info *about, thrum_error *error) {
  const thrum_model *model = about->model;
  struct stat status;
  about->file_bytes = stat(about->path, &status) == 0 ? (double)status.st_size : NAN;
  about->has_mesh = model->vertices != NULL;
  about->meta = model_meta_parse(model);

  THRUM_TRY(
      thrum_reserve(&about->hertz, model->rank, sizeof *about->hertz, "the frequencies", error));
  thrum_frequencies(model->omega2, model->rank, about->hertz);

  // what needs a mesh is left out for a polynomial alone
  if (about->has_mesh)
    THRUM_TRY(thrum_quality_measure(model, &about->quality, error));
  if (about->has_mesh && model->solid_count > 0)
    THRUM_TRY(weigh(model, &about->quality, error));
  THRUM_TRY(thrum_reserve(&about->stepped, model->rank, sizeof *about->stepped, "the frequencies",
                          error));
  THRUM_TRY(model_condense_to(model, 0, &about->steps_memory, &about->steps, error));
  THRUM_TRY(stepped_modes_at(about->steps, &about->def, about->stepped, error));
  THRUM_TRY(split_at(about->steps, about->def.dt, &about->split, error));
  if (about->touch_asked)
    THRUM_TRY(measure_touch(about, error));
  if (about->gradient_asked)
    THRUM_TRY(frequency_gradient_find(model, linear_modes(about), &about->gradient, error));
  if (about->shape_gradient)
    THRUM_TRY(write_shape_gradient(about, error));
  return about->load_count == 0 ? THRUM_OK : measure_loads(about, error);
}

/* Is it a folder, and not the name of a model, which may have a run beside it? */
static bool is_folder(const char *path) {
  struct stat status;
  model_recipe recipe = {0};
  return stat(path, &status) == 0 && S_ISDIR(status.st_mode) &&
         (model_recipe_find(path, &recipe, NULL) < 0 || !recipe.found);
}

/* Says what the run in a folder is; other folders are refused. */
static int say_run(const info_request *request) {
  thrum_error error = {0};
  if (recorded_folder_check(request->path, ", or a model file", &error) < 0)
    return config_refuse(&error);
  if (request->dt > 0 || request->integrator != (thrum_integrator)-1 || request->load_count > 0 ||
      request->touch || request->gradient || request->shape_gradient)
    return config_usage("info", "%s is the folder of a run: all options but --json go with a model",
                        request->path);
  return info_run(request->path, request->json, &error) < 0 ? config_refuse(&error) : COMMAND_DONE;
}

int cmd_info(int argc, char **argv) {
  info_request request = {.integrator = (thrum_integrator)-1};
  CONFIG_TRY(config_options_read_one(&command_info, "model", argc, argv, &request, &request.path));
  if (is_folder(request.path))
    return say_run(&request);

  thrum_error error = {0};
  thrum_load_share shares[LOADS_MAX];
  info about = {.path = request.path,
                .def = thrum_default_state_def(),
                .steps_named = request.dt > 0 || request.integrator != (thrum_integrator)-1,
                .touch_asked = request.touch,
                .gradient_asked = request.gradient,
                .shape_gradient = request.shape_gradient,
                .loads = request.loads,
                .shares = shares,
                .load_count = request.load_count,
                .began = clock_seconds()};
  if (request.dt > 0)
    about.def.dt = request.dt;
  if (request.integrator != (thrum_integrator)-1)
    about.def.integrator = request.integrator;
  named_model_file file;
  thrum_status status = named_model_load(request.path, false, &about.model, &file, &error);

  // a surface file is no model, but lacks only what makes one
  if (status == THRUM_MISSING && info_surface(request.path, request.json))
    return COMMAND_DONE;
  if (status < 0)
    return config_refuse(&error);

  about.path = file.path;
  about.read = clock_seconds();
  status = gather(&about, &error);
  if (status >= 0 && request.json)
    json_print(make_report(&about));
  else if (status >= 0)
    print_table(&about, make_report(&about));
  cJSON_Delete(about.meta);
  frequency_gradient_free(&about.gradient);
  free(about.hertz);
  free(about.stepped);
  free(about.steps_memory);
  thrum_model_destroy(about.model);
  return status < 0 ? config_refuse(&error) : COMMAND_DONE;
}
