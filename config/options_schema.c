/* The JSON schema of options files and scene files, made of the tables that read them.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "config/options.h"
#include "io/json.h"

static cJSON *typed(const char *type) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "type", type);
  return object;
}

/* {"anyOf": [a, b]} */
static cJSON *either(cJSON *a, cJSON *b) {
  cJSON *object = cJSON_CreateObject();
  cJSON *list = cJSON_AddArrayToObject(object, "anyOf");
  cJSON_AddItemToArray(list, a);
  cJSON_AddItemToArray(list, b);
  return object;
}

static cJSON *list_of(cJSON *items, int count) {
  cJSON *object = typed("array");
  cJSON_AddItemToObject(object, "items", items);
  if (count > 0) {
    json_number(object, "minItems", count);
    json_number(object, "maxItems", count);
  }
  return object;
}

static cJSON *number_schema(const config_option *o) {
  cJSON *object = typed(o->kind == CONFIG_COUNT ? "integer" : "number");
  if (o->least == 0 && o->most == 0)
    return object;
  json_number(object, o->above ? "exclusiveMinimum" : "minimum", o->least);
  if (isfinite(o->most))
    json_number(object, o->below ? "exclusiveMaximum" : "maximum", o->most);
  return object;
}

static cJSON *names_schema(const char *const *names) {
  cJSON *object = cJSON_CreateObject();
  cJSON *list = cJSON_AddArrayToObject(object, "enum");
  for (int n = 0; names[n] != NULL; n++)
    cJSON_AddItemToArray(list, cJSON_CreateString(names[n]));
  return object;
}

static cJSON *object_schema(const config_option *keys, bool records);

static cJSON *option_schema(const config_option *o, bool records) {
  static const char *const switches[] = {"off", "on", NULL};
  if (o->schema != NULL)
    return cJSON_Parse(o->schema);

  // otherwise the kind says what JSON it takes
  switch (o->kind) {
  case CONFIG_FLAG:
    return typed("boolean");
  case CONFIG_SWITCH:
    return either(typed("boolean"), names_schema(switches));
  case CONFIG_NUMBER:
  case CONFIG_COUNT:
    return number_schema(o);
  case CONFIG_VECTOR:
    return list_of(number_schema(o), 3);
  case CONFIG_CHOICE:
    return names_schema(o->names);
  case CONFIG_WORD:
    return either(typed("number"), typed("string"));
  case CONFIG_PAIR:
    return either(typed("number"), list_of(typed("number"), 2));
  case CONFIG_OBJECT:
    return object_schema(o->keys, records);
  case CONFIG_LIST:
    return list_of(object_schema(o->keys, records), 0);
  default:
    return o->repeats || o->kind == CONFIG_TEXTS
               ? either(typed("string"), list_of(typed("string"), 0))
               : typed("string");
  }
}

/* "about: WANTS [UNIT]; default FALLBACK" */
static void describe(const config_option *o, cJSON *object) {
  char text[600];
  const bool free_form = o->kind == CONFIG_WORD && o->wants != NULL;
  snprintf(text, sizeof text, "%s%s%s%s%s%s%s%s", o->about, free_form ? ": " : "",
           free_form ? o->wants : "", o->unit ? " [" : "", o->unit ? o->unit : "",
           o->unit ? "]" : "", o->fallback ? "; default " : "", o->fallback ? o->fallback : "");
  cJSON_AddStringToObject(object, "description", text);
}

/* What holds without the option, where its words are a value and no explanation. */
static void add_default(const config_option *o, cJSON *object) {
  cJSON *value = NULL;
  if (o->fallback == NULL || o->kind == CONFIG_TEXT || o->kind == CONFIG_TEXTS)
    return;
  for (int n = 0; o->kind == CONFIG_CHOICE && o->names[n] != NULL; n++)
    if (strcmp(o->names[n], o->fallback) == 0)
      value = cJSON_CreateString(o->fallback);
  if (o->kind != CONFIG_CHOICE)
    value = cJSON_ParseWithOpts(o->fallback, NULL, true);
  if (value != NULL)
    cJSON_AddItemToObject(object, "default", value);
}

static cJSON *object_schema(const config_option *keys, bool records) {
  config_row rows[CONFIG_OPTION_MAX];
  const int count = config_rows(keys, rows);
  cJSON *object = typed("object");
  cJSON_AddBoolToObject(object, "additionalProperties", false);
  cJSON *required = cJSON_CreateArray();
  cJSON *properties = cJSON_AddObjectToObject(object, "properties");

  // an options file and the help are no keys
  for (int n = 0; n < count; n++) {
    const config_option *o = rows[n].option;
    char name[64];
    if (o->kind == CONFIG_FILE || o->helps)
      continue;
    snprintf(name, sizeof name, "%s", o->name);
    for (char *c = name; *c != 0; c++)
      *c = records && *c == '-' ? '_' : *c;
    cJSON *schema = option_schema(o, records);
    describe(o, schema);
    add_default(o, schema);
    cJSON_AddItemToObject(properties, name, schema);
    if (o->needed)
      cJSON_AddItemToArray(required, cJSON_CreateString(name));
  }

  // draft 7 wants at least one name in "required"
  if (cJSON_GetArraySize(required) > 0)
    cJSON_AddItemToObject(object, "required", required);
  else
    cJSON_Delete(required);
  return object;
}

cJSON *config_schema(const char *title, const config_option *table, bool records) {
  cJSON *schema = object_schema(table, records);
  cJSON_AddStringToObject(schema, "$schema", "http://json-schema.org/draft-07/schema#");
  cJSON_AddStringToObject(schema, "title", title);
  cJSON_AddItemToObject(cJSON_GetObjectItem(schema, "properties"), "$schema", typed("string"));
  return schema;
}
