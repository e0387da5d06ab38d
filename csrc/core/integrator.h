/* CVODE's life cycle: created once, re-initialised at every event. */
#ifndef BS_INTEGRATOR_H
#define BS_INTEGRATOR_H

#include "system.h"

typedef struct bs_integrator bs_integrator;

bs_status bs_integrator_create(bs_integrator **integrator,
                               const bs_system *system,
                               const bs_settings *settings, char *text);
void bs_integrator_free(bs_integrator *integrator);

/* Forget the past and go on in `mode` from (t, y), first step `h`. */
bs_status bs_integrator_restart(bs_integrator *integrator, bs_mode mode,
                                double t, const double *y, double h);

/* One internal step; *t is the time reached. */
bs_status bs_integrator_step(bs_integrator *integrator, double *t);

/* State (size 2n) anywhere in the last step, by the solver's own interpolant.
 */
bs_status bs_integrator_at(bs_integrator *integrator, double t, double *y);

/* The interpolant of row.y (row = NULL: of y[unit]) over the last step [a, b],
 * as a polynomial in x = (t - b)/(b - a), x in [-1, 0]: `power` (size 16) and
 * *degree. *width = b - a. */
bs_status bs_integrator_polynomial(bs_integrator *integrator, const double *row,
                                   int64_t unit, double *power, int *degree,
                                   double *width);

/* Adds the counters of CVODE to the summary. */
void bs_integrator_count(const bs_integrator *integrator, bs_summary *summary);
const char *bs_integrator_text(const bs_integrator *integrator);
int32_t bs_integrator_code(const bs_integrator *integrator);
void bs_integrator_inject(bs_integrator *integrator, const bs_faults *faults);

#endif
