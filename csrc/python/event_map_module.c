/* beltsim._event_map: the exact map for Python. Limited API, buffers only. */
#include <string.h>

#include "beltsim_map.h"
#include "event_map_buffers.h"

/* Columns of `reals` and `integers`, in and out. */
enum {
  R_OMEGA,
  R_Q_M,
  R_Q_S,
  R_EVENT_LIMIT,
  R_TIME,
  R_REACTION_SCALE,
  R_SIGMA,
  R_COUNT
};
enum {
  I_JOINT,
  I_PERIODS,
  I_MODE,
  I_STARTED,
  I_MULTIPLICITY,
  I_FIRST_MODE,
  I_COUNT
};

/* Columns of `search`, in and out. */
enum {
  S_PERIODS,
  S_SIGN,
  S_TOLERANCE,
  S_RESIDUAL,
  S_FOLLOWED,
  S_SETTLE,
  S_COUNT
};

static void pack(const bm_run *run, double *reals, int64_t *integers) {
  reals[R_TIME] = run->time;
  reals[R_REACTION_SCALE] = run->reaction_scale;
  integers[I_PERIODS] = run->periods;
  integers[I_MODE] = run->mode;
  integers[I_STARTED] = run->started;
  integers[I_MULTIPLICITY] = run->multiplicity;
  integers[I_FIRST_MODE] = run->first_mode;
}

static void unpack(bm_run *run, const double *reals, const int64_t *integers) {
  run->joint = (int)integers[I_JOINT];
  run->Q_m = reals[R_Q_M];
  run->Q_s = reals[R_Q_S];
  run->sigma = reals[R_SIGMA];
  run->event_limit = reals[R_EVENT_LIMIT];
  run->time = reals[R_TIME];
  run->reaction_scale = reals[R_REACTION_SCALE];
  run->periods = integers[I_PERIODS];
  run->mode = (int)integers[I_MODE];
  run->started = (int)integers[I_STARTED];
  run->multiplicity = (int)integers[I_MULTIPLICITY];
  run->first_mode = (int)integers[I_FIRST_MODE];
}

/* Sizes of a run, the leading arguments of what walks. */
typedef struct {
  int n, H, m_free, m_held, saturated;
} sizes;

static int inner_reals(const sizes *of) {
  return of->saturated ? 2 * of->n : 2 * of->n - 2;
}

static int sizes_hold(const sizes *of) {
  if (of->n >= 1 && of->n <= MOST_COORDINATES && of->H >= 0 &&
      of->H <= MOST_COORDINATES && of->m_free >= BM_CELLS &&
      of->m_free <= 2 * of->n && of->m_held >= BM_CELLS &&
      of->m_held <= 2 * of->n) {
    return 1;
  }
  PyErr_Format(PyExc_ValueError, "sizes out of range: n %d, H %d, m %d, %d",
               of->n, of->H, of->m_free, of->m_held);
  return 0;
}

/* The buffers with which every walk begins: free, held, reals, integers, state
 */
enum { FREE, HELD, REALS, INTEGERS, STATE, RUN_BUFFERS };

static void run_buffers(const sizes *of, wanted *kinds) {
  Py_ssize_t free_reals =
      (Py_ssize_t)bm_flow_reals(2 * of->n, of->m_free, of->H);
  Py_ssize_t held_reals =
      (Py_ssize_t)bm_flow_reals(inner_reals(of), of->m_held, of->H);
  kinds[FREE] = (wanted){"free", "d", 0, free_reals};
  kinds[HELD] = (wanted){"held", "d", 0, held_reals};
  kinds[REALS] = (wanted){"reals", "d", 1, R_COUNT};
  kinds[INTEGERS] = (wanted){"integers", "q", 1, I_COUNT};
  kinds[STATE] = (wanted){"state", "d", 1, 2 * of->n};
}

/* The run that these buffers describe; 0 with an exception. */
static int run_of(const sizes *of, void **data, bm_flow *free_flow,
                  bm_flow *held_flow, bm_run *run) {
  const double *reals = data[REALS];
  const int64_t *integers = data[INTEGERS];
  if (integers[I_JOINT] < 0 || integers[I_JOINT] >= of->n ||
      !(reals[R_OMEGA] > 0.0) || of->saturated != (reals[R_SIGMA] > 0.0)) {
    PyErr_Format(PyExc_ValueError,
                 "joint out of range, Omega <= 0 or sigma against the law");
    return 0;
  }
  double Omega = reals[R_OMEGA];
  bm_flow_unpack(free_flow, data[FREE], 2 * of->n, of->m_free, of->H, Omega);
  bm_flow_unpack(held_flow, data[HELD], inner_reals(of), of->m_held, of->H,
                 Omega);
  run->free = free_flow;
  run->held = held_flow;
  run->state = data[STATE];
  unpack(run, reals, integers);
  return 1;
}

/* propagate(n, H, m_free, m_held, saturated, free, held, reals, integers,
 * state, event_integers, event_reals, capacity, count, end_periods, end_time)
 *   -> (status, count) */
static PyObject *propagate(PyObject *self, PyObject *args) {
  (void)self;
  enum { EVENT_INTEGERS = RUN_BUFFERS, EVENT_REALS, BUFFERS };
  sizes of;
  long long capacity, count, end_periods;
  double end_time;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  wanted kinds[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iiiiiOOOOOOOLLLd", &of.n, &of.H, &of.m_free,
                        &of.m_held, &of.saturated, &objects[0], &objects[1],
                        &objects[2], &objects[3], &objects[4], &objects[5],
                        &objects[6], &capacity, &count, &end_periods,
                        &end_time) ||
      !sizes_hold(&of)) {
    return NULL;
  }
  if (capacity < 1 || capacity > 1000000000 || count < 0 || count > capacity) {
    return PyErr_Format(PyExc_ValueError,
                        "sizes out of range: capacity %lld, count %lld",
                        capacity, count);
  }
  run_buffers(&of, kinds);
  kinds[EVENT_INTEGERS] = (wanted){"event_integers", "q", 1,
                                   (Py_ssize_t)capacity * BM_EVENT_INTEGERS};
  kinds[EVENT_REALS] =
      (wanted){"event_reals", "d", 1,
               (Py_ssize_t)capacity * (BM_EVENT_REALS + 2 * of.n)};
  if (!take(BUFFERS, objects, kinds, views, data)) {
    return NULL;
  }
  bm_flow free_flow, held_flow;
  bm_run run;
  if (!run_of(&of, data, &free_flow, &held_flow, &run)) {
    release(views, BUFFERS);
    return NULL;
  }
  bm_events events = {capacity, count, data[EVENT_INTEGERS], data[EVENT_REALS]};
  bm_status status;
  Py_BEGIN_ALLOW_THREADS;
  status = bm_propagate(&run, end_periods, end_time, &events);
  Py_END_ALLOW_THREADS;
  pack(&run, data[REALS], data[INTEGERS]);
  release(views, BUFFERS);
  return Py_BuildValue("iL", (int)status, (long long)events.count);
}

/* The routines of LAPACK, from the capsules that SciPy publishes. */
static bm_lapack lapack;

/* A routine whose C signature begins as `begins`: 32-bit integers. */
static void *routine(PyObject *capsule, const char *begins) {
  if (!PyCapsule_CheckExact(capsule)) {
    return PyErr_Format(PyExc_TypeError, "a routine must come as a capsule");
  }
  const char *name = PyCapsule_GetName(capsule);
  if (!name || strncmp(name, begins, strlen(begins)) != 0) {
    return PyErr_Format(PyExc_TypeError,
                        "a routine of type '%s', must begin "
                        "with '%s'",
                        name ? name : "", begins);
  }
  return PyCapsule_GetPointer(capsule, name);
}

/* use_lapack(dgeev, dgesv, zgesv): what `modes` and `orbit` call */
static PyObject *use_lapack(PyObject *self, PyObject *args) {
  (void)self;
  PyObject *dgeev, *dgesv, *zgesv;
  if (!PyArg_ParseTuple(args, "OOO", &dgeev, &dgesv, &zgesv)) {
    return NULL;
  }
  void *found[] = {routine(dgeev, "void (char *, char *, int *, "), NULL, NULL};
  found[1] = found[0] ? routine(dgesv, "void (int *, int *, ") : NULL;
  found[2] = found[1] ? routine(zgesv, "void (int *, int *, ") : NULL;
  if (!found[2]) {
    return NULL;
  }
  /* through memory: ISO C does not convert object to function pointers */
  memcpy(&lapack.dgeev, &found[0], sizeof found[0]);
  memcpy(&lapack.dgesv, &found[1], sizeof found[1]);
  memcpy(&lapack.zgesv, &found[2], sizeof found[2]);
  Py_RETURN_NONE;
}

static int have_lapack(void) {
  if (lapack.zgesv) {
    return 1;
  }
  PyErr_Format(PyExc_RuntimeError, "call use_lapack first");
  return 0;
}

/* orbit(n, H, m_free, m_held, saturated, free, held, reals, integers, state,
 * changes, search, history, image, derivative, multipliers, event_integers,
 * event_reals, history_capacity, event_capacity)
 *   -> (status, steps, events, first_mode, last_mode) */
static PyObject *orbit(PyObject *self, PyObject *args) {
  (void)self;
  enum {
    CHANGES = RUN_BUFFERS,
    SEARCH,
    HISTORY,
    IMAGE,
    DERIVATIVE,
    MULTIPLIERS,
    EVENT_INTEGERS,
    EVENT_REALS,
    BUFFERS
  };
  sizes of;
  long long capacity, rows;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  wanted kinds[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iiiiiOOOOOOOOOOOOOLL", &of.n, &of.H, &of.m_free,
                        &of.m_held, &of.saturated, &objects[0], &objects[1],
                        &objects[2], &objects[3], &objects[4], &objects[5],
                        &objects[6], &objects[7], &objects[8], &objects[9],
                        &objects[10], &objects[11], &objects[12], &capacity,
                        &rows) ||
      !sizes_hold(&of) || !have_lapack()) {
    return NULL;
  }
  if (capacity < 1 || capacity > 1000000000 || rows < 0 || rows > 1000000000) {
    return PyErr_Format(PyExc_ValueError, "capacity %lld or %lld out of range",
                        capacity, rows);
  }
  Py_ssize_t N = 2 * of.n;
  run_buffers(&of, kinds);
  kinds[CHANGES] = (wanted){
      "changes", "d", 0, (Py_ssize_t)bm_changes_reals(of.n, inner_reals(&of))};
  kinds[SEARCH] = (wanted){"search", "d", 1, S_COUNT};
  kinds[HISTORY] = (wanted){"history", "d", 1, (Py_ssize_t)capacity};
  kinds[IMAGE] = (wanted){"image", "d", 1, N};
  kinds[DERIVATIVE] = (wanted){"derivative", "d", 1, N * N};
  kinds[MULTIPLIERS] = (wanted){"multipliers", "d", 1, 2 * N};
  kinds[EVENT_INTEGERS] =
      (wanted){"event_integers", "q", 1, (Py_ssize_t)rows * BM_EVENT_INTEGERS};
  kinds[EVENT_REALS] =
      (wanted){"event_reals", "d", 1, (Py_ssize_t)rows * (BM_EVENT_REALS + N)};
  if (!take(BUFFERS, objects, kinds, views, data)) {
    return NULL;
  }
  bm_flow free_flow, held_flow;
  bm_run run;
  double *asked = data[SEARCH];
  if (!run_of(&of, data, &free_flow, &held_flow, &run)) {
    release(views, BUFFERS);
    return NULL;
  }
  if (!(asked[S_PERIODS] > 0.0 && asked[S_PERIODS] < 1e6) ||
      bm_flow_amplitudes(&free_flow) != free_flow.N ||
      bm_flow_amplitudes(&held_flow) != held_flow.N) {
    release(views, BUFFERS);
    return PyErr_Format(PyExc_ValueError,
                        "periods not within 0 and 1e6, or modes that are not "
                        "one of each pair");
  }
  bm_changes changes;
  bm_changes_unpack(&changes, data[CHANGES], of.n, inner_reals(&of));
  bm_search search = {
      .periods = asked[S_PERIODS],
      .sign = asked[S_SIGN],
      .tolerance = asked[S_TOLERANCE],
      .residual = asked[S_RESIDUAL],
      .settle = asked[S_SETTLE],
      .capacity = capacity,
      .history = data[HISTORY],
      .image = data[IMAGE],
      .derivative = data[DERIVATIVE],
      .lapack = &lapack,
      .multipliers = data[MULTIPLIERS],
      .events = {rows, 0, data[EVENT_INTEGERS], data[EVENT_REALS]}};
  bm_status status;
  Py_BEGIN_ALLOW_THREADS;
  status = bm_orbit(&run, &changes, &search);
  Py_END_ALLOW_THREADS;
  asked[S_RESIDUAL] = search.residual;
  asked[S_FOLLOWED] = search.followed;
  release(views, BUFFERS);
  return Py_BuildValue("iLLii", (int)status, (long long)search.steps,
                       (long long)search.events.count, search.first_mode,
                       search.last_mode);
}

/* modes(k, H, Omega, M, D, K, F, load, row, direct, d_c, packed)
 *   -> (status, m, condition, stiffness, nearest, nearest_mean) */
static PyObject *modes(PyObject *self, PyObject *args) {
  (void)self;
  enum { M_, D_, K_, F_, LOAD, ROW, DIRECT, PACKED, BUFFERS };
  bm_system of;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iidOOOOOOOdO", &of.k, &of.H, &of.Omega,
                        &objects[M_], &objects[D_], &objects[K_], &objects[F_],
                        &objects[LOAD], &objects[ROW], &objects[DIRECT],
                        &of.d_c, &objects[PACKED]) ||
      !have_lapack()) {
    return NULL;
  }
  if (of.k < 0 || of.k > MOST_COORDINATES || of.H < 0 ||
      of.H > MOST_COORDINATES || !(of.Omega > 0.0)) {
    return PyErr_Format(PyExc_ValueError, "out of range: k %d, H %d or Omega",
                        of.k, of.H);
  }
  Py_ssize_t k = of.k, harmonics = (Py_ssize_t)of.H + 1;
  wanted kinds[BUFFERS] = {
      {"M", "d", 0, k * k},
      {"D", "d", 0, k * k},
      {"K", "d", 0, k * k},
      {"F", "d", 0, 2 * harmonics * k},
      {"load", "d", 0, k},
      {"row", "d", 0, 2 * k},
      {"direct", "d", 0, 2 * harmonics},
      {"packed", "d", 1, (Py_ssize_t)bm_flow_reals(2 * of.k, 2 * of.k, of.H)},
  };
  if (!take(BUFFERS, objects, kinds, views, data)) {
    return NULL;
  }
  of.M = data[M_];
  of.D = data[D_];
  of.K = data[K_];
  of.F = data[F_];
  of.load = data[LOAD];
  of.row = data[ROW];
  of.direct = data[DIRECT];
  int m = 0;
  bm_soundness sound = {0.0, 0.0, 0.0, 0.0};
  bm_status status;
  Py_BEGIN_ALLOW_THREADS;
  status = bm_modes(&lapack, &of, data[PACKED], &m, &sound);
  Py_END_ALLOW_THREADS;
  release(views, BUFFERS);
  return Py_BuildValue("iidddd", (int)status, m, sound.condition,
                       sound.stiffness, sound.nearest, sound.nearest_mean);
}

/* changes(n, H, m_free, m_held, saturated, Omega, free, held, joint, mass, m_t,
 * push, packed) -> status */
static PyObject *changes(PyObject *self, PyObject *args) {
  (void)self;
  enum { FREE_FLOW, HELD_FLOW, M_T, PUSH, PACKED, BUFFERS };
  sizes of;
  double Omega;
  bm_joint joint;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iiiiidOOidOOO", &of.n, &of.H, &of.m_free,
                        &of.m_held, &of.saturated, &Omega, &objects[FREE_FLOW],
                        &objects[HELD_FLOW], &joint.index, &joint.mass,
                        &objects[M_T], &objects[PUSH], &objects[PACKED]) ||
      !sizes_hold(&of)) {
    return NULL;
  }
  if (joint.index < 0 || joint.index >= of.n || !(Omega > 0.0)) {
    return PyErr_Format(PyExc_ValueError, "joint out of range or Omega <= 0");
  }
  int N = 2 * of.n, Nh = inner_reals(&of);
  wanted kinds[BUFFERS] = {
      {"free", "d", 0, (Py_ssize_t)bm_flow_reals(N, of.m_free, of.H)},
      {"held", "d", 0, (Py_ssize_t)bm_flow_reals(Nh, of.m_held, of.H)},
      {"m_t", "d", 0, of.n - 1},
      {"push", "d", 0, of.n},
      {"packed", "d", 1, (Py_ssize_t)bm_changes_reals(of.n, Nh)},
  };
  if (!take(BUFFERS, objects, kinds, views, data)) {
    return NULL;
  }
  bm_flow free_flow, held_flow;
  bm_flow_unpack(&free_flow, data[FREE_FLOW], N, of.m_free, of.H, Omega);
  bm_flow_unpack(&held_flow, data[HELD_FLOW], Nh, of.m_held, of.H, Omega);
  joint.m_t = data[M_T];
  joint.push = data[PUSH];
  if (bm_flow_amplitudes(&free_flow) != N ||
      bm_flow_amplitudes(&held_flow) != Nh) {
    release(views, BUFFERS);
    return PyErr_Format(PyExc_ValueError,
                        "modes that are not one of each pair");
  }
  PyThreadState *state = let_go(of.n > 100);
  bm_status status =
      bm_changes_fill(&free_flow, &held_flow, &joint, data[PACKED]);
  take_back(state);
  release(views, BUFFERS);
  return Py_BuildValue("i", (int)status);
}

/* changes_reals(n, Nh) -> size of packed changes */
static PyObject *changes_reals(PyObject *self, PyObject *args) {
  (void)self;
  int n, Nh;
  if (!PyArg_ParseTuple(args, "ii", &n, &Nh)) {
    return NULL;
  }
  if (n < 1 || n > MOST_COORDINATES || Nh < 0 || Nh > 2 * n) {
    return PyErr_Format(PyExc_ValueError, "sizes out of range: n %d, Nh %d", n,
                        Nh);
  }
  return Py_BuildValue("L", (long long)bm_changes_reals(n, Nh));
}

/* flow_reals(N, m, H) -> (inputs, reals): sizes of a packed flow */
static PyObject *flow_reals(PyObject *self, PyObject *args) {
  (void)self;
  int N, m, H;
  if (!PyArg_ParseTuple(args, "iii", &N, &m, &H)) {
    return NULL;
  }
  if (N < 0 || N > 2 * MOST_COORDINATES || m < BM_CELLS || m > N || H < 0 ||
      H > MOST_COORDINATES) {
    return PyErr_Format(PyExc_ValueError,
                        "sizes out of range: N %d, m %d, H %d", N, m, H);
  }
  return Py_BuildValue("LL", (long long)bm_flow_inputs(N, m, H),
                       (long long)bm_flow_reals(N, m, H));
}

static PyMethodDef methods[] = {
    {"flow_reals", flow_reals, METH_VARARGS, "Sizes of a packed flow."},
    {"use_lapack", use_lapack, METH_VARARGS, "Takes SciPy's routines."},
    {"modes", modes, METH_VARARGS, "Fills a packed flow from its matrices."},
    {"changes", changes, METH_VARARGS, "Fills the packed changes of flows."},
    {"changes_reals", changes_reals, METH_VARARGS, "Size of packed changes."},
    {"propagate", propagate, METH_VARARGS,
     "Runs the exact map until the end, or until the event buffer is full."},
    {"orbit", orbit, METH_VARARGS, "Looks for a periodic orbit."},
    {"integrals", integrals, METH_VARARGS, "Adds integrals over a walk."},
    {"sample", sample, METH_VARARGS, "A walk at given times."},
    {"fourier", fourier, METH_VARARGS, "Adds Fourier integrals of a walk."},
    {NULL, NULL, 0, NULL}};

static PyModuleDef_Slot slots[] = {{0, NULL}};

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT,
                                    .m_name = "_event_map",
                                    .m_doc = "The exact event map in C.",
                                    .m_size = 0,
                                    .m_methods = methods,
                                    .m_slots = slots};

PyMODINIT_FUNC PyInit__event_map(void) {
  return PyModuleDef_Init(&module);
}
