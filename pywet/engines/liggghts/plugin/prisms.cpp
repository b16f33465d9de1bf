// Dry contacts with wires that are prisms: the engine's own law at the closest point, one spring for each sphere and wire.
#include "prisms.h"

#include "bridges.h"

namespace pywet {

// Groups parallel wires of a mesh, in order across.
void Bridges::arrange_wires() {
  shift_then_.resize(walls.meshes.size());
  for (size_t w = 0; w < prisms.size(); w++) {
    const Prism &p = prisms[w];
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
        least[m] = std::min(least[m], prisms[w].middle[m]);
        most[m] = std::max(most[m], prisms[w].middle[m]);
      }
    weave.second = most[1] - least[1] > most[0] - least[0];
    std::sort(weave.wires.begin(), weave.wires.end(), [&](int a, int b) {
      return prisms[a].middle[weave.second] < prisms[b].middle[weave.second];
    });
    for (int w : weave.wires) weave.place.push_back(prisms[w].middle[weave.second]);
  }
}

// A sphere moves less than one skin between two looks at the same neighbour list, a mesh half of one before the next look.
bool Bridges::wires_moved() const {
  for (const Weave &weave : weaves_)
    if (norm(walls.meshes[weave.mesh].shift - shift_then_[weave.mesh]) > 0.5 * skin()) return true;
  return false;
}

void Bridges::find_wire_candidates() {
  const std::vector<WireSpring> known = wire_springs();
  saved_springs_.clear();
  wire_candidates_.clear();
  for (const Weave &weave : weaves_) shift_then_[weave.mesh] = walls.meshes[weave.mesh].shift;
  for (int a = 0; a < at_.nlocal; a++) {
    const int id = at_.tag[a];
    const double reach = radius(id) + 1.5 * skin();
    for (const Weave &weave : weaves_) {
      double y[3];
      store(walls.meshes[weave.mesh].to_rest(Vec(at_.x[a])), y);
      const double place = y[(weave.axis + 1 + weave.second) % 3], far = reach + weave.widest;
      const auto begin = weave.place.begin();
      for (size_t k = std::lower_bound(begin, weave.place.end(), place - far) - begin;
           k < weave.place.size() && weave.place[k] < place + far; k++) {
        if (!prisms[weave.wires[k]].near(y, reach)) continue;
        WireCandidate c{a, id, weave.wires[k], {0, 0, 0}};
        const WireSpring wanted{id, c.wire, {}};
        const auto spring = std::lower_bound(known.begin(), known.end(), wanted);
        if (spring != known.end() && !(wanted < *spring)) std::copy(spring->spring, spring->spring + 3, c.spring);
        wire_candidates_.push_back(c);
      }
    }
  }
}

// All springs that are not zero, of all ranks, sorted; just after a resumption those of the checkpoint.
std::vector<WireSpring> Bridges::wire_springs() const {
  std::vector<WireSpring> all = saved_springs_, mine;
  for (const WireCandidate &c : wire_candidates_)
    if (c.spring[0] != 0 || c.spring[1] != 0 || c.spring[2] != 0)
      mine.push_back(WireSpring{c.id, c.wire, {c.spring[0], c.spring[1], c.spring[2]}});
  if (ranks_ > 1) mine = gathered(mine);
  all.insert(all.end(), mine.begin(), mine.end());
  std::sort(all.begin(), all.end());
  return all;
}

// After the engine's own contacts, before the bridges. A sphere that no longer touches loses its spring.
void Bridges::touch_wires(bool fresh, bool log) {
  if (prisms.empty()) return;
  if (fresh || wires_moved()) find_wire_candidates();
  for (WireCandidate &c : wire_candidates_) {
    const Prism &wire = prisms[c.wire];
    const Mesh &mesh = walls.meshes[wire.mesh];
    const double r = radius(c.id);
    double y[3], q[3];
    store(mesh.to_rest(Vec(at_.x[c.a])), y);
    bool touches = wire.near(y, r);
    if (touches && !wire.closest(y, q))
      throw std::runtime_error("the centre of sphere " + std::to_string(c.id) + " is inside a wire of mesh " + mesh.name +
                               " at step " + std::to_string(now_) + "; likely too large a time step or too soft a contact");
    if (touches) {
      const Vec point = mesh.to_world(Vec(q)), d = Vec(at_.x[c.a]) - point, velocity = mesh.velocity_at(point);
      const double distance = norm(d);
      touches = distance <= r;
      if (touches) energy_.wall_power[CONTACT] += dot(press(c.a, r, d, distance, velocity, c.spring), velocity);
    }
    if (!touches) c.spring[0] = c.spring[1] = c.spring[2] = 0;
    else if (log) wire_log_.write(WireContact{now_, wire.wall, wire.triangle, c.id, 0, {c.spring[0], c.spring[1], c.spring[2]}});
  }
}

}  // namespace pywet
