/* The files and the JSON object that all kinds of experiments share.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "app/results.h"
#include "config/progress.h"
#include "io/json.h"
#include "io/made_text.h"

thrum_status experiments_write_rows(const experiments_request *request, const char *name,
                                    const cJSON *rows, thrum_error *error) {
  char file[64];
  thrum_file_writer writer = {NULL, NULL, NULL};
  snprintf(file, sizeof file, "%s.csv", name);
  THRUM_TRY(results_open(request->output, file, &writer, error));
  return thrum_file_writer_end(&writer, json_table_csv(writer.stream, rows, error), error);
}

/* The object {"status", "command", ...} to which the rows are added. */
static cJSON *report(const experiments_request *request, const experiments_outcome *outcome,
                     const char *status) {
  const bool whole = cJSON_GetArraySize(outcome->missing) == 0;
  cJSON *object = json_report("experiments", whole ? status : "incomplete");
  if (!whole)
    cJSON_AddItemToObject(object, "missing_jobs", cJSON_Duplicate(outcome->missing, true));
  cJSON_AddStringToObject(object, "kind", request->name);
  results_add_machine(object);
  json_string(object, "output", request->output);
  json_number(object, "threads", (double)request->threads);
  json_number(object, "dt", request->dt);
  json_number(object, "time", request->time);
  return object;
}

/* The file names of the tables of a kind. */
static const char *name_of(const experiments_request *request, int table) {
  const char *name = request->form->tables[table].name;
  return name != NULL ? name : request->name;
}

static bool has_table(const experiments_form *form, int table) {
  return table < EXPERIMENTS_TABLES_MAX && form->tables[table].key != NULL;
}

thrum_status experiments_write_list(const experiments_request *request, const char *file,
                                    const experiments_outcome *outcome, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(results_open(request->output, file, &writer, error));
  outcome->write_list(writer.stream, outcome->of);
  return thrum_file_writer_commit(&writer, error);
}

static thrum_status write_files(const experiments_request *request,
                                const experiments_outcome *outcome, thrum_error *error) {
  const experiments_form *form = request->form;
  char about[64];
  if (form->list != NULL)
    THRUM_TRY(experiments_write_list(request, form->list, outcome, error));
  for (int n = 0; has_table(form, n); n++)
    THRUM_TRY(experiments_write_rows(request, name_of(request, n), outcome->rows[n], error));

  // the page is made of the first table
  snprintf(about, sizeof about, "%s.about.json", name_of(request, 0));
  THRUM_TRY(results_write_json(request->output, about, report(request, outcome, "done"), error));
  results_make_page(request->output, request->name, name_of(request, 0));
  return THRUM_OK;
}

static void print(const experiments_form *form, const experiments_outcome *outcome) {
  if (form->heading != NULL)
    fputs(form->heading, stdout);
  for (int n = 0; has_table(form, n); n++)
    json_table_print(outcome->rows[n], form->tables[n].columns);
}

static thrum_status publish(const experiments_request *request, const experiments_outcome *outcome,
                            thrum_error *error) {
  const experiments_form *form = request->form;
  const thrum_status status = write_files(request, outcome, error);
  if (status >= 0 && !request->json)
    print(form, outcome);

  // the object takes the rows over, and they go with it
  cJSON *object = report(request, outcome, outcome->flagged ? "flagged" : "done");
  for (int n = 0; has_table(form, n); n++)
    cJSON_AddItemToObject(object, form->tables[n].key, outcome->rows[n]);
  if (status >= 0 && request->json)
    json_print(object);
  else
    cJSON_Delete(object);
  return status;
}

/* The result of a job: what experiments_jobs.c puts together again. */
static thrum_status keep(const experiments_request *request, const experiments_outcome *outcome,
                         thrum_error *error) {
  const experiments_form *form = request->form;
  cJSON_AddBoolToObject(request->result, "flagged", outcome->flagged);
  for (int n = 0; has_table(form, n); n++)
    cJSON_AddItemToObject(request->result, form->tables[n].key, outcome->rows[n]);
  if (form->list == NULL)
    return THRUM_OK;

  // the list, as its file would have it
  char *text = made_text(outcome->write_list, outcome->of, NULL);
  if (text == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s", form->list);
  json_string(request->result, "list", text);
  free(text);
  return THRUM_OK;
}

thrum_status experiments_publish(const experiments_request *request,
                                 const experiments_outcome *outcome, thrum_error *error) {
  return request->result != NULL ? keep(request, outcome, error) : publish(request, outcome, error);
}

bool experiments_progress(void *context, double fraction) {
  config_progress_update(context, "experiments", fraction);
  return true;
}
