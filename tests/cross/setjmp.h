/* WASI has no setjmp, and tests/cross/cmocka.h needs none. SPDX-License-Identifier: Apache-2.0 */
