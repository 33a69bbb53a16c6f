#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "axode/codegen/recording.hpp"

namespace axode::codegen {

/// The first derivatives of A(q) = M⁻¹ for CasADi, by those of M and products of matrices, which are loops:
/// written out they would be more than compilers take for a humanoid. With weights W, and B = A W A,
///
///     dA = - A dM A,    d(W·A) = - B·dM.
class CasadiInverse {
 public:
  enum Kind : std::size_t { tangent, adjoint, jacobian };
  static constexpr std::size_t kinds = 3;

  /// A function of M, (nv, nv): its change along a direction, the gradient with weights B, or the derivatives
  /// by each coordinate one behind the other. Its results are the entries `places` of that.
  struct Part {
    Recording recording;
    std::vector<int> places;
  };

  /// The function for A results in its `entries`, r + nv c, whose weights are called `weights`.
  CasadiInverse(int nq, int nv, std::vector<int> entries, std::string weights,
                std::array<Part, kinds> masses);

  const Recording& of_masses(Kind kind) const { return masses_[kind].recording; }
  /// Arguments and results of a function for A: 1, or 0 where they are 0 always, which the function leaves
  /// out.
  Recording signature(Kind kind) const;
  /// What it does besides A.
  Operations operations(Kind kind) const;
  /// Numbers that it takes behind its results.
  std::size_t scratch() const;
  /// The body of the function in C. `inverse` and `masses` are the names of the functions for A and of the part of M,
  /// table(numbers) is that of a constant array.
  std::string body(Kind kind, const std::string& prefix, const std::string& inverse,
                   const std::string& masses,
                   const std::function<std::string(const std::vector<int>&)>& table) const;
  /// Loops that the functions of a file share.
  static std::string loops(const std::string& prefix);

 private:
  std::size_t nq_, nv_;
  std::vector<int> entries_;
  std::string weights_;
  std::array<Part, kinds> masses_;
  std::vector<int> begin_;  ///< where the results for M by coordinate k begin
  std::vector<int> by_q_;   ///< entries of A by q that may not be 0: k n + e for entry e of n
};

}  // namespace axode::codegen
