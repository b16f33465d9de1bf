// Wall parts: geometry at rest, the motion of each mesh taken from the engine, closest points, films per triangle.
#pragma once
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "vec.h"

namespace pywet {

struct Part {
  int mesh = 0;
  std::vector<int> triangles;           // indices into Walls::triangles
  double half_width = 0;                // infinity for a large wall
  double contact_angle = 0;
  int group = 0;                        // index into the transfer tables
  Vec low, high;                        // bounds at rest
};

// A rigid body: x = turn(y) + shift takes the rest position y of a point to the present one.
struct Mesh {
  std::string name;
  int first = 0;                        // its first triangle; the others follow in file order
  int count = 0;                        // of its triangles, the first ones, those that the engine holds
  Vec shift, velocity;                  // velocity: of the point at y = 0
  bool turns = false;
  Turn turn;
  Vec spin;
  Vec to_rest(const Vec &x) const { return turns ? turn.back(x - shift) : x - shift; }
  Vec to_world(const Vec &y) const { return turns ? turn(y) + shift : y + shift; }
  Vec velocity_at(const Vec &x) const { return turns ? velocity + cross(spin, x - shift) : velocity; }
};

// A sphere near a part: the triangles that can be closest while the sphere moves less than `margin` relative to the mesh.
struct Site {
  std::vector<int> near;
  Vec reference;
  double distance_then = -1;            // at `reference`; negative: never evaluated
};

struct Closest {
  Vec point;
  double distance = std::numeric_limits<double>::infinity();
  int triangle = -1;
};

class Walls {
 public:
  std::vector<Triangle> triangles;
  std::vector<double> area, film;
  std::vector<int> part_of;
  std::vector<Part> parts;
  std::vector<Mesh> meshes;

  void finish() {
    area.resize(triangles.size());
    film.assign(triangles.size(), 0.0);
    part_of.resize(triangles.size());
    for (size_t p = 0; p < parts.size(); p++) bound(int(p));
    for (size_t k = 0; k < triangles.size(); k++)
      area[k] = 0.5 * norm(cross(triangles[k].b - triangles[k].a, triangles[k].c - triangles[k].a));
  }

  // Closest point of a part to a centre x, exact; only triangles that can matter are looked at.
  Closest closest(int p, const Vec &x, Site &site, double margin) const {
    const Part &part = parts[p];
    const Mesh &mesh = meshes[part.mesh];
    const Vec y = mesh.to_rest(x);
    Closest best;
    if (site.distance_then >= 0) {
      const Vec moved = y - site.reference;
      if (dot(moved, moved) < margin * margin) {
        for (int k : site.near) consider(k, y, best);
        best.point = mesh.to_world(best.point);
        return best;
      }
    }
    site.near.clear();
    std::vector<double> &distance = scratch_;
    distance.resize(part.triangles.size());
    for (size_t k = 0; k < part.triangles.size(); k++) {
      const double before = best.distance;
      const Vec q = closest_point(y, triangles[part.triangles[k]]);
      distance[k] = norm(y - q);
      if (distance[k] < before) best = Closest{q, distance[k], part.triangles[k]};
    }
    for (size_t k = 0; k < part.triangles.size(); k++)
      if (distance[k] <= best.distance + 2 * margin) site.near.push_back(part.triangles[k]);
    site.reference = y;
    site.distance_then = best.distance;
    best.point = mesh.to_world(best.point);
    return best;
  }

  bool near_bounds(int p, const Vec &x, double reach) const {
    const Part &part = parts[p];
    const Vec y = meshes[part.mesh].to_rest(x);
    return y.x > part.low.x - reach && y.x < part.high.x + reach && y.y > part.low.y - reach &&
           y.y < part.high.y + reach && y.z > part.low.z - reach && y.z < part.high.z + reach;
  }

 private:
  mutable std::vector<double> scratch_;

  void consider(int k, const Vec &y, Closest &best) const {
    const Vec q = closest_point(y, triangles[k]);
    const double d = norm(y - q);
    if (d < best.distance) best = Closest{q, d, k};
  }

  void bound(int p) {
    const double big = std::numeric_limits<double>::infinity();
    Part &part = parts[p];
    part.low = Vec(big, big, big);
    part.high = Vec(-big, -big, -big);
    for (int k : part.triangles) {
      part_of[k] = p;
      for (const Vec *v : {&triangles[k].a, &triangles[k].b, &triangles[k].c}) {
        part.low = Vec(std::min(part.low.x, v->x), std::min(part.low.y, v->y), std::min(part.low.z, v->z));
        part.high = Vec(std::max(part.high.x, v->x), std::max(part.high.y, v->y), std::max(part.high.z, v->z));
      }
    }
  }
};

}  // namespace pywet
