#pragma once
#include <Eigen/Core>
#include <span>

#include "axode/contact/derivatives/contact_jet.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// Changes of a vector in space along k directions, 3 × k.
using VectorChanges = Eigen::Matrix3Xd;

/// How a contact changes along k directions: its point, its normal and its gap.
struct ContactChanges {
  VectorChanges point, normal;
  Eigen::RowVectorXd gap;
};

/// How the axes of a contact change along k directions.
struct FrameChanges {
  VectorChanges n, t1, t2;
};
/// Changes of contact_frame(normal).
FrameChanges frame_changes(const Vec3<>& normal, const VectorChanges& dnormal);
/// Changes of turned(contact_frame(from), to).
FrameChanges turned_changes(const Vec3<>& from, const VectorChanges& dfrom, const Vec3<>& to,
                            const VectorChanges& dto);

/// The bodies of a tree at a state (q, v), and how they change along k directions (dq, dv), a column each:
/// displacements dq are left-trivialised. ξ_i is the displacement of body i, and with the twists V_i = V_p +
/// S v,
///   ξ_i = ξ_p + S dq,   dV_i = dV_p + [ξ_i, S v] + S dv                                            (D11.17)
/// about the fixed point O that is the origin of the root of i at q. O(n k). It is the scratch memory of one
/// thread.
class DisplacedMotion {
 public:
  using Changes = Eigen::MatrixXd;

  explicit DisplacedMotion(const Model& model);

  /// Computes twists and their changes.
  void run(const double* q, const double* v, const Changes& dq, const Changes& dv);

  Eigen::Index directions() const { return xi_.cols(); }
  /// The poses of the internal frames of all bodies, n_bodies + 1.
  std::span<const SE3<>> poses() const { return poses_; }
  /// How the contact of a jet changes if its bodies are displaced.
  ContactChanges contact(const ContactJet& jet);
  /// Changes of the velocities of the rows of a contact (`rows` × k), see ContactSystem::contact_velocity(),
  /// and the velocities u themselves.
  Changes row_velocities(const ContactJet& at, const ContactChanges& change, const ContactFrame& axes,
                         const FrameChanges& daxes, int rows, double* u);
  /// Adds the changes of Jᵀ λ for constant λ to out (nv × k), where λ has `rows` entries.
  void add_impulse_changes(const ContactJet& at, const ContactChanges& change, const ContactFrame& axes,
                           const FrameChanges& daxes, int rows, const double* lambda, Changes& out);

 private:
  Vec3<> origin(int body) { return body > 0 ? spatial_->origin[body] : Vec3<>{}; }
  /// The rows of a body in matrices with six rows for each body.
  auto of(const Changes& x, int body) const { return x.middleRows<6>(6 * body); }
  /// The displacement of a point that moves with a body.
  VectorChanges displacement(int body, const Vec3<>& point);

  const Tree<double>* tree_;
  WithScratch<double, SpatialTree<double>> spatial_;
  std::vector<SE3<>> poses_;
  std::vector<Twist<Spatial>> V_;
  Changes xi_, dV_;  ///< 6 (n_bodies + 1) × k
};

}  // namespace axode
