/* The mode machine: slip, stick and the transitions between them.
 *
 *   slip   ends where the joint's velocity reaches zero. There the reaction H
 *          that would hold the joint decides: |H| <= Q_s sticks, otherwise the
 *          joint goes on in the direction of H.
 *   stick  ends where |H| reaches Q_s; the joint goes in the direction of H.
 *
 * A phase starts on a zero of its own signal: of order 1 after a reversal or a
 * release with Q_s > Q_m, of order 2 after a release with Q_s = Q_m, where the
 * acceleration is continuous and only the jerk is left.
 *
 * The saturated law has a band |v| <= sigma instead of stick, with a flow of
 * its own. The right-hand side is continuous at its edges, so an exit through
 * an edge always goes on to the other side.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"

enum { KIND_STICK = 0, KIND_REVERSE = 1, KIND_SLIP_POS = 2, KIND_SLIP_NEG = 3 };

typedef struct {
  bm_run *run;
  bm_watch free, held;
  double *rest; /* state without the joint (2n - 2)                 */
  double period;
  int64_t marked;   /* period in which events are being counted         */
  double in_period; /* events since then                                */
} machine;

static int n_of(const bm_run *run) {
  return run->free->N / 2;
}

static void with_joint(const bm_run *run, const double *rest, double position,
                       double *x) {
  int n = n_of(run), k = 0;
  for (int j = 0; j < 2 * n; j++) {
    if (j == run->joint) {
      x[j] = position;
    } else if (j == n + run->joint) {
      x[j] = 0.0;
    } else {
      x[j] = rest[k++];
    }
  }
}

/* Reaction that would hold the joint at rest in the run's present state. */
static double reaction_of(machine *it) {
  bm_run *run = it->run;
  bm_without_joint(n_of(run), run->joint, run->state, it->rest);
  double H =
      bm_flow_signal(run->held, run->time, run->state[run->joint], it->rest);
  if (fabs(H) > run->reaction_scale) {
    run->reaction_scale = fabs(H);
  }
  return H;
}

/* Starts the phase of the run's mode; returns its constant load. */
static double begin(machine *it) {
  bm_run *run = it->run;
  if (run->mode == BM_STICK && run->sigma > 0.0) {
    bm_watch_begin(&it->held, run->time, 0.0, run->state);
    return 0.0;
  }
  if (run->mode == BM_STICK) {
    double position = run->state[run->joint];
    bm_without_joint(n_of(run), run->joint, run->state, it->rest);
    bm_watch_begin(&it->held, run->time, position, it->rest);
    return position;
  }
  double torque = run->mode * run->Q_m;
  bm_watch_begin(&it->free, run->time, torque, run->state);
  return torque;
}

/* Exit of the present phase within `limit` of its start. */
static bm_exit exit_of(machine *it, double limit) {
  bm_run *run = it->run;
  double lo, hi;
  int side;
  if (run->mode != BM_STICK) {
    lo = run->mode > 0 ? run->sigma : -HUGE_VAL;
    hi = run->mode > 0 ? HUGE_VAL : -run->sigma;
    return bm_signal_exit(&it->free.signal, lo, hi, limit, run->multiplicity,
                          -run->mode);
  }
  if (run->sigma > 0.0) {
    lo = -run->sigma;
    hi = run->sigma;
    side = run->state[n_of(run) + run->joint] < 0.0 ? -1 : 1;
  } else {
    lo = -run->Q_s;
    hi = run->Q_s;
    side = run->multiplicity && reaction_of(it) < 0.0 ? -1 : 1;
  }
  return bm_signal_exit(&it->held.signal, lo, hi, limit, run->multiplicity,
                        side);
}

static void move(machine *it, double load, double tau) {
  bm_run *run = it->run;
  if (run->mode != BM_STICK) {
    bm_watch_state(&it->free, run->time, load, tau, run->state);
  } else if (run->sigma > 0.0) {
    bm_watch_state(&it->held, run->time, load, tau, run->state);
  } else {
    bm_watch_state(&it->held, run->time, load, tau, it->rest);
    with_joint(run, it->rest, load, run->state);
  }
  run->time += tau;
  while (run->time >= it->period) {
    run->time -= it->period;
    run->periods++;
  }
}

static void mark(machine *it, bm_events *events, int kind, double before,
                 double after, double margin, const bm_exit *out) {
  bm_run *run = it->run;
  int64_t i = events->count++;
  int reals = 2 * n_of(run);
  int64_t *whole = events->integers + i * BM_EVENT_INTEGERS;
  double *real = events->reals + i * (BM_EVENT_REALS + reals);
  whole[BM_PERIODS] = run->periods;
  whole[BM_KIND] = kind;
  whole[BM_MULTIPLE] = out->multiple;
  real[BM_TIME] = run->time;
  real[BM_TORQUE_BEFORE] = before;
  real[BM_TORQUE_AFTER] = after;
  real[BM_MARGIN] = margin;
  real[BM_TOUCH_TIME] = out->margin_tau;
  real[BM_TOUCH_GAP] = out->margin;
  memcpy(real + BM_EVENT_REALS, run->state, (size_t)reals * sizeof(double));
}

/* The velocity has reached zero: stick, or go on in the direction of H. */
static void stop(machine *it, bm_events *events, const bm_exit *out) {
  bm_run *run = it->run;
  double before = run->mode * run->Q_m, Q_s = run->Q_s;
  run->state[n_of(run) + run->joint] = 0.0;
  double H = reaction_of(it), scale = run->reaction_scale;
  double margin = scale > 0.0 ? fabs(fabs(H) - Q_s) / scale : 0.0;
  int held = Q_s > 0.0 && fabs(H) <= Q_s;
  int direction = H > 0.0 ? BM_SLIP_POS : BM_SLIP_NEG;
  if (Q_s == 0.0) {
    direction = -run->mode;
  }
  if (!held && direction == run->mode) {
    /* a touch: the velocity grows again the way it came */
    run->multiplicity = 1;
    return;
  }
  mark(it, events, held ? KIND_STICK : KIND_REVERSE, before,
       held ? H : direction * run->Q_m, margin, out);
  run->mode = held ? BM_STICK : direction;
  run->multiplicity = held ? (Q_s - fabs(H) <= 8.0 * DBL_EPSILON * scale) : 1;
}

/* The reaction has reached the static level: slip in its direction. */
static void release(machine *it, bm_events *events, const bm_exit *out) {
  bm_run *run = it->run;
  int mode = out->side;
  mark(it, events, mode > 0 ? KIND_SLIP_POS : KIND_SLIP_NEG, mode * run->Q_s,
       mode * run->Q_m, 1.0, out);
  run->mode = mode;
  run->multiplicity = run->Q_s > run->Q_m ? 1 : 2;
}

/* An edge of the band: the motion goes on to its other side. */
static void cross(machine *it, bm_events *events, const bm_exit *out) {
  bm_run *run = it->run;
  int edge = run->mode == BM_STICK ? out->side : run->mode;
  double torque = edge * run->Q_m;
  int kind = run->mode != BM_STICK ? KIND_STICK
             : edge > 0            ? KIND_SLIP_POS
                                   : KIND_SLIP_NEG;
  run->state[n_of(run) + run->joint] = edge * run->sigma;
  mark(it, events, kind, torque, torque, 1.0, out);
  run->mode = run->mode == BM_STICK ? edge : BM_STICK;
  run->multiplicity = 1;
}

/* Whether the phase of the run's mode is left the moment it begins. */
static int ends_at_once(machine *it) {
  begin(it);
  bm_exit out = exit_of(it, it->period);
  return out.side != 0 && out.tau == 0.0;
}

/* Mode of a run that starts in the given state. */
static void start(machine *it) {
  bm_run *run = it->run;
  double v = run->state[n_of(run) + run->joint];
  run->started = 1;
  if (run->sigma > 0.0) {
    run->multiplicity = 0;
    run->mode = v > run->sigma    ? BM_SLIP_POS
                : v < -run->sigma ? BM_SLIP_NEG
                                  : BM_STICK;
    return;
  }
  run->multiplicity = v == 0.0;
  if (v != 0.0) {
    run->mode = v > 0.0 ? BM_SLIP_POS : BM_SLIP_NEG;
    return;
  }
  double H = reaction_of(it);
  if (run->Q_s > 0.0 && fabs(H) <= run->Q_s) {
    run->mode = BM_STICK;
    run->multiplicity =
        run->Q_s - fabs(H) <= 8.0 * DBL_EPSILON * run->reaction_scale;
    if (run->multiplicity && ends_at_once(it)) {
      run->mode = H > 0.0 ? BM_SLIP_POS : BM_SLIP_NEG;
      run->multiplicity = run->Q_s > run->Q_m ? 1 : 2;
    }
    return;
  }
  run->mode = H >= 0.0 ? BM_SLIP_POS : BM_SLIP_NEG;
  if (H == 0.0 && ends_at_once(it)) {
    run->mode = BM_SLIP_NEG;
  }
}

static int too_many(machine *it) {
  bm_run *run = it->run;
  if (run->periods != it->marked) {
    it->marked = run->periods;
    it->in_period = 0.0;
  }
  return ++it->in_period > run->event_limit;
}

static int finite_state(const bm_run *run) {
  double sum = 0.0;
  for (int j = 0; j < run->free->N; j++) {
    sum += run->state[j] * 0.0;
  }
  return sum == 0.0;
}

static bm_status run_machine(machine *it, int64_t end_periods, double end_time,
                             bm_events *events) {
  bm_run *run = it->run;
  if (!run->started) {
    start(it);
    run->first_mode = run->mode;
  }
  for (;;) {
    double limit = (double)(end_periods - run->periods) * it->period +
                   (end_time - run->time);
    if (limit <= 0.0) {
      return BM_OK;
    }
    if (events->count == events->capacity) {
      return BM_FULL;
    }
    double load = begin(it);
    bm_exit out = exit_of(it, limit);
    int mode = run->mode;
    move(it, load, out.tau);
    if (!finite_state(run)) {
      return BM_NOT_FINITE;
    }
    if (out.side == 0) {
      run->periods = end_periods;
      run->time = end_time;
      run->multiplicity = 0;
      return BM_OK;
    }
    if (too_many(it)) {
      return BM_CHATTER;
    }
    if (run->sigma > 0.0) {
      cross(it, events, &out);
    } else if (mode == BM_STICK) {
      release(it, events, &out);
    } else {
      stop(it, events, &out);
    }
  }
}

static bm_status set_up(machine *it, bm_run *run) {
  memset(it, 0, sizeof(*it));
  it->run = run;
  it->period = 6.283185307179586 / run->free->Omega;
  it->rest = calloc((size_t)run->held->N + 1, sizeof(double));
  if (!it->rest || !bm_watch_create(&it->free, run->free) ||
      !bm_watch_create(&it->held, run->held)) {
    return BM_NO_MEMORY;
  }
  return BM_OK;
}

static void tear_down(machine *it) {
  bm_watch_free(&it->free);
  bm_watch_free(&it->held);
  free(it->rest);
}

bm_status bm_propagate(bm_run *run, int64_t end_periods, double end_time,
                       bm_events *events) {
  machine it;
  bm_status status = set_up(&it, run);
  if (status == BM_OK) {
    status = run_machine(&it, end_periods, end_time, events);
  }
  tear_down(&it);
  return status;
}
