/* The defs of thrum/fields.h for JavaScript, which finds the places of their fields here and writes
 * them itself: a new field needs nothing in this folder. SPDX-License-Identifier: Apache-2.0 */
#include "javascript/bridge.h"

static union {
  thrum_scene_body_def body;
  thrum_scene_link_def link;
  thrum_scene_solid_def solid;
  thrum_contact_pairs_def pairs;
  thrum_scene_wind_def wind;
  thrum_scene_load_def load;
  thrum_obstacle obstacle;
} def;

void *js_def_made(void) {
  return &def;
}

/* Makes the one def that is filled in: it has the defaults of its record. */
void *EXPORT(js_def)(int32_t record) {
  thrum_scene_record_default((thrum_scene_record)record, &def);
  return &def;
}

/* numbers: kind, width, and the places of field `index` of a record and of the count of its rows;
 * its range, whether the least is not in it, and whether it is a key of scene files. Returns 0
 * where there is no such field. */
int32_t EXPORT(js_field)(int32_t record, int32_t index) {
  int64_t count;
  const thrum_field *fields = thrum_scene_fields((thrum_scene_record)record, &count);
  if (index >= count)
    return 0;
  js_number[0] = fields[index].kind;
  js_number[1] = fields[index].width;
  js_number[2] = (double)fields[index].offset;
  js_number[3] = (double)fields[index].count_offset;
  js_number[4] = fields[index].least;
  js_number[5] = fields[index].most;
  js_number[6] = fields[index].above;
  js_number[7] = fields[index].key;
  return 1;
}

/* The name (0), the names of its choices (1) or what holds without a field (2); NULL: nothing to
 * say. */
const char *EXPORT(js_field_text)(int32_t record, int32_t index, int32_t which) {
  int64_t count;
  const thrum_field *field = thrum_scene_fields((thrum_scene_record)record, &count) + index;
  const char *const texts[] = {field->name, field->names, field->otherwise};
  return texts[which];
}
