// Booking: every rank books the same events in the same order.
#include "bridges.h"

#include <algorithm>
#include <cstring>

namespace pywet {

// One exchange says how many events there are and whether any rank met a problem; then all ranks stop with the same words.
void Bridges::agree(const std::string &problem) {
  int mine[2] = {int(events_.size()), problem.empty() ? 0 : 1}, all[2] = {mine[0], mine[1]};
  if (ranks_ > 1) MPI_Allreduce(mine, all, 2, MPI_INT, MPI_SUM, world_);
  if (all[1] > 0) {
    int from = problem.empty() ? ranks_ : rank_, first = from;
    if (ranks_ > 1) MPI_Allreduce(&from, &first, 1, MPI_INT, MPI_MIN, world_);
    char text[1024] = {};
    if (rank_ == first) std::strncpy(text, problem.c_str(), sizeof(text) - 1);
    MPI_Bcast(text, sizeof(text), MPI_CHAR, first, world_);
    throw Stop(text);
  }
  if (all[0] > 0) gather_events();
}

void Bridges::gather_events() {
  if (ranks_ > 1) events_ = gathered(events_);
  std::sort(events_.begin(), events_.end(), [](const Event &a, const Event &b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    if (a.partner_kind != b.partner_kind) return a.partner_kind < b.partner_kind;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
}

void Bridges::book_formations() {
  std::unordered_map<int, double> asked, asked_wall;
  for (const Event &e : events_)
    if (e.kind == FORMATION) {
      asked[e.i] += e.share_i;
      if (e.partner_kind == SPHERE) asked[e.j] += e.share_j;
      else asked_wall[e.triangle] += e.share_j;
    }
  auto part_of = [](double held, double ask) {  // a film drawn dry may be below zero by its last digit: it gives nothing
    held = std::max(held, 0.0);
    return ask > held ? held / ask : 1.0;
  };
  std::unordered_map<int, double> grant, grant_wall;  // from the films at the start of the step
  for (auto &a : asked) grant[a.first] = part_of(film[a.first], a.second);
  for (auto &a : asked_wall) grant_wall[a.first] = part_of(walls.film[a.first], a.second);
  for (Event &e : events_)
    if (e.kind == FORMATION) {
      e.share_i *= grant[e.i];
      e.share_j *= e.partner_kind == SPHERE ? grant[e.j] : grant_wall[e.triangle];
      e.volume = e.share_i + e.share_j;
      Bridge b = made(e.partner_kind, e.i, e.j, e.volume);
      place(b);
      b.rupture_distance = laws.rupture(e.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j);
      e.rupture_distance = b.rupture_distance;
      b.triangle = e.triangle;
      auto it = proposed_.find(key(e.partner_kind, e.i, e.j));
      if (it != proposed_.end()) {
        b.candidate = it->second;
        (e.partner_kind == SPHERE ? pair_rest_ : wall_rest_)[it->second] = INF;
      }
      add(std::move(b));
      energy_.formed += stored(bridges_.size() - 1, e.separation);
      formations_++;
    }
}

void Bridges::book_ruptures() {
  for (const Event &e : events_)
    if (e.kind == RUPTURE) {
      const uint64_t k = key(e.partner_kind, e.i, e.j);
      const int at = index_.at(k);
      const int c = bridges_[at].candidate;
      if (c >= 0) (e.partner_kind == SPHERE ? pair_rest_ : wall_rest_)[c] = 0;
      energy_.ruptured += stored(at, e.separation);
      index_.erase(k);
      if (at != int(bridges_.size()) - 1) {
        bridges_[at] = std::move(bridges_.back());
        std::copy(prepared_.end() - laws.lines, prepared_.end(), prepared_.begin() + at * laws.lines);
        index_[key(bridges_[at].kind, bridges_[at].i, bridges_[at].j)] = at;
        enter(at);
      }
      bridges_.pop_back();
      prepared_.resize(prepared_.size() - laws.lines);
      standing_[e.i]--;
      if (e.partner_kind == SPHERE) standing_[e.j]--;
      ruptures_++;
    }
}

void Bridges::book() {
  for (Event &e : events_) {
    e.film_i_before = film[e.i];
    e.film_j_before = e.partner_kind == SPHERE ? film[e.j] : walls.film[e.triangle];
  }
  book_formations();
  book_ruptures();
  for (const Event &e : events_) {
    const double sign = e.kind == FORMATION ? -1.0 : 1.0;
    set_film(e.i, film[e.i] + sign * e.share_i);
    if (e.partner_kind == SPHERE) {
      set_film(e.j, film[e.j] + sign * e.share_j);
    } else {
      double &w = walls.film[e.triangle];
      w += sign * e.share_j;
      double &widest = part_thickness_[walls.part_of[e.triangle]];
      widest = std::max(widest, w / walls.area[e.triangle]);
      wall_thicker_ = std::max(wall_thicker_, widest - part_thickness_then_[walls.part_of[e.triangle]]);
    }
  }
  for (Event &e : events_) {
    e.film_i_after = film[e.i];
    e.film_j_after = e.partner_kind == SPHERE ? film[e.j] : walls.film[e.triangle];
    if (rank_ == 0) event_log_.write(e);
  }
  carry();
}

}  // namespace pywet
