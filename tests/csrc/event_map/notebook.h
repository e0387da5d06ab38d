/* Room for the events of one mass. */
#ifndef BM_NOTEBOOK_H
#define BM_NOTEBOOK_H

#include "beltsim_map.h"

#define ROOM 64
typedef struct {
  int64_t integers[ROOM * BM_EVENT_INTEGERS];
  double reals[ROOM * (BM_EVENT_REALS + 2)];
  bm_events events;
} notebook;

static void notebook_open(notebook *book, int64_t capacity) {
  bm_events events = {capacity, 0, book->integers, book->reals};
  book->events = events;
}

#endif
