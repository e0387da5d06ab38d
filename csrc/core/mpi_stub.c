/* Stand-ins for the MPI symbols that SUNDIALS 7 archives built with Open MPI
 * refer to from their logger and profiler (BELTSIM_MPI_STUB, off by default).
 * A serial run never calls them; one that does stops at once. Hidden, so that a
 * real MPI in the same process is not disturbed. */
#include <stdlib.h>

#define STUB(name) \
  int name(void);  \
  int name(void) { \
    abort();       \
  }

STUB(MPI_Abort)
STUB(MPI_Comm_dup)
STUB(MPI_Comm_free)
STUB(MPI_Comm_rank)
STUB(MPI_Comm_size)
STUB(MPI_Op_create)
STUB(MPI_Op_free)
STUB(MPI_Reduce)
STUB(MPI_Type_commit)
STUB(MPI_Type_create_resized)
STUB(MPI_Type_create_struct)
STUB(MPI_Type_free)
STUB(MPI_Type_get_extent)

/* only their addresses are compared */
extern char ompi_mpi_comm_null[512], ompi_mpi_double[512], ompi_mpi_long[512];
char ompi_mpi_comm_null[512], ompi_mpi_double[512], ompi_mpi_long[512];
