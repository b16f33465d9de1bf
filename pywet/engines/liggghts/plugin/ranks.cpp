#include "ranks.h"

#include <cstring>

namespace pywet {

void Ranks::join(MPI_Comm comm) {
  all = comm;
  MPI_Comm_rank(all, &me);
  MPI_Comm_size(all, &count);
}

int Ranks::agree(int mine, const std::string &problem) const {
  int own[2] = {mine, problem.empty() ? 0 : 1}, sum[2] = {own[0], own[1]};
  if (!alone()) MPI_Allreduce(own, sum, 2, MPI_INT, MPI_SUM, all);
  if (sum[1] == 0) return sum[0];
  int from = problem.empty() ? count : me, speaker = from;
  if (!alone()) MPI_Allreduce(&from, &speaker, 1, MPI_INT, MPI_MIN, all);
  char text[1024] = {};
  if (me == speaker) std::strncpy(text, problem.c_str(), sizeof(text) - 1);
  MPI_Bcast(text, sizeof(text), MPI_CHAR, speaker, all);
  throw Stop(text);
}

}  // namespace pywet
