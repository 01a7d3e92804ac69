/* Judges what is asked of a precompute before it starts: shared by the run and by its estimate, so
 * that both refuse the same. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_OPTIONS_CHECK_H
#define THRUM_PRECOMPUTE_OPTIONS_CHECK_H

#include <stdbool.h>

#include "precompute/fem/fem.h"
#include "precompute/options/precompute_options.h"

/* Static responses: three of each handle, one of each actuator. */
int64_t thrum_options_responses(const thrum_precompute_options *options);

/* k modes and the three responses of each handle, which a rank should have room for. */
int64_t thrum_options_shapes(const thrum_precompute_options *options);

/* The coordinates whose products the polynomial has, the first: all, or the linear modes of a model
 * that will be condensed; and the columns of its Gram product. The options are complete. */
int64_t thrum_options_squared(const thrum_precompute_options *options);
double thrum_options_columns(const thrum_precompute_options *options);

/* Coordinates that the parameters of a body add beside the rank, as far as it has room for them;
 * and bytes of what its moduli and densities add to the polynomial and to the mass, at a rank that
 * has them. 0 without parameters. */
int64_t thrum_options_added(const thrum_precompute_options *options, const thrum_fem *fem);
double thrum_options_share_bytes(const thrum_precompute_options *options, const thrum_fem *fem,
                                 double rank);

/* The rank that is taken for so many modes where none is given: these, and twice as many directions
 * of their derivatives up to 30, at most half of those that there are; at least 2 a mode. */
int64_t thrum_options_usual_rank(int64_t modes);

/* The options with the rank that 0 stands for, and without modes where a basis is imported. */
thrum_precompute_options thrum_options_complete(const thrum_precompute_options *options);

/* Refuses, in complete options, counts out of range, threads, the mass, a check that is not built
 * in. */
thrum_status thrum_options_check(const thrum_precompute_options *options, thrum_error *error);

/* The same with the body: that it is held or free (thrum_constraints_check, whose *free_body this
 * is), and has room for the modes and the rank, which `fit` lowers to that room first. */
thrum_status thrum_options_check_body(thrum_precompute_options *options, const thrum_fem *fem,
                                      bool *free_body, thrum_error *error);

/* Should the modes of a body of so many free components be counted by inertia as well, where that
 * can be done? */
bool thrum_options_count_wanted(thrum_check check, int64_t free_count);

/* Are they? */
bool thrum_options_counted(const thrum_precompute_options *options, int64_t free_count);

#endif
