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

/// Whether a quantity of a parallel manipulator exists at a configuration and, if not, what is singular.
struct TaskVerdict {
  enum class Kind {
    solved,
    limb_singular,        ///< type 1: joints of a limb can move while the platform is at rest
    drives_singular,      ///< type 2: the platform can move while all drives are locked
    constraint_singular,  ///< the limbs leave the platform one freedom more than at regular configurations
    mass_singular,        ///< the mass matrix of the task space is singular: a motion moves no mass
    not_finite,           ///< an argument or a result is not a finite number
  };
  Kind kind = Kind::solved;
  int limb = -1;  ///< index of the singular limb; -1 if no limb is singular
  bool ok() const { return kind == Kind::solved; }
};

/// The equations of motion of a parallel manipulator in its task space (D18.11):
///   M V' + h = Jᵀ u,   v = F V,   a = F V' + c.
/// V are the f task velocities: components of the platform's twist, and then the velocities of joints that
/// the platform does not determine. u are the forces of the drives, whose velocities are J V. v and a are the
/// velocities and accelerations of all joints (nv each), and c is a for V' = 0. M is the mass matrix for V,
/// and h has the Coriolis, centrifugal and gravity forces minus the generalised forces of the loads.
struct TaskEquations {
  TaskVerdict verdict;      ///< if it is not ok(), the matrices are empty
  Eigen::MatrixXd M;        ///< f × f, kg m², kg m and kg
  Eigen::VectorXd h;        ///< f numbers: Coriolis, centrifugal and gravity forces minus those of the loads
  Eigen::MatrixXd J;        ///< (number of drives) × f: the velocities of the drives are J V
  std::vector<int> drives;  ///< indices of the velocities with drives, ascending
  Eigen::MatrixXd F;        ///< nv × f matrix of v = F V
  Eigen::VectorXd c;        ///< nv numbers: the accelerations for V' = 0
};

/// A parallel manipulator in its task space: chains of bodies, the limbs, carry a body called the platform,
/// and the velocities of each limb follow from the motion of the platform independently of the other limbs.
/// The task velocities V are components of the body-fixed twist of the platform, as many as it has degrees of
/// freedom, followed by joint velocities that the platform does not determine, such as the spin of a rod
/// between two balls. Without a platform all task velocities are joint velocities. See (D18.1) to (D18.6) of
/// docs/derivations/constraint-embedding.md.
///
/// A TaskSpace has the scratch memory of one thread; only equations() allocates. Configurations q must close
/// the loops, and velocities v must keep them closed. The springs of the model do not act; their forces may
/// be added to those that forward_dynamics() takes. Costs are O(limbs) for limbs of bounded size.
class TaskSpace {
 public:
  /// Determines the limbs (the chains that carry the platform) and the task velocities at a regular
  /// configuration q with closed loops. `platform` is the name of a body whose joint is on the ground. If it
  /// is empty, the body is chosen for which computations limb by limb cost least, or none if the joint of
  /// this body is coupled or not on the ground. Throws std::invalid_argument for a wrong size of q or a q
  /// that leaves a loop open, an unknown body, a given platform whose joint is coupled or not on the ground,
  /// a mechanism without loops or with prescribed motions, and loop equations whose rank is uncertain because
  /// of rounding errors.
  TaskSpace(const Model& model, std::span<const double> q, std::string_view platform = {});
  ~TaskSpace();
  TaskSpace(TaskSpace&&) noexcept;
  TaskSpace& operator=(TaskSpace&&) noexcept;

  const Model& model() const;
  int platform() const;  ///< index of the platform's body, 0 if there is none
  /// The number f of task velocities, and their names. Components of the platform's twist are called
  /// "BODY.omega_x" to "BODY.v_z", where BODY is the name of the platform's body. Task velocities that are
  /// joint velocities have the names of these.
  int freedom() const;
  const std::vector<std::string>& names() const;
  /// limbs() is the number of limbs, which are the chains that carry the platform, and limb(l) has the
  /// indices of the velocities of limb l. If there are joints that belong neither to a limb nor to the path
  /// from the ground to the platform, their velocities count as one more limb, the last one.
  int limbs() const;
  const std::vector<int>& limb(int l) const;

  /// Computes v = F V (nv) from task velocities V (f), with one small linear system for each limb (D18.6).
  [[nodiscard]] TaskVerdict velocities(std::span<const double> q, std::span<const double> V,
                                       std::span<double> v);
  /// Computes the joint accelerations a (nv) for rates V' of the task velocities, at joint velocities v that
  /// keep the loops closed (D18.10).
  [[nodiscard]] TaskVerdict accelerations(std::span<const double> q, std::span<const double> v,
                                          std::span<const double> dV, std::span<double> a);
  /// Computes the drive forces τ (nv; 0 in passive joints) for the rates V' of the task velocities at (q, v)
  /// (D18.9). If there are more drives than needed, τ has the least Euclidean norm.
  [[nodiscard]] TaskVerdict inverse_dynamics(std::span<const double> q, std::span<const double> v,
                                             std::span<const double> dV, std::span<double> tau,
                                             const Loads<double>& loads = {});
  /// Computes the rates V' of the task velocities under joint forces τ (nv), which may act in passive joints
  /// too, and the accelerations a (nv) of the joints unless `a` is empty (D18.11).
  [[nodiscard]] TaskVerdict forward_dynamics(std::span<const double> q, std::span<const double> v,
                                             std::span<const double> tau, std::span<double> dV,
                                             std::span<double> a = {}, const Loads<double>& loads = {});
  /// Computes the matrices of the equations of motion. Allocates.
  [[nodiscard]] TaskEquations equations(std::span<const double> q, std::span<const double> v,
                                        const Loads<double>& loads = {});

  /// The computations and the scratch memory, for the other functions of constraints/embedding.
  TaskKernel& kernel() { return *kernel_; }
  const TaskKernel& kernel() const { return *kernel_; }

 private:
  std::unique_ptr<TaskKernel> kernel_;
};

/// One sentence for the user: what is singular, that numbers are not finite, or that nothing is singular.
std::string to_string(const TaskSpace& space, const TaskVerdict& verdict);

}  // namespace axode
