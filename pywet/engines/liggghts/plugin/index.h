// Hash table from the key of a bridge to its index. One block of memory.
#pragma once
#include <cstdint>
#include <vector>

namespace pywet {

class Index {
 public:
  void begin(size_t bridges) {
    bits_ = 6;
    while ((size_t(1) << bits_) < 4 * bridges) bits_++;
    slots_.assign(size_t(1) << bits_, Slot());
    used_ = 0;
  }

  void set(uint64_t name, int place) {
    if (2 * used_ >= slots_.size()) grow();
    Slot &slot = slots_[slot_of(name)];
    if (slot.name == NOBODY) used_++;
    slot = Slot{name, place};
  }

  int find(uint64_t name) const { return slots_.empty() ? -1 : slots_[slot_of(name)].place; }

  void forget(uint64_t name) {
    if (find(name) >= 0) slots_[slot_of(name)].place = -1;
  }

  bool crowded(size_t bridges) const { return used_ > 2 * bridges + 64; }  // with slots of forgotten bridges

 private:
  static const uint64_t NOBODY = ~uint64_t(0);
  struct Slot {
    uint64_t name = NOBODY;
    int place = -1;
  };
  std::vector<Slot> slots_;             // size is a power of two, at most half of the slots are used
  int bits_ = 0;
  size_t used_ = 0;

  // Slot of the key, or the empty slot for it: linear probing after a multiplicative hash (Knuth 6.4).
  size_t slot_of(uint64_t name) const {
    size_t at = (name * 0x9E3779B97F4A7C15u) >> (64 - bits_);
    while (slots_[at].name != name && slots_[at].name != NOBODY) at = (at + 1) & (slots_.size() - 1);
    return at;
  }

  void grow() {
    const std::vector<Slot> before = slots_;
    begin(before.size() / 2);
    for (const Slot &slot : before)
      if (slot.place >= 0) set(slot.name, slot.place);
  }
};

}  // namespace pywet
