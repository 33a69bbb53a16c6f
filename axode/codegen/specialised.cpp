#include "axode/codegen/specialised.hpp"

#include <algorithm>
#include <optional>

#include "axode/batch/check_states.hpp"
#include "axode/batch/portions.hpp"
#include "axode/batch/scratch.hpp"
#include "axode/codegen/machine_code.hpp"
#include "axode/codegen/states_source.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

using codegen::Function;
using codegen::Quantity;

std::string name_of(Quantity quantity) {
  return std::string(codegen::quantities[static_cast<std::size_t>(quantity)]);
}

/// What axode/batch.hpp calls the results of codegen::quantities, in that order.
constexpr std::array<const char*, codegen::quantities.size()> results{
    "tau",      "a",       "M",  "M_inverse", "C",        "J",       "dtau", "dtau",
    "gradient", "hessian", "da", "da",        "gradient", "hessian", "C"};

const char* name_of(catalog::Input input) { return catalog::to_string(input).data(); }

bool same(const Function& a, const Function& b) {
  return a.quantity == b.quantity && (!codegen::is_of_a_frame(a.quantity) ||
                                      (a.frame == b.frame && a.representation == b.representation));
}

/// What the size of a result is made of, as in "3 nv nv N".
template <class T> std::string meaning_of(const catalog::Function<T>& row) {
  const std::size_t numbers = static_cast<std::size_t>(catalog::numbers_of(row.entry)) * row.symbols.size();
  std::string meaning = numbers == 1 ? "" : std::to_string(numbers) + ' ';
  for (const catalog::Extent extent : row.shape)
    meaning += extent == catalog::Extent::n_frames ? "n_frames " : "nv ";
  return meaning + 'N';
}

}  // namespace

/// A function as it lies in memory.
template <class T> struct Specialised<T>::Code {
  struct Argument {
    catalog::Input input;
    std::size_t length;  ///< numbers of a state
  };
  struct Entry {
    Function function;
    const catalog::Function<T>* row;
    void (*call)(long count, const T* const* arguments, T* result, T* scratch, unsigned char* doubts);
    std::size_t scratch, size;  ///< numbers that are needed in all, and that a state has as its result
    const char* result;         ///< its name
    std::string meaning;        ///< of its size
    bool may_doubt;
    std::vector<Argument> arguments;
  };
  codegen::MachineCode library;
  std::vector<Entry> entries;

  Code(const Model& model, std::span<const Function> functions, const SpecialisedOptions& options)
      : Code(model, codegen::states_source(model, functions, std::same_as<T, float>, options.lanes),
             functions, options) {}
  Code(const Model& model, const codegen::Source& source, std::span<const Function> functions,
       const SpecialisedOptions& options)
      : library(source.text, options.flags, options.monitor) {
    for (std::size_t k = 0; k < functions.size(); ++k) {
      const std::string name = name_of(functions[k].quantity), &symbol = source.functions[k].name;
      Entry entry{.function = functions[k], .row = catalog::find<Fast, T>(name)};
      if (entry.row == nullptr) entry.row = catalog::find<BodyFixed, T>(name);
      entry.call = reinterpret_cast<decltype(entry.call)>(library.address(symbol + "_states"));
      entry.scratch =
          static_cast<std::size_t>(*static_cast<const long*>(library.address(symbol + "_scratch")));
      entry.size = entry.row->size(model, 0);
      entry.result = results[static_cast<std::size_t>(functions[k].quantity)];
      entry.meaning = meaning_of(*entry.row);
      entry.may_doubt = name.starts_with("forward") || functions[k].quantity == Quantity::inverse_mass_matrix;
      for (const catalog::Input input : catalog::inputs_of_numbers)
        if (entry.row->takes_input(input))
          entry.arguments.push_back(
              {input, static_cast<std::size_t>(input == catalog::Input::q ? model.nq() : model.nv())});
      entries.push_back(std::move(entry));
    }
  }

  const Entry& entry(const Model& model, const Function& wanted) const {
    const auto found =
        std::ranges::find_if(entries, [&](const Entry& each) { return same(each.function, wanted); });
    if (found == entries.end())
      throw std::invalid_argument(
          "model \"" + model.name() + "\" was specialised without " + name_of(wanted.quantity) +
          (wanted.quantity == Quantity::jacobian ? " of that frame in that representation" : ""));
    return *found;
  }
};

/// A call on N states.
template <class T> class Specialised<T>::Run {
 public:
  Run(const Model& model, const typename Code::Entry& entry, const catalog::Given<T>& given, std::span<T> out,
      std::size_t N)
      : model_(model), entry_(entry), given_(given), out_(out) {
    for (const auto& [input, length] : entry.arguments)
      if (input != catalog::Input::q)
        check_size(name_of(input), catalog::numbers(given_, input).size(), length * N, "nv N");
    check_size(entry.result, out.size(), entry.size * N, entry.meaning.c_str());
    for (const auto& [input, length] : entry.arguments)
      check_separate(entry.result, out, name_of(input), catalog::numbers(given_, input));
    if (entry.may_doubt && N > 1) verdicts_.resize(N);
  }

  /// Scratch memory of a thread.
  struct Memory {
    std::shared_ptr<T> numbers;
    std::optional<Workspace<T>> workspace;
  };
  Memory memory(std::size_t N) const { return {N > 1 ? batch::scratch<T>(entry_.scratch) : nullptr, {}}; }

  void operator()(Memory& memory, std::size_t first, std::size_t states) {
    std::array<const T*, most_arguments> at{};
    for (std::size_t i = 0; i < entry_.arguments.size(); ++i)
      at[i] = catalog::numbers(given_, entry_.arguments[i].input).data() + first * entry_.arguments[i].length;
    entry_.call(static_cast<long>(states), at.data(), result(first).data(), memory.numbers.get(),
                &verdict(first));
    for (std::size_t k = first; entry_.may_doubt && k < first + states; ++k) {
      if (verdict(k) == solved) {
        if (!finite(result(k))) verdict(k) = not_finite;
      } else {
        if (!memory.workspace) memory.workspace.emplace(model_);
        verdict(k) = solve(*memory.workspace, k).ok() ? solved : singular;
      }
    }
  }

  batch::Outcome outcome(std::size_t done) {
    batch::Outcome outcome{.done = done};
    for (std::size_t k = 0; entry_.may_doubt && k < done; ++k)
      if (verdict(k) != solved && outcome.singular_states++ == 0) outcome.first = k;
    if (outcome.ok()) return outcome;
    outcome.solvability.not_finite = true;
    if (verdict(outcome.first) == singular) {
      Workspace<T> workspace(model_);
      outcome.solvability = solve(workspace, outcome.first);
    }
    return outcome;
  }

 private:
  static constexpr std::size_t most_arguments = 6;
  enum Verdict : unsigned char { solved, doubtful, singular, not_finite };

  std::span<T> result(std::size_t k) const { return out_.subspan(k * entry_.size, entry_.size); }
  unsigned char& verdict(std::size_t k) { return verdicts_.empty() ? one_verdict_ : verdicts_[k]; }
  /// By the library.
  Solvability solve(Workspace<T>& workspace, std::size_t k) {
    catalog::Given<T> one;
    for (const auto& [input, length] : entry_.arguments)
      catalog::numbers(one, input) = catalog::numbers(given_, input).subspan(k * length, length);
    return entry_.row->call(model_, workspace, one, result(k));
  }

  const Model& model_;
  const typename Code::Entry& entry_;
  catalog::Given<T> given_;
  std::span<T> out_;
  std::vector<unsigned char> verdicts_;
  unsigned char one_verdict_ = solved;
};

template <class T>
Specialised<T>::Specialised(const Model& model, std::span<const Function> functions,
                            SpecialisedOptions options)
    : model_(model) {
  constexpr std::array widths{1, 2, 4, 8, 16};
  if (std::ranges::find(widths, options.lanes) == widths.end())
    throw std::invalid_argument("lanes is " + std::to_string(options.lanes) + "; expected 1, 2, 4, 8 or 16");
  if (std::ranges::any_of(functions, [](const Function& f) { return f.quantity == Quantity::pose; }))
    throw std::invalid_argument("specialised models have no pose of one frame; ask for poses, which has all");
  code_ = std::make_shared<const Code>(model, functions, options);
}

template <class T> batch::CompiledDynamics<T> Specialised<T>::compiled_dynamics() const {
  const auto& entry = code_->entry(model_, {Quantity::forward_dynamics});
  return {entry.call, entry.scratch};
}

template <class T> bool Specialised<T>::has(const Function& function) const {
  return std::ranges::any_of(code_->entries, [&](const auto& each) { return same(each.function, function); });
}

template <class T>
batch::Outcome Specialised<T>::operator()(const Function& function, const catalog::Given<T>& given,
                                          std::span<T> out, int threads,
                                          const batch::Monitor& monitor) const {
  const std::size_t group = threads > 1 ? 16 : 64;  // registers are filled, and a few states are shared out
  const auto& entry = code_->entry(model_, function);
  const std::size_t N = batch::check_states(model_, given.q, threads);
  if (!given.loads.wrenches.empty() || given.loads.joint_losses)
    throw std::invalid_argument("specialised functions take no loads and no joint losses");
  Run run(model_, entry, given, out, N);
  if (out.empty()) return {.done = N};
  if (N <= group) {
    typename Run::Memory memory = run.memory(N);
    run(memory, 0, N);
    return run.outcome(N);
  }
  return run.outcome(batch::in_portions(N, group, threads, monitor, [&]() -> batch::Work {
    return [&, memory = run.memory(N)](std::size_t first, std::size_t states) mutable {
      run(memory, first, states);
    };
  }));
}

template class Specialised<double>;
template class Specialised<float>;

}  // namespace axode
