/* Reads the heads of HTTP requests, see http_request.h. What is not plainly right is refused: no
 * folded lines, no blanks before a colon, one Host. SPDX-License-Identifier: Apache-2.0 */
#include "app/view/http_request.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* A run of bytes in the head. */
typedef struct span {
  const char *at;
  size_t length;
} span;

static bool is(span text, const char *word) {
  return text.length == strlen(word) && memcmp(text.at, word, text.length) == 0;
}

static bool is_caseless(span text, const char *word) {
  return text.length == strlen(word) && strncasecmp(text.at, word, text.length) == 0;
}

size_t cli_http_head_length(const char *text, size_t length) {
  for (size_t n = 4; n <= length; n++) {
    if (memcmp(text + n - 4, "\r\n\r\n", 4) == 0)
      return n;
  }
  return 0;
}

/* Cuts the text up to `end` off the front of `rest`, and `end` with it. */
static bool cut(span *rest, const char *end, span *front) {
  const size_t width = strlen(end);
  for (size_t n = 0; n + width <= rest->length; n++) {
    if (memcmp(rest->at + n, end, width) != 0)
      continue;
    *front = (span){rest->at, n};
    *rest = (span){rest->at + n + width, rest->length - n - width};
    return true;
  }
  return false;
}

/* "GET /path?query HTTP/1.1" */
static int parse_line(span line, cli_http_request *request) {
  span method, target, query;
  if (!cut(&line, " ", &method) || !cut(&line, " ", &target) || method.length == 0)
    return 400;
  if (line.length != 8 || memcmp(line.at, "HTTP/", 5) != 0)
    return 400;
  if (!is(line, "HTTP/1.1") && !is(line, "HTTP/1.0"))
    return 505;
  request->body = is(method, "GET");
  if (!request->body && !is(method, "HEAD"))
    return 405;
  span rest = target;
  if (cut(&rest, "?", &query))
    target = query;
  if (target.length == 0 || target.at[0] != '/')
    return 400;
  if (target.length >= sizeof request->path)
    return 414;
  memcpy(request->path, target.at, target.length);
  request->path[target.length] = 0;
  return 200;
}

static span trim(span text) {
  while (text.length > 0 && (text.at[0] == ' ' || text.at[0] == '\t'))
    text = (span){text.at + 1, text.length - 1};
  while (text.length > 0 && (text.at[text.length - 1] == ' ' || text.at[text.length - 1] == '\t'))
    text.length--;
  return text;
}

static bool is_own_host(span host, int64_t port) {
  static const char *const names[] = {"127.0.0.1", "localhost"};
  char own[64];
  for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
    snprintf(own, sizeof own, "%s:%" PRId64, names[n], port);
    if (is_caseless(host, own) || (port == 80 && is_caseless(host, names[n])))
      return true;
  }
  return false;
}

/* The headers up to the empty line; of them only Host matters. */
static int parse_headers(span rest, int64_t port) {
  span line, name;
  int hosts = 0;
  bool own = false;
  while (cut(&rest, "\r\n", &line) && line.length > 0) {
    if (!cut(&line, ":", &name) || name.length == 0)
      return 400;
    for (size_t n = 0; n < name.length; n++) {
      if (name.at[n] <= ' ' || name.at[n] == 127)
        return 400;
    }
    if (!is_caseless(name, "host"))
      continue;
    hosts++;
    own = is_own_host(trim(line), port);
  }
  if (hosts != 1)
    return 400;
  return own ? 200 : 403;
}

int cli_http_parse(const char *head, size_t length, int64_t port, cli_http_request *request) {
  span rest = {head, length}, line;
  cli_http_request parsed = {0};
  // what is no text is no request
  for (size_t n = 0; n < length; n++) {
    const unsigned char c = (unsigned char)head[n];
    if (c == 127 || (c < ' ' && c != '\r' && c != '\n' && c != '\t'))
      return 400;
  }
  if (!cut(&rest, "\r\n", &line))
    return 400;
  int status = parse_line(line, &parsed);
  if (status == 200)
    status = parse_headers(rest, port);
  if (status == 200)
    *request = parsed;
  return status;
}
