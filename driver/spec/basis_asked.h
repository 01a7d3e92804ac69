/* Whether a basis is to be judged, and what error of it is accepted: the options, and what they
 * fill in. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_BASIS_ASKED_H
#define THRUM_DRIVER_SPEC_BASIS_ASKED_H

#include <stdbool.h>

#include "config/options.h"

/* Whether a basis is judged: where it takes no longer than BASIS_SECONDS_MOST, always, or never. */
typedef enum basis_judging { BASIS_JUDGE_AUTO, BASIS_JUDGE_ON, BASIS_JUDGE_OFF } basis_judging;

#define BASIS_SECONDS_MOST 10.0
#define BASIS_ACCEPTED 0.1 /* share of the motion that may be wrong without a flag */
#define BASIS_WHOLE 0.98   /* of a run: rows that are thinned end a little before it does */

/* For request structs: what was asked for. */
typedef struct basis_asked {
  basis_judging judging;
  double accepted;    /* share beyond which the answer is flagged; 1: it is not */
  const char *unless; /* why it cannot be judged, whatever is asked for; NULL: it can */
  bool together;      /* others act on the body: it is judged with its scene */
} basis_asked;

/* The rows of the two options, in a request that has a basis_asked `member`. */
extern const char *const basis_judging_names[];
#define OPTION_ACCEPT_ERROR(called, taken)                                                         \
  OPTION_WORD(called, "P%", "10%",                                                                 \
              "share of the motion that the basis may have wrong, as far as it is estimated, "     \
              "before the answer is flagged (exit code 3); 100% accepts all",                      \
              .take = taken, .wants = "a share such as 20%",                                       \
              .schema = "{\"anyOf\":[{\"type\":\"number\",\"exclusiveMinimum\":0,\"maximum\":1},"  \
                        "{\"type\":\"string\",\"pattern\":\"^[0-9.]+%?$\"}]}")
#define OPTION_JUDGE(type, member)                                                                 \
  OPTION_CHOICE("judge", basis_judging_names, "auto",                                              \
                "whether the mesh is asked how far the basis is wrong: where that takes no more "  \
                "than about 10 s, always, or never",                                               \
                CONFIG_AT(type, member.judging))

#endif
