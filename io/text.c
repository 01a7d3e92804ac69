/* Reads the lines, words and numbers of text files; see io/text.h.
 *
 * Numbers are delimited here and converted by strtod, which rounds correctly; it gets the decimal
 * mark of the locale that the program runs in, so that files read the same in all of them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/text.h"

#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"

enum { ROOM = 128 /* bytes of a number without memory of its own */, PATH_SHOWN = 150 };

static bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

static char lower(char c) {
  return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

thrum_status thrum_text_view(const char *name, const void *data, size_t size, char comment,
                             char separator, thrum_text *text, thrum_error *error) {
  const unsigned char *bytes = data;

  // a wide encoding would read as garbage: name it
  if (size >= 2 &&
      ((bytes[0] == 0xff && bytes[1] == 0xfe) || (bytes[0] == 0xfe && bytes[1] == 0xff)))
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%.200s: is UTF-16 text; save it as UTF-8",
                           name);

  // a UTF-8 byte order mark is no part of the text
  size_t mark = size >= 3 && bytes[0] == 0xef && bytes[1] == 0xbb && bytes[2] == 0xbf ? 3 : 0;
  const char *first = size > 0 ? (const char *)data + mark : "";
  *text = (thrum_text){.name = name,
                       .next = first,
                       .stop = first + (size - mark),
                       .start = first,
                       .end = first,
                       .at = first,
                       .error = error,
                       .comment = comment,
                       .separator = separator};
  return THRUM_OK;
}

thrum_status thrum_text_open(const char *path, char comment, char separator, thrum_text *text,
                             thrum_error *error) {
  void *data = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_read(path, &data, &size, error));
  thrum_status status = thrum_text_view(path, data, size, comment, separator, text, error);
  if (status < 0)
    free(data);
  else
    text->data = data;
  return status;
}

void thrum_text_close(thrum_text *text) {
  free(text->data);
  *text = (thrum_text){0};
}

bool thrum_text_next_line(thrum_text *text) {
  while (text->next < text->stop) {
    const char *start = text->next, *end = start;
    while (end < text->stop && *end != '\n' && *end != '\r')
      end++;

    // a line ends in LF, CR LF or CR
    const char *next = end < text->stop ? end + 1 : end;
    if (next < text->stop && *end == '\r' && *next == '\n')
      next++;

    text->next = next;
    text->line++;

    // comments and blanks are cut off, and lines of nothing else are skipped but counted
    const char *comment =
        text->comment ? memchr(start, text->comment, (size_t)(end - start)) : NULL;
    if (comment)
      end = comment;
    while (start < end && is_blank(*start))
      start++;
    while (end > start && is_blank(end[-1]))
      end--;

    if (start == end)
      continue;
    text->start = text->at = start;
    text->end = end;
    return true;
  }

  text->start = text->end = text->at = text->stop;
  return false;
}

thrum_status thrum_text_need_line(thrum_text *text, const char *what) {
  if (thrum_text_next_line(text))
    return THRUM_OK;
  return thrum_text_fail(text, THRUM_BAD_FORMAT, "the file ends before %s; is it cut short?", what);
}

void thrum_text_rewind(thrum_text *text) {
  text->at = text->start;
}

static bool separates(const thrum_text *text, char c) {
  return is_blank(c) || (text->separator && c == text->separator);
}

bool thrum_text_more(thrum_text *text) {
  while (text->at < text->end && separates(text, *text->at))
    text->at++;
  return text->at < text->end;
}

thrum_status thrum_text_need_word(thrum_text *text, const char *what) {
  while (!thrum_text_more(text))
    THRUM_TRY(thrum_text_need_line(text, what));
  return THRUM_OK;
}

bool thrum_text_word(thrum_text *text, thrum_word *word) {
  if (!thrum_text_more(text))
    return false;
  const char *start = text->at;
  while (text->at < text->end && !separates(text, *text->at))
    text->at++;
  *word = (thrum_word){start, (size_t)(text->at - start)};
  return true;
}

thrum_word thrum_text_line(const thrum_text *text) {
  return (thrum_word){text->start, (size_t)(text->end - text->start)};
}

bool thrum_text_take(thrum_text *text, char character) {
  while (text->at < text->end && is_blank(*text->at))
    text->at++;
  if (text->at == text->end || *text->at != character)
    return false;
  text->at++;
  return true;
}

static thrum_status expected(const thrum_text *text, const char *what, thrum_word word) {
  const char *hint = memchr(word.text, ',', word.length) ? " (the decimal mark is a point)" : "";
  return thrum_text_fail(text, THRUM_BAD_FORMAT, "expected %s, found '%s'%s", what,
                         thrum_text_excerpt(word).text, hint);
}

/* Tells whether a word is a whole number, perhaps one that 64 bits cannot hold. */
static bool is_whole(thrum_word word) {
  size_t digits = word.length > 1 && (word.text[0] == '-' || word.text[0] == '+') ? 1 : 0;
  while (digits < word.length && word.text[digits] >= '0' && word.text[digits] <= '9')
    digits++;
  return word.length > 0 && digits == word.length;
}

thrum_status thrum_text_integer(thrum_text *text, const char *what, int64_t low, int64_t high,
                                int64_t *value) {
  thrum_word word = {"", 0};
  if (!thrum_text_word(text, &word))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "the line ends before %s", what);
  int64_t number = 0;
  size_t used = thrum_text_scan_integer(word.text, word.text + word.length, &number);

  // a number beyond 64 bits deserves another message than a word that is none
  if (used != word.length && is_whole(word))
    return thrum_text_fail(text, THRUM_BAD_VALUE,
                           "%s is %s, which is out of range; it may be %lld to %lld", what,
                           thrum_text_excerpt(word).text, (long long)low, (long long)high);
  if (used != word.length)
    return expected(text, what, word);

  if (number < low || number > high)
    return thrum_text_fail(text, THRUM_BAD_VALUE,
                           "%s is %lld, which is out of range; it may be %lld to %lld", what,
                           (long long)number, (long long)low, (long long)high);
  *value = number;
  return THRUM_OK;
}

thrum_status thrum_text_number(thrum_text *text, const char *what, double *value) {
  thrum_word word = {"", 0};
  if (!thrum_text_word(text, &word))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "the line ends before %s", what);
  double number = 0;
  const char *end = word.text + word.length;
  const size_t used = text->fortran ? thrum_text_scan_fortran(word.text, end, &number)
                                    : thrum_text_scan_number(word.text, end, &number);
  if (used != word.length)
    return expected(text, what, word);
  if (!isfinite(number))
    return thrum_text_fail(text, THRUM_BAD_VALUE, "%s is '%s', which is not a finite number", what,
                           thrum_text_excerpt(word).text);
  *value = number;
  return THRUM_OK;
}

thrum_status thrum_text_item(thrum_text *text, const char *what, int64_t i, int64_t *base) {
  int64_t number = 0;
  if (i == 0)
    return thrum_text_integer(text, what, 0, 1, base);

  THRUM_TRY(thrum_text_integer(text, what, 0, INT64_MAX, &number));
  if (number == i + *base)
    return THRUM_OK;
  return thrum_text_fail(text, THRUM_BAD_FORMAT,
                         "%s is %lld where %lld comes next; number them one by one", what,
                         (long long)number, (long long)(i + *base));
}

thrum_status thrum_text_position(thrum_text *text, double position[3]) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  for (int c = 0; c < 3; c++)
    THRUM_TRY(thrum_text_number(text, axes[c], &position[c]));
  return THRUM_OK;
}

thrum_status thrum_text_finish(thrum_text *text, const char *what) {
  thrum_word word = {"", 0};
  if (!thrum_text_word(text, &word))
    return THRUM_OK;
  return thrum_text_fail(text, THRUM_BAD_FORMAT,
                         "unexpected '%s' after %s (is a decimal mark a comma?)",
                         thrum_text_excerpt(word).text, what);
}

thrum_status thrum_text_fail(const thrum_text *text, thrum_status status, const char *format, ...) {
  if (!text->error)
    return status;
  char message[sizeof text->error->message];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);

  // the end of a very long path says most
  size_t length = strlen(text->name);
  const char *cut = length > PATH_SHOWN ? "..." : "";
  const char *name = length > PATH_SHOWN ? text->name + length - PATH_SHOWN : text->name;

  if (text->line > 0)
    return thrum_error_set(text->error, status, "%s%s:%lld: %s", cut, name, (long long)text->line,
                           message);
  return thrum_error_set(text->error, status, "%s%s: %s", cut, name, message);
}

bool thrum_text_equals(thrum_word word, const char *name) {
  for (size_t i = 0; i < word.length; i++)
    if (!name[i] || lower(word.text[i]) != lower(name[i]))
      return false;
  return !name[word.length];
}

thrum_excerpt thrum_text_excerpt(thrum_word word) {
  enum { SHOWN = 40 };
  thrum_excerpt excerpt = {{0}};
  for (size_t i = 0; i < word.length && i < SHOWN; i++)
    excerpt.text[i] = word.text[i] >= ' ' && word.text[i] <= '~' ? word.text[i] : '?';
  if (word.length > SHOWN)
    memcpy(excerpt.text + SHOWN, "...", 4);
  return excerpt;
}

thrum_word thrum_word_of(const char *text) {
  return (thrum_word){text, strlen(text)};
}

size_t thrum_text_scan_integer(const char *at, const char *end, int64_t *value) {
  const char *p = at;
  bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+'))
    p++;
  if (p == end || !is_digit(*p))
    return 0;

  // the check before each digit keeps the product from overflowing
  uint64_t number = 0;
  for (; p < end && is_digit(*p); p++) {
    unsigned digit = (unsigned)(*p - '0');
    if (number > ((uint64_t)INT64_MAX - digit) / 10)
      return 0;
    number = 10 * number + digit;
  }

  *value = negative ? -(int64_t)number : (int64_t)number;
  return (size_t)(p - at);
}

/* Scans nan, inf and infinity, so that they can be refused by name. */
static size_t scan_word(const char *p, const char *end, double *value) {
  static const char *const words[] = {"infinity", "inf", "nan"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
    size_t length = strlen(words[i]);
    if ((size_t)(end - p) >= length && thrum_text_equals((thrum_word){p, length}, words[i])) {
      *value = i == 2 ? (double)NAN : (double)INFINITY;
      return length;
    }
  }
  return 0;
}

/* Finds the end of "digits . digits e sign digits" at p; NULL when it has no digit before the e. An
 * e without digits behind it does not belong to the number. *point is the mark, NULL without one.
 */
static const char *find_number_end(const char *p, const char *end, const char **point) {
  bool any = false;
  *point = NULL;

  for (; p < end && (is_digit(*p) || (*p == '.' && !*point)); p++)
    if (*p == '.')
      *point = p;
    else
      any = true;
  if (!any)
    return NULL;

  // an exponent counts only with digits behind its e
  const char *q = p;
  if (q == end || lower(*q) != 'e')
    return p;
  q++;
  if (q < end && (*q == '-' || *q == '+'))
    q++;
  if (q == end || !is_digit(*q))
    return p;
  while (q < end && is_digit(*q))
    q++;
  return q;
}

/* Converts the number in [p, end), whose form is known, by strtod with the mark that the locale
 * wants. Returns false when there is no memory for a very long one. */
static bool convert(const char *p, const char *end, const char *point, double *value) {
  const char *mark = localeconv()->decimal_point;
  const size_t head = (size_t)((point ? point : end) - p), between = point ? strlen(mark) : 0;
  const size_t tail = point ? (size_t)(end - point - 1) : 0;
  char room[ROOM], *text = room;

  // few numbers need memory of their own
  if (head + between + tail >= sizeof room)
    text = malloc(head + between + tail + 1);
  if (!text)
    return false;

  // the point of the file becomes the decimal mark of the locale
  memcpy(text, p, head);
  memcpy(text + head, mark, between);
  if (point)
    memcpy(text + head + between, point + 1, tail);
  text[head + between + tail] = '\0';

  *value = strtod(text, NULL);
  if (text != room)
    free(text);
  return true;
}

size_t thrum_text_scan_number(const char *at, const char *end, double *value) {
  const char *p = at, *point = NULL;
  const bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+'))
    p++;

  // digits are the rule; the words for what is not finite are tried after them
  double magnitude = 0;
  const char *stop = find_number_end(p, end, &point);
  if (!stop) {
    const size_t used = scan_word(p, end, &magnitude);
    if (!used)
      return 0;
    stop = p + used;
  } else if (!convert(p, stop, point, &magnitude)) {
    return 0;
  }

  *value = negative ? -magnitude : magnitude;
  return (size_t)(stop - at);
}

size_t thrum_text_scan_fortran(const char *at, const char *end, double *value) {
  const size_t head = thrum_text_scan_number(at, end, value);
  const char *p = at + head;
  char text[ROOM];
  if (head == 0 || p == end || !(is_digit(p[-1]) || p[-1] == '.'))
    return head;

  // a d, or a sign without a letter, begins an exponent only with digits behind it
  if (lower(*p) == 'd')
    p++;
  const char *exponent = p;
  if (p < end && (*p == '+' || *p == '-'))
    p++;
  const char *digits = p;
  while (p < end && is_digit(*p))
    p++;
  const size_t tail = (size_t)(p - exponent);
  const size_t length = head + 1 + tail;
  if (p == digits || length > sizeof text)
    return head;

  // with an e in its place the number is one like all others, if it has no exponent already
  double number = 0;
  memcpy(text, at, head);
  text[head] = 'e';
  memcpy(text + head + 1, exponent, tail);
  if (thrum_text_scan_number(text, text + length, &number) < length)
    return head;
  *value = number;
  return (size_t)(p - at);
}

int thrum_utf8_length(const char *text, size_t length) {
  const unsigned char *s = (const unsigned char *)text;
  if (length > 0 && s[0] < 0x80)
    return 1;

  // the first byte tells the length, and the others must continue it
  const size_t wanted = length == 0                   ? 0
                        : s[0] >= 0xc2 && s[0] < 0xe0 ? 2
                        : s[0] >= 0xe0 && s[0] < 0xf0 ? 3
                        : s[0] >= 0xf0 && s[0] < 0xf5 ? 4
                                                      : 0;
  if (wanted == 0 || wanted > length)
    return 0;
  for (size_t n = 1; n < wanted; n++)
    if ((s[n] & 0xc0) != 0x80)
      return 0;

  // overlong forms, surrogates, and what lies beyond the last code point
  if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) ||
      (s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f))
    return 0;
  return (int)wanted;
}
