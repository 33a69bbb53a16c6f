#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/recording.hpp"

/// Recordings made from recordings: of functions of functions, and of derivatives by the rules of differentiation. Where a
/// number does not depend on another, its derivative is the constant 0, so what is left shows the structure.
namespace axode::codegen {

/// What is made of recordings, on a tape of its own.
class Composition {
 public:
  using Numbers = std::vector<Trace>;

  /// A further argument.
  Numbers argument(const std::string& name, int n);
  /// The arguments of a function, as further arguments here.
  std::vector<Numbers> arguments_of(const Recording& f);
  /// The results of a function; what makes it doubtful makes this doubtful.
  Numbers operator()(const Recording& f, std::span<const Numbers> arguments);
  Numbers operator()(const Recording& f, std::initializer_list<Numbers> arguments) {
    return (*this)(f, std::span(arguments.begin(), arguments.size()));
  }
  /// What x changes by along a direction of the arguments; entry k of `direction` is about argument k, and those that are
  /// left out rest.
  Numbers along(const Numbers& x, std::span<const Numbers> direction) const;
  /// The gradient of w x by the first arguments, one behind the other.
  Numbers gradient(const Numbers& x, const Numbers& w, std::size_t arguments) const;
  /// Derivatives of x by the first arguments: a column for each of their entries, one behind the other.
  Numbers jacobian(const Numbers& x, std::size_t arguments) const;

  Recording with(const std::string& result, Numbers results);

 private:
  /// The same of the results of what was made so far, of which some nodes are needed.
  Numbers along(const Recording& made, const std::vector<char>& need,
                std::span<const Numbers> direction) const;
  /// The node of an entry of an argument.
  std::size_t node(std::size_t argument, std::size_t entry) const;

  Tape tape_;
  Recording recording_;
  std::vector<Numbers> inputs_;
};

/// The derivatives of a function by all its arguments x: a column of the results' derivatives for each entry of x, one behind the
/// other.
Recording jacobian_of(const Recording& f);
/// What a direction does to the results: further arguments fwd_q, ... for q, ...
Recording tangent_of(const Recording& f);
/// Further arguments that weigh the results, whose numbers they share among them.
struct Weights {
  std::vector<std::string> names;
  std::vector<int> lengths;
  /// As arguments, one behind the other.
  Composition::Numbers on(Composition& composition) const;
};
/// The gradient of w f, one behind the other for all arguments.
Recording adjoint_of(const Recording& f, const Weights& weights);
/// The second derivatives of w f by all arguments, a square matrix.
Recording hessian_of(const Recording& f, const Weights& weights);

}  // namespace axode::codegen
