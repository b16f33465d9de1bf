/* What a rank sends and how much processor time it spends within MPI: preloaded, it writes $MPI_ACCOUNT.<rank> at the end.
 *
 *   mpicc -O2 -shared -fPIC -o mpi_account.so mpi_account.c
 */
#define _GNU_SOURCE
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double within;                 /* processor time in MPI [s] */
static long long near_bytes, all_bytes, near_calls, all_calls;  /* to one rank; to or from all */

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static long long size_of(int count, MPI_Datatype type) {
  int size;
  PMPI_Type_size(type, &size);
  return (long long)count * size;
}

#define COUNT(what, count, type) (what##_calls++, what##_bytes += size_of(count, type))
#define TIMED(call) do { const double began = now(); const int status = call; within += now() - began; return status; } while (0)

int MPI_Send(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c) { COUNT(near, n, t); TIMED(PMPI_Send(b, n, t, to, tag, c)); }
int MPI_Rsend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c) { COUNT(near, n, t); TIMED(PMPI_Rsend(b, n, t, to, tag, c)); }
int MPI_Isend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request *r) { COUNT(near, n, t); TIMED(PMPI_Isend(b, n, t, to, tag, c, r)); }
int MPI_Recv(void *b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Status *s) { TIMED(PMPI_Recv(b, n, t, from, tag, c, s)); }
int MPI_Irecv(void *b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Request *r) { TIMED(PMPI_Irecv(b, n, t, from, tag, c, r)); }
int MPI_Sendrecv(const void *b, int n, MPI_Datatype t, int to, int tag, void *rb, int rn, MPI_Datatype rt, int from, int rtag, MPI_Comm c, MPI_Status *s) { COUNT(near, n, t); TIMED(PMPI_Sendrecv(b, n, t, to, tag, rb, rn, rt, from, rtag, c, s)); }
int MPI_Wait(MPI_Request *r, MPI_Status *s) { TIMED(PMPI_Wait(r, s)); }
int MPI_Waitall(int n, MPI_Request *r, MPI_Status *s) { TIMED(PMPI_Waitall(n, r, s)); }
int MPI_Waitany(int n, MPI_Request *r, int *k, MPI_Status *s) { TIMED(PMPI_Waitany(n, r, k, s)); }
int MPI_Barrier(MPI_Comm c) { all_calls++; TIMED(PMPI_Barrier(c)); }
int MPI_Bcast(void *b, int n, MPI_Datatype t, int root, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Bcast(b, n, t, root, c)); }
int MPI_Reduce(const void *b, void *o, int n, MPI_Datatype t, MPI_Op op, int root, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Reduce(b, o, n, t, op, root, c)); }
int MPI_Allreduce(const void *b, void *o, int n, MPI_Datatype t, MPI_Op op, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Allreduce(b, o, n, t, op, c)); }
int MPI_Scan(const void *b, void *o, int n, MPI_Datatype t, MPI_Op op, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Scan(b, o, n, t, op, c)); }
int MPI_Gather(const void *b, int n, MPI_Datatype t, void *o, int on, MPI_Datatype ot, int root, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Gather(b, n, t, o, on, ot, root, c)); }
int MPI_Gatherv(const void *b, int n, MPI_Datatype t, void *o, const int *on, const int *at, MPI_Datatype ot, int root, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Gatherv(b, n, t, o, on, at, ot, root, c)); }
int MPI_Allgather(const void *b, int n, MPI_Datatype t, void *o, int on, MPI_Datatype ot, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Allgather(b, n, t, o, on, ot, c)); }
int MPI_Allgatherv(const void *b, int n, MPI_Datatype t, void *o, const int *on, const int *at, MPI_Datatype ot, MPI_Comm c) { COUNT(all, n, t); TIMED(PMPI_Allgatherv(b, n, t, o, on, at, ot, c)); }
int MPI_Neighbor_allgather(const void *b, int n, MPI_Datatype t, void *o, int on, MPI_Datatype ot, MPI_Comm c) { COUNT(near, n, t); TIMED(PMPI_Neighbor_allgather(b, n, t, o, on, ot, c)); }
int MPI_Neighbor_allgatherv(const void *b, int n, MPI_Datatype t, void *o, const int *on, const int *at, MPI_Datatype ot, MPI_Comm c) { COUNT(near, n, t); TIMED(PMPI_Neighbor_allgatherv(b, n, t, o, on, at, ot, c)); }

__attribute__((destructor)) static void tell(void) {
  const char *name = getenv("MPI_ACCOUNT"), *rank = getenv("OMPI_COMM_WORLD_RANK");
  char path[4096];
  FILE *file;
  if (!name || near_calls + all_calls < 10) return;
  snprintf(path, sizeof path, "%s.%s", name, rank ? rank : "0");
  if (!(file = fopen(path, "w"))) return;
  fprintf(file, "{\"mpi_s\": %.9g, \"near_calls\": %lld, \"near_B\": %lld, \"all_calls\": %lld, \"all_B\": %lld}\n", within, near_calls, near_bytes,
          all_calls, all_bytes);
  fclose(file);
}
