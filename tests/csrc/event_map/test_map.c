/* The mode machine on one mass, whose motion is known by hand. */
#include "mass.h"
#include "notebook.h"

static const double *event(const notebook *book, int i) {
  return book->reals + i * (BM_EVENT_REALS + 2);
}

static int64_t kind(const notebook *book, int i) {
  return book->integers[i * BM_EVENT_INTEGERS + BM_KIND];
}

/* q'' + q + 0.1 sign(q') = 0 from 1.05: five half swings, each 0.2 shorter. */
static void stops_after_five_half_swings(void) {
  for (int cells = 0; cells < 2; cells++) {
    mass it = {.c = 0.0, .k = 1.0, .Omega = 0.25, .Q_m = 0.1, .Q_s = 0.1};
    static notebook book;
    mass_create(&it, cells);
    notebook_open(&book, ROOM);
    it.state[0] = 1.05;
    CHECK(bm_propagate(&it.run, 1, 0.0, &book.events) == BM_OK);
    CHECK(book.events.count == 5);
    for (int i = 0; i < 5; i++) {
      CHECK(kind(&book, i) == (i < 4 ? 1 : 0));
      NEAR(event(&book, i)[BM_TIME], (i + 1) * 0.5 * TURN, 1e-13);
      double place = (i % 2 ? 1.0 : -1.0) * (1.05 - 0.2 * (i + 1));
      NEAR(event(&book, i)[BM_EVENT_REALS], place, 1e-13);
      CHECK(event(&book, i)[BM_EVENT_REALS + 1] == 0.0);
    }
    CHECK(it.run.mode == BM_STICK && it.state[1] == 0.0);
    mass_free(&it);
  }
}

/* At rest under F cos: released where F cos(t) reaches Q_s; the rest in time. */
static void releases_where_the_reaction_reaches_the_limit(void) {
  mass it = {.c = 0.1, .k = 3.0, .F = 1.0, .Omega = 1.0, .Q_m = 0.5, .Q_s = 0.8};
  static notebook book;
  mass_create(&it, 0);
  notebook_open(&book, ROOM);
  it.run.time = 0.25 * TURN; /* the reaction is zero and falls */
  CHECK(bm_propagate(&it.run, 0, 0.5 * TURN, &book.events) == BM_OK);
  CHECK(it.run.first_mode == BM_STICK);
  CHECK(book.events.count >= 1 && kind(&book, 0) == 3);
  NEAR(event(&book, 0)[BM_TIME], acos(-0.8), 1e-13);
  NEAR(event(&book, 0)[BM_TORQUE_BEFORE], -0.8, 0.0);
  NEAR(event(&book, 0)[BM_TORQUE_AFTER], -0.5, 0.0);
  mass_free(&it);
}

/* A buffer of one event: the same run, drained and resumed. */
static void a_full_buffer_changes_nothing(void) {
  for (int cells = 0; cells < 2; cells++) {
    mass it = {.c = 0.1, .k = 1.0, .F = 1.0, .Omega = 0.7, .Q_m = 0.4,
               .Q_s = 0.4};
    static notebook whole, one;
    mass_create(&it, cells);
    bm_run run = it.run;
    double state[2] = {0.0, 0.0};
    run.state = state;
    notebook_open(&whole, ROOM);
    CHECK(bm_propagate(&it.run, 5, 0.3, &whole.events) == BM_OK);
    CHECK(whole.events.count >= 8);
    int64_t found = 0;
    bm_status status = BM_FULL;
    while (status == BM_FULL) {
      notebook_open(&one, 1);
      status = bm_propagate(&run, 5, 0.3, &one.events);
      for (int64_t i = 0; i < one.events.count; i++, found++) {
        CHECK(found < whole.events.count &&
              !memcmp(event(&one, 0), event(&whole, (int)found),
                      (BM_EVENT_REALS + 2) * sizeof(double)));
      }
    }
    CHECK(status == BM_OK && found == whole.events.count);
    CHECK(state[0] == it.state[0] && state[1] == it.state[1]);
    mass_free(&it);
  }
}

static void failures_have_their_status(void) {
  static notebook book;
  mass it = {.c = 0.1, .k = 1.0, .F = 1.0, .Omega = 0.7, .Q_m = 0.4,
             .Q_s = 0.4};
  mass_create(&it, 0);
  it.run.event_limit = 1.0;
  notebook_open(&book, ROOM);
  CHECK(bm_propagate(&it.run, 9, 0.0, &book.events) == BM_CHATTER);
  mass_free(&it);

  mass_create(&it, 0);
  it.state[0] = NAN;
  notebook_open(&book, ROOM);
  CHECK(bm_propagate(&it.run, 1, 0.0, &book.events) == BM_NOT_FINITE);
  mass_free(&it);

  mass grows = {.c = -3.9, .k = 4.0, .F = 1.0, .Omega = 0.01};
  mass_create(&grows, 0);
  notebook_open(&book, ROOM);
  bm_status status = BM_FULL;
  while (status == BM_FULL) {
    notebook_open(&book, ROOM);
    status = bm_propagate(&grows.run, 9, 0.0, &book.events);
  }
  CHECK(status == BM_NOT_FINITE);
  mass_free(&grows);
}

int main(void) {
  stops_after_five_half_swings();
  releases_where_the_reaction_reaches_the_limit();
  a_full_buffer_changes_nothing();
  failures_have_their_status();
  return failures != 0;
}
