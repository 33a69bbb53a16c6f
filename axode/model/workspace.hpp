#pragma once
#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// Scratch memory for one thread: make one for a model and use it in every call, nothing is allocated afterwards. It
/// holds no results; no call depends on an earlier one. T is the scalar of the computation, double or float.
template <class T = double> class Workspace {
 public:
  explicit Workspace(const Model& model) : Workspace(model.n_bodies()) {}
  explicit Workspace(int n_bodies)
      : n_bodies_(n_bodies), lines_((n_bodies + 1) * numbers_per_body * sizeof(T) / sizeof(Line) + 1) {}

  int n_bodies() const { return n_bodies_; }
  std::size_t bytes() const { return lines_.size() * sizeof(Line); }

  /// Throws std::invalid_argument where the workspace is too small for a model.
  void check(const Model& model) const {
    if (n_bodies_ < model.n_bodies())
      throw std::invalid_argument("workspace: made for " + std::to_string(n_bodies_) + " bodies; model \"" +
                                  model.name() + "\" has " + std::to_string(model.n_bodies()));
  }

  /// Hands out the memory of a workspace, from its start, for the length of one call.
  class Arena {
   public:
    explicit Arena(Workspace& workspace)
        : next_(reinterpret_cast<std::byte*>(workspace.lines_.data())), n_(workspace.n_bodies_ + 1) {}
    /// One U for each body and the ground. All that one call takes fits into numbers_per_body numbers for each body.
    template <class U> U* per_body() {
      U* p = std::launder(reinterpret_cast<U*>(next_));
      next_ += n_ * sizeof(U);
      return p;
    }

   private:
    std::byte* next_;
    std::size_t n_;
  };

  static constexpr std::size_t numbers_per_body = 112;

 private:
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  int n_bodies_;
  std::vector<Line> lines_;
};

}  // namespace axode
