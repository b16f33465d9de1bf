#include "communicator.h"

#include <cstring>

namespace pywet {

void Communicator::join(MPI_Comm comm) {
  all = comm;
  MPI_Comm_rank(all, &me);
  MPI_Comm_size(all, &count);
}

std::array<int, 2> Communicator::agree(const std::array<int, 2> &mine, const std::string &problem) const {
  int sum[3] = {mine[0], mine[1], problem.empty() ? 0 : 1};
  if (!alone()) MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPI_INT, MPI_SUM, all);
  if (sum[2] == 0) return {sum[0], sum[1]};
  int from = problem.empty() ? count : me, speaker = from;
  if (!alone()) MPI_Allreduce(&from, &speaker, 1, MPI_INT, MPI_MIN, all);
  char text[1024] = {};
  if (me == speaker) std::strncpy(text, problem.c_str(), sizeof(text) - 1);
  MPI_Bcast(text, sizeof(text), MPI_CHAR, speaker, all);
  throw Stop(text);
}

}  // namespace pywet
