#include "axode/contact/pairs/touch.hpp"

#include "axode/contact/pairs/closed_forms.hpp"
#include "axode/contact/pairs/convex_contacts.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {
namespace {

bool is_round(const ContactShape& shape) {
  return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule;
}

}  // namespace

template <class T>
bool touch(const ContactShapes& shapes, int i, int j, const SE3<T>& A, const SE3<T>& B,
           PointList<T>& out) noexcept {
  const ContactShape &a = shapes[i], &b = shapes[j];
  const auto are = [&](ShapeKind first, ShapeKind second) { return a.kind == first && b.kind == second; };
  out.select(i, j, false);
  if (a.kind == ShapeKind::plane) {
    touch_plane(A, b, B, out);
  } else if (b.kind == ShapeKind::plane) {
    out.select(j, i, false);
    touch_plane(B, a, A, out);
  } else if (is_round(a) && is_round(b)) {
    touch_round(a, A, b, B, out);
  } else if (are(ShapeKind::box, ShapeKind::box)) {
    return touch_boxes(a, A, b, B, out);
  } else if (are(ShapeKind::box, ShapeKind::sphere)) {
    touch_box_and_sphere(a, A, b, B, out);
  } else if (are(ShapeKind::sphere, ShapeKind::box)) {
    out.select(i, j, true);
    touch_box_and_sphere(b, B, a, A, out);
  } else {
    return false;
  }
  return true;
}

template bool touch(const ContactShapes&, int, int, const SE3<>&, const SE3<>&, PointList<>&) noexcept;
template bool touch(const ContactShapes&, int, int, const SE3<Displaced>&, const SE3<Displaced>&,
                    PointList<Displaced>&) noexcept;

}  // namespace axode
