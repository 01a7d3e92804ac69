/* The commands that make the recommended model and run it: as texts for a shell, and as options
 * files. SPDX-License-Identifier: Apache-2.0 */
#include "app/tradeoff_commands.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/results.h"
#include "driver/model/basis_estimate.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/made_text.h"
#include "io/number_text.h"
#include "io/shell_word.h"
#include "mesh/formats/mesh_read.h"
#include "runtime/material/material_law.h"

static const tradeoff_run *run_of(const tradeoff_commands *c) {
  return &c->result->runs[c->result->chosen];
}

static const tradeoff_basis *basis_of(const tradeoff_commands *c) {
  return &c->result->bases[run_of(c)->basis];
}

static const tradeoff_recipe *recipe_of(const tradeoff_commands *c) {
  return &basis_of(c)->recipe;
}

static thrum_law law_of(const tradeoff_commands *c) {
  return thrum_law_of_model(c->problem->model);
}

/* Whether precompute must be told the law. Laws of regions come with the mesh, or with the model
 * that it is taken from; so one that was asked for in their place is named, stvk too. */
static bool names_law(const tradeoff_commands *c) {
  return law_of(c) != THRUM_LAW_BY_REGION && (law_of(c) != THRUM_LAW_STVK || c->request->law_given);
}

/* Whether a model file has to be made: not of an own basis that lies in a file. */
static bool is_made(const tradeoff_commands *c) {
  return recipe_of(c)->modes > 0 || thrum_mesh_is_named(c->request->model_path);
}

static void put_text(FILE *stream, const char *option, const char *text) {
  fprintf(stream, " %s ", option);
  shell_word_put(stream, text);
}

static void put_number(FILE *stream, const char *option, double value) {
  char text[THRUM_NUMBER_TEXT];
  thrum_number_text(value, text);
  fprintf(stream, " %s %s", option, text);
}

static void put_damping(FILE *stream, const char *option, const double damping[2]) {
  if (!(damping[0] > 0 || damping[1] > 0))
    return;
  char text[80];
  snprintf(text, sizeof text, "%.17g,%.17g", damping[0], damping[1]);
  fprintf(stream, " %s %s", option, text);
}

/* All loads together, as a case of a training. */
static void join_loads(const tradeoff_commands *c, char *text, size_t size) {
  size_t used = 0;
  text[0] = 0;
  for (int64_t n = 0; n < c->load_count && used < size; n++)
    used += (size_t)snprintf(text + used, size - used, "%s%s", n > 0 ? ";" : "", c->loads[n].text);
}

/* Room for them; the caller frees. */
static char *joined(const tradeoff_commands *c) {
  size_t size = 1;
  for (int64_t n = 0; n < c->load_count; n++)
    size += strlen(c->loads[n].text) + 1;
  char *text = malloc(size);
  if (text != NULL)
    join_loads(c, text, size);
  return text;
}

static void put_mesh(FILE *stream, const tradeoff_commands *c) {
  const mesh_model_def *def = &c->request->mesh_def;
  const double numbers[] = {def->material.young, def->material.poisson, def->material.density};
  static const char *const names[] = {"--young", "--poisson", "--density"};
  fputc(' ', stream);
  shell_word_put(stream, c->request->model_path);
  for (int64_t n = 0; n < def->fix_count; n++)
    put_text(stream, "--fix", def->fixes[n]);
  for (int n = 0; n < 3; n++)
    if (!isnan(numbers[n]))
      put_number(stream, names[n], numbers[n]);
  for (int64_t n = 0; n < def->material_count; n++)
    put_text(stream, "--material", def->materials[n]);

  // how the file is read
  const thrum_mesh_read_options *reading = &def->reading;
  if (reading->scale != 1)
    put_number(stream, "--scale", reading->scale);
  if (reading->order > 0)
    fprintf(stream, " --order %d", reading->order);
  if (reading->element != THRUM_ELEMENT_AUTO)
    put_text(stream, "--element", element_names[reading->element]);
  const char *const texts[] = {reading->unit, reading->regions};
  static const char *const options[] = {"--unit", "--regions"};
  for (int n = 0; n < 2; n++)
    if (texts[n] != NULL)
      put_text(stream, options[n], texts[n]);
}

static int64_t modes_of(const tradeoff_commands *c) {
  const tradeoff_recipe *recipe = recipe_of(c);
  return recipe->modes > 0 ? recipe->modes : c->own_modes;
}

static int64_t rank_of(const tradeoff_commands *c) {
  const tradeoff_recipe *recipe = recipe_of(c);
  return recipe->modes > 0 ? recipe->rank : c->problem->model->rank;
}

static void put_precompute(FILE *stream, const void *of) {
  const tradeoff_commands *c = of;
  const tradeoff_recipe *recipe = recipe_of(c);
  char model[600];

  // the options that make the basis and its energy
  fprintf(stream, "%s precompute", c->program);
  put_mesh(stream, c);
  fprintf(stream, " --modes %lld --rank %lld", (long long)modes_of(c), (long long)rank_of(c));
  if (recipe->modes > 0 && recipe->single)
    fputs(" --precision single", stream);
  if (names_law(c))
    fprintf(stream, " --law %s", thrum_law_name(law_of(c)));
  if (recipe->cubature_error > 0) {
    fputs(" --cubature", stream);
    put_number(stream, "--cubature-error", recipe->cubature_error);
    put_number(stream, "--cubature-range", basis_of(c)->cubature_range);
    if (c->request->cubature_refine > 0)
      fprintf(stream, " --cubature-refine %lld", (long long)c->request->cubature_refine);
  }
  if (c->result->lumped)
    fputs(" --mass lumped", stream);

  // the training is the run that the errors are measured against
  char *loads = recipe->trained ? joined(c) : NULL;
  if (loads != NULL) {
    put_text(stream, "--train", loads);
    put_number(stream, "--train-time", c->request->time);
    put_number(stream, "--train-dt", c->request->full_dt);
    put_damping(stream, "--train-damping", c->request->damping);
    if (c->request->keep_runs != NULL)
      put_text(stream, "--keep-runs", c->request->keep_runs);
  }
  free(loads);
  snprintf(model, sizeof model, "%.500s/model.npz", c->request->output);
  put_text(stream, "-o", model);
}

/* The share of the motion that a run of the pick may have wrong without a flag: twice what was
 * found, as its estimate is another one; 0: the usual one. */
static double accepted_of(const tradeoff_commands *c) {
  const double twice = ceil(200 * run_of(c)->error.displacement) / 100;
  return twice > BASIS_ACCEPTED ? fmin(twice, 1) : 0;
}

static void put_simulate(FILE *stream, const void *of) {
  const tradeoff_commands *c = of;
  const tradeoff_run *run = run_of(c);
  const tradeoff_recipe *recipe = recipe_of(c);
  char path[600];
  snprintf(path, sizeof path, "%.500s/model.npz", c->request->output);
  fprintf(stream, "%s simulate ", c->program);
  shell_word_put(stream, is_made(c) ? path : c->request->model_path);

  // the setting that was chosen
  fprintf(stream, " --integrator %s", experiment_scheme_names[run->integrator]);
  put_number(stream, "--dt", run->dt);
  put_number(stream, "--tolerance", run->tolerance);
  if (recipe->masters > 0)
    fprintf(stream, " --condense %lld", (long long)recipe->masters);
  if (accepted_of(c) > 0)
    put_number(stream, "--accept-error", accepted_of(c));

  // the motion that it was chosen for
  put_damping(stream, "--damping", c->request->damping);
  for (int64_t n = 0; n < c->load_count; n++)
    put_text(stream, "--load", c->loads[n].text);
  put_number(stream, "--time", c->request->time);
  snprintf(path, sizeof path, "%.500s/run", c->request->output);
  put_text(stream, "-o", path);
}

/* The chosen setting, as simulate and precompute take it from an options file. */
static cJSON *simulate_options(const tradeoff_commands *c) {
  const tradeoff_run *run = run_of(c);
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "integrator", experiment_scheme_names[run->integrator]);
  json_number(object, "dt", run->dt);
  if (accepted_of(c) > 0)
    json_number(object, "accept-error", accepted_of(c));
  json_number(object, "tolerance", run->tolerance);
  if (recipe_of(c)->masters > 0)
    json_number(object, "condense", (double)recipe_of(c)->masters);
  return object;
}

static cJSON *precompute_options(const tradeoff_commands *c) {
  const tradeoff_recipe *recipe = recipe_of(c);
  cJSON *object = cJSON_CreateObject();

  // the options that make the basis and its energy
  json_number(object, "modes", (double)modes_of(c));
  json_number(object, "rank", (double)rank_of(c));
  cJSON_AddStringToObject(object, "precision",
                          recipe->modes > 0 && recipe->single ? "single" : "double");
  if (names_law(c))
    cJSON_AddStringToObject(object, "law", thrum_law_name(law_of(c)));
  if (recipe->cubature_error > 0) {
    cJSON_AddBoolToObject(object, "cubature", true);
    json_number(object, "cubature-error", recipe->cubature_error);
    json_number(object, "cubature-range", basis_of(c)->cubature_range);
    if (c->request->cubature_refine > 0)
      json_number(object, "cubature-refine", (double)c->request->cubature_refine);
  }
  if (c->result->lumped)
    cJSON_AddStringToObject(object, "mass", "lumped");

  // a trained basis has the loads of its training
  char *loads = recipe->trained ? joined(c) : NULL;
  if (loads != NULL) {
    cJSON *train = cJSON_AddArrayToObject(object, "train");
    json_add_string(train, loads);
    json_number(object, "train-time", c->request->time);
    json_number(object, "train-dt", c->request->full_dt);
    if (c->request->damping[0] > 0 || c->request->damping[1] > 0)
      json_numbers(object, "train-damping", c->request->damping, 2);
  }
  free(loads);
  return object;
}

thrum_status tradeoff_commands_write(const tradeoff_commands *c, const char *folder,
                                     thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(results_open(folder, "commands.sh", &writer, error));
  if (is_made(c)) {
    put_precompute(writer.stream, c);

    // points that miss the error of their force end with 3, whose motion was judged here
    fputs(recipe_of(c)->cubature_error > 0 ? " || [ $? -eq 3 ]\n" : "\n", writer.stream);
  }
  put_simulate(writer.stream, c);
  fputc('\n', writer.stream);

  // the same as files of options
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  THRUM_TRY(results_write_json(folder, "simulate.json", simulate_options(c), error));
  return is_made(c) ? results_write_json(folder, "precompute.json", precompute_options(c), error)
                    : THRUM_OK;
}

thrum_status tradeoff_commands_add(const tradeoff_commands *c, cJSON *object, thrum_error *error) {
  cJSON *item = cJSON_AddObjectToObject(object, "commands");
  char *precompute = is_made(c) ? made_text(put_precompute, c, NULL) : NULL;
  char *simulate = made_text(put_simulate, c, NULL);
  const bool whole = simulate != NULL && (precompute != NULL || !is_made(c));
  json_string(item, "precompute", precompute);
  json_string(item, "simulate", simulate);
  free(precompute);
  free(simulate);
  return whole ? THRUM_OK
               : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the commands");
}

void tradeoff_commands_print(const tradeoff_commands *c) {
  puts("\nto make it and run it:");
  if (is_made(c)) {
    put_precompute(stdout, c);
    puts("");
  }
  put_simulate(stdout, c);
  puts("");
}
