#include "axode/constraints/constrained_dynamics.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/loop_system/geared_acceleration.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/dynamics/gear_losses.hpp"
#include "axode/dynamics/wrench_frame.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

/// The memory for multipliers or impulses: the caller's span or, if this is empty, memory of its own.
template <class T> class Multipliers {
 public:
  Multipliers(const Model& model, const char* name, std::span<T> given) : given_(given) {
    if (given.empty()) {
      own_.resize(static_cast<std::size_t>(model.loops().rows));
    } else {
      check_rows(name, given.size(), model.loops().rows, "loops().rows");
    }
  }
  T* data() { return given_.empty() ? own_.data() : given_.data(); }

 private:
  std::span<T> given_;
  std::vector<T> own_;
};

/// The forces M a + h (nv) that the spanning tree needs for accelerations a, with its mass matrix M and bias
/// forces h.
template <class T> struct TreeForces {
  /// Computes the forces, and updates `system` to the motion (q, v, a). Throws std::invalid_argument for
  /// wrong sizes and loads.
  TreeForces(LoopSystem<T>& system, Numbers<T> q, Numbers<T> v, Numbers<T> a, const Loads<T>& loads)
      : need(system.model().nv()) {
    check_size("a", a.size(), v.size(), "nv");
    check_loads(system.model(), loads, true);
    system.move(q.data(), v.data(), loads, need.data());
    rounding = rounding_of_need();
    system.force(q.data(), v.data(), a.data(), loads, need.data());
    rounding += rounding_of_need();
  }
  /// Subtracts joint forces that act besides those of the drives.
  void subtract(Numbers<T> forces) {
    for (Eigen::Index c = 0; c < need.size(); ++c) need[c] -= forces[static_cast<std::size_t>(c)];
    rounding += rounding_of_need();
  }

  Eigen::VectorX<T> need;
  T rounding;  ///< of the terms that may cancel in `need`: no smaller part of it is known

 private:
  T rounding_of_need() const { return RowElimination<T>::rounding * need.stableNorm(); }
};

/// Computes drive forces that, together with the constraint forces of the loops, have the same effect on the
/// motion as given joint forces of the spanning tree, or nearly so (least squares) if no drive forces have.
/// If there are several solutions, the one with the least sum of squares (of numbers in N m and N) is taken
/// (D7.10). The kinematics of the LoopSystem must have been updated.
template <class T> struct DriveForces {
  using Vector = Eigen::VectorX<T>;

  DriveForces(LoopSystem<T>& system, const TreeForces<T>& forces, const std::vector<int>& drives)
      : rows(system, ConstraintLevel::velocity), tau(Vector::Zero(forces.need.size())) {
    const Vector& need = forces.need;
    const Eigen::MatrixXd N = rows.kernel().template cast<double>(), basis = rows.effective_forces(drives);
    const Eigen::VectorXd wanted = N.transpose() * need.template cast<double>();
    const Eigen::MatrixXd moving = N(drives, Eigen::indexing::all).transpose() * basis;
    const Eigen::VectorXd x = least_squares(moving, wanted, 0);
    tau(drives) = (basis * x).template cast<T>();
    const T left = static_cast<T>((wanted - moving * x).stableNorm());
    missing = left > forces.rounding ? left / need.stableNorm() : T(0);
    by_loops = need - tau;
  }

  IndependentRows<T> rows;
  Vector tau, by_loops;  ///< forces of the drives and Aᵀ λ of the loops, nv numbers each; their sum is `need`
  T missing;             ///< the part of |need| that neither drives nor loops produce
};

/// Throws std::invalid_argument if a gear has losses and its joint is not among the drives.
template <class T>
void check_gears_driven(const Model& model, const Loads<T>& loads, std::span<const int> drives) {
  if (!loads.joint_losses || model.gears().empty()) return;
  const std::vector<int> all = driven(model, drives);
  for (const Gear& gear : model.gears())
    if (std::ranges::find(all, gear.velocity) == all.end())
      throw std::invalid_argument("the gear of joint \"" +
                                  velocity_names(model)[static_cast<std::size_t>(gear.velocity)] +
                                  "\" has losses, and its joint is not among the drives; add it to them, or "
                                  "set joint_losses to false");
}

/// Computes the wrench that each joint of the spanning tree transmits to its body for the multipliers
/// `lambda` of the loops. W[i - 1] belongs to joint i, in the representation Rep of the frame of body i, with
/// this frame moved to the point `at` (origin of the body frame or of the joint frame) without turning it.
/// Spatial wrenches are about the inertial origin. `system` must have computed the forces of the spanning
/// tree and the rows of the loop equations.
template <class Rep, class T>
void write_joint_wrenches(const Model& model, LoopSystem<T>& system, Numbers<T> lambda, WrenchPoint at,
                          std::span<Wrench<Rep, T>> W) {
  std::vector<Wrench<Spatial, T>> about_root(W.size() + 1);
  system.joint_wrenches(lambda.data(), about_root.data());
  each_root(model.topology(), [&](int root) {
    for (int i = root; i < model.topology().subtree_end[root]; ++i) {
      const Wrench<Spatial, T>& W_i = about_root[static_cast<std::size_t>(i)];
      Wrench<Rep, T>& out = W[static_cast<std::size_t>(i - 1)];
      if constexpr (std::same_as<Rep, Spatial>) {
        out = {W_i.m + cross(system.root_origins()[root], W_i.f), W_i.f};
      } else {
        out = change<Rep>(system.link(i).C * wrench_frame<T>(model, i, at), W_i);
      }
    }
  });
}

}  // namespace

template <class T>
Solvability forward_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             std::type_identity_t<std::span<T>> lambda,
                             const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_motions<"forward_dynamics">(model);
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("tau", tau.size(), v.size(), "nv");
  check_size("a", a.size(), v.size(), "nv");
  check_loads(model, loads, true);
  check_separate("lambda", lambda, "a", a);
  Multipliers<T> multipliers(model, "lambda", lambda);
  return accelerate_with_losses(system, model, q, v, tau, loads, a, multipliers.data());
}

template <class T>
T inverse_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<T>> tau, std::type_identity_t<std::span<T>> lambda,
                   std::span<const int> drives, const std::type_identity_t<Loads<T>>& loads,
                   std::type_identity_t<Numbers<T>> forces) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("tau", tau.size(), v.size(), "nv");
  check_separate("lambda", lambda, "tau", tau);
  if (!forces.empty()) {
    check_size("forces", forces.size(), v.size(), "nv");
    check_separate("tau", tau, "forces", forces);
  }
  if (!lambda.empty()) check_rows("lambda", lambda.size(), model.loops().rows, "loops().rows");
  check_drives(model, drives);
  check_size("a", a.size(), v.size(), "nv");
  check_loads(model, loads, true);
  check_gears_driven(model, loads, drives);
  std::optional<GearLosses<T>> gears;
  if (loads.joint_losses && !model.gears().empty()) {
    if (forces.empty()) refuse_springs_with_gears("inverse_dynamics", "give them as `forces`", model);
    gears.emplace(model, v, a);
  }
  const std::span<T> f = system.force_fast(q.data(), v.data(), a.data(), loads);
  if constexpr (std::same_as<T, double>)  // in single precision A a + γ consists of rounding errors
    check_accelerations(system, q, v, a);
  for (std::size_t c = 0; c < forces.size(); ++c) f[c] -= forces[c];
  if (system.drive_forces(drives, f.data(), tau.data(), lambda.empty() ? nullptr : lambda.data())) {
    if (gears) gears->add(tau);
    return T(0);
  }
  const std::vector<int> at = driven(model, drives);
  TreeForces<T> of_tree(system, q, v, a, loads);
  if (!forces.empty()) of_tree.subtract(forces);
  const DriveForces<T> found(system, of_tree, at);
  std::ranges::copy(found.tau, tau.begin());
  if (gears) gears->add(tau);
  if (!lambda.empty()) found.rows.least_multipliers(found.by_loops, lambda);
  return found.missing;
}

template <RecursionRepresentation Rep, class T>
void joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<Numbers<T>> lambda,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads, WrenchPoint at) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_rows("lambda", lambda.size(), model.loops().rows, "loops().rows");
  check_size("W", W.size(), static_cast<std::size_t>(model.n_bodies()), "n_bodies");
  check_size("a", a.size(), v.size(), "nv");
  check_loads(model, loads, true);
  Eigen::VectorX<T> forces(model.nv());
  system.force(q.data(), v.data(), a.data(), loads, forces.data());
  system.make_rows(ConstraintLevel::velocity);
  write_joint_wrenches<Rep>(model, system, lambda, at, W);
}

template <RecursionRepresentation Rep, class T>
T joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                 std::type_identity_t<std::span<Wrench<Rep, T>>> W, std::span<const int> drives,
                 const std::type_identity_t<Loads<T>>& loads, WrenchPoint at) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("W", W.size(), static_cast<std::size_t>(model.n_bodies()), "n_bodies");
  check_gears_driven(model, loads, drives);
  const TreeForces<T> of_tree(system, q, v, a, loads);
  system.make_rows(ConstraintLevel::velocity);
  if constexpr (std::same_as<T, double>)  // in single precision A a + γ consists of rounding errors
    check_accelerations(system, q, v, a);
  const DriveForces<T> found(system, of_tree, driven(model, drives));
  std::vector<T> lambda(static_cast<std::size_t>(model.loops().rows));
  found.rows.least_multipliers(found.by_loops, lambda);
  write_joint_wrenches<Rep>(model, system, Numbers<T>(lambda), at, W);
  return found.missing;
}

template <class T>
Solvability impact(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, T restitution,
                   std::type_identity_t<std::span<T>> v_after, std::type_identity_t<std::span<T>> impulses) {
  catalog::check_counts<"impact">(model);
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("v_after", v_after.size(), v.size(), "nv");
  check_separate("impulses", impulses, "v", v);
  check_separate("impulses", impulses, "v_after", v_after);
  if (!(restitution >= T(0) && restitution <= T(1)))
    throw std::invalid_argument("restitution is " + to_text(static_cast<double>(restitution)) +
                                "; it must be from 0 to 1");
  return system.impact(q.data(), v.data(), restitution, v_after.data(),
                       Multipliers<T>(model, "impulses", impulses).data());
}

template <RecursionRepresentation Rep, class T>
void loop_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                   std::type_identity_t<std::span<Wrench<Rep, T>>> W) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("lambda", lambda.size(), model.loops().rows, "loops().rows");
  const std::vector<Loop>& joints = model.loops().joints;
  check_size("W", W.size(), model.loops().all.size(), "loops().all.size()");
  system.update_kinematics(q.data());
  system.make_wrenches(ConstraintLevel::velocity);
  const Tree<T>& tree = model.tree<T>();
  std::ranges::fill(W, Wrench<Rep, T>{});
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const Wrench<Spatial, T> about_O = system.wrench(k, lambda.data());
    const int j = joints[k].ends[1].body;
    const Vec3<T> O = system.origin(k);
    if constexpr (std::same_as<Rep, Spatial>) {
      W[k] = {about_O.m + cross(O, about_O.f), about_O.f};
    } else {
      const SE3<T> C = j > 0 ? system.link(j).C * tree.frame_offset[j] : SE3<T>{{}, -O};
      W[k] = change<Rep>(C, about_O);
    }
  }
}

template AXODE_ENTRY Solvability forward_dynamics(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                                  Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                                  std::span<AXODE_T>, const Loads<AXODE_T>&);
template AXODE_ENTRY AXODE_T inverse_dynamics(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                              Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                              std::span<AXODE_T>, std::span<const int>, const Loads<AXODE_T>&,
                                              Numbers<AXODE_T>);
template AXODE_ENTRY Solvability impact(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                        Numbers<AXODE_T>, AXODE_T, std::span<AXODE_T>, std::span<AXODE_T>);
#define AXODE_WRENCHES(Rep)                                                                             \
  template AXODE_ENTRY void loop_wrenches<Rep>(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, \
                                               Numbers<AXODE_T>, std::span<Wrench<Rep, AXODE_T>>);      \
  template AXODE_ENTRY void joint_wrenches<Rep>(                                                        \
      const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>, Numbers<AXODE_T>,      \
      Numbers<AXODE_T>, std::span<Wrench<Rep, AXODE_T>>, const Loads<AXODE_T>&, WrenchPoint);           \
  template AXODE_ENTRY AXODE_T joint_wrenches<Rep>(                                                     \
      const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>, Numbers<AXODE_T>,      \
      std::span<Wrench<Rep, AXODE_T>>, std::span<const int>, const Loads<AXODE_T>&, WrenchPoint)
AXODE_WRENCHES(BodyFixed);
AXODE_WRENCHES(Spatial);
AXODE_WRENCHES(Hybrid);
AXODE_WRENCHES(Mixed);
#undef AXODE_WRENCHES

}  // namespace axode
