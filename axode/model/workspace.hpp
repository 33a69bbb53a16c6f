#pragma once
#include <concepts>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/model/arena.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// A tag that selects the spanning tree of a mechanism: the mechanism without its loops and couplings.
struct CutTree {};
inline constexpr CutTree cut_tree;

/// Scratch memory for one thread, so that functions need not allocate. Construct one for a model and pass it
/// to every call. It holds no results. T is the scalar of the computation. The memory is proportional to the
/// number of bodies unless joints are coupled.
///
/// A workspace has memory for the spanning tree of a mechanism only. Functions whose result depends on loops
/// throw if they get a workspace for a model with loops; they take a LoopWorkspace instead. If the workspace
/// was made with the tag `cut_tree`, they accept it and compute with the spanning tree, without the loops.
template <class T = double> class Workspace {
 public:
  /// Makes a workspace for every function of the library; T is double or float.
  explicit Workspace(const Model& model);
  Workspace(const Model& model, CutTree) : Workspace(model) { is_for_cut_tree_ = true; }
  /// Makes a workspace of a number of bytes, as footprint() returns it for an algorithm, for any scalar.
  Workspace(const Topology& topology, std::size_t bytes)
      : made_for_(topology), lines_(bytes / sizeof(Line) + 1) {}

  bool is_for_cut_tree() const { return is_for_cut_tree_; }
  std::size_t bytes() const { return lines_.size() * sizeof(Line); }

  /// The whole memory as an arena for one call; whether it suffices for the topology is not checked.
  Arena arena(const Topology& topology) {
    return {topology, reinterpret_cast<std::byte*>(lines_.data()), bytes()};
  }

  /// Throws std::invalid_argument if the workspace was made for fewer bodies, joint screws or coupled joints.
  void check(const Model& model) const {
    const Extent needed(model.topology());
    if (made_for_.bodies < needed.bodies || made_for_.screws < needed.screws || made_for_.ties < needed.ties)
      throw std::invalid_argument("workspace: made for " + made_for_.text() + "; model \"" + model.name() +
                                  "\" has " + needed.text());
  }

 private:
  /// The sizes of a mechanism on which the memory of kernels depends. `ties` is Topology::Ties::n_pairs.
  struct Extent {
    explicit Extent(const Topology& t) : bodies(t.n), screws(t.n_screws), ties(t.ties.n_pairs) {}
    std::string text() const {
      return std::to_string(bodies) + " bodies with " + std::to_string(screws) + " joint screws" +
             (ties > 0 ? " and " + std::to_string(ties) + " ties of coupled joints" : "");
    }
    int bodies, screws;
    std::size_t ties;
  };
  struct alignas(Arena::line) Line {
    std::byte bytes[Arena::line];
  };
  Extent made_for_;
  bool is_for_cut_tree_ = false;
  std::vector<Line> lines_;
};

/// An algorithm together with its scratch memory, for any scalar T, as in `WithScratch<Dual<double, 3>,
/// InverseDynamicsRecursion<Hybrid, Dual<double, 3>>> dynamics(topology)`.
template <class T, class Kernel> class WithScratch {
 public:
  explicit WithScratch(const Topology& topology)
      : workspace_(topology, footprint<Kernel>(topology)),
        arena_(workspace_.arena(topology)),
        kernel_(arena_) {}
  Kernel* operator->() { return &kernel_; }
  Kernel& operator*() { return kernel_; }

 private:
  Workspace<T> workspace_;
  Arena arena_;
  Kernel kernel_;
};

template <class T> Workspace<T>::Workspace(const Model& model) : Workspace(model.topology(), 0) {
  static_assert(
      std::same_as<T, double> || std::same_as<T, float>,
      "the functions that take a Workspace are compiled for double and float only; for another scalar T "
      "include axode/dynamics/generic_dynamics.hpp and use GenericDynamics<T>, or run a kernel of "
      "axode/recursion by WithScratch<T, Kernel>");
}
template <> Workspace<double>::Workspace(const Model& model);
template <> Workspace<float>::Workspace(const Model& model);

}  // namespace axode
