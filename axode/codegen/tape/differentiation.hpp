#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/tape/recording.hpp"

/// Recordings that are made from recordings: functions of functions, and derivatives by the rules of
/// differentiation. If a number does not depend on another, its derivative is the constant 0; the other
/// derivatives show the sparsity.
namespace axode::codegen {

/// A function that is composed of recordings, on a tape of its own.
class Composition {
 public:
  using Traces = std::vector<Trace>;

  /// Adds an argument.
  Traces argument(const std::string& name, int n);
  /// Adds the arguments of a function.
  std::vector<Traces> arguments_of(const Recording& f);
  /// The results of the function f with these arguments. If the mass matrix of f may be singular, so may that
  /// of the composition.
  Traces operator()(const Recording& f, std::span<const Traces> arguments);
  Traces operator()(const Recording& f, std::initializer_list<Traces> arguments) {
    return (*this)(f, std::span(arguments.begin(), arguments.size()));
  }
  /// The derivative of x in a direction. Entry k of `direction` is the direction of argument k; arguments
  /// without an entry do not change.
  Traces along(const Traces& x, std::span<const Traces> direction) const;
  /// The gradient of Σ w_k x_k by the first `arguments` arguments, contiguous.
  Traces gradient(const Traces& x, const Traces& w, std::size_t arguments) const;
  /// The derivatives of x by the first `arguments` arguments: contiguous columns, one for each entry of these
  /// arguments.
  Traces jacobian(const Traces& x, std::size_t arguments) const;

  /// The recording of these results under the name `result`; the composition is empty afterwards.
  Recording with(const std::string& result, Traces results);

 private:
  /// The derivatives of the results of a recording on this tape in a direction. Only the nodes with need[k]
  /// are differentiated.
  Traces along(const Recording& made, const std::vector<char>& need, std::span<const Traces> direction) const;
  /// The node of an entry of an argument.
  std::size_t node(std::size_t argument, std::size_t entry) const;

  Tape tape_;
  Recording recording_;
  std::vector<Traces> inputs_;
};

/// The derivatives of a function by all its arguments x: contiguous columns, one for each entry of x.
Recording jacobian_of(const Recording& f);
/// The derivative of the results of f in a direction. The direction of an argument q is an additional
/// argument fwd_q.
Recording tangent_of(const Recording& f);
/// Additional arguments with a weight for each result.
struct Weights {
  std::vector<std::string> names;
  std::vector<int> lengths;
  /// Adds the arguments to a composition and returns their entries.
  Composition::Traces on(Composition& composition) const;
};
/// The gradient of Σ w_k f_k by all arguments of f, contiguous.
Recording adjoint_of(const Recording& f, const Weights& weights);
/// The second derivatives of Σ w_k f_k by all arguments of f, a square matrix.
Recording hessian_of(const Recording& f, const Weights& weights);

}  // namespace axode::codegen
