// The force laws: addresses of compiled Python functions. A null pointer is an effect that is off.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace pywet {

typedef double (*Fn2)(double, double);
typedef double (*Fn3)(double, double, double);
typedef double (*Fn4)(double, double, double, double);
typedef double (*Fn5)(double, double, double, double, double);
typedef double (*Fn6)(double, double, double, double, double, double);
typedef double (*Fn7)(double, double, double, double, double, double, double);

struct Laws {
  Fn7 capillary = nullptr;           // S, V, r_i, r_j, theta_i, theta_j, sigma -> F >= 0
  Fn6 viscous_normal = nullptr;      // S, V, r_i, r_j, v_n, eta -> F along n
  Fn4 translation = nullptr;         // S, r_i, r_j, eta -> c_t
  Fn4 rotation = nullptr;            // S, r_i, r_j, eta -> c_r
  Fn5 rupture = nullptr;             // V, r_i, r_j, theta_i, theta_j -> S_rup
  Fn3 dynamic_rupture = nullptr;     // speed, eta, sigma -> factor
  Fn3 from_sphere = nullptr;         // L_i, r_i, r_j -> V_i
  Fn3 from_sphere_at_wire = nullptr; // L_i, r_i, r_w -> V_i
  Fn2 from_wall = nullptr;           // W, r_i -> V_w
  Fn3 from_wire = nullptr;           // W, r_i, r_w -> V_w
  double surface_tension = 0, viscosity = 0;
};

// Transfer ratios over V*, equally spaced from 0 to v_max, one row for each (kind, type of i, type of j or wall group).
class TransferTables {
 public:
  void set(int kind, int type_i, int other, const double *values, int n, double v_max) {
    rows_[key(kind, type_i, other)] = std::vector<double>(values, values + n);
    v_max_ = v_max;
  }
  bool has(int kind, int type_i, int other) const { return rows_.count(key(kind, type_i, other)) > 0; }
  double ratio(int kind, int type_i, int other, double v_star) const {
    const std::vector<double> &row = rows_.at(key(kind, type_i, other));
    const double h = v_max_ / double(row.size() - 1);
    const double u = std::min(std::max(v_star, 0.0), v_max_) / h;
    const int k = std::min(int(u), int(row.size()) - 2);
    const double w = u - k;
    return (1 - w) * row[k] + w * row[k + 1];
  }

 private:
  static int key(int kind, int type_i, int other) { return (kind * 1000 + type_i) * 1000 + other; }
  std::map<int, std::vector<double>> rows_;
  double v_max_ = 0.5;
};

}  // namespace pywet
