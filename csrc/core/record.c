/* What is written down while the motion passes: samples, touches, events, and
 * integrals by Gauss quadrature on the dense output. */
#include <math.h>
#include <string.h>

#include "state.h"

/* Ten-point Gauss rule on [-1, 1]: exact up to degree 19. */
static const double NODE[5] = {0.1488743389816312, 0.4333953941292472,
                               0.6794095682990244, 0.8650633666889845,
                               0.9739065285171717};
static const double WEIGHT[5] = {0.2955242247147529, 0.2692667193099963,
                                 0.2190863625159820, 0.1494513491505806,
                                 0.0666713443086881};

/* One term of the integrals at local time t. */
static bs_status add_powers(bs_core *core, double t, double weight,
                            int in_window) {
  const bs_system *system = &core->system;
  double *y = core->scratch;
  bs_status status = bs_phase_at(core, t, y);
  if (status != BS_OK) {
    return status;
  }
  if (system->joint >= 0) {
    const double loss = weight * y[system->n + system->joint] *
                        bs_system_torque(system, core->mode, t, y);
    core->summary.friction_loss += loss;
    core->summary.window_friction_loss += in_window ? loss : 0.0;
  }
  if (in_window) {
    core->summary.viscous_loss += weight * bs_system_viscous_power(system, y);
    core->summary.forcing_work +=
        weight * bs_system_power(system, t, y, core->held.f);
  }
  return BS_OK;
}

static bs_status integrate(bs_core *core, double from, double to,
                           int in_window) {
  /* a series spans several radians of the fastest mode, a step about one */
  const int panels = core->stretch.source == BS_FROM_SERIES ? 3 : 1;
  const double half = 0.5 * (to - from) / panels;
  for (int panel = 0; panel < panels && half > 0.0; panel++) {
    const double middle = from + (2 * panel + 1) * half;
    for (int i = 0; i < 5; i++) {
      for (int side = -1; side <= 1; side += 2) {
        bs_status status = add_powers(core, middle + side * half * NODE[i],
                                      half * WEIGHT[i], in_window);
        if (status != BS_OK) {
          return status;
        }
      }
    }
  }
  return BS_OK;
}

static bs_status add_integrals(bs_core *core, double limit) {
  const double opening = core->window_start < HUGE_VAL
                             ? bs_state_local(core, core->window_start)
                             : HUGE_VAL;
  const int everywhere = core->system.friction.law == BS_SATURATED;
  double from = core->t;
  bs_status status = BS_OK;
  if (!core->window_open && opening <= limit) {
    status = bs_phase_at(core, opening, core->window_state);
    core->window_open = 1;
  }
  if (!core->window_open) {
    return everywhere ? integrate(core, from, limit, 0) : BS_OK;
  }
  if (status == BS_OK && from < opening) {
    if (everywhere) {
      status = integrate(core, from, fmin(opening, limit), 0);
    }
    from = opening;
  }
  return status == BS_OK ? integrate(core, from, limit, 1) : status;
}

static bs_status add_samples(bs_core *core, double limit, bs_output *out) {
  const size_t width = 2 * (size_t)core->system.n;
  while (out->samples_done < out->n_samples) {
    const int64_t i = out->samples_done;
    const double t = bs_state_local(core, out->sample_t[i]);
    if (!(t <= limit)) {
      break;
    }
    double *y = out->sample_state + (size_t)i * width;
    bs_status status = bs_phase_at(core, t, y);
    if (status != BS_OK) {
      return status;
    }
    out->sample_torque[i] =
        core->system.joint < 0
            ? 0.0
            : bs_system_torque(&core->system, core->mode, t, y);
    out->samples_done++;
  }
  return BS_OK;
}

bs_status bs_record_until(bs_core *core, double limit, bs_output *out) {
  bs_stretch *stretch = &core->stretch;
  while (stretch->n_touches > 0 && stretch->touch_t[0] <= limit) {
    if (out->touches_done == out->touch_capacity) {
      return BS_TOUCHES_FULL;
    }
    double *row = out->touch_values + out->touches_done++ * BS_TOUCH_VALUES;
    row[BS_TOUCH_T] = bs_state_absolute(core, stretch->touch_t[0]);
    row[BS_TOUCH_DISTANCE] = stretch->touch_distance[0];
    row[BS_TOUCH_MODE] = core->mode;
    stretch->n_touches--;
    memmove(stretch->touch_t, stretch->touch_t + 1,
            (size_t)stretch->n_touches * sizeof(double));
    memmove(stretch->touch_distance, stretch->touch_distance + 1,
            (size_t)stretch->n_touches * sizeof(double));
  }
  bs_status status = add_samples(core, limit, out);
  if (status == BS_OK) {
    status = add_integrals(core, limit);
  }
  if (status == BS_OK) {
    core->t = limit;
  }
  return status;
}

void bs_record_event(bs_core *core, bs_kind kind, bs_quality quality,
                     const double *values, bs_output *out) {
  const size_t width = 2 * (size_t)core->system.n;
  const size_t i = (size_t)out->events_done++;
  memcpy(out->event_values + i * BS_EVENT_VALUES, values,
         BS_EVENT_VALUES * sizeof(double));
  out->event_codes[2 * i] = kind;
  out->event_codes[2 * i + 1] = quality;
  if (out->event_states != NULL) {
    memcpy(out->event_states + i * width, core->y, width * sizeof(double));
  }
  core->summary.last_event_t = values[BS_EVENT_T];
  core->summary.last_event_kind = kind;
  core->summary.events++;
}
