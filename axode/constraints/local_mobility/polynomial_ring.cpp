#include "axode/constraints/local_mobility/polynomial_ring.hpp"

#include <stdexcept>
#include <string>

namespace axode::higher_order {
namespace {

/// Appends to `out` the exponents of all monomials that begin with the exponents `head` and whose other
/// exponents add up to k. Monomials are in descending lexicographic order.
void append_exponents(int variables, int k, std::vector<int>& head, std::vector<std::vector<int>>& out) {
  if (static_cast<int>(head.size()) == variables - 1) {
    out.push_back(head);
    out.back().push_back(k);
    return;
  }
  for (int a = k; a >= 0; --a) {
    head.push_back(a);
    append_exponents(variables, k - a, head, out);
    head.pop_back();
  }
}

}  // namespace

double PolynomialRing::products(int variables, int degree) {
  double pairs = 1;
  for (int k = 1; k <= degree; ++k) pairs *= static_cast<double>(2 * variables + k) / k;
  return pairs;
}

PolynomialRing::PolynomialRing(int variables, int degree) : variables_(variables), degree_(degree) {
  if (products(variables, degree) > most_products)
    throw std::length_error("polynomials of degree " + std::to_string(degree) + " in " +
                            std::to_string(variables) + " variables are too large");
  std::vector<std::vector<int>> all;
  std::vector<int> head;
  begin_.push_back(0);
  for (int k = 0; k <= degree; ++k) {
    append_exponents(variables, k, head, all);
    begin_.push_back(static_cast<int>(all.size()));
    degrees_.resize(all.size(), k);
  }
  for (std::size_t i = 0; i < all.size(); ++i) numbers_[all[i]] = static_cast<int>(i);
  for (std::size_t i = 0; i < all.size(); ++i) {
    int first = -1;
    for (std::size_t k = 0; k < all[i].size(); ++k) {
      exponents_.push_back(all[i][k]);
      std::vector<int> divided = all[i];
      --divided[k];
      quotients_.push_back(all[i][k] > 0 ? numbers_.at(divided) : -1);
      if (first < 0 && all[i][k] > 0) first = static_cast<int>(k);
    }
    first_factor_.push_back(first);
    first_product_.push_back(products_.size());
    for (int j = 0; j < begin(degree - degrees_[i] + 1); ++j) {
      std::vector<int> sum = all[i];
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += all[static_cast<std::size_t>(j)][k];
      products_.push_back(numbers_.at(sum));
    }
  }
}

int PolynomialRing::monomial(std::span<const int> exponents) const {
  return numbers_.at({exponents.begin(), exponents.end()});
}

Eigen::MatrixXd PolynomialRing::linear(const Eigen::Ref<const Eigen::MatrixXd>& A) const {
  Eigen::MatrixXd p = zero(A.rows());
  p.middleCols(1, variables_) = A;
  return p;
}

Eigen::MatrixXd PolynomialRing::times(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                      const Eigen::Ref<const Eigen::RowVectorXd>& b) const {
  Eigen::MatrixXd out = zero(a.rows());
  for (int j = 0; j < size(); ++j) {
    if (b[j] == 0) continue;
    for (int i = 0; i < begin(degree_ - degree_of(j) + 1); ++i) out.col(product(i, j)) += b[j] * a.col(i);
  }
  return out;
}

Eigen::MatrixXd PolynomialRing::derivative(const Eigen::Ref<const Eigen::MatrixXd>& p, int variable) const {
  Eigen::MatrixXd out = zero(p.rows());
  for (int i = 0; i < size(); ++i)
    if (const int lower = quotient(i, variable); lower >= 0)
      out.col(lower) = exponent(i, variable) * p.col(i);
  return out;
}

Eigen::MatrixXd PolynomialRing::substitute(const Eigen::Ref<const Eigen::MatrixXd>& p,
                                           const PolynomialRing& into,
                                           const Eigen::Ref<const Eigen::MatrixXd>& z) const {
  // Monomials are visited depth first, so that only one product of each degree is stored.
  Eigen::MatrixXd out = into.zero(p.rows());
  std::vector<Eigen::RowVectorXd> products(static_cast<std::size_t>(degree_) + 1, into.zero(1));
  products[0][0] = 1;
  const auto visit = [&](const auto& self, int i) -> void {
    const auto n = static_cast<std::size_t>(degree_of(i));
    out += p.col(i) * products[n];
    if (degree_of(i) == degree_) return;
    const int last = i == 0 ? variables_ - 1 : first_factor_[static_cast<std::size_t>(i)];
    for (int k = 0; k <= last; ++k) {
      products[n + 1] = into.times(products[n], z.row(k));
      self(self, product(i, 1 + k));
    }
  };
  visit(visit, 0);
  return out;
}

Eigen::VectorXd PolynomialRing::monomials_at(const Eigen::Ref<const Eigen::VectorXd>& u, int count) const {
  Eigen::VectorXd values(count);
  values[0] = 1;
  for (int i = 1; i < count; ++i) {
    const int k = first_factor_[static_cast<std::size_t>(i)];
    values[i] = values[quotient(i, k)] * u[k];
  }
  return values;
}

Eigen::VectorXd PolynomialRing::at(const Eigen::Ref<const Eigen::MatrixXd>& p,
                                   const Eigen::Ref<const Eigen::VectorXd>& u) const {
  return p * monomials_at(u, static_cast<int>(p.cols()));
}

Eigen::MatrixXd PolynomialRing::gradient(const Eigen::Ref<const Eigen::MatrixXd>& p,
                                         const Eigen::Ref<const Eigen::VectorXd>& u) const {
  const int count = static_cast<int>(p.cols());
  const Eigen::VectorXd values = monomials_at(u, count);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(p.rows(), variables_);
  for (int i = 1; i < count; ++i)
    for (int k = 0; k < variables_; ++k)
      if (const int lower = quotient(i, k); lower >= 0)
        out.col(k) += (exponent(i, k) * values[lower]) * p.col(i);
  return out;
}

const PolynomialRing& PolynomialRings::at(int variables, int degree) {
  std::unique_ptr<PolynomialRing>& ring = rings_[{variables, degree}];
  if (!ring) ring = std::make_unique<PolynomialRing>(variables, degree);
  return *ring;
}

}  // namespace axode::higher_order
