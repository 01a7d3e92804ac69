/* How long a run is under the sanitizers. These see in its beginning what they see in all of it,
 * and take ten times as long; what is said about its length is said by the other builds.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_SANITIZED_H
#define THRUM_TESTS_SUPPORT_SANITIZED_H

/* `whole` in a build without sanitizers, `part` with them. */
#ifdef THRUM_SANITIZED
#define LENGTH_OF_RUN(whole, part) (part)
#else
#define LENGTH_OF_RUN(whole, part) (whole)
#endif

#endif
