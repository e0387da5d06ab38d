/* beltsim._event_map: the exact map for Python. Limited API, buffers only. */
#define PY_SSIZE_T_CLEAN
#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#include <Python.h>
#include <string.h>

#include "beltsim_map.h"

/* Largest n: keeps every size below far from the range of int. */
#define MOST_COORDINATES 20000

/* A contiguous buffer of `format` ("d" or "q"): its address, or NULL with an
 * exception. `least` is the number of items it must hold. */
static void *buffer_of(PyObject *object, const char *name, const char *format,
                       int writable, Py_ssize_t least, Py_buffer *view) {
  int flags =
      PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (writable ? PyBUF_WRITABLE : 0);
  if (PyObject_GetBuffer(object, view, flags) < 0) {
    return NULL;
  }
  const char *found = view->format ? view->format : "B";
  int same =
      strcmp(found, format) == 0 ||
      (format[0] == 'q' && strcmp(found, "l") == 0 && view->itemsize == 8);
  if (!same) {
    PyErr_Format(PyExc_TypeError, "%s: format '%s', must be '%s'", name, found,
                 format);
  } else if (view->len < least * view->itemsize) {
    PyErr_Format(PyExc_ValueError, "%s: %zd items, must be at least %zd", name,
                 view->len / view->itemsize, least);
  } else {
    return view->buf;
  }
  PyBuffer_Release(view);
  return NULL;
}

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
enum { S_PERIODS, S_SIGN, S_TOLERANCE, S_RESIDUAL, S_FOLLOWED, S_COUNT };

/* An argument that is a buffer. */
typedef struct {
  const char *name, *format;
  int writable;
  Py_ssize_t least;
} wanted;

static void release(Py_buffer *views, int count) {
  for (int i = 0; i < count; i++) {
    PyBuffer_Release(&views[i]);
  }
}

/* All buffers of a call, or none with an exception. */
static int take(int count, PyObject **objects, const wanted *kinds,
                Py_buffer *views, void **data) {
  for (int i = 0; i < count; i++) {
    data[i] = buffer_of(objects[i], kinds[i].name, kinds[i].format,
                        kinds[i].writable, kinds[i].least, &views[i]);
    if (!data[i]) {
      release(views, i);
      return 0;
    }
  }
  return 1;
}

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
  Py_ssize_t free_reals = (Py_ssize_t)bm_flow_reals(2 * of->n, of->m_free,
                                                    of->H);
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

/* orbit(n, H, m_free, m_held, saturated, free, held, reals, integers, state,
 * changes, search, history, image, derivative, event_integers, event_reals,
 * history_capacity, event_capacity)
 *   -> (status, steps, events, first_mode, last_mode) */
static PyObject *orbit(PyObject *self, PyObject *args) {
  (void)self;
  enum {
    CHANGES = RUN_BUFFERS,
    SEARCH,
    HISTORY,
    IMAGE,
    DERIVATIVE,
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
  if (!PyArg_ParseTuple(args, "iiiiiOOOOOOOOOOOOLL", &of.n, &of.H, &of.m_free,
                        &of.m_held, &of.saturated, &objects[0], &objects[1],
                        &objects[2], &objects[3], &objects[4], &objects[5],
                        &objects[6], &objects[7], &objects[8], &objects[9],
                        &objects[10], &objects[11], &capacity, &rows) ||
      !sizes_hold(&of)) {
    return NULL;
  }
  if (capacity < 1 || capacity > 1000000000 || rows < 0 || rows > 1000000000) {
    return PyErr_Format(PyExc_ValueError, "capacity %lld or %lld out of range",
                        capacity, rows);
  }
  Py_ssize_t N = 2 * of.n;
  run_buffers(&of, kinds);
  kinds[CHANGES] =
      (wanted){"changes", "d", 0,
               (Py_ssize_t)bm_changes_reals(of.n, inner_reals(&of))};
  kinds[SEARCH] = (wanted){"search", "d", 1, S_COUNT};
  kinds[HISTORY] = (wanted){"history", "d", 1, (Py_ssize_t)capacity};
  kinds[IMAGE] = (wanted){"image", "d", 1, N};
  kinds[DERIVATIVE] = (wanted){"derivative", "d", 1, N * N};
  kinds[EVENT_INTEGERS] = (wanted){"event_integers", "q", 1,
                                   (Py_ssize_t)rows * BM_EVENT_INTEGERS};
  kinds[EVENT_REALS] = (wanted){"event_reals", "d", 1,
                                (Py_ssize_t)rows * (BM_EVENT_REALS + N)};
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
  bm_search search = {.periods = asked[S_PERIODS],
                      .sign = asked[S_SIGN],
                      .tolerance = asked[S_TOLERANCE],
                      .residual = asked[S_RESIDUAL],
                      .capacity = capacity,
                      .history = data[HISTORY],
                      .image = data[IMAGE],
                      .derivative = data[DERIVATIVE],
                      .events = {rows, 0, data[EVENT_INTEGERS],
                                 data[EVENT_REALS]}};
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

/* gram(N, m, H, Omega, flow, begin, from, to, load, states, count, gram)
 *   -> status */
static PyObject *gram(PyObject *self, PyObject *args) {
  (void)self;
  enum { FLOW, BEGIN, FROM, TO, LOAD, STATES, GRAM, BUFFERS };
  int N, m, H;
  double Omega;
  long long count;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iiidOOOOOOOL", &N, &m, &H, &Omega, &objects[0],
                        &objects[1], &objects[2], &objects[3], &objects[4],
                        &objects[5], &objects[6], &count)) {
    return NULL;
  }
  if (N < 0 || N > 2 * MOST_COORDINATES || m < 0 || m > N || H < 0 ||
      H > MOST_COORDINATES || !(Omega > 0.0) || count < 0 ||
      count > 1000000000) {
    return PyErr_Format(PyExc_ValueError,
                        "out of range: N %d, m %d, H %d, Omega or count", N, m,
                        H);
  }
  Py_ssize_t many = (Py_ssize_t)count, wide = 2 * ((Py_ssize_t)m + H + 2);
  wanted kinds[BUFFERS] = {
      {"flow", "d", 0, (Py_ssize_t)bm_flow_reals(N, m, H)},
      {"begin", "d", 0, many},
      {"from", "d", 0, many},
      {"to", "d", 0, many},
      {"load", "d", 0, many},
      {"states", "d", 0, many * N},
      {"gram", "d", 1, wide * wide},
  };
  if (!take(BUFFERS, objects, kinds, views, data)) {
    return NULL;
  }
  bm_flow flow;
  bm_flow_unpack(&flow, data[FLOW], N, m, H, Omega);
  bm_stretches all = {count,      data[BEGIN],  data[FROM], data[TO],
                      data[LOAD], data[STATES], data[GRAM]};
  bm_status status;
  Py_BEGIN_ALLOW_THREADS;
  status = bm_gram(&flow, &all);
  Py_END_ALLOW_THREADS;
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

/* prepare(N, m, H, Omega, packed): fills the tables of a packed flow */
static PyObject *prepare(PyObject *self, PyObject *args) {
  (void)self;
  int N, m, H;
  double Omega;
  PyObject *object;
  Py_buffer view;
  if (!PyArg_ParseTuple(args, "iiidO", &N, &m, &H, &Omega, &object)) {
    return NULL;
  }
  if (N < 0 || N > 2 * MOST_COORDINATES || m < 0 || m > N || H < 0 ||
      H > MOST_COORDINATES || !(Omega > 0.0)) {
    return PyErr_Format(PyExc_ValueError,
                        "out of range: N %d, m %d, H %d or Omega", N, m, H);
  }
  Py_ssize_t least = (Py_ssize_t)bm_flow_reals(N, m, H);
  double *packed = buffer_of(object, "packed", "d", 1, least, &view);
  if (!packed) {
    return NULL;
  }
  bm_flow_prepare(packed, N, m, H, Omega);
  PyBuffer_Release(&view);
  Py_RETURN_NONE;
}

static PyMethodDef methods[] = {
    {"flow_reals", flow_reals, METH_VARARGS, "Sizes of a packed flow."},
    {"prepare", prepare, METH_VARARGS, "Fills the tables of a packed flow."},
    {"changes_reals", changes_reals, METH_VARARGS, "Size of packed changes."},
    {"propagate", propagate, METH_VARARGS,
     "Runs the exact map until the end, or until the event buffer is full."},
    {"orbit", orbit, METH_VARARGS, "Looks for a periodic orbit."},
    {"gram", gram, METH_VARARGS, "Adds integrals of products of a flow."},
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
