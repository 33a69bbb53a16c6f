#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace axode::higher_order {

/// Polynomials in d variables, truncated after degree K. They are stored as matrices of coefficients: a row
/// is a polynomial, and a column belongs to a monomial. Columns are sorted by degree; column 0 is the
/// constant, and column 1 + k is variable k.
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
  /// The monomials of degree k have the indices begin(k) to begin(k + 1) - 1.
  int begin(int k) const { return begin_[static_cast<std::size_t>(k)]; }
  int count(int k) const { return begin(k + 1) - begin(k); }
  int degree_of(int monomial) const { return degrees_[static_cast<std::size_t>(monomial)]; }
  int exponent(int monomial, int variable) const { return exponents_[index(monomial, variable)]; }
  /// The index of a monomial divided by a variable; -1 if the variable does not divide it.
  int quotient(int monomial, int variable) const { return quotients_[index(monomial, variable)]; }
  /// The index of the product of monomials i and j, whose degrees must add up to at most K.
  int product(int i, int j) const {
    return products_[first_product_[static_cast<std::size_t>(i)] + static_cast<std::size_t>(j)];
  }
  /// The index of the monomial with the given exponents, one for each variable.
  int monomial(std::span<const int> exponents) const;

  Eigen::MatrixXd zero(Eigen::Index rows) const { return Eigen::MatrixXd::Zero(rows, size()); }
  /// The linear forms A u of the variables u, as polynomials.
  Eigen::MatrixXd linear(const Eigen::Ref<const Eigen::MatrixXd>& A) const;
  /// Multiplies each row of a by the polynomial b (1 × size).
  Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& a,
                        const Eigen::Ref<const Eigen::RowVectorXd>& b) const;
  /// Computes ∂p/∂u_k for the variable k, with terms up to degree K - 1.
  Eigen::MatrixXd derivative(const Eigen::Ref<const Eigen::MatrixXd>& p, int variable) const;
  /// Computes the polynomials p(z): row k of z, a polynomial in the variables of `into`, replaces variable k.
  Eigen::MatrixXd substitute(const Eigen::Ref<const Eigen::MatrixXd>& p, const PolynomialRing& into,
                             const Eigen::Ref<const Eigen::MatrixXd>& z) const;

  /// Computes the values of the first `count` monomials at the point u.
  Eigen::VectorXd monomials_at(const Eigen::Ref<const Eigen::VectorXd>& u, int count) const;
  /// The values of the polynomials p at the point u. p may lack the columns of monomials of high degrees.
  Eigen::VectorXd at(const Eigen::Ref<const Eigen::MatrixXd>& p,
                     const Eigen::Ref<const Eigen::VectorXd>& u) const;
  /// Computes the derivatives of the polynomials p by the variables at the point u (rows × variables).
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
  std::vector<int> first_factor_;           ///< first variable that divides each monomial
  std::vector<std::size_t> first_product_;
  std::vector<int> products_;
  std::map<std::vector<int>, int> numbers_;  ///< index of each monomial by its exponents
};

/// Exception that ends an analysis if its monitor has returned false.
struct AnalysisEnded {};

/// The polynomial rings of an analysis, each made when it is first used, and the monitor of the analysis.
class PolynomialRings {
 public:
  explicit PolynomialRings(std::function<bool()> monitor = {}) : monitor_(std::move(monitor)) {}
  /// Calls the monitor. Throws AnalysisEnded if it returns false.
  void ask() const {
    if (monitor_ && !monitor_()) throw AnalysisEnded{};
  }
  const PolynomialRing& at(int variables, int degree);

 private:
  std::function<bool()> monitor_;
  std::map<std::pair<int, int>, std::unique_ptr<PolynomialRing>> rings_;
};

}  // namespace axode::higher_order
