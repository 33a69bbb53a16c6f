#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// The points between which the bodies of a model are drawn: those of their joints, frames, loops, springs
/// and drives, in the frames of the bodies.
class Points {
 public:
  explicit Points(const Model& model);

  /// Point of the joint of body i; empty if the joint has no point.
  const std::optional<Vec3<>>& joint(int i) const { return joints_[i]; }
  /// The corners of the points on a body, no two of which are nearer than a hundredth of the size.
  const std::vector<Vec3<>>& distinct(int body) const { return distinct_[body]; }
  /// For each body that is fixed to the ground, by its name, the points between which it is drawn, in the
  /// inertial frame (m): the points of its joints, its centre of mass, the origins of bodies that are fixed
  /// to it, and its own origin. The origin of a body that is described in the inertial frame is left out,
  /// because it may be anywhere.
  const std::map<std::string, std::vector<Vec3<>>>& fixed() const { return fixed_; }
  std::vector<Vec3<>> distinct(const std::vector<Vec3<>>& points) const;
  /// The length (m) of a body: the diagonal of a box around its points or, if it has only one point, twice
  /// the distance of its centre of mass from this point.
  double length(int body) const { return lengths_[body]; }
  /// Height of the lowest point in the reference configuration, m.
  double lowest(const Vec3<>& up) const;
  /// The length of the longest body, m.
  double size() const { return size_; }
  /// Calls f(body, point) for each point of springs and drives along lines, with the point in the body frame.
  template <class F> static void for_line_ends(const Model& model, const F& f) {
    const auto visit = [&](const Spring::Path& path) {
      for (const Spring::Path::Point& it : path.points) {
        const Frame& frame = model.frame(it.frame);
        f(frame.body, frame.pose * it.point);
      }
    };
    for (const Spring& spring : model.springs().elements)
      if (const auto* path = std::get_if<Spring::Path>(&spring.geometry)) visit(*path);
    for (const Spring::Path& line : model.springs().drive_lines) visit(line);
  }

 private:
  void add_fixed_bodies(const Model& model);

  std::vector<std::optional<Vec3<>>> joints_;
  std::vector<std::vector<Vec3<>>> all_, distinct_;
  std::map<std::string, std::vector<Vec3<>>> fixed_;
  std::vector<double> lengths_;
  std::vector<Vec3<>> reference_;  ///< all points in the reference configuration, in the inertial frame
  double size_ = 0;
};

}  // namespace axode::view
