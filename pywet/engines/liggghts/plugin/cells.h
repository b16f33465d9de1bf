// Finds the triangles of a mesh at rest within reach of a point: a grid of cells, each of which lists the triangles within its reach.
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "walls.h"

namespace pywet {

class Cells {
 public:
  // Triangles [first, first + count) of the array `triangles`.
  Cells(const std::vector<Triangle> &triangles, int first, int count, double reach) {
    Bounds all;
    for (int k = first; k < first + count; k++) widen(all, triangles[k]);
    const Vec size = all.high - all.low;
    const double longest = std::max({size.x, size.y, size.z});
    width_ = std::max(reach, longest / MOST);
    low_ = all.low - Vec(reach, reach, reach);
    const Vec high = all.high + Vec(reach, reach, reach);
    for (int axis = 0; axis < 3; axis++) number_[axis] = cell(high, axis) + 1;
    // first pass: count the entries of each cell; second pass: fill them
    first_.assign(size_t(number_[0]) * number_[1] * number_[2] + 1, 0);
    for (int k = first; k < first + count; k++) each(triangles[k], reach, [&](size_t c) { first_[c + 1]++; });
    for (size_t c = 1; c < first_.size(); c++) first_[c] += first_[c - 1];
    listed_.resize(first_.back());
    std::vector<size_t> next(first_.begin(), first_.end() - 1);
    for (int k = first; k < first + count; k++) each(triangles[k], reach, [&](size_t c) { listed_[next[c]++] = k; });
  }

  // Sorts the triangles of each cell by number.
  std::pair<const int *, const int *> near(const Vec &y) const {
    int at[3];
    for (int axis = 0; axis < 3; axis++) {
      const double along = (component(y, axis) - component(low_, axis)) / width_;
      if (!(along >= 0 && along < number_[axis])) return {nullptr, nullptr};
      at[axis] = int(along);
    }
    const size_t c = index(at);
    return {listed_.data() + first_[c], listed_.data() + first_[c + 1]};
  }

 private:
  static constexpr int MOST = 48;       // largest number of cells along the longest side
  double width_;
  Vec low_;
  int number_[3];
  std::vector<size_t> first_;           // index in listed_ of the first entry of each cell
  std::vector<int> listed_;

  static double component(const Vec &v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
  static void widen(Bounds &bounds, const Triangle &t) {
    for (const Vec *v : {&t.a, &t.b, &t.c}) bounds.widen(*v);
  }
  int cell(const Vec &v, int axis) const { return int((component(v, axis) - component(low_, axis)) / width_); }
  size_t index(const int *at) const { return (size_t(at[2]) * number_[1] + at[1]) * number_[0] + at[0]; }

  // Cells within reach of the triangle's bounding box and of its plane.
  template <class Work>
  void each(const Triangle &t, double reach, Work work) const {
    Bounds b;
    widen(b, t);
    const Vec far(reach, reach, reach), low = b.low - far, high = b.high + far;
    Vec n = cross(t.b - t.a, t.c - t.a);
    n = (1.0 / norm(n)) * n;
    const double half = 0.5 * width_, most = reach + half * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z));
    int from[3], to[3], at[3];
    for (int axis = 0; axis < 3; axis++) {
      from[axis] = std::max(cell(low, axis), 0);
      to[axis] = std::min(cell(high, axis), number_[axis] - 1);
    }
    for (at[2] = from[2]; at[2] <= to[2]; at[2]++)
      for (at[1] = from[1]; at[1] <= to[1]; at[1]++)
        for (at[0] = from[0]; at[0] <= to[0]; at[0]++) {
          const Vec middle = low_ + Vec(width_ * at[0] + half, width_ * at[1] + half, width_ * at[2] + half);
          if (std::fabs(dot(n, middle - t.a)) <= most * (1 + 1e-9)) work(index(at));
        }
  }
};

}  // namespace pywet
