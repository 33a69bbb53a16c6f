#include "axode/constraints/embedding/task_singularities.hpp"

#include <algorithm>
#include <cmath>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/embedding/task_kernel.hpp"
#include "axode/constraints/vector_text.hpp"
#include "axode/eigen.hpp"
#include "axode/lie/screw_geometry.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Describes in words a twist V about the inertial origin; it is called a translation if its axis is farther
/// away than 1e6 times `length`.
std::string in_words(const Twist<Spatial>& V, double length) {
  if (!(norm(V.w) * 1e6 * length > norm(V.v))) return "along " + rounded_text((1 / norm(V.v)) * V.v);
  const ScrewAxis<> axis = screw_axis(Screw<>{V.w, V.v});
  std::string words = "about the axis along " + rounded_text(axis.e) + " through " + rounded_text(axis.p);
  if (std::abs(axis.h) > 1e-6 * length) words += " with the pitch " + rounded_text(axis.h) + " m/rad";
  return words;
}

/// Scaled matrices of a parallel manipulator: the Jacobian of the loop equations, and the matrix that maps
/// the velocities of the joint that connects the platform to the ground in the spanning tree (most often a
/// free joint) to the twist of the platform about `center`, the centre of the loop joints on the platform. To
/// compare rotations with translations, angular velocities, and loop equations whose constraint reaction is a
/// pure couple, are multiplied by `length`, the mean distance of these loop joints from `center`.
class Scaled {
 public:
  Scaled(TaskKernel& kernel, std::span<const double> q) : kernel_(kernel), model_(kernel.model()) {
    LoopSystem<double>& system = kernel.system();
    system.update_kinematics(q.data());
    find_center(system);
    system.make_rows(ConstraintLevel::velocity);
    LoopSystem<double>::RowByRow A(model_.loops().rows, model_.nv());
    system.write(A.data());
    A_ = A;
    for (std::size_t k = 0; k < model_.loops().joints.size(); ++k) {  // rows of couples are multiplied by the
                                                                      // length
      const LoopPath::Range rows = system.table().paths[k].rows;
      for (int r = rows.first; r < rows.first + rows.count; ++r) {
        const Vector unit = Vector::Unit(A_.rows(), r);
        if (norm(system.wrench(k, unit.data()).f) == 0) A_.row(r) *= length;
      }
    }
    rate_.setOnes(model_.nv());
    const std::vector<bool> angles = angle_velocities();
    for (Eigen::Index c = 0; c < rate_.size(); ++c)
      if (angles[static_cast<std::size_t>(c)]) rate_[c] = 1 / length;
    A_ = A_ * rate_.asDiagonal();
    make_twists();
  }

  Matrix of(const std::vector<int>& rows, const std::vector<int>& velocities) const {
    return A_(rows, velocities);
  }
  /// The twist (rad/s, m/s) of the platform, about the inertial origin, for velocities of the joint between
  /// the ground and the platform, all in m/s: angular velocities are multiplied by `length`.
  Twist<Spatial> twist(const Vector& carrying) const {
    const Vector X = twists_ * carrying;  // (length ω; v) about the centre
    const Vec3<> w{X[0] / length, X[1] / length, X[2] / length}, v{X[3], X[4], X[5]};
    return {w, v + cross(center, w)};
  }
  const Matrix& twists() const { return twists_; }

  double length = 1;
  Vec3<> center{};

 private:
  void find_center(const LoopSystem<double>& system) {
    std::vector<Vec3<>> points;
    pose_ = kernel_.platform_pose();
    for (const LoopPath& path : system.table().paths)
      for (const Loop::End& end : path.ends)
        if (end.body == kernel_.platform) points.push_back(pose_ * end.F.r);
    if (points.empty()) return;
    Vec3<> sum{};
    for (const Vec3<>& p : points) sum = sum + p;
    center = (1.0 / static_cast<double>(points.size())) * sum;
    double distance = 0;
    for (const Vec3<>& p : points) distance += norm(p - center);
    distance /= static_cast<double>(points.size());
    if (distance > 0) length = distance;
  }
  /// Whether each velocity of the model is the rate of an angle.
  std::vector<bool> angle_velocities() const {
    std::vector<bool> angles(static_cast<std::size_t>(model_.nv()));
    for (int i = 1; i <= model_.n_bodies(); ++i) {
      const Joint& joint = model_.joint(i);
      for (int d = 0; d < joint.nv; ++d)
        angles[static_cast<std::size_t>(joint.iv + d)] =
            norm(model_.body(i).X[static_cast<std::size_t>(d)].w) > 0;
    }
    return angles;
  }
  /// Computes the twists of the platform for a unit of each velocity of the joint between the ground and the
  /// platform: 1 m/s for a translation, and 1/length rad/s for a rotation. A twist is (length ω; v) in
  /// inertial axes about `center`, the centre of the loop joints on the platform, and `length` is their mean
  /// distance from it.
  void make_twists() {
    const std::vector<int>& carrying = kernel_.carrying();
    twists_.setZero(6, std::ssize(carrying));
    const int first = model_.joint(kernel_.platform).iv;
    const SE3<> body = pose_ * model_.tree<double>().frame_offset[static_cast<std::size_t>(kernel_.platform)];
    for (std::size_t j = 0; j < carrying.size(); ++j) {
      const Screw<> X =
          Ad(body, model_.body(kernel_.platform).X[static_cast<std::size_t>(carrying[j] - first)]);
      const Vec3<> v = X.v - cross(center, X.w);
      const double rate = rate_[carrying[j]];
      twists_.col(static_cast<Eigen::Index>(j)) << rate * length * X.w.x, rate * length * X.w.y,
          rate * length * X.w.z, rate * v.x, rate * v.y, rate * v.z;
    }
  }

  TaskKernel& kernel_;
  Model model_;
  SE3<> pose_;  ///< pose of the internal frame of the platform
  Matrix A_, twists_;
  Vector rate_;  ///< nv: each velocity of the model for a scaled velocity of 1 m/s: 1/length for rotations
};

/// Singular value number `rank`, the smallest that must not vanish, divided by the largest one.
double distance_of(const SingularValues& svd, Eigen::Index rank) {
  const Vector& sigma = svd.s;
  if (rank == 0 || sigma.size() == 0) return 1;
  if (rank > sigma.size()) return 0;
  return sigma[0] > 0 ? sigma[rank - 1] / sigma[0] : 0;
}

std::vector<std::string> considerable_names(const Vector& x, const std::vector<int>& velocities,
                                            const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (std::size_t j = 0; j < velocities.size(); ++j)
    if (std::abs(x[static_cast<Eigen::Index>(j)]) > considerable * x.cwiseAbs().maxCoeff())
      out.push_back(names[static_cast<std::size_t>(velocities[j])]);
  return out;
}

/// The twist V divided by the larger of |ω| and |v| / length, where v is the velocity of the centre.
Twist<Spatial> normalized(const Twist<Spatial>& V, const Scaled& scaled) {
  const double size = std::max(norm(V.w), norm(V.v - cross(scaled.center, V.w)) / scaled.length);
  return {(1 / size) * V.w, (1 / size) * V.v};
}

}  // namespace

std::vector<TaskSingularity> singularities(TaskSpace& space, std::span<const double> q, double within) {
  using enum TaskSingularity::Type;
  TaskKernel& kernel = space.kernel();
  const Model& model = space.model();
  check_configuration(model, q);
  kernel.check_platform();
  if (!(within >= 0 && within <= 1))
    throw std::invalid_argument("within is " + to_text(within) + "; distances are from 0 to 1");
  check_closed(kernel.system(), q, std::vector<double>(static_cast<std::size_t>(model.nv())));
  const std::vector<std::string> names = velocity_names(model);
  const Scaled scaled(kernel, q);
  const std::vector<int>& carrying = kernel.carrying();
  const auto s = static_cast<Eigen::Index>(carrying.size());
  std::vector<TaskSingularity> found;

  // Rows of F_l = -A_l⁺ A_pl of the driven velocities, and the wrenches by which the limbs hold the platform.
  std::vector<int> driven_velocities;
  std::vector<Eigen::RowVectorXd> drive_rows, held;
  for (std::size_t l = 0; l < kernel.parts().size(); ++l) {
    const TaskKernel::Part& part = kernel.parts()[l];
    if (part.rows.empty()) continue;
    const auto rows = static_cast<Eigen::Index>(part.rows.size());
    const Matrix A_p = scaled.of(part.rows, carrying);
    Matrix U = Matrix::Identity(rows, rows);
    if (!part.velocities.empty()) {
      const SingularValues svd = singular_values(scaled.of(part.rows, part.velocities));
      U = svd.U;
      const double distance = distance_of(svd, part.dependent);
      if (distance < within) {
        TaskSingularity at{.type = limb, .limb = static_cast<int>(l), .distance = distance, .twist = {}};
        at.joints = considerable_names(svd.V.col(part.dependent - 1), part.velocities, names);
        at.sentence = "type 1: joints of the limb " + kernel.name_of_limb(at.limb) +
                      " can move while the platform is at rest: " + listed(at.joints);
        found.push_back(at);
      }
      Matrix F = Matrix::Zero(std::ssize(part.velocities), s);
      for (int k = 0; k < part.dependent; ++k)
        if (svd.s[k] > 1e-12 * svd.s[0]) F -= svd.V.col(k) * (U.col(k).transpose() * A_p) / svd.s[k];
      for (std::size_t j = 0; j < part.velocities.size(); ++j) {
        const int c = part.velocities[j];
        if (model.loops().driven[static_cast<std::size_t>(c)] == 0) continue;
        driven_velocities.push_back(c);
        drive_rows.push_back(F.row(static_cast<Eigen::Index>(j)));
      }
    }
    for (Eigen::Index k = part.dependent; k < rows; ++k) held.push_back(U.col(k).transpose() * A_p);
  }
  for (Eigen::Index j = 0; j < s; ++j) {
    if (model.loops().driven[static_cast<std::size_t>(carrying[static_cast<std::size_t>(j)])] == 0) continue;
    driven_velocities.push_back(carrying[static_cast<std::size_t>(j)]);
    drive_rows.push_back(Eigen::RowVectorXd::Unit(s, j));
  }
  const auto stacked = [&](const std::vector<Eigen::RowVectorXd>& rows) {
    Matrix out(std::ssize(rows), s);
    for (std::size_t k = 0; k < rows.size(); ++k) out.row(static_cast<Eigen::Index>(k)) = rows[k];
    return out;
  };
  // The columns of to_carrying are unit twists of the platform, so that singular values are those of twists.
  const Matrix to_carrying =
      s == 6 ? least_squares(scaled.twists(), Matrix::Identity(6, 6), 1e-15) : Matrix::Identity(s, s);
  const auto free_motion = [&](TaskSingularity& at, const Vector& x) {
    at.twist = normalized(scaled.twist(to_carrying * x), scaled);
    return in_words(at.twist, scaled.length);
  };

  Matrix N = Matrix::Identity(s, s);
  if (!held.empty()) {
    const Eigen::Index rank = s - space.kernel().independent();
    const SingularValues svd = singular_values(stacked(held) * to_carrying);
    if (const double distance = distance_of(svd, rank); distance < within) {
      TaskSingularity at{.type = constraint, .distance = distance, .twist = {}};
      at.sentence = "constraint singularity: no limb holds the platform against a motion " +
                    free_motion(at, svd.V.col(rank - 1));
      found.push_back(at);
    }
    N = svd.V.rightCols(s - rank);
  }
  if (N.cols() == 0) return found;
  if (drive_rows.empty()) drive_rows.emplace_back(Eigen::RowVectorXd::Zero(s));
  const Matrix J = stacked(drive_rows) * to_carrying * N;
  const SingularValues svd = singular_values(J);
  if (const double distance = distance_of(svd, N.cols()); distance < within) {
    TaskSingularity at{.type = TaskSingularity::Type::drives, .distance = distance, .twist = {}};
    at.sentence = "type 2: the platform can move while all drives are locked, " +
                  free_motion(at, N * svd.V.col(N.cols() - 1));
    if (N.cols() <= std::ssize(driven_velocities)) {
      at.joints = considerable_names(svd.U.col(N.cols() - 1), driven_velocities, names);
      at.sentence += "; these drives hold each other: " + listed(at.joints);
    }
    found.push_back(at);
  }
  return found;
}

}  // namespace axode
