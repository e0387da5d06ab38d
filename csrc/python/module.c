/* beltsim._core: the C core as one Python type, through the limited API.
 *
 * Every buffer is checked here (type, shape, layout, writability) before C sees
 * it; the core's own header never meets Python.h. The lock is released while
 * the core runs. */
#define PY_SSIZE_T_CLEAN
#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#include <Python.h>
#include <string.h>

#include "beltsim_core.h"

#ifdef __GNUC__ /* Python's slots hold functions as void pointers */
#pragma GCC diagnostic ignored "-Wpedantic"
#endif

/* --- buffers -------------------------------------------------------------- */

enum { MOST_BUFFERS = 12 };

typedef struct {
  Py_buffer view[MOST_BUFFERS];
  int count;
} buffers;

static void release(buffers *held) {
  while (held->count > 0) {
    PyBuffer_Release(&held->view[--held->count]);
  }
}

static int format_fits(const char *format, char type, Py_ssize_t size) {
  if (format == NULL || format[0] == '\0' || format[1] != '\0') {
    return 0;
  }
  if (type == 'd') {
    return format[0] == 'd';
  }
  const Py_ssize_t wanted = type == 'i' ? 4 : 8;
  return strchr("ilq", format[0]) != NULL && size == wanted;
}

/* The memory of `object` as rows*columns entries of `type` ('d' double, 'i'
 * int32, 'q' int64); columns = 0: one dimension; rows < 0: any number, then
 * written to *found. NULL with an exception set when it does not fit. */
static void *take(buffers *held, PyObject *object, const char *name, char type,
                  int writable, Py_ssize_t rows, Py_ssize_t columns,
                  Py_ssize_t *found) {
  const char *kind =
      type == 'd' ? "float64" : (type == 'i' ? "int32" : "int64");
  Py_buffer *view = &held->view[held->count];
  if (PyObject_GetBuffer(object, view, PyBUF_STRIDES | PyBUF_FORMAT) != 0) {
    PyErr_Clear();
    PyErr_Format(PyExc_TypeError, "%s: must be a %s array", name, kind);
    return NULL;
  }
  held->count++;
  if (!format_fits(view->format, type, view->itemsize)) {
    PyErr_Format(PyExc_TypeError, "%s: must have dtype %s", name, kind);
    return NULL;
  }
  if (view->ndim != (columns > 0 ? 2 : 1) ||
      (rows >= 0 && view->shape[0] != rows) ||
      (columns > 0 && view->shape[1] != columns)) {
    PyErr_Format(PyExc_ValueError,
                 columns > 0 ? "%s: must have shape (%zd, %zd)"
                             : "%s: must have shape (%zd,)",
                 name, rows, columns);
    return NULL;
  }
  if (!PyBuffer_IsContiguous(view, 'C')) {
    PyErr_Format(PyExc_ValueError, "%s: must be C-contiguous", name);
    return NULL;
  }
  if (writable && view->readonly) {
    PyErr_Format(PyExc_ValueError, "%s: must be writable", name);
    return NULL;
  }
  if (found != NULL) {
    *found = view->shape[0];
  }
  return view->buf;
}

/* --- the type ------------------------------------------------------------- */

typedef struct {
  PyObject_HEAD bs_core *core;
  Py_ssize_t n;
  int busy; /* guarded by the interpreter lock */
} Core;

static const char core_doc[] =
    "Core(n, joint, law, method, Omega, Q_m, Q_s, sigma, rtol, max_steps,\n"
    "     max_events, events_per_period, grazing, window_start, M, C, G, K,\n"
    "     f_cos, f_sin, atol, y0)\n\n"
    "One run of the C core; see csrc/core/include/beltsim_core.h.";

static PyObject *raise_status(bs_status status, const char *text) {
  if (status == BS_NO_MEMORY) {
    return PyErr_NoMemory();
  }
  PyErr_Format(PyExc_RuntimeError, "%s: %s%s%s", bs_status_name(status),
               bs_status_text(status), text[0] ? "; " : "", text);
  return NULL;
}

static int fill_inputs(buffers *held, PyObject **array, bs_problem *problem,
                       bs_settings *settings, const double **y0) {
  const Py_ssize_t n = problem->n;
  Py_ssize_t rows = 0;
  const char *names[4] = {"M", "C", "G", "K"};
  const double **slots[4] = {&problem->M, &problem->C, &problem->G,
                             &problem->K};
  for (int i = 0; i < 4; i++) {
    *slots[i] = take(held, array[i], names[i], 'd', 0, n, n, NULL);
    if (*slots[i] == NULL) {
      return -1;
    }
  }
  problem->f_cos = take(held, array[4], "f_cos", 'd', 0, -1, n, &rows);
  if (problem->f_cos == NULL) {
    return -1;
  }
  if (rows < 1 || rows > INT32_MAX) {
    PyErr_SetString(PyExc_ValueError, "f_cos: must have at least one row");
    return -1;
  }
  problem->harmonics = (int32_t)(rows - 1);
  problem->f_sin = take(held, array[5], "f_sin", 'd', 0, rows, n, NULL);
  settings->atol = problem->f_sin
                       ? take(held, array[6], "atol", 'd', 0, 2 * n, 0, NULL)
                       : NULL;
  *y0 = settings->atol ? take(held, array[7], "y0", 'd', 0, 2 * n, 0, NULL)
                       : NULL;
  return *y0 ? 0 : -1;
}

static PyObject *core_new(PyTypeObject *type, PyObject *args,
                          PyObject *keywords) {
  bs_problem problem = {0};
  bs_settings settings = {0};
  double window_start;
  PyObject *array[8];
  long long max_steps, max_events;
  if (keywords != NULL && PyDict_Size(keywords) > 0) {
    PyErr_SetString(PyExc_TypeError, "Core takes no keyword arguments");
    return NULL;
  }
  if (!PyArg_ParseTuple(
          args, "iiiidddddLLdddOOOOOOOO:Core", &problem.n, &problem.joint,
          &problem.law, &settings.method, &problem.Omega, &problem.Q_m,
          &problem.Q_s, &problem.sigma, &settings.rtol, &max_steps, &max_events,
          &settings.events_per_period, &settings.grazing, &window_start,
          &array[0], &array[1], &array[2], &array[3], &array[4], &array[5],
          &array[6], &array[7])) {
    return NULL;
  }
  if (problem.n < 1 || problem.n > 20000) {
    return PyErr_Format(PyExc_ValueError, "n = %d: must be 1 to 20000",
                        (int)problem.n);
  }
  settings.max_steps = max_steps;
  settings.max_events = max_events;
  buffers held = {.count = 0};
  const double *y0 = NULL;
  if (fill_inputs(&held, array, &problem, &settings, &y0) != 0) {
    release(&held);
    return NULL;
  }
  char text[256] = "";
  bs_core *core = NULL;
  bs_status status;
  Py_BEGIN_ALLOW_THREADS status =
      bs_create(&core, &problem, &settings, y0, text);
  Py_END_ALLOW_THREADS release(&held);
  if (status != BS_OK) {
    return raise_status(status, text);
  }
  bs_set_window(core, window_start);
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  Core *self = (Core *)allocate(type, 0);
  if (self == NULL) {
    bs_free(core);
    return NULL;
  }
  self->core = core;
  self->n = problem.n;
  return (PyObject *)self;
}

static void core_dealloc(PyObject *object) {
  PyTypeObject *type = Py_TYPE(object);
  freefunc release_memory = (freefunc)PyType_GetSlot(type, Py_tp_free);
  bs_free(((Core *)object)->core);
  release_memory(object);
  Py_DECREF(type);
}

static int refuse_if_busy(const Core *self) {
  if (self->busy) {
    PyErr_SetString(PyExc_RuntimeError,
                    "this Core is running in another thread");
    return -1;
  }
  return 0;
}

/* --- run ------------------------------------------------------------------ */

static const char run_doc[] =
    "run(t_stop, seconds, counts, sample_t, sample_state, sample_torque,\n"
    "    event_values, event_codes, event_states, touch_values) -> status\n\n"
    "counts: int64 (3,), in and out: samples, events and touches written.\n"
    "event_states may be None.";

static int fill_output(buffers *held, PyObject **array, Py_ssize_t n,
                       bs_output *out, int64_t **counts) {
  Py_ssize_t rows = 0;
  *counts = take(held, array[0], "counts", 'q', 1, 3, 0, NULL);
  if (!*counts) {
    return -1;
  }
  out->sample_t = take(held, array[1], "sample_t", 'd', 0, -1, 0, &rows);
  if (!out->sample_t) {
    return -1;
  }
  out->n_samples = rows;
  out->sample_state =
      take(held, array[2], "sample_state", 'd', 1, rows, 2 * n, NULL);
  out->sample_torque = out->sample_state ? take(held, array[3], "sample_torque",
                                                'd', 1, rows, 0, NULL)
                                         : NULL;
  if (!out->sample_torque) {
    return -1;
  }
  out->event_values =
      take(held, array[4], "event_values", 'd', 1, -1, BS_EVENT_VALUES, &rows);
  out->event_codes = out->event_values ? take(held, array[5], "event_codes",
                                              'i', 1, rows, 2, NULL)
                                       : NULL;
  if (!out->event_codes) {
    return -1;
  }
  out->event_capacity = rows;
  if (array[6] != Py_None) {
    out->event_states =
        take(held, array[6], "event_states", 'd', 1, rows, 2 * n, NULL);
    if (!out->event_states) {
      return -1;
    }
  }
  out->touch_values =
      take(held, array[7], "touch_values", 'd', 1, -1, BS_TOUCH_VALUES, &rows);
  out->touch_capacity = rows;
  return out->touch_values ? 0 : -1;
}

static int counts_fit(const int64_t *counts, const bs_output *out) {
  if (out->event_capacity < 1 || out->touch_capacity < 1 || counts[0] < 0 ||
      counts[0] > out->n_samples || counts[1] < 0 ||
      counts[1] > out->event_capacity || counts[2] < 0 ||
      counts[2] > out->touch_capacity) {
    PyErr_SetString(PyExc_ValueError,
                    "counts: must lie between 0 and the buffers' lengths, "
                    "which must be at least 1 for events and touches");
    return 0;
  }
  return 1;
}

static PyObject *core_run(PyObject *object, PyObject *args) {
  Core *self = (Core *)object;
  double t_stop, seconds;
  PyObject *array[8];
  if (!PyArg_ParseTuple(args, "ddOOOOOOOO:run", &t_stop, &seconds, &array[0],
                        &array[1], &array[2], &array[3], &array[4], &array[5],
                        &array[6], &array[7]) ||
      refuse_if_busy(self) != 0) {
    return NULL;
  }
  if (!(t_stop >= 0.0 && t_stop - t_stop == 0.0)) {
    PyErr_SetString(PyExc_ValueError, "t_stop: must be finite and >= 0");
    return NULL;
  }
  buffers held = {.count = 0};
  bs_output out = {0};
  int64_t *counts = NULL;
  if (fill_output(&held, array, self->n, &out, &counts) != 0 ||
      !counts_fit(counts, &out)) {
    release(&held);
    return NULL;
  }
  out.samples_done = counts[0];
  out.events_done = counts[1];
  out.touches_done = counts[2];
  bs_status status;
  self->busy = 1;
  Py_BEGIN_ALLOW_THREADS status = bs_run(self->core, t_stop, seconds, &out);
  Py_END_ALLOW_THREADS self->busy = 0;
  counts[0] = out.samples_done;
  counts[1] = out.events_done;
  counts[2] = out.touches_done;
  release(&held);
  return PyLong_FromLong(status);
}

/* --- what is known -------------------------------------------------------- */

static PyObject *copy_state(PyObject *object, PyObject *target,
                            void (*copy)(const bs_core *, double *)) {
  Core *self = (Core *)object;
  buffers held = {.count = 0};
  if (refuse_if_busy(self) != 0) {
    return NULL;
  }
  double *y = take(&held, target, "target", 'd', 1, 2 * self->n, 0, NULL);
  if (y != NULL) {
    copy(self->core, y);
  }
  release(&held);
  return y != NULL ? Py_NewRef(Py_None) : NULL;
}

static PyObject *core_state(PyObject *object, PyObject *target) {
  return copy_state(object, target, bs_state);
}

static PyObject *core_window_state(PyObject *object, PyObject *target) {
  return copy_state(object, target, bs_window_state);
}

static PyObject *core_summary(PyObject *object, PyObject *unused) {
  Core *self = (Core *)object;
  bs_summary s;
  (void)unused;
  if (refuse_if_busy(self) != 0) {
    return NULL;
  }
  bs_summarise(self->core, &s);
  return Py_BuildValue(
      "{s:d,s:i,s:i,s:L,s:d,s:i,s:i,s:L,s:L,s:L,s:L,s:L,s:L,s:L,s:d,s:d,s:d,"
      "s:d,s:d,s:d,s:s}",
      "t", s.t, "mode", (int)s.mode, "initial_mode", (int)s.initial_mode,
      "events", (long long)s.events, "last_event_t", s.last_event_t,
      "last_event_kind", (int)s.last_event_kind, "solver_code",
      (int)s.solver_code, "steps", (long long)s.steps, "series_steps",
      (long long)s.series_steps, "right_sides", (long long)s.right_sides,
      "error_test_failures", (long long)s.error_test_failures,
      "convergence_failures", (long long)s.convergence_failures, "jacobians",
      (long long)s.jacobians, "restarts", (long long)s.restarts,
      "velocity_peak", s.velocity_peak, "reaction_peak", s.reaction_peak,
      "forcing_work", s.forcing_work, "viscous_loss", s.viscous_loss,
      "window_friction_loss", s.window_friction_loss, "friction_loss",
      s.friction_loss, "solver_text", bs_solver_text(self->core));
}

static PyObject *core_cancel(PyObject *object, PyObject *unused) {
  (void)unused;
  bs_cancel(((Core *)object)->core);
  return Py_NewRef(Py_None);
}

static PyObject *core_inject(PyObject *object, PyObject *args) {
  Core *self = (Core *)object;
  long long solver_call, bad_rhs_call, bad_root_call;
  bs_faults faults = {0};
  if (!PyArg_ParseTuple(args, "iLLL:inject", &faults.solver_code, &solver_call,
                        &bad_rhs_call, &bad_root_call) ||
      refuse_if_busy(self) != 0) {
    return NULL;
  }
  faults.solver_call = solver_call;
  faults.bad_rhs_call = bad_rhs_call;
  faults.bad_root_call = bad_root_call;
  bs_inject(self->core, &faults);
  return Py_NewRef(Py_None);
}

static PyMethodDef core_methods[] = {
    {"run", core_run, METH_VARARGS, run_doc},
    {"state", core_state, METH_O, "Write the state reached into (2n,)."},
    {"window_state", core_window_state, METH_O,
     "Write the state at the window's start into (2n,)."},
    {"summary", core_summary, METH_NOARGS, "What is known, as a dict."},
    {"cancel", core_cancel, METH_NOARGS, "Make run return at the next step."},
    {"inject", core_inject, METH_VARARGS,
     "inject(solver_code, solver_call, bad_rhs_call, bad_root_call): tests."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot core_slots[] = {
    {Py_tp_doc, (void *)core_doc},
    {Py_tp_new, core_new},
    {Py_tp_dealloc, core_dealloc},
    {Py_tp_methods, core_methods},
    {0, NULL},
};

static PyType_Spec core_spec = {
    "beltsim._core.Core", sizeof(Core), 0, Py_TPFLAGS_DEFAULT, core_slots,
};

/* --- the module ----------------------------------------------------------- */

static PyObject *status_name(PyObject *module, PyObject *code) {
  (void)module;
  const long status = PyLong_AsLong(code);
  if (status == -1 && PyErr_Occurred()) {
    return NULL;
  }
  return PyUnicode_FromString(bs_status_name((bs_status)status));
}

static PyObject *status_text(PyObject *module, PyObject *code) {
  (void)module;
  const long status = PyLong_AsLong(code);
  if (status == -1 && PyErr_Occurred()) {
    return NULL;
  }
  return PyUnicode_FromString(bs_status_text((bs_status)status));
}

static PyMethodDef module_methods[] = {
    {"status_name", status_name, METH_O, "Name of a status code."},
    {"status_text", status_text, METH_O, "Advice for a status code."},
    {NULL, NULL, 0, NULL},
};

static int module_exec(PyObject *module) {
  PyObject *type = PyType_FromSpec(&core_spec);
  if (type == NULL || PyModule_AddObjectRef(module, "Core", type) != 0) {
    Py_XDECREF(type);
    return -1;
  }
  Py_DECREF(type);
  if (PyModule_AddIntConstant(module, "EVENT_VALUES", BS_EVENT_VALUES) != 0 ||
      PyModule_AddIntConstant(module, "TOUCH_VALUES", BS_TOUCH_VALUES) != 0) {
    return -1;
  }
  return PyModule_AddStringConstant(module, "sundials_version",
                                    bs_sundials_version());
}

static PyModuleDef_Slot module_slots[] = {
    {Py_mod_exec, module_exec},
    {0, NULL},
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT,
    "beltsim._core",
    "The compiled integrator; used by beltsim.transient only.",
    0,
    module_methods,
    module_slots,
    NULL,
    NULL,
    NULL,
};

PyMODINIT_FUNC PyInit__core(void) {
  return PyModuleDef_Init(&module);
}
