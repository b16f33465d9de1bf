#include "analytic_wires.h"

#include <algorithm>

namespace pywet {

void AnalyticWires::arrange() {
  shift_then_.resize(world_.walls.meshes.size());
  for (size_t w = 0; w < parts.size(); w++) {
    const AnalyticWire &p = parts[w];
    Weave *found = nullptr;
    for (Weave &weave : weaves_)
      if (weave.mesh == p.mesh && weave.axis == p.along) found = &weave;
    if (!found) {
      weaves_.push_back(Weave{p.mesh, p.along, false, 0.0, {}, {}});
      found = &weaves_.back();
    }
    found->wires.push_back(int(w));
    found->widest = std::max(found->widest, p.round);
  }
  for (Weave &weave : weaves_) {
    double least[2] = {INF, INF}, most[2] = {-INF, -INF};
    for (int w : weave.wires)
      for (int m = 0; m < 2; m++) {
        least[m] = std::min(least[m], parts[w].middle[m]);
        most[m] = std::max(most[m], parts[w].middle[m]);
      }
    weave.second = most[1] - least[1] > most[0] - least[0];
    std::sort(weave.wires.begin(), weave.wires.end(), [&](int a, int b) {
      return parts[a].middle[weave.second] < parts[b].middle[weave.second];
    });
    for (int w : weave.wires) weave.place.push_back(parts[w].middle[weave.second]);
  }
}

// Between two checks of one neighbour list a sphere moves less than one skin and a mesh less than half of one.
bool AnalyticWires::moved() const {
  for (const Weave &weave : weaves_)
    if (norm(world_.walls.meshes[weave.mesh].shift - shift_then_[weave.mesh]) > 0.5 * world_.engine.skin) return true;
  return false;
}

void AnalyticWires::find() {
  const View &at = world_.engine.at;
  const std::vector<Mesh> &meshes = world_.walls.meshes;
  std::vector<WireSpring> known = springs();
  if (!world_.ranks.alone()) known = world_.ranks.near(known);
  std::sort(known.begin(), known.end());
  saved_.clear();
  candidates_.clear();
  for (const Weave &weave : weaves_) shift_then_[weave.mesh] = meshes[weave.mesh].shift;
  for (int a = 0; a < at.nlocal; a++) {
    const int id = at.tag[a];
    const double reach = world_.spheres.radius(id) + 1.5 * world_.engine.skin;
    for (const Weave &weave : weaves_) {
      double y[3];
      store(meshes[weave.mesh].to_rest(Vec(at.x[a])), y);
      const double place = y[(weave.axis + 1 + weave.second) % 3], far = reach + weave.widest;
      const auto begin = weave.place.begin();
      for (size_t k = std::lower_bound(begin, weave.place.end(), place - far) - begin;
           k < weave.place.size() && weave.place[k] < place + far; k++) {
        if (!parts[weave.wires[k]].near(y, reach)) continue;
        Candidate c{a, id, weave.wires[k], {0, 0, 0}};
        const WireSpring wanted{id, c.wire, {}};
        const auto spring = std::lower_bound(known.begin(), known.end(), wanted);
        if (spring != known.end() && !(wanted < *spring)) std::copy(spring->spring, spring->spring + 3, c.spring);
        candidates_.push_back(c);
      }
    }
  }
}

std::vector<WireSpring> AnalyticWires::springs() const {
  std::vector<WireSpring> here = saved_;
  for (const Candidate &c : candidates_)
    if (c.spring[0] != 0 || c.spring[1] != 0 || c.spring[2] != 0)
      here.push_back(WireSpring{c.id, c.wire, {c.spring[0], c.spring[1], c.spring[2]}});
  return here;
}

void AnalyticWires::take_up(const std::vector<WireSpring> &springs) {
  for (const WireSpring &s : springs)
    if (s.wire >= 0) saved_.push_back(s);
}

// The spring of a sphere that no longer touches is deleted.
void AnalyticWires::touch(bool fresh) {
  if (parts.empty()) return;
  const bool log = world_.clock.logs_contacts();
  if (fresh || moved() || log) find();  // also in logged steps, so that the replay sees the stored springs
  const View &at = world_.engine.at;
  for (Candidate &c : candidates_) {
    const AnalyticWire &wire = parts[c.wire];
    const Mesh &mesh = world_.walls.meshes[wire.mesh];
    const double r = world_.spheres.radius(c.id);
    double y[3], q[3];
    store(mesh.to_rest(Vec(at.x[c.a])), y);
    bool touches = wire.near(y, r);
    if (touches && !wire.closest(y, q))
      throw std::runtime_error("the centre of sphere " + std::to_string(c.id) + " is inside a wire of mesh " + mesh.name +
                               " at step " + std::to_string(world_.clock.now) + "; likely too large a time step or too soft a contact");
    if (touches) {
      const Vec point = mesh.to_world(Vec(q)), d = Vec(at.x[c.a]) - point, velocity = mesh.velocity_at(point);
      const double distance = norm(d);
      touches = distance <= r;
      if (touches)
        energy_.wall_power[CONTACT] += dot(world_.engine.press(c.a, r, d, r - distance, velocity, c.spring), velocity);
    }
    if (!touches) c.spring[0] = c.spring[1] = c.spring[2] = 0;
    else if (log)
      logs_.write(WireContact{world_.clock.now, wire.wall, wire.triangle, c.id, 0, {c.spring[0], c.spring[1], c.spring[2]}});
  }
}

}  // namespace pywet
