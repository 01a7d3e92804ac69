/* The laws one by one, as material_law.h says of all of them. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_RUNTIME_MATERIAL_MATERIAL_LAW_PRIVATE_H
#define THRUM_RUNTIME_MATERIAL_MATERIAL_LAW_PRIVATE_H

#include "runtime/material/material_law.h"

double material_law_stvk_stress(double lambda, double mu, double gradient[3][3],
                                double stress[3][3]);
void material_law_stvk_tangent(double lambda, double mu, double gradient[3][3],
                               double tangent[9][9]);

double material_law_corotational_stress(double lambda, double mu, double gradient[3][3],
                                        double stress[3][3]);
void material_law_corotational_tangent(double lambda, double mu, double gradient[3][3],
                                       double tangent[9][9]);
thrum_law_cubic material_law_corotational_cubic(double lambda, double mu);

double material_law_neo_hookean_stress(double lambda, double mu, double gradient[3][3],
                                       double stress[3][3]);
void material_law_neo_hookean_tangent(double lambda, double mu, double gradient[3][3],
                                      double tangent[9][9]);
thrum_law_cubic material_law_neo_hookean_cubic(double lambda, double mu);

#endif
