/* Fuzz target of snapshots of states: a state is made and stepped as the input says, its snapshot
 * is changed in places and gets the checksum of the changed bytes, so that they come to the checks
 * behind it. What is refused leaves the state as it was, and what is restored can be stepped.
 * sources: core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include <float.h>

#include "core/base/seal.h"
#include "core/state/state_layout.h"
#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_random.h"
#include "thrum/thrum.h"

#define RANK 3
#define SNAPSHOT_MAX 16384

static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 't', 'a'}, THRUM_STATE_VERSION};

static thrum_state_def draw_def(fuzz_draw *draw) {
  thrum_state_def def = thrum_default_state_def();
  const unsigned bits = draw_byte(draw);
  def.integrator = (thrum_integrator)draw_index(draw, 10);
  def.dt = 0.05;
  def.damping_alpha = bits & 1 ? 0.1 : 0;
  def.damping_beta = bits & 2 ? 1e-3 : 0;
  def.damping_form = bits & 4 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = (int32_t)draw_index(draw, RANK + 1);
  def.split_form = (thrum_split_form)draw_index(draw, 3);
  def.solver = bits & 8 ? THRUM_SOLVER_NEWTON : THRUM_SOLVER_QUASI_NEWTON;
  def.borrows_scratch = bits & 16 ? 1 : 0;

  // where numbers leave no solution, more iterations would only take time
  def.iterations_max = 6;
  return def;
}

/* A state of the def, with scratch where it borrows that. */
static thrum_state *make(const thrum_model *model, const thrum_state_def *def, void **scratch) {
  thrum_state *state = NULL;
  size_t size;
  if (thrum_state_create(model, def, &state, NULL) < 0)
    abort();
  *scratch = NULL;
  if (!def->borrows_scratch)
    return state;
  if (thrum_state_scratch_size(model, def, &size, NULL) < 0 ||
      posix_memalign(scratch, 64, size) != 0 || thrum_state_lend(state, *scratch, size, NULL) < 0)
    abort();
  return state;
}

/* Changes as many places as the input has. */
static void change(unsigned char *bytes, size_t size, fuzz_draw *draw) {
  do {
    const size_t at = (size_t)draw_index(draw, (int64_t)size);
    const unsigned how = draw_byte(draw);
    const double number = draw_any(draw);
    const int64_t whole = (int64_t)draw_byte(draw) - 8;
    if (how % 4 == 0)
      bytes[at] ^= (unsigned char)(1u << how / 4 % 8);
    else if (how % 4 == 1)
      memcpy(bytes + at / 8 * 8, &number, at / 8 * 8 + 8 <= size ? 8 : 0);
    else if (how % 4 == 2)
      memcpy(bytes + at / 8 * 8, &whole, at / 8 * 8 + 8 <= size ? 8 : 0);
    else
      memcpy(bytes + at / 4 * 4, &whole, at / 4 * 4 + 4 <= size ? 4 : 0);
  } while (draw->left > 0);
}

static void use(const thrum_model *model, thrum_state *state) {
  thrum_error error = {0};
  thrum_energies energies;
  double q[RANK], p[RANK];
  for (int step = 0; step < 3; step++) {
    fuzz_check(thrum_step(model, state, &error), &error);
    fuzz_check(thrum_state_energies(model, state, &energies, &error), &error);
    if (thrum_state_get(model, state, q, p, &error) >= 0)
      for (int n = 0; n < RANK; n++)
        if (!isfinite(q[n]) || !isfinite(p[n]))
          abort();
    if (step == 1)
      fuzz_check(thrum_state_set_dt(model, state, 0.02, &error), &error);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const double q[RANK] = {0.3, -0.1, 0.15}, p[RANK] = {-0.2, 0.4, 0.1};
  static unsigned char snapshot[SNAPSHOT_MAX];
  fuzz_draw draw = {data, size};
  thrum_error error = {0};
  const thrum_model *model = fuzz_random_model(RANK, 0);
  const thrum_state_def def = draw_def(&draw);
  const int64_t steps = draw_index(&draw, 8);

  // where the state is when the snapshot is taken
  void *scratch, *other_scratch;
  thrum_state *state = make(model, &def, &scratch), *other = make(model, &def, &other_scratch);
  if (thrum_state_set(model, state, q, p, &error) < 0)
    abort();
  for (int64_t step = 0; step < steps; step++)
    thrum_step(model, state, NULL);
  const size_t bytes = thrum_state_snapshot_size(state);
  if (bytes > sizeof snapshot || thrum_state_snapshot(state, snapshot, bytes, &error) < 0)
    abort();

  change(snapshot + THRUM_SEAL_BYTES, bytes - THRUM_SEAL_BYTES, &draw);
  thrum_seal_put(snapshot, bytes, kind);

  // into a state of the same def, which keeps its own bytes where it refuses
  const size_t kept = thrum_state_kept_bytes(other);
  void *before = malloc(kept);
  if (before == NULL)
    abort();
  memcpy(before, other, kept);
  const thrum_status status = thrum_state_restore(model, other, snapshot, bytes, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    use(model, other);
  else if (memcmp(before, other, kept) != 0)
    abort();

  free(before);
  thrum_state_destroy(state);
  thrum_state_destroy(other);
  free(scratch);
  free(other_scratch);
  return 0;
}
