/* A shared library of Thrum exports the functions declared with THRUM_API, and nothing else.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_API_H
#define THRUM_API_H

/* Stands before every public function. The libraries are compiled with hidden visibility. */
#if defined(__GNUC__)
#define THRUM_API __attribute__((visibility("default")))
#else
#define THRUM_API
#endif

#endif
