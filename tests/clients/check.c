/* Prints from C what Check.cs prints: sizes and places of structs, and the bits of the same run.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "thrum/thrum.h"

static void print_bits(double number) {
  uint64_t bits = 0;
  memcpy(&bits, &number, sizeof bits);
  printf("%016" PRIx64 "\n", bits);
}

static void print_layouts(void) {
  // a client that declares structs by hand must have these sizes and offsets
  printf("error %zu\nerror.Message %zu\n", sizeof(thrum_error), offsetof(thrum_error, message));

  printf("def %zu\n", sizeof(thrum_state_def));
#define FIELD(name, field) printf("def." name " %zu\n", offsetof(thrum_state_def, field))
  FIELD("Integrator", integrator);
  FIELD("Dt", dt);
  FIELD("DampingForm", damping_form);
  FIELD("SplitSafety", split_safety);
  FIELD("Tolerance", tolerance);
  FIELD("ExplicitCount", explicit_count);
  FIELD("Kernel", kernel);
  FIELD("Solver", solver);
  FIELD("UntrainedFlow", untrained_flow);
#undef FIELD

  printf("energies %zu\nenergies.Total %zu\nenergies.High %zu\n", sizeof(thrum_energies),
         offsetof(thrum_energies, total), offsetof(thrum_energies, high));
}

static thrum_status run(const thrum_model *model, thrum_state *state, thrum_error *error) {
  static double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX], load[THRUM_RANK_MAX];
  const double force[3] = {0, 1, -2};
  THRUM_TRY(thrum_mode_add(model, 0, 0.1, q, error));
  THRUM_TRY(thrum_state_set(model, state, q, NULL, error));
  THRUM_TRY(thrum_load_add_vertex(model, model->vertex_count - 1, force, load, error));
  THRUM_TRY(thrum_state_set_force(model, state, load, error));
  printf("status %d\n", thrum_steps(model, state, 500, NULL, error));

  // the bits of the end, which the other client must have too
  THRUM_TRY(thrum_state_get(model, state, q, p, error));
  for (int64_t i = 0; i < model->rank; i++)
    print_bits(q[i]);
  for (int64_t i = 0; i < model->rank; i++)
    print_bits(p[i]);
  thrum_energies energies;
  THRUM_TRY(thrum_state_energies(model, state, &energies, error));
  print_bits(energies.total);
  double moved[3];
  THRUM_TRY(thrum_displacement(model, q, model->vertex_count - 1, 1, moved, error));
  print_bits(moved[2]);
  return THRUM_OK;
}

int main(int argc, char **argv) {
  const thrum_model *model = NULL;
  thrum_state *state = NULL;
  thrum_error error = {.status = THRUM_OK};
  print_layouts();
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return 1;
  printf("rank %" PRId64 " vertices %" PRId64 "\n", model->rank, model->vertex_count);

  // one run, then one refusal, whose message crosses the border as well
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.002;
  def.damping_alpha = 0.1;
  int failed = thrum_state_create(model, &def, &state, &error) < 0 || run(model, state, &error) < 0;
  thrum_state_destroy(state);
  def.dt = -1;
  if (thrum_state_create(model, &def, &state, &error) < 0)
    printf("%s\n", error.message);
  thrum_model_destroy(model);
  return failed;
}
