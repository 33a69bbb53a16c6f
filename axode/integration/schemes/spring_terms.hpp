#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// Forces of the springs of a model in addition to the drive forces, and their derivatives.
class SpringTerms {
 public:
  using Span = std::span<const double>;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit SpringTerms(const Model& model) : model_(model) {
    if (model.springs().empty()) return;
    workspace_.emplace(model);
    total_.resize(static_cast<std::size_t>(model.nv()));
    by_q.resize(model.nv(), model.nv());
    by_v = by_q;
  }
  bool any() const { return workspace_.has_value(); }
  /// Returns the sum of the spring forces at (q, v) and the drive forces tau (nv numbers).
  const double* forces(Span q, Span v, const double* tau) {
    if (!any()) return tau;
    std::ranges::copy_n(tau, model_.nv(), total_.begin());
    if (finite(q))
      add_spring_forces(model_, *workspace_, q, v, total_);  // if this is not so, the accelerations are not
                                                             // finite either
    return total_.data();
  }
  /// Computes the derivatives by_q and by_v of the spring forces.
  void differentiate(Span q, Span v) {
    spring_force_derivatives(model_, *workspace_, q, v, {as_span(by_q), as_span(by_v)});
  }
  Rows by_q, by_v;

 private:
  const Model& model_;
  std::optional<Workspace<double>> workspace_;
  std::vector<double> total_;
};

}  // namespace axode
