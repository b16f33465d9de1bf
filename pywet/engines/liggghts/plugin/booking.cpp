#include "booking.h"

#include <algorithm>
#include <unordered_map>

namespace pywet {

void Booking::gather(const std::string &problem) {
  const Ranks &ranks = world_.ranks;
  const auto between_spheres = [](const Event &e) { return e.partner_kind == SPHERE; };
  const auto apart = std::stable_partition(events.begin(), events.end(), between_spheres);
  std::vector<Event> at_walls(apart, events.end());
  const auto [all, walls] = ranks.agree({int(events.size()), int(at_walls.size())}, problem);
  any = all > 0;
  if (!ranks.alone()) {
    events.erase(apart, events.end());
    if (all > walls) events = ranks.near(events);
    const auto elsewhere = [&](const Event &e) { return world_.engine.local(e.i) < 0 && world_.engine.local(e.j) < 0; };
    events.erase(std::remove_if(events.begin(), events.end(), elsewhere), events.end());
    if (walls > 0) at_walls = ranks.gathered(at_walls);
    events.insert(events.end(), at_walls.begin(), at_walls.end());
  }
  std::sort(events.begin(), events.end(), [](const Event &a, const Event &b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    if (a.partner_kind != b.partner_kind) return a.partner_kind < b.partner_kind;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
}

bool Booking::mine(const Event &e) const { return world_.engine.at.owned(world_.engine.local(e.i)); }

void Booking::count(const Event &e) {
  if (mine(e)) (e.kind == FORMATION ? standing_.formations : standing_.ruptures)++;
}

// What is granted to a sphere that is not here is not known, and not asked for.
void Booking::book_formations() {
  std::unordered_map<int, double> asked, asked_wall;
  for (const Event &e : events)
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
  for (auto &a : asked) grant[a.first] = part_of(films_.of(a.first), a.second);
  for (auto &a : asked_wall) grant_wall[a.first] = part_of(films_.wall[a.first], a.second);
  for (Event &e : events)
    if (e.kind == FORMATION) {
      e.share_i *= grant[e.i];
      e.share_j *= e.partner_kind == SPHERE ? grant[e.j] : grant_wall[e.triangle];
      e.volume = e.share_i + e.share_j;
      Bridge b = standing_.made(e.partner_kind, e.i, e.j, e.volume);
      standing_.place(b);
      count(e);
      if (!b.here) continue;
      b.rupture_distance = world_.laws.rupture(e.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j);
      e.rupture_distance = b.rupture_distance;
      near_.bridged(b);
      standing_.add(b);
      if (b.mine) energy_.formed += energy_.stored(standing_.bridges.size() - 1, e.separation);
    }
}

void Booking::book_ruptures() {
  for (const Event &e : events)
    if (e.kind == RUPTURE) {
      count(e);
      const int k = standing_.find(e.partner_kind, e.i, e.j);
      if (k < 0) continue;
      near_.wake(standing_.bridges[k]);
      if (standing_.bridges[k].mine) energy_.ruptured += energy_.stored(k, e.separation);
      standing_.remove(k);
    }
}

void Booking::book_all() {
  auto other_film = [&](const Event &e) { return e.partner_kind == SPHERE ? films_.of(e.j) : films_.wall[e.triangle]; };
  for (Event &e : events) {
    e.film_i_before = films_.of(e.i);
    e.film_j_before = other_film(e);
  }
  book_formations();
  book_ruptures();
  for (const Event &e : events) {
    const double sign = e.kind == FORMATION ? -1.0 : 1.0;
    films_.add(e.i, sign * e.share_i);
    if (e.partner_kind == SPHERE) films_.add(e.j, sign * e.share_j);
    else films_.add_to_wall(e.triangle, sign * e.share_j);
  }
  for (Event &e : events) {
    e.film_i_after = films_.of(e.i);
    e.film_j_after = other_film(e);
    if (mine(e)) logs_.write(e);
  }
}

void Booking::book() {
  std::string problem;
  try {
    book_all();
  } catch (const std::exception &e) {
    problem = e.what();
  }
  world_.ranks.agree({0, 0}, problem);
  weight_.carry(events);
}

}  // namespace pywet
