#pragma once
#include <Eigen/Cholesky>

#include "axode/constraints/embedding/task_space.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

/// Checks the results of a computation that ended with `verdict`, which says whether it succeeded or what was
/// singular. Returns this verdict, or not_finite if the computation succeeded but a result is not finite.
/// Unless the returned verdict is success, all results are set to NaN.
TaskVerdict judged(TaskVerdict verdict, std::initializer_list<std::span<double>> results) noexcept;

/// The equations of motion of a parallel manipulator in task velocities: components of the platform's twist,
/// and velocities of joints that the platform does not determine. The dependent velocities of each limb (a
/// chain that carries the platform) are eliminated from its loop equations. The equations that remain
/// restrict the carrying velocities, those of the joints between the ground and the platform.
class TaskKernel {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  struct Part {
    std::vector<int> velocities;  ///< dependent velocities, followed by the inner ones
    std::vector<int> loops, rows;
    int dependent = 0;
    int first_inner = 0;   ///< index of the first inner velocity of this limb among the task velocities
    bool coupled = false;  ///< whether the mass matrix of the tree couples this limb with the carrying
                           ///< velocities
    RowElimination<double> matrix;
    Matrix F;     ///< velocities of the limb × f task velocities: rows of F (D18.6)
    Vector x, b;  ///< scratch memory, one number for each velocity and for each row
    int inner() const { return static_cast<int>(velocities.size()) - dependent; }
    int first_carrying() const { return static_cast<int>(velocities.size()); }
  };

  TaskKernel(const Model& model, std::span<const double> q, int platform);

  int freedom() const { return freedom_; }
  LoopSystem<double>& system() { return system_; }
  const Model& model() const { return system_.model(); }
  const std::vector<Part>& parts() const { return parts_; }
  const std::vector<int>& carrying() const { return carrying_; }
  /// The number of independent carrying velocities.
  int independent() const { return static_cast<int>(carrying_.size()) - dependent_; }

  /// Eliminates the dependent velocities of each limb (a chain that carries the platform) and of the
  /// platform's joint from the loop equations ((D18.2) to (D18.5)). Returns what is singular.
  TaskVerdict resolve() noexcept;
  /// Computes the joint velocities or accelerations x (nv) that keep the loops closed, A x = -γ (D18.10),
  /// from task velocities or their rates X (f numbers). A is the Jacobian of the loop equations; γ is the
  /// bias of (A v)' = A a + γ for accelerations, and null for velocities. x may share the memory of X. The
  /// dependent velocities must have been eliminated from the loop equations before.
  void expand(const double* X, const double* gamma, double* x) noexcept;
  /// Computes the rows of F of all limbs (D18.6). Must be called after resolve().
  void make_F() noexcept;
  /// Computes the mass matrix of the task space (D18.11) at q, f × f for f task velocities. The kinematics at
  /// q must have been computed, and then the matrix that maps task velocities to joint velocities.
  void make_M(std::span<const double> q) noexcept;
  /// Computes Fᵀ w (f) for w (nv). Must be called after make_F().
  void project(const double* w, double* out) const noexcept;
  /// Subtracts M x (nv) from w, with the mass matrix M of the spanning tree. Requires make_M().
  void subtract_inertia_forces(const double* x, double* w) const noexcept;
  const Matrix& M() const { return M_; }
  const Matrix& N() const { return N_; }
  /// Replaces b by M⁻¹ b with the mass matrix M of f task velocities; false if M is not positive definite.
  bool solve(double* b) noexcept;

  std::string name_of_limb(int l) const;
  /// Throws std::invalid_argument if there is no platform.
  void check_platform() const;
  /// The pose of the platform's internal frame in the inertial frame, at the present kinematics.
  SE3<> platform_pose() const;

  int platform = 0;
  std::vector<std::string> names;

  const Vector zero;          ///< nv zeros
  Vector acceleration, bias;  ///< scratch memory of nv and of loops().rows numbers

 private:
  void make_parts(const Limbs& limbs);
  void determine_ranks();
  void choose_components();
  /// Sorts velocities by the pivots that an elimination chose: first the dependent velocities, which are
  /// those of the pivots, then the others, each in ascending order. Returns the number of dependent
  /// velocities.
  int sort(const RowElimination<double>& matrix, std::vector<int>& velocities);
  void number_columns(const std::vector<int>& velocities);
  /// Fill the matrix of a limb (a chain that carries the platform), or of the platform's joint, with its loop
  /// equations and eliminate the velocities that follow from the others. Both return whether the rank is
  /// certain.
  bool eliminate(Part& part) noexcept;
  bool eliminate_constraints() noexcept;
  /// Computes N for the independent carrying velocities as task velocities, N_c of (D18.4).
  void solve_constraints() noexcept;
  /// Replaces the task velocities, which are independent velocities of the platform's joint, by the chosen
  /// components of the platform's twist: changes the matrix N that maps task velocities to the velocities of
  /// the joint. Returns whether these components determine the motion.
  bool change_to_components() noexcept;
  /// Computes the mass matrix of the spanning tree at q; entries of velocities on different paths remain 0.
  void make_tree_M(std::span<const double> q) noexcept;

  LoopSystem<double> system_;
  Workspace<double> workspace_;
  std::vector<Part> parts_;
  std::vector<int> column_;    ///< nv: column of each velocity in the matrix of its limb, or its index among
                               ///< the carrying velocities
  std::vector<char> carries_;  ///< nv: whether each velocity is carrying
  std::vector<int> carrying_;  ///< the dependent carrying velocities, followed by the independent ones
  int dependent_ = 0;          ///< number of dependent carrying velocities
  int freedom_ = 0;
  RowElimination<double> constraints_;  ///< remaining rows of all limbs, with one column for each carrying
                                        ///< velocity
  std::vector<int> chosen_;      ///< components of the platform's twist that are task velocities, ascending
  Matrix P_;                     ///< chosen components of the platform's twist for a unit of each carrying
                                 ///< velocity
  bool are_components_ = false;  ///< whether the carrying velocities themselves are the chosen components
  RowElimination<double> to_components_;
  Matrix N_;  ///< carrying velocities × f: N of (D18.5)
  Matrix tree_M_, M_, work_;
  std::vector<Inertia<>> composite_;  ///< inertia of each body with its subtree, about the origin of its root
                                      ///< body
  std::vector<int> screw_;            ///< nv: the index of the joint screw of each velocity
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Vector before_, after_, remaining_, s_, y_;
};

}  // namespace axode
