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
  /// Points between which a body is drawn, in its frame (m): those of joints, frames, loop joints, springs
  /// and drives on the body. If there are more than 60 of them, only those that are farthest out in one of 60
  /// directions are taken. No two are nearer to each other than size() / 100, where size() is the length of
  /// the longest body.
  const std::vector<Vec3<>>& distinct(int body) const { return distinct_[body]; }
  /// For each body that is fixed to the ground, by its name, the points between which it is drawn, in the
  /// inertial frame (m): the points of its joints, its centre of mass, the origins of bodies that are fixed
  /// to it, and its own origin. If the axis and point of a body's joint are given in the inertial frame, the
  /// origin of this body is left out: its body frame may then be far from the body.
  const std::map<std::string, std::vector<Vec3<>>>& fixed() const { return fixed_; }
  std::vector<Vec3<>> distinct(const std::vector<Vec3<>>& points) const;
  /// The length (m) of a body. It is the larger of two lengths: the diagonal of a box along the axes of the
  /// body frame around the points of the joints, frames, loops, springs and drives on the body, and twice the
  /// distance of the centre of mass from the first of these points.
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
