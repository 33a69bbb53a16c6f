#pragma once
#include <cmath>
#include <vector>

#include "axode/model/configuration.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode::command {

/// A number with its derivative in one direction, for which no operation is executed that a derivative does
/// not need: a product takes two more products and a sum, a sum takes one more.
template <class S> struct Tangent {
  S x{}, dx{};

  Tangent() = default;
  template <class Number>
    requires std::constructible_from<S, Number> Tangent(const Number& value)
        : x(value) {}  // NOLINT(google-explicit-constructor): a constant
    Tangent(const S& value, const S& derivative) : x(value), dx(derivative) {}

    friend Tangent operator+(const Tangent& a, const Tangent& b) { return {a.x + b.x, a.dx + b.dx}; }
    friend Tangent operator-(const Tangent& a, const Tangent& b) { return {a.x - b.x, a.dx - b.dx}; }
    friend Tangent operator-(const Tangent& a) { return {-a.x, -a.dx}; }
    friend Tangent operator*(const Tangent& a, const Tangent& b) {
      return {a.x * b.x, a.dx * b.x + a.x * b.dx};
    }
    friend Tangent operator/(const Tangent& a, const Tangent& b) {
      const S q = a.x / b.x;
      return {q, (a.dx - q * b.dx) / b.x};
    }
    Tangent& operator+=(const Tangent& b) { return *this = *this + b; }
    Tangent& operator-=(const Tangent& b) { return *this = *this - b; }
    friend Tangent sqrt(const Tangent& a) {
      const S r = sqrt(a.x);
      return {r, a.dx / (r + r)};
    }
    friend Tangent sin(const Tangent& a) { return {sin(a.x), cos(a.x) * a.dx}; }
    friend Tangent cos(const Tangent& a) { return {cos(a.x), -sin(a.x) * a.dx}; }
    friend bool operator<(const Tangent& a, const Tangent& b) { return a.x < b.x; }
    friend bool operator>(const Tangent& a, const Tangent& b) { return b < a; }
    friend Tangent select(bool condition, const Tangent& a, const Tangent& b) { return condition ? a : b; }
};

/// Computes the derivatives ∂τ/∂q, ∂τ/∂v and ∂τ/∂a of inverse dynamics by forward differentiation: the
/// recursion for τ runs once for each direction, on numbers that carry their derivative in this direction.
template <class T> class TangentDerivatives {
  using Number = Tangent<T>;

 public:
  TangentDerivatives(const Model& model, const Tree<T>& tree, std::span<const double> q)
      : tree_(cast<Number>(tree)), q_(q.size()), v_(static_cast<std::size_t>(tree->nv)), a_(v_), tau_(v_) {
    std::vector<double> unit(v_.size());
    for (double& direction : unit) {
      direction = 1;
      rates_.push_back(coordinate_rates(model, q, unit));
      direction = 0;
    }
  }

  /// Writes the three matrices to out, each row by row.
  template <class Rep> void run(const T* q, const T* v, const T* a, T* out) {
    WithScratch<Number, InverseDynamicsRecursion<Rep, Number>> recursion(*tree_.topology());
    const std::size_t nv = v_.size();
    std::copy_n(q, q_.size(), q_.begin());
    std::copy_n(v, nv, v_.begin());
    std::copy_n(a, nv, a_.begin());
    const auto put = [&](std::size_t matrix, std::size_t column) {
      recursion->run(tree_, q_.data(), v_.data(), a_.data(), {});
      recursion->project(tree_, v_.data(), a_.data(), false, tau_.data());
      for (std::size_t c = 0; c < nv; ++c) out[(matrix * nv + c) * nv + column] = tau_[c].dx;
    };
    for (std::size_t k = 0; k < nv; ++k) {
      for (std::size_t c = 0; c < q_.size(); ++c) q_[c].dx = rates_[k][c];
      put(0, k);
      for (Number& x : q_) x.dx = T(0);
      v_[k].dx = T(1);
      put(1, k);
      v_[k].dx = T(0);
      a_[k].dx = T(1);
      put(2, k);
      a_[k].dx = T(0);
    }
  }

 private:
  Tree<Number> tree_;
  std::vector<Number> q_, v_, a_, tau_;
  std::vector<std::vector<double>> rates_;  ///< nv: rates of the coordinates for a unit of each velocity
};

}  // namespace axode::command
