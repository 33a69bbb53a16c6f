#pragma once
#include "axode/lie/mat3.hpp"
#include "axode/lie/twist.hpp"

/// Changes of loads (external wrenches) when the bodies on which they act are displaced. The components of a
/// load are constant in its representation (body-fixed, spatial, hybrid or mixed), which the user chooses for
/// each load. The representation determines whether the load turns with the body on which it acts.
namespace axode {

/// The change L(X) W of a load W (an external wrench) when its body is displaced along a screw X. The
/// components of the load are constant in `representation`: body-fixed, spatial, hybrid or mixed. W, X and
/// the result are resolved in the frame on which the load acts. See (D1.14) of docs/derivations.
template <class T>
constexpr Wrench<BodyFixed, T> load_change(Representation representation, const Wrench<BodyFixed, T>& W,
                                           const Twist<BodyFixed, T>& X) {
  switch (representation) {
    case Representation::body: break;
    case Representation::spatial: return T(-1) * coad(X, W);
    case Representation::hybrid: return {cross(W.m, X.w), cross(W.f, X.w)};
    case Representation::mixed: return {{}, cross(W.f, X.w)};
  }
  return {};
}
/// The transposed map of load_change(): the gradient by a screw X of the power L(X) W | Y for a twist Y.
/// L(X) W is the change of a load W (an external wrench) when its body is displaced along X and the
/// components of the load are constant in `representation`. W, X, Y and the result are resolved in the frame
/// on which the load acts.
template <class T>
constexpr Wrench<BodyFixed, T> load_change_transposed(Representation representation,
                                                      const Wrench<BodyFixed, T>& W,
                                                      const Twist<BodyFixed, T>& Y) {
  switch (representation) {
    case Representation::body: break;
    case Representation::spatial: return coad(Y, W);
    case Representation::hybrid: return {cross(Y.w, W.m) + cross(Y.v, W.f), {}};
    case Representation::mixed: return {cross(Y.v, W.f), {}};
  }
  return {};
}

/// The stiffness matrix N of loads (external wrenches), whose components are constant in their
/// representations (body-fixed, spatial, hybrid or mixed). If a subtree is displaced along X, the wrench that
/// balances its loads changes by N X, as seen in a frame that is displaced with the subtree ((D1.15) of
/// docs/derivations). N = [[A, -b~], [-f~, 0]] with a 3 × 3 matrix A, the sum f of the forces of all loads
/// that are not body-fixed, and the sum b of the forces of spatial loads. The 15 numbers of A, b and f can be
/// summed over loads.
template <class T> struct LoadStiffness {
  Mat3<T> A;
  Vec3<T> b, f;

  /// The matrix N of one load (m; f) at the point r, all in inertial axes. It is 0 if the load is body-fixed.
  static constexpr LoadStiffness of(Representation representation, const Vec3<T>& r, const Vec3<T>& m,
                                    const Vec3<T>& f) {
    const auto minus = [](const Mat3<T>& X) { return T(-1) * X; };
    switch (representation) {
      case Representation::body: break;
      case Representation::spatial: return {minus(skew_matrix(m + cross(r, f))), f, f};
      case Representation::hybrid: return {minus(skew_matrix(m) + cross(r, skew_matrix(f))), {}, f};
      case Representation::mixed: return {minus(cross(r, skew_matrix(f))), {}, f};
    }
    return {};
  }
  constexpr Wrench<Spatial, T> operator*(const Twist<Spatial, T>& X) const {
    return {A * X.w + cross(X.v, b), cross(X.w, f)};
  }
  constexpr Wrench<Spatial, T> transposed_times(const Twist<Spatial, T>& X) const {
    return {axode::transposed_times(A, X.w) + cross(f, X.v), cross(b, X.w)};
  }
  constexpr LoadStiffness& operator+=(const LoadStiffness& other) {
    A += other.A;
    b += other.b;
    f += other.f;
    return *this;
  }
};

}  // namespace axode
