/* A linear flow in its modes, and the signal that watches a phase. */
#ifndef BM_FLOW_H
#define BM_FLOW_H

#include "beltsim_map.h"
#include "signal.h"

/* A flow with its signal tabulated and room for one phase's amplitudes. */
typedef struct {
  const bm_flow *flow;
  bm_signal signal;
  double *ar, *ai;       /* amplitudes at the start of the phase (m)          */
  const double *gr, *gi; /* signal per unit amplitude (m)                    */
  const double *sr, *si; /* signal of the forced response (H + 1)            */
  double s_c;            /* signal per unit constant load                     */
  double *rest;          /* scratch (N)                                       */
  double *memory;        /* the one block behind what is written              */
} bm_watch;

int bm_watch_create(bm_watch *watch, const bm_flow *flow);
void bm_watch_free(bm_watch *watch);

/* Begins a phase at `time` in the period, in state x (N), under load c. */
void bm_watch_begin(bm_watch *watch, double time, double c, const double *x);

/* State x (N) of the present phase tau after its start at `time`. */
void bm_watch_state(const bm_watch *watch, double time, double c, double tau,
                    double *x);

/* Signal in state x (N) at `time` under load c. */
double bm_flow_signal(const bm_flow *flow, double time, double c,
                      const double *x);

/* The state x (2n) without the joint. */
void bm_without_joint(int n, int joint, const double *x, double *rest);

#endif
