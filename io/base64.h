/* Writes bytes to a stream as base64 text (RFC 4648), piece by piece. SPDX-License-Identifier:
 * Apache-2.0 */
#ifndef THRUM_IO_BASE64_H
#define THRUM_IO_BASE64_H

#include <stddef.h>
#include <stdio.h>

/* A text in the making: up to two bytes wait for the third of their group. Begin with {stream}. */
typedef struct thrum_base64 {
  FILE *stream;
  unsigned char waiting[3];
  size_t waiting_count;
} thrum_base64;

/* Appends bytes to the text; a failure leaves its mark on the stream. */
void thrum_base64_put(thrum_base64 *text, const void *bytes, size_t size);

/* Ends the text, with '=' where the last group is not full. The next bytes begin another text. */
void thrum_base64_end(thrum_base64 *text);

#endif
