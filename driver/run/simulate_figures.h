/* The figures of one body's run: how it ended, its energies, work and drift.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_SIMULATE_FIGURES_H
#define THRUM_DRIVER_RUN_SIMULATE_FIGURES_H

#include "driver/model/model_hash.h"
#include "driver/run/against_report.h"
#include "driver/run/drift.h"
#include "driver/run/simulate_options.h"
#include "precompute/full/full.h"
#include "precompute/model/blow.h"

typedef struct simulate_figures {
  const simulate_request *request;
  const thrum_model *model;
  const char *model_file; /* that the model was read from, where a mesh is named; NULL: as named */
  model_hash model_hash;  /* of the file and of its arrays */
  thrum_status status;    /* THRUM_OK, or how the run ended */
  bool energy_grew;       /* for at least one of the three reasons that follow */
  bool grew_freely;       /* its mean did in free motion */
  bool grew_beside_loads; /* it did while loads acted that moved next to nothing */
  bool gained; /* much of it is no work of loads; its steps tell the third: report.grown_steps */
  bool condensed_wrong; /* condensing left out more than the result can be believed with */
  bool basis_wrong;     /* the basis errs by more than is accepted */
  bool uncounted;       /* something acts whose work is not counted */
  thrum_error stop;     /* why it ended early; empty message: it did not */
  thrum_state_report report;
  thrum_full_report full; /* of --full */
  int64_t fallback_steps;
  thrum_energies first, last;
  double energy_min, energy_max;
  double work_load, work_base; /* [J] */
  double work_actuators;       /* of all of them [J] */
  double work_moved; /* magnitudes of the work of all steps [J]; INFINITY where it is not counted */
  double dissipated; /* [J]; NaN where it is not counted */
  double plastic_work;    /* of it, that plastic flow took [J] */
  double plastic_strain;  /* largest at the end */
  double point_stiffness; /* of points that may flow, over that of the body, the most */
  double spin[3];         /* of a body with --spin, at the end [degrees/s] */
  driver_drift windows;   /* after the last load has ended */
  driver_drift whole;     /* of the whole run, for loads that move nothing to speak of */
  double drift;           /* NaN where it says nothing */
  double growth;          /* the same with damping too, where it is below zero or the energy grew */
  double peak;            /* largest displacement of the recorded states [m]; NaN without a basis */
  int64_t peak_vertex;
  int64_t masters;      /* of a condensed model; 0: the model is not condensed */
  bool follows_loads;   /* loads alone move what follows, as touch modes do */
  double inertia_share; /* of the kinetic energy, largest over largest, that it leaves out [1] */
  double energy_defect; /* of the largest strain energy against the mesh [1]; NaN: not looked at */
  double vibration_share; /* rms of the slaves' vibration that is left out, over that of q [1] */
  double impact_share; /* rms of where what impacts give to the slaves takes the masters, over that
                          and q [1] */
  against_mesh against;
  thrum_blow blow; /* of a run's only load, which is short; else zeros */
  double seconds_read, seconds_step, seconds_output, seconds_plot, seconds_total;
} simulate_figures;

/* Plans the windows of the drift; request and model are set. */
void simulate_figures_begin(simulate_figures *figures);

/* Takes in the energies of row `row`; row -1: those of the last step, which may have no row. */
void simulate_figures_add(simulate_figures *figures, int64_t row, const thrum_energies *energies);

/* The change of the energy that work and losses leave unexplained [J]; NaN where the losses are not
 * counted. */
double simulate_figures_balance(const simulate_figures *figures);

/* Whether a run of a condensed model that leaves out these shares can be believed; NaN: not looked
 * at. */
bool simulate_condensed_believed(double inertia_share, double energy_defect, double vibration_share,
                                 double impact_share);

/* Tells what stepped the body: its integrator, and where imexv has switched, since when and to
 * what. */
void simulate_figures_stepped_by(const simulate_figures *figures, char text[128]);

/* Sets drift, growth and energy_grew: the mean energy grew in free motion, or much of the energy
 * came from nowhere. */
void simulate_figures_end(simulate_figures *figures);

/* How a run ended, X(name, its word in reports): done, or what flags it. */
#define RUN_OUTCOMES(X)                                                                            \
  X(DONE, "done")                                                                                  \
  X(ENERGY_GREW, "energy_grew")                                                                    \
  X(CONDENSED_WRONG, "condensed_wrong")                                                            \
  X(BASIS_WRONG, "basis_wrong")                                                                    \
  X(FELL_BACK, "fell_back")                                                                        \
  X(NOT_CONVERGED, "not_converged")                                                                \
  X(NOT_FINITE, "not_finite")                                                                      \
  X(INTERRUPTED, "interrupted")                                                                    \
  X(FAILED, "failed")                                                                              \
  X(SURFACES_CROSSED, "surfaces_crossed")                                                          \
  X(CONTACT_GIVEN_UP, "contact_given_up")                                                          \
  X(JOINTS_OPEN, "joints_open")

typedef enum run_outcome {
#define X(name, word) RUN_##name,
  RUN_OUTCOMES(X)
#undef X
} run_outcome;

const char *run_outcome_word(run_outcome outcome);
run_outcome simulate_outcome(const simulate_figures *figures);

#endif
