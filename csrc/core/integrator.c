#include "integrator.h"

#include <cvode/cvode.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "dense.h"
#include "vector.h"

#if SUNDIALS_VERSION_MAJOR >= 7
#define BS_NO_COMM SUN_COMM_NULL
#else
#define BS_NO_COMM NULL
#endif

struct bs_integrator {
  const bs_system *system;
  bs_mode mode;
  double rtol;
  double longest; /* CVODE's step limit: it must see every harmonic; 0: none */
  SUNContext context;
  void *cvode;
  bs_vector_pool *pool;
  N_Vector y, atol, probe_vector;
  bs_probe probe;
  SUNMatrix matrix;
  SUNLinearSolver linear;
  SUNNonlinearSolver nonlinear;
  bs_status rhs_status; /* why the right-hand side refused */
  int32_t code;
  int started;
  long before[4]; /* counters that a re-initialisation would clear */
  bs_faults faults;
  char text[256];
};

static const char *const SETTING_UP = "setting up CVODE";

/* --- functions called by CVODE ------------------------------------------ */

static int rhs(sunrealtype t, N_Vector y, N_Vector y_dot, void *data) {
  bs_integrator *it = data;
  double *out = N_VGetArrayPointer_Serial(y_dot);
  bs_system_rhs(it->system, it->mode, t, N_VGetArrayPointer_Serial(y), out);
  if (it->faults.bad_rhs_call > 0 && --it->faults.bad_rhs_call == 0) {
    out[0] = NAN;
  }
  double sum = 0.0; /* NaN or Inf anywhere shows in the sum of zeros */
  for (int32_t i = 0; i < 2 * it->system->n; i++) {
    sum += out[i] * 0.0;
  }
  if (sum != 0.0) { /* NaN compares unequal */
    it->rhs_status = BS_NOT_FINITE;
    return -1; /* unrecoverable: CVODE would retry, or loop on NaN */
  }
  return 0;
}

static int jacobian(sunrealtype t, N_Vector y, N_Vector y_dot, SUNMatrix J,
                    void *data, N_Vector a, N_Vector b, N_Vector c) {
  const bs_integrator *it = data;
  const int32_t n = it->system->n;
  const bs_dynamics *dynamics = bs_system_dynamics(it->system, it->mode);
  (void)t, (void)y, (void)y_dot, (void)a, (void)b, (void)c;
  SUNMatZero(J);
  for (int32_t k = 0; k < 2 * n; k++) {
    sunrealtype *column = SUNDenseMatrix_Column(J, k);
    if (k >= n) {
      column[k - n] = 1.0;
    }
    for (int32_t i = 0; i < n; i++) {
      column[n + i] = -dynamics->A[(size_t)k * (size_t)n + (size_t)i];
    }
  }
  return 0;
}

#if SUNDIALS_VERSION_MAJOR >= 7
static void keep_text(int line, const char *function, const char *file,
                      const char *message, SUNErrCode code, void *data,
                      SUNContext context) {
  bs_integrator *it = data;
  (void)line, (void)file, (void)code, (void)context;
  snprintf(it->text, sizeof it->text, "%s: %s", function, message);
}
#else
static void keep_text(int code, const char *module, const char *function,
                      char *message, void *data) {
  bs_integrator *it = data;
  (void)module;
  if (code < 0) {
    snprintf(it->text, sizeof it->text, "%s: %s", function, message);
  }
}
#endif

/* --- return codes -------------------------------------------------------- */

static bs_status status_of(int code) {
  switch (code) {
    case CV_SUCCESS:
    case CV_TSTOP_RETURN:
    case CV_ROOT_RETURN:
    case CV_WARNING: return BS_OK;
    case CV_TOO_MUCH_WORK: return BS_TOO_MANY_STEPS;
    case CV_TOO_MUCH_ACC: return BS_TOO_MUCH_ACCURACY;
    case CV_ERR_FAILURE: return BS_ERROR_TEST;
    case CV_CONV_FAILURE: return BS_CONVERGENCE;
    case CV_LINIT_FAIL: return BS_LINEAR_SOLVER_INIT;
    case CV_LSETUP_FAIL: return BS_LINEAR_SOLVER_SETUP;
    case CV_LSOLVE_FAIL: return BS_LINEAR_SOLVER_SOLVE;
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR: return BS_RIGHT_SIDE;
    case CV_CONSTR_FAIL: return BS_CONSTRAINT;
    case CV_NLS_INIT_FAIL:
    case CV_NLS_SETUP_FAIL:
    case CV_NLS_FAIL: return BS_NONLINEAR_SOLVER;
    case CV_MEM_FAIL: return BS_NO_MEMORY;
    case CV_MEM_NULL:
    case CV_ILL_INPUT:
    case CV_NO_MALLOC:
    case CV_BAD_K:
    case CV_BAD_T:
    case CV_BAD_DKY:
    case CV_TOO_CLOSE: return BS_SOLVER_USE;
    case CV_VECTOROP_ERR: return BS_VECTOR;
    default: return BS_SOLVER_UNKNOWN;
  }
}

/* The linear solver interface numbers its codes anew. */
static bs_status linear_checked(bs_integrator *it, int code) {
  if (code == CVLS_SUCCESS) {
    return BS_OK;
  }
  it->code = code;
  return code == CVLS_MEM_FAIL ? BS_NO_MEMORY : BS_SOLVER_USE;
}

/* Every return code of SUNDIALS of a run passes here, the injected ones too. */
static bs_status checked(bs_integrator *it, int code) {
  if (it->faults.solver_call > 0 && --it->faults.solver_call == 0) {
    code = it->faults.solver_code;
    snprintf(it->text, sizeof it->text, "injected code %d", code);
  }
  bs_status status = status_of(code);
  if (status != BS_OK) {
    it->code = code;
    if (status == BS_RIGHT_SIDE && it->rhs_status != BS_OK) {
      status = it->rhs_status;
    }
  }
  return status;
}

/* --- life cycle ---------------------------------------------------------- */

static bs_status set_up_vectors(bs_integrator *it,
                                const bs_settings *settings) {
  const sunindextype size = 2 * (sunindextype)it->system->n;
  it->pool = bs_vector_pool_create(it->context, size);
  if (it->pool == NULL) {
    return BS_NO_MEMORY;
  }
  it->y = bs_vector_take(it->pool);
  it->atol = bs_vector_take(it->pool);
  it->probe_vector = bs_vector_probe(it->context, &it->probe);
  if (it->probe_vector == NULL) {
    return BS_NO_MEMORY;
  }
  memcpy(N_VGetArrayPointer_Serial(it->atol), settings->atol,
         (size_t)size * sizeof(double));
  return BS_OK;
}

static bs_status set_up_solver(bs_integrator *it, bs_method method) {
  const sunindextype size = 2 * (sunindextype)it->system->n;
  if (method == BS_ADAMS) {
    it->nonlinear = SUNNonlinSol_FixedPoint(it->y, 0, it->context);
    return it->nonlinear == NULL
               ? BS_NO_MEMORY
               : checked(it, CVodeSetNonlinearSolver(it->cvode, it->nonlinear));
  }
  it->matrix = SUNDenseMatrix(size, size, it->context);
  if (it->matrix == NULL) {
    return BS_NO_MEMORY;
  }
  it->linear = SUNLinSol_Dense(it->y, it->matrix, it->context);
  if (it->linear == NULL) {
    return BS_NO_MEMORY;
  }
  bs_dense_speed_up(it->linear);
  bs_status status = linear_checked(
      it, CVodeSetLinearSolver(it->cvode, it->linear, it->matrix));
  if (status == BS_OK) {
    status = linear_checked(it, CVodeSetJacFn(it->cvode, jacobian));
  }
  return status;
}

static bs_status set_up_cvode(bs_integrator *it, const bs_settings *settings) {
  const bs_method method = (bs_method)settings->method;
  bs_status status = set_up_vectors(it, settings);
  if (status != BS_OK) {
    return status;
  }
  it->cvode = CVodeCreate(method == BS_BDF ? CV_BDF : CV_ADAMS, it->context);
  if (it->cvode == NULL) {
    return BS_NO_MEMORY;
  }
#if SUNDIALS_VERSION_MAJOR < 7
  status = checked(it, CVodeSetErrHandlerFn(it->cvode, keep_text, it));
#endif
  if (status == BS_OK) {
    status = checked(it, CVodeInit(it->cvode, rhs, 0.0, it->y));
  }
  if (status == BS_OK) {
    status = checked(it, CVodeSetUserData(it->cvode, it));
  }
  if (status == BS_OK) {
    status = checked(it, CVodeSVtolerances(it->cvode, it->rtol, it->atol));
  }
  if (status == BS_OK) {
    status = checked(it, CVodeSetMaxStep(it->cvode, it->longest));
  }
  return status == BS_OK ? set_up_solver(it, method) : status;
}

bs_status bs_integrator_create(bs_integrator **integrator,
                               const bs_system *system,
                               const bs_settings *settings, char *text) {
  bs_integrator *it = calloc(1, sizeof *it);
  *integrator = NULL;
  if (it == NULL) {
    return BS_NO_MEMORY;
  }
  it->system = system;
  it->rtol = settings->rtol;
  it->longest =
      system->harmonics > 0 ? 0.5 * system->period / system->harmonics : 0.0;
  snprintf(it->text, sizeof it->text, "%s", SETTING_UP);
  bs_status status = BS_NO_MEMORY;
  if (SUNContext_Create(BS_NO_COMM, &it->context) == 0) {
#if SUNDIALS_VERSION_MAJOR >= 7
    SUNContext_ClearErrHandlers(it->context);
    SUNContext_PushErrHandler(it->context, keep_text, it);
#endif
    status = set_up_cvode(it, settings);
  }
  if (status != BS_OK) {
    snprintf(text, 256, "%s", it->text);
    bs_integrator_free(it);
    return status;
  }
  it->text[0] = '\0';
  *integrator = it;
  return BS_OK;
}

void bs_integrator_free(bs_integrator *it) {
  if (it == NULL) {
    return;
  }
  CVodeFree(&it->cvode);
  if (it->linear != NULL) {
    SUNLinSolFree(it->linear);
  }
  if (it->nonlinear != NULL) {
    SUNNonlinSolFree(it->nonlinear);
  }
  if (it->matrix != NULL) {
    SUNMatDestroy(it->matrix);
  }
  if (it->probe_vector != NULL) {
    N_VFreeEmpty(it->probe_vector);
  }
  bs_vector_pool_free(it->pool);
  if (it->context != NULL) {
    SUNContext_Free(&it->context);
  }
  free(it);
}

/* CVodeReInit sets the counters to zero: keep what they had. */
static void read_counters(const bs_integrator *it, long *now) {
  memset(now, 0, 4 * sizeof *now);
  if (it->started) {
    CVodeGetNumRhsEvals(it->cvode, &now[0]);
    CVodeGetNumErrTestFails(it->cvode, &now[1]);
    CVodeGetNumNonlinSolvConvFails(it->cvode, &now[2]);
    if (it->linear != NULL) {
      CVodeGetNumJacEvals(it->cvode, &now[3]);
    }
  }
}

bs_status bs_integrator_restart(bs_integrator *it, bs_mode mode, double t,
                                const double *y, double h) {
  long now[4];
  read_counters(it, now);
  for (int i = 0; i < 4; i++) {
    it->before[i] += now[i];
  }
  it->started = 0;
  it->mode = mode;
  it->rhs_status = BS_OK;
  memcpy(N_VGetArrayPointer_Serial(it->y), y,
         2 * (size_t)it->system->n * sizeof(double));
  bs_status status = checked(it, CVodeReInit(it->cvode, t, it->y));
  if (status == BS_OK) {
    status = checked(it, CVodeSetInitStep(it->cvode, h));
  }
  it->started = status == BS_OK;
  return status;
}

bs_status bs_integrator_step(bs_integrator *it, double *t) {
  sunrealtype reached = 0.0;
  /* the output time only tells CVODE the direction: one internal step */
  bs_status status = checked(it, CVode(it->cvode, *t + it->system->period,
                                       it->y, &reached, CV_ONE_STEP));
  if (status == BS_OK && it->rhs_status != BS_OK) {
    /* the fixed-point corrector takes a refusal for slow convergence */
    status = it->rhs_status;
  }
  if (status != BS_OK) {
    return status;
  }
  if (!(reached > *t)) {
    /* sizes whose squares overflow end in a step of zero */
    return N_VMaxNorm(it->y) < 1e150 ? BS_STUCK_TIME : BS_NOT_FINITE;
  }
  *t = reached;
  return BS_OK;
}

bs_status bs_integrator_at(bs_integrator *it, double t, double *y) {
  bs_status status = checked(it, CVodeGetDky(it->cvode, t, 0, it->y));
  if (status == BS_OK) {
    memcpy(y, N_VGetArrayPointer_Serial(it->y),
           2 * (size_t)it->system->n * sizeof(double));
  }
  return status;
}

bs_status bs_integrator_polynomial(bs_integrator *it, const double *row,
                                   int64_t unit, double *power, int *degree,
                                   double *width) {
  bs_probe *probe = &it->probe;
  sunrealtype h, now;
  bs_status status = checked(it, CVodeGetLastStep(it->cvode, &h));
  if (status == BS_OK) {
    status = checked(it, CVodeGetCurrentTime(it->cvode, &now));
  }
  probe->n = 2 * (int64_t)it->system->n;
  probe->row = row;
  probe->unit = unit;
  probe->count = 0;
  if (status == BS_OK) {
    status = checked(it, CVodeGetDky(it->cvode, now - h, 0, it->probe_vector));
  }
  if (status != BS_OK) {
    return status;
  }
  const int d = probe->count - 1;
  /* terms come from the highest power down, their factors are x^k; x is -1 but
   * for the rounding of now - h, which counts when h is tiny against now */
  const double x = ((now - h) - now) / h;
  for (int k = 0; k <= d; k++) {
    const double expected = pow(x, d - k);
    if (!(fabs(probe->factor[k] - expected) < 1e-6 * fabs(expected))) {
      return BS_INTERNAL;
    }
    power[d - k] = probe->term[k];
  }
  *degree = d;
  *width = h;
  return d >= 0 ? BS_OK : BS_INTERNAL;
}

void bs_integrator_count(const bs_integrator *it, bs_summary *summary) {
  long now[4];
  read_counters(it, now);
  summary->right_sides = it->before[0] + now[0];
  summary->error_test_failures = it->before[1] + now[1];
  summary->convergence_failures = it->before[2] + now[2];
  summary->jacobians = it->before[3] + now[3];
}

const char *bs_integrator_text(const bs_integrator *it) {
  return it->text;
}

int32_t bs_integrator_code(const bs_integrator *it) {
  return it->code;
}

void bs_integrator_inject(bs_integrator *it, const bs_faults *faults) {
  it->faults = *faults;
}

const char *bs_sundials_version(void) {
  return SUNDIALS_VERSION;
}
