// The liquid of a deleted sphere is removed from the ledger at the end of the step, after all other events, which use the films at its start.
#include "turnover.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace pywet {

static const double ROUNDING = 1e-9;     // relative error up to which the liquid of a restart file is complete

static const auto BY_ID = [](const RetiredSphere &p, const RetiredSphere &q) { return p.id < q.id; };

// The record with this id in a sorted list, or null.
static RetiredSphere *among(std::vector<RetiredSphere> &list, int id) {
  RetiredSphere wanted = {};
  wanted.id = id;
  const auto found = std::lower_bound(list.begin(), list.end(), wanted, BY_ID);
  return found != list.end() && found->id == id ? &*found : nullptr;
}

RetiredSphere *Turnover::went(int id) { return among(gone_, id); }

void Turnover::begin() {
  if (!world_.rules.scripted) return;
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) at.liquid[a][ENTERS] = 1;
  keep();
}

void Turnover::keep() {
  const View &at = world_.engine.at;
  kept_.resize(at.nlocal);
  for (int a = 0; a < at.nlocal; a++) {
    RetiredSphere &s = kept_[a];
    s.id = at.tag[a];
    s.type = world_.spheres.type_of[s.id];
    s.film = films_.volume(a);
    store(Vec(at.x[a]), s.x);
    store(Vec(at.v[a]), s.v);
  }
}

void Turnover::look() {
  const View &at = world_.engine.at;
  std::vector<Newcomer> come;
  for (int a = 0; a < at.nlocal; a++)
    if (!known(a)) {
      come.push_back(Newcomer{at.tag[a], at.type[a], at.radius[a], at.mass[a], {}});
      store(Vec(at.x[a]), come.back().x);
    }
  int64_t here[2] = {at.nlocal, int64_t(come.size())}, all[2] = {here[0], here[1]};
  if (!world_.ranks.alone()) MPI_Allreduce(here, all, 2, MPI_INT64_T, MPI_SUM, world_.ranks.all);
  if (all[0] - all[1] != present()) find_gone();
  if (all[1] > 0) take_in(world_.ranks.gathered(come));
  keep();  // of the spheres that are on this rank now; further set-ups may follow before the next step
}

void Turnover::find_gone() {
  const View &at = world_.engine.at;
  std::vector<int> mine(world_.spheres.ids(), 0), seen(mine.size(), 0);
  for (int a = 0; a < at.nlocal; a++)
    if (known(a)) mine[at.tag[a]] = 1;
  MPI_Allreduce(mine.data(), seen.data(), int(mine.size()), MPI_INT, MPI_MAX, world_.ranks.all);
  std::vector<RetiredSphere> gone;
  for (const RetiredSphere &s : kept_)
    if (!seen[s.id]) gone.push_back(s);
  gone = world_.ranks.gathered(gone);
  std::sort(gone.begin(), gone.end(), BY_ID);
  std::sort(kept_.begin(), kept_.end(), BY_ID);
  end_bridges(gone);
  gone_.insert(gone_.end(), gone.begin(), gone.end());
  std::sort(gone_.begin(), gone_.end(), BY_ID);
  std::vector<int64_t> &retired = world_.spheres.retired;
  for (const RetiredSphere &s : gone) retired.push_back(s.id);
  std::sort(retired.begin(), retired.end());
  world_.spheres.count -= int64_t(gone.size());
}

// The rank that counted a bridge in the last step reports it completely, with its ends as they were then; the second may have been on
// another rank, which has the bridge too.
void Turnover::end_bridges(std::vector<RetiredSphere> gone) {
  const auto lost = [&](const Bridge &b) { return among(gone, b.i) || (b.kind == SPHERE && among(gone, b.j)); };
  std::vector<RetiredSphere> ends;
  for (const Bridge &b : standing_.bridges)
    for (const int id : {b.i, b.kind == SPHERE ? b.j : b.i})
      if (const RetiredSphere *s = lost(b) ? among(kept_, id) : nullptr) ends.push_back(*s);
  ends = world_.ranks.gathered(ends);
  std::sort(ends.begin(), ends.end(), BY_ID);
  std::vector<Event> ended;
  for (const Bridge &b : standing_.bridges) {
    if (!b.mine || !lost(b)) continue;
    const RetiredSphere *i = among(ends, b.i), *j = b.kind == SPHERE ? among(ends, b.j) : nullptr;
    Event e = {};
    e.time = world_.clock.time; e.kind = RETIREMENT; e.partner_kind = b.kind;
    e.i = b.i; e.j = b.j; e.triangle = -1;
    e.volume = b.volume;
    e.share_i = standing_.share(b);
    e.share_j = b.volume - e.share_i;
    e.rupture_distance = b.rupture_distance;
    if (b.kind != SPHERE) {
      const Closest closest = world_.walls.closest(Vec(i->x), standing_.sites[b.site]);
      e.triangle = closest.triangle;
      e.separation = closest.distance - b.radius_i;
      e.speed = norm(Vec(i->v) - world_.walls.mesh_of(b.j).velocity_at(closest.on_wall()));
    } else {
      e.separation = norm(world_.engine.at.images.nearest(Vec(i->x) - Vec(j->x))) - b.radius_i - b.radius_j;
      e.speed = norm(Vec(i->v) - Vec(j->v));
    }
    ended.push_back(e);
    standing_.ruptures++;
  }
  ended = world_.ranks.gathered(ended);
  for (const Event &e : ended)
    if (const int k = standing_.find(e.partner_kind, e.i, e.j); k >= 0) standing_.remove(k);
  ended_.insert(ended_.end(), ended.begin(), ended.end());
}

void Turnover::take_in(std::vector<Newcomer> all) {
  Spheres &spheres = world_.spheres;
  std::sort(all.begin(), all.end(), [](const Newcomer &p, const Newcomer &q) { return p.id < q.id; });
  for (const Newcomer &s : all)
    if (spheres.exists(s.id))
      throw Stop("sphere " + std::to_string(s.id) + " came before step " + std::to_string(world_.clock.now) +
                 " with the number of one that has been there; expected new numbers: insert before the newest spheres are deleted");
  const int64_t from = world_.clock.now + (world_.clock.again ? 1 : 0);
  std::vector<int> types(all.size());
  std::vector<double> films(all.size());
  enter(int(all.size()), from, all.data(), types.data(), films.data());
  long double sum = films_.initial;
  for (size_t k = 0; k < all.size(); k++) {
    spheres.type_of.resize(std::max(spheres.ids(), size_t(all[k].id) + 1));
    spheres.type_of[all[k].id] = types[k];
    sum += films[k];
    if (const int a = world_.engine.local(all[k].id); world_.engine.at.owned(a)) films_.enter(a, films[k], std::max(from, int64_t(1)));
  }
  films_.initial = double(sum);
  spheres.count += int64_t(all.size());
}

// Counts, wall films, bridges, in this order; the films on spheres are in p_liquid.
std::vector<double> Turnover::serialized() const {
  int64_t here[2] = {standing_.formations, standing_.ruptures}, all[2];
  MPI_Allreduce(here, all, 2, MPI_INT64_T, MPI_SUM, world_.ranks.all);
  const std::vector<BridgeRecord> bridges = world_.ranks.gathered_first(standing_.mine());
  const size_t walls = films_.wall.size(), each = sizeof(BridgeRecord) / sizeof(double);
  std::vector<double> values{films_.initial, films_.left, films_.retired, double(all[0]), double(all[1]), double(walls)};
  values.insert(values.end(), films_.wall.begin(), films_.wall.end());
  values.resize(values.size() + each * bridges.size());
  if (!bridges.empty()) std::memcpy(&values[values.size() - each * bridges.size()], bridges.data(), sizeof(BridgeRecord) * bridges.size());
  return values;
}

void Turnover::resume(const std::vector<double> &values) {
  double here[2] = {films_.begun, films_.restored ? 1.0 : 0.0};
  double all[2] = {here[0], here[1]};
  if (!world_.ranks.alone()) MPI_Allreduce(here, all, 2, MPI_DOUBLE, MPI_SUM, world_.ranks.all);
  if (values.empty()) {
    if (all[1] > 0)
      throw std::runtime_error("the restart file holds films of spheres, and bridges of a fix pywet with another ID; expected "
                               "the same ID in this script as in the one that wrote the file");
    return;
  }
  const size_t walls = size_t(values[5]), each = sizeof(BridgeRecord) / sizeof(double), n = (values.size() - 6 - walls) / each;
  if (walls != films_.wall.size())
    throw std::runtime_error("the restart file holds films on " + std::to_string(walls) + " triangles of walls; expected the " +
                             std::to_string(films_.wall.size()) + " of this script: name the same walls in the liquid's file");
  films_.initial = values[0] + all[0]; films_.left = values[1]; films_.retired = values[2];
  if (world_.ranks.first()) standing_.formations = int64_t(values[3]), standing_.ruptures = int64_t(values[4]);
  std::copy(&values[6], &values[6] + walls, films_.wall.begin());
  std::shared_ptr<BridgeRecord> bridges(new BridgeRecord[n + 1], std::default_delete<BridgeRecord[]>());
  std::memcpy(static_cast<void *>(bridges.get()), values.data() + 6 + walls, sizeof(BridgeRecord) * n);
  refuse_incomplete(bridges.get(), n);
  standing_.expect(bridges, int64_t(n));
}

// A restart file that was written between a deletion and the next step lacks liquid of deleted spheres or has their bridges.
void Turnover::refuse_incomplete(const BridgeRecord *bridges, size_t n) const {
  const View &at = world_.engine.at;
  bool whole = true;
  double here = 0, held = 0;
  for (int a = 0; a < at.nlocal; a++) here += films_.volume(a);
  MPI_Allreduce(&here, &held, 1, MPI_DOUBLE, MPI_SUM, world_.ranks.all);
  held += films_.left + films_.retired;
  for (double wall : films_.wall) held += wall;
  for (const BridgeRecord *b = bridges; b < bridges + n; b++) {
    held += b->volume;
    whole = whole && standing_.has_ends(*b);
  }
  if (!whole || std::fabs(held - films_.initial) > ROUNDING * films_.initial)
    throw std::runtime_error("the restart file lacks liquid of spheres that were deleted or holds their bridges; expected one "
                             "written after a step that follows the deletion: put `run 1` before `write_restart`");
}

// All ranks know what a wall receives; the rank with the remaining end writes the event, otherwise the first rank.
void Turnover::apply_events() {
  if (world_.clock.again) return;
  const Engine &engine = world_.engine;
  const auto film = [&](int id) {
    const RetiredSphere *s = went(id);
    return s ? s->film : films_.of(id);
  };
  const auto other = [&](const Event &e) { return e.partner_kind == SPHERE ? film(e.j) : films_.at_wall(e.triangle); };
  std::sort(ended_.begin(), ended_.end(), [](const Event &a, const Event &b) {
    if (a.partner_kind != b.partner_kind) return a.partner_kind < b.partner_kind;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
  for (Event &e : ended_) {
    e.step = world_.clock.now;
    e.time = world_.clock.time;
    e.film_i_before = film(e.i);
    e.film_j_before = other(e);
  }
  const auto give = [&](int id, double volume) {
    if (RetiredSphere *s = went(id)) s->film += volume;
    else films_.add(id, volume);
  };
  for (const Event &e : ended_) {
    give(e.i, e.share_i);
    if (e.partner_kind == SPHERE) give(e.j, e.share_j);
    else films_.add_to_wall(world_.walls.film_of[e.triangle], e.share_j);
  }
  for (Event &e : ended_) {
    e.film_i_after = film(e.i);
    e.film_j_after = other(e);
    const int left = !went(e.i) ? e.i : e.partner_kind == SPHERE && !went(e.j) ? e.j : 0;
    if (left ? engine.at.owned(engine.local(left)) : world_.ranks.first()) logs_.write(e);
  }
  long double sum = films_.retired;
  for (RetiredSphere &s : gone_) {
    s.step = world_.clock.now;
    s.time = world_.clock.time;
    sum += s.film;
    logs_.write(s);
  }
  films_.retired = double(sum);
  ended_.clear();
  gone_.clear();
  keep();
}

}  // namespace pywet
