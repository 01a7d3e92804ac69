/* `thrum view` as a server: what it answers to browsers, to others, and to Ctrl-C.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>

#include "tests/support/cli_support.h"

#define PAGE "<script type=\"application/octet-stream\" id=\"thrum-pack\"></script>\n"

static char folder[64];
static pid_t server;
static int port;

/* Starts the server in the folder; its port is in the line that it prints. */
static pid_t start(int *at, const char *wanted) {
  int ends[2];
  char line[256];
  assert_int_equal(pipe(ends), 0);
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    // as a shell starts a program in front
    signal(SIGINT, SIG_DFL);
    if (chdir(folder) != 0 || dup2(ends[1], STDOUT_FILENO) < 0)
      _exit(126);
    close(ends[0]);
    close(ends[1]);
    execl(THRUM_PROGRAM, THRUM_PROGRAM, "view", "beam.npz", "--json", "--no-open", "-q",
          wanted != NULL ? "--port" : (char *)NULL, wanted, (char *)NULL);
    _exit(127);
  }
  close(ends[1]);
  FILE *out = fdopen(ends[0], "r");
  assert_non_null(out);
  assert_non_null(fgets(line, sizeof line, out));
  assert_int_equal(sscanf(line, "{\"url\":\"http://127.0.0.1:%d/\"}", at), 1);
  fclose(out);
  return child;
}

/* Its exit code, -1 for a signal's. */
static int stop(pid_t child, int number) {
  int status = 0;
  kill(child, number);
  assert_true(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static int make_server(void **state) {
  (void)state;
  char page[160];
  if (cli_make_folder(folder) == NULL)
    return -1;
  snprintf(page, sizeof page, "%s/page.html", folder);
  if (!cli_write_text(page, PAGE) || setenv("THRUM_VIEWER", page, 1) != 0)
    return -1;
  signal(SIGPIPE, SIG_IGN);
  cli_result made = thrum_run(folder, "precompute", "beam:6x2x2@1x0.2x0.3", "--fix", "x<0.001",
                              "-q", "-o", "beam.npz", NULL);
  const int code = made.exit_code;
  cli_result_free(&made);
  if (code == 0)
    server = start(&port, NULL);
  return code;
}

static int stop_server(void **state) {
  (void)state;
  const int code = stop(server, SIGINT);
  cli_remove_folder(folder);
  return code;
}

static int dial(uint32_t host) {
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
  address.sin_addr.s_addr = htonl(host);
  const int made = socket(AF_INET, SOCK_STREAM, 0);
  assert_true(made >= 0);
  if (connect(made, (struct sockaddr *)&address, sizeof address) == 0)
    return made;
  close(made);
  return -1;
}

static void send_text(int to, const char *text) {
  assert_int_equal(send(to, text, strlen(text), 0), strlen(text));
}

typedef struct reply {
  int status;
  char *text; /* the head, ended by 0 after its empty line is cut off, then the body */
  char *body;
  size_t body_size;
} reply;

/* All that comes until the server hangs up. */
static reply receive(int from) {
  reply r = {0};
  size_t used = 0, room = 1 << 22;
  r.text = malloc(room + 1);
  assert_non_null(r.text);
  for (;;) {
    const ssize_t got = recv(from, r.text + used, room - used, 0);
    if (got <= 0)
      break;
    used += (size_t)got;
  }
  close(from);
  r.text[used] = 0;
  assert_int_equal(sscanf(r.text, "HTTP/1.1 %d ", &r.status), 1);
  r.body = strstr(r.text, "\r\n\r\n");
  assert_non_null(r.body);
  r.body[2] = 0;
  r.body += 4;
  r.body_size = used - (size_t)(r.body - r.text);
  return r;
}

static reply ask(const char *text) {
  const int to = dial(INADDR_LOOPBACK);
  assert_true(to >= 0);
  send_text(to, text);
  return receive(to);
}

/* A request with the right Host. */
static reply request(const char *line) {
  char text[512];
  snprintf(text, sizeof text, "%s HTTP/1.1\r\nAccept: */*\r\nhost: localhost:%d\r\n\r\n", line,
           port);
  return ask(text);
}

static void expect_status(reply r, int status) {
  if (r.status != status)
    fail_msg("%s, not %d", r.text, status);
  free(r.text);
}

static void expect_header(const reply *r, const char *line) {
  if (strstr(r->text, line) == NULL)
    fail_msg("'%s' lacks '%s'", r->text, line);
}

static void the_page_and_the_pack_are_served(void **state) {
  (void)state;
  char length[64];
  reply page = request("GET /");
  assert_int_equal(page.status, 200);
  assert_string_equal(page.body, PAGE);
  expect_header(&page, "\r\nContent-Type: text/html; charset=utf-8\r\n");
  expect_header(&page, "\r\nCache-Control: no-store\r\n");
  expect_header(&page, "\r\nCross-Origin-Resource-Policy: same-origin\r\n");
  free(page.text);
  expect_status(request("GET /?model=beam"), 200);
  reply pack = request("GET /pack");
  assert_int_equal(pack.status, 200);
  assert_memory_equal(pack.body, "THRUMPK1", 8);
  expect_header(&pack, "\r\nContent-Type: application/octet-stream\r\n");
  snprintf(length, sizeof length, "\r\nContent-Length: %zu\r\n", pack.body_size);
  expect_header(&pack, length);
  reply head = request("HEAD /pack");
  assert_int_equal(head.status, 200);
  assert_int_equal(head.body_size, 0);
  expect_header(&head, length);
  free(head.text);
  free(pack.text);
}

static void other_paths_and_methods_are_not(void **state) {
  (void)state;
  expect_status(request("GET /etc/passwd"), 404);
  expect_status(request("GET /../beam.npz"), 404);
  expect_status(request("GET /PACK"), 404);
  reply post = request("POST /pack");
  expect_header(&post, "\r\nAllow: GET, HEAD\r\n");
  expect_status(post, 405);
}

static void what_is_no_request_is_refused(void **state) {
  (void)state;
  char text[256];
  static const char *const wrong[] = {"GET", "GET /", "GET  / ", " / ", "GET pack", "\001"};
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    snprintf(text, sizeof text, "%s\r\nHost: localhost:%d\r\n\r\n", wrong[n], port);
    expect_status(ask(text), 400);
  }
  snprintf(text, sizeof text, "GET / HTTP/2.0\r\nHost: localhost:%d\r\n\r\n", port);
  expect_status(ask(text), 505);
  snprintf(text, sizeof text, "GET / HTTP/1.1\r\nHost : localhost:%d\r\n\r\n", port);
  expect_status(ask(text), 400);
}

/* A page of another site whose name points to 127.0.0.1 has the browser send that name. */
static void another_sites_name_is_refused(void **state) {
  (void)state;
  char text[256];
  static const char *const hosts[][2] = {{"evil.example", ":"},
                                         {"127.0.0.1.evil.example", ":"},
                                         {"localhost", ":1"},
                                         {"127.0.0.1", ":0"}};
  for (size_t n = 0; n < sizeof hosts / sizeof hosts[0]; n++) {
    snprintf(text, sizeof text, "GET /pack HTTP/1.1\r\nHost: %s%s%d\r\n\r\n", hosts[n][0],
             hosts[n][1], port);
    reply r = ask(text);
    assert_null(strstr(r.body, "THRUM"));
    expect_status(r, 403);
  }
  expect_status(ask("GET /pack HTTP/1.1\r\n\r\n"), 400);
  snprintf(text, sizeof text, "GET / HTTP/1.1\r\nHost: localhost:%d\r\nHost: localhost:%d\r\n\r\n",
           port, port);
  expect_status(ask(text), 400);
}

static void a_head_that_does_not_end_is_refused(void **state) {
  (void)state;
  const int to = dial(INADDR_LOOPBACK);
  send_text(to, "GET / HTTP/1.1\r\n");
  for (int n = 0; n < 200; n++)
    send(to, "X-Long: 0123456789012345678901234567890123456789\r\n", 50, 0);
  expect_status(receive(to), 431);
}

static void clients_that_stand_still_keep_nobody_waiting(void **state) {
  (void)state;
  int still[8];
  for (int n = 0; n < 8; n++) {
    still[n] = dial(INADDR_LOOPBACK);
    send_text(still[n], n % 2 == 0 ? "GET /" : "GET /pack HTTP/1.1\r\n");
  }
  expect_status(request("GET /"), 200);
  // and each is served once it goes on
  char rest[128];
  snprintf(rest, sizeof rest, "Host: 127.0.0.1:%d\r\n\r\n", port);
  send_text(still[1], rest);
  expect_status(receive(still[1]), 200);
  for (int n = 0; n < 8; n++) {
    if (n != 1)
      close(still[n]);
  }
  expect_status(request("GET /"), 200);
}

static void only_this_machine_reaches_it(void **state) {
  (void)state;
  // another address of the loopback, on which nobody listens
  assert_int_equal(dial(INADDR_LOOPBACK + 1), -1);
}

static void a_port_that_is_taken_is_refused(void **state) {
  (void)state;
  char text[16];
  snprintf(text, sizeof text, "%d", port);
  cli_result run = thrum_run(folder, "view", "beam.npz", "--no-open", "--port", text, NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "already in use"));
  assert_true(cli_line_count_is(run.err, 1));
  cli_result_free(&run);
}

static void signals_end_it_well(void **state) {
  (void)state;
  static const int numbers[] = {SIGINT, SIGTERM};
  for (int n = 0; n < 2; n++) {
    int other = 0;
    const pid_t child = start(&other, NULL);
    const int to = dial(INADDR_LOOPBACK); // a client of the first server is nobody's here
    assert_int_equal(stop(child, numbers[n]), 0);
    close(to);
    // its port is free at once
    char text[16];
    snprintf(text, sizeof text, "%d", other);
    int again = 0;
    const pid_t next = start(&again, text);
    assert_int_equal(again, other);
    assert_int_equal(stop(next, numbers[n]), 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_page_and_the_pack_are_served),
      cmocka_unit_test(other_paths_and_methods_are_not),
      cmocka_unit_test(what_is_no_request_is_refused),
      cmocka_unit_test(another_sites_name_is_refused),
      cmocka_unit_test(a_head_that_does_not_end_is_refused),
      cmocka_unit_test(clients_that_stand_still_keep_nobody_waiting),
      cmocka_unit_test(only_this_machine_reaches_it),
      cmocka_unit_test(a_port_that_is_taken_is_refused),
      cmocka_unit_test(signals_end_it_well),
  };
  return cmocka_run_group_tests(tests, make_server, stop_server);
}
