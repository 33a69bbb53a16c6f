#pragma once
#include <array>
#include <cstddef>
#include <initializer_list>
#include <string_view>
#include <utility>

/// Types for the table of functions of a state: names, arguments, results and costs as data.
namespace axode::catalog {

/// A value without a default: a row of the table of functions that leaves it out does not compile.
template <class E> struct Decided {
  E value;
  constexpr Decided(E of) : value(of) {}  // NOLINT(google-explicit-constructor): a row writes the value
  constexpr operator E() const {
    return value;
  }  // NOLINT(google-explicit-constructor): and a reader reads it
};

/// A list of at most `most` elements that can be used in constant expressions.
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

/// The possible arguments of functions of a state, such as coordinates q, velocities v and loads at one time.
enum class Input { q, v, a, tau, p, dq, dv, da, dtau, weights, loads, place, base, form, at };
/// The inputs that are arrays of numbers, such as q and v. All other inputs are settings, such as a frame.
inline constexpr std::array inputs_of_numbers{Input::q,  Input::v,  Input::a,  Input::tau,  Input::p,
                                              Input::dq, Input::dv, Input::da, Input::dtau, Input::weights};
constexpr bool is_of_numbers(Input input) {
  return static_cast<std::size_t>(input) < inputs_of_numbers.size();
}
std::string_view to_string(Input input);

/// The kind of the entries of a result. Entries of six numbers have the angular part first.
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

/// The possible lengths of an axis of a result, such as nv for a vector with an entry for each velocity.
enum class Extent { nv, n_bodies, n_joints, n_frames, n_screws, n_parameters, n_loads, six };
std::string_view to_string(Extent extent);

/// What a caller selects by the representation (BodyFixed, Spatial, Hybrid or Mixed) of a function.
enum class Choice {
  none,            ///< there is nothing to choose
  representation,  ///< representation of the result
  recursion,       ///< representation of the recursion, or Fast; the result is the same for all
};

/// The growth of the computing time with the number of velocities; the size of the result is included.
enum class Cost { linear, quadratic, cubic };

/// The memory in which the results of a call may be.
enum class Memory {
  may_share,  ///< results may share memory with arguments
  own,        ///< results need their own memory: arguments are read while results are written
};

/// The treatment of a property of mechanisms, such as loops or springs, by a function.
enum class Word {
  counted,      ///< the function takes the property into account
  of_the_tree,  ///< the quantity is by definition that of the mechanism without the property
  optional,     ///< a parameter makes the function take the property into account
  partly,       ///< a parameter includes a part of the property; the call throws for the rest
  refused,      ///< the call throws if the model has the property
};

/// How a function treats a property of mechanisms, such as loops. `word` names the treatment, for example
/// `counted` or `refused`. `sentence` says what to call instead or in addition; it is required if the
/// treatment is `refused` or `partly`.
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

/// What a function does with each property of mechanisms; a row that leaves one out does not compile.
struct Counts {
  Count loops, passive_joints, springs, joint_losses, motions, drives, plays, contacts;
};
/// The members of Counts, with the names of the properties in sentences.
inline constexpr std::array properties{std::pair{std::string_view("loops"), &Counts::loops},
                                       std::pair{std::string_view("passive joints"), &Counts::passive_joints},
                                       std::pair{std::string_view("springs"), &Counts::springs},
                                       std::pair{std::string_view("joint losses"), &Counts::joint_losses},
                                       std::pair{std::string_view("prescribed motions"), &Counts::motions},
                                       std::pair{std::string_view("drives with states"), &Counts::drives},
                                       std::pair{std::string_view("couplings with play"), &Counts::plays},
                                       std::pair{std::string_view("contacts"), &Counts::contacts}};
static_assert(sizeof(Counts) == properties.size() * sizeof(Count));

/// The description of a function of a state: a row of the table functions_of_state.
struct Words {
  std::string_view name;     ///< name in C++, in Python and in the command
  std::string_view purpose;  ///< a whole sentence on the result, which no other row has
  /// The units of the result; semicolons separate those of several results. If a unit depends on whether a
  /// velocity, or a part of a six-vector, is angular or linear, both units are listed, angular first, as in
  /// "N m, N". If it depends on several velocities or parts, unit k of the list, counted from 0, is for k
  /// linear ones. "of x" stands for the units of x, and "per" for division by the unit of a direction,
  /// velocity, parameter, displacement or impulse: "of tau per unit of the direction" are the units of the
  /// derivatives of tau by q, v and a.
  std::string_view units;
  List<Input, 8> takes;  ///< the inputs, in the order of the parameters in C++
  Decided<Choice> choice;
  Decided<Entry> entry;
  List<Extent, 3> shape;  ///< axes of the result, outermost first
  Decided<bool> columns;  ///< whether readers see the entries of the last axis as columns
  /// The symbols of the results, which have equal shapes and are stored one after the other in this order.
  List<std::string_view, 4> symbols;
  std::string_view together;  ///< name of all results together, in SIMD lanes and in generated code
  Decided<Cost> cost;
  Decided<bool> allocates;
  Decided<Memory> memory;
  /// Whether the call can fail: the mass matrix M is singular, or the computation with M⁻¹ overflows.
  Decided<bool> may_fail;
  std::string_view derivative_of;  ///< name of the function of which it is a derivative; or empty
  Decided<bool> lanes;             ///< whether batches compute several states in SIMD lanes
  Decided<bool> tape;              ///< whether there is generated and specialised code for it
  Counts counts;

  /// The inputs of the function that are arrays of numbers.
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

/// Pointers to the arrays of numbers that a kernel reads, by input.
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
