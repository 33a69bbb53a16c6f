#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>

#include "axode/model/topology.hpp"

namespace axode {

// The functions are always inlined, because their code must not be shared between instruction sets.

/// Scratch memory that is handed out from its start, for the length of one call. A kernel takes its memory in
/// its constructor; on an arena without memory, the same constructor only counts how much it would take, see
/// footprint().
class Arena {
 public:
  static constexpr std::size_t line = 64;        ///< bytes of a cache line, to which the memory is aligned
  static constexpr std::size_t most_lanes = 16;  ///< largest number of lanes of a SIMD register

  [[gnu::always_inline]] Arena(const Topology& topology, std::byte* begin, std::size_t bytes)
      : topology_(&topology),
        begin_(reinterpret_cast<std::uintptr_t>(begin)),
        next_(begin_),
        end_(begin_ + bytes) {}
  /// An arena without memory, which only counts the memory that is taken from it.
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
  /// Memory from the start of a cache line.
  template <class U> [[gnu::always_inline]] U* lines(std::size_t n) {
    next_ += -next_ % line;
    return array<U>(n);
  }
  /// Arrays with an entry for each body and the ground, each joint screw, each velocity, each tie of coupled
  /// joints, each pair of a tie and a screw of its body, or each pair of ties of one group.
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
  /// An array with an entry for each body, and for the lanes beyond the last body.
  template <class U> [[gnu::always_inline]] U* per_lane() {
    return array<U>((size(topology_->n) + most_lanes) / most_lanes * most_lanes);
  }

 private:
  [[gnu::always_inline]] static std::size_t size(int n) { return static_cast<std::size_t>(n); }

  const Topology* topology_;
  std::uintptr_t begin_ = 0, next_ = 0, end_;
};

/// The largest memory that one of the kernels takes of an arena, in bytes.
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
