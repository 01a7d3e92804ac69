/* The .npy format 1.0 (NumPy enhancement proposal 1):
 *
 *   93 'NUMPY' 01 00 | length of the text, uint16 | text, ended by a newline | data
 *
 * where the text is a Python dictionary with the keys descr, fortran_order and shape:
 *   {'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }
 * The parser takes the keys in any order and blanks anywhere, and nothing else. Cost: one pass over
 * the text.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/npy.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef struct text_cursor {
  const char *at;
  const char *end;
} text_cursor;

static void skip_blanks(text_cursor *text) {
  while (text->at < text->end && (*text->at == ' ' || *text->at == '\n' || *text->at == '\t'))
    text->at++;
}

static int take(text_cursor *text, char c) {
  skip_blanks(text);
  if (text->at == text->end || *text->at != c)
    return 0;
  text->at++;
  return 1;
}

static int take_word(text_cursor *text, const char *word) {
  skip_blanks(text);
  size_t size = strlen(word);
  if ((size_t)(text->end - text->at) < size || memcmp(text->at, word, size) != 0)
    return 0;
  text->at += size;
  return 1;
}

// a quoted string without escapes, too long ones are refused
static int take_string(text_cursor *text, char *value, size_t capacity) {
  char quote = '\'';
  if (!take(text, quote)) {
    quote = '"';
    if (!take(text, quote))
      return 0;
  }
  size_t size = 0;
  for (; text->at < text->end && *text->at != quote; text->at++) {
    if (size + 1 >= capacity || *text->at < 0x20 || *text->at > 0x7E || *text->at == '\\')
      return 0;
    value[size++] = *text->at;
  }
  value[size] = '\0';
  return take(text, quote);
}

static int take_integer(text_cursor *text, int64_t *value) {
  skip_blanks(text);
  const char *first = text->at;
  int64_t v = 0;
  for (; text->at < text->end && *text->at >= '0' && *text->at <= '9'; text->at++) {
    if (v > (INT64_MAX - 9) / 10)
      return 0;
    v = 10 * v + (*text->at - '0');
  }
  *value = v;
  return text->at != first;
}

// (), (5,), (3, 2), (3, 2,): a comma is needed after a lone entry
static int take_shape(text_cursor *text, thrum_npy *npy) {
  npy->dims = 0;
  if (!take(text, '('))
    return 0;
  int comma = 1;
  while (!take(text, ')')) {
    if (!comma || npy->dims == THRUM_NPY_DIMS_MAX || !take_integer(text, &npy->shape[npy->dims]))
      return 0;
    npy->dims++;
    comma = take(text, ',');
  }
  return npy->dims != 1 || comma;
}

// one key and its value; `seen` has a bit for each key
static int take_entry(text_cursor *text, thrum_npy *npy, unsigned *seen) {
  char key[16];
  if (!take_string(text, key, sizeof key) || !take(text, ':'))
    return 0;

  // each of the three keys has its kind of value
  unsigned bit = 0;
  int good = 0;
  if (strcmp(key, "descr") == 0) {
    bit = 1;
    good = take_string(text, npy->type, sizeof npy->type);
  } else if (strcmp(key, "fortran_order") == 0) {
    bit = 2;
    npy->fortran = take_word(text, "True");
    good = npy->fortran || take_word(text, "False");
  } else if (strcmp(key, "shape") == 0) {
    bit = 4;
    good = take_shape(text, npy);
  }

  // a key that comes twice makes the header ambiguous
  int fresh = (*seen & bit) == 0;
  *seen |= bit;
  return good && fresh;
}

static int take_dictionary(text_cursor *text, thrum_npy *npy) {
  unsigned seen = 0;
  if (!take(text, '{'))
    return 0;
  int comma = 1;
  while (!take(text, '}')) {
    if (!comma || !take_entry(text, npy, &seen))
      return 0;
    comma = take(text, ',');
  }
  skip_blanks(text);
  return seen == 7 && text->at == text->end;
}

thrum_status thrum_npy_parse(const void *bytes, size_t size, const char *where, thrum_npy *npy,
                             thrum_error *error) {
  const unsigned char *p = bytes;

  // the mark and the version
  if (size < 10 || memcmp(p, "\x93NUMPY", 6) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%s: not in the .npy format", where);
  if (p[6] != 1 || p[7] != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%s: .npy format %u.%u, only 1.0 is read",
                           where, (unsigned)p[6], (unsigned)p[7]);

  // the length of the header, little-endian
  size_t length = (size_t)p[8] | (size_t)p[9] << 8;
  if (length > size - 10)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%s: its .npy header is cut short", where);

  // the header is text, the data follow it
  thrum_npy found = {{0}, 0, 0, {0}, p + 10 + length, size - 10 - length};
  text_cursor text = {(const char *)p + 10, (const char *)p + 10 + length};
  if (!take_dictionary(&text, &found))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s: its .npy header is not that of a plain array", where);
  *npy = found;
  return THRUM_OK;
}

void thrum_npy_shape_text(const thrum_npy *npy, char text[96]) {
  size_t used = 0;
  text[used++] = '(';
  for (int d = 0; d < npy->dims && used < 64; d++) {
    int n = snprintf(text + used, 96 - used, d == 0 ? "%" PRId64 : ", %" PRId64, npy->shape[d]);
    used += (size_t)n;
  }
  memcpy(text + used, npy->dims == 1 ? ",)" : ")", npy->dims == 1 ? 3 : 2);
}

// entries times bytes an entry, 0 on overflow
static int data_size(const thrum_npy *npy, size_t item, size_t *size) {
  size_t total = item;
  for (int d = 0; d < npy->dims; d++) {
    if (npy->shape[d] == 0) {
      *size = 0;
      return 1;
    }
    if ((uint64_t)npy->shape[d] > SIZE_MAX / total)
      return 0;
    total *= (size_t)npy->shape[d];
  }
  *size = total;
  return 1;
}

thrum_status thrum_npy_expect(const thrum_npy *npy, const char *type, size_t item,
                              const char *where, thrum_error *error) {
  if (strcmp(npy->type, type) != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE, "%s has type '%s', '%s' is needed", where,
                           npy->type, type);

  // the two orders are one for a vector
  if (npy->fortran && npy->dims > 1)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%s is in Fortran order: pass it through numpy.ascontiguousarray",
                           where);

  // the data must fill the shape exactly
  size_t size = 0;
  if (!data_size(npy, item, &size) || size != npy->size) {
    char shape[96];
    thrum_npy_shape_text(npy, shape);
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s has shape %s of '%s', which its %lu bytes of data do not fill",
                           where, shape, type, (unsigned long)npy->size);
  }
  return THRUM_OK;
}
