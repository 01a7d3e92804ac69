/* Requests of HTTP/1.1, as far as a server of a few fixed files needs to understand them: RFC 9110
 * and 9112. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_HTTP_REQUEST_H
#define THRUM_APP_VIEW_HTTP_REQUEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CLI_HTTP_HEAD_MAX 8192 /* bytes of a request line and its headers */
#define CLI_HTTP_PATH_MAX 256

typedef struct cli_http_request {
  bool body;                    /* GET; false: HEAD */
  char path[CLI_HTTP_PATH_MAX]; /* as sent, without what follows '?' */
} cli_http_request;

/* Bytes of the head that the text begins with, its empty line included; 0: not all there yet. */
size_t cli_http_head_length(const char *text, size_t length);

/* Understands a whole head. 200, or the status to refuse it with: 400; 403 where Host is not this
 * machine's own name and `port`, so that no page of another site reads what is served by having
 * its name point here (DNS rebinding); 405, 414, 505. */
int cli_http_parse(const char *head, size_t length, int64_t port, cli_http_request *request);

#endif
