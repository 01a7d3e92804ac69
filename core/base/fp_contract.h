/* Forbids the compiler to fuse a multiplication and an addition, from here to the end of the file:
 * fused sums have other bits (docs/determinism.md). The build passes -ffp-contract=off, and gcc
 * does not fuse under -std=c11; this header is for sources that are compiled by hand with clang. A
 * file includes it before any header that computes. Every library may include it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_FP_CONTRACT_H
#define THRUM_CORE_BASE_FP_CONTRACT_H

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#endif
