/* The JSON schema of options files, made of the same table that reads them.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "config/options.h"
#include "io/json.h"

static cJSON *type_object(const char *type) {
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

static cJSON *array_of(cJSON *item, int count) {
  cJSON *object = type_object("array");
  cJSON_AddItemToObject(object, "items", item);
  if (count > 0) {
    json_number(object, "minItems", count);
    json_number(object, "maxItems", count);
  }
  return object;
}

static cJSON *number_object(const config_option *option) {
  cJSON *object = type_object(option->kind == CONFIG_COUNT ? "integer" : "number");
  if (option->least == 0 && option->most == 0)
    return object;
  json_number(object, option->above ? "exclusiveMinimum" : "minimum", option->least);
  if (isfinite(option->most))
    json_number(object, option->below ? "exclusiveMaximum" : "maximum", option->most);
  return object;
}

static cJSON *choice_object(const config_option *option) {
  cJSON *object = cJSON_CreateObject();
  cJSON *list = cJSON_AddArrayToObject(object, "enum");
  for (int n = 0; option->names[n] != NULL; n++)
    cJSON_AddItemToArray(list, cJSON_CreateString(option->names[n]));
  return option->names == config_switches ? either(type_object("boolean"), object) : object;
}

static cJSON *option_object(const config_option *option) {
  switch (option->kind) {
  case CONFIG_FLAG:
    return type_object("boolean");
  case CONFIG_NUMBER:
  case CONFIG_COUNT:
    return number_object(option);
  case CONFIG_CHOICE:
    return choice_object(option);
  case CONFIG_WORD:
    return either(type_object("number"), type_object("string"));
  case CONFIG_PAIR:
    return either(type_object("number"), array_of(type_object("number"), 2));
  default:
    return option->repeats ? either(type_object("string"), array_of(type_object("string"), 0))
                           : type_object("string");
  }
}

cJSON *config_options_schema(const char *command, const config_option *table) {
  cJSON *schema = cJSON_CreateObject();
  char title[80];
  snprintf(title, sizeof title, "Options of thrum %s", command);
  cJSON_AddStringToObject(schema, "$schema", "http://json-schema.org/draft-07/schema#");
  cJSON_AddStringToObject(schema, "title", title);
  cJSON_AddStringToObject(schema, "type", "object");
  cJSON_AddBoolToObject(schema, "additionalProperties", false);
  cJSON *properties = cJSON_AddObjectToObject(schema, "properties");
  cJSON_AddItemToObject(properties, "$schema", type_object("string"));
  for (const config_option *option = table; option->name != NULL; option++) {
    if (option->kind == CONFIG_FILE || option->letter == 'h')
      continue;
    cJSON *object = option_object(option);
    if (option->wants != NULL)
      cJSON_AddStringToObject(object, "description", option->wants);
    cJSON_AddItemToObject(properties, option->name, object);
  }
  return schema;
}
