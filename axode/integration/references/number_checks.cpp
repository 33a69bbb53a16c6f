#include "axode/integration/references/number_checks.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/scalar/text.hpp"

namespace axode {

void check_finite(const char* name, std::span<const double> x) {
  for (std::size_t k = 0; k < x.size(); ++k)
    if (!std::isfinite(x[k]))
      throw std::invalid_argument(std::string(name) + "[" + std::to_string(k) + "] is not finite");
}

void check_times(std::span<const double> t) {
  for (std::size_t k = 0; k < t.size(); ++k)
    if (!std::isfinite(t[k]) || (k > 0 && !(t[k] > t[k - 1])))
      throw std::invalid_argument("t[" + std::to_string(k) + "] is " + to_text(t[k]) +
                                  "; times must be finite and increase");
}

std::vector<double> for_each_velocity(const Model& model, const char* name, std::span<const double> given) {
  const auto nv = static_cast<std::size_t>(model.nv());
  if (given.size() != 1 && given.size() != nv)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(given.size()) +
                                " numbers; expected 1 or nv = " + std::to_string(nv));
  return given.size() == nv ? std::vector(given.begin(), given.end()) : std::vector<double>(nv, given[0]);
}

}  // namespace axode
