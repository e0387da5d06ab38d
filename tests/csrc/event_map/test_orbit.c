/* Shooting on one mass, its derivative, and the integrals over a phase. */
#include "derivative.h"
#include "mass.h"
#include "notebook.h"

typedef struct {
  double history[50], image[2], derivative[4];
  notebook book;
  bm_search search;
} hunt;

static void hunt_set(hunt *it, double periods, double sign, int64_t room) {
  notebook_open(&it->book, room);
  bm_search search = {.periods = periods,
                      .sign = sign,
                      .tolerance = 1e-12,
                      .capacity = 50,
                      .history = it->history,
                      .image = it->image,
                      .derivative = it->derivative,
                      .events = it->book.events};
  it->search = search;
}

static mass rubbing(void) {
  mass it = {.c = 0.04, .k = 1.0, .F = 1.0, .Omega = 0.5, .Q_m = 0.4,
             .Q_s = 0.4};
  return it;
}

/* The orbit repeats; modes, cells and the whole period find the same one. */
static void finds_the_orbit(void) {
  double first[2] = {0.0, 0.0};
  for (int i = 0; i < 4; i++) {
    int cells = i % 2, half = i < 2;
    static hunt found;
    mass it = rubbing();
    mass_create(&it, cells);
    hunt_set(&found, half ? 0.5 : 1.0, half ? -1.0 : 1.0, ROOM);
    CHECK(bm_orbit(&it.run, &it.changes, &found.search) == BM_OK);
    CHECK(found.search.residual <= 1e-12);
    CHECK(found.search.steps >= 2 && found.search.followed > 0.0);
    CHECK(found.search.events.count == (half ? 2 : 4));
    for (int j = 0; j < 2; j++) {
      NEAR(found.image[j], it.state[j], 1e-12);
      if (i > 0) {
        NEAR(it.state[j], first[j], 1e-10);
      }
    }
    memcpy(first, it.state, sizeof first);
    mass_free(&it);
  }
}

/* Against central differences of walks, with a jump of the acceleration at
 * releases too. */
static void derivative_is_the_slope(void) {
  for (int i = 0; i < 4; i++) {
    static notebook book;
    mass it = rubbing();
    it.Q_s = i < 2 ? 0.4 : 0.5;
    mass_create(&it, i % 2);
    bm_carrier carrier;
    CHECK(bm_carrier_create(&carrier, &it.run));
    double ends[2][2][2], x[2] = {1.3, 0.2}, h = 1e-6, length = 1.7;
    for (int j = 0; j < 2; j++) {
      for (int s = 0; s < 2; s++) {
        bm_run run = it.run;
        memcpy(ends[j][s], x, sizeof x);
        ends[j][s][j] += s ? h : -h;
        run.state = ends[j][s];
        notebook_open(&book, ROOM);
        CHECK(bm_propagate(&run, 1, (length - 1.0) * TURN / it.Omega,
                           &book.events) == BM_OK);
      }
    }
    bm_run run = it.run;
    run.state = x;
    notebook_open(&book, ROOM);
    CHECK(bm_propagate(&run, 1, (length - 1.0) * TURN / it.Omega,
                       &book.events) == BM_OK);
    CHECK(book.events.count >= 4);
    bm_walk walk = {book.events, run.first_mode, run.mode,
                    length * TURN / it.Omega};
    bm_carry(&carrier, &it.run, &it.changes, &walk);
    for (int r = 0; r < 2; r++) {
      for (int j = 0; j < 2; j++) {
        double sum = 0.0; /* out S into */
        for (int a = 0; a < 2; a++) {
          for (int b = 0; b < 2; b++) {
            sum += it.changes.out[2 * r + a] * carrier.S[2 * a + b] *
                   it.changes.into[2 * b + j];
          }
        }
        NEAR(sum, (ends[j][1][r] - ends[j][0][r]) / (2.0 * h), 1e-7);
      }
    }
    bm_carrier_free(&carrier);
    mass_free(&it);
  }
}

static void a_small_buffer_is_told(void) {
  static hunt found;
  mass it = rubbing();
  mass_create(&it, 0);
  hunt_set(&found, 1.0, 1.0, 1);
  found.search.capacity = 2; /* of the history: the last one stays */
  CHECK(bm_orbit(&it.run, &it.changes, &found.search) == BM_OK);
  CHECK(found.search.events.count == 4);
  CHECK(found.search.steps > 2 &&
        found.history[1] == found.search.residual);
  mass_free(&it);
}

static void a_motion_that_runs_away_is_told(void) {
  static hunt found;
  mass it = {.c = -3.9, .k = 4.0, .F = 1.0, .Omega = 0.01, .Q_m = 0.1,
             .Q_s = 0.1};
  mass_create(&it, 0);
  hunt_set(&found, 1.0, 1.0, ROOM);
  CHECK(bm_orbit(&it.run, &it.changes, &found.search) == BM_NOT_FINITE);
  mass_free(&it);
}

/* Of the free phases of a walk within a window, by the midpoint rule. */
static void integrals_are_sums(void) {
  static notebook book;
  mass it = rubbing();
  mass_create(&it, 0);
  double x[2] = {1.3, 0.2}, start[2] = {1.3, 0.2};
  bm_run run = it.run;
  run.state = x;
  notebook_open(&book, ROOM);
  CHECK(bm_propagate(&run, 2, 0.0, &book.events) == BM_OK);
  bm_walk walk = {book.events, run.first_mode, run.mode, 2.0 * TURN / it.Omega};
  double F[4] = {0.0, 0.0, it.F, 0.0}, squares = 0.0;
  bm_phases phases = {.role = BM_FREE, .Q_m = it.Q_m, .start = 0.9, .end = 21.0,
                      .state = start};
  bm_integrals of = {.F = F, .C = &it.c, .squares = &squares};
  CHECK(bm_integrate(&it.free, &walk, &phases, &of) == BM_OK);
  double sums[5] = {0.0};
  enum { MANY = 200000 };
  double d = (phases.end - phases.start) / MANY;
  bm_run on = it.run;
  on.state = start;
  for (int s = 0; s < MANY; s++) {
    double t = phases.start + (s + 0.5) * d;
    double whole = floor(t * it.Omega / TURN);
    notebook_open(&book, ROOM);
    CHECK(bm_propagate(&on, (int64_t)whole, t - whole * TURN / it.Omega,
                       &book.events) == BM_OK);
    double q = start[0], v = start[1];
    double parts[] = {q * q, v * v, it.F * cos(it.Omega * t) * v, it.c * v * v,
                      on.mode * it.Q_m * v};
    for (int i = 0; i < 5 && on.mode != BM_STICK; i++) {
      sums[i] += d * parts[i];
    }
  }
  NEAR(squares, sums[0], 1e-3); /* steps across an event count by their middle */
  NEAR(of.speed, sums[1], 1e-7);
  NEAR(of.work, sums[2], 1e-7);
  NEAR(of.loss, sums[3], 1e-7);
  NEAR(of.slipped, sums[4], 1e-7);
  mass_free(&it);
}

int main(void) {
  finds_the_orbit();
  derivative_is_the_slope();
  a_small_buffer_is_told();
  a_motion_that_runs_away_is_told();
  integrals_are_sums();
  return failures != 0;
}
