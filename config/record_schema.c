/* The JSON schema of a file of records, made of the tables that read it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "config/record.h"
#include "io/json.h"

static cJSON *typed(const char *type) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "type", type);
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

static cJSON *number_schema(const config_key *key) {
  cJSON *object = typed(key->kind == CONFIG_KEY_COUNT ? "integer" : "number");
  if (key->least == 0 && key->most == 0)
    return object;
  json_number(object, key->above ? "exclusiveMinimum" : "minimum", key->least);
  if (isfinite(key->most))
    json_number(object, key->below ? "exclusiveMaximum" : "maximum", key->most);
  return object;
}

static cJSON *choice_schema(const config_key *key) {
  cJSON *object = cJSON_CreateObject();
  cJSON *list = cJSON_AddArrayToObject(object, "enum");
  for (int n = 0; key->names[n] != NULL; n++)
    cJSON_AddItemToArray(list, cJSON_CreateString(key->names[n]));
  return object;
}

static cJSON *texts_schema(void) {
  cJSON *object = cJSON_CreateObject();
  cJSON *list = cJSON_AddArrayToObject(object, "anyOf");
  cJSON_AddItemToArray(list, typed("string"));
  cJSON_AddItemToArray(list, list_of(typed("string"), 0));
  return object;
}

static cJSON *record_schema(const config_key *keys);

static cJSON *key_schema(const config_key *key) {
  switch (key->kind) {
  case CONFIG_KEY_BOOL:
    return typed("boolean");
  case CONFIG_KEY_NUMBER:
  case CONFIG_KEY_COUNT:
    return number_schema(key);
  case CONFIG_KEY_VECTOR:
    return list_of(number_schema(key), 3);
  case CONFIG_KEY_TEXT:
    return typed("string");
  case CONFIG_KEY_TEXTS:
    return texts_schema();
  case CONFIG_KEY_CHOICE:
    return choice_schema(key);
  case CONFIG_KEY_OBJECT:
    return record_schema(key->keys);
  case CONFIG_KEY_LIST:
    return list_of(record_schema(key->keys), 0);
  case CONFIG_KEY_OWN:
    break;
  }
  return cJSON_Parse(key->schema);
}

/* "about, in UNIT; default FALLBACK" */
static void describe(const config_key *key, cJSON *object) {
  char text[400];
  const bool unit = key->unit != NULL && key->unit[0] != 0;
  snprintf(text, sizeof text, "%s%s%s%s%s%s", key->about, unit ? " [" : "", unit ? key->unit : "",
           unit ? "]" : "", key->fallback != NULL ? "; default " : "",
           key->fallback != NULL ? key->fallback : "");
  cJSON_AddStringToObject(object, "description", text);
}

static cJSON *record_schema(const config_key *keys) {
  cJSON *object = typed("object");
  cJSON_AddBoolToObject(object, "additionalProperties", false);
  cJSON *required = cJSON_CreateArray();
  cJSON *properties = cJSON_AddObjectToObject(object, "properties");
  for (const config_key *key = keys; key->name != NULL; key++) {
    cJSON *schema = key_schema(key);
    describe(key, schema);
    cJSON_AddItemToObject(properties, key->name, schema);
    if (key->needed)
      cJSON_AddItemToArray(required, cJSON_CreateString(key->name));
  }
  if (cJSON_GetArraySize(required) > 0)
    cJSON_AddItemToObject(object, "required", required);
  else
    cJSON_Delete(required);
  return object;
}

cJSON *config_record_schema(const char *title, const config_key *keys) {
  cJSON *schema = record_schema(keys);
  cJSON_AddStringToObject(schema, "$schema", "http://json-schema.org/draft-07/schema#");
  cJSON_AddStringToObject(schema, "title", title);
  cJSON_AddItemToObject(cJSON_GetObjectItem(schema, "properties"), "$schema", typed("string"));
  return schema;
}
