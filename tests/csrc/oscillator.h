/* Small problems with known answers, shared by the tests of the core. */
#ifndef BS_OSCILLATOR_H
#define BS_OSCILLATOR_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "beltsim_core.h"

#define PI 3.14159265358979323846

/* A problem with its own memory; H <= 2, n <= 2. */
typedef struct {
  bs_problem problem;
  bs_settings settings;
  double M[4], C[4], G[4], K[4], f_cos[6], f_sin[6], atol[4], y0[4];
} oscillator;

static void oscillator_set(oscillator *o) {
  o->problem.M = o->M;
  o->problem.C = o->C;
  o->problem.G = o->G;
  o->problem.K = o->K;
  o->problem.f_cos = o->f_cos;
  o->problem.f_sin = o->f_sin;
  o->settings.atol = o->atol;
  for (int i = 0; i < 4; i++) {
    o->atol[i] = 1e-12;
  }
  o->settings.rtol = 1e-10;
  o->settings.max_steps = 10000000;
  o->settings.max_events = 1000000;
  o->settings.events_per_period = 1000.0;
  o->settings.grazing = 1e-4;
}

/* m = 1, k = 4 (swing of pi), Omega = 2, so that T = pi too. */
__attribute__((unused)) static oscillator one_mass(double Q_m,
                                                   double amplitude) {
  oscillator o;
  memset(&o, 0, sizeof o);
  o.problem.n = 1;
  o.problem.harmonics = 1;
  o.problem.law = BS_COULOMB;
  o.problem.Omega = 2.0;
  o.problem.Q_m = o.problem.Q_s = Q_m;
  o.problem.sigma = 1.0;
  o.M[0] = 1.0;
  o.K[0] = 4.0;
  o.f_cos[1] = amplitude;
  return o;
}

/* Two masses, the joint second, coupled through every matrix. */
__attribute__((unused)) static oscillator two_masses(double Q_m) {
  oscillator o;
  const double M[4] = {2.0, 0.3, 0.3, 1.0}, C[4] = {0.2, 0.05, 0.05, 0.1};
  const double G[4] = {0.0, 0.4, -0.4, 0.0}, K[4] = {9.0, -2.0, -2.0, 5.0};
  memset(&o, 0, sizeof o);
  o.problem.n = 2;
  o.problem.joint = 1;
  o.problem.harmonics = 2;
  o.problem.law = BS_COULOMB;
  o.problem.Omega = 1.3;
  o.problem.Q_m = o.problem.Q_s = Q_m;
  o.problem.sigma = 1.0;
  memcpy(o.M, M, sizeof M);
  memcpy(o.C, C, sizeof C);
  memcpy(o.G, G, sizeof G);
  memcpy(o.K, K, sizeof K);
  o.f_cos[2] = 1.0; /* row 1 */
  o.f_sin[3] = 0.7;
  o.f_cos[5] = 0.4; /* row 2 */
  return o;
}

enum { ROOM = 4096, TOUCH_ROOM = 256 };

typedef struct {
  bs_output out;
  double values[ROOM * BS_EVENT_VALUES], states[ROOM * 4];
  double touches[TOUCH_ROOM * BS_TOUCH_VALUES];
  int32_t codes[ROOM * 2];
} notebook;

__attribute__((unused)) static notebook *notebook_create(void) {
  notebook *book = calloc(1, sizeof *book);
  if (book == NULL) {
    abort();
  }
  book->out.event_capacity = ROOM;
  book->out.touch_capacity = TOUCH_ROOM;
  book->out.event_values = book->values;
  book->out.event_codes = book->codes;
  book->out.event_states = book->states;
  book->out.touch_values = book->touches;
  return book;
}

__attribute__((unused)) static double event_value(const notebook *book,
                                                  int64_t event, int column) {
  return book->values[event * BS_EVENT_VALUES + column];
}

__attribute__((unused)) static int event_kind(const notebook *book,
                                              int64_t event) {
  return book->codes[2 * event];
}

#endif
