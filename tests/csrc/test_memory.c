/* The k-th allocation fails, for every k: a clean status and no leak. Linked
 * with --wrap, so that it catches SUNDIALS' allocations too where its static
 * archives are used. Left out is what SUNContext_Create allocates: SUNDIALS
 * 6.4.1 writes through NULL there (SUNHashMap_New), out of our reach. */
#include <sundials/sundials_context.h>
#include <sundials/sundials_version.h>

#include "oscillator.h"
#include "test.h"

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);

static long countdown = 0; /* 0: nothing fails */
static long allocations = 0;

static int inside_context = 0;

#if SUNDIALS_VERSION_MAJOR >= 7
#define COMM SUNComm
#else
#define COMM void *
#endif
int __real_SUNContext_Create(COMM comm, SUNContext *context);
int __wrap_SUNContext_Create(COMM comm, SUNContext *context);

int __wrap_SUNContext_Create(COMM comm, SUNContext *context) {
  inside_context = 1;
  const int code = __real_SUNContext_Create(comm, context);
  inside_context = 0;
  return code;
}

static int fails_now(void) {
  if (inside_context) {
    return 0;
  }
  allocations++;
  return countdown > 0 && --countdown == 0;
}

void *__wrap_malloc(size_t size) {
  return fails_now() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails_now() ? NULL : __real_calloc(count, size);
}

static void every_allocation_may_fail(void) {
  char text[256];
  for (int method = BS_ADAMS; method <= BS_TAYLOR; method++) {
    oscillator o = two_masses(0.6);
    o.settings.method = method;
    oscillator_set(&o);
    int failed = 0, k = 1;
    for (; k < 10000; k++) {
      bs_core *core = NULL;
      countdown = k;
      const bs_status status =
          bs_create(&core, &o.problem, &o.settings, o.y0, text);
      const int reached = countdown == 0;
      countdown = 0;
      if (!reached) {
        CHECK(status == BS_OK && core != NULL);
        bs_free(core);
        break;
      }
      /* either it says so, or it did without that memory */
      if (status == BS_OK) {
        bs_free(core);
      } else {
        CHECK(status == BS_NO_MEMORY);
        CHECK(core == NULL);
        failed++;
      }
    }
    CHECK(failed >= 15 && k < 10000);
  }
}

static void a_run_allocates_nothing_of_its_own(void) {
  char text[256];
  bs_core *core = NULL;
  oscillator o = two_masses(0.6);
  o.settings.method = BS_TAYLOR;
  o.y0[0] = 0.5;
  oscillator_set(&o);
  CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == BS_OK);
  notebook *book = notebook_create();
  const long before = allocations;
  CHECK(bs_run(core, 100.0, 1e9, &book->out) == BS_OK);
  CHECK(allocations == before);
  bs_free(core);
  free(book);
}

/* CVODE allocates on its first step: failures there must be clean too. */
static void a_failure_during_the_run_is_clean(void) {
  char text[256];
  for (int k = 1; k < 40; k++) {
    bs_core *core = NULL;
    oscillator o = two_masses(0.6);
    oscillator_set(&o);
    CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == BS_OK);
    notebook *book = notebook_create();
    countdown = k;
    const bs_status status = bs_run(core, 20.0, 1e9, &book->out);
    const int reached = countdown == 0;
    countdown = 0;
    CHECK(status == BS_OK || (reached && status < 0));
    bs_free(core);
    free(book);
  }
}

int main(void) {
  RUN(every_allocation_may_fail);
  RUN(a_run_allocates_nothing_of_its_own);
  RUN(a_failure_during_the_run_is_clean);
  return TEST_RESULT;
}
