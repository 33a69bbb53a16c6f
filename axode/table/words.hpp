#pragma once
#include <array>
#include <cstddef>
#include <initializer_list>
#include <string_view>
#include <utility>

/// The types in which a row of the table of functions is written. They do not depend on kernels, scalars or
/// representations.
namespace axode::catalog {

/// A value that every row must state. It has no default, so that a row without it does not compile.
template <class E> struct Decided {
  E value;
  constexpr Decided(E of) : value(of) {}  // NOLINT(google-explicit-constructor): a row writes the value
  constexpr operator E() const {
    return value;
  }  // NOLINT(google-explicit-constructor): and a reader reads it
};

/// A short list for constants.
template <class E, std::size_t most> class List {
 public:
  constexpr List() = default;
  constexpr List(std::initializer_list<E> given) {
    for (const E& each : given) add(each);
  }
  constexpr void add(const E& each) { items_[n_++] = each; }
  constexpr const E* begin() const { return items_.data(); }
  constexpr const E* end() const { return items_.data() + n_; }
  constexpr std::size_t size() const { return n_; }
  constexpr bool empty() const { return n_ == 0; }
  constexpr const E& operator[](std::size_t k) const { return items_[k]; }
  constexpr const E& back() const { return items_[n_ - 1]; }

 private:
  std::array<E, most> items_{};
  std::size_t n_ = 0;
};

/// The arguments of functions of a state.
enum class Input { q, v, a, tau, p, dq, dv, da, dtau, weights, loads, place, base, form, at };
/// The inputs that are numbers for each coordinate or velocity of a state. The others are settings.
inline constexpr std::array inputs_of_numbers{Input::q,  Input::v,  Input::a,  Input::tau,  Input::p,
                                              Input::dq, Input::dv, Input::da, Input::dtau, Input::weights};
constexpr bool is_of_numbers(Input input) {
  return static_cast<std::size_t>(input) < inputs_of_numbers.size();
}
std::string_view to_string(Input input);

/// The kind of an entry of a result, which decides how many numbers it has. Six-vectors have their angular
/// part first.
enum class Entry {
  number,    ///< one number
  vector,    ///< 3 numbers, in inertial axes
  twist,     ///< 6 numbers
  rate,      ///< 6 numbers, the rate of a twist
  wrench,    ///< 6 numbers; also the rate of a momentum
  momentum,  ///< 6 numbers
  pose,      ///< 12 numbers: the columns of R, then r
  inertia,   ///< 10 numbers: m, h, Θ (xx yy zz xy xz yz)
};
constexpr int numbers_of(Entry entry) {
  switch (entry) {
    case Entry::number: return 1;
    case Entry::vector: return 3;
    case Entry::pose: return 12;
    case Entry::inertia: return 10;
    default: return 6;
  }
}

/// The axes over which the entries of a result run.
enum class Extent { nv, n_bodies, n_joints, n_frames, n_screws, n_parameters, n_loads, six };
std::string_view to_string(Extent extent);

/// The representation that a caller chooses.
enum class Choice {
  none,            ///< there is nothing to choose
  representation,  ///< representation of the result
  recursion,       ///< representation in which the recursion runs, or Fast; the result does not depend on it
};

/// How the work, memory for the result included, grows with the number of velocities.
enum class Cost { linear, quadratic, cubic };

/// The memory in which the results of a call may lie.
enum class Memory {
  may_share,  ///< memory that may be shared with arguments
  own,        ///< memory of their own: arguments are read while results are written
};

/// How a function treats a property of mechanisms.
enum class Word {
  counted,      ///< the answer is that of the whole mechanism
  of_the_tree,  ///< the quantity is by definition one of the mechanism without the property
  optional,     ///< a parameter turns it on
  partly,       ///< a parameter turns on a part of it, and the call throws for the rest
  refused,      ///< the call throws
};

/// The treatment of a property, with a sentence that says what to call instead or in addition.
struct Count {
  Word word;
  std::string_view sentence;
  consteval Count(Word of, std::string_view hint = {}) : word(of), sentence(hint) {
    if ((of == Word::refused || of == Word::partly) && hint.empty())
      throw "a refusal says what to call instead";
  }
};
inline constexpr Count counted{Word::counted}, optional{Word::optional};
consteval Count of_the_tree(std::string_view besides = {}) { return {Word::of_the_tree, besides}; }
consteval Count refused(std::string_view instead) { return {Word::refused, instead}; }

/// The treatment of every property of mechanisms by a function. A new property is a member here; a row that
/// does not state its treatment does not compile.
struct Counts {
  Count loops, passive_joints, springs, joint_losses, motions, drives, plays, contacts;
};
/// The members by their names in sentences.
inline constexpr std::array properties{std::pair{std::string_view("loops"), &Counts::loops},
                                       std::pair{std::string_view("passive joints"), &Counts::passive_joints},
                                       std::pair{std::string_view("springs"), &Counts::springs},
                                       std::pair{std::string_view("joint losses"), &Counts::joint_losses},
                                       std::pair{std::string_view("prescribed motions"), &Counts::motions},
                                       std::pair{std::string_view("drives with states"), &Counts::drives},
                                       std::pair{std::string_view("couplings with play"), &Counts::plays},
                                       std::pair{std::string_view("contacts"), &Counts::contacts}};
static_assert(sizeof(Counts) == properties.size() * sizeof(Count));

/// The description of a function in one row.
struct Words {
  std::string_view name;     ///< name in C++, in Python and in the command
  std::string_view purpose;  ///< purpose: a phrase that can be read alone
  /// The units of the numbers. A list names those of numbers of 0, 1, ... lengths, counted over the
  /// velocities of the joints and the angular and linear parts of a six-vector: "N m, N". "of x" stands for
  /// the units of x. "per" stands for a quotient by the units of a direction, a velocity, a parameter or a
  /// displacement, along the last axes. A semicolon separates several results.
  std::string_view units;
  List<Input, 8> takes;
  Decided<Choice> choice;
  Decided<Entry> entry;
  List<Extent, 3> shape;  ///< axes of the result, outermost first
  Decided<bool> columns;  ///< whether the entries of the last axis are columns to a reader
  /// Symbols of the result, or of several results of that shape, one after the other.
  List<std::string_view, 4> symbols;
  std::string_view
      together;  ///< the name of all results, one behind the other, where rows run in lanes or on tapes
  Decided<Cost> cost;
  Decided<bool> allocates;
  Decided<Memory> memory;
  /// Whether the call fails if the mass matrix is singular or results overflow on the way to M⁻¹.
  Decided<bool> may_fail;
  std::string_view derivative_of;  ///< row whose results it differentiates, if any
  Decided<bool> lanes;             ///< whether states go through SIMD lanes, see axode/batch.hpp
  Decided<bool> tape;              ///< whether it is recorded for generated and specialised code
  Counts counts;

  /// The inputs of the row that are numbers of a state.
  constexpr List<Input, 8> numbers() const {
    List<Input, 8> all;
    for (const Input each : takes)
      if (is_of_numbers(each)) all.add(each);
    return all;
  }
  constexpr bool takes_input(Input input) const {
    for (const Input each : takes)
      if (each == input) return true;
    return false;
  }
};

/// The numbers of a state that a kernel reads, by input.
template <class T> class Read {
 public:
  [[gnu::always_inline]] const T*& operator[](Input input) { return at_[static_cast<std::size_t>(input)]; }
  [[gnu::always_inline]] const T* operator[](Input input) const {
    return at_[static_cast<std::size_t>(input)];
  }

 private:
  const T* at_[inputs_of_numbers.size()] = {};
};

}  // namespace axode::catalog
