/* The friction law: torque by mode, and the rule that changes modes. */
#ifndef BS_FRICTION_H
#define BS_FRICTION_H

#include "beltsim_core.h"

typedef struct {
  bs_law law;
  double Q_m, Q_s, sigma;
} bs_friction;

/* Constant part of the torque in a mode: +-Q_m while slipping, else 0. */
double bs_friction_level(const bs_friction *friction, bs_mode mode);

/* Mode of a Coulomb joint whose velocity is zero, from the reaction that would
 * hold it and its derivatives.
 *
 *   |R| < Q_s              stick
 *   |R| > Q_s              slip in the direction of R
 *   |R| = Q_s to rounding  the first derivative of R that is not zero to
 *                          rounding: growing |R| slips, falling |R| sticks;
 *                          none: stick
 *
 * series[k] is the k-th derivative over k! of the reaction of the *held*
 * system, noise[k] >= 0 its rounding error, k = 0..order. With `on_limit` the
 * caller knows that |R| = Q_s, whatever rounding says. */
bs_mode bs_friction_mode_at_rest(const bs_friction *friction,
                                 const double *series, const double *noise,
                                 int order, int on_limit);

/* Kind of the event that leads from one mode to another.
 *
 *   from \ to   stick    slip+    slip-
 *   stick       -        slip+    slip-
 *   slip+       stick    -        reverse
 *   slip-       stick    reverse  -
 *
 * Returns 0 and sets *kind, or -1 where there is no event. */
int bs_friction_kind(bs_mode from, bs_mode to, bs_kind *kind);

#endif
