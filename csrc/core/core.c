/* The event machine: the mode is fixed while the motion is integrated and
 * changes only here, after a threshold has been reached. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "state.h"

/* Chatter: this many events within this share of a period. */
static const double CHATTER_SPAN = 1e-9;
/* Events closer than this share of a period are one as far as time can tell. */
static const double SAME_TIME = 1e-12;

static double now_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* --- which mode ----------------------------------------------------------- */

/* Coulomb joint at rest in core->y at core->t; fills *reaction. */
static bs_mode mode_at_rest(bs_core *core, int on_limit, double *reaction) {
  double value[BS_SERIES_ORDER + 1], noise[BS_SERIES_ORDER + 1];
  bs_series_expand(&core->held, &core->system, BS_STICK, core->t, core->y);
  bs_series_reaction(&core->held, &core->system, value, noise);
  *reaction = value[0];
  return bs_friction_mode_at_rest(&core->system.friction, value, noise,
                                  BS_SERIES_ORDER, on_limit);
}

/* Saturated joint on an edge of the band, v = edge: the first derivative of v
 * that is not zero decides; none: `stay`. */
static bs_mode mode_at_edge(bs_core *core, int edge, bs_mode stay) {
  double value[BS_SERIES_ORDER + 1], noise[BS_SERIES_ORDER + 1];
  bs_series_expand(&core->held, &core->system, BS_STICK, core->t, core->y);
  bs_series_velocity(&core->held, &core->system, BS_STICK, value, noise);
  for (int k = 1; k <= BS_SERIES_ORDER; k++) {
    if (fabs(value[k]) > noise[k]) {
      const bs_mode outside = edge > 0 ? BS_SLIP_POS : BS_SLIP_NEG;
      return edge * value[k] > 0.0 ? outside : BS_STICK;
    }
  }
  return stay;
}

static bs_mode initial_mode(bs_core *core) {
  const bs_system *system = &core->system;
  if (system->joint < 0) {
    return BS_FREE;
  }
  const double v = core->y[system->n + system->joint];
  double reaction;
  if (system->friction.law == BS_SATURATED) {
    if (fabs(v) == system->friction.sigma) {
      return mode_at_edge(core, v > 0.0 ? 1 : -1, BS_STICK);
    }
    if (fabs(v) < system->friction.sigma) {
      return BS_STICK;
    }
  } else if (v == 0.0) {
    return mode_at_rest(core, 0, &reaction);
  }
  return v > 0.0 ? BS_SLIP_POS : BS_SLIP_NEG;
}

/* --- life cycle ----------------------------------------------------------- */

static bs_status build(bs_core *core, const bs_problem *problem,
                       const double *y0, char *text) {
  const size_t width = 2 * (size_t)problem->n;
  core->atol = malloc(width * sizeof(double));
  core->y = malloc(width * sizeof(double));
  core->scratch = malloc(width * sizeof(double));
  core->window_state = malloc(width * sizeof(double));
  if (!core->atol || !core->y || !core->scratch || !core->window_state) {
    return BS_NO_MEMORY;
  }
  memcpy(core->atol, core->settings.atol, width * sizeof(double));
  core->settings.atol = core->atol;
  memcpy(core->y, y0, width * sizeof(double));
  for (size_t i = 0; i < width; i++) {
    core->window_state[i] = NAN;
  }
  bs_status status = bs_system_init(&core->system, problem);
  if (status != BS_OK) {
    return status;
  }
  if (bs_series_init(&core->series, problem->n) != 0 ||
      bs_series_init(&core->held, problem->n) != 0) {
    return BS_NO_MEMORY;
  }
  if (core->settings.method != BS_TAYLOR) {
    status = bs_integrator_create(&core->integrator, &core->system,
                                  &core->settings, text);
  }
  return status;
}

static int usable(const bs_problem *p, const bs_settings *s, const double *y0) {
  if (!p || !s || !y0 || !p->M || !p->C || !p->G || !p->K || !p->f_cos ||
      !p->f_sin || !s->atol) {
    return 0;
  }
  if (p->n < 1 || p->harmonics < 0 || !(p->Omega > 0.0) ||
      p->law < BS_NO_FRICTION || p->law > BS_SATURATED ||
      s->method < BS_ADAMS || s->method > BS_TAYLOR || !(s->rtol > 0.0)) {
    return 0;
  }
  if (p->law == BS_NO_FRICTION) {
    return 1;
  }
  return p->joint >= 0 && p->joint < p->n && p->Q_m >= 0.0 &&
         (p->law == BS_COULOMB ? p->Q_s >= p->Q_m : p->sigma > 0.0);
}

bs_status bs_create(bs_core **out, const bs_problem *problem,
                    const bs_settings *settings, const double *y0, char *text) {
  *out = NULL;
  text[0] = '\0';
  if (!usable(problem, settings, y0)) {
    return BS_BAD_INPUT;
  }
  bs_core *core = calloc(1, sizeof *core);
  if (core == NULL) {
    return BS_NO_MEMORY;
  }
  core->settings = *settings;
  bs_status status = build(core, problem, y0, text);
  if (status != BS_OK) {
    bs_free(core);
    return status;
  }
  core->window_start = HUGE_VAL;
  core->summary.last_event_t = NAN;
  core->summary.velocity_peak = 0.0;
  for (int i = 0; i < BS_RECENT; i++) {
    core->recent[i] = -HUGE_VAL;
  }
  core->mode = initial_mode(core);
  core->summary.initial_mode = core->mode;
  core->restart = 1;
  core->zero_order = 1;
  *out = core;
  return BS_OK;
}

void bs_free(bs_core *core) {
  if (core == NULL) {
    return;
  }
  bs_integrator_free(core->integrator);
  bs_series_clear(&core->series);
  bs_series_clear(&core->held);
  bs_system_clear(&core->system);
  free(core->atol);
  free(core->y);
  free(core->scratch);
  free(core->window_state);
  free(core);
}

void bs_set_window(bs_core *core, double start) {
  core->window_start = start;
}

void bs_cancel(bs_core *core) {
  core->cancelled = 1;
}

/* --- events --------------------------------------------------------------- */

/* An impossible number of events or touches in a vanishing time. */
static bs_status check_recent(bs_core *core) {
  const int slot = core->recent_count++ % BS_RECENT;
  const double period = core->system.period;
  const double since = (core->base - core->recent_base[slot]) * period +
                       (core->t - core->recent[slot]);
  core->recent[slot] = core->t;
  core->recent_base[slot] = core->base;
  core->recent_count %= BS_RECENT;
  return since < CHATTER_SPAN * period ? BS_CHATTER : BS_OK;
}

/* An impossible number of events in one period. */
static bs_status check_crowd(bs_core *core) {
  const double period = core->system.period;
  const double number = core->base + floor(core->t / period);
  if (number != core->crowd_period) {
    core->crowd_period = number;
    core->crowd = 0.0;
  }
  core->crowd += 1.0;
  return core->crowd > core->settings.events_per_period ? BS_CHATTER : BS_OK;
}

static bs_quality quality_of(const bs_core *core, double reaction, bs_kind kind,
                             double t) {
  const bs_system *system = &core->system;
  const double grazing = core->settings.grazing;
  const double torque = fmax(system->friction.Q_s, core->summary.reaction_peak);
  const int coulomb = system->friction.law == BS_COULOMB;
  const int release = kind == BS_EVENT_SLIP_POS || kind == BS_EVENT_SLIP_NEG;
  if (t - core->summary.last_event_t <= SAME_TIME * system->period) {
    return BS_MULTIPLE;
  }
  /* inside the band the velocity lives on its width, not on its peak */
  const double held = coulomb ? torque : system->friction.sigma;
  const double peak = release ? held : core->summary.velocity_peak;
  int close = core->stretch.depth < grazing * peak;
  if (coulomb && !release) {
    const double gap = fabs(fabs(reaction) - system->friction.Q_s);
    close |= system->friction.Q_s > 0.0 && gap < grazing * torque;
  }
  return close ? BS_NEAR_GRAZING : BS_SIMPLE;
}

/* State, new mode and reaction where a threshold has been reached. */
static bs_mode resolve(bs_core *core, double *reaction) {
  const bs_system *system = &core->system;
  const int32_t v = system->n + system->joint;
  *reaction = 0.0;
  if (system->friction.law == BS_SATURATED) {
    const int edge = core->mode == BS_STICK ? core->stretch.side : core->mode;
    core->y[v] = edge * system->friction.sigma;
    *reaction = edge * system->friction.Q_m;
    return mode_at_edge(core, edge, core->mode);
  }
  core->y[v] = 0.0;
  return mode_at_rest(core, core->mode == BS_STICK, reaction);
}

/* A threshold was reached but not crossed: go on in the same mode. */
static bs_status pass_touch(bs_core *core, bs_output *out) {
  double *row = out->touch_values + out->touches_done++ * BS_TOUCH_VALUES;
  row[BS_TOUCH_T] = bs_state_absolute(core, core->t);
  row[BS_TOUCH_DISTANCE] = 0.0;
  row[BS_TOUCH_MODE] = core->mode;
  core->zero_order = 1;
  core->limit_side = core->mode == BS_STICK ? core->stretch.side : 0;
  return BS_OK;
}

static bs_status change_mode(bs_core *core, bs_mode to, double reaction,
                             bs_output *out) {
  const bs_system *system = &core->system;
  const bs_friction *friction = &system->friction;
  const int coulomb = friction->law == BS_COULOMB;
  double values[BS_EVENT_VALUES];
  bs_kind kind;
  if (bs_friction_kind(core->mode, to, &kind) != 0) {
    return BS_INTERNAL;
  }
  if (core->mode == BS_STICK && coulomb && friction->Q_s > 0.0) {
    reaction = core->stretch.side * friction->Q_s; /* rid of rounding */
  }
  core->summary.reaction_peak =
      fmax(core->summary.reaction_peak, fabs(reaction));
  values[BS_EVENT_T] = bs_state_absolute(core, core->t);
  values[BS_EVENT_POSITION] = core->y[system->joint];
  values[BS_EVENT_BEFORE] = core->mode == BS_STICK
                                ? reaction
                                : bs_friction_level(friction, core->mode);
  values[BS_EVENT_AFTER] =
      to == BS_STICK ? reaction : bs_friction_level(friction, to);
  values[BS_EVENT_REACTION] = reaction;
  values[BS_EVENT_RATE] = core->stretch.rate;
  values[BS_EVENT_DEPTH] = core->stretch.depth;
  bs_status status = check_crowd(core);
  if (status != BS_OK) {
    return status;
  }
  bs_record_event(core, kind,
                  quality_of(core, reaction, kind, values[BS_EVENT_T]), values,
                  out);
  /* a release at Q_s = Q_m has zero velocity and zero acceleration */
  core->zero_order =
      coulomb && core->mode == BS_STICK && friction->Q_s == friction->Q_m ? 2
                                                                          : 1;
  core->limit_side = 0;
  core->mode = to;
  return BS_OK;
}

static bs_status pass_threshold(bs_core *core, bs_output *out) {
  double reaction;
  if (out->events_done == out->event_capacity) {
    return BS_EVENTS_FULL;
  }
  if (out->touches_done == out->touch_capacity) {
    return BS_TOUCHES_FULL;
  }
  if (core->summary.events >= core->settings.max_events) {
    return BS_TOO_MANY_EVENTS;
  }
  bs_status status = bs_phase_at(core, core->stretch.end, core->y);
  if (status != BS_OK) {
    return status;
  }
  const bs_mode to = resolve(core, &reaction);
  status = check_recent(core);
  if (status != BS_OK) {
    return status;
  }
  status = to == core->mode ? pass_touch(core, out)
                            : change_mode(core, to, reaction, out);
  if (status == BS_OK) {
    core->stretch.source = BS_NOTHING; /* core->y holds the state */
    core->stretch.crossing = 0;
    core->restart = 1;
  }
  return status;
}

/* --- the loop ------------------------------------------------------------- */

/* One turn: record up to the end of the stretch or the stop, then the next. */
static bs_status turn(bs_core *core, double t_stop, bs_output *out, int *done) {
  const bs_stretch *stretch = &core->stretch;
  if (stretch->source != BS_NOTHING) {
    const double stop = bs_state_local(core, t_stop);
    const double limit = fmin(stretch->end, stop);
    if (limit > core->t || stretch->n_touches > 0) {
      bs_status status = bs_record_until(core, fmax(limit, core->t), out);
      if (status != BS_OK) {
        return status;
      }
    }
    if (stretch->end > stop) {
      *done = 1;
      return BS_OK;
    }
    if (stretch->crossing) {
      return pass_threshold(core, out);
    }
  }
  if (core->t >= bs_state_local(core, t_stop) && !core->restart) {
    *done = 1;
    return BS_OK;
  }
  return bs_phase_next(core);
}

bs_status bs_run(bs_core *core, double t_stop, double seconds,
                 bs_output *output) {
  const double deadline = now_seconds() + seconds;
  int done = 0;
  core->cancelled = 0;
  if (core->failure != BS_OK) {
    return core->failure;
  }
  for (int turns = 1; !done; turns++) {
    bs_status status = turn(core, t_stop, output, &done);
    if (status < 0) {
      core->failure = status;
      return status;
    }
    if (status > 0) {
      return status;
    }
    if (core->cancelled || (turns % 32 == 0 && now_seconds() > deadline)) {
      return done ? BS_OK : BS_SLICE;
    }
  }
  return BS_OK;
}

/* --- what is known -------------------------------------------------------- */

void bs_state(const bs_core *core, double *y) {
  if (bs_phase_at((bs_core *)core, core->t, y) != BS_OK) {
    memcpy(y, core->y, 2 * (size_t)core->system.n * sizeof(double));
  }
}

void bs_window_state(const bs_core *core, double *y) {
  memcpy(y, core->window_state, 2 * (size_t)core->system.n * sizeof(double));
}

void bs_summarise(const bs_core *core, bs_summary *summary) {
  *summary = core->summary;
  summary->t = bs_state_absolute(core, core->t);
  summary->mode = core->mode;
  if (core->integrator != NULL) {
    bs_integrator_count(core->integrator, summary);
    summary->solver_code = bs_integrator_code(core->integrator);
  }
}

const char *bs_solver_text(const bs_core *core) {
  return core->integrator != NULL ? bs_integrator_text(core->integrator) : "";
}

void bs_inject(bs_core *core, const bs_faults *faults) {
  core->faults = *faults;
  if (core->integrator != NULL) {
    bs_integrator_inject(core->integrator, faults);
  }
}
