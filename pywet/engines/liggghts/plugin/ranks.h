// The ranks of a run: what they tell each other, and how they stop together.
#pragma once
#include <mpi.h>

#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace pywet {

// A run that has to stop, known to every rank alike.
struct Stop : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Ranks {
 public:
  MPI_Comm all = MPI_COMM_NULL;
  int me = 0, count = 1;

  void join(MPI_Comm comm);
  bool alone() const { return count == 1; }
  bool first() const { return me == 0; }

  // How many of something all ranks have together. Where any rank met a problem, all stop with the same words.
  int agree(int mine, const std::string &problem) const;

  // Records of all ranks, in order of the ranks.
  template <class T>
  std::vector<T> gathered(const std::vector<T> &mine) const;

  // The same for the first rank alone; nothing for others.
  template <class T>
  std::vector<T> told_first(const std::vector<T> &mine) const;

  // Of all ranks together, on the first.
  template <class T, size_t N>
  void add_up(T (&numbers)[N]) const {
    if (alone()) return;
    const MPI_Datatype type = std::is_same<T, long double>::value ? MPI_LONG_DOUBLE : MPI_DOUBLE;
    MPI_Reduce(first() ? MPI_IN_PLACE : numbers, numbers, N, type, MPI_SUM, 0, all);
  }
};

template <class T>
std::vector<T> Ranks::gathered(const std::vector<T> &mine) const {
  std::vector<int> bytes(count), offset(count, 0);
  const int size = int(mine.size() * sizeof(T));
  MPI_Allgather(&size, 1, MPI_INT, bytes.data(), 1, MPI_INT, all);
  for (int k = 1; k < count; k++) offset[k] = offset[k - 1] + bytes[k - 1];
  std::vector<T> of_all((offset.back() + bytes.back()) / sizeof(T));
  MPI_Allgatherv(mine.data(), size, MPI_BYTE, of_all.data(), bytes.data(), offset.data(), MPI_BYTE, all);
  return of_all;
}

template <class T>
std::vector<T> Ranks::told_first(const std::vector<T> &mine) const {
  if (alone()) return mine;
  std::vector<int> bytes(count), offset(count, 0);
  const int size = int(mine.size() * sizeof(T));
  MPI_Gather(&size, 1, MPI_INT, bytes.data(), 1, MPI_INT, 0, all);
  for (int k = 1; k < count; k++) offset[k] = offset[k - 1] + bytes[k - 1];
  std::vector<T> of_all(first() ? (offset.back() + bytes.back()) / sizeof(T) : 0);
  MPI_Gatherv(mine.data(), size, MPI_BYTE, of_all.data(), bytes.data(), offset.data(), MPI_BYTE, 0, all);
  return of_all;
}

}  // namespace pywet
