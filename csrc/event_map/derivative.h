/* The exact derivative of the map over a recorded walk. */
#ifndef BM_DERIVATIVE_H
#define BM_DERIVATIVE_H

#include "flow.h"

/* Room for the derivative of systems of one size. */
typedef struct {
  bm_watch held; /* for the rate of the reaction                            */
  double *S;     /* derivative of the present amplitudes (at most Na, 2n)   */
  double *next;  /* scratch of that size                                    */
  double *place; /* derivative of the joint's place while it is held (2n)   */
  double *row;   /* scratch (2n)                                            */
  double *rest;  /* state without the joint                                 */
  double *cells; /* scratch of flows in cells, or NULL                      */
  int fresh;     /* S is the identity still: it stands for the modes of the */
  double moved;  /* free flow over this time, the walk's first phase        */
} bm_carrier;

int bm_carrier_create(bm_carrier *carrier, const bm_run *run);
void bm_carrier_free(bm_carrier *carrier);

/* carrier->S (2n, 2n): free amplitudes at the end per free amplitude at the
 * start. */
void bm_carry(bm_carrier *carrier, const bm_run *run, const bm_changes *changes,
              const bm_walk *walk);

#endif
