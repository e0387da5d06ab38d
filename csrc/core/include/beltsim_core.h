/* beltsim core: n linear coordinates, one dry-friction joint, periodic forcing.
 *
 *     M q'' + (C + G) q' + K q + e_j h(q_j') = f(t)
 *     f(t) = sum_k c_k cos(k Omega t) + s_k sin(k Omega t),  period T = 2
 * pi/Omega
 *
 * Coulomb joint: h = Q_m sgn(v) while v = q_j' is not 0; at v = 0 whatever
 * keeps it at rest, up to Q_s. Saturated joint: h = Q_m clip(v/sigma, -1, 1).
 *
 * This header is the whole interface. Every function that can fail returns a
 * bs_status: 0 and positive codes are news, negative codes are errors. Inputs
 * are const and copied; outputs go to the caller's buffers, whose sizes are
 * stated below. Nothing here prints, exits, or keeps a pointer of the caller's
 * after a function has returned. One handle belongs to one thread at a time;
 * different handles are independent. */
#ifndef BELTSIM_CORE_H
#define BELTSIM_CORE_H

#include <stdint.h>

typedef struct bs_core bs_core;

/* News (>= 0) and errors (< 0) of every function. */
typedef enum {
  BS_OK = 0,           /* done; for bs_run: the stop time is reached */
  BS_EVENTS_FULL = 1,  /* drain the event buffer, then call bs_run again */
  BS_TOUCHES_FULL = 2, /* drain the touch buffer, then call bs_run again */
  BS_SLICE = 3,        /* the time slice is over; call bs_run again */

  BS_BAD_INPUT = -1,       /* an argument that the caller should have refused */
  BS_NO_MEMORY = -2,       /* an allocation failed, ours or SUNDIALS' */
  BS_NOT_DEFINITE = -3,    /* M is not positive definite to working accuracy */
  BS_NOT_FINITE = -4,      /* NaN or Inf in the state or its derivative */
  BS_TOO_MANY_STEPS = -5,  /* budget max_steps is used up */
  BS_TOO_MANY_EVENTS = -6, /* budget max_events is used up */
  BS_CHATTER = -7,         /* an impossible number of events in a short time */
  BS_STUCK_TIME = -8,      /* the step no longer moves the clock: t + h = t */
  BS_TOO_MUCH_ACCURACY = -9, /* CV_TOO_MUCH_ACC */
  BS_ERROR_TEST = -10,       /* CV_ERR_FAILURE: error test failed, h at least */
  BS_CONVERGENCE = -11,      /* CV_CONV_FAILURE */
  BS_LINEAR_SOLVER_INIT = -12,  /* CV_LINIT_FAIL */
  BS_LINEAR_SOLVER_SETUP = -13, /* CV_LSETUP_FAIL */
  BS_LINEAR_SOLVER_SOLVE = -14, /* CV_LSOLVE_FAIL */
  BS_RIGHT_SIDE = -15,       /* CV_RHSFUNC_FAIL and its first-call, repeated and
                                unrecoverable relatives */
  BS_CONSTRAINT = -16,       /* CV_CONSTR_FAIL */
  BS_NONLINEAR_SOLVER = -17, /* CV_NLS_INIT_FAIL, _SETUP_FAIL, CV_NLS_FAIL */
  BS_VECTOR = -18,           /* CV_VECTOROP_ERR */
  BS_SOLVER_USE = -19, /* CV_ILL_INPUT, CV_BAD_*, CV_TOO_CLOSE, CV_NO_MALLOC */
  BS_SOLVER_UNKNOWN = -20, /* any other code of SUNDIALS */
  BS_INTERNAL = -21,       /* a promise inside the core was broken */
  BS_OUT_OF_TIME = -22     /* for callers that keep a budget of wall time */
} bs_status;

/* Mode of the joint: the sign of its velocity, or no joint at all. For the
 * saturated law BS_STICK means: inside the band. */
typedef enum {
  BS_STICK = 0,
  BS_SLIP_POS = 1,
  BS_SLIP_NEG = -1,
  BS_FREE = 2
} bs_mode;

typedef enum {
  BS_EVENT_STICK = 0,
  BS_EVENT_REVERSE = 1,
  BS_EVENT_SLIP_POS = 2,
  BS_EVENT_SLIP_NEG = 3
} bs_kind;

typedef enum { BS_SIMPLE = 0, BS_NEAR_GRAZING = 1, BS_MULTIPLE = 2 } bs_quality;

typedef enum { BS_NO_FRICTION = 0, BS_COULOMB = 1, BS_SATURATED = 2 } bs_law;

typedef enum { BS_ADAMS = 0, BS_BDF = 1, BS_TAYLOR = 2 } bs_method;

/* What to integrate. Matrices are row-major. */
typedef struct {
  int32_t n;         /* coordinates, >= 1 */
  int32_t joint;     /* index of the friction coordinate; ignored without law */
  int32_t harmonics; /* H >= 0 */
  int32_t law;       /* bs_law */
  double Omega;      /* > 0 */
  double Q_m, Q_s;   /* Coulomb; Q_m alone for the saturated law */
  double sigma;      /* half width of the band; saturated law only */
  const double *M, *C, *G, *K; /* size n*n each */
  const double *f_cos, *f_sin; /* size (H + 1)*n each, row k: harmonic k */
} bs_problem;

typedef struct {
  double rtol;
  const double *atol;       /* size 2n: coordinates, then velocities; all > 0 */
  int32_t method;           /* bs_method */
  int64_t max_steps;        /* internal steps of the whole run */
  int64_t max_events;       /* events of the whole run */
  double events_per_period; /* more than this is chatter */
  double grazing; /* touches below this share of the peak are reported */
} bs_settings;

/* One event takes BS_EVENT_VALUES doubles, in this order. */
enum {
  BS_EVENT_T = 0,    /* absolute time */
  BS_EVENT_POSITION, /* coordinate of the joint */
  BS_EVENT_BEFORE,   /* friction torque just before */
  BS_EVENT_AFTER,    /* friction torque just after */
  BS_EVENT_REACTION, /* torque that would hold the joint here */
  BS_EVENT_RATE,     /* rate of the threshold function through zero */
  BS_EVENT_DEPTH,    /* how far beyond the threshold the function would go
                        before it turns back; HUGE_VAL when it does not */
  BS_EVENT_VALUES
};

/* One touch takes BS_TOUCH_VALUES doubles. */
enum {
  BS_TOUCH_T = 0,
  BS_TOUCH_DISTANCE, /* from the threshold, >= 0 */
  BS_TOUCH_MODE,     /* bs_mode it happened in */
  BS_TOUCH_VALUES
};

/* Where bs_run writes. The caller resets `*_done` when it has drained. */
typedef struct {
  int64_t n_samples;
  int64_t samples_done;   /* in and out */
  const double *sample_t; /* size n_samples: absolute, not decreasing */
  double *sample_state;   /* size n_samples*2n */
  double *sample_torque;  /* size n_samples */
  int64_t event_capacity; /* >= 1 */
  int64_t events_done;    /* in and out */
  double *event_values;   /* size event_capacity*BS_EVENT_VALUES */
  int32_t *event_codes;   /* size event_capacity*2: bs_kind, bs_quality */
  double *event_states;   /* size event_capacity*2n, or NULL */
  int64_t touch_capacity; /* >= 1 */
  int64_t touches_done;   /* in and out */
  double *touch_values;   /* size touch_capacity*BS_TOUCH_VALUES */
} bs_output;

/* What is known at any time, after an error too. */
typedef struct {
  double t;             /* absolute time reached */
  int32_t mode;         /* bs_mode there */
  int32_t initial_mode; /* bs_mode at t = 0 */
  int64_t events;       /* so far */
  double last_event_t;  /* NaN before the first */
  int32_t last_event_kind;
  int32_t solver_code;  /* last code of SUNDIALS that was an error, or 0 */
  int64_t steps;        /* internal steps, series steps included */
  int64_t series_steps; /* of them by the local series */
  int64_t right_sides;  /* evaluations asked for by CVODE */
  int64_t error_test_failures;
  int64_t convergence_failures;
  int64_t jacobians;
  int64_t restarts;
  double velocity_peak;        /* largest |v| of the joint at step ends */
  double reaction_peak;        /* largest |reaction| at events and in stick */
  double forcing_work;         /* integral of f.q' over the window */
  double viscous_loss;         /* integral of q''C q' over the window */
  double window_friction_loss; /* integral of h v over the window */
  double friction_loss; /* integral of h v over the run; saturated law only */
} bs_summary;

/* Faults for tests: make the next things go wrong. All zero: none. */
typedef struct {
  int32_t solver_code;   /* pretend that SUNDIALS returned this ... */
  int64_t solver_call;   /* ... at this call from now (1: the next) */
  int64_t bad_rhs_call;  /* NaN from this right-hand side (1: the next) */
  int64_t bad_root_call; /* NaN from this threshold scan (1: the next) */
} bs_faults;

/* Life cycle. bs_create copies what it needs; `y0` has size 2n. On failure
 * *core is NULL and `text` (size >= 256) says why. bs_free(NULL) is fine. */
bs_status bs_create(bs_core **core, const bs_problem *problem,
                    const bs_settings *settings, const double *y0, char *text);
void bs_free(bs_core *core);

/* Everything from `start` (absolute) on is integrated into the window. Call
 * before the first bs_run. */
void bs_set_window(bs_core *core, double start);

/* Advance to the absolute time `t_stop`, at most `seconds` of wall time. */
bs_status bs_run(bs_core *core, double t_stop, double seconds,
                 bs_output *output);

/* Stop a run from another thread or a signal handler: bs_run returns BS_SLICE
 * at the next step. Cleared when bs_run starts. */
void bs_cancel(bs_core *core);

/* State at the time reached and at the window's start, size 2n each. The
 * latter is NaN until the run has passed it. */
void bs_state(const bs_core *core, double *y);
void bs_window_state(const bs_core *core, double *y);
void bs_summarise(const bs_core *core, bs_summary *summary);

/* Text that SUNDIALS gave with its last error; "" when there is none. */
const char *bs_solver_text(const bs_core *core);

/* Name ("BS_CHATTER") and one sentence of advice for each status. */
const char *bs_status_name(bs_status status);
const char *bs_status_text(bs_status status);

/* Version of SUNDIALS this was compiled against, such as "6.4.1". */
const char *bs_sundials_version(void);

/* Tests only. */
void bs_inject(bs_core *core, const bs_faults *faults);

#endif /* BELTSIM_CORE_H */
