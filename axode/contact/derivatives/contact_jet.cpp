#include "axode/contact/derivatives/contact_jet.hpp"

#include <algorithm>
#include <utility>

#include "axode/contact/pairs/convex_contacts.hpp"
#include "axode/contact/pairs/touch.hpp"
#include "axode/model/tree.hpp"

namespace axode {
namespace {

/// An upper bound of the number of contact points of one pair with a closed form.
constexpr std::size_t most_points = 128;

/// The pose C with derivatives along a rotation w about its origin and a translation v, six numbers (w; v).
SE3<Displaced> displaced(const SE3<>& C) {
  SE3<Displaced> out = cast<Displaced>(C);
  const auto turn = [](const Vec3<>& a, Vec3<Displaced>& to) {  // w × a
    to.x.dx = {0, a.z, -a.y, 0, 0, 0};
    to.y.dx = {-a.z, 0, a.x, 0, 0, 0};
    to.z.dx = {a.y, -a.x, 0, 0, 0, 0};
  };
  turn(C.R.x, out.R.x);
  turn(C.R.y, out.R.y);
  turn(C.R.z, out.R.z);
  out.r.x.dx[3] = out.r.y.dx[4] = out.r.z.dx[5] = 1;
  return out;
}

}  // namespace

ContactJets::ContactJets(ContactShapes shapes) : shapes_(std::move(shapes)), points_(most_points) {}

bool ContactJets::touch_pair(std::uint64_t key, std::span<const SE3<>> C, double margin) noexcept {
  const auto [first, second] = shapes_of_key(key);
  const int a = first, b = second;
  if (a == i_ && b == j_) return closed_;
  i_ = a;
  j_ = b;
  const auto pose = [&](int k) { return C[static_cast<std::size_t>(shapes_[k].body)] * shapes_[k].pose; };
  about_ = pose(b).r;
  const SE3<Displaced> A = cast<Displaced>(pose(a)), B = displaced(pose(b));
  PointList<Displaced> out(points_, margin);
  const auto in_order = [&](int i, int j, const SE3<Displaced>& I, const SE3<Displaced>& J) {
    return touch(shapes_, i, j, I, J, out) || touch_polytopes(shapes_[i], I, shapes_[j], J, out);
  };
  closed_ = a < b ? in_order(a, b, A, B) : in_order(b, a, B, A);
  count_ = out.count();
  return closed_;
}

const ContactJet* ContactJets::find(std::uint64_t key, std::span<const SE3<>> C, double margin) noexcept {
  if (!touch_pair(key, C, margin)) return nullptr;
  const auto points = std::span(points_).first(count_);
  const auto found = std::ranges::find(points, key, &ContactPointOf<Displaced>::key);
  if (found == points.end()) return nullptr;
  jet_ = {.a = shapes_[i_].body,
          .b = shapes_[j_].body,
          .point = value(found->point),
          .normal = value(found->normal),
          .about = about_,
          .gap = value(found->gap),
          .point_by = derivatives(found->point),
          .normal_by = derivatives(found->normal),
          .gap_by = derivatives(found->gap)};
  return &jet_;
}

std::string ContactJets::names(std::uint64_t key) const {
  const auto [a, b] = shapes_of_key(key);
  return '"' + shapes_[a].name + "\" and \"" + shapes_[b].name + '"';
}

}  // namespace axode
