/* A real sum of complex exponentials and its first exit from an interval. */
#ifndef BM_SIGNAL_H
#define BM_SIGNAL_H

#include "beltsim_map.h"

/* Cells have the lengths base 2^-level, level = 0 .. BM_LEVELS - 1. */
#define BM_LEVELS 30

/* f(tau) = offset + Re sum_k w_k exp(lambda_k tau), tau from the cell start */
typedef struct {
  int K;       /* exponentials, filled up with zeros to a multiple of 4 */
  double base; /* length of a cell at level 0                         */
  double offset;
  int series_level; /* first level whose cells suit the Taylor series      */
  const double *lr, *li; /* exponents (K)                                    */
  const double *er, *ei; /* exp(lambda base 2^-level), (BM_LEVELS, K)        */
  const double *bound;   /* factor of |w_k| in the Hermite error, likewise   */
  double *wr, *wi; /* coefficients at the start of the present cell (K)   */
  double *pr, *pi; /* scratch (K)                                         */
  const bm_cells *cells; /* not NULL: f = rows[0] wr, wr the extended state  */
} bm_signal;

typedef struct {
  double tau;        /* time of the exit, or the limit asked for            */
  int side;          /* -1 through lo, +1 through hi, 0 none                */
  int multiple;      /* the exit is tangent to working precision            */
  double margin;     /* closest approach of an extremum that was no exit    */
  double margin_tau; /* and its time                                        */
} bm_exit;

/* Fills er, ei and bound, (BM_LEVELS, K) each, for the exponents lr, li (K). */
void bm_signal_tabulate(int K, double base, const double *lr, const double *li,
                        double *er, double *ei, double *bound);

/* First level whose cells suit the Taylor series. */
int bm_signal_series_level(int K, double base, const double *lr,
                           const double *li);

/* First tau in (0, limit] at which f leaves (lo, hi). `multiplicity` is the
 * order of the zero of f - lo (`side` -1) or f - hi (`side` +1) at tau = 0. */
bm_exit bm_signal_exit(bm_signal *f, double lo, double hi, double limit,
                       int multiplicity, int side);

/* Rate of f at the start of the present cell. */
double bm_signal_slope(const bm_signal *f);

#endif
