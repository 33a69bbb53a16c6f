#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>

#include "axode/model/topology.hpp"

namespace axode {

// The functions of Arena are always inlined, because code that is compiled for one instruction set must not
// be shared with callers that are compiled for another one.

/// Scratch memory for one call. An algorithm takes its arrays from it, one after the other, and does not
/// return them. An arena that was made without memory counts the bytes that would be taken.
class Arena {
 public:
  static constexpr std::size_t line = 64;        ///< bytes of a cache line, to which the memory is aligned
  static constexpr std::size_t most_lanes = 16;  ///< largest number of lanes of a SIMD register

  [[gnu::always_inline]] Arena(const Topology& topology, std::byte* begin, std::size_t bytes)
      : topology_(&topology),
        begin_(reinterpret_cast<std::uintptr_t>(begin)),
        next_(begin_),
        end_(begin_ + bytes) {}
  /// Makes an arena without memory, which only counts the bytes that are taken from it.
  [[gnu::always_inline]] explicit Arena(const Topology& topology)
      : topology_(&topology), end_(std::numeric_limits<std::uintptr_t>::max()) {}

  [[gnu::always_inline]] const Topology& topology() const { return *topology_; }
  [[gnu::always_inline]] std::size_t bytes_taken() const { return next_ - begin_; }

  template <class U> [[gnu::always_inline]] U* array(std::size_t n) {
    next_ += -next_ % alignof(U);
    U* const p = reinterpret_cast<U*>(next_);
    next_ += n * sizeof(U);
    assert(next_ <= end_);
    return p;
  }
  /// Takes an array of n entries that begins at the start of a cache line.
  template <class U> [[gnu::always_inline]] U* lines(std::size_t n) {
    next_ += -next_ % line;
    return array<U>(n);
  }
  /// Each function takes an array from the arena: per_body() with an entry for the ground and each body,
  /// per_screw() for each joint screw, and per_velocity() for each joint velocity. Three more functions are
  /// for coupled joints. They count ties: a tie is a pair of a velocity that several joints share and a body
  /// on the paths from these joints to the body where the paths meet. per_tie() has an entry for each tie,
  /// and per_tie_and_screw() for each tie and each screw of the joint of its body. per_pair_of_ties() has an
  /// entry for each ordered pair of ties of one body, a tie with itself included, that the elimination of
  /// velocities can couple (ties of a group of Topology::Ties).
  template <class U> [[gnu::always_inline]] U* per_body() { return array<U>(size(topology_->n + 1)); }
  template <class U> [[gnu::always_inline]] U* per_screw() { return array<U>(size(topology_->n_screws)); }
  template <class U> [[gnu::always_inline]] U* per_velocity() { return array<U>(size(topology_->nv)); }
  template <class U> [[gnu::always_inline]] U* per_tie() { return array<U>(topology_->ties.velocity.size()); }
  template <class U> [[gnu::always_inline]] U* per_tie_and_screw() {
    return array<U>(topology_->ties.of_screws.back());
  }
  template <class U> [[gnu::always_inline]] U* per_pair_of_ties() {
    return array<U>(topology_->ties.n_pairs);
  }
  /// Takes an array with an entry for the ground and each body, padded to whole SIMD registers.
  template <class U> [[gnu::always_inline]] U* per_lane() {
    return array<U>((size(topology_->n) + most_lanes) / most_lanes * most_lanes);
  }

 private:
  [[gnu::always_inline]] static std::size_t size(int n) { return static_cast<std::size_t>(n); }

  const Topology* topology_;
  std::uintptr_t begin_ = 0, next_ = 0, end_;
};

/// The bytes of arena memory that the largest of the given kernels takes for a topology.
template <class... Kernels> std::size_t footprint(const Topology& topology) {
  std::size_t most = 0;
  const auto count = [&]<class Kernel>(Kernel*) {
    Arena arena(topology);
    static_cast<void>(Kernel(arena));
    if (arena.bytes_taken() > most) most = arena.bytes_taken();
  };
  (count(static_cast<Kernels*>(nullptr)), ...);
  return most;
}

}  // namespace axode
