/* Exact map of a linear system with one Coulomb joint: the whole interface.
 *
 * Between events the state x = (q, q_dot) follows a linear flow with periodic
 * forcing and one constant load c,
 *
 *   x(t) = Re( V a(t) ) + Re sum_h P_h exp(i h Omega t) + X_c c,
 *   a_k(t) = a_k(0) exp(lambda_k t),      a(0) = W (x(0) - forced part).
 *
 * There are two flows. Free joint: N = 2n, c is the friction torque. Held
 * joint: N = 2(n - 1), c is the position at which it is held. Each flow
 * carries the signal that ends its phases: the joint's velocity, or the
 * reaction that holds the joint,
 *
 *   s(t) = row x + Re sum_h D_h exp(i h Omega t) + d_c c.
 *
 * A flow without good eigenvectors (defective, nearly so, at rest or at a
 * resonance) comes as cells instead: the matrix of the extended state
 * y = (in x, 1, c, cos h Omega t .., sin h Omega t ..), its exponential over a
 * cell, and the signal's Taylor rows. Its m is BM_CELLS.
 *
 * All arrays are row-major and belong to the caller; nothing is kept after a
 * call. No function prints, allocates more than its workspace, or calls back.
 */
#ifndef BELTSIM_MAP_H
#define BELTSIM_MAP_H

#include <stdint.h>

typedef enum { BM_STICK = 0, BM_SLIP_POS = 1, BM_SLIP_NEG = -1 } bm_mode;

typedef enum {
  BM_OK = 0,          /* the end of the run was reached                     */
  BM_FULL = 1,        /* the event buffer is full: drain it and go on       */
  BM_NO_MEMORY = -1,  /* the workspace could not be allocated               */
  BM_CHATTER = -2,    /* more events than this system can have              */
  BM_NOT_FINITE = -3, /* the state left the range of double                */
  BM_NO_MODES = -4    /* LAPACK found no eigenvalues                        */
} bm_status;

/* Amplitudes of a flow that comes as cells. */
#define BM_CELLS (-1)
/* Terms of every Taylor series, enough for a cell. */
#define BM_TERMS 32

/* What stands for the modes; Na = N + 2 + 2H reals in the extended state. */
typedef struct {
  double d;                 /* length of a cell: |A| d <= 1               */
  const double *into, *out; /* x to the first N of y and back, transposed */
  const double *A, *E;      /* A d and exp(A d), transposed (Na, Na)      */
  const double *rows;       /* Taylor rows of the signal (BM_TERMS, Na)   */
} bm_cells;

/* One linear flow; m amplitudes, H harmonics, N reals of state. Complex arrays
 * come as separate real and imaginary parts, laid out as the loops read them.
 */
typedef struct {
  int N;        /* reals in the state                         */
  int m;        /* modal amplitudes                           */
  int H;        /* highest harmonic of the forcing            */
  double Omega; /* fundamental frequency                      */
  const double *lambda_re, *lambda_im; /* exponents (m)                      */
  const double *V_re, *V_im; /* amplitudes to state, transposed: (m, N)    */
  const double *W_re, *W_im; /* state to amplitudes, transposed: (N, m)    */
  const double *P_re, *P_im; /* forced response (H + 1, N)                 */
  const double *X_c;         /* response to a unit constant load (N)       */
  const double *row;         /* signal row (N)                             */
  const double *D_re, *D_im; /* direct part of the signal (H + 1)          */
  double d_c;                /* direct part of the constant load           */
  const double *tables;      /* what bm_flow_prepare derives from the rest */
  bm_cells cells;            /* used when m is BM_CELLS                    */
} bm_flow;

/* A run: what is solved, and where it stands. Time is counted in whole
 * periods and a rest, so that phase does not drift over long runs. */
typedef struct {
  const bm_flow *free;   /* joint moving: N = 2n, c = friction torque      */
  const bm_flow *held;   /* joint at rest: N = 2(n - 1), c = its position; */
                         /* saturated law: inside the band, N = 2n, c = 0  */
  double sigma;          /* half width of the band; 0 = set-valued law     */
  int joint;             /* index of the joint among the n coordinates     */
  double Q_m, Q_s;       /* kinetic and static friction torque             */
  double event_limit;    /* events per period that this system can have    */
  int64_t periods;       /* in, out: forcing periods completed             */
  double time;           /* in, out: time since then, below one period     */
  int mode;              /* in, out: a bm_mode, ignored when `started` = 0 */
  int started;           /* in, out: 0 = decide the mode from the state    */
  int first_mode;        /* out: what was decided                          */
  int multiplicity;      /* in, out: order of zero this phase began with   */
  double reaction_scale; /* in, out: largest reaction met, at least Q_s    */
  double *state;         /* in, out: (2n)                                  */
} bm_run;

/* Columns of an event's reals, before its state (2n). */
enum {
  BM_TIME,          /* since the start of the event's period                  */
  BM_TORQUE_BEFORE, /* friction torque just before                            */
  BM_TORQUE_AFTER,  /* and just after                                         */
  BM_MARGIN,        /* distance to the other outcome, see the Python side     */
  BM_TOUCH_TIME,    /* nearest miss within the phase that ends here: its time */
  BM_TOUCH_GAP,     /* after the phase's start, and how near it came          */
  BM_EVENT_REALS
};

/* Columns of an event's integers. */
enum {
  BM_PERIODS,  /* forcing periods completed                              */
  BM_KIND,     /* 0 stick, 1 reverse, 2 slip+, 3 slip-                   */
  BM_MULTIPLE, /* 1: tangent to working precision                        */
  BM_EVENT_INTEGERS
};

typedef struct {
  int64_t capacity;
  int64_t count;     /* in, out: rows filled                           */
  int64_t *integers; /* (capacity, BM_EVENT_INTEGERS)                  */
  double *reals;     /* (capacity, BM_EVENT_REALS + 2n)                */
} bm_events;

/* Reals in a packed flow: the arrays of bm_flow one after the other, then d_c;
 * that many are the caller's. Then room for the tables: `reals` in all. With m
 * BM_CELLS: into, out, A, E, rows, row, D_re, D_im, d_c, d and no tables. */
int64_t bm_flow_inputs(int N, int m, int H);
int64_t bm_flow_reals(int N, int m, int H);

/* Fills the tables of a packed flow whose inputs are set. */
void bm_flow_prepare(double *packed, int N, int m, int H, double Omega);

/* Points `flow` into a prepared flow of that size. */
void bm_flow_unpack(bm_flow *flow, const double *packed, int N, int m, int H,
                    double Omega);

/* The routines of LAPACK that are used, as Fortran has them; the caller hands
 * them in, so that this library links to none. */
typedef struct {
  void (*dgeev)(char *, char *, int *, double *, int *, double *, double *,
                double *, int *, double *, int *, double *, int *, int *);
  void (*dgesv)(int *, int *, double *, int *, int *, double *, int *, int *);
  void (*zgesv)(int *, int *, double *, int *, int *, double *, int *, int *);
} bm_lapack;

/* What a flow is made of; k coordinates, complex numbers as pairs of reals. */
typedef struct {
  int k, H;
  double Omega;
  const double *M, *D, *K; /* (k, k), M and K symmetric                      */
  const double *F;         /* harmonics of the forcing, complex (H + 1, k)   */
  const double *load;      /* a unit of the constant load (k)                */
  const double *row;       /* signal row (2k)                                */
  const double *direct;    /* direct part of the signal, complex (H + 1)     */
  double d_c;              /* direct part of the constant load               */
} bm_system;

/* How far the modes can be trusted. */
typedef struct {
  double condition; /* worst of an eigenvalue, in units of energy           */
  double stiffness; /* condition of K                                        */
  double nearest, nearest_mean; /* least distance of an exponent from a
                                   harmonic, without and with the mean; over
                                   Omega                                     */
} bm_soundness;

/* Fills a packed flow of `m` amplitudes; `packed` has room for 2k of them.
 * What cannot be answered is infinite, in the flow too. */
bm_status bm_modes(const bm_lapack *lapack, const bm_system *of, double *packed,
                   int *m, bm_soundness *sound);

/* How a small change of the state passes through a walk. It is carried in real
 * amplitudes, N of a flow: the real and imaginary part of each complex one and
 * each real one; in cells the first N of y. One change of flow is one matrix.
 * Saturated law: `impact`, `position`, `push`, `kick`, `grip` are zero. */
typedef struct {
  const double *into, *out; /* free flow: state to amplitudes, back (2n, 2n) */
  const double *stick;      /* free amplitudes to held ones (Nh, 2n)         */
  const double *release;    /* and back (2n, Nh)                             */
  const double *place, *velocity; /* the joint's, of free amplitudes (2n)    */
  const double *position;    /* free amplitudes per unit of held place (2n)   */
  const double *impact;      /* held ones per unit of velocity at a stop (Nh) */
  const double *push, *kick; /* free ones per unit of torque jump, and of the
                                joint's acceleration with the rest held (2n) */
  const double *grip;        /* reaction, of held amplitudes (Nh)             */
  double grip_c, mass;       /* reaction per unit of place; the joint's mass  */
} bm_changes;

/* Reals of packed changes: the arrays in that order, then the two numbers. */
int64_t bm_changes_reals(int n, int Nh);
void bm_changes_unpack(bm_changes *changes, const double *packed, int n,
                       int Nh);

/* The joint at an event: m_t = M_qq^-1 M_qt (n - 1), mass = M_tt - M_tq m_t,
 * push = M^-1 e_t (n). */
typedef struct {
  int index;
  double mass;
  const double *m_t, *push;
} bm_joint;

/* Fills packed changes between a free flow and a held one, or a band's. */
bm_status bm_changes_fill(const bm_flow *free_flow, const bm_flow *inner,
                          const bm_joint *joint, double *packed);

/* A walk from the start of a period: its events and both ends. */
typedef struct {
  bm_events events;
  int first_mode, last_mode;
  double length;
} bm_walk;

/* A search for a periodic orbit by shooting over `periods` forcing periods. */
typedef struct {
  double periods;     /* of the walk: half those of the orbit with sign -1  */
  double sign;        /* the orbit ends as sign times its start             */
  double tolerance;   /* residual at which it counts as closed              */
  double settle;      /* > 0: residual to which the motion is followed      */
                      /* before Newton's method may choose another orbit    */
  double residual;    /* in: > 0 when the state is near an orbit; out: left */
  double followed;    /* out: forcing periods walked                        */
  int64_t capacity;   /* of the history                                     */
  int64_t steps;      /* out: states tried; the last fills the history's end */
  double *history;    /* out: their residuals (capacity)                    */
  double *image;      /* out: what the state becomes, sign included (2n)    */
  double *derivative; /* out: of the image, in amplitudes of the free flow  */
  const bm_lapack *lapack; /* for the multipliers, or NULL                   */
  double *multipliers; /* out: eigenvalues of the derivative, complex (2n)   */
  int first_mode, last_mode; /* out: of the last walk                       */
  bm_events events; /* out: its events. When they do not fit, `count` is  */
                    /* above the capacity and none are written            */
} bm_search;

/* Real amplitudes of a flow; bm_orbit needs N of each. */
int bm_flow_amplitudes(const bm_flow *flow);

/* Goes on until `end_periods` and `end_time`, or until a buffer is full. */
bm_status bm_propagate(bm_run *run, int64_t end_periods, double end_time,
                       bm_events *events);

/* From `run->state`, which receives the orbit's state at t = 0, closed or not
 * (see the residual). Only the law and the flows of `run` are read. */
bm_status bm_orbit(const bm_run *run, const bm_changes *changes,
                   bm_search *search);

/* Which phases of a walk a flow has. */
typedef enum { BM_FREE = 0, BM_HELD = 1, BM_BAND = 2 } bm_role;

/* The phases of one flow between two times of a walk. None of what follows is
 * for flows in cells. */
typedef struct {
  bm_role role;
  int joint;
  double Q_m;
  double slope;        /* torque per velocity inside the band                */
  double start, end;   /* of the window; samples have none of their own    */
  const double *state; /* at the walk's start (2n)                           */
} bm_phases;

typedef struct {
  const double *F, *C; /* complex (H + 1, n) and (n, n); NULL: no energies   */
  double *squares;     /* in, out: of each coordinate (n)                    */
  double speed;        /* in, out: of the joint's velocity, squared          */
  double work, loss;   /* in, out: of the forcing, of viscous damping        */
  double slipped;      /* in, out: of the load times the joint's velocity    */
} bm_integrals;

/* Adds the integrals over these phases, exactly. */
bm_status bm_integrate(const bm_flow *flow, const bm_walk *walk,
                       const bm_phases *phases, bm_integrals *of);

typedef struct {
  int64_t count;
  const double *t; /* ascending (count)                                      */
  double *x;       /* out: states (count, 2n), of times within these phases  */
  double *torque;  /* out: friction torque (count)                           */
} bm_samples;

/* States and friction torque at given times. */
bm_status bm_sample(const bm_flow *flow, const bm_walk *walk,
                    const bm_phases *phases, bm_samples *to);

typedef struct {
  int count, first, step; /* orders first + i step, i < count                */
  double *values; /* in, out: state and torque, complex (count, 2n + 1)      */
} bm_coefficients;

/* Adds the integrals of state and friction torque times exp(-i k Omega t). */
bm_status bm_fourier(const bm_flow *flow, const bm_walk *walk,
                     const bm_phases *phases, bm_coefficients *to);

#endif
