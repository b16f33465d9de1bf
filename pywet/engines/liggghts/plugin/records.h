// Records of the logs. Layout = pywet/schema.py, packed, little endian; a test compares them field by field.
#pragma once
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace pywet {

enum { FORMATION = 0, RUPTURE = 1, RETIREMENT = 2 };  // RETIREMENT: the bridge ends because one of its spheres is removed
enum { SPHERE = 0, LARGE_WALL = 1, SMALL_WALL = 2, LEFT = 3 };  // LEFT: for drops only

#pragma pack(push, 1)
struct Event {
  int64_t step;
  double time;
  int32_t kind, partner_kind, i, j, triangle, pad;
  double volume, share_i, share_j;
  double film_i_before, film_i_after, film_j_before, film_j_after;
  double separation, rupture_distance, speed;
};
struct Contact {
  int64_t step;
  double time;
  int32_t partner_kind, i, j, triangle;
  double xi[3], vi[3], wi[3], xj[3], vj[3], wj[3];
  double volume, separation, rupture_distance, capillary, viscous_normal;
  double viscous_tangential[3], force_i[3], torque_i[3], torque_j[3];
  double viscous_law, factor_normal, factor_tangential;
  int32_t sharing_i, sharing_j;
  double push[3], spin_push[3], weight;
};
struct Ledger {
  int64_t step;
  double time, films, bridges, walls, left, retired, initial;
  int64_t spheres, bridge_count, formations, ruptures;
};
struct BridgeSnapshot {
  int64_t step;
  int32_t partner_kind, i, j, triangle;
  double volume, share_i, separation, xi[3], xj[3];
  double capillary_impulse, viscous_impulse, least_separation, largest_separation;
};
struct Energy {
  int64_t step;
  double time, kinetic, spin, capillary_stored, formed, ruptured;
  double gravity, contact, capillary, viscous_normal, viscous_tangential, wall_motion, drive, half_kick;
};
struct Film {
  int64_t step;
  int32_t id, pad;
  double film;
};
struct Impulse {
  int64_t step;
  int32_t id, pad;
  double impulse[3];
};
struct Drop {
  int64_t step;
  double time;
  int32_t partner_kind, i, j, pad;
  double volume, film_i_before, film_j_before, fallen, felt[3], x[3];
};
struct Felt {
  int64_t step;
  int32_t id, pad;
  double film, v[3], felt[3];
};
struct WireContact {
  int64_t step;
  int32_t mesh, triangle, i, pad;
  double spring[3];
};
struct State {
  int64_t step;
  double time;
  int32_t id, type;
  double x[3], v[3], w[3];
};
struct Pose {
  int64_t step;
  int32_t mesh, pad;
  double shift[3], turn_0[3], turn_1[3], turn_2[3], velocity[3], spin[3];
};
struct RetiredSphere {
  int64_t step;
  double time;
  int32_t id, type, outlet, pad;  // outlet: number of the outlet, 0: the collecting bin
  double film, x[3], v[3];
};
#pragma pack(pop)
static_assert(sizeof(Event) == 120, "records must match pywet/schema.py");
static_assert(sizeof(Contact) == 400, "records must match pywet/schema.py");
static_assert(sizeof(Ledger) == 96, "records must match pywet/schema.py");
static_assert(sizeof(BridgeSnapshot) == 128, "records must match pywet/schema.py");
static_assert(sizeof(Energy) == 120, "records must match pywet/schema.py");
static_assert(sizeof(Film) == 24, "records must match pywet/schema.py");
static_assert(sizeof(Impulse) == 40, "records must match pywet/schema.py");
static_assert(sizeof(Drop) == 112, "records must match pywet/schema.py");
static_assert(sizeof(Felt) == 72, "records must match pywet/schema.py");
static_assert(sizeof(RetiredSphere) == 88, "records must match pywet/schema.py");
static_assert(sizeof(State) == 96, "records must match pywet/schema.py");
static_assert(sizeof(Pose) == 160, "records must match pywet/schema.py");
static_assert(sizeof(WireContact) == 48, "records must match pywet/schema.py");

// Formats a number for a message: six significant digits, whereas std::to_string would write a film of 3e-7 as 0.000000.
inline std::string number(double value) {
  char text[32];
  snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Append-only file of one kind of record; a failed write (disk full) raises an error.
class RecordFile {
 public:
  void open(const std::string &path) {
    path_ = path;
    file_ = fopen(path.c_str(), "ab");
    if (!file_) throw std::runtime_error("the log " + path + " cannot be opened for writing");
    setvbuf(file_, nullptr, _IOFBF, 1 << 20);
  }
  template <class T>
  void write(const T &record) {
    if (fwrite(&record, sizeof(T), 1, file_) != 1)
      throw std::runtime_error("the log " + path_ + " could not be written; is the disk full?");
  }
  void flush() {
    if (file_ && fflush(file_) != 0)
      throw std::runtime_error("the log " + path_ + " could not be written; is the disk full?");
  }
  ~RecordFile() {
    if (file_) fclose(file_);
  }

 private:
  std::string path_;
  FILE *file_ = nullptr;
};

}  // namespace pywet
