// Wall parts: geometry at rest, motion of each mesh as given by the engine, closest points.
#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "vec.h"

namespace pywet {

struct Bounds {
  Vec low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void widen(const Vec &v) {
    low = Vec(std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z));
    high = Vec(std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z));
  }
};

struct Part {
  int mesh = 0;
  std::vector<int> triangles;           // indices into Walls::triangles
  std::vector<int> border;              // triangles that share a corner with another part of the mesh
  double half_width = 0;                // infinity for a large wall
  double contact_angle = 0;
  int group = 0;                        // index into the transfer tables
  Bounds bounds;                        // bounding box at rest
};

// A rigid body: x = turn(y) + shift takes the rest position y of a point to the present one.
struct Mesh {
  std::string name;
  int first = 0;                        // its first triangle; the others follow in file order
  int count = 0;                        // number of its triangles that the engine holds, the first ones
  Vec shift, velocity;                  // velocity: of the point at y = 0
  Bounds bounds, extent;                // bounding boxes at rest, of its parts and of all its triangles
  int triangles = 0;
  bool turns = false;
  Turn turn;
  Vec spin;
  bool whole() const { return count == triangles; }  // otherwise its contacts are those of analytic wires
  Vec to_rest(const Vec &x) const { return turns ? turn.back(x - shift) : x - shift; }
  Vec to_world(const Vec &y) const { return turns ? turn(y) + shift : y + shift; }
  Vec velocity_at(const Vec &x) const { return turns ? velocity + cross(spin, x - shift) : velocity; }
};

// Sphere near a part: the triangles that can be the closest while the sphere moves less than Walls::margin relative to the mesh, and
// their distances at `reference`. Corners are copied, since reading them from the mesh would miss the cache. In most cases there is
// only one triangle.
struct Site {
  struct Near {
    double distance;
    int triangle;
    bool operator<(const Near &o) const { return distance != o.distance ? distance < o.distance : triangle < o.triangle; }
  };
  struct Other {
    Near near;
    Triangle corners;
  };
  int part, mesh;
  int first = -1;                       // the nearest triangle
  Vec reference;
  double distance_then = -1;            // distance of the nearest; negative: never evaluated
  double second = std::numeric_limits<double>::infinity();  // distance of the second nearest
  Triangle nearest{};
  std::vector<Other> others;            // sorted by distance
  std::vector<Site> copies;             // the same for periodic images of the part that came near
  int copy = 0;                         // its number among all images

  Site(int part, int mesh) : part(part), mesh(mesh) {}
};

struct Closest {
  Vec point;
  double distance = std::numeric_limits<double>::infinity();
  int triangle = -1;
  Vec back;                             // displacement from the periodic image to the wall itself
  Vec on_wall() const { return point + back; }
};

// Area over which the liquid of a wall spreads at once, so that its thickness is uniform there.
enum WallFilm { OF_TRIANGLE = 0, OF_PART = 1, OF_WALL = 2 };

class Walls {
 public:
  std::vector<Triangle> triangles;
  std::vector<double> area;
  WallFilm film = OF_TRIANGLE;
  std::vector<int> film_of;             // number of the film of each triangle, which is that of the film's first triangle
  std::vector<double> film_area;        // area by the number of the film
  std::vector<int> part_of;
  std::vector<Part> parts;
  std::vector<Mesh> meshes;
  double margin = 0;                    // displacement of a sphere after which the triangles near it are searched again
  Images images;                        // periodic images of the box

  const Mesh &mesh_of(int part) const { return meshes[parts[part].mesh]; }

  void finish(double look_again_after) {
    margin = look_again_after;
    area.resize(triangles.size());
    part_of.resize(triangles.size());
    for (size_t p = 0; p < parts.size(); p++) bound(int(p));
    find_borders();
    for (size_t k = 0; k < triangles.size(); k++)
      area[k] = 0.5 * norm(cross(triangles[k].b - triangles[k].a, triangles[k].c - triangles[k].a));
    join_films();
  }

  // Parts that share a film with one of the given parts.
  std::vector<int> sharing(int part) const {
    std::vector<int> all{part};
    for (size_t p = 0; film == OF_WALL && p < parts.size(); p++)
      if (int(p) != part && parts[p].mesh == parts[part].mesh) all.push_back(int(p));
    return all;
  }

  // Share of a film's liquid that is on one of its triangles.
  double share_of(int triangle) const { return area[triangle] / film_area[film_of[triangle]]; }

  Site site_at(int part) const { return Site(part, parts[part].mesh); }

  // Closest point of a part to a centre x, exact; only triangles that can be the closest are evaluated. Of two equal distances the first.
  // In a periodic box, the closest point of the nearest image of the part.
  Closest closest(const Vec &x, Site &site) const {
    Closest best = closest_of_one(x, site);
    if (!images.any) return best;
    const Mesh &mesh = meshes[site.mesh];
    each_copy([&](int copy, const Vec &back) {
      if (outside(parts[site.part].bounds, mesh.to_rest(x + back)) >= best.distance) return;
      Closest other = closest_of_one(x + back, site_of_copy(site, copy));
      if (other.distance >= best.distance) return;
      other.point = other.point - back;
      other.back = back;
      best = other;
    });
    return best;
  }

  // The same for one image only, by default the part itself.
  Closest closest_of_one(const Vec &x, Site &site) const {
    const Mesh &mesh = meshes[site.mesh];
    const Vec y = mesh.to_rest(x);
    double moved = site.distance_then < 0 ? margin : norm(y - site.reference);
    if (!(moved < margin)) {
      look_around(y, site);
      moved = 0;
    }
    Closest best;
    auto look = [&](const Triangle &triangle, int k) {
      const Vec q = closest_point(y, triangle);
      const double d = norm(y - q);
      if (d < best.distance || (d == best.distance && k < best.triangle)) best = Closest{q, d, k};
    };
    look(site.nearest, site.first);
    if (!(site.second - moved > best.distance * (1 + 1e-12)))
      for (const Site::Other &other : site.others) {
        if (other.near.distance - moved > best.distance * (1 + 1e-12)) break;
        look(other.corners, other.near.triangle);
      }
    best.point = mesh.to_world(best.point);
    return best;
  }

  // Whether a point x is within `near` of the triangles of a part that border on other parts.
  bool on_border(int part, const Vec &x, double near) const {
    bool any = on_border_of_one(part, x, near);
    if (images.any) each_copy([&](int, const Vec &back) { any = any || on_border_of_one(part, x + back, near); });
    return any;
  }

  // Whether a part continues from its point x closer to c: one of its triangles within `near` of x has its closest point to c farther
  // than that from x.
  bool goes_on(int part, const Vec &x, const Vec &c, double near) const {
    bool any = goes_on_of_one(part, x, c, near);
    if (images.any) each_copy([&](int, const Vec &back) { any = any || goes_on_of_one(part, x + back, c + back, near); });
    return any;
  }

  // Distance of a point from the bounding box of a part or mesh, of its nearest image.
  double outside(const Mesh &mesh, const Bounds &b, const Vec &x) const {
    double least = outside(b, mesh.to_rest(x));
    if (images.any) each_copy([&](int, const Vec &back) { least = std::min(least, outside(b, mesh.to_rest(x + back))); });
    return least;
  }

  // Distance of a point y at rest from the bounding box of a part: a lower bound of that from the part.
  static double outside(const Bounds &b, const Vec &y) {
    const double x = std::max({b.low.x - y.x, y.x - b.high.x, 0.0}), u = std::max({b.low.y - y.y, y.y - b.high.y, 0.0}),
                 v = std::max({b.low.z - y.z, y.z - b.high.z, 0.0});
    return norm(Vec(x, u, v));
  }

 private:
  mutable std::vector<Site::Near> scratch_;

  // Neighbouring periodic boxes and the displacement to each: a mesh is at most half a box from its position at rest.
  template <class Work>
  void each_copy(Work work) const {
    const int n[3] = {images.along[0], images.along[1], images.along[2]};
    for (int x = -n[0]; x <= n[0]; x++)
      for (int y = -n[1]; y <= n[1]; y++)
        for (int z = -n[2]; z <= n[2]; z++)
          if (x || y || z) work(9 * x + 3 * y + z, images.shift(x, y, z));
  }

  static Site &site_of_copy(Site &site, int copy) {
    for (Site &other : site.copies)
      if (other.copy == copy) return other;
    site.copies.push_back(Site(site.part, site.mesh));
    site.copies.back().copy = copy;
    return site.copies.back();
  }

  bool on_border_of_one(int part, const Vec &x, double near) const {
    const Vec y = mesh_of(part).to_rest(x);
    if (outside(parts[part].bounds, y) > near) return false;
    for (int k : parts[part].border)
      if (norm(y - closest_point(y, triangles[k])) <= near) return true;
    return false;
  }

  bool goes_on_of_one(int part, const Vec &x, const Vec &c, double near) const {
    const Vec y = mesh_of(part).to_rest(x), centre = mesh_of(part).to_rest(c);
    if (outside(parts[part].bounds, y) > near) return false;
    for (int k : parts[part].border)
      if (norm(y - closest_point(y, triangles[k])) <= near && norm(y - closest_point(centre, triangles[k])) > near) return true;
    return false;
  }

  void look_around(const Vec &y, Site &site) const {
    double least = std::numeric_limits<double>::infinity();
    scratch_.clear();
    for (int k : parts[site.part].triangles) {
      scratch_.push_back(Site::Near{norm(y - closest_point(y, triangles[k])), k});
      least = std::min(least, scratch_.back().distance);
    }
    const Site::Near first = *std::min_element(scratch_.begin(), scratch_.end());
    const auto far = std::remove_if(scratch_.begin(), scratch_.end(), [&](const Site::Near &near) {
      return !(near.distance <= least + 2 * margin) || near.triangle == first.triangle;
    });
    std::sort(scratch_.begin(), far);
    site.others.clear();
    for (auto near = scratch_.begin(); near != far; ++near) site.others.push_back(Site::Other{*near, triangles[near->triangle]});
    site.first = first.triangle;
    site.nearest = triangles[site.first];
    site.reference = y;
    site.distance_then = least;
    site.second = site.others.empty() ? std::numeric_limits<double>::infinity() : site.others[0].near.distance;
  }

  void join_films() {
    film_of.resize(triangles.size());
    film_area.assign(triangles.size(), 0.0);
    for (size_t k = 0; k < triangles.size(); k++) film_of[k] = int(k);
    if (film != OF_TRIANGLE)
      for (const Part &part : parts)
        for (int k : part.triangles)
          film_of[k] = film == OF_PART ? *std::min_element(part.triangles.begin(), part.triangles.end()) : meshes[part.mesh].first;
    for (size_t k = 0; k < triangles.size(); k++) film_area[film_of[k]] += area[k];
  }

  // Corners at one point are bitwise equal: the surfaces are closed, and their coordinates come from one STL file.
  void find_borders() {
    using Corner = std::array<double, 4>;  // mesh, x, y, z
    auto corner = [&](int p, const Vec &v) { return Corner{double(parts[p].mesh), v.x, v.y, v.z}; };
    std::map<Corner, int> part_at;         // the part at a corner, -1: several parts
    for (int p = 0; p < int(parts.size()); p++)
      for (int k : parts[p].triangles)
        for (const Vec *v : {&triangles[k].a, &triangles[k].b, &triangles[k].c}) {
          const auto [at, fresh] = part_at.emplace(corner(p, *v), p);
          if (!fresh && at->second != p) at->second = -1;
        }
    for (int p = 0; p < int(parts.size()); p++)
      for (int k : parts[p].triangles)
        for (const Vec *v : {&triangles[k].a, &triangles[k].b, &triangles[k].c})
          if (part_at[corner(p, *v)] < 0) {
            parts[p].border.push_back(k);
            break;
          }
  }

  void bound(int p) {
    Bounds &bounds = parts[p].bounds, &all = meshes[parts[p].mesh].bounds;
    for (int k : parts[p].triangles) {
      part_of[k] = p;
      for (const Vec *v : {&triangles[k].a, &triangles[k].b, &triangles[k].c}) {
        bounds.widen(*v);
        all.widen(*v);
      }
    }
  }
};

}  // namespace pywet
