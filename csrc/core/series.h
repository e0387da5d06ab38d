/* Local Taylor series of the motion in one mode.
 *
 * The system is linear with harmonic forcing, so the derivatives of any order
 * follow from the state by repeated products with A. The series starts every
 * phase: it knows the order of the zero at the start exactly, where step ends
 * show rounding noise. It is also a method of its own. */
#ifndef BS_SERIES_H
#define BS_SERIES_H

#include "system.h"

enum { BS_SERIES_ORDER = 20 };

typedef struct {
  int32_t n;
  double t0;    /* local time of the expansion */
  double reach; /* the series is used on [t0, t0 + reach] */
  double *c;    /* size (order + 1)*2n: row k is y^(k)(t0)/k! */
  double *f;    /* size (order + 1)*n: the same of F */
} bs_series;

int bs_series_init(bs_series *series, int32_t n);
void bs_series_clear(bs_series *series);

/* Expand about (t0, y0) in `mode`. */
void bs_series_expand(bs_series *series, const bs_system *system, bs_mode mode,
                      double t0, const double *y0);

/* Largest step whose truncation error stays below `share` of the error that
 * rtol*|y| + atol allows; at most `longest`. */
double bs_series_reach(const bs_series *series, double rtol, const double *atol,
                       double share, double longest);

/* y (size 2n) at local time t. */
void bs_series_at(const bs_series *series, double t, double *y);

/* Series of the joint's velocity and its rounding errors, size order + 1. */
void bs_series_velocity(const bs_series *series, const bs_system *system,
                        bs_mode mode, double *value, double *noise);

/* Series of the reaction and its rounding errors, size order + 1. */
void bs_series_reaction(const bs_series *series, const bs_system *system,
                        double *value, double *noise);

#endif
