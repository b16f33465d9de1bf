#include "liquid_ledger.h"

#include <algorithm>
#include <unordered_map>

namespace pywet {

void LiquidLedger::gather(const std::string &problem) {
  const Communicator &ranks = world_.ranks;
  const Engine &engine = world_.engine;
  const auto at_wall = [](const Event &e) { return e.partner_kind != SPHERE; };
  const int count = int(std::count_if(events.begin(), events.end(), at_wall));
  const auto [all, walls] = ranks.agree({int(events.size()), count}, problem);
  any = all > 0;
  at_walls_ = walls > 0;
  if (any && !ranks.alone()) {
    // if all spheres of an event are inside the domain, no other rank holds an end of it
    const auto boundary = std::stable_partition(events.begin(), events.end(), [&](const Event &e) {
      return !engine.elsewhere(engine.local(e.i)) && (at_wall(e) || !engine.elsewhere(engine.local(e.j)));
    });
    std::vector<Event> at_boundary(boundary, events.end());
    events.erase(boundary, events.end());
    // cppcheck-suppress invalidContainer; iterated over is a copy, made before the elements are erased
    for (const Event &e : ranks.near(at_boundary))
      if (engine.local(e.i) >= 0 || (!at_wall(e) && engine.local(e.j) >= 0)) events.push_back(e);
  }
  std::sort(events.begin(), events.end(), [](const Event &a, const Event &b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    if (a.partner_kind != b.partner_kind) return a.partner_kind < b.partner_kind;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
}

bool LiquidLedger::mine(const Event &e) const { return world_.engine.at.owned(world_.engine.local(e.i)); }

void LiquidLedger::count(const Event &e) {
  if (mine(e)) (e.kind == FORMATION ? standing_.formations : standing_.ruptures)++;
}

std::vector<LiquidLedger::AtWall> LiquidLedger::of_walls(const std::function<double(const Event &)> &part) {
  std::vector<AtWall> sums;
  if (!at_walls_) return sums;
  place_.resize(films_.wall.size(), -1);
  const auto add = [&](int film, double volume) {
    if (place_[film] < 0) {
      place_[film] = int(sums.size());
      sums.push_back(AtWall{film, 0.0});
    }
    sums[place_[film]].volume += volume;
  };
  const auto taken = [&] {
    for (const AtWall &sum : sums) place_[sum.film] = -1;
    return std::move(sums);
  };
  for (const Event &e : events)
    if (e.partner_kind != SPHERE && mine(e)) add(world_.walls.film_of[e.triangle], part(e));
  if (world_.ranks.alone()) return taken();
  const std::vector<AtWall> all = world_.ranks.gathered(taken());
  sums.clear();
  for (const AtWall &sum : all) add(int(sum.film), sum.volume);
  return taken();
}

// If more liquid is requested of a reservoir than it has, the requests are reduced in proportion. What a sphere on another rank
// receives is not computed here.
void LiquidLedger::grant() {
  std::unordered_map<int, double> asked;
  for (const Event &e : events)
    if (e.kind == FORMATION) {
      asked[e.i] += e.share_i;
      if (e.partner_kind == SPHERE) asked[e.j] += e.share_j;
    }
  auto part_of = [](double held, double ask) {  // round-off can make an emptied film slightly negative: it gives nothing
    held = std::max(held, 0.0);
    return ask > held ? held / ask : 1.0;
  };
  std::unordered_map<int, double> granted, granted_wall;  // computed from the films at the start of the step
  for (const auto &[id, volume] : asked) granted[id] = part_of(films_.of(id), volume);
  for (const AtWall &sum : of_walls([](const Event &e) { return e.kind == FORMATION ? e.share_j : 0.0; }))
    granted_wall[int(sum.film)] = part_of(films_.wall[sum.film], sum.volume);
  for (Event &e : events)
    if (e.kind == FORMATION) {
      e.share_i *= granted[e.i];
      e.share_j *= e.partner_kind == SPHERE ? granted[e.j] : granted_wall[world_.walls.film_of[e.triangle]];
      e.volume = e.share_i + e.share_j;
    }
}

void LiquidLedger::apply_formations() {
  for (Event &e : events)
    if (e.kind == FORMATION) {
      Bridge b = standing_.made(e.partner_kind, e.i, e.j, e.volume);
      standing_.place(b);
      count(e);
      if (!b.here) continue;
      b.rupture_distance = standing_.rupture_distance(b);
      e.rupture_distance = b.rupture_distance;
      near_.bridged(b);
      standing_.add(b, BridgeSums{0, 0, e.separation, e.separation});
      if (b.mine) energy_.formed += energy_.stored(standing_.bridges.size() - 1, e.separation);
    }
}

void LiquidLedger::apply_ruptures() {
  for (const Event &e : events)
    if (e.kind != FORMATION) {
      count(e);
      const int k = standing_.find(e.partner_kind, e.i, e.j);
      if (k < 0) continue;
      near_.activate(standing_.bridges[k]);
      if (standing_.bridges[k].mine) energy_.ruptured += energy_.stored(k, e.separation);
      standing_.remove(k);
    }
}

void LiquidLedger::apply_all() {
  auto other_film = [&](const Event &e) { return e.partner_kind == SPHERE ? films_.of(e.j) : films_.at_wall(e.triangle); };
  for (Event &e : events) {
    e.film_i_before = films_.of(e.i);
    e.film_j_before = other_film(e);
  }
  const auto sign = [](const Event &e) { return e.kind == FORMATION ? -1.0 : 1.0; };
  grant();
  const auto gained = of_walls([&](const Event &e) { return sign(e) * e.share_j; });  // first, since it is collective
  apply_formations();
  apply_ruptures();
  for (const Event &e : events) {
    films_.add(e.i, sign(e) * e.share_i);
    if (e.partner_kind == SPHERE) films_.add(e.j, sign(e) * e.share_j);
  }
  for (const AtWall &sum : gained) films_.add_to_wall(int(sum.film), sum.volume);
  for (Event &e : events) {
    e.film_i_after = films_.of(e.i);
    e.film_j_after = other_film(e);
    if (mine(e)) logs_.write(e);
  }
}

void LiquidLedger::apply_events() {
  std::string problem;
  try {
    apply_all();
  } catch (const std::exception &e) {
    problem = e.what();
  }
  world_.ranks.agree({0, 0}, problem);
  weight_.carry(events);
}

}  // namespace pywet
