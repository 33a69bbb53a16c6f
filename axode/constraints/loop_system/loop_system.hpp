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
#include "axode/scalar/index.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// The redundant loop equations, as LoopSystem::determine_rank() found them at a closed configuration. If a
/// solution is computed with a RowRank, the multipliers of these equations are 0. An integration keeps one
/// RowRank for a whole step, because equations that are redundant only while the loops are closed become
/// independent as soon as the loops are a little open.
struct RowRank {
  std::vector<char> redundant = {};  ///< whether each row of A is redundant; empty before determine_rank()
};

/// The loop equation of a prescribed motion, in which a joint coordinate or the length of a rod (a loop joint
/// that keeps two points at a fixed distance) follows a function s of time. For the coordinate or length ρ
/// (rad or m) the residual is ρ - s, and the equations for velocities and accelerations are ρ' = s' and
/// ρ'' = s''. `row` is the index of the equation among those for velocities, and `residual` its index among
/// the residuals.
template <class T> struct PrescribedRow {
  int row = 0, residual = 0;
  T s{}, ds{}, dds{};  ///< s minus the constant that r already contains, such as the drawn length of a rod;
                       ///< s' and s''
};

/// The level at which constraints are imposed.
enum class ConstraintLevel {
  position,  ///< the rows R of the residuals r, r' = R v; some rows of A have no residual
  velocity,  ///< all rows A, with A v = 0
};

/// The loops of a spanning tree at a state (q, v), and the constrained equations of motion
///   M a + h - Aᵀ λ = τ,   A a + γ = 0
/// for the accelerations a and the multipliers λ of the loop equations A v = 0, with the drive forces τ, the
/// mass matrix M and the bias forces h of the tree, and γ = A' v. With M = Lᵀ D L, factorised by articulated
/// bodies, and Y = D^-½ L⁻ᵀ Aᵀ, the multipliers are solutions of Yᵀ Y λ = -(Yᵀ D^-½ L⁻ᵀ (τ - h) + γ) ((D7.1)
/// to (D7.6)). O(n + m d + m² d + m³) for n bodies and m loop equations on paths of d joints.
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

  /// Prescribes the right sides s, s' and s'' of some loop equations, for position, velocity and
  /// acceleration, for all later calls. For all other equations they are 0 (D12.1).
  void prescribe(std::span<const PrescribedRow<T>> rows) { prescribed_.assign(rows.begin(), rows.end()); }
  std::span<const PrescribedRow<T>> prescribed() const { return prescribed_; }

  /// Computes the accelerations a (nv) and the multipliers λ of the loop equations at (q, v). If the mass
  /// matrix of the spanning tree is singular, both are NaN. The kinematics that other functions use are not
  /// updated: call update_kinematics() before these.
  Solvability accelerate(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a, T* lambda,
                         const RowRank& rank = {}) noexcept;
  /// Computes the forces M a + h (nv) that the spanning tree needs for the motion (q, v, a), with its mass
  /// matrix M and bias forces h, and updates the kinematics and the motion of the bodies.
  void force(const T* q, const T* v, const T* a, const Loads<T>& loads, T* tau) noexcept;
  /// Computes the forces M a + h (nv) that the spanning tree needs for the motion (q, v, a), with its mass
  /// matrix M and bias forces h, and the Jacobian of the loop equations, by a fast algorithm. The forces
  /// are valid until the next call. The motion of the bodies, from which joint_wrenches() and differentiate()
  /// compute their results, is not updated.
  std::span<T> force_fast(const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept;
  /// Computes the residual (A v)' - s'' of the loop equations A v = s' (a number for each equation), where s'
  /// is not 0 for prescribed motions. The motion (q, v, a) and the loop equations for velocities must have
  /// been computed. The numbers are valid until the next call.
  std::span<const T> acceleration_residual(const T* a) noexcept;
  /// Computes drive forces τ (nv) and, unless `lambda` is null, multipliers λ of the loop equations A v = 0,
  /// such that τ + Aᵀ λ = f for given joint forces f of the spanning tree. If several τ are possible, the one
  /// with the least sum of squares (of numbers in N m and N) is taken. Drives act on the velocities with
  /// indices in `drives` or, if it is empty, on those of all joints that are not passive. The Jacobian A must
  /// have been computed. Returns false, without results, if the mechanism can move while all drives are
  /// locked, if λ is wanted and not unique, or if a rank in the elimination of A is uncertain because of
  /// rounding errors.
  bool drive_forces(std::span<const int> drives, const T* f, T* tau, T* lambda) noexcept;
  /// A scale by which eliminations judge the Jacobian of the loop equations: a pivot may be a rounding error
  /// if it is small compared with this scale or with the largest entry. The scale is 0.1 d. Here d is the
  /// largest distance (m) of a loop joint k from the point origin(k), about which its wrenches are taken, but
  /// at most 1, and 1 if the largest distance is 0.
  T considerable_entry() const noexcept;
  /// Computes the velocities v⁺ (nv) after an impact of the loops at q, A v⁺ = -e A v with the Jacobian A of
  /// the loop equations and the coefficient of restitution e, and the impulses of the equations (D7.12). With
  /// prescribed right sides s', A v - s' replaces A v.
  Solvability impact(const T* q, const T* v, const T& e, T* v_after, T* impulses) noexcept;
  /// Computes the velocities v⁺ (nv) after an impact, and the impulses, at the last factorised configuration.
  Solvability impact(const T* v, const T& e, T* v_after, T* impulses, const RowRank& rank = {}) noexcept;
  /// Computes a step x (nv) that closes the loops to first order: of all x with r + R x = 0, where r is the
  /// residual of the loops and R its Jacobian, the one with the least norm xᵀ M x for the mass matrix M
  /// (D7.13).
  Solvability projection_step(const T* q, T* x, const RowRank& rank = {}) noexcept;

  /// Factorises the mass matrix of the spanning tree and the loop equations at a closed configuration q, and
  /// writes to `rank` which equations are redundant. If the mass matrix is singular, `rank` keeps its
  /// contents.
  Solvability determine_rank(const T* q, RowRank& rank) noexcept;
  /// Determines which of the rows A are redundant. The rows must be factorised already, see factorize_rows().
  void determine_rank(RowRank& rank) noexcept;

  /// Computes the poses of the bodies, the joint screws and the frames of the loop joints. The first function
  /// computes them for joint coordinates q; the second one for poses C of the bodies relative to the point
  /// `origin` in inertial axes, which need not agree with the joints.
  void update_kinematics(const T* q) noexcept;
  void update_kinematics(const SE3<T>* C, const Vec3<T>& origin) noexcept;
  /// Updates the kinematics with the motion of all bodies, and computes the bias forces h (nv) of the tree.
  void move(const T* q, const T* v, const Loads<T>& loads, T* h) noexcept {
    force(q, v, zero_.data(), loads, h);
  }

  void residual(const T* q, T* r) const noexcept;  ///< computes the residual r(q) minus s, after
                                                   ///< update_kinematics() or move()
  /// Computes A v - s'. Must be called after make_rows(ConstraintLevel::velocity).
  void velocity_residual(const T* v, T* out) const noexcept;
  /// Computes the wrenches of the loop joints and the entries of the rows of a level, A or R.
  void make_rows(ConstraintLevel level) noexcept;
  void make_wrenches(ConstraintLevel level) noexcept;  ///< computes only the wrenches of make_rows(), not the
                                                       ///< entries
  /// The entries of the Jacobian of the loop equations that can be non-zero, for each loop, stored column by
  /// column. A column has an entry for each equation of the loop. It belongs to a joint screw on the paths in
  /// the spanning tree from the two bodies of the loop to the body where these paths meet, or to a term of a
  /// coupling of joints.
  const std::vector<std::vector<T>>& entries() const { return entries_; }
  /// Writes the entries of the rows A or R of the present level as a dense matrix, m × nv, row by row.
  void write(T* A) const noexcept;
  /// times() computes out = A x, and add_transposed_times() adds Aᵀ λ to `out`. A is the Jacobian that was
  /// computed last. It is that of the loop equations A v = 0 for the velocities v, or that of the position
  /// residuals r(q) of the loops.
  void times(const T* x, T* out) const noexcept;
  void add_transposed_times(const T* lambda, T* out) const noexcept;
  /// Computes γ - s'' for the loop equations A v = s' with prescribed right sides s', where γ is the part of
  /// (A v)' that does not depend on accelerations (D6.7). The first function uses the motion of the bodies
  /// that move() computed last. The second one takes the twists V of the bodies and the rates dV that the
  /// twists have if the joint velocities are constant. Both are in inertial axes, for each body about the
  /// origin of the first body on the path from the ground to it.
  void bias(T* gamma) noexcept {
    bias(dynamics_->recursion.motion.bodies.V, dynamics_->recursion.motion.bodies.dV, gamma);
  }
  void bias(const Twist<Spatial, T>* V, const TwistRate<Spatial, T>* dV, T* gamma) const noexcept;
  /// Computes the rates A x of all loop equations (D6.6), with their Jacobian A, for joint velocities x (nv).
  /// X are the twists of the bodies at these velocities in inertial axes, for each body about the origin of
  /// the first body on the path from the ground to it.
  void rates(const Twist<Spatial, T>* X, const T* x, T* out) const noexcept;
  /// Adds the constraint forces of the loops for multipliers λ. Loop joints exert wrenches on the bodies,
  /// which are added to `on`: in inertial axes, for each body about the origin of the first body on the path
  /// from the ground to it. Couplings of joints exert joint forces, which are added to tau (nv).
  void add_wrenches(const T* lambda, Wrench<Spatial, T>* on, T* tau) const noexcept;
  /// Computes the wrenches W[1] to W[n] that the joints transmit for multipliers λ of the loop equations, in
  /// inertial axes, each about the origin of the first body on the path from the ground to the body. The
  /// motion and the loop equations for velocities must have been computed.
  void joint_wrenches(const T* lambda, Wrench<Spatial, T>* W) noexcept;

  /// Computes derivatives of (A v)' = A a + γ, for the loop equations A v = 0, at the motion (q, v, a) of the
  /// bodies that was computed last, and adds them to three matrices, which are stored row by row ((D6.10),
  /// (D6.11)): the derivatives of (A v)' by q and v to by_q and by_v (m × nv each), and the derivative by q
  /// of the constraint forces Aᵀ λ, for given constant multipliers λ, to constraint_forces_by_q (nv × nv). A
  /// must have been computed.
  void differentiate(const T* lambda, T* by_q, T* by_v, T* constraint_forces_by_q) noexcept;
  /// Computes the rate of Rᵀ λ (nv) for constant λ as the bodies move with the velocities of the last move().
  void differentiate_residuals(const T* lambda, T* rate) noexcept;

  /// Updates the kinematics to q, and factorises the mass matrix M of the tree and the rows A.
  Solvability factorize(const T* q, const RowRank& rank = {}) noexcept;
  /// Factorises the mass matrix of the spanning tree at the present kinematics, with the armature of the
  /// model or another one (nv, kg m² and kg).
  Solvability factorize() noexcept { return factorize_with_armature(tree().armature.data()); }
  Solvability factorize_with_armature(const T* armature) noexcept;
  /// Computes Y = D^-½ L⁻ᵀ Aᵀ, G = Yᵀ Y = A M⁻¹ Aᵀ and the size of each loop equation: the square root of its
  /// diagonal entry of G, but not less than a limit (D7.7). M = Lᵀ D L is the mass matrix of the spanning
  /// tree, and A the Jacobian of the equations.
  void factorize_rows() noexcept;
  /// Solves A M⁻¹ Aᵀ λ = -b for the multipliers λ of the loop equations A v = 0 and a given b (one number for
  /// each equation), with the mass matrix M of the spanning tree. The multipliers of equations that are
  /// redundant according to `rank` are 0. If the other equations are dependent or nearly so, λ approximates
  /// the solution with the least Σ d_k² λ_k² (D7.8), where d_k² is the diagonal entry of A M⁻¹ Aᵀ for
  /// equation k, but not less than a limit.
  void solve_rows(const T* b, T* lambda, const RowRank& rank = {}) noexcept;
  /// Sets a small number μ, the filter, from the residual of the loops at q. Later solutions for multipliers
  /// have no part in directions in which A M⁻¹ Aᵀ is small compared with μ times its diagonal entries (D7.9).
  /// A is the Jacobian of the loop equations, and M the mass matrix of the spanning tree.
  void set_filter(const T* q, const RowRank& rank) noexcept;
  /// A number from 1 (independent) to 0 (dependent) for the loop equations A v = 0 of the last computation of
  /// multipliers. It is the least ratio of a pivot in the factorisation of A M⁻¹ Aᵀ, with the mass matrix M,
  /// to d², the diagonal entry of A M⁻¹ Aᵀ for the equation of the pivot, but not less than a limit. If all
  /// these ratios are larger than 1e-3 (float: 1e-2), the number is 1. Equations that determine_rank() had
  /// found redundant do not count. If the number is near 0, the configuration is nearly singular, and the
  /// accelerations are those of a mechanism with more degrees of freedom.
  T weakest_row() const { return weakest_row_; }
  /// Adds A M⁻¹ x to b (m numbers) for x (nv). The rows must be factorised.
  void add_response(const T* x, T* b) noexcept;
  /// Computes the accelerations a that forces τ (nv) add: M a - Aᵀ λ = τ with A a = 0 (D7.14), for the mass
  /// matrix M of the spanning tree and the factorised loop equations with Jacobian A and multipliers λ.
  void force_response(const T* tau, T* a) noexcept;
  /// Replaces x (nv) by M⁻¹ x.
  void solve(T* x) noexcept { dynamics_->bodies.solve(tree(), x); }

  /// The wrench of loop joint k on its second body, for the multipliers λ; the opposite wrench acts on the
  /// first body. It is about the point that origin(k) returns. The wrenches for unit multipliers must have
  /// been computed.
  Wrench<Spatial, T> wrench(std::size_t k, const T* lambda) const noexcept;
  Vec3<T> origin(std::size_t k) const noexcept;
  /// The origins in the inertial frame of the root bodies, which are joined to the ground. Each is stored at
  /// the index of its body.
  const Vec3<T>* root_origins() const { return origin_; }

  /// The matrix Y = D^-½ L⁻ᵀ Aᵀ of the last factorisation, with the Jacobian A of the m loop equations and
  /// the mass matrix LᵀD L of the spanning tree. It is nv × m, followed by columns of zeros up to a multiple
  /// of 8.
  const RowByRow& Y() const { return Y_; }
  /// The size of each loop equation, by which its rounding errors are judged: the square root of its diagonal
  /// entry of A M⁻¹ Aᵀ, but not less than a limit (D7.7). A is the Jacobian of the equations, and M the mass
  /// matrix of the spanning tree.
  const Vector& scale() const { return scale_; }
  const LoopTable& table() const { return table_; }
  const Link<Spatial, T>& link(int i) const { return link_[i]; }
  /// The diagonal of D^-½ (nv) of the last factorisation of the mass matrix M = LᵀD L of the spanning tree.
  const Vector& root() const { return root_; }
  /// The articulated bodies of the spanning tree.
  ArticulatedBodies<Spatial, T>& bodies() { return dynamics_->bodies; }

 private:
  struct State {
    loops::LoopFrames<T> frames;  ///< frames of the loop joint on its two bodies, relative to origin(k)
    Vec3<T> shift;                ///< vector from origin(k) to the origin of the root body of the first body
    loops::LoopWrenches<T> W;     ///< wrenches on the second body for unit multipliers
  };
  const Tree<T>& tree() const { return model_.tree<T>(); }
  using Range = LoopPath::Range;
  Range range(const LoopPath& path) const {
    return level_ == ConstraintLevel::velocity ? path.rows : path.residuals;
  }
  int count(const LoopPath& path) const { return range(path).count; }
  int first(const LoopPath& path) const { return range(path).first; }
  const std::vector<LoopTable::VelocityBlock>& blocks() const {
    return level_ == ConstraintLevel::velocity ? table_.row_blocks : table_.residual_blocks;
  }
  /// Computes accelerations, and multipliers of the loop equations, by the articulated-body algorithm without
  /// estimates of rounding errors (D4.12). Returns false, without results, if the model has couplings (loop
  /// equations between joint coordinates) or coupled joints (joints whose coordinate depends on that of
  /// another joint and that share its velocity), if the mass matrix may be singular, or if all equations of a
  /// loop may be rounding errors, because their diagonal entries of A M⁻¹ Aᵀ are close to 0 (A: their
  /// Jacobian, M: mass matrix).
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
  /// Factorises the mass matrix M = LᵀD L of the spanning tree, and computes Y = D^-½ L⁻ᵀ Aᵀ and Yᵀ Y for the
  /// Jacobian A of the loop equations: of all equations for velocities or, at the position level, of the
  /// position residuals. Also sets the filter, a small number μ: if equations are nearly dependent, each
  /// diagonal entry of A M⁻¹ Aᵀ is increased by μ times itself (D7.9). The kinematics must have been updated
  /// to q.
  Solvability prepare(ConstraintLevel level, const T* q, const RowRank& rank) noexcept;
  /// Computes w = D^-½ L⁻ᵀ x for x (nv), and stores it in w_.
  void pull(const T* x) noexcept;
  /// Computes x = L⁻¹ D^-½ (w + Y λ) (nv) with w in w_.
  void push(const T* lambda, T* x) noexcept;
  /// add_to_rows() adds Yᵀ w to b, and add_to_velocities() adds Y λ to w, with w in w_.
  void add_to_rows(T* b) const noexcept;
  void add_to_velocities(const T* lambda) noexcept;
  /// Calls f(row) for those rows of the present level that are redundant in `rank`.
  template <class F> void each_redundant(const RowRank& rank, const F& f) const;
  /// Solves A M⁻¹ Aᵀ λ = -b for the multipliers λ of the loop equations A v = 0 by one Cholesky
  /// factorisation, with the mass matrix M and a given b. The multipliers of equations that are redundant
  /// according to `rank` are 0. Returns false, without λ, if the pivot of another equation is at most 1e-3
  /// (float: 1e-2) of d². For each equation, d² is the larger of two numbers: its diagonal entry of A M⁻¹ Aᵀ,
  /// and a lower limit, such as 1 % of the largest diagonal entry of its loop.
  bool solve_sound_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// Solves A M⁻¹ Aᵀ λ = -b for the multipliers λ of the loop equations A v = 0, which may be dependent, by
  /// the proximal iteration (D7.8), with the mass matrix M and a given b.
  void solve_filtered_rows(const T* b, T* lambda, const RowRank& rank) noexcept;
  /// Sets up the linear system A M⁻¹ Aᵀ λ = -b of the multipliers λ for a given b, with the Jacobian A of the
  /// loop equations and the mass matrix M of the tree. Each diagonal entry is increased by `filter` d²
  /// (D7.9). For each equation, d² is the larger of two numbers: its diagonal entry of A M⁻¹ Aᵀ, and a lower
  /// limit, such as 1 % of the largest diagonal entry of its loop. The multipliers of redundant equations
  /// become 0.
  void set_rows(const T* b, const T& filter, const RowRank& rank) noexcept;
  SE3<T> pose(const Loop::End& end, int root, const Vec3<T>& O) const noexcept;
  Wrench<Spatial, T> on_first(const State& at, const Wrench<Spatial, T>& W) const {
    return {W.m - cross(at.shift, W.f), W.f};
  }
  /// Moves the wrenches of a loop, F_i on its first and F_j on its second body, along the paths of these
  /// bodies to the ground. Where the two paths meet, F_j becomes the sum of both wrenches. step(i, F) moves F
  /// across the joint of body i.
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
  /// Each of these functions computes a part of Y = D^-½ L⁻ᵀ Aᵀ (D7.6), where LᵀD L is the mass matrix of the
  /// spanning tree and A the Jacobian of the loop equations. pull_row() computes the column of Y for one loop
  /// equation, pull_rows() the columns for n equations of one loop, and pull_loop() the columns for all
  /// equations of one loop. All three use the factors of the mass matrix that ArticulatedBodies has computed.
  /// pull_rows_fast() computes the same columns as pull_rows(), but from the factors that the fast
  /// articulated-body algorithm has computed.
  void pull_row(const LoopPath& path, int row, const Wrench<Spatial, T>& first,
                const Wrench<Spatial, T>& second) noexcept;
  template <int n> void pull_rows(const LoopPath& path, const State& at, int row) noexcept;
  template <int n> void pull_rows_fast(const LoopPath& path, const State& at, int row) noexcept;
  void pull_loop(const LoopPath& path, const State& at) noexcept;
  void multiply_rows() noexcept;  ///< computes G = Yᵀ Y, on and above the diagonal, and first bounds of the
                                  ///< sizes d

  /// The motion and the wrenches of the bodies of the spanning tree at a state, and its articulated bodies.
  struct TreeDynamics {
    InverseDynamicsRecursion<Spatial, T> recursion;
    ArticulatedBodies<Spatial, T> bodies;

    explicit TreeDynamics(Arena& arena) : recursion(arena), bodies(arena) {}
  };
  /// Scratch memory of accelerate_fast() and force_fast(), whose size depends on the SIMD instruction set.
  /// For each body it has the position r of the origin relative to that of its root body (the one joined to
  /// the ground) and the velocity v of the origin; force_fast() also uses the rotation R and the angular
  /// velocity w. All are in inertial axes.
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
  std::vector<State> at_;  ///< frames and wrenches of each loop joint
  std::vector<PrescribedRow<T>> prescribed_;
  ConstraintLevel level_ = ConstraintLevel::velocity;
  static constexpr T least_filter = std::same_as<T, float> ? T(1e-5) : T(1e-12);
  T filter_ = least_filter;  ///< filter μ of solve_rows() (D7.9)
  T weakest_row_ = T(1);
  std::vector<std::vector<T>> entries_;  ///< entries of A or R for each loop: a column of up to six entries
                                         ///< for each LoopColumn
  RowByRow Y_, G_;
  RowCholesky<T> factor_;
  DriveElimination<T> drives_;
  std::vector<char> driven_;  ///< nv: whether each velocity has a drive
  RowByRow left_;             ///< remainder of Y after the projection on the columns of independent rows is
                              ///< subtracted
  Eigen::RowVectorX<T> along_;
  Matrix basis_;
  Vector root_;  ///< diagonal of D^-½ (nv), with the D of M = Lᵀ D L
  Vector scale_, zero_, forces_, w_, b_, lambda_, step_, rest_, moved_;
};

}  // namespace axode
