#pragma once
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/model/lanes.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Scratch memory for one thread: make one for a model and use it in every call, nothing is allocated
/// afterwards. It holds no results; no call depends on an earlier one. T is the scalar of the computation,
/// double or float. Where joints are coupled it has room for a mass matrix.
template <class T = double> class Workspace {
  static constexpr std::size_t most_lanes = 16;  ///< of a SIMD register

  struct Size {
    template <class U>
    explicit Size(const Tree<U>& tree)
        : bodies(static_cast<std::size_t>(tree.n)),
          screws(static_cast<std::size_t>(tree.n_screws)),
          pairs(tree.n_screws > tree.nv ? static_cast<std::size_t>(tree.nv * tree.nv) : 0) {}
    std::size_t numbers() const { return 152 * (bodies + 1) + 32 * screws + pairs + 40 * 2 * most_lanes; }
    std::string text() const {
      return std::to_string(bodies) + " bodies with " + std::to_string(screws) + " joint screws" +
             (pairs > 0 ? " and a mass matrix of " + std::to_string(pairs) + " entries" : "");
    }
    std::size_t bodies, screws, pairs;
  };

 public:
  explicit Workspace(const Model& model) : Workspace(model.tree<double>()) {}
  /// For kernels on another scalar.
  template <class U>
  explicit Workspace(const Tree<U>& tree) : size_(tree), lines_(bytes_for(tree) / sizeof(Line)) {}

  /// What a workspace takes.
  template <class U> static std::size_t bytes_for(const Tree<U>& tree) {
    return (Size(tree).numbers() * sizeof(T) / sizeof(Line) + 1) * sizeof(Line);
  }

  std::size_t bytes() const { return lines_.size() * sizeof(Line); }

  /// Throws std::invalid_argument where the workspace is too small for a model.
  void check(const Model& model) const {
    const Size needed(model.tree<double>());
    if (size_.bodies < needed.bodies || size_.screws < needed.screws || size_.pairs < needed.pairs)
      throw std::invalid_argument("workspace: made for " + size_.text() + "; model \"" + model.name() +
                                  "\" has " + needed.text());
  }

  /// Hands out the memory of a workspace, from its start, for the length of one call.
  class Arena {
   public:
    explicit Arena(Workspace& workspace)
        : next_(reinterpret_cast<std::byte*>(workspace.lines_.data())), size_(workspace.size_) {}
    /// From memory of the caller's, aligned to a cache line.
    template <class U> Arena(std::byte* memory, const Tree<U>& tree) : next_(memory), size_(tree) {}
    template <class U> U* array(std::size_t n) { return take<U>(n); }
    /// One U for each body and the ground, for each joint screw, for each pair of velocities (where joints
    /// are coupled). All that one call takes fits into the numbers of Size.
    template <class U> U* per_body() { return take<U>(size_.bodies + 1); }
    template <class U> U* per_screw() { return take<U>(size_.screws); }
    /// One U for each body, and for the lanes behind the last one.
    template <class U> U* per_lane() {
      return take<U>((size_.bodies + most_lanes) / most_lanes * most_lanes);
    }
    /// n arrays of one U for each body and the ground, or for each joint screw, and the lanes behind the last
    /// one.
    template <class U> Arrays<U> arrays(int n) { return arrays_of<U>(n, size_.bodies + 1); }
    template <class U> Arrays<U> screw_arrays(int n) { return arrays_of<U>(n, size_.screws); }
    template <class U> U* per_pair() { return take<U>(size_.pairs); }

   private:
    template <class U> Arrays<U> arrays_of(int n, std::size_t entries) {
      // Whole registers; or, for entries as long as a cache line, an odd number of them, which no cache folds.
      const std::size_t stride =
          Lanes<U>::width > 1 ? (entries + 2 * most_lanes - 1) / most_lanes * most_lanes : entries | 1;
      next_ += -reinterpret_cast<std::uintptr_t>(next_) % sizeof(Line);
      return {take<U>(static_cast<std::size_t>(n) * stride), static_cast<std::ptrdiff_t>(stride)};
    }
    template <class U> U* take(std::size_t n) {
      next_ += -reinterpret_cast<std::uintptr_t>(next_) % alignof(U);
      U* p = std::launder(reinterpret_cast<U*>(next_));
      next_ += n * sizeof(U);
      return p;
    }

    std::byte* next_;
    Size size_;
  };

 private:
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  Size size_;
  std::vector<Line> lines_;
};

}  // namespace axode
