/* Isolation of roots and minima of polynomials. */
#include "roots.h"
#include "test.h"

static void bernstein_of_product(const double *root, int degree, double *b) {
  double power[BS_ROOTS_DEGREE + 1] = {1.0};
  for (int i = 0; i < degree; i++) { /* times (root - x) */
    for (int k = i + 1; k > 0; k--) {
      power[k] = root[i] * power[k] - power[k - 1];
    }
    power[0] *= root[i];
  }
  bs_roots_bernstein(degree, power, b);
}

static void values_and_slopes_agree_with_the_power_form(void) {
  const double power[5] = {1.0, -2.0, 0.5, 3.0, -1.25};
  double b[5], p, slope, curvature;
  bs_roots_bernstein(4, power, b);
  for (double x = 0.0; x <= 1.0; x += 0.125) {
    bs_roots_value(4, b, x, &p, &slope, &curvature);
    CHECK_CLOSE(p, 1 + x * (-2 + x * (0.5 + x * (3 - 1.25 * x))), 1e-14);
    CHECK_CLOSE(slope, -2 + x * (1 + x * (9 - 5 * x)), 1e-13);
    CHECK_CLOSE(curvature, 1 + x * (18 - 15 * x), 1e-12);
  }
}

static void shift_moves_and_stretches(void) {
  double power[4] = {1.0, -2.0, 0.5, 3.0};
  bs_roots_shift(3, power, -1.0, 0.5); /* p(-1 + x/2) */
  const double x = 0.7, u = -1.0 + 0.5 * x;
  CHECK_CLOSE(power[0] + x * (power[1] + x * (power[2] + x * power[3])),
              1.0 + u * (-2.0 + u * (0.5 + u * 3.0)), 1e-14);
}

static void finds_the_first_of_several(void) {
  const double roots[3] = {0.9, 0.31, 0.5};
  double b[4], x = -1.0;
  bernstein_of_product(roots, 3, b);
  CHECK(bs_roots_first(3, b, &x));
  CHECK_CLOSE(x, 0.31, 1e-15);
}

static void two_roots_inside_one_step_are_found(void) {
  for (double gap = 1e-1; gap > 1e-7; gap *= 0.1) {
    const double roots[4] = {0.4, 0.4 + gap, 3.0, 5.0};
    double b[5], x = -1.0;
    bernstein_of_product(roots, 4, b);
    CHECK(b[0] > 0.0 && b[4] > 0.0); /* no change of sign at the ends */
    CHECK(bs_roots_first(4, b, &x));
    CHECK_CLOSE(x, 0.4, 1e-15 / gap + 1e-15);
  }
}

static void a_touch_is_a_minimum_and_no_root(void) {
  /* (x - 0.4)^2 + 1e-9 */
  const double power[3] = {0.16 + 1e-9, -0.8, 1.0};
  double b[3], x = -1.0, low = -1.0;
  bs_roots_bernstein(2, power, b);
  CHECK(!bs_roots_first(2, b, &x));
  CHECK(bs_roots_minima(2, b, 1e-6, 1, &x, &low) == 1);
  CHECK_CLOSE(x, 0.4, 1e-12);
  CHECK_CLOSE(low, 1e-9, 1e-15);
  CHECK(bs_roots_minima(2, b, 1e-10, 1, &x, &low) == 0);
}

static void a_minimum_on_a_cut_is_found(void) {
  const double power[3] = {0.25 + 1e-9, -1.0, 1.0}; /* at exactly 1/2 */
  double b[3], x = -1.0, low = -1.0;
  bs_roots_bernstein(2, power, b);
  CHECK(bs_roots_minima(2, b, 1e-6, 1, &x, &low) == 1);
  CHECK_CLOSE(x, 0.5, 1e-12);
}

static void several_minima_come_in_order(void) {
  /* (x-.2)^2 (x-.8)^2 + 1e-6 */
  double power[5] = {0.0256 + 1e-6, -0.32, 1.32, -2.0, 1.0};
  double b[5], x[2], low[2];
  bs_roots_bernstein(4, power, b);
  CHECK(bs_roots_minima(4, b, 1e-3, 2, x, low) == 2);
  CHECK_CLOSE(x[0], 0.2, 1e-9);
  CHECK_CLOSE(x[1], 0.8, 1e-9);
}

static void roots_at_the_ends(void) {
  const double falling[2] = {1.0, 0.0}, from_zero[2] = {0.0, 1.0};
  const double constant[2] = {1.0, 1.0};
  double x = -1.0;
  CHECK(bs_roots_first(1, falling, &x) && x == 1.0);
  CHECK(bs_roots_first(1, from_zero, &x) && x == 0.0);
  CHECK(!bs_roots_first(1, constant, &x));
  CHECK(!bs_roots_first(0, constant, &x));
}

static void not_a_number_ends_the_search(void) {
  const double bad[4] = {1.0, NAN, -1.0, NAN};
  double x = -1.0;
  (void)bs_roots_first(3, bad, &x); /* any answer, but an answer */
  CHECK(1);
}

int main(void) {
  RUN(values_and_slopes_agree_with_the_power_form);
  RUN(shift_moves_and_stretches);
  RUN(finds_the_first_of_several);
  RUN(two_roots_inside_one_step_are_found);
  RUN(a_touch_is_a_minimum_and_no_root);
  RUN(a_minimum_on_a_cut_is_found);
  RUN(several_minima_come_in_order);
  RUN(roots_at_the_ends);
  RUN(not_a_number_ends_the_search);
  return TEST_RESULT;
}
