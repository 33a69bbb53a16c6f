#pragma once
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

class LimbPack;

/// Checks the results of a computation that ended with `verdict`, which says whether it succeeded or what was
/// singular. Returns this verdict, or not_finite if the computation succeeded but a result is not finite.
/// Unless the returned verdict is success, all results are set to NaN.
TaskVerdict judged(TaskVerdict verdict, std::initializer_list<std::span<double>> results) noexcept;

/// The equations of motion of a parallel manipulator in task velocities: components of the platform's twist,
/// and velocities of joints that the platform does not determine. The joint that connects the platform to the
/// ground in the spanning tree is most often a free joint; its velocities are called the carrying velocities.
/// The dependent velocities of each limb (a chain that carries the platform) are eliminated from its loop
/// equations. The equations that remain restrict the carrying velocities. Limbs with the same numbers of
/// equations and velocities are computed together, in SIMD lanes.
class AXODE_ENTRY TaskKernel {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  struct Part {
    std::vector<int> velocities;  ///< dependent velocities, those without a drive first, and the inner ones
    std::vector<int> loops, rows;
    int dependent = 0;
    bool coupled = false;  ///< whether the mass matrix of the tree couples this limb with the joint between
                           ///< the ground and the platform
    int inner() const { return static_cast<int>(velocities.size()) - dependent; }
  };

  TaskKernel(const Model& model, std::span<const double> q, int platform);
  ~TaskKernel();

  int freedom() const { return freedom_; }
  LoopSystem<double>& system() { return system_; }
  const Model& model() const { return system_.model(); }
  const std::vector<Part>& parts() const { return parts_; }
  const std::vector<int>& carrying() const { return carrying_; }
  /// The number of velocities of the joint between the ground and the platform that can be chosen
  /// independently under the loop equations: the degrees of freedom of the platform.
  int independent() const { return static_cast<int>(carrying_.size()) - dependent_; }

  /// Eliminates the dependent velocities of each limb (a chain that carries the platform) and of the joint
  /// between the ground and the platform from the loop equations ((D18.2) to (D18.5)). Returns limb_singular
  /// with the index of a limb whose loop equations do not determine its dependent velocities,
  /// constraint_singular if the motion of the platform is not determined by its task velocities, and
  /// otherwise solved.
  TaskVerdict resolve() noexcept;
  /// Computes the joint velocities or accelerations x (nv) that keep the loops closed, A x = -γ (D18.10),
  /// from task velocities or their rates X (f numbers). A is the Jacobian of the loop equations; γ is the
  /// bias of (A v)' = A a + γ for accelerations, and null for velocities. x may share the memory of X. The
  /// dependent velocities must have been eliminated from the loop equations before.
  void expand(const double* X, const double* gamma, double* x) noexcept;
  /// Computes the rows of all limbs (chains that carry the platform) in the matrix F, which maps task
  /// velocities to joint velocities (D18.6). Must be called after resolve().
  void make_F() noexcept;
  /// Writes the complete matrix F, nv × f, which maps task velocities to joint velocities (D18.6). Must be
  /// called after make_F(), which computes the rows of F for the limbs, the chains that carry the platform.
  void write_F(Eigen::MatrixXd& F) const;
  /// Computes the forces M a + h (nv) that the spanning tree needs for the motion (q, v, a), with its mass
  /// matrix M and bias forces h. They are valid until the next call.
  std::span<double> tree_forces(std::span<const double> q, std::span<const double> v, const double* a,
                                const Loads<double>& loads) noexcept;
  /// Computes the drive forces τ (nv) of a motion, in which the spanning tree needs the joint forces f = M a
  /// + h (nv) with its mass matrix M and bias forces h ((D18.7) to (D18.9)). Returns false, without results,
  /// if the mechanism can move while all drives are locked, or if rounding leaves this open. Must be called
  /// after resolve().
  bool drive_forces(const double* f, double* tau) noexcept;
  /// Computes the mass matrix of the task space (D18.11) at q, f × f for f task velocities. Requires the
  /// kinematics at q and make_F(), which computes the matrix F that maps task velocities to joint velocities.
  void make_M(std::span<const double> q) noexcept;
  /// Computes Fᵀ w (f numbers) for w (nv), where F maps task velocities to joint velocities. Must be called
  /// after make_F(), which computes F.
  void project(const double* w, double* out) noexcept;
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
  bool has_drive(int c) const { return model().loops().driven[index(c)] != 0; }
  void make_parts(const Limbs& limbs);
  void determine_ranks();
  /// Distributes the limbs (chains that carry the platform) over packs, whose limbs are computed together in
  /// SIMD lanes. The limbs of a pack have the same numbers of loop equations, of dependent velocities (which
  /// the loop equations determine) with and without a drive, and of other velocities. The loop equations of a
  /// limb also contain the velocities of the joint that connects the platform to the ground in the spanning
  /// tree; `carrying_` lists them in the order of their columns.
  void make_packs();
  void choose_components();
  /// Orders `velocities` in three groups: the dependent velocities without a drive, the dependent ones with a
  /// drive, and the independent ones, each group in ascending order. The dependent velocities are those for
  /// which the elimination of `matrix` found a pivot. Returns their number.
  int sort(const RowElimination<double>& matrix, std::vector<int>& velocities);
  void number_columns(const std::vector<int>& velocities);
  /// Finds the dependent velocities of a limb. Throws std::invalid_argument if rounding leaves the rank open.
  void determine_rank(Part& part);
  /// Eliminates the dependent velocities of all limbs from their loop equations. Returns the index of a limb
  /// that is singular; -1 if there is none.
  int eliminate_limbs() noexcept;
  /// Eliminates the dependent velocities of the joint that connects the platform to the ground in the
  /// spanning tree, most often a free joint. `carrying_` lists the velocities of this joint, the `dependent_`
  /// dependent ones first. They are eliminated from the loop equations that remain after the elimination of
  /// the limbs' velocities. Returns whether the rank of these equations is certain in spite of rounding
  /// errors.
  bool eliminate_constraints() noexcept;
  /// Computes the matrix N_c of (D18.4) and stores it in `N_`. The loop equations restrict the velocities of
  /// the joint between the ground and the platform, so that only some of these velocities are independent, as
  /// many as the platform has degrees of freedom. N_c maps the independent velocities of this joint to all
  /// its velocities.
  void solve_constraints() noexcept;
  /// Replaces the task velocities of the platform: they are independent velocities of the joint between the
  /// ground and the platform before the call, and the chosen components of the platform's twist after it.
  /// Changes the matrix N that maps task velocities to the velocities of the joint (D18.5). Returns whether
  /// the chosen components determine the motion of the platform.
  bool change_to_components() noexcept;
  /// Computes the inertias of the bodies with the indices first, first + 1, ..., one in each SIMD lane. They
  /// are in inertial axes, about the origin of the first body on the path from the ground to each body.
  void set_inertias(int first) noexcept;
  /// Computes the mass matrix of the spanning tree at q; entries of velocities on different paths remain 0.
  void make_tree_M(std::span<const double> q) noexcept;

  LoopSystem<double> system_;
  Workspace<double> workspace_;
  std::vector<Part> parts_;
  std::vector<LimbPack> packs_;
  std::vector<int>
      first_inner_;  ///< for each limb: the first of its inner velocities among the task velocities
  std::unique_ptr<WithScratch<double, InverseDynamicsRecursion<Fast, double>>> inverse_;
  std::vector<double> forces_;  ///< nv: result of tree_forces()
  std::vector<int> column_;     ///< nv: column of each velocity in the matrix of its limb, or its index among
                                ///< the carrying velocities
  std::vector<char> carries_;   ///< nv: whether each velocity is carrying
  std::vector<int> carrying_;   ///< the dependent carrying velocities, followed by the independent ones
  int dependent_ = 0;           ///< number of dependent carrying velocities
  int freedom_ = 0;
  RowElimination<double> constraints_;  ///< remaining rows of all limbs, with one column for each carrying
                                        ///< velocity
  std::vector<int> chosen_;      ///< components of the platform's twist that are task velocities, ascending
  Matrix P_;                     ///< chosen components of the platform's twist for a unit of each carrying
                                 ///< velocity
  bool are_components_ = false;  ///< whether the carrying velocities themselves are the chosen components
  RowElimination<double> to_components_;
  /// The linear system for the multipliers of the loop equations that remain after the elimination of the
  /// limbs' velocities without a drive (D18.8). It has a row for each velocity of the platform's joint on the
  /// ground, a column for each remaining loop equation, and a last column for the right side.
  Eigen::MatrixXd drives_;
  bool drives_by_limbs_ = false;  ///< whether drive_forces() may use the elimination of resolve()
  Matrix N_;                      ///< carrying velocities × f: N of (D18.5)
  Matrix tree_M_, M_;
  std::vector<Inertia<>> composite_;  ///< inertia of each body's subtree about the origin of its root body
                                      ///< body
  std::vector<int> screw_;            ///< nv: the index of the joint screw of each velocity
  Vector before_, after_, remaining_, s_, y_;
};

}  // namespace axode
