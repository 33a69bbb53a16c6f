#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/contact_point.hpp"
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {

/// A contact point with its derivatives along the displacement (w; v) of body b
/// against body a: the small rotation w about the point `about` and the
/// translation v of this point, in inertial axes (D11.16). All quantities are
/// in the inertial frame.
struct ContactJet {
  int a = 0, b = 0;  ///< bodies; 0 is the ground
  Vec3<> point, normal, about;
  double gap = 0;
  Eigen::Matrix<double, 3, 6> point_by, normal_by;
  Eigen::Matrix<double, 1, 6> gap_by;
};

/// Differentiates the points of contact between shapes with closed forms. Which
/// features touch does not change along the displacement. It is the scratch
/// memory of one thread.
class ContactJets {
 public:
  explicit ContactJets(ContactShapes shapes);

  /// The jet of the contact with a key at the poses C of the internal frames of
  /// all bodies (n_bodies + 1), or null if the pair has no such point with a
  /// gap below the margin, or if it has no closed form. The pointer is valid
  /// until the next call.
  const ContactJet* find(std::uint64_t key, std::span<const SE3<>> C, double margin) noexcept;
  /// Whether the points of the pair of the last find() have a closed form.
  bool closed_form() const { return closed_; }
  /// The indices of the shapes (a, b) of a contact with this key, see
  /// ContactPoint.
  static std::array<int, 2> shapes_of(std::uint64_t key) {
    return {static_cast<int>(key >> 44), static_cast<int>(key >> 24 & 0xfffff)};
  }
  /// Names the two shapes of a contact.
  std::string names(std::uint64_t key) const;
  /// Must be called before the poses or the margin of find() change.
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
