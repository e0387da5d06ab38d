/* Forcing, dynamics, reaction and local series, on two coupled masses. */
#include "oscillator.h"
#include "series.h"
#include "system.h"
#include "test.h"

static const double Y[4] = {0.3, -0.2, 0.9, -0.5};

static double force(const oscillator *o, int i, double t) {
  double sum = o->f_cos[i];
  for (int k = 1; k <= 2; k++) {
    sum += o->f_cos[2 * k + i] * cos(k * o->problem.Omega * t) +
           o->f_sin[2 * k + i] * sin(k * o->problem.Omega * t);
  }
  return sum;
}

/* M a + (C + G) v + K q - f: what is left over in row i */
static double residual(const oscillator *o, int i, double t, const double *y,
                       const double *a) {
  double sum = -force(o, i, t);
  for (int k = 0; k < 2; k++) {
    const int at = 2 * i + k;
    sum += o->M[at] * a[k] + (o->C[at] + o->G[at]) * y[2 + k] + o->K[at] * y[k];
  }
  return sum;
}

static void slip_obeys_the_equations(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  for (int mode = -1; mode <= 1; mode += 2) {
    double dot[4];
    bs_system_rhs(&system, (bs_mode)mode, 0.7, Y, dot);
    CHECK(dot[0] == Y[2] && dot[1] == Y[3]);
    CHECK_CLOSE(residual(&o, 0, 0.7, Y, dot + 2), 0.0, 1e-14);
    CHECK_CLOSE(residual(&o, 1, 0.7, Y, dot + 2), -0.6 * mode, 1e-14);
  }
  bs_system_clear(&system);
}

static void stick_holds_the_joint_and_the_reaction_closes_its_row(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  const double y[4] = {Y[0], Y[1], Y[2], 0.0};
  double dot[4];
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  bs_system_rhs(&system, BS_STICK, 0.7, y, dot);
  CHECK(dot[1] == 0.0 && dot[3] == 0.0); /* exactly */
  CHECK_CLOSE(residual(&o, 0, 0.7, y, dot + 2), 0.0, 1e-14);
  CHECK_CLOSE(residual(&o, 1, 0.7, y, dot + 2),
              -bs_system_reaction(&system, 0.7, y), 1e-14);
  bs_system_clear(&system);
}

static void the_band_adds_damping(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  double dot[4];
  o.problem.law = BS_SATURATED;
  o.problem.sigma = 0.8;
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  bs_system_rhs(&system, BS_STICK, 0.7, Y, dot);
  CHECK_CLOSE(residual(&o, 0, 0.7, Y, dot + 2), 0.0, 1e-14);
  CHECK_CLOSE(residual(&o, 1, 0.7, Y, dot + 2), -0.6 * (Y[3] / 0.8), 1e-14);
  CHECK_CLOSE(bs_system_torque(&system, BS_STICK, 0.7, Y), 0.6 * (Y[3] / 0.8),
              1e-15);
  bs_system_clear(&system);
}

static void an_indefinite_mass_is_refused(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  o.M[1] = o.M[2] = 2.0;
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_NOT_DEFINITE);
  bs_system_clear(&system);
}

static void powers_are_those_of_the_matrices(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  double work[2];
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  CHECK_CLOSE(bs_system_power(&system, 0.4, Y, work),
              force(&o, 0, 0.4) * Y[2] + force(&o, 1, 0.4) * Y[3], 1e-15);
  CHECK_CLOSE(bs_system_viscous_power(&system, Y),
              0.2 * Y[2] * Y[2] + 0.1 * Y[2] * Y[3] + 0.1 * Y[3] * Y[3], 1e-15);
  bs_system_clear(&system);
}

static void the_series_solves_the_equations(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  bs_series series = {0};
  double y[4], before[4], after[4], dot[4];
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  CHECK(bs_series_init(&series, 2) == 0);
  bs_series_expand(&series, &system, BS_SLIP_POS, 0.7, Y);
  bs_series_at(&series, 0.7, y);
  CHECK(memcmp(y, Y, sizeof y) == 0);
  const double h = 1e-5;
  bs_series_at(&series, 1.0, y);
  bs_series_at(&series, 1.0 - h, before);
  bs_series_at(&series, 1.0 + h, after);
  bs_system_rhs(&system, BS_SLIP_POS, 1.0, y, dot);
  for (int i = 0; i < 4; i++) {
    CHECK_CLOSE((after[i] - before[i]) / (2.0 * h), dot[i], 1e-8);
  }
  bs_series_clear(&series);
  bs_system_clear(&system);
}

static void velocity_and_reaction_series_match_their_values(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  bs_series series = {0};
  const double y0[4] = {Y[0], Y[1], Y[2], 0.0};
  double y[4], value[BS_SERIES_ORDER + 1], noise[BS_SERIES_ORDER + 1];
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  CHECK(bs_series_init(&series, 2) == 0);
  bs_series_expand(&series, &system, BS_STICK, 0.7, y0);
  bs_series_at(&series, 1.0, y);
  CHECK(y[1] == y0[1] && y[3] == 0.0);
  bs_series_reaction(&series, &system, value, noise);
  double sum = 0.0;
  for (int k = BS_SERIES_ORDER; k >= 0; k--) {
    sum = sum * (1.0 - 0.7) + value[k];
    CHECK(noise[k] >= 0.0 && noise[k] < 1e-9);
  }
  CHECK_CLOSE(sum, bs_system_reaction(&system, 1.0, y), 1e-13);
  bs_series_velocity(&series, &system, BS_STICK, value, noise);
  for (int k = 0; k <= BS_SERIES_ORDER; k++) {
    CHECK(value[k] == 0.0);
  }
  bs_series_clear(&series);
  bs_system_clear(&system);
}

static void the_reach_keeps_the_truncation_small(void) {
  oscillator o = two_masses(0.6);
  bs_system system = {0};
  bs_series whole = {0}, part = {0};
  double y[4], again[4];
  oscillator_set(&o);
  CHECK(bs_system_init(&system, &o.problem) == BS_OK);
  CHECK(bs_series_init(&whole, 2) == 0 && bs_series_init(&part, 2) == 0);
  bs_series_expand(&whole, &system, BS_SLIP_POS, 0.0, Y);
  const double reach = bs_series_reach(&whole, 1e-10, o.atol, 1e-3, 100.0);
  CHECK(reach > 0.1 && reach < 100.0);
  bs_series_at(&whole, reach, y);
  bs_series_at(&whole, 0.5 * reach, again);
  bs_series_expand(&part, &system, BS_SLIP_POS, 0.5 * reach, again);
  bs_series_at(&part, reach, again);
  for (int i = 0; i < 4; i++) {
    CHECK_CLOSE(y[i], again[i], 1e-12);
  }
  bs_series_clear(&whole);
  bs_series_clear(&part);
  bs_system_clear(&system);
}

static void trailing_zero_harmonics_are_dropped(void) {
  const double f_cos[8] = {1.0, 2.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0};
  const double f_sin[8] = {0.0};
  bs_forcing forcing = {0};
  double f[2];
  CHECK(bs_forcing_init(&forcing, 2, 3, 1.3, f_cos, f_sin) == 0);
  CHECK(forcing.harmonics == 1);
  bs_forcing_at(&forcing, 0.9, f);
  CHECK_CLOSE(f[0], 1.0 + 0.5 * cos(1.3 * 0.9), 1e-15);
  CHECK(f[1] == 2.0);
  bs_forcing_clear(&forcing);
}

int main(void) {
  RUN(slip_obeys_the_equations);
  RUN(stick_holds_the_joint_and_the_reaction_closes_its_row);
  RUN(the_band_adds_damping);
  RUN(an_indefinite_mass_is_refused);
  RUN(powers_are_those_of_the_matrices);
  RUN(the_series_solves_the_equations);
  RUN(velocity_and_reaction_series_match_their_values);
  RUN(the_reach_keeps_the_truncation_small);
  RUN(trailing_zero_harmonics_are_dropped);
  return TEST_RESULT;
}
