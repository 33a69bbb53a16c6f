#pragma once
#include <Eigen/Core>
#include <span>

#include "axode/contact/derivatives/contact_jet.hpp"
#include "axode/contact/derivatives/parameter_changes.hpp"
#include "axode/eigen.hpp"
#include "axode/recursion/changes.hpp"

namespace axode {

/// Changes of a vector in space along k directions, 3 × k.
using VectorChanges = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
/// Changes of a screw along k directions, 6 × k, angular part first.
using ScrewChanges = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

/// The changes of the point, the normal and the gap of a contact along k directions.
struct ContactChanges {
  Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::RowMajor> rows;

  auto point() { return rows.topRows<3>(); }
  auto point() const { return rows.topRows<3>(); }
  auto normal() { return rows.middleRows<3>(3); }
  auto normal() const { return rows.middleRows<3>(3); }
  auto gap() { return rows.row(6); }
  auto gap() const { return rows.row(6); }
};

/// The displacements of a body along k directions: six rows, a rotation and the translation of the point O.
struct Displacements {
  Eigen::Ref<const ScrewChanges, 0, Eigen::OuterStride<>> xi;
  Vec3<> O;
};
/// The changes of the point, normal and gap of a contact by displacements of its two bodies (D11.16).
ContactChanges contact_changes(const ContactJet& jet, const Displacements& a, const Displacements& b);

/// The changes of the axes n, t1, t2 of a contact along k directions.
struct FrameChanges {
  VectorChanges n, t1, t2;
};
/// The changes of contact_frame(normal) for changes of the normal.
FrameChanges frame_changes(const Vec3<>& normal, const ChangesArgument& dnormal);
/// The changes of turned(contact_frame(from), to) for changes of both normals.
FrameChanges turned_changes(const Vec3<>& from, const ChangesArgument& dfrom, const Vec3<>& to,
                            const ChangesArgument& dto);

/// The motion of the bodies of a tree at a state (q, v), and its changes along k directions (dq, dv), a
/// column for each. dq are left-trivialised displacements. Let ξ_i be the displacement and V_i = V_p + S v
/// the twist of body i with the predecessor p and the joint screws S. With the changes dπ of the geometric
/// parameters of body i and the unit screws U along which they move it,
///   ξ_i = ξ_p + U dπ + S dq,   dV_i = dV_p + [ξ_i, S v] + S dv                                     (D11.17)
/// about a fixed point O, which at q is the origin of the first body on the path from the ground to body i.
/// Costs O(n k) for n bodies. An object is the scratch memory of one thread.
class DisplacedMotion {
 public:
  explicit DisplacedMotion(const Model& model);

  /// Sets the changes of the geometric parameters of all n bodies along p directions: `geometry`, 6 n × p, or
  /// empty if the parameters do not change. Rows 6 (i - 1) to 6 i - 1 belong to body i. The six parameters of
  /// a body displace its joint and its subtree along the unit screws, angular before linear, of the frame
  /// that the body has while its joint is at zero.
  void set_geometry(const Changes& geometry) { geometry_ = geometry; }
  /// Computes the poses and twists of all bodies and their changes along (dq, dv), nv × k each. If the
  /// geometric parameters change and k > 0, they change along the directions `first` to `first` + p - 1.
  void run(const double* q, const double* v, const Changes& dq, const Changes& dv, Eigen::Index first = 0);

  Eigen::Index directions() const { return xi_.cols(); }
  /// The poses of the internal frames of all bodies in the inertial frame, n_bodies + 1 entries.
  std::span<const SE3<>> poses() const { return poses_; }
  /// The changes of the point, normal and gap of a contact that follow from the displacements of its bodies.
  ContactChanges contact(const ContactJet& jet) {
    return contact_changes(jet, displacements(jet.a), displacements(jet.b));
  }
  /// Computes the relative velocities u of the bodies at a contact along `axes`, and returns their changes
  /// along the k directions (`rows` × k). The directions are the changes (dq, dv) of the state that were
  /// given to the last run(). `change` and `daxes` are the changes of the contact point and of the axes along
  /// these directions.
  Changes row_velocities(const ContactJet& at, const ContactChanges& change, const ContactFrame& axes,
                         const FrameChanges& daxes, int rows, double* u);
  /// Adds to `out` (nv × k) the changes of the generalised impulse Jᵀ λ of one contact along the k directions
  /// (dq, dv) of the last run(), which computes the displaced motion. J is the Jacobian of the relative
  /// velocities along the axes of the contact, and λ are the impulses along these axes (`rows` numbers),
  /// which are constant. `change` and `daxes` are the changes of the contact point and of the axes along the
  /// k directions.
  void add_impulse_changes(const ContactJet& at, const ContactChanges& change, const ContactFrame& axes,
                           const FrameChanges& daxes, int rows, const double* lambda, Changes& out);

 private:
  Vec3<> origin(int body) { return body > 0 ? spatial_->origin[body] : Vec3<>{}; }
  /// The six rows of a body in a matrix with six rows for each body.
  static auto of(const Changes& x, int body) { return x.middleRows<6>(6 * body); }
  Displacements displacements(int body) { return {of(xi_, body), origin(body)}; }

  const Tree<double>* tree_;
  WithScratch<double, SpatialTree<double>> spatial_;
  std::vector<SE3<>> poses_;
  std::vector<Twist<Spatial>> V_;
  Changes geometry_;
  Changes xi_, dV_;  ///< ξ and dV of all bodies, 6 (n_bodies + 1) × k
};

}  // namespace axode
