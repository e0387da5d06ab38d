/* The transition table. */
#include "friction.h"
#include "test.h"

static const bs_friction LAW = {BS_COULOMB, 1.0, 2.0, 0.0};
static const bs_friction NONE = {BS_COULOMB, 0.0, 0.0, 0.0};
static const double NOISE[3] = {1e-14, 1e-14, 1e-14};

static bs_mode rest(const bs_friction *law, double r0, double r1, double r2,
                    int on_limit) {
  const double series[3] = {r0, r1, r2};
  return bs_friction_mode_at_rest(law, series, NOISE, 2, on_limit);
}

static void inside_the_limit_it_sticks(void) {
  CHECK(rest(&LAW, 1.9, 5.0, 0.0, 0) == BS_STICK);
  CHECK(rest(&LAW, -1.9, -5.0, 0.0, 0) == BS_STICK);
}

static void beyond_the_limit_it_slips_with_the_reaction(void) {
  CHECK(rest(&LAW, 2.1, -5.0, 0.0, 0) == BS_SLIP_POS);
  CHECK(rest(&LAW, -2.1, 5.0, 0.0, 0) == BS_SLIP_NEG);
}

static void on_the_limit_the_first_derivative_above_rounding_decides(void) {
  CHECK(rest(&LAW, 2.0, 1.0, 0.0, 0) == BS_SLIP_POS);
  CHECK(rest(&LAW, 2.0, -1.0, 0.0, 0) == BS_STICK);
  CHECK(rest(&LAW, -2.0, -1.0, 0.0, 0) == BS_SLIP_NEG);
  CHECK(rest(&LAW, -2.0, 1.0, 0.0, 0) == BS_STICK);
  CHECK(rest(&LAW, 2.0, 1e-15, 1.0, 0) == BS_SLIP_POS);
  CHECK(rest(&LAW, 2.0, -1e-15, -1.0, 0) == BS_STICK);
  CHECK(rest(&LAW, 2.0, 1e-15, -1e-15, 0) == BS_STICK);
  CHECK(rest(&LAW, 2.0 + 1e-15, -1.0, 0.0, 0) == BS_STICK);
}

static void a_located_limit_is_believed(void) {
  CHECK(rest(&LAW, 2.0 - 1e-9, 1.0, 0.0, 1) == BS_SLIP_POS);
  CHECK(rest(&LAW, 2.0 + 1e-9, -1.0, 0.0, 1) == BS_STICK);
}

static void without_friction_any_pull_releases(void) {
  CHECK(rest(&NONE, 0.1, 0.0, 0.0, 0) == BS_SLIP_POS);
  CHECK(rest(&NONE, 0.0, -1.0, 0.0, 0) == BS_SLIP_NEG);
  CHECK(rest(&NONE, 0.0, 0.0, 1.0, 0) == BS_SLIP_POS);
  CHECK(rest(&NONE, 0.0, 0.0, 0.0, 0) == BS_STICK);
}

static void kinds_follow_the_table(void) {
  const bs_mode modes[3] = {BS_STICK, BS_SLIP_POS, BS_SLIP_NEG};
  const int wanted[3][3] = {
      {-1, BS_EVENT_SLIP_POS, BS_EVENT_SLIP_NEG},
      {BS_EVENT_STICK, -1, BS_EVENT_REVERSE},
      {BS_EVENT_STICK, BS_EVENT_REVERSE, -1},
  };
  for (int from = 0; from < 3; from++) {
    for (int to = 0; to < 3; to++) {
      bs_kind kind = BS_EVENT_STICK;
      const int failed = bs_friction_kind(modes[from], modes[to], &kind);
      CHECK((failed != 0) == (wanted[from][to] < 0));
      CHECK(failed || (int)kind == wanted[from][to]);
    }
  }
}

static void the_torque_opposes_the_motion(void) {
  CHECK(bs_friction_level(&LAW, BS_SLIP_POS) == 1.0);
  CHECK(bs_friction_level(&LAW, BS_SLIP_NEG) == -1.0);
  CHECK(bs_friction_level(&LAW, BS_STICK) == 0.0);
  CHECK(bs_friction_level(&LAW, BS_FREE) == 0.0);
}

int main(void) {
  RUN(inside_the_limit_it_sticks);
  RUN(beyond_the_limit_it_slips_with_the_reaction);
  RUN(on_the_limit_the_first_derivative_above_rounding_decides);
  RUN(a_located_limit_is_believed);
  RUN(without_friction_any_pull_releases);
  RUN(kinds_follow_the_table);
  RUN(the_torque_opposes_the_motion);
  return TEST_RESULT;
}
