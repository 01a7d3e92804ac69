/* Tables made from reports, see report.h. SPDX-License-Identifier: Apache-2.0 */
#include "io/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/plain_text.h"
#include "io/json.h"
#include "io/percent.h"

#define WORD_BYTES 100  /* bytes of a key, of a format and of a number */
#define TEXT_BYTES 1000 /* bytes between two braces */
#define LINE_BYTES 4000 /* bytes of a line */
#define SCOPES 3

/* Where values are looked for, the first that has the key: an item of a list, what the table has
 * alone, the report. */
typedef struct scopes {
  const cJSON *of[SCOPES];
} scopes;

/* A text that is being made. */
typedef struct made {
  char *text;
  size_t size, used;
} made;

static void put(made *m, const char *text, size_t length) {
  const size_t left = m->size - 1 - m->used, taken = length < left ? length : left;
  memcpy(m->text + m->used, text, taken);
  m->used += taken;
  m->text[m->used] = 0;
}

/* --- values ----------------------------------------------------------------------------------- */

/* The part of an object or an array that a word names; NULL: it has none. */
static const cJSON *part_of(const cJSON *item, const char *word) {
  char *end;
  if (!cJSON_IsArray(item))
    return cJSON_GetObjectItemCaseSensitive(item, word);
  const long place = strtol(word, &end, 10);
  return *end == 0 ? cJSON_GetArrayItem(item, (int)place) : NULL;
}

/* The value of a key such as "a.b.0"; NULL where it is missing. */
static const cJSON *find(const scopes *in, const char *key) {
  const cJSON *item = NULL;
  for (int n = 0; n < SCOPES && item == NULL; n++) {
    const char *at = key;
    item = in->of[n];
    while (item != NULL && *at != 0) {
      char word[WORD_BYTES];
      const size_t length = strcspn(at, ".");
      snprintf(word, sizeof word, "%.*s", (int)length, at);
      item = part_of(item, word);
      at += length + (at[length] == '.' ? 1 : 0);
    }
  }
  return item == NULL || cJSON_IsNull(item) ? NULL : item;
}

static bool is_true(const cJSON *item) {
  if (item == NULL || cJSON_IsBool(item))
    return cJSON_IsTrue(item);
  if (cJSON_IsString(item))
    return item->valuestring[0] != 0;
  return cJSON_IsArray(item) || cJSON_IsObject(item) ? item->child != NULL : json_value(item) != 0;
}

static bool holds(const scopes *in, const char *condition) {
  char key[WORD_BYTES];
  const bool no = condition[0] == '!';
  const char *from = condition + (no ? 1 : 0), *text = strchr(from, '=');
  snprintf(key, sizeof key, "%.*s", (int)strcspn(from, "="), from);

  // a key, or a text that it is to be
  const cJSON *item = find(in, key);
  const char *said = item != NULL ? cJSON_GetStringValue(item) : "null";
  const bool yes = text == NULL ? is_true(item) : said != NULL && strcmp(said, text + 1) == 0;
  return yes != no;
}

/* --- braces ----------------------------------------------------------------------------------- */

/* A number as printf has it, in per cent where a % ends the format. */
static void put_number(made *m, double number, const char *format) {
  char form[WORD_BYTES + 8], text[WORD_BYTES];
  const size_t length = strlen(format);
  const bool percent = length > 0 && format[length - 1] == '%';
  if (length == 1 && percent) {
    put(m, text, (size_t)snprintf(text, sizeof text, "%s %%", percent_text(number, form)));
    return;
  }
  snprintf(form, sizeof form, "%%%.*s%s", (int)(length - percent), format, percent ? " %%" : "");
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  snprintf(text, sizeof text, form, percent ? 100 * number : number);
#pragma GCC diagnostic pop
  put(m, text, strlen(text));
}

/* A value in a format; "": its own. */
static void put_value(made *m, const cJSON *item, const char *format) {
  char own[WORD_BYTES], padded[TEXT_BYTES];
  const size_t length = strlen(format);
  if (length > 0 && format[length - 1] != 's') {
    put_number(m, json_value(item), format);
    return;
  }

  // texts, and numbers with their digits
  snprintf(own, sizeof own, "%.15g", json_value(item));
  const char *said = cJSON_IsString(item) ? item->valuestring : own;
  if (length > 0) {
    snprintf(padded, sizeof padded, "%*s", atoi(format), said);
    said = padded;
  }
  put(m, said, strlen(said));
}

/* Length of a text up to one of these characters outside of braces in it. */
static size_t span(const char *text, const char *ends) {
  int depth = 0;
  size_t n = 0;
  for (; text[n] != 0 && (depth > 0 || strchr(ends, text[n]) == NULL); n++)
    depth += text[n] == '{' ? 1 : text[n] == '}' ? -1 : 0;
  return n;
}

static bool fill(made *m, const scopes *in, const char *text);

/* Of "one|other" the first, or the second, which may not be there. */
static bool fill_either(made *m, const scopes *in, const char *both, bool first) {
  char one[TEXT_BYTES];
  const size_t bar = span(both, "|");
  if (!first)
    return both[bar] == 0 || fill(m, in, both + bar + 1);
  snprintf(one, sizeof one, "%.*s", (int)bar, both);
  return fill(m, in, one);
}

/* What stands between two braces; false where a value is missing. */
static bool fill_braces(made *m, const scopes *in, const char *inside) {
  char key[WORD_BYTES], format[WORD_BYTES];
  const size_t length = strcspn(inside, ":?#|");
  const char mark = inside[length], *rest = inside + length + (mark != 0 ? 1 : 0);
  snprintf(key, sizeof key, "%.*s", (int)length, inside);
  const cJSON *item = mark == '?' ? NULL : find(in, key);
  if (mark == '?' || (mark == '#' && item != NULL))
    return fill_either(m, in, rest, mark == '?' ? holds(in, key) : json_value(item) == 1);

  // what stands in the place of a value that is missing
  const size_t bar = mark == '|' ? 0 : span(rest, "|");
  if (item == NULL && (mark == '|' || rest[bar] == '|'))
    return fill(m, in, rest + bar + (mark == '|' ? 0 : 1));
  if (item == NULL)
    return false;

  // one value, or all of an array
  snprintf(format, sizeof format, "%.*s", mark == ':' ? (int)bar : 0, rest);
  if (!cJSON_IsArray(item)) {
    put_value(m, item, format);
    return true;
  }
  for (const cJSON *at = item->child; at != NULL; at = at->next) {
    put(m, ", ", at == item->child ? 0 : 2);
    put_value(m, at, format);
  }
  return true;
}

/* A text with its values; false where one outside of brackets is missing. */
static bool fill(made *m, const scopes *in, const char *text) {
  bool whole = true, bracket = false, there = true;
  size_t begun = 0;
  for (const char *at = text; *at != 0; at++) {
    if (*at == '{') {
      char inside[TEXT_BYTES];
      const size_t length = span(at + 1, "}");
      snprintf(inside, sizeof inside, "%.*s", (int)length, at + 1);
      const bool filled = fill_braces(m, in, inside);
      there = there && (filled || !bracket);
      whole = whole && (filled || bracket);
      at += length + 1;
    } else if ((*at == '[' || *at == ']') && at[1] == *at) {
      put(m, at++, 1);
    } else if (*at == '[') {
      bracket = there = true;
      begun = m->used;
    } else if (*at == ']') {
      m->used = there ? m->used : begun;
      m->text[m->used] = 0;
      bracket = false;
    } else {
      put(m, at, 1);
    }
  }
  return whole;
}

/* --- lines ------------------------------------------------------------------------------------ */

static bool text_in(const scopes *in, const char *text, char *into, size_t size) {
  made m = {.text = into, .size = size};
  into[0] = 0;
  return fill(&m, in, text);
}

bool report_text(const cJSON *report, const cJSON *more, const char *text, char *into,
                 size_t size) {
  return text_in(&(scopes){{NULL, more, report}}, text, into, size);
}

/* Prints a line, or returns false where it is left out. */
static bool print_line(const scopes *in, int width, const report_line *line, bool first) {
  char label[TEXT_BYTES], text[LINE_BYTES];
  if (line->when != NULL && !holds(in, line->when))
    return false;
  if (!text_in(in, line->label, label, sizeof label) || !text_in(in, line->text, text, sizeof text))
    return false;

  // a value may be of a file from elsewhere, and hold anything
  thrum_plain_text(label);
  thrum_plain_text(text);
  printf("%-*s%s\n", width, line->once && !first ? "" : label, text);
  return true;
}

/* The same line of each item, whose keys come before those of the report. */
static void print_each(scopes in, const char *each, int width, const report_line *line) {
  const cJSON *item = NULL, *list = find(&in, each);
  bool first = true;
  cJSON_ArrayForEach(item, list) {
    in.of[0] = item;
    first = !print_line(&in, width, line, first) && first;
  }
}

void report_print(const cJSON *report, const cJSON *more, int width, const report_line *lines) {
  const scopes in = {{NULL, more, report}};
  for (const report_line *line = lines; line->text != NULL; line++)
    if (line->each != NULL)
      print_each(in, line->each, width, line);
    else
      print_line(&in, width, line, true);
}

void report_print_each(const cJSON *report, const cJSON *more, const char *each, int width,
                       const report_line *lines) {
  scopes in = {{NULL, more, report}};
  const cJSON *item = NULL, *list = find(&in, each);
  cJSON_ArrayForEach(item, list) {
    in.of[0] = item;
    for (const report_line *line = lines; line->text != NULL; line++)
      print_line(&in, width, line, true);
  }
}

void report_show(cJSON *report, cJSON *more, bool json, int width, const report_line *lines) {
  if (!json) {
    report_end(report, more, width, lines);
    return;
  }
  json_print(report);
  cJSON_Delete(more);
}

void report_end(cJSON *report, cJSON *more, int width, const report_line *lines) {
  report_print(report, more, width, lines);
  cJSON_Delete(report);
  cJSON_Delete(more);
}
