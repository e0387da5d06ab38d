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

enum {
  FREE,
  HELD,
  REALS,
  INTEGERS,
  STATE,
  EVENT_INTEGERS,
  EVENT_REALS,
  BUFFERS
};

static const struct {
  const char *name, *format;
  int writable;
} KINDS[BUFFERS] = {
    {"free", "d", 0},        {"held", "d", 0},  {"reals", "d", 1},
    {"integers", "q", 1},    {"state", "d", 1}, {"event_integers", "q", 1},
    {"event_reals", "d", 1},
};

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

static void release(Py_buffer *views, int count) {
  for (int i = 0; i < count; i++) {
    PyBuffer_Release(&views[i]);
  }
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

/* propagate(n, H, m_free, m_held, saturated, free, held, reals, integers,
 * state, event_integers, event_reals, capacity, count, end_periods, end_time)
 *   -> (status, count) */
static PyObject *propagate(PyObject *self, PyObject *args) {
  (void)self;
  int n, H, m_free, m_held, saturated;
  long long capacity, count, end_periods;
  double end_time;
  PyObject *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "iiiiiOOOOOOOLLLd", &n, &H, &m_free, &m_held,
                        &saturated, &objects[0], &objects[1], &objects[2],
                        &objects[3], &objects[4], &objects[5], &objects[6],
                        &capacity, &count, &end_periods, &end_time)) {
    return NULL;
  }
  if (n < 1 || n > MOST_COORDINATES || H < 0 || H > MOST_COORDINATES ||
      m_free < BM_CELLS || m_free > 2 * n || m_held < BM_CELLS ||
      m_held > 2 * n || capacity < 1 || capacity > 1000000000 || count < 0 ||
      count > capacity) {
    return PyErr_Format(
        PyExc_ValueError,
        "sizes out of range: n %d, H %d, m %d, %d, capacity %lld, "
        "count %lld",
        n, H, m_free, m_held, capacity, count);
  }
  int inner = saturated ? 2 * n : 2 * n - 2;
  Py_ssize_t least[BUFFERS] = {
      (Py_ssize_t)bm_flow_reals(2 * n, m_free, H),
      (Py_ssize_t)bm_flow_reals(inner, m_held, H),
      R_COUNT,
      I_COUNT,
      2 * n,
      (Py_ssize_t)capacity * BM_EVENT_INTEGERS,
      (Py_ssize_t)capacity * (BM_EVENT_REALS + 2 * n),
  };
  for (int i = 0; i < BUFFERS; i++) {
    data[i] = buffer_of(objects[i], KINDS[i].name, KINDS[i].format,
                        KINDS[i].writable, least[i], &views[i]);
    if (!data[i]) {
      release(views, i);
      return NULL;
    }
  }
  double *reals = data[REALS];
  int64_t *integers = data[INTEGERS];
  if (integers[I_JOINT] < 0 || integers[I_JOINT] >= n ||
      !(reals[R_OMEGA] > 0.0) || saturated != (reals[R_SIGMA] > 0.0)) {
    release(views, BUFFERS);
    return PyErr_Format(
        PyExc_ValueError,
        "joint out of range, Omega <= 0 or sigma against the law");
  }
  bm_flow free_flow, held_flow;
  bm_flow_unpack(&free_flow, data[FREE], 2 * n, m_free, H, reals[R_OMEGA]);
  bm_flow_unpack(&held_flow, data[HELD], inner, m_held, H, reals[R_OMEGA]);
  bm_run run = {.free = &free_flow, .held = &held_flow, .state = data[STATE]};
  unpack(&run, reals, integers);
  bm_events events = {capacity, count, data[EVENT_INTEGERS], data[EVENT_REALS]};
  bm_status status;
  Py_BEGIN_ALLOW_THREADS;
  status = bm_propagate(&run, end_periods, end_time, &events);
  Py_END_ALLOW_THREADS;
  pack(&run, reals, integers);
  release(views, BUFFERS);
  return Py_BuildValue("iL", (int)status, (long long)events.count);
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
    {"propagate", propagate, METH_VARARGS,
     "Runs the exact map until the end, or until the event buffer is full."},
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
