#include "axode/contact/convex/least_norm.hpp"

#include <cmath>

namespace axode::convex {
namespace {

using Weights = std::array<double, 4>;

/// Computes weights mu whose sum is 1 such that the weighted sum of the vertices of a simplex, each shifted
/// by `shift`, is the point of least norm in their affine hull (D10.6). The edges from the last vertex are
/// orthogonalised. Returns false if the vertices are affinely dependent.
bool affine_weights(const Simplex& x, const Vec3<>& shift, Weights& mu) noexcept {
  const int edges = x.count - 1;
  const Vec3<> base = x.vertex[edges].w, start = base + shift;
  std::array<Vec3<>, 3> q;
  std::array<std::array<double, 3>, 3> upper;
  std::array<double, 3> y, inverse;
  constexpr double least = 64 * epsilon;
  for (int i = 0; i < edges; ++i) {
    q[i] = x.vertex[i].w - base;
    const double length2 = dot(q[i], q[i]);
    for (int j = 0; j < i; ++j) {
      upper[j][i] = dot(q[j], q[i]);
      q[i] -= upper[j][i] * q[j];
    }
    const double rest2 = dot(q[i], q[i]);
    if (!(rest2 > least * least * length2)) return false;
    inverse[i] = 1 / std::sqrt(rest2);
    q[i] = inverse[i] * q[i];
    y[i] = -dot(q[i], start);
  }
  mu[edges] = 1;
  for (int i = edges - 1; i >= 0; --i) {
    for (int j = i + 1; j < edges; ++j) y[i] -= upper[i][j] * mu[j];
    mu[i] = y[i] * inverse[i];
    mu[edges] -= mu[i];
  }
  return true;
}

/// Moves the weights of the vertices of a simplex until they give its point of least norm, and drops every
/// vertex whose weight reaches 0 on the way. Returns false if the vertices are affinely dependent.
bool reduce(Simplex& x, const Vec3<>& shift) noexcept {
  Weights mu;
  while (x.count > 1) {
    if (!affine_weights(x, shift, mu)) return false;
    double theta = 1;
    int drop = -1;
    for (int i = 0; i < x.count; ++i) {
      if (mu[i] > 0) continue;
      const double fall = x.weight[i] - mu[i], part = fall > 0 ? x.weight[i] / fall : 1;
      if (part > theta) continue;
      theta = part;
      drop = i;
    }
    for (int i = 0; i < x.count; ++i) x.weight[i] += theta * (mu[i] - x.weight[i]);
    if (drop < 0) return true;
    x.remove(drop);
  }
  x.weight[0] = 1;
  return true;
}

}  // namespace

void least_norm(CorePair& pair, Candidate& c, const Vec3<>& shift, double gap) noexcept {
  constexpr int most_iterations = 64;
  if (c.simplex.count == 0) c.simplex.add(pair.support(c.n), 1);
  double last = infinity;
  for (int k = 0; k < most_iterations; ++k) {
    const Vec3<> x = c.simplex.point(shift);
    const double length = norm(x);
    c.inside = c.simplex.count == 4 || length <= pair.rounding;
    if (c.inside || !(length < last)) return;
    last = length;
    c.n = (1 / length) * x;
    const Vertex v = pair.support(c.n);
    c.s = dot(c.n, v.w);
    if (length - dot(c.n, shift) - c.s <= gap) return;
    c.simplex.add(v, 0);
    if (!reduce(c.simplex, shift)) break;
  }
  if (c.simplex.weight[c.simplex.count - 1] == 0) --c.simplex.count;
}

}  // namespace axode::convex
