#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/contact_point.hpp"
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {

/// A contact point with its derivatives along the displacement (w; v) of body b relative to body a (D11.16).
/// w is a small rotation about the point `about`, and v is the translation of this point. All quantities are
/// in the inertial frame.
struct ContactJet {
  int a = 0, b = 0;  ///< bodies; 0 is the ground
  Vec3<> point, normal, about;
  double gap = 0;
  Eigen::Matrix<double, 3, 6> point_by, normal_by;
  Eigen::Matrix<double, 1, 6> gap_by;
};

/// Computes derivatives of contact points for those pairs of shapes whose contact points have a closed form.
/// It is assumed that a displacement does not change which features (faces, edges, vertices) of the shapes
/// touch. An object is the scratch memory of one thread.
class ContactJets {
 public:
  explicit ContactJets(ContactShapes shapes);

  /// Returns the contact point with the given key, and the first derivatives of its position, normal and gap
  /// along the displacement of its body b relative to its body a. The key denotes two shapes and the features
  /// (faces, edges, vertices) that touch. Returns null if contact points of the two shapes have no closed
  /// form, or if the shapes have no contact point with this key whose gap is below `margin` (m). `C` has the
  /// poses of the internal frames (joint frames) of all bodies (n_bodies + 1 entries). The pointer is valid
  /// until the next call.
  const ContactJet* find(std::uint64_t key, std::span<const SE3<>> C, double margin) noexcept;
  /// Whether the contact points of the pair of the last find() have a closed form.
  bool closed_form() const { return closed_; }
  /// The names of the two shapes of a contact, as text for messages.
  std::string names(std::uint64_t key) const;
  /// Forgets the points of the last pair of shapes. It must be called before find() is called with other
  /// poses or another margin.
  void restart() noexcept { i_ = -1; }

 private:
  bool touch_pair(std::uint64_t key, std::span<const SE3<>> C, double margin) noexcept;

  ContactShapes shapes_;
  std::vector<ContactPointOf<Displaced>> points_;
  std::size_t count_ = 0;
  int i_ = -1, j_ = -1;  ///< the shapes whose points are known
  bool closed_ = false;
  Vec3<> about_;
  ContactJet jet_;
};

}  // namespace axode
