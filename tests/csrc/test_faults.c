/* Things made to go wrong: every return code of SUNDIALS, NaN from the
 * right-hand side and from the threshold scan, each at many calls. */
#include <cvode/cvode.h>

#include "oscillator.h"
#include "test.h"

typedef struct {
  int code;
  bs_status status;
} pair;

static const pair CODES[] = {
    {CV_TOO_MUCH_WORK, BS_TOO_MANY_STEPS},
    {CV_TOO_MUCH_ACC, BS_TOO_MUCH_ACCURACY},
    {CV_ERR_FAILURE, BS_ERROR_TEST},
    {CV_CONV_FAILURE, BS_CONVERGENCE},
    {CV_LINIT_FAIL, BS_LINEAR_SOLVER_INIT},
    {CV_LSETUP_FAIL, BS_LINEAR_SOLVER_SETUP},
    {CV_LSOLVE_FAIL, BS_LINEAR_SOLVER_SOLVE},
    {CV_RHSFUNC_FAIL, BS_RIGHT_SIDE},
    {CV_FIRST_RHSFUNC_ERR, BS_RIGHT_SIDE},
    {CV_REPTD_RHSFUNC_ERR, BS_RIGHT_SIDE},
    {CV_UNREC_RHSFUNC_ERR, BS_RIGHT_SIDE},
    {CV_RTFUNC_FAIL, BS_SOLVER_UNKNOWN}, /* CVODE's root finder is not used */
    {CV_NLS_INIT_FAIL, BS_NONLINEAR_SOLVER},
    {CV_NLS_SETUP_FAIL, BS_NONLINEAR_SOLVER},
    {CV_CONSTR_FAIL, BS_CONSTRAINT},
    {CV_NLS_FAIL, BS_NONLINEAR_SOLVER},
    {CV_MEM_FAIL, BS_NO_MEMORY},
    {CV_MEM_NULL, BS_SOLVER_USE},
    {CV_ILL_INPUT, BS_SOLVER_USE},
    {CV_NO_MALLOC, BS_SOLVER_USE},
    {CV_BAD_K, BS_SOLVER_USE},
    {CV_BAD_T, BS_SOLVER_USE},
    {CV_BAD_DKY, BS_SOLVER_USE},
    {CV_TOO_CLOSE, BS_SOLVER_USE},
    {CV_VECTOROP_ERR, BS_VECTOR},
    {CV_CONTEXT_ERR, BS_SOLVER_UNKNOWN},
    {CV_UNRECOGNIZED_ERR, BS_SOLVER_UNKNOWN},
    {-1234, BS_SOLVER_UNKNOWN},
};

/* Run 60 time units with these faults; the run must end with `wanted`, keep
 * what it has, and be freed cleanly. */
static void fails_with(const bs_faults *faults, int method, bs_status wanted) {
  oscillator o = two_masses(0.6);
  bs_core *core = NULL;
  bs_summary seen;
  char text[256];
  double y[4];
  o.y0[0] = 0.5;
  o.settings.method = method;
  oscillator_set(&o);
  CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == BS_OK);
  notebook *book = notebook_create();
  bs_inject(core, faults);
  const bs_status status = bs_run(core, 60.0, 1e9, &book->out);
  if (status != wanted) {
    fprintf(stderr, "code %d call %lld: got %s, wanted %s\n",
            faults->solver_code,
            (long long)(faults->solver_call + faults->bad_rhs_call),
            bs_status_name(status), bs_status_name(wanted));
  }
  CHECK(status == wanted);
  CHECK(bs_run(core, 60.0, 1e9, &book->out) == wanted);
  bs_summarise(core, &seen);
  CHECK(seen.t >= 0.0 && seen.t < 60.0);
  CHECK(seen.events == book->out.events_done);
  bs_state(core, y);
  for (int i = 0; i < 4; i++) {
    CHECK(isfinite(y[i]));
  }
  if (faults->solver_code != 0) {
    CHECK(seen.solver_code == faults->solver_code);
    CHECK(strlen(bs_solver_text(core)) > 0);
  }
  bs_free(core);
  free(book);
}

static void every_code_of_sundials_has_its_status(void) {
  for (size_t i = 0; i < sizeof CODES / sizeof CODES[0]; i++) {
    const bs_faults early = {CODES[i].code, 1, 0, 0};
    const bs_faults late = {CODES[i].code, 500 + 37 * (int64_t)i, 0, 0};
    fails_with(&early, BS_ADAMS, CODES[i].status);
    fails_with(&late, BS_ADAMS, CODES[i].status);
    fails_with(&late, BS_BDF, CODES[i].status);
  }
}

static void nan_from_the_right_side_at_any_call(void) {
  for (int64_t call = 1; call < 1000; call = 1 + call * 5 / 4) {
    const bs_faults faults = {0, 0, call, 0};
    fails_with(&faults, BS_ADAMS, BS_NOT_FINITE);
    fails_with(&faults, BS_BDF, BS_NOT_FINITE);
  }
}

static void nan_from_the_thresholds_at_any_call(void) {
  for (int64_t call = 1; call < 1500; call = 1 + call * 5 / 4) {
    const bs_faults faults = {0, 0, 0, call};
    fails_with(&faults, BS_ADAMS, BS_NOT_FINITE);
  }
}

static void an_infinite_start_is_not_finite(void) {
  oscillator o = two_masses(0.6);
  bs_core *core = NULL;
  char text[256];
  for (int method = BS_ADAMS; method <= BS_TAYLOR; method++) {
    for (int i = 0; i < 4; i++) {
      const double bad[2] = {NAN, INFINITY};
      for (int k = 0; k < 2; k++) {
        memset(o.y0, 0, sizeof o.y0);
        o.y0[i] = bad[k];
        o.settings.method = method;
        oscillator_set(&o);
        CHECK(bs_create(&core, &o.problem, &o.settings, o.y0, text) == BS_OK);
        notebook *book = notebook_create();
        CHECK(bs_run(core, 60.0, 1e9, &book->out) == BS_NOT_FINITE);
        bs_free(core);
        free(book);
      }
    }
  }
}

int main(void) {
  RUN(every_code_of_sundials_has_its_status);
  RUN(nan_from_the_right_side_at_any_call);
  RUN(nan_from_the_thresholds_at_any_call);
  RUN(an_infinite_start_is_not_finite);
  return TEST_RESULT;
}
