#pragma once
#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "axode/constraints/embedding/drive_elimination.hpp"
#include "axode/constraints/loop_system/row_cholesky.hpp"
#include "axode/constraints/loop_system/rows_in_lanes.hpp"
#include "axode/constraints/loops/loop_table.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// The redundant rows of the loops, as LoopSystem::determine_rank() finds them at a closed configuration. In
/// solutions with this rank, the multipliers of redundant rows are 0. An integration keeps the rank for a
/// whole step, because rows that are redundant by geometry become independent as soon as the loops are a
/// little open.
struct RowRank {
  std::vector<char> redundant = {};  ///< whether each row of A is redundant; empty before determine_rank()
};

/// A row that follows a function of time: r = ρ - s, A v = s' and A a + γ = s''.
template <class T> struct PrescribedRow {
  int row = 0, residual = 0;
  T s{}, ds{}, dds{};  ///< s less what the drawing has for it, s' and s''
};

/// The level at which constraints are imposed.
enum class ConstraintLevel {
  position,  ///< the rows R, those that have a residual r, with r' = R v
  velocity,  ///< all rows A, A v = 0
};

/// The loops of a tree at a state, and the linear system of motion under them:
///   M a + h - Aᵀ λ = τ,   A a + γ = 0
/// Articulated bodies factorise M = Lᵀ D L, so that Y = D^-½ L⁻ᵀ Aᵀ and Yᵀ Y λ = -(Yᵀ w + γ) with w = D^-½
/// L⁻ᵀ (τ - h). Y takes one sweep to the root for each row, along the path of its loop. O(n + m d + m² d +
/// m³) for m rows on paths of d joints. See (D7.1) to (D7.6) of docs/derivations.
template <class T> class AXODE_ENTRY LoopSystem {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;
  using RowByRow = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit LoopSystem(const Model& model);
  ~LoopSystem();

  const Model& model() const { return model_; }
  int size(ConstraintLevel level) const {
    return level == ConstraintLevel::velocity ? model_.loops().rows : model_.loops().residuals;
  }

  /// The right sides of rows from now on, see (D12.1) of docs/derivations. All other right sides are 0.
  void prescribe(std::span<const PrescribedRow<T>> rows) { prescribed_.assign(rows.begin(), rows.end()); }

  /// Computes a and λ at a state; both are NaN if the mass matrix of the tree is singular. The kinematics
  /// have to be updated before any other call.
  Solvability accelerate(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a, T* lambda,
                         const RowRank& rank = {}) noexcept;
  /// Computes the forces M a + h (nv) of the tree at a motion.
  void force(const T* q, const T* v, const T* a, const Loads<T>& loads, T* tau) noexcept;
  /// Computes M a + h with the fast kernel, and the rows A of velocities. Returns the nv forces; they are
  /// valid until the next call. Afterwards only acceleration_residual() and drive_forces() may be called.
  std::span<T> force_fast(const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept;
  /// A a + γ - s'' of all rows at the motion of the last force() or force_fast() with the accelerations a.
  /// The rows A must have been made. The numbers are valid until the next call.
  std::span<const T> acceleration_residual(const T* a) noexcept;
  /// Computes the least drive forces τ (nv) and, unless it is null, the multipliers λ, such that τ + Aᵀ λ =
  /// f, with drives at the given velocities or, if there are none, at those of all joints that are not
  /// passive. The rows A must have been made. Returns false without results if the elimination is not
  /// certain, see DriveElimination.
  bool drive_forces(std::span<const int> drives, const T* f, T* tau, T* lambda) noexcept;
  /// A lower bound of the size of an entry of A that is not 0 by geometry or by a singularity, for decisions
  /// about rounding errors: a tenth of the largest lever of a loop joint about the origin of a root, at most
  /// 0.1.
  T considerable_entry() const noexcept;
  /// Computes v after an impact of the loops, A v⁺ = -e A v, and the impulses (D7.12). With prescribed rows
  /// A v - s' takes the place of A v.
  Solvability impact(const T* q, const T* v, const T& e, T* v_after, T* impulses) noexcept;
  /// Computes an impact at the configuration of the last factorize(q) or determine_rank(q).
  Solvability impact(const T* v, const T& e, T* v_after, T* impulses, const RowRank& rank = {}) noexcept;
  /// Computes a step x towards a closed configuration, with r + R x = 0. Of all such steps it is the least
  /// one in the norm of the mass matrix (D7.13).
  Solvability projection_step(const T* q, T* x, const RowRank& rank = {}) noexcept;

  /// Determines which rows are redundant at a closed q. Afterwards the rows A are factorised at q. If the
  /// mass matrix of the tree is singular, `rank` remains unchanged.
  Solvability determine_rank(const T* q, RowRank& rank) noexcept;
  /// Determines which of the rows A are redundant; these must be factorised already.
  void determine_rank(RowRank& rank) noexcept;

  /// Computes links, joint screws and loop ends at q. The overload takes the poses C of the bodies about
  /// `origin` instead, which the joints need not allow.
  void update_kinematics(const T* q) noexcept;
  void update_kinematics(const SE3<T>* C, const Vec3<T>& origin) noexcept;
  /// Updates the kinematics with the motion of all bodies, and computes the bias forces h (nv) of the tree.
  void move(const T* q, const T* v, const Loads<T>& loads, T* h) noexcept {
    force(q, v, zero_.data(), loads, h);
  }

  void residual(const T* q, T* r) const noexcept;  ///< r(q), after update_kinematics() or move()
  /// Computes A v - s' with the rows of velocities made.
  void velocity_residual(const T* v, T* out) const noexcept;
  /// Computes the wrenches and the entries of the rows of a level, A or R.
  void make_rows(ConstraintLevel level) noexcept;
  void make_wrenches(ConstraintLevel level) noexcept;  ///< computes the wrenches, but not the entries
  /// The entries of the rows of each loop: a column of its rows for each LoopColumn of its path.
  const std::vector<std::vector<T>>& entries() const { return entries_; }
  /// Writes the entries of the rows as a dense matrix, m × nv.
  void write(T* A) const noexcept;
  /// Computes out = A x; add_transposed_times() adds Aᵀ λ to out.
  void times(const T* x, T* out) const noexcept;
  void add_transposed_times(const T* lambda, T* out) const noexcept;
  /// Computes γ - s'' (D6.7) after move(), or for given twists and rates of the bodies about the origins of
  /// their roots.
  void bias(T* gamma) noexcept {
    bias(dynamics_->recursion.motion.bodies.V, dynamics_->recursion.motion.bodies.dV, gamma);
  }
  void bias(const Twist<Spatial, T>* V, const TwistRate<Spatial, T>* dV, T* gamma) const noexcept;
  /// Computes out = A v (D6.6) from the twists X of the bodies about the origins of their roots, and from the
  /// joint rates x.
  void rates(const Twist<Spatial, T>* X, const T* x, T* out) const noexcept;
  /// Adds the wrenches W λ of the loops to the wrenches `on` the bodies, which are about the origins of the
  /// roots, and adds the forces of couplings to tau (nv).
  void add_wrenches(const T* lambda, Wrench<Spatial, T>* on, T* tau) const noexcept;
  /// Computes the wrenches that the joints transmit under multipliers λ, W[1] to W[n], each about the origin
  /// of its root, in inertial axes. Must be called after force() and make_rows(ConstraintLevel::velocity).
  void joint_wrenches(const T* lambda, Wrench<Spatial, T>* W) noexcept;

  /// Adds the partial derivatives of A a + γ by q and v (m × nv), and of Aᵀ λ by q (nv × nv), [component,
  /// direction], at the motion of the last force(), after make_rows(ConstraintLevel::velocity). See (D6.10)
  /// and (D6.11) of docs/derivations.
  void differentiate(const T* lambda, T* by_q, T* by_v, T* constraint_forces_by_q) noexcept;
  /// Computes the rate of Rᵀ λ (nv) for constant λ, as the bodies move with their twists. Must be called
  /// after move().
  void differentiate_residuals(const T* lambda, T* rate) noexcept;

  /// Updates the kinematics, and factorises M and the rows A.
  Solvability factorize(const T* q, const RowRank& rank = {}) noexcept;
  /// Factorises M = Lᵀ D L at the present kinematics, with the armature of the model or with another one.
  Solvability factorize() noexcept { return factorize_with_armature(tree().armature.data()); }
  Solvability factorize_with_armature(const T* armature) noexcept;
  /// Computes Y, G = Yᵀ Y and the sizes d of the rows (D7.7).
  void factorize_rows() noexcept;
  /// Solves G λ = -b. If rows are redundant, λ is the least solution; if rows contradict each other, it is
  /// the least-squares solution (D7.8).
  void solve_rows(const T* b, T* lambda, const RowRank& rank = {}) noexcept;
  /// Sets μ, the part of a row that solve_rows() ignores, by the residual of the loops at q (D7.9).
  /// accelerate(), impact(q) and projection_step() call it themselves.
  void set_filter(const T* q, const RowRank& rank) noexcept;
  /// The least pivot of a row in the last solve_rows(), relative to the square of the size of this row; 1 if
  /// all rows were far from redundant. If it is near 0, branches of the motion meet, and accelerations are
  /// those of a mechanism with more degrees of freedom.
  T weakest_row() const { return weakest_row_; }
  /// Adds A M⁻¹ x to b.
  void add_response(const T* x, T* b) noexcept;
  /// Computes the accelerations a that additional forces τ (nv) cause: M a - Aᵀ λ = τ with A a = 0 (D7.14).
  /// The rows A must be factorised.
  void force_response(const T* tau, T* a) noexcept;
  /// Replaces x by M⁻¹ x.
  void solve(T* x) noexcept { dynamics_->bodies.solve(tree(), x); }

  /// The wrench W λ on the second body of loop joint k, about origin(k); -W λ acts on the first body. Must be
  /// called after make_rows().
  Wrench<Spatial, T> wrench(std::size_t k, const T* lambda) const noexcept;
  Vec3<T> origin(std::size_t k) const noexcept;
  /// The origins of the roots in the inertial frame, at the index of each root body.
  const Vec3<T>* root_origins() const { return origin_; }

  /// The matrix Y = D^-½ L⁻ᵀ Aᵀ, nv × m, padded with zero columns to a whole block.
  const RowByRow& Y() const { return Y_; }
  /// The size d of each row (D7.7).
  const Vector& scale() const { return scale_; }
  const LoopTable& table() const { return table_; }
  const Link<Spatial, T>& link(int i) const { return link_[i]; }
  /// The articulated bodies of the spanning tree.
  ArticulatedBodies<Spatial, T>& bodies() { return dynamics_->bodies; }

 private:
  struct State {
    loops::LoopFrames<T> frames;  ///< the frames of the joint on its two bodies, about origin(k)
    Vec3<T> shift;                ///< vector from origin(k) to the origin of the first body's root
    loops::LoopWrenches<T> W;     ///< wrenches on the second body for unit multipliers
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
  /// Computes what accelerate() does, with the fast articulated bodies. Returns false, without a and λ, if
  /// velocities are coupled or if a pivot is too small for the fast elimination.
  bool accelerate_fast(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a, T* lambda,
                       const RowRank& rank) noexcept;
  /// The motion of the two bodies of a loop joint about origin(k).
  loops::EndMotion<T> motion_of_ends(std::size_t k, const Twist<Spatial, T>* V,
                                     const TwistRate<Spatial, T>* dV) const noexcept;
  /// Calls f(row, velocity, entry) for the entries of the rows of the present level.
  template <class F> void each_entry(const F& f) const {
    for (std::size_t k = 0; k < entries_.size(); ++k) {
      const LoopPath& path = table_.paths[k];
      const T* entry = entries_[k].data();
      for (const LoopColumn& column : path.columns)
        for (int r = 0; r < count(path); ++r) f(first(path) + r, column.velocity, *entry++);
    }
  }
  void update_loops() noexcept;      ///< updates joint screws and loop ends
  void update_loop_ends() noexcept;  ///< updates only the frames of the loop joints
  void make_entries() noexcept;
  /// Factorises M and the rows of a level at the present kinematics.
  Solvability prepare(ConstraintLevel level, const T* q, const RowRank& rank) noexcept;
  /// Computes w = D^-½ L⁻ᵀ x.
  void pull(const T* x) noexcept;
  /// Computes x = L⁻¹ D^-½ (w + Y λ).
  void push(const T* lambda, T* x) noexcept;
  /// Adds Yᵀ w to b; add_to_velocities() adds Y λ to w.
  void add_to_rows(T* b) const noexcept;
  void add_to_velocities(const T* lambda) noexcept;
  /// Calls f(row) for the redundant rows among those of the present level.
  template <class F> void each_redundant(const RowRank& rank, const F& f) const;
  /// Solves G λ = -b in one step. Returns false, without λ, unless every row is far from redundant.
  bool solve_sound_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// Solves G λ = -b by the proximal iteration (D7.8).
  void solve_filtered_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// Writes G + filter d² and the right side -b for the factorisation.
  void set_rows(const T* b, const T& filter, const RowRank& rank) noexcept;
  SE3<T> pose(const Loop::End& end, int root, const Vec3<T>& O) const noexcept;
  Wrench<Spatial, T> on_first(const State& at, const Wrench<Spatial, T>& W) const {
    return {W.m - cross(at.shift, W.f), W.f};
  }
  /// Moves the wrenches of a loop on its two bodies along the paths to the ground. step(i, F) is called for
  /// each body i on the way, and moves F across the joint of this body.
  template <class Wrenches, class Step>
  void propagate_to_root(const LoopPath& path, Wrenches& F_i, Wrenches& F_j,
                         const Step& step) const noexcept {
    const auto& parent = tree()->parent;
    for (int i = path.ends[0].body; i != path.meeting; i = parent[i]) step(i, F_i);
    for (int j = path.ends[1].body; j != path.meeting; j = parent[j]) step(j, F_j);
    F_j.m += F_i.m;
    F_j.f += F_i.f;
    for (int i = path.meeting; i > 0; i = parent[i]) step(i, F_j);
  }
  /// Compute entries of Y: for one row, for n rows of a loop, for n rows with the fast articulated bodies,
  /// and for all rows of a loop (D7.6).
  void pull_row(const LoopPath& path, int row, const Wrench<Spatial, T>& first,
                const Wrench<Spatial, T>& second) noexcept;
  template <int n> void pull_rows(const LoopPath& path, const State& at, int row) noexcept;
  template <int n> void pull_rows_fast(const LoopPath& path, const State& at, int row) noexcept;
  void pull_loop(const LoopPath& path, const State& at) noexcept;
  void multiply_rows() noexcept;  ///< computes Yᵀ Y, on and above the diagonal

  /// The motion and the wrenches of the cut tree at a state, and its articulated bodies.
  struct TreeDynamics {
    InverseDynamicsRecursion<Spatial, T> recursion;
    ArticulatedBodies<Spatial, T> bodies;

    explicit TreeDynamics(Arena& arena) : recursion(arena), bodies(arena) {}
  };
  /// Scratch of accelerate_fast() and force_fast(): the fast kernels, and the motion of the bodies about the
  /// origins of their roots. Its size depends on the instruction set.
  struct FastKernel {
    using Bodies = typename FastForwardDynamics<T>::Bodies;
    struct OriginMotion {
      typename Bodies::Vector r, v;
    };
    struct BodyMotion {
      typename Bodies::Matrix R;
      typename Bodies::Vector r, v, w;
    };
    FastForwardDynamics<T> tree;
    InverseDynamicsRecursion<Fast, T> inverse;
    OriginMotion* moving;
    BodyMotion* motion;

    explicit FastKernel(Arena& arena)
        : tree(arena),
          inverse(arena),
          moving(arena.per_body<OriginMotion>()),
          motion(arena.per_body<BodyMotion>()) {}
  };

  Model model_;
  WithScratch<T, TreeDynamics> dynamics_;
  std::unique_ptr<WithScratch<T, FastKernel>> fast_;
  LoopTable table_;
  Link<Spatial, T>* link_ = nullptr;
  Vec3<T>* origin_ = nullptr;
  std::vector<State> at_;  ///< one for each loop joint
  std::vector<PrescribedRow<T>> prescribed_;
  ConstraintLevel level_ = ConstraintLevel::velocity;
  static constexpr T least_filter = std::same_as<T, float> ? T(1e-5) : T(1e-12);
  T filter_ = least_filter;  ///< μ (D7.9)
  T weakest_row_ = T(1);
  std::vector<std::vector<T>> entries_;  ///< entries of A or R for each loop: a column of up to six rows for
                                         ///< each LoopColumn
  RowByRow Y_, G_;
  RowCholesky<T> factor_;
  DriveElimination<T> drives_;
  std::vector<char> driven_;  ///< nv: whether each velocity has a drive
  RowByRow left_;             ///< Y minus its projection on the independent rows
  Eigen::RowVectorX<T> along_;
  Matrix basis_;
  Vector root_;  ///< D^-½ (nv)
  Vector scale_, zero_, forces_, w_, b_, lambda_, step_, rest_, moved_;
};

}  // namespace axode
