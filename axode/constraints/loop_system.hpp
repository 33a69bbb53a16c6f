#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "axode/constraints/loops/loop_table.hpp"
#include "axode/constraints/row_cholesky.hpp"
#include "axode/constraints/rows_in_lanes.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/forward_dynamics.hpp"

namespace axode {

/// The rank of the rows of the loops, as LoopSystem::determine_rank() finds it at a closed configuration. Solutions
/// with this rank give redundant rows multipliers of 0. An integration keeps the rank for a whole step, because
/// rows that are redundant by geometry become independent as soon as the loops are a little open.
struct RowRank {
  std::vector<char> redundant = {};  ///< whether each row of A is redundant; empty where nothing was decided
};

/// The level at which constraints are imposed.
enum class ConstraintLevel {
  position,  ///< the rows R that have a residual, r' = R v
  velocity,  ///< all rows A, A v = 0
};

/// The loops of a tree at a state, and the system that they make:
///   M a + h - Aᵀ λ = τ,   A a + γ = 0
/// Articulated bodies factor M = Lᵀ D L, so that with Y = D^-½ L⁻ᵀ Aᵀ the multipliers come from Yᵀ Y λ = -(Yᵀ w + γ),
/// w = D^-½ L⁻ᵀ (τ - h): Gauss' principle. One sweep up for each row, along the path of its loop. O(n + m d + m² d + m³).
template <class T> class LoopSystem {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;
  using RowByRow = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit LoopSystem(const Model& model);

  const Model& model() const { return model_; }
  int size(ConstraintLevel level) const {
    return level == ConstraintLevel::velocity ? model_.loops().rows : model_.loops().residuals;
  }

  /// a and λ at a state; all NaN where the tree without its loops has no accelerations. The place is unknown afterwards.
  Solvability accelerate(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a, T* lambda,
                         const RowRank& rank = {}) noexcept;
  /// The forces (nv) of the tree at a motion, M a + h.
  void force(const T* q, const T* v, const T* a, const Loads<T>& loads, T* tau) noexcept;
  /// v after the impulses of loops that close suddenly, (A v)⁺ = -e A v, and these impulses.
  Solvability impact(const T* q, const T* v, const T& e, T* v_after, T* impulses) noexcept;
  /// Velocities after the impulses, and the impulses, at the configuration of the last factorize(q) or determine_rank(q).
  Solvability impact(const T* v, const T& e, T* v_after, T* impulses, const RowRank& rank = {}) noexcept;
  /// The step x towards a closed configuration, r + R x = 0, that moves the masses least.
  Solvability projection_step(const T* q, T* x, const RowRank& rank = {}) noexcept;

  /// Decides at a closed q which rows are redundant; the rows of velocities are factorised there afterwards.
  /// Decides nothing where the tree without its loops has no accelerations.
  Solvability determine_rank(const T* q, RowRank& rank) noexcept;
  /// Determines the rank of the rows of velocities that are factorised already.
  void determine_rank(RowRank& rank) noexcept;

  /// Links, screws and loops at q, or where bodies have the poses C, seen from an origin, which their joints need not allow.
  void update_kinematics(const T* q) noexcept;
  void update_kinematics(const SE3<T>* C, const Vec3<T>& origin) noexcept;
  /// And the forces h (nv) of the tree without accelerations, with the motion of all bodies.
  void move(const T* q, const T* v, const Loads<T>& loads, T* h) noexcept {
    force(q, v, zero_.data(), loads, h);
  }

  void residual(const T* q, T* r) const noexcept;  ///< after place() or move()
  /// Makes the rows; A, or R.
  void make_rows(ConstraintLevel level) noexcept;
  void make_wrenches(ConstraintLevel level) noexcept;  ///< without the entries
  /// Entries of the rows, dense, m × nv.
  void write(T* A) const noexcept;
  /// out = A x and out += Aᵀ λ.
  void times(const T* x, T* out) const noexcept;
  void add_transposed_times(const T* lambda, T* out) const noexcept;
  /// γ; after move(), or for twists of bodies about the origins of their roots.
  void bias(T* gamma) noexcept {
    bias(dynamics_->recursion.motion.bodies.V, dynamics_->recursion.motion.bodies.dV, gamma);
  }
  void bias(const Twist<Spatial, T>* V, const TwistRate<Spatial, T>* dV, T* gamma) const noexcept;
  /// Wᵀ X of bodies that move with X about the origins of their roots, and of joint rates x.
  void rates(const Twist<Spatial, T>* X, const T* x, T* out) const noexcept;
  /// W λ on bodies, likewise, and on joints.
  void add_wrenches(const T* lambda, Wrench<Spatial, T>* on, T* tau) const noexcept;
  /// The wrenches that the joints transmit under multipliers λ, W[1] to W[n], each about the origin of its root, in
  /// inertial axes. After force() and make_rows(ConstraintLevel::velocity).
  void joint_wrenches(const T* lambda, Wrench<Spatial, T>* W) noexcept;

  /// Partial derivatives along q and v of A a + γ (m × nv), and along q of Aᵀ λ (nv × nv), [component, direction], at the
  /// motion of force() and with the rows A made. Adds to what is there.
  void differentiate(const T* lambda, T* by_q, T* by_v, T* constraint_forces_by_q) noexcept;

  /// The rate of Rᵀ λ (nv) as the bodies move with their V; after move().
  void differentiate_residuals(const T* lambda, T* rate) noexcept;

  /// The place q, with M and the rows A factorised.
  Solvability factorize(const T* q, const RowRank& rank = {}) noexcept;
  /// M = Lᵀ D L at the configuration of the links, where joints may have another armature than the model says.
  Solvability factorize() noexcept { return factorize_with_armature(tree().armature.data()); }
  Solvability factorize_with_armature(const T* armature) noexcept;
  /// Y and Yᵀ Y of the rows.
  void factorize_rows() noexcept;
  /// λ with Yᵀ Y λ = -b, least where that does not fix it, and as far as the rows agree with each other.
  void solve_rows(const T* b, T* lambda, const RowRank& rank = {}) noexcept;
  /// Sets how small a part of a row solve_rows() ignores, by how far the loops are from closed at the place q.
  /// Accelerations, impulses and steps towards closed configurations set it where they are.
  void set_filter(const T* q, const RowRank& rank) noexcept;
  /// The smallest part of a row, squared, that the rows before it left in the last solve_rows(); 1 if no row was in doubt. Near 0
  /// branches of a motion meet, and accelerations are those of a mechanism with more freedoms.
  T weakest_row() const { return weakest_row_; }
  /// b += Yᵀ D^-½ L⁻ᵀ x = A M⁻¹ x.
  void add_response(const T* x, T* b) noexcept;
  /// The part of the accelerations that forces τ (nv) add, M a - Aᵀ λ = τ with A a = 0; with the rows factorised.
  void force_response(const T* tau, T* a) noexcept;
  /// x := M⁻¹ x.
  void solve(T* x) noexcept { dynamics_->bodies.solve(tree(), x); }

  /// W λ on the second body of loop joint k and -W λ on the first, about origin(k); after make_rows().
  Wrench<Spatial, T> wrench(std::size_t k, const T* lambda) const noexcept;
  Vec3<T> origin(std::size_t k) const noexcept;
  /// The origins of the roots in the inertial frame, at the index of each root body.
  const Vec3<T>* root_origins() const { return origin_; }

  /// D^-½ L⁻ᵀ Aᵀ, nv × m, and zeros up to a whole block.
  const RowByRow& Y() const { return Y_; }
  /// The size of each row, no less than a tenth of the largest of its loop: it may be felt by no joint.
  const Vector& scale() const { return scale_; }
  const LoopTable& table() const { return table_; }
  const Link<Spatial, T>& link(int i) const { return link_[i]; }
  /// The tree without its loops.
  ArticulatedBodies<Spatial, T>& bodies() { return dynamics_->bodies; }

 private:
  struct State {
    loops::LoopFrames<T> frames;  ///< about origin(k)
    Vec3<T> shift;                ///< from there to the origin of the first body's root
    loops::LoopWrenches<T> W;
  };
  const Tree<T>& tree() const { return model_.tree<T>(); }
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  using Range = LoopPath::Range;
  Range range(const LoopPath& path) const {
    return level_ == ConstraintLevel::velocity ? path.rows : path.residuals;
  }
  int count(const LoopPath& path) const { return range(path).count; }
  int first(const LoopPath& path) const { return range(path).first; }
  const std::vector<LoopTable::VelocityBlock>& blocks() const {
    return level_ == ConstraintLevel::velocity ? table_.row_blocks : table_.residual_blocks;
  }
  /// accelerate() with the fast articulated bodies; false, and a and λ not written, where these cannot, or where velocities
  /// are coupled.
  bool accelerate_fast(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a, T* lambda,
                       const RowRank& rank) noexcept;
  /// The motion of the two bodies of a loop joint about origin(k).
  loops::EndMotion<T> motion_of_ends(std::size_t k, const Twist<Spatial, T>* V,
                                     const TwistRate<Spatial, T>* dV) const noexcept;
  /// f(row, velocity, entry) for the entries of the rows.
  template <class F> void each_entry(const F& f) const {
    for (std::size_t k = 0; k < entries_.size(); ++k) {
      const LoopPath& path = table_.paths[k];
      const T* entry = entries_[k].data();
      for (const LoopColumn& column : path.columns)
        for (int r = 0; r < count(path); ++r) f(first(path) + r, column.velocity, *entry++);
    }
  }
  template <int n> void pull_rows_fast(const LoopPath& path, const State& at, int row) noexcept;
  /// Joint screws, and the loops between the bodies where they end.
  void place_loops() noexcept;
  void place_ends() noexcept;  ///< the loops alone
  void make_entries() noexcept;
  /// All that solve_rows() needs, at the place.
  Solvability prepare(ConstraintLevel level, const T* q, const RowRank& rank) noexcept;
  /// w = D^-½ L⁻ᵀ x.
  void pull(const T* x) noexcept;
  /// x = L⁻¹ D^-½ (w + Y λ).
  void push(const T* lambda, T* x) noexcept;
  /// b += Yᵀ w and w += Y λ.
  void add_to_rows(T* b) const noexcept;
  void add_to_velocities(const T* lambda) noexcept;
  /// f(row) for the redundant ones of the rows that were made.
  template <class F> void each_redundant(const RowRank& rank, const F& f) const;
  /// solve_rows() where every row is far from depending on others, in one step; false, and λ not written, otherwise.
  bool solve_sound_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// The same for all rows, step by step.
  void solve_filtered_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// What is to be factorised.
  void set_rows(const T* b, const T& filter, const RowRank& rank) noexcept;
  SE3<T> pose(const Loop::End& end, int root, const Vec3<T>& O) const noexcept;
  Wrench<Spatial, T> on_first(const State& at, const Wrench<Spatial, T>& W) const {
    return {W.m - cross(at.shift, W.f), W.f};
  }
  /// Takes the wrenches of a loop on its two bodies to the ground: step(i, F) past the joint of body i.
  template <class Wrenches, class Step>
  void propagate_to_root(const LoopPath& path, Wrenches& F_i, Wrenches& F_j,
                         const Step& step) const noexcept {
    const auto& parent = tree()->parent;
    for (int i = path.ends[0].body; i != path.meeting; i = parent[i]) step(i, F_i);
    for (int j = path.ends[1].body; j != path.meeting; j = parent[j]) step(j, F_j);
    F_j.m += F_i.m, F_j.f += F_i.f;
    for (int i = path.meeting; i > 0; i = parent[i]) step(i, F_j);
  }
  void pull_row(const LoopPath& path, int row, const Wrench<Spatial, T>& first,
                const Wrench<Spatial, T>& second) noexcept;
  template <int n> void pull_rows(const LoopPath& path, const State& at, int row) noexcept;
  void pull_loop(const LoopPath& path, const State& at) noexcept;
  void multiply_rows() noexcept;  ///< Yᵀ Y, on and above the diagonal

  /// What accelerate_fast() runs on: the tree, and the places and velocities of bodies against their roots.
  struct FastKernel {
    using Bodies = typename FastForwardDynamics<T>::Bodies;
    struct OriginMotion {
      typename Bodies::Vector r, v;
    };
    FastForwardDynamics<T> tree;
    OriginMotion* moving;

    explicit FastKernel(Arena& arena) : tree(arena), moving(arena.per_body<OriginMotion>()) {}
  };

  Model model_;
  WithScratch<T, ForwardDynamicsRecursion<Spatial, T>> dynamics_;
  WithScratch<T, FastKernel> fast_;
  LoopTable table_;
  Link<Spatial, T>* link_ = nullptr;
  Vec3<T>* origin_ = nullptr;
  std::vector<State> at_;  ///< of each loop joint
  ConstraintLevel level_ = ConstraintLevel::velocity;
  T filter_, weakest_row_ = T(1);
  std::vector<std::vector<T>> entries_;  ///< of each loop: A, a column of up to six rows for each LoopColumn
  RowByRow Y_, G_;
  RowCholesky<T> factor_;
  RowByRow left_;  ///< of Y, by the rows that are independent
  Eigen::RowVectorX<T> along_;
  Matrix basis_;
  Vector root_;  ///< D^-½, by velocity
  Vector scale_, zero_, forces_, w_, b_, lambda_, step_, rest_, moved_;
};

}  // namespace axode
