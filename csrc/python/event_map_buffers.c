#include "event_map_buffers.h"

#include <string.h>

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

void release(Py_buffer *views, int count) {
  for (int i = 0; i < count; i++) {
    PyBuffer_Release(&views[i]);
  }
}

/* All buffers of a call, or none with an exception. */
int take(int count, PyObject **objects, const wanted *kinds, Py_buffer *views,
         void **data) {
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

PyThreadState *let_go(int worth_it) {
  return worth_it ? PyEval_SaveThread() : NULL;
}

void take_back(PyThreadState *state) {
  if (state) {
    PyEval_RestoreThread(state);
  }
}
