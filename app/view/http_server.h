/* A server of a few files on this machine alone. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_HTTP_SERVER_H
#define THRUM_APP_VIEW_HTTP_SERVER_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

/* What stands at a path: the bytes are the caller's and must stay. */
typedef struct cli_http_file {
  const char *path, *type; /* "/", "text/html; charset=utf-8" */
  const void *bytes;
  size_t size;
} cli_http_file;

typedef struct cli_http_server cli_http_server;

/* Listens on 127.0.0.1; port 0 takes a free one. From now on SIGINT, SIGTERM and SIGHUP, where they
 * are not ignored, end cli_http_serve. One server at a time. */
thrum_status cli_http_open(int64_t port, cli_http_server **opened, thrum_error *error);

/* The port listened on. */
int64_t cli_http_port(const cli_http_server *server);

/* Answers GET and HEAD until a signal. One thread: no client waits for another, and one that stands
 * still for some seconds is let go. */
void cli_http_serve(cli_http_server *server, const cli_http_file *files, int64_t count);

/* Hangs up; the signals do again what they did before. NULL is fine. */
void cli_http_close(cli_http_server *server);

#endif
