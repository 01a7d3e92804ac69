/* A line and number scanner shared by the mesh readers and the fix lists.
 *
 * A file is read whole into memory and walked line by line, a line word by word. Numbers are
 * rounded correctly and read the same in every locale: the decimal mark is a point. Every failure
 * becomes one message "file:line: what is wrong". Cost: linear in the size of the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_TEXT_H
#define THRUM_IO_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

typedef struct thrum_text {
  const char *name;   /* of the file, for messages; borrowed */
  thrum_error *error; /* where failures of the functions below go; NULL: nowhere */
  char *data;         /* the whole file, owned; NULL when the text is borrowed */
  const char *next;   /* first byte past the present line */
  const char *stop;   /* first byte past the text */
  const char *start;  /* present line, without blanks around it and without a comment */
  const char *end;
  const char *at; /* first unread byte of the present line */
  int64_t line;   /* 1-based number of the present line; 0 for a text without lines */
  char comment;   /* opens a comment that runs to the end of the line; 0: there are none */
  char separator; /* stands for a blank between words, such as ','; 0: there is none */
  bool fortran;   /* numbers may be as Fortran writes them, see thrum_text_scan_fortran */
} thrum_text;

/* Reads the file; a byte-order mark is skipped. `path` must outlive *text. On failure *text is
 * untouched. Close it with thrum_text_close. */
thrum_status thrum_text_open(const char *path, char comment, char separator, thrum_text *text,
                             thrum_error *error);
/* Reads `size` bytes of the caller in the same way; name and bytes must outlive *text. */
thrum_status thrum_text_view(const char *name, const void *data, size_t size, char comment,
                             char separator, thrum_text *text, thrum_error *error);
void thrum_text_close(thrum_text *text);

/* Moves to the next line that is not blank; returns false at the end and keeps the line number. */
bool thrum_text_next_line(thrum_text *text);
/* The same where `what` must follow, and the file is cut short if it does not. */
thrum_status thrum_text_need_line(thrum_text *text, const char *what);
/* Reads the present line again from its start. */
void thrum_text_rewind(thrum_text *text);

/* Tells whether there is another word on the line, and skips the separators in front of it. */
bool thrum_text_more(thrum_text *text);
/* Goes on to the line with the next word, which must follow. */
thrum_status thrum_text_need_word(thrum_text *text, const char *what);
/* A word of the text, which must outlive it. */
typedef struct thrum_word {
  const char *text; /* without a zero behind it */
  size_t length;
} thrum_word;
/* Takes the next word of the line; returns false and leaves *word when there is none. */
bool thrum_text_word(thrum_text *text, thrum_word *word);
/* A text that ends with a zero, and the present line, as one word. */
thrum_word thrum_word_of(const char *text);
thrum_word thrum_text_line(const thrum_text *text);
/* Takes `character` if it comes next, after blanks. */
bool thrum_text_take(thrum_text *text, char character);

/* Reads the next word as a whole number within [low, high], or as a finite number; `what` names it
 * in the message, such as "the x coordinate". On failure *value is untouched. */
thrum_status thrum_text_integer(thrum_text *text, const char *what, int64_t low, int64_t high,
                                int64_t *value);
thrum_status thrum_text_number(thrum_text *text, const char *what, double *value);
/* Reads the number in front of item `i` (0-based) of a list, which is numbered one by one: the
 * first number, 0 or 1, is *base. */
thrum_status thrum_text_item(thrum_text *text, const char *what, int64_t i, int64_t *base);
/* The three coordinates of a point. */
thrum_status thrum_text_position(thrum_text *text, double position[3]);
/* Refuses anything left on the line after `what`. */
thrum_status thrum_text_finish(thrum_text *text, const char *what);

/* Fills the error of the text with "file:line: message" and returns `status`. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
thrum_status
thrum_text_fail(const thrum_text *text, thrum_status status, const char *format, ...);

/* Tells whether the word equals `name`; capitals do not matter. */
bool thrum_text_equals(thrum_word word, const char *name);

/* A printable excerpt of at most 40 bytes of foreign text, for messages. */
typedef struct thrum_excerpt {
  char text[48];
} thrum_excerpt;
thrum_excerpt thrum_text_excerpt(thrum_word word);

/* Returns the length of the well-formed UTF-8 sequence (RFC 3629) at the start of `length` bytes, 1
 * to 4; 0 when there is none. Overlong forms, surrogates and code points above the last are
 * refused. */
int thrum_utf8_length(const char *text, size_t length);

/* Scans a decimal number at [at, end) and returns the number of bytes used, 0 when there is none.
 * The number is rounded correctly, and one that is too large becomes infinity. `nan` and `inf` are
 * scanned too, so that they can be named. */
size_t thrum_text_scan_number(const char *at, const char *end, double *value);
/* The same of a number as Fortran writes it: the exponent may follow a d in the place of the e, or
 * its sign alone, as in 1.5d0 and 1.5+3. */
size_t thrum_text_scan_fortran(const char *at, const char *end, double *value);
/* Scans a whole number in the same way; returns 0 also when it does not fit. */
size_t thrum_text_scan_integer(const char *at, const char *end, int64_t *value);

#endif
