#include "apps/files/state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>

#include "apps/files/json_text.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {
namespace {

/// A JSON value for a message, shortened if it is long.
std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

/// Reads a state from JSON and collects every fault.
class StateReader {
 public:
  StateReader(const Model& model, std::string source) : model_(model), source_(std::move(source)) {}

  State read(const std::string& text) {
    State state = neutral_state(model_);
    const Json json = parse(text);
    if (!json.is_object()) {
      fault(
          "expected an object with the keys q, v, a, jerk, snap, tau, p, dq, dv, da, dtau, w, loads and "
          "targets, got " +
          shown(json));
    } else {
      for (const auto& [key, value] : json.items()) entry(key, value, state);
    }
    if (faults_.empty()) {
      try {
        check_configuration(model_, state.q);
      } catch (const std::invalid_argument& off) {
        fault(off.what());
      }
    }
    if (!faults_.empty()) throw InputError(std::move(faults_));
    return state;
  }

 private:
  static constexpr std::array<std::string_view, 14> known_keys{
      "q", "v", "a", "jerk", "snap", "tau", "p", "dq", "dv", "da", "dtau", "w", "loads", "targets"};
  /// The keys whose value is an array or an object with a number for each velocity.
  static constexpr std::array<std::pair<std::string_view, std::vector<double> State::*>, 11> of_velocities{
      {{"v", &State::v},
       {"a", &State::a},
       {"jerk", &State::jerk},
       {"snap", &State::snap},
       {"tau", &State::tau},
       {"p", &State::p},
       {"dq", &State::dq},
       {"dv", &State::dv},
       {"da", &State::da},
       {"dtau", &State::dtau},
       {"w", &State::w}}};
  static constexpr std::array<std::string_view, 2> known_target_keys{"frame", "pose"};
  static constexpr std::array<std::string_view, 3> known_load_keys{"frame", "representation", "wrench"};

  void fault(const std::string& sentence) { faults_.push_back(source_ + ": " + sentence); }

  /// The largest depth of nested JSON values that is accepted; a limit protects the stack.
  static constexpr int deepest = 16;

  Json parse(const std::string& text) {
    std::vector<std::set<std::string>> keys;
    const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
      if (depth > deepest)
        throw InputError(source_ + fmt::format(": it is nested deeper than {} levels", deepest));
      if (event == Json::parse_event_t::object_start) keys.emplace_back();
      if (event == Json::parse_event_t::object_end) keys.pop_back();
      if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
        fault("the key " + value.dump() + " is given twice in one object");
      return true;
    };
    try {
      return Json::parse(text, watch);
    } catch (const Json::exception& error) {
      const std::string what = error.what();  // for example "[json.exception.parse_error.101] parse error at
                                              // line 1, ..."
      throw InputError(source_ + ": this is not JSON: " + what.substr(what.find("] ") + 2));
    }
  }

  void entry(const std::string& key, const Json& value, State& state) {
    const auto coordinates = [](const Joint& joint) { return std::pair(joint.iq, joint.nq); };
    const auto velocities = [](const Joint& joint) { return std::pair(joint.iv, joint.nv); };
    for (const auto& [name, member] : of_velocities)
      if (key == name) {
        (state.*member).resize(static_cast<std::size_t>(model_.nv()));
        return numbers(key, value, velocities, "nv", state.*member);
      }
    if (key == "q") {
      numbers("q", value, coordinates, "nq", state.q);
    } else if (key == "loads") {
      each(value, "loads",
           [&](const std::string& where, const Json& item) { load(where, item, state.loads); });
    } else if (key == "targets") {
      each(value, "targets",
           [&](const std::string& where, const Json& item) { target(where, item, state.targets); });
    } else {
      unknown_key("", key, known_keys);
    }
  }

  void unknown_key(const std::string& where, const std::string& key,
                   std::span<const std::string_view> known) {
    fault(where + "the key " + none_of(key, known, [](std::string_view name) { return name; }));
  }

  /// Reads q, v or a from JSON: either an array with all numbers in the model's order, or an object with the
  /// numbers of some joints, keyed by joint name. indices(joint) returns the indices of the numbers of a
  /// joint.
  template <class Indices>
  void numbers(const std::string& key, const Json& value, Indices indices, const char* size,
               std::vector<double>& out) {
    if (value.is_array()) {
      if (value.size() == out.size()) {
        fill(key, value, out);
      } else {
        fault(fmt::format("{} has {}; model \"{}\" takes {} = {}", key, counted(value.size(), "number"),
                          model_.name(), size, out.size()));
      }
    } else if (value.is_object()) {
      for (const auto& [name, x] : value.items()) {
        if (const Joint* joint = joint_of(key, name)) {
          const auto [first, count] = indices(*joint);
          joint_numbers(fmt::format("{}: joint \"{}\"", key, name), x, std::span(out).subspan(first, count));
        }
      }
    } else {
      fault(fmt::format("{} must be an array of numbers or an object keyed by joint name, got {}", key,
                        shown(value)));
    }
  }

  const Joint* joint_of(const std::string& key, const std::string& name) {
    const std::span<const Joint> joints = model_.joints();
    const auto found =
        std::find_if(joints.begin(), joints.end(), [&](const Joint& j) { return j.name == name; });
    if (found == joints.end()) {
      fault(fmt::format("{}: model \"{}\" has no joint \"{}\"{}", key, model_.name(), name,
                        did_you_mean(name, joints, [](const Joint& joint) { return joint.name; })));
    } else if (found->leader) {
      fault(fmt::format("{}: joint \"{}\" has no coordinate of its own; it follows joint \"{}\"", key, name,
                        model_.joint(found->leader->joint).name));
    } else {
      return &*found;
    }
    return nullptr;
  }

  void joint_numbers(const std::string& where, const Json& value, std::span<double> out) {
    if (value.is_array() && value.size() == out.size()) {
      fill(where, value, out);
    } else if (value.is_number() && out.size() == 1) {
      out[0] = value.get<double>();
    } else {
      fault(fmt::format("{} takes {}, got {}", where, counted(out.size(), "number"), shown(value)));
    }
  }

  void fill(const std::string& where, const Json& array, std::span<double> out) {
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (array[k].is_number()) {
        out[k] = array[k].get<double>();
      } else {
        fault(fmt::format("{}: entry {} must be a number, got {}", where, k, shown(array[k])));
      }
    }
  }

  template <class F> void each(const Json& value, const std::string& key, F&& f) {
    if (!value.is_array()) {
      fault(key + " must be an array of objects, got " + shown(value));
      return;
    }
    for (std::size_t k = 0; k < value.size(); ++k) f(fmt::format("{}[{}]", key, k), value[k]);
  }

  void load(const std::string& where, const Json& value, std::vector<AppliedWrench<>>& out) {
    if (!value.is_object()) {
      fault(where + " must be an object with the keys frame, representation and wrench, got " + shown(value));
      return;
    }
    for (const auto& item : value.items())
      if (std::ranges::find(known_load_keys, item.key()) == known_load_keys.end())
        unknown_key(where + ": ", item.key(), known_load_keys);
    try {
      const int frame = model_.frame_index(word(value, "frame"));
      const Representation representation =
          value.contains("representation")
              ? choose<std::invalid_argument>("representation", word(value, "representation"),
                                              representations)
              : Representation::body;
      std::array<double, 6> W{};
      const Json& wrench = required(value, "wrench");
      if (!wrench.is_array() || wrench.size() != W.size())
        throw std::invalid_argument("wrench takes 6 numbers, moment then force, got " + shown(wrench));
      fill(where + ": wrench", wrench, W);
      out.emplace_back(frame, representation, Vec3<>{W[0], W[1], W[2]}, Vec3<>{W[3], W[4], W[5]});
    } catch (const std::invalid_argument& wrong) {
      fault(where + ": " + wrong.what());
    }
  }

  void target(const std::string& where, const Json& value, std::vector<PoseTarget>& out) {
    if (!value.is_object()) {
      fault(where + " must be an object with the keys frame and pose, got " + shown(value));
      return;
    }
    for (const auto& item : value.items())
      if (std::ranges::find(known_target_keys, item.key()) == known_target_keys.end())
        unknown_key(where + ": ", item.key(), known_target_keys);
    try {
      const int frame = model_.frame_index(word(value, "frame"));
      const Json& rows = required(value, "pose");
      std::array<std::array<double, 4>, 3> C{};
      if (!rows.is_array() || (rows.size() != 3 && rows.size() != 4))
        throw std::invalid_argument("pose takes the rows of a 4x4 matrix, got " + shown(rows));
      for (std::size_t r = 0; r < C.size(); ++r) {
        if (!rows[r].is_array() || rows[r].size() != C[r].size())
          throw std::invalid_argument(
              fmt::format("row {} of pose takes 4 numbers, got {}", r, shown(rows[r])));
        fill(fmt::format("{}: row {} of pose", where, r), rows[r], C[r]);
      }
      if (rows.size() == 4 && rows[3] != Json{0, 0, 0, 1} && rows[3] != Json{0.0, 0.0, 0.0, 1.0})
        throw std::invalid_argument("row 3 of pose must be [0, 0, 0, 1], got " + shown(rows[3]));
      const auto column = [&](int k) { return Vec3<>{C[0][k], C[1][k], C[2][k]}; };
      out.push_back({.place = frame, .pose = {{column(0), column(1), column(2)}, column(3)}});
    } catch (const std::invalid_argument& wrong) {
      fault(where + ": " + wrong.what());
    }
  }

  static const Json& required(const Json& object, const std::string& key) {
    if (!object.contains(key)) throw std::invalid_argument(fmt::format("the key \"{}\" is missing", key));
    return object[key];
  }

  static std::string word(const Json& object, const std::string& key) {
    const Json& value = required(object, key);
    if (!value.is_string())
      throw std::invalid_argument(fmt::format("{} must be a word in quotes, got {}", key, shown(value)));
    return value.get<std::string>();
  }

  const Model& model_;
  std::string source_;
  std::vector<std::string> faults_;
};

}  // namespace

State read_state(const Model& model, const std::string& file) {
  return StateReader(model, file == "-" ? "standard input" : file).read(read_text(file));
}

}  // namespace axode::command
