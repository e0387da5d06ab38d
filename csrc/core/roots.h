/* Roots and minima of a polynomial on [0, 1], found and not sampled.
 *
 * In Bernstein form a polynomial lies in the hull of its coefficients and has
 * no more roots than they have sign changes. Halving the interval until there
 * is none or exactly one finds every crossing, two inside one step as well,
 * down to rounding. Plain C, no solver in here. */
#ifndef BS_ROOTS_H
#define BS_ROOTS_H

enum { BS_ROOTS_DEGREE = 40 };

/* Bernstein coefficients (size degree + 1) of sum_k power[k] x^k on [0, 1]. */
void bs_roots_bernstein(int degree, const double *power, double *bernstein);

/* power <- coefficients of p(at + x*width), in place. */
void bs_roots_shift(int degree, double *power, double at, double width);

/* First x in [0, 1] where a polynomial that is positive before it reaches
 * zero. Returns 1 and sets *x, or 0 when it stays positive. A polynomial that
 * starts at or below zero has its root at 0; one that is zero throughout has
 * none. Roots that only rounding could tell from a touch are not returned. */
int bs_roots_first(int degree, const double *bernstein, double *x);

/* Minima inside (0, 1) with p < limit: writes at most `capacity` of them, in
 * order, and returns how many. */
int bs_roots_minima(int degree, const double *bernstein, double limit,
                    int capacity, double *x, double *value);

/* p, p' and p'' at x. */
void bs_roots_value(int degree, const double *bernstein, double x, double *p,
                    double *slope, double *curvature);

#endif
