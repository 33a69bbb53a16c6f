#pragma once
#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// Scratch memory for one thread: make one for a model and use it in every call, nothing is allocated
/// afterwards. It holds no results; no call depends on an earlier one. T is the scalar of the computation,
/// double or float. Where joints are coupled it has room for a mass matrix.
template <class T = double> class Workspace {
  struct Size {
    template <class U>
    explicit Size(const Tree<U>& tree)
        : bodies(static_cast<std::size_t>(tree.n)),
          screws(static_cast<std::size_t>(tree.n_screws)),
          pairs(tree.n_screws > tree.nv ? static_cast<std::size_t>(tree.nv * tree.nv) : 0) {}
    std::size_t numbers() const { return 144 * (bodies + 1) + 32 * screws + pairs; }
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
  explicit Workspace(const Tree<U>& tree)
      : size_(tree), lines_(size_.numbers() * sizeof(T) / sizeof(Line) + 1) {}

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
    /// One U for each body and the ground, for each joint screw, for each pair of velocities (where joints
    /// are coupled). All that one call takes fits into the numbers of Size.
    template <class U> U* per_body() { return take<U>(size_.bodies + 1); }
    template <class U> U* per_screw() { return take<U>(size_.screws); }
    template <class U> U* per_pair() { return take<U>(size_.pairs); }

   private:
    template <class U> U* take(std::size_t n) {
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
