// MPI communication between the ranks of a run, and a common stop.
#pragma once
#include <mpi.h>

#include <array>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace pywet {

// Exception that stops the run; all ranks throw it with the same message.
struct Stop : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// MPI type of a record: counts are numbers of records, so that they do not overflow in large beds.
template <class T>
struct Whole {
  MPI_Datatype type;
  Whole() {
    MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
    MPI_Type_commit(&type);
  }
  ~Whole() { MPI_Type_free(&type); }
};

class Communicator {
 public:
  MPI_Comm all = MPI_COMM_NULL;
  int me = 0, count = 1;
  int neighbour[2][2] = {};              // neighbouring ranks below and above along x and y; MPI_PROC_NULL: none
  int hops[2][2] = {};                   // number of ranks below and above along x and y that may hold a sphere of this one

  void join(MPI_Comm comm);
  bool alone() const { return count == 1; }
  bool first() const { return me == 0; }

  // Gathers two quantities over all ranks. If any rank reports a problem, all stop with the same message.
  std::array<int, 2> agree(const std::array<int, 2> &mine, const std::string &problem) const;

  // Records of all ranks that share an end with this one, and possibly of more; its own first.
  template <class T>
  std::vector<T> near(std::vector<T> mine) const;

  // Records of all ranks, in the order of the ranks.
  template <class T>
  std::vector<T> gathered(const std::vector<T> &mine) const;

  // The same on the first rank only; empty on others.
  template <class T>
  std::vector<T> gathered_first(const std::vector<T> &mine) const;

  // Sum over all ranks, on the first rank.
  template <class T, size_t N>
  void add_up(T (&numbers)[N]) const {
    if (alone()) return;
    const MPI_Datatype type = std::is_same<T, long double>::value ? MPI_LONG_DOUBLE : MPI_DOUBLE;
    MPI_Reduce(first() ? MPI_IN_PLACE : numbers, numbers, N, type, MPI_SUM, 0, all);
  }

 private:
  template <class T>
  std::vector<T> passed_on(const std::vector<T> &records, int to, int from) const;
};

template <class T>
std::vector<T> Communicator::gathered(const std::vector<T> &mine) const {
  const Whole<T> whole;
  std::vector<int> sizes(count), offset(count, 0);
  const int size = int(mine.size());
  MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, all);
  for (int k = 1; k < count; k++) offset[k] = offset[k - 1] + sizes[k - 1];
  std::vector<T> of_all(offset.back() + sizes.back());
  MPI_Allgatherv(mine.data(), size, whole.type, of_all.data(), sizes.data(), offset.data(), whole.type, all);
  return of_all;
}

// First along x, then along y including what was received along x, as the engine exchanges ghosts.
template <class T>
std::vector<T> Communicator::near(std::vector<T> mine) const {
  for (int axis : {0, 1}) {
    std::vector<T> down = mine, up = mine;
    for (int hop = 0; hop < hops[axis][0]; hop++) {
      down = passed_on(down, neighbour[axis][0], neighbour[axis][1]);
      mine.insert(mine.end(), down.begin(), down.end());
      if (hop >= hops[axis][1]) continue;
      up = passed_on(up, neighbour[axis][1], neighbour[axis][0]);
      mine.insert(mine.end(), up.begin(), up.end());
    }
  }
  return mine;
}

template <class T>
std::vector<T> Communicator::passed_on(const std::vector<T> &records, int to, int from) const {
  const Whole<T> whole;
  const int size = int(records.size());
  int coming = 0;                        // remains zero without a neighbour
  MPI_Sendrecv(&size, 1, MPI_INT, to, 0, &coming, 1, MPI_INT, from, 0, all, MPI_STATUS_IGNORE);
  std::vector<T> come(coming);
  MPI_Sendrecv(records.data(), size, whole.type, to, 1, come.data(), coming, whole.type, from, 1, all, MPI_STATUS_IGNORE);
  return come;
}

template <class T>
std::vector<T> Communicator::gathered_first(const std::vector<T> &mine) const {
  if (alone()) return mine;
  const Whole<T> whole;
  std::vector<int> sizes(count), offset(count, 0);
  const int size = int(mine.size());
  MPI_Gather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, all);
  for (int k = 1; k < count; k++) offset[k] = offset[k - 1] + sizes[k - 1];
  std::vector<T> of_all(first() ? offset.back() + sizes.back() : 0);
  MPI_Gatherv(mine.data(), size, whole.type, of_all.data(), sizes.data(), offset.data(), whole.type, 0, all);
  return of_all;
}

}  // namespace pywet
