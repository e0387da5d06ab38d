/* Integrals, samples and Fourier integrals of recorded walks, for Python. */
#include "beltsim_map.h"
#include "event_map_buffers.h"

/* The phases of one flow of a walk, the first argument of what looks at them:
 * a tuple (n, H, m, role, joint, Omega, Q_m, slope, flow, start, end, length,
 * first_mode, event_integers, event_reals, count, state). */
typedef struct {
  int n, H;
  bm_flow flow;
  bm_walk walk;
  bm_phases phases;
  Py_buffer views[4];
} walked;

static int take_phases(PyObject *tuple, walked *it) {
  enum { FLOW, EVENT_INTEGERS, EVENT_REALS, X, BUFFERS };
  int m, role;
  long long count;
  double Omega;
  PyObject *objects[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(tuple, "iiiiidddOdddiOOLO", &it->n, &it->H, &m, &role,
                        &it->phases.joint, &Omega, &it->phases.Q_m,
                        &it->phases.slope, &objects[FLOW], &it->phases.start,
                        &it->phases.end, &it->walk.length, &it->walk.first_mode,
                        &objects[EVENT_INTEGERS], &objects[EVENT_REALS], &count,
                        &objects[X])) {
    return 0;
  }
  int N = role == BM_HELD ? 2 * it->n - 2 : 2 * it->n;
  if (it->n < 1 || it->n > MOST_COORDINATES || m < 0 || m > N || it->H < 0 ||
      it->H > MOST_COORDINATES || !(Omega > 0.0) || count < 0 ||
      count > 1000000000 || it->phases.joint < 0 || it->phases.joint >= it->n ||
      role < BM_FREE || role > BM_BAND) {
    PyErr_Format(PyExc_ValueError,
                 "out of range: n %d, m %d, H %d, joint %d, role %d, Omega or "
                 "count",
                 it->n, m, it->H, it->phases.joint, role);
    return 0;
  }
  Py_ssize_t many = (Py_ssize_t)count, wide = 2 * (Py_ssize_t)it->n;
  wanted kinds[BUFFERS] = {
      {"flow", "d", 0, (Py_ssize_t)bm_flow_reals(N, m, it->H)},
      {"event_integers", "q", 0, many * BM_EVENT_INTEGERS},
      {"event_reals", "d", 0, many * (BM_EVENT_REALS + wide)},
      {"state", "d", 0, wide},
  };
  if (!take(BUFFERS, objects, kinds, it->views, data)) {
    return 0;
  }
  bm_flow_unpack(&it->flow, data[FLOW], N, m, it->H, Omega);
  it->phases.role = (bm_role)role;
  it->phases.state = data[X];
  it->walk.events =
      (bm_events){count, count, data[EVENT_INTEGERS], data[EVENT_REALS]};
  return 1;
}

static void release_phases(walked *it) {
  release(it->views, 4);
}

/* integrals(phases, F, C, squares, sums) -> status; F and C may be None.
 * `sums`: speed, work, loss, slipped. */
PyObject *integrals(PyObject *self, PyObject *args) {
  (void)self;
  enum { SQUARES, SUMS, F_, C_, BUFFERS };
  walked it = {0};
  PyObject *tuple, *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS] = {NULL};
  if (!PyArg_ParseTuple(args, "O!OOOO", &PyTuple_Type, &tuple, &objects[F_],
                        &objects[C_], &objects[SQUARES], &objects[SUMS]) ||
      !take_phases(tuple, &it)) {
    return NULL;
  }
  Py_ssize_t n = it.n;
  wanted kinds[BUFFERS] = {
      {"squares", "d", 1, n},
      {"sums", "d", 1, 4},
      {"F", "d", 0, 2 * ((Py_ssize_t)it.H + 1) * n},
      {"C", "d", 0, n * n},
  };
  int buffers = objects[C_] == Py_None ? F_ : BUFFERS;
  if (!take(buffers, objects, kinds, views, data)) {
    release_phases(&it);
    return NULL;
  }
  double *sums = data[SUMS];
  bm_integrals of = {data[F_], data[C_], data[SQUARES], sums[0],
                     sums[1],  sums[2],  sums[3]};
  PyThreadState *state = let_go((it.walk.events.count + 1) * it.n > 200);
  bm_status status = bm_integrate(&it.flow, &it.walk, &it.phases, &of);
  take_back(state);
  sums[0] = of.speed;
  sums[1] = of.work;
  sums[2] = of.loss;
  sums[3] = of.slipped;
  release(views, buffers);
  release_phases(&it);
  return Py_BuildValue("i", (int)status);
}

/* sample(phases, count, t, x, torque) -> status */
PyObject *sample(PyObject *self, PyObject *args) {
  (void)self;
  enum { T, X, TORQUE, BUFFERS };
  walked it = {0};
  long long count;
  PyObject *tuple, *objects[BUFFERS];
  Py_buffer views[BUFFERS];
  void *data[BUFFERS];
  if (!PyArg_ParseTuple(args, "O!LOOO", &PyTuple_Type, &tuple, &count,
                        &objects[T], &objects[X], &objects[TORQUE]) ||
      !take_phases(tuple, &it)) {
    return NULL;
  }
  int valid = count >= 0 && count <= 1000000000;
  Py_ssize_t many = valid ? (Py_ssize_t)count : 0;
  wanted kinds[BUFFERS] = {
      {"t", "d", 0, many},
      {"x", "d", 1, many * 2 * (Py_ssize_t)it.n},
      {"torque", "d", 1, many},
  };
  if (!valid) {
    PyErr_Format(PyExc_ValueError, "count %lld out of range", count);
  }
  if (!valid || !take(BUFFERS, objects, kinds, views, data)) {
    release_phases(&it);
    return NULL;
  }
  bm_samples to = {count, data[T], data[X], data[TORQUE]};
  PyThreadState *state = let_go(count * it.n > 1000);
  bm_status status = bm_sample(&it.flow, &it.walk, &it.phases, &to);
  take_back(state);
  release(views, BUFFERS);
  release_phases(&it);
  return Py_BuildValue("i", (int)status);
}

/* fourier(phases, count, first, step, values) -> status */
PyObject *fourier(PyObject *self, PyObject *args) {
  (void)self;
  walked it = {0};
  bm_coefficients to;
  PyObject *tuple, *object;
  Py_buffer view;
  void *values = NULL;
  if (!PyArg_ParseTuple(args, "O!iiiO", &PyTuple_Type, &tuple, &to.count,
                        &to.first, &to.step, &object) ||
      !take_phases(tuple, &it)) {
    return NULL;
  }
  int valid = to.count >= 0 && to.count <= 10000000 && to.first >= 0 &&
              to.first <= 1 && to.step >= 1 && to.step <= 2;
  if (!valid) {
    PyErr_Format(PyExc_ValueError, "orders out of range: %d from %d by %d",
                 to.count, to.first, to.step);
  }
  wanted kind = {"values", "d", 1,
                 valid ? to.count * 2 * (2 * (Py_ssize_t)it.n + 1) : 0};
  if (!valid || !take(1, &object, &kind, &view, &values)) {
    release_phases(&it);
    return NULL;
  }
  to.values = values;
  PyThreadState *state =
      let_go((it.walk.events.count + 1) * to.count * it.n > 1000);
  bm_status status = bm_fourier(&it.flow, &it.walk, &it.phases, &to);
  take_back(state);
  release(&view, 1);
  release_phases(&it);
  return Py_BuildValue("i", (int)status);
}
