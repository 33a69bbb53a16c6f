#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace axode::higher_order {

/// Polynomials in d variables without their terms above degree K. The rows of a matrix (rows × size) are
/// polynomials, and its columns are monomials, sorted by degree; column 0 is the constant, and column 1 + k
/// is variable k.
class PolynomialRing {
 public:
  static constexpr double most_products = 1e6;
  /// Throws std::length_error if d and K need more than most_products products.
  PolynomialRing(int variables, int degree);
  /// The number of pairs of monomials whose product is kept, C(2d + K, K): the cost of a product.
  static double products(int variables, int degree);

  int variables() const { return variables_; }
  int degree() const { return degree_; }
  int size() const { return begin_.back(); }
  /// The monomials of degree k are begin(k) to begin(k + 1) - 1.
  int begin(int k) const { return begin_[static_cast<std::size_t>(k)]; }
  int count(int k) const { return begin(k + 1) - begin(k); }
  int degree_of(int monomial) const { return degrees_[static_cast<std::size_t>(monomial)]; }
  int exponent(int monomial, int variable) const { return exponents_[index(monomial, variable)]; }
  /// The monomial divided by a variable; -1 if the variable does not divide it.
  int quotient(int monomial, int variable) const { return quotients_[index(monomial, variable)]; }
  /// The product of two monomials whose degrees add up to at most K.
  int product(int i, int j) const {
    return products_[first_product_[static_cast<std::size_t>(i)] + static_cast<std::size_t>(j)];
  }
  /// The monomial with these exponents, one for each variable.
  int monomial(std::span<const int> exponents) const;

  Eigen::MatrixXd zero(Eigen::Index rows) const { return Eigen::MatrixXd::Zero(rows, size()); }
  /// The linear forms A u of the variables u.
  Eigen::MatrixXd linear(const Eigen::Ref<const Eigen::MatrixXd>& A) const;
  /// The rows of a, each times the polynomial b (1 × size).
  Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& a,
                        const Eigen::Ref<const Eigen::RowVectorXd>& b) const;
  /// ∂p/∂u_k, which has terms up to degree K - 1.
  Eigen::MatrixXd derivative(const Eigen::Ref<const Eigen::MatrixXd>& p, int variable) const;
  /// p(z) in another ring; row k of z replaces variable k of this ring.
  Eigen::MatrixXd substitute(const Eigen::Ref<const Eigen::MatrixXd>& p, const PolynomialRing& into,
                             const Eigen::Ref<const Eigen::MatrixXd>& z) const;

  /// The values of the first `count` monomials at u.
  Eigen::VectorXd monomials_at(const Eigen::Ref<const Eigen::VectorXd>& u, int count) const;
  /// The values of polynomials at u; p may have the columns of a lower degree only.
  Eigen::VectorXd at(const Eigen::Ref<const Eigen::MatrixXd>& p,
                     const Eigen::Ref<const Eigen::VectorXd>& u) const;
  /// The derivatives (rows × variables) of polynomials at u.
  Eigen::MatrixXd gradient(const Eigen::Ref<const Eigen::MatrixXd>& p,
                           const Eigen::Ref<const Eigen::VectorXd>& u) const;

 private:
  std::size_t index(int monomial, int variable) const {
    return static_cast<std::size_t>(monomial) * static_cast<std::size_t>(variables_) +
           static_cast<std::size_t>(variable);
  }

  int variables_, degree_;
  std::vector<int> begin_, degrees_;
  std::vector<int> exponents_, quotients_;  ///< size × variables
  std::vector<int> first_factor_;           ///< the first variable that divides a monomial
  std::vector<std::size_t> first_product_;
  std::vector<int> products_;
  std::map<std::vector<int>, int> numbers_;  ///< monomials by their exponents
};

/// Ends an analysis whose monitor wants it to end.
struct AnalysisEnded {};

/// The rings of an analysis, each made once, and its monitor.
class PolynomialRings {
 public:
  explicit PolynomialRings(std::function<bool()> monitor = {}) : monitor_(std::move(monitor)) {}
  /// Throws AnalysisEnded if the monitor returns false.
  void ask() const {
    if (monitor_ && !monitor_()) throw AnalysisEnded{};
  }
  const PolynomialRing& at(int variables, int degree);

 private:
  std::function<bool()> monitor_;
  std::map<std::pair<int, int>, std::unique_ptr<PolynomialRing>> rings_;
};

}  // namespace axode::higher_order
