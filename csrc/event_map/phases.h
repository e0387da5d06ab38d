/* The phases of a recorded walk that belong to one flow. */
#ifndef BM_PHASES_H
#define BM_PHASES_H

#include "flow.h"

/* A phase, or the part of it within a window. Zeros but for `rest` before the
 * first one. */
typedef struct {
  int64_t next;    /* number of the phase after this one                */
  int mode;        /* of this phase                                     */
  double start;    /* of the phase, since the start of the walk         */
  double begin;    /* and since the start of its period                 */
  double end;      /* of the phase, since the start of the walk         */
  double from, to; /* part of it, since its start                       */
  double load;     /* its constant                                      */
  const double *x; /* the flow's state where it begins                  */
  double *rest;    /* room for it (2n)                                  */
} bm_stretch;

/* Coordinates of the whole system. */
int bm_coordinates(const bm_flow *flow, const bm_phases *phases);

/* Moves on to the next phase of this flow; 0 when there is none. */
int bm_next_stretch(const bm_walk *walk, const bm_phases *phases, int n,
                    double Omega, bm_stretch *at);

/* The whole state (2n) from that of the phase's flow. */
void bm_whole_state(const bm_phases *phases, const bm_stretch *at, int n,
                    const double *x, double *whole);

/* Integral of exp(s tau) over (0, d), s = a + ib, exp(s d) = er + i ei. */
void bm_integral(double a, double b, double d, double er, double ei, double *re,
                 double *im);

#endif
