/* Names and texts of the status codes: one table, used for both. */
#include <stddef.h>

#include "beltsim_core.h"

typedef struct {
  bs_status status;
  const char *name;
  const char *text;
} status_row;

#define ROW(code, text) \
  { code, #code, text }

static const status_row table[] = {
    ROW(BS_OK, "done"),
    ROW(BS_EVENTS_FULL, "the event buffer is full; drain it and go on"),
    ROW(BS_TOUCHES_FULL, "the touch buffer is full; drain it and go on"),
    ROW(BS_SLICE, "the time slice is over; go on"),
    ROW(BS_BAD_INPUT, "an argument is out of its range"),
    ROW(BS_NO_MEMORY,
        "out of memory; ask for fewer samples or free some memory"),
    ROW(BS_NOT_DEFINITE,
        "the mass matrix is not positive definite to working accuracy; check "
        "its rows for missing or repeated inertia"),
    ROW(BS_NOT_FINITE,
        "the motion is no longer finite; check the stability of the linear "
        "system (eigenvalues with a positive real part)"),
    ROW(BS_TOO_MANY_STEPS,
        "the step budget is used up; raise max_steps, loosen rtol or run "
        "fewer periods"),
    ROW(BS_TOO_MANY_EVENTS,
        "the event budget is used up; raise max_events or run fewer periods"),
    ROW(BS_CHATTER,
        "more stick-slip events than this system can have; the tolerance is "
        "too loose for the band or the input is wrong"),
    ROW(BS_STUCK_TIME,
        "the step is too small to move the clock; check the units of the "
        "problem or loosen rtol"),
    ROW(BS_TOO_MUCH_ACCURACY,
        "the tolerance is tighter than double precision allows; loosen rtol"),
    ROW(BS_ERROR_TEST,
        "the error test failed at the smallest step; loosen rtol"),
    ROW(BS_CONVERGENCE,
        "the corrector did not converge at the smallest step; try method "
        "\"bdf\""),
    ROW(BS_LINEAR_SOLVER_INIT, "the linear solver could not be started"),
    ROW(BS_LINEAR_SOLVER_SETUP,
        "the iteration matrix could not be factorised; loosen rtol"),
    ROW(BS_LINEAR_SOLVER_SOLVE, "the linear solver failed"),
    ROW(BS_RIGHT_SIDE, "the right-hand side failed"),
    ROW(BS_CONSTRAINT, "an inequality constraint failed"),
    ROW(BS_NONLINEAR_SOLVER, "the nonlinear solver failed"),
    ROW(BS_VECTOR, "a vector operation failed"),
    ROW(BS_SOLVER_USE, "SUNDIALS refused an input"),
    ROW(BS_SOLVER_UNKNOWN, "SUNDIALS returned a code unknown to this version"),
    ROW(BS_INTERNAL, "a promise inside the core was broken; please report it"),
    ROW(BS_OUT_OF_TIME,
        "the time budget is used up; raise max_seconds, loosen rtol or run "
        "fewer periods"),
};

static const status_row *find(bs_status status) {
  for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
    if (table[i].status == status) {
      return &table[i];
    }
  }
  return NULL;
}

const char *bs_status_name(bs_status status) {
  const status_row *row = find(status);
  return row ? row->name : "BS_UNKNOWN";
}

const char *bs_status_text(bs_status status) {
  const status_row *row = find(status);
  return row ? row->text : "unknown status";
}
