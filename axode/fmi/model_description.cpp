#include "axode/fmi/model_description.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

#include "axode/fmi/stepped_motion.hpp"
#include "axode/model/building/fault.hpp"

namespace axode::fmi {
namespace {

/// A unit as a product of powers of SI base units.
struct Unit {
  std::string_view name;
  std::vector<std::pair<const char*, int>> base;
};
const std::vector<Unit>& units() {
  static const std::vector<Unit> all{{"s", {{"s", 1}}},
                                     {"1", {}},
                                     {"1/s", {{"s", -1}}},
                                     {"rad", {{"rad", 1}}},
                                     {"rad/s", {{"s", -1}, {"rad", 1}}},
                                     {"rad/s2", {{"s", -2}, {"rad", 1}}},
                                     {"m", {{"m", 1}}},
                                     {"m/s", {{"m", 1}, {"s", -1}}},
                                     {"m/s2", {{"m", 1}, {"s", -2}}},
                                     {"kg", {{"kg", 1}}},
                                     {"kg.m2", {{"kg", 1}, {"m", 2}}},
                                     {"N", {{"kg", 1}, {"m", 1}, {"s", -2}}},
                                     {"N.m", {{"kg", 1}, {"m", 2}, {"s", -2}}},
                                     {"N/m", {{"kg", 1}, {"s", -2}}},
                                     {"N.m/rad", {{"kg", 1}, {"m", 2}, {"s", -2}, {"rad", -1}}},
                                     {"N.s/m", {{"kg", 1}, {"s", -1}}},
                                     {"N.m.s/rad", {{"kg", 1}, {"m", 2}, {"s", -1}, {"rad", -1}}},
                                     {"A", {{"A", 1}}}};
  return all;
}

bool is_state(Role role) {
  return role == Role::coordinate || role == Role::velocity || role == Role::drive_state;
}
bool is_rate(Role role) {
  return role == Role::coordinate_rate || role == Role::acceleration || role == Role::drive_rate;
}
bool is_input(Role role) { return role == Role::force || role == Role::load; }
bool is_output(Role role) { return role == Role::coordinate || role == Role::velocity || role == Role::pose; }

const char* causality(Role role) {
  switch (role) {
    case Role::time: return "independent";
    case Role::force:
    case Role::load: return "input";
    case Role::parameter: return "parameter";
    default: return is_output(role) ? "output" : "local";
  }
}
/// The value of the attribute `initial` of a variable; empty if the attribute must be left out.
const char* initial(Role role) {
  if (role == Role::time || is_input(role)) return "";
  return is_state(role) || role == Role::parameter ? "exact" : "calculated";
}
bool has_start(Role role) { return is_state(role) || role == Role::parameter || is_input(role); }

class Writer {
 public:
  Writer(const VariableTable& table, Version version) : table_(table), three_(version == Version::fmi3) {}

  std::string write(const Model& model, const std::vector<Kind>& kinds, const std::string& identifier,
                    const std::string& token) {
    out_.PushHeader(false, true);
    open("fmiModelDescription");
    put("fmiVersion", three_ ? "3.0" : "2.0");
    put("modelName", model.name());
    put(three_ ? "instantiationToken" : "guid", token);
    put("generationTool", "axode");
    put("variableNamingConvention", "flat");
    if (!three_) put("numberOfEventIndicators", std::to_string(table_.count(Role::indicator)));
    for (const Kind kind : kinds) write(kind, identifier);
    write_units();
    open("LogCategories");
    open("Category");
    put("name", "logStatusError");
    close();
    close();
    open("DefaultExperiment");
    put("startTime", "0");
    // With contact, steps of a given length are usual: fine tolerances take long where contacts change.
    if (!moves_with_contact(model)) put("tolerance", "1e-8");
    close();
    open("ModelVariables");
    for (std::size_t r = 0; r < table_.size(); ++r) write(r);
    close();
    write_structure();
    close();
    return out_.CStr();
  }

 private:
  void open(const char* element) { out_.OpenElement(element); }
  void close() { out_.CloseElement(); }
  void put(const char* attribute, const std::string& text) { out_.PushAttribute(attribute, text.c_str()); }

  void write(Kind kind, const std::string& identifier) {
    open(kind == Kind::model_exchange ? "ModelExchange" : "CoSimulation");
    put("modelIdentifier", identifier);
    put(three_ ? "canGetAndSetFMUState" : "canGetAndSetFMUstate", "true");
    put(three_ ? "providesDirectionalDerivatives" : "providesDirectionalDerivative", "true");
    if (three_) put("providesAdjointDerivatives", "true");
    if (kind == Kind::co_simulation) put("canHandleVariableCommunicationStepSize", "true");
    if (kind == Kind::model_exchange && three_) put("needsCompletedIntegratorStep", "true");
    close();
  }

  void write_units() {
    std::set<std::string> used;
    for (const Variable& it : table_.all())
      if (!it.unit.empty()) used.insert(it.unit);
    open("UnitDefinitions");
    for (const std::string& name : used) {
      open("Unit");
      put("name", name);
      const auto known = std::ranges::find(units(), name, &Unit::name);
      if (known != units().end()) {
        open("BaseUnit");
        for (const auto& [base, exponent] : known->base) put(base, std::to_string(exponent));
        close();
      }
      close();
    }
    close();
  }

  /// The value reference of the state whose time derivative the variable `rate` is.
  std::size_t state_of(const Variable& rate) const {
    const Role role = rate.role == Role::coordinate_rate ? Role::coordinate
                      : rate.role == Role::acceleration  ? Role::velocity
                                                         : Role::drive_state;
    return table_.first(role) + rate.index;
  }
  /// The number of a variable in the model structure: value reference (FMI 3.0) or index from 1 (FMI 2.0).
  std::size_t number(std::size_t reference) const { return three_ ? reference : reference + 1; }

  void write(std::size_t reference) {
    const Variable& it = table_[reference];
    open(three_ ? "Float64" : "ScalarVariable");
    put("name", it.name);
    put("valueReference", std::to_string(reference));
    put("description", it.description);
    put("causality", causality(it.role));
    put("variability", it.role == Role::parameter ? "fixed" : "continuous");
    if (*initial(it.role) != '\0') put("initial", initial(it.role));
    if (!three_) open("Real");
    if (!it.unit.empty()) put("unit", it.unit);
    if (is_rate(it.role)) put("derivative", std::to_string(number(state_of(it))));
    if (it.nominal != 1) put("nominal", axode::to_text(it.nominal));
    if (has_start(it.role)) put("start", axode::to_text(it.start));
    if (!three_) close();
    close();
  }

  void unknown(const char* element, std::size_t reference) {
    open(element);
    put(three_ ? "valueReference" : "index", std::to_string(number(reference)));
    const Role role = table_[reference].role;
    if (is_state(role)) put("dependencies", std::to_string(number(reference)));
    close();
  }
  template <class Wanted> void unknowns(const char* element, const Wanted& wanted) {
    for (std::size_t r = 0; r < table_.size(); ++r)
      if (wanted(table_[r].role)) unknown(element, r);
  }
  void write_structure() {
    const auto calculated = [](Role role) { return is_rate(role) || role == Role::pose; };
    open("ModelStructure");
    if (three_) {
      unknowns("Output", is_output);
      unknowns("ContinuousStateDerivative", is_rate);
      unknowns("InitialUnknown", calculated);
      unknowns("EventIndicator", [](Role role) { return role == Role::indicator; });
    } else {
      const auto list = [&](const char* element, const auto& wanted) {
        if (std::ranges::none_of(table_.all(), [&](const Variable& it) { return wanted(it.role); })) return;
        open(element);
        unknowns("Unknown", wanted);
        close();
      };
      list("Outputs", is_output);
      list("Derivatives", is_rate);
      list("InitialUnknowns", calculated);
    }
    close();
  }

  const VariableTable& table_;
  bool three_;
  tinyxml2::XMLPrinter out_;
};

}  // namespace

std::string model_description(const Model& model, const VariableTable& table, Version version,
                              const std::vector<Kind>& kinds, const std::string& identifier,
                              const std::string& token) {
  return Writer(table, version).write(model, kinds, identifier, token);
}

}  // namespace axode::fmi
