/* The k-th allocation fails, for every k: a clean status and no leak. Linked
 * with --wrap. */
#include "flow.h"
#include "lapack.h"
#include "mass.h"
#include "notebook.h"

void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

static long countdown = 0; /* 0: nothing fails */

static int fails_now(void) {
  return countdown > 0 && --countdown == 0;
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails_now() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size) {
  return fails_now() ? NULL : __real_realloc(old, size);
}

static bm_status walk(mass *it) {
  static notebook book;
  notebook_open(&book, ROOM);
  return bm_propagate(&it->run, 1, 0.0, &book.events);
}

static bm_status hunt(mass *it) {
  static double history[50], image[2], derivative[4], multipliers[4];
  static notebook book;
  notebook_open(&book, ROOM);
  bm_search search = {.periods = 1.0,
                      .sign = 1.0,
                      .tolerance = 1e-12,
                      .capacity = 50,
                      .history = history,
                      .image = image,
                      .derivative = derivative,
                      .lapack = &small_lapack,
                      .multipliers = multipliers,
                      .events = book.events};
  return bm_orbit(&it->run, &it->changes, &search);
}

static bm_status integrate(mass *it) {
  double x[2] = {0.1, 0.2}, squares = 0.0;
  bm_walk walk = {.first_mode = BM_SLIP_POS, .length = 1.0};
  bm_phases phases = {.end = 1.0, .state = x};
  bm_integrals of = {.squares = &squares};
  return bm_integrate(&it->free, &walk, &phases, &of);
}

static bm_status sample(mass *it) {
  double x[2] = {0.1, 0.2}, t = 0.5, at[2], torque;
  bm_walk walk = {.first_mode = BM_SLIP_POS, .length = 1.0};
  bm_phases phases = {.end = 1.0, .state = x};
  bm_samples to = {1, &t, at, &torque};
  return bm_sample(&it->free, &walk, &phases, &to);
}

static bm_status fourier(mass *it) {
  double x[2] = {0.1, 0.2}, values[6] = {0.0};
  bm_walk walk = {.first_mode = BM_SLIP_POS, .length = 1.0};
  bm_phases phases = {.end = 1.0, .state = x};
  bm_coefficients to = {1, 0, 1, values};
  return bm_fourier(&it->free, &walk, &phases, &to);
}

static bm_status modes(mass *it) {
  double one = 1.0, row[2] = {0.0, 1.0}, F[4] = {0.0}, packed[1024];
  int m;
  bm_soundness sound;
  bm_system of = {1, 1, it->Omega, &one, &it->c, &it->k, F, &one, row, F, 0.0};
  return bm_modes(&small_lapack, &of, packed, &m, &sound);
}

static bm_status change(mass *it) {
  double one = 1.0, packed[64];
  bm_joint joint = {0, 1.0, NULL, &one};
  return bm_changes_fill(&it->free, &it->held, &joint, packed);
}

static void every_allocation_may_fail(bm_status (*work)(mass *), int cells,
                                      int least) {
  int failed = 0, k = 1;
  for (; k < 10000; k++) {
    mass it = {.c = 0.04, .k = 1.0, .F = 1.0, .Omega = 0.05, .Q_m = 0.1,
               .Q_s = 0.1};
    mass_create(&it, cells);
    countdown = k;
    bm_status status = work(&it);
    int reached = countdown == 0;
    countdown = 0;
    mass_free(&it);
    if (!reached) {
      CHECK(status == BM_OK);
      break;
    }
    /* a Newton step that found no memory is one that led nowhere */
    CHECK(status == BM_NO_MEMORY || (status == BM_OK && work == hunt));
    failed += status == BM_NO_MEMORY;
  }
  CHECK(failed >= least && k < 10000);
}

int main(void) {
  for (int cells = 0; cells < 2; cells++) {
    every_allocation_may_fail(walk, cells, 3);
    every_allocation_may_fail(hunt, cells, 10);
  }
  every_allocation_may_fail(integrate, 0, 2);
  every_allocation_may_fail(sample, 0, 2);
  every_allocation_may_fail(fourier, 0, 2);
  every_allocation_may_fail(modes, 0, 2);
  every_allocation_may_fail(change, 0, 2);
  return failures != 0;
}
