// The force laws: addresses of compiled Python functions; null: the effect is off.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

namespace pywet {

typedef double (*Fn2)(double, double);
typedef double (*Fn3)(double, double, double);
typedef double (*Fn5)(double, double, double, double, double);

// A law evaluated for many bridges: arguments are rows of BATCH values in the order of Row, results likewise, as in pywet/laws/batch.py.
const int BATCH = 64;
enum Row { SEPARATION, VOLUME, RADIUS_I, RADIUS_J, ANGLE_I, ANGLE_J, SPEED, ROWS };
typedef void (*Batch)(int64_t n, const double *rows, double sigma, double eta, const int64_t *prepared, double *out);
typedef void (*Prepare)(double volume, double r_i, double r_j, double theta_i, double theta_j, double *numbers);

// Values of the force laws of BATCH bridges: capillary force F >= 0, viscous force along n at the speed of row SPEED, coefficients c_t, c_r.
struct LawValues {
  double pull[BATCH], viscous[BATCH], tangential[2][BATCH];
};

const int VISCOUS = 1;  // number of the viscous force among them

// Laws in one loop: they write `count` of the arrays of LawValues, from the one of number `first` on.
struct ForceLaws {
  Batch loop;
  int first, count;
};

struct Laws {
  std::vector<ForceLaws> forces;
  Prepare prepare = nullptr;          // for the capillary law: precomputed data of a bridge, `lines` cache lines of numbers
  int lines = 0;
  Fn5 rupture = nullptr;             // V, r_i, r_j, theta_i, theta_j -> S_rup
  Fn3 dynamic_rupture = nullptr;     // speed, eta, sigma -> factor
  Fn3 from_sphere = nullptr;         // L_i, r_i, r_j -> V_i
  Fn3 from_sphere_at_wire = nullptr; // L_i, r_i, r_w -> V_i
  Fn2 from_wall = nullptr;           // W, r_i -> V_w
  Fn3 from_wire = nullptr;           // W, r_i, r_w -> V_w
  Fn5 shed_drop = nullptr;           // L_i, r_i, specific force, density, sigma -> volume of the drop
  Fn3 shed_time = nullptr;           // L_i, density, sigma -> response time of the film
  double surface_tension = 0, viscosity = 0;

  // Whether there is a capillary force.
  bool attract() const { return !forces.empty() && forces[0].first == 0; }

  // Laws that are off give 0. An error inside a law shows as NaN. With `only`, the number of a value, other loops are left out.
  void evaluate(int64_t n, const double *rows, const int64_t *prepared, LawValues &values, int only = -1) const {
    double *out = reinterpret_cast<double *>(&values);
    std::fill(out, out + sizeof values / sizeof *out, 0.0);
    for (const ForceLaws &f : forces) {
      if (only >= 0 && (only < f.first || only >= f.first + f.count)) continue;
      double *from = out + f.first * BATCH;
      std::fill(from, from + f.count * BATCH, std::nan(""));
      f.loop(n, rows, surface_tension, viscosity, prepared, from);
    }
  }
};

// One cache line of the processor.
struct alignas(64) CacheLine {
  double number[8];
};

// Transfer ratios over V*, linear between nodes, constant beyond; one row for each (kind, type of i, type of j or wall group).
class TransferTables {
 public:
  void set(int kind, int type_i, int other, const double *nodes, const double *values, int n) {
    rows_[key(kind, type_i, other)] = Row{std::vector<double>(nodes, nodes + n), std::vector<double>(values, values + n)};
  }
  double ratio(int kind, int type_i, int other, double v_star) const {
    const Row &row = rows_.at(key(kind, type_i, other));
    const std::vector<double> &x = row.nodes, &y = row.values;
    if (v_star <= x.front()) return y.front();
    if (v_star >= x.back()) return y.back();
    const size_t k = std::upper_bound(x.begin(), x.end(), v_star) - x.begin();
    const double w = (v_star - x[k - 1]) / (x[k] - x[k - 1]);
    return (1 - w) * y[k - 1] + w * y[k];
  }

 private:
  static int key(int kind, int type_i, int other) { return (kind * 1000 + type_i) * 1000 + other; }
  struct Row {
    std::vector<double> nodes, values;
  };
  std::map<int, Row> rows_;
};

}  // namespace pywet
