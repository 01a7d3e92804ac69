/* A small server of HTTP/1.1, see http_server.h: one poll over all clients, one request a
 * connection. A client is read until its head is whole, written to, and then drained until it hangs
 * up, since closing on bytes unread would take the answer from it (RFC 9112, 9.6).
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/view/http_server.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "app/view/http_request.h"
#include "platform/clock.h"
#include "thrum/thrum.h"

#define CLIENTS_MAX 32
#define READ_SECONDS 10.0  /* for a whole head */
#define WRITE_SECONDS 60.0 /* for a whole answer */
#define DRAIN_SECONDS 2.0
#define TICK_MILLISECONDS 500

typedef enum client_stage { READING, WRITING, DRAINING } client_stage;

typedef struct client {
  int socket; /* -1: none */
  client_stage stage;
  double deadline; /* clock_seconds() */
  char head[CLI_HTTP_HEAD_MAX];
  size_t head_size;
  char answer[1024]; /* its head, and the body of a refusal */
  size_t answer_size;
  const char *body;
  size_t body_size, sent; /* sent: of the answer and the body together */
} client;

static const int ends[] = {SIGINT, SIGTERM, SIGHUP};
enum { END_COUNT = sizeof ends / sizeof ends[0] };

struct cli_http_server {
  int listener;
  int64_t port;
  const cli_http_file *files;
  int64_t file_count;
  int signals[2]; /* a pipe: the handler writes, poll reads */
  struct sigaction before[END_COUNT];
  client clients[CLIENTS_MAX];
};

static const char *reason(int status) {
  static const struct {
    int status;
    const char *text;
  } reasons[] = {
      {200, "OK"},
      {400, "Bad Request"},
      {403, "Forbidden"},
      {404, "Not Found"},
      {405, "Method Not Allowed"},
      {408, "Request Timeout"},
      {414, "URI Too Long"},
      {431, "Request Header Fields Too Large"},
      {505, "HTTP Version Not Supported"},
  };
  for (size_t n = 0; n < sizeof reasons / sizeof reasons[0]; n++) {
    if (reasons[n].status == status)
      return reasons[n].text;
  }
  return "Error";
}

/* The head of an answer; a refusal's body is its reason. */
static void answer(client *c, int status, const cli_http_file *file, bool body) {
  const char *text = reason(status);
  const size_t size = file != NULL ? file->size : strlen(text) + 1;
  const int length = snprintf(
      c->answer, sizeof c->answer,
      "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n"
      "Connection: close\r\n%s\r\n%s%s",
      status, text, file != NULL ? file->type : "text/plain; charset=utf-8", size,
      status == 405 ? "Allow: GET, HEAD\r\n" : "", file == NULL && body ? text : "",
      file == NULL && body ? "\n" : "");
  c->answer_size = (size_t)length;
  c->body = file != NULL ? file->bytes : NULL;
  c->body_size = file != NULL && body ? file->size : 0;
  c->sent = 0;
  c->stage = WRITING;
  c->deadline = clock_seconds() + WRITE_SECONDS;
}

static void answer_request(const cli_http_server *s, client *c, size_t length) {
  cli_http_request request = {.body = true};
  const int status = cli_http_parse(c->head, length, s->port, &request);
  for (int64_t n = 0; n < s->file_count && status == 200; n++) {
    if (strcmp(s->files[n].path, request.path) == 0) {
      answer(c, 200, &s->files[n], request.body);
      return;
    }
  }
  answer(c, status == 200 ? 404 : status, NULL, request.body);
}

static void drop(client *c) {
  close(c->socket);
  c->socket = -1;
}

/* Did the call fail for good? */
static bool broken(ssize_t result) {
  return result < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR;
}

static void read_head(const cli_http_server *s, client *c) {
  const ssize_t got = recv(c->socket, c->head + c->head_size, sizeof c->head - c->head_size, 0);
  if (got == 0 || broken(got)) {
    drop(c);
    return;
  }
  c->head_size += got > 0 ? (size_t)got : 0;
  const size_t length = cli_http_head_length(c->head, c->head_size);
  if (length > 0)
    answer_request(s, c, length);
  else if (c->head_size == sizeof c->head)
    answer(c, 431, NULL, true);
}

static void write_answer(client *c) {
  const bool in_head = c->sent < c->answer_size;
  const size_t done = in_head ? c->sent : c->sent - c->answer_size;
  const char *from = in_head ? c->answer : c->body;
  const size_t left = (in_head ? c->answer_size : c->body_size) - done;
  const ssize_t put = left > 0 ? send(c->socket, from + done, left, MSG_NOSIGNAL) : 0;
  if (broken(put)) {
    drop(c);
    return;
  }
  c->sent += put > 0 ? (size_t)put : 0;
  if (c->sent == c->answer_size + c->body_size) {
    shutdown(c->socket, SHUT_WR);
    c->stage = DRAINING;
    c->deadline = clock_seconds() + DRAIN_SECONDS;
  }
}

static void drain(client *c) {
  const ssize_t got = recv(c->socket, c->head, sizeof c->head, 0);
  if (got == 0 || broken(got))
    drop(c);
}

/* Neither blocks nor is inherited by a program that is started. */
static bool set_up(int descriptor) {
  const int flags = fcntl(descriptor, F_GETFL);
  return flags >= 0 && fcntl(descriptor, F_SETFL, flags | O_NONBLOCK) == 0 &&
         fcntl(descriptor, F_SETFD, FD_CLOEXEC) == 0;
}

static void take_client(cli_http_server *s) {
  const int taken = accept(s->listener, NULL, NULL);
  if (taken < 0)
    return;
  for (int n = 0; n < CLIENTS_MAX; n++) {
    client *c = &s->clients[n];
    if (c->socket >= 0)
      continue;
    if (!set_up(taken))
      break;
    c->socket = taken;
    c->stage = READING;
    c->head_size = 0;
    c->deadline = clock_seconds() + READ_SECONDS;
    return;
  }
  close(taken);
}

static void serve_client(const cli_http_server *s, client *c, short events) {
  if (events != 0 && c->stage == WRITING)
    write_answer(c);
  else if (events != 0 && c->stage == READING)
    read_head(s, c);
  else if (events != 0)
    drain(c);
  if (c->socket < 0 || clock_seconds() < c->deadline)
    return;
  if (c->stage == READING && c->head_size > 0)
    answer(c, 408, NULL, true);
  else
    drop(c);
}

/* Waits for the listener, the clients and the signals' pipe, and serves what there is; false once a
 * signal came, or when waiting fails. */
static bool serve_once(cli_http_server *s) {
  struct pollfd waiting[CLIENTS_MAX + 2];
  bool full = true;
  for (int n = 0; n < CLIENTS_MAX; n++) {
    const client *c = &s->clients[n];
    const short events = c->stage == WRITING ? POLLOUT : POLLIN;
    waiting[n] = (struct pollfd){.fd = c->socket, .events = events};
    full = full && c->socket >= 0;
  }
  // while all places are taken, new clients wait in the system's queue
  waiting[CLIENTS_MAX] = (struct pollfd){.fd = full ? -1 : s->listener, .events = POLLIN};
  waiting[CLIENTS_MAX + 1] = (struct pollfd){.fd = s->signals[0], .events = POLLIN};
  if (poll(waiting, CLIENTS_MAX + 2, TICK_MILLISECONDS) < 0)
    return errno == EINTR;
  for (int n = 0; n < CLIENTS_MAX; n++) {
    if (waiting[n].fd >= 0)
      serve_client(s, &s->clients[n], waiting[n].revents);
  }
  if (waiting[CLIENTS_MAX].revents != 0)
    take_client(s);
  return waiting[CLIENTS_MAX + 1].revents == 0;
}

void cli_http_serve(cli_http_server *s, const cli_http_file *files, int64_t count) {
  s->files = files;
  s->file_count = count;
  while (serve_once(s))
    continue;
}

int64_t cli_http_port(const cli_http_server *s) {
  return s->port;
}

/* Where the handler writes. */
static volatile sig_atomic_t signal_pipe = -1;

static void note_signal(int number) {
  const int before = errno;
  const char byte = (char)number;
  // a pipe full of signals says enough
  const ssize_t written = write(signal_pipe, &byte, 1);
  (void)written;
  errno = before;
}

static void catch_signals(cli_http_server *s) {
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = note_signal;
  sigemptyset(&action.sa_mask);
  signal_pipe = s->signals[1];
  for (int n = 0; n < END_COUNT; n++) {
    if (sigaction(ends[n], NULL, &s->before[n]) == 0 && s->before[n].sa_handler != SIG_IGN)
      sigaction(ends[n], &action, NULL);
  }
}

void cli_http_close(cli_http_server *s) {
  if (s == NULL)
    return;
  for (int n = 0; n < END_COUNT && signal_pipe >= 0; n++)
    sigaction(ends[n], &s->before[n], NULL);
  signal_pipe = -1;
  for (int n = 0; n < CLIENTS_MAX; n++) {
    if (s->clients[n].socket >= 0)
      drop(&s->clients[n]);
  }
  const int others[] = {s->signals[0], s->signals[1], s->listener};
  for (int n = 0; n < 3; n++) {
    if (others[n] >= 0)
      close(others[n]);
  }
  free(s);
}

static bool start_listening(cli_http_server *s) {
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)s->port)};
  socklen_t size = sizeof address;
  const int on = 1;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  s->listener = socket(AF_INET, SOCK_STREAM, 0);
  // a port that was served on a moment ago is free
  if (s->listener < 0 || !set_up(s->listener) ||
      setsockopt(s->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      bind(s->listener, (struct sockaddr *)&address, sizeof address) != 0 ||
      listen(s->listener, CLIENTS_MAX) != 0 ||
      getsockname(s->listener, (struct sockaddr *)&address, &size) != 0)
    return false;
  s->port = ntohs(address.sin_port);
  return true;
}

thrum_status cli_http_open(int64_t port, cli_http_server **opened, thrum_error *error) {
  cli_http_server *s = calloc(1, sizeof *s);
  if (s == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a server");
  s->port = port;
  s->listener = s->signals[0] = s->signals[1] = -1;
  for (int n = 0; n < CLIENTS_MAX; n++)
    s->clients[n].socket = -1;
  if (!start_listening(s) || pipe(s->signals) != 0 || !set_up(s->signals[0]) ||
      !set_up(s->signals[1])) {
    const int number = errno;
    cli_http_close(s);
    return thrum_error_set(error, THRUM_IO, "port %" PRId64 " of this machine: %s%s", port,
                           strerror(number),
                           number == EADDRINUSE ? "; choose another with --port, or none" : "");
  }
  catch_signals(s);
  *opened = s;
  return THRUM_OK;
}
