/* The table of the runs. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "validation/tradeoff/tradeoff.h"

void tradeoff_csv(FILE *stream, const tradeoff_result *result, double error, double cost) {
  fputs(
      "modes,rank,precision,trained,masters,integrator,dt_s,tolerance,stable,us_per_step,cost_s_"
      "per_s,"
      "error_displacement,error_velocity,error_energy,basis_error,time_error,frequency_error,drift,"
      "speedup,front,projection,disproved,flag,points,cubature_error,cubature_range,force_error,"
      "barred\n",
      stream);
  for (int64_t n = 0; n < result->run_count; n++) {
    const tradeoff_run *run = &result->runs[n];
    const tradeoff_basis *basis = &result->bases[run->basis];
    const tradeoff_recipe *recipe = &basis->recipe;
    fprintf(stream, "%lld,%lld,%s,%d,%lld,%s,%g,%g,%d", (long long)recipe->modes,
            (long long)basis->rank, tradeoff_precision(basis), recipe->trained,
            (long long)recipe->masters, experiment_scheme_names[run->integrator], run->dt,
            run->tolerance, run->stable);

    // a number that is not finite is left empty
    const double numbers[] = {run->us_per_step,
                              run->cost,
                              run->error.displacement,
                              run->error.velocity,
                              run->error.energy,
                              basis->error.displacement,
                              run->time_error.displacement,
                              run->frequency_error,
                              run->drift,
                              result->full_cost / run->cost};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      fprintf(stream, isfinite(numbers[k]) ? ",%.10g" : ",", numbers[k]);
    const char *flag = tradeoff_flag(run);
    fprintf(stream, ",%d,%.10g,%d,%s,%lld", run->front, basis->projection, run->disproved,
            flag != NULL ? flag : "", (long long)basis->points);

    // what its points were asked for; of an own basis that is not known
    const bool asked = recipe->cubature_error > 0;
    const double figures[] = {asked ? recipe->cubature_error : NAN, basis->cubature_range,
                              basis->force_error};
    for (int k = 0; k < 3; k++)
      fprintf(stream, isfinite(figures[k]) ? ",%.10g" : ",", figures[k]);
    const char *barred = tradeoff_barred(result, run, error, cost);
    fprintf(stream, ",%s\n", barred != NULL ? barred : "");
  }
}
