// Three-vectors and the closest point of a triangle.
#pragma once
#include <cmath>

namespace pywet {

struct Vec {
  double x, y, z;
  Vec() : x(0), y(0), z(0) {}
  Vec(double a, double b, double c) : x(a), y(b), z(c) {}
  explicit Vec(const double *p) : x(p[0]), y(p[1]), z(p[2]) {}
};
inline Vec operator+(const Vec &a, const Vec &b) { return Vec(a.x + b.x, a.y + b.y, a.z + b.z); }
inline Vec operator-(const Vec &a, const Vec &b) { return Vec(a.x - b.x, a.y - b.y, a.z - b.z); }
inline Vec operator*(double s, const Vec &a) { return Vec(s * a.x, s * a.y, s * a.z); }
inline double dot(const Vec &a, const Vec &b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec &a, const Vec &b) {
  return Vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
inline double norm(const Vec &a) { return std::sqrt(dot(a, a)); }
inline void store(const Vec &a, double *p) { p[0] = a.x; p[1] = a.y; p[2] = a.z; }
inline void accumulate(double *p, const Vec &a) { p[0] += a.x; p[1] += a.y; p[2] += a.z; }

// Periodic images of a box: minimum image of a difference vector.
struct Images {
  bool along[3] = {false, false, false}, any = false;
  double length[3] = {0, 0, 0};
  Vec nearest(const Vec &d) const { return any ? Vec(shortest(d.x, 0), shortest(d.y, 1), shortest(d.z, 2)) : d; }
  Vec shift(int x, int y, int z) const { return Vec(x * length[0], y * length[1], z * length[2]); }

 private:
  double shortest(double d, int axis) const { return along[axis] ? d - length[axis] * std::round(d / length[axis]) : d; }
};

struct Triangle {
  Vec a, b, c;
};

// Rotation matrix by rows.
struct Turn {
  Vec x, y, z;
  Turn() : x(1, 0, 0), y(0, 1, 0), z(0, 0, 1) {}
  Vec operator()(const Vec &a) const { return Vec(dot(x, a), dot(y, a), dot(z, a)); }
  Vec back(const Vec &a) const { return a.x * x + a.y * y + a.z * z; }
};

// Right-handed orthonormal axes of a triangle, as rows.
inline Turn axes_of(const Triangle &t) {
  Turn axes;
  axes.x = t.b - t.a;
  axes.x = (1.0 / norm(axes.x)) * axes.x;
  axes.z = cross(t.b - t.a, t.c - t.a);
  axes.z = (1.0 / norm(axes.z)) * axes.z;
  axes.y = cross(axes.z, axes.x);
  return axes;
}

// The rotation that maps the directions of triangle `rest` to those of `now`.
inline Turn turn_between(const Triangle &rest, const Triangle &now) {
  const Turn from = axes_of(rest), to = axes_of(now);
  Turn turn;  // sum over the axes of (to-axis)(from-axis)^T
  turn.x = to.x.x * from.x + to.y.x * from.y + to.z.x * from.z;
  turn.y = to.x.y * from.x + to.y.y * from.y + to.z.y * from.z;
  turn.z = to.x.z * from.x + to.y.z * from.y + to.z.z * from.z;
  return turn;
}

// Angular velocity of a rigid triangle from its corners' velocities: w = n (n.w) + n x (n.w)' with the normal n.
inline Vec spin_of(const Triangle &at, const Vec &va, const Vec &vb, const Vec &vc) {
  const Vec e = at.b - at.a, g = at.c - at.a, de = vb - va, dg = vc - va;
  Vec n = cross(e, g);
  const double area = norm(n);
  n = (1.0 / area) * n;
  const Vec dn = (1.0 / area) * (cross(de, g) + cross(e, dg));  // its normal component vanishes for a rigid triangle
  const double about_n = dot(cross(e, de), n) / dot(e, e) ;
  return cross(n, dn) + about_n * n;
}

// Point of triangle t closest to p, by the Voronoi regions of its corners, edges and face.
inline Vec closest_point(const Vec &p, const Triangle &t) {
  const Vec ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return t.a;
  const Vec bp = p - t.b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return t.b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t.a + (d1 / (d1 - d3)) * ab;
  const Vec cp = p - t.c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return t.c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t.a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return t.b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t.c - t.b);
  const double s = 1.0 / (va + vb + vc);
  return t.a + (vb * s) * ab + (vc * s) * ac;
}

}  // namespace pywet
