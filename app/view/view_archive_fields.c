/* Members of defs in an archive, by the rows of thrum/fields.h. SPDX-License-Identifier: Apache-2.0
 */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>

#include "app/view/view_archive.h"
#include "io/json.h"
#include "thrum/thrum.h"

void view_archive_add_fields(cJSON *object, thrum_scene_record record, const void *def) {
  int64_t count;
  const thrum_field *fields = thrum_scene_fields(record, &count);
  for (const thrum_field *field = fields; field < fields + count; field++) {
    const void *at = (const char *)def + field->offset;
    if (!field->key || cJSON_HasObjectItem(object, field->name))
      continue;
    if (field->kind == THRUM_FIELD_FLAG)
      cJSON_AddBoolToObject(object, field->name, *(const int32_t *)at);
    else if (field->kind == THRUM_FIELD_INT64)
      json_number(object, field->name, (double)*(const int64_t *)at);
    else if (field->width > 1)
      json_numbers(object, field->name, at, field->width);
    else if (isfinite(*(const double *)at)) // JSON has no infinity, which is a default
      json_number(object, field->name, *(const double *)at);
  }
}
