#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace axode {

/// Anderson acceleration of a fixed-point iteration x ← g(x). The next x is a combination of the last four
/// values of g; it is the combination for which the residual g - x, predicted linearly from the last steps,
/// is least.
class Multisecant {
 public:
  void reserve(std::size_t n) {
    for (std::vector<double>* v : {&residual_, &residual_before_, &value_before_}) v->reserve(n);
    for (std::size_t k = 0; k < depth; ++k) {
      residuals_[k].reserve(n);
      values_[k].reserve(n);
    }
  }
  /// Forgets all steps.
  void restart() noexcept {
    filled_ = 0;
    has_step_ = false;
  }
  /// Makes one step of the accelerated iteration x ← g(x): replaces the value g(x) in `g` by the next x. The
  /// size of a residual g(x) - x is the norm of its entries times `weights`. All vectors since the last
  /// restart must have one size. Allocates nothing up to the reserved size.
  void update(std::span<const double> x, std::span<const double> weights, std::span<double> g) {
    const std::size_t n = x.size();
    residual_.resize(n);
    for (std::size_t i = 0; i < n; ++i) residual_[i] = weights[i] * (g[i] - x[i]);
    if (has_step_) add_secant(g);
    residual_before_ = residual_;
    value_before_.assign(g.begin(), g.end());
    has_step_ = true;
    for (std::size_t k = 0; k < filled_; ++k) {  // The residuals of the secants are orthogonal.
      const double size = dot(residuals_[k], residuals_[k]);
      if (!(size > 0)) continue;
      const double part = dot(residuals_[k], residual_) / size;
      for (std::size_t i = 0; i < n; ++i) g[i] -= part * values_[k][i];
    }
  }

 private:
  static constexpr std::size_t depth = 3;

  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }
  /// Puts the last secant first, and makes the residual differences of all secants orthogonal.
  void add_secant(std::span<const double> g) {
    filled_ = std::min(filled_ + 1, depth);
    std::rotate(residuals_.begin(), residuals_.end() - 1, residuals_.end());
    std::rotate(values_.begin(), values_.end() - 1, values_.end());
    residuals_[0].resize(g.size());
    values_[0].resize(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
      residuals_[0][i] = residual_[i] - residual_before_[i];
      values_[0][i] = g[i] - value_before_[i];
    }
    constexpr double dependent = 1e-12;
    for (std::size_t k = 1; k < filled_; ++k) {
      const double before = dot(residuals_[k], residuals_[k]);
      for (std::size_t l = 0; l < k; ++l) {
        const double size = dot(residuals_[l], residuals_[l]);
        if (!(size > 0)) continue;
        const double part = dot(residuals_[l], residuals_[k]) / size;
        for (std::size_t i = 0; i < g.size(); ++i) {
          residuals_[k][i] -= part * residuals_[l][i];
          values_[k][i] -= part * values_[l][i];
        }
      }
      if (!(dot(residuals_[k], residuals_[k]) > dependent * before))
        std::fill(residuals_[k].begin(), residuals_[k].end(), 0.0);
    }
  }

  std::array<std::vector<double>, depth> residuals_, values_;  ///< changes in a step, the newest first
  std::vector<double> residual_, residual_before_, value_before_;
  std::size_t filled_ = 0;
  bool has_step_ = false;
};

}  // namespace axode
