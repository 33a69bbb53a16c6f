#pragma once
#include <Eigen/Cholesky>

#include "axode/constraints/embedding/task_space.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"

namespace axode {

/// Completes a verdict: results that are not finite are refused, and results without a solution are NaN.
TaskVerdict judged(TaskVerdict verdict, std::initializer_list<std::span<double>> results) noexcept;

/// The computations of a TaskSpace. Each limb has velocities that its rows determine from the others, its
/// dependent ones, and `inner` ones that are task velocities; what remains of its rows are the wrenches that
/// the limb exerts on the platform however its joints move, and the carrying velocities must not work on
/// these.
class TaskKernel {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  struct Part {
    std::vector<int> velocities;  ///< the dependent ones, followed by the inner ones
    std::vector<int> loops, rows;
    int dependent = 0;
    int first_inner = 0;   ///< number of its first inner velocity among the task velocities
    bool coupled = false;  ///< whether the mass matrix couples it with the carrying velocities
    RowElimination<double> matrix;
    Matrix F;     ///< velocities × f
    Vector x, b;  ///< scratch, a number for each velocity and for each row
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

  /// Resolves the limbs and the carrying velocities at the present rows A of velocities, (D18.2) to (D18.5).
  TaskVerdict resolve() noexcept;
  /// Computes x (nv) with A x = -γ and the task part X (f): v for γ = 0, which may be null, or a (D18.10).
  /// x may share the memory of X. Must follow resolve().
  void expand(const double* X, const double* gamma, double* x) noexcept;
  /// Computes F of (D18.6). Must follow resolve().
  void make_F() noexcept;
  /// Computes M (f × f) of (D18.11) at q and the present kinematics, after make_F().
  void make_M(std::span<const double> q) noexcept;
  /// Computes Fᵀ w (f) for w (nv).
  void project(const double* w, double* out) const noexcept;
  /// Subtracts the product of the mass matrix of the tree and x from w (nv both), after make_M().
  void subtract_inertia_forces(const double* x, double* w) const noexcept;
  const Matrix& M() const { return M_; }
  const Matrix& N() const { return N_; }
  /// Replaces b (f) by the solution x of M x = b. Returns false if M is not positive definite.
  bool solve(double* b) noexcept;

  std::string name_of_limb(int l) const;
  /// Throws std::invalid_argument if there is no platform.
  void check_platform() const;
  /// The pose of the internal frame of the platform in the inertial frame, at the present kinematics.
  SE3<> platform_pose() const;

  int platform = 0;
  std::vector<std::string> names;

  const Vector zero;          ///< nv
  Vector acceleration, bias;  ///< scratch of nv and of loops().rows numbers

 private:
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  void make_parts(const Limbs& limbs);
  void determine_ranks();
  void choose_components();
  /// Orders velocities as an elimination chose them: the dependent ones, then the others. Returns the number
  /// of dependent ones.
  int sort(const RowElimination<double>& matrix, std::vector<int>& velocities);
  void number_columns(const std::vector<int>& velocities);
  /// Fills the rows of a limb with entries of A, and eliminates the dependent velocities; returns whether the
  /// rank is certain. The second function does so with the rows that remain of all limbs.
  bool eliminate(Part& part) noexcept;
  bool eliminate_constraints() noexcept;
  /// Computes the columns of N for the independent carrying velocities, N_c of (D18.4).
  void solve_constraints() noexcept;
  /// Changes the columns of N to those of the chosen components; returns whether these determine the motion.
  bool change_to_components() noexcept;
  /// Computes the mass matrix of the tree, entries of velocities on one path, at the present kinematics.
  void make_tree_M(std::span<const double> q) noexcept;

  LoopSystem<double> system_;
  Workspace<double> workspace_;
  std::vector<Part> parts_;
  std::vector<int> column_;    ///< nv: column of a velocity in its limb, or among the carrying ones
  std::vector<char> carries_;  ///< nv
  std::vector<int> carrying_;  ///< the dependent carrying velocities, followed by the independent ones
  int dependent_ = 0;          ///< number of dependent carrying velocities
  int freedom_ = 0;
  RowElimination<double> constraints_;  ///< what remains of the rows of the limbs, on carrying velocities
  std::vector<int> chosen_;      ///< components of the platform's twist that are task velocities, ascending
  Matrix P_;                     ///< those of the twist for a unit of each carrying velocity
  bool are_components_ = false;  ///< whether the carrying velocities themselves are these components
  RowElimination<double> to_components_;
  Matrix N_;  ///< carrying × f
  Matrix tree_M_, M_, work_;
  std::vector<Inertia<>> composite_;  ///< of each body with its subtree, about the origin of its root
  std::vector<int> screw_;            ///< nv: the number of the joint screw of each velocity
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Vector before_, after_, remaining_, s_, y_;
};

}  // namespace axode
