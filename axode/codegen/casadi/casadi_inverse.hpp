#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "axode/codegen/tape/recording.hpp"

namespace axode::codegen {

/// Generates C code for the first derivatives of the inverse mass matrix A(q) = M⁻¹ for CasADi. The code
/// computes them from derivatives of the mass matrix M, and multiplies matrices in `for` loops:
///
///     dA = - A dM A,    d(W·A) = - B·dM with B = A W A,
///
/// where W has a weight for each entry of A, and · is the sum of the products of corresponding entries.
class CasadiInverse {
 public:
  enum Kind : std::size_t { tangent, adjoint, jacobian };
  static constexpr std::size_t kinds = 3;

  /// The recording (list of operations) of a derivative of the mass matrix M: along a direction (nv x nv
  /// numbers), or by each coordinate q_k (nq times nv x nv numbers), or the gradient by q of B·M, where B has
  /// a weight for each entry of M (nq numbers). Only numbers that can differ from 0 are recorded. `places`
  /// are their indices among all numbers of the derivative.
  struct Part {
    Recording recording;
    std::vector<int> places;
  };

  /// `entries` are the indices r + nv c of the entries (r, c) of A = M⁻¹ that the generated function for A
  /// computes. `masses` are recordings (lists of operations) of three derivatives of the mass matrix M by q,
  /// in this order: along a direction, the gradient of a weighted sum of the entries of M, and by each
  /// coordinate. `weights` is the name of the argument with the weights of the entries of A, for the function
  /// that computes the gradient of their weighted sum.
  CasadiInverse(int nq, int nv, std::vector<int> entries, std::string weights,
                std::array<Part, kinds> masses);

  const Recording& of_masses(Kind kind) const { return masses_[kind].recording; }
  /// The signature of the generated function for a derivative of A = M⁻¹, where M is the mass matrix: the
  /// names and lengths of its arguments, the name of its result, and the sparsity of the result. It has the
  /// form of a recording (a list of operations) in which each entry of the result is the constant 0 if it is
  /// always 0, and otherwise the constant 1.
  Recording signature(Kind kind) const;
  /// The operations that a derivative of A takes in addition to the computation of A.
  Operations operations(Kind kind) const;
  /// Length (in numbers) of the memory that a derivative of A uses after its results.
  std::size_t scratch() const;
  /// The body in C of the function for a derivative of A = M⁻¹. `inverse` and `masses` are the names of the
  /// functions for A and for the derivative of the mass matrix M. table(numbers) returns the name of a
  /// constant array with these numbers.
  std::string body(Kind kind, const std::string& prefix, const std::string& inverse,
                   const std::string& masses,
                   const std::function<std::string(const std::vector<int>&)>& table) const;
  /// Functions in C with the loops that all derivatives of A in a file call.
  static std::string loops(const std::string& prefix);

 private:
  std::size_t nq_, nv_;
  std::vector<int> entries_;
  std::string weights_;
  std::array<Part, kinds> masses_;
  std::vector<int> begin_;  ///< for each coordinate q_k: where its results begin among those of ∂M/∂q
  std::vector<int> by_q_;   ///< the non-zero entries of ∂A/∂q: k n + e, with n entries of A, if the
                            ///< derivative of entry e by q_k may not be 0
};

}  // namespace axode::codegen
