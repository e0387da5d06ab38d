/* The event machine on one and two masses. */
#include "oscillator.h"
#include "test.h"

static bs_core *start(oscillator *o) {
  bs_core *core = NULL;
  char text[256];
  oscillator_set(o);
  const bs_status status =
      bs_create(&core, &o->problem, &o->settings, o->y0, text);
  CHECK(status == BS_OK && core != NULL);
  if (core == NULL) {
    fprintf(stderr, "%s %s\n", bs_status_name(status), text);
    exit(1);
  }
  return core;
}

static bs_status run_to(bs_core *core, double t, notebook *book) {
  return bs_run(core, t, 1e9, &book->out);
}

static void free_decay_stops_at_the_exact_place(void) {
  for (int method = BS_ADAMS; method <= BS_TAYLOR; method++) {
    oscillator o = one_mass(0.5, 0.0);
    double y[2];
    bs_summary seen;
    o.y0[0] = 0.8; /* each half swing loses 2 Q_m/k = 0.25 */
    o.settings.method = method;
    bs_core *core = start(&o);
    notebook *book = notebook_create();
    CHECK(run_to(core, 10.0, book) == BS_OK);
    CHECK(book->out.events_done == 3);
    for (int i = 0; i < 3; i++) {
      CHECK_CLOSE(event_value(book, i, BS_EVENT_T), (i + 1) * PI / 2, 2e-8);
      CHECK(event_kind(book, i) ==
            (i == 2 ? BS_EVENT_STICK : BS_EVENT_REVERSE));
      CHECK(book->states[2 * i + 1] == 0.0); /* exactly */
    }
    bs_state(core, y);
    CHECK_CLOSE(y[0], -0.05, 1e-7);
    CHECK(y[1] == 0.0);
    CHECK(y[0] == event_value(book, 2, BS_EVENT_POSITION));
    bs_summarise(core, &seen);
    CHECK(seen.t == 10.0 && seen.mode == BS_STICK);
    CHECK(seen.initial_mode == BS_SLIP_NEG && seen.events == 3);
    bs_free(core);
    free(book);
  }
}

static void a_run_in_pieces_gives_the_same_bits(void) {
  oscillator o = two_masses(0.6);
  o.y0[0] = 0.5;
  notebook *whole = notebook_create(), *pieces = notebook_create();
  double y[4], again[4];
  bs_core *core = start(&o);
  CHECK(run_to(core, 40.0, whole) == BS_OK);
  bs_state(core, y);
  bs_free(core);
  core = start(&o);
  for (int i = 1; i <= 400; i++) {
    CHECK(run_to(core, i * 0.1, pieces) == BS_OK);
  }
  bs_state(core, again);
  bs_free(core);
  CHECK(whole->out.events_done > 10);
  CHECK(whole->out.events_done == pieces->out.events_done);
  CHECK(memcmp(whole->values, pieces->values, sizeof whole->values) == 0);
  CHECK(memcmp(whole->states, pieces->states, sizeof whole->states) == 0);
  CHECK(memcmp(y, again, sizeof y) == 0);
  free(whole);
  free(pieces);
}

static void a_full_event_buffer_loses_nothing(void) {
  oscillator o = two_masses(0.6);
  o.y0[0] = 0.5;
  notebook *whole = notebook_create(), *small = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 40.0, whole) == BS_OK);
  bs_free(core);
  core = start(&o);
  small->out.event_capacity = 1;
  int64_t events = 0;
  bs_status status;
  do {
    small->out.events_done = 0;
    status = run_to(core, 40.0, small);
    for (int64_t i = 0; i < small->out.events_done; i++, events++) {
      CHECK(event_value(small, i, BS_EVENT_T) ==
            event_value(whole, events, BS_EVENT_T));
    }
  } while (status == BS_EVENTS_FULL);
  CHECK(status == BS_OK);
  CHECK(events == whole->out.events_done);
  bs_free(core);
  free(whole);
  free(small);
}

static void samples_lie_on_the_motion_and_stop_nothing(void) {
  oscillator o = one_mass(0.0, 0.0);
  double t[101], y[202], torque[101];
  bs_summary with, without;
  o.problem.law = BS_NO_FRICTION;
  o.y0[0] = 1.0;
  for (int i = 0; i <= 100; i++) {
    t[i] = 0.1 * i;
  }
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 10.0, book) == BS_OK);
  bs_summarise(core, &without);
  bs_free(core);
  book->out.n_samples = 101;
  book->out.sample_t = t;
  book->out.sample_state = y;
  book->out.sample_torque = torque;
  core = start(&o);
  CHECK(run_to(core, t[100], book) == BS_OK);
  bs_summarise(core, &with);
  bs_free(core);
  CHECK(book->out.samples_done == 101);
  CHECK(with.steps == without.steps);
  CHECK(with.mode == BS_FREE);
  for (int i = 0; i <= 100; i++) {
    CHECK_CLOSE(y[2 * i], cos(2.0 * t[i]), 1e-8);
    CHECK_CLOSE(y[2 * i + 1], -2.0 * sin(2.0 * t[i]), 1e-8);
    CHECK(torque[i] == 0.0);
  }
  free(book);
}

static void locked_for_ever_invents_no_event(void) {
  oscillator o = two_masses(50.0);
  bs_summary seen;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 1000.0 * 2.0 * PI / 1.3, book) == BS_OK);
  bs_summarise(core, &seen);
  CHECK(seen.events == 0 && seen.mode == BS_STICK && seen.restarts == 1);
  CHECK(book->out.touches_done == 0);
  bs_free(core);
  /* nothing but the joint: the step grows to the limit set by the forcing */
  o = one_mass(5.0, 1.0);
  core = start(&o);
  CHECK(run_to(core, 1000.0 * PI, book) == BS_OK);
  bs_summarise(core, &seen);
  CHECK(seen.events == 0 && seen.steps < 2100);
  bs_free(core);
  free(book);
}

static void a_crawling_start_is_a_slip(void) {
  oscillator o = one_mass(0.5, 0.0);
  o.y0[0] = 0.1;
  o.y0[1] = 1e-12;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 1.0, book) == BS_OK);
  /* decelerated by 0.9: it stops after 1.1e-12 */
  CHECK(book->out.events_done == 1);
  CHECK(event_kind(book, 0) == BS_EVENT_STICK);
  CHECK_CLOSE(event_value(book, 0, BS_EVENT_T), 1e-12 / 0.9, 1e-20);
  CHECK(book->codes[1] == BS_NEAR_GRAZING || book->codes[1] == BS_SIMPLE);
  bs_free(core);
  free(book);
}

/* k q = 4*0.125 = 0.5 = Q_s exactly; the forcing decides what comes next. */
static bs_mode start_on_the_limit(double f_cos, double f_sin) {
  oscillator o = one_mass(0.5, 0.0);
  bs_summary seen;
  o.y0[0] = -0.125; /* reaction +0.5 - f_cos + f_cos */
  o.f_cos[0] = -f_cos;
  o.f_cos[1] = f_cos;
  o.f_sin[1] = f_sin;
  bs_core *core = start(&o);
  bs_summarise(core, &seen);
  notebook *book = notebook_create();
  CHECK(run_to(core, 0.01, book) == BS_OK);
  CHECK(book->out.events_done == 0); /* the start itself is no event */
  bs_free(core);
  free(book);
  return (bs_mode)seen.mode;
}

static void exactly_on_the_limit_the_first_derivative_decides(void) {
  CHECK(start_on_the_limit(0.0, 0.3) == BS_SLIP_POS);
  CHECK(start_on_the_limit(0.0, -0.3) == BS_STICK);
  CHECK(start_on_the_limit(0.3, 0.0) == BS_STICK); /* second derivative */
  CHECK(start_on_the_limit(-0.3, 0.0) == BS_SLIP_POS);
  CHECK(start_on_the_limit(0.0, 0.0) == BS_STICK); /* for ever */
}

static void a_release_starts_from_rest_without_a_false_stop(void) {
  /* reaction sin(2t) reaches 0.5 at t = pi/12; released it must not come back
   * at once although it starts with zero velocity and acceleration */
  oscillator o = one_mass(0.5, 0.0);
  o.K[0] = 0.0;
  o.f_sin[1] = 1.0;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 1.0, book) == BS_OK);
  CHECK(book->out.events_done == 1);
  CHECK(event_kind(book, 0) == BS_EVENT_SLIP_POS);
  CHECK_CLOSE(event_value(book, 0, BS_EVENT_T), PI / 12, 1e-12);
  CHECK(event_value(book, 0, BS_EVENT_BEFORE) == 0.5);
  CHECK(event_value(book, 0, BS_EVENT_AFTER) == 0.5);
  bs_free(core);
  free(book);
}

static void static_friction_drops_to_kinetic(void) {
  oscillator o = one_mass(0.5, 0.0);
  o.problem.Q_s = 0.8;
  o.f_sin[1] = 1.0;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 0.6, book) == BS_OK);
  CHECK(book->out.events_done == 1);
  CHECK_CLOSE(event_value(book, 0, BS_EVENT_T), asin(0.8) / 2.0, 1e-12);
  CHECK(event_value(book, 0, BS_EVENT_BEFORE) == 0.8);
  CHECK(event_value(book, 0, BS_EVENT_AFTER) == 0.5);
  bs_free(core);
  free(book);
}

static void an_event_at_the_stop_belongs_to_the_run(void) {
  oscillator o = one_mass(0.5, 0.0);
  o.y0[0] = 0.8;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 2.0, book) == BS_OK);
  const double t = event_value(book, 0, BS_EVENT_T);
  bs_free(core);
  double y[2];
  book->out.events_done = 0;
  core = start(&o);
  CHECK(run_to(core, t, book) == BS_OK);
  CHECK(book->out.events_done == 1);
  bs_state(core, y);
  CHECK(y[1] == 0.0);
  CHECK(run_to(core, 2.0, book) == BS_OK);
  CHECK(book->out.events_done == 1);
  bs_free(core);
  free(book);
}

static void no_friction_only_reverses(void) {
  oscillator o = one_mass(0.0, 0.0);
  o.y0[0] = 1.0;
  notebook *book = notebook_create();
  bs_core *core = start(&o);
  CHECK(run_to(core, 100.0, book) == BS_OK);
  CHECK(book->out.events_done == 63); /* 100/(pi/2) */
  for (int64_t i = 0; i < book->out.events_done; i++) {
    CHECK(event_kind(book, i) == BS_EVENT_REVERSE);
  }
  bs_free(core);
  free(book);
}

static void at_rest_without_load_nothing_happens(void) {
  for (int method = BS_ADAMS; method <= BS_TAYLOR; method++) {
    oscillator o = one_mass(0.0, 0.0);
    double y[2];
    o.settings.method = method;
    notebook *book = notebook_create();
    bs_core *core = start(&o);
    CHECK(run_to(core, 1000.0, book) == BS_OK);
    bs_state(core, y);
    CHECK(book->out.events_done == 0 && y[0] == 0.0 && y[1] == 0.0);
    bs_free(core);
    free(book);
  }
}

static void grazing_is_told(void) {
  /* f = a (1 - cos 2t) with a = 1/4: the reaction a(1 - cos) touches Q_s = 1/2
   * at t = pi/2 (1 + eps) */
  for (int sign = -1; sign <= 1; sign += 2) {
    oscillator o = one_mass(0.5, 0.0);
    o.f_cos[0] = 0.25 * (1.0 + sign * 1e-7);
    o.f_cos[1] = -0.25 * (1.0 + sign * 1e-7);
    notebook *book = notebook_create();
    bs_core *core = start(&o);
    CHECK(run_to(core, 3.0, book) == BS_OK);
    if (sign < 0) {
      CHECK(book->out.events_done == 0 && book->out.touches_done == 1);
      CHECK_CLOSE(book->touches[BS_TOUCH_T], PI / 2, 1e-9);
      CHECK_CLOSE(book->touches[BS_TOUCH_DISTANCE], 5e-8, 1e-12);
    } else {
      CHECK(book->out.events_done == 2); /* a short slip */
      CHECK(event_kind(book, 0) == BS_EVENT_SLIP_POS);
      CHECK(event_kind(book, 1) == BS_EVENT_STICK);
      CHECK(book->codes[1] == BS_NEAR_GRAZING);
    }
    bs_free(core);
    free(book);
  }
}

static void the_saturated_band_has_located_edges(void) {
  const int methods[2] = {BS_BDF, BS_TAYLOR};
  for (int i = 0; i < 2; i++) {
    oscillator o = one_mass(0.5, 1.0);
    o.problem.law = BS_SATURATED;
    o.problem.sigma = 0.01;
    o.C[0] = 0.3;
    o.settings.method = methods[i];
    notebook *book = notebook_create();
    bs_core *core = start(&o);
    CHECK(run_to(core, 10.0 * PI, book) == BS_OK);
    CHECK(book->out.events_done > 20);
    for (int64_t k = 0; k < book->out.events_done; k++) {
      CHECK(fabs(book->states[2 * k + 1]) == 0.01); /* exactly the edge */
      CHECK(event_kind(book, k) != BS_EVENT_REVERSE);
    }
    bs_free(core);
    free(book);
  }
}

static void budgets_and_chatter_stop_the_run(void) {
  notebook *book = notebook_create();
  oscillator o = one_mass(0.1, 1.0);
  o.y0[0] = 1.0;
  bs_core *core = start(&o);
  bs_free(core);
  struct {
    bs_status wanted;
    int64_t steps, events;
    double crowd;
  } cases[3] = {{BS_TOO_MANY_STEPS, 50, 1000, 1e3},
                {BS_TOO_MANY_EVENTS, 1000000, 3, 1e3},
                {BS_CHATTER, 1000000, 1000, 1.0}};
  for (int i = 0; i < 3; i++) {
    char text[256];
    bs_summary seen;
    o.settings.max_steps = cases[i].steps;
    oscillator_set(&o);
    o.settings.max_steps = cases[i].steps;
    o.settings.max_events = cases[i].events;
    o.settings.events_per_period = cases[i].crowd;
    book->out.events_done = 0;
    CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == BS_OK);
    CHECK(run_to(core, 100.0, book) == cases[i].wanted);
    CHECK(run_to(core, 100.0, book) == cases[i].wanted); /* it stays */
    bs_summarise(core, &seen);
    CHECK(seen.t > 0.0 && seen.t < 100.0);
    bs_free(core);
  }
  free(book);
}

static void a_slice_and_a_cancel_return_early(void) {
  notebook *book = notebook_create();
  oscillator o = two_masses(0.6);
  bs_core *core = start(&o);
  CHECK(bs_run(core, 1e5, 0.0, &book->out) == BS_SLICE);
  bs_summary seen;
  bs_summarise(core, &seen);
  CHECK(seen.steps < 100);
  bs_cancel(core); /* before a run: no effect */
  CHECK(bs_run(core, seen.t + 1.0, 1e9, &book->out) == BS_OK);
  bs_free(core);
  free(book);
}

static void bad_arguments_are_refused(void) {
  char text[256];
  bs_core *core = NULL;
  oscillator good = one_mass(0.5, 1.0);
  oscillator_set(&good);
#define REFUSED(change)                                            \
  do {                                                             \
    oscillator o = good;                                           \
    oscillator_set(&o);                                            \
    change;                                                        \
    CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == \
          BS_BAD_INPUT);                                           \
    CHECK(core == NULL);                                           \
  } while (0)
  REFUSED(o.problem.n = 0);
  REFUSED(o.problem.joint = 1);
  REFUSED(o.problem.joint = -1);
  REFUSED(o.problem.Omega = 0.0);
  REFUSED(o.problem.Q_s = 0.4);
  REFUSED(o.problem.Q_m = -1.0);
  REFUSED(o.problem.law = 3);
  REFUSED(o.problem.law = BS_SATURATED; o.problem.sigma = 0.0);
  REFUSED(o.problem.K = NULL);
  REFUSED(o.problem.harmonics = -1);
  REFUSED(o.settings.method = 3);
  REFUSED(o.settings.rtol = 0.0);
  REFUSED(o.settings.atol = NULL);
  bs_free(NULL);
}

static void every_status_has_a_name_and_a_text(void) {
  for (int status = BS_OUT_OF_TIME; status <= BS_SLICE; status++) {
    CHECK(strncmp(bs_status_name((bs_status)status), "BS_", 3) == 0);
    CHECK(strcmp(bs_status_name((bs_status)status), "BS_UNKNOWN") != 0);
    CHECK(strlen(bs_status_text((bs_status)status)) > 3);
  }
  CHECK(strcmp(bs_status_name((bs_status)-99), "BS_UNKNOWN") == 0);
}

static void a_growing_motion_is_not_finite_in_the_end(void) {
  for (int method = BS_ADAMS; method <= BS_TAYLOR; method++) {
    oscillator o = one_mass(0.0, 0.0);
    o.problem.law = BS_NO_FRICTION;
    o.K[0] = -1e4;
    o.y0[0] = 1.0;
    o.settings.method = method;
    notebook *book = notebook_create();
    bs_core *core = start(&o);
    const bs_status status = run_to(core, 100.0, book);
    CHECK(status == BS_NOT_FINITE);
    bs_free(core);
    free(book);
  }
}

int main(void) {
  RUN(free_decay_stops_at_the_exact_place);
  RUN(a_run_in_pieces_gives_the_same_bits);
  RUN(a_full_event_buffer_loses_nothing);
  RUN(samples_lie_on_the_motion_and_stop_nothing);
  RUN(locked_for_ever_invents_no_event);
  RUN(a_crawling_start_is_a_slip);
  RUN(exactly_on_the_limit_the_first_derivative_decides);
  RUN(a_release_starts_from_rest_without_a_false_stop);
  RUN(static_friction_drops_to_kinetic);
  RUN(an_event_at_the_stop_belongs_to_the_run);
  RUN(no_friction_only_reverses);
  RUN(at_rest_without_load_nothing_happens);
  RUN(grazing_is_told);
  RUN(the_saturated_band_has_located_edges);
  RUN(budgets_and_chatter_stop_the_run);
  RUN(a_slice_and_a_cancel_return_early);
  RUN(bad_arguments_are_refused);
  RUN(every_status_has_a_name_and_a_text);
  RUN(a_growing_motion_is_not_finite_in_the_end);
  return TEST_RESULT;
}
