/* First exit of a sum of exponentials: every way in which one can be missed. */
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "signal.h"

#define SIZE 8
static const double PI = 3.14159265358979323846;
static double memory[6 * SIZE + 3 * BM_LEVELS * SIZE];

/* offset + sum_k amplitude_k exp(rate_k t) cos(w_k t + phase_k) */
typedef struct {
  double amplitude, rate, w, phase;
} term;

static bm_signal signal_of(double base, double offset, int count,
                           const term *terms) {
  bm_signal f;
  double *next = memory;
  memset(memory, 0, sizeof memory);
  double *lr = next, *li = lr + SIZE, *er = li + 5 * SIZE;
  double *ei = er + BM_LEVELS * SIZE, *bound = ei + BM_LEVELS * SIZE;
  f.wr = li + SIZE;
  f.wi = f.wr + SIZE;
  f.pr = f.wi + SIZE;
  f.pi = f.pr + SIZE;
  f.cells = NULL;
  f.K = SIZE;
  f.base = base;
  f.offset = offset;
  for (int k = 0; k < count; k++) {
    lr[k] = terms[k].rate;
    li[k] = terms[k].w;
    f.wr[k] = terms[k].amplitude * cos(terms[k].phase);
    f.wi[k] = terms[k].amplitude * sin(terms[k].phase);
  }
  f.series_level = bm_signal_series_level(SIZE, base, lr, li);
  bm_signal_tabulate(SIZE, base, lr, li, er, ei, bound);
  f.lr = lr;
  f.li = li;
  f.er = er;
  f.ei = ei;
  f.bound = bound;
  return f;
}

static void simple_roots(void) {
  for (double base = 0.01; base < 20.0; base *= 3.0) {
    term t = {1.0, 0.0, 1.0, 0.0};
    bm_signal f = signal_of(base, 0.25, 1, &t);
    bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 100.0, 0, 0);
    CHECK(out.side == -1 && !out.multiple);
    NEAR(out.tau, acos(-0.25), 1e-14);
    f = signal_of(base, 0.25, 1, &t);
    out = bm_signal_exit(&f, -2.0, 1.0 - 1e-3, 100.0, 0, 0);
    CHECK(out.side == 1);
  }
}

static void exit_through_either_end(void) {
  term t = {1.0, 0.1, 3.0, 0.5 * PI};
  bm_signal f = signal_of(5.0, 0.0, 1, &t);
  bm_exit out = bm_signal_exit(&f, -0.5, 0.6, 50.0, 0, 0);
  CHECK(out.side == -1);
  NEAR(exp(0.1 * out.tau) * sin(3.0 * out.tau), 0.5, 1e-14);
  f = signal_of(5.0, 0.0, 1, &t);
  out = bm_signal_exit(&f, -1.06, 0.6, 50.0, 0, 0);
  CHECK(out.side == 1);
}

/* a minimum just above, and just below zero: two roots in one cell */
static void grazing(void) {
  for (double gap = 1e-2; gap > 1e-13; gap *= 0.1) {
    term t = {1.0, 0.0, 1.0, PI - 2.3};
    bm_signal f = signal_of(1.7, 1.0 + gap, 1, &t);
    bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 6.0, 0, 0);
    CHECK(out.side == 0);
    NEAR(out.tau, 6.0, 0.0);
    NEAR(out.margin, gap, 0.1 * gap + 1e-15);
    NEAR(out.margin_tau, 2.3, 2.0 * sqrt(gap));
    f = signal_of(1.7, 1.0 - gap, 1, &t);
    out = bm_signal_exit(&f, 0.0, HUGE_VAL, 6.0, 0, 0);
    CHECK(out.side == -1);
    NEAR(out.tau, 2.3 - acos(1.0 - gap), 3e-16 / sqrt(gap) + 1e-14);
  }
}

static void double_root(void) {
  term t = {1.0, 0.0, 1.0, PI - 2.3};
  bm_signal f = signal_of(1.7, 1.0, 1, &t);
  bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 6.0, 0, 0);
  /* either answer is right to rounding, but it must be marked */
  CHECK(out.side == 0 ? out.margin <= 1e-14 : out.multiple);
}

/* two fast roots far below the cell's length */
static void two_roots_in_a_cell(void) {
  term t[] = {{1.0, 0.0, 1.0, 0.0}, {-0.5, 0.0, 60.0, 0.2}};
  bm_signal f = signal_of(40.0, 0.55, 2, t);
  bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 40.0, 0, 0);
  double x = 0.0, h = 1e-4;
  while (0.55 + cos(x) - 0.5 * cos(60.0 * x + 0.2) > 0.0) {
    x += h;
  }
  CHECK(out.side == -1);
  NEAR(out.tau, x, h);
  NEAR(0.55 + cos(out.tau) - 0.5 * cos(60.0 * out.tau + 0.2), 0.0, 1e-13);
}

/* f = t^p (...) from a zero at the start, p = 1, 2, 3 */
static void zero_at_start(void) {
  term one = {1.0, 0.0, 1.0, -0.5 * PI}; /* sin t */
  bm_signal f = signal_of(2.0, 0.0, 1, &one);
  bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 10.0, 1, -1);
  CHECK(out.side == -1);
  NEAR(out.tau, PI, 1e-14);

  term two[] = {{-1.0, 0.0, 1.0, 0.0},
                {-0.3, 0.0, 1.0, 0.0}}; /* 1.3 (1 - cos) */
  f = signal_of(2.0, 1.3, 2, two);
  out = bm_signal_exit(&f, 0.0, HUGE_VAL, 6.0, 2, -1);
  CHECK(out.side == 0);

  term three[] = {{1.0, 0.0, 1.0, -0.5 * PI}, {-0.5, 0.0, 2.0, -0.5 * PI}};
  f = signal_of(2.0, 0.0, 2, three); /* sin t - sin 2t / 2 */
  out = bm_signal_exit(&f, 0.0, HUGE_VAL, 6.0, 1, -1);
  CHECK(out.multiple); /* the order is higher than was said */
  CHECK(out.side == -1);
  NEAR(out.tau, PI, 1e-5); /* again a root of order three */
}

static void outward_at_start(void) {
  term t = {-1.0, 0.0, 1.0, -0.5 * PI};
  bm_signal f = signal_of(2.0, 0.0, 1, &t);
  bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 10.0, 1, -1);
  CHECK(out.side == -1 && out.tau == 0.0);
  f = signal_of(2.0, 0.0, 1, &t);
  out = bm_signal_exit(&f, -HUGE_VAL, 0.0, 10.0, 1, 1); /* inward from above */
  CHECK(out.side == 1);
  NEAR(out.tau, PI, 1e-14);
}

static void flat_at_start(void) {
  bm_signal f = signal_of(2.0, 0.5, 0, NULL);
  bm_exit out = bm_signal_exit(&f, -0.5, 0.5, 1e6, 1, 1);
  CHECK(out.side == 0 && out.tau == 1e6);
}

static void none_for_ever(void) {
  term t = {1.0, 0.0, 1.0, 0.0};
  bm_signal f = signal_of(1.6, 0.0, 1, &t);
  bm_exit out = bm_signal_exit(&f, -1.01, 1.01, 1e5, 0, 0);
  CHECK(out.side == 0 && out.tau == 1e5);
}

static void decay_onto_the_border(void) {
  term t = {1.0, -1.0, 0.0, 0.0}; /* exp(-t) never reaches zero */
  bm_signal f = signal_of(1.6, 0.0, 1, &t);
  bm_exit out = bm_signal_exit(&f, 0.0, HUGE_VAL, 1e3, 0, 0);
  CHECK(out.side == 0 || out.multiple);
  f = signal_of(1.6, 0.25, 1, &t); /* down to 0.25: beyond rounding it hugs */
  out = bm_signal_exit(&f, 0.25, HUGE_VAL, 1e3, 0, 0);
  CHECK(out.side == 0 || out.multiple);
  CHECK(out.tau > 30.0);
}

static void not_finite(void) {
  term t = {NAN, 0.0, 1.0, 0.0};
  bm_signal f = signal_of(1.6, 0.0, 1, &t);
  CHECK(bm_signal_exit(&f, -1.0, 1.0, 10.0, 0, 0).side == 0);
}

int main(void) {
  simple_roots();
  exit_through_either_end();
  grazing();
  double_root();
  two_roots_in_a_cell();
  zero_at_start();
  outward_at_start();
  flat_at_start();
  none_for_ever();
  decay_onto_the_border();
  not_finite();
  return failures != 0;
}
