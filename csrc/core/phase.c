/* The motion between events: stretches, and the threshold that ends them.
 *
 * Root set of each mode, all positive inside it:
 *
 *             Coulomb                saturated
 *   slip+     v                      v - sigma
 *   slip-     -v                     -v - sigma
 *   stick     Q_s - R, Q_s + R       sigma - v, sigma + v
 *
 * They are polynomials on each stretch (the solver's own interpolant, or the
 * local series), and roots.c finds the first root and every close minimum. So
 * no crossing can hide between two step ends. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "roots.h"
#include "state.h"

/* Degree to which harmonics are expanded on a piece of at most one radian: the
 * next term is below 1/17! = 3e-15. */
enum { LIFT = 16 };

/* A local series spans at most this angle of the highest harmonic: the first
 * term left out is below 1.5^21/21! = 1e-16. */
static const double LONGEST_ANGLE = 1.5;

double bs_state_absolute(const bs_core *core, double local) {
  return fma(core->base, core->system.period, local);
}

double bs_state_local(const bs_core *core, double absolute) {
  return fma(-core->base, core->system.period, absolute);
}

bs_status bs_phase_at(bs_core *core, double t, double *y) {
  const bs_stretch *stretch = &core->stretch;
  if (stretch->source == BS_NOTHING) {
    memcpy(y, core->y, 2 * (size_t)core->system.n * sizeof(double));
    return BS_OK;
  }
  t = fmin(fmax(t, stretch->start), stretch->step_end);
  if (stretch->source == BS_FROM_SERIES) {
    bs_series_at(&core->series, t, y);
    return BS_OK;
  }
  return bs_integrator_at(core->integrator, t, y);
}

/* --- thresholds ----------------------------------------------------------- */

/* g = offset + sign*L, where L is the velocity or the reaction. */
typedef struct {
  double offset, sign;
} threshold;

static int thresholds(const bs_core *core, threshold *set) {
  const bs_friction *friction = &core->system.friction;
  const int coulomb = friction->law == BS_COULOMB;
  if (core->mode == BS_STICK) {
    const double limit = coulomb ? friction->Q_s : friction->sigma;
    set[0] = (threshold){limit, -1.0};
    set[1] = (threshold){limit, 1.0};
    return 2;
  }
  set[0] = (threshold){coulomb ? 0.0 : -friction->sigma, (double)core->mode};
  return 1;
}

static int watches_reaction(const bs_core *core) {
  return core->mode == BS_STICK && core->system.friction.law == BS_COULOMB;
}

/* Minima of g below this are reported: a share of what the watched quantity
 * reaches, which inside the band of the saturated law is the band's width. */
static double touch_limit(const bs_core *core) {
  const bs_friction *friction = &core->system.friction;
  double peak = core->summary.velocity_peak;
  if (core->mode == BS_STICK) {
    peak = watches_reaction(core)
               ? fmax(core->summary.reaction_peak, friction->Q_s)
               : friction->sigma;
  }
  return core->settings.grazing * peak;
}

static void note_touch(bs_stretch *stretch, double t, double distance) {
  if (stretch->n_touches < BS_MINIMA) {
    stretch->touch_t[stretch->n_touches] = t;
    stretch->touch_distance[stretch->n_touches++] = fmax(distance, 0.0);
  }
}

/* Take the root of one threshold function on the piece [start, start + width]
 * if it comes before the one already known. g: Bernstein form on the piece;
 * reduced: the same after division by x^m at a start on the threshold. */
static void take_root(bs_stretch *stretch, int side, int degree,
                      const double *g, int reduced_degree,
                      const double *reduced, double start, double width) {
  double x, p, slope, curvature;
  if (!bs_roots_first(reduced_degree, reduced, &x)) {
    return;
  }
  const double t = start + x * width;
  if (stretch->crossing && stretch->end <= t) {
    return;
  }
  bs_roots_value(degree, g, x, &p, &slope, &curvature);
  stretch->crossing = 1;
  stretch->end = fmin(t, stretch->step_end);
  stretch->side = side;
  stretch->rate = slope / width;
  stretch->depth = curvature > 0.0 ? 0.5 * slope * slope / curvature : HUGE_VAL;
}

static void take_minima(const bs_core *core, bs_stretch *stretch, int degree,
                        const double *g, double start, double width) {
  double x[BS_MINIMA], low[BS_MINIMA];
  const int count =
      bs_roots_minima(degree, g, touch_limit(core), BS_MINIMA, x, low);
  for (int i = 0; i < count; i++) {
    note_touch(stretch, start + x[i] * width, low[i]);
  }
}

/* A minimum may also lie where two steps join. */
static void take_joint_minimum(bs_core *core, bs_stretch *stretch, int which,
                               int degree, const double *g, double start,
                               double width) {
  const double slope = degree * (g[1] - g[0]) / width;
  if (core->slope_before[which] < 0.0 && slope >= 0.0 && g[0] > 0.0 &&
      g[0] < touch_limit(core)) {
    note_touch(stretch, start, g[0]);
  }
  core->slope_before[which] = degree * (g[degree] - g[degree - 1]) / width;
}

static void drop_late_touches(bs_stretch *stretch) {
  int kept = 0;
  for (int i = 0; i < stretch->n_touches; i++) {
    if (!stretch->crossing || stretch->touch_t[i] < stretch->end) {
      stretch->touch_t[kept] = stretch->touch_t[i];
      stretch->touch_distance[kept++] = stretch->touch_distance[i];
    }
  }
  stretch->n_touches = kept;
}

/* --- scan of a series ----------------------------------------------------- */

/* Order of the zero of g at the start. A release (Q_s = Q_m) starts with zero
 * velocity and acceleration whatever rounding makes of it; a start on a limit
 * has g = 0. Beyond what is known, the first coefficient above its rounding
 * error decides. */
static int start_order(const bs_core *core, const double *g,
                       const double *noise, int fresh, int side) {
  int order = 0;
  if (!fresh) {
    return 0;
  }
  if (watches_reaction(core)) {
    order = core->limit_side == side || fabs(g[0]) <= noise[0];
  } else {
    order = g[0] == 0.0 ? (core->zero_order > 1 ? 2 : 1) : 0;
  }
  while (order > 0 && order < BS_SERIES_ORDER &&
         fabs(g[order]) <= noise[order]) {
    order++;
  }
  return order;
}

static bs_status scan_series(bs_core *core, int fresh) {
  bs_stretch *stretch = &core->stretch;
  double value[BS_SERIES_ORDER + 1], noise[BS_SERIES_ORDER + 1];
  double g[BS_SERIES_ORDER + 1], b[BS_SERIES_ORDER + 1];
  double r[BS_SERIES_ORDER + 1];
  threshold set[2];
  const int count = thresholds(core, set), d = BS_SERIES_ORDER;
  const double width = stretch->step_end - stretch->start;
  if (watches_reaction(core)) {
    bs_series_reaction(&core->series, &core->system, value, noise);
    core->summary.reaction_peak =
        fmax(core->summary.reaction_peak, fabs(value[0]));
  } else {
    bs_series_velocity(&core->series, &core->system, core->mode, value, noise);
    core->summary.velocity_peak =
        fmax(core->summary.velocity_peak, fabs(value[0]));
  }
  for (int i = 0; i < count; i++) {
    const int side = i == 0 ? 1 : -1;
    for (int k = 0; k <= d; k++) {
      g[k] = set[i].sign * value[k] + (k == 0 ? set[i].offset : 0.0);
    }
    const int m = start_order(core, g, noise, fresh, side);
    for (int k = 0; k < m; k++) {
      g[k] = 0.0;
    }
    if (m == d && fabs(g[d]) <= noise[d]) {
      continue; /* identically zero: nothing moves */
    }
    memcpy(r, g + m, (size_t)(d + 1 - m) * sizeof(double));
    bs_roots_shift(d, g, 0.0, width);
    bs_roots_shift(d - m, r, 0.0, width);
    bs_roots_bernstein(d, g, b);
    take_minima(core, stretch, d, b, stretch->start, width);
    double reduced[BS_SERIES_ORDER + 1];
    bs_roots_bernstein(d - m, r, reduced);
    take_root(stretch, side, d, b, d - m, reduced, stretch->start, width);
    if (m == 0) {
      take_joint_minimum(core, stretch, i, d, b, stretch->start, width);
    }
    core->slope_before[i] = d * (b[d] - b[d - 1]) / width;
  }
  drop_late_touches(stretch);
  return BS_OK;
}

/* --- scan of a step ------------------------------------------------------- */

/* Largest slope of the forcing's own part of the reaction. */
static double reaction_slope(const bs_forcing *reaction) {
  double sum = 0.0;
  for (int32_t k = 1; k <= reaction->harmonics; k++) {
    sum += k * (fabs(reaction->cos[k]) + fabs(reaction->sin[k]));
  }
  return sum * reaction->Omega;
}

/* Nothing comes near zero when the value at the end exceeds all that the
 * polynomial can change. */
static int far_from_zero(const bs_core *core, const threshold *set, int count,
                         const double *power, int degree, double end_value,
                         double width) {
  double change = 0.0;
  for (int k = 1; k <= degree; k++) {
    change += fabs(power[k]);
  }
  if (watches_reaction(core)) {
    change += width * reaction_slope(&core->system.reaction);
  }
  const double least = change + touch_limit(core);
  for (int i = 0; i < count; i++) {
    if (!(set[i].offset + set[i].sign * end_value > least)) {
      return 0;
    }
  }
  return 1;
}

/* Coefficients of L on the part [first, first + share] of the step, x in
 * [0, 1]; returns the degree. */
static int step_part(const bs_core *core, const double *power, int degree,
                     double first, double share, double width, double *out) {
  memset(out, 0, (LIFT + 1) * sizeof(double));
  memcpy(out, power, (size_t)(degree + 1) * sizeof(double));
  bs_roots_shift(degree, out, first - 1.0, share);
  if (!watches_reaction(core)) {
    return degree;
  }
  double own[LIFT + 1];
  const double start = core->stretch.step_end + (first - 1.0) * width;
  bs_forcing_series(&core->system.reaction, start, LIFT, own);
  bs_roots_shift(LIFT, own, 0.0, share * width);
  for (int k = 0; k <= LIFT; k++) {
    out[k] += own[k];
  }
  return LIFT;
}

static bs_status scan_step(bs_core *core) {
  bs_stretch *stretch = &core->stretch;
  const bs_system *system = &core->system;
  double power[LIFT + 1] = {0.0}, part[LIFT + 1], g[LIFT + 1], b[LIFT + 1];
  double width;
  int degree;
  threshold set[2];
  const int reaction = watches_reaction(core);
  const int count = thresholds(core, set);
  bs_status status = bs_integrator_polynomial(
      core->integrator, reaction ? system->row : NULL,
      (int64_t)system->n + system->joint, power, &degree, &width);
  if (status != BS_OK) {
    return status;
  }
  double end_value = power[0];
  if (core->faults.bad_root_call > 0 && --core->faults.bad_root_call == 0) {
    end_value = NAN;
  }
  if (reaction) {
    double own;
    bs_forcing_at(&system->reaction, stretch->step_end, &own);
    end_value += own;
    core->summary.reaction_peak =
        fmax(core->summary.reaction_peak, fabs(end_value));
  } else {
    core->summary.velocity_peak =
        fmax(core->summary.velocity_peak, fabs(end_value));
  }
  if (!isfinite(end_value)) {
    return BS_NOT_FINITE;
  }
  if (far_from_zero(core, set, count, power, degree, end_value, width)) {
    core->slope_before[0] = core->slope_before[1] = 0.0;
    return BS_OK;
  }
  const double angle =
      reaction ? system->harmonics * system->reaction.Omega * width : 0.0;
  const int parts = angle > 1.0 ? (int)ceil(angle) : 1;
  for (int piece = 0; piece < parts && !stretch->crossing; piece++) {
    const double share = 1.0 / parts, first = piece * share;
    const double start = stretch->step_end + (first - 1.0) * width;
    const int d = step_part(core, power, degree, first, share, width, part);
    for (int i = 0; i < count; i++) {
      for (int k = 0; k <= d; k++) {
        g[k] = set[i].sign * part[k] + (k == 0 ? set[i].offset : 0.0);
      }
      bs_roots_bernstein(d, g, b);
      if (d > 0) {
        take_joint_minimum(core, stretch, i, d, b, start, share * width);
      }
      take_minima(core, stretch, d, b, start, share * width);
      take_root(stretch, i == 0 ? 1 : -1, d, b, d, b, start, share * width);
    }
  }
  drop_late_touches(stretch);
  return BS_OK;
}

/* --- stretches ------------------------------------------------------------ */

/* First step of CVODE: half of what makes its first-order error as large as
 * the tolerance, from y'' at (t, y). */
static double first_step(bs_core *core, double t, const double *y) {
  const int32_t n = core->system.n;
  const bs_dynamics *dynamics = bs_system_dynamics(&core->system, core->mode);
  double *first = core->scratch, *second = core->held.c;
  double *slope = core->held.f; /* two rows: F and F' */
  bs_system_rhs(&core->system, core->mode, t, y, first);
  bs_forcing_series(&dynamics->forcing, t, 1, slope);
  bs_system_apply(&core->system, dynamics, first, second);
  double sum = 0.0;
  for (int32_t i = 0; i < 2 * n; i++) {
    const double derivative = i < n ? first[n + i] : second[i - n] + slope[i];
    const double term =
        derivative / (core->settings.rtol * fabs(y[i]) + core->atol[i]);
    sum += term * term;
  }
  const double size = sqrt(sum / (2.0 * n));
  const double longest = core->system.period;
  return size > 0.0 ? fmin(longest, 0.5 * sqrt(2.0 / size)) : longest;
}

static bs_status check_finite(const bs_core *core, const double *y) {
  double sum = 0.0;
  for (int32_t i = 0; i < 2 * core->system.n; i++) {
    sum += y[i] * 0.0;
  }
  return sum == 0.0 ? BS_OK : BS_NOT_FINITE;
}

/* Whole periods go from the local time into `base`, so that neither the phase
 * nor the resolution of time suffers in a long run. */
static void rebase(bs_core *core) {
  const double whole = floor(core->t / core->system.period);
  if (whole >= 1.0) {
    core->t = fmax(0.0, fma(-whole, core->system.period, core->t));
    core->base += whole;
  }
}

static bs_status series_stretch(bs_core *core, int fresh) {
  const bs_system *system = &core->system;
  bs_stretch *stretch = &core->stretch;
  const int alone = core->settings.method == BS_TAYLOR;
  rebase(core);
  double longest = system->period;
  if (system->harmonics > 0) { /* the forcing's own series must be exact too */
    longest = LONGEST_ANGLE / (system->harmonics * system->load.Omega);
  }
  bs_series_expand(&core->series, system, core->mode, core->t, core->y);
  const double reach =
      bs_series_reach(&core->series, core->settings.rtol, core->atol,
                      alone ? 0.02 : 1e-3, longest);
  memset(stretch, 0, sizeof *stretch);
  stretch->start = core->t;
  stretch->end = stretch->step_end = core->t + reach;
  if (!(stretch->step_end > stretch->start)) {
    const double *last =
        core->series.c + (size_t)BS_SERIES_ORDER * 2 * (size_t)system->n;
    const int sound = isfinite(reach) && check_finite(core, last) == BS_OK;
    return sound ? BS_STUCK_TIME : BS_NOT_FINITE;
  }
  stretch->source = BS_FROM_SERIES;
  core->summary.steps++;
  core->summary.series_steps++;
  return system->joint >= 0 ? scan_series(core, fresh) : BS_OK;
}

static bs_status step_stretch(bs_core *core) {
  bs_stretch *stretch = &core->stretch;
  double t = core->t;
  bs_status status = BS_OK;
  if (stretch->source == BS_FROM_SERIES) {
    bs_series_at(&core->series, t, core->y);
    status = check_finite(core, core->y);
    if (status == BS_OK) {
      const double h = first_step(core, t, core->y);
      status =
          bs_integrator_restart(core->integrator, core->mode, t, core->y, h);
    }
  }
  if (status == BS_OK) {
    status = bs_integrator_step(core->integrator, &t);
  }
  if (status != BS_OK) {
    return status;
  }
  memset(stretch, 0, sizeof *stretch);
  stretch->source = BS_FROM_STEP;
  stretch->start = core->t;
  stretch->end = stretch->step_end = t;
  core->summary.steps++;
  return core->system.joint >= 0 ? scan_step(core) : BS_OK;
}

bs_status bs_phase_next(bs_core *core) {
  if (core->summary.steps >= core->settings.max_steps) {
    return BS_TOO_MANY_STEPS;
  }
  if (core->restart) {
    core->restart = 0;
    core->summary.restarts++;
    core->slope_before[0] = core->slope_before[1] = 0.0;
    return series_stretch(core, 1);
  }
  if (core->settings.method == BS_TAYLOR) {
    bs_series_at(&core->series, core->t, core->y);
    bs_status status = check_finite(core, core->y);
    return status == BS_OK ? series_stretch(core, 0) : status;
  }
  return step_stretch(core);
}
