/* Orthotropic materials and laminates of options. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/region_elastic.h"

#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "io/text.h"

typedef struct scan {
  const char *at, *end;
} scan;

/* Takes a word and the comma behind it. */
static bool take_word(scan *s, const char *word) {
  const size_t length = strlen(word);
  if ((size_t)(s->end - s->at) <= length || strncmp(s->at, word, length) != 0 ||
      s->at[length] != ',')
    return false;
  s->at += length + 1;
  return true;
}

/* Takes so many numbers with commas between them, and a comma behind the last where more follows.
 */
static bool take_numbers(scan *s, int count, double *numbers) {
  for (int n = 0; n < count; n++) {
    const size_t used = thrum_text_scan_number(s->at, s->end, &numbers[n]);
    s->at += used;
    if (used == 0 || (s->at == s->end ? n < count - 1 : *s->at != ','))
      return false;
    s->at += s->at < s->end;
  }
  return s->at == s->end ? s->end[-1] != ',' : true;
}

bool region_elastic_is(const char *at, const char *end) {
  scan s = {at, end};
  return take_word(&s, "ortho") || take_word(&s, "transverse");
}

/* The constants of the first row, and the density. */
static bool take_constants(scan *s, region_elastic *made) {
  double *row = made->rows, n[10];
  if (take_word(s, "ortho")) {
    if (!take_numbers(s, 10, n))
      return false;
    memcpy(row + THRUM_ELASTIC_YOUNG, n, 9 * sizeof *n);
    made->density = n[9];
    return true;
  }

  // alike along all directions across 1
  if (!take_word(s, "transverse") || !take_numbers(s, 6, n))
    return false;
  const double constants[9] = {
      n[0], n[1], n[1], n[2], n[2], n[3], n[4], n[4], n[1] / (2 * (1 + n[3]))};
  memcpy(row + THRUM_ELASTIC_YOUNG, constants, sizeof constants);
  made->density = n[5];
  return true;
}

/* Direction 1, and another one where it is given; else one that is not parallel. */
static bool take_directions(scan *s, double *row) {
  static const double usual[6] = {1, 0, 0, 0, 1, 0};
  double *first = row + THRUM_ELASTIC_FIRST, *second = row + THRUM_ELASTIC_SECOND;
  memcpy(first, usual, sizeof usual);
  if (!take_word(s, "along"))
    return true;
  if (!take_numbers(s, 3, first))
    return false;
  scan ahead = *s;
  double other[3];
  if (s->at < s->end && take_numbers(&ahead, 3, other)) {
    *s = ahead;
    memcpy(second, other, sizeof other);
    return true;
  }
  const bool along_y = fabs(first[1]) > fabs(first[0]) && fabs(first[1]) > fabs(first[2]);
  second[0] = along_y ? -1 : 0;
  second[1] = along_y ? 0 : 1;
  second[2] = 0;
  return true;
}

/* Layers from the lower face on: angles in degrees, and thicknesses where they differ. */
static bool take_layers(scan *s, region_elastic *made) {
  made->count = 1;
  if (s->at == s->end)
    return true;
  if (!take_word(s, "layers"))
    return false;
  for (made->count = 0; made->count < THRUM_ELASTIC_LAYERS_MAX; made->count++) {
    double *row = made->rows + THRUM_ELASTIC_NUMBERS * made->count, degrees = 0, thickness = 1;
    memmove(row, made->rows, THRUM_ELASTIC_NUMBERS * sizeof *row);
    const size_t used = thrum_text_scan_number(s->at, s->end, &degrees);
    s->at += used;
    if (used == 0 || !(fabs(degrees) <= 360))
      return false;
    if (s->at < s->end && *s->at == '@') {
      const size_t more = thrum_text_scan_number(++s->at, s->end, &thickness);
      s->at += more;
      if (more == 0 || !(thickness > 0 && thickness < 1e30))
        return false;
    }
    row[THRUM_ELASTIC_ANGLE] = degrees * THRUM_PI / 180;
    row[THRUM_ELASTIC_THICKNESS] = thickness;
    if (s->at == s->end) {
      made->count++;
      return true;
    }
    if (*s->at++ != '/')
      return false;
  }
  return false;
}

thrum_status region_elastic_parse(const char *text, const char *at, const char *end,
                                  region_elastic *made, thrum_error *error) {
  scan s = {at, end};
  thrum_elastic_matrix root;
  *made = (region_elastic){0};
  if (!take_constants(&s, made) || !take_directions(&s, made->rows) || !take_layers(&s, made))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.60s' is no material of a region; write "
                           "REGION:ortho,E1,E2,E3,NU12,NU13,NU23,G12,G13,G23,RHO or "
                           "REGION:transverse,E1,E2,NU12,NU23,G12,RHO, then ,along,X,Y,Z and "
                           ",layers,0/90/0 with up to %d layers",
                           text, THRUM_ELASTIC_LAYERS_MAX);
  if (!(made->density >= 1e-30 && made->density <= 1e30))
    return thrum_error_set(error, THRUM_BAD_VALUE, "'%.100s': RHO is above 0, in kg/m^3", text);
  if (!thrum_elastic_root(made->rows, root))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.100s' has no positive energy: moduli are above 0, and Poisson's "
                           "ratios small enough, such as NU12^2 < E1/E2",
                           text);
  return THRUM_OK;
}
