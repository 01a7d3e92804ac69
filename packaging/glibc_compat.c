/* Functions that static libraries of Debian 12 call and glibc 2.31 does not have yet, for the
 * relocatable program (packaging/tarball.sh). Each does what glibc says it does, by what 2.31
 * has. SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <sys/random.h>

void arc4random_buf(void *bytes, size_t size);

/* expat seeds its hash with it. Random bytes of the kernel; the program ends where there are none,
 * as in glibc. */
void arc4random_buf(void *bytes, size_t size) {
  unsigned char *place = bytes;
  while (size > 0) {
    const ssize_t got = getrandom(place, size, 0);
    if (got < 0 && errno != EINTR)
      abort();
    if (got > 0) {
      place += got;
      size -= (size_t)got;
    }
  }
}
