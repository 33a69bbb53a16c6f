#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

class TaskKernel;

/// Whether a quantity of a parallel manipulator exists at a configuration, and what is singular if not.
struct TaskVerdict {
  enum class Kind {
    solved,
    limb_singular,        ///< type 1: joints of a limb can move while the platform is at rest
    drives_singular,      ///< type 2: the platform can move while all drives are locked
    constraint_singular,  ///< the limbs of reduced mobility leave the platform another freedom
    mass_singular,        ///< a motion moves no mass
    not_finite,           ///< an argument or a result is not a finite number
  };
  Kind kind = Kind::solved;
  int limb = -1;  ///< the number of the singular limb
  bool ok() const { return kind == Kind::solved; }
};

/// The equations of motion of a parallel manipulator in its task space (D18.11):
///   M V' + h = Jᵀ u,   v = F V,   a = F V' + c
/// for f task velocities V, the forces u of d drives, and all nv joint velocities v.
struct TaskEquations {
  TaskVerdict verdict;      ///< if it is not ok(), the matrices are empty
  Eigen::MatrixXd M;        ///< f × f, kg m², kg m and kg
  Eigen::VectorXd h;        ///< f, Coriolis, centrifugal and gravity forces, less those of loads
  Eigen::MatrixXd J;        ///< d × f: the rates of the drives are J V
  std::vector<int> drives;  ///< the velocities of the drives, ascending
  Eigen::MatrixXd F;        ///< nv × f
  Eigen::VectorXd c;        ///< nv
};

/// A parallel manipulator in its task space: a platform that is carried by limbs, each of which is resolved
/// by itself from the motion of the platform. The task velocities V are components of the body-fixed twist of
/// the platform, as many as it has freedoms, followed by joint velocities that the platform does not
/// determine: those of a rod that spins between two balls, or of an arm on the platform. Without a platform
/// all task velocities are joint velocities.
///
/// A TaskSpace has the scratch memory of one thread; its functions do not allocate. Configurations q must be
/// closed and velocities v must keep the loops closed, as place() and velocities() compute them. Costs are
/// O(limbs) for limbs of bounded size. See docs/derivations/constraint-embedding.md.
class TaskSpace {
 public:
  /// Determines the limbs, their mobility and the task velocities at a closed configuration q that should not
  /// be singular. `platform` is the name of a body whose joint is on the ground; if it is empty, the body is
  /// taken for which eliminations limb by limb cost least. Throws std::invalid_argument for a wrong q, an
  /// unknown body or one that another body carries, a mechanism without loops, prescribed motions, and ranks
  /// that rounding leaves open. Springs act only if their forces are added to τ.
  TaskSpace(const Model& model, std::span<const double> q, std::string_view platform = {});
  ~TaskSpace();
  TaskSpace(TaskSpace&&) noexcept;
  TaskSpace& operator=(TaskSpace&&) noexcept;

  const Model& model() const;
  int platform() const;  ///< the body, 0 if there is none
  /// The number f of task velocities, and their names: "platform.omega_x" to "platform.v_z", or the name of a
  /// joint velocity.
  int freedom() const;
  const std::vector<std::string>& names() const;
  /// The number of limbs, and the velocities of one. The last limb has no loops if joints move independently.
  int limbs() const;
  const std::vector<int>& limb(int l) const;

  /// Computes v = F V (nv) from task velocities V (f), with one small linear system for each limb (D18.6).
  [[nodiscard]] TaskVerdict velocities(std::span<const double> q, std::span<const double> V,
                                       std::span<double> v);
  /// Computes a = F V' + c (nv) at a motion v that keeps the loops closed (D18.10).
  [[nodiscard]] TaskVerdict accelerations(std::span<const double> q, std::span<const double> v,
                                          std::span<const double> dV, std::span<double> a);
  /// Computes the drive forces τ (nv; 0 in passive joints) for the rates V' of the task velocities (D18.9).
  /// If there are more drives than needed, τ is the least one.
  [[nodiscard]] TaskVerdict inverse_dynamics(std::span<const double> q, std::span<const double> v,
                                             std::span<const double> dV, std::span<double> tau,
                                             const Loads<double>& loads = {});
  /// Computes the rates V' (f) of the task velocities and, unless it is empty, the accelerations a (nv) under
  /// joint forces τ (nv), which may act in passive joints too (D18.11).
  [[nodiscard]] TaskVerdict forward_dynamics(std::span<const double> q, std::span<const double> v,
                                             std::span<const double> tau, std::span<double> dV,
                                             std::span<double> a = {}, const Loads<double>& loads = {});
  /// Computes the matrices of the equations of motion. Allocates.
  [[nodiscard]] TaskEquations equations(std::span<const double> q, std::span<const double> v,
                                        const Loads<double>& loads = {});

  /// The scratch memory, for the functions of this room.
  TaskKernel& kernel() { return *kernel_; }
  const TaskKernel& kernel() const { return *kernel_; }

 private:
  std::unique_ptr<TaskKernel> kernel_;
};

/// One sentence for the user: what is singular, or that numbers are not finite.
std::string to_string(const TaskSpace& space, const TaskVerdict& verdict);

}  // namespace axode
