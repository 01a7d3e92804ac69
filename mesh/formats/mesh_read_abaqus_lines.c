/* Lines and fields of Abaqus decks: comments, continued keyword lines, *INCLUDE, numbers as Fortran
 * writes them, blank fields.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "mesh/formats/mesh_read_abaqus.h"

thrum_text *inp_text(inp_reader *r) {
  return thrum_included_text(&r->files);
}

static bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static char lower(char c) {
  return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

bool inp_same(thrum_word a, thrum_word b) {
  size_t i = 0, j = 0;
  for (;;) {
    while (i < a.length && is_blank(a.text[i]))
      i++;
    while (j < b.length && is_blank(b.text[j]))
      j++;
    if (i == a.length || j == b.length)
      return i == a.length && j == b.length;
    if (lower(a.text[i++]) != lower(b.text[j++]))
      return false;
  }
}

bool inp_is(thrum_word word, const char *name) {
  return inp_same(word, thrum_word_of(name));
}

/* Returns the text without the blanks and quotes around it. */
static thrum_word trim(const char *start, const char *end) {
  while (start < end && is_blank(*start))
    start++;
  while (end > start && is_blank(end[-1]))
    end--;
  if (end - start >= 2 && *start == '"' && end[-1] == '"') {
    start++;
    end--;
  }
  return (thrum_word){start, (size_t)(end - start)};
}

/* Goes to the next line that is no comment, whatever keyword it has. */
static bool raw_line(inp_reader *r) {
  while (thrum_included_next_line(&r->files)) {
    const thrum_text *text = inp_text(r);
    if (text->end - text->start < 2 || text->start[0] != '*' || text->start[1] != '*')
      return true;
  }
  return false;
}

/* The next comma outside of quotes, NULL: there is none. */
static const char *find_comma(const char *start, const char *end) {
  bool quoted = false;
  for (const char *p = start; p < end; p++) {
    quoted = quoted != (*p == '"');
    if (*p == ',' && !quoted)
      return p;
  }
  return NULL;
}

/* Splits the present line at commas into `key=value`; a comma at its end continues the list on the
 * next line. */
static void read_parameters(inp_reader *r, const char *start, inp_keyword *keyword) {
  for (;;) {
    // a comma at the end of a line says that the next one goes on
    if (start == inp_text(r)->end) {
      if (!raw_line(r))
        return;
      start = inp_text(r)->start;
    }
    const char *end = inp_text(r)->end, *comma = find_comma(start, end);
    const char *stop = comma ? comma : end;

    // a parameter without '=' is a flag such as GENERATE
    const char *equals = memchr(start, '=', (size_t)(stop - start));
    thrum_word key = trim(start, equals ? equals : stop);
    if (key.length > 0 && keyword->count < INP_PARAMETERS_MAX)
      keyword->parameters[keyword->count++] =
          (inp_parameter){key, equals ? trim(equals + 1, stop) : (thrum_word){"", 0}};

    // the list ends with its last parameter
    if (!comma)
      return;
    start = comma + 1;
  }
}

void inp_read_keyword(inp_reader *r, inp_keyword *keyword) {
  thrum_text *text = inp_text(r);
  const char *start = text->start + 1, *end = text->end, *comma = find_comma(start, end);
  *keyword = (inp_keyword){.name = trim(start, comma ? comma : end), .line = text->line};
  if (comma)
    read_parameters(r, comma + 1, keyword);
  inp_text(r)->at = inp_text(r)->end;
}

/* Keeps the first failure of a step to the next line, which can only say that there is no more. */
static bool break_off(inp_reader *r, thrum_status status) {
  r->broken = status;
  if (r->error)
    r->failure = *r->error;
  return false;
}

bool inp_next_line(inp_reader *r) {
  if (r->broken < 0)
    return false;
  if (r->again) {
    r->again = false;
    thrum_text_rewind(inp_text(r));
    return true;
  }

  // *INCLUDE may stand anywhere, also among data, so readers never see it
  while (raw_line(r)) {
    inp_keyword keyword;
    const thrum_text *text = inp_text(r);
    if (text->end - text->start < 8 || *text->start != '*' ||
        !inp_is((thrum_word){text->start, 8}, "*INCLUDE"))
      return true;
    inp_read_keyword(r, &keyword);
    const thrum_status status =
        thrum_included_open(&r->files, "*INCLUDE", inp_parameter_of(&keyword, "INPUT"));
    if (status < 0)
      return break_off(r, status);
  }
  return false;
}

bool inp_data_line(inp_reader *r) {
  if (!inp_next_line(r))
    return false;
  r->again = *inp_text(r)->start == '*';
  return !r->again;
}

thrum_status inp_open_input(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word input = inp_parameter_of(keyword, "INPUT");
  return input.text ? thrum_included_open(&r->files, "INPUT=", input) : THRUM_OK;
}

thrum_word inp_parameter_of(const inp_keyword *keyword, const char *key) {
  for (int i = 0; i < keyword->count; i++)
    if (inp_is(keyword->parameters[i].key, key))
      return keyword->parameters[i].value;
  return (thrum_word){NULL, 0};
}

bool inp_has_parameter(const inp_keyword *keyword, const char *key) {
  return inp_parameter_of(keyword, key).text != NULL;
}

/* --- fields ------------------------------------------------------------------------------------
 */

bool inp_more(inp_reader *r) {
  thrum_text *text = inp_text(r);
  while (text->at < text->end && is_blank(*text->at))
    text->at++;
  return text->at < text->end;
}

/* Takes the comma behind a field. */
static void end_field(inp_reader *r) {
  thrum_text *text = inp_text(r);
  if (inp_more(r) && *text->at == ',')
    text->at++;
}

/* Takes the next field up to a blank or a comma; empty: it is blank. */
static thrum_word take_field(inp_reader *r) {
  thrum_text *text = inp_text(r);
  inp_more(r);
  const char *start = text->at;
  while (text->at < text->end && *text->at != ',' && !is_blank(*text->at))
    text->at++;
  const thrum_word word = {start, (size_t)(text->at - start)};
  end_field(r);
  return word;
}

static thrum_status expected(inp_reader *r, const char *what, thrum_word word) {
  return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT, "expected %s, found '%s'", what,
                         thrum_text_excerpt(word).text);
}

thrum_status inp_number(inp_reader *r, const char *what, double *value) {
  const thrum_word word = take_field(r);
  double number = 0;
  if (word.length > 0 &&
      thrum_text_scan_fortran(word.text, word.text + word.length, &number) != word.length)
    return expected(r, what, word);
  if (!isfinite(number))
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE, "%s is '%s', which is not a finite number",
                           what, thrum_text_excerpt(word).text);
  *value = number;
  return THRUM_OK;
}

thrum_status inp_integer_or(inp_reader *r, const char *what, int64_t low, int64_t *value) {
  const thrum_word word = take_field(r);
  if (word.length == 0)
    return THRUM_OK;

  // one word is read as in all formats, so that all say the same of it
  thrum_text one = *inp_text(r);
  one.at = word.text;
  one.end = word.text + word.length;
  return thrum_text_integer(&one, what, low, INT64_MAX, value);
}

thrum_status inp_integer(inp_reader *r, const char *what, int64_t low, int64_t *value) {
  thrum_text *text = inp_text(r);
  if (!inp_more(r))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "the line ends before %s", what);
  if (*text->at == ',')
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "%s is blank", what);
  return inp_integer_or(r, what, low, value);
}

thrum_word inp_word(inp_reader *r) {
  thrum_text *text = inp_text(r);
  const char *comma = find_comma(text->at, text->end), *end = comma ? comma : text->end;
  const thrum_word word = trim(text->at, end);
  text->at = end;
  end_field(r);
  return word;
}

thrum_status inp_finish(inp_reader *r, const char *what) {
  while (inp_more(r)) {
    const thrum_word word = take_field(r);
    if (word.length > 0)
      return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                             "unexpected '%s' after %s (is a decimal mark a comma?)",
                             thrum_text_excerpt(word).text, what);
  }
  return THRUM_OK;
}
