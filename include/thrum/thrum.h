/* Thrum: real-time deformable bodies that keep their energy. Everything public.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_THRUM_H
#define THRUM_THRUM_H

#include "thrum/actuation.h"
#include "thrum/api.h"
#include "thrum/base_motion.h"
#include "thrum/batch.h"
#include "thrum/condensed_model.h"
#include "thrum/contact.h"
#include "thrum/contact_pairs.h"
#include "thrum/displacement.h"
#include "thrum/embedding.h"
#include "thrum/equilibrium.h"
#include "thrum/external_load.h"
#include "thrum/floating_frame.h"
#include "thrum/inertia.h"
#include "thrum/kernel.h"
#include "thrum/kernel_pass.h"
#include "thrum/link.h"
#include "thrum/model.h"
#include "thrum/monitor.h"
#include "thrum/parameters.h"
#include "thrum/polynomial.h"
#include "thrum/rigid_frame.h"
#include "thrum/state.h"
#include "thrum/status.h"
#include "thrum/step_equation.h"
#include "thrum/stress.h"
#include "thrum/surface.h"
#include "thrum/version.h"

#endif
