/* Buffers of Python objects for the exact map. Limited API. */
#ifndef BELTSIM_EVENT_MAP_BUFFERS_H
#define BELTSIM_EVENT_MAP_BUFFERS_H

#define PY_SSIZE_T_CLEAN
#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#include <Python.h>

/* Largest n: keeps every size below far from the range of int. */
#define MOST_COORDINATES 20000

/* An argument that is a buffer of `format` ("d" or "q") with at least so many
 * items. */
typedef struct {
  const char *name, *format;
  int writable;
  Py_ssize_t least;
} wanted;

/* All buffers of a call, or none with an exception. */
int take(int count, PyObject **objects, const wanted *kinds, Py_buffer *views,
         void **data);
void release(Py_buffer *views, int count);

/* The interpreter's lock. Short calls keep it: to hand it over takes longer. */
PyThreadState *let_go(int worth_it);
void take_back(PyThreadState *state);

/* What looks at a recorded walk: see event_map_motion.c. */
PyObject *integrals(PyObject *self, PyObject *args);
PyObject *sample(PyObject *self, PyObject *args);
PyObject *fourier(PyObject *self, PyObject *args);

#endif
