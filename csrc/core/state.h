/* What a run knows: shared by core.c, phase.c and record.c, by nobody else. */
#ifndef BS_STATE_H
#define BS_STATE_H

#include <signal.h>

#include "beltsim_core.h"
#include "integrator.h"
#include "series.h"
#include "system.h"

enum { BS_RECENT = 100, BS_MINIMA = 4 };

/* Where the motion of the current stretch of time comes from. */
typedef enum { BS_NOTHING = 0, BS_FROM_SERIES, BS_FROM_STEP } bs_source;

/* A stretch of one mode on which the motion is known: one step, cut short at
 * the first crossing of a threshold. */
typedef struct {
  bs_source source;
  double start, end; /* local times; `end` is the crossing where there is one */
  double step_end;   /* end of the whole step */
  int crossing;      /* a threshold is reached at `end` */
  int side;          /* stick: +1 or -1, the limit that is reached */
  double rate;       /* of the threshold function there, < 0 */
  double depth;      /* how far below zero it would go; HUGE_VAL: for good */
  int n_touches;     /* minima close to zero, in order */
  double touch_t[BS_MINIMA], touch_distance[BS_MINIMA];
} bs_stretch;

struct bs_core {
  bs_system system;
  bs_settings settings; /* atol: own copy */
  double *atol;
  bs_series series, held; /* of the motion; of the joint held at rest */
  bs_integrator *integrator;
  bs_summary summary;
  bs_status failure; /* sticky: an error stays */
  volatile sig_atomic_t cancelled;
  bs_faults faults;

  double base; /* whole periods before local time 0 */
  double t;    /* local time consumed */
  bs_mode mode;
  double *y;       /* size 2n: state at a start or an event */
  double *scratch; /* size 2n */
  bs_stretch stretch;
  int restart;            /* the next stretch begins with a series at (t, y) */
  int zero_order;         /* order of the zero known at the start: 0, 1 or 2 */
  int limit_side;         /* stick: the start lies on this limit; 0: on none */
  double slope_before[2]; /* of the threshold functions at the last end */

  double window_start;  /* absolute; HUGE_VAL: none */
  double *window_state; /* size 2n */
  int window_open;

  double recent[BS_RECENT]; /* local times of the last events and touches */
  double recent_base[BS_RECENT]; /* and their whole periods; a ring */
  int recent_count;
  double crowd_period; /* period number of `crowd` */
  double crowd;        /* events in it */
};

/* Time conversions: absolute = base periods + local, each rounded once. */
double bs_state_absolute(const bs_core *core, double local);
double bs_state_local(const bs_core *core, double absolute);

/* phase.c: motion on the current stretch, and the next stretch. */
bs_status bs_phase_at(bs_core *core, double t, double *y);
bs_status bs_phase_next(bs_core *core);

/* record.c: samples, touches and integrals on the stretch up to `limit`. */
bs_status bs_record_until(bs_core *core, double limit, bs_output *output);
void bs_record_event(bs_core *core, bs_kind kind, bs_quality quality,
                     const double *values, bs_output *output);

#endif
